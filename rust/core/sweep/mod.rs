//! The sweep engine: named axes in, one number (or a reduction over one axis)
//! per cell out, over threads and SIMD lanes, with the same bits whatever their
//! number.

mod chunks;
mod columns;
mod gait_outputs;
mod grid;
mod job;
mod kernel;
mod outputs;
pub mod pool;
mod reduce;
mod registry;
pub mod replay;
mod run;
mod runs;
mod scalar;
mod simulation;
mod trace;
mod trajectories;

pub use chunks::Buffer;
pub use gait_outputs::GaitOutput;
pub use grid::{Axis, Grid};
pub use job::{Job, Request};
pub use outputs::Output;
pub use pool::threads_to_use;
pub use reduce::Reduce;
pub use registry::{Entry, QUANTITIES};
pub use run::{Control, DEFAULT_CHUNK, FRESH_CHUNK, Options, run};
pub use simulation::Choice;
pub use trace::{Traces, trace};
