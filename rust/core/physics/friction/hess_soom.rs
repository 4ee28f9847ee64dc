//! The rational fall from static to Coulomb friction.

use super::fall::Fall;
use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;

pub struct HessSoom;

impl Law for HessSoom {
    const INFO: LawInfo = LawInfo {
        name: "hess_soom",
        formula: r"F = \left[F_C + \frac{F_S - F_C}{1 + (v/v_s)^2}\right]\mathrm{sgn}\,v + \mu_V v",
        source: "Hess and Soom 1990",
        limits: "falls slowly: a hundredth of the drop is left at ten times the Stribeck speed",
        meaning: "falls from static to Coulomb friction along a rational curve",
        params: &["mu_static", "mu_coulomb", "viscous", "stribeck_speed"],
        reference: ReferenceValue {
            // 4 + 4/1.25 + 2*0.25.
            parameters: &[
                ("mu_static", 0.8),
                ("mu_coulomb", 0.4),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("viscous", 2.0),
                ("stribeck_speed", 0.5),
            ],
            speed: 0.25,
            force: 7.7,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Fall<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Fall<L> {
        Fall::stribeck(contact, params)
    }
}

impl Dry for HessSoom {
    #[inline(always)]
    fn resistance<L: Lane>(law: &Fall<L>, speed: L, _: &ContactState<L>) -> L {
        let u = speed * law.per_speed;
        let share = speed.splat(1.0) / u.mul_add(u, speed.splat(1.0));
        law.with_share(share, speed)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Fall<L>, _: &ContactState<L>) -> L {
        law.break_away
    }
}
