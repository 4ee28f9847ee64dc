//! Friction that bends within few steps behind a lag, a spring or a gap, against a plain
//! integration.

use super::against_plain::{MICROMETRE, pulses};
use super::plain::Rig;
use super::*;

/// Numbers of `on`.
fn usual(effect: Effect) -> Vec<f64> {
    on(effect)[effect.first()..][..effect.info().params.len()].to_vec()
}

/// Largest errors of x, m, at samples of these many milliseconds; plain steps of `longest`.
pub(super) fn errors(
    effects: &[(Effect, &[f64])],
    strength: f64,
    spans: &[usize],
    longest: f64,
) -> Vec<f64> {
    let (mut active, mut values) = (Active::default(), [0.0; EFFECT_PARAMS]);
    for (effect, numbers) in effects {
        active = active.with(*effect);
        values[effect.first()..][..numbers.len()].copy_from_slice(numbers);
    }
    let nominal = Nominal { limit: 1e9, ..NOMINAL };
    let pushed = |dt: f64| {
        let mut run = pulses(dt, 1.0);
        run.drive.iter_mut().for_each(|drive| *drive *= strength);
        run
    };
    let fine = pushed(1e-3);
    let rig = Rig { nominal: &nominal, active, values: &values, slope_deg: fine.slope_deg };
    let truth = rig.motion(&fine.times, &fine.drive, longest);
    let one = |span: &usize| {
        let run = pushed(*span as f64 * 1e-3);
        let columns = [column(active, values, run.times.len())];
        let level = Level::current().unwrap();
        let found = replay(&nominal, &[run], &columns, (level, 1), &Control::default()).unwrap();
        let picked: Vec<f64> = truth.x.iter().step_by(*span).copied().collect();
        assert_eq!(picked.len(), found.x.len());
        largest(&found.x, &picked)
    };
    spans.iter().map(one).collect()
}

/// Drives of 0.9 to 4 N over short waves and long ones.
fn waves_are_followed(link: Effect, numbers: &[f64]) {
    for wave in [0.004, 0.01] {
        for strength in [0.63, 1.0, 2.8] {
            let along: &[f64] = &[0.9, wave, 0.7];
            let effects = [(link, numbers), (Effect::PositionDependentFriction, along)];
            let all = errors(&effects, strength, &[1, 2, 5, 10, 25], 2e-7);
            // Of which up to a half is the plain integration's own.
            let most = all.iter().copied().fold(0.0, f64::max);
            let name = link.info().name;
            let what = format!("{name} {numbers:?}, waves of {wave} m, {strength} times the drive");
            assert!(most < 2.0 * MICROMETRE, "{what}: {all:?} m");
        }
    }
}

#[test]
fn waves_of_friction_along_the_way_behind_a_short_lag() {
    waves_are_followed(Effect::DriveLag, &[3e-3]);
}

#[test]
fn waves_of_friction_along_the_way_behind_a_long_lag() {
    waves_are_followed(Effect::DriveLag, &[20e-3]);
}

#[test]
fn waves_of_friction_along_the_way_behind_a_spring() {
    waves_are_followed(Effect::TransmissionCompliance, &usual(Effect::TransmissionCompliance));
}

/// A step that only looks at its middle would miss a fall that is passed within a sample.
#[test]
fn a_sharp_fall_of_friction_behind_links_is_not_missed_between_samples() {
    let links: [(Effect, &[f64]); 2] =
        [(Effect::DriveLag, &[20e-3]), (Effect::TransmissionCompliance, &[300.0, 0.5, 0.03])];
    for link in links {
        for fall in [1e-3, 1e-4] {
            let effects = [link, (Effect::StribeckFriction, &[0.3, fall, 2.0])];
            let all = errors(&effects, 1.0, &[1, 5, 25], 2e-7);
            let off = all.iter().map(|error| (error - all[0]).abs()).fold(0.0, f64::max);
            assert!(off < 0.5 * MICROMETRE, "{} {fall}: {all:?} m", link.0.info().name);
        }
    }
}

/// The load changes its sign within a sample, drag grows with the speed.
#[test]
fn friction_that_changes_between_samples_behind_a_lag() {
    for lag in [3e-3, 20e-3] {
        for bent in [Effect::LoadDependentFriction, Effect::QuadraticDrag, Effect::LubricantBuildup]
        {
            let numbers = usual(bent);
            let effects = [(Effect::DriveLag, &[lag][..]), (bent, &numbers[..])];
            let all = errors(&effects, 1.0, &[1, 2, 5, 10, 25], 2e-7);
            let most = all.iter().copied().fold(0.0, f64::max);
            assert!(most < MICROMETRE, "{lag} {}: {all:?} m", bent.info().name);
        }
    }
}

/// A contact that opens and closes leaves more to chance, in the plain integration most.
#[test]
#[ignore = "takes ten seconds"]
fn friction_that_bends_behind_a_spring_or_a_gap() {
    for (link, longest) in
        [(Effect::TransmissionCompliance, 2e-7), (Effect::TransmissionBacklash, 5e-8)]
    {
        for bent in [Effect::StribeckFriction, Effect::LoadDependentFriction] {
            let (a, b) = (usual(link), usual(bent));
            let all = errors(&[(link, &a[..]), (bent, &b[..])], 1.0, &[1, 2, 5, 10, 25], longest);
            let most = all.iter().copied().fold(0.0, f64::max);
            let names = (link.info().name, bent.info().name);
            assert!(most < MICROMETRE, "{names:?}: {all:?} m");
        }
    }
}

/// A sample is held in as many parts: looks for events are up to as many times denser, and hardly
/// any part is long enough for a long step.
const PARTS: usize = 64;

/// Where nothing happens, one long step is taken; and fast oscillations are looked at no more
/// than a few times a sample. Neither moves the head by more than rounding, or than the steps
/// of friction that bends.
#[test]
fn few_looks_at_stiff_joints_see_what_many_do() {
    let run = pulses(4e-3, 1.0);
    let part = |t: f64, i: usize| t + 4e-3 * i as f64 / PARTS as f64;
    let dense = Run {
        times: run.times.iter().flat_map(|t| (0..PARTS).map(move |i| part(*t, i))).collect(),
        drive: run.drive.iter().flat_map(|u| [*u; PARTS]).collect(),
        ..run.clone()
    };
    let mass = NOMINAL.mass;
    let bent: [&[(Effect, &[f64])]; 3] = [
        &[],
        &[(Effect::StribeckFriction, &[0.8, 0.01, 1.0])],
        &[(Effect::PositionDependentFriction, &[0.5, 0.01, 0.3])],
    ];
    let mut joints = Vec::new();
    for side in [0.02 * mass, 0.2 * mass] {
        for stiffness in [1e3, 1e4, 1e5, 1e6].map(|k| k * mass) {
            let critical = 2.0 * (stiffness * side).sqrt();
            joints.extend([0.02, 0.3].map(|share| {
                (Effect::TransmissionCompliance, vec![stiffness, share * critical, side])
            }));
        }
        joints.extend([1e-4, 2e-3].map(|gap| (Effect::TransmissionBacklash, vec![gap, side])));
    }
    let mut worst = [0.0_f64; 2];
    for (joint, numbers) in &joints {
        for others in bent {
            let (mut active, mut values) = (Active::default(), [0.0; EFFECT_PARAMS]);
            for (effect, numbers) in others.iter().copied().chain([(*joint, &numbers[..])]) {
                active = active.with(effect);
                values[effect.first()..][..numbers.len()].copy_from_slice(numbers);
            }
            let positions = |run: &Run| {
                let columns = [column(active, values, run.times.len())];
                let how = (Level::current().unwrap(), 1);
                replay(&NOMINAL, std::slice::from_ref(run), &columns, how, &Control::default())
                    .unwrap()
                    .x
            };
            let many: Vec<f64> = positions(&dense).into_iter().step_by(PARTS).collect();
            let off = largest(&positions(&run), &many);
            let kind = usize::from(!others.is_empty());
            worst[kind] = worst[kind].max(off);
        }
    }
    assert!(worst[0] < 5e-9 && worst[1] < 0.5 * MICROMETRE, "{worst:?}");
}
