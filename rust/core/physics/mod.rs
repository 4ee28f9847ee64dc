//! The physics, written once: parameters, what holds and what drags, and the
//! closed forms. Forces in N, forward (up-hill) positive; SI throughout, angles
//! enter in degrees and are turned into sine and cosine once per axis value.

pub mod closed_form;
pub mod drive;
pub mod effects;
pub mod friction;
pub mod gait;
pub mod params;
pub mod point;
pub mod robot;
pub mod segment;
pub mod status;

pub use closed_form::Quantity;
pub use gait::Gait;
pub use params::{PARAMS, ParamId};
pub use point::Point;
pub use robot::Robot;
pub use status::Status;
