//! The engine: same bits however the work is cut, reductions against a slow
//! reference, refusals.

mod cuts;
#[path = "../common/engine.rs"]
mod engine;
mod levels;
#[path = "../common/random.rs"]
mod random;
mod reductions;
mod refusals;

use engine::*;
use locosweep::Error;
use locosweep::lane::Level;
use locosweep::physics::closed_form::*;
use locosweep::physics::{ParamId, Point, Quantity, Status};
use locosweep::sweep::{
    Buffer, Choice, Control, DEFAULT_CHUNK, Entry, Grid, Job, Options, QUANTITIES, Reduce, Request,
    run,
};
use random::Random;
use std::sync::atomic::Ordering;
use std::time::Instant;

type Axes = Vec<(&'static str, Vec<f64>)>;
type Fixed = Vec<(&'static str, f64)>;

/// Formulas of one point. What is simulated has tests of its own.
fn closed() -> Vec<&'static Entry> {
    QUANTITIES.iter().filter(|entry| entry.closed().is_some()).collect()
}

fn all() -> Vec<Request> {
    closed().into_iter().map(|entry| Request { entry, reduce: None }).collect()
}

fn job(axes: &[(&str, Vec<f64>)], fixed: &[(&str, f64)], requests: Vec<Request>) -> Job {
    Job::new(Grid::new(axes, fixed).unwrap(), requests, None, &Choice::default()).unwrap()
}

fn reduced(axes: &[(&str, Vec<f64>)], fixed: &[(&str, f64)], over: &str, name: &str) -> Vec<Job> {
    let entry = Entry::parse(name).unwrap();
    let grid = || Grid::new(axes, fixed).unwrap();
    REDUCTIONS
        .iter()
        .map(|reduce| {
            let request = Request { entry, reduce: Some(*reduce) };
            Job::new(grid(), vec![request], Some(over), &Choice::default()).unwrap()
        })
        .collect()
}

const REDUCTIONS: [Reduce; 10] = [
    Reduce::Max,
    Reduce::Min,
    Reduce::Argmax,
    Reduce::Argmin,
    Reduce::Mean,
    Reduce::Count,
    Reduce::LastFeasible,
    Reduce::Quantile(0.0),
    Reduce::Quantile(0.3),
    Reduce::Quantile(1.0),
];

/// Values alone: the way that may write past the caches.
fn values(job: &Job, options: Options) -> Vec<f64> {
    let mut values = vec![f64::MAX; job.cells()];
    run(job, vec![(0, Buffer::F64(&mut values))], options, &Control::default()).unwrap();
    values
}

const OTHERS: [(&str, f64); 3] = [("time", 0.4), ("speed", -0.2), ("segments_max", 500.0)];

/// A grid that keeps the promise of plain points.
fn plain() -> (Axes, Fixed) {
    let axes = vec![
        ("mu_static", steps(0.05, 1.4, 7)),
        ("mu_coulomb", steps(0.02, 0.9, 5)),
        ("slope_deg", steps(0.0, 40.0, 23)),
        ("segments", whole(2, 20)),
    ];
    (axes, OTHERS.to_vec())
}

/// The same coefficients and counts with everything that plain points leave out.
fn general() -> (Axes, Fixed) {
    let axes = vec![
        ("viscous", vec![0.0, 0.3, 40.0]),
        ("drive_limit", vec![0.6, 3.0, f64::INFINITY]),
        ("brake", vec![0.0, 1.0]),
        ("speed_limit", vec![0.02, f64::INFINITY]),
        ("slope_deg", vec![-12.0, 0.0, 7.5, 21.0]),
        ("mu_static", vec![0.2, 0.55, 1.3]),
        ("segments", vec![1.0, 2.0, 3.0, 5.0, 11.0]),
    ];
    let mut fixed = OTHERS.to_vec();
    fixed.extend([("mu_coulomb", 0.17), ("wall_force", 0.7), ("anchors_ahead", 1.0)]);
    (axes, fixed)
}
