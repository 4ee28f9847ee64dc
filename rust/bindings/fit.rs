//! Fits of models to measured runs as Python classes.

use crate::door::{enter, input_error, raise};
use crate::replay::{READ, Replay, rows};
use crate::slides::GivenSlides;
use locosweep::Error;
use locosweep::lane::Level;
use locosweep::physics::effects::{Active, EFFECT_PARAMS, Effect};
use locosweep::physics::robot::Motor;
use locosweep::sweep::Control;
use locosweep::sweep::fit::{self, Begin, Coordinate, How, Point, Rule, Shift, Signal, Source};
use locosweep::sweep::fit::{DMatrix, DVector, FINE, OverSpans, Replayed, Span, Terms, What};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use numpy::{PyReadonlyArray2, PyReadwriteArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::sync::Arc;

type Array<'py> = PyReadonlyArray1<'py, f64>;
type Table<'py> = PyReadonlyArray2<'py, f64>;

/// Measured runs, or windows of them, as they are replayed.
#[pyclass(frozen, module = "locosweep._core")]
pub struct Experiment {
    pub core: Arc<fit::Experiment>,
}

/// A model with values, as Python has it.
#[derive(FromPyObject)]
struct GivenPoint<'py> {
    names: Vec<String>,
    values: Array<'py>,
    factors: Array<'py>,
    speeds: Array<'py>,
    start_offsets: Array<'py>,
}

#[derive(FromPyObject)]
struct GivenFree {
    effect: String,
    name: String,
    log: bool,
    size: f64,
    low: f64,
    high: f64,
}

#[derive(FromPyObject)]
struct GivenModel {
    names: Vec<String>,
    free: Vec<GivenFree>,
}

#[derive(FromPyObject)]
struct GivenNuisances {
    moving: Vec<usize>,
    spread: [f64; 4],
    speed: f64,
    start_offsets: Vec<(usize, f64)>,
}

#[derive(FromPyObject)]
pub struct GivenFit<'py> {
    model: GivenModel,
    nuisances: GivenNuisances,
    theta: Array<'py>,
    chi2: f64,
    covariance: Table<'py>,
    damping: f64,
    limit: f64,
}

/// Bounds of what is known before, in deviations.
const AROUND: f64 = 8.0;

fn active_of(py: Python<'_>, names: &[String]) -> PyResult<Active> {
    names.iter().try_fold(Active::default(), |active, name| {
        Ok(active.with(Effect::parse(name).map_err(|error| raise(py, error))?))
    })
}

impl GivenPoint<'_> {
    fn point(&self, py: Python<'_>, experiment: &fit::Experiment) -> PyResult<Point> {
        let (values, shares) = (self.values.as_array(), self.factors.as_array());
        if (values.len(), shares.len()) != (EFFECT_PARAMS, 4) {
            let message = format!(
                "values and factors have lengths {} and {}: allowed are {EFFECT_PARAMS} and 4",
                values.len(),
                shares.len()
            );
            return Err(input_error(py, message));
        }
        let spans = experiment.spans().len();
        let fits = |array: &Array<'_>| array.len() == spans;
        if experiment.begins_with_runs() && !(fits(&self.speeds) && fits(&self.start_offsets)) {
            let message = format!("speeds and start_offsets: allowed are {spans} numbers each");
            return Err(input_error(py, message));
        }
        Ok(Point {
            active: active_of(py, &self.names)?,
            values: std::array::from_fn(|k| values[k]),
            shares: std::array::from_fn(|k| shares[k]),
            speeds: self.speeds.as_array().to_vec(),
            offsets: self.start_offsets.as_array().to_vec(),
        })
    }
}

impl GivenFree {
    fn coordinate(&self, py: Python<'_>) -> PyResult<(What, Coordinate)> {
        let effect = Effect::parse(&self.effect).map_err(|error| raise(py, error))?;
        let place = effect.info().params.iter().position(|p| p.param.name == self.name);
        let unknown = || input_error(py, format!("{} has no {}", self.effect, self.name));
        let index = effect.first() + place.ok_or_else(unknown)?;
        let bound = |value: f64| if self.log { value.ln() } else { value };
        let (low, high) = (bound(self.low), bound(self.high));
        let coordinate = Coordinate { low, high, size: self.size, deviation: f64::INFINITY };
        Ok((What::Parameter { index, log: self.log }, coordinate))
    }
}

/// Least shares of mass, Coulomb level and gain beyond their nominal values, and the least clock
/// offset: friction may vanish, a mass and a gain stay positive.
const LEAST_SHARES: [f64; 4] = [-0.99, -1.0, -0.99, f64::NEG_INFINITY];

impl GivenNuisances {
    /// In the order of `theta`: uncertain values, start speeds, start positions.
    fn coordinates(&self) -> impl Iterator<Item = (What, Coordinate)> {
        let around = |what: What, deviation: f64| {
            let most = AROUND * deviation;
            (what, Coordinate { low: -most, high: most, size: deviation, deviation })
        };
        let uncertain = self.spread.iter().enumerate().filter(|(_, deviation)| **deviation > 0.0);
        let shares = uncertain.map(move |(k, deviation)| {
            let (what, around) = around(What::Share(k), *deviation);
            (what, Coordinate { low: around.low.max(LEAST_SHARES[k]), ..around })
        });
        let free = Coordinate {
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
            size: self.speed,
            deviation: f64::INFINITY,
        };
        let speeds = self.moving.iter().map(move |span| (What::Speed(*span), free));
        let offsets = self.start_offsets.iter();
        let offsets = offsets.map(move |(span, deviation)| around(What::Offset(*span), *deviation));
        shares.chain(speeds).chain(offsets)
    }
}

impl GivenFit<'_> {
    /// The same without what is about the start of a run, to be evaluated.
    pub fn anywhere(&self, py: Python<'_>) -> PyResult<fit::Fit> {
        let mut fit = self.fit(py, false)?;
        // What is about a run stands behind all else.
        fit.model.free.retain(|one| matches!(one, What::Parameter { .. } | What::Share(_)));
        fit.coordinates.truncate(fit.model.free.len());
        fit.theta = fit.theta.rows(0, fit.coordinates.len()).into_owned();
        fit.covariance = None;
        Ok(fit)
    }

    fn fit(&self, py: Python<'_>, known: bool) -> PyResult<fit::Fit> {
        let own = self.model.free.iter().map(|free| free.coordinate(py));
        let coordinates = own.chain(self.nuisances.coordinates().map(Ok));
        let (free, coordinates): (Vec<_>, Vec<_>) =
            coordinates.collect::<PyResult<Vec<_>>>()?.into_iter().unzip();
        let (theta, covariance) = (self.theta.as_array(), self.covariance.as_array());
        if theta.len() != coordinates.len() {
            let message = format!(
                "theta has {} values: allowed are {}, one for every free value",
                theta.len(),
                coordinates.len()
            );
            return Err(input_error(py, message));
        }
        let given = covariance.dim() == (theta.len(), theta.len());
        let entries = || DMatrix::from_fn(theta.len(), theta.len(), |i, j| covariance[[i, j]]);
        Ok(fit::Fit {
            model: Replayed { active: active_of(py, &self.model.names)?, free },
            coordinates,
            theta: DVector::from_iterator(theta.len(), theta.iter().copied()),
            chi2: known.then_some(self.chi2),
            covariance: given.then(entries),
            damping: self.damping,
            limit: self.limit,
        })
    }
}

/// A fit as it came out: theta, chi2, covariance and damping.
type Found<'py> = (Bound<'py, PyArray1<f64>>, f64, Bound<'py, PyArray2<f64>>, f64);

#[pymethods]
impl Experiment {
    /// `spans` lists what is replayed at a time: the number of a run, first sample, one
    /// beyond the last, factor on the mass, and whether the robot was turned round.
    /// `begins` has a row for each: position and speed; or, of a window, the position,
    /// speed and acceleration that were seen there, seconds since the start of its run,
    /// the position there, and the distance moved forward since the last rest or turn.
    /// `motor` is resistance and force constant.
    #[new]
    #[pyo3(signature = (job, spans, begins, motor=None))]
    fn new(
        py: Python<'_>,
        job: &Replay,
        spans: Vec<(usize, usize, usize, f64, bool)>,
        begins: Table<'_>,
        motor: Option<(f64, f64)>,
    ) -> PyResult<Experiment> {
        let begins = begins.as_array();
        if begins.nrows() != spans.len() || ![2, 6].contains(&begins.ncols()) {
            let message = format!(
                "begins has shape {:?}: allowed are ({}, 2) and ({}, 6)",
                begins.dim(),
                spans.len(),
                spans.len()
            );
            return Err(input_error(py, message));
        }
        let mut made = Vec::with_capacity(spans.len());
        for (i, (run, first, last, payload, reversed)) in spans.into_iter().enumerate() {
            let length = job.runs.get(run).map_or(0, |run| run.times.len());
            if first >= last || last > length {
                let message = format!(
                    "span {i} is samples {first} to {last} of run {run}: allowed is a window within its {length} samples"
                );
                return Err(input_error(py, message));
            }
            let row = begins.row(i);
            let begin = if row.len() == 2 {
                Begin::Run { position: row[0], speed: row[1] }
            } else {
                Begin::Seen {
                    state: [row[0], row[1], row[2]],
                    since: row[3],
                    base: row[4],
                    sliding_distance: row[5],
                }
            };
            made.push(Span { run, window: (first, last), begin, payload, reversed });
        }
        // A force that was given had the voltage that it needs.
        let motor = motor.map(|(resistance, force_constant)| Motor {
            supply: f64::INFINITY,
            resistance,
            force_constant,
        });
        let core = fit::Experiment::new(job.nominal, job.runs.clone(), made, motor);
        Ok(Experiment { core: Arc::new(core) })
    }

    /// What the sensors would read: rows of x, v, x_rear and force, point after point, span
    /// after span. `moved` shifts position and speed at the start of each span.
    #[pyo3(signature = (points, spans, threads, moved=None))]
    fn read<'py>(
        &self,
        py: Python<'py>,
        points: Vec<GivenPoint<'_>>,
        spans: Vec<usize>,
        threads: usize,
        moved: Option<Table<'_>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = points_of(py, &self.core, &points, &spans)?;
        let moved = moved.map(|table| {
            let table = table.as_array();
            table.rows().into_iter().map(|row| (row[0], row[1])).collect::<Vec<(f64, f64)>>()
        });
        let total = points.len() * self.core.samples(&spans);
        let read = PyArray2::<f64>::zeros(py, [READ.len(), total], false);
        let mut writable: PyReadwriteArray2<f64> = read.readwrite();
        let to = rows(writable.as_slice_mut(), &READ).map_err(|e| input_error(py, e))?;
        through_door(py, threads, |how| {
            fit::readings(&self.core, &points, &spans, moved.as_deref(), how, to)
        })?;
        drop(writable);
        Ok(read)
    }
}

/// Measured runs, and how far models may be from them.
#[pyclass(frozen, module = "locosweep._core")]
pub struct Misfit {
    core: fit::Misfit,
}

#[pymethods]
impl Misfit {
    /// `channels` lists what was measured: the row of `Experiment.read` that predicts it,
    /// None for electric power, readings, and inverse deviations, 0 where a sample does
    /// not count. `shifts` lists what may differ from span to span: the channels that it
    /// acts on, by number, and what a deviation of it changes in their weighted readings.
    #[new]
    #[allow(clippy::type_complexity)]
    fn new(
        py: Python<'_>,
        experiment: &Experiment,
        channels: Vec<(Option<usize>, Array<'_>, Array<'_>)>,
        shifts: Vec<Vec<(usize, Array<'_>)>>,
    ) -> PyResult<Misfit> {
        let every: Vec<usize> = (0..experiment.core.spans().len()).collect();
        let total = experiment.core.samples(&every);
        let signals: Vec<Signal> = channels
            .iter()
            .map(|(row, measured, weights)| Signal {
                source: row.map_or(Source::Power, Source::Replayed),
                measured: measured.as_array().to_vec(),
                weights: weights.as_array().to_vec(),
            })
            .collect();
        let shifts: Vec<Shift> = shifts
            .iter()
            .map(|shift| shift.iter().map(|(c, u)| (*c, u.as_array().to_vec())).collect())
            .collect();
        let lengths = signals.iter().flat_map(|s| [s.measured.len(), s.weights.len()]);
        let lengths = lengths.chain(shifts.iter().flatten().map(|(_, u)| u.len()));
        let known = |(c, _): &(usize, Vec<f64>)| *c < signals.len();
        let rows = channels.iter().all(|(row, ..)| row.is_none_or(|row| row < 4));
        let fits = lengths.into_iter().all(|n| n == total) && shifts.iter().flatten().all(known);
        if !rows || !fits {
            let message = format!(
                "channels and shifts: allowed are rows below 4, arrays of {total} samples, and channels below {}",
                channels.len()
            );
            return Err(input_error(py, message));
        }
        Ok(Misfit { core: fit::Misfit::new(experiment.core.clone(), &signals, &shifts) })
    }

    /// Whitened residuals of models over some spans, a row each: channel by channel, span
    /// by span, and last the shifts in deviations, at most `most` of them.
    #[pyo3(signature = (points, spans, threads, most=f64::INFINITY))]
    fn residuals<'py>(
        &self,
        py: Python<'py>,
        points: Vec<GivenPoint<'_>>,
        spans: Vec<usize>,
        threads: usize,
        most: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = points_of(py, self.core.experiment(), &points, &spans)?;
        let found = PyArray2::<f64>::zeros(py, [points.len(), self.core.residuals(&spans)], false);
        let mut writable: PyReadwriteArray2<f64> = found.readwrite();
        let to = writable.as_slice_mut().map_err(|error| input_error(py, error.to_string()))?;
        through_door(py, threads, |how| {
            fit::residuals(&self.core, &points, &spans, most, how, to)
        })?;
        drop(writable);
        Ok(found)
    }

    /// What small forces along a motion over some spans, or, without one, errors of the position
    /// that is read, change of residuals: terms a row each, in tables one after another, into the
    /// front of the rows of `to`.
    #[allow(clippy::too_many_arguments)]
    fn corrections(
        &self,
        py: Python<'_>,
        terms: Vec<Table<'_>>,
        motion: Option<GivenSlides<'_>>,
        spans: Vec<usize>,
        threads: usize,
        mut to: PyReadwriteArray2<'_, f64>,
    ) -> PyResult<()> {
        check_spans(py, self.core.experiment(), &spans)?;
        let (samples, length) =
            (self.core.experiment().samples(&spans), self.core.residuals(&spans));
        let [rows, width] = [to.shape()[0], to.shape()[1]];
        let fits = terms.iter().all(|table| table.shape()[1] == samples) && length <= width;
        if !fits || terms.iter().map(|table| table.shape()[0]).sum::<usize>() != rows {
            let message = format!(
                "terms and to: allowed are as many rows, {samples} and at least {length} columns"
            );
            return Err(input_error(py, message));
        }
        if rows == 0 || samples == 0 {
            return Ok(());
        }
        let unordered = || input_error(py, "terms and to must be stored row by row".to_owned());
        // A table that is stored column by column has a slice, too.
        if !(to.is_c_contiguous() && terms.iter().all(|table| table.is_c_contiguous())) {
            return Err(unordered());
        }
        let whole = |_| unordered();
        let mut each: Vec<&[f64]> = Vec::with_capacity(rows);
        for table in &terms {
            each.extend(table.as_slice().map_err(whole)?.chunks_exact(samples));
        }
        let mut to: Vec<&mut [f64]> =
            to.as_slice_mut().map_err(whole)?.chunks_exact_mut(width).collect();
        let what = match &motion {
            Some(motion) => Terms::Forces(motion.slides(py, samples)?),
            None => Terms::Readings,
        };
        through_door(py, threads, |how| {
            fit::corrections(&self.core, &each, what, &spans, how, &mut to)
        })
    }

    /// Chi2 of fits over some spans, and, where they are kept, their residuals and last
    /// those of what is known before.
    #[allow(clippy::type_complexity)]
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        fits: Vec<GivenFit<'_>>,
        spans: Vec<usize>,
        threads: usize,
        keep: bool,
    ) -> PyResult<Vec<(f64, Option<Bound<'py, PyArray1<f64>>>)>> {
        let fits = self.fits(py, &fits, &spans, &vec![false; fits.len()])?;
        let models: Vec<_> = fits.iter().map(|fit| (fit, fit.theta.clone())).collect();
        let found =
            through_door(py, threads, |how| fit::evaluate(&self.core, &models, &spans, keep, how))?;
        let given = |one: fit::Evaluated| (one.chi2, one.residual.map(|e| e.into_pyarray(py)));
        Ok(found.into_iter().map(given).collect())
    }

    /// Derivatives of a fit's residuals over some spans, a row for every free value.
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        fit: GivenFit<'_>,
        spans: Vec<usize>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let made = self.fits(py, &[fit], &spans, &[true])?;
        let rows =
            through_door(py, threads, |how| fit::jacobian(&self.core, &made[0], &spans, how))?;
        let length = rows.first().map_or_else(|| self.core.residuals(&spans), Vec::len);
        let count = rows.len();
        rows.concat().into_pyarray(py).reshape([count, length])
    }

    /// Improve fits; `known` says of which chi2 is known, `least` is the
    /// smallest one that others have come to, None where each fit stands alone.
    /// Returns theta, chi2, covariance and damping of each, and the number of
    /// samples that were replayed.
    #[allow(clippy::too_many_arguments)]
    fn fit<'py>(
        &self,
        py: Python<'py>,
        fits: Vec<GivenFit<'_>>,
        known: Vec<bool>,
        spans: Vec<usize>,
        steps: usize,
        tolerance: f64,
        least: Option<f64>,
        threads: usize,
    ) -> PyResult<(Vec<Found<'py>>, u64)> {
        let mut made = self.fits(py, &fits, &spans, &known)?;
        let rule = Rule { steps, tolerance, share: FINE, least };
        let objective = OverSpans { misfit: &self.core, spans: &spans };
        let ended = through_door(py, threads, |how| fit::fit(&objective, &mut made, rule, how))?;
        let found = made.into_iter().map(|fit| {
            let covariance = fit.covariance.unwrap_or_else(|| DMatrix::zeros(0, 0));
            // It is symmetric: its columns are its rows.
            let shape = [covariance.nrows(), covariance.ncols()];
            let covariance = covariance.as_slice().to_vec().into_pyarray(py).reshape(shape)?;
            let theta = fit.theta.as_slice().to_vec().into_pyarray(py);
            Ok((theta, fit.chi2.unwrap_or(f64::INFINITY), covariance, fit.damping))
        });
        Ok((found.collect::<PyResult<Vec<Found<'py>>>>()?, ended.evaluated))
    }
}

impl Misfit {
    fn fits(
        &self,
        py: Python<'_>,
        fits: &[GivenFit<'_>],
        spans: &[usize],
        known: &[bool],
    ) -> PyResult<Vec<fit::Fit>> {
        check_spans(py, self.core.experiment(), spans)?;
        fits.iter().zip(known).map(|(fit, known)| fit.fit(py, *known)).collect()
    }
}

fn check_spans(py: Python<'_>, experiment: &fit::Experiment, spans: &[usize]) -> PyResult<()> {
    let count = experiment.spans().len();
    if spans.iter().any(|span| *span >= count) {
        return Err(input_error(
            py,
            format!("spans are {spans:?}: allowed are those below {count}"),
        ));
    }
    Ok(())
}

fn points_of(
    py: Python<'_>,
    experiment: &fit::Experiment,
    points: &[GivenPoint<'_>],
    spans: &[usize],
) -> PyResult<Vec<Point>> {
    check_spans(py, experiment, spans)?;
    points.iter().map(|point| point.point(py, experiment)).collect()
}

pub fn through_door<T: Send>(
    py: Python<'_>,
    threads: usize,
    work: impl FnOnce(&How) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let level = Level::current().map_err(|error| raise(py, error))?;
    let control = Control::default();
    enter(py, &control, 0, None, || work(&How { level, threads, control: &control }))
}
