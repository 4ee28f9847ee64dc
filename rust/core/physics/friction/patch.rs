//! A patch of other friction on the track.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::params::ParamId;

pub struct Patch;

#[derive(Clone, Copy)]
pub struct Edges<L> {
    contact: Contact<L>,
    start: L,
    end: L,
    ratio: L,
}

impl<L: Lane> Edges<L> {
    #[inline(always)]
    fn at(&self, level: L, at: &ContactState<L>) -> L {
        let on = L::and(self.start.le(at.x), at.x.lt(self.end));
        L::select(on, level * self.ratio, level)
    }
}

impl Law for Patch {
    const INFO: LawInfo = LawInfo {
        name: "patch",
        formula: r"F = F_C\,\rho(x)\,\mathrm{sgn}\,v + \mu_V v,\quad \rho = \rho_p \text{ for } x_p \le x < x_p + L_p \text{, else } 1",
        source: "piecewise constant friction along the track; this project",
        limits: "jumps at both edges, where fixed steps lose their order; static friction jumps alike; acts at a point, not over the length of a segment",
        meaning: "levels that differ on a patch of the track",
        params: &[
            "mu_static",
            "mu_coulomb",
            "viscous",
            "patch_start",
            "patch_length",
            "patch_ratio",
        ],
        reference: ReferenceValue {
            // 2*4.2 + 0.5*2 on the patch.
            parameters: &[
                ("mu_static", 0.5),
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 12.0),
                ("viscous", 0.5),
                ("patch_start", 0.5),
                ("patch_length", 0.25),
                ("patch_ratio", 2.0),
            ],
            speed: 2.0,
            at: (0.6, 0.0, 0.0),
            force: 9.4,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Edges<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Edges<L> {
        let start = params.get(ParamId::PatchStart);
        Edges {
            contact: *contact,
            start,
            end: start + params.get(ParamId::PatchLength),
            ratio: params.get(ParamId::PatchRatio),
        }
    }
}

impl Dry for Patch {
    const PLACED: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(law: &Edges<L>, speed: L, at: &ContactState<L>) -> L {
        law.contact.viscous.mul_add(speed, law.at(law.contact.coulomb, at))
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Edges<L>, at: &ContactState<L>) -> L {
        law.at(law.contact.break_away, at)
    }
}
