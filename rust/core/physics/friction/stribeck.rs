//! The bell-shaped fall from static to Coulomb friction.

use super::fall::Fall;
use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::lane::exp::exp;

pub struct Stribeck;

impl Law for Stribeck {
    const INFO: LawInfo = LawInfo {
        name: "stribeck",
        formula: r"F = \left[F_C + (F_S - F_C)\,e^{-(v/v_s)^2}\right]\mathrm{sgn}\,v + \mu_V v",
        source: "Stribeck 1902; the bell shape after Armstrong-Helouvry 1991",
        limits: "sliding is unstable where the level falls faster than the viscous part rises",
        meaning: "falls from static to Coulomb friction along a bell curve",
        params: &["mu_static", "mu_coulomb", "viscous", "stribeck_speed"],
        reference: ReferenceValue {
            parameters: &[
                ("mu_static", 0.8),
                ("mu_coulomb", 0.4),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("stribeck_speed", 0.5),
                ("viscous", 2.0),
            ],
            speed: 0.25,
            force: 7.615_203_132_285_619,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Fall<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Fall<L> {
        Fall::stribeck(contact, params)
    }
}

impl Dry for Stribeck {
    #[inline(always)]
    fn resistance<L: Lane>(law: &Fall<L>, speed: L, _: &ContactState<L>) -> L {
        let u = speed * law.per_speed;
        law.with_share(exp(-(u * u)), speed)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Fall<L>, _: &ContactState<L>) -> L {
        law.break_away
    }
}
