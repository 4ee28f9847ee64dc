//! The cells of a grid: their parameters as columns, and the closed forms over them,
//! compiled per quantity, per set of varying parameters and per SIMD level. A layer of
//! its own, since these kernels take long to compile and seldom change.

pub mod closed;
pub mod columns;
pub mod grid;
pub mod kernel;

use locosweep_base::{describe, error, lane};
use locosweep_formulas as physics;
