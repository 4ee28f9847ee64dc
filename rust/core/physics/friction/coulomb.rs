//! Coulomb friction.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;

/// A constant level, at rest any force up to it.
pub struct Coulomb;

impl Law for Coulomb {
    const INFO: LawInfo = LawInfo {
        name: "coulomb",
        formula: r"F = F_C\,\mathrm{sgn}\,v,\quad |F| \le F_C \text{ at rest}",
        source: "Coulomb 1785; paper, equation (1)",
        limits: "no difference between rest and motion, no dependence on speed",
        meaning: "constant level against the motion",
        params: &["mu_coulomb"],
        reference: ReferenceValue {
            parameters: &[("mu_coulomb", 0.35), ("mass", 1.0), ("gravity", 12.0)],
            speed: 0.5,
            force: 4.2,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = L;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, _: &impl Parameters<L>) -> L {
        contact.coulomb
    }
}

impl Dry for Coulomb {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(law: &L, _: L, _: &ContactState<L>) -> L {
        *law
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &L, _: &ContactState<L>) -> L {
        *law
    }
    #[inline(always)]
    fn linear<L: Lane>(law: &L, at: &ContactState<L>) -> (L, L) {
        (*law, at.x.splat(0.0))
    }
}
