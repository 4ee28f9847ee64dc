//! A yield level with drag along a power law, as greases have.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::lane::log::power;
use crate::params::ParamId;

pub struct PowerDrag;

#[derive(Clone, Copy)]
pub struct Yield<L> {
    level: L,
    drag: L,
    exponent: L,
}

impl Law for PowerDrag {
    const INFO: LawInfo = LawInfo {
        name: "power_drag",
        formula: r"F = \left[F_C + c_p\,|v/(1\,\mathrm{m/s})|^p\right]\mathrm{sgn}\,v",
        source: "Ostwald 1925; with a yield level Herschel and Bulkley 1926",
        limits: "p < 1 thins under shear and rises infinitely steeply from rest",
        meaning: "constant level and drag along a power of the speed",
        params: &["mu_coulomb", "power_drag", "power_exponent"],
        reference: ReferenceValue {
            // 0.35*12 + 2*0.25^1.5.
            parameters: &[
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 12.0),
                ("power_drag", 2.0),
                ("power_exponent", 1.5),
            ],
            speed: 0.25,
            force: 4.45,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Yield<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Yield<L> {
        Yield {
            level: contact.coulomb,
            drag: params.get(ParamId::PowerDrag),
            exponent: params.get(ParamId::PowerExponent),
        }
    }
}

impl Dry for PowerDrag {
    #[inline(always)]
    fn resistance<L: Lane>(law: &Yield<L>, speed: L, _: &ContactState<L>) -> L {
        let u = speed.max(speed.splat(0.0));
        law.drag.mul_add(power(u, law.exponent), law.level)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Yield<L>, _: &ContactState<L>) -> L {
        law.level
    }
}
