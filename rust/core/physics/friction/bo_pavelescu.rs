//! The fall with a free exponent.

use super::fall::Fall;
use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::lane::exp::exp;
use crate::lane::log::power;
use crate::params::ParamId;

pub struct BoPavelescu;

/// Share of the drop from static to Coulomb friction that is left at `u`, the speed
/// over the Stribeck speed; all of it below rest, where a trial step may look.
#[inline(always)]
pub fn share_left<L: Lane>(u: L, exponent: L) -> L {
    exp(-power(u.max(u.splat(0.0)), exponent))
}

impl Law for BoPavelescu {
    const INFO: LawInfo = LawInfo {
        name: "bo_pavelescu",
        formula: r"F = \left[F_C + (F_S - F_C)\,e^{-|v/v_s|^\delta}\right]\mathrm{sgn}\,v + \mu_V v",
        source: "Bo and Pavelescu 1982, who found exponents of 0.5 to 1",
        limits: "exponent and speed of the fall are hard to tell apart in data; below 1 infinitely steep at rest",
        meaning: "falls from static to Coulomb friction with a free exponent",
        params: &["mu_static", "mu_coulomb", "viscous", "stribeck_speed", "stribeck_exponent"],
        reference: ReferenceValue {
            // 4 + 4 e^-sqrt(0.5) + 2*0.25.
            parameters: &[
                ("mu_static", 0.8),
                ("mu_coulomb", 0.4),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("viscous", 2.0),
                ("stribeck_speed", 0.5),
                ("stribeck_exponent", 0.5),
            ],
            speed: 0.25,
            force: 6.472_274_765_580_959,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = (Fall<L>, L);

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> (Fall<L>, L) {
        (Fall::stribeck(contact, params), params.get(ParamId::StribeckExponent))
    }
}

impl Dry for BoPavelescu {
    #[inline(always)]
    fn resistance<L: Lane>(law: &(Fall<L>, L), speed: L, _: &ContactState<L>) -> L {
        law.0.with_share(share_left(speed * law.0.per_speed, law.1), speed)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &(Fall<L>, L), _: &ContactState<L>) -> L {
        law.0.break_away
    }
}
