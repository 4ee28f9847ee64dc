//! Dahl: the stress-strain curve of a contact that yields gradually.

use super::fall::{at_least, sign};
use super::{Bristle, Contact, Law, LawInfo, MOST_STATES, Parameters, Partials, ReferenceValue};
use crate::lane::Lane;
use crate::lane::log::power;
use crate::params::ParamId;

pub struct Dahl;

#[derive(Clone, Copy)]
pub struct Yielding<L> {
    stiffness: L,
    level: L,
    /// sigma_0/F_C.
    per_deflection: L,
    viscous: L,
    exponent: L,
}

impl<L: Lane> Yielding<L> {
    /// Distance to sliding, w = 1 - z sgn(v) sigma_0/F_C, its size kept off 0,
    /// where an exponent below 1 has an infinite slope.
    #[inline(always)]
    fn margin(&self, v: L, z: L) -> (L, L) {
        let margin = v.splat(1.0) - (sign(v) * z) * self.per_deflection;
        (margin, margin.abs().max(v.splat(1e-9)))
    }
}

impl Law for Dahl {
    const INFO: LawInfo = LawInfo {
        name: "dahl",
        formula: r"\dot z = v\,|w|^i\,\mathrm{sgn}\,w,\quad w = 1 - \frac{\sigma_0 z}{F_C}\mathrm{sgn}\,v,\quad F = \sigma_0 z + \mu_V v",
        source: "Dahl 1968; with a viscous part beside it",
        limits: "no static friction, no fall with speed; drifts under any load that varies",
        meaning: "contact that yields gradually towards the Coulomb level",
        params: &["mu_coulomb", "viscous", "bristle_stiffness", "dahl_exponent"],
        reference: ReferenceValue {
            // Half-way to sliding: 1e5*5e-6 + 0.4*0.1.
            parameters: &[
                ("mu_coulomb", 1.0),
                ("mass", 1.0),
                ("gravity", 1.0),
                ("viscous", 0.4),
                ("bristle_stiffness", 1e5),
            ],
            speed: 0.1,
            states: [5e-6, 0.0, 0.0, 0.0],
            force: 0.54,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Yielding<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Yielding<L> {
        let stiffness = params.get(ParamId::BristleStiffness);
        let level = at_least(contact.coulomb);
        Yielding {
            stiffness,
            level,
            per_deflection: stiffness / level,
            viscous: contact.viscous,
            exponent: params.get(ParamId::DahlExponent),
        }
    }
}

impl Bristle for Dahl {
    const STATES: usize = 1;

    #[inline(always)]
    fn rates<L: Lane>(law: &Yielding<L>, v: L, z: &[L; MOST_STATES]) -> [L; MOST_STATES] {
        let zero = v.splat(0.0);
        let (margin, _) = law.margin(v, z[0]);
        // |w|^i sgn w = w |w|^(i-1), but finite at 0 for every i.
        let rate = v * (power(margin.abs(), law.exponent) * sign(margin));
        [rate, zero, zero, zero]
    }

    #[inline(always)]
    fn force<L: Lane>(law: &Yielding<L>, v: L, z: &[L; MOST_STATES], _: &[L; MOST_STATES]) -> L {
        law.viscous.mul_add(v, law.stiffness * z[0])
    }

    #[inline(always)]
    fn partials<L: Lane>(law: &Yielding<L>, v: L, z: &[L; MOST_STATES]) -> Partials<L> {
        let (margin, size) = law.margin(v, z[0]);
        let slope = law.exponent * power(size, law.exponent - 1.0);
        let mut partials = Partials::zero(v);
        partials.rate_v[0] = power(margin.abs(), law.exponent) * sign(margin);
        partials.rate_z[0][0] = -((v.abs() * law.per_deflection) * slope);
        partials.force_v = law.viscous;
        partials.force_z[0] = law.stiffness;
        partials
    }

    #[inline(always)]
    fn stored<L: Lane>(law: &Yielding<L>, z: &[L; MOST_STATES]) -> L {
        (law.stiffness * 0.5) * (z[0] * z[0])
    }

    #[inline(always)]
    fn steady<L: Lane>(law: &Yielding<L>, v: L) -> [L; MOST_STATES] {
        let zero = v.splat(0.0);
        [sign(v) * (law.level / law.stiffness), zero, zero, zero]
    }
}
