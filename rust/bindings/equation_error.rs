//! The equation error of measured runs as a Python class.

use crate::door::input_error;
use crate::fit::{Experiment, GivenFit, through_door};
use locosweep::sweep::fit::{self, Blocks, FINE, Motion, Rule};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

type Array<'py> = PyReadonlyArray1<'py, f64>;

/// Displacements of models along the measured motion of runs.
#[pyclass(frozen, module = "locosweep._core")]
pub struct EquationError {
    core: fit::EquationError,
}

#[pymethods]
impl EquationError {
    /// `experiment` has each run as a span; `motions` x, v and sliding distance at the samples
    /// of each, and its slides in one direction, pairs of first sample and one beyond the last.
    /// `means`, `weights` and `times` are those of blocks of `block` samples, slide by slide:
    /// mean reading of x, its inverse deviation (0 where nothing was read) and mean time.
    #[new]
    #[pyo3(signature = (experiment, motions, block, means, weights, times))]
    #[allow(clippy::type_complexity)]
    fn new(
        py: Python<'_>,
        experiment: &Experiment,
        motions: Vec<(Array<'_>, Array<'_>, Array<'_>, Vec<(usize, usize)>)>,
        block: usize,
        means: Array<'_>,
        weights: Array<'_>,
        times: Array<'_>,
    ) -> PyResult<EquationError> {
        let read = |array: &Array<'_>| array.as_array().to_vec();
        let motions: Vec<Motion> = motions
            .iter()
            .map(|(x, v, s, slides)| Motion {
                x: read(x),
                v: read(v),
                sliding_distance: read(s),
                slides: slides.clone(),
            })
            .collect();
        let spans = experiment.core.spans();
        if block == 0 || motions.len() != spans.len() {
            let message = format!(
                "block is {block}, motions are {}: allowed is a block of at least one sample, and a motion for each of {} runs",
                motions.len(),
                spans.len()
            );
            return Err(input_error(py, message));
        }
        for (i, (motion, span)) in motions.iter().zip(spans).enumerate() {
            let (length, slides) = (span.samples(), &motion.slides);
            let within = slides.iter().all(|(from, to)| from < to && *to <= length);
            let follow = slides.windows(2).all(|pair| pair[0].1 <= pair[1].0 + 1);
            let lengths = [motion.x.len(), motion.v.len(), motion.sliding_distance.len()];
            if span.run != i || span.window.0 != 0 || lengths != [length; 3] || !within || !follow {
                let message = format!(
                    "motion {i}: allowed are {length} positions, speeds and distances of the whole run, and slides that follow each other within them"
                );
                return Err(input_error(py, message));
            }
        }
        let blocks = Blocks {
            size: block,
            readings: read(&means),
            weights: read(&weights),
            times: read(&times),
        };
        let core = fit::EquationError::new(experiment.core.clone(), motions, blocks);
        let core = core.ok_or_else(|| {
            let message = format!("means, weights and times: allowed are those of blocks of {block} samples of all slides, of which there has to be one");
            input_error(py, message)
        })?;
        Ok(EquationError { core })
    }

    /// What was measured, in the form of `displacements`.
    fn measured<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.core.measured().to_vec().into_pyarray(py)
    }

    /// How far fits would have come in each slide under the forces of the measured motion, a
    /// row each: block by block in units of the noise, without the line in time of every slide.
    /// Bristles are left out, and what a fit says about the start of a run.
    fn displacements<'py>(
        &self,
        py: Python<'py>,
        fits: Vec<GivenFit<'_>>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let fits = made(py, &fits)?;
        let models: Vec<_> = fits.iter().map(|fit| (fit, fit.theta.clone())).collect();
        let rows = through_door(py, threads, |how| self.core.displacements(&models, how))?;
        rows.into_pyarray(py).reshape([models.len(), self.core.measured().len()])
    }

    /// Derivatives of the displacements of a fit, a row for every free value but those about
    /// the start of a run.
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        fit: GivenFit<'_>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let fit = fit.anywhere(py)?;
        let rows = through_door(py, threads, |how| self.core.jacobian(&fit, how))?;
        let shape = [fit.theta.len(), self.core.measured().len()];
        rows.into_pyarray(py).reshape(shape)
    }

    /// Improve fits; returns theta, without what is about the start of a run, and chi2 of each.
    #[allow(clippy::type_complexity)]
    fn fit<'py>(
        &self,
        py: Python<'py>,
        fits: Vec<GivenFit<'_>>,
        steps: usize,
        tolerance: f64,
        threads: usize,
    ) -> PyResult<Vec<(Bound<'py, PyArray1<f64>>, f64)>> {
        let mut fits = made(py, &fits)?;
        let rule = Rule { steps, tolerance, share: FINE, least: Some(f64::INFINITY) };
        through_door(py, threads, |how| fit::fit(&self.core, &mut fits, rule, how))?;
        let given = |fit: fit::Fit| {
            let theta = fit.theta.as_slice().to_vec().into_pyarray(py);
            (theta, fit.chi2.unwrap_or(f64::INFINITY))
        };
        Ok(fits.into_iter().map(given).collect())
    }
}

fn made(py: Python<'_>, fits: &[GivenFit<'_>]) -> PyResult<Vec<fit::Fit>> {
    fits.iter().map(|fit| fit.anywhere(py)).collect()
}
