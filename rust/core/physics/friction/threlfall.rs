//! Threlfall's exponential in place of the jump at rest.

use super::fall::sign;
use super::{Contact, Law, LawInfo, Parameters, ReferenceValue, Smooth};
use crate::lane::Lane;
use crate::lane::exp::exp_less_one;
use crate::params::ParamId;

pub struct Threlfall;

#[derive(Clone, Copy)]
pub struct Rise<L> {
    coulomb: L,
    viscous: L,
    per_transition: L,
}

impl Law for Threlfall {
    const INFO: LawInfo = LawInfo {
        name: "threlfall",
        formula: r"F = F_C \left(1 - e^{-3 \min(|v|/v_t, 1)}\right)\mathrm{sgn}\,v + \mu_V v",
        source: "Threlfall 1978",
        limits: "creeps; not normalised: beyond v_t it stays at 1 - e^-3 = 0.950213 of the Coulomb level, where some authors jump to the whole; kink at v_t",
        meaning: "Coulomb friction that rises exponentially from zero",
        params: &["mu_coulomb", "viscous", "transition_speed"],
        reference: ReferenceValue {
            // 1 - e^-3u = 1/2 at u = ln(2)/3.
            parameters: &[
                ("mu_coulomb", 0.3),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("transition_speed", 1e-3),
            ],
            speed: 0.231_049_060_186_648_4e-3,
            force: 1.5,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Rise<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Rise<L> {
        let transition = params.get(ParamId::TransitionSpeed);
        Rise {
            coulomb: contact.coulomb,
            viscous: contact.viscous,
            per_transition: transition.splat(1.0) / transition,
        }
    }
}

impl Smooth for Threlfall {
    #[inline(always)]
    fn force<L: Lane>(law: &Rise<L>, v: L) -> L {
        let u = (v.abs() * law.per_transition).min(v.splat(1.0));
        let size = -(law.coulomb * exp_less_one(u * -3.0));
        size.mul_add(sign(v), law.viscous * v)
    }
}
