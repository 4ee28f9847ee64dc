//! Replays in batches: lanes are columns of parameters (candidates, perturbed
//! parameters, restarts), over threads, with the same bits whatever their number.

use super::pool::pool;
use super::run::Control;
use crate::error::{Error, Result};
use crate::integrate::replay::{Reading, Samples, body, head, sensed};
use crate::lane::{Level, Pack, Task, run};
use crate::physics::effects::{Active, EFFECT_PARAMS, Nominal, Plant, shortness};
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

/// What the sensors would read, sample by sample, column by column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Readings {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub x_rear: Vec<f64>,
    pub force: Vec<f64>,
}

impl Readings {
    fn zeros(count: usize) -> Readings {
        let new = || vec![0.0; count];
        Readings { x: new(), v: new(), x_rear: new(), force: new() }
    }

    /// The part of every column, one after another.
    fn parts(&mut self, lengths: impl Iterator<Item = usize>) -> Vec<Part<'_>> {
        let mut rest: Part<'_> =
            [&mut self.x, &mut self.v, &mut self.x_rear, &mut self.force].map(Vec::as_mut_slice);
        lengths
            .map(|length| {
                let mut part: Part<'_> = Default::default();
                for (rest, part) in rest.iter_mut().zip(&mut part) {
                    let (own, others) = std::mem::take(rest).split_at_mut(length);
                    (*part, *rest) = (own, others);
                }
                part
            })
            .collect()
    }
}

/// Readings of one column: x, v, x_rear, force.
type Part<'a> = [&'a mut [f64]; 4];

/// Replays every column; the readings of all of them follow each other.
pub fn replay(
    nominal: &Nominal,
    runs: &[Run],
    columns: &[Column],
    (level, threads): (Level, usize),
    control: &Control,
) -> Result<Readings> {
    let length = |column: &Column| column.window.1 - column.window.0;
    let mut found = Readings::zeros(columns.iter().map(length).sum());
    // Columns that share run, window and effects go side by side. The order
    // within does not matter: no lane looks at its neighbours.
    let key = |column: &Column| (column.run, column.window, column.active);
    let pace = |column: &Column| shortness(column.active, &column.values);
    let parts = found.parts(columns.iter().map(length));
    let mut order: Vec<(&Column, Part<'_>)> = columns.iter().zip(parts).collect();
    // Those of one pace stand together: a pack takes the steps of its slowest lane.
    order.sort_by(|(a, _), (b, _)| key(a).cmp(&key(b)).then_with(|| pace(a).total_cmp(&pace(b))));
    let intervals: Vec<f64> = runs.iter().map(interval).collect();
    let groups: Vec<&mut [(&Column, Part<'_>)]> = order
        .chunk_by_mut(|(a, _), (b, _)| key(a) == key(b))
        .flat_map(|group| group.chunks_mut(PACK))
        .collect();
    let queue = Mutex::new(groups.into_iter());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = || {
        while let Some(group) = next() {
            if control.cancel.load(Ordering::Relaxed) {
                return;
            }
            let count = group.len() as u64;
            run(level, Group { nominal, runs, intervals: &intervals, group, control });
            control.done.fetch_add(count, Ordering::Relaxed);
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
    Ok(found)
}

/// The usual time between samples: their median.
fn interval(run: &Run) -> f64 {
    let mut steps: Vec<f64> = run.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 1.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Columns that one task takes: the widest pack.
const PACK: usize = 16;

struct Group<'a, 'b, 'c> {
    nominal: &'a Nominal,
    runs: &'a [Run],
    intervals: &'a [f64],
    group: &'b mut [(&'a Column, Part<'c>)],
    control: &'a Control,
}

impl Task for Group<'_, '_, '_> {
    type Output = ();
    const SCALAR_BASELINE: bool = true;

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let Group { nominal, runs, intervals, group, control } = self;
        let go_on = || !control.cancel.load(Ordering::Relaxed);
        let like = P::splat(token, 0.0);
        let nothing = Reading { x: like, v: like, force: like };
        let (mut readings, mut rear) = (Vec::new(), Vec::new());
        for part in group.chunks_mut(P::LANES) {
            let first = part[0].0;
            let run = &runs[first.run];
            let (from, to) = first.window;
            // A pack that is not full repeats its last column.
            let column = |lane: usize| part[lane.min(part.len() - 1)].0;
            let values = std::array::from_fn(|k| like.fill(|lane| column(lane).values[k]));
            let shares: [P; 4] = std::array::from_fn(|k| like.fill(|lane| column(lane).shares[k]));
            let start =
                (like.fill(|lane| column(lane).start.0), like.fill(|lane| column(lane).start.1));
            let interval = intervals[first.run];
            let window = (from, to);
            let samples = Samples { times: &run.times, drive: &run.drive, window, interval };
            let count = to - from;
            let [mass, level, gain, clock] = shares;
            let shares = ([mass, level, gain], clock);
            let plant = like.apart(
                #[inline(always)]
                || Plant::new(nominal, run.slope_deg, first.active, &values, shares),
            );
            readings.clear();
            readings.resize(count, nothing);
            head(
                &plant,
                samples,
                start,
                go_on,
                #[inline(always)]
                |i, reading| readings[i] = reading,
            );
            rear.clear();
            rear.resize(count, like);
            if let Some(anchored) = &plant.body {
                body(
                    &plant,
                    anchored,
                    samples,
                    #[inline(always)]
                    |i: usize| readings[i].force,
                    go_on,
                    #[inline(always)]
                    |i, x| rear[i] = x,
                );
            }
            for i in 0..count {
                let x = sensed(
                    &plant,
                    samples,
                    i,
                    #[inline(always)]
                    |i: usize| (readings[i].x, readings[i].v),
                );
                let now = [x, readings[i].v, rear[i], readings[i].force];
                for (lane, (_, own)) in part.iter_mut().enumerate() {
                    for (own, now) in own.iter_mut().zip(now) {
                        own[i] = now.lane(lane);
                    }
                }
            }
        }
    }
}
