//! Generalised Maxwell slip: four elements side by side, each a spring that
//! slides when its share of the steady friction is reached.
//!
//! The published law switches each element between a stuck and a sliding mode.
//! Here the mode is read from the element's load w, its force over its share of
//! g(v), so that nothing but the deflections needs to be integrated: elastic up
//! to a load of `elastic_share`, from there its compliance rises linearly until
//! at 1 it slides, and where g(v) has fallen below the force the excess decays
//! at the published rate C(w - 1). The rates are continuous in speed and
//! deflection, so that stiff one-step methods need no events; with an elastic
//! share near 1 the elements are Maxwell's. What the published mode has besides:
//! an element that slides while g(v) rises lags behind it, this one follows.

use super::fall::{Bell, sign};
use super::{Bristle, Contact, Law, LawInfo, MOST_STATES, Parameters, Partials, ReferenceValue};
use crate::lane::Lane;
use crate::params::ParamId;

/// Each element's share of the steady friction.
const SHARE: f64 = 1.0 / MOST_STATES as f64;

pub struct MaxwellSlip;

#[derive(Clone, Copy)]
pub struct Elements<L> {
    bell: Bell<L>,
    viscous: L,
    stiffness: [L; MOST_STATES],
    /// Rate at which the excess of each element decays, m/s.
    decay: [L; MOST_STATES],
    /// One over the width of the load in which sliding begins.
    per_width: L,
}

/// One element at a speed and a deflection.
struct Element<L> {
    /// Share of the speed that bends it.
    bends: L,
    /// Load beyond 1.
    excess: L,
    /// Derivatives of both by the load.
    bends_w: L,
    excess_w: L,
    load: L,
    /// dw/dz.
    load_z: L,
}

impl<L: Lane> Elements<L> {
    #[inline(always)]
    fn element(&self, i: usize, v: L, z: L, level: L) -> Element<L> {
        let (zero, one) = (v.splat(0.0), v.splat(1.0));
        let load_z = sign(v) * (self.stiffness[i] / (level * SHARE));
        let load = load_z * z;
        let left = (one - load) * self.per_width;
        let sliding = load.gt(one);
        Element {
            bends: left.max(zero).min(one),
            excess: (load - one).max(zero),
            bends_w: L::select(L::and(left.gt(zero), left.lt(one)), -self.per_width, zero),
            excess_w: L::select(sliding, one, zero),
            load,
            load_z,
        }
    }
}

impl Law for MaxwellSlip {
    const INFO: LawInfo = LawInfo {
        name: "maxwell_slip",
        formula: r"\dot z_i = v\,\varphi(w_i) - \frac{C\nu}{k_i}\max(w_i - 1, 0)\,\mathrm{sgn}\,v,\quad w_i = \frac{k_i z_i}{\nu g(v)}\mathrm{sgn}\,v,\quad \nu = \tfrac14,\quad F = \sum_{i=1}^4 k_i z_i + \mu_V v;\quad \varphi \text{ falls from } 1 \text{ at the elastic share to } 0 \text{ at } w = 1,\quad k_i \propto \kappa^i,\ \sum k_i = \sigma_0",
        source: "Lampaert, Al-Bender and Swevers 2003; Al-Bender, Lampaert and Swevers 2005; the mode read from the load is this project's",
        limits: "sliding elements lag behind a level that falls, not behind one that rises",
        meaning: "four springs side by side that slide one after the other",
        params: &[
            "mu_static",
            "mu_coulomb",
            "viscous",
            "stribeck_speed",
            "bristle_stiffness",
            "stiffness_spread",
            "elastic_share",
            "attraction",
        ],
        reference: ReferenceValue {
            // Stiffness 1, 2, 4, 8 e4 N/m: 0.1 + 0.2 + 0.16 + 0.24 + 0.4*0.1.
            parameters: &[
                ("mu_static", 1.5),
                ("mu_coulomb", 1.0),
                ("mass", 1.0),
                ("gravity", 1.0),
                ("viscous", 0.4),
                ("bristle_stiffness", 1.5e5),
            ],
            speed: 0.1,
            states: [1e-5, 1e-5, 4e-6, 3e-6],
            force: 0.74,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Elements<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Elements<L> {
        let one = contact.normal.splat(1.0);
        let spread = params.get(ParamId::StiffnessSpread);
        let mut parts = [one; MOST_STATES];
        let mut sum = one;
        for i in 1..MOST_STATES {
            parts[i] = parts[i - 1] * spread;
            sum = sum + parts[i];
        }
        let unit = params.get(ParamId::BristleStiffness) / sum;
        let attraction = params.get(ParamId::Attraction);
        let (mut stiffness, mut decay) = (parts, parts);
        for i in 0..MOST_STATES {
            stiffness[i] = unit * parts[i];
            decay[i] = attraction * SHARE / stiffness[i];
        }
        Elements {
            bell: Bell::of(contact, params),
            viscous: contact.viscous,
            stiffness,
            decay,
            per_width: one / (one - params.get(ParamId::ElasticShare)),
        }
    }
}

impl Bristle for MaxwellSlip {
    const STATES: usize = MOST_STATES;

    #[inline(always)]
    fn rates<L: Lane>(law: &Elements<L>, v: L, z: &[L; MOST_STATES]) -> [L; MOST_STATES] {
        let (level, _) = law.bell.level(v);
        let mut rates = *z;
        for (i, rate) in rates.iter_mut().enumerate() {
            let element = law.element(i, v, z[i], level);
            *rate = v * element.bends - sign(v) * (law.decay[i] * element.excess);
        }
        rates
    }

    #[inline(always)]
    fn force<L: Lane>(law: &Elements<L>, v: L, z: &[L; MOST_STATES], _: &[L; MOST_STATES]) -> L {
        let mut sum = law.viscous * v;
        for (k, z) in law.stiffness.iter().zip(z) {
            sum = k.mul_add(*z, sum);
        }
        sum
    }

    #[inline(always)]
    fn partials<L: Lane>(law: &Elements<L>, v: L, z: &[L; MOST_STATES]) -> Partials<L> {
        let (level, level_v) = law.bell.level(v);
        let mut partials = Partials::zero(v);
        partials.force_v = law.viscous;
        for (i, z) in z.iter().enumerate() {
            let element = law.element(i, v, *z, level);
            let by_load = v * element.bends_w - sign(v) * (law.decay[i] * element.excess_w);
            let load_v = -(element.load * (level_v / level));
            partials.rate_v[i] = by_load.mul_add(load_v, element.bends);
            partials.rate_z[i][i] = by_load * element.load_z;
            partials.force_z[i] = law.stiffness[i];
        }
        partials
    }

    #[inline(always)]
    fn stored<L: Lane>(law: &Elements<L>, z: &[L; MOST_STATES]) -> L {
        let mut sum = z[0].splat(0.0);
        for (k, z) in law.stiffness.iter().zip(z) {
            sum = (*k * 0.5).mul_add(*z * *z, sum);
        }
        sum
    }

    #[inline(always)]
    fn steady<L: Lane>(law: &Elements<L>, v: L) -> [L; MOST_STATES] {
        let (level, _) = law.bell.level(v);
        let mut z = law.stiffness;
        for z in &mut z {
            *z = sign(v) * (level * SHARE / *z);
        }
        z
    }
}
