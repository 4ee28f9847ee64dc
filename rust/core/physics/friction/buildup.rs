//! Lubricant that piles up before a segment that moves forward.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::params::ParamId;

pub struct Buildup;

#[derive(Clone, Copy)]
pub struct Heap<L> {
    coulomb: L,
    viscous: L,
    height: L,
    root: L,
    plough: L,
}

impl<L: Lane> Heap<L> {
    /// Coulomb level and what the heap yields at, which only a forward segment
    /// pushes.
    #[inline(always)]
    fn level(&self, at: &ContactState<L>) -> L {
        let sliding_distance = at.sliding_distance.max(at.sliding_distance.splat(0.0));
        let heap = self.height.mul_add(sliding_distance, self.root * sliding_distance.sqrt());
        self.coulomb + ploughed(heap, at)
    }
}

/// A force that only a segment moving forward meets.
#[inline(always)]
pub fn ploughed<L: Lane>(force: L, at: &ContactState<L>) -> L {
    let zero = force.splat(0.0);
    L::select(at.direction.lt(zero), zero, force)
}

impl Law for Buildup {
    const INFO: LawInfo = LawInfo {
        name: "buildup",
        formula: r"F = F_C\,\mathrm{sgn}\,v + \mu_V v + \left(k_b s + c_1 \sqrt{s} + c_3 v^2\right)_{v > 0},\quad s \text{ swept since the last rest or turn}",
        source: "this project's own model, after the lubricant piled up in the paper's Figures 10 and 11",
        limits: "the heap is gone at each rest or turn; the root is infinitely steep at its start; the mass of the heap is left out",
        meaning: "friction that grows with the lubricant pushed along",
        params: &["mu_coulomb", "viscous", "buildup", "buildup_root", "snowplough"],
        reference: ReferenceValue {
            // 4.2 + 0.5*2 + 10*0.04 + 3*0.2 + 0.7*4.
            parameters: &[
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 12.0),
                ("viscous", 0.5),
                ("buildup", 10.0),
                ("buildup_root", 3.0),
                ("snowplough", 0.7),
            ],
            speed: 2.0,
            at: (0.0, 0.04, 0.0),
            force: 9.0,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Heap<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Heap<L> {
        Heap {
            coulomb: contact.coulomb,
            viscous: contact.viscous,
            height: params.get(ParamId::Buildup),
            root: params.get(ParamId::BuildupRoot),
            plough: params.get(ParamId::Snowplough),
        }
    }
}

impl Dry for Buildup {
    const PLACED: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(law: &Heap<L>, speed: L, at: &ContactState<L>) -> L {
        let linear = law.viscous.mul_add(speed, law.level(at));
        (ploughed(law.plough, at) * speed).mul_add(speed, linear)
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Heap<L>, at: &ContactState<L>) -> L {
        law.level(at)
    }
}
