//! Adaptive steps of dry laws: samples come from the dense output and shorten no
//! step, events lie where the exact method has them, nothing is stepped over.

use super::*;

fn dry_laws() -> impl Iterator<Item = &'static LawEntry> {
    LAWS.iter().filter(|law| law.kind == Kind::Dry)
}

fn traced(case: &Case, stations: &[f64]) -> Traces {
    trace(&case.job(&["final_position"]), stations, options(1, 64), &Control::default()).unwrap()
}

/// Slope of log error over log step.
fn order(steps: &[f64], errors: &[f64]) -> f64 {
    let logs = |all: &[f64]| all.iter().map(|x| x.ln()).collect::<Vec<_>>();
    let (x, y) = (logs(steps), logs(errors));
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    let (mx, my) = (mean(&x), mean(&y));
    let cross: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
    cross / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
}

#[test]
fn samples_do_not_shorten_steps() {
    for law in dry_laws() {
        for method in ["dormand_prince", "dormand_prince_fixed"] {
            let case = Case::usual(law.info.name, DriveKind::Sine).by(method);
            let end = case.get(&["final_position", "final_speed"]);
            for count in [2, 13, 1001] {
                let all = traced(&case, &steps(0.0, 1.0, count));
                let last = [all.x[count - 1], all.v[count - 1]];
                same(&last, &end, &case.name());
            }
        }
    }
}

/// Between steps motion is as good as at their ends.
#[test]
fn dense_output_is_of_fifth_order() {
    let stations = steps(0.0, 1.0, 98);
    // Sliding throughout, so that all that counts is the step.
    let case = Case::usual("stribeck", DriveKind::Sine).with(&[
        ("start_speed", 0.3),
        ("drive_force", 1.2),
        ("drive_amplitude", 0.3),
        ("stribeck_speed", 0.3),
        ("drive_limit", 1e3),
        ("duration", 0.5),
    ]);
    let case = case.by("dormand_prince_fixed");
    let known = traced(&case.clone().with(&[("time_step", 1e-4)]), &stations);
    let sizes: Vec<f64> = (0..6).map(|k| 0.04 / 2f64.powi(k)).collect();
    let miss = |h: &f64| {
        let all = traced(&case.clone().with(&[("time_step", *h)]), &stations);
        let square =
            |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum() };
        (square(&all.x, &known.x) + square(&all.v, &known.v)).sqrt()
    };
    let errors: Vec<f64> = sizes.iter().map(miss).collect();
    let found = order(&sizes, &errors);
    assert!((found - 5.0).abs() < 0.15, "order {found}: {errors:?}");
    // Straight lines between the ends would be far off.
    let h = sizes[5];
    let share = h / 0.5;
    let ends = traced(&case.with(&[("time_step", h)]), &[0.0, 0.5 * share, share]);
    let straight = 0.5 * (ends.v[0] + ends.v[2]) - ends.v[1];
    assert!(straight.abs() > 1e3 * errors[5], "{straight:e} {errors:?}");
}

/// Stops, rests, strokes and ledgers of the exact method.
#[test]
fn events_are_where_exact_propagation_has_them() {
    for drive in [DriveKind::Constant, DriveKind::Pulse, DriveKind::Table] {
        for law in LAWS.iter().filter(|law| law.linear) {
            let case = Case::usual(law.info.name, drive)
                .over("start_speed", vec![-0.3, -0.01, 0.0, 0.05, 0.4])
                .over("stroke", vec![1e-4, 1e-3, 3e-3]);
            let (exact, codes) = results(&case.all(), options(1, 64));
            let case = case.with(&[("tolerance", 1e-11)]).by("dormand_prince");
            let (found, others) = results(&case.all(), options(1, 64));
            assert_eq!(codes, others, "{}", case.name());
            for (name, (a, b)) in outputs().iter().zip(exact.iter().zip(&found)) {
                for (i, (a, b)) in a.iter().zip(b).enumerate() {
                    let close = (a - b).abs() < 1e-10 + 1e-9 * a.abs();
                    let both = a.is_nan() && b.is_nan();
                    assert!(close || both, "{} {name} cell {i}: {a} {b}", case.name());
                }
            }
        }
    }
}

/// The error follows the tolerance for every law, whatever happens on the way.
#[test]
fn tighter_tolerances_come_closer() {
    let mut faults = String::new();
    for law in dry_laws() {
        // Friction that jumps along the way is met by steps of any size alike.
        let jumps = law.info.name == "patch";
        // Nor has an error estimate derivatives to follow at the joints of a track, or
        // where drag rises infinitely steeply from rest.
        let bent = ["power_drag", "track"].contains(&law.info.name);
        for drive in [DriveKind::Sine, DriveKind::Ramp, DriveKind::Pulse] {
            let case = Case::usual(law.info.name, drive).by("dormand_prince");
            let at = |tolerance: f64| case.clone().with(&[("tolerance", tolerance)]);
            let names = ["final_position", "final_speed", "work_in", "dissipated"];
            let known = at(1e-12).get(&names);
            for tolerance in [1e-4, 1e-6, 1e-8] {
                let floor = if jumps { 1e-4 } else { 0.0 } + if bent { 1e-5 } else { 0.0 };
                let allowed = floor + 100.0 * tolerance;
                for (name, (a, b)) in names.iter().zip(known.iter().zip(at(tolerance).get(&names)))
                {
                    let miss = (a - b).abs() / a.abs().max(0.01);
                    if miss >= allowed {
                        faults += &format!("\n{} {name} at {tolerance:e}: {miss:e}", case.name());
                    }
                }
            }
        }
    }
    assert!(faults.is_empty(), "{faults}");
}

/// A run without anything that would shorten a step, but for what lies ahead.
#[test]
fn nothing_along_the_way_is_stepped_over() {
    let slides = [("start_speed", 0.5), ("drive_force", 0.6), ("duration", 0.5), ("viscous", 0.0)];
    let free = Case::usual("patch", DriveKind::Constant).with(&slides).by("dormand_prince");
    let patch = free.clone().with(&[("patch_start", 0.1), ("patch_length", 2e-3)]);
    let away = free.with(&[("patch_start", 50.0)]);
    let [met, missed] = [&patch, &away].map(|case| case.get(&["dissipated", "final_position"]));
    let level = missed[0] / (missed[1] - 0.01);
    // The patch counts as so much more distance.
    near(met[0] / level - (met[1] - 0.01), (1.6 - 1.0) * 2e-3, 0.05);
}

/// What never changes is one step per piece; what rests is not stepped through.
#[test]
fn fixed_and_adaptive_steps_agree() {
    for law in dry_laws() {
        let jumps = law.info.name == "patch";
        for drive in DriveKind::ALL {
            let case = Case::usual(law.info.name, *drive);
            let tight = case.clone().with(&[("tolerance", 1e-10)]).by("dormand_prince");
            let fixed = case.clone().with(&[("time_step", 1e-4)]).by("dormand_prince_fixed");
            let steps = case.with(&[("time_step", 2e-5)]).by("runge_kutta");
            let names = ["final_position", "final_speed", "stuck_time", "stick_phases"];
            let allowed = if jumps { 1e-3 } else { 1e-6 };
            let known = tight.get(&names);
            for other in [fixed, steps] {
                for (name, (a, b)) in names.iter().zip(known.iter().zip(other.get(&names))) {
                    let miss = (a - b).abs();
                    assert!(miss < allowed * (1.0 + a.abs()), "{} {name}: {a} {b}", other.name());
                }
            }
        }
    }
}

#[test]
fn motion_that_is_looked_at_takes_dense_output() {
    let method = |law: &str, drive: DriveKind, motion: bool| {
        let case = Case::usual(law, drive).change(|choice| choice.motion = motion);
        case.job(&["final_position"]).choice().unwrap().2
    };
    assert_eq!(method("stribeck", DriveKind::Sine, false), "runge_kutta");
    assert_eq!(method("stribeck", DriveKind::Sine, true), "dormand_prince");
    assert_eq!(method("coulomb", DriveKind::Pulse, true), "exact");
    assert_eq!(method("lugre", DriveKind::Sine, true), "rosenbrock");
}
