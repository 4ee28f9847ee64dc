//! Coulomb friction with a viscous part.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
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
        reference: ReferenceValue {
            parameters: &[("mu_coulomb", 0.15), ("viscous", 0.5)],
            speed: 1.0,
            force: 0.15 * 0.271 * 9.81 + 0.5,
            ..ReferenceValue::NONE
        },
    };
    /// F_C and the viscous coefficient.
    type Coefficients<L: Lane> = (L, L);

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, _: &impl Parameters<L>) -> (L, L) {
        (contact.coulomb, contact.viscous)
    }
}

impl Dry for CoulombViscous {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(law: &(L, L), speed: L, _: &ContactState<L>) -> L {
        law.1.mul_add(speed, law.0)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &(L, L), _: &ContactState<L>) -> L {
        law.0
    }
    #[inline(always)]
    fn linear<L: Lane>(law: &(L, L), _: &ContactState<L>) -> (L, L) {
        *law
    }
}
