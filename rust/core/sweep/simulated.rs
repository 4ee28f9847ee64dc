//! Simulated quantities of a block of cells: one simulation serves all of them.

use super::gait_outputs::GaitOutput;
use super::job::Job;
use super::registry::Evaluation;
use crate::cells::columns::{Columns, PADDING};
use crate::integrate::Watch;
use crate::integrate::robot::ensemble;
use crate::lane::Level;
use crate::physics::Status;
use crate::simulate::outputs::Output;
use crate::simulate::packs::{Fate, Stretch};
use crate::simulate::trajectories::simulate;
use std::sync::atomic::AtomicBool;

/// Cells that are simulated together.
pub const SIMULATED_BLOCK: usize = 256;
/// Cells of a chunk: trajectories take longer than formulas.
pub const SIMULATED_CHUNK: usize = 1024;

/// First cell, number of cells, and index of the rival.
pub type BlockKey = (usize, usize, usize);

/// The last block's results.
pub struct Simulated {
    watch: Watch,
    /// Of what the results are, for segments and for robots.
    known: [Option<BlockKey>; 2],
    outputs: Vec<(Output, Vec<f64>)>,
    fates: Vec<f64>,
    gaits: Vec<(GaitOutput, Vec<f64>)>,
    statuses: Vec<Status>,
}

impl Simulated {
    pub fn new(job: &Job) -> Simulated {
        let mut outputs: Vec<(Output, Vec<f64>)> = Vec::new();
        let mut gaits: Vec<(GaitOutput, Vec<f64>)> = Vec::new();
        for request in &job.requests {
            match request.entry.evaluation {
                Evaluation::Trajectory(output)
                    if outputs.iter().all(|(known, _)| *known != output) =>
                {
                    outputs.push((output, Vec::new()));
                }
                Evaluation::Gait(output) if gaits.iter().all(|(known, _)| *known != output) => {
                    gaits.push((output, Vec::new()));
                }
                _ => {}
            }
        }
        let watch = Output::watch(outputs.iter().map(|(output, _)| *output));
        let (fates, statuses) = (Vec::new(), Vec::new());
        Simulated { watch, known: [None; 2], outputs, fates, gaits, statuses }
    }

    /// Values of one simulated quantity on the cells that `columns` point at.
    pub fn values(
        &mut self,
        job: &Job,
        level: Level,
        cancel: &AtomicBool,
        columns: Columns,
        evaluation: Evaluation,
        key: BlockKey,
    ) -> &[f64] {
        let len = key.1;
        let robots = matches!(evaluation, Evaluation::Gait(_));
        if self.known[usize::from(robots)] != Some(key) {
            if robots {
                self.walk(job, level, cancel, columns, len);
            } else {
                self.simulate(job, level, cancel, columns, len);
            }
            self.known[usize::from(robots)] = Some(key);
        }
        let found = match evaluation {
            Evaluation::Closed(_) => None,
            Evaluation::Trajectory(output) => {
                self.outputs.iter().find(|known| known.0 == output).map(|k| &k.1)
            }
            Evaluation::Gait(output) => {
                self.gaits.iter().find(|known| known.0 == output).map(|k| &k.1)
            }
        };
        found.map_or(&[], |values| &values[..len])
    }

    fn simulate(
        &mut self,
        job: &Job,
        level: Level,
        cancel: &AtomicBool,
        columns: Columns,
        len: usize,
    ) {
        let Some(simulation) = &job.simulation else { return };
        let (count, len) = (len, len.next_multiple_of(PADDING));
        self.fates.resize(len, 0.0);
        for (_, values) in &mut self.outputs {
            values.resize(len, f64::NAN);
        }
        simulate(
            level,
            Stretch {
                columns,
                simulation,
                watch: self.watch,
                count,
                len,
                outputs: &mut self.outputs,
                fates: &mut self.fates,
                trace: None,
                cancel,
            },
        );
    }

    fn walk(&mut self, job: &Job, level: Level, cancel: &AtomicBool, columns: Columns, len: usize) {
        let Some(gait) = job.gait else { return };
        self.statuses.resize(len, Status::NotFinite);
        for (_, values) in &mut self.gaits {
            values.resize(len, f64::NAN);
        }
        ensemble(level, gait, len, &|i| columns.row(i), cancel, &mut |i, tally| {
            self.statuses[i] = tally.status();
            for (output, values) in &mut self.gaits {
                // Beyond what a double holds is no value.
                let value = output.of(&tally);
                values[i] = if value.is_finite() { value } else { f64::NAN };
            }
        });
    }

    /// Why cell `i` of the last block has no value.
    pub fn status(&self, i: usize, output: Output) -> Status {
        match self.fates.get(i).map_or(Status::Ok, |fate| status_of(*fate)) {
            status if status != Status::Ok => status,
            _ if output == Output::StrokeTime => Status::NotReached,
            _ => Status::NotFinite,
        }
    }

    /// The same for whole robots.
    pub fn gait_status(&self, i: usize) -> Status {
        match self.statuses.get(i) {
            Some(Status::Ok) | None => Status::NotFinite,
            Some(status) => *status,
        }
    }
}

/// What became of a trajectory, as a status.
pub fn status_of(fate: f64) -> Status {
    match fate {
        Fate::LOST => Status::Unresolved,
        Fate::DIVERGED => Status::Diverged,
        Fate::LONG => Status::TooManySteps,
        _ => Status::Ok,
    }
}
