//! Several effects act in the contract's order: delay, gain and sag, dead zone,
//! saturation, lag, transmission, back-EMF; of the sensor scale, drift, delay.

use super::*;

fn both(a: Effect, b: Effect) -> (Active, [f64; EFFECT_PARAMS]) {
    let mut values = on(a);
    values[b.first()..][..b.info().params.len()]
        .copy_from_slice(&on(b)[b.first()..][..b.info().params.len()]);
    (Active::default().with(a).with(b), values)
}

/// Replays a pair of effects, the limit of the nominal drive out of the way.
fn replayed(active: Active, values: [f64; EFFECT_PARAMS], run: &Run) -> Readings {
    let nominal = Nominal { limit: 1e9, ..NOMINAL };
    let columns = [column(active, values, run.times.len())];
    let level = Level::current().unwrap();
    replay(&nominal, std::slice::from_ref(run), &columns, (level, 1), &Control::default()).unwrap()
}

/// What the drive gives, stage by stage, on its samples: all but lag and
/// transmission are functions of one command and its time.
fn staged(active: Active, values: &[f64; EFFECT_PARAMS], run: &Run, t: f64, sample: f64) -> f64 {
    let value = |effect: Effect, k: usize| values[effect.first() + k];
    let mut force = sample * NOMINAL.gain;
    if active.has(Effect::DriveGainError) {
        force *= 1.0 + value(Effect::DriveGainError, 0);
    }
    if active.has(Effect::SupplySag) {
        let (a, time) = (value(Effect::SupplySag, 0), value(Effect::SupplySag, 1));
        force *= 1.0 - a * (1.0 - (-t / time).exp());
    }
    if active.has(Effect::DriveDeadzone) {
        force = force.signum() * (force.abs() - value(Effect::DriveDeadzone, 0)).max(0.0);
    }
    if active.has(Effect::DriveSaturation) {
        force = force.signum() * force.abs().min(value(Effect::DriveSaturation, 0));
    }
    assert!(t <= run.times[run.times.len() - 1]);
    force
}

const STATIC: [Effect; 4] =
    [Effect::DriveGainError, Effect::SupplySag, Effect::DriveDeadzone, Effect::DriveSaturation];

/// Sample that acts at `t`, `delay` late; before the first one it has its value.
fn held(run: &Run, t: f64, delay: f64) -> f64 {
    let at = run.times.partition_point(|time| time + delay <= t);
    run.drive[at.saturating_sub(1)]
}

#[test]
fn pairs_of_drive_effects_act_in_order() {
    let run = run(600, 2e-3);
    let late = [Effect::DriveDelay, Effect::BackEmf];
    for a in STATIC.into_iter().chain(late) {
        for b in STATIC.into_iter().chain(late).filter(|b| *b != a) {
            let (active, values) = both(a, b);
            let found = replayed(active, values, &run);
            let delay = if active.has(Effect::DriveDelay) {
                values[Effect::DriveDelay.first()]
            } else {
                0.0
            };
            for (i, t) in run.times.iter().enumerate().take(599) {
                let mut force = staged(active, &values, &run, *t, held(&run, *t, delay));
                if active.has(Effect::BackEmf) {
                    // Last of all: what the delivered force loses to motion.
                    force -= values[Effect::BackEmf.first()] * found.v[i];
                }
                let miss = (found.force[i] - force).abs();
                let (a, b) = (a.info().name, b.info().name);
                assert!(miss < 1e-12, "{a} and {b} at {t}: {} {force}", found.force[i]);
            }
        }
    }
}

/// The lag follows what gain, dead zone and limit have left, exactly from sample
/// to sample: a map doubled 13 times keeps all digits but those 13 bits.
#[test]
fn a_lag_comes_after_the_limits() {
    let run = run(600, 2e-3);
    for other in [Effect::DriveGainError, Effect::DriveDeadzone, Effect::DriveSaturation] {
        let (active, values) = both(Effect::DriveLag, other);
        let found = replayed(active, values, &run);
        let fade = (-2e-3 / values[Effect::DriveLag.first()]).exp();
        let settled = |i: usize| staged(active, &values, &run, run.times[i], run.drive[i]);
        let mut force = settled(0);
        for i in 0..599 {
            let miss = (found.force[i] - force).abs();
            assert!(miss < 3e-11, "{} at {i}: {} {force}", other.info().name, found.force[i]);
            force = settled(i) + (force - settled(i)) * fade;
        }
    }
}

/// A delayed lag is a lag, later; a sensor that scales and drifts late reads what
/// was scaled and drifted then.
#[test]
fn delays_shift_what_the_others_make() {
    let run = run(600, 2e-3);
    let lag = Effect::DriveLag;
    let (active, mut values) = both(lag, Effect::DriveDelay);
    values[Effect::DriveDelay.first()] = 0.02;
    let late = replayed(active, values, &run);
    let prompt = replayed(Active::default().with(lag), values, &run);
    for i in 10..600 {
        assert!((late.force[i] - prompt.force[i - 10]).abs() < 1e-11, "{i}");
    }
    let (active, mut values) = both(Effect::SensorScale, Effect::SensorDrift);
    values[Effect::SensorDelay.first()] = 0.02;
    let prompt = replayed(active, values, &run);
    let late = replayed(active.with(Effect::SensorDelay), values, &run);
    let plain = replayed(Active::default(), values, &run);
    for i in 0..600 {
        let scaled = plain.x[i] * 1.03 + 1e-3 * run.times[i];
        assert!((prompt.x[i] - scaled).abs() < 1e-12, "{i}");
        if i >= 10 {
            assert!((late.x[i] - prompt.x[i - 10]).abs() < 1e-7, "{i}: {}", late.x[i]);
        }
    }
}

/// Back-EMF acts on the head, behind the transmission, and friction takes the
/// force before it.
#[test]
fn back_emf_is_viscous_friction_that_the_force_sensor_sees() {
    let run = run(600, 2e-3);
    for other in [
        Effect::TransmissionCompliance,
        Effect::TransmissionBacklash,
        Effect::LoadDependentFriction,
        Effect::DriveLag,
    ] {
        let (active, values) = both(Effect::BackEmf, other);
        let emf = replayed(active, values, &run);
        let (active, mut values) = both(Effect::ViscousFriction, other);
        let k = 0.5;
        values[Effect::ViscousFriction.first()] = k;
        let viscous = replayed(active, values, &run);
        let name = other.info().name;
        assert!(largest(&emf.x, &viscous.x) == 0.0, "{name}");
        for i in 0..600 {
            let expected = viscous.force[i] - k * viscous.v[i];
            assert!((emf.force[i] - expected).abs() < 1e-12, "{name} at {i}");
        }
    }
}
