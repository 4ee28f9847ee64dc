//! One step of a head behind a joint or a lag, whatever happens within, by a map or a series;
//! and the one with friction and gravity as they are at its middle.

use super::propagation::{Changes, Inputs, MODES};
use super::{ElasticDrive, Now};
use crate::lane::Lane;

/// How a step is taken. Two types, so that the frequent one is compiled without the other.
pub(super) trait Step<L: Lane>: Copy {
    fn half(self) -> Self;
    /// Where it leads a lane of a mode.
    fn end<F>(
        self,
        drive: &ElasticDrive<L, F>,
        from: &Inputs<L>,
        changes: Option<Changes<L>>,
        mode: usize,
    ) -> [L; 4];
}

/// The map of a level.
#[derive(Clone, Copy)]
pub(super) struct ByMap(pub usize);

impl<L: Lane> Step<L> for ByMap {
    /// No level that is stepped over is the lowest.
    #[inline(always)]
    fn half(self) -> Self {
        ByMap(self.0 - 1)
    }
    #[inline(always)]
    fn end<F>(
        self,
        drive: &ElasticDrive<L, F>,
        from: &Inputs<L>,
        changes: Option<Changes<L>>,
        mode: usize,
    ) -> [L; 4] {
        let level = &drive.levels[self.0];
        let end = level.maps[mode].apply(from);
        match changes {
            Some(changes) => level.bends[mode].add(changes, end),
            None => end,
        }
    }
}

/// Taylor's series, over any short time.
#[derive(Clone, Copy)]
pub(super) struct BySeries<L>(pub L);

impl<L: Lane> Step<L> for BySeries<L> {
    #[inline(always)]
    fn half(self) -> Self {
        BySeries(self.0 * 0.5)
    }
    #[inline(always)]
    fn end<F>(
        self,
        drive: &ElasticDrive<L, F>,
        from: &Inputs<L>,
        changes: Option<Changes<L>>,
        mode: usize,
    ) -> [L; 4] {
        self.0.outlined(
            #[inline(always)]
            || drive.rates.series(from, changes, self.0, MODES[mode]),
        )
    }
}

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
    /// One step from `now`, whatever happens within, with inputs that change over it, if any.
    #[inline(always)]
    pub(super) fn moved(
        &self,
        step: impl Step<L>,
        now: &Now<L>,
        inputs: (L, L),
        changes: Option<Changes<L>>,
    ) -> Now<L> {
        let (offset, at) = self.inward(now, inputs);
        let end = self.by_mode(
            now,
            #[inline(always)]
            |mode| step.end(self, &at, changes, mode),
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

    /// What acts over a step, friction as it is at `now` and at the step's middle in time.
    #[inline(always)]
    pub(super) fn inputs(&self, now: &Now<L>, (t, dt): (L, L), drive: L) -> (L, L) {
        (self.pull(now, dt.mul_add(dt.splat(0.5), t)), drive)
    }

    /// Where a step leads from `from` with friction as it is at its middle, and
    /// what acts over it.
    #[inline(always)]
    pub(super) fn midpoint(
        &self,
        step: impl Step<L>,
        from: &Now<L>,
        (t, dt): (L, L),
        drive: L,
    ) -> (Now<L>, (L, L)) {
        let mut inputs = self.inputs(from, (t, dt), drive);
        let zero = dt.splat(0.0);
        if self.bent && L::any(zero.lt(from.direction.abs())) {
            let middle = self.moved(step.half(), from, inputs, None);
            inputs = self.inputs(&middle, (t, dt), drive);
        }
        (self.moved(step, from, inputs, None), inputs)
    }
}
