//! Equation error: displacements of models along measured motions, in place of replays. Start
//! and start speed of every slide are free, so nothing about the start of a run matters.

use super::super::replay::{finished, one_by_one};
use super::compared::{Asked, Compared, Normal, with_priors};
use super::coordinates::{Fit, Replayed};
use super::experiment::Experiment;
use super::job::How;
use super::objective::Objective;
use crate::error::Result;
use crate::integrate::measured_motion::MeasuredMotion;
use crate::replays::displacements::{Along, displaced};
use crate::replays::packs::{Column, PACK};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Measured motion of one run, at its samples.
#[derive(Debug, Clone, Default)]
pub struct Motion {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    /// Distance moved forward since the last rest or turn.
    pub sliding_distance: Vec<f64>,
    /// Slides in one direction: first sample and one beyond the last.
    pub slides: Vec<(usize, usize)>,
}

impl Motion {
    fn blocks(&self, block: usize) -> impl Iterator<Item = usize> {
        self.slides.iter().map(move |(from, to)| (to - from).div_ceil(block))
    }
}

/// Means over blocks of samples of all slides, one after another.
#[derive(Debug, Clone)]
pub struct Blocks {
    /// Samples of a block.
    pub size: usize,
    pub readings: Vec<f64>,
    /// Inverse deviations, 0 where nothing was read.
    pub weights: Vec<f64>,
    pub times: Vec<f64>,
}

/// Runs of an experiment, each of them a span, with their measured motions.
pub struct EquationError {
    experiment: Arc<Experiment>,
    motions: Vec<Motion>,
    size: usize,
    /// First block of every slide, and one beyond the last.
    edges: Vec<usize>,
    weights: Vec<f64>,
    /// Weighted unit rows of a constant and of the time in every slide.
    lines: [Vec<f64>; 2],
    measured: Vec<f64>,
}

impl EquationError {
    /// None where the blocks are not those of the slides, or there is none.
    pub fn new(
        experiment: Arc<Experiment>,
        motions: Vec<Motion>,
        blocks: Blocks,
    ) -> Option<EquationError> {
        let Blocks { size, readings, weights, times } = blocks;
        let mut edges = vec![0];
        for count in motions.iter().flat_map(|motion| motion.blocks(size)) {
            edges.push(edges[edges.len() - 1] + count);
        }
        let count = edges[edges.len() - 1];
        let fits = |row: &Vec<f64>| row.len() == count;
        if count == 0 || ![&readings, &weights, &times].into_iter().all(fits) {
            return None;
        }
        let mut lines = [weights.clone(), times];
        lines[1].iter_mut().zip(&weights).for_each(|(t, w)| *t *= w);
        let [constant, time] = &mut lines;
        for slide in edges.windows(2) {
            let (one, t) = (&mut constant[slide[0]..slide[1]], &mut time[slide[0]..slide[1]]);
            unit(one);
            take_out(t, one);
            unit(t);
        }
        let mut found =
            EquationError { experiment, motions, size, edges, weights, lines, measured: readings };
        let mut measured = std::mem::take(&mut found.measured);
        found.project(&mut measured);
        found.measured = measured;
        Some(found)
    }

    /// What was measured, in the form of `displacements`.
    pub fn measured(&self) -> &[f64] {
        &self.measured
    }

    /// Brings block means into units of the noise, and takes out lines in time.
    fn project(&self, row: &mut [f64]) {
        row.iter_mut().zip(&self.weights).for_each(|(e, w)| *e *= w);
        for slide in self.edges.windows(2) {
            let own = slide[0]..slide[1];
            for line in &self.lines {
                take_out(&mut row[own.clone()], &line[own.clone()]);
            }
        }
    }

    /// Displacements of models at values of a fit's coordinates, a row each: block by block
    /// in units of the noise, without the line in time of every slide.
    pub fn displacements(&self, models: &[(&Fit, DVector<f64>)], how: &How) -> Result<Vec<f64>> {
        let experiment = &*self.experiment;
        let moving: Vec<usize> =
            (0..self.motions.len()).filter(|run| !self.motions[*run].slides.is_empty()).collect();
        let columns: Vec<Column> = models
            .iter()
            .flat_map(|(fit, theta)| {
                let column =
                    |span: &usize| experiment.column(*span, &fit.spot(experiment, theta, *span)).0;
                moving.iter().map(column).collect::<Vec<Column>>()
            })
            .collect();
        let mut found = vec![0.0; models.len() * self.measured.len()];
        self.displace(&columns, how, &mut found)?;
        for row in found.chunks_exact_mut(self.measured.len().max(1)) {
            self.project(row);
        }
        Ok(found)
    }

    /// Block means of columns, one after another.
    fn displace(&self, columns: &[Column], how: &How, to: &mut [f64]) -> Result<()> {
        let Experiment { nominal, runs, intervals, .. } = &*self.experiment;
        let mut rest = to;
        let mut order: Vec<(&Column, &mut [f64])> = Vec::with_capacity(columns.len());
        for column in columns {
            let own;
            (own, rest) = rest.split_at_mut(self.motions[column.run].blocks(self.size).sum());
            order.push((column, own));
        }
        let key = |column: &Column| (column.run, column.active);
        order.sort_by_key(|(column, _)| key(column));
        let groups: Vec<&mut [(&Column, &mut [f64])]> = order
            .chunk_by_mut(|(a, _), (b, _)| key(a) == key(b))
            .flat_map(|group| group.chunks_mut(PACK))
            .collect();
        let threads = if columns.len() <= PACK { 1 } else { how.threads };
        let cancel = &how.control.cancel;
        one_by_one(groups, threads, how.control, |group, (): &mut ()| {
            let (count, of) = (group.len(), group[0].0.run);
            let Motion { x, v, sliding_distance, slides } = &self.motions[of];
            let motion = MeasuredMotion { x, v, sliding_distance, slides };
            let (run, interval, block) = (&runs[of], intervals[of], self.size);
            displaced(how.level, Along { nominal, run, motion, interval, block, group, cancel });
            count
        })?;
        finished(how.control, columns.len())
    }

    /// Displacements of each model, and where they are asked for their derivatives by its
    /// coordinates, a row each in turn.
    fn with_slopes(&self, asked: &[Asked], how: &How) -> Result<Vec<(Vec<f64>, Vec<f64>)>> {
        let steps: Vec<Vec<f64>> = asked
            .iter()
            .map(|one| if one.slopes { one.fit.steps(&one.theta) } else { Vec::new() })
            .collect();
        let mut models = Vec::new();
        for (Asked { fit, theta, .. }, steps) in asked.iter().zip(&steps) {
            models.push((*fit, theta.clone()));
            for (i, step) in steps.iter().enumerate() {
                let mut theta = theta.clone();
                theta[i] += step;
                models.push((*fit, theta));
            }
        }
        let length = self.measured.len();
        let rows = self.displacements(&models, how)?;
        let mut rest = &rows[..];
        let mut found = Vec::with_capacity(asked.len());
        for steps in &steps {
            let (own, others) = rest.split_at((1 + steps.len()) * length);
            rest = others;
            let (base, moved) = own.split_at(length);
            let mut slopes = moved.to_vec();
            for (row, step) in slopes.chunks_exact_mut(length.max(1)).zip(steps) {
                for (e, base) in row.iter_mut().zip(base) {
                    let slope = (*e - base) / step;
                    *e = if slope.is_finite() { slope } else { 0.0 };
                }
            }
            found.push((base.to_vec(), slopes));
        }
        Ok(found)
    }

    /// Derivatives of the displacements of a fit by its coordinates, a row each in turn.
    pub fn jacobian(&self, fit: &Fit, how: &How) -> Result<Vec<f64>> {
        let asked = Asked { fit, theta: fit.theta.clone(), slopes: true };
        Ok(self.with_slopes(&[asked], how)?.remove(0).1)
    }

    /// What was measured less a row of displacements, in its place.
    fn subtract(&self, row: &mut [f64]) {
        row.iter_mut().zip(&self.measured).for_each(|(e, y)| *e = y - *e);
    }
}

impl Objective for EquationError {
    type Model = Replayed;

    fn compare(&self, asked: &[Asked], how: &How) -> Result<Vec<Compared>> {
        let length = self.measured.len().max(1);
        let compared = |(one, (mut error, slopes)): (&Asked, (Vec<f64>, Vec<f64>))| {
            self.subtract(&mut error);
            let chi2 = one.chi2(dot(&error, &error));
            let normal = one.slopes.then(|| {
                let rows: Vec<&[f64]> = slopes.chunks_exact(length).collect();
                let count = rows.len();
                let matrix = DMatrix::from_fn(count, count, |a, b| dot(rows[a], rows[b]));
                // An error falls as its displacement grows.
                let gradient = DVector::from_fn(count, |a, _| -dot(rows[a], &error));
                with_priors(one, Normal { matrix, gradient })
            });
            Compared { chi2, normal }
        };
        Ok(asked.iter().zip(self.with_slopes(asked, how)?).map(compared).collect())
    }

    fn room(&self, _: &Fit, _: usize) -> usize {
        // Many fits share its packs as they are.
        0
    }

    fn samples(&self) -> u64 {
        self.measured.len() as u64
    }

    fn samples_of_derivatives(&self, fit: &Fit) -> u64 {
        self.samples() * fit.theta.len() as u64
    }
}

/// Sums that run side by side, so that they take no longer than the numbers take to arrive.
const SUMS: usize = 8;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; SUMS];
    let (a, b) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Takes the part along a unit row out of a row.
fn take_out(row: &mut [f64], unit: &[f64]) {
    let along = dot(row, unit);
    row.iter_mut().zip(unit).for_each(|(e, u)| *e -= along * u);
}

fn unit(row: &mut [f64]) {
    let size = dot(row, row).max(f64::MIN_POSITIVE).sqrt();
    row.iter_mut().for_each(|e| *e /= size);
}
