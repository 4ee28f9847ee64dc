//! Viscous friction that grows with the normal force.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
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
        reference: ReferenceValue {
            // 0.35*16 + (0.5 + 0.2*16^0.5)*2.
            parameters: &[
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 16.0),
                ("viscous", 0.5),
                ("viscous_load", 0.2),
                ("load_exponent", 0.5),
            ],
            speed: 2.0,
            force: 8.2,
            ..ReferenceValue::NONE
        },
    };
    /// F_C and the whole viscous coefficient.
    type Coefficients<L: Lane> = (L, L);

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> (L, L) {
        let grown = power(contact.normal, params.get(ParamId::LoadExponent));
        let viscous = params.get(ParamId::ViscousLoad).mul_add(grown, contact.viscous);
        (contact.coulomb, viscous)
    }
}

impl Dry for LoadViscous {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(law: &(L, L), speed: L, _: &ContactState<L>) -> L {
        law.1.mul_add(speed, law.0)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &(L, L), _: &ContactState<L>) -> L {
        law.0
    }
    #[inline(always)]
    fn linear<L: Lane>(law: &(L, L), _: &ContactState<L>) -> (L, L) {
        *law
    }
}
