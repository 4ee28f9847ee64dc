//! Bengisu and Akay: a parabola up to static friction, then an exponential fall.

use super::fall::sign;
use super::{Contact, Law, LawInfo, Parameters, ReferenceValue, Smooth};
use crate::lane::Lane;
use crate::lane::exp::exp;
use crate::params::ParamId;

pub struct BengisuAkay;

#[derive(Clone, Copy)]
pub struct Hump<L> {
    contact: Contact<L>,
    transition: L,
    per_transition: L,
    per_stribeck: L,
}

impl Law for BengisuAkay {
    const INFO: LawInfo = LawInfo {
        name: "bengisu_akay",
        formula: r"F = \left\{\begin{array}{ll} F_S\left[1 - (|v|/v_t - 1)^2\right] & |v| \le v_t \\ F_C + (F_S - F_C)\,e^{-(|v| - v_t)/v_s} & |v| > v_t \end{array}\right\}\mathrm{sgn}\,v + \mu_V v",
        source: "Bengisu and Akay 1994",
        limits: "creeps below static friction; kink at v_t",
        meaning: "rises to static friction along a parabola, then falls exponentially",
        params: &["mu_static", "mu_coulomb", "viscous", "stribeck_speed", "transition_speed"],
        reference: ReferenceValue {
            // 4 + 4 e^-0.5 + 2*0.5, past the transition by half of v_s.
            parameters: &[
                ("mu_static", 0.8),
                ("mu_coulomb", 0.4),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("viscous", 2.0),
                ("stribeck_speed", 0.5),
                ("transition_speed", 0.25),
            ],
            speed: 0.5,
            force: 7.426_122_638_850_534,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Hump<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Hump<L> {
        let transition = params.get(ParamId::TransitionSpeed);
        let stribeck = params.get(ParamId::StribeckSpeed);
        let one = transition.splat(1.0);
        Hump {
            contact: *contact,
            transition,
            per_transition: one / transition,
            per_stribeck: one / stribeck,
        }
    }
}

impl Smooth for BengisuAkay {
    #[inline(always)]
    fn force<L: Lane>(law: &Hump<L>, v: L) -> L {
        let Contact { coulomb, break_away, viscous, .. } = law.contact;
        let size = v.abs();
        // u (2 - u) keeps its digits near rest, 1 - (u - 1)^2 does not.
        let u = (size * law.per_transition).min(v.splat(1.0));
        let rising = break_away * (u * (v.splat(2.0) - u));
        let past = (size - law.transition).max(v.splat(0.0)) * law.per_stribeck;
        let falling = (break_away - coulomb).mul_add(exp(-past), coulomb);
        let level = L::select(size.lt(law.transition), rising, falling);
        level.mul_add(sign(v), viscous * v)
    }
}
