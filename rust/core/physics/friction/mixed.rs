//! Mixed lubrication: a film takes over from solid contact as speed rises.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::lane::exp::exp;
use crate::lane::log::power;
use crate::params::ParamId;

pub struct Mixed;

#[derive(Clone, Copy)]
pub struct Film<L> {
    boundary: L,
    viscous: L,
    per_speed: L,
    exponent: L,
}

impl Law for Mixed {
    const INFO: LawInfo = LawInfo {
        name: "mixed",
        formula: r"F = \left[F_S\,e^{-|v/v_m|^n} + \left(1 - e^{-|v/v_m|^n}\right)\mu_V |v|\right]\mathrm{sgn}\,v",
        source: "Stribeck 1902; load shared by solid contact and film as in mixed lubrication",
        limits: "steady film: no lag, no squeezing out at rest; nothing but the film brakes at high speed",
        meaning: "solid contact at rest, a viscous film at speed",
        params: &["mu_static", "viscous", "mixed_speed", "mixed_exponent"],
        reference: ReferenceValue {
            // With e = exp(-0.25): 6 e + (1 - e)*0.5*0.25.
            parameters: &[
                ("mu_static", 0.5),
                ("mass", 1.0),
                ("gravity", 12.0),
                ("viscous", 0.5),
                ("mixed_speed", 0.5),
                ("mixed_exponent", 2.0),
            ],
            speed: 0.25,
            force: 4.700_454_600_544_504,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Film<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Film<L> {
        let speed = params.get(ParamId::MixedSpeed);
        Film {
            boundary: contact.break_away,
            viscous: contact.viscous,
            per_speed: speed.splat(1.0) / speed,
            exponent: params.get(ParamId::MixedExponent),
        }
    }
}

impl Dry for Mixed {
    #[inline(always)]
    fn resistance<L: Lane>(law: &Film<L>, speed: L, _: &ContactState<L>) -> L {
        let u = (speed * law.per_speed).max(speed.splat(0.0));
        let share = exp(-power(u, law.exponent));
        let film = (speed.splat(1.0) - share) * (law.viscous * speed);
        law.boundary.mul_add(share, film)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Film<L>, _: &ContactState<L>) -> L {
        law.boundary
    }
}
