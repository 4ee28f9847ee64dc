//! Least squares of a law's force: what the loop of all fits asks for, by finite differences,
//! and steps along parameters without derivatives.

use crate::error::{Error, Result};
use crate::sweep::fit::{Asked, Compared, Coordinate, Fit, How, Normal, Objective, Rule, fit};
use nalgebra::{DMatrix, DVector};
use std::cell::RefCell;
use std::sync::atomic::Ordering;

/// Damping of a search's first step.
const DAMPING: f64 = 1e-3;

/// What is minimised: residuals at parameters of about 1, with their finite differences.
pub trait Residuals {
    /// Residuals at `u`, of about 1 where nothing is explained; not finite where the model has
    /// no value.
    fn at(&self, u: &[f64]) -> Vec<f64>;
    fn bounds(&self, i: usize) -> (f64, f64);
    /// Width of a finite difference.
    fn width(&self, i: usize) -> f64;
    /// Relative fall of the sum of squares below which a search is at rest.
    fn settled(&self) -> f64 {
        1e-10
    }
}

/// Where a search ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    pub u: Vec<f64>,
    /// Sum of squares; infinite where no value was found.
    pub cost: f64,
    /// Whether it came to rest, rather than ran out of steps.
    pub settled: bool,
}

/// Columns of derivatives of the residuals, central where bounds leave room.
pub fn jacobian(
    model: &impl Residuals,
    u: &[f64],
    here: &[f64],
    moved: &[usize],
    central: bool,
) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(here.len(), moved.len());
    for (k, i) in moved.iter().copied().enumerate() {
        let width = model.width(i);
        let (low, high) = model.bounds(i);
        let shifted = |to: f64| {
            let mut at = u.to_vec();
            at[i] = to;
            (model.at(&at), to)
        };
        let up = (u[i] + width).min(high);
        let up = if up > u[i] { up } else { u[i] };
        let down = if central || up == u[i] { (u[i] - width).max(low) } else { u[i] };
        let (above, top) = if up > u[i] { shifted(up) } else { (here.to_vec(), u[i]) };
        let (below, bottom) = if down < u[i] { shifted(down) } else { (here.to_vec(), u[i]) };
        let span = top - bottom;
        if span > 0.0 {
            let column = above.iter().zip(&below).map(|(a, b)| (a - b) / span);
            matrix.set_column(k, &DVector::from_iterator(here.len(), column));
        }
    }
    matrix
}

/// Products of columns by plain sums, whose bits no machine changes.
pub fn gram(j: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(j.ncols(), j.ncols(), |a, b| j.column(a).dot(&j.column(b)))
}

/// Residuals over some of their parameters, as the loop of all fits sees them.
struct Over<'a, R> {
    residuals: &'a R,
    /// Values of all parameters; those that move are replaced.
    base: Vec<f64>,
    moved: &'a [usize],
    /// Values and residuals of the last call: the next one asks for derivatives at one of them.
    last: RefCell<Vec<(DVector<f64>, DVector<f64>)>>,
}

impl<R: Residuals> Over<'_, R> {
    fn values(&self, theta: &DVector<f64>) -> Vec<f64> {
        let mut u = self.base.clone();
        for (i, value) in self.moved.iter().zip(theta.iter()) {
            u[*i] = *value;
        }
        u
    }

    fn at(&self, theta: &DVector<f64>) -> DVector<f64> {
        let last = self.last.borrow();
        let known = last.iter().find(|(values, _)| values == theta);
        let anew = || DVector::from_vec(self.residuals.at(&self.values(theta)));
        known.map_or_else(anew, |(_, residuals)| residuals.clone())
    }

    fn one(&self, asked: &Asked<()>, here: &DVector<f64>) -> Compared {
        let squares = here.norm_squared();
        let normal = asked.slopes.then(|| {
            let u = self.values(&asked.theta);
            let mut j = jacobian(self.residuals, &u, here.as_slice(), self.moved, false);
            for mut column in j.column_iter_mut() {
                // The model has no value a step away: it stays where it is.
                if !column.iter().all(|slope| slope.is_finite()) {
                    column.fill(0.0);
                }
            }
            let pull = j.column_iter().map(|column| column.dot(here));
            let gradient = DVector::from_iterator(j.ncols(), pull);
            Normal { matrix: gram(&j), gradient }
        });
        Compared { chi2: if squares.is_finite() { squares } else { f64::INFINITY }, normal }
    }
}

impl<R: Residuals> Objective for Over<'_, R> {
    type Model = ();

    fn compare(&self, asked: &[Asked<()>], how: &How) -> Result<Vec<Compared>> {
        let mut seen = Vec::with_capacity(asked.len());
        let mut compared = Vec::with_capacity(asked.len());
        for asked in asked {
            if how.control.cancel.load(Ordering::Relaxed) {
                return Err(Error::Cancelled { done: 0, total: 0 });
            }
            let here = self.at(&asked.theta);
            compared.push(self.one(asked, &here));
            seen.push((asked.theta.clone(), here));
        }
        self.last.replace(seen);
        Ok(compared)
    }

    fn room(&self, _: &Fit<()>, _: usize) -> usize {
        0
    }

    fn samples(&self) -> u64 {
        1
    }

    fn samples_of_derivatives(&self, _: &Fit<()>) -> u64 {
        self.moved.len() as u64
    }
}

/// Searches from `start` over the parameters `moved`, at most `steps` steps.
pub fn minimise(
    residuals: &impl Residuals,
    start: &[f64],
    moved: &[usize],
    steps: usize,
    how: &How,
) -> Result<Minimum> {
    let over = Over { residuals, base: start.to_vec(), moved, last: RefCell::default() };
    let coordinates: Vec<Coordinate> = moved
        .iter()
        .map(|i| {
            let (low, high) = residuals.bounds(*i);
            Coordinate { low, high, size: 1.0, deviation: f64::INFINITY }
        })
        .collect();
    let inside = moved.iter().zip(&coordinates).map(|(i, c)| start[*i].clamp(c.low, c.high));
    let mut fits = [Fit {
        model: (),
        theta: DVector::from_iterator(moved.len(), inside),
        coordinates,
        chi2: None,
        covariance: None,
        damping: DAMPING,
        limit: f64::INFINITY,
    }];
    let share = residuals.settled();
    let rule = Rule { steps, tolerance: 0.0, share, least: None };
    let ended = fit(&over, &mut fits, rule, how)?;
    let [found] = fits;
    let cost = found.chi2.unwrap_or(f64::INFINITY);
    let settled = ended.open.is_empty() && cost.is_finite();
    Ok(Minimum { u: over.values(&found.theta), cost, settled })
}

/// Searches over parameters without derivatives, by steps along each that halve
/// where neither way helps; `others` follow by least squares.
pub fn compass(
    model: &impl Residuals,
    from: Minimum,
    edges: &[usize],
    others: &[usize],
    mut width: f64,
    how: &How,
) -> Result<Minimum> {
    let mut best = from;
    for _ in 0..10 {
        let mut helped = false;
        for i in edges.iter().copied() {
            for direction in [1.0, -1.0] {
                let (low, high) = model.bounds(i);
                let mut tried = best.u.clone();
                let reach = if (high - low).is_finite() { high - low } else { 1.0 };
                tried[i] = (tried[i] + direction * width * reach).clamp(low, high);
                let found = minimise(model, &tried, others, 3, how)?;
                if found.cost < best.cost * (1.0 - 1e-9) {
                    best = Minimum { settled: true, ..found };
                    helped = true;
                    break;
                }
            }
        }
        if !helped {
            width *= 0.5;
        }
    }
    Ok(best)
}
