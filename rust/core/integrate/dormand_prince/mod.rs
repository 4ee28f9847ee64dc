//! Steps whose size follows a tolerance, for single trajectories of dry laws of
//! any shape: the pair of Dormand and Prince with a proportional-integral
//! controller. Stops, strokes and samples are found on the dense output, so that
//! no sample shortens a step; a stop ends its step, which is taken anew up to
//! there.
//!
//! On plain numbers: trajectories whose steps differ this much gain nothing from
//! lanes. At rest the drive is looked at every `time_step`, and between as often as it
//! swings.

mod dense;
mod pair;

use super::drive_resolution::{looks, outruns_step, outruns_wait};
use super::dry_contact::{PlainContact, wait};
use super::{Advance, MOST_STIFF_STEPS, State, Tally};
use crate::physics::segment::Segment;
use dense::Quartic;
use pair::{NODES, Slopes, WEIGHTS};

/// Steps between two looks at the flag that stops a run.
const PATIENCE: u32 = 64;
/// Events within one `time_step` before a trajectory is given up.
const MOST_EVENTS: u32 = 100;
/// Smallest step, as a share of the time left; below, a trajectory is given up.
const SMALLEST: f64 = 1e-13;
/// Sizes of position and speed below which errors count absolutely, m and m/s.
const FLOORS: [f64; 2] = [1e-6, 1e-4];
/// Exponents of this step's error and of the last one's.
const PROPORTIONAL: f64 = 0.17;
const INTEGRAL: f64 = 0.04;

pub struct DormandPrince<'a, 'b, F> {
    segment: &'b Segment<'a, f64>,
    contact: &'b dyn PlainContact,
    adaptive: bool,
    locate: bool,
    go_on: F,
    /// How far the run has come; states before are read from `leg`.
    front: State<f64>,
    leg: Leg,
    /// The step to take next, and how close the last one came to the tolerance.
    next: f64,
    past: f64,
    /// Start of the current row of equal steps, and how many of them are done.
    row: (f64, f64),
    /// Events since the time beside them.
    events: (u32, f64),
}

/// The last stretch of a run.
struct Leg {
    begin: State<f64>,
    dt: f64,
    x: Quartic,
    v: Quartic,
}

/// A step that was tried.
struct Step {
    dt: f64,
    x: f64,
    v: f64,
    /// Acceleration at its end.
    end: f64,
    /// Its speed and position over time.
    leg: [Quartic; 2],
    work: f64,
    heat: f64,
    error: f64,
}

impl<F: FnMut() -> bool> Advance<f64> for DormandPrince<'_, '_, F> {
    fn advance(&mut self, state: &mut State<f64>, tally: &mut Tally<f64>, until: f64) -> bool {
        let mut count = 0;
        while self.front.t < until {
            self.advance_front(tally);
            count += 1;
            if count % PATIENCE == 0 {
                tally.give_up(&mut self.front, self.segment.duration, MOST_STIFF_STEPS);
                if !(self.go_on)() {
                    return false;
                }
            }
        }
        *state = self.state_at(until);
        true
    }

    fn steps(&self, duration: f64) -> f64 {
        let pieces = self.segment.drive.pieces(duration);
        if self.adaptive { pieces } else { duration / self.segment.step + pieces }
    }
}

impl<'a, 'b, F: FnMut() -> bool> DormandPrince<'a, 'b, F> {
    /// `adaptive`: steps from the tolerance; else all as given. Without `locate`
    /// events count at the end of their step.
    pub fn new(
        segment: &'b Segment<'a, f64>,
        contact: &'b dyn PlainContact,
        (adaptive, locate): (bool, bool),
        go_on: F,
    ) -> Self {
        let front = State::start(segment);
        let leg = Leg {
            begin: front,
            dt: 0.0,
            x: Quartic::constant(front.x),
            v: Quartic::constant(front.v),
        };
        DormandPrince {
            segment,
            contact,
            adaptive,
            locate,
            go_on,
            front,
            leg,
            next: segment.step,
            past: 1.0,
            row: (0.0, 0.0),
            events: (0, 0.0),
        }
    }

    /// The state at a time that the front has reached.
    fn state_at(&self, t: f64) -> State<f64> {
        if t >= self.front.t {
            return self.front;
        }
        let Leg { begin, dt, x, v } = &self.leg;
        let theta = ((t - begin.t) / dt).clamp(0.0, 1.0);
        let x = x.at(theta);
        // Rounding must not turn what is about to stop.
        let along = begin.direction * v.at(theta);
        let v = if along < 0.0 { 0.0 } else { begin.direction * along };
        let forward = if begin.direction > 0.0 { x - begin.x } else { 0.0 };
        State { t, x, v, sliding_distance: begin.sliding_distance + forward, ..*begin }
    }

    /// Takes the front on by one stretch of sliding or rest.
    fn advance_front(&mut self, tally: &mut Tally<f64>) {
        let piece_end = self.segment.drive.piece_end(self.front.clock.piece);
        let end = piece_end.min(self.segment.duration);
        let left = end - self.front.t;
        if left > 0.0 {
            self.rest_or_slide(tally, end, left);
            tally.steps += 1.0;
        }
        if self.front.t >= end {
            self.row = (end, 0.0);
            self.segment.drive.turn_over(&mut self.front.clock, piece_end, piece_end <= end);
            // The drive may have jumped: what rests is decided anew.
            if self.front.v == 0.0 {
                self.front.direction = 0.0;
            }
        }
    }

    fn rest_or_slide(&mut self, tally: &mut Tally<f64>, end: f64, left: f64) {
        if self.front.direction == 0.0 {
            let (push, over) = self.excess(&self.front);
            if over > 0.0 {
                self.front.direction = push.signum();
            }
        }
        let mut longest = if self.adaptive { left } else { self.until_mark(left) };
        if self.contact.placed() || self.front.direction == 0.0 {
            // What lies along the way, or in the drive's course, may be short.
            longest = longest.min(self.segment.step);
        }
        if self.front.direction == 0.0 {
            return self.rest(tally, end, longest);
        }
        let Some((step, stops)) = self.fitting(tally, end, longest) else { return };
        self.take(tally, &step, end);
        if stops {
            self.decide(tally);
        }
    }

    /// Time to the end of a step on the even grid of fixed steps.
    fn until_mark(&mut self, left: f64) -> f64 {
        let (from, step) = (self.row.0, self.segment.step);
        let mut to = from + (self.row.1 + 1.0) * step - self.front.t;
        if to <= 1e-9 * step {
            self.row.1 += 1.0;
            to = from + (self.row.1 + 1.0) * step - self.front.t;
        }
        if left <= to * (1.0 + 1e-9) { left } else { to }
    }

    /// A step that meets the tolerance, and whether it ends at a stop; `None`
    /// where there is none.
    fn fitting(&mut self, tally: &mut Tally<f64>, end: f64, longest: f64) -> Option<(Step, bool)> {
        if !self.adaptive {
            if outruns_step(self.segment, self.front.t, longest) {
                tally.rough += 1.0;
            }
            let step = self.attempt(longest);
            return Some(self.stopped(&step).map_or((step, false), |step| (step, true)));
        }
        loop {
            let cut = longest <= self.next * (1.0 + 1e-9);
            let mut step = self.attempt(if cut { longest } else { self.next });
            let mut stops = false;
            // What is steep about rest may show only in the step that ends there.
            if step.error <= 1.0
                && let Some(stopped) = self.stopped(&step)
            {
                (step, stops) = (stopped, true);
            }
            if step.error <= 1.0 {
                self.adapt(&step, cut || stops);
                return Some((step, stops));
            }
            tally.steps += 1.0;
            self.next = step.dt * (0.9 * power(step.error, -0.2)).clamp(0.1, 1.0);
            if self.next <= (end - self.front.t) * SMALLEST + 1e-300 {
                self.give_up(tally);
                return None;
            }
        }
    }

    /// Sizes the next step after one that was good enough.
    fn adapt(&mut self, step: &Step, cut: bool) {
        let error = step.error.max(1e-10);
        let factor = 0.9 * power(error, -PROPORTIONAL) * power(self.past, INTEGRAL);
        let proposed = step.dt * factor.clamp(0.2, 5.0);
        // A stretch cut short says nothing about the step that fits.
        self.next = if cut { self.next.max(proposed) } else { proposed };
        self.past = error.max(1e-4);
    }

    /// The step up to the stop that lies in it, if one does.
    fn stopped(&self, step: &Step) -> Option<Step> {
        let direction = self.front.direction;
        let until = match self.locate {
            true => {
                let theta = step.leg[1].along(direction).fall()?;
                self.stop(step.dt * theta, step.dt)
            }
            false => (direction * step.v < 0.0).then_some(step.dt)?,
        };
        Some(Step { v: 0.0, ..self.attempt(until) })
    }

    fn give_up(&mut self, tally: &mut Tally<f64>) {
        tally.lost += 1.0;
        let none = Quartic::constant(f64::NAN);
        self.leg = Leg { begin: self.front, dt: 1.0, x: none, v: none };
        self.front = State { t: self.segment.duration, x: f64::NAN, v: f64::NAN, ..self.front };
    }

    fn slope(&self, t: f64, x: f64, v: f64) -> (f64, f64, f64) {
        self.contact.slope(self.segment, &self.front, (t, x, v))
    }

    fn excess(&self, state: &State<f64>) -> (f64, f64) {
        self.contact.excess(self.segment, state, state.t)
    }

    /// One step of sliding from the front.
    fn attempt(&self, dt: f64) -> Step {
        let State { t, x: x0, v: v0, direction, .. } = self.front;
        let (mut along, mut faster): (Slopes, Slopes) = ([0.0; 7], [0.0; 7]);
        let (mut x, mut v) = (x0, v0);
        let (mut work, mut heat) = (0.0, 0.0);
        for (i, node) in NODES.into_iter().enumerate() {
            (x, v) = (pair::stage(i, x0, dt, &along), pair::stage(i, v0, dt, &faster));
            let (slope, force, against) = self.slope(t + node * dt, x, v);
            (along[i], faster[i]) = (v, slope);
            if let Some(weight) = WEIGHTS.get(i) {
                work += weight * (force * v);
                heat += weight * (against * v);
            }
        }
        let scale = |i: usize, from: f64, to: f64| {
            self.segment.tolerance * (from.abs().max(to.abs()) + FLOORS[i])
        };
        let errors =
            [pair::error(dt, &along) / scale(0, x0, x), pair::error(dt, &faster) / scale(1, v0, v)];
        let sum = errors[0].abs() + errors[1].abs();
        Step {
            dt,
            x,
            v,
            end: faster[6],
            leg: [pair::dense(x0, x, dt, &along), pair::dense(v0, v, dt, &faster)],
            work: dt * work,
            heat: direction * (dt * heat),
            // What is no number fits nowhere.
            error: if sum.is_nan() { f64::INFINITY } else { sum },
        }
    }

    /// When the speed passes zero: from the dense output, then by Newton on the
    /// step itself.
    fn stop(&self, mut until: f64, longest: f64) -> f64 {
        for _ in 0..3 {
            let step = self.attempt(until);
            let better = until - step.v / step.end;
            if better > 0.0 && better <= longest {
                until = better;
            }
        }
        until
    }

    /// Moves the front to the end of a step.
    fn take(&mut self, tally: &mut Tally<f64>, step: &Step, end: f64) {
        let begin = self.front;
        let [x, v] = step.leg;
        if tally.watch.stroke && tally.arrives(self.segment, begin.x, step.x) {
            tally.stroke_time = begin.t + self.arrival(step);
        }
        if tally.watch.energy {
            tally.spend(step.work, step.heat);
        }
        if tally.watch.peaks {
            tally.peak_v = v.peak().map_or(tally.peak_v, |peak| tally.peak_v.max(peak));
        }
        if self.contact.placed() && begin.direction > 0.0 {
            self.front.sliding_distance += step.x - begin.x;
        }
        let left = end - begin.t;
        self.front.t = if step.dt >= left { end } else { begin.t + step.dt };
        (self.front.x, self.front.v) = (step.x, step.v);
        tally.look(step.x, step.v);
        self.leg = Leg { begin, dt: step.dt, x, v };
    }

    /// Time within a step at which the stroke is complete.
    fn arrival(&self, step: &Step) -> f64 {
        let target = self.segment.target;
        let theta = step.leg[0].short_of(target, 1.0).fall().unwrap_or(1.0);
        let mut after = step.dt * theta;
        for _ in 0..2 {
            let trial = self.attempt(after);
            let better = after - (trial.x - target) / trial.v;
            if better > 0.0 && better <= step.dt {
                after = better;
            }
        }
        after
    }

    /// At a stop: rests, or slides the other way.
    fn decide(&mut self, tally: &mut Tally<f64>) {
        let (push, over) = self.excess(&self.front);
        self.front.sliding_distance = 0.0;
        self.front.direction = if over > 0.0 { push.signum() } else { 0.0 };
        if over <= 0.0 {
            tally.sticks += 1.0;
        }
        if self.front.t - self.events.1 > self.segment.step {
            self.events = (0, self.front.t);
        }
        self.events.0 += 1;
        if self.events.0 > MOST_EVENTS {
            self.give_up(tally);
        }
    }

    /// Rests until friction gives way, at most for `longest`.
    fn rest(&mut self, tally: &mut Tally<f64>, end: f64, longest: f64) {
        let begin = self.front;
        let blind = if self.locate { outruns_wait } else { outruns_step };
        if blind(self.segment, begin.t, longest) {
            tally.rough += 1.0;
        }
        let looks = looks(self.segment, begin.t, longest);
        let excess = |t| self.contact.excess(self.segment, &begin, t);
        let (wait, direction) = wait(begin.t, longest, (self.locate, looks), excess);
        tally.stuck += wait;
        self.front.t = if wait >= end - begin.t { end } else { begin.t + wait };
        (self.front.v, self.front.direction) = (0.0, direction);
        let (x, v) = (Quartic::constant(begin.x), Quartic::constant(0.0));
        self.leg = Leg { begin, dt: wait, x, v };
    }
}

/// The same on every system, as the bits of a run have to be.
fn power(base: f64, exponent: f64) -> f64 {
    libm::pow(base, exponent)
}
