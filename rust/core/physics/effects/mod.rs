//! Effects on measured runs: their registry (`rows`, in the words of `row`), and
//! the plant that takes them up.

mod behind_joint;
mod friction;
mod plant;
mod row;
mod rows;

pub use behind_joint::{BehindJoint, Jointed};
pub use friction::{Coefficients, Measured};
pub use plant::{Body, Joint, Levels, Nominal, Plant, shortness};
pub use row::{
    EffectInfo, EffectParam, LevelForm, Magnitude, Need, Off, Shape, Shown, Site, Variable,
};
pub use rows::{EFFECTS, Effect};

use crate::describe::nearest;
use crate::error::{Error, Result};

/// Number of all parameters of all effects.
pub const EFFECT_PARAMS: usize = {
    let (mut count, mut i) = (0, 0);
    while i < EFFECTS.len() {
        count += EFFECTS[i].params.len();
        i += 1;
    }
    count
};

impl Effect {
    pub fn info(self) -> &'static EffectInfo {
        &EFFECTS[self as usize]
    }

    /// Place of the effect's first parameter among those of all effects.
    pub const fn first(self) -> usize {
        let (mut first, mut i) = (0, 0);
        while i < self as usize {
            first += EFFECTS[i].params.len();
            i += 1;
        }
        first
    }

    pub fn parse(name: &str) -> Result<Effect> {
        let names = || EFFECTS.iter().map(|e| e.name);
        match EFFECTS.iter().position(|e| e.name == name) {
            Some(i) => Ok(Effect::ALL[i]),
            None => Err(Error::UnknownName {
                kind: "effect",
                given: name.to_owned(),
                nearest: nearest(name, names()).map(str::to_owned),
                known: names().map(str::to_owned).collect(),
            }),
        }
    }
}

/// A set of effects, a bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, PartialOrd, Ord)]
pub struct Active(u32);

const _: () = assert!(EFFECTS.len() <= u32::BITS as usize, "Active has no bit for an effect more");

impl Active {
    pub fn with(self, effect: Effect) -> Active {
        Active(self.0 | 1 << effect as usize)
    }

    #[inline(always)]
    pub fn has(self, effect: Effect) -> bool {
        self.0 >> effect as usize & 1 == 1
    }

    pub fn any(self, effects: &[Effect]) -> bool {
        effects.iter().any(|effect| self.has(*effect))
    }

    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.iter().copied().filter(move |effect| self.has(*effect))
    }
}
