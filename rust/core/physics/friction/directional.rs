//! A skin of scales or bristles that slides forward more easily than backward.

use super::{Contact, Dry, Given, Law, LawInfo, Place, Worked};
use crate::lane::Lane;
use crate::params::ParamId;

pub struct Directional;

#[derive(Clone, Copy)]
pub struct Skin<L> {
    contact: Contact<L>,
    ratio: L,
}

/// The level of the direction `way` (1 or -1).
#[inline(always)]
pub fn directed<L: Lane>(way: L, forward: L, backward: L) -> L {
    L::select(way.lt(way.with(0.0)), backward, forward)
}

impl<L: Lane> Skin<L> {
    #[inline(always)]
    fn against(&self, level: L, place: &Place<L>) -> L {
        directed(place.way, level, level * self.ratio)
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
        worked: Worked {
            // -(3*0.35*12 + 0.5*2).
            given: &[
                ("mu_static", 0.5),
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 12.0),
                ("viscous", 0.5),
                ("skin_ratio", 3.0),
            ],
            speed: -2.0,
            force: -13.6,
            ..Worked::NONE
        },
    };
    type Set<L: Lane> = Skin<L>;

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, given: &impl Given<L>) -> Skin<L> {
        Skin { contact: *contact, ratio: given.get(ParamId::SkinRatio) }
    }
}

impl Dry for Directional {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(set: &Skin<L>, speed: L, place: &Place<L>) -> L {
        set.contact.viscous.mul_add(speed, set.against(set.contact.coulomb, place))
    }
    #[inline(always)]
    fn holding<L: Lane>(set: &Skin<L>, place: &Place<L>) -> L {
        set.against(set.contact.holding, place)
    }
    #[inline(always)]
    fn linear<L: Lane>(set: &Skin<L>, place: &Place<L>) -> (L, L) {
        (set.against(set.contact.coulomb, place), set.contact.viscous)
    }
}
