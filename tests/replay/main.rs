//! Replays of measured drives: every effect in its limit is the nominal model,
//! and acts where it should.

mod against_plain;
mod behind_links;
mod bits;
mod joint_law;
mod limits;
mod order;
mod plain;
mod sensitivities;
mod steps;
mod windows;

use locosweep::lane::Level;
use locosweep::physics::effects::{Active, EFFECT_PARAMS, EFFECTS, Effect, Nominal, Off};
use locosweep::sweep::Control;
use locosweep::sweep::replay::{Column, Readings, Run, replay};

const NOMINAL: Nominal = Nominal {
    segments: 4.0,
    mass: 0.271,
    gravity: 9.81,
    mu_coulomb: 0.15,
    coulomb_force: None,
    viscous: 0.05,
    slope_deg: 3.0,
    gain: 1.1,
    limit: 0.85,
    rotary: false,
    gravity_torque: 0.0,
};

/// Forward, coast, backward and small commands, 2000 samples of 1 ms or 2 ms.
fn run(count: usize, dt: f64) -> Run {
    let times: Vec<f64> = (0..count).map(|i| i as f64 * dt).collect();
    let drive = times
        .iter()
        .map(|t| {
            let slow = (2.0 * std::f64::consts::PI * 0.7 * t).sin();
            let fast = (2.0 * std::f64::consts::PI * 2.3 * t + 0.4).sin();
            let value: f64 = 0.55 * slow + 0.4 * fast;
            (value * 50.0).round() / 50.0
        })
        .collect();
    Run { times, drive, slope_deg: 3.0 }
}

fn coulomb() -> f64 {
    0.15 * 0.271 * 9.81 * 3f64.to_radians().cos()
}

/// Parameters with everything off, or as near to it as a number can be.
fn off(effect: Effect) -> [f64; EFFECT_PARAMS] {
    let mut values = [0.0; EFFECT_PARAMS];
    for (k, param) in effect.info().params.iter().enumerate() {
        values[effect.first() + k] = match param.off {
            Off::At(value) if value.is_infinite() => 1e9,
            Off::At(value) => value,
            Off::Coulomb => coulomb(),
            Off::Never => match param.param.name {
                "sigma1" => 0.0,
                "b" => 0.0,
                "m_d" => 1e-7,
                "d" => 1.0,
                "L" => 0.01,
                "v_s" => 0.02,
                _ => 0.5,
            },
        };
    }
    values
}

/// Parameters of an effect of visible size.
fn on(effect: Effect) -> [f64; EFFECT_PARAMS] {
    let mut values = [0.0; EFFECT_PARAMS];
    let numbers: &[f64] = match effect {
        Effect::ViscousFriction => &[0.6],
        Effect::QuadraticDrag => &[3.0],
        Effect::StribeckFriction => &[0.7, 0.02, 1.0],
        Effect::PreslidingCompliance => &[2e4, 30.0],
        Effect::DirectionDependentFriction => &[0.3, 0.5],
        Effect::PositionDependentFriction => &[0.4, 0.01, 0.7],
        Effect::LoadDependentFriction => &[0.2],
        Effect::FrictionDrift => &[0.5, 0.8],
        Effect::LubricantBuildup => &[5.0],
        Effect::DriveSaturation => &[0.6],
        Effect::DriveLag => &[0.03],
        Effect::DriveDelay => &[0.0123],
        Effect::DriveDeadzone => &[0.1],
        Effect::DriveGainError => &[-0.15],
        Effect::BackEmf => &[0.5],
        Effect::SupplySag => &[0.3, 0.7],
        Effect::TransmissionBacklash => &[5e-4, 0.03],
        Effect::TransmissionCompliance => &[400.0, 1.0, 0.05],
        Effect::SlopeError => &[1.5],
        Effect::PayloadMass => &[0.08],
        Effect::CoulombError => &[0.05, 0.0],
        Effect::AnchorSlip => &[0.1, 0.06],
        Effect::SensorScale => &[0.03],
        Effect::SensorDrift => &[1e-3],
        Effect::SensorDelay => &[0.0077],
    };
    values[effect.first()..][..numbers.len()].copy_from_slice(numbers);
    values
}

fn column(active: Active, values: [f64; EFFECT_PARAMS], count: usize) -> Column {
    Column {
        run: 0,
        window: (0, count),
        active,
        values,
        shares: [1.0, 1.0, 1.0, 0.0],
        start: (0.0, 0.0),
        sliding_distance: 0.0,
    }
}

fn all(columns: &[Column], run: &Run, level: Level) -> Vec<Readings> {
    let runs = [run.clone()];
    apart(columns, replay(&NOMINAL, &runs, columns, (level, 1), &Control::default()).unwrap())
}

/// The readings of every column for itself.
fn apart(columns: &[Column], all: Readings) -> Vec<Readings> {
    let mut from = 0;
    let mut one = |column: &Column| {
        let to = from + column.window.1 - column.window.0;
        let cut = |field: &[f64]| field[from..to].to_vec();
        let part = Readings {
            x: cut(&all.x),
            v: cut(&all.v),
            x_rear: cut(&all.x_rear),
            force: cut(&all.force),
        };
        from = to;
        part
    };
    columns.iter().map(&mut one).collect()
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
