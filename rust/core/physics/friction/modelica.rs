//! Friction in the form of the Modelica Standard Library.

use super::fall::Fall;
use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::params::ParamId;

pub struct Modelica;

impl Law for Modelica {
    const INFO: LawInfo = LawInfo {
        name: "modelica",
        formula: r"F = \left[F_C + (F_S - F_C)\,e^{-f_\mathrm{exp}|v|}\right]\mathrm{sgn}\,v + \mu_V v",
        source: "Modelica Standard Library, Mechanics.Translational.Components.MassWithStopAndFriction (F_Str is F_S - F_C, F_prop the viscous coefficient)",
        limits: "the exponential fall of tustin, told by its decay instead of its speed",
        meaning: "exponential fall in the parameters of the Modelica library",
        params: &["mu_static", "mu_coulomb", "viscous", "modelica_decay"],
        reference: ReferenceValue {
            // 4 + 4 e^-0.75 + 2*0.25.
            parameters: &[
                ("mu_static", 0.8),
                ("mu_coulomb", 0.4),
                ("mass", 1.0),
                ("gravity", 10.0),
                ("viscous", 2.0),
                ("modelica_decay", 3.0),
            ],
            speed: 0.25,
            force: 6.389_466_210_964_059,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Fall<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Fall<L> {
        Fall::of(contact, params.get(ParamId::ModelicaDecay))
    }
}

impl Dry for Modelica {
    #[inline(always)]
    fn resistance<L: Lane>(law: &Fall<L>, speed: L, _: &ContactState<L>) -> L {
        law.exponential(speed)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Fall<L>, _: &ContactState<L>) -> L {
        law.break_away
    }
}
