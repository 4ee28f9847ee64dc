//! Replays against a plain integration of the contract: single effects whose friction
//! is steep, the body beside what shapes the drive's force, and, in the long check, every
//! pair of effects.

use super::plain::Rig;
use super::*;

/// Forward, off, backward, off again.
pub(super) fn pulses(dt: f64, seconds: f64) -> Run {
    let times: Vec<f64> = (0..(seconds / dt) as usize).map(|i| i as f64 * dt).collect();
    let level = |t: &f64| [1.3, 0.0, -1.1, 0.2][((t / 0.25 + 1e-9) as usize) % 4];
    let drive = times.iter().map(level).collect();
    Run { times, drive, slope_deg: 3.0 }
}

/// Largest errors of x and x_rear, m, with plain steps of `longest`.
fn errors(effects: &[(Effect, &[f64])], run: &Run, longest: f64) -> (f64, f64) {
    let (mut active, mut values) = (Active::default(), [0.0; EFFECT_PARAMS]);
    for (effect, numbers) in effects {
        active = active.with(*effect);
        values[effect.first()..][..numbers.len()].copy_from_slice(numbers);
    }
    let nominal = Nominal { limit: 1e9, ..NOMINAL };
    let rig = Rig { nominal: &nominal, active, values: &values, slope_deg: run.slope_deg };
    let truth = rig.motion(&run.times, &run.drive, longest);
    let columns = [column(active, values, run.times.len())];
    let level = Level::current().unwrap();
    let runs = std::slice::from_ref(run);
    let found = replay(&nominal, runs, &columns, (level, 1), &Control::default()).unwrap();
    assert!(found.x.iter().all(|x| x.is_finite()));
    let rear =
        if active.has(Effect::AnchorSlip) { largest(&found.x_rear, &truth.x_rear) } else { 0.0 };
    (largest(&found.x, &truth.x), rear)
}

pub(super) const MICROMETRE: f64 = 1e-6;

/// The slope of the fall has no bound at rest where its exponent is below 1.
#[test]
fn a_sharp_fall_of_friction_is_followed_to_a_micrometre() {
    for exponent in [0.1, 0.3, 0.5, 1.0] {
        for dt in [1e-3, 5e-3] {
            let run = pulses(dt, 1.0);
            let fall: &[f64] = &[0.7, 0.02, exponent];
            let (x, _) = errors(&[(Effect::StribeckFriction, fall)], &run, 2.5e-7);
            assert!(x < MICROMETRE, "exponent {exponent}, samples of {dt} s: {x} m");
        }
    }
}

#[test]
fn friction_along_the_way_is_followed_to_a_micrometre() {
    for dt in [1e-3, 5e-3] {
        let run = pulses(dt, 1.0);
        let (x, _) = errors(&[(Effect::PositionDependentFriction, &[0.5, 0.01, 0.7])], &run, 1e-7);
        assert!(x < MICROMETRE, "samples of {dt} s: {x} m");
    }
}

/// A step from wave to wave, or to the same height of another wave, sees no change.
#[test]
fn fast_waves_of_friction_along_the_way_are_not_jumped_over() {
    for (strength, a) in [(1.0, 0.9), (1.5, 0.5), (3.0, 0.5)] {
        for dt in [1e-3, 2e-3] {
            let mut run = pulses(dt, 1.0);
            run.drive.iter_mut().for_each(|drive| *drive *= strength);
            let waves: &[f64] = &[a, 0.004, 0.7];
            let (x, _) = errors(&[(Effect::PositionDependentFriction, waves)], &run, 1e-7);
            // Of which a part is the plain integration's own.
            let what = format!("{strength} times the drive, a {a}, samples of {dt} s");
            assert!(x < 2.0 * MICROMETRE, "{what}: {x} m");
        }
    }
}

/// What acts between the samples moves the body, not the mean of the samples' forces.
#[test]
fn the_body_feels_the_force_between_the_samples() {
    let slip: (Effect, &[f64]) = (Effect::AnchorSlip, &[0.1, 0.06]);
    let others: [(Effect, &[f64]); 6] = [
        (Effect::DriveLag, &[0.01]),
        (Effect::DriveLag, &[0.003]),
        (Effect::BackEmf, &[0.5]),
        (Effect::BackEmf, &[3.0]),
        (Effect::TransmissionCompliance, &[400.0, 1.0, 0.05]),
        (Effect::SupplySag, &[0.3, 0.7]),
    ];
    for other in others {
        for dt in [1e-3, 5e-3] {
            let (_, rear) = errors(&[slip, other], &pulses(dt, 1.0), 4e-7);
            let name = other.0.info().name;
            assert!(rear < MICROMETRE, "{name} {:?}, samples of {dt} s: {rear} m", other.1);
        }
    }
}

/// Bristles, joint and lag are states of one step.
#[test]
fn bristles_behind_a_joint_are_followed_to_micrometres() {
    let bristle: (Effect, &[f64]) = (Effect::PreslidingCompliance, &[2e4, 60.0]);
    let soft: (Effect, &[f64]) = (Effect::PreslidingCompliance, &[1e3, 5.0]);
    let spring: (Effect, &[f64]) = (Effect::TransmissionCompliance, &[400.0, 1.0, 0.05]);
    let stiff: (Effect, &[f64]) = (Effect::TransmissionCompliance, &[2e4, 3.0, 0.2]);
    let gap: (Effect, &[f64]) = (Effect::TransmissionBacklash, &[0.002, 0.05]);
    let none: (Effect, &[f64]) = (Effect::ViscousFriction, &[0.0]);
    let others: [(Effect, &[f64]); 5] = [
        none,
        (Effect::DriveLag, &[0.01]),
        (Effect::LoadDependentFriction, &[0.1]),
        (Effect::SupplySag, &[0.3, 0.7]),
        (Effect::AnchorSlip, &[0.1, 0.06]),
    ];
    for bristle in [bristle, soft] {
        for joint in [spring, stiff, gap] {
            for other in others {
                let run = pulses(2e-3, 0.6);
                let (x, rear) = errors(&[bristle, joint, other], &run, 5e-7);
                // What presses the bristle changes with the ringing of the joint.
                let pressed = other.0 == Effect::LoadDependentFriction;
                let allowed = if pressed { 3.0 } else { 1.0 } * MICROMETRE;
                let names = [joint, other].map(|effect| effect.0.info().name);
                assert!(x.max(rear) < allowed, "{names:?}: x {x} m, x_rear {rear} m");
            }
        }
    }
}

/// Friction along the way changes under a bristle within a step.
#[test]
fn bristles_on_waves_are_followed_to_micrometres() {
    for (numbers, allowed) in [([1e3, 5.0], 3.0), ([2e4, 60.0], 3.0), ([1e6, 400.0], 8.0)] {
        for wave in [0.004, 0.05] {
            for dt in [5e-3, 0.02] {
                let along: (Effect, &[f64]) =
                    (Effect::PositionDependentFriction, &[0.5, wave, 0.7]);
                let bristle: (Effect, &[f64]) = (Effect::PreslidingCompliance, &numbers);
                let (x, _) = errors(&[bristle, along], &pulses(dt, 1.0), 5e-7);
                let what = format!("{numbers:?}, waves of {wave} m, samples of {dt} s");
                assert!(x < allowed * MICROMETRE, "{what}: {x} m");
            }
        }
    }
}

/// All pairs: within 1.5 micrometres, behind a joint within 8, of which the plain integration
/// of a gap has most. Two joints in one drive are left out: a model has one of them. When
/// the heap before a bristle levels out is left open: a bristle never rests.
#[test]
#[ignore = "minutes: part of the long check"]
fn every_pair_of_effects_follows_the_contract() {
    let joints = [Effect::TransmissionBacklash, Effect::TransmissionCompliance];
    let sensors = [Effect::SensorScale, Effect::SensorDrift, Effect::SensorDelay];
    let plant = Effect::ALL.iter().copied().filter(|e| !sensors.contains(e));
    let plant: Vec<Effect> = plant.collect();
    let run = pulses(2e-3, 1.0);
    for (i, a) in plant.iter().enumerate() {
        for b in &plant[i..] {
            let joined = joints.contains(a) || joints.contains(b);
            let bristle = [a, b].contains(&&Effect::PreslidingCompliance);
            let heap = [a, b].contains(&&Effect::LubricantBuildup);
            let unlike = bristle && heap || joints.contains(a) && joints.contains(b);
            if a != b && unlike {
                continue;
            }
            let [first, second] = [a, b].map(|effect| {
                let (from, count) = (effect.first(), effect.info().params.len());
                (*effect, on(*effect)[from..from + count].to_vec())
            });
            let (x, rear) =
                errors(&[(first.0, &first.1[..]), (second.0, &second.1[..])], &run, 5e-7);
            let allowed = if joined { 8.0 } else { 1.5 } * MICROMETRE;
            let names = (a.info().name, b.info().name);
            assert!(x.max(rear) < allowed, "{names:?}: x {x} m, x_rear {rear} m");
        }
    }
}
