//! Stretches in which nothing happens behind a joint: its motion is linear there, and one long
//! step as exact as the many in which events would be looked for.
//!
//! The joint swings around the force F that the two sides would have without it, by no more
//! than its energy allows: |force - F| <= k A + d B, where E = k A^2/2 = m B^2/2, and m is the
//! mass that swings: of the drive's side while the head rests, else the reduced one.

use super::{ElasticDrive, Now};
use crate::lane::Lane;
use crate::physics::effects::{Active, Variable};

/// Factor on what the swing and the motion could do, as viscous friction changes with the speed
/// and shifts what the joint swings around. Held by
/// `cargo test --release --test replay few_looks`, which fails by millimetres without a bound.
const MARGIN: f64 = 2.0;
/// Largest share of the speed that viscous friction may take meanwhile, far within `MARGIN`.
const MOST_FADE: f64 = 0.1;

/// Whether what holds the head stays what it is while it rests. The drive has to be steady, too.
pub(super) fn is_possible(active: Active) -> bool {
    let changes = |v| matches!(v, Some(Variable::Load | Variable::Time));
    !active.iter().any(|effect| changes(effect.info().variable))
}

impl<L: Lane, F> ElasticDrive<'_, '_, L, F> {
    /// Lanes in which nothing can happen for `left` seconds while the drive gives `drive`.
    #[inline(always)]
    pub(super) fn is_calm(&self, now: &Now<L>, t: L, left: L, drive: L) -> L::Mask {
        let zero = t.splat(0.0);
        let rates = &self.rates;
        let slides = zero.lt(now.direction.abs());
        let back = self.segment.pull_back(now.x);
        let per_mass = rates.per_mass;
        // What pulls the head back while it slides, and the inverse of the mass that swings.
        let level = self.level(now, now.direction, self.push(now), t);
        let viscous = rates.viscous * now.v / per_mass;
        let against = now.direction.mul_add(level, back + viscous);
        let per_swing = L::select(slides, rates.per_side + per_mass, rates.per_side);
        let pulls = L::select(slides, against * per_mass, zero);
        let middle = drive.mul_add(rates.per_side, pulls) / per_swing;
        let rate = L::select(slides, now.b - now.v, now.b);
        let off = self.depth(now) - middle / rates.stiffness;
        let energy = (rates.stiffness * off).mul_add(off, rate * rate / per_swing);
        let swing = (energy * rates.stiffness).sqrt() + rates.damping * (energy * per_swing).sqrt();
        let swing = swing * MARGIN;

        // The joint goes on to transmit, or in free flight not to.
        let joined = if self.is_gap { zero.lt(now.joined) } else { zero.le(zero) };
        let mut stays = zero.le(zero);
        let mut force = (middle.abs() + swing, (middle - back).abs() + swing);
        if self.is_gap {
            let touches = swing.lt(now.a.sign() * middle);
            let pace = (drive * rates.per_side).abs() + pulls.abs();
            let way = (pace * left).mul_add(left * 0.5, rate.abs() * left) * MARGIN;
            let flies = way.lt(self.gap - now.a.abs());
            stays = L::or(L::and(joined, touches), L::and(L::not(joined), flies));
            force = (L::select(joined, force.0, zero), L::select(joined, force.1, back.abs()));
        }

        // The head goes on to slide, or to rest.
        let slows = (force.0 + against.abs()) * per_mass * left * MARGIN;
        let goes_on = L::and(
            slows.lt(now.direction * now.v),
            (rates.viscous * left).lt(zero.splat(MOST_FADE)),
        );
        let still = Now { v: zero, sliding_distance: zero, ..*now };
        let one = zero.splat(1.0);
        let holds = self.holds(&still, one, zero, t).min(self.holds(&still, -one, zero, t));
        let rests = force.1.lt(holds);
        // While it slides, friction that bends is taken at the middle of short steps.
        let moves = if self.bent { zero.lt(zero) } else { L::and(slides, goes_on) };
        L::and(stays, L::or(moves, L::and(L::not(slides), rests)))
    }
}
