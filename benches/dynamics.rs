//! What simulating costs, per trajectory, robot or sample: the works of
//! `dynamics_peers.py` in the Rust core, and replays of every effect.
//! `cargo bench --bench dynamics -- --test` runs everything once, on few cells.

mod common;

use common::*;
use criterion::{Criterion, criterion_group, criterion_main};
use locosweep::lane::Level;
use locosweep::physics::effects::{Active, EFFECT_PARAMS, Effect, Nominal};
use locosweep::sweep::replay::{Column, DIRECTIONS, Run, replay, replay_with_sensitivities};
use locosweep::sweep::{Choice, Control, Entry, Grid, Job, Request};
use std::hint::black_box;

type Axes = Vec<(&'static str, Vec<f64>)>;

/// Without weight and with a wall force of 1 N coefficients are forces.
const BARE: [(&str, f64); 2] = [("gravity", 0.0), ("wall_force", 1.0)];

/// Whether everything runs once only, to see that it works.
fn trial() -> bool {
    std::env::args().any(|arg| arg == "--test")
}

/// All of an axis, or its ends in a trial.
fn axis(from: f64, to: f64, count: usize) -> Vec<f64> {
    linspace(from, to, if trial() { 2 } else { count })
}

fn job(quantity: &str, choice: &Choice, axes: &Axes, fixed: &[(&str, f64)]) -> Job {
    let entry = Entry::parse(quantity).expect("a known quantity");
    let fixed = [&BARE[..], fixed].concat();
    let grid = Grid::new(axes, &fixed).expect("a valid grid");
    Job::new(grid, vec![Request { entry, reduce: None }], None, choice).expect("a valid job")
}

fn by(law: &str, drive: &str, method: Option<&str>) -> Choice {
    let method = method.map(str::to_owned);
    Choice { law: law.to_owned(), drive: drive.to_owned(), method, ..Choice::default() }
}

/// W3: a smooth law under a sine, 2000 explicit steps.
fn steps(c: &mut Criterion) {
    let axes = vec![
        ("mu_static", axis(0.7, 1.1, 16)),
        ("viscous", axis(0.0, 0.5, 16)),
        ("mass", axis(0.2, 0.35, 16)),
    ];
    let fixed = [
        ("mu_coulomb", 0.4),
        ("stribeck_speed", 0.05),
        ("transition_speed", 0.015),
        ("drive_amplitude", 2.0),
        ("duration", 2.0),
        ("time_step", 1e-3),
    ];
    let choice = by("tanh", "sine", Some("runge_kutta"));
    let job = job("final_position", &choice, &axes, &fixed);
    bench_job(c, "W3 tanh, 2000 steps", &job, &variants());
}

/// W4: stick-slip of bristles on a pulled spring; the loosest tolerance at which
/// every position is good to 1e-4.
fn bristles(c: &mut Criterion) {
    let axes = vec![("spring_stiffness", axis(1.5, 2.5, 8)), ("mu_static", axis(1.3, 1.7, 8))];
    let fixed = [
        ("mass", 1.0),
        ("mu_coulomb", 1.0),
        ("viscous", 0.4),
        ("stribeck_speed", 1e-3),
        ("bristle_stiffness", 1e5),
        ("bristle_damping", 1e5f64.sqrt()),
        ("pull_speed", 0.1),
        ("duration", if trial() { 0.5 } else { 10.0 }),
        ("tolerance", 1e-4),
    ];
    let job = job("final_position", &by("lugre", "constant", None), &axes, &fixed);
    bench_job(c, "W4 lugre, 10 s of stick-slip", &job, &variants());
}

/// W5: twelve phases with true sticking, from event to event and in steps.
fn pulses(c: &mut Criterion) {
    let axes = vec![
        ("drive_amplitude", axis(0.8, 3.0, 16)),
        ("drive_back", axis(0.4, 2.0, 8)),
        ("mu_static", axis(1.0, 1.5, 8)),
        ("viscous", axis(0.05, 0.5, 8)),
    ];
    let fixed = [
        ("mass", 0.271),
        ("mu_coulomb", 0.6),
        ("drive_period", 0.3),
        ("drive_duty", 0.6),
        ("duration", 1.8),
        // As long as it may be for positions good to 1e-9.
        ("time_step", 2e-3),
    ];
    for (method, name) in [("exact", "W5 exact"), ("runge_kutta", "W5 runge_kutta")] {
        let choice = by("static_viscous", "pulse", Some(method));
        let job = job("final_position", &choice, &axes, &fixed);
        bench_job(c, name, &job, &variants());
    }
}

/// Whole robots: four segments, three servos, ten cycles.
fn robots(c: &mut Criterion) {
    let axes = vec![("mu_coulomb", axis(0.1, 0.4, 16)), ("mass", axis(0.2, 0.35, 16))];
    let fixed = [
        ("mu_static", 0.5),
        ("segments", 4.0),
        ("stroke", 0.02),
        ("drive_limit", 5.0),
        ("speed_limit", 0.1),
        ("joint_stiffness", 2e3),
        ("joint_damping", 20.0),
        ("dwell", 0.1),
        ("cycles", if trial() { 1.0 } else { 10.0 }),
        ("time_step", 5e-3),
        ("gravity", 9.81),
        ("wall_force", 0.0),
    ];
    let entry = Entry::parse("gait_advance").expect("a known quantity");
    let grid = Grid::new(&axes, &fixed).expect("a valid grid");
    let request = vec![Request { entry, reduce: None }];
    let job = Job::new(grid, request, None, &Choice::default()).expect("a valid job");
    bench_job(c, "robot, 4 segments, 10 cycles", &job, &variants());
}

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

/// Six runs of measured length: sines of two frequencies, rounded as a command is.
fn runs() -> Vec<Run> {
    let count = if trial() { 50 } else { 2000 };
    let drive = |run: usize, t: f64| {
        let slow = (std::f64::consts::TAU * (0.5 + 0.1 * run as f64) * t).sin();
        let fast = (std::f64::consts::TAU * 2.3 * t + 0.4 * run as f64).sin();
        ((0.55 * slow + 0.4 * fast) * 50.0).round() / 50.0
    };
    let times: Vec<f64> = (0..count).map(|i| i as f64 * 2e-3).collect();
    let one = |run: usize| Run {
        drive: times.iter().map(|t| drive(run, *t)).collect(),
        times: times.clone(),
        slope_deg: 3.0,
    };
    (0..6).map(one).collect()
}

/// An effect's parameters, of visible size.
fn sizes(effect: Effect) -> &'static [f64] {
    match effect {
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
    }
}

/// A pack of candidates per run.
const CANDIDATES: usize = 16;

fn columns(effect: Option<Effect>, runs: &[Run]) -> Vec<Column> {
    let active = effect.map_or(Active::default(), |effect| Active::default().with(effect));
    let column = |run: usize, i: usize| {
        let mut values = [0.0; EFFECT_PARAMS];
        if let Some(effect) = effect {
            for (k, value) in sizes(effect).iter().enumerate() {
                values[effect.first() + k] = value * (1.0 + 1e-3 * i as f64);
            }
        }
        Column {
            run,
            window: (0, runs[run].times.len()),
            active,
            values,
            shares: [1.0, 1.0, 1.0, 0.0],
            start: (0.0, 0.0),
            sliding_distance: 0.0,
        }
    };
    (0..runs.len()).flat_map(|run| (0..CANDIDATES).map(move |i| column(run, i))).collect()
}

fn bench_replay(c: &mut Criterion, name: &str, columns: &[Column], tried: &[(Level, usize)]) {
    bench_replay_of(c, name, &NOMINAL, columns, tried);
}

fn bench_replay_of(
    c: &mut Criterion,
    name: &str,
    nominal: &Nominal,
    columns: &[Column],
    tried: &[(Level, usize)],
) {
    let runs = runs();
    let samples = columns.iter().map(|column| column.window.1 - column.window.0).sum();
    let mut group = group(c, name, samples);
    for &(level, threads) in tried {
        group.bench_function(id(level, threads), |b| {
            b.iter(|| {
                let columns = black_box(columns);
                replay(nominal, &runs, columns, (level, threads), &Control::default())
                    .expect("the replay runs")
            });
        });
    }
    group.finish();
}

/// Sample-steps per second: the nominal head at every level, then each effect.
fn replays(c: &mut Criterion) {
    let runs = runs();
    bench_replay(c, "replay nominal", &columns(None, &runs), &variants());
    let pendulum = Nominal {
        mass: 0.02,
        coulomb_force: Some(0.03),
        rotary: true,
        gravity_torque: 0.5,
        ..NOMINAL
    };
    let one = [(best_level(), 1)];
    bench_replay_of(c, "replay pendulum", &pendulum, &columns(None, &runs), &one);
    let stiff = Effect::PreslidingCompliance;
    for effect in Effect::ALL {
        let tried = if *effect == stiff { variants() } else { vec![(best_level(), 1)] };
        let name = format!("replay {}", effect.info().name);
        bench_replay(c, &name, &columns(Some(*effect), &runs), &tried);
    }
}

/// One model over six runs, and its derivatives in eight directions: exact ones, carried along
/// with one trajectory, and differences, nine trajectories side by side.
fn derivatives(c: &mut Criterion) {
    let runs = runs();
    let level = (best_level(), 1);
    let (first, second) = (Effect::ViscousFriction, Effect::DriveGainError);
    let whole = columns(Some(first), &runs);
    let mut alone: Vec<Column> = whole.iter().step_by(CANDIDATES).cloned().collect();
    for column in &mut alone {
        column.active = column.active.with(second);
        column.values[second.first()] = sizes(second)[0];
    }
    let own = [first.first(), second.first()];
    let directions: Vec<usize> = own.into_iter().chain(EFFECT_PARAMS..DIRECTIONS).collect();
    let samples: usize = alone.iter().map(|column| column.window.1).sum();
    let mut group = group(c, "replay derivatives", samples);
    group.bench_function("value alone", |b| {
        b.iter(|| {
            for one in &alone {
                let one = std::slice::from_ref(black_box(one));
                replay(&NOMINAL, &runs, one, level, &Control::default()).expect("the replay runs");
            }
        });
    });
    for count in [2, directions.len()] {
        let by: Vec<(Column, Vec<usize>)> =
            alone.iter().map(|one| (one.clone(), directions[..count].to_vec())).collect();
        let mut to = vec![vec![0.0; samples]; 4];
        let mut slopes = vec![vec![0.0; samples * count]; 4];
        group.bench_function(format!("value and {count}, exact"), |b| {
            b.iter(|| {
                replay_with_sensitivities(
                    &NOMINAL,
                    &runs,
                    black_box(&by),
                    level,
                    &Control::default(),
                    (rows(&mut to), rows(&mut slopes)),
                )
                .expect("the replay runs")
            });
        });
        let moved: Vec<Column> = alone
            .iter()
            .flat_map(|one| {
                (0..=count).map(|i| moved(one, i.checked_sub(1).map(|i| directions[i])))
            })
            .collect();
        group.bench_function(format!("value and {count}, differences"), |b| {
            b.iter(|| {
                replay(&NOMINAL, &runs, black_box(&moved), level, &Control::default())
                    .expect("the replay runs")
            });
        });
    }
    group.finish();
}

fn rows(of: &mut [Vec<f64>]) -> [&mut [f64]; 4] {
    let mut rows = of.iter_mut();
    std::array::from_fn(|_| rows.next().map(Vec::as_mut_slice).unwrap_or_default())
}

/// A column with what a direction stands for a little larger.
fn moved(column: &Column, direction: Option<usize>) -> Column {
    let mut column = column.clone();
    match direction {
        None => {}
        Some(i) if i < EFFECT_PARAMS => column.values[i] *= 1.0 + 1e-5,
        Some(i) if i < EFFECT_PARAMS + 4 => column.shares[i - EFFECT_PARAMS] += 1e-5,
        Some(i) if i == EFFECT_PARAMS + 4 => column.start.0 += 1e-5,
        Some(_) => column.start.1 += 1e-5,
    }
    column
}

criterion_group!(trajectories, steps, bristles, pulses);
criterion_group!(others, robots, replays, derivatives);
criterion_main!(trajectories, others);
