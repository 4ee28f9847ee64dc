//! Replays in batches: lanes are columns of parameters (candidates, perturbed
//! parameters, restarts), over threads, with the same bits whatever their number.

use super::pool::pool;
use super::run::Control;
use crate::error::{Error, Result};
use crate::integrate::replay::{Samples, body, head, sensed};
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

/// The part of every column, one after another.
fn parts<'a>(to: [&'a mut [f64]; 4], lengths: impl Iterator<Item = usize>) -> Vec<Part<'a>> {
    let mut rest: Part<'a> = to;
    lengths
        .map(|length| {
            let mut part: Part<'a> = Default::default();
            for (rest, part) in rest.iter_mut().zip(&mut part) {
                let (own, others) = std::mem::take(rest).split_at_mut(length);
                (*part, *rest) = (own, others);
            }
            part
        })
        .collect()
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
    let count = samples(columns);
    let new = || vec![0.0; count];
    let mut found = Readings { x: new(), v: new(), x_rear: new(), force: new() };
    let Readings { x, v, x_rear, force } = &mut found;
    replay_into(nominal, runs, columns, (level, threads), control, [x, v, x_rear, force])?;
    Ok(found)
}

/// Samples of all columns.
pub fn samples(columns: &[Column]) -> usize {
    columns.iter().map(|column| column.window.1 - column.window.0).sum()
}

/// The same into x, v, x_rear and force of as many samples, all of them 0: memory that
/// was never touched stays so where nothing is read.
pub fn replay_into(
    nominal: &Nominal,
    runs: &[Run],
    columns: &[Column],
    (level, threads): (Level, usize),
    control: &Control,
    to: [&mut [f64]; 4],
) -> Result<()> {
    let length = |column: &Column| column.window.1 - column.window.0;
    // Columns that share run, window and effects go side by side. The order
    // within does not matter: no lane looks at its neighbours.
    let key = |column: &Column| (column.run, column.window, column.active);
    let pace = |column: &Column| shortness(column.active, &column.values);
    let parts = parts(to, columns.iter().map(length));
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
        let mut scratch = Scratch::default();
        while let Some(group) = next() {
            if control.cancel.load(Ordering::Relaxed) {
                return;
            }
            let count = group.len() as u64;
            let (intervals, scratch) = (&intervals, &mut scratch);
            run(level, Group { nominal, runs, intervals, group, control, scratch });
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
    Ok(())
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
    scratch: &'b mut Scratch,
}

/// Readings of one pack, a sample after another, kept from group to group.
#[derive(Default)]
struct Scratch {
    /// x, v and force of all lanes.
    head: Vec<f64>,
    rear: Vec<f64>,
    /// What the position sensor reads.
    seen: Vec<f64>,
}

/// Every `stride`th of `from`.
#[inline(always)]
fn spread(from: &[f64], stride: usize, to: &mut [f64]) {
    for (to, from) in to.iter_mut().zip(from.iter().step_by(stride)) {
        *to = *from;
    }
}

/// Samples that go to the columns at a time.
const TILE: usize = 32;

impl Task for Group<'_, '_, '_> {
    type Output = ();
    const SCALAR_BASELINE: bool = true;

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let Group { nominal, runs, intervals, group, control, scratch } = self;
        let go_on = || !control.cancel.load(Ordering::Relaxed);
        let like = P::splat(token, 0.0);
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
            let Scratch { head: motion, rear, seen } = &mut *scratch;
            let (own, all) = (P::LANES, 3 * P::LANES);
            // What a cancelled run leaves out is 0, not another column's.
            motion.clear();
            motion.resize(count * all, 0.0);
            seen.resize(seen.len().max(count * own), 0.0);
            head(
                &plant,
                samples,
                start,
                go_on,
                #[inline(always)]
                |i, reading| {
                    let to = &mut motion[i * all..(i + 1) * all];
                    reading.x.store(&mut to[..own]);
                    reading.v.store(&mut to[own..2 * own]);
                    reading.force.store(&mut to[2 * own..]);
                },
            );
            let slides = plant.body.is_some();
            if let Some(anchored) = &plant.body {
                rear.clear();
                rear.resize(count * own, 0.0);
                body(
                    &plant,
                    anchored,
                    samples,
                    #[inline(always)]
                    |i: usize| P::load(token, &motion[i * all + 2 * own..]),
                    go_on,
                    #[inline(always)]
                    |i, x: P| x.store(&mut rear[i * own..]),
                );
            }
            for i in 0..count {
                let x = sensed(
                    &plant,
                    samples,
                    i,
                    #[inline(always)]
                    |i: usize| {
                        let at = &motion[i * all..];
                        (P::load(token, at), P::load(token, &at[own..]))
                    },
                );
                x.store(&mut seen[i * own..]);
            }
            // Tile by tile, so that what is read for one lane is at hand for the next.
            for first in (0..count).step_by(TILE) {
                let last = (first + TILE).min(count);
                for (lane, (_, [x, v, x_rear, force])) in part.iter_mut().enumerate() {
                    let moved = &motion[first * all + lane..last * all];
                    spread(&seen[first * own + lane..last * own], own, &mut x[first..last]);
                    spread(&moved[own..], all, &mut v[first..last]);
                    spread(&moved[2 * own..], all, &mut force[first..last]);
                    if slides {
                        spread(
                            &rear[first * own + lane..last * own],
                            own,
                            &mut x_rear[first..last],
                        );
                    }
                }
            }
        }
    }
}
