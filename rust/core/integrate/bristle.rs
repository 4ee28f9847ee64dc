//! Stiff steps for bristle laws: a Rosenbrock method of order 3 with an embedded
//! one of order 2, L-stable and stiffly accurate, so that bristles a thousand
//! times faster than the motion neither limit the step nor ring.
//!
//! RODAS3 of Sandu, Verwer, Blom, Spee, Carmichael and Potra 1997: four stages,
//! three evaluations, one small linear system per step. Every lane has its own
//! step size; none changes with its neighbours.

mod system;

use super::drive_resolution::outruns_step;
use super::event_location::Cubic;
use super::step_control::cube_root;
use super::{Advance, Clock, MOST_STIFF_STEPS, State, Tally};
use crate::lane::Lane;
use crate::physics::friction::{Bristle, ContactState, MOST_STATES};
use crate::physics::segment::Segment;
use system::{Ledger, Solver};

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

/// x, v, then the bristle states; the last two are work and heat.
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
        if !self.adaptive && self.segment.drive.swings() {
            let rough = L::and(active, outruns_step(self.segment, state.t, dt));
            tally.rough = L::select(rough, tally.rough + one, tally.rough);
        }
        if self.adaptive {
            let smallest = left * SMALLEST + 1e-300;
            let tiny = dt.le(smallest);
            let fine = step.error.le(one);
            accepted = L::and(active, L::or(fine, tiny));
            let given_up = L::and(active, L::and(tiny, L::not(fine)));
            tally.lost = L::select(given_up, tally.lost + 1.0, tally.lost);
            // Error falls with the third power of the step.
            let error = L::select(finite, step.error.max(zero.splat(1e-9)), zero.splat(1e6));
            let factor = (cube_root(error) * (1.0 / 0.9)).max(zero.splat(1.0 / 6.0));
            let factor = factor.min(zero.splat(5.0));
            let proposed = (dt / factor).frozen();
            // The last stretch before a station says nothing about the step that
            // fits, unless it was too long.
            let keep = L::and(last, proposed.lt(self.next));
            let keep = L::and(keep, step.error.le(one));
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

impl<Q: Bristle, L: Lane> Bound<Q, L> {
    #[inline(always)]
    fn rates(
        &self,
        segment: &Segment<L>,
        law: &Q::Coefficients<L>,
        t: L,
        clock: &Clock<L>,
        y: &Vector<L>,
    ) -> (L, [L; MOST_STATES], L, L) {
        t.outlined(
            #[inline(always)]
            || self.rates_here(segment, law, t, clock, y),
        )
    }

    #[inline(always)]
    fn rates_here(
        &self,
        segment: &Segment<L>,
        law: &Q::Coefficients<L>,
        t: L,
        clock: &Clock<L>,
        y: &Vector<L>,
    ) -> (L, [L; MOST_STATES], L, L) {
        let (x, v) = (y[0], y[1]);
        let z: [L; MOST_STATES] = std::array::from_fn(|i| y[2 + i]);
        let mut rates = Q::rates(law, v, &z);
        let against = Q::force(law, v, &z, &rates);
        let force = segment.force(t, clock, x, v);
        let mut push = force - segment.pull_back(x) - against;
        if let Some((driven, per_mass)) = Q::driven(law) {
            push = push - force;
            rates[driven] = force.mul_add(per_mass, rates[driven]);
        }
        (push * segment.per_mass, rates, force, against)
    }

    #[inline(always)]
    fn attempt_here(&self, segment: &Segment<L>, state: &State<L>, dt: L, energy: bool) -> Step<L> {
        let zero = dt.splat(0.0);
        let count = Q::STATES;
        let mut y: Vector<L> = [zero; MOST_STATES + 2];
        (y[0], y[1]) = (state.x, state.v);
        y[2..2 + count].copy_from_slice(&state.z[..count]);
        // Where the law varies along the way it is taken at the step's middle.
        let middle = ContactState {
            direction: state.v.sign(),
            x: (dt * 0.5).mul_add(state.v, state.x),
            sliding_distance: state.sliding_distance,
            drive: segment.commanded(state.t, &state.clock),
            t: state.t + dt * 0.5,
        };
        let law = Q::placed(&self.0, &middle);
        let partials = Q::partials(&law, state.v, &state.z);
        let per_dt = dt.splat(1.0) / dt;
        let solver = Solver::new::<Q>(segment, &partials, state.x, per_dt * 2.0);
        let force_t = segment.force_slope(state.t, &state.clock);
        // What the drive accelerates, and how that changes with time.
        let (pushed, per_mass) = match Q::driven(&law) {
            Some((driven, per_mass)) => (2 + driven, per_mass),
            None => (1, segment.per_mass),
        };
        let slope_t = force_t * per_mass;

        let (a, rates, f1, r1) = self.rates(segment, &law, state.t, &state.clock, &y);
        // Stage 1: f + dt/2 f_t.
        let mut right: Vector<L> = [zero; MOST_STATES + 2];
        let fill = |right: &mut Vector<L>, v: L, a: L, rates: &[L; MOST_STATES]| {
            right[0] = v;
            right[1] = a;
            right[2..2 + count].copy_from_slice(&rates[..count]);
        };
        fill(&mut right, y[1], a, &rates);
        right[pushed] = (dt * 0.5).mul_add(slope_t, right[pushed]);
        let k1 = solver.solve::<Q>(&right);
        // Work and friction are components like any other, only that nothing
        // depends on them.
        let ledger = Ledger::new::<Q>(segment, &partials, (f1, r1), y[1], per_dt * 2.0);
        let (power1, rubbing1) = (f1 * y[1], r1 * y[1]);
        let power_t = force_t * (y[1] * dt);
        let w1 = ledger.solve::<Q>((power1 + power_t * 0.5, rubbing1), &k1);
        // Stage 2: the same f + 4/dt k1 + 3/2 dt f_t.
        fill(&mut right, y[1], a, &rates);
        right[pushed] = (dt * 1.5).mul_add(slope_t, right[pushed]);
        for (right, k1) in right.iter_mut().zip(&k1) {
            *right = (per_dt * 4.0).mul_add(*k1, *right);
        }
        let k2 = solver.solve::<Q>(&right);
        let with = |base: (L, L), sum: (L, L)| (base.0 + sum.0, base.1 + sum.1);
        let times = |w: (L, L), by: L| (w.0 * by, w.1 * by);
        let w2 = ledger
            .solve::<Q>(with((power1 + power_t * 1.5, rubbing1), times(w1, per_dt * 4.0)), &k2);
        // Stage 3 at y + 2 k1.
        let mut at = y;
        for (at, k1) in at.iter_mut().zip(&k1) {
            *at = *at + *k1 * 2.0;
        }
        let later = state.t + dt;
        let (a, rates, f3, r3) = self.rates(segment, &law, later, &state.clock, &at);
        fill(&mut right, at[1], a, &rates);
        for i in 0..right.len() {
            right[i] = per_dt.mul_add(k1[i] - k2[i], right[i]);
        }
        let k3 = solver.solve::<Q>(&right);
        let back = times((w1.0 - w2.0, w1.1 - w2.1), per_dt);
        let w3 = ledger.solve::<Q>(with((f3 * at[1], r3 * at[1]), back), &k3);
        // Stage 4 at y + 2 k1 + k3.
        for (at, k3) in at.iter_mut().zip(&k3) {
            *at = *at + *k3;
        }
        let (a, rates, f4, r4) = self.rates(segment, &law, later, &state.clock, &at);
        fill(&mut right, at[1], a, &rates);
        for i in 0..right.len() {
            right[i] = per_dt.mul_add(k1[i] - k2[i] - k3[i] * (8.0 / 3.0), right[i]);
        }
        let k4 = solver.solve::<Q>(&right);
        let (work, heat) = if energy {
            let back = with(back, times(w3, per_dt * (-8.0 / 3.0)));
            let w4 = ledger.solve::<Q>(with((f4 * at[1], r4 * at[1]), back), &k4);
            (w1.0 * 2.0 + w3.0 + w4.0, w1.1 * 2.0 + w3.1 + w4.1)
        } else {
            (zero, zero)
        };
        let mut z = [zero; MOST_STATES];
        let mut error = zero;
        for i in 0..2 + count {
            let new = at[i] + k4[i];
            let scale = scale::<Q, L>(segment.tolerance, i, y[i], new);
            error = error.max((k4[i] / scale).abs());
            at[i] = new;
        }
        z[..count].copy_from_slice(&at[2..2 + count]);
        let error = L::select(error.not_nan(), error, zero.splat(f64::INFINITY));
        Step { x: at[0], v: at[1], z, work, heat, error }
    }
}

/// Size of an error that just passes.
#[inline(always)]
fn scale<Q: Bristle, L: Lane>(tolerance: L, i: usize, from: L, to: L) -> L {
    let floor = match i {
        0 => 1e-6,
        1 => 1e-4,
        _ => Q::FLOORS[i - 2],
    };
    tolerance * (from.abs().max(to.abs()) + floor)
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
