//! Static and Coulomb friction as two separate levels.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
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
        reference: ReferenceValue {
            parameters: &[
                ("mu_static", 0.5),
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 12.0),
            ],
            speed: 0.5,
            force: 4.2,
            ..ReferenceValue::NONE
        },
    };
    /// F_S and F_C.
    type Coefficients<L: Lane> = (L, L);

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, _: &impl Parameters<L>) -> (L, L) {
        (contact.break_away, contact.coulomb)
    }
}

impl Dry for StaticCoulomb {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(law: &(L, L), _: L, _: &ContactState<L>) -> L {
        law.1
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &(L, L), _: &ContactState<L>) -> L {
        law.0
    }
    #[inline(always)]
    fn linear<L: Lane>(law: &(L, L), at: &ContactState<L>) -> (L, L) {
        (law.1, at.x.splat(0.0))
    }
}
