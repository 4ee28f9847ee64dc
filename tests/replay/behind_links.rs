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
            let all = errors(&effects, strength, &[1, 2, 5], 2e-7);
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

/// A contact that opens and closes leaves more to chance, in the plain integration most.
#[test]
fn friction_that_bends_behind_a_spring_or_a_gap() {
    for (link, longest) in
        [(Effect::TransmissionCompliance, 2e-7), (Effect::TransmissionBacklash, 5e-8)]
    {
        for bent in [Effect::StribeckFriction, Effect::LoadDependentFriction] {
            let (a, b) = (usual(link), usual(bent));
            let all = errors(&[(link, &a[..]), (bent, &b[..])], 1.0, &[1, 2, 5], longest);
            let most = all.iter().copied().fold(0.0, f64::max);
            let names = (link.info().name, bent.info().name);
            assert!(most < MICROMETRE, "{names:?}: {all:?} m");
        }
    }
}
