//! The sweep engine: named axes in, one number (or a reduction over one axis)
//! per cell out, over threads and SIMD lanes, with the same bits whatever their
//! number.

mod chunks;
mod execute;
pub mod fit;
mod gait_outputs;
mod job;
pub mod pool;
mod reduce;
mod registry;
pub mod replay;
mod simulated;
mod trace;

pub use cells::grid::{Axis, Grid};
pub use chunks::Buffer;
pub use execute::{Control, DEFAULT_CHUNK, FRESH_CHUNK, Options, run};
pub use gait_outputs::GaitOutput;
pub use job::{Job, Request};
pub use pool::threads_to_use;
pub use reduce::Reduce;
pub use registry::{Entry, QUANTITIES};
pub use simulate::outputs::Output;
pub use simulate::simulation::Choice;
pub use trace::{Traces, trace};

use locosweep_base::{describe, error, lane};
use {locosweep_cells as cells, locosweep_integrate as integrate};
use {locosweep_physics as physics, locosweep_replay as replays, locosweep_simulate as simulate};
