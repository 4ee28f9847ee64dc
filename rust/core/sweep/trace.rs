//! Trajectories themselves, at evenly spread times: for looking, not for sweeps.

use super::execute::{Control, Options};
use super::job::Job;
use super::pool::pool;
use super::simulated::{SIMULATED_BLOCK, status_of};
use crate::cells::columns::{Cursor, PADDING, Vary};
use crate::error::{Error, Result};
use crate::integrate::Watch;
use crate::physics::Status;
use crate::simulate::packs::{Stretch, Trace};
use crate::simulate::trajectories::simulate;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};

/// Position, speed, drive force and direction of sliding (0 at rest) of every
/// cell at every station: cells in C order, stations fastest.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Traces {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub force: Vec<f64>,
    pub direction: Vec<f64>,
    /// Code of each cell; one that has diverged has no states from there on.
    pub statuses: Vec<u8>,
}

/// Simulates every cell of a job and keeps its state at `stations`, shares of
/// the duration that rise from 0 to 1.
pub fn trace(job: &Job, stations: &[f64], options: Options, control: &Control) -> Result<Traces> {
    let Some(simulation) = &job.simulation else {
        return Err(Error::BadOption {
            name: "quantity",
            given: "a closed form".to_owned(),
            allowed: "quantities that are simulated".to_owned(),
        });
    };
    let (cells, count) = (job.cells(), stations.len());
    let make = || vec![f64::NAN; cells * count];
    let statuses = vec![Status::Ok as u8; cells];
    let mut traces = Traces { x: make(), v: make(), force: make(), direction: make(), statuses };
    let watch = Watch { energy: false, stroke: false, peaks: false };
    {
        let size = SIMULATED_BLOCK * count.max(1);
        let fields = [&mut traces.x, &mut traces.v, &mut traces.force, &mut traces.direction];
        let mut parts = fields.map(|field| field.chunks_mut(size));
        let mut codes = traces.statuses.chunks_mut(SIMULATED_BLOCK);
        let blocks = std::iter::from_fn(|| {
            let [x, v, force, direction] = &mut parts;
            Some(([x.next()?, v.next()?, force.next()?, direction.next()?], codes.next()?))
        });
        let queue = Mutex::new(blocks.enumerate());
        let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = || {
            let mut cursor = Cursor::new(&job.layout, &job.fixed);
            let mut buffers: [Vec<f64>; 4] = Default::default();
            let mut fates = Vec::new();
            while let Some((number, (mut targets, codes))) = next() {
                let (begin, len) = (number * SIMULATED_BLOCK, targets[0].len() / count);
                let mut offset = 0;
                while offset < len && !control.cancel.load(Ordering::Relaxed) {
                    let cell = begin + offset;
                    let left_in_row = job.layout.row - cell % job.layout.row;
                    let now = left_in_row.min(len - offset);
                    let padded = now.next_multiple_of(PADDING);
                    for buffer in &mut buffers {
                        buffer.clear();
                        buffer.resize(padded * count, f64::NAN);
                    }
                    fates.resize(padded, 0.0);
                    let [x, v, force, direction] = &mut buffers;
                    simulate(
                        options.level,
                        Stretch {
                            columns: cursor.at(cell, Vary::ANY),
                            simulation,
                            watch,
                            count: now,
                            len: padded,
                            outputs: &mut [],
                            fates: &mut fates,
                            trace: Some(Trace { stations, x, v, force, direction }),
                            cancel: &control.cancel,
                        },
                    );
                    for (code, fate) in codes[offset..].iter_mut().zip(&fates[..now]) {
                        *code = status_of(*fate) as u8;
                    }
                    for (target, buffer) in targets.iter_mut().zip(&buffers) {
                        for (i, one) in
                            target[offset * count..].chunks_mut(count).take(now).enumerate()
                        {
                            for (k, value) in one.iter_mut().enumerate() {
                                *value = buffer[k * padded + i];
                            }
                        }
                    }
                    control.done.fetch_add(now as u64, Ordering::Relaxed);
                    offset += now;
                }
            }
        };
        let workers = options.threads.min(cells.div_ceil(SIMULATED_BLOCK));
        if workers <= 1 {
            work();
        } else {
            pool(options.threads)?.scope(|scope| {
                for _ in 0..workers {
                    scope.spawn(|_| work());
                }
            });
        }
    }
    if control.cancel.load(Ordering::Relaxed) {
        let done = control.done.load(Ordering::Relaxed);
        return Err(Error::Cancelled { done, total: cells as u64 });
    }
    Ok(traces)
}
