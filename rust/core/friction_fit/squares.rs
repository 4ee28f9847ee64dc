//! Nonlinear least squares with bounds: Levenberg and Marquardt's step on the
//! parameters that no bound holds.

use nalgebra::{DMatrix, DVector};

/// What is minimised: residuals at parameters, with their finite differences.
pub trait Residuals {
    /// Residuals at `u`; not finite where the model has no value.
    fn at(&mut self, u: &[f64]) -> Vec<f64>;
    fn bounds(&self, i: usize) -> (f64, f64);
    /// Width of a finite difference.
    fn width(&self, i: usize) -> f64;
    /// Relative fall of the sum of squares below which a search is at rest.
    fn settled(&self) -> f64 {
        1e-10
    }
    /// Shorter steps that are tried where one does not help.
    fn tries(&self) -> usize {
        12
    }
    /// True to stop early.
    fn stop(&self) -> bool;
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

fn cost(residuals: &[f64]) -> f64 {
    let sum: f64 = residuals.iter().map(|r| r * r).sum();
    if sum.is_finite() { sum } else { f64::INFINITY }
}

/// Columns of derivatives of the residuals, central where bounds leave room.
pub fn jacobian(
    model: &mut impl Residuals,
    u: &[f64],
    here: &[f64],
    moved: &[usize],
    central: bool,
) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(here.len(), moved.len());
    for (k, i) in moved.iter().copied().enumerate() {
        let width = model.width(i);
        let (low, high) = model.bounds(i);
        let shifted = |to: f64, model: &mut dyn FnMut(&[f64]) -> Vec<f64>| {
            let mut at = u.to_vec();
            at[i] = to;
            (model(&at), at[i])
        };
        let mut eval = |at: &[f64]| model.at(at);
        let up = (u[i] + width).min(high);
        let up = if up > u[i] { up } else { u[i] };
        let down = if central || up == u[i] { (u[i] - width).max(low) } else { u[i] };
        let (above, top) = if up > u[i] { shifted(up, &mut eval) } else { (here.to_vec(), u[i]) };
        let (below, bottom) =
            if down < u[i] { shifted(down, &mut eval) } else { (here.to_vec(), u[i]) };
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

/// Searches from `start` over the parameters `moved`, at most `steps` steps.
pub fn minimise(
    model: &mut impl Residuals,
    start: &[f64],
    moved: &[usize],
    steps: usize,
) -> Minimum {
    let mut u = start.to_vec();
    for i in moved {
        let (low, high) = model.bounds(*i);
        u[*i] = u[*i].clamp(low, high);
    }
    let mut here = model.at(&u);
    let mut now = cost(&here);
    let mut damping = 1e-3;
    for _ in 0..steps {
        if !now.is_finite() || now == 0.0 || model.stop() {
            break;
        }
        let slopes = jacobian(model, &u, &here, moved, false);
        let residual = DVector::from_row_slice(&here);
        let pull: Vec<f64> = (0..moved.len()).map(|k| slopes.column(k).dot(&residual)).collect();
        // A bound that the fall points across holds its parameter.
        let loose: Vec<usize> = (0..moved.len())
            .filter(|k| {
                let (low, high) = model.bounds(moved[*k]);
                let value = u[moved[*k]];
                !(value <= low && pull[*k] > 0.0 || value >= high && pull[*k] < 0.0)
            })
            .filter(|k| slopes.column(*k).norm_squared() > 0.0)
            .collect();
        if loose.is_empty() {
            return Minimum { u, cost: now, settled: true };
        }
        let j = slopes.select_columns(&loose);
        let square = gram(&j);
        let right = DVector::from_iterator(loose.len(), loose.iter().map(|k| -pull[*k]));
        let mut fell = None;
        for _ in 0..model.tries() {
            let mut damped = square.clone();
            for i in 0..loose.len() {
                damped[(i, i)] *= 1.0 + damping;
            }
            let Some(factor) = damped.cholesky() else {
                damping = (damping * 10.0_f64).max(1e-9);
                continue;
            };
            let step = factor.solve(&right);
            let mut tried = u.clone();
            for (k, step) in loose.iter().zip(step.iter()) {
                let (low, high) = model.bounds(moved[*k]);
                tried[moved[*k]] = (u[moved[*k]] + step).clamp(low, high);
            }
            let there = model.at(&tried);
            let then = cost(&there);
            if then < now {
                fell = Some(now - then);
                (u, here, now) = (tried, there, then);
                damping = (damping * 0.2).max(1e-12);
                break;
            }
            damping *= 5.0;
        }
        match fell {
            Some(fall) if fall > model.settled() * now => {}
            // No step is shorter than rounding, or the last one hardly helped.
            _ => return Minimum { u, cost: now, settled: true },
        }
    }
    Minimum { u, cost: now, settled: false }
}

/// Searches over parameters without derivatives, by steps along each that halve
/// where neither way helps; `others` follow by least squares.
pub fn compass(
    model: &mut impl Residuals,
    from: Minimum,
    edges: &[usize],
    others: &[usize],
    mut width: f64,
) -> Minimum {
    let mut best = from;
    for _ in 0..10 {
        let mut helped = false;
        for i in edges.iter().copied() {
            for direction in [1.0, -1.0] {
                if model.stop() {
                    return best;
                }
                let (low, high) = model.bounds(i);
                let mut tried = best.u.clone();
                let reach = if (high - low).is_finite() { high - low } else { 1.0 };
                tried[i] = (tried[i] + direction * width * reach).clamp(low, high);
                let found = minimise(model, &tried, others, 3);
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
    best
}
