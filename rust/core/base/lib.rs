//! What all layers share: records of what things are, errors, numbers in lanes.

pub mod describe;
pub mod error;
pub mod lane;

pub use error::{Error, Result};
