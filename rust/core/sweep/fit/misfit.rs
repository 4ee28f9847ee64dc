//! What was measured, in the form in which models are compared with it.

use super::experiment::Experiment;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Numbers that sums run over side by side: those of the widest pack, so that the order of
/// summation, and with it the bits, are those of every level.
pub const WIDE: usize = 16;

/// Where the prediction of a channel comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The replay's x, v, x_rear or force, by number.
    Replayed(usize),
    /// Electric power, from force and speed.
    Power,
}

/// A measured channel, the samples of all spans one after another.
#[derive(Debug, Clone)]
pub struct Signal {
    pub source: Source,
    /// Readings, and the inverse of their deviations: 0 where a sample does not count.
    pub measured: Vec<f64>,
    pub weights: Vec<f64>,
}

/// Something that may differ from span to span within a deviation, and is projected out to
/// first order: what a deviation of it changes, in weighted readings of some channels.
pub type Shift = Vec<(usize, Vec<f64>)>;

/// One span in rows: channel after channel, each filled up with zeros to a multiple of
/// `WIDE` samples, so that vectors never straddle two of them.
pub(super) struct Measured {
    pub(super) samples: usize,
    pub(super) padded: usize,
    pub(super) readings: Vec<f64>,
    pub(super) weights: Vec<f64>,
    pub(super) shifts: Directions,
}

/// What shifts do to a row, in orthonormal directions.
///
/// Of a row e, shifts U and sizes m the least |e - U m|^2 + |m|^2 is what is left of (e, 0) beside
/// the columns of (U, I) = Q R. Shifts can be millions of deviations long: their products would
/// hold few digits.
pub(super) struct Directions {
    /// The part of each column of Q that lies in the row: where it begins, and its numbers.
    pub(super) rows: Vec<(usize, Vec<f64>)>,
    /// Triangular: from sizes of shifts to sizes along the columns.
    root: DMatrix<f64>,
    /// Which shift each column of the root stands for.
    order: Vec<usize>,
}

impl Directions {
    /// Of shifts, where each begins in a row and its numbers.
    fn new(shifts: &[(usize, Vec<f64>)]) -> Directions {
        let count = shifts.len();
        if count == 0 {
            return Directions { rows: vec![], root: DMatrix::zeros(0, 0), order: vec![] };
        }
        let length = shifts.iter().map(|(at, u)| at + u.len()).max().unwrap_or(0);
        // A column is a sum of the shifts up to it: it begins no earlier than they do.
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|k| std::cmp::Reverse(shifts[*k].0));
        // The prior lies on top, so that it holds the pivots, and zeros of the shifts stay zeros.
        let mut columns = DMatrix::zeros(count + length, count);
        for (j, k) in order.iter().enumerate() {
            let (at, shift) = &shifts[*k];
            columns[(j, j)] = 1.0;
            columns.view_mut((count + at, j), (shift.len(), 1)).copy_from_slice(shift);
        }
        let decomposed = columns.qr();
        let (basis, root) = (decomposed.q(), decomposed.r());
        let rows = order
            .iter()
            .enumerate()
            .map(|(j, k)| {
                let at = shifts[*k].0;
                let end = order[..=j].iter().map(|k| shifts[*k].0 + shifts[*k].1.len()).max();
                let column = basis.column(j);
                (
                    at,
                    column
                        .rows_range(count + at..count + end.unwrap_or(at))
                        .iter()
                        .copied()
                        .collect(),
                )
            })
            .collect();
        Directions { rows, root, order }
    }

    pub(super) fn len(&self) -> usize {
        self.order.len()
    }

    /// Sizes of the shifts in deviations, each at most `most`, of a row that has such products
    /// with the directions; these become the sizes along them that are left.
    pub(super) fn sizes(&self, along: &mut [f64], most: f64, to: &mut [f64]) {
        let mut sizes = DVector::from_column_slice(along);
        // Its diagonal is 1 or more: a deviation is never worth less than itself.
        self.root.solve_upper_triangular_mut(&mut sizes);
        if sizes.iter().any(|size| size.abs() > most) {
            sizes.iter_mut().for_each(|size| *size = size.clamp(-most, most));
            along.copy_from_slice((&self.root * &sizes).as_slice());
        }
        for (k, size) in self.order.iter().zip(&sizes) {
            to[*k] = *size;
        }
    }
}

impl Measured {
    /// Length of a row: all channels, then the shifts.
    pub(super) fn stride(&self) -> usize {
        self.readings.len() + self.shifts.len().next_multiple_of(WIDE)
    }
}

/// Measured runs, and how far models may be from them.
pub struct Misfit {
    pub(super) experiment: Arc<Experiment>,
    pub(super) sources: Vec<Source>,
    pub(super) measured: Vec<Measured>,
    shifts: usize,
}

impl Misfit {
    /// Channels and shifts have the samples of all spans of the experiment.
    pub fn new(experiment: Arc<Experiment>, channels: &[Signal], shifts: &[Shift]) -> Misfit {
        let mut first = 0;
        let measured = experiment
            .spans
            .iter()
            .map(|span| {
                let own = first..first + span.samples();
                first = own.end;
                let padded = own.len().next_multiple_of(WIDE);
                let joined = |of: &dyn Fn(&Signal) -> Vec<f64>| {
                    let mut row = Vec::with_capacity(channels.len() * padded);
                    for channel in channels {
                        row.extend(of(channel));
                        row.resize(row.len().next_multiple_of(WIDE), 0.0);
                    }
                    row
                };
                let shifts: Vec<(usize, Vec<f64>)> = shifts
                    .iter()
                    .map(|shift| {
                        let front = shift.iter().map(|(channel, _)| *channel).min().unwrap_or(0);
                        let back = shift.iter().map(|(channel, _)| channel + 1).max().unwrap_or(0);
                        let mut row = vec![0.0; (back - front) * padded];
                        for (channel, change) in shift {
                            let at = (channel - front) * padded;
                            row[at..at + own.len()].copy_from_slice(&change[own.clone()]);
                        }
                        // What has not begun yet is 0.
                        let begun = row.iter().take_while(|change| **change == 0.0).count();
                        let skipped = begun.min(row.len()) / WIDE * WIDE;
                        (front * padded + skipped, row.split_off(skipped))
                    })
                    .collect();
                Measured {
                    samples: own.len(),
                    padded,
                    readings: joined(&|channel| {
                        let counts = |(y, w): (&f64, &f64)| if *w > 0.0 { *y } else { 0.0 };
                        let (y, w) =
                            (&channel.measured[own.clone()], &channel.weights[own.clone()]);
                        y.iter().zip(w).map(counts).collect()
                    }),
                    weights: joined(&|channel| channel.weights[own.clone()].to_vec()),
                    shifts: Directions::new(&shifts),
                }
            })
            .collect();
        let sources = channels.iter().map(|channel| channel.source).collect();
        Misfit { experiment, sources, measured, shifts: shifts.len() }
    }

    /// Which of x, v, x_rear and force predict a channel; x also says where a replay diverges.
    pub(super) fn asked(&self) -> [bool; 4] {
        let mut asked = [true, false, false, false];
        for source in &self.sources {
            match source {
                Source::Replayed(k) => asked[*k] = true,
                Source::Power => (asked[1], asked[3]) = (true, true),
            }
        }
        asked
    }

    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// Residuals of some spans: every sample of every channel, and every shift.
    pub fn residuals(&self, spans: &[usize]) -> usize {
        self.sources.len() * self.experiment.samples(spans) + self.shifts * spans.len()
    }

    /// Puts a row of one of several spans where it belongs among the residuals of all:
    /// channel by channel, span by span, and last shift by shift.
    pub(super) fn place(&self, row: &[f64], spans: &[usize], rank: usize, to: &mut [f64]) {
        let own = &self.measured[spans[rank]];
        let all = self.experiment.samples(spans);
        let before = self.experiment.samples(&spans[..rank]);
        for channel in 0..self.sources.len() {
            let (from, at) = (channel * own.padded, channel * all + before);
            to[at..at + own.samples].copy_from_slice(&row[from..from + own.samples]);
        }
        let (from, at) = (own.readings.len(), self.sources.len() * all);
        for shift in 0..self.shifts {
            to[at + shift * spans.len() + rank] = row[from + shift];
        }
    }
}
