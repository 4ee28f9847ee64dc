//! A segment on dry ground: how it accelerates while it slides, and whether and
//! when friction gives way while it rests.

use super::State;
use super::settle::rise;
use crate::lane::Lane;
use crate::physics::friction::{Dry, Place};
use crate::physics::segment::Segment;

pub struct Ground<'a, 'b, Q: Dry, L: Lane> {
    pub segment: &'b Segment<'a, L>,
    pub set: &'b Q::Set<L>,
}

impl<Q: Dry, L: Lane> Ground<'_, '_, Q, L> {
    #[inline(always)]
    fn place(&self, state: &State<L>, way: L, x: L, drive: L, t: L) -> Place<L> {
        let forward = (x - state.x).max(x.with(0.0));
        let swept = if Q::PLACED { state.swept + forward } else { state.swept };
        Place { way, x, swept, drive, t }
    }

    /// Acceleration, drive force and resistance on lanes that slide.
    #[inline(always)]
    pub fn slope(&self, state: &State<L>, t: L, x: L, v: L) -> (L, L, L) {
        let segment = self.segment;
        let force = segment.force(t, &state.clock, x, v);
        let place = self.place(state, state.way, x, force, t);
        let against = Q::resistance(self.set, state.way * v, &place);
        let net = force - segment.pull_back(x) - state.way * against;
        (net * segment.per_mass, force, against)
    }

    /// Force that friction would have to hold at rest, and by how much it
    /// exceeds what it can.
    #[inline(always)]
    pub fn excess(&self, state: &State<L>, t: L) -> (L, L) {
        t.apart(
            #[inline(always)]
            || self.excess_here(state, t),
        )
    }

    #[inline(always)]
    fn excess_here(&self, state: &State<L>, t: L) -> (L, L) {
        let zero = t.with(0.0);
        let force = self.segment.force(t, &state.clock, state.x, zero);
        let push = force - self.segment.pull_back(state.x);
        let place = Place { way: push.sign(), x: state.x, swept: zero, drive: force, t };
        let holds = Q::holding(self.set, &place);
        let holds = holds.max(Q::resistance(self.set, zero, &place));
        (push, push.abs() - holds)
    }

    /// Time until friction gives way within the next `left` seconds and the
    /// direction then; all of `left` and 0 where it holds.
    #[inline(always)]
    pub fn wait(&self, state: &State<L>, left: L, locate: bool) -> (L, L) {
        let zero = left.with(0.0);
        let excess = |theta: L| self.excess(state, state.t + left * theta).1;
        let one = left.with(1.0);
        let end = excess(one);
        if !locate {
            // Seen at the end of the step only: the next one starts with it.
            return (left, zero);
        }
        let (start, half) = (excess(zero), excess(one * 0.5));
        // A peak between the ends, from the parabola through three points.
        let bend = start + end - half * 2.0;
        let tilt = end - start;
        let peak = L::select(bend.lt(zero), (tilt / bend) * -0.25 + 0.5, one);
        let inside = L::and(zero.lt(peak), peak.lt(one));
        let peak = L::select(inside, peak, one);
        let at_peak = excess(peak);
        let reach = L::select(zero.lt(at_peak), peak, one);
        let breaks = L::or(zero.lt(end), zero.lt(at_peak));
        if !L::any(breaks) {
            return (left, zero);
        }
        let theta = rise(reach, excess);
        let wait = L::select(breaks, left * theta, left);
        let (push, _) = self.excess(state, state.t + wait);
        (wait, L::select(breaks, push.sign(), zero))
    }
}
