//! Classical Runge-Kutta steps for dry laws of any shape, with stops and
//! break-aways located within the step.
//!
//! A step integrates the law of one direction of sliding; where the speed has
//! passed zero by its end (or dipped below it within), the stop is located, the
//! segment rests or turns there, and the rest of the step follows.

use super::drive_resolution::{looks, outruns_step, outruns_wait};
use super::dry_contact::{DryContact, Slide, wait};
use super::event_location::Cubic;
use super::step_control::{MOST_GROWTH, MOST_SHRINK, SAFETY};
use super::{Advance, MOST_STEPS, State, Tally};
use crate::lane::Lane;
use crate::physics::segment::Segment;

/// With `CONTROL` a step is cut where its error would exceed what sensors can see.
pub struct RungeKutta<'a, 'b, C: ?Sized, L, F, const CONTROL: bool = false> {
    segment: &'b Segment<'a, L>,
    contact: &'b C,
    locate: bool,
    /// Longest step.
    step: L,
    /// Longest way of a controlled step, m: a step that spans a wave of friction along the
    /// track can miss it, and so can the estimate of its error.
    stride: L,
    /// Largest error of the speed in a controlled step, m/s, as the embedded third-order
    /// solution shows it.
    speed_error: L,
    /// Whether what pushes and what holds the segment at rest stay from jump to jump.
    steady: bool,
    /// What the error of the last part of a step would have allowed.
    reach: L,
    go_on: F,
}

impl<'a, 'b, C: DryContact<L> + ?Sized, L: Lane, F, const CONTROL: bool>
    RungeKutta<'a, 'b, C, L, F, CONTROL>
{
    pub fn new(
        segment: &'b Segment<'a, L>,
        contact: &'b C,
        locate: bool,
        step: L,
        go_on: F,
    ) -> Self {
        let stride = step.splat(f64::INFINITY);
        let steady = segment.is_steady() && !contact.ages();
        let speed_error = stride;
        RungeKutta {
            segment,
            contact,
            locate,
            step,
            stride,
            speed_error,
            steady,
            reach: step,
            go_on,
        }
    }

    /// The same with steps that go no further than `stride`, m, and err by no more than
    /// `speed_error`, m/s.
    pub fn within(self, stride: L, speed_error: L) -> Self {
        RungeKutta { stride, speed_error, ..self }
    }
}

/// Shortest controlled step, as a share of the longest: a law that jumps has no short
/// enough one.
const SHORTEST: f64 = 1e-6;
/// Errors below this are rounding, m/s.
const NO_ERROR: f64 = 1e-30;

/// Steps between two looks at the flag that stops a run.
const PATIENCE: u32 = 256;
/// Events that one step may hold before its trajectory is given up.
const MOST_EVENTS: u32 = 100;
/// The same of parts of a controlled step, most of which end for their error: a trajectory
/// that needs ever shorter ones is given up. Cutting a step to `SHORTEST` and growing it
/// again takes some twenty; friction that falls far below the speeds of a run takes
/// thousands in every step, at 10 000 of them 0.8 ms a sample. Tried by
/// `cargo test --test replay`: nothing there is given up.
const MOST_PARTS: u32 = 1000;

impl<C: DryContact<L> + ?Sized, L: Lane, F: FnMut() -> bool, const CONTROL: bool> Advance<L>
    for RungeKutta<'_, '_, C, L, F, CONTROL>
{
    #[inline(always)]
    fn advance(&mut self, state: &mut State<L>, tally: &mut Tally<L>, until: L) -> bool {
        let h = self.step;
        let (mut from, mut taken) = (state.t, h.splat(0.0));
        let mut count = 0;
        while L::any(state.t.lt(until)) {
            let piece_end = self.segment.drive.piece_end(state.clock.piece);
            let active = state.t.lt(until);
            let end = piece_end.min(until);
            let left = (end - state.t).max(h.splat(0.0));
            // A step that would leave less than a rounding error takes it along.
            let last = left.le(h * (1.0 + 1e-9));
            let dt = L::select(last, left, h);
            // Not a running sum, whose rounding would grow with the steps.
            taken = taken + 1.0;
            let next = L::select(last, end, taken.mul_add(h, from));
            self.step(state, tally, dt);
            state.t = L::select(active, next, state.t);
            let over = L::and(L::and(active, last), piece_end.le(until));
            self.segment.drive.turn_over(&mut state.clock, piece_end, over);
            from = L::select(over, end, from);
            taken = L::select(over, h.splat(0.0), taken);
            tally.steps = L::select(active, tally.steps + 1.0, tally.steps);
            count += 1;
            if count % PATIENCE == 0 {
                tally.give_up(state, until, MOST_STEPS);
                if !(self.go_on)() {
                    return false;
                }
            }
        }
        true
    }

    #[inline(always)]
    fn steps(&self, duration: L) -> L {
        duration / self.step + self.segment.drive.pieces(duration)
    }
}

impl<C: DryContact<L> + ?Sized, L: Lane, F: FnMut() -> bool, const CONTROL: bool>
    RungeKutta<'_, '_, C, L, F, CONTROL>
{
    #[inline(always)]
    fn slide(&self, state: &State<L>, dt: L, energy: bool) -> Slide<L> {
        self.contact.slide(self.segment, state, dt, energy)
    }

    #[inline(always)]
    fn excess(&self, state: &State<L>, t: L) -> (L, L) {
        self.contact.excess(self.segment, state, t)
    }

    /// See `dry_contact::wait`, of lanes that friction holds at the start.
    #[inline(always)]
    fn wait(&self, state: &State<L>, left: L, locate: bool) -> (L, L) {
        if self.steady {
            return (left, left.splat(0.0));
        }
        wait(
            state.t,
            left,
            (locate, looks(self.segment, state.t, left)),
            #[inline(always)]
            |t| self.excess(state, t),
        )
    }

    /// One step of `dt`, with whatever happens within.
    #[inline(always)]
    fn step(&mut self, state: &mut State<L>, tally: &mut Tally<L>, dt: L) {
        let zero = dt.splat(0.0);
        // What a step left at rest is decided anew: the drive may have jumped.
        let still = L::not(zero.lt(state.v.abs()));
        state.direction = L::select(still, zero, state.direction);
        let moving = zero.lt(state.direction.abs());
        let resting = L::not(moving);
        if self.segment.drive.swings() {
            self.heed_drive(state, tally, dt, moving);
        }
        let mut tried = None;
        // Most steps hold no event in any lane.
        if !L::any(resting) || (self.locate && self.stays(state, resting, dt)) {
            let length = L::select(moving, dt, zero);
            let step = self.slide(state, length, tally.watch.energy);
            let rough =
                if CONTROL { L::and(moving, self.rough(state, &step, dt)) } else { zero.lt(zero) };
            if !L::any(L::or(rough, L::and(moving, self.stops(state, &step, dt)))) {
                take(self.segment, self.contact.placed(), state, tally, &step, dt, moving);
                tally.stuck = L::select(resting, tally.stuck + dt, tally.stuck);
                return;
            }
            tried = Some(step);
        }
        dt.outlined(
            #[inline(always)]
            || self.eventful(state, tally, dt, tried),
        );
    }

    /// Counts the lanes whose drive swings too fast for a step of `dt`, sliding where the
    /// mask holds, at rest elsewhere.
    #[inline(always)]
    fn heed_drive(&self, state: &State<L>, tally: &mut Tally<L>, dt: L, moving: L::Mask) {
        let step = outruns_step(self.segment, state.t, dt);
        let resting = if self.locate { outruns_wait(self.segment, state.t, dt) } else { step };
        let rough = L::or(L::and(moving, step), L::and(L::not(moving), resting));
        tally.rough = L::select(rough, tally.rough + 1.0, tally.rough);
    }

    /// Whether friction holds all resting lanes over a step: at its ends and by the
    /// parabola through its middle, as a wait would find.
    #[inline(always)]
    fn stays(&self, state: &State<L>, resting: L::Mask, dt: L) -> bool {
        if L::any(L::and(resting, dt.splat(0.0).lt(self.excess(state, state.t).1))) {
            return false;
        }
        let (_, direction) = self.wait(state, dt, true);
        !L::any(L::and(resting, dt.splat(0.0).lt(direction.abs())))
    }

    /// Lanes whose speed passes zero within the step.
    #[inline(always)]
    fn stops(&self, state: &State<L>, step: &Slide<L>, dt: L) -> L::Mask {
        let zero = dt.splat(0.0);
        let (from, to) = (state.direction * state.v, state.direction * step.v);
        let (falls, rises) = (state.direction * step.start, state.direction * step.end);
        let dips = L::and(falls.lt(zero), zero.lt(rises));
        let below = to.lt(zero);
        if self.locate && L::any(dips) {
            let cubic = Cubic::new(dt, (from, falls), (to, rises));
            return L::or(below, L::and(dips, cubic.at(cubic.turn()).lt(zero)));
        }
        below
    }

    /// A step with events, `tried` as if there were none where that was done.
    #[inline(always)]
    fn eventful(
        &mut self,
        state: &mut State<L>,
        tally: &mut Tally<L>,
        dt: L,
        mut tried: Option<Slide<L>>,
    ) {
        let zero = dt.splat(0.0);
        let begin = state.t;
        let mut left = dt;
        let mut events = 0;
        // The first part tries all of the step, as a lane whose neighbours hold no event does.
        self.reach = dt;
        while L::any(zero.lt(left)) {
            events += 1;
            if events > if CONTROL { MOST_PARTS } else { MOST_EVENTS } {
                let open = zero.lt(left);
                tally.lost = L::select(open, tally.lost + 1.0, tally.lost);
                break;
            }
            let used = self.part(state, tally, left, tried.take());
            left = L::select(used.lt(left), left - used, zero);
            state.t = state.t + used;
        }
        state.t = begin;
    }

    /// To the next event of each lane, or to the end of what is left of the
    /// step; returns the time that this took. `tried` is all that is left, taken as one step.
    #[inline(always)]
    fn part(
        &mut self,
        state: &mut State<L>,
        tally: &mut Tally<L>,
        left: L,
        tried: Option<Slide<L>>,
    ) -> L {
        let zero = left.splat(0.0);
        let open = zero.lt(left);
        let resting = L::and(open, L::not(zero.lt(state.direction.abs())));
        let mut used = left;
        let mut released = zero;
        if L::any(resting) {
            let (push, over) = self.excess(state, state.t);
            let at_once = zero.lt(over);
            let (wait, direction) = self.wait(state, left, self.locate);
            let wait = L::select(at_once, zero, wait);
            released = L::select(at_once, push.sign(), direction);
            used = L::select(resting, wait, used);
            tally.stuck = L::select(resting, tally.stuck + wait, tally.stuck);
        }
        let moving = L::and(open, zero.lt(state.direction.abs()));
        if L::any(moving) {
            let mut dt = L::select(moving, left, zero);
            if self.segment.drive.swings() {
                self.heed_drive(state, tally, dt, moving);
            }
            let mut whole = match tried {
                Some(tried) => tried,
                None => self.slide(state, dt, tally.watch.energy),
            };
            if CONTROL {
                (dt, whole) = self.controlled(state, moving, (dt, whole));
                used = L::select(moving, dt, used);
            }
            let stops = L::and(moving, self.stops(state, &whole, dt));
            if L::any(stops) {
                let until = if self.locate { self.stop_time(state, &whole, dt) } else { dt };
                let mut until = L::select(stops, until, dt);
                let mut step = self.slide(state, until, tally.watch.energy);
                let mut stops = stops;
                if CONTROL {
                    // The last of the way is where friction may be steepest: a part ends
                    // before the stop where the step to it is too long.
                    let early = L::and(stops, self.rough(state, &step, until));
                    if L::any(early) {
                        (until, step) = self.controlled(state, early, (until, step));
                        stops = L::and(stops, L::not(early));
                    }
                }
                step.v = L::select(stops, zero, step.v);
                take(self.segment, self.contact.placed(), state, tally, &step, until, moving);
                used = L::select(moving, until, used);
                let now = State { t: state.t + used, ..*state };
                let (push, over) = self.excess(&now, now.t);
                let goes = zero.lt(over);
                let direction = L::select(goes, push.sign(), zero);
                let rests = L::and(stops, L::not(goes));
                tally.sticks = L::select(rests, tally.sticks + 1.0, tally.sticks);
                state.sliding_distance = L::select(stops, zero, state.sliding_distance);
                state.direction = L::select(stops, direction, state.direction);
            } else {
                take(self.segment, self.contact.placed(), state, tally, &whole, dt, moving);
            }
        }
        state.direction = L::select(resting, released, state.direction);
        used
    }

    /// A step cut to where its error is small; keeps what the next part may reach. Only
    /// replays ask for it, which count no energy.
    #[inline(always)]
    fn controlled(
        &mut self,
        state: &State<L>,
        moving: L::Mask,
        (whole, slide): (L, Slide<L>),
    ) -> (L, Slide<L>) {
        let shortest = self.step * SHORTEST;
        // A step beyond the reach of the last one would only be cut again.
        let mut dt = L::select(moving, whole.min(self.reach), whole);
        let mut step = if L::any(dt.lt(whole)) { self.slide(state, dt, false) } else { slide };
        loop {
            let rough = self.rough(state, &step, dt);
            let rough = L::and(L::and(moving, shortest.lt(dt)), rough);
            let reach = (dt * growth(&step, self.speed_error))
                .min(self.stride * SAFETY / fastest(state, &step));
            self.reach = L::select(moving, reach.frozen(), self.reach);
            if !L::any(rough) {
                return (dt, step);
            }
            dt = L::select(rough, self.reach.max(shortest), dt);
            step = self.slide(state, dt, false);
        }
    }

    /// Lanes whose step of `dt` is too long, for its error or for the way that it takes.
    #[inline(always)]
    fn rough(&self, state: &State<L>, step: &Slide<L>, dt: L) -> L::Mask {
        let inexact = self.speed_error.lt(step.error);
        L::or(inexact, self.stride.lt(dt * fastest(state, step)))
    }

    /// When the speed passes zero: from the cubic, then by Newton on the step
    /// itself.
    #[inline(always)]
    fn stop_time(&self, state: &State<L>, whole: &Slide<L>, dt: L) -> L {
        let zero = dt.splat(0.0);
        let (from, to) = (state.direction * state.v, state.direction * whole.v);
        let slopes = (state.direction * whole.start, state.direction * whole.end);
        let cubic = Cubic::new(dt, (from, slopes.0), (to, slopes.1));
        let end = L::select(to.lt(zero), dt.splat(1.0), cubic.turn());
        let mut until = dt * cubic.fall(end);
        for _ in 0..3 {
            let step = self.slide(state, until, false);
            let better = until - step.v / step.end;
            let usable = L::and(better.gt(zero), better.le(dt));
            until = L::select(usable, better, until);
        }
        until
    }
}

/// The higher one of the speeds at a step's ends.
#[inline(always)]
fn fastest<L: Lane>(state: &State<L>, step: &Slide<L>) -> L {
    state.v.abs().max(step.v.abs())
}

/// Factor by which a step may grow, or has to shrink: the error goes with its fourth power.
#[inline(always)]
fn growth<L: Lane>(step: &Slide<L>, speed_error: L) -> L {
    let one = step.error.splat(1.0);
    let share = speed_error / step.error.max(one * NO_ERROR);
    (share.sqrt().sqrt() * SAFETY).max(one * MOST_SHRINK).min(one * MOST_GROWTH)
}

/// Takes a finished step into state and tally, where `mask` holds.
#[inline(always)]
fn take<L: Lane>(
    segment: &Segment<L>,
    placed: bool,
    state: &mut State<L>,
    tally: &mut Tally<L>,
    step: &Slide<L>,
    dt: L,
    mask: L::Mask,
) {
    // The same for all laws: compiled once.
    dt.outlined(
        #[inline(always)]
        || take_here(segment, placed, state, tally, step, dt, mask),
    );
}

#[inline(always)]
fn take_here<L: Lane>(
    segment: &Segment<L>,
    placed: bool,
    state: &mut State<L>,
    tally: &mut Tally<L>,
    step: &Slide<L>,
    dt: L,
    mask: L::Mask,
) {
    let zero = dt.splat(0.0);
    let x = L::select(mask, step.x, state.x);
    let v = L::select(mask, step.v, state.v);
    if tally.watch.stroke {
        let arrives = L::and(mask, tally.arrives(segment, state.x, x));
        if L::any(arrives) {
            let target = segment.target;
            let gone = Cubic::new(dt, (target - state.x, -state.v), (target - x, -v));
            let when = state.t + dt * gone.fall(dt.splat(1.0));
            tally.stroke_time = L::select(arrives, when, tally.stroke_time);
        }
    }
    if tally.watch.energy {
        let (work, heat) = (L::select(mask, step.work, zero), L::select(mask, step.heat, zero));
        tally.spend(work, heat);
    }
    // A peak of the speed between the ends.
    let peaks = L::and(mask, (step.start * step.end).lt(zero));
    if L::any(peaks) {
        let cubic = Cubic::new(dt, (state.v, step.start), (step.v, step.end));
        let peak = L::select(peaks, cubic.at(cubic.turn()), v);
        tally.peak_v = tally.peak_v.max(peak.abs());
    }
    if placed {
        let forward = L::and(mask, zero.lt(state.direction));
        let sliding_distance = state.sliding_distance + (x - state.x);
        state.sliding_distance = L::select(forward, sliding_distance, state.sliding_distance);
    }
    state.x = x;
    state.v = v;
    tally.look(x, v);
}
