//! Exact propagation: Coulomb and viscous friction, static friction and a drive
//! that is constant piece by piece.
//!
//! Within a piece the speed approaches its limit monotonously, so it passes zero
//! at most once, and then either rests or slides the other way until the piece
//! ends. Two legs per piece are therefore all there is, and no event can be
//! missed. With y = b t/m, v = v0 e^-y + (f t/m) E1(y) and
//! x = x0 + v0 t E1(y) + (f t^2/m) E2(y), smooth at b = 0.

use super::{Advance, MOST_STEPS, State, Tally};
use crate::lane::Lane;
use crate::lane::exp::motion_factors;
use crate::lane::log::ln_1p;
use crate::physics::friction::{ContactState, Dry};
use crate::physics::segment::Segment;

pub struct Exact<'a, 'b, C, L, F> {
    pub segment: &'b Segment<'a, L>,
    pub contact: &'b C,
    /// Whether to go on; asked once in a while.
    pub go_on: F,
}

/// Pieces between two looks at the flag that stops a run.
const PATIENCE: u32 = 256;

/// One stretch of sliding under a constant force.
#[derive(Clone, Copy)]
struct Leg<L> {
    dt: L,
    /// Force per mass, friction included, viscous part excluded.
    pull: L,
    /// b/m.
    rate: L,
    /// e^-y, E1(y) and E2(y).
    decay: L,
    e1: L,
    e2: L,
}

impl<L: Lane> Leg<L> {
    #[inline(always)]
    fn new(dt: L, pull: L, rate: L) -> Self {
        let (decay, e1, e2) = motion_factors(rate * dt);
        Leg { dt, pull, rate, decay, e1, e2 }
    }

    #[inline(always)]
    fn speed(&self, v: L) -> L {
        // Without a pull the speed only decays: it never turns by rounding.
        v.mul_add(self.decay, (self.pull * self.dt) * self.e1)
    }

    #[inline(always)]
    fn path(&self, v: L) -> L {
        self.dt * v.mul_add(self.e1, (self.pull * self.dt) * self.e2)
    }
}

impl<C: LinearContact<L>, L: Lane, F: FnMut() -> bool> Advance<L> for Exact<'_, '_, C, L, F> {
    #[inline(always)]
    fn advance(&mut self, state: &mut State<L>, tally: &mut Tally<L>, until: L) -> bool {
        let mut count = 0;
        while L::any(state.t.lt(until)) {
            let end = self.segment.drive.piece_end(state.clock.piece);
            let active = state.t.lt(until);
            let to = end.min(until);
            self.contact.piece(self.segment, state, tally, to);
            let over = L::and(active, end.le(to));
            self.segment.drive.turn_over(&mut state.clock, end, over);
            count += 1;
            tally.steps = L::select(active, tally.steps + 1.0, tally.steps);
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
        self.segment.drive.pieces(duration)
    }
}

/// A linear law with its coefficients, as the integrator meets it: a piece at a time.
/// Not behind `dyn`: a piece is too short to hide a call.
pub trait LinearContact<L: Lane> {
    /// To time `to` within one piece.
    fn piece(&self, segment: &Segment<L>, state: &mut State<L>, tally: &mut Tally<L>, to: L);
}

/// The coefficients of law `Q`.
pub struct Bound<Q: Dry, L: Lane>(pub Q::Coefficients<L>);

impl<Q: Dry, L: Lane> LinearContact<L> for Bound<Q, L> {
    #[inline(always)]
    fn piece(&self, segment: &Segment<L>, state: &mut State<L>, tally: &mut Tally<L>, to: L) {
        let zero = state.t.splat(0.0);
        let dt = (to - state.t).max(zero);
        let t = dt.mul_add(zero.splat(0.5), state.t);
        let drive = segment.drive.mean(state.t, dt, &state.clock).clip(segment.limit);
        let push = drive - segment.weight;
        // What has come to a stop at the end of the last piece is decided anew.
        let resting = L::not(zero.lt(state.v.abs()));
        let may_move = L::and(resting, zero.lt(dt));
        let mut direction = state.direction;
        if L::any(may_move) {
            direction = L::select(may_move, self.release(push, drive, state.x, state.t), direction);
        }
        let moving = zero.lt(direction.abs());
        let contact_state =
            ContactState { direction, x: state.x, sliding_distance: zero, drive, t };
        let (level, viscous) = Q::linear(&self.0, &contact_state);
        let rate = viscous * segment.per_mass;
        // At rest friction balances the push, whatever it is.
        let pull = L::select(moving, (push - direction * level) * segment.per_mass, zero);
        let leg = Leg::new(dt, pull, rate);
        let v = L::select(moving, leg.speed(state.v), zero);
        let turned = L::and(moving, (direction * v).lt(zero));
        let path = L::select(moving, leg.path(state.v), zero);
        if L::any(turned) {
            let turn = Turn { turned, direction, leg, v, path, drive, level };
            return zero.outlined(
                #[inline(always)]
                || self.turn(segment, state, tally, to, turn),
            );
        }
        let rested = L::select(moving, zero, dt);
        tally.stuck = tally.stuck + rested;
        let began = L::and(zero.lt(state.direction.abs()), L::not(moving));
        tally.sticks = L::select(began, tally.sticks + 1.0, tally.sticks);
        account(segment, state, tally, leg, v, path, drive, level);
        state.t = L::select(zero.lt(dt), to, state.t);
        state.direction = direction;
    }
}

impl<Q: Dry, L: Lane> Bound<Q, L> {
    /// Direction in which a force moves what is at rest, 0 if friction holds it.
    #[inline(always)]
    fn release(&self, push: L, drive: L, x: L, t: L) -> L {
        let direction = push.sign();
        let contact_state = ContactState { direction, x, sliding_distance: x.splat(0.0), drive, t };
        let (level, _) = Q::linear(&self.0, &contact_state);
        let holds = Q::break_away(&self.0, &contact_state).max(level);
        L::select(holds.lt(push.abs()), direction, x.splat(0.0))
    }

    /// The same where some lanes stop on the way.
    #[inline(always)]
    fn turn(
        &self,
        segment: &Segment<L>,
        state: &mut State<L>,
        tally: &mut Tally<L>,
        to: L,
        turn: Turn<L>,
    ) {
        let zero = state.t.splat(0.0);
        let one = zero.splat(1.0);
        let Turn { turned, direction, leg, v, path, drive, level } = turn;
        // tau = (v/-a) ln(1 + u)/u with u = (b/m) v/(-a).
        let brake = L::select(turned, -(state.v / leg.pull), zero);
        let u = (leg.rate * brake).max(zero);
        let whole = L::select(zero.lt(u), ln_1p(u) / u, one);
        let tau = (brake * whole).min(leg.dt);
        let first = Leg::new(tau, leg.pull, leg.rate);
        let stop = L::select(turned, first.path(state.v), path);
        let moving = zero.lt(direction.abs());
        let mid = L::select(turned, zero, v);
        let used = L::select(turned, tau, leg.dt);
        let first = Leg::new(used, leg.pull, leg.rate);
        let rested = L::select(moving, zero, leg.dt);
        account(segment, state, tally, first, mid, stop, drive, level);

        state.t = state.t + used;
        let push = drive - segment.weight;
        let released = self.release(push, drive, state.x, state.t);
        let rest = leg.dt - used;
        let t = rest.mul_add(zero.splat(0.5), state.t);
        let back =
            ContactState { direction: released, x: state.x, sliding_distance: zero, drive, t };
        let (level, viscous) = Q::linear(&self.0, &back);
        let pull = (push - released * level) * segment.per_mass;
        let goes = L::and(turned, zero.lt(released.abs()));
        let second = Leg::new(L::select(goes, rest, zero), pull, viscous * segment.per_mass);
        let v = L::select(goes, second.speed(zero), state.v);
        let path = L::select(goes, second.path(zero), zero);
        account(segment, state, tally, second, v, path, drive, level);
        let stays = L::and(turned, L::not(goes));
        tally.stuck = tally.stuck + L::select(stays, rest, rested);
        let began = L::and(zero.lt(state.direction.abs()), L::not(moving));
        let began = L::or(stays, began);
        tally.sticks = L::select(began, tally.sticks + 1.0, tally.sticks);
        state.direction = L::select(turned, released, direction);
        state.t = L::select(zero.lt(leg.dt), to, state.t);
    }
}

/// Takes a leg into state and tally.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn account<L: Lane>(
    segment: &Segment<L>,
    state: &mut State<L>,
    tally: &mut Tally<L>,
    leg: Leg<L>,
    v: L,
    path: L,
    drive: L,
    level: L,
) {
    let x = state.x + path;
    if tally.watch.stroke {
        let arrives = tally.arrives(segment, state.x, x);
        if L::any(arrives) {
            // The same for all laws: compiled once.
            let after = x.outlined(
                #[inline(always)]
                || arrival(segment, state, leg),
            );
            let when = state.t + after;
            tally.stroke_time = L::select(arrives, when, tally.stroke_time);
        }
    }
    if tally.watch.energy {
        let viscous = x.outlined(
            #[inline(always)]
            || viscous_heat(segment.mass, state.v, leg),
        );
        let heat = level.mul_add(path.abs(), viscous);
        tally.spend(drive * path, heat);
    }
    state.x = x;
    state.v = v;
    tally.look(x, v);
}

/// Time within the leg at which the stroke is complete.
#[inline(always)]
fn arrival<L: Lane>(segment: &Segment<L>, state: &State<L>, leg: Leg<L>) -> L {
    let left = segment.target - state.x;
    let zero = left.splat(0.0);
    let (mut low, mut high) = (zero, leg.dt);
    let mut t = leg.dt;
    // A lane that has settled stays, however long its neighbours take.
    let mut open = zero.le(zero);
    // Newton within a bracket that halves where Newton would leave it.
    for _ in 0..64 {
        let trial = Leg::new(t, leg.pull, leg.rate);
        let miss = trial.path(state.v) - left;
        let below = miss.lt(zero);
        low = L::select(below, t, low);
        high = L::select(below, high, t);
        let next = t - miss / trial.speed(state.v);
        let inside = L::and(low.lt(next), next.lt(high));
        let half = (low + high) * 0.5;
        let new = L::select(inside, next, half);
        let moved = (t.abs() * 1e-16).lt((new - t).abs());
        t = L::select(open, new, t);
        open = L::and(open, moved);
        if !L::any(open) {
            break;
        }
    }
    t
}

/// b times the integral of v^2 over a leg that begins at speed `v`.
///
/// With q = a t - y v0, v = v0 + q s E1(y s) along s from 0 to 1, so that
/// integral is v0^2 + 2 v0 q E2(y) + q^2 B(y) with
/// B = sum over n >= 2 of (-1)^n (2^n - 2) y^(n-2)/(n+1)!.
#[inline(always)]
fn viscous_heat<L: Lane>(mass: L, v: L, leg: Leg<L>) -> L {
    let zero = v.splat(0.0);
    let one = zero.splat(1.0);
    let y = leg.rate * leg.dt;
    let gain = leg.pull * leg.dt;
    let near = y.min(one);
    let mut sum = zero;
    for coefficient in SQUARES.iter().rev() {
        sum = sum.mul_add(near, zero.splat(*coefficient));
    }
    let q = (-near).mul_add(v, gain);
    let cross = (v * 2.0) * (q * leg.e2);
    let small = near * (q * q).mul_add(sum, v.mul_add(v, cross));
    // Beyond y = 1 from v = w + (v0 - w) e^-y with the limit w = a/rate.
    let far = y.max(one);
    let limit = gain / far;
    let gap = v - limit;
    let mix = (limit * gap) * 2.0;
    let fade = gap * gap * 0.5;
    let left = (one - leg.decay, one - leg.decay * leg.decay);
    let large = (limit * limit).mul_add(far, mix.mul_add(left.0, fade * left.1));
    mass * L::select(y.lt(one), small, large)
}

/// Coefficients of B; 24 of them leave less than 1e-17 at y = 1.
const SQUARES: [f64; 24] = {
    let mut coefficients = [0.0; 24];
    let (mut n, mut power, mut factorial, mut sign) = (2, 4.0, 6.0, 1.0);
    while n < 26 {
        coefficients[n - 2] = sign * (power - 2.0) / factorial;
        n += 1;
        power *= 2.0;
        factorial *= (n + 1) as f64;
        sign = -sign;
    }
    coefficients
};

struct Turn<L: Lane> {
    turned: L::Mask,
    direction: L,
    leg: Leg<L>,
    v: L,
    path: L,
    drive: L,
    level: L,
}
