//! A window replayed from the full run's own state gives the rest of the run;
//! and the rotary bench.

use super::*;

/// Effects that carry nothing from sample to sample but position, speed and what the drive's samples
/// say.
const MEMORYLESS: [Effect; 16] = [
    Effect::ViscousFriction,
    Effect::QuadraticDrag,
    Effect::StribeckFriction,
    Effect::DirectionDependentFriction,
    Effect::PositionDependentFriction,
    Effect::LoadDependentFriction,
    Effect::FrictionDrift,
    Effect::DriveSaturation,
    Effect::DriveLag,
    Effect::DriveDelay,
    Effect::DriveDeadzone,
    Effect::DriveGainError,
    Effect::BackEmf,
    Effect::SupplySag,
    Effect::SlopeError,
    Effect::PayloadMass,
];

#[test]
fn a_window_is_the_rest_of_the_run() {
    let run = run(1000, 2e-3);
    let level = Level::current().unwrap();
    for effect in MEMORYLESS {
        let whole = column(Active::default().with(effect), on(effect), 1000);
        let full = &all(std::slice::from_ref(&whole), &run, level)[0];
        for (from, to) in [(0, 500), (137, 1000), (500, 777), (998, 1000)] {
            let start = (full.x[from], full.v[from]);
            let part = Column { window: (from, to), start, ..whole.clone() };
            let found = &all(&[part], &run, level)[0];
            let miss = largest(&found.x, &full.x[from..to]);
            let off = largest(&found.v, &full.v[from..to]);
            let name = effect.info().name;
            assert_eq!(found.x.len(), to - from);
            // What rounding makes of seconds of motion.
            assert!(miss < 1e-12 && off < 1e-12, "{name} {from}..{to}: {miss:e} {off:e}");
        }
    }
}

/// What is pushed ahead since the last rest is there when a window begins.
#[test]
fn a_window_begins_behind_its_heap() {
    let run = run(1000, 2e-3);
    let level = Level::current().unwrap();
    for others in [&[][..], &[Effect::DriveLag], &[Effect::FrictionDrift]] {
        let heap = Effect::LubricantBuildup;
        let mut values = on(heap);
        let mut active = Active::default().with(heap);
        for other in others {
            active = active.with(*other);
            let own = on(*other);
            let last = other.first() + other.info().params.len();
            values[other.first()..last].copy_from_slice(&own[other.first()..last]);
        }
        let whole = column(active, values, 1000);
        let full = &all(std::slice::from_ref(&whole), &run, level)[0];
        let mut behind = 0;
        for from in (100..1000).step_by(23) {
            let rest = (0..=from).rfind(|i| full.v[*i] <= 0.0).unwrap();
            // A turn between two samples is at no sample's place.
            if full.v[rest] < 0.0 {
                continue;
            }
            let sliding_distance = full.x[from] - full.x[rest];
            behind += usize::from(sliding_distance > 1e-3);
            let start = (full.x[from], full.v[from]);
            let part = Column { window: (from, 1000), start, sliding_distance, ..whole.clone() };
            let found = &all(std::slice::from_ref(&part), &run, level)[0];
            let miss = largest(&found.x, &full.x[from..]);
            assert!(miss < 1e-12, "{others:?} {from}: {miss:e}");
            let anew = &all(&[Column { sliding_distance: 0.0, ..part }], &run, level)[0];
            let off = largest(&anew.x, &full.x[from..]);
            assert!(off > 1e-6 || sliding_distance < 1e-3, "{others:?} {from}: {off:e}");
        }
        assert!(behind >= 2, "{behind} windows begin behind a heap");
    }
}

/// Small swings of a pendulum without friction: period 2 pi sqrt(J/M).
#[test]
fn a_pendulum_swings_at_its_period() {
    let (inertia, torque) = (0.02, 0.5);
    let nominal = Nominal {
        mass: inertia,
        mu_coulomb: 0.0,
        coulomb_force: Some(0.0),
        viscous: 0.0,
        rotary: true,
        gravity_torque: torque,
        ..NOMINAL
    };
    let times: Vec<f64> = (0..2001).map(|i| f64::from(i) * 1e-3).collect();
    let run = Run { drive: vec![0.0; 2001], times: times.clone(), slope_deg: 0.0 };
    let level = Level::current().unwrap();
    let swing = |angle: f64| {
        let mut column = column(Active::default(), [0.0; EFFECT_PARAMS], 2001);
        column.start = (angle, 0.0);
        let runs = [run.clone()];
        replay(&nominal, &runs, &[column], (level, 1), &Control::default()).unwrap()
    };
    let rate = (torque / inertia).sqrt();
    let small = swing(1e-4);
    for (t, x) in times.iter().zip(&small.x) {
        assert!((x - 1e-4 * (rate * t).cos()).abs() < 1e-11, "{t}: {x}");
    }
    // A large swing is slower by 1 + a^2/16 + 11 a^4/3072, and keeps its energy.
    let a = 0.8;
    let large = swing(a);
    let quarter = (1..2001).find(|i| large.x[*i] < 0.0).unwrap();
    let (x0, x1) = (large.x[quarter - 1], large.x[quarter]);
    let when = times[quarter - 1] + 1e-3 * x0 / (x0 - x1);
    let slower = 1.0 + a * a / 16.0 + 11.0 / 3072.0 * a.powi(4) + 173.0 / 737_280.0 * a.powi(6);
    let expected = std::f64::consts::FRAC_PI_2 / rate * slower;
    assert!((when / expected - 1.0).abs() < 1e-5, "{when} {expected}");
    let energy = |x: f64, v: f64| 0.5 * inertia * v * v - torque * x.cos();
    for (x, v) in large.x.iter().zip(&large.v) {
        assert!((energy(*x, *v) - energy(a, 0.0)).abs() < 1e-9);
    }
}
