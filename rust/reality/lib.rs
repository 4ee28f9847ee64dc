//! What a robot or a test bench really does in the blind check, and what its
//! sensors then read.
//!
//! A second opinion on the measured plant: plain numbers, small steps, its own
//! formulas. It depends on nothing, least of all on the engine that is checked.

pub mod batch;
pub mod effects;
pub mod rig;
pub mod run;

mod body;
mod disturbances;
mod drive;
mod friction;
mod head;
mod sensor;
mod transmission;

/// All of this crate: a case drawn with other sources is another case.
pub const SOURCE: &str = include_str!(concat!(env!("OUT_DIR"), "/source.txt"));

pub use batch::{Job, run_all};
pub use effects::{Effect, FORMS, Form};
pub use rig::Rig;
pub use run::{Readings, Samples, simulate};
