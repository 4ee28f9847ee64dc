//! Closed forms of rectilinear locomotion and the engine that sweeps them.
//!
//! Every layer is a crate, so that an edit compiles anew only what stands on it, and no
//! compiler holds all kernels at once. This one gathers them under one name and adds
//! the fits, the highest layer.

pub mod friction_fit;

pub use locosweep_base::{Error, Result, describe, error, lane};
pub use locosweep_formulas::for_each_quantity;
pub use locosweep_physics::for_each_law;
pub use {
    locosweep_integrate as integrate, locosweep_physics as physics, locosweep_sweep as sweep,
};
