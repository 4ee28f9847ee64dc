//! Friction laws fitted to measured motion and friction force, with what each
//! leaves on samples it was not fitted to.

mod candidate;
mod search;
pub mod spread;
pub mod squares;
pub mod ties;
pub mod velocity;

pub use candidate::{Candidate, FALLS, FROZEN, Free, Pressing, Scales, What};
pub use search::fit;

use crate::error::{Error, Result};
use crate::lane::Level;
use crate::physics::friction::imposed::Motion;
use crate::physics::friction::{LawEntry, Values};
use crate::physics::params::ParamId;
use crate::sweep::Control;
use crate::sweep::fit::How;
use crate::sweep::pool::pool;
use spread::median;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};

/// One measured run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The normal force is filled in for each candidate.
    pub motion: Motion,
    /// Measured friction force, with the sign of the motion it opposes.
    pub force: Vec<f64>,
    /// Load at every sample; all 0 without one.
    pub load: Vec<f64>,
    /// Samples that count, rising.
    pub rows: Vec<usize>,
    /// The fold of each of them: it is predicted by a fit without its fold.
    pub folds: Vec<u8>,
}

/// Fold of samples that are only fitted to.
pub const FITTED: u8 = 255;

/// Measured runs and the normal force where the load does not give it.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    pub runs: Vec<Run>,
    pub normal: f64,
    /// The slowest motion that counts as motion.
    pub slowest: f64,
}

impl Measured {
    pub fn rows(&self) -> impl Iterator<Item = (&Run, usize)> {
        self.runs.iter().flat_map(|run| run.rows.iter().map(move |row| (run, *row)))
    }

    /// Sizes from which ranges and steps are made.
    pub fn scales(&self) -> Scales {
        let of = |f: &dyn Fn(&Run, usize) -> f64| -> f64 {
            median(&self.rows().map(|(run, row)| f(run, row).abs()).collect::<Vec<_>>())
        };
        let mut speeds: Vec<f64> = self.rows().map(|(run, row)| run.motion.v[row].abs()).collect();
        speeds.sort_by(f64::total_cmp);
        let high = speeds.get(speeds.len() * 95 / 100).copied().unwrap_or(1.0);
        let positions = || self.runs.iter().flat_map(|run| run.motion.x.iter().copied());
        let track = (
            positions().fold(f64::INFINITY, f64::min),
            positions().fold(f64::NEG_INFINITY, f64::max),
        );
        let spans: Vec<f64> = self
            .runs
            .iter()
            .map(|run| run.motion.t[run.motion.len() - 1] - run.motion.t[0])
            .collect();
        let intervals: Vec<f64> =
            self.runs.iter().map(|run| velocity::interval(&run.motion.t)).collect();
        let usable = |value: f64| if value > 0.0 { value } else { f64::MIN_POSITIVE.sqrt() };
        Scales {
            force: usable(of(&|run, row| run.force[row])),
            speed: usable(high),
            slowest: usable(self.slowest),
            track: (track.0, track.1.max(track.0 + 1e-9)),
            duration: usable(median(&spans)),
            interval: usable(median(&intervals)),
            normal: self.normal,
            load: of(&|run, row| run.load[row]),
            drive: of(&|run, row| run.motion.drive[row]),
        }
    }
}

/// One parameter as found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    pub what: What,
    pub value: f64,
    /// Infinite where the data say nothing of it, NaN where it has none: an edge,
    /// or a value at the end of its range.
    pub std: f64,
    /// The fit moves its logarithm, which is what errors are even in.
    pub logarithmic: bool,
    /// At an end of its range; of a static level that is the Coulomb one.
    pub bounded: bool,
}

/// A candidate as fitted to all samples that count for fits.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    pub found: Vec<Found>,
    /// Pieces of data that are independent, beyond the parameters.
    pub freedom: f64,
    /// Rows that carry as much as one independent one.
    pub memory: f64,
    /// Root mean square of what is left of the samples fitted to.
    pub rms: f64,
    pub settled: bool,
    /// The force at every row by this fit.
    pub predicted: Vec<f64>,
    /// The same by a fit without the row's fold; NaN where it has none.
    pub held_out: Vec<f64>,
}

/// Fits every candidate, in their order, whatever the number of threads.
pub fn fit_all(
    measured: &Measured,
    candidates: &[Candidate],
    threads: usize,
    control: &Control,
) -> Result<Vec<Outcome>> {
    check(measured)?;
    let scales = measured.scales();
    for candidate in candidates {
        if let Some(why) = candidate.lacks(&scales) {
            return Err(Error::BadOption {
                name: "law",
                given: format!("{} ({})", candidate.law.info.name, candidate.pressing.name()),
                allowed: format!("one that the data can show: {why}"),
            });
        }
    }
    // Each candidate is fitted in the thread that takes it.
    let how = How { level: Level::current()?, threads: 1, control };
    let queue = Mutex::new(candidates.iter().enumerate());
    let done = Mutex::new(Vec::new());
    let work = || {
        loop {
            let next = queue.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some((i, candidate)) = next else { return };
            if control.cancel.load(Ordering::Relaxed) {
                return;
            }
            let outcome = fit(measured, candidate, &scales, &how);
            control.done.fetch_add(1, Ordering::Relaxed);
            done.lock().unwrap_or_else(PoisonError::into_inner).push((i, outcome));
        }
    };
    pool(threads)?.scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|_| work());
        }
    });
    if control.cancel.load(Ordering::Relaxed) {
        let done = control.done.load(Ordering::Relaxed);
        return Err(Error::Cancelled { done, total: candidates.len() as u64 });
    }
    let mut all = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    all.sort_by_key(|(i, _)| *i);
    all.into_iter().map(|(_, outcome)| outcome).collect()
}

fn check(measured: &Measured) -> Result<()> {
    let bad = |name: &'static str, given: String, allowed: &str| {
        Err(Error::BadOption { name, given, allowed: allowed.to_owned() })
    };
    if measured.rows().next().is_none() {
        return bad("rows", "empty".to_owned(), "at least one sample that counts");
    }
    for (i, run) in measured.runs.iter().enumerate() {
        let count = run.motion.len();
        let Motion { x, v, drive, normal, .. } = &run.motion;
        let lengths = [x, v, drive, normal, &run.force, &run.load].map(Vec::len);
        if count < 2 || lengths.iter().any(|l| *l != count) || run.folds.len() != run.rows.len() {
            return bad("runs", format!("run {i}"), "columns of one length, at least 2");
        }
        let finite =
            [x, v, drive, &run.force, &run.load].iter().all(|c| c.iter().all(|v| v.is_finite()));
        let rises = run.motion.t.windows(2).all(|pair| pair[0] < pair[1]);
        let rows = run.rows.windows(2).all(|pair| pair[0] < pair[1]);
        if !finite || !rises || !rows || run.rows.last().is_some_and(|row| *row >= count) {
            return bad("runs", format!("run {i}"), "finite values, rising times and rising rows");
        }
    }
    Ok(())
}

/// The force of a law at every sample of an imposed motion, under the normal
/// force given in it.
pub fn imposed(law: &LawEntry, given: &[(ParamId, f64)], motion: &Motion) -> Result<Vec<f64>> {
    let values = Values::of(given);
    law.check(&values)?;
    let rows: Vec<usize> = (0..motion.len()).collect();
    let mut force = vec![0.0; rows.len()];
    (law.imposed)(&values, motion, &rows, &mut force);
    Ok(force)
}
