//! Events within a step: stops, break-aways and contacts that close or open, found by
//! halving the step and, within the shortest one, by the straight line.

use super::one_step::{ByMap, BySeries};
use super::{ElasticDrive, Now};
use crate::Tally;
use crate::lane::Lane;

/// Events between two samples before a trajectory is given up: a joint can chatter.
const MOST_EVENTS: f64 = 64.0;

/// Share of a step at which the straight line between its ends turns positive; 1
/// where it does not.
#[inline(always)]
fn crossing<L: Lane>(from: L, to: L) -> L {
    let one = from.splat(1.0);
    let share = (-from / (to - from)).max(from.splat(0.0)).min(one);
    L::select(from.splat(0.0).lt(to), share, one)
}

impl<L: Lane, F> ElasticDrive<'_, '_, L, F> {
    /// Takes the lanes of `happens` from `from` to their first event within a step; returns
    /// the time that the step took, of all lanes of `mask`. Seldom needed.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(super) fn meet(
        &mut self,
        (mask, happens): (L::Mask, L::Mask),
        from: &Now<L>,
        inputs: (L, L),
        (t, dt): (L, L),
        tally: &mut Tally<L>,
        events: &mut L,
    ) -> L {
        let zero = dt.splat(0.0);
        *events = L::select(happens, *events + 1.0, *events);
        let lost = L::and(happens, zero.splat(MOST_EVENTS).lt(*events));
        if L::any(lost) {
            tally.lost = L::select(lost, tally.lost + 1.0, tally.lost);
            // Nothing happens to what is not a number any more.
            let nothing = zero.splat(f64::NAN);
            self.now.x = L::select(lost, nothing, self.now.x);
            self.now.v = L::select(lost, nothing, self.now.v);
            self.now.direction = L::select(lost, zero.splat(1.0), self.now.direction);
        }
        let happens = L::and(happens, L::not(lost));
        let (low, gone) = self.before(L::select(happens, dt, zero), from, inputs, t);
        let short = self.levels[0].dt;
        // The rest lies within the shortest one: by the straight line.
        let far = self.moved(ByMap(0), &low, inputs, None);
        let (before, after) =
            (self.overruns(&low, t + gone), self.overruns(&far, t + gone + short));
        let (own, touch) = (crossing(before.0, after.0), crossing(before.1, after.1));
        let first = own.min(touch);
        let creep = L::select(happens, short * first, zero);
        let mut met = self.moved(BySeries(creep), &low, inputs, None);
        let own_event = L::and(zero.lt(after.0), own.le(touch));
        let slides = zero.lt(from.direction.abs());
        let stops = L::and(own_event, slides);
        met.v = L::select(stops, zero, met.v);
        met.sliding_distance = L::select(stops, zero, met.sliding_distance);
        met.joined = L::select(own_event, met.joined, zero.splat(1.0) - met.joined);
        let (push, over) = self.excess(&met, t + gone + creep);
        let direction = L::select(zero.lt(over), push.sign(), zero);
        // A break-away found a hair early is one all the same.
        let direction = L::select(L::and(own_event, L::not(slides)), push.sign(), direction);
        met.direction = L::select(own_event, direction, met.direction);
        self.now = met.or(happens, self.now);
        let used = (gone + creep).min(dt);
        L::select(happens, used, L::select(mask, dt, zero))
    }

    /// The last state before an event within a step of `dt`, by maps of ever shorter parts, and
    /// its time.
    #[inline(always)]
    fn before(&self, dt: L, from: &Now<L>, inputs: (L, L), t: L) -> (Now<L>, L) {
        let zero = t.splat(0.0);
        let (mut low, mut gone) = (*from, zero);
        for (level, part) in self.levels.iter().enumerate().rev() {
            let after = gone + part.dt;
            let within = after.lt(dt);
            if !L::any(within) {
                continue;
            }
            let trial = self.moved(ByMap(level), &low, inputs, None);
            let (own, touch) = self.overruns(&trial, t + after);
            let clear = L::and(within, own.max(touch).le(zero));
            low = trial.or(clear, low);
            gone = L::select(clear, after, gone);
        }
        (low, gone)
    }
}
