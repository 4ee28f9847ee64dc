//! The smooth Stribeck curve of Simscape's Translational Friction block.

use super::{Contact, Law, LawInfo, Parameters, ReferenceValue, Smooth};
use crate::lane::Lane;
use crate::lane::exp::{exp, tanh};
use crate::params::ParamId;

pub struct Simscape;

#[derive(Clone, Copy)]
pub struct BreakAway<L> {
    coulomb: L,
    /// sqrt(2 e) (F_S - F_C).
    peak: L,
    viscous: L,
    per_stribeck: L,
    per_coulomb: L,
}

impl Law for Simscape {
    const INFO: LawInfo = LawInfo {
        name: "simscape",
        formula: r"F = \sqrt{2e}\,(F_S - F_C)\,e^{-(v/v_\mathrm{St})^2}\frac{v}{v_\mathrm{St}} + F_C \tanh\frac{v}{v_\mathrm{Coul}} + \mu_V v,\quad v_\mathrm{St} = \sqrt 2\,v_t,\ v_\mathrm{Coul} = v_t/10",
        source: "MathWorks, Simscape Translational Friction block (v_t is its breakaway friction velocity)",
        limits: "creeps; the peak passes F_S a little, on the rise of the tanh",
        meaning: "smooth curve with static friction at the break-away speed",
        params: &["mu_static", "mu_coulomb", "viscous", "transition_speed"],
        reference: ReferenceValue {
            // F_S + 2*0.25 at the break-away speed, less 4 (1 - tanh 10).
            parameters: &[
                ("mu_static", 0.8),
                ("mu_coulomb", 0.4),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("viscous", 2.0),
                ("transition_speed", 0.25),
            ],
            speed: 0.25,
            force: 8.499_999_983_510_77,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = BreakAway<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> BreakAway<L> {
        const SQRT_2E: f64 = 2.331_643_981_597_124;
        let per = contact.normal.splat(1.0) / params.get(ParamId::TransitionSpeed);
        BreakAway {
            coulomb: contact.coulomb,
            peak: (contact.break_away - contact.coulomb) * SQRT_2E,
            viscous: contact.viscous,
            per_stribeck: per * std::f64::consts::FRAC_1_SQRT_2,
            per_coulomb: per * 10.0,
        }
    }
}

impl Smooth for Simscape {
    #[inline(always)]
    fn force<L: Lane>(law: &BreakAway<L>, v: L) -> L {
        let u = v * law.per_stribeck;
        let peak = law.peak * (exp(-(u * u)) * u);
        let rise = law.coulomb.mul_add(tanh(v * law.per_coulomb), peak);
        law.viscous.mul_add(v, rise)
    }
}
