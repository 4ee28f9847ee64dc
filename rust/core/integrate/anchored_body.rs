//! The anchored body under the reaction to the drive: dry friction and a force that
//! changes evenly over a step, so that stops and break-aways are roots of a quadratic.

use crate::lane::Lane;
use crate::physics::effects::Body;

/// The body of one trajectory per lane; levels and weight per mass.
pub struct AnchoredBody<L> {
    per_mass: L,
    weight: L,
    break_away: L,
    coulomb: L,
    /// Displacement since the start.
    pub x: L,
    v: L,
    /// Direction of sliding, 0 at rest.
    direction: L,
}

/// Stops and break-aways within a step under a force that changes evenly: it stops,
/// rests, breaks away the other way, and that is all; the rest is for rounding.
const MOST_EVENTS: usize = 8;

impl<L: Lane> AnchoredBody<L> {
    /// At rest.
    #[inline(always)]
    pub fn new(body: &Body<L>) -> Self {
        let zero = body.mass.splat(0.0);
        let per_mass = zero.splat(1.0) / body.mass;
        let coulomb = body.levels.coulomb * per_mass;
        AnchoredBody {
            per_mass,
            weight: body.weight * per_mass,
            break_away: (body.levels.break_away * per_mass).max(coulomb),
            coulomb,
            x: zero,
            v: zero,
            direction: zero,
        }
    }

    /// Takes it `dt` on while the drive force on the head goes evenly from `from` to `to`.
    #[inline(always)]
    pub fn advance(&mut self, dt: L, from: L, to: L) {
        let zero = dt.splat(0.0);
        let never = zero.splat(f64::INFINITY);
        // Acceleration without friction, and its rate.
        let mut push = -from.mul_add(self.per_mass, self.weight);
        let rate = L::select(zero.lt(dt), (from - to) * self.per_mass / dt, zero);
        let mut left = dt;
        for _ in 0..MOST_EVENTS {
            if !L::any(zero.lt(left)) {
                break;
            }
            let slides = zero.lt(self.direction.abs());
            let at_once = self.break_away.lt(push.abs());
            let reach = (rate.sign() * self.break_away - push) / rate;
            let wait = L::select(zero.lt(rate.abs()), reach.max(zero), never);
            let wait = L::select(at_once, zero, wait);
            let lasts = L::select(slides, self.time_to_stop(push, rate), wait);
            let ends = lasts.lt(left);
            let h = L::select(ends, lasts, left);

            let pull = push - self.direction * self.coulomb;
            let moved = (rate * (1.0 / 6.0)).mul_add(h, pull * 0.5).mul_add(h, self.v) * h;
            let v = (rate * 0.5).mul_add(h, pull).mul_add(h, self.v);
            self.x = L::select(slides, self.x + moved, self.x);
            self.v = L::select(L::and(slides, L::not(ends)), v, zero);
            push = rate.mul_add(h, push);
            left = left - h;

            let over = self.break_away.lt(push.abs());
            let turned = L::select(over, push.sign(), zero);
            let released = L::select(at_once, push.sign(), rate.sign());
            let next = L::select(slides, turned, released);
            self.direction = L::select(ends, next, self.direction);
        }
    }

    /// Until the speed passes zero; infinite where it does not.
    #[inline(always)]
    fn time_to_stop(&self, push: L, rate: L) -> L {
        let zero = push.splat(0.0);
        let speed = self.direction * self.v;
        let gain = self.direction * push - self.coulomb;
        // What has just broken away does not fall back by rounding.
        let gain = L::select(zero.lt(speed), gain, gain.max(zero));
        let bend = self.direction * rate;
        let square = gain.mul_add(gain, -(bend * speed * 2.0));
        let root = square.max(zero).sqrt();
        let falls = L::and(gain.lt(zero), zero.le(square));
        let turns = L::and(zero.le(gain), bend.lt(zero));
        let never = zero.splat(f64::INFINITY);
        let later = L::select(turns, -(gain + root) / bend, never);
        L::select(falls, speed * 2.0 / (root - gain), later)
    }
}
