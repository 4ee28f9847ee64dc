//! Parameters and what follows from them in closed form. Forces in N, forward (up-hill)
//! positive; SI throughout, angles enter in degrees and are turned into sine and
//! cosine once per axis value.

pub mod closed_form;
pub mod params;
pub mod point;
pub mod status;

pub use closed_form::Quantity;
pub use params::{PARAMS, ParamId};
pub use point::Point;
pub use status::Status;

use locosweep_base::{describe, error, lane};
