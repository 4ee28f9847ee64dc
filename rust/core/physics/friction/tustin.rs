//! The exponential fall from static to Coulomb friction.

use super::fall::Fall;
use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
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
        reference: ReferenceValue {
            // 4 + 4 e^-0.5 + 2*0.25.
            parameters: &[
                ("mu_static", 0.8),
                ("mu_coulomb", 0.4),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("viscous", 2.0),
                ("stribeck_speed", 0.5),
            ],
            speed: 0.25,
            force: 6.926_122_638_850_534,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Fall<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Fall<L> {
        Fall::stribeck(contact, params)
    }
}

impl Dry for Tustin {
    #[inline(always)]
    fn resistance<L: Lane>(law: &Fall<L>, speed: L, _: &ContactState<L>) -> L {
        law.exponential(speed)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Fall<L>, _: &ContactState<L>) -> L {
        law.break_away
    }
}
