//! Replays of measured drives, their derivatives, and displacements along measured motion, of
//! packs of models: compiled per SIMD level. A layer of its own, since that takes long.

pub mod displacements;
pub mod packs;
pub mod sensitivity;

use locosweep_base::lane;
use {locosweep_integrate as integrate, locosweep_physics as physics};
