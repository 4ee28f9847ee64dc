//! The registries as Python records. Python holds no list of its own.

use crate::door::raise;
use locosweep::describe::Param;
use locosweep::integrate::Method;
use locosweep::lane::Level;
use locosweep::physics::drive::DriveKind;
use locosweep::physics::friction::{ContactState, LAWS, LawEntry, Values};
use locosweep::physics::params::{FILE_CHOICES, FILE_KEYS};
use locosweep::physics::{PARAMS, ParamId, Status};
use locosweep::sweep::{Entry, QUANTITIES, Reduce};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

/// A parameter: what it is called, measured in, and which values it may take.
#[pyclass(frozen, module = "locosweep._core")]
pub struct Parameter(Param);

#[pymethods]
impl Parameter {
    #[getter]
    fn name(&self) -> &'static str {
        self.0.name
    }

    #[getter]
    fn symbol(&self) -> &'static str {
        self.0.symbol
    }

    #[getter]
    fn unit(&self) -> &'static str {
        self.0.unit
    }

    /// None where the user must give it.
    #[getter]
    fn default(&self) -> Option<f64> {
        self.0.default
    }

    /// Smallest and largest value allowed.
    #[getter]
    fn range(&self) -> (f64, f64) {
        self.0.range
    }

    #[getter]
    fn integer(&self) -> bool {
        self.0.integer
    }

    /// Table and key in a robot file, where it has one.
    #[getter]
    fn file_key(&self) -> Option<(&'static str, &'static str)> {
        self.0.file_key
    }

    #[getter]
    fn meaning(&self) -> &'static str {
        self.0.meaning
    }

    /// What is allowed, in words.
    #[getter]
    fn allowed(&self) -> String {
        self.0.allowed()
    }

    fn __repr__(&self) -> String {
        let Param { name, unit, default, range: (low, high), .. } = self.0;
        let default = default.map_or("none".to_owned(), |v| v.to_string());
        format!("Parameter(name='{name}', unit='{unit}', default={default}, range=[{low}, {high}])")
    }

    /// Raise InputError where the value is not allowed.
    fn check(&self, py: Python<'_>, value: f64) -> PyResult<f64> {
        self.0.check(value, None).map_err(|error| raise(py, error))
    }
}

impl From<&Param> for Parameter {
    fn from(param: &Param) -> Self {
        Parameter(*param)
    }
}

/// A quantity that a sweep can compute.
#[pyclass(frozen, get_all, module = "locosweep._core")]
pub struct Quantity {
    name: &'static str,
    symbol: &'static str,
    unit: &'static str,
    /// TeX, in the symbols of the parameters.
    formula: &'static str,
    source: &'static str,
    limits: &'static str,
    meaning: &'static str,
    integer: bool,
    larger_is_better: bool,
    parameters: Vec<Py<Parameter>>,
    /// Found by simulating a trajectory; law and drive then add parameters.
    simulated: bool,
}

#[pymethods]
impl Quantity {
    fn __repr__(&self) -> String {
        format!("Quantity(name='{}', unit='{}', meaning='{}')", self.name, self.unit, self.meaning)
    }
}

fn quantity(py: Python<'_>, entry: &Entry) -> PyResult<Quantity> {
    let info = &entry.info;
    let used = ParamId::all().filter(|id| entry.uses(*id));
    let parameters = used.map(|id| Py::new(py, Parameter::from(id.param())));
    Ok(Quantity {
        name: info.name,
        symbol: info.symbol,
        unit: info.unit,
        formula: info.formula,
        source: info.source,
        limits: info.limits,
        meaning: info.meaning,
        integer: info.integer,
        larger_is_better: info.larger_is_better,
        parameters: parameters.collect::<PyResult<_>>()?,
        simulated: entry.closed().is_none(),
    })
}

/// A friction law.
#[pyclass(frozen, get_all, module = "locosweep._core")]
pub struct Law {
    name: &'static str,
    /// dry, smooth or bristle.
    kind: &'static str,
    /// TeX, in the symbols of the parameters.
    formula: &'static str,
    source: &'static str,
    limits: &'static str,
    meaning: &'static str,
    parameters: Vec<Py<Parameter>>,
    /// Motion between events is known in closed form.
    exact: bool,
}

#[pymethods]
impl Law {
    fn __repr__(&self) -> String {
        format!("Law(name='{}', kind='{}', meaning='{}')", self.name, self.kind, self.meaning)
    }
}

/// A drive: the force that the actuator is told to give, over time.
#[pyclass(frozen, get_all, module = "locosweep._core")]
pub struct Drive {
    name: &'static str,
    formula: &'static str,
    meaning: &'static str,
    parameters: Vec<Py<Parameter>>,
}

#[pymethods]
impl Drive {
    fn __repr__(&self) -> String {
        format!("Drive(name='{}', meaning='{}')", self.name, self.meaning)
    }
}

fn named(py: Python<'_>, names: &[&str]) -> PyResult<Vec<Py<Parameter>>> {
    let known = ParamId::all().map(ParamId::param).filter(|param| names.contains(&param.name));
    known.map(|param| Py::new(py, Parameter::from(param))).collect()
}

/// All friction laws.
#[pyfunction]
pub fn laws(py: Python<'_>) -> PyResult<Vec<Law>> {
    let law = |entry: &LawEntry| {
        let info = &entry.info;
        Ok(Law {
            name: info.name,
            kind: entry.kind.name(),
            formula: info.formula,
            source: info.source,
            limits: info.limits,
            meaning: info.meaning,
            parameters: named(py, info.params)?,
            exact: entry.linear,
        })
    };
    LAWS.iter().map(law).collect()
}

/// Signed friction force of steady sliding at each speed; 0 at rest for smooth
/// laws, else what friction holds against a forward push.
#[pyfunction]
pub fn characteristic<'py>(
    py: Python<'py>,
    law: &str,
    given: Vec<(String, f64)>,
    speeds: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let force = || {
        let law = LawEntry::parse(law)?;
        let given: Vec<(&str, f64)> = given.iter().map(|(n, v)| (n.as_str(), *v)).collect();
        let values = Values::named(&given)?;
        law.check(&values)?;
        let at = |v: &f64| match *v {
            0.0 => (law.break_away)(&values, &ContactState::start(1.0)),
            v => (law.steady)(&values, v),
        };
        Ok(speeds.as_array().iter().map(at).collect::<Vec<_>>())
    };
    force().map(|force| force.into_pyarray(py)).map_err(|error| raise(py, error))
}

/// All drives.
#[pyfunction]
pub fn drives(py: Python<'_>) -> PyResult<Vec<Drive>> {
    let drive = |kind: &DriveKind| {
        let info = kind.info();
        Ok(Drive {
            name: info.name,
            formula: info.formula,
            meaning: info.meaning,
            parameters: named(py, info.params)?,
        })
    };
    DriveKind::ALL.iter().map(drive).collect()
}

/// Name and meaning of every method of simulation.
#[pyfunction]
pub fn methods() -> Vec<(&'static str, &'static str)> {
    Method::ALL.iter().map(|(_, name, meaning)| (*name, *meaning)).collect()
}

/// All parameters of the closed forms.
#[pyfunction]
pub fn parameters() -> Vec<Parameter> {
    PARAMS.iter().map(Parameter::from).collect()
}

/// All quantities, in the order of their equations.
#[pyfunction]
pub fn quantities(py: Python<'_>) -> PyResult<Vec<Quantity>> {
    QUANTITIES.iter().map(|entry| quantity(py, entry)).collect()
}

/// Code, name and sentence of every status.
#[pyfunction]
pub fn statuses() -> Vec<(u8, &'static str, &'static str)> {
    Status::ALL.iter().map(|s| (*s as u8, s.name(), s.sentence())).collect()
}

/// Name and meaning of every reduction.
#[pyfunction]
pub fn reductions() -> Vec<(&'static str, &'static str)> {
    Reduce::ALL.to_vec()
}

/// Keys of a robot file that are not parameters of the closed forms.
#[pyfunction]
pub fn file_keys() -> Vec<Parameter> {
    FILE_KEYS.iter().map(Parameter::from).collect()
}

/// Table, key and allowed words of the keys of a robot file that take a word.
#[pyfunction]
pub fn file_choices() -> Vec<(&'static str, &'static str, Vec<&'static str>)> {
    FILE_CHOICES.iter().map(|(table, key, words)| (*table, *key, words.to_vec())).collect()
}

/// SIMD level in use.
#[pyfunction]
pub fn simd_level(py: Python<'_>) -> PyResult<&'static str> {
    Level::current().map(Level::name).map_err(|error| raise(py, error))
}

/// SIMD levels that this machine runs, lowest first.
#[pyfunction]
pub fn simd_levels() -> Vec<&'static str> {
    Level::available().into_iter().map(Level::name).collect()
}

/// Threads that a call would use.
#[pyfunction]
#[pyo3(signature = (asked=None))]
pub fn threads_to_use(py: Python<'_>, asked: Option<usize>) -> PyResult<usize> {
    locosweep::sweep::threads_to_use(asked).map_err(|error| raise(py, error))
}

/// The known name that was probably meant, if one is close to what was given.
#[pyfunction]
pub fn nearest(given: &str, known: Vec<String>) -> Option<String> {
    locosweep::describe::nearest(given, known.iter().map(String::as_str)).map(str::to_owned)
}

/// Version of the package.
#[pyfunction]
pub fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}
