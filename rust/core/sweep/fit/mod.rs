//! Least-squares fits of models to measured runs: many models, starts and runs in one
//! job, each replayed, weighed and summed up in the thread that takes it.

mod compared;
mod coordinates;
mod corrections;
mod derivatives;
mod equation_error;
mod evaluate;
mod experiment;
mod job;
mod marquardt;
mod misfit;
mod objective;
mod rows;

pub use compared::{Asked, Compared, Normal};
pub use coordinates::{Coordinate, Fit, Replayed, What};
pub use corrections::{Terms, corrections};
pub use derivatives::jacobian;
pub use equation_error::{Blocks, EquationError, Motion};
pub use evaluate::{Evaluated, evaluate, readings, residuals};
pub use experiment::{Begin, Experiment, Point, Span};
pub use job::How;
pub use marquardt::{Ended, FINE, Rule, fit};
pub use misfit::{Misfit, Shift, Signal, Source};
pub use nalgebra::{DMatrix, DVector};
pub use objective::{Objective, OverSpans};
