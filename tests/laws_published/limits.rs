//! Laws that turn into simpler ones, and what laws hold at rest.

use super::*;

/// Pairs that agree to the last bit where a parameter leaves its term out.
#[test]
fn laws_without_their_term_are_simpler_laws() {
    let base = [("mu_static", 0.7), ("mu_coulomb", 0.4), ("viscous", 1.3)];
    let equal = [("mu_static", 0.4), ("mu_coulomb", 0.4), ("viscous", 1.3)];
    let dry = [("mu_static", 0.7), ("mu_coulomb", 0.4), ("viscous", 0.0)];
    let cases: [Limit; 18] = [
        ("coulomb_viscous", &dry, "coulomb"),
        ("static_coulomb", &base, "coulomb"),
        ("quadratic", &base, "coulomb_viscous"),
        ("power_drag", &base, "coulomb"),
        ("static_viscous", &dry, "static_coulomb"),
        ("static_viscous", &base, "coulomb_viscous"),
        ("load_friction", &base, "static_viscous"),
        ("load_viscous", &base, "coulomb_viscous"),
        ("directional", &base, "static_viscous"),
        ("ripple", &base, "static_viscous"),
        ("patch", &base, "static_viscous"),
        ("track", &base, "static_viscous"),
        ("buildup", &base, "coulomb_viscous"),
        ("tustin", &equal, "coulomb_viscous"),
        ("bo_pavelescu", &equal, "coulomb_viscous"),
        ("stribeck", &equal, "coulomb_viscous"),
        ("hess_soom", &equal, "coulomb_viscous"),
        ("modelica", &equal, "coulomb_viscous"),
    ];
    for (name, given, simpler) in cases {
        let values = contact(9.81, given);
        for direction in [1.0, -1.0] {
            let contact_state =
                ContactState { direction, x: 0.37, sliding_distance: 0.2, drive: 4.0, t: 0.0 };
            for speed in [0.0, 1e-4, 0.03, 2.0] {
                let [got, expected] = [name, simpler]
                    .map(|n| (law(n).resistance)(&values, speed, &contact_state, &NONE));
                assert_eq!(got.to_bits(), expected.to_bits(), "{name} and {simpler} at {speed}");
            }
        }
    }
}

#[test]
fn limits_between_laws() {
    let base = [
        ("mu_static", 0.8),
        ("mu_coulomb", 0.5),
        ("viscous", 2.0),
        ("stribeck_speed", 0.0625),
        ("modelica_decay", 16.0),
        ("power_drag", 2.0),
        ("power_exponent", 1.0),
        ("transition_speed", 1e-7),
    ];
    let with = |more: &[(&str, f64)]| contact(10.0, &[&base[..], more].concat());
    let values = with(&[("stribeck_exponent", 1.0)]);
    let bell = with(&[("stribeck_exponent", 2.0)]);
    for v in [1e-3, 0.02, 0.1, 0.5, 3.0] {
        assert_eq!(force("modelica", &values, v), force("tustin", &values, v));
        close(force("bo_pavelescu", &values, v), force("tustin", &values, v), 1e-15);
        close(force("bo_pavelescu", &bell, v), force("stribeck", &bell, v), 1e-15);
        close(force("power_drag", &values, v), force("coulomb_viscous", &values, v), 1e-15);
        // Regularised laws far above their transition, bristles in steady sliding.
        close(force("tanh", &values, v), force("stribeck", &values, v), 1e-15);
        close(force("bengisu_akay", &values, v), force("tustin", &values, v), 1e-5);
        for name in ["brown_mcphee", "simscape"] {
            close(force(name, &values, v), force("coulomb_viscous", &values, v), 1e-9);
        }
        for name in ["lugre", "elasto_plastic", "maxwell_slip"] {
            close(steady(name, &values, v), force("stribeck", &values, v), 1e-14);
        }
        close(steady("dahl", &values, v), force("coulomb_viscous", &values, v), 1e-14);
        // A thick film: only its shear is left.
        let film = with(&[("mixed_speed", 1e-6)]);
        close(force("mixed", &film, v), 2.0 * v, 1e-15);
    }
    // Equal levels and no damping: LuGre is Dahl's curve with exponent 1.
    let plain = contact(10.0, &[("mu_static", 0.5), ("mu_coulomb", 0.5), ("bristle_damping", 0.0)]);
    let (lugre, dahl) = (coefficients::<Lugre>(&plain), coefficients::<Dahl>(&plain));
    for z in [-4e-5, -1e-6, 0.0, 3e-5, 4.9e-5] {
        for v in [-0.3, 0.01] {
            let z = [z, 0.0, 0.0, 0.0];
            let [a, b] = [Lugre::rates(&lugre, v, &z), Dahl::rates(&dahl, v, &z)];
            assert!((a[0] - b[0]).abs() <= 1e-14 * v.abs(), "{a:?} {b:?}");
        }
    }
    for law in LAWS.iter().filter(|law| law.kind == Kind::Bristle) {
        let mu = if law.uses(ParamId::MuStatic) { 0.8 } else { 0.5 };
        close((law.break_away)(&values, &ContactState::start(-1.0)), 10.0 * mu, 1e-9);
    }
}

#[test]
fn elasto_plastic_bristles_do_not_slide_below_their_share() {
    let values = standard(&[("elastic_share", 0.7)]);
    let law = coefficients::<ElastoPlastic>(&values);
    // 0.7 F_C/sigma_0 is 7 um; g at rest 15 um.
    for v in [-1e-3, 1e-6, 0.2] {
        for um in [-6.9, -1.0, 0.0, 5.0, 6.9] {
            let z = [um * 1e-6, 0.0, 0.0, 0.0];
            assert_eq!(ElastoPlastic::rates(&law, v, &z)[0], v);
        }
        let back = [-v.signum() * 14e-6, 0.0, 0.0, 0.0];
        assert_eq!(ElastoPlastic::rates(&law, v, &back)[0], v);
        let beyond = [v.signum() * 20e-6, 0.0, 0.0, 0.0];
        assert!(ElastoPlastic::rates(&law, v, &beyond)[0] / v < 0.0);
    }
}

#[test]
fn gonthier_breaks_away_at_what_it_dwelled_for() {
    let law = coefficients::<Gonthier>(&standard(&[("viscous", 0.0), ("dwell_time", 2.0)]));
    for (dwell, level) in [(0.0, 1.0), (0.5, 1.25), (1.0, 1.5)] {
        let z = [1.0, dwell, 0.0, 0.0];
        let rates = Gonthier::rates(&law, 1e-9, &z);
        close(Gonthier::force(&law, 1e-9, &z, &rates), level, 1e-9);
        assert!((rates[1] - (1.0 - dwell) / 2.0).abs() < 1e-8);
    }
    // Sliding forgets at the relaxation time of the bristles.
    let rates = Gonthier::rates(&law, 0.1, &[1e-5, 1.0, 0.0, 0.0]);
    close(rates[1], -(1e5 / 316.227_766_016_837_94), 1e-12);
}

#[test]
fn directional_skin_holds_both_ways() {
    let given = [("mu_static", 0.5), ("mu_coulomb", 0.25), ("skin_ratio", 3.0), ("viscous", 2.0)];
    let values = contact(8.0, &given);
    let skin = law("directional");
    for (direction, holds, slides) in [(1.0, 4.0, 2.2), (-1.0, 12.0, 6.2)] {
        assert_eq!((skin.break_away)(&values, &ContactState::start(direction)), holds);
        close(
            (skin.resistance)(&values, 0.1, &ContactState::start(direction), &NONE),
            slides,
            1e-15,
        );
    }
}
