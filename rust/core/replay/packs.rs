//! Replays of packs of columns (candidates, perturbed parameters, restarts), a column
//! per lane.

use crate::integrate::replay::{Samples, Start, head, sensed};
use crate::lane::{Level, Pack, Task, run};
use crate::physics::effects::{Active, EFFECT_PARAMS, Nominal, Plant};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

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
    /// Distance moved forward there since the last rest or turn.
    pub sliding_distance: f64,
}

/// Readings of one column: x, v, x_rear, force; empty where nobody asks for them.
pub type Part<'a> = [&'a mut [f64]; 4];

/// Replays a group at a level.
#[inline(never)]
pub fn replay_pack(level: Level, group: Group) {
    run(level, group);
}

/// Columns that one task takes: two packs.
pub const PACK: usize = 16;

/// Columns that share run, window and effects, at most `PACK` of them.
pub struct Group<'a, 'b, 'c> {
    pub nominal: &'a Nominal,
    pub runs: &'a [Run],
    pub intervals: &'a [f64],
    pub group: &'b mut [(&'a Column, Part<'c>)],
    pub cancel: &'a AtomicBool,
    pub scratch: &'b mut Scratch,
}

/// Readings of one pack, a sample after another, kept from group to group.
#[derive(Default)]
pub struct Scratch {
    /// x, v, force of all lanes, and x_rear where a body slides.
    head: Vec<f64>,
    /// What the position sensor reads.
    seen: Vec<f64>,
}

/// Every `stride`th of `from` to samples of what was asked for.
#[inline(always)]
fn spread(from: &[f64], stride: usize, to: &mut [f64], samples: Range<usize>) {
    let Some(to) = to.get_mut(samples) else { return };
    for (to, from) in to.iter_mut().zip(from.iter().step_by(stride)) {
        *to = *from;
    }
}

/// Nothing that a bench measures moves as fast, m/s (rad/s of a pendulum): the speed of
/// light. A replay beyond it has diverged, also where its numbers are still finite.
const FASTEST: f64 = 299_792_458.0;

/// Whether a head can be at `x` with speed `v`, `dt` seconds after it was at `start`; the
/// `others` of its readings only have to be numbers.
pub(super) fn bounded(dt: f64, start: f64, x: f64, v: f64, others: [f64; 2]) -> bool {
    let others = others.iter().all(|value| value.is_finite());
    others && v.abs() <= FASTEST && (x - start).abs() <= FASTEST * dt + start.abs()
}

/// The sample from which on the positions that were read have no meaning, if there is one.
/// Of `count`, only the last sample says whether there is one: what has diverged does not come back.
pub(super) fn divergence(
    count: usize,
    read: impl Fn(usize) -> f64,
    fine: impl Fn(usize) -> bool,
) -> Option<usize> {
    if count == 0 || fine(count - 1) {
        return None;
    }
    // A sensor with a negative delay reads ahead.
    (0..count).find(|i| !fine(*i) || !read(*i).is_finite())
}

/// The head's own motion in one lane of a pack, a row a sample, and what the position sensor read.
struct Motion<'a> {
    rows: &'a [f64],
    seen: &'a [f64],
    stride: usize,
    own: usize,
    slides: bool,
}

impl Motion<'_> {
    fn is_bounded(&self, i: usize, start: f64, dt: f64) -> bool {
        let row = &self.rows[i * self.stride..];
        let rear = if self.slides { row[3 * self.own] } else { 0.0 };
        bounded(dt, start, row[0], row[self.own], [row[2 * self.own], rear])
    }

    /// Readings from the divergence on are no numbers.
    fn end_where_diverged(&self, start: f64, times: &[f64], readings: &mut Part) {
        let fine = |i: usize| self.is_bounded(i, start, times[i] - times[0]);
        if let Some(first) = divergence(times.len(), |i| self.seen[i * self.own], fine) {
            for reading in readings.iter_mut().filter_map(|reading| reading.get_mut(first..)) {
                reading.fill(f64::NAN);
            }
        }
    }
}

/// Samples that go to the columns at a time.
const TILE: usize = 32;

impl Task for Group<'_, '_, '_> {
    type Output = ();
    // Sixteen lanes wait for one another at more events. With eight, processor time of the
    // diagnoses of `benches/diagnosis.py` without a gap, with a lag and with Stribeck friction
    // was 8 to 20 % less, that with bristles 7 to 13 % more (two rounds each at
    // `LOCOSWEEP_SIMD=avx2` and without, when AVX-512 still had sixteen). Eight in one vector of
    // AVX-512 take 0.60 to 1.06 of the time of eight in two of AVX2 (`cargo bench --bench dynamics
    // -- replay`), and the five slowest of 400 diagnoses 0.72 to 0.81.
    const EIGHT_LANES: bool = true;

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let Group { nominal, runs, intervals, group, cancel, scratch } = self;
        let go_on = || !cancel.load(Ordering::Relaxed);
        let like = P::broadcast(token, 0.0);
        for part in group.chunks_mut(P::LANES) {
            let first = part[0].0;
            let run = &runs[first.run];
            let (from, to) = first.window;
            // A pack that is not full repeats its last column.
            let column = |lane: usize| part[lane.min(part.len() - 1)].0;
            let values = std::array::from_fn(|k| like.fill(|lane| column(lane).values[k]));
            let shares: [P; 4] = std::array::from_fn(|k| like.fill(|lane| column(lane).shares[k]));
            let start = Start {
                x: like.fill(|lane| column(lane).start.0),
                v: like.fill(|lane| column(lane).start.1),
                sliding_distance: like.fill(|lane| column(lane).sliding_distance),
            };
            let interval = intervals[first.run];
            let window = (from, to);
            let samples = Samples { times: &run.times, drive: &run.drive, window, interval };
            let count = to - from;
            let [mass, level, gain, clock] = shares;
            let shares = ([mass, level, gain], clock);
            let plant = like.outlined(
                #[inline(always)]
                || Plant::new(nominal, run.slope_deg, first.active, &values, shares),
            );
            let Scratch { head: motion, seen } = &mut *scratch;
            let slides = plant.body.is_some();
            let own = P::LANES;
            let all = if slides { 4 * own } else { 3 * own };
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
                    reading.force.store(&mut to[2 * own..3 * own]);
                    if slides {
                        reading.x_rear.store(&mut to[3 * own..]);
                    }
                },
            );
            like.outlined(
                #[inline(always)]
                || {
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
                },
            );
            // Tile by tile, so that what is read for one lane is at hand for the next.
            for first in (0..count).step_by(TILE) {
                let last = (first + TILE).min(count);
                for (lane, (_, [x, v, x_rear, force])) in part.iter_mut().enumerate() {
                    let moved = &motion[first * all + lane..last * all];
                    spread(&seen[first * own + lane..last * own], own, x, first..last);
                    spread(&moved[own..], all, v, first..last);
                    spread(&moved[2 * own..], all, force, first..last);
                    if slides {
                        spread(&moved[3 * own..], all, x_rear, first..last);
                    }
                }
            }
            for (lane, (column, readings)) in part.iter_mut().enumerate() {
                let (rows, seen) = (&motion[lane..], &seen[lane..]);
                let motion = Motion { rows, seen, stride: all, own, slides };
                motion.end_where_diverged(column.start.0, &run.times[from..to], readings);
            }
        }
    }
}
