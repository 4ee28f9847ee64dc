//! Displacements along a measured motion, of packs of models: a model per lane.

use super::packs::{Column, Run};
use crate::integrate::measured_motion::{MeasuredMotion, displacements};
use crate::integrate::replay::Samples;
use crate::lane::{Level, Pack, Task, run};
use crate::physics::effects::{Nominal, Plant};
use std::sync::atomic::{AtomicBool, Ordering};

/// Means over blocks of samples, of models of one run with the same effects; each model's
/// one after another go to its part of `group`.
pub struct Along<'a, 'b, 'c> {
    pub nominal: &'a Nominal,
    pub run: &'a Run,
    pub motion: MeasuredMotion<'a>,
    pub interval: f64,
    pub block: usize,
    pub group: &'b mut [(&'a Column, &'c mut [f64])],
    pub cancel: &'a AtomicBool,
}

#[inline(never)]
pub fn displaced(level: Level, work: Along) {
    run(level, work);
}

impl Task for Along<'_, '_, '_> {
    type Output = ();
    const AVX2_AT_MOST: bool = true;

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let Along { nominal, run, motion, interval, block, group, cancel } = self;
        let like = P::broadcast(token, 0.0);
        let window = (0, run.times.len());
        let samples = Samples { times: &run.times, drive: &run.drive, window, interval };
        let mut lanes = vec![0.0; P::LANES];
        for part in group.chunks_mut(P::LANES) {
            // A pack that is not full repeats its last model.
            let column = |lane: usize| part[lane.min(part.len() - 1)].0;
            let values = std::array::from_fn(|k| like.fill(|lane| column(lane).values[k]));
            let [mass, level, gain, clock] =
                std::array::from_fn(|k| like.fill(|lane| column(lane).shares[k]));
            let active = part[0].0.active;
            let plant = like.outlined(
                #[inline(always)]
                || {
                    Plant::new(
                        nominal,
                        run.slope_deg,
                        active,
                        &values,
                        ([mass, level, gain], clock),
                    )
                },
            );
            let mut at = 0;
            displacements(
                &plant,
                samples,
                motion,
                block,
                #[inline(always)]
                || !cancel.load(Ordering::Relaxed),
                #[inline(always)]
                |mean| {
                    mean.store(&mut lanes);
                    for ((_, to), lane) in part.iter_mut().zip(&lanes) {
                        to[at] = *lane;
                    }
                    at += 1;
                },
            );
        }
    }
}
