//! One candidate: where the search begins, how it goes on, what it is worth.

use super::candidate::{Candidate, Free, Pressing, Scales, Start, What};
use super::spread::{blocks, memory, uncertainty};
use super::squares::{Minimum, Residuals, compass, jacobian, minimise};
use super::{FITTED, Found, Measured, Outcome};
use crate::error::Result;
use crate::physics::friction::imposed::Motion;
use crate::physics::friction::{Kind, Values};
use crate::physics::params::ParamId;
use crate::sweep::fit::How;
use std::cell::RefCell;

/// How much is spent on a search.
struct Effort {
    /// Rows on which starts are compared, and rows that are fitted to.
    screened: usize,
    fitted: usize,
    /// Starts for each parameter that is spread.
    starts: usize,
    /// Steps from each start, of a search, and of one that begins where another ended.
    first_steps: usize,
    steps: usize,
    few_steps: usize,
    /// Starts that are followed on the screened rows, and then on all.
    followed: usize,
    kept: usize,
    /// Relative fall of the sum of squares that is none.
    settled: f64,
}

const THOROUGH: Effort = Effort {
    screened: 1500,
    fitted: usize::MAX,
    starts: 16,
    first_steps: 5,
    steps: 60,
    few_steps: 15,
    followed: 4,
    kept: 2,
    settled: 1e-9,
};

/// A bristle law is integrated, to a tolerance: each look takes as long as a
/// hundred at another law, and says no more than that tolerance.
const SPARING: Effort = Effort {
    screened: 400,
    fitted: 1200,
    starts: 4,
    first_steps: 2,
    steps: 25,
    few_steps: 6,
    followed: 2,
    kept: 1,
    settled: 1e-6,
};

fn effort(kind: Kind) -> &'static Effort {
    if kind == Kind::Bristle { &SPARING } else { &THOROUGH }
}

/// A candidate and some rows of the data.
struct Model<'a> {
    measured: &'a Measured,
    candidate: &'a Candidate,
    free: &'a [Free],
    /// The static level and the Coulomb one that it stands on, where there are both.
    levels: Option<(usize, usize)>,
    /// Of which a preload that is fitted changes the normal force.
    motions: RefCell<Vec<Motion>>,
    /// Rows in use, run by run.
    rows: Vec<Vec<usize>>,
    /// Typical force, N, which residuals are given in.
    force: f64,
}

impl<'a> Model<'a> {
    fn new(measured: &'a Measured, candidate: &'a Candidate, free: &'a [Free], force: f64) -> Self {
        let motions = measured
            .runs
            .iter()
            .map(|run| {
                let normal = match candidate.pressing {
                    Pressing::Constant => vec![measured.normal; run.load.len()],
                    _ => run.load.iter().map(|load| load.abs()).collect(),
                };
                Motion { normal, ..run.motion.clone() }
            })
            .collect();
        let rows = measured.runs.iter().map(|run| run.rows.clone()).collect();
        let (levels, motions) = (levels(free), RefCell::new(motions));
        Model { measured, candidate, free, levels, motions, rows, force }
    }

    fn effort(&self) -> &'static Effort {
        effort(self.candidate.law.kind)
    }

    /// All rows of every run.
    fn whole(&mut self) {
        for (run, rows) in self.measured.runs.iter().zip(&mut self.rows) {
            rows.clone_from(&run.rows);
        }
    }

    /// About so many of the rows that are fitted to, or all of them: with `without`
    /// those outside that fold.
    ///
    /// A bristle law has to be taken along the motion anyway: of it the first part
    /// of each run. Of other laws any row will do.
    fn fitted_to(&mut self, most: usize, without: Option<u8>) {
        let in_turn = folds(self.measured) > 1;
        let first = self.candidate.law.kind == Kind::Bristle;
        let fits = |fold: u8| in_turn || fold == FITTED;
        let all = self.measured.runs.iter().flat_map(|run| &run.folds);
        let share = all.filter(|fold| fits(**fold)).count().div_ceil(most).max(1);
        for (run, rows) in self.measured.runs.iter().zip(&mut self.rows) {
            let part = run.rows.len().div_ceil(share);
            let numbered = run.rows.iter().zip(&run.folds).enumerate();
            *rows = numbered
                .filter(|(k, _)| if first { *k < part } else { k % share == 0 })
                .filter(|(_, (_, fold))| fits(**fold) && Some(**fold) != without)
                .map(|(_, (row, _))| *row)
                .collect();
        }
    }

    /// Force at the rows in use, N.
    fn predicted(&self, u: &[f64]) -> Vec<f64> {
        let mut motions = self.motions.borrow_mut();
        let mut given: Vec<(ParamId, f64)> = Vec::with_capacity(u.len());
        let (mut offset, mut gain) = (0.0, 0.0);
        for (i, free) in self.free.iter().enumerate() {
            let value = self.value(i, u);
            match free.what {
                What::Law(id) => given.push((id, value)),
                What::Offset => offset = value,
                What::Gain => gain = value,
                What::Preload => {
                    for (motion, run) in motions.iter_mut().zip(&self.measured.runs) {
                        for (normal, load) in motion.normal.iter_mut().zip(&run.load) {
                            *normal = load.abs() + value;
                        }
                    }
                }
            }
        }
        let values = Values::of(&given);
        let mut all = Vec::with_capacity(self.rows.iter().map(Vec::len).sum());
        for ((motion, run), rows) in motions.iter().zip(&self.measured.runs).zip(&self.rows) {
            let start = all.len();
            all.resize(start + rows.len(), 0.0);
            (self.candidate.law.imposed)(&values, motion, rows, &mut all[start..]);
            for (force, row) in all[start..].iter_mut().zip(rows) {
                *force += gain.mul_add(run.load[*row], offset);
            }
        }
        all
    }

    /// Parameter `i`: of the static level the fit moves what it has beyond the Coulomb one.
    fn value(&self, i: usize, u: &[f64]) -> f64 {
        let own = self.free[i].outer(u[i]);
        match self.levels {
            Some((at_rest, sliding)) if at_rest == i => own + self.free[sliding].outer(u[sliding]),
            _ => own,
        }
    }

    fn lengths(&self) -> Vec<usize> {
        self.rows.iter().map(Vec::len).collect()
    }
}

impl Residuals for Model<'_> {
    fn at(&self, u: &[f64]) -> Vec<f64> {
        let mut all = self.predicted(u);
        let measured = self.measured.runs.iter().zip(&self.rows);
        let force = measured.flat_map(|(run, rows)| rows.iter().map(|row| run.force[*row]));
        for (value, force) in all.iter_mut().zip(force) {
            *value = (*value - force) / self.force;
        }
        all
    }

    fn bounds(&self, i: usize) -> (f64, f64) {
        self.free[i].bounds()
    }

    fn width(&self, i: usize) -> f64 {
        let free = self.free[i];
        let (low, high) = free.bounds();
        match free {
            Free { edge: true, .. } => 0.02 * (high - low),
            // Integrated to a tolerance, not to the last digit.
            _ if self.candidate.law.kind == Kind::Bristle => 1e-3,
            _ => 1e-5,
        }
    }

    fn settled(&self) -> f64 {
        self.effort().settled
    }
}

/// Indices of the static and the Coulomb level, where a law has both: friction falls from
/// one to the other, so the static level is never the lower one.
fn levels(free: &[Free]) -> Option<(usize, usize)> {
    let at = |id| free.iter().position(|f| f.what == What::Law(id));
    at(ParamId::MuStatic).zip(at(ParamId::MuCoulomb))
}

/// Number `i` of a sequence that fills the unit interval evenly (Halton).
fn even(i: usize, dimension: usize) -> f64 {
    const PRIMES: [usize; 8] = [2, 3, 5, 7, 11, 13, 17, 19];
    let base = PRIMES[dimension % PRIMES.len()];
    let (mut i, mut digit_weight, mut sum) = (i + 1, 1.0, 0.0);
    while i > 0 {
        digit_weight /= base as f64;
        sum += digit_weight * (i % base) as f64;
        i /= base;
    }
    sum
}

/// Points from which the search begins.
fn starts(free: &[Free], kind: Kind) -> Vec<Vec<f64>> {
    let spread: Vec<usize> =
        (0..free.len()).filter(|i| !matches!(free[*i].start, Start::Inner(_))).collect();
    let rough = free.iter().any(|f| f.edge || f.start == Start::SpreadInverse);
    let count = match (spread.len(), rough, kind) {
        (0, ..) => 1,
        (_, true, _) => 400,
        (n, ..) => effort(kind).starts * n,
    };
    let point = |k: usize| {
        let value = |(i, f): (usize, &Free)| {
            let digit_weight = spread.iter().position(|s| *s == i).unwrap_or(0);
            f.inner(f.spread(even(k, digit_weight)).clamp(f.low, f.high))
        };
        free.iter().enumerate().map(value).collect()
    };
    (0..count).map(point).collect()
}

/// Fits one candidate.
pub fn fit(
    measured: &Measured,
    candidate: &Candidate,
    scales: &Scales,
    how: &How,
) -> Result<Outcome> {
    let free = candidate.free(scales);
    let mut model = Model::new(measured, candidate, &free, scales.force);
    let effort = model.effort();
    let best = search(&mut model, how)?;
    let fitted = finish(&model, best, effort.steps, how)?;
    let (found, freedom, memory, rms) = worth(&model, &fitted);
    // What is said of held-out samples comes from fits that never saw them.
    let mut held_out = vec![f64::NAN; measured.rows().count()];
    for fold in 0..folds(measured) as u8 {
        let mut without = fitted.clone();
        if folds(measured) > 1 {
            model.fitted_to(effort.fitted, Some(fold));
            without = finish(&model, without, effort.few_steps, how)?;
        }
        model.whole();
        let all = model.predicted(&without.u);
        let of = measured.runs.iter().flat_map(|run| &run.folds);
        for ((to, from), f) in held_out.iter_mut().zip(all).zip(of) {
            if *f == fold {
                *to = from;
            }
        }
    }
    model.whole();
    let predicted = model.predicted(&fitted.u);
    Ok(Outcome { found, freedom, memory, rms, settled: fitted.settled, predicted, held_out })
}

/// Number of folds. One: its samples are held out for good; more: each in turn.
fn folds(measured: &Measured) -> usize {
    let all = measured.runs.iter().flat_map(|run| &run.folds);
    all.filter(|f| **f != FITTED).max().map_or(0, |f| usize::from(*f) + 1)
}

fn every(free: &[Free], keep: impl Fn(&Free) -> bool) -> Vec<usize> {
    (0..free.len()).filter(|i| keep(&free[*i])).collect()
}

/// Finds where to go on from, and leaves the rows that are fitted to in use.
fn search(model: &mut Model, how: &How) -> Result<Minimum> {
    let (free, effort) = (model.free, model.effort());
    let inner = every(free, |f| matches!(f.start, Start::Inner(_)));
    let smooth = every(free, |f| !f.edge);
    let points = starts(free, model.candidate.law.kind);
    let best = |mut found: Vec<Minimum>, most: usize| {
        found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        found.truncate(most);
        found
    };
    model.fitted_to(effort.screened, None);
    let begin = |u: &Vec<f64>| minimise(model, u, &inner, effort.first_steps, how);
    let begun = best(points.iter().map(begin).collect::<Result<_>>()?, effort.followed);
    let follow =
        |model: &Model, from: &Minimum| minimise(model, &from.u, &smooth, effort.steps / 2, how);
    let followed = begun.iter().map(|from| follow(model, from)).collect::<Result<_>>()?;
    let kept = best(followed, effort.kept);
    model.fitted_to(effort.fitted, None);
    let kept = kept.iter().map(|from| follow(model, from)).collect::<Result<_>>()?;
    Ok(best(kept, 1).swap_remove(0))
}

/// Takes a search to its end on the rows in use.
fn finish(model: &Model, from: Minimum, steps: usize, how: &How) -> Result<Minimum> {
    let smooth = every(model.free, |f| !f.edge);
    let edges = every(model.free, |f| f.edge);
    let found = minimise(model, &from.u, &smooth, steps, how)?;
    if edges.is_empty() {
        return Ok(found);
    }
    let near = compass(model, found, &edges, &smooth, 0.05, how)?;
    let found = minimise(model, &near.u, &smooth, steps, how)?;
    Ok(if found.cost <= near.cost { found } else { near })
}

/// Values with their uncertainty, its degrees of freedom, the memory of the
/// residuals and their root mean square, on the rows that are fitted to.
fn worth(model: &Model, fitted: &Minimum) -> (Vec<Found>, f64, f64, f64) {
    let free = model.free;
    let residuals = model.at(&fitted.u);
    let runs = model.lengths();
    let memory = memory(&residuals, &runs);
    let bounded = |i: usize| {
        let (low, high) = free[i].bounds();
        // Scaled values are about one where they matter.
        fitted.u[i] <= low + 1e-6 || fitted.u[i] >= high - 1e-6
    };
    let smooth = every(free, |f| !f.edge);
    let mut slopes = jacobian(model, &fitted.u, &residuals, &smooth, true);
    let idle = |i: usize| {
        smooth.iter().position(|s| *s == i).is_some_and(|k| slopes.column(k).norm() == 0.0)
    };
    // A bound takes a parameter's freedom away, unless nothing depends on it.
    let bounded: Vec<bool> = (0..free.len()).map(|i| bounded(i) && !idle(i)).collect();
    let kept: Vec<usize> = (0..smooth.len()).filter(|k| !bounded[smooth[*k]]).collect();
    let moved: Vec<usize> = kept.iter().map(|k| smooth[*k]).collect();
    if let Some((at_rest, sliding)) = model.levels
        && !bounded[at_rest]
    {
        // From what stands on the Coulomb level to the levels themselves: both have one scale.
        let column = |i: usize| smooth.iter().position(|s| *s == i);
        if let Some((above, below)) = column(at_rest).zip(column(sliding)) {
            let own = slopes.column(below) - slopes.column(above);
            slopes.set_column(below, &own);
        }
    }
    let slopes = slopes.select_columns(&kept);
    let spread = uncertainty(&slopes, &residuals, &blocks(&runs, memory));
    let found = (0..free.len()).map(|i| {
        let value = model.value(i, &fitted.u);
        let own = moved.iter().position(|m| *m == i).map_or(f64::NAN, |k| spread.std[k]);
        let std = if free[i].logarithmic { own * value } else { own * free[i].scale };
        let logarithmic = free[i].logarithmic;
        Found { what: free[i].what, value, std, logarithmic, bounded: bounded[i] }
    });
    let found = found.collect();
    let mean = residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len().max(1) as f64;
    (found, spread.freedom, memory, mean.sqrt() * model.force)
}
