//! Trajectories that are known: closed forms, and stick-slip to which many
//! digits were computed with other programs.

use super::*;

/// m = 1 kg and g = 1 m/s^2: coefficients are forces.
fn unit(law: &str, drive: &str, more: &[(&'static str, f64)]) -> Case {
    Case::new(law, drive, vec![("mass", 1.0), ("gravity", 1.0)]).with(more)
}

#[test]
fn a_sliding_segment_stops_where_the_closed_form_says() {
    for (viscous, time, path) in [(0.5, 0.440_444_6, 0.190_719_0), (0.0, 0.679_572_7, 0.339_786_3)]
    {
        let given = [
            ("mass", 0.271),
            ("gravity", 1.0),
            ("mu_coulomb", 0.39878 / 0.271),
            ("viscous", viscous),
            ("start_speed", 1.0),
            ("duration", 2.0),
        ];
        let case = Case::new("coulomb_viscous", "constant", given.to_vec());
        let found = case.get(&["stuck_time", "final_position", "stick_phases", "energy_residual"]);
        near(2.0 - found[0], time, 1e-6);
        near(found[1], path, 1e-6);
        assert_eq!(found[2], 1.0);
        assert!(found[3].abs() < 1e-14, "{}", found[3]);
        let stepped = case.by("runge_kutta");
        let stepped = stepped.get(&["stuck_time", "final_position", "stick_phases"]);
        near(stepped[0], found[0], 1e-12);
        near(stepped[1], found[1], 1e-12);
        assert_eq!(stepped[2], 1.0);
    }
}

#[test]
fn dry_oscillator_loses_the_same_amplitude_each_half_cycle() {
    for (half, turn) in [(1.0, -0.035), (2.0, 0.015), (3.0, 0.005), (4.0, 0.005)] {
        let case = unit(
            "coulomb",
            "constant",
            &[
                ("mu_coulomb", 1.0),
                ("spring_stiffness", 100.0),
                ("start_position", 0.055),
                ("duration", half * std::f64::consts::PI / 10.0),
            ],
        );
        let found = case.one("final_position");
        assert!((found - turn).abs() < 1e-9, "{half}: {found}");
    }
}

#[test]
fn lugre_stick_slip() {
    let case = unit(
        "lugre",
        "constant",
        &[
            ("mu_coulomb", 1.0),
            ("mu_static", 1.5),
            ("viscous", 0.4),
            ("stribeck_speed", 1e-3),
            ("bristle_stiffness", 1e5),
            ("bristle_damping", 1e5f64.sqrt()),
            ("spring_stiffness", 2.0),
            ("pull_speed", 0.1),
            ("duration", 30.0),
            ("tolerance", 1e-7),
        ],
    );
    let found = case.get(&["final_position", "peak_motion"]);
    near(found[0], 2.545_101_9, 1e-5);
    near(found[1], 0.369_816, 1e-5);
}

/// One method is checked against another: where both fit they agree.
#[test]
fn methods_agree() {
    for drive in [DriveKind::Constant, DriveKind::Pulse, DriveKind::Table] {
        for law in LAWS.iter().filter(|law| law.linear) {
            let case = Case::usual(law.info.name, drive);
            let exact = case.get(&outputs());
            let stepped = case.clone().with(&[("time_step", 1e-4)]).by("runge_kutta");
            for ((name, a), b) in outputs().iter().zip(exact).zip(stepped.get(&outputs())) {
                let close = (a - b).abs() < 1e-7 + 1e-6 * a.abs();
                assert!(close || a.is_nan() && b.is_nan(), "{} {name}: {a} {b}", case.name());
            }
        }
    }
    for law in LAWS.iter().filter(|law| law.kind == Kind::Smooth) {
        let case = Case::usual(law.info.name, DriveKind::Sine);
        let fine = [("time_step", 2e-5), ("tolerance", 1e-9)];
        let stiff = case.clone().with(&fine).one("final_position");
        let stepped = case.clone().with(&fine).by("runge_kutta").one("final_position");
        assert!((stiff - stepped).abs() < 1e-8, "{}: {stiff} {stepped}", case.name());
    }
    for law in LAWS.iter().filter(|law| law.kind != Kind::Dry) {
        let case = Case::usual(law.info.name, DriveKind::Sine);
        let adaptive = case.clone().with(&[("tolerance", 1e-8)]).one("final_position");
        let fixed = case.clone().with(&[("time_step", 2e-6)]).by("rosenbrock_fixed");
        let fixed = fixed.one("final_position");
        assert!((adaptive - fixed).abs() < 1e-8, "{}: {adaptive} {fixed}", case.name());
    }
}
