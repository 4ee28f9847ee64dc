//! Running a job: chunks of cells over threads, blocks within a chunk, kernels
//! on a block. No cell's result depends on where those cuts fall.

use super::chunks::{Buffer, Chunk, cut};
use super::job::{Job, Request};
use super::pool::pool;
use super::reduce::{Reduce, quantile};
use super::registry::{Entry, Evaluation};
use super::simulated::{SIMULATED_BLOCK, Simulated};
use crate::cells::closed::{Closed, Points, Search};
use crate::cells::columns::{BLOCK, Cursor, PADDING, Vary, is_wide};
use crate::cells::grid::Axis;
use crate::cells::kernel::{FoldAll, FoldBest, Kept, Rivals};
use crate::error::{Error, Result};
use crate::lane::{self, Level, scalar_token, stream};
use crate::physics::closed_form::TIE;
use crate::physics::{ParamId, Status};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Cells of a chunk, the unit of work.
pub const DEFAULT_CHUNK: usize = 1 << 16;
/// The same where memory was never touched: several huge pages each, so that
/// threads do not wait for one another while the system clears a page.
pub const FRESH_CHUNK: usize = 1 << 20;
/// Evaluations between two looks at the cancel flag, in searches.
const PATIENCE: usize = 1 << 16;
/// Results beyond this many bytes do not stay in caches anyway.
const STREAMED: usize = 8 << 20;

#[derive(Debug, Clone, Copy)]
pub struct Options {
    pub threads: usize,
    /// Cells per chunk.
    pub chunk: usize,
    pub level: Level,
    /// The results' memory was never touched: its pages come with their first
    /// write and through the caches, past which nothing should then be stored.
    pub fresh: bool,
}

/// Shared with whoever watches: a flag to stop, a count of finished evaluations.
#[derive(Default)]
pub struct Control {
    pub cancel: AtomicBool,
    pub done: AtomicU64,
}

/// Fills the buffers, each with the result of the request it names.
pub fn run(
    job: &Job,
    buffers: Vec<(usize, Buffer)>,
    options: Options,
    control: &Control,
) -> Result<()> {
    for (request, buffer) in &buffers {
        if buffer.len() != job.cells() {
            return Err(Error::OutSize {
                quantity: job.requests[*request].entry.info.name.to_owned(),
                given: buffer.len(),
                needed: job.cells(),
            });
        }
    }
    let streamed = !options.fresh && job.cells() * size_of::<f64>() > STREAMED;
    let chunks = cut(job, buffers, options.chunk);
    // A worker per thread takes chunks as it gets to them: making one costs more
    // than a small chunk does.
    let workers = options.threads.min(chunks.len());
    let queue = Mutex::new(chunks.into_iter());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let work = || {
        let mut worker = Worker::new(job, options.level, control, streamed);
        while let Some(chunk) = next() {
            worker.chunk(chunk);
        }
    };
    if workers == 1 {
        work();
    } else {
        pool(options.threads)?.scope(|scope| {
            for _ in 0..workers {
                scope.spawn(|_| work());
            }
        });
    }
    if control.cancel.load(Ordering::Relaxed) {
        let done = control.done.load(Ordering::Relaxed);
        return Err(Error::Cancelled { done, total: job.evaluations() });
    }
    Ok(())
}

/// One thread's view of the job and its scratch memory.
struct Worker<'a> {
    job: &'a Job,
    level: Level,
    control: &'a Control,
    streamed: bool,
    cursor: Cursor<'a>,
    scratch: Scratch,
    runs: Simulated,
}

#[derive(Default)]
struct Scratch {
    /// Cells of the block; `values` may be longer, for the widest pack.
    cells: usize,
    values: Vec<f64>,
    best: Vec<f64>,
    at: Vec<f64>,
    count: Vec<f64>,
    chosen: [Vec<f64>; 2],
    trace: Vec<f64>,
}

impl<'a> Worker<'a> {
    fn new(job: &'a Job, level: Level, control: &'a Control, streamed: bool) -> Worker<'a> {
        let cursor = Cursor::new(&job.layout, &job.fixed);
        let (scratch, runs) = (Scratch::default(), Simulated::new(job));
        Worker { job, level, control, streamed, cursor, scratch, runs }
    }

    fn chunk(&mut self, chunk: Chunk) {
        let Chunk { start, len, mut buffers } = chunk;
        let mut offset = 0;
        while offset < len && !self.cancelled() {
            let cell = start + offset;
            let left_in_row = self.job.layout.row - cell % self.job.layout.row;
            let block = left_in_row.min(self.block_size()).min(len - offset);
            for request in 0..self.job.requests.len() {
                if self.write_direct(request, cell, block, &mut buffers, offset) {
                    continue;
                }
                self.compute(request, cell, block);
                for (target, buffer) in &mut buffers {
                    if *target == request {
                        self.emit(request, cell, block, buffer, offset);
                    }
                }
            }
            let rivals = self.job.rival_count().max(1);
            let evaluated = block * rivals * self.job.requests.len();
            self.control.done.fetch_add(evaluated as u64, Ordering::Relaxed);
            offset += block;
        }
        if self.streamed {
            stream::fence();
        }
    }

    /// Lets the kernel write straight into the result, where that is the only
    /// thing to do with it.
    fn write_direct(
        &mut self,
        request: usize,
        cell: usize,
        len: usize,
        buffers: &mut [(usize, Buffer)],
        offset: usize,
    ) -> bool {
        let mut targets = buffers.iter_mut().filter(|(target, _)| *target == request);
        let (Some((_, Buffer::F64(to))), None) = (targets.next(), targets.next()) else {
            return false;
        };
        if self.job.requests[request].reduce.is_some() {
            return false;
        }
        self.dense(request, cell, &mut to[offset..offset + len], self.streamed);
        true
    }

    /// Values of one request, not reduced, on a stretch of cells.
    fn dense(&mut self, request: usize, cell: usize, out: &mut [f64], streamed: bool) {
        match self.job.requests[request].entry.evaluation {
            Evaluation::Closed(Closed { dense, .. }) => {
                let (plain, vary) = self.kernel();
                let points = Points { columns: self.cursor.at(cell, vary as u8), plain, vary };
                dense(self.level, points, out, streamed);
            }
            evaluation => {
                let columns = self.cursor.at(cell, Vary::ANY);
                let cells = (cell, out.len(), 0);
                let (cancel, level) = (&self.control.cancel, self.level);
                let values = self.runs.values(self.job, level, cancel, columns, evaluation, cells);
                out.copy_from_slice(values);
            }
        }
    }

    /// The dense kernel that fits the job: promise and vary class.
    fn kernel(&self) -> (bool, Vary) {
        let plain = self.job.plain && self.job.layout.vary != Vary::Any;
        (plain, if plain { self.job.layout.vary } else { Vary::Any })
    }

    fn cancelled(&self) -> bool {
        self.control.cancel.load(Ordering::Relaxed)
    }

    fn block_size(&self) -> usize {
        let has_quantile = |r: &Request| matches!(r.reduce, Some(Reduce::Quantile(_)));
        if self.job.requests.iter().any(has_quantile) {
            PADDING
        } else if self.job.over.is_some() {
            BLOCK / 4
        } else if self.job.simulates() {
            SIMULATED_BLOCK
        } else {
            BLOCK
        }
    }

    /// Values of one request on a block, into `scratch.values`.
    fn compute(&mut self, request: usize, cell: usize, len: usize) {
        let Request { entry, reduce } = &self.job.requests[request];
        let padded = len.next_multiple_of(PADDING);
        let mut scratch = std::mem::take(&mut self.scratch);
        // Kernels fill what is asked for; what pads a vector up is never handed on.
        scratch.values.resize(padded, f64::NAN);
        scratch.cells = len;
        match reduce {
            None if entry.closed().is_some() => {
                self.dense(request, cell, &mut scratch.values, false);
            }
            // What only fills a pack up is not simulated.
            None => self.dense(request, cell, &mut scratch.values[..len], false),
            Some(reduce) => self.reduce(entry, *reduce, cell, &mut scratch),
        }
        self.scratch = scratch;
    }

    fn reduce(&mut self, entry: &Entry, reduce: Reduce, cell: usize, scratch: &mut Scratch) {
        let cells = scratch.values.len();
        let axis = self.over();
        match reduce {
            Reduce::Argmax | Reduce::Argmin | Reduce::Max | Reduce::Min => {
                self.search(entry, reduce, cell, scratch);
                if reduce.gives_axis_value() {
                    look_up(&axis.values, &scratch.at, &mut scratch.values);
                } else {
                    self.value_at_best(entry, cell, scratch);
                }
            }
            Reduce::Mean | Reduce::Count | Reduce::LastFeasible => {
                reset(&mut scratch.best, cells, 0.0);
                reset(&mut scratch.at, cells, f64::NAN);
                reset(&mut scratch.count, cells, 0.0);
                self.for_each_rival(entry, cell, scratch, |level, index, values, kept| {
                    lane::run(level, FoldAll { values, kept, index });
                });
                match reduce {
                    Reduce::Mean => {
                        for (i, value) in scratch.values.iter_mut().enumerate() {
                            // 0/0 is the NaN of a cell where nothing works.
                            *value = scratch.best[i] / scratch.count[i];
                        }
                    }
                    Reduce::Count => scratch.values.copy_from_slice(&scratch.count),
                    _ => look_up(&axis.values, &scratch.at, &mut scratch.values),
                }
            }
            Reduce::Quantile(q) => {
                let mut trace = std::mem::take(&mut scratch.trace);
                reset(&mut trace, axis.values.len() * cells, f64::NAN);
                self.for_each_rival(entry, cell, scratch, |_, index, values, _| {
                    trace[index * cells..][..cells].copy_from_slice(values);
                });
                let sorted = &mut scratch.best;
                for (i, value) in scratch.values.iter_mut().enumerate() {
                    sorted.clear();
                    sorted.extend(trace.iter().skip(i).step_by(cells).filter(|v| !v.is_nan()));
                    sorted.sort_unstable_by(f64::total_cmp);
                    *value = quantile(sorted, q);
                }
                scratch.trace = trace;
            }
        }
    }

    /// Places of the best rivals, into `scratch.at`.
    fn search(&mut self, entry: &Entry, reduce: Reduce, cell: usize, scratch: &mut Scratch) {
        let cells = scratch.values.len();
        let min = matches!(reduce, Reduce::Argmin | Reduce::Min);
        let margin = if reduce.gives_axis_value() { TIE } else { 0.0 };
        reset(&mut scratch.at, cells, f64::NAN);
        let over = self.over().id;
        // The largest value itself may differ in its last bits from the value of
        // the largest score.
        let plain = self.job.plain && self.job.layout.vary != Vary::Any;
        let searches = |c: &&Closed| reduce != Reduce::Max || c.score_power == 1.0;
        let closed = entry.closed().filter(searches);
        if let (true, Some(closed), ParamId::Segments) = (plain, closed, over) {
            let floor = if min { f64::NEG_INFINITY } else { closed.score_floor };
            reset(&mut scratch.best, cells, floor);
            let ahead = margin * if min { 1.0 } else { closed.score_power };
            let columns = self.cursor.at(cell, Vary::MAIN);
            let [main, derived] = &self.job.rivals;
            let part = (PATIENCE / cells).max(1);
            for first in (0..main.len()).step_by(part) {
                let range = first..(first + part).min(main.len());
                let rivals = Rivals {
                    main: &main[range.clone()],
                    derived: &derived[range.clone()],
                    indices: &self.job.indices[range],
                };
                let search = Search { columns, rivals, ahead, min };
                (closed.extremum)(self.level, search, &mut scratch.best, &mut scratch.at);
                if self.control.cancel.load(Ordering::Relaxed) {
                    return;
                }
            }
            return;
        }
        reset(&mut scratch.best, cells, f64::NEG_INFINITY);
        let sign = if min { -1.0 } else { 1.0 };
        self.for_each_rival(entry, cell, scratch, |level, index, values, kept| {
            lane::run(level, FoldBest { values, kept, index, ahead: margin, sign });
        });
    }

    fn over(&self) -> &'a Axis {
        &self.job.grid.axes[self.job.over.unwrap_or(0)]
    }

    /// Computes the block once per rival, into `scratch.values`, and calls
    /// `fold` with the rival's index, its values and what to keep.
    fn for_each_rival(
        &mut self,
        entry: &Entry,
        cell: usize,
        scratch: &mut Scratch,
        mut fold: impl FnMut(Level, usize, &[f64], Kept),
    ) {
        let id = self.over().id;
        // The reduced parameter joins those that vary within the block.
        let closed = entry.closed().is_some();
        let main = closed && self.job.layout.vary != Vary::Any && is_wide(Vary::MAIN, id.main());
        let vary = if self.job.plain && main { Vary::Main } else { Vary::Any };
        let plain = vary == Vary::Main;
        let (job, level, control) = (self.job, self.level, self.control);
        let columns = self.cursor.at(cell, vary as u8);
        let Scratch { cells, values, chosen, best, at, count, .. } = scratch;
        for index in 0..job.rival_count() {
            if control.cancel.load(Ordering::Relaxed) {
                return;
            }
            for (chosen, rivals) in chosen.iter_mut().zip(&job.rivals) {
                reset(chosen, values.len() + PADDING, rivals[index]);
            }
            let columns = columns.replacing(id, [&chosen[0], &chosen[1]]);
            match entry.evaluation {
                Evaluation::Closed(Closed { dense, .. }) => {
                    dense(level, Points { columns, plain, vary }, values, false);
                }
                evaluation => {
                    let stretch = (cell, *cells, index);
                    let cancel = &control.cancel;
                    let found = self.runs.values(job, level, cancel, columns, evaluation, stretch);
                    values[..*cells].copy_from_slice(found);
                }
            }
            fold(level, index, values, Kept { best, at, count });
        }
    }

    /// The quantity itself at the indices in `scratch.at`.
    fn value_at_best(&mut self, entry: &Entry, cell: usize, scratch: &mut Scratch) {
        let param = self.over().id;
        let columns = self.cursor.at(cell, Vary::ANY);
        let Scratch { cells, chosen, at, values, .. } = scratch;
        for (chosen, rivals) in chosen.iter_mut().zip(&self.job.rivals) {
            reset(chosen, at.len() + PADDING, f64::NAN);
            look_up(rivals, at, chosen);
        }
        let columns = columns.replacing(param, [&chosen[0], &chosen[1]]);
        match entry.evaluation {
            Evaluation::Closed(Closed { dense, .. }) => {
                dense(self.level, Points { columns, plain: false, vary: Vary::Any }, values, false);
            }
            evaluation => {
                let stretch = (cell, *cells, usize::MAX);
                let (job, cancel) = (self.job, &self.control.cancel);
                let found = self.runs.values(job, self.level, cancel, columns, evaluation, stretch);
                values[..*cells].copy_from_slice(found);
            }
        }
        for (value, at) in values.iter_mut().zip(at) {
            if at.is_nan() {
                *value = f64::NAN;
            }
        }
    }

    /// Hands a computed block on.
    fn emit(
        &mut self,
        request: usize,
        cell: usize,
        len: usize,
        buffer: &mut Buffer,
        offset: usize,
    ) {
        let values = &self.scratch.values[..len];
        match buffer {
            Buffer::F64(to) => to[offset..offset + len].copy_from_slice(values),
            Buffer::F32(to) => {
                for (to, value) in to[offset..offset + len].iter_mut().zip(values) {
                    *to = *value as f32;
                }
            }
            Buffer::Status(to) => {
                let Request { entry, reduce } = &self.job.requests[request];
                let columns = self.cursor.at(cell, Vary::ANY);
                let points =
                    columns.reader::<f64, { Vary::ANY }>(scalar_token(), entry.used, 0, len);
                for (i, value) in values.iter().enumerate() {
                    let status = if !value.is_nan() {
                        Status::Ok
                    } else if reduce.is_some() {
                        Status::NoneFeasible
                    } else {
                        match &entry.evaluation {
                            Evaluation::Closed(closed) => (closed.status)(&points.at(i)),
                            Evaluation::Trajectory(output) => self.runs.status(i, *output),
                            Evaluation::Gait(_) => self.runs.gait_status(i),
                        }
                    };
                    to[offset + i] = status as u8;
                }
            }
        }
    }
}

fn reset(buffer: &mut Vec<f64>, len: usize, value: f64) {
    buffer.clear();
    buffer.resize(len, value);
}

/// `to[i] = values[at[i]]`, NaN where there is no index.
fn look_up(values: &[f64], at: &[f64], to: &mut [f64]) {
    for (to, at) in to.iter_mut().zip(at) {
        *to = if at.is_nan() { f64::NAN } else { values[*at as usize] };
    }
}
