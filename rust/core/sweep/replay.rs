//! Replays in batches: lanes are columns of parameters (candidates, perturbed
//! parameters, restarts), over threads, with the same bits whatever their number.

use super::pool::pool;
use super::run::Control;
use crate::error::{Error, Result};
use crate::integrate::replay::{Reading, Samples, body, head, sensed};
use crate::lane::{Level, Pack, Task, run};
use crate::physics::effects::{Active, EFFECT_PARAMS, Nominal, Plant};
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};

/// A measured run: drive samples, and the slope where it differs.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Seconds since the first sample, rising from 0.
    pub times: Vec<f64>,
    pub drive: Vec<f64>,
    pub slope_deg: f64,
}

/// One trajectory: a run, a set of effects and their parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    pub run: usize,
    /// First sample and one beyond the last: a window.
    pub window: (usize, usize),
    pub active: Active,
    /// Parameters of all effects, in the order of the registry.
    pub values: [f64; EFFECT_PARAMS],
    /// Factors on nominal mass, Coulomb level and gain, and the clock offset, s.
    pub shares: [f64; 4],
    /// Position and speed at the window's start.
    pub start: (f64, f64),
}

/// What the sensors would read, sample by sample.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Readings {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub x_rear: Vec<f64>,
    pub force: Vec<f64>,
}

/// Replays every column; the result has their order.
pub fn replay(
    nominal: &Nominal,
    runs: &[Run],
    columns: &[Column],
    (level, threads): (Level, usize),
    control: &Control,
) -> Result<Vec<Readings>> {
    // Columns that share run, window and effects go side by side. The order
    // within does not matter: no lane looks at its neighbours.
    let mut order: Vec<usize> = (0..columns.len()).collect();
    let key = |i: &usize| (columns[*i].run, columns[*i].window, columns[*i].active);
    order.sort_by_key(key);
    let mut found: Vec<Readings> = Vec::new();
    found.resize_with(columns.len(), Readings::default);
    let groups: Vec<&[usize]> =
        order.chunk_by(|a, b| key(a) == key(b)).flat_map(|group| group.chunks(PACK)).collect();
    let queue = Mutex::new(groups.into_iter());
    let done = Mutex::new(Vec::new());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = || {
        while let Some(group) = next() {
            if control.cancel.load(Ordering::Relaxed) {
                return;
            }
            let readings = run(level, Group { nominal, runs, columns, group, control });
            control.done.fetch_add(group.len() as u64, Ordering::Relaxed);
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            done.extend(group.iter().copied().zip(readings));
        }
    };
    if threads <= 1 || columns.len() <= PACK {
        work();
    } else {
        pool(threads)?.scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|_| work());
            }
        });
    }
    if control.cancel.load(Ordering::Relaxed) {
        let done = control.done.load(Ordering::Relaxed);
        return Err(Error::Cancelled { done, total: columns.len() as u64 });
    }
    for (i, readings) in done.into_inner().unwrap_or_else(PoisonError::into_inner) {
        found[i] = readings;
    }
    Ok(found)
}

/// Columns that one task takes: the widest pack.
const PACK: usize = 16;

struct Group<'a> {
    nominal: &'a Nominal,
    runs: &'a [Run],
    columns: &'a [Column],
    group: &'a [usize],
    control: &'a Control,
}

impl Task for Group<'_> {
    type Output = Vec<Readings>;
    const SCALAR_BASELINE: bool = true;

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) -> Vec<Readings> {
        let Group { nominal, runs, columns, group, control } = self;
        let go_on = || !control.cancel.load(Ordering::Relaxed);
        let mut found = Vec::with_capacity(group.len());
        for part in group.chunks(P::LANES) {
            let first = &columns[part[0]];
            let run = &runs[first.run];
            let (from, to) = first.window;
            let like = P::splat(token, 0.0);
            // A pack that is not full repeats its last column.
            let column = |lane: usize| &columns[part[lane.min(part.len() - 1)]];
            let values = std::array::from_fn(|k| like.fill(|lane| column(lane).values[k]));
            let shares: [P; 4] = std::array::from_fn(|k| like.fill(|lane| column(lane).shares[k]));
            let start =
                (like.fill(|lane| column(lane).start.0), like.fill(|lane| column(lane).start.1));
            let samples = Samples { times: &run.times, drive: &run.drive, window: (from, to) };
            let count = to - from;
            let [mass, level, gain, clock] = shares;
            let plant = Plant::new(
                nominal,
                run.slope_deg,
                first.active,
                &values,
                ([mass, level, gain], clock),
            );
            let nothing = Reading { x: like, v: like, force: like };
            let mut readings = vec![nothing; count];
            head(&plant, samples, start, go_on, |i, reading| readings[i] = reading);
            let mut rear = vec![like; count];
            if let Some(anchored) = &plant.body {
                let forces = |i: usize| readings[i].force;
                body(&plant, anchored, samples, forces, go_on, |i, x| rear[i] = x);
            }
            let motion = |i: usize| (readings[i].x, readings[i].v);
            for lane in 0..part.len() {
                found.push(Readings {
                    x: Vec::with_capacity(count),
                    v: readings.iter().map(|r| r.v.lane(lane)).collect(),
                    x_rear: rear.iter().map(|x| x.lane(lane)).collect(),
                    force: readings.iter().map(|r| r.force.lane(lane)).collect(),
                });
            }
            let base = found.len() - part.len();
            for i in 0..count {
                let x = sensed(&plant, samples, i, motion);
                for lane in 0..part.len() {
                    found[base + lane].x.push(x.lane(lane));
                }
            }
        }
        found
    }
}
