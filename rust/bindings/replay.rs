//! Replays of measured runs as a Python class.

use crate::door::{enter, input_error, raise};
use crate::sweep::CancelToken;
use locosweep::lane::Level;
use locosweep::physics::effects::{Active, EFFECT_PARAMS, Effect, Nominal};
use locosweep::physics::robot::Motor;
use locosweep::sweep::replay::{
    Column, DIRECTIONS, OTHER_DIRECTIONS, Part, Run, replay_into, replay_with_sensitivities,
    samples,
};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use numpy::{PyArrayMethods, PyReadwriteArray2};
use pyo3::prelude::*;
use std::collections::HashMap;

/// Numbers of what a replay reads: x, v, x_rear and force.
pub const READ: [usize; 4] = [0, 1, 2, 3];

/// Runs of a drive, and the model that they are replayed through.
#[pyclass(frozen, module = "locosweep._core")]
pub struct Replay {
    pub nominal: Nominal,
    pub runs: Vec<Run>,
}

#[pymethods]
impl Replay {
    /// `nominal` has the keys segments, mass, gravity, viscous, slope_deg, gain,
    /// limit, and mu_coulomb or coulomb_force; for a pendulum also
    /// gravity_torque. Each run is (times in s from 0, drive, slope in degrees).
    #[new]
    #[allow(clippy::type_complexity)]
    fn new(
        py: Python<'_>,
        nominal: HashMap<String, f64>,
        runs: Vec<(PyReadonlyArray1<'_, f64>, PyReadonlyArray1<'_, f64>, f64)>,
    ) -> PyResult<Replay> {
        let need = |name: &str| {
            let value = nominal.get(name).copied();
            value.ok_or_else(|| input_error(py, format!("the nominal model has no {name}")))
        };
        let coulomb_force = nominal.get("coulomb_force").copied();
        let gravity_torque = nominal.get("gravity_torque").copied();
        let model = Nominal {
            segments: need("segments")?,
            mass: need("mass")?,
            gravity: need("gravity")?,
            mu_coulomb: if coulomb_force.is_some() { 0.0 } else { need("mu_coulomb")? },
            coulomb_force,
            viscous: need("viscous")?,
            slope_deg: need("slope_deg")?,
            gain: need("gain")?,
            limit: need("limit")?,
            rotary: gravity_torque.is_some(),
            gravity_torque: gravity_torque.unwrap_or(0.0),
        };
        let mut read = Vec::with_capacity(runs.len());
        for (i, (times, drive, slope_deg)) in runs.into_iter().enumerate() {
            let run = Run {
                times: times.as_array().to_vec(),
                drive: drive.as_array().to_vec(),
                slope_deg,
            };
            let rises = run.times.windows(2).all(|pair| pair[0] < pair[1]);
            let finite = run.times.iter().chain(&run.drive).all(|value| value.is_finite());
            if run.times.is_empty() || run.times.len() != run.drive.len() || !rises || !finite {
                let message = format!(
                    "run {i}: allowed are as many finite drive values as rising times, at least one"
                );
                return Err(input_error(py, message));
            }
            read.push(run);
        }
        Ok(Replay { nominal: model, runs: read })
    }

    /// Samples of each run.
    #[getter]
    fn lengths(&self) -> Vec<usize> {
        self.runs.iter().map(|run| run.times.len()).collect()
    }

    /// Replay columns, each (run, first sample, one beyond the last, effects).
    ///
    /// `values` holds the parameters of all effects, a row a column; `shares`
    /// factors on nominal mass, Coulomb level and gain, and the clock offset in
    /// s; `starts` position and speed at the window's start. `channels` are the rows that
    /// are returned, by number, of x, v, x_rear and force, which come without it; all columns
    /// one after another.
    #[pyo3(signature = (columns, values, shares, starts, threads, progress=None, token=None, channels=None))]
    #[allow(clippy::too_many_arguments, clippy::type_complexity)]
    fn run<'py>(
        &self,
        py: Python<'py>,
        columns: Vec<(usize, usize, usize, Vec<String>)>,
        values: PyReadonlyArray2<'_, f64>,
        shares: PyReadonlyArray2<'_, f64>,
        starts: PyReadonlyArray2<'_, f64>,
        threads: usize,
        progress: Option<Py<PyAny>>,
        token: Option<&CancelToken>,
        channels: Option<Vec<usize>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let channels = asked(py, channels)?;
        let made = self.columns(py, columns, values, shares, starts)?;
        let level = Level::current().map_err(|error| raise(py, error))?;
        let control = token.map_or_else(Default::default, CancelToken::control);
        let total = samples(&made);
        // NumPy asks for huge pages where there is much of it.
        let read = PyArray2::<f64>::zeros(py, [channels.len(), total], false);
        let mut writable: PyReadwriteArray2<f64> = read.readwrite();
        let to = rows(writable.as_slice_mut(), &channels).map_err(|e| input_error(py, e))?;
        let how = (level, threads);
        let work = || replay_into(&self.nominal, &self.runs, &made, how, &control, to);
        enter(py, &control, made.len() as u64, progress.as_ref(), work)?;
        drop(writable);
        Ok(read)
    }

    /// The same with derivatives: `directions` lists for every column what they are taken
    /// by, as `sensitivity_directions` numbers them. Returns the rows of `run`, and as many
    /// in which a column has as many of its lengths as it has directions, one direction
    /// after another.
    #[pyo3(signature = (columns, values, shares, starts, directions, threads, progress=None, token=None, channels=None))]
    #[allow(clippy::too_many_arguments, clippy::type_complexity)]
    fn run_with_sensitivities<'py>(
        &self,
        py: Python<'py>,
        columns: Vec<(usize, usize, usize, Vec<String>)>,
        values: PyReadonlyArray2<'_, f64>,
        shares: PyReadonlyArray2<'_, f64>,
        starts: PyReadonlyArray2<'_, f64>,
        directions: Vec<Vec<usize>>,
        threads: usize,
        progress: Option<Py<PyAny>>,
        token: Option<&CancelToken>,
        channels: Option<Vec<usize>>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
        let channels = asked(py, channels)?;
        let made = self.columns(py, columns, values, shares, starts)?;
        if directions.len() != made.len() || directions.iter().flatten().any(|d| *d >= DIRECTIONS) {
            let message = format!(
                "directions: allowed is a list for each of {} columns, of numbers below {DIRECTIONS}",
                made.len()
            );
            return Err(input_error(py, message));
        }
        let level = Level::current().map_err(|error| raise(py, error))?;
        let control = token.map_or_else(Default::default, CancelToken::control);
        let total = samples(&made);
        let made: Vec<(Column, Vec<usize>)> = made.into_iter().zip(directions).collect();
        let length = |column: &Column| column.window.1 - column.window.0;
        let all: usize = made.iter().map(|(column, by)| length(column) * by.len()).sum();
        let read = PyArray2::<f64>::zeros(py, [channels.len(), total], false);
        let slopes = PyArray2::<f64>::zeros(py, [channels.len(), all], false);
        let (mut to, mut by) = (read.readwrite(), slopes.readwrite());
        let to = rows(to.as_slice_mut(), &channels).map_err(|e| input_error(py, e))?;
        let by = rows(by.as_slice_mut(), &channels).map_err(|e| input_error(py, e))?;
        let how = (level, threads);
        let work =
            || replay_with_sensitivities(&self.nominal, &self.runs, &made, how, &control, (to, by));
        enter(py, &control, made.len() as u64, progress.as_ref(), work)?;
        Ok((read, slopes))
    }
}

impl Replay {
    #[allow(clippy::type_complexity)]
    fn columns(
        &self,
        py: Python<'_>,
        columns: Vec<(usize, usize, usize, Vec<String>)>,
        values: PyReadonlyArray2<'_, f64>,
        shares: PyReadonlyArray2<'_, f64>,
        starts: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Vec<Column>> {
        let count = columns.len();
        let (values, shares, starts) = (values.as_array(), shares.as_array(), starts.as_array());
        let shapes = [values.dim(), shares.dim(), starts.dim()];
        if shapes != [(count, EFFECT_PARAMS), (count, 4), (count, 2)] {
            let message = format!(
                "values, shares and starts have shapes {shapes:?}: allowed are ({count}, {EFFECT_PARAMS}), ({count}, 4) and ({count}, 2)"
            );
            return Err(input_error(py, message));
        }
        let mut made = Vec::with_capacity(count);
        for (i, (run, first, last, names)) in columns.into_iter().enumerate() {
            let length = self.runs.get(run).map_or(0, |run| run.times.len());
            if first >= last || last > length {
                let message = format!(
                    "column {i} is samples {first} to {last} of run {run}: allowed is a window within its {length} samples"
                );
                return Err(input_error(py, message));
            }
            let mut active = Active::default();
            for name in &names {
                active = active.with(Effect::parse(name).map_err(|error| raise(py, error))?);
            }
            made.push(Column {
                run,
                window: (first, last),
                active,
                values: std::array::from_fn(|k| values[[i, k]]),
                shares: std::array::from_fn(|k| shares[[i, k]]),
                start: (starts[[i, 0]], starts[[i, 1]]),
                sliding_distance: 0.0,
            });
        }
        Ok(made)
    }
}

/// Numbers of the rows that are asked for, all without any.
fn asked(py: Python<'_>, channels: Option<Vec<usize>>) -> PyResult<Vec<usize>> {
    let Some(channels) = channels else { return Ok(READ.to_vec()) };
    let twice = |i: usize| channels[..i].contains(&channels[i]);
    if channels.is_empty() || (0..channels.len()).any(|i| channels[i] >= READ.len() || twice(i)) {
        let message = format!(
            "channels are {channels:?}: allowed are different numbers below {}, at least one",
            READ.len()
        );
        return Err(input_error(py, message));
    }
    Ok(channels)
}

/// The rows of a table that hold x, v, x_rear and force, of which `channels` are there.
pub fn rows<'a, E: std::fmt::Display>(
    whole: Result<&'a mut [f64], E>,
    channels: &[usize],
) -> Result<Part<'a>, String> {
    let whole = whole.map_err(|error| error.to_string())?;
    let length = whole.len() / channels.len();
    let mut to = Part::default();
    for (channel, row) in channels.iter().zip(whole.chunks_exact_mut(length.max(1))) {
        to[*channel] = row;
    }
    Ok(to)
}

/// Names of what derivatives may be taken by beside the parameters of effects, which
/// come first: they follow in this order.
#[pyfunction]
pub fn sensitivity_directions() -> Vec<&'static str> {
    OTHER_DIRECTIONS.to_vec()
}

/// Electric power in W at forces and speeds, of a motor that is given by its supply
/// voltage, resistance and force constant.
#[pyfunction]
pub fn motor_power<'py>(
    py: Python<'py>,
    force: PyReadonlyArray1<'py, f64>,
    speed: PyReadonlyArray1<'py, f64>,
    motor: (f64, f64, f64),
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (force, speed) = (force.as_array(), speed.as_array());
    if force.len() != speed.len() {
        return Err(input_error(py, "force and speed must be equally long".to_owned()));
    }
    let (supply, resistance, force_constant) = motor;
    let motor = Motor { supply, resistance, force_constant };
    let power: Vec<f64> = force.iter().zip(speed).map(|(f, v)| motor.power(*f, *v)).collect();
    Ok(power.into_pyarray(py))
}
