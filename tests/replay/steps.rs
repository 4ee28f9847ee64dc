//! Steps between samples are short enough: the same drive on a finer grid of
//! samples, which shortens them, moves nothing by a micrometre.

use super::*;

/// The same drive with every sample repeated `by` times.
fn finer(run: &Run, by: usize) -> Run {
    let count = run.times.len();
    let dt = run.times[1] - run.times[0];
    let times = (0..(count - 1) * by + 1).map(|i| {
        let (sample, part) = (i / by, i % by);
        if part == 0 { run.times[sample] } else { run.times[sample] + dt * part as f64 / by as f64 }
    });
    let drive = (0..(count - 1) * by + 1).map(|i| run.drive[i / by]);
    Run { times: times.collect(), drive: drive.collect(), slope_deg: run.slope_deg }
}

fn gap(effect: Effect, run: &Run, by: usize) -> f64 {
    let level = Level::current().unwrap();
    let fine = finer(run, by);
    let active = Active::default().with(effect);
    let coarse = &all(&[column(active, on(effect), run.times.len())], run, level)[0];
    let fine = &all(&[column(active, on(effect), fine.times.len())], &fine, level)[0];
    let picked: Vec<f64> = fine.x.iter().step_by(by).copied().collect();
    let rear: Vec<f64> = fine.x_rear.iter().step_by(by).copied().collect();
    assert_eq!(picked.len(), coarse.x.len());
    largest(&coarse.x, &picked).max(largest(&coarse.x_rear, &rear))
}

/// Effects with which motion from sample to sample has a closed form.
const EXACT: [Effect; 12] = [
    Effect::ViscousFriction,
    Effect::DirectionDependentFriction,
    Effect::LoadDependentFriction,
    Effect::DriveSaturation,
    Effect::DriveDelay,
    Effect::DriveDeadzone,
    Effect::DriveGainError,
    Effect::BackEmf,
    Effect::SlopeError,
    Effect::PayloadMass,
    Effect::CoulombError,
    Effect::SensorScale,
];

#[test]
fn linear_effects_are_exact() {
    let run = run(500, 4e-3);
    for effect in EXACT {
        let gap = gap(effect, &run, 8);
        assert!(gap < 1e-12, "{}: {gap:e}", effect.info().name);
    }
}

#[test]
fn other_effects_are_good_to_a_micrometre() {
    let run = run(500, 2e-3);
    let mut report = String::new();
    for effect in Effect::ALL {
        // The body takes the head's force as the mean of two samples, and the
        // delayed sensor lies on a cubic between them.
        let gap = gap(*effect, &run, 8);
        if gap >= 1e-6 {
            report += &format!("\n{}: {gap:.1e} m", effect.info().name);
        }
    }
    assert!(report.is_empty(), "{report}");
}

/// A drive that stays as it is, on a slope.
fn constant(drive: f64, slope_deg: f64) -> Run {
    let times: Vec<f64> = (0..5).map(|i| 0.25 * i as f64).collect();
    Run { drive: vec![drive; times.len()], times, slope_deg }
}

#[test]
fn what_rests_lets_go_between_samples_where_friction_or_the_drive_wears_off() {
    // Drag too weak to be seen takes the steps that bent friction needs.
    let drag = Effect::QuadraticDrag;
    for (effect, sizes, run) in [
        (Effect::FrictionDrift, [-0.5, 0.8], constant(0.45, 3.0)),
        (Effect::SupplySag, [0.95, 0.3], constant(0.4, 12.0)),
    ] {
        let active = Active::default().with(effect).with(drag);
        let mut values = [0.0; EFFECT_PARAMS];
        values[effect.first()..][..2].copy_from_slice(&sizes);
        values[drag.first()] = 1e-9;
        let level = Level::current().unwrap();
        let by = 500;
        let fine = finer(&run, by);
        let coarse = &all(&[column(active, values, run.times.len())], &run, level)[0];
        let fine = &all(&[column(active, values, fine.times.len())], &fine, level)[0];
        let picked: Vec<f64> = fine.x.iter().step_by(by).copied().collect();
        assert_eq!(fine.x[50], 0.0, "{} rests at first", effect.info().name);
        assert!(picked[2].abs() > 1e-3, "{} moves then", effect.info().name);
        let gap = largest(&coarse.x, &picked);
        assert!(gap < 1e-6, "{}: {gap:e}", effect.info().name);
    }
}

/// A pendulum's steps are as long as their error allows: samples sixteen times as near change nothing.
#[test]
fn a_driven_pendulum_is_good_to_a_micrometre() {
    let nominal = Nominal {
        mass: 0.02,
        coulomb_force: Some(0.03),
        viscous: 0.01,
        rotary: true,
        gravity_torque: 0.5,
        ..NOMINAL
    };
    let level = Level::current().unwrap();
    let moved = |run: &Run| {
        let column = column(Active::default(), [0.0; EFFECT_PARAMS], run.times.len());
        let runs = std::slice::from_ref(run);
        replay(&nominal, runs, &[column], (level, 1), &Control::default()).unwrap().x
    };
    let run = run(1000, 5e-3);
    let fine: Vec<f64> = moved(&finer(&run, 16)).into_iter().step_by(16).collect();
    let coarse = moved(&run);
    assert!(coarse.iter().any(|x| x.abs() > 0.5));
    let gap = largest(&coarse, &fine);
    assert!(gap < 1e-6, "{gap:e}");
}
