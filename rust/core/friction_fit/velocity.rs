//! Derivatives of noisy samples: local polynomials over a window as wide as the
//! noise asks for and the motion allows.

use super::spread::{median, robust};
use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector};

/// A derivative, and what is known of its noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Derivative {
    pub values: Vec<f64>,
    /// Standard deviation of the noise of the samples.
    pub noise: f64,
    /// Of the derivative: what is left of that noise, and what the window rounds
    /// off.
    pub error: f64,
    /// Samples of a window.
    pub window: usize,
}

/// Windows that are tried, samples.
const WINDOWS: &[usize] = &[5, 7, 9, 13, 17, 25, 35, 49, 69, 99, 139, 199];
/// Places at which windows are compared.
const PLACES: usize = 1500;

/// Weights of the samples in one derivative (0: the value) of the polynomial
/// through a window, at one of its times.
fn weights(t: &[f64], at: f64, degree: usize, order: usize) -> Option<Vec<f64>> {
    let reach = t.iter().map(|t| (t - at).abs()).fold(0.0, f64::max);
    let basis = DMatrix::from_fn(t.len(), degree + 1, |i, k| ((t[i] - at) / reach).powi(k as i32));
    let square = basis.tr_mul(&basis);
    let mut right = DVector::zeros(degree + 1);
    right[order] = (1..=order).product::<usize>() as f64 / reach.powi(order as i32);
    let factors = square.cholesky()?.solve(&right);
    Some((basis * factors).iter().copied().collect())
}

fn window(i: usize, size: usize, count: usize) -> (usize, usize) {
    let from = i.saturating_sub(size / 2).min(count - size);
    (from, from + size)
}

/// One derivative at a sample, and the sum of the squared weights.
fn derive(t: &[f64], y: &[f64], i: usize, size: usize, kind: (usize, usize)) -> (f64, f64) {
    let (from, to) = window(i, size, t.len());
    match weights(&t[from..to], t[i], kind.0, kind.1) {
        Some(w) => {
            (w.iter().zip(&y[from..to]).map(|(w, y)| w * y).sum(), w.iter().map(|w| w * w).sum())
        }
        None => (f64::NAN, f64::NAN),
    }
}

/// Derivative of `order` 1 or 2 at every sample.
///
/// The window is the one with the smallest expected error: noise that is left,
/// and the difference to a polynomial two degrees higher beyond what noise makes.
pub fn derivative(t: &[f64], y: &[f64], order: usize) -> Result<Derivative> {
    let count = t.len();
    let degree = order + 1;
    let least = degree + 3;
    if count < least.max(9) || t.len() != y.len() {
        return Err(Error::BadOption {
            name: "samples",
            given: format!("{} times and {} values", t.len(), y.len()),
            allowed: format!("as many of each, {} or more", least.max(9)),
        });
    }
    let step = (count / PLACES).max(1);
    let indices: Vec<usize> = (0..count).step_by(step).collect();
    let noise = noise(t, y, &indices);
    let mut best: Option<(f64, usize)> = None;
    for size in WINDOWS.iter().copied().filter(|size| (least..=count).contains(size)) {
        let (mut bias, mut left, mut used) = (0.0, 0.0, 0.0);
        for i in indices.iter().copied() {
            let (from, to) = window(i, size, count);
            let plain = weights(&t[from..to], t[i], degree, order);
            let fine = weights(&t[from..to], t[i], degree + 2, order);
            let (Some(plain), Some(fine)) = (plain, fine) else { continue };
            let (mut apart, mut spread, mut own) = (0.0, 0.0, 0.0);
            for ((a, b), y) in plain.iter().zip(&fine).zip(&y[from..to]) {
                apart += (a - b) * y;
                spread += (a - b) * (a - b);
                own += a * a;
            }
            bias += apart * apart - spread * noise * noise;
            left += own * noise * noise;
            used += 1.0;
        }
        if used == 0.0 {
            continue;
        }
        let error = ((f64::max(bias, 0.0) + left) / used).sqrt();
        if best.is_none_or(|(least, _)| error < least) {
            best = Some((error, size));
        }
    }
    let (error, size) = best.unwrap_or((f64::NAN, least.max(9)));
    let values = (0..count).map(|i| derive(t, y, i, size, (degree, order)).0).collect();
    Ok(Derivative { values, noise, error, window: size })
}

/// Standard deviation of white noise on samples of something smooth: what local
/// cubics leave, so that neither slopes nor bends count.
pub fn noise(t: &[f64], y: &[f64], indices: &[usize]) -> f64 {
    const SIZE: usize = 7;
    if t.len() < SIZE {
        return f64::NAN;
    }
    let left: Vec<f64> = indices
        .iter()
        .map(|i| {
            let (from, _) = window(*i, SIZE, t.len());
            let Some(w) = weights(&t[from..from + SIZE], t[*i], 3, 0) else { return 0.0 };
            let smooth: f64 = w.iter().zip(&y[from..]).map(|(w, y)| w * y).sum();
            // The sample's own weight shortens its distance.
            let own = (1.0 - w[i - from]).max(0.05).sqrt();
            (y[*i] - smooth) / own
        })
        .collect();
    let spread = robust(&left);
    // A coarse sensor that seldom moves: half the samples fit exactly.
    if spread > 0.0 {
        spread
    } else {
        (left.iter().map(|r| r * r).sum::<f64>() / left.len() as f64).sqrt()
    }
}

/// Typical time between samples.
pub fn interval(t: &[f64]) -> f64 {
    median(&t.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>())
}
