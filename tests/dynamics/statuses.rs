//! Why a trajectory has no value: NaN exactly where the status is not ok.

use super::*;
use locosweep::physics::friction::Values;

#[track_caller]
fn agree(values: &[f64], codes: &[u8], what: &str) {
    for (value, code) in values.iter().zip(codes) {
        assert_eq!(value.is_nan(), *code != 0, "{what}: {value} with code {code}");
        assert!(!value.is_infinite(), "{what}");
    }
}

#[test]
fn a_stroke_that_is_not_reached() {
    for case in everything() {
        let case = case.over("stroke", vec![1e-6, 1e-4, 1e-3, 3e-3, 1.0, 10.0]);
        let (values, codes) = results(&case.all(), options(1, 64));
        for (k, name) in outputs().iter().enumerate() {
            agree(&values[k], &codes[k], &case.name());
            let expected = match *name {
                "stroke_time" => Status::NotReached,
                _ => Status::Ok,
            };
            assert_eq!(codes[k][5], expected as u8, "{} {name}", case.name());
        }
        let times = &values[outputs().iter().position(|name| *name == "stroke_time").unwrap()];
        let reached: Vec<f64> = times.iter().copied().filter(|t| !t.is_nan()).collect();
        assert!(!reached.is_empty(), "{} reaches nothing", case.name());
        assert!(reached.windows(2).all(|t| t[0] < t[1]), "{}: {reached:?}", case.name());
        assert!(reached.iter().all(|t| (0.0..=0.25).contains(t)));
    }
}

/// When the stroke is complete the position is there.
#[test]
fn stroke_time_is_when_the_position_is_there() {
    for law in LAWS {
        for method in methods(law, DriveKind::Pulse) {
            let fine = [("time_step", 2e-4), ("tolerance", 1e-8)];
            let case = Case::usual(law.info.name, DriveKind::Pulse).by(method).with(&fine);
            let time = case.one("stroke_time");
            let there = case.clone().with(&[("duration", time)]).one("final_position");
            assert!((there - 0.011).abs() < 1e-8, "{}: {there} at {time}", case.name());
        }
    }
}

fn smooth_laws() -> impl Iterator<Item = &'static LawEntry> {
    LAWS.iter().filter(|law| law.kind == Kind::Smooth)
}

/// A step far too long for a steep law is seen, not passed on, also where it jumps
/// over the law's whole rise so that no stage meets the steep part.
#[test]
fn steps_too_long_for_the_law_have_no_value() {
    let mut passed = String::new();
    let steep = [("transition_speed", 1e-7), ("duration", 1.0)];
    let from_rest = [("drive_force", 1.2), ("start_speed", 0.0)];
    for law in smooth_laws() {
        for (drive, given) in [(DriveKind::Sine, &[][..]), (DriveKind::Constant, &from_rest)] {
            let case = Case::usual(law.info.name, drive)
                .by("runge_kutta")
                .with(&steep)
                .with(given)
                .over("time_step", vec![1e-3, 1e-2]);
            let (values, codes) = results(&case.all(), options(1, 64));
            // The stiff method takes the same law as it is.
            let stiff = Case { choice: Choice { method: None, ..case.choice.clone() }, ..case };
            let (known, fine) = results(&stiff.all(), options(1, 64));
            assert!(fine[0].iter().all(|code| *code == 0));
            for k in 0..values.len() {
                agree(&values[k], &codes[k], law.info.name);
                for (i, code) in codes[k].iter().enumerate() {
                    let (got, known) = (values[k][i], known[k][i]);
                    if *code != Status::Unresolved as u8 {
                        let (law, name) = (law.info.name, outputs()[k]);
                        passed += &format!("\n{law} {name} cell {i}: {got:e}, stiff {known:e}");
                    }
                }
            }
        }
    }
    assert!(passed.is_empty(), "values from steps that are too long:{passed}");
}

/// Steps that follow the law keep their values: short enough for its rise at rest,
/// or never near it, or at rest for good.
#[test]
fn steps_that_fit_the_law_have_their_values() {
    let fast = [
        ("transition_speed", 1e-7),
        ("time_step", 1e-3),
        ("start_speed", 0.5),
        ("drive_force", 1.0),
    ];
    let still = [
        ("transition_speed", 1e-7),
        ("time_step", 1e-3),
        ("start_speed", 0.0),
        ("drive_force", 0.0),
        ("slope_deg", 0.0),
    ];
    for law in smooth_laws() {
        let turning = Case::usual(law.info.name, DriveKind::Sine)
            .with(&[("transition_speed", 1e-3), ("duration", 0.5)]);
        let given = turning.given.iter().map(|(name, v)| (ParamId::parse(name).unwrap(), *v));
        let values = Values::of(&given.collect::<Vec<_>>());
        let slowest = 1e-12;
        let rate = (law.steady)(&values, slowest) / slowest / 0.271;
        let turning = turning.with(&[("time_step", 2.0 / rate)]);
        let steady = Case::usual(law.info.name, DriveKind::Constant);
        for case in [turning, steady.clone().with(&fast), steady.with(&still)] {
            let stiff = case.clone().with(&[("tolerance", 1e-9)]);
            let case = case.by("runge_kutta");
            let (values, codes) = results(&case.job(&["final_position"]), options(1, 64));
            assert_eq!(codes[0][0], 0, "{}", case.name());
            let miss = (values[0][0] - stiff.one("final_position")).abs();
            assert!(miss < 1e-4, "{}: off by {miss:e}", case.name());
        }
    }
}

#[test]
fn trajectories_that_leave_all_bounds() {
    // A spring so stiff that explicit steps of a millisecond amplify it.
    for law in ["coulomb", "tanh"] {
        let case = Case::usual(law, DriveKind::Sine)
            .by("runge_kutta")
            .with(&[("spring_stiffness", 1e9), ("duration", 1.0)])
            .over("start_position", vec![0.01, 0.02]);
        let (values, codes) = results(&case.all(), options(1, 64));
        for k in 0..values.len() {
            agree(&values[k], &codes[k], law);
            let no = [Status::Diverged as u8, Status::Unresolved as u8];
            assert!(codes[k].iter().all(|code| no.contains(code)), "{law}: {:?}", codes[k]);
        }
    }
    let far = Case::usual("coulomb", DriveKind::Constant)
        .with(&[
            ("mass", 1e-9),
            ("gravity", 0.0),
            ("wall_force", 0.0),
            ("drive_limit", f64::INFINITY),
        ])
        .with(&[("drive_force", 1e9), ("duration", 1e9)]);
    let (values, codes) = results(&far.all(), options(1, 64));
    for (value, code) in values.iter().zip(&codes) {
        agree(value, code, "far");
    }
}

/// A run of more steps than are ever taken is refused before it begins.
#[test]
fn endless_runs_say_so() {
    let run = [("duration", 1e3), ("time_step", 1e-9)];
    for (law, method) in
        [("stribeck", "runge_kutta"), ("tanh", "runge_kutta"), ("lugre", "rosenbrock_fixed")]
    {
        let case = Case::usual(law, DriveKind::Sine).by(method).with(&run);
        let (values, codes) = results(&case.all(), options(1, 64));
        for (value, code) in values.iter().zip(&codes) {
            agree(value, code, law);
            assert_eq!(code[0], Status::TooManySteps as u8, "{law}");
        }
    }
    let pulses = [("drive_period", 1e-6), ("duration", 1e3)];
    let case = Case::usual("coulomb", DriveKind::Pulse).with(&pulses);
    assert_eq!(results(&case.all(), options(1, 64)).1[0][0], Status::TooManySteps as u8);
}

#[test]
fn without_location_events_fall_on_steps() {
    for law in LAWS.iter().filter(|law| law.kind == Kind::Dry) {
        let case = Case::usual(law.info.name, DriveKind::Sine).by("runge_kutta");
        let located = case.clone().with(&[("time_step", 1e-4)]).one("final_position");
        let rough = |h: f64| {
            let case = case.clone().with(&[("time_step", h)]).change(|c| c.locate = false);
            (case.one("final_position") - located).abs()
        };
        assert!(rough(1e-3) > 0.0 && rough(2e-5) < 2e-5, "{} {}", law.info.name, rough(2e-5));
    }
}
