//! Replays in batches: lanes are columns of parameters (candidates, perturbed
//! parameters, restarts), over threads, with the same bits whatever their number.

use super::execute::Control;
use super::pool::pool;
use crate::error::{Error, Result};
use crate::lane::Level;
use crate::physics::effects::{Nominal, shortness};
pub use crate::replays::packs::{Column, Part, Run};
use crate::replays::packs::{Group, PACK, Scratch, replay_pack};
pub use crate::replays::sensitivity::{DIRECTIONS, OTHER_DIRECTIONS};
use crate::replays::sensitivity::{Derived, Sensitivity, replay_derived};
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};

/// What the sensors would read, sample by sample, column by column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Readings {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub x_rear: Vec<f64>,
    pub force: Vec<f64>,
}

/// The part of every column, one after another.
fn parts<'a>(to: Part<'a>, lengths: impl Iterator<Item = usize>) -> Vec<Part<'a>> {
    let mut rest = to;
    lengths
        .map(|length| {
            let mut part: Part<'a> = Default::default();
            for (rest, part) in rest.iter_mut().zip(&mut part) {
                let length = length.min(rest.len());
                let (own, others) = std::mem::take(rest).split_at_mut(length);
                (*part, *rest) = (own, others);
            }
            part
        })
        .collect()
}

/// Replays every column; the readings of all of them follow each other.
pub fn replay(
    nominal: &Nominal,
    runs: &[Run],
    columns: &[Column],
    (level, threads): (Level, usize),
    control: &Control,
) -> Result<Readings> {
    let count = samples(columns);
    let new = || vec![0.0; count];
    let mut found = Readings { x: new(), v: new(), x_rear: new(), force: new() };
    let Readings { x, v, x_rear, force } = &mut found;
    replay_into(nominal, runs, columns, (level, threads), control, [x, v, x_rear, force])?;
    Ok(found)
}

/// Samples of all columns.
pub fn samples(columns: &[Column]) -> usize {
    columns.iter().map(|column| column.window.1 - column.window.0).sum()
}

/// The same into x, v, x_rear and force of as many samples, all of them 0, or none where that
/// is not asked for: memory that was never touched stays so where nothing is read.
pub fn replay_into(
    nominal: &Nominal,
    runs: &[Run],
    columns: &[Column],
    (level, threads): (Level, usize),
    control: &Control,
    to: Part,
) -> Result<()> {
    let length = |column: &Column| column.window.1 - column.window.0;
    // Columns that share run, window and effects go side by side. The order
    // within does not matter: no lane looks at its neighbours.
    let key = |column: &Column| (column.run, column.window, column.active);
    let pace = |column: &Column| shortness(column.active, &column.values);
    let parts = parts(to, columns.iter().map(length));
    let mut order: Vec<(&Column, Part<'_>)> = columns.iter().zip(parts).collect();
    // Those of one pace stand together: a pack takes the steps of its slowest lane.
    order.sort_by(|(a, _), (b, _)| key(a).cmp(&key(b)).then_with(|| pace(a).total_cmp(&pace(b))));
    let intervals: Vec<f64> = runs.iter().map(interval).collect();
    let groups: Vec<&mut [(&Column, Part<'_>)]> = order
        .chunk_by_mut(|(a, _), (b, _)| key(a) == key(b))
        .flat_map(|group| group.chunks_mut(PACK))
        .collect();
    let threads = if columns.len() <= PACK { 1 } else { threads };
    let cancel = &control.cancel;
    one_by_one(groups, threads, control, |group, scratch: &mut Scratch| {
        let (count, intervals) = (group.len(), &intervals);
        replay_pack(level, Group { nominal, runs, intervals, group, cancel, scratch });
        count
    })?;
    finished(control, columns.len())
}

/// Replays every column with its derivatives: `directions` of each column are numbers
/// below `DIRECTIONS`. Readings go to `to` as from `replay_into`; derivatives of a column
/// to as many of its lengths as it has directions, one direction after another. What is not
/// asked for is empty in both.
pub fn replay_with_sensitivities(
    nominal: &Nominal,
    runs: &[Run],
    columns: &[(Column, Vec<usize>)],
    (level, threads): (Level, usize),
    control: &Control,
    (to, slopes): (Part, Part),
) -> Result<()> {
    let length = |(column, _): &(Column, Vec<usize>)| column.window.1 - column.window.0;
    let readings = parts(to, columns.iter().map(length));
    let all = |column: &(Column, Vec<usize>)| length(column) * column.1.len();
    let slopes = parts(slopes, columns.iter().map(all));
    let intervals: Vec<f64> = runs.iter().map(interval).collect();
    let tasks: Vec<_> = columns.iter().zip(readings.into_iter().zip(slopes)).collect();
    let cancel = &control.cancel;
    one_by_one(tasks, threads.min(columns.len()), control, |task, (): &mut ()| {
        let ((column, directions), (readings, slopes)) = task;
        let (run, interval) = (&runs[column.run], intervals[column.run]);
        let to = Derived { readings, slopes };
        let one = Sensitivity { nominal, run, interval, column, directions, cancel, to };
        replay_derived(level, one);
        1
    })?;
    finished(control, columns.len())
}

/// Takes tasks from a queue, on as many threads, each with a memory of its own, until all are
/// done or the run is cancelled; `work` returns how many columns a task has.
pub(super) fn one_by_one<T: Send, S: Default>(
    tasks: Vec<T>,
    threads: usize,
    control: &Control,
    work: impl Fn(T, &mut S) -> usize + Sync,
) -> Result<()> {
    let queue = Mutex::new(tasks.into_iter());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    spread_over(threads, || {
        let mut memory = S::default();
        while let Some(task) = next() {
            if control.cancel.load(Ordering::Relaxed) {
                return;
            }
            let count = work(task, &mut memory) as u64;
            control.done.fetch_add(count, Ordering::Relaxed);
        }
    })
}

/// Runs `work` on as many threads.
pub(super) fn spread_over(threads: usize, work: impl Fn() + Sync) -> Result<()> {
    if threads <= 1 {
        work();
        return Ok(());
    }
    pool(threads)?.scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|_| work());
        }
    });
    Ok(())
}

/// What a call returns that may have been cancelled.
pub(super) fn finished(control: &Control, total: usize) -> Result<()> {
    if control.cancel.load(Ordering::Relaxed) {
        let done = control.done.load(Ordering::Relaxed);
        return Err(Error::Cancelled { done, total: total as u64 });
    }
    Ok(())
}

/// The usual time between samples: their median.
pub(super) fn interval(run: &Run) -> f64 {
    let mut steps: Vec<f64> = run.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 1.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}
