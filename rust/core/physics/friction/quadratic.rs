//! Coulomb friction with viscous and quadratic drag.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::params::ParamId;

pub struct Quadratic;

#[derive(Clone, Copy)]
pub struct Drag<L> {
    coulomb: L,
    viscous: L,
    quadratic: L,
}

/// A resistance with drag that grows with `speed * size`, where `size` is the speed or
/// its magnitude.
#[inline(always)]
pub fn dragged<L: Lane>(resistance: L, quadratic: L, speed: L, size: L) -> L {
    (quadratic * speed).mul_add(size, resistance)
}

impl Law for Quadratic {
    const INFO: LawInfo = LawInfo {
        name: "quadratic",
        formula: r"F = (F_C + c_2 v^2)\,\mathrm{sgn}\,v + \mu_V v",
        source: "Newton 1687 (square of the speed), with Coulomb 1785 and Reynolds 1886",
        limits: "drag of a body that pushes a fluid aside; negligible at crawling speeds in air",
        meaning: "constant level, a viscous part and drag with the square of the speed",
        params: &["mu_coulomb", "viscous", "quadratic"],
        reference: ReferenceValue {
            // 0.35*12 + 0.5*2 + 3*4.
            parameters: &[
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 12.0),
                ("viscous", 0.5),
                ("quadratic", 3.0),
            ],
            speed: 2.0,
            force: 17.2,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Drag<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Drag<L> {
        Drag {
            coulomb: contact.coulomb,
            viscous: contact.viscous,
            quadratic: params.get(ParamId::Quadratic),
        }
    }
}

impl Dry for Quadratic {
    #[inline(always)]
    fn resistance<L: Lane>(law: &Drag<L>, speed: L, _: &ContactState<L>) -> L {
        let linear = law.viscous.mul_add(speed, law.coulomb);
        dragged(linear, law.quadratic, speed, speed)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Drag<L>, _: &ContactState<L>) -> L {
        law.coulomb
    }
}
