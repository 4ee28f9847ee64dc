//! Which of several fits are better on samples they were not fitted to, and which
//! cannot be told apart there.

use super::spread::{blocks, memory};

/// A fit against the best one, on the same samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standing {
    /// Root mean square of the residuals.
    pub rms: f64,
    /// How much larger its sum of squares is than the best one's, in standard
    /// deviations of that difference; 0 of the best.
    pub sigmas: f64,
    /// Whether it cannot be told from the best.
    pub tied: bool,
}

/// Standard deviations from which a difference counts.
const CLEAR: f64 = 2.0;
/// Relative difference of the root mean squares below which it does not matter.
const SLIGHT: f64 = 0.005;

/// Ranks residuals of several fits on the same samples; `runs` are the lengths of
/// consecutive runs. Neighbours in time count as one where they move together.
pub fn rank(residuals: &[Vec<f64>], runs: &[usize]) -> Vec<Standing> {
    let mean = |r: &Vec<f64>| r.iter().map(|r| r * r).sum::<f64>() / r.len().max(1) as f64;
    let squares: Vec<f64> = residuals.iter().map(mean).collect();
    let order = |a: &usize, b: &usize| squares[*a].total_cmp(&squares[*b]);
    let Some(best) = (0..squares.len()).filter(|i| squares[*i].is_finite()).min_by(order) else {
        return squares
            .iter()
            .map(|_| Standing { rms: f64::NAN, sigmas: f64::INFINITY, tied: false })
            .collect();
    };
    let mut all = Vec::with_capacity(residuals.len());
    for (i, own) in residuals.iter().enumerate() {
        let rms = squares[i].sqrt();
        if i == best {
            all.push(Standing { rms, sigmas: 0.0, tied: true });
            continue;
        }
        if !squares[i].is_finite() {
            all.push(Standing { rms: f64::NAN, sigmas: f64::INFINITY, tied: false });
            continue;
        }
        let apart: Vec<f64> =
            own.iter().zip(&residuals[best]).map(|(a, b)| a * a - b * b).collect();
        let sigmas = distance(&apart, runs);
        let slight = rms <= squares[best].sqrt() * (1.0 + SLIGHT);
        all.push(Standing { rms, sigmas, tied: slight || sigmas < CLEAR });
    }
    all
}

/// The mean of differences in standard deviations of that mean.
fn distance(apart: &[f64], runs: &[usize]) -> f64 {
    let block = blocks(runs, memory(apart, runs));
    let count = block.last().map_or(0, |b| b + 1);
    let mean = apart.iter().sum::<f64>() / apart.len().max(1) as f64;
    if count < 2 {
        return 0.0;
    }
    let mut sums = vec![0.0; count];
    for (b, d) in block.iter().zip(apart) {
        sums[*b] += d - mean;
    }
    let spread = sums.iter().map(|s| s * s).sum::<f64>() * count as f64 / (count - 1) as f64;
    let std = spread.sqrt() / apart.len() as f64;
    if std > 0.0 { mean / std } else { 0.0 }
}
