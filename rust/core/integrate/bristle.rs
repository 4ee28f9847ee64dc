//! Stiff steps for bristle laws: a Rosenbrock method of order 4 with an embedded
//! one of order 3, L-stable and stiffly accurate, so that bristles a thousand
//! times faster than the motion neither limit the step nor ring.
//!
//! Every lane has its own step size; none changes with its neighbours.

mod rodas;
mod system;

use super::drive_resolution::outruns_step;
use super::event_location::Cubic;
use super::step_control::{MOST_GROWTH, MOST_SHRINK, SAFETY};
use super::{Advance, MOST_STIFF_STEPS, State, Tally};
use crate::lane::Lane;
use crate::physics::friction::{Bristle, MOST_STATES};
use crate::physics::segment::Segment;

pub struct Rosenbrock<'a, 'b, C: ?Sized, L, F> {
    pub segment: &'b Segment<'a, L>,
    pub contact: &'b C,
    /// Step sizes from the tolerance; else all as given.
    pub adaptive: bool,
    /// The step that each lane would take next.
    pub next: L,
    pub go_on: F,
}

const PATIENCE: u32 = 64;
/// Smallest step, as a share of the time left; below, a trajectory is given up.
const SMALLEST: f64 = 1e-13;
/// Errors beyond which a step shrinks or grows by all that one may, also where there is no number.
const LEAST_ERROR: f64 = 1e-9;
const MOST_ERROR: f64 = 1e6;
/// Estimated error of the speed in a step of fixed length, as a share of the speed (of 1 mm/s, where it
/// is slower), beyond which the step follows no motion: with all of it, nothing of the speed is known.
/// `pytest -m slow tests/test_divergence.py` holds that no run is left which misses all of its motion.
const COARSE: f64 = 1.0;

/// x, v, then the bristle states.
type Vector<L> = [L; MOST_STATES + 2];

impl<C: BristleContact<L> + ?Sized, L: Lane, F: FnMut() -> bool> Advance<L>
    for Rosenbrock<'_, '_, C, L, F>
{
    #[inline(always)]
    fn elastic(&self, state: &State<L>) -> L {
        self.contact.stored(&state.z)
    }

    #[inline(always)]
    fn advance(&mut self, state: &mut State<L>, tally: &mut Tally<L>, until: L) -> bool {
        let mut count = 0;
        while L::any(state.t.lt(until)) {
            self.step(state, tally, until);
            count += 1;
            if count % PATIENCE == 0 {
                tally.give_up(state, until, MOST_STIFF_STEPS);
                if !(self.go_on)() {
                    return false;
                }
            }
        }
        true
    }

    #[inline(always)]
    fn steps(&self, duration: L) -> L {
        let pieces = self.segment.drive.pieces(duration);
        if self.adaptive { pieces } else { duration / self.segment.step + pieces }
    }
}

/// What one step found.
#[derive(Clone, Copy)]
pub struct Step<L> {
    x: L,
    v: L,
    z: [L; MOST_STATES],
    work: L,
    heat: L,
    error: L,
    /// That of the speed alone.
    speed_error: L,
}

/// A bristle law with its coefficients, as the integrator meets it: a step at a time,
/// behind `dyn` (see `DryContact`).
pub trait BristleContact<L: Lane> {
    /// One step from `state`.
    fn attempt(&self, segment: &Segment<L>, state: &State<L>, dt: L, energy: bool) -> Step<L>;

    /// Elastic energy in the bristles.
    fn stored(&self, z: &[L; MOST_STATES]) -> L;
}

/// The coefficients of law `Q`.
pub struct Bound<Q: Bristle, L: Lane>(pub Q::Coefficients<L>);

impl<Q: Bristle, L: Lane> BristleContact<L> for Bound<Q, L> {
    #[inline(always)]
    fn attempt(&self, segment: &Segment<L>, state: &State<L>, dt: L, energy: bool) -> Step<L> {
        dt.outlined(
            #[inline(always)]
            || self.attempt_here(segment, state, dt, energy),
        )
    }

    #[inline(always)]
    fn stored(&self, z: &[L; MOST_STATES]) -> L {
        z[0].outlined(
            #[inline(always)]
            || Q::stored(&self.0, z),
        )
    }
}

impl<'a, 'b, C, L, F> Rosenbrock<'a, 'b, C, L, F>
where
    C: BristleContact<L> + ?Sized,
    L: Lane,
    F: FnMut() -> bool,
{
    #[inline(always)]
    pub fn new(
        segment: &'b Segment<'a, L>,
        contact: &'b C,
        adaptive: bool,
        go_on: F,
    ) -> Rosenbrock<'a, 'b, C, L, F> {
        // The first step is cautious: the controller grows it soon.
        let first = if adaptive { segment.step * 0.01 } else { segment.step };
        Rosenbrock { segment, contact, adaptive, next: first, go_on }
    }

    #[inline(always)]
    fn step(&mut self, state: &mut State<L>, tally: &mut Tally<L>, until: L) {
        let zero = state.t.splat(0.0);
        let active = state.t.lt(until);
        let piece_end = self.segment.drive.piece_end(state.clock.piece);
        let end = piece_end.min(until);
        let left = (end - state.t).max(zero);
        let last = left.le(self.next * (1.0 + 1e-9));
        let dt = L::select(last, left, self.next);
        // A lane that has arrived steps over a nominal time and is then ignored.
        let dt = L::select(zero.lt(dt), dt, self.segment.step);
        let step = self.contact.attempt(self.segment, state, dt, tally.watch.energy);
        let one = zero.splat(1.0);
        let finite = step.error.lt(zero.splat(f64::INFINITY));
        let mut accepted = active;
        if !self.adaptive {
            let share = step.speed_error * self.segment.tolerance;
            let mut rough = L::and(active, zero.splat(COARSE).lt(share));
            if self.segment.drive.swings() {
                let outrun = outruns_step(self.segment, state.t, dt);
                rough = L::or(rough, L::and(active, outrun));
            }
            tally.rough = L::select(rough, tally.rough + one, tally.rough);
        }
        if self.adaptive {
            let smallest = left * SMALLEST + 1e-300;
            let tiny = dt.le(smallest);
            let fine = step.error.le(one);
            accepted = L::and(active, L::or(fine, tiny));
            let given_up = L::and(active, L::and(tiny, L::not(fine)));
            tally.lost = L::select(given_up, tally.lost + 1.0, tally.lost);
            // Error falls with the fourth power of the step.
            let error =
                L::select(finite, step.error.max(zero.splat(LEAST_ERROR)), one * MOST_ERROR);
            let factor =
                (one * SAFETY / error.sqrt().sqrt()).max(one * MOST_SHRINK).min(one * MOST_GROWTH);
            let proposed = (dt * factor).frozen();
            // The last stretch before a station says nothing about the step that
            // fits, unless it was too long.
            let keep = L::and(last, proposed.lt(self.next));
            let keep = L::and(keep, fine);
            let next = L::select(keep, self.next, proposed);
            self.next = L::select(active, next, self.next);
        }
        take(self.segment, state, tally, &step, dt, accepted);
        let t = L::select(last, end, state.t + dt);
        state.t = L::select(accepted, t, state.t);
        let over = L::and(L::and(accepted, last), piece_end.le(until));
        self.segment.drive.turn_over(&mut state.clock, piece_end, over);
        tally.steps = L::select(active, tally.steps + 1.0, tally.steps);
    }
}

/// Takes a finished step into state and tally, where `mask` holds.
#[inline(always)]
fn take<L: Lane>(
    segment: &Segment<L>,
    state: &mut State<L>,
    tally: &mut Tally<L>,
    step: &Step<L>,
    dt: L,
    mask: L::Mask,
) {
    // The same for all laws: compiled once.
    dt.outlined(
        #[inline(always)]
        || take_here(segment, state, tally, step, dt, mask),
    );
}

#[inline(always)]
fn take_here<L: Lane>(
    segment: &Segment<L>,
    state: &mut State<L>,
    tally: &mut Tally<L>,
    step: &Step<L>,
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
        tally.spend(L::select(mask, step.work, zero), L::select(mask, step.heat, zero));
    }
    let far = L::and(mask, (state.v * v).lt(zero));
    if L::any(far) {
        let position = Cubic::new(dt, (state.x, state.v), (x, v));
        let peak = position.at(position.turn());
        tally.peak_x = L::select(far, tally.peak_x.max(peak), tally.peak_x);
    }
    // Swept since the last turn; backward motion leaves nothing to push.
    let sliding_distance = (state.sliding_distance + (x - state.x)).max(zero);
    let sliding_distance = L::select(zero.lt(v), sliding_distance, zero);
    state.sliding_distance = L::select(mask, sliding_distance, state.sliding_distance);
    for i in 0..MOST_STATES {
        state.z[i] = L::select(mask, step.z[i], state.z[i]);
    }
    state.x = x;
    state.v = v;
    tally.look(x, v);
}
