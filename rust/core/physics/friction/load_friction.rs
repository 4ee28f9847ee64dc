//! Friction that the drive itself presses onto the ground.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::params::ParamId;

pub struct LoadFriction;

#[derive(Clone, Copy)]
pub struct Pressed<L> {
    contact: Contact<L>,
    load: L,
}

/// A level with what the drive adds by pressing the segment to the ground.
#[inline(always)]
pub fn pressed<L: Lane>(level: L, drive: L, load: L) -> L {
    load.mul_add(drive.abs(), level)
}

impl<L: Lane> Pressed<L> {
    #[inline(always)]
    fn beside(&self, level: L, at: &ContactState<L>) -> L {
        pressed(level, at.drive, self.load)
    }
}

impl Law for LoadFriction {
    const INFO: LawInfo = LawInfo {
        name: "load_friction",
        formula: r"F = (F_C + \mu_l |F_P|)\,\mathrm{sgn}\,v + \mu_V v,\quad |F| \le F_S + \mu_l |F_P| \text{ at rest}",
        source: "load-dependent friction of drives, as in robot gear models (Dohring, Lee and Newman 1993)",
        limits: "jumps with the drive force; from 1 on the drive locks itself",
        meaning: "levels that rise with the force of the drive",
        params: &["mu_static", "mu_coulomb", "viscous", "load_friction"],
        reference: ReferenceValue {
            // 4.2 + 0.1*|-5| + 0.5*2.
            parameters: &[
                ("mu_static", 0.5),
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 12.0),
                ("viscous", 0.5),
                ("load_friction", 0.1),
            ],
            speed: 2.0,
            at: (0.0, 0.0, -5.0),
            force: 5.7,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Pressed<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Pressed<L> {
        Pressed { contact: *contact, load: params.get(ParamId::LoadFriction) }
    }
}

impl Dry for LoadFriction {
    const LINEAR: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(law: &Pressed<L>, speed: L, at: &ContactState<L>) -> L {
        law.contact.viscous.mul_add(speed, law.beside(law.contact.coulomb, at))
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Pressed<L>, at: &ContactState<L>) -> L {
        law.beside(law.contact.break_away, at)
    }
    #[inline(always)]
    fn linear<L: Lane>(law: &Pressed<L>, at: &ContactState<L>) -> (L, L) {
        (law.beside(law.contact.coulomb, at), law.contact.viscous)
    }
}
