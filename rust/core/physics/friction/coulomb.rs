//! Coulomb friction.

use super::{Contact, Dry, Given, Law, LawInfo, Place, Worked};
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
        worked: Worked {
            given: &[("mu_coulomb", 0.35), ("mass", 1.0), ("gravity", 12.0)],
            speed: 0.5,
            force: 4.2,
            ..Worked::NONE
        },
    };
    type Set<L: Lane> = L;

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, _: &impl Given<L>) -> L {
        contact.coulomb
    }
}

impl Dry for Coulomb {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(set: &L, _: L, _: &Place<L>) -> L {
        *set
    }
    #[inline(always)]
    fn holding<L: Lane>(set: &L, _: &Place<L>) -> L {
        *set
    }
    #[inline(always)]
    fn linear<L: Lane>(set: &L, place: &Place<L>) -> (L, L) {
        (*set, place.x.with(0.0))
    }
}
