//! What laws that fall from static to Coulomb friction share.

use super::{Contact, Parameters};
use crate::lane::Lane;
use crate::lane::exp::exp;
use crate::params::ParamId;

/// Levels of a dry law between which a share of the drop remains.
#[derive(Clone, Copy)]
pub struct Fall<L> {
    coulomb: L,
    pub(super) break_away: L,
    drop: L,
    viscous: L,
    /// One over the speed of the fall.
    pub(super) per_speed: L,
}

impl<L: Lane> Fall<L> {
    #[inline(always)]
    pub(super) fn of(contact: &Contact<L>, per_speed: L) -> Self {
        Fall {
            coulomb: contact.coulomb,
            break_away: contact.break_away,
            drop: contact.break_away - contact.coulomb,
            viscous: contact.viscous,
            per_speed,
        }
    }

    /// With the Stribeck speed.
    #[inline(always)]
    pub(super) fn stribeck(contact: &Contact<L>, params: &impl Parameters<L>) -> Self {
        let speed = params.get(ParamId::StribeckSpeed);
        Fall::of(contact, speed.splat(1.0) / speed)
    }

    /// Resistance where `share` of the drop from static to Coulomb remains.
    #[inline(always)]
    pub(super) fn with_share(&self, share: L, speed: L) -> L {
        self.viscous.mul_add(speed, self.drop.mul_add(share, self.coulomb))
    }

    /// Resistance of the exponential fall, smooth through zero for a trial step
    /// and bounded where one goes far below.
    #[inline(always)]
    pub(super) fn exponential(&self, speed: L) -> L {
        let u = (speed * self.per_speed).max(speed.splat(-1.0));
        self.with_share(exp(-u), speed)
    }
}

/// A contact without load slides on a nanonewton: bristle laws divide by the
/// level.
const LEAST_LEVEL: f64 = 1e-9;

/// Bell-shaped steady friction g(v) of the bristle laws.
#[derive(Clone, Copy)]
pub struct Bell<L> {
    coulomb: L,
    drop: L,
    per_speed: L,
}

impl<L: Lane> Bell<L> {
    #[inline(always)]
    pub(super) fn of(contact: &Contact<L>, params: &impl Parameters<L>) -> Self {
        let speed = params.get(ParamId::StribeckSpeed);
        Bell {
            coulomb: contact.coulomb,
            drop: contact.break_away - contact.coulomb,
            per_speed: speed.splat(1.0) / speed,
        }
    }

    /// g and dg/dv.
    #[inline(always)]
    pub(super) fn level(&self, v: L) -> (L, L) {
        let u = v * self.per_speed;
        let fall = self.drop * exp(-(u * u));
        (at_least(fall + self.coulomb), (fall * u) * (self.per_speed * -2.0))
    }

    /// The lowest g over all speeds.
    #[inline(always)]
    pub(super) fn lowest(&self) -> L {
        at_least(self.coulomb + self.drop.min(self.drop.splat(0.0)))
    }
}

#[inline(always)]
pub(super) fn at_least<L: Lane>(level: L) -> L {
    level.max(level.splat(LEAST_LEVEL))
}

/// 1 or -1, never 0: forward at rest.
#[inline(always)]
pub(super) fn sign<L: Lane>(v: L) -> L {
    L::select(v.lt(v.splat(0.0)), v.splat(-1.0), v.splat(1.0))
}
