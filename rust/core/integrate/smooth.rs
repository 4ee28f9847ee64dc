//! Classical Runge-Kutta steps for laws that are functions of speed: no events,
//! so every step is the same few operations. Such laws creep instead of resting;
//! time at rest is therefore not counted.

use super::drive_resolution::outruns_step;
use super::event_location::Cubic;
use super::{Advance, State, Tally};
use crate::lane::Lane;
use crate::physics::friction::Smooth;
use crate::physics::segment::Segment;

pub struct Steps<'a, 'b, L, F> {
    contact: &'b dyn SmoothContact<L>,
    around: Around<'a, 'b, L>,
    ahead: Ahead<'b>,
    go_on: F,
}

/// A smooth law with its coefficients, as the integrator meets it: a step at a time,
/// behind `dyn` (see `DryContact`).
pub trait SmoothContact<L> {
    /// Its force at `SLOWEST`.
    fn rise(&self, like: L) -> L;

    fn step(
        &self,
        around: &Around<L>,
        state: &mut State<L>,
        tally: &mut Tally<L>,
        dt: L,
        forces: [L; 3],
    );
}

/// The coefficients of law `Q`.
pub struct Bound<Q: Smooth, L: Lane>(pub Q::Coefficients<L>);

/// What a step needs beside the law.
#[derive(Clone, Copy)]
pub struct Around<'a, 'b, L> {
    segment: &'b Segment<'a, L>,
    sprung: bool,
    rest: Rest<L>,
    /// Whether some lane's usual step is too long for its law near rest.
    steep: bool,
}

/// The law near rest, where it is steepest.
#[derive(Clone, Copy)]
struct Rest<L> {
    /// Slope of the resistance over the mass, 1/s.
    rate: L,
    /// Speed at which that slope would reach the static level.
    width: L,
}

/// A step times a rate beyond which Runge-Kutta steps amplify what should decay.
const STABLE: f64 = 2.8;
/// Far below every speed over which a law rises, m/s.
const SLOWEST: f64 = 1e-12;

/// Shape of the drive at start, middle and end of every step, where it is the
/// same for all trajectories, each at its own amplitude; empty where it is not.
#[derive(Debug, Clone, Copy)]
pub struct Ahead<'a>(pub &'a [[f64; 3]]);

const PATIENCE: u32 = 256;

impl<L: Lane, F: FnMut() -> bool> Advance<L> for Steps<'_, '_, L, F> {
    #[inline(always)]
    fn advance(&mut self, state: &mut State<L>, tally: &mut Tally<L>, until: L) -> bool {
        let segment = self.around.segment;
        let usual = segment.step.min((until - state.t).max(until.splat(0.0)));
        // A chirp is fastest at one of its ends.
        for t in [state.t, until - usual] {
            let outrun = outruns_step(segment, t, usual);
            tally.rough = L::select(outrun, tally.rough + 1.0, tally.rough);
        }
        if !self.ahead.0.is_empty() {
            return self.in_step(state, tally, until);
        }
        let h = segment.step;
        let (mut from, mut taken) = (state.t, h.splat(0.0));
        let mut count = 0;
        while L::any(state.t.lt(until)) {
            let piece_end = segment.drive.piece_end(state.clock.piece);
            let active = state.t.lt(until);
            let end = piece_end.min(until);
            let left = (end - state.t).max(h.splat(0.0));
            let last = left.le(h * LAST);
            let dt = L::select(last, left, h);
            // Not a running sum, whose rounding would grow with the steps.
            taken = taken + 1.0;
            let next = L::select(last, end, taken.mul_add(h, from));
            let half = dt * 0.5;
            let clock = &state.clock;
            let (start, middle) = (segment.commanded(state.t, clock), state.t + half);
            let middle = segment.commanded(middle, clock);
            let forces = [start, middle, segment.commanded(state.t + dt, clock)];
            let old = *state;
            self.step(state, tally, dt, forces);
            state.t = next;
            let over = L::and(last, piece_end.le(until));
            segment.drive.turn_over(&mut state.clock, piece_end, over);
            from = L::select(over, state.t, from);
            taken = L::select(over, h.splat(0.0), taken);
            *state = state.or(active, old);
            count += 1;
            if count % PATIENCE == 0 && !(self.go_on)() {
                return false;
            }
        }
        true
    }

    #[inline(always)]
    fn steps(&self, duration: L) -> L {
        let segment = self.around.segment;
        duration / segment.step + segment.drive.pieces(duration)
    }
}

/// A step that would leave less than a rounding error takes it along.
pub const LAST: f64 = 1.0 + 1e-9;

impl<'a, 'b, L: Lane, F: FnMut() -> bool> Steps<'a, 'b, L, F> {
    /// `sprung`: whether any trajectory is pulled by a spring.
    #[inline(always)]
    pub fn new(
        segment: &'b Segment<'a, L>,
        contact: &'b dyn SmoothContact<L>,
        sprung: bool,
        ahead: Ahead<'b>,
        go_on: F,
    ) -> Self {
        let slope = contact.rise(segment.mass) * (1.0 / SLOWEST);
        let rate = slope * segment.per_mass;
        let level = segment.contact.break_away.max(segment.contact.coulomb);
        // A little early: the last step of a run may be longer by a rounding error.
        let steep = L::any(rate.splat(0.99 * STABLE).lt(segment.step * rate));
        let rest = Rest { rate, width: level / slope };
        Steps { contact, around: Around { segment, sprung, rest, steep }, ahead, go_on }
    }

    /// All lanes in the same steps, without a spring, from start to end.
    #[inline(always)]
    fn in_step(&mut self, state: &mut State<L>, tally: &mut Tally<L>, until: L) -> bool {
        let segment = self.around.segment;
        let h = segment.step;
        let steps = self.ahead.0.len();
        for (i, shapes) in self.ahead.0.iter().enumerate() {
            let last = i + 1 == steps;
            let dt = if last { until - state.t } else { h };
            let mut forces = [h; 3];
            for (force, shape) in forces.iter_mut().zip(shapes) {
                *force = segment.drive.shaped(h.splat(*shape)).clip(segment.limit);
            }
            self.step(state, tally, dt, forces);
            state.t = if last { until } else { h * (i + 1) as f64 };
            if i as u32 % PATIENCE == PATIENCE - 1 && !(self.go_on)() {
                return false;
            }
        }
        true
    }

    #[inline(always)]
    fn step(&mut self, state: &mut State<L>, tally: &mut Tally<L>, dt: L, forces: [L; 3]) {
        self.contact.step(&self.around, state, tally, dt, forces);
    }
}

impl<L: Lane> Around<'_, '_, L> {
    /// Lanes whose step of `dt` jumps out of, into or over the law's rise at rest,
    /// which it is too long to follow; `low` and `high` bound its speeds.
    #[inline(always)]
    fn jumps(&self, dt: L, low: L, high: L) -> L::Mask {
        let Rest { rate, width } = self.rest;
        let long = rate.splat(STABLE).lt(dt * rate);
        let meets = L::and(low.lt(width), (-width).lt(high));
        let leaves = width.lt(high - low);
        L::and(long, L::and(meets, leaves))
    }
}

impl<Q: Smooth, L: Lane> SmoothContact<L> for Bound<Q, L> {
    fn rise(&self, like: L) -> L {
        like.outlined(
            #[inline(always)]
            || Q::force(&self.0, like.splat(SLOWEST)),
        )
    }

    fn step(
        &self,
        around: &Around<L>,
        state: &mut State<L>,
        tally: &mut Tally<L>,
        dt: L,
        forces: [L; 3],
    ) {
        dt.outlined(
            #[inline(always)]
            || self.step_here(around, state, tally, dt, forces),
        );
    }
}

impl<Q: Smooth, L: Lane> Bound<Q, L> {
    #[inline(always)]
    fn step_here(
        &self,
        around: &Around<L>,
        state: &mut State<L>,
        tally: &mut Tally<L>,
        dt: L,
        forces: [L; 3],
    ) {
        let segment = around.segment;
        let half = dt * 0.5;
        let sixth = dt * (1.0 / 6.0);
        let zero = dt.splat(0.0);
        let (x0, v0) = (state.x, state.v);
        // The slopes of the previous stage, and the weighted sums.
        let (mut a, mut u) = (zero, v0);
        let (mut start, mut sum_a, mut sum_v) = (zero, zero, zero);
        let mut first_change = zero;
        let (mut low, mut high) = (v0, v0);
        let (mut work, mut heat) = (zero, zero);
        for stage in 0..4usize {
            let reach = if stage == 3 {
                dt
            } else if stage == 0 {
                zero
            } else {
                half
            };
            let v = reach.mul_add(a, v0);
            if around.steep {
                (low, high) = (low.min(v), high.max(v));
            }
            let drive = forces[stage.div_ceil(2)];
            let force = if around.sprung {
                let x = reach.mul_add(u, x0);
                segment.with_spring(drive, state.t + reach, x, v)
            } else {
                drive
            };
            let against = Q::force(&self.0, v);
            let before = a;
            a = ((force - segment.weight) - against) * segment.per_mass;
            u = v;
            let weight = if stage == 1 || stage == 2 { 2.0 } else { 1.0 };
            sum_a = a.mul_add(dt.splat(weight), sum_a);
            sum_v = v.mul_add(dt.splat(weight), sum_v);
            if stage == 0 {
                start = a;
            } else if stage == 1 {
                first_change = (a - start).abs();
            } else if stage == 2 {
                // The step times the law's steepness over the mass, from how two
                // stages disagree.
                let steep = (first_change * (0.5 * STABLE)).lt((a - before).abs());
                let large = (a.abs() * 1e-6).lt(first_change);
                let rough = L::and(steep, large);
                tally.rough = L::select(rough, tally.rough + 1.0, tally.rough);
            }
            if tally.watch.energy {
                work = (force * v).mul_add(dt.splat(weight), work);
                heat = (against * v).mul_add(dt.splat(weight), heat);
            }
        }
        let v = sixth.mul_add(sum_a, v0);
        let x = sixth.mul_add(sum_v, x0);
        if around.steep {
            // No stage need meet a rise that the step jumps over.
            let jumps = around.jumps(dt, low.min(v), high.max(v));
            tally.rough = L::select(jumps, tally.rough + 1.0, tally.rough);
        }
        if tally.watch.energy {
            tally.spend(sixth * work, sixth * heat);
        }
        if tally.watch.stroke {
            let arrives = tally.arrives(segment, x0, x);
            if L::any(arrives) {
                let target = segment.target;
                let gone = Cubic::new(dt, (target - x0, -v0), (target - x, -v));
                let when = state.t + dt * gone.fall(dt.splat(1.0));
                tally.stroke_time = L::select(arrives, when, tally.stroke_time);
            }
        }
        if tally.watch.peaks {
            // The speed peaks where its slope changes sign, the position where
            // the speed does.
            let fast = (start * a).lt(dt.splat(0.0));
            let far = (v0 * v).lt(dt.splat(0.0));
            if L::any(L::or(fast, far)) {
                let speed = Cubic::new(dt, (v0, start), (v, a));
                let peak = speed.at(speed.turn()).abs();
                tally.peak_v = L::select(fast, tally.peak_v.max(peak), tally.peak_v);
                let position = Cubic::new(dt, (x0, v0), (x, v));
                let peak = position.at(position.turn());
                tally.peak_x = L::select(far, tally.peak_x.max(peak), tally.peak_x);
            }
            tally.look(x, v);
        }
        tally.steps = tally.steps + 1.0;
        state.x = x;
        state.v = v;
    }
}
