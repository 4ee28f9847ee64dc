//! Brown and McPhee: one smooth curve with a static peak.

use super::{Contact, Law, LawInfo, Parameters, ReferenceValue, Smooth};
use crate::lane::Lane;
use crate::lane::exp::tanh;
use crate::params::ParamId;

pub struct BrownMcphee;

#[derive(Clone, Copy)]
pub struct Peak<L> {
    coulomb: L,
    drop: L,
    viscous: L,
    per_transition: L,
}

impl Law for BrownMcphee {
    const INFO: LawInfo = LawInfo {
        name: "brown_mcphee",
        formula: r"F = F_C \tanh(4u) + \frac{(F_S - F_C)\,u}{(u^2/4 + 3/4)^2} + \mu_V v,\quad u = v/v_t",
        source: "Brown and McPhee 2016",
        limits: "creeps; v_t, where the peak stands, is empirical; static friction below Coulomb counts as equal",
        meaning: "smooth curve with a static peak at the transition speed",
        params: &["mu_static", "mu_coulomb", "viscous", "transition_speed"],
        reference: ReferenceValue {
            // 4 tanh 4 + 4 + 2*0.25 at the peak.
            parameters: &[
                ("mu_static", 0.8),
                ("mu_coulomb", 0.4),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("viscous", 2.0),
                ("transition_speed", 0.25),
            ],
            speed: 0.25,
            force: 8.497_317_198_956_264,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Peak<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Peak<L> {
        let transition = params.get(ParamId::TransitionSpeed);
        Peak {
            coulomb: contact.coulomb,
            // A negative peak would drive the segment: tanh 4 is below 1.
            drop: (contact.break_away - contact.coulomb).max(transition.splat(0.0)),
            viscous: contact.viscous,
            per_transition: transition.splat(1.0) / transition,
        }
    }
}

impl Smooth for BrownMcphee {
    #[inline(always)]
    fn force<L: Lane>(law: &Peak<L>, v: L) -> L {
        let u = v * law.per_transition;
        let width = (u * u).mul_add(v.splat(0.25), v.splat(0.75));
        let peak = (law.drop * u) / (width * width);
        let rise = law.coulomb.mul_add(tanh(u * 4.0), peak);
        law.viscous.mul_add(v, rise)
    }
}
