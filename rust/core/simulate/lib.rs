//! Trajectories of packs of cells: integrators joined to friction laws and compiled per SIMD
//! level. A layer of its own, since that takes long.

mod bounds;
pub mod outputs;
pub mod packs;
mod scalar;
pub mod simulation;
pub mod trajectories;

use locosweep_base::{describe, error, lane};
use locosweep_cells::{columns, grid};
use {locosweep_integrate as integrate, locosweep_physics as physics};
