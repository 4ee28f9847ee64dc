//! The exponential fall from static to Coulomb friction.

use super::fall::Fall;
use super::{Contact, Dry, Given, Law, LawInfo, Place, Worked};
use crate::lane::Lane;

pub struct Tustin;

impl Law for Tustin {
    const INFO: LawInfo = LawInfo {
        name: "tustin",
        formula: r"F = \left[F_C + (F_S - F_C)\,e^{-|v|/v_s}\right]\mathrm{sgn}\,v + \mu_V v",
        source: "Tustin 1947",
        limits: "steepest at rest: the least stable start of sliding of the Stribeck forms",
        meaning: "falls from static to Coulomb friction exponentially",
        params: &["mu_static", "mu_coulomb", "viscous", "stribeck_speed"],
        worked: Worked {
            // 4 + 4 e^-0.5 + 2*0.25.
            given: &[
                ("mu_static", 0.8),
                ("mu_coulomb", 0.4),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("viscous", 2.0),
                ("stribeck_speed", 0.5),
            ],
            speed: 0.25,
            force: 6.926_122_638_850_534,
            ..Worked::NONE
        },
    };
    type Set<L: Lane> = Fall<L>;

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, given: &impl Given<L>) -> Fall<L> {
        Fall::stribeck(contact, given)
    }
}

impl Dry for Tustin {
    #[inline(always)]
    fn resistance<L: Lane>(set: &Fall<L>, speed: L, _: &Place<L>) -> L {
        set.exponential(speed)
    }
    #[inline(always)]
    fn holding<L: Lane>(set: &Fall<L>, _: &Place<L>) -> L {
        set.holding
    }
}
