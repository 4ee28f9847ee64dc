//! The drive's side of a joint along a measured motion of the head: what it passes on of the
//! drive's impulse, from sample to sample. Contacts of a gap are taken as rigid and without
//! rebound; an oscillation that samples do not resolve dies out.

use crate::lane::Lane;
use crate::physics::effects::Joint;

/// Relative position and speed of the drive's side, and the side of a gap that it touches,
/// 0 in free flight.
pub struct DrivenSide<L> {
    joint: Joint<L>,
    gap: L,
    speed: L,
    side: L,
}

/// Diagonal of the method's stages: of second order, and oscillations too fast for it decay.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

impl<L: Lane> DrivenSide<L> {
    /// A spring starts loaded by the first force, a gap in its middle.
    #[inline(always)]
    pub fn new(joint: Joint<L>, first: L) -> Self {
        let zero = first.splat(0.0);
        let gap = if joint.is_spring { first / joint.stiffness } else { zero };
        DrivenSide { joint, gap, speed: zero, side: zero }
    }

    /// Impulse on the head over `dt`, in which the drive gives `impulse` and the head's speed
    /// rises by `rise`.
    #[inline(always)]
    pub fn pass_on(&mut self, impulse: L, rise: f64, dt: f64) -> L {
        let before = self.speed;
        // Acceleration of the drive's side beside the head without a joint.
        let pull = (impulse / self.joint.mass - impulse.splat(rise)) * (1.0 / dt);
        if self.joint.is_spring {
            self.stretch(pull, dt);
        } else {
            self.cross(pull, dt);
        }
        impulse - self.joint.mass * (self.speed - before + rise)
    }

    /// Two stages of the diagonally implicit method, stiffly accurate.
    #[inline(always)]
    fn stretch(&mut self, pull: L, dt: f64) {
        let rest = pull.splat((1.0 - GAMMA) * dt);
        let h = pull.splat(GAMMA * dt);
        let (g, v) = (self.gap, self.speed);
        let (g1, v1) = self.stage(pull, GAMMA * dt, (g, v));
        let (g, v) = (g1.mul_add(rest, g), v1.mul_add(rest, v));
        let (g2, v2) = self.stage(pull, GAMMA * dt, (g, v));
        self.gap = g2.mul_add(h, g);
        self.speed = v2.mul_add(h, v);
    }

    /// Slopes of gap and speed at the end of a stage of length `h` that begins at (gap, speed).
    #[inline(always)]
    fn stage(&self, pull: L, h: f64, (gap, speed): (L, L)) -> (L, L) {
        let one = pull.splat(1.0);
        let per_mass = one / self.joint.mass;
        let (k, d) = (self.joint.stiffness * per_mass, self.joint.damping * per_mass);
        let bottom = one / ((k * h + d) * h + 1.0);
        let rate = (pull - k * speed.mul_add(pull.splat(h), gap) - d * speed) * bottom;
        (rate.mul_add(pull.splat(h), speed), rate)
    }

    /// Rest on a side, or flight until it touches the one that it comes to first.
    #[inline(always)]
    fn cross(&mut self, pull: L, dt: f64) {
        let zero = pull.splat(0.0);
        let whole = pull.splat(dt);
        let rests = zero.lt(self.side * pull);
        let (ahead, behind) = (self.touch(pull, 1.0), self.touch(pull, -1.0));
        let touches = L::and(ahead.min(behind).le(whole), L::not(rests));
        let side = L::select(ahead.le(behind), pull.splat(1.0), pull.splat(-1.0));
        let speed = pull.mul_add(whole, self.speed);
        let gap = (self.speed + speed).mul_add(whole * 0.5, self.gap);
        let stays = L::or(rests, touches);
        self.side = L::select(rests, self.side, L::select(touches, side, zero));
        self.gap = L::select(stays, self.side * self.joint.gap, gap);
        self.speed = L::select(stays, zero, speed);
    }

    /// Time until it touches a side of the gap, infinite if it does not.
    #[inline(always)]
    fn touch(&self, pull: L, side: f64) -> L {
        let zero = pull.splat(0.0);
        // What is left of the way is side (v t + pull t^2/2).
        let left = (self.joint.gap - self.gap * side).max(zero);
        let (v, a) = (self.speed * side, pull * side);
        let square = v.mul_add(v, a * left * 2.0);
        let bottom = v + square.max(zero).sqrt();
        let comes = L::and(zero.le(square), zero.lt(bottom));
        // What already touches and moves away, or is pushed away, does not touch again.
        let leaves = L::and(left.le(zero), L::or(v.lt(zero), a.le(zero)));
        L::select(L::and(comes, L::not(leaves)), (left * 2.0) / bottom, zero.splat(f64::INFINITY))
    }
}
