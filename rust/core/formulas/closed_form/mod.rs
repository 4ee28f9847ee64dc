//! QUANTITY REGISTRY: what a sweep can compute. A new quantity is one `impl
//! Quantity` in the file of its topic and one line in `for_each_quantity!`.

mod continuous;
mod energy;
mod forces;
mod motion;
mod optimum;
mod phase;
mod pipe;
mod slip;
mod traction;

pub use continuous::OptimalSegments;
pub use energy::*;
pub use forces::*;
pub use motion::*;
pub use optimum::*;
pub use pipe::*;
pub use slip::*;

use super::params::used_by;
use super::{Point, Status};
use crate::describe::Info;
use crate::lane::Lane;

/// A closed form over the parameters of a point.
pub trait Quantity: 'static {
    const INFO: Info;
    /// One bit per parameter that enters. Worked out here once per quantity: a kernel's own
    /// constant would be, for each of its variants.
    const USED: u128 = used_by(Self::INFO.params);

    /// NaN exactly where there is no value.
    ///
    /// `PLAIN` promises what most sweeps fulfil: no limit of force or speed, no
    /// brake, no viscosity, no anchors ahead, no down-hill slope and more
    /// segments than move. The result then has the same bits as without the
    /// promise; only the work for the rest is left out at compile time.
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L;

    /// Why a point has no value; asked only where `value` is NaN.
    fn status(p: &Point<f64>) -> Status;

    /// A cheaper number that rises with the value: `value^SCORE_POWER` up to a
    /// positive factor that does not vary between rivals. A score at or below
    /// `SCORE_FLOOR` means no value.
    #[inline(always)]
    fn score<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        Self::value::<L, PLAIN>(p)
    }
    const SCORE_POWER: f64 = 1.0;
    const SCORE_FLOOR: f64 = f64::NEG_INFINITY;
}

/// Calls a macro with every quantity, in the order users see them.
#[macro_export]
macro_rules! for_each_quantity {
    ($mac:ident) => {
        $mac! {
            AnchorCapacity,
            PropulsiveForce,
            Resistance,
            NetForce,
            FrictionForce,
            Acceleration,
            PhaseTime,
            CycleTime,
            MeanVelocity,
            PeakSpeed,
            Velocity,
            VelocityLimit,
            TimeConstant,
            OptimalSegments,
            BestSegments,
            BestVelocity,
            SlopeLimitDeg,
            Feasible,
            AnchorReserve,
            AnchorSafety,
            SlipRatio,
            NetAdvance,
            CostOfTransport,
            MeanPower,
            PeakPower,
            ImpactLoss,
            Preload,
        }
    };
}

/// Lists parameter names: those of what anchors hold, and more.
macro_rules! anchors {
    ($($more:literal),*) => {
        &["mu_static", "segments", "slope_deg", "mass", "gravity", "moving", "anchor_weight",
          "skin_ratio", "wall_force", "corner_deg" $(, $more)*]
    };
}
pub(crate) use anchors;

/// Lists parameter names: those of what an anchor holds and what drags a mover, and more.
macro_rules! any_count {
    ($($more:literal),*) => {
        &["mu_static", "mu_coulomb", "slope_deg", "mass", "gravity", "moving", "anchor_weight",
          "skin_ratio", "wall_force", "wall_release", "corner_deg" $(, $more)*]
    };
}
pub(crate) use any_count;

/// The same with the segment count.
macro_rules! ground {
    ($($more:literal),*) => { $crate::closed_form::any_count!("segments" $(, $more)*) };
}
pub(crate) use ground;
