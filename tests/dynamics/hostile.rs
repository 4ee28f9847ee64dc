//! Whatever the ranges allow gives a finite value or a reason, without a panic.

use super::*;
use proptest::prelude::*;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Anything a range allows, its ends and extremes among them.
fn allowed(random: &mut Random, id: ParamId) -> f64 {
    let param = id.param();
    let (low, high) = param.range;
    let top = if high.is_infinite() { 1e30 } else { high };
    let sign = if low < 0.0 && random.one_in(2) { -1.0 } else { 1.0 };
    let value = match random.whole(0, 9) as u32 {
        0..=4 => usual_value(id),
        5 => random.pick(&[low, high, param.default.unwrap_or(low)]),
        6 => sign * random.log(1e-30, top.max(1e-29)),
        7 => sign * random.log(low.clamp(1e-9, 1.0), top),
        _ => usual_value(id) * random.log(0.1, 10.0),
    };
    let value = value.clamp(low, high);
    if param.integer { value.floor().max(low) } else { value }
}

/// Looks of 5 ms each at a job; one that takes longer shows no more than that it can be stopped.
const PATIENCE: usize = 100;

/// Runs a job for a while at most; `None` if it takes longer.
fn patiently(job: &Job, names: usize) -> Option<Results> {
    let control = Control::default();
    let mut values = vec![vec![f64::MAX; job.cells()]; names];
    let mut codes = vec![vec![u8::MAX; job.cells()]; names];
    let mut buffers: Vec<_> = values.iter_mut().map(|v| Buffer::F64(v)).enumerate().collect();
    buffers.extend(codes.iter_mut().map(|c| Buffer::Status(c)).enumerate());
    let done = std::sync::atomic::AtomicBool::new(false);
    let result = std::thread::scope(|scope| {
        let watch = scope.spawn(|| {
            for _ in 0..PATIENCE {
                if done.load(Ordering::Relaxed) {
                    return;
                }
                std::thread::park_timeout(Duration::from_millis(5));
            }
            control.cancel.store(true, Ordering::Relaxed);
        });
        let result = run(job, buffers, options(1, 64), &control);
        done.store(true, Ordering::Relaxed);
        watch.thread().unpark();
        result
    });
    match result {
        Ok(()) => Some((values, codes)),
        Err(Error::Cancelled { .. }) => None,
        Err(error) => panic!("{error}"),
    }
}

fn check(case: &Case, names: &[&str]) -> Result<bool, TestCaseError> {
    let job = case.job(names);
    let Some((values, codes)) = patiently(&job, names.len()) else { return Ok(false) };
    for ((name, values), codes) in names.iter().zip(&values).zip(&codes) {
        for (value, code) in values.iter().zip(codes) {
            let given = &case.given;
            prop_assert_eq!(
                value.is_nan(),
                *code != 0,
                "{} {}: {} {} {:?}",
                case.name(),
                name,
                value,
                code,
                given
            );
            prop_assert!(!value.is_infinite(), "{} {}: {:?}", case.name(), name, given);
        }
    }
    Ok(true)
}

fn a_run_is_a_value_or_a_reason(seed: u64) -> Result<(), TestCaseError> {
    let mut random = Random(seed);
    let (law, drive) = (random.pick(&LAWS.iter().collect::<Vec<_>>()), random.pick(DriveKind::ALL));
    let mut case = Case::usual(law.info.name, drive);
    for (name, value) in &mut case.given {
        *value = allowed(&mut random, ParamId::parse(name).unwrap());
    }
    // Short runs of few steps and few pieces; what adaptive steps make of it is theirs.
    let duration = random.log(1e-6, 0.5);
    let step = duration / random.log(1.0, 300.0);
    let more = [
        ("duration", duration),
        ("time_step", step.max(1e-12)),
        ("tolerance", random.log(1e-8, 0.1)),
        ("drive_period", duration / random.log(0.1, 30.0)),
    ];
    let speeds = vec![-0.1, 0.0, allowed(&mut random, ParamId::StartSpeed)];
    let mut case = case.with(&more).over("start_speed", speeds);
    let sprung = case.given.iter().any(|(name, v)| name.starts_with("spring") && *v != 0.0);
    let mut fit = methods(law, drive);
    fit.retain(|method| !sprung || *method != "exact");
    if !fit.is_empty() && random.one_in(2) {
        case = case.by(random.pick(&fit));
    }
    case.choice.locate = random.one_in(2);
    check(&case, &outputs()).map(|_| ())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..Default::default() })]

    #[test]
    fn any_run_is_a_value_or_a_reason(seed in any::<u64>()) {
        a_run_is_a_value_or_a_reason(seed)?;
    }

    #[test]
    #[ignore = "takes a quarter of a minute"]
    fn many_runs_are_values_or_reasons(seeds in prop::array::uniform5(any::<u64>())) {
        for seed in seeds {
            a_run_is_a_value_or_a_reason(seed)?;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..Default::default() })]

    #[test]
    fn any_robot_is_a_value_or_a_reason(seed in any::<u64>()) {
        use locosweep::physics::gait::GAITS;
        let mut random = Random(seed);
        let gait = random.pick(GAITS);
        let mut case = Case::usual("coulomb", DriveKind::Constant)
            .change(|c| c.gait = gait.name().to_owned());
        for (name, value) in &mut case.given {
            *value = allowed(&mut random, ParamId::parse(name).unwrap());
        }
        let case = if random.one_in(2) { case.dry() } else { case };
        let case = case.with(&[
            ("segments", random.whole(1, 5)),
            ("moving", random.whole(1, 3)),
            ("cycles", 1.0),
        ]);
        let get = |name: &str| case.given.iter().find(|(known, _)| *known == name).unwrap().1;
        // One phase of at most so many steps: more is refused, but only after they are taken.
        let phase = (get("stroke") / get("speed_limit")).max(get("dwell")) / get("time_step");
        prop_assume!(get("joint_stiffness").is_infinite() || phase < 300.0);
        let names: Vec<&str> =
            locosweep::sweep::GaitOutput::ALL.iter().map(|output| output.info().name).collect();
        check(&case, &names)?;
    }
}
