//! Elasto-plastic friction: LuGre whose bristles first bend without sliding.

use super::fall::{Bell, sign};
use super::lugre::Bristles;
use super::{Bristle, Contact, Law, LawInfo, MOST_STATES, Parameters, Partials, ReferenceValue};
use crate::lane::Lane;
use crate::lane::trig::{cos_turns, sin_turns};
use crate::params::ParamId;

pub struct ElastoPlastic;

#[derive(Clone, Copy)]
pub struct Elastic<L> {
    bristles: Bristles<L>,
    /// z_ba: purely elastic up to here.
    elastic: L,
}

/// alpha(z, v), and its derivatives.
struct Plastic<L> {
    share: L,
    by_v: L,
    by_z: L,
}

impl<L: Lane> Elastic<L> {
    /// `end` and `end_v` are g/sigma_0 and its derivative.
    #[inline(always)]
    fn plastic(&self, v: L, z: L, end: L, end_v: L) -> Plastic<L> {
        let (zero, one) = (v.splat(0.0), v.splat(1.0));
        let per_width = one / (end - self.elastic);
        let along = (z.abs() - self.elastic) * per_width;
        let q = along.max(zero).min(one);
        // Sine blend of Dupont: 1/2 sin(pi (q - 1/2)) + 1/2.
        let share = (one - cos_turns(q * 0.5)) * 0.5;
        let slope = sin_turns(q * 0.5) * std::f64::consts::FRAC_PI_2;
        let bent_along = (z * sign(v)).gt(zero);
        let inside = L::and(along.gt(zero), along.lt(one));
        let slope = L::select(L::and(bent_along, inside), slope, zero);
        Plastic {
            share: L::select(bent_along, share, zero),
            by_v: -(slope * q) * (per_width * end_v),
            by_z: slope * per_width * sign(z),
        }
    }
}

impl Law for ElastoPlastic {
    const INFO: LawInfo = LawInfo {
        name: "elasto_plastic",
        formula: r"\dot z = v\left[1 - \alpha(z, v)\frac{z}{z_\mathrm{ss}}\right],\quad F = \sigma_0 z + \sigma_1 e^{-(v/v_d)^2}\dot z + \mu_V v,\quad z_\mathrm{ss} = \mathrm{sgn}(v)\,g(v)/\sigma_0;\quad \alpha = 0 \text{ up to } z_\mathrm{ba} \text{ and on the way back, a sine from there to } 1 \text{ at } z_\mathrm{ss}",
        source: "Dupont, Hayward, Armstrong and Altpeter 2002; g(v) and the fading of the damping as in lugre; z_ba is a share of the lower of F_S and F_C over the stiffness",
        limits: "no drift under loads below the elastic share; kinks where a branch changes",
        meaning: "bristles that bend elastically before they begin to slide",
        params: &[
            "mu_static",
            "mu_coulomb",
            "viscous",
            "stribeck_speed",
            "bristle_stiffness",
            "bristle_damping",
            "damping_speed",
            "elastic_share",
        ],
        reference: ReferenceValue {
            // z half-way between z_ba = 5 um and z_ss = 10 um (g is F_C to
            // 1e-16): alpha = 1/2, z' = 0.1 (1 - 3/8), F = 0.75 + 10 z' + 0.04.
            parameters: &[
                ("mu_static", 1.5),
                ("mu_coulomb", 1.0),
                ("mass", 1.0),
                ("gravity", 1.0),
                ("viscous", 0.4),
                ("stribeck_speed", 1e-3),
                ("bristle_stiffness", 1e5),
                ("bristle_damping", 10.0),
                ("elastic_share", 0.5),
            ],
            speed: 0.1,
            states: [7.5e-6, 0.0, 0.0, 0.0],
            force: 1.415,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Elastic<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Elastic<L> {
        let bristles = Bristles::of(contact, params);
        let lowest = Bell::of(contact, params).lowest();
        let share = params.get(ParamId::ElasticShare);
        Elastic { bristles, elastic: share * lowest / bristles.stiffness }
    }
}

impl Bristle for ElastoPlastic {
    const STATES: usize = 1;

    #[inline(always)]
    fn rates<L: Lane>(law: &Elastic<L>, v: L, z: &[L; MOST_STATES]) -> [L; MOST_STATES] {
        let zero = v.splat(0.0);
        let (level, _) = law.bristles.level(v);
        let end = level / law.bristles.stiffness;
        let plastic = law.plastic(v, z[0], end, zero);
        [v * (v.splat(1.0) - plastic.share * (z[0].abs() / end)), zero, zero, zero]
    }

    #[inline(always)]
    fn force<L: Lane>(law: &Elastic<L>, v: L, z: &[L; MOST_STATES], rates: &[L; MOST_STATES]) -> L {
        law.bristles.force(v, z[0], rates[0])
    }

    #[inline(always)]
    fn partials<L: Lane>(law: &Elastic<L>, v: L, z: &[L; MOST_STATES]) -> Partials<L> {
        let one = v.splat(1.0);
        let (level, level_v) = law.bristles.level(v);
        let per_stiffness = one / law.bristles.stiffness;
        let (end, end_v) = (level * per_stiffness, level_v * per_stiffness);
        let plastic = law.plastic(v, z[0], end, end_v);
        let bent = z[0].abs() / end;
        let left = one - plastic.share * bent;
        let share_v = plastic.by_v * bent - plastic.share * bent * (end_v / end);
        let rate_v = left - v * share_v;
        let rate_z = -(v * (plastic.by_z * bent + plastic.share * sign(z[0]) / end));
        law.bristles.partials(v, v * left, rate_v, rate_z)
    }

    #[inline(always)]
    fn stored<L: Lane>(law: &Elastic<L>, z: &[L; MOST_STATES]) -> L {
        (law.bristles.stiffness * 0.5) * (z[0] * z[0])
    }

    #[inline(always)]
    fn steady<L: Lane>(law: &Elastic<L>, v: L) -> [L; MOST_STATES] {
        law.bristles.steady(v)
    }
}
