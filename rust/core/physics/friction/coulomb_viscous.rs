//! Coulomb friction with a viscous part.

use super::{Contact, Dry, Given, Law, LawInfo, Place, Worked};
use crate::lane::Lane;

/// Coulomb friction and a film of lubricant side by side.
pub struct CoulombViscous;

impl Law for CoulombViscous {
    const INFO: LawInfo = LawInfo {
        name: "coulomb_viscous",
        formula: r"F = F_C\,\mathrm{sgn}\,v + \mu_V v",
        source: "Morin 1833, Reynolds 1886; paper, equation (10) with the Coulomb term kept",
        limits: "no fall from static to sliding friction",
        meaning: "constant level and a part that grows with speed",
        params: &["mu_coulomb", "viscous"],
        worked: Worked {
            given: &[("mu_coulomb", 0.15), ("viscous", 0.5)],
            speed: 1.0,
            force: 0.15 * 0.271 * 9.81 + 0.5,
            ..Worked::NONE
        },
    };
    /// F_C and the viscous coefficient.
    type Set<L: Lane> = (L, L);

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, _: &impl Given<L>) -> (L, L) {
        (contact.coulomb, contact.viscous)
    }
}

impl Dry for CoulombViscous {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(set: &(L, L), speed: L, _: &Place<L>) -> L {
        set.1.mul_add(speed, set.0)
    }
    #[inline(always)]
    fn holding<L: Lane>(set: &(L, L), _: &Place<L>) -> L {
        set.0
    }
    #[inline(always)]
    fn linear<L: Lane>(set: &(L, L), _: &Place<L>) -> (L, L) {
        *set
    }
}
