//! Closed forms of rectilinear locomotion and the engine that sweeps them.
//!
//! Modules stand in the order of dependence: a lower line may use the ones
//! above it, never the other way round.

pub mod describe;
pub mod error;
pub mod fit;
pub mod integrate;
pub mod lane;
pub mod physics;
pub mod sweep;

pub use error::{Error, Result};
