//! What is kept of a trajectory: a few numbers, whatever the number of steps.

use super::State;
use crate::lane::Lane;
use crate::physics::segment::Segment;

/// What is to be kept, beside the state; the rest is left out of the loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Watch {
    pub energy: bool,
    pub stroke: bool,
    pub peaks: bool,
}

impl Watch {
    pub const NOTHING: Watch = Watch { energy: false, stroke: false, peaks: false };
}

#[derive(Clone, Copy)]
pub struct Tally<L> {
    pub watch: Watch,
    pub x: L,
    pub v: L,
    /// Largest position and largest speed in either direction.
    pub peak_x: L,
    pub peak_v: L,
    /// When the stroke was complete; NaN while it is not.
    pub stroke_time: L,
    /// Time at rest and how often it began.
    pub stuck: L,
    pub sticks: L,
    /// Work of the drive and what friction turned into heat, J.
    pub work: L,
    pub heat: L,
    /// Sum of the sizes of all work done, the scale of the residual.
    pub moved: L,
    /// Kinetic, potential and elastic energy gained since the start.
    pub stored: L,
    /// Steps taken.
    pub steps: L,
    /// Steps too long for the law's steepness or the drive's frequency.
    pub rough: L,
    /// Runs of more steps than are taken.
    pub long: L,
    /// Events that could not be resolved; such a trajectory has no value.
    pub lost: L,
}

impl<L: Lane> Tally<L> {
    #[inline(always)]
    pub fn start(segment: &Segment<L>, watch: Watch) -> Self {
        let zero = segment.x.splat(0.0);
        Tally {
            watch,
            x: segment.x,
            v: segment.v,
            peak_x: segment.x,
            peak_v: segment.v.abs(),
            stroke_time: zero.splat(f64::NAN),
            stuck: zero,
            sticks: zero,
            work: zero,
            heat: zero,
            moved: zero,
            stored: zero,
            steps: zero,
            rough: zero,
            long: zero,
            lost: zero,
        }
    }

    /// Ends the lanes that have taken too many steps; looked at once in a while.
    #[inline(always)]
    pub fn give_up(&mut self, state: &mut State<L>, until: L, most: f64) {
        let zero = until.splat(0.0);
        let long = L::and(state.t.lt(until), zero.splat(most).lt(self.steps));
        self.long = L::select(long, zero.splat(1.0), self.long);
        state.t = L::select(long, until, state.t);
    }

    #[inline(always)]
    pub fn look(&mut self, x: L, v: L) {
        self.peak_x = self.peak_x.max(x);
        self.peak_v = self.peak_v.max(v.abs());
    }

    /// Lanes that reach the stroke's end between two positions for the first time.
    #[inline(always)]
    pub fn arrives(&self, segment: &Segment<L>, from: L, to: L) -> L::Mask {
        let new = L::not(self.stroke_time.not_nan());
        let there = L::and(from.lt(segment.target), segment.target.le(to));
        L::and(new, there)
    }

    #[inline(always)]
    pub fn spend(&mut self, work: L, heat: L) {
        self.work = self.work + work;
        self.heat = self.heat + heat;
        self.moved = self.moved + (work.abs() + heat.abs());
    }

    /// Closes the ledger; `elastic` is what the bristles hold of the work done
    /// against friction.
    #[inline(always)]
    pub fn end(mut self, segment: &Segment<L>, state: &State<L>, elastic: L) -> Self {
        self.x = state.x;
        self.v = state.v;
        let speed = segment.mass * 0.5 * (state.v * state.v - segment.v * segment.v);
        let lift = segment.weight * (state.x - segment.x);
        self.stored = speed + lift + elastic;
        // The slope does work as well.
        self.moved = self.moved + lift.abs();
        self.heat = self.heat - elastic;
        let rough = self.rough.splat(0.0).lt(self.rough);
        self.lost = L::select(rough, self.lost + 1.0, self.lost);
        self
    }
}
