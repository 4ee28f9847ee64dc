//! How far numbers lie apart where outliers and memory must not decide it.

use nalgebra::{DMatrix, SVD};

/// Median; NaN of nothing.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    if sorted.is_empty() {
        return f64::NAN;
    }
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[half] } else { 0.5 * (sorted[half - 1] + sorted[half]) }
}

/// Standard deviation of a normal distribution with this median distance from
/// the median.
const PER_DISTANCE: f64 = 1.482_602_218_505_602;

/// Standard deviation from the median distance to the median.
pub fn robust(values: &[f64]) -> f64 {
    let middle = median(values);
    let distances: Vec<f64> = values.iter().map(|v| (v - middle).abs()).collect();
    PER_DISTANCE * median(&distances)
}

/// Half width of the neighbourhood in which a sample may stand out.
const NEIGHBOURS: usize = 3;

/// Samples that stand alone, further from the median of their neighbours than
/// `times` the spread of such distances.
pub fn spikes(values: &[f64], times: f64) -> Vec<usize> {
    let count = values.len();
    if count < 2 * NEIGHBOURS + 1 {
        return Vec::new();
    }
    let off: Vec<f64> = (0..count)
        .map(|i| {
            // As many on either side, so that a step is no spike: at the ends
            // the neighbourhood is smaller.
            let reach = NEIGHBOURS.min(i).min(count - 1 - i).max(1);
            let (from, to) = (i.saturating_sub(reach), (i + reach).min(count - 1));
            values[i] - median(&values[from..=to])
        })
        .collect();
    // Most samples are their own median where the noise is coarse.
    let moved: Vec<f64> = off.iter().copied().filter(|d| *d != 0.0).collect();
    if moved.is_empty() {
        return Vec::new();
    }
    let limit = times * PER_DISTANCE * median(&moved.iter().map(|d| d.abs()).collect::<Vec<_>>());
    (0..count).filter(|i| off[*i].abs() > limit).collect()
}

/// Samples that carry as much as one independent sample, from the
/// autocorrelation of residuals within runs (lengths of consecutive pieces).
///
/// The sum over lags ends where a pair of neighbours turns negative (Geyer 1992).
pub fn memory(residuals: &[f64], runs: &[usize]) -> f64 {
    let mean = residuals.iter().sum::<f64>() / residuals.len().max(1) as f64;
    let longest = runs.iter().copied().max().unwrap_or(0) / 3;
    let at = |lag: usize| -> f64 {
        let mut sum = 0.0;
        let mut start = 0;
        for run in runs {
            for i in start..(start + run).saturating_sub(lag) {
                sum += (residuals[i] - mean) * (residuals[i + lag] - mean);
            }
            start += run;
        }
        sum
    };
    let whole = at(0);
    if whole.is_nan() || whole <= 0.0 {
        return 1.0;
    }
    let mut time = 1.0;
    let mut lag = 1;
    while lag < longest {
        let pair = (at(lag) + at(lag + 1)) / whole;
        if pair <= 0.0 {
            break;
        }
        time += 2.0 * pair;
        lag += 2;
    }
    time.max(1.0)
}

/// Memories that a block holds, so that blocks are almost independent.
const MEMORIES: f64 = 6.0;
/// Blocks that a run is cut into at most: more say no more.
const MOST_BLOCKS: usize = 200;

/// The block of each residual: runs cut into even pieces several memories long.
pub fn blocks(runs: &[usize], memory: f64) -> Vec<usize> {
    let total: usize = runs.iter().sum();
    let long = (MEMORIES * memory).ceil() as usize;
    let long = long.max(total / (MOST_BLOCKS * runs.len().max(1)).max(1)).max(1);
    let mut all = Vec::with_capacity(total);
    let mut first = 0;
    for run in runs {
        let pieces = (run / long).max(1);
        all.extend((0..*run).map(|i| first + i * pieces / run));
        first += pieces;
    }
    all
}

/// Standard deviations of parameters, and how many independent pieces of data
/// beyond the parameters they rest on.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Infinite where the data say nothing.
    pub std: Vec<f64>,
    pub freedom: f64,
}

/// Smallest share of a direction's length that counts as seen.
const SEEN: f64 = 1e-7;

/// Uncertainty of a least-squares fit whose residuals have memory and uneven
/// size: the spread of the blocks' pulls on the parameters (Liang and Zeger 1986).
pub fn uncertainty(j: &DMatrix<f64>, residuals: &[f64], blocks: &[usize]) -> Uncertainty {
    let (count, size) = (j.nrows(), j.ncols());
    let lengths: Vec<f64> = (0..size).map(|k| j.column(k).norm()).collect();
    let last = blocks.iter().copied().max().map_or(0, |b| b + 1);
    let mut pulls = DMatrix::zeros(last, size);
    for i in 0..count {
        for k in 0..size {
            if lengths[k] > 0.0 {
                pulls[(blocks[i], k)] += j[(i, k)] / lengths[k] * residuals[i];
            }
        }
    }
    let scaled = DMatrix::from_fn(size, size, |a, b| {
        let length = lengths[a] * lengths[b];
        if length > 0.0 { j.column(a).dot(&j.column(b)) / length } else { 0.0 }
    });
    let parts = SVD::new(scaled, true, true);
    let freedom = last as f64 - size as f64;
    let mut std = vec![f64::INFINITY; size];
    let (Some(u), Some(v_t)) = (parts.u, parts.v_t) else { return Uncertainty { std, freedom } };
    let largest = parts.singular_values.iter().copied().fold(0.0, f64::max);
    let seen = |i: usize| parts.singular_values[i] > SEEN * SEEN.sqrt() * largest;
    let inverse = DMatrix::from_fn(size, size, |a, b| {
        (0..size)
            .filter(|i| seen(*i))
            .map(|i| v_t[(i, a)] * u[(b, i)] / parts.singular_values[i])
            .sum::<f64>()
    });
    let middle = pulls.tr_mul(&pulls);
    let covariance = &inverse * middle * inverse.transpose();
    if freedom < 1.0 {
        return Uncertainty { std, freedom };
    }
    let few = last as f64 / freedom;
    for k in 0..size {
        let unseen: f64 = (0..size).filter(|i| !seen(*i)).map(|i| v_t[(i, k)].powi(2)).sum();
        if lengths[k] > 0.0 && unseen < 1e-6 {
            std[k] = (covariance[(k, k)].max(0.0) * few).sqrt() / lengths[k];
        }
    }
    Uncertainty { std, freedom }
}
