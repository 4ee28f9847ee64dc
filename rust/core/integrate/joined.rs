//! A drive with a mass of its own, joined to the head by a spring or a gap: two
//! bodies, of which only the head rubs.
//!
//! Classical Runge-Kutta steps short against the joint's own oscillation; stops
//! and break-aways of the head are located by repeating the step.

use super::{State, Tally};
use crate::lane::Lane;
use crate::physics::effects::Joint;
use crate::physics::friction::{Dry, Place};
use crate::physics::segment::Segment;

pub struct Joined<'a, 'b, Q: Dry, L: Lane> {
    pub segment: &'b Segment<'a, L>,
    pub set: Q::Set<L>,
    pub joint: Joint<L>,
    /// Position and speed of the drive's side.
    pub side: (L, L),
    pub step: L,
}

#[derive(Clone, Copy)]
struct Four<L> {
    x: L,
    v: L,
    sx: L,
    sv: L,
}

/// Events that one step may hold before its trajectory is given up: a heap of
/// lubricant that levels out at every stop can make a stiff joint chatter.
const MOST_EVENTS: u32 = 20;

impl<'a, 'b, Q: Dry, L: Lane> Joined<'a, 'b, Q, L> {
    pub fn new(
        segment: &'b Segment<'a, L>,
        set: Q::Set<L>,
        joint: Joint<L>,
        start: &State<L>,
    ) -> Self {
        let zero = start.x.with(0.0);
        let (joint, reduced) = joint.followed(segment.mass);
        // A spring starts loaded by the first force, a gap in its middle.
        let first = segment.commanded(zero, &start.clock);
        let loaded = if joint.is_spring { first / joint.stiffness } else { zero };
        let (rate, drag) = (joint.stiffness / reduced, joint.damping / reduced);
        // An eighth of what one radian of the oscillation takes.
        let step = segment.step.min(zero.with(0.125) / rate.sqrt().max(drag * 0.5));
        Joined { segment, set, joint, side: (start.x + loaded, start.v), step }
    }

    /// Force of the joint on the head.
    #[inline(always)]
    pub fn force(&self, x: L, v: L, side: (L, L)) -> L {
        let (stretch, rate) = (side.0 - x, side.1 - v);
        if self.joint.is_spring {
            return self.joint.damping.mul_add(rate, self.joint.stiffness * stretch);
        }
        let zero = x.with(0.0);
        let depth = stretch.abs() - self.joint.gap;
        let way = stretch.sign();
        let closing = way * rate;
        // Contacts push, they do not pull.
        let push = self.joint.damping.mul_add(closing, self.joint.stiffness * depth).max(zero);
        L::select(zero.lt(depth), way * push, zero)
    }

    #[inline(always)]
    fn slope(&self, state: &State<L>, t: L, at: &Four<L>, slides: L::Mask) -> Four<L> {
        let zero = t.with(0.0);
        let segment = self.segment;
        let joint = self.force(at.x, at.v, (at.sx, at.sv));
        let drive = segment.commanded(t, &state.clock);
        let swept = state.swept + (at.x - state.x).max(zero);
        let place = Place { way: state.way, x: at.x, swept, drive: joint, t };
        let against = Q::resistance(&self.set, state.way * at.v, &place);
        let net = joint - segment.pull_back(at.x) - state.way * against;
        let a = L::select(slides, net * segment.per_mass, zero);
        let side = (drive - joint) / self.joint.mass;
        let v = L::select(slides, at.v, zero);
        Four { x: v, v: a, sx: at.sv, sv: side }
    }

    #[inline(always)]
    fn try_step(&self, state: &State<L>, dt: L) -> Four<L> {
        dt.apart(
            #[inline(always)]
            || self.try_here(state, dt),
        )
    }

    #[inline(always)]
    fn try_here(&self, state: &State<L>, dt: L) -> Four<L> {
        let zero = dt.with(0.0);
        let half = dt * 0.5;
        let slides = zero.lt(state.way.abs());
        let start = Four { x: state.x, v: state.v, sx: self.side.0, sv: self.side.1 };
        let mut k = Four { x: zero, v: zero, sx: zero, sv: zero };
        let mut sum = k;
        for stage in 0..4 {
            let reach = if stage == 0 {
                zero
            } else if stage < 3 {
                half
            } else {
                dt
            };
            let at = Four {
                x: reach.mul_add(k.x, start.x),
                v: reach.mul_add(k.v, start.v),
                sx: reach.mul_add(k.sx, start.sx),
                sv: reach.mul_add(k.sv, start.sv),
            };
            k = self.slope(state, state.t + reach, &at, slides);
            let weight = dt * (if stage == 1 || stage == 2 { 1.0 / 3.0 } else { 1.0 / 6.0 });
            sum.x = weight.mul_add(k.x, sum.x);
            sum.v = weight.mul_add(k.v, sum.v);
            sum.sx = weight.mul_add(k.sx, sum.sx);
            sum.sv = weight.mul_add(k.sv, sum.sv);
        }
        Four {
            x: start.x + sum.x,
            v: start.v + sum.v,
            sx: start.sx + sum.sx,
            sv: start.sv + sum.sv,
        }
    }

    /// What pushes the head at rest, and by how much it exceeds what holds it.
    #[inline(always)]
    fn excess(&self, t: L, at: &Four<L>) -> (L, L) {
        let zero = t.with(0.0);
        let joint = self.force(at.x, zero, (at.sx, at.sv));
        let push = joint - self.segment.pull_back(at.x);
        let place = Place { way: push.sign(), x: at.x, swept: zero, drive: joint, t };
        let holds = Q::holding(&self.set, &place);
        let holds = holds.max(Q::resistance(&self.set, zero, &place));
        (push, push.abs() - holds)
    }

    /// Positive where the event of a lane's mode has happened: passed zero, or
    /// pushed harder than friction holds.
    #[inline(always)]
    fn overrun(&self, state: &State<L>, t: L, at: &Four<L>) -> L {
        let slides = t.with(0.0).lt(state.way.abs());
        L::select(slides, -(state.way * at.v), self.excess(t, at).1)
    }

    /// How far the drive's side has come into contact; a spring always is.
    #[inline(always)]
    fn depth(&self, at: &Four<L>) -> L {
        if self.joint.is_spring {
            return at.x.with(f64::INFINITY);
        }
        (at.sx - at.x).abs() - self.joint.gap
    }

    /// Takes every lane to its time `until`.
    #[inline(always)]
    pub fn advance(&mut self, state: &mut State<L>, tally: &mut Tally<L>, until: L) {
        let zero = until.with(0.0);
        while L::any(state.t.lt(until)) {
            let piece_end = self.segment.drive.piece_end(state.clock.piece);
            let active = state.t.lt(until);
            let end = piece_end.min(until);
            let left = (end - state.t).max(zero);
            let last = left.le(self.step * (1.0 + 1e-9));
            let dt = L::select(last, left, self.step);
            let next = L::select(last, end, state.t + self.step);
            self.whole_step(state, tally, dt);
            state.t = L::select(active, next, state.t);
            let over = L::and(L::and(active, last), piece_end.le(until));
            self.segment.drive.turn_over(&mut state.clock, piece_end, over);
        }
    }

    #[inline(always)]
    fn whole_step(&mut self, state: &mut State<L>, tally: &mut Tally<L>, dt: L) {
        let zero = dt.with(0.0);
        let begin = state.t;
        let mut left = dt;
        let mut events = 0;
        while L::any(zero.lt(left)) {
            events += 1;
            if events > MOST_EVENTS {
                let open = zero.lt(left);
                tally.lost = L::select(open, tally.lost + 1.0, tally.lost);
                // Nothing happens to what is not a number any more.
                let nothing = zero.with(f64::NAN);
                state.x = L::select(open, nothing, state.x);
                state.v = L::select(open, nothing, state.v);
                let (x, v) = self.side;
                self.side = (L::select(open, nothing, x), L::select(open, nothing, v));
                break;
            }
            // What rests may be free to go at once.
            let now = Four { x: state.x, v: state.v, sx: self.side.0, sv: self.side.1 };
            let rests = L::not(zero.lt(state.way.abs()));
            let (push, over) = self.excess(state.t, &now);
            let goes = L::and(L::and(rests, zero.lt(left)), zero.lt(over));
            state.way = L::select(goes, push.sign(), state.way);
            let mut used = left;
            let mut to = self.try_step(state, left);
            // The contact's force jumps at touch-down: a step ends there. At
            // lift-off it falls to zero by itself.
            let apart = self.depth(&now).le(zero);
            let past = |t: L, at: &Four<L>| {
                let touches = L::and(apart, zero.lt(self.depth(at)));
                L::or(zero.lt(self.overrun(state, t, at)), touches)
            };
            let happens = L::and(past(state.t + left, &to), zero.lt(left));
            if L::any(happens) {
                let (mut low, mut high) = (zero, left);
                // A lane that has settled stays, however long the others take.
                let mut open = happens;
                for _ in 0..40 {
                    let middle = (low + high) * 0.5;
                    let at = self.try_step(state, middle);
                    let past = past(state.t + middle, &at);
                    high = L::select(L::and(open, past), middle, high);
                    low = L::select(L::and(open, L::not(past)), middle, low);
                    open = L::and(open, (left * 1e-9).lt(high - low));
                    if !L::any(open) {
                        break;
                    }
                }
                used = L::select(happens, high, left);
                to = self.try_step(state, used);
            }
            let slides = zero.lt(state.way.abs());
            let overrun = zero.lt(self.overrun(state, state.t + used, &to));
            let forward = L::and(slides, zero.lt(state.way));
            let swept = L::select(forward, state.swept + (to.x - state.x), zero);
            state.swept = L::select(slides, swept, zero);
            state.x = to.x;
            let stops = L::and(L::and(happens, overrun), slides);
            state.v = L::select(stops, zero, to.v);
            self.side = (to.sx, to.sv);
            let resting = L::not(slides);
            tally.stuck = L::select(resting, tally.stuck + used, tally.stuck);
            state.t = state.t + used;
            // The next round decides whether it rests or goes on.
            let at = Four { x: state.x, v: zero, sx: to.sx, sv: to.sv };
            let (push, over) = self.excess(state.t, &at);
            let way = L::select(zero.lt(over), push.sign(), zero);
            let decides = L::or(stops, L::and(happens, resting));
            state.way = L::select(decides, way, state.way);
            left = L::select(used.lt(left), left - used, zero);
        }
        state.t = begin;
    }
}
