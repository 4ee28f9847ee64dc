//! Trajectories and replays of packs of cells: integrators joined to friction laws and
//! compiled per SIMD level. A layer of its own, since that takes long.

mod bounds;
pub mod displacements;
pub mod outputs;
pub mod packs;
pub mod replay;
mod scalar;
pub mod sensitivity;
pub mod simulation;
pub mod trajectories;

use locosweep_base::{describe, error, lane};
use locosweep_cells::{columns, grid};
use {locosweep_integrate as integrate, locosweep_physics as physics};
