//! A patch of other friction on the track.

use super::{Contact, Dry, Given, Law, LawInfo, Place, Worked};
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
    fn at(&self, level: L, place: &Place<L>) -> L {
        let on = L::and(self.start.le(place.x), place.x.lt(self.end));
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
        worked: Worked {
            // 2*4.2 + 0.5*2 on the patch.
            given: &[
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
            ..Worked::NONE
        },
    };
    type Set<L: Lane> = Edges<L>;

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, given: &impl Given<L>) -> Edges<L> {
        let start = given.get(ParamId::PatchStart);
        Edges {
            contact: *contact,
            start,
            end: start + given.get(ParamId::PatchLength),
            ratio: given.get(ParamId::PatchRatio),
        }
    }
}

impl Dry for Patch {
    const PLACED: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(set: &Edges<L>, speed: L, place: &Place<L>) -> L {
        set.contact.viscous.mul_add(speed, set.at(set.contact.coulomb, place))
    }
    #[inline(always)]
    fn holding<L: Lane>(set: &Edges<L>, place: &Place<L>) -> L {
        set.at(set.contact.holding, place)
    }
}
