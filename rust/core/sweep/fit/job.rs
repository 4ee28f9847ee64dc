//! Jobs of many replays: those that can share a pack are put side by side, and what comes
//! of each is worked out in the thread that replayed it.

use super::super::execute::Control;
use super::super::replay::{finished, spread_over};
use super::experiment::Spot;
use super::misfit::Misfit;
use super::rows::Reading;
use crate::error::Result;
use crate::lane::Level;
use crate::physics::effects::{Active, shortness};
use crate::replays::packs::{Group, PACK, Part, Scratch, replay_pack};
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};

/// How a job runs.
pub struct How<'a> {
    pub level: Level,
    pub threads: usize,
    pub control: &'a Control,
}

/// Replays of one model over one span that belong together: a model's own values and those
/// with one of them moved.
pub(super) struct Request {
    pub span: usize,
    active: Active,
    pace: f64,
    columns: usize,
}

impl Request {
    pub fn new(span: usize, spot: &Spot, columns: usize) -> Request {
        let pace = shortness(spot.active, &spot.values);
        Request { span, active: spot.active, pace, columns }
    }
}

/// Columns that one task takes, if no request has more: four packs, so that few lanes stay
/// empty whatever a request takes, and readings stay in a core's cache.
const TASK: usize = 2 * PACK;

/// Numbers of requests that are replayed side by side.
fn tasks(requests: &[Request]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..requests.len()).collect();
    let key = |i: usize| (requests[i].span, requests[i].active);
    // Those of one pace stand together: a pack takes the steps of its slowest lane.
    order.sort_by(|a, b| {
        let pace = |i: usize| requests[i].pace;
        key(*a).cmp(&key(*b)).then_with(|| pace(*a).total_cmp(&pace(*b)))
    });
    let mut tasks: Vec<Vec<usize>> = Vec::new();
    let mut columns = 0;
    for i in order {
        columns += requests[i].columns;
        match tasks.last_mut() {
            Some(task) if key(task[0]) == key(i) && columns <= TASK => task.push(i),
            _ => {
                tasks.push(vec![i]);
                columns = requests[i].columns;
            }
        }
    }
    tasks
}

/// What a thread keeps from task to task.
#[derive(Default)]
struct Workplace {
    scratch: Scratch,
    readings: Vec<f64>,
    rows: Vec<f64>,
}

/// Replays all requests, `spots` of each, and returns what `work` makes of them, which may
/// use some memory of its thread.
pub(super) fn replayed<T: Send>(
    misfit: &Misfit,
    requests: &[Request],
    spots: impl Fn(usize, &mut Vec<Spot>) + Sync,
    how: &How,
    work: impl Fn(usize, &[Reading], &mut Vec<f64>) -> T + Sync,
) -> Result<Vec<T>> {
    let tasks = tasks(requests);
    let found: Mutex<Vec<Option<T>>> = Mutex::new(requests.iter().map(|_| None).collect());
    let count = tasks.len();
    let queue = Mutex::new(tasks.into_iter());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let take = || {
        let mut place = Workplace::default();
        while let Some(task) = next() {
            if how.control.cancel.load(Ordering::Relaxed) {
                return;
            }
            let made = one_task(misfit, requests, &task, &spots, how, &work, &mut place);
            let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
            for (i, value) in task.into_iter().zip(made) {
                found[i] = Some(value);
            }
        }
    };
    spread_over(how.threads.min(count), take)?;
    finished(how.control, requests.len())?;
    let found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(found.into_iter().flatten().collect())
}

fn one_task<T>(
    misfit: &Misfit,
    requests: &[Request],
    task: &[usize],
    spots: &(impl Fn(usize, &mut Vec<Spot>) + Sync),
    how: &How,
    work: &(impl Fn(usize, &[Reading], &mut Vec<f64>) -> T + Sync),
    place: &mut Workplace,
) -> Vec<T> {
    let (experiment, asked) = (&*misfit.experiment, misfit.asked());
    let span = requests[task[0]].span;
    let samples = experiment.spans[span].samples();
    let mut all = Vec::new();
    for i in task {
        spots(*i, &mut all);
    }
    let columns: Vec<_> = all.iter().map(|spot| experiment.column(span, spot)).collect();
    let each = asked.iter().filter(|asked| **asked).count();
    let size = each * samples * columns.len();
    place.readings.resize(place.readings.len().max(size), 0.0);
    let mut parts = place.readings.chunks_exact_mut(samples);
    let mut group: Vec<(_, Part)> = columns
        .iter()
        .map(|(column, _)| {
            let part = asked.map(|asked| asked.then(|| parts.next()).flatten().unwrap_or_default());
            (column, part)
        })
        .collect();
    for (_, [_, _, rear, _]) in &mut group {
        // Of a body that does not slide nothing is written: it reads 0.
        rear.fill(0.0);
    }
    for group in group.chunks_mut(PACK) {
        let work = Group {
            nominal: &experiment.nominal,
            runs: &experiment.runs,
            intervals: &experiment.intervals,
            group,
            cancel: &how.control.cancel,
            scratch: &mut place.scratch,
        };
        replay_pack(how.level, work);
    }
    how.control.done.fetch_add(columns.len() as u64, Ordering::Relaxed);
    let readings: Vec<Reading> = group
        .iter()
        .zip(&columns)
        .map(|((_, parts), (_, added))| Reading {
            parts: std::array::from_fn(|k| &*parts[k]),
            added: *added,
        })
        .collect();
    let mut first = 0;
    let own = |i: &usize| {
        let own = &readings[first..first + requests[*i].columns];
        first += own.len();
        work(*i, own, &mut place.rows)
    };
    task.iter().map(own).collect()
}
