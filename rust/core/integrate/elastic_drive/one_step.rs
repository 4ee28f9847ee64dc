//! One step of a head behind a joint or a lag, whatever happens within: friction and gravity as
//! they are at its middle.

use super::propagation::{Inputs, Level, MODES};
use super::{ElasticDrive, Now};
use crate::lane::Lane;
use crate::lane::exp::speed_factor;
use crate::physics::effects::Effect;

/// `a` where the mask holds, `b` elsewhere.
#[inline(always)]
fn either<L: Lane>(mask: L::Mask, a: [L; 4], b: [L; 4]) -> [L; 4] {
    let mut chosen = a;
    for (chosen, other) in chosen.iter_mut().zip(b) {
        *chosen = L::select(mask, *chosen, other);
    }
    chosen
}

impl<L: Lane, F> ElasticDrive<'_, '_, L, F> {
    /// One step of a level from `now`, whatever happens within.
    #[inline(always)]
    pub(super) fn moved(&self, level: &Level<L>, now: &Now<L>, inputs: (L, L)) -> Now<L> {
        let (offset, at) = self.inward(now, inputs);
        let end = self.by_mode(
            now,
            #[inline(always)]
            |mode| level.maps[mode].apply(&at),
        );
        self.gone(now, end, offset)
    }

    /// The same over any time up to the shortest step.
    #[inline(always)]
    pub(super) fn crept(&self, dt: L, now: &Now<L>, inputs: (L, L)) -> Now<L> {
        let (offset, at) = self.inward(now, inputs);
        let end = self.by_mode(
            now,
            #[inline(always)]
            |mode| {
                let (slides, joined) = MODES[mode];
                self.rates.series(&at, dt, slides, joined)
            },
        );
        self.gone(now, end, offset)
    }

    /// Where each lane comes to, by its mode; `to` is worked out for modes that some lane is in.
    #[inline(always)]
    fn by_mode(&self, now: &Now<L>, to: impl Fn(usize) -> [L; 4]) -> [L; 4] {
        let zero = now.x.splat(0.0);
        let (slides, joined) = (zero.lt(now.direction.abs()), zero.lt(now.joined));
        let mut end = [zero; 4];
        for (mode, own) in MODES.iter().enumerate().take(self.modes) {
            let mask = if own.0 { slides } else { L::not(slides) };
            let there = if own.1 { joined } else { L::not(joined) };
            let mask = if self.is_gap { L::and(mask, there) } else { mask };
            if L::any(mask) {
                end = either(mask, to(mode), end);
            }
        }
        end
    }

    /// Where a step has led to.
    #[inline(always)]
    fn gone(&self, now: &Now<L>, end: [L; 4], offset: L) -> Now<L> {
        let zero = now.x.splat(0.0);
        let sliding_distance =
            L::select(zero.lt(now.direction), now.sliding_distance + end[3], zero);
        Now {
            x: now.x + end[3],
            a: end[0] + offset,
            b: end[1],
            v: end[2],
            sliding_distance,
            ..*now
        }
    }

    /// State and inputs with the stretch counted from the contact's face.
    #[inline(always)]
    fn inward(&self, now: &Now<L>, (g, u): (L, L)) -> (L, Inputs<L>) {
        let offset = now.a - self.depth(now);
        (offset, [now.a - offset, now.b, now.v, g, u])
    }

    /// What acts over a step from `from`, friction as it is at `now`.
    #[inline(always)]
    pub(super) fn inputs(&self, now: &Now<L>, from: &Now<L>, (t, dt): (L, L), drive: L) -> (L, L) {
        let mut load = self.push(now);
        if self.rates.is_lag && self.law.active.has(Effect::LoadDependentFriction) {
            // Mean over the step.
            load = (from.a - drive).mul_add(speed_factor(dt * self.rates.lag), drive);
        }
        let level = self.level(now, now.direction, load, dt.mul_add(dt.splat(0.5), t));
        let back = now.direction.mul_add(level, self.segment.pull_back(now.x));
        (-back * self.segment.per_mass, drive)
    }

    /// Where a step of a level leads from `from` with friction as it is at its middle, and
    /// what acts over it.
    #[inline(always)]
    pub(super) fn midpoint(
        &self,
        level: usize,
        from: &Now<L>,
        (t, dt): (L, L),
        drive: L,
    ) -> (Now<L>, (L, L)) {
        let mut inputs = self.inputs(from, from, (t, dt), drive);
        if self.bent && level > 0 {
            let middle = self.moved(&self.levels[level - 1], from, inputs);
            inputs = self.inputs(&middle, from, (t, dt), drive);
        }
        (self.moved(&self.levels[level], from, inputs), inputs)
    }
}
