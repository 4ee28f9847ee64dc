//! A skin of scales or bristles that slides forward more easily than backward.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::params::ParamId;

pub struct Directional;

#[derive(Clone, Copy)]
pub struct Skin<L> {
    contact: Contact<L>,
    ratio: L,
}

/// The level of `direction` (1 or -1).
#[inline(always)]
pub fn directed<L: Lane>(direction: L, forward: L, backward: L) -> L {
    L::select(direction.lt(direction.splat(0.0)), backward, forward)
}

impl<L: Lane> Skin<L> {
    #[inline(always)]
    fn against(&self, level: L, at: &ContactState<L>) -> L {
        directed(at.direction, level, level * self.ratio)
    }
}

impl Law for Directional {
    const INFO: LawInfo = LawInfo {
        name: "directional",
        formula: r"F = F_C + \mu_V v \text{ forward},\quad F = -\rho F_C + \mu_V v \text{ backward},\quad -\rho F_S \le F \le F_S \text{ at rest}",
        source: "Miller 1988 (snakes); Gidoni, Noselli and DeSimone 2014 (crawlers)",
        limits: "the same ratio at rest and in motion; no fall with speed",
        meaning: "levels that differ between forward and backward",
        params: &["mu_static", "mu_coulomb", "viscous", "skin_ratio"],
        reference: ReferenceValue {
            // -(3*0.35*12 + 0.5*2).
            parameters: &[
                ("mu_static", 0.5),
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 12.0),
                ("viscous", 0.5),
                ("skin_ratio", 3.0),
            ],
            speed: -2.0,
            force: -13.6,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Skin<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Skin<L> {
        Skin { contact: *contact, ratio: params.get(ParamId::SkinRatio) }
    }
}

impl Dry for Directional {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(law: &Skin<L>, speed: L, at: &ContactState<L>) -> L {
        law.contact.viscous.mul_add(speed, law.against(law.contact.coulomb, at))
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Skin<L>, at: &ContactState<L>) -> L {
        law.against(law.contact.break_away, at)
    }
    #[inline(always)]
    fn linear<L: Lane>(law: &Skin<L>, at: &ContactState<L>) -> (L, L) {
        (law.against(law.contact.coulomb, at), law.contact.viscous)
    }
}
