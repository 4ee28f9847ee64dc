//! LuGre: bristles that bend, then slide along a Stribeck curve.

use super::fall::{Bell, sign};
use super::{Bristle, Contact, Law, LawInfo, MOST_STATES, Parameters, Partials, ReferenceValue};
use crate::lane::Lane;
use crate::lane::exp::exp;
use crate::params::ParamId;

pub struct Lugre;

/// Bristles over a Stribeck curve, and what laws of one deflection share.
#[derive(Clone, Copy)]
pub struct Bristles<L> {
    pub(super) stiffness: L,
    damping: L,
    /// 1/v_d, 0 where the damping does not fade.
    per_fading: L,
    viscous: L,
    bell: Bell<L>,
}

impl<L: Lane> Bristles<L> {
    #[inline(always)]
    pub(super) fn of(contact: &Contact<L>, params: &impl Parameters<L>) -> Self {
        Bristles {
            stiffness: params.get(ParamId::BristleStiffness),
            damping: params.get(ParamId::BristleDamping),
            per_fading: contact.normal.splat(1.0) / params.get(ParamId::DampingSpeed),
            viscous: contact.viscous,
            bell: Bell::of(contact, params),
        }
    }

    /// Friction of steady sliding without the viscous part, and its derivative.
    #[inline(always)]
    pub(super) fn level(&self, v: L) -> (L, L) {
        self.bell.level(v)
    }

    /// Damping at a speed, and its derivative.
    #[inline(always)]
    fn damping(&self, v: L) -> (L, L) {
        let u = v * self.per_fading;
        let damping = self.damping * exp(-(u * u));
        (damping, (damping * u) * (self.per_fading * -2.0))
    }

    #[inline(always)]
    pub(super) fn force(&self, v: L, z: L, rate: L) -> L {
        let (damping, _) = self.damping(v);
        self.viscous.mul_add(v, damping.mul_add(rate, self.stiffness * z))
    }

    /// All derivatives from those of the deflection's rate.
    #[inline(always)]
    pub(super) fn partials(&self, v: L, rate: L, rate_v: L, rate_z: L) -> Partials<L> {
        let (damping, damping_v) = self.damping(v);
        let mut partials = Partials::zero(v);
        partials.rate_v[0] = rate_v;
        partials.rate_z[0][0] = rate_z;
        partials.force_v = damping.mul_add(rate_v, damping_v * rate) + self.viscous;
        partials.force_z[0] = damping.mul_add(rate_z, self.stiffness);
        partials
    }

    #[inline(always)]
    pub(super) fn steady(&self, v: L) -> [L; MOST_STATES] {
        let (level, _) = self.level(v);
        let zero = v.splat(0.0);
        [sign(v) * (level / self.stiffness), zero, zero, zero]
    }
}

impl Law for Lugre {
    const INFO: LawInfo = LawInfo {
        name: "lugre",
        formula: r"\dot z = v - \sigma_0\frac{|v|}{g(v)} z,\quad F = \sigma_0 z + \sigma_1 e^{-(v/v_d)^2}\dot z + \mu_V v,\quad g = F_C + (F_S - F_C)e^{-(v/v_s)^2}",
        source: "Canudas de Wit, Olsson, Astrom and Lischinsky 1995",
        limits: "stiff; drifts under a load that varies below break-away; passive only for small damping",
        meaning: "elastic bristles that slide along a Stribeck curve",
        params: &[
            "mu_static",
            "mu_coulomb",
            "viscous",
            "stribeck_speed",
            "bristle_stiffness",
            "bristle_damping",
            "damping_speed",
        ],
        reference: ReferenceValue {
            // Steady sliding of the standard set at 5 mm/s, bristles at rest:
            // g = 1 + 0.5 e^-25, F = g + 0.4 * 0.005.
            parameters: &[
                ("mu_static", 1.5),
                ("mu_coulomb", 1.0),
                ("mass", 1.0),
                ("gravity", 1.0),
                ("viscous", 0.4),
                ("stribeck_speed", 1e-3),
                ("bristle_stiffness", 1e5),
            ],
            speed: 5e-3,
            states: [1.000_000_000_006_943_9e-5, 0.0, 0.0, 0.0],
            force: 1.002_000_000_006_944,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Bristles<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Bristles<L> {
        Bristles::of(contact, params)
    }
}

impl Bristle for Lugre {
    const STATES: usize = 1;

    #[inline(always)]
    fn rates<L: Lane>(law: &Bristles<L>, v: L, z: &[L; MOST_STATES]) -> [L; MOST_STATES] {
        let (level, _) = law.level(v);
        let rate = v - (law.stiffness * v.abs()) * (z[0] / level);
        [rate, v.splat(0.0), v.splat(0.0), v.splat(0.0)]
    }

    #[inline(always)]
    fn force<L: Lane>(
        law: &Bristles<L>,
        v: L,
        z: &[L; MOST_STATES],
        rates: &[L; MOST_STATES],
    ) -> L {
        law.force(v, z[0], rates[0])
    }

    #[inline(always)]
    fn partials<L: Lane>(law: &Bristles<L>, v: L, z: &[L; MOST_STATES]) -> Partials<L> {
        let (level, level_v) = law.level(v);
        let per_level = v.splat(1.0) / level;
        let pull = (law.stiffness * v.abs()) * per_level;
        // d/dv of |v|/g is sgn/g - |v| g'/g^2.
        let pull_v = (law.stiffness * per_level) * (sign(v) - (v.abs() * per_level) * level_v);
        law.partials(v, v - pull * z[0], v.splat(1.0) - pull_v * z[0], -pull)
    }

    #[inline(always)]
    fn stored<L: Lane>(law: &Bristles<L>, z: &[L; MOST_STATES]) -> L {
        (law.stiffness * 0.5) * (z[0] * z[0])
    }

    #[inline(always)]
    fn steady<L: Lane>(law: &Bristles<L>, v: L) -> [L; MOST_STATES] {
        law.steady(v)
    }
}
