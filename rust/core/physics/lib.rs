//! The physics, written once: friction, drives, effects, robots and gaits, and from the
//! layer below the parameters and closed forms, so that whoever uses this has them all.

pub mod drive;
pub mod effects;
pub mod friction;
pub mod gait;
pub mod lubricant;
pub mod robot;
pub mod segment;

pub use gait::Gait;
pub use locosweep_formulas::*;
pub use robot::Robot;

use locosweep_base::{describe, error, lane};
