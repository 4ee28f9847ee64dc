//! Brown and McPhee: one smooth curve with a static peak.

use super::{Contact, Given, Law, LawInfo, Smooth, Worked};
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
        worked: Worked {
            // 4 tanh 4 + 4 + 2*0.25 at the peak.
            given: &[
                ("mu_static", 0.8),
                ("mu_coulomb", 0.4),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("viscous", 2.0),
                ("transition_speed", 0.25),
            ],
            speed: 0.25,
            force: 8.497_317_198_956_264,
            ..Worked::NONE
        },
    };
    type Set<L: Lane> = Peak<L>;

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, given: &impl Given<L>) -> Peak<L> {
        let transition = given.get(ParamId::TransitionSpeed);
        Peak {
            coulomb: contact.coulomb,
            // A negative peak would drive the segment: tanh 4 is below 1.
            drop: (contact.holding - contact.coulomb).max(transition.with(0.0)),
            viscous: contact.viscous,
            per_transition: transition.with(1.0) / transition,
        }
    }
}

impl Smooth for BrownMcphee {
    #[inline(always)]
    fn force<L: Lane>(set: &Peak<L>, v: L) -> L {
        let u = v * set.per_transition;
        let width = (u * u).mul_add(v.with(0.25), v.with(0.75));
        let peak = (set.drop * u) / (width * width);
        let rise = set.coulomb.mul_add(tanh(u * 4.0), peak);
        set.viscous.mul_add(v, rise)
    }
}
