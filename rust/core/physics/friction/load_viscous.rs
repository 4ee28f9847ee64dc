//! Viscous friction that grows with the normal force.

use super::{Contact, Dry, Given, Law, LawInfo, Place, Worked};
use crate::lane::Lane;
use crate::lane::log::power;
use crate::params::ParamId;

pub struct LoadViscous;

impl Law for LoadViscous {
    const INFO: LawInfo = LawInfo {
        name: "load_viscous",
        formula: r"F = F_C\,\mathrm{sgn}\,v + \left[\mu_V + b_1 (F_N/1\,\mathrm{N})^q\right] v",
        source: "fit in common use: a film thins under load, so that its shear rises",
        limits: "the normal force is constant over one run",
        meaning: "constant level and a viscous part that grows with the normal force",
        params: &["mu_coulomb", "viscous", "viscous_load", "load_exponent"],
        worked: Worked {
            // 0.35*16 + (0.5 + 0.2*16^0.5)*2.
            given: &[
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 16.0),
                ("viscous", 0.5),
                ("viscous_load", 0.2),
                ("load_exponent", 0.5),
            ],
            speed: 2.0,
            force: 8.2,
            ..Worked::NONE
        },
    };
    /// F_C and the whole viscous coefficient.
    type Set<L: Lane> = (L, L);

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, given: &impl Given<L>) -> (L, L) {
        let grown = power(contact.normal, given.get(ParamId::LoadExponent));
        let viscous = given.get(ParamId::ViscousLoad).mul_add(grown, contact.viscous);
        (contact.coulomb, viscous)
    }
}

impl Dry for LoadViscous {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(set: &(L, L), speed: L, _: &Place<L>) -> L {
        set.1.mul_add(speed, set.0)
    }
    #[inline(always)]
    fn holding<L: Lane>(set: &(L, L), _: &Place<L>) -> L {
        set.0
    }
    #[inline(always)]
    fn linear<L: Lane>(set: &(L, L), _: &Place<L>) -> (L, L) {
        *set
    }
}
