//! Steps that know their error, for friction that bends within a step: each is taken whole
//! and in two halves, and halved until both agree.

use super::propagation::HALVINGS;
use super::{ElasticDrive, Now};
use crate::State;
use crate::lane::Lane;
use crate::physics::effects::{Coefficients, Effect};

/// Largest difference of the speed between a whole step and its halves, m/s. Set by
/// `cargo test --release --test replay behind_links`: 1e-7 leaves up to a micrometre of the
/// position, this less than the plain integration does.
const SPEED_ERROR: f64 = 3e-8;
/// Longest way of a step as a share of the wavelength of friction along the track: whole and
/// halves may agree because both miss a wave. The same as without a link, `STRIDE` in
/// `replay.rs`, set there by `cargo test --test replay fast_waves`.
const STRIDE: f64 = 0.125;
/// Most halvings of a step: a law that jumps has no short enough one. Of a millisecond they
/// leave two microseconds, in which a newton changes the speed of the paper's head by 7 um/s.
const MOST_HALVINGS: usize = 9;
/// What half a step leaves of the difference, as one part in so many: it goes with the third
/// power.
const PER_HALVING: f64 = 8.0;

/// Whether friction changes so fast along the track, the speed or the oscillation of a joint
/// that usual steps are too long, or needlessly short.
pub(super) fn is_needed<L>(law: &Coefficients<L>, is_lag: bool) -> bool {
    let steep = [Effect::StribeckFriction, Effect::PositionDependentFriction];
    law.active.any(&steep) || !is_lag && law.active.has(Effect::LoadDependentFriction)
}

/// Longest way of a step.
pub(super) fn stride<L: Lane>(law: &Coefficients<L>) -> L {
    let waves = law.active.has(Effect::PositionDependentFriction);
    let like = law.per_length;
    if waves { (like.splat(STRIDE) / like).frozen() } else { like.splat(f64::INFINITY) }
}

/// Shortest level of steps that are tried in halves.
const LEAST: usize = HALVINGS as usize - MOST_HALVINGS;

impl<L: Lane, F> ElasticDrive<'_, '_, L, F> {
    /// Lanes that may take a step of a level. Motion at rest is exact, whatever the step.
    #[inline(always)]
    pub(super) fn reaches(&self, level: usize) -> L::Mask {
        let zero = self.reach.splat(0.0);
        let rests = self.now.direction.abs().le(zero);
        L::or(rests, zero.splat(level as f64).le(self.reach))
    }

    /// Takes the lanes of `mask` whose step of a level is short enough, and holds no event,
    /// over it, and keeps what the next one may reach. Returns the time that this took, and
    /// the lanes of which a plain step is good enough; all others are to try a shorter one.
    #[inline(always)]
    pub(super) fn refined(
        &mut self,
        level: usize,
        mask: L::Mask,
        (t, state): (L, &State<L>),
        dt: L,
    ) -> (L, L::Mask) {
        let zero = dt.splat(0.0);
        self.release(mask, t);
        let slides = L::and(mask, zero.lt(self.now.direction.abs()));
        if level < LEAST || !L::any(slides) {
            return (zero, mask);
        }
        let from = self.now;
        let half = dt * 0.5;
        let drive = self.mean(t, dt, state);
        let (whole, inputs) = self.midpoint(level, &from, (t, dt), drive);
        // Up to an event, friction is taken as at the middle.
        let bend = (inputs.0 - self.inputs(&from, &from, (t, dt), drive).0).abs() * dt;
        let drive = self.mean(t, half, state);
        let (middle, _) = self.midpoint(level - 1, &from, (t, half), drive);
        let drive = self.mean(t + half, half, state);
        let (halves, _) = self.midpoint(level - 1, &middle, (t + half, half), drive);
        let end = halves.beyond(&whole);

        let (own, touch) = self.overruns(&end, t + dt);
        let happens = zero.lt(own.max(touch));
        let allowed = zero.splat(SPEED_ERROR);
        let error = L::select(happens, bend, (halves.v - whole.v).abs());
        let way = dt * from.v.abs().max(whole.v.abs());
        let long = L::or(allowed.lt(error), self.stride.lt(way));
        let rough = if level > LEAST { L::and(slides, long) } else { zero.lt(zero) };

        let now = zero.splat(level as f64);
        let far = (allowed * PER_HALVING).lt(error);
        let cut = L::select(far, now - 2.0, now - 1.0).max(zero.splat(LEAST as f64));
        let smooth = L::and((error * PER_HALVING).le(allowed), (way * 2.0).le(self.stride));
        let grown = L::select(smooth, self.reach.max(now + 1.0), self.reach);
        let reach = L::select(rough, cut, grown);
        self.reach = L::select(slides, reach, self.reach).frozen();

        let taken = L::and(slides, L::not(L::or(rough, happens)));
        self.now = end.or(taken, from);
        (L::select(taken, dt, zero), L::and(mask, L::not(L::or(rough, taken))))
    }
}

impl<L: Lane> Now<L> {
    /// Where `self`, two steps of order two, and `whole`, one over the same time, point to.
    #[inline(always)]
    fn beyond(&self, whole: &Now<L>) -> Now<L> {
        Now {
            x: limit(self.x, whole.x),
            a: limit(self.a, whole.a),
            b: limit(self.b, whole.b),
            v: limit(self.v, whole.v),
            sliding_distance: limit(self.sliding_distance, whole.sliding_distance),
            ..*self
        }
    }
}

/// Limit of a number by two steps of order two and by one over the same time.
#[inline(always)]
fn limit<L: Lane>(halves: L, whole: L) -> L {
    (halves - whole).mul_add(halves.splat(1.0 / 3.0), halves)
}
