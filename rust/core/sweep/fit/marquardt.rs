//! Levenberg and Marquardt's method for many fits side by side.

use super::compared::{Asked, Compared, Normal};
use super::coordinates::Fit;
use super::job::How;
use super::objective::Objective;
use crate::error::Result;
use nalgebra::{DMatrix, DVector};

/// Factors on the damping that each step tries side by side.
const TRIALS: [f64; 3] = [0.05, 1.0, 30.0];
/// Factor on the damping where none of them helps, and the damping at which a fit is given
/// up; none is below the least.
const STUCK: f64 = 300.0;
const MOST_DAMPING: f64 = 1e7;
const LEAST_DAMPING: f64 = 1e-9;
/// Factor on the fall of chi2 that derivatives promise, up to which a fit may still fall.
const DOUBT: f64 = 3.0;
/// Least gain of a step over a fit's distance in chi2 from the best one, beyond `NEAR`: with less
/// it would not catch up in the fifteen steps or so that fits are given.
const COARSE: f64 = 1.0 / 15.0;
const NEAR: f64 = 200.0;
/// Share of chi2 that a step of a replayed model has to gain.
pub const FINE: f64 = 1e-7;
/// Sizes of a coordinate that a step may take.
const REACH: f64 = 3.0;
/// Derivatives, over a coordinate's size, below which it is left where it is.
const FLOOR: f64 = 1e-6;
/// What is added to the diagonal of a normal matrix of unit diagonal before it is inverted.
const RIDGE: f64 = 1e-12;

/// When fits are done.
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    pub steps: usize,
    /// Fall of chi2 by a step below which a fit is done, and what is added to it for each unit
    /// of chi2.
    pub tolerance: f64,
    pub share: f64,
    /// Smallest chi2 that other fits have come to, infinite where there are none; nothing where
    /// each fit stands alone, whatever those beside it come to.
    pub least: Option<f64>,
}

/// What a job has done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ended {
    /// Samples that were evaluated.
    pub evaluated: u64,
    /// Numbers of the fits whose steps ran out.
    pub open: Vec<usize>,
}

/// Improves fits until their chi2 falls by less than the tolerance, or the steps are made;
/// one that would not catch up with the best one is left unless it stands alone, and one whose
/// limit is out of reach.
pub fn fit<O: Objective>(
    objective: &O,
    fits: &mut [Fit<O::Model>],
    rule: Rule,
    how: &How,
) -> Result<Ended> {
    let mut evaluated = 0;
    let samples = objective.samples();
    let bare: Vec<usize> = (0..fits.len()).filter(|i| fits[*i].chi2.is_none()).collect();
    let starts: Vec<_> = bare.iter().map(|i| asked(&fits[*i], &fits[*i].theta, false)).collect();
    evaluated += starts.len() as u64 * samples;
    for (i, found) in bare.iter().zip(objective.compare(&starts, how)?) {
        fits[*i].chi2 = Some(found.chi2);
    }
    let of = |fit: &Fit<O::Model>| fit.chi2.unwrap_or(f64::INFINITY);
    let open = |fit: &Fit<O::Model>| !fit.theta.is_empty() && of(fit).is_finite();
    let mut todo: Vec<usize> = (0..fits.len()).filter(|i| open(&fits[*i])).collect();
    // Derivatives that came with the step to where a fit is, and which of its trials that was.
    let mut known: Vec<Option<Normal>> = fits.iter().map(|_| None).collect();
    let mut last = vec![0; fits.len()];
    for _ in 0..rule.steps {
        if todo.is_empty() {
            break;
        }
        let least = rule.least.map(|least| fits.iter().map(of).fold(least, f64::min));
        evaluated += todo.iter().map(|i| objective.samples_of_derivatives(&fits[*i])).sum::<u64>();
        let unknown: Vec<usize> = todo.iter().copied().filter(|i| known[*i].is_none()).collect();
        let here: Vec<_> =
            unknown.iter().map(|i| asked(&fits[*i], &fits[*i].theta, true)).collect();
        for (i, found) in unknown.iter().zip(objective.compare(&here, how)?) {
            known[*i] = found.normal;
        }
        let mut trials: Vec<Trial> = Vec::new();
        for i in &todo {
            let (fit, Some(normal)) = (&mut fits[*i], known[*i].take()) else { continue };
            let (covariance, moves) = proposals(fit, &normal);
            let promise = normal.gradient.dot(&(&covariance * &normal.gradient));
            fit.covariance = Some(covariance);
            let hopeless = promise.is_finite() && of(fit) - DOUBT * promise > fit.limit;
            if !hopeless {
                let ahead = &likeliest(last[*i])[..objective.room(fit, TRIALS.len())];
                trials.extend(moves.into_iter().enumerate().map(|(k, (damping, theta))| Trial {
                    fit: *i,
                    damping,
                    theta,
                    slopes: ahead.contains(&k),
                }));
            }
        }
        let tried: Vec<_> =
            trials.iter().map(|one| asked(&fits[one.fit], &one.theta, one.slopes)).collect();
        evaluated += tried.len() as u64 * samples;
        let mut compared = objective.compare(&tried, how)?;
        todo.clear();
        for (group, compared) in trials.chunks(TRIALS.len()).zip(compared.chunks_mut(TRIALS.len()))
        {
            let mut best: Option<(f64, usize)> = None;
            for (k, Compared { chi2, .. }) in compared.iter().enumerate() {
                if chi2.is_finite() && best.is_none_or(|(least, _)| *chi2 < least) {
                    best = Some((*chi2, k));
                }
            }
            let (Some((new, k)), at) = (best, group[0].fit) else {
                continue;
            };
            let fit = &mut fits[at];
            let old = of(fit);
            let done = if new < old {
                (fit.theta, fit.chi2) = (group[k].theta.clone(), Some(new));
                fit.damping = group[k].damping.max(LEAST_DAMPING);
                (known[at], last[at]) = (compared[k].normal.take(), k);
                let behind = least.map_or(0.0, |least| COARSE * (new - least - NEAR).max(0.0));
                old - new < rule.tolerance + rule.share * new + behind
            } else {
                fit.damping *= STUCK;
                fit.damping > MOST_DAMPING
            };
            if !done {
                todo.push(at);
            }
        }
    }
    Ok(Ended { evaluated, open: todo })
}

/// Numbers of the trials, the likeliest to be taken after trial `last` first: the same again, or
/// the least damping after the most. It decides what is worked out twice, not where a fit goes.
fn likeliest(last: usize) -> [usize; TRIALS.len()] {
    match last {
        1 => [1, 0, 2],
        _ => [0, 1, 2],
    }
}

/// Values that a step may lead to.
struct Trial {
    /// Number of the fit.
    fit: usize,
    damping: f64,
    theta: DVector<f64>,
    /// Whether derivatives there are worked out along with it.
    slopes: bool,
}

fn asked<'a, M>(fit: &'a Fit<M>, theta: &DVector<f64>, slopes: bool) -> Asked<'a, M> {
    Asked { fit, theta: theta.clone(), slopes }
}

/// The covariance of a fit, and dampings with the values that they lead to.
fn proposals<M>(fit: &Fit<M>, normal: &Normal) -> (DMatrix<f64>, Vec<(f64, DVector<f64>)>) {
    let Normal { matrix, gradient } = normal;
    let count = fit.theta.len();
    let floor = DVector::from_fn(count, |i, _| FLOOR / fit.coordinates[i].size.powi(2));
    let scale = DVector::from_fn(count, |i, _| matrix[(i, i)].max(floor[i]));
    let free: Vec<usize> = (0..count)
        .filter(|i| {
            let (coordinate, value) = (&fit.coordinates[*i], fit.theta[*i]);
            let held = (value <= coordinate.low && gradient[*i] > 0.0)
                || (value >= coordinate.high && gradient[*i] < 0.0);
            !held
        })
        .collect();
    let moves = TRIALS
        .iter()
        .map(|factor| {
            let damping = fit.damping * factor;
            let damped = DMatrix::from_fn(free.len(), free.len(), |a, b| {
                let (i, j) = (free[a], free[b]);
                matrix[(i, j)] + if a == b { damping * scale[i] + floor[i] } else { 0.0 }
            });
            let right = DVector::from_fn(free.len(), |a, _| gradient[free[a]]);
            let mut step = DVector::zeros(count);
            for (i, found) in free.iter().zip(solved(&damped, &right).iter()) {
                step[*i] = -found;
            }
            let sizes = fit.coordinates.iter().map(|coordinate| REACH * coordinate.size);
            let reach = step.iter().zip(sizes).map(|(s, most)| s.abs() / most).fold(1.0, f64::max);
            let theta = DVector::from_fn(count, |i, _| {
                let coordinate = &fit.coordinates[i];
                (fit.theta[i] + step[i] / reach).max(coordinate.low).min(coordinate.high)
            });
            (damping, theta)
        })
        .collect();
    (inverse(matrix, &floor), moves)
}

/// A symmetric matrix with a unit diagonal, and the scales that make it so.
fn scaled(matrix: &DMatrix<f64>, floor: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let scale = DVector::from_fn(floor.len(), |i, _| matrix[(i, i)].max(floor[i]).powf(-0.5));
    let unit =
        DMatrix::from_fn(scale.len(), scale.len(), |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    (unit, scale)
}

/// The solution of a damped system; 0 where it has none.
fn solved(matrix: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let (unit, scale) = scaled(matrix, &DVector::zeros(right.len()));
    let found = unit.cholesky().map(|factor| factor.solve(&right.component_mul(&scale)));
    let found = found.map(|found| found.component_mul(&scale));
    found.filter(|found| found.iter().all(|x| x.is_finite())).unwrap_or_else(|| right * 0.0)
}

/// The inverse of a normal matrix; of its diagonal where derivatives depend on each other.
fn inverse(normal: &DMatrix<f64>, floor: &DVector<f64>) -> DMatrix<f64> {
    let (unit, scale) = scaled(normal, floor);
    let count = scale.len();
    match (unit + DMatrix::identity(count, count) * RIDGE).cholesky() {
        Some(factor) => {
            let inverse = factor.inverse();
            DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] * scale[i] * scale[j])
        }
        None => DMatrix::from_diagonal(&scale.map(|s| s * s)),
    }
}
