//! Replays with their forward sensitivities: derivatives of what the sensors would read
//! by parameters, nuisances and start state, exact through stops and break-aways.

use super::packs::{Column, Part, Run, bounded, divergence};
use crate::integrate::replay::{Samples, Start, head, sensed};
use crate::lane::{Dual, Lane, Level, Pack, Task, run};
use crate::physics::effects::{EFFECT_PARAMS, Nominal, Plant};
use std::sync::atomic::{AtomicBool, Ordering};

/// What a derivative is taken by: parameters of all effects in the order of the registry,
/// then the factors on nominal mass, Coulomb level and gain, the clock offset, and position
/// and speed at the window's start.
pub const DIRECTIONS: usize = EFFECT_PARAMS + OTHER_DIRECTIONS.len();

/// Those behind the parameters of effects.
pub const OTHER_DIRECTIONS: &[&str] =
    &["mass_share", "coulomb_share", "gain_share", "clock_offset", "x_start", "v_start"];

/// Readings and derivatives of one column: those of all samples, and of each direction the same.
pub struct Derived<'a> {
    pub readings: Part<'a>,
    pub slopes: Part<'a>,
}

/// Replays a column with its derivatives at a level.
#[inline(never)]
pub fn replay_derived(level: Level, work: Sensitivity) {
    run(level, work);
}

pub struct Sensitivity<'a, 'b> {
    pub nominal: &'a Nominal,
    pub run: &'a Run,
    pub interval: f64,
    pub column: &'a Column,
    pub directions: &'b [usize],
    pub cancel: &'a AtomicBool,
    pub to: Derived<'b>,
}

impl Task for Sensitivity<'_, '_> {
    type Output = ();
    const AVX2_AT_MOST: bool = true;

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let Sensitivity { nominal, run, interval, column, directions, cancel, to } = self;
        let go_on = || !cancel.load(Ordering::Relaxed);
        let none = P::broadcast(token, 0.0);
        let (from, last) = column.window;
        let count = last - from;
        let samples =
            Samples { times: &run.times, drive: &run.drive, window: (from, last), interval };
        let Derived { mut readings, mut slopes } = to;
        let mut motion: Vec<[Dual<P>; 4]> = Vec::with_capacity(count);
        let mut seen = vec![0.0; count];
        let mut unit = vec![0.0; P::LANES];
        // Without directions there still are readings.
        let alone = directions.is_empty().then_some(directions);
        for (turn, group) in directions.chunks(P::LANES).chain(alone).enumerate() {
            let seeded = |value: f64, direction: usize, unit: &mut [f64]| {
                for (k, unit) in unit.iter_mut().enumerate() {
                    *unit = if group.get(k) == Some(&direction) { 1.0 } else { 0.0 };
                }
                Dual::new(value, P::load(token, unit))
            };
            let values: [Dual<P>; EFFECT_PARAMS] =
                std::array::from_fn(|k| seeded(column.values[k], k, &mut unit));
            let shares: [Dual<P>; 4] =
                std::array::from_fn(|k| seeded(column.shares[k], EFFECT_PARAMS + k, &mut unit));
            let like = Dual::new(0.0, none);
            let start = Start {
                x: seeded(column.start.0, EFFECT_PARAMS + 4, &mut unit),
                v: seeded(column.start.1, EFFECT_PARAMS + 5, &mut unit),
                sliding_distance: like.splat(column.sliding_distance),
            };
            let [mass, level, gain, clock] = shares;
            let shares = ([mass, level, gain], clock);
            let plant = like.outlined(
                #[inline(always)]
                || Plant::new(nominal, run.slope_deg, column.active, &values, shares),
            );
            motion.clear();
            head(
                &plant,
                samples,
                start,
                go_on,
                #[inline(always)]
                |_, reading| motion.push([reading.x, reading.v, reading.x_rear, reading.force]),
            );
            let mut part = vec![0.0; P::LANES];
            for i in 0..motion.len() {
                let [_, v, x_rear, force] = motion[i];
                let x = sensed(
                    &plant,
                    samples,
                    i,
                    #[inline(always)]
                    |i: usize| (motion[i][0], motion[i][1]),
                );
                seen[i] = x.value();
                for (k, reading) in [x, v, x_rear, force].into_iter().enumerate() {
                    let Some(read) = readings[k].get_mut(i) else { continue };
                    *read = reading.value();
                    reading.slopes().store(&mut part);
                    for (d, slope) in part.iter().enumerate().take(group.len()) {
                        slopes[k][(turn * P::LANES + d) * count + i] = *slope;
                    }
                }
            }
            let fine = |i: usize| {
                let [x, v, x_rear, force] = motion[i].map(|reading| reading.value());
                let dt = run.times[from + i] - run.times[from];
                bounded(dt, column.start.0, x, v, [x_rear, force])
            };
            if let Some(first) = divergence(motion.len(), |i| seen[i], fine) {
                let all = readings.iter_mut().zip(&mut slopes);
                for (read, slopes) in all.filter(|(read, _)| !read.is_empty()) {
                    read[first..].fill(f64::NAN);
                    for d in 0..group.len() {
                        let end = (turn * P::LANES + d + 1) * count;
                        slopes[end - count + first..end].fill(f64::NAN);
                    }
                }
            }
        }
    }
}
