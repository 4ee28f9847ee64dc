//! Traces show the trajectories of the sweep; a table of samples is the pulse
//! train that it describes.

use super::*;

fn traced(case: &Case, stations: &[f64], options: Options) -> Traces {
    trace(&case.job(&["final_position"]), stations, options, &Control::default()).unwrap()
}

/// Where nothing lies between, the last station is the end to the last bit.
#[test]
fn the_end_of_a_trace_is_the_end_of_the_sweep() {
    for case in everything() {
        let case = case.over("start_speed", steps(-0.2, 0.3, 19));
        let (values, _) = results(&case.job(&["final_position", "final_speed"]), options(1, 64));
        let all = traced(&case, &[1.0], options(1, 64));
        same(&all.x, &values[0], &case.name());
        same(&all.v, &values[1], &case.name());
    }
}

/// Stations cut steps: that is rounding for exact runs, the order of the step
/// elsewhere.
#[test]
fn stations_on_the_way_change_what_a_step_does() {
    let stations = steps(0.0, 1.0, 11);
    for case in everything() {
        let case = case.over("start_speed", vec![-0.2, 0.0, 0.05, 0.3]);
        let allowed = match case.choice.method.as_deref() {
            Some("exact") => 1e-14,
            Some("dormand_prince" | "dormand_prince_fixed") => 0.0,
            // Its friction jumps along the direction, wherever the steps fall.
            Some("runge_kutta") if case.choice.law == "patch" => 2e-5,
            Some("runge_kutta") => 2e-7,
            Some("rosenbrock") => 2e-6,
            _ => 1e-4,
        };
        let (values, _) = results(&case.job(&["final_position", "final_speed"]), options(1, 64));
        let all = traced(&case, &stations, options(1, 64));
        for (i, end) in values[0].iter().enumerate() {
            let (first, last) = (11 * i, 11 * i + 10);
            assert_eq!(all.x[first], 0.01, "{}", case.name());
            assert_eq!(all.v[first], case.axes[0].1[i], "{}", case.name());
            let miss = (all.x[last] - end).abs();
            assert!(miss <= allowed, "{} cell {i}: {miss:e}", case.name());
        }
        let dry = LawEntry::parse(&case.choice.law).unwrap().kind == Kind::Dry;
        for i in 0..44 {
            let (v, direction, force) = (all.v[i], all.direction[i], all.force[i]);
            assert!(force.abs() <= 1.6, "{} {force}", case.name());
            assert!([-1.0, 0.0, 1.0].contains(&direction), "{} {direction}", case.name());
            assert!(direction * v >= 0.0, "{} {direction} {v}", case.name());
            // Friction of a dry law holds or not; the others always slide.
            assert!(!dry || direction != 0.0 || v == 0.0, "{} creeps at {v}", case.name());
        }
    }
}

#[test]
fn threads_and_levels_do_not_change_a_trace() {
    let stations = steps(0.0, 1.0, 17);
    for (law, drive) in [
        ("static_viscous", DriveKind::Pulse),
        ("stribeck", DriveKind::Sine),
        ("tanh", DriveKind::Chirp),
        ("lugre", DriveKind::Ramp),
    ] {
        let case = Case::usual(law, drive)
            .over("slope_deg", steps(-4.0, 6.0, 5))
            .over("start_speed", steps(-0.2, 0.3, 119));
        let expected = traced(&case, &stations, options(1, 64));
        for threads in [2, 3] {
            assert!(traced(&case, &stations, options(threads, 7)) == expected, "{law}");
        }
        for level in Level::available() {
            let at = Options { level, ..options(2, 64) };
            let got = traced(&case, &stations, at);
            same(&got.x, &expected.x, law);
            same(&got.v, &expected.v, law);
        }
    }
}

#[test]
fn closed_forms_have_no_trace() {
    let case = Case::usual("coulomb", DriveKind::Pulse);
    let error = trace(&case.job(&["mean_velocity"]), &[1.0], options(1, 64), &Control::default());
    assert!(matches!(error, Err(Error::BadOption { name: "quantity", .. })));
}

#[test]
fn a_table_of_a_pulse_train_is_that_pulse_train() {
    let (period, duty, forward, back) = (0.1, 0.6, 1.5, 1.9);
    // The samples' times as the pulse train computes its own.
    let times: Vec<f64> = (0..6)
        .map(|i| {
            let share = if i % 2 == 1 { duty } else { 0.0 };
            (f64::from(i / 2) + share) * period
        })
        .collect();
    let values: Vec<f64> = (0..6).map(|i| if i % 2 == 0 { forward } else { -back }).collect();
    for law in LAWS {
        let pulse = Case::usual(law.info.name, DriveKind::Pulse);
        for method in methods(law, DriveKind::Pulse) {
            let pulse = pulse.clone().by(method).over("start_speed", vec![-0.2, 0.0, 0.05, 0.3]);
            let mut table = pulse.clone().with(&[("gain", 1.0)]).change(|c| {
                c.drive = "table".to_owned();
                (c.times, c.values) = (times.clone(), values.clone());
            });
            let [a, b] = [&pulse, &table].map(|case| results(&case.all(), options(1, 64)).0);
            for (k, name) in outputs().iter().enumerate() {
                same(&a[k], &b[k], &format!("{} {name}", pulse.name()));
            }
            // Before its first sample a table has that sample's value.
            table.choice.times[0] = 0.05;
            let late = results(&table.all(), options(1, 64)).0;
            for (k, name) in outputs().iter().enumerate() {
                same(&late[k], &a[k], &format!("{} {name} begun late", pulse.name()));
            }
        }
    }
}

/// The gain of a table is a factor on its samples.
#[test]
fn gain_is_a_factor_on_samples() {
    let case = Case::usual("static_viscous", DriveKind::Table);
    let twice = case.clone().with(&[("gain", 3.0)]);
    let double = case.change(|c| c.values.iter_mut().for_each(|v| *v *= 2.0));
    assert_eq!(bits(&twice.get(&outputs())), bits(&double.get(&outputs())));
}
