//! Static and Coulomb friction as two separate levels.

use super::{Contact, Dry, Given, Law, LawInfo, Place, Worked};
use crate::lane::Lane;

pub struct StaticCoulomb;

impl Law for StaticCoulomb {
    const INFO: LawInfo = LawInfo {
        name: "static_coulomb",
        formula: r"F = F_C\,\mathrm{sgn}\,v,\quad |F| \le F_S \text{ at rest}",
        source: "Morin 1833",
        limits: "the fall from static to Coulomb friction takes no distance and no time",
        meaning: "constant level against the motion, a higher one at rest",
        params: &["mu_static", "mu_coulomb"],
        worked: Worked {
            given: &[("mu_static", 0.5), ("mu_coulomb", 0.35), ("mass", 1.0), ("gravity", 12.0)],
            speed: 0.5,
            force: 4.2,
            ..Worked::NONE
        },
    };
    /// F_S and F_C.
    type Set<L: Lane> = (L, L);

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, _: &impl Given<L>) -> (L, L) {
        (contact.holding, contact.coulomb)
    }
}

impl Dry for StaticCoulomb {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(set: &(L, L), _: L, _: &Place<L>) -> L {
        set.1
    }
    #[inline(always)]
    fn holding<L: Lane>(set: &(L, L), _: &Place<L>) -> L {
        set.0
    }
    #[inline(always)]
    fn linear<L: Lane>(set: &(L, L), place: &Place<L>) -> (L, L) {
        (set.1, place.x.with(0.0))
    }
}
