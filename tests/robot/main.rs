//! The whole robot against the closed forms of its gaits, conservation laws,
//! symmetries, and the decision about sticking against brute force.

mod battery;
mod conservation;
mod crawling;
mod drive_work;
mod elastic;
#[path = "../common/engine.rs"]
mod engine;
mod events;
mod gaits;
mod lanes;
mod lubricant;
mod motor;
mod phases;
#[path = "../common/random.rs"]
mod random;
mod sticking;

use locosweep::integrate::robot::*;
use locosweep::lane::{Level, Pack, Task, run};
use locosweep::physics::ParamId::{self, *};
use locosweep::physics::gait::{GAITS, Gait, Grip, Phase, Schedule};
use locosweep::physics::point::row;
use locosweep::physics::robot::{Joint, Motor, Robot, Segment};
use locosweep::physics::{Point, Quantity, Status, closed_form};
use random::Random;
use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

const G: f64 = 9.81;
const M: f64 = 0.271;
const MG: f64 = M * G;
const STROKE: f64 = 0.02;

type Given<'a> = &'a [(ParamId, f64)];

fn with(base: Given, more: Given) -> Vec<(ParamId, f64)> {
    [base, more].concat()
}

#[track_caller]
fn near(got: f64, expected: f64, relative: f64) {
    let size = expected.abs().max(f64::MIN_POSITIVE);
    assert!((got - expected).abs() <= relative * size, "{got} is not {expected}");
}

/// Asserts that `got` rounds to the decimal number `shown`.
#[track_caller]
fn shows(got: f64, shown: &str) {
    let digits = shown.split_once('.').map_or(0, |(_, digits)| digits.len());
    let expected: f64 = shown.parse().unwrap();
    let half = 0.5 * 10f64.powi(-(digits as i32)) * (1.0 + 1e-9);
    assert!((got - expected).abs() <= half, "{got} does not show {shown}");
}

/// Runs a point through the ensemble.
fn tally(gait: Gait, given: Given) -> GaitTally<f64> {
    let point = row(given);
    let mut out = None;
    let level = *Level::available().last().unwrap();
    ensemble(level, gait, 1, &|_| point, &AtomicBool::new(false), &mut |_, t| out = Some(t));
    out.unwrap()
}

fn dry(segments: f64) -> Vec<(ParamId, f64)> {
    // The paper's values; the paper drops the speeds at the end of a phase, and its movers
    // have no static friction.
    vec![(MuStatic, 0.5), (MuCoulomb, 0.3), (Segments, segments), (Impact, 0.0), (BreakAway, 0.0)]
}

fn segment() -> Segment<f64> {
    Segment {
        mass: M,
        pull: 0.0,
        load: MG,
        wall: 0.0,
        mu_static: 0.5,
        mu_coulomb: 0.3,
        viscous: 0.0,
        skin_ratio: 1.0,
    }
}

fn ideal(limit: f64, speed: f64) -> Joint<f64> {
    Joint { stroke: STROKE, limit, speed, stiffness: f64::INFINITY, damping: 0.0 }
}

/// The paper's motor, and the same with a supply that bounds nothing.
const PAPER_MOTOR: Motor<f64> = Motor { supply: 10.0, resistance: 20.0, force_constant: 1.7 };
const MOTOR: Motor<f64> = Motor { supply: f64::INFINITY, ..PAPER_MOTOR };

fn robot(segments: Vec<Segment<f64>>, joint: Joint<f64>) -> Robot<f64> {
    let joints = vec![joint; segments.len() - 1];
    Robot {
        segments,
        joints,
        motor: MOTOR,
        wall_release: 0.0,
        gravity: G,
        lubricants: Vec::new(),
        segment_pitch: 0.0,
    }
}

const OPTIONS: RunOptions<f64> =
    RunOptions { time_step: 1e-3, dwell: 0.0, impact: 0.0, break_away: 0.0 };

/// A phase in which only the joints named change, at a common pace.
fn phase(segments: usize, target: &[f64], pace: f64, movers: &[usize]) -> Phase {
    Phase {
        target: target.to_vec(),
        pace,
        moves: (0..segments).map(|i| movers.contains(&i)).collect(),
        grip: vec![Grip::Full; segments],
        rests: true,
    }
}

/// The head's first phase alone.
fn head_phase(segments: usize) -> Schedule {
    let mut target = vec![0.0; segments - 1];
    target[0] = 1.0;
    let phases = vec![phase(segments, &target, 1.0, &[0])];
    Schedule { start: vec![0.0; segments - 1], phases, travel: 0.0 }
}

fn once(robot: &Robot<f64>, schedule: &Schedule, options: &RunOptions<f64>) -> GaitTally<f64> {
    simulate(robot, &Plan { schedule, cycles: 1 }, options, &mut ())
}

struct Values(Row);

impl locosweep::physics::friction::Parameters<f64> for Values {
    fn get(&self, id: ParamId) -> f64 {
        self.0[id.main()]
    }
    fn derived(&self, id: ParamId) -> f64 {
        self.0[id.derived()]
    }
}

fn from_point(given: Given, segments: usize) -> Robot<f64> {
    Robot::uniform(&Values(row(given)), segments)
}

fn random_robot(random: &mut Random, n: usize, elastic: bool) -> Robot<f64> {
    let segments = (0..n)
        .map(|_| Segment {
            mass: random.between(0.1, 0.5),
            pull: random.between(-0.3, 0.3),
            load: random.between(1.0, 4.0),
            wall: random.between(0.0, 3.0),
            mu_static: random.between(0.1, 0.6),
            mu_coulomb: random.between(0.05, 0.5),
            viscous: if random.one_in(2) { random.between(0.0, 3.0) } else { 0.0 },
            skin_ratio: random.between(0.5, 2.0),
        })
        .collect();
    let joint = |random: &mut Random| Joint {
        stroke: random.between(0.01, 0.03),
        limit: random.between(2.0, 12.0),
        speed: random.between(0.05, 0.3),
        stiffness: if elastic { random.between(500.0, 5e3) } else { f64::INFINITY },
        damping: if elastic { random.between(0.0, 40.0) } else { 0.0 },
    };
    let joints = (1..n).map(|_| joint(random)).collect();
    Robot {
        segments,
        joints,
        motor: MOTOR,
        wall_release: random.unit(),
        gravity: G,
        lubricants: Vec::new(),
        segment_pitch: 0.0,
    }
}

fn random_plan(random: &mut Random, n: usize) -> (Gait, Schedule) {
    let gait = GAITS[random.whole(0, GAITS.len() as u32 - 1) as usize];
    let moving = random.whole(1, n as u32 - 1) as usize;
    (gait, gait.schedule(n, moving).unwrap())
}

fn random_options(random: &mut Random) -> RunOptions<f64> {
    RunOptions {
        time_step: random.between(5e-4, 4e-3),
        dwell: random.between(0.0, 0.1),
        impact: random.whole(0, 1),
        break_away: random.whole(0, 1),
    }
}

fn servo(time_step: f64) -> Vec<(ParamId, f64)> {
    let joint = [(DriveLimit, 5.0), (SpeedLimit, 0.1), (JointStiffness, 2e3), (JointDamping, 20.0)];
    let run = [(Dwell, 0.1), (Cycles, 4.0), (TimeStep, time_step)];
    with(&[(MuStatic, 0.5), (MuCoulomb, 0.3), (Segments, 4.0)], &with(&joint, &run))
}
