//! What lubricant adds to the dry friction of a robot's segment: a level that
//! falls with the speed, and a heap that a segment moving forward pushes along.

use super::friction::{Parameters, share_left};
use super::params::ParamId;
use crate::lane::Lane;

/// Lubricant under a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lubricant<L> {
    /// 1: sliding friction falls from static to Coulomb with the speed; 0: at once.
    pub stribeck: L,
    /// One over the speed of the fall, s/m.
    pub per_speed: L,
    pub exponent: L,
    /// N/m.
    pub buildup: L,
    /// N/m^0.5.
    pub buildup_root: L,
    /// N s^2/m^2.
    pub snowplough: L,
}

impl<L: Lane> Lubricant<L> {
    #[inline(always)]
    pub fn of(params: &impl Parameters<L>) -> Lubricant<L> {
        let speed = params.get(ParamId::StribeckSpeed);
        Lubricant {
            stribeck: params.get(ParamId::StribeckTerm),
            per_speed: speed.splat(1.0) / speed,
            exponent: params.get(ParamId::StribeckExponent),
            buildup: params.get(ParamId::Buildup),
            buildup_root: params.get(ParamId::BuildupRoot),
            snowplough: params.get(ParamId::Snowplough),
        }
    }

    /// Where it changes friction at all.
    #[inline(always)]
    pub fn acts(&self) -> L::Mask {
        let zero = self.stribeck.splat(0.0);
        let heap = L::or(zero.lt(self.buildup), zero.lt(self.buildup_root));
        L::or(zero.lt(self.stribeck), L::or(heap, zero.lt(self.snowplough)))
    }

    /// Share of the drop from static to Coulomb friction that a sliding segment still
    /// meets.
    #[inline(always)]
    pub fn share(&self, speed: L) -> L {
        self.stribeck * share_left(speed.abs() * self.per_speed, self.exponent)
    }

    /// Resistance of the heap from `swept` metres of fresh ground, N.
    #[inline(always)]
    pub fn heap(&self, swept: L) -> L {
        self.buildup.mul_add(swept, self.buildup_root * swept.sqrt())
    }

    /// One lane.
    pub fn lane(&self, i: usize) -> Lubricant<f64> {
        Lubricant {
            stribeck: self.stribeck.lane(i),
            per_speed: self.per_speed.lane(i),
            exponent: self.exponent.lane(i),
            buildup: self.buildup.lane(i),
            buildup_root: self.buildup_root.lane(i),
            snowplough: self.snowplough.lane(i),
        }
    }
}
