//! The rational fall from static to Coulomb friction.

use super::fall::Fall;
use super::{Contact, Dry, Given, Law, LawInfo, Place, Worked};
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
        worked: Worked {
            // 4 + 4/1.25 + 2*0.25.
            given: &[
                ("mu_static", 0.8),
                ("mu_coulomb", 0.4),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("viscous", 2.0),
                ("stribeck_speed", 0.5),
            ],
            speed: 0.25,
            force: 7.7,
            ..Worked::NONE
        },
    };
    type Set<L: Lane> = Fall<L>;

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, given: &impl Given<L>) -> Fall<L> {
        Fall::stribeck(contact, given)
    }
}

impl Dry for HessSoom {
    #[inline(always)]
    fn resistance<L: Lane>(set: &Fall<L>, speed: L, _: &Place<L>) -> L {
        let u = speed * set.per_speed;
        let share = speed.with(1.0) / u.mul_add(u, speed.with(1.0));
        set.with_share(share, speed)
    }
    #[inline(always)]
    fn holding<L: Lane>(set: &Fall<L>, _: &Place<L>) -> L {
        set.holding
    }
}
