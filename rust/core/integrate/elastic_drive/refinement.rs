//! Steps that know their error, for friction and gravity that bend with the motion: an
//! exponential Runge-Kutta method of order four. What is linear is propagated exactly, what
//! bends enters as a parabola in time through its values at the start, the middle and the end
//! of a step (S. M. Cox, P. C. Matthews, Exponential time differencing for stiff systems,
//! Journal of Computational Physics 176, 2002, ETD4RK).

use super::one_step::Step;
use super::{ElasticDrive, Now};
use crate::State;
use crate::lane::Lane;
use crate::step_control::{MOST_GROWTH, MOST_SHRINK, SAFETY, cube_root};

/// Largest change of the speed that the parabola's bend makes in a step, m/s: the error of a
/// method of order two, far above the step's own. It sees what falls within a step, which a
/// difference of two high orders can miss. Set by `cargo test --release --test replay links`.
const SPEED_ERROR: f64 = 1e-6;
/// Largest change of the speed by what friction changes over a step with an event, m/s: friction
/// is taken as at the middle there. Set by the same command.
const EVENT_ERROR: f64 = 1e-7;
/// Shortest step that knows its error, s: a law that jumps has no short enough one. In it a newton
/// changes the speed of the paper's head by 7 um/s. Not derived.
const SHORTEST: f64 = 2e-6;
/// Errors below this are rounding, in shares of what is allowed.
const NO_ERROR: f64 = 1e-9;

/// Friction and gravity that bend with the motion.
#[derive(Clone, Copy)]
pub struct Bent<L> {
    /// Whether they may fall or kink within a small part of a step.
    pub steep: bool,
    /// Factor on the errors that a step may make.
    pub allowed: L,
    /// Longest way of a step, m: all values of one may miss a wave of friction along the track.
    pub stride: L,
}

/// Where a step leads, and what bends on the way.
struct Curve<L> {
    middle: Now<L>,
    end: Now<L>,
    /// Acceleration by friction and gravity at the start, the middle and the end.
    pulls: [L; 3],
}

impl<L: Lane, F> ElasticDrive<'_, '_, L, F> {
    /// Where a step leads by the parabola through three of its values.
    #[inline(always)]
    fn curve(
        &self,
        step: impl Step<L>,
        from: &Now<L>,
        (t, state): (L, &State<L>),
        dt: L,
    ) -> Curve<L> {
        let (half, part) = (dt * 0.5, step.half());
        let before = self.mean(t, half, state);
        let first = self.pull(from, t);
        let near = self.moved(part, from, (first, before), None);
        let early = self.pull(&near, t + half);
        let mut flat = dt.lt(dt);
        let mut plain = *from;
        if !self.bends.steep {
            // What hardly changes over half a step, and does not fall, is as good as its value in
            // the middle.
            flat = ((early - first).abs() * dt).le(self.bends.allowed * SPEED_ERROR);
            plain = self.moved(step, from, (early, self.mean(t, dt, state)), None);
            if !L::any(L::not(flat)) {
                return Curve { middle: near, end: plain, pulls: [first, early, early] };
            }
        }
        let after = self.mean(t + half, half, state);
        let middle = self.moved(part, from, (early, before), None);
        let late = self.pull(&middle, t + half);
        let far = self.moved(part, &near, (late * 2.0 - first, after), None);
        let last = self.pull(&far, t + dt);

        let midway = (early + late) * 0.5;
        let square = (first - midway * 2.0 + last) * 2.0;
        let rise = last - first - square;
        let swell = (after - before) * 2.0;
        let held = (first, (before + after - swell) * 0.5);
        let end = self.moved(step, from, held, Some([rise, square, swell]));
        let pulls = [first, L::select(flat, early, midway), L::select(flat, early, last)];
        Curve { middle: near.or(flat, middle), end: plain.or(flat, end), pulls }
    }

    /// Positive where what slides has passed zero or its contact has closed or would pull.
    #[inline(always)]
    fn turned(&self, now: &Now<L>) -> L {
        (-(now.direction * now.v)).max(self.touches(now))
    }

    /// Takes the lanes of `mask` whose step is short enough, and holds no event, over it, and
    /// keeps what the next one may reach. Returns the time that this took, and the lanes of
    /// which a plain step is good enough; all others are to try a shorter one.
    #[inline(always)]
    pub(super) fn refined(
        &mut self,
        step: impl Step<L>,
        mask: L::Mask,
        (t, state): (L, &State<L>),
        dt: L,
    ) -> (L, L::Mask) {
        let zero = dt.splat(0.0);
        self.release(mask, t);
        let slides = L::and(mask, zero.lt(self.now.direction.abs()));
        let slides = L::and(slides, zero.splat(SHORTEST).lt(dt));
        if !L::any(slides) {
            return (zero, mask);
        }
        let from = self.now;
        let Curve { middle, end, pulls: [first, midway, last] } =
            self.curve(step, &from, (t, state), dt);

        let one = zero.splat(1.0);
        let happens = zero.lt(self.turned(&end));
        let passes = L::and(zero.lt(self.turned(&middle)), L::not(happens));
        let change = (midway - first).abs().max((last - first).abs()) * dt;
        let bend = (first - midway * 2.0 + last).abs() * (dt * (1.0 / 6.0));
        let error = L::select(happens, change * (1.0 / EVENT_ERROR), bend * (1.0 / SPEED_ERROR));
        let error = error / self.bends.allowed;
        let way = dt * from.v.abs().max(end.v.abs()) / self.bends.stride;
        let long = L::or(L::or(one.lt(error), one.lt(way)), passes);
        let rough = L::and(slides, long);

        let share = cube_root(error).max(way).max(one * NO_ERROR);
        let factor = (one * SAFETY / share).max(one * MOST_SHRINK).min(one * MOST_GROWTH);
        // A stop is approached to a part of the way.
        let stops = (end.direction * end.v).lt(zero);
        let stop = from.v / (from.v - end.v) * SAFETY;
        let factor = L::select(stops, factor.min(stop.max(one * MOST_SHRINK)), factor);
        let touches = L::and(happens, L::not(stops));
        let factor = L::select(L::or(passes, touches), factor.min(one * 0.5), factor);
        let reach = dt * factor;
        // The last step before the end of a stretch is short for no error of its own.
        let reach = L::select(rough, reach.max(zero.splat(SHORTEST)), self.reach.max(reach));
        self.reach = L::select(slides, reach, self.reach).frozen();

        let taken = L::and(slides, L::not(L::or(rough, happens)));
        self.now = end.or(taken, from);
        (L::select(taken, dt, zero), L::and(mask, L::not(L::or(rough, taken))))
    }
}
