//! The laws as one table: what each is, and its functions for a single contact.

use super::imposed::{self, Motion};
use super::*;
use crate::describe::nearest;
use crate::error::{Error, Result};

impl ContactState<f64> {
    /// The origin of the track, no sliding since a reversal, no drive.
    pub fn start(direction: f64) -> Self {
        ContactState { direction, x: 0.0, sliding_distance: 0.0, drive: 0.0, t: 0.0 }
    }
}

/// A law as users of the registry see it.
pub struct LawEntry {
    pub info: LawInfo,
    pub kind: Kind,
    /// Number of states of a bristle law.
    pub states: usize,
    /// Motion between events is known in closed form (see `Dry::LINEAR`).
    pub linear: bool,
    /// Friction depends on where the segment is or on the sliding distance since reversal.
    pub placed: bool,
    /// A dry law's force against the motion, at a speed counted along
    /// `at.direction`; of the others the signed force at a signed speed.
    pub resistance: fn(&Values, f64, &ContactState<f64>, &[f64; MOST_STATES]) -> f64,
    /// The friction characteristic: signed force of steady sliding at a signed
    /// speed other than 0, at the start of the track without a drive.
    pub steady: fn(&Values, f64) -> f64,
    /// The largest force in direction `at.direction` that does not start motion: 0
    /// for a smooth law, the steady force of the slowest sliding for bristles.
    pub break_away: fn(&Values, &ContactState<f64>) -> f64,
    /// The signed force at some samples of an imposed motion, under the normal
    /// force given there; of a dry law at rest what it holds.
    pub imposed: fn(&Values, &Motion, &[usize], &mut [f64]),
}

impl LawEntry {
    pub fn parse(name: &str) -> Result<&'static LawEntry> {
        let names = || LAWS.iter().map(|law| law.info.name);
        LAWS.iter().find(|law| law.info.name == name).ok_or_else(|| Error::UnknownName {
            kind: "friction law",
            given: name.to_owned(),
            nearest: nearest(name, names()).map(str::to_owned),
            known: names().map(str::to_owned).collect(),
        })
    }

    pub fn uses(&self, id: ParamId) -> bool {
        NORMAL.contains(&id) || self.info.params.contains(&id.param().name)
    }

    /// Checks that every parameter of the law has a value.
    pub fn check(&self, values: &Values) -> Result<()> {
        match ParamId::all().find(|id| self.uses(*id) && values.get(*id).is_nan()) {
            Some(id) => Err(Error::MissingParameter {
                name: id.param().name.to_owned(),
                quantity: format!("friction law {}", self.info.name),
            }),
            None => Ok(()),
        }
    }

    const fn dry<D: Dry>() -> LawEntry {
        LawEntry {
            info: D::INFO,
            kind: Kind::Dry,
            states: 0,
            linear: D::LINEAR,
            placed: D::PLACED,
            resistance: |values, speed, at, _| D::resistance(&coefficients::<D>(values), speed, at),
            steady: |values, v| {
                let direction = if v < 0.0 { -1.0 } else { 1.0 };
                direction
                    * D::resistance(
                        &coefficients::<D>(values),
                        v.abs(),
                        &ContactState::start(direction),
                    )
            },
            break_away: |values, at| D::break_away(&coefficients::<D>(values), at),
            imposed: imposed::dry::<D>,
        }
    }

    const fn smooth<S: Smooth>() -> LawEntry {
        LawEntry {
            info: S::INFO,
            kind: Kind::Smooth,
            states: 0,
            linear: false,
            placed: false,
            resistance: |values, speed, _, _| S::force(&coefficients::<S>(values), speed),
            steady: |values, v| S::force(&coefficients::<S>(values), v),
            break_away: |_, _| 0.0,
            imposed: imposed::smooth::<S>,
        }
    }

    const fn bristle<B: Bristle>() -> LawEntry {
        LawEntry {
            info: B::INFO,
            kind: Kind::Bristle,
            states: B::STATES,
            linear: false,
            placed: false,
            resistance: |values, speed, _, states| {
                let law = coefficients::<B>(values);
                B::force(&law, speed, states, &B::rates(&law, speed, states))
            },
            steady: steady::<B>,
            break_away: |values, at| at.direction * steady::<B>(values, at.direction * SLOWEST),
            imposed: imposed::bristle::<B>,
        }
    }
}

/// Far below every Stribeck speed, m/s.
const SLOWEST: f64 = 1e-30;

fn coefficients<T: Law>(values: &Values) -> T::Coefficients<f64> {
    T::coefficients(&Contact::of(values), values)
}

fn steady<B: Bristle>(values: &Values, v: f64) -> f64 {
    let law = coefficients::<B>(values);
    // Nothing changes in steady sliding: a rate rounded off zero would be
    // multiplied by the damping.
    B::force(&law, v, &B::steady(&law, v), &[0.0; MOST_STATES])
}

macro_rules! entries {
    ($($kind:ident $file:ident::$law:ident),+ $(,)?) => {
        /// Every law, in the order users see them.
        pub static LAWS: &[LawEntry] = &[$(LawEntry::$kind::<$law>()),+];
    };
}
crate::for_each_law!(entries);
