//! Gonthier: bristles whose static friction grows with the time at rest.

use super::fall::sign;
use super::{Bristle, Contact, Law, LawInfo, MOST_STATES, Parameters, Partials, ReferenceValue};
use crate::lane::Lane;
use crate::lane::exp::{exp, exp_less_one};
use crate::params::ParamId;

/// Least relaxation time of the bristles, s: the law divides by their damping.
const LEAST_RELAXATION: f64 = 1e-6;

pub struct Gonthier;

#[derive(Clone, Copy)]
pub struct Dwell<L> {
    stiffness: L,
    damping: L,
    viscous: L,
    coulomb: L,
    drop: L,
    per_stribeck: L,
    per_dwell: L,
    /// One over the relaxation time of the bristles.
    per_relaxation: L,
}

impl<L: Lane> Dwell<L> {
    /// Degree of sticking, 1 at rest, and its derivative.
    #[inline(always)]
    fn sticking(&self, v: L) -> (L, L) {
        let u = v * self.per_stribeck;
        let s = exp(-(u * u));
        (s, (s * u) * (self.per_stribeck * -2.0))
    }

    /// Force of the bristles before the cap, and the cap.
    #[inline(always)]
    fn force(&self, v: L, z: &[L; MOST_STATES], s: L) -> (L, L) {
        let stuck = self.damping.mul_add(v, self.stiffness * z[0]);
        let sliding = self.coulomb * sign(v);
        let cap = self.drop.mul_add(z[1], self.coulomb).max(v.splat(0.0));
        (s.mul_add(stuck - sliding, sliding), cap)
    }

    #[inline(always)]
    fn capped(&self, v: L, z: &[L; MOST_STATES], s: L) -> L {
        let (force, cap) = self.force(v, z, s);
        force.min(cap).max(-cap)
    }

    /// Rate of the dwell state: slow to gain, quick to lose.
    #[inline(always)]
    fn pace(&self, s: L, dwell: L) -> L {
        L::select(s.lt(dwell), self.per_relaxation, self.per_dwell)
    }
}

impl Law for Gonthier {
    const INFO: LawInfo = LawInfo {
        name: "gonthier",
        formula: r"\sigma_0 z + \sigma_1 \dot z = \mathrm{sat}_{F_C + (F_S - F_C) s_\mathrm{dw}}\left[s(\sigma_0 z + \sigma_1 v) + (1 - s) F_C\,\mathrm{sgn}\,v\right],\quad \dot s_\mathrm{dw} = \frac{s - s_\mathrm{dw}}{\tau},\quad s = e^{-(v/v_s)^2},\quad F = \sigma_0 z + \sigma_1 \dot z + \mu_V v;\quad \tau = \tau_\mathrm{dw} \text{ at rest, } \sigma_1/\sigma_0 \text{ once it slides}",
        source: "Gonthier, McPhee, Lange and Piedboeuf 2004",
        limits: "two time scales; the cap has kinks; the relaxation time of the bristles counts as at least 1e-6 s",
        meaning: "bristles whose static friction grows with the time at rest",
        params: &[
            "mu_static",
            "mu_coulomb",
            "viscous",
            "stribeck_speed",
            "bristle_stiffness",
            "bristle_damping",
            "dwell_time",
        ],
        reference: ReferenceValue {
            // At v_s, s = 1/e: (1e5*1e-6 + 100*1e-3) s + (1 - s) + 0.4e-3.
            parameters: &[
                ("mu_static", 1.5),
                ("mu_coulomb", 1.0),
                ("mass", 1.0),
                ("gravity", 1.0),
                ("viscous", 0.4),
                ("stribeck_speed", 1e-3),
                ("bristle_stiffness", 1e5),
                ("bristle_damping", 100.0),
            ],
            speed: 1e-3,
            states: [1e-6, 0.5, 0.0, 0.0],
            force: 0.706_096_447_062_846_1,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Dwell<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Dwell<L> {
        let one = contact.normal.splat(1.0);
        let stiffness = params.get(ParamId::BristleStiffness);
        let damping = params.get(ParamId::BristleDamping).max(stiffness * LEAST_RELAXATION);
        Dwell {
            stiffness,
            damping,
            viscous: contact.viscous,
            coulomb: contact.coulomb,
            drop: contact.break_away - contact.coulomb,
            per_stribeck: one / params.get(ParamId::StribeckSpeed),
            per_dwell: one / params.get(ParamId::DwellTime),
            per_relaxation: stiffness / damping,
        }
    }
}

impl Bristle for Gonthier {
    const STATES: usize = 2;

    #[inline(always)]
    fn rates<L: Lane>(law: &Dwell<L>, v: L, z: &[L; MOST_STATES]) -> [L; MOST_STATES] {
        let zero = v.splat(0.0);
        let (s, _) = law.sticking(v);
        let bent = (law.capped(v, z, s) - law.stiffness * z[0]) / law.damping;
        [bent, (s - z[1]) * law.pace(s, z[1]), zero, zero]
    }

    #[inline(always)]
    fn force<L: Lane>(law: &Dwell<L>, v: L, z: &[L; MOST_STATES], rates: &[L; MOST_STATES]) -> L {
        let bristles = law.damping.mul_add(rates[0], law.stiffness * z[0]);
        law.viscous.mul_add(v, bristles)
    }

    #[inline(always)]
    fn partials<L: Lane>(law: &Dwell<L>, v: L, z: &[L; MOST_STATES]) -> Partials<L> {
        let (zero, one) = (v.splat(0.0), v.splat(1.0));
        let (s, s_v) = law.sticking(v);
        let (force, cap) = law.force(v, z, s);
        let free = force.abs().lt(cap);
        let stuck = law.damping.mul_add(v, law.stiffness * z[0]);
        let away = stuck - law.coulomb * sign(v);
        let force_v = L::select(free, s_v.mul_add(away, s * law.damping), zero);
        let force_z = L::select(free, s * law.stiffness, zero);
        let force_dwell = L::select(free, zero, law.drop * sign(force));
        let per_damping = one / law.damping;
        let pace = law.pace(s, z[1]);
        let mut partials = Partials::zero(v);
        partials.rate_v[0] = force_v * per_damping;
        partials.rate_z[0][0] = (force_z - law.stiffness) * per_damping;
        partials.rate_z[0][1] = force_dwell * per_damping;
        partials.rate_v[1] = s_v * pace;
        partials.rate_z[1][1] = -pace;
        partials.force_v = force_v + law.viscous;
        partials.force_z[0] = force_z;
        partials.force_z[1] = force_dwell;
        partials
    }

    #[inline(always)]
    fn stored<L: Lane>(law: &Dwell<L>, z: &[L; MOST_STATES]) -> L {
        (law.stiffness * 0.5) * (z[0] * z[0])
    }

    #[inline(always)]
    fn steady<L: Lane>(law: &Dwell<L>, v: L) -> [L; MOST_STATES] {
        let zero = v.splat(0.0);
        let (s, _) = law.sticking(v);
        let u = v * law.per_stribeck;
        // s v/(1 - s) by which the bristles trail; infinite as v falls to 0.
        let trail = (s * v.abs()) / -exp_less_one(-(u * u));
        let free = law.damping.mul_add(trail, law.coulomb);
        let level = free.min(law.drop.mul_add(s, law.coulomb).max(zero));
        [sign(v) * (level / law.stiffness), s, zero, zero]
    }
}
