//! Fits of friction laws to measured motion and friction force.

use crate::door::{enter, enter_briefly, input_error, raise};
use crate::sweep::CancelToken;
use locosweep::friction_fit::spread;
use locosweep::friction_fit::ties::rank;
use locosweep::friction_fit::velocity;
use locosweep::friction_fit::{self, Candidate, FALLS, Found, Measured, Outcome, Pressing, Run};
use locosweep::physics::ParamId;
use locosweep::physics::friction::LawEntry;
use locosweep::physics::friction::imposed::Motion;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

type Array<'py> = PyReadonlyArray1<'py, f64>;

/// Name and meaning of every relation between friction level and load.
#[pyfunction]
pub fn pressings() -> Vec<(&'static str, &'static str)> {
    Pressing::ALL.iter().map(|(_, name, meaning)| (*name, *meaning)).collect()
}

/// Name of every parameter that says over which speeds friction passes from one level to
/// the other, and whether it is one over that speed.
#[pyfunction]
pub fn falls() -> Vec<(&'static str, bool)> {
    FALLS.iter().map(|(id, inverse)| (id.param().name, *inverse)).collect()
}

/// A friction law to fit, how its levels follow the load, and what the force
/// sensor adds.
#[pyclass(frozen, from_py_object, module = "locosweep._core")]
#[derive(Clone)]
pub struct FrictionCandidate(Candidate);

#[pymethods]
impl FrictionCandidate {
    #[new]
    #[pyo3(signature = (law, load="constant", *, offset=false, gain=false))]
    fn new(
        py: Python<'_>,
        law: &str,
        load: &str,
        offset: bool,
        gain: bool,
    ) -> PyResult<FrictionCandidate> {
        let law = LawEntry::parse(law).map_err(|error| raise(py, error))?;
        let pressing = Pressing::parse(load).map_err(|error| raise(py, error))?;
        Ok(FrictionCandidate(Candidate { law, pressing, offset, gain }))
    }

    #[getter]
    fn law(&self) -> &'static str {
        self.0.law.info.name
    }

    #[getter]
    fn load(&self) -> &'static str {
        self.0.pressing.name()
    }

    #[getter]
    fn offset(&self) -> bool {
        self.0.offset
    }

    #[getter]
    fn gain(&self) -> bool {
        self.0.gain
    }

    fn __repr__(&self) -> String {
        format!(
            "FrictionCandidate(law='{}', load='{}', offset={}, gain={})",
            self.law(),
            self.load(),
            self.offset(),
            self.gain()
        )
    }
}

/// A parameter as a fit found it.
#[pyclass(frozen, get_all, module = "locosweep._core")]
pub struct FrictionParameter {
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    value: f64,
    /// inf where the data say nothing of it, NaN where it has none.
    std: f64,
    /// Its logarithm is what the fit moves and errors are even in.
    logarithmic: bool,
    /// At an end of the range that was searched.
    bounded: bool,
}

impl From<&Found> for FrictionParameter {
    fn from(found: &Found) -> Self {
        FrictionParameter {
            name: found.what.name(),
            unit: found.what.unit(),
            meaning: found.what.meaning(),
            value: found.value,
            std: found.std,
            logarithmic: found.logarithmic,
            bounded: found.bounded,
        }
    }
}

/// A candidate as fitted.
#[pyclass(frozen, module = "locosweep._core")]
pub struct FrictionOutcome(Outcome);

#[pymethods]
impl FrictionOutcome {
    #[getter]
    fn parameters(&self) -> Vec<FrictionParameter> {
        self.0.found.iter().map(FrictionParameter::from).collect()
    }

    /// Independent pieces of data beyond the parameters.
    #[getter]
    fn freedom(&self) -> f64 {
        self.0.freedom
    }

    /// Rows that carry as much as one independent one.
    #[getter]
    fn memory(&self) -> f64 {
        self.0.memory
    }

    /// Root mean square of the residuals of the rows fitted to, N.
    #[getter]
    fn rms(&self) -> f64 {
        self.0.rms
    }

    /// Whether the search came to rest.
    #[getter]
    fn settled(&self) -> bool {
        self.0.settled
    }

    /// Force at every row, N.
    #[getter]
    fn predicted<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.predicted.clone().into_pyarray(py)
    }

    /// The same by fits that never saw the row; NaN where there is none.
    #[getter]
    fn held_out<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.held_out.clone().into_pyarray(py)
    }
}

/// Measured motion and friction force, run by run.
#[pyclass(frozen, module = "locosweep._core")]
pub struct FrictionData(Measured);

#[pymethods]
impl FrictionData {
    /// Each run is (t, x, v, drive, load, force, rows, folds): columns of one
    /// length, the samples that count, and the fold of each of these, 255 where it
    /// is only fitted to. `normal` is the normal force in N where no load gives
    /// it; up to `rest_speed` (m/s) a sample is at rest.
    #[new]
    #[allow(clippy::type_complexity)]
    fn new(
        py: Python<'_>,
        runs: Vec<(
            Array<'_>,
            Array<'_>,
            Array<'_>,
            Array<'_>,
            Array<'_>,
            Array<'_>,
            PyReadonlyArray1<'_, i64>,
            PyReadonlyArray1<'_, u8>,
        )>,
        normal: f64,
        rest_speed: f64,
    ) -> PyResult<FrictionData> {
        if !(normal > 0.0 && normal.is_finite() && rest_speed >= 0.0 && rest_speed.is_finite()) {
            let text = format!(
                "normal is {normal} and rest_speed {rest_speed}: allowed are a force above 0 and a speed from 0"
            );
            return Err(input_error(py, text));
        }
        let column = |array: &Array<'_>| array.as_array().to_vec();
        let mut read = Vec::with_capacity(runs.len());
        for (t, x, v, drive, load, force, rows, folds) in &runs {
            let columns = [t, x, v, drive, load, force].map(column);
            let [t, x, v, drive, load, force] = columns;
            if [&x, &v, &drive].iter().any(|c| c.len() != t.len()) {
                return Err(input_error(py, "columns of one run differ in length".to_owned()));
            }
            let motion = Motion::new(t, x, v, drive, rest_speed);
            let count = motion.len();
            let rows = rows.as_array();
            let rows = rows.iter().map(|row| usize::try_from(*row).unwrap_or(count)).collect();
            let folds = folds.as_array().to_vec();
            read.push(Run { motion, force, load, rows, folds });
        }
        Ok(FrictionData(Measured { runs: read, normal, slowest: rest_speed }))
    }

    /// Why a candidate cannot be fitted to these data; None if it can.
    fn lacks(&self, candidate: &FrictionCandidate) -> Option<&'static str> {
        candidate.0.lacks(&self.0.scales())
    }

    /// Fit every candidate; what is found has their order.
    #[pyo3(signature = (candidates, threads, progress=None, token=None))]
    fn fit(
        &self,
        py: Python<'_>,
        candidates: Vec<FrictionCandidate>,
        threads: usize,
        progress: Option<Py<PyAny>>,
        token: Option<&CancelToken>,
    ) -> PyResult<Vec<FrictionOutcome>> {
        let candidates: Vec<Candidate> = candidates.into_iter().map(|c| c.0).collect();
        let control = token.map_or_else(Default::default, CancelToken::control);
        let total = candidates.len() as u64;
        let work = || friction_fit::fit_all(&self.0, &candidates, threads, &control);
        let found = enter(py, &control, total, progress.as_ref(), work)?;
        Ok(found.into_iter().map(FrictionOutcome).collect())
    }
}

/// Signed friction force of a law at every sample of an imposed motion, under
/// the normal force in N given at each sample.
///
/// States of a bristle law are integrated along it; of a dry law at rest, so up
/// to `rest_speed`, it is what the law holds in the direction in which the motion
/// goes on.
#[pyfunction]
#[pyo3(signature = (law, given, t, x, v, normal, drive, rest_speed=0.0))]
#[allow(clippy::too_many_arguments)]
pub fn imposed_force<'py>(
    py: Python<'py>,
    law: &str,
    given: Vec<(String, f64)>,
    t: Array<'py>,
    x: Array<'py>,
    v: Array<'py>,
    normal: Array<'py>,
    drive: Array<'py>,
    rest_speed: f64,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let law = LawEntry::parse(law).map_err(|error| raise(py, error))?;
    let mut values = Vec::with_capacity(given.len());
    for (name, value) in &given {
        let id = ParamId::parse(name).and_then(|id| Ok((id, id.param().check(*value, None)?)));
        values.push(id.map_err(|error| raise(py, error))?);
    }
    let [t, x, v, normal, drive] = [t, x, v, normal, drive].map(|array| array.as_array().to_vec());
    let count = t.len();
    let finite = [&t, &x, &v, &normal, &drive].iter().all(|c| c.iter().all(|v| v.is_finite()));
    let same = [&x, &v, &normal, &drive].iter().all(|c| c.len() == count);
    if !same || !finite || !t.windows(2).all(|pair| pair[0] < pair[1]) {
        let text = "t, x, v, normal and drive: allowed are finite columns of one length, t rising";
        return Err(input_error(py, text.to_owned()));
    }
    let mut motion = Motion::new(t, x, v, drive, rest_speed);
    motion.normal = normal;
    let force = enter_briefly(py, || friction_fit::imposed(law, &values, &motion))?;
    Ok(force.into_pyarray(py))
}

/// Derivative of order 1 or 2 of noisy samples, the standard deviation of their
/// noise, that of the derivative, and the samples of the window that was used.
#[pyfunction]
pub fn derivative<'py>(
    py: Python<'py>,
    t: Array<'py>,
    y: Array<'py>,
    order: usize,
) -> PyResult<(Bound<'py, PyArray1<f64>>, f64, f64, usize)> {
    if !(1..=2).contains(&order) {
        return Err(input_error(py, format!("order is {order}: allowed are 1 and 2")));
    }
    let (t, y) = (t.as_array().to_vec(), y.as_array().to_vec());
    let found = enter_briefly(py, || velocity::derivative(&t, &y, order))?;
    Ok((found.values.into_pyarray(py), found.noise, found.error, found.window))
}

/// Standard deviation of white noise on samples of something smooth.
#[pyfunction]
pub fn noise(t: Array<'_>, y: Array<'_>) -> f64 {
    let (t, y) = (t.as_array().to_vec(), y.as_array().to_vec());
    let indices: Vec<usize> = (0..t.len().min(y.len())).collect();
    velocity::noise(&t, &y, &indices)
}

/// Numbers of the samples that stand alone, further from the median of their
/// neighbours than `times` the spread of such distances.
#[pyfunction]
pub fn spikes(values: Array<'_>, times: f64) -> Vec<usize> {
    spread::spikes(&values.as_array().to_vec(), times)
}

/// Of several fits, given the residuals of each on the same samples in runs of
/// `lengths`: root mean square, distance from the best in standard deviations, and
/// whether it cannot be told from the best.
#[pyfunction]
pub fn rank_fits(
    py: Python<'_>,
    residuals: Vec<Array<'_>>,
    lengths: Vec<usize>,
) -> PyResult<Vec<(f64, f64, bool)>> {
    let residuals: Vec<Vec<f64>> = residuals.iter().map(|r| r.as_array().to_vec()).collect();
    let total: usize = lengths.iter().sum();
    if residuals.iter().any(|r| r.len() != total) {
        let text = format!("residuals: allowed are as many as lengths say, {total}");
        return Err(input_error(py, text));
    }
    let found = enter_briefly(py, || Ok(rank(&residuals, &lengths)))?;
    Ok(found.into_iter().map(|s| (s.rms, s.sigmas, s.tied)).collect())
}
