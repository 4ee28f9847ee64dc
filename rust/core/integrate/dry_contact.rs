//! A segment on dry ground: how it accelerates while it slides, and whether and
//! when friction gives way while it rests.

use super::State;
use super::event_location::rise;
use crate::lane::Lane;
use crate::physics::friction::{ContactState, Dry};
use crate::physics::segment::Segment;

/// A dry law with its coefficients, as integrators meet it. Laws come behind `dyn`, so
/// that an integrator is compiled once for all of them: what they are asked is a whole
/// step, or what was a call of its own anyway, and the pointer costs nothing beside it.
pub trait DryContact<L: Lane> {
    /// See `Dry::PLACED`.
    fn placed(&self) -> bool;

    /// See `Dry::ages`.
    fn ages(&self) -> bool;

    /// One Runge-Kutta step of sliding from `state`.
    fn slide(&self, segment: &Segment<L>, state: &State<L>, dt: L, energy: bool) -> Slide<L>;

    /// Force that friction would have to hold at rest, and by how much it
    /// exceeds what it can.
    fn excess(&self, segment: &Segment<L>, state: &State<L>, t: L) -> (L, L);
}

/// The same for methods that take plain numbers stage by stage.
pub trait PlainContact {
    fn placed(&self) -> bool;

    /// Acceleration, drive force and resistance while it slides.
    fn slope(
        &self,
        segment: &Segment<f64>,
        state: &State<f64>,
        at: (f64, f64, f64),
    ) -> (f64, f64, f64);

    /// See `DryContact::excess`.
    fn excess(&self, segment: &Segment<f64>, state: &State<f64>, t: f64) -> (f64, f64);
}

/// The end of a step, and what was done on the way.
#[derive(Clone, Copy)]
pub struct Slide<L> {
    pub x: L,
    pub v: L,
    /// Accelerations at both ends.
    pub start: L,
    pub end: L,
    pub work: L,
    pub heat: L,
    /// How far the speed lies from that of the embedded third-order solution, which takes
    /// the fifth slope in place of the fourth.
    pub error: L,
}

/// The coefficients of law `Q`.
pub struct Bound<Q: Dry, L: Lane>(pub Q::Coefficients<L>);

impl<Q: Dry, L: Lane> Bound<Q, L> {
    #[inline(always)]
    fn contact_state(
        &self,
        state: &State<L>,
        direction: L,
        x: L,
        drive: L,
        t: L,
    ) -> ContactState<L> {
        let forward = (x - state.x).max(x.splat(0.0));
        let sliding_distance =
            if Q::PLACED { state.sliding_distance + forward } else { state.sliding_distance };
        ContactState { direction, x, sliding_distance, drive, t }
    }

    /// Acceleration, drive force and resistance on lanes that slide, under what the drive
    /// gives without the spring.
    #[inline(always)]
    fn slope(
        &self,
        segment: &Segment<L>,
        state: &State<L>,
        (t, x, v): (L, L, L),
        drive: L,
    ) -> (L, L, L) {
        let force = segment.with_spring(drive, t, x, v);
        let contact_state = self.contact_state(state, state.direction, x, force, t);
        let against = Q::resistance(&self.0, state.direction * v, &contact_state);
        let net = force - segment.pull_back(x) - state.direction * against;
        (net * segment.per_mass, force, against)
    }

    #[inline(always)]
    fn excess_here(&self, segment: &Segment<L>, state: &State<L>, t: L) -> (L, L) {
        let zero = t.splat(0.0);
        let force = segment.force(t, &state.clock, state.x, zero);
        let push = force - segment.pull_back(state.x);
        let contact_state = ContactState {
            direction: push.sign(),
            x: state.x,
            sliding_distance: zero,
            drive: force,
            t,
        };
        let holds = Q::break_away(&self.0, &contact_state);
        let holds = holds.max(Q::resistance(&self.0, zero, &contact_state));
        (push, push.abs() - holds)
    }

    #[inline(always)]
    fn slide_here(&self, segment: &Segment<L>, state: &State<L>, dt: L, energy: bool) -> Slide<L> {
        let half = dt * 0.5;
        let sixth = dt * (1.0 / 6.0);
        let zero = dt.splat(0.0);
        let (x0, v0) = (state.x, state.v);
        let (mut a, mut u) = (zero, v0);
        let (mut x, mut v) = (x0, v0);
        let (mut start, mut sum_a, mut sum_v) = (zero, zero, zero);
        let (mut work, mut heat) = (zero, zero);
        let mut fourth = zero;
        let steady = segment.drive.is_steady();
        let mut drive = segment.commanded(state.t, &state.clock);
        // The fifth slope is the one after the step, for the cubics; that of the
        // fourth stage lies an order lower.
        for stage in 0..5 {
            let reach = if stage == 0 {
                zero
            } else if stage < 3 {
                half
            } else {
                dt
            };
            if stage < 4 {
                v = reach.mul_add(a, v0);
                x = reach.mul_add(u, x0);
            } else {
                v = sixth.mul_add(sum_a, v0);
                x = sixth.mul_add(sum_v, x0);
            }
            let t = state.t + reach;
            // The other stages share the time of the one before.
            if !steady && (stage == 1 || stage == 3) {
                drive = segment.commanded(t, &state.clock);
            }
            let (slope, force, against) = self.slope(segment, state, (t, x, v), drive);
            (a, u) = (slope, v);
            if stage == 0 {
                start = a;
            }
            if stage == 3 {
                fourth = a;
            }
            if stage < 4 {
                let weight = dt.splat(if stage == 1 || stage == 2 { 2.0 } else { 1.0 });
                sum_a = a.mul_add(weight, sum_a);
                sum_v = v.mul_add(weight, sum_v);
                if energy {
                    work = (force * v).mul_add(weight, work);
                    heat = (against * v).mul_add(weight, heat);
                }
            }
        }
        let (work, heat) = (sixth * work, state.direction * (sixth * heat));
        let error = (sixth * (fourth - a)).abs();
        Slide { x, v, start, end: a, work, heat, error }
    }
}

impl<Q: Dry, L: Lane> DryContact<L> for Bound<Q, L> {
    #[inline(always)]
    fn placed(&self) -> bool {
        Q::PLACED
    }

    #[inline(always)]
    fn ages(&self) -> bool {
        Q::ages(&self.0)
    }

    #[inline(always)]
    fn slide(&self, segment: &Segment<L>, state: &State<L>, dt: L, energy: bool) -> Slide<L> {
        dt.outlined(
            #[inline(always)]
            || self.slide_here(segment, state, dt, energy),
        )
    }

    #[inline(always)]
    fn excess(&self, segment: &Segment<L>, state: &State<L>, t: L) -> (L, L) {
        t.outlined(
            #[inline(always)]
            || self.excess_here(segment, state, t),
        )
    }
}

impl<Q: Dry> PlainContact for Bound<Q, f64> {
    fn placed(&self) -> bool {
        Q::PLACED
    }

    fn slope(
        &self,
        segment: &Segment<f64>,
        state: &State<f64>,
        at: (f64, f64, f64),
    ) -> (f64, f64, f64) {
        Bound::slope(self, segment, state, at, segment.commanded(at.0, &state.clock))
    }

    fn excess(&self, segment: &Segment<f64>, state: &State<f64>, t: f64) -> (f64, f64) {
        self.excess_here(segment, state, t)
    }
}

/// Width about a peak, as a share of a look, in which a second parabola follows it.
const NARROW: f64 = 1.0 / 16.0;
/// How far below zero a peak may seem, as a share of the first parabola's bend, to be
/// followed further. Over an eighth of a period of a sine the seeming peak lies at most
/// 3e-4 of the bend below the true one.
const SEEMING: f64 = 1e-2;

/// Time from `from` until friction gives way within the next `left` seconds and the
/// direction then; all of `left` and 0 where it holds. `excess_at` is `excess` over time,
/// `looks` the number of equal parts in each of which it has one peak at the most.
#[inline(always)]
pub fn wait<L: Lane>(
    from: L,
    left: L,
    (locate, looks): (bool, L),
    excess_at: impl Fn(L) -> (L, L),
) -> (L, L) {
    let zero = left.splat(0.0);
    if !locate {
        // Seen at the end of the step only: the next one starts with it.
        return (left, zero);
    }
    let one = left.splat(1.0);
    if !L::any(one.lt(looks)) {
        return look(from, left, &excess_at);
    }
    let part = left / looks;
    let (mut wait, mut direction) = (left, zero);
    let mut done = zero;
    let mut open = zero.lt(looks);
    while L::any(open) {
        let start = done * part;
        let (within, way) = look(from + start, part, &excess_at);
        let breaks = L::and(open, zero.lt(way.abs()));
        wait = L::select(breaks, start + within, wait);
        direction = L::select(breaks, way, direction);
        done = done + one;
        open = L::and(L::and(open, L::not(breaks)), done.lt(looks));
    }
    (wait.min(left), direction)
}

/// By how much the push exceeds what holds at a share of a time from its start on.
#[inline(always)]
fn excess<L: Lane>(at: &impl Fn(L) -> (L, L), (from, left): (L, L), share: L) -> L {
    at(from + left * share).1
}

/// A wait with one look: at its ends, its middle and a peak between.
#[inline(always)]
fn look<L: Lane>(from: L, left: L, excess_at: &impl Fn(L) -> (L, L)) -> (L, L) {
    let zero = left.splat(0.0);
    let part = (from, left);
    let one = left.splat(1.0);
    let end = excess(excess_at, part, one);
    let (start, half) = (excess(excess_at, part, zero), excess(excess_at, part, one * 0.5));
    // A peak between the ends, from the parabola through three points.
    let bend = start + end - half * 2.0;
    let tilt = end - start;
    let peak = L::select(bend.lt(zero), (tilt / bend) * -0.25 + 0.5, one);
    let inside = L::and(zero.lt(peak), peak.lt(one));
    let mut peak = L::select(inside, peak, one);
    let mut at_peak = excess(excess_at, part, peak);
    let seeming = L::and((bend * SEEMING).lt(at_peak), L::not(zero.lt(at_peak)));
    let near = L::and(inside, seeming);
    if L::any(near) {
        let (before, after) =
            (excess(excess_at, part, peak - NARROW), excess(excess_at, part, peak + NARROW));
        let bend = before + after - at_peak * 2.0;
        let better = peak - ((after - before) / bend) * (0.5 * NARROW);
        let usable = L::and(L::and(zero.lt(better), better.lt(one)), bend.lt(zero));
        let better = L::select(L::and(near, usable), better, peak);
        let at_better = excess(excess_at, part, better);
        let higher = at_peak.lt(at_better);
        peak = L::select(higher, better, peak);
        at_peak = L::select(higher, at_better, at_peak);
    }
    let reach = L::select(zero.lt(at_peak), peak, one);
    let breaks = L::or(zero.lt(end), zero.lt(at_peak));
    if !L::any(breaks) {
        return (left, zero);
    }
    let theta = rise(
        reach,
        #[inline(always)]
        |theta| excess(excess_at, part, theta),
    );
    let wait = L::select(breaks, left * theta, left);
    let (push, _) = excess_at(from + wait);
    (wait, L::select(breaks, push.sign(), zero))
}
