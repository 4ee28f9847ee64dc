//! Laws at imposed motion, and found again from their own force.

use crate::Uniform;
use locosweep::friction_fit::{
    Candidate, FITTED, FROZEN, Measured, Pressing, Run, What, fit_all, imposed,
};
use locosweep::physics::ParamId;
use locosweep::physics::friction::imposed::Motion;
use locosweep::physics::friction::{ContactState, Kind, LAWS, LawEntry, Values};
use locosweep::sweep::Control;

/// Back and forth with two amplitudes, every speed from 0 up.
fn motion(count: usize) -> Motion {
    let t: Vec<f64> = (0..count).map(|i| 0.01 * i as f64).collect();
    let speed = |t: &f64| 0.04 * (1.3 * t).sin() + 0.02 * (3.1 * t).sin();
    let v: Vec<f64> = t.iter().map(speed).collect();
    let position =
        |t: &f64| 0.04 / 1.3 * (1.0 - (1.3 * t).cos()) + 0.02 / 3.1 * (1.0 - (3.1 * t).cos());
    let x = t.iter().map(position).collect();
    let drive = t.iter().map(|t| 2.0 * (0.7 * t).sin()).collect();
    Motion::new(t, x, v, drive, 1e-5)
}

fn given(pairs: &[(&str, f64)]) -> Vec<(ParamId, f64)> {
    pairs.iter().map(|(name, value)| (ParamId::parse(name).unwrap(), *value)).collect()
}

const PLAIN: &[(&str, f64)] = &[("mu_static", 0.9), ("mu_coulomb", 0.6), ("viscous", 2.0)];

#[test]
fn imposed_force_is_the_registered_one() {
    let motion = motion(400);
    for law in LAWS.iter().filter(|law| law.kind != Kind::Bristle) {
        let pairs = given(PLAIN);
        let values =
            Values::of(&[pairs.clone(), given(&[("gravity", 0.0), ("wall_force", 1.0)])].concat());
        let force = imposed(law, &pairs, &motion).unwrap();
        for (i, found) in force.iter().enumerate().skip(1) {
            let (v, direction) = (motion.v[i], motion.v[i].signum());
            let (x, sliding_distance, drive) =
                (motion.x[i], motion.sliding_distance[i], motion.drive[i]);
            let position = ContactState { direction, x, sliding_distance, drive, t: motion.t[i] };
            let own = match law.kind {
                Kind::Dry => direction * (law.resistance)(&values, v.abs(), &position, &[0.0; 4]),
                _ => (law.resistance)(&values, v, &position, &[0.0; 4]),
            };
            assert_eq!(*found, own, "{} at {i}", law.info.name);
        }
    }
}

#[test]
fn a_rest_shows_what_friction_holds_in_the_direction_of_the_next_motion() {
    let t: Vec<f64> = (0..30).map(f64::from).collect();
    let v = t.iter().map(|t| if *t < 20.0 { 0.0 } else { -0.1 }).collect();
    let motion = Motion::new(t.clone(), vec![0.0; 30], v, vec![0.0; 30], 1e-6);
    let law = LawEntry::parse("static_viscous").unwrap();
    let force = imposed(law, &given(PLAIN), &motion).unwrap();
    assert_eq!(force[10], -0.9);
    assert!((force[25] + 0.6 + 0.2).abs() < 1e-15);
}

/// Slow presliding of Dahl's law: F = F_C (1 - exp(-sigma_0 x/F_C)).
#[test]
fn presliding_follows_its_closed_form() {
    let count = 2000;
    let t: Vec<f64> = (0..count).map(|i| 0.001 * i as f64).collect();
    // From rest, evenly faster.
    let v = t.iter().map(|t| 1e-3 * t).collect();
    let x: Vec<f64> = t.iter().map(|t| 5e-4 * t * t).collect();
    let motion = Motion::new(t, x.clone(), v, vec![0.0; count], 0.0);
    let law = LawEntry::parse("dahl").unwrap();
    let force =
        imposed(law, &given(&[("mu_coulomb", 1.0), ("bristle_stiffness", 2e3)]), &motion).unwrap();
    for (x, force) in x.iter().zip(&force) {
        let exact = -f64::exp_m1(-2e3 * x);
        assert!((force - exact).abs() < 2e-3, "{force} for {exact}");
    }
}

/// However fast the bristles are, steady sliding is the steady force.
#[test]
fn stiff_bristles_end_on_the_characteristic() {
    let count = 50;
    let t: Vec<f64> = (0..count).map(|i| 0.05 * i as f64).collect();
    let turn = |t: &f64| if *t < 1.0 { 0.02 } else { -0.02 };
    let v: Vec<f64> = t.iter().map(turn).collect();
    let motion = Motion::new(t, vec![0.0; count], v, vec![0.0; count], 0.0);
    for law in LAWS.iter().filter(|law| law.kind == Kind::Bristle) {
        let mut pairs = given(PLAIN);
        pairs.extend(given(&[("bristle_stiffness", 1e7)]));
        let force = imposed(law, &pairs, &motion).unwrap();
        let values = Values::of(&[pairs, given(&[("gravity", 0.0), ("wall_force", 1.0)])].concat());
        let steady = (law.steady)(&values, -0.02);
        let last = force[count - 1];
        assert!((last / steady - 1.0).abs() < 2e-3, "{}: {last} for {steady}", law.info.name);
    }
}

fn measured(law: &LawEntry, pairs: &[(&str, f64)], noise: f64, folds: bool) -> Measured {
    let motion = motion(1500);
    let mut uniform = Uniform(11);
    // What moves without a rest does not show what friction holds.
    let all = [given(&[("mu_static", 0.9)]), given(pairs)].concat();
    let clean = imposed(law, &all, &motion).unwrap();
    let force = clean.iter().map(|f| f + noise * 12.0_f64.sqrt() * uniform.draw()).collect();
    let rows: Vec<usize> = (0..motion.len()).filter(|i| !motion.rests[*i]).collect();
    let fold = |i: usize| if folds { (i * 10 / rows.len() % 5) as u8 } else { FITTED };
    let folds = (0..rows.len()).map(fold).collect();
    let load = vec![0.0; motion.len()];
    Measured { runs: vec![Run { motion, force, load, rows, folds }], normal: 1.0, slowest: 1e-5 }
}

#[test]
fn parameters_are_found_within_their_uncertainty() {
    for (name, pairs) in [
        ("coulomb_viscous", &[("mu_coulomb", 0.6), ("viscous", 2.0)][..]),
        (
            "stribeck",
            &[("mu_static", 0.9), ("mu_coulomb", 0.6), ("viscous", 2.0), ("stribeck_speed", 0.01)],
        ),
        ("directional", &[("mu_coulomb", 0.6), ("viscous", 1.0), ("skin_ratio", 1.7)]),
        (
            "tanh",
            &[
                ("mu_static", 0.9),
                ("mu_coulomb", 0.6),
                ("viscous", 1.0),
                ("stribeck_speed", 0.02),
                ("transition_speed", 0.004),
            ],
        ),
        ("dahl", &[("mu_coulomb", 0.6), ("viscous", 1.0), ("bristle_stiffness", 800.0)]),
    ] {
        let law = LawEntry::parse(name).unwrap();
        let data = measured(law, pairs, 0.01, true);
        let candidate = Candidate { law, pressing: Pressing::Constant, offset: false, gain: false };
        let found = fit_all(&data, &[candidate], 1, &Control::default()).unwrap().remove(0);
        assert!((found.rms / 0.01 - 1.0).abs() < 0.1, "{name}: {found:?}", found = found.rms);
        for (parameter, value) in pairs {
            let own = found.found.iter().find(|f| f.what.name() == *parameter).unwrap();
            assert!(
                (own.value - value).abs() < 4.0 * own.std && own.std < 0.3 * value,
                "{name}: {parameter} is {} +- {}, should be {value}",
                own.value,
                own.std
            );
        }
        assert!(found.held_out.iter().all(|f| f.is_finite()));
    }
}

#[test]
fn threads_and_order_change_no_bit() {
    let law = LawEntry::parse("coulomb_viscous").unwrap();
    let data = measured(law, &[("mu_coulomb", 0.6), ("viscous", 2.0)], 0.01, true);
    let candidates: Vec<Candidate> = ["coulomb", "coulomb_viscous", "stribeck", "quadratic"]
        .map(|name| Candidate {
            law: LawEntry::parse(name).unwrap(),
            pressing: Pressing::Constant,
            offset: true,
            gain: false,
        })
        .to_vec();
    let one = fit_all(&data, &candidates, 1, &Control::default()).unwrap();
    let three = fit_all(&data, &candidates, 3, &Control::default()).unwrap();
    let bits = |all: &[locosweep::friction_fit::Outcome]| -> Vec<u64> {
        all.iter()
            .flat_map(|o| o.predicted.iter().chain(&o.held_out).map(|f| f.to_bits()))
            .collect()
    };
    assert_eq!(bits(&one), bits(&three));
    let back: Vec<Candidate> = candidates.iter().rev().copied().collect();
    let mut reversed = fit_all(&data, &back, 2, &Control::default()).unwrap();
    reversed.reverse();
    assert_eq!(bits(&one), bits(&reversed));
}

#[test]
fn a_sensor_offset_is_told_from_friction() {
    let law = LawEntry::parse("coulomb").unwrap();
    let mut data = measured(law, &[("mu_coulomb", 0.6)], 0.01, true);
    data.runs[0].force.iter_mut().for_each(|f| *f += 0.25);
    let candidate = Candidate { law, pressing: Pressing::Constant, offset: true, gain: false };
    let found = fit_all(&data, &[candidate], 1, &Control::default()).unwrap().remove(0);
    let offset = found.found.iter().find(|f| f.what == What::Offset).unwrap();
    assert!((offset.value - 0.25).abs() < 4.0 * offset.std && offset.std < 1e-3, "{offset:?}");
}

#[test]
fn what_the_data_cannot_show_is_refused_by_name() {
    let law = LawEntry::parse("coulomb").unwrap();
    let data = measured(law, &[("mu_coulomb", 0.6)], 0.01, false);
    let candidate = Candidate { law, pressing: Pressing::Affine, offset: false, gain: false };
    let error = fit_all(&data, &[candidate], 1, &Control::default()).unwrap_err().to_string();
    assert!(error.contains("coulomb") && error.contains("no load"), "{error}");
    let mut holes = data.clone();
    holes.runs[0].force[7] = f64::NAN;
    let plain = Candidate { pressing: Pressing::Constant, ..candidate };
    assert!(fit_all(&holes, &[plain], 1, &Control::default()).is_err());
}

/// A law's own new parameter must not fall silently to its default in fits.
#[test]
fn every_parameter_of_a_law_is_fitted_or_frozen_for_a_reason() {
    let coulomb = LawEntry::parse("coulomb").unwrap();
    let scales = measured(coulomb, &[("mu_coulomb", 0.6)], 0.01, false).scales();
    for law in LAWS {
        let pressing = Pressing::Constant;
        let candidate = Candidate { law, pressing, offset: false, gain: false };
        let forgotten: Vec<_> = candidate.forgotten(&scales).collect();
        assert_eq!(forgotten, [], "{}: give it a range in `range`", law.info.name);
        for (id, why) in FROZEN {
            assert!(
                candidate.free(&scales).iter().all(|free| free.what != What::Law(*id)),
                "{why}"
            );
        }
    }
    for (id, _) in FROZEN {
        let name = id.param().name;
        assert!(LAWS.iter().any(|law| law.info.params.contains(&name)), "{name}");
    }
}
