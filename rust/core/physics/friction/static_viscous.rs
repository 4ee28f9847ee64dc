//! Static, Coulomb and viscous friction.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;

pub struct StaticViscous;

impl Law for StaticViscous {
    const INFO: LawInfo = LawInfo {
        name: "static_viscous",
        formula: r"F = F_C\,\mathrm{sgn}\,v + \mu_V v,\quad |F| \le F_S \text{ at rest}",
        source: "Morin 1833, Reynolds 1886",
        limits: "the fall from static to Coulomb friction takes no distance and no time",
        meaning: "constant level and a viscous part in motion, a higher level at rest",
        params: &["mu_static", "mu_coulomb", "viscous"],
        reference: ReferenceValue {
            parameters: &[("mu_static", 0.3), ("mu_coulomb", 0.15), ("viscous", 0.5)],
            speed: 1.0,
            force: 0.15 * 0.271 * 9.81 + 0.5,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Contact<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, _: &impl Parameters<L>) -> Contact<L> {
        *contact
    }
}

impl Dry for StaticViscous {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(law: &Contact<L>, speed: L, _: &ContactState<L>) -> L {
        law.viscous.mul_add(speed, law.coulomb)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Contact<L>, _: &ContactState<L>) -> L {
        law.break_away
    }
    #[inline(always)]
    fn linear<L: Lane>(law: &Contact<L>, _: &ContactState<L>) -> (L, L) {
        (law.coulomb, law.viscous)
    }
}
