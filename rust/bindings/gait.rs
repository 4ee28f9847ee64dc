//! Gaits of one whole robot.

use crate::door::{enter, raise};
use crate::sweep::CancelToken;
use crate::tables::Parameter;
use locosweep::Error;
use locosweep::integrate::robot::{
    GAIT_OUTPUTS, GAIT_PARAMS, GaitTally, Now, Observer, PerPart, Plan, RunParameters, Trace,
    simulate,
};
use locosweep::physics::gait::{GAITS, Gait};
use locosweep::sweep::Control;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use std::sync::atomic::Ordering;

/// A gait: which segments move, phase by phase.
#[pyclass(frozen, get_all, module = "locosweep._core", name = "Gait")]
pub struct GaitRecord {
    name: &'static str,
    meaning: &'static str,
}

#[pymethods]
impl GaitRecord {
    fn __repr__(&self) -> String {
        format!("Gait(name='{}', meaning='{}')", self.name, self.meaning)
    }
}

/// A number that the run of a gait leaves.
#[pyclass(frozen, get_all, module = "locosweep._core", name = "GaitOutput")]
pub struct GaitOutputRecord {
    name: &'static str,
    symbol: &'static str,
    unit: &'static str,
    meaning: &'static str,
}

#[pymethods]
impl GaitOutputRecord {
    fn __repr__(&self) -> String {
        format!("GaitOutput(name='{}', unit='{}')", self.name, self.unit)
    }
}

/// A parameter of a run, where it stands in a gait file, and whether it belongs
/// to the run, to each segment or to each joint.
#[pyclass(frozen, get_all, module = "locosweep._core")]
pub struct GaitParameter {
    parameter: Py<Parameter>,
    part: &'static str,
    table: &'static str,
    key: &'static str,
}

/// All gaits.
#[pyfunction]
pub fn gaits() -> Vec<GaitRecord> {
    let record = |gait: &Gait| {
        let info = gait.info();
        GaitRecord { name: info.name, meaning: info.meaning }
    };
    GAITS.iter().map(record).collect()
}

/// What the run of a gait leaves, in order.
#[pyfunction]
pub fn gait_outputs() -> Vec<GaitOutputRecord> {
    let record = |output: &locosweep::integrate::robot::GaitOutput| GaitOutputRecord {
        name: output.name,
        symbol: output.symbol,
        unit: output.unit,
        meaning: output.meaning,
    };
    GAIT_OUTPUTS.iter().map(record).collect()
}

/// What the run of a gait takes.
#[pyfunction]
pub fn gait_parameters(py: Python<'_>) -> PyResult<Vec<GaitParameter>> {
    let record = |given: &locosweep::integrate::robot::GaitParam| {
        Ok(GaitParameter {
            parameter: Py::new(py, Parameter::from(given.id.param()))?,
            part: given.part.name(),
            table: given.table,
            key: given.key,
        })
    };
    GAIT_PARAMS.iter().map(record).collect()
}

/// Longer than any run lasts, s.
const NEVER: f64 = 1e300;

/// A trace that also looks whether the run has been called off.
struct Watched<'a> {
    trace: Trace,
    control: &'a Control,
}

impl Observer<f64> for Watched<'_> {
    const ON: bool = true;

    fn see(&mut self, now: &Now<f64>) {
        self.trace.see(now);
    }

    fn next(&self) -> f64 {
        self.trace.next()
    }

    fn go_on(&self) -> bool {
        !self.control.cancel.load(Ordering::Relaxed)
    }
}

/// What a run leaves. The rows of `x`, `v`, `slide` and `heap` have a number per
/// segment, those of `force` one per joint, one row after another.
#[pyclass(frozen, get_all, module = "locosweep._core")]
pub struct GaitResult {
    /// Code of the status; every result is NaN where it is not 0.
    status: u8,
    /// Name and value, in the order of `gait_outputs`.
    results: Vec<(&'static str, f64)>,
    /// Distance that each segment slides backward per cycle, m.
    slip: Py<PyArray1<f64>>,
    t: Py<PyArray1<f64>>,
    phase: Py<PyArray1<i64>>,
    x: Py<PyArray1<f64>>,
    v: Py<PyArray1<f64>>,
    force: Py<PyArray1<f64>>,
    slide: Py<PyArray1<i8>>,
    /// Fresh ground whose lubricant each segment pushes along, m; empty where the
    /// robot meets none.
    heap: Py<PyArray1<f64>>,
    power: Py<PyArray1<f64>>,
    propulsive: Py<PyArray1<f64>>,
}

/// Runs a gait. `parameters` hold for all parts alike, `per_segment` and
/// `per_joint` have a value for each; the motion is kept every `trace_every`
/// seconds, and only its start where that is not given.
#[pyfunction]
#[pyo3(signature = (gait, parameters, per_segment, per_joint, trace_every=None, token=None))]
pub fn gait_run(
    py: Python<'_>,
    gait: &str,
    parameters: Vec<(String, f64)>,
    per_segment: Vec<PerPart>,
    per_joint: Vec<PerPart>,
    trace_every: Option<f64>,
    token: Option<&CancelToken>,
) -> PyResult<GaitResult> {
    let given = Gait::parse(gait)
        .and_then(|gait| Ok((gait, RunParameters::new(&parameters, &per_segment, &per_joint)?)));
    let (gait, run) = given.map_err(|error| raise(py, error))?;
    let control = token.map_or_else(Default::default, CancelToken::control);
    let every = trace_every.filter(|every| *every > 0.0).unwrap_or(NEVER);
    let work = || {
        let trace = Trace::new(every);
        let mut watched = Watched { trace, control: &control };
        let tally = match gait.schedule(run.segments, run.moving) {
            Ok(schedule) => {
                let plan = Plan { schedule: &schedule, cycles: run.cycles };
                simulate(&run.robot, &plan, &run.options, &mut watched)
            }
            Err(status) => GaitTally::none(0.0, status),
        };
        if !Observer::<f64>::go_on(&watched) {
            return Err(Error::Cancelled { done: 0, total: 1 });
        }
        Ok((tally, watched.trace))
    };
    let (tally, trace) = enter(py, &control, 1, None, work)?;
    let phase: Vec<i64> = trace.phase.iter().map(|p| *p as i64).collect();
    let array = |values: Vec<f64>| values.into_pyarray(py).unbind();
    Ok(GaitResult {
        status: tally.status() as u8,
        results: GAIT_OUTPUTS.iter().map(|o| (o.name, (o.value)(&tally))).collect(),
        slip: array(tally.slip[..run.segments].to_vec()),
        t: array(trace.t),
        phase: phase.into_pyarray(py).unbind(),
        x: array(trace.x),
        v: array(trace.v),
        force: array(trace.force),
        slide: trace.slide.into_pyarray(py).unbind(),
        heap: array(trace.heap),
        power: array(trace.power),
        propulsive: array(trace.propulsive),
    })
}
