//! Dahl: the stress-strain curve of a contact that yields gradually.

use super::fall::{at_least, sign};
use super::{Bristle, Contact, Given, Law, LawInfo, MOST_STATES, Partials, Worked};
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
        let margin = v.with(1.0) - (sign(v) * z) * self.per_deflection;
        (margin, margin.abs().max(v.with(1e-9)))
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
        worked: Worked {
            // Half-way to sliding: 1e5*5e-6 + 0.4*0.1.
            given: &[
                ("mu_coulomb", 1.0),
                ("mass", 1.0),
                ("gravity", 1.0),
                ("viscous", 0.4),
                ("bristle_stiffness", 1e5),
            ],
            speed: 0.1,
            states: [5e-6, 0.0, 0.0, 0.0],
            force: 0.54,
            ..Worked::NONE
        },
    };
    type Set<L: Lane> = Yielding<L>;

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, given: &impl Given<L>) -> Yielding<L> {
        let stiffness = given.get(ParamId::BristleStiffness);
        let level = at_least(contact.coulomb);
        Yielding {
            stiffness,
            level,
            per_deflection: stiffness / level,
            viscous: contact.viscous,
            exponent: given.get(ParamId::DahlExponent),
        }
    }
}

impl Bristle for Dahl {
    const STATES: usize = 1;

    #[inline(always)]
    fn rates<L: Lane>(set: &Yielding<L>, v: L, z: &[L; MOST_STATES]) -> [L; MOST_STATES] {
        let zero = v.with(0.0);
        let (margin, _) = set.margin(v, z[0]);
        // |w|^i sgn w = w |w|^(i-1), but finite at 0 for every i.
        let rate = v * (power(margin.abs(), set.exponent) * sign(margin));
        [rate, zero, zero, zero]
    }

    #[inline(always)]
    fn force<L: Lane>(set: &Yielding<L>, v: L, z: &[L; MOST_STATES], _: &[L; MOST_STATES]) -> L {
        set.viscous.mul_add(v, set.stiffness * z[0])
    }

    #[inline(always)]
    fn partials<L: Lane>(set: &Yielding<L>, v: L, z: &[L; MOST_STATES]) -> Partials<L> {
        let (margin, size) = set.margin(v, z[0]);
        let slope = set.exponent * power(size, set.exponent - 1.0);
        let mut partials = Partials::zero(v);
        partials.rate_v[0] = power(margin.abs(), set.exponent) * sign(margin);
        partials.rate_z[0][0] = -((v.abs() * set.per_deflection) * slope);
        partials.force_v = set.viscous;
        partials.force_z[0] = set.stiffness;
        partials
    }

    #[inline(always)]
    fn stored<L: Lane>(set: &Yielding<L>, z: &[L; MOST_STATES]) -> L {
        (set.stiffness * 0.5) * (z[0] * z[0])
    }

    #[inline(always)]
    fn steady<L: Lane>(set: &Yielding<L>, v: L) -> [L; MOST_STATES] {
        let zero = v.with(0.0);
        [sign(v) * (set.level / set.stiffness), zero, zero, zero]
    }
}
