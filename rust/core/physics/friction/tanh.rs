//! A hyperbolic tangent in place of the jump at rest.

use super::{Contact, Law, LawInfo, Parameters, ReferenceValue, Smooth};
use crate::lane::Lane;
use crate::lane::exp::{exp, tanh};
use crate::params::ParamId;

/// Stribeck friction times tanh(v/v_t).
pub struct Tanh;

#[derive(Clone, Copy)]
pub struct Curve<L> {
    coulomb: L,
    drop: L,
    viscous: L,
    per_stribeck: L,
    per_transition: L,
}

impl Law for Tanh {
    const INFO: LawInfo = LawInfo {
        name: "tanh",
        formula: r"F = \left[F_C + (F_S - F_C)\,e^{-(v/v_s)^2}\right]\tanh\frac{v}{v_t} + \mu_V v",
        source: "Andersson, Soderberg and Bjorklund 2007",
        limits: "creeps: never holds on a slope; stiffness F_C/(m v_t) bounds the step",
        meaning: "Stribeck friction with the jump at rest smoothed by tanh",
        params: &["mu_static", "mu_coulomb", "viscous", "stribeck_speed", "transition_speed"],
        reference: ReferenceValue {
            // tanh(0.549306) = 1/2, the creep of half the Coulomb level.
            parameters: &[
                ("mu_static", 0.3),
                ("mu_coulomb", 0.3),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("transition_speed", 1e-3),
            ],
            speed: 0.549_306_144_334_054_8e-3,
            force: 1.5,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Curve<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Curve<L> {
        let stribeck = params.get(ParamId::StribeckSpeed);
        let transition = params.get(ParamId::TransitionSpeed);
        let one = stribeck.splat(1.0);
        Curve {
            coulomb: contact.coulomb,
            drop: contact.break_away - contact.coulomb,
            viscous: contact.viscous,
            per_stribeck: one / stribeck,
            per_transition: one / transition,
        }
    }
}

impl Smooth for Tanh {
    #[inline(always)]
    fn force<L: Lane>(law: &Curve<L>, v: L) -> L {
        let u = v * law.per_stribeck;
        let level = law.drop.mul_add(exp(-(u * u)), law.coulomb);
        level.mul_add(tanh(v * law.per_transition), law.viscous * v)
    }
}
