//! Bengisu and Akay: a parabola up to static friction, then an exponential fall.

use super::fall::sign;
use super::{Contact, Given, Law, LawInfo, Smooth, Worked};
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
        worked: Worked {
            // 4 + 4 e^-0.5 + 2*0.5, past the transition by half of v_s.
            given: &[
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
            ..Worked::NONE
        },
    };
    type Set<L: Lane> = Hump<L>;

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, given: &impl Given<L>) -> Hump<L> {
        let transition = given.get(ParamId::TransitionSpeed);
        let stribeck = given.get(ParamId::StribeckSpeed);
        let one = transition.with(1.0);
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
    fn force<L: Lane>(set: &Hump<L>, v: L) -> L {
        let Contact { coulomb, holding, viscous, .. } = set.contact;
        let size = v.abs();
        // u (2 - u) keeps its digits near rest, 1 - (u - 1)^2 does not.
        let u = (size * set.per_transition).min(v.with(1.0));
        let rising = holding * (u * (v.with(2.0) - u));
        let past = (size - set.transition).max(v.with(0.0)) * set.per_stribeck;
        let falling = (holding - coulomb).mul_add(exp(-past), coulomb);
        let level = L::select(size.lt(set.transition), rising, falling);
        level.mul_add(sign(v), viscous * v)
    }
}
