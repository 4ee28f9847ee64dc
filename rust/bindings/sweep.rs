//! Sweeps as a Python class: checked when made, run as often as wanted.

use crate::arrays::Output;
use crate::door::{SMALL, enter, enter_briefly, raise};
use locosweep::lane::Level;
use locosweep::sweep::{
    Choice, Control, DEFAULT_CHUNK, Entry, FRESH_CHUNK, Grid, Job, Options, Reduce, Request,
    Traces, run, trace,
};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Fields of a trace, and the status codes of its cells.
type Traced<'py> = ([Bound<'py, PyArray1<f64>>; 4], Bound<'py, PyArray1<u8>>);

/// Stops a running sweep from another thread.
#[pyclass(frozen, module = "locosweep._core")]
#[derive(Default)]
pub struct CancelToken {
    control: Arc<Control>,
}

impl CancelToken {
    pub fn control(&self) -> Arc<Control> {
        self.control.clone()
    }
}

#[pymethods]
impl CancelToken {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Ask the sweep that holds this token to stop.
    fn cancel(&self) {
        self.control.cancel.store(true, Ordering::Relaxed);
    }

    /// Evaluations finished so far.
    #[getter]
    fn done(&self) -> u64 {
        self.control.done.load(Ordering::Relaxed)
    }
}

/// A checked grid and what to compute on it.
#[pyclass(frozen, module = "locosweep._core")]
pub struct Sweep {
    job: Job,
}

#[pymethods]
impl Sweep {
    /// `requests` are (quantity, reduction or None, q or None). Law, drive, method
    /// and table (times and values) count where a quantity is simulated; `motion`
    /// says that it is looked at itself, which prefers a method with dense output.
    /// `sample` is a last axis along which several parameters take their values together.
    #[new]
    #[pyo3(signature = (axes, fixed, requests, over=None, *, law=None, drive=None, gait=None, method=None, locate=true, table=None, motion=false, sample=Vec::new()))]
    #[allow(clippy::too_many_arguments, clippy::type_complexity)]
    fn new(
        py: Python<'_>,
        axes: Vec<(String, PyReadonlyArray1<'_, f64>)>,
        fixed: Vec<(String, f64)>,
        requests: Vec<(String, Option<String>, Option<f64>)>,
        over: Option<&str>,
        law: Option<String>,
        drive: Option<String>,
        gait: Option<String>,
        method: Option<String>,
        locate: bool,
        table: Option<(PyReadonlyArray1<'_, f64>, PyReadonlyArray1<'_, f64>)>,
        motion: bool,
        sample: Vec<(String, PyReadonlyArray1<'_, f64>)>,
    ) -> PyResult<Sweep> {
        let mut choice = Choice { method, locate, motion, ..Choice::default() };
        choice.law = law.unwrap_or(choice.law);
        choice.drive = drive.unwrap_or(choice.drive);
        choice.gait = gait.unwrap_or(choice.gait);
        if let Some((times, values)) = table {
            choice.times = times.as_array().to_vec();
            choice.values = values.as_array().to_vec();
        }
        let owned = |named: Vec<(String, PyReadonlyArray1<'_, f64>)>| -> Vec<(String, Vec<f64>)> {
            named.into_iter().map(|(name, values)| (name, values.as_array().to_vec())).collect()
        };
        let (axes, sample) = (owned(axes), owned(sample));
        let build = || {
            let grid = Grid::with_sample(&axes, &sample, &fixed)?;
            let requests = requests.iter().map(|(quantity, reduce, q)| {
                let entry = Entry::parse(quantity)?;
                let reduce = reduce.as_ref().map(|name| Reduce::parse(name, *q)).transpose()?;
                Ok(Request { entry, reduce })
            });
            Job::new(grid, requests.collect::<Result<_, _>>()?, over, &choice)
        };
        Ok(Sweep { job: build().map_err(|error| raise(py, error))? })
    }

    /// Shape of each result.
    #[getter]
    fn shape(&self) -> Vec<usize> {
        self.job.shape()
    }

    /// Names of the axes of the result, in order.
    #[getter]
    fn axes(&self) -> Vec<&'static str> {
        self.job.kept().iter().map(|axis| axis.id.param().name).collect()
    }

    /// Name and value of every parameter that is not an axis.
    #[getter]
    fn fixed(&self) -> Vec<(&'static str, f64)> {
        let grid = &self.job.grid;
        let all = locosweep::physics::ParamId::all();
        all.filter(|id| grid.along(*id).is_none())
            .filter_map(|id| Some((id.param().name, grid.fixed[id as usize]?)))
            .collect()
    }

    /// Cells of each result.
    #[getter]
    fn cells(&self) -> usize {
        self.job.cells()
    }

    /// How often a formula is evaluated.
    #[getter]
    fn evaluations(&self) -> u64 {
        self.job.evaluations()
    }

    /// Whether trajectories are simulated.
    #[getter]
    fn simulates(&self) -> bool {
        self.job.simulates()
    }

    /// Gait in use, where whole robots are simulated.
    #[getter]
    fn gait(&self) -> Option<&'static str> {
        self.job.gait()
    }

    /// Law, drive and method in use, where trajectories are simulated.
    #[getter]
    fn choice(&self) -> Option<(&'static str, &'static str, &'static str)> {
        self.job.choice()
    }

    /// Position, speed, drive force and direction of sliding (0 at rest) of every
    /// cell at `stations` (shares of the duration): shape (cells, stations) each; and
    /// the status codes of the cells.
    #[pyo3(signature = (stations, threads, progress=None, token=None))]
    fn trace<'py>(
        &self,
        py: Python<'py>,
        stations: PyReadonlyArray1<'_, f64>,
        threads: usize,
        progress: Option<Py<PyAny>>,
        token: Option<&CancelToken>,
    ) -> PyResult<Traced<'py>> {
        let stations = stations.as_array().to_vec();
        let level = Level::current().map_err(|error| raise(py, error))?;
        let options = Options { threads, chunk: DEFAULT_CHUNK, level, fresh: true };
        let control = token.map_or_else(Default::default, CancelToken::control);
        let total = self.job.cells() as u64;
        let work = || trace(&self.job, &stations, options, &control);
        let Traces { x, v, force, direction, statuses } =
            enter(py, &control, total, progress.as_ref(), work)?;
        let fields = [x, v, force, direction].map(|field| field.into_pyarray(py));
        Ok((fields, statuses.into_pyarray(py)))
    }

    /// Bytes needed beside the results.
    fn working_bytes(&self, threads: usize) -> usize {
        self.job.working_bytes(threads)
    }

    /// Fill arrays: each output is (number of the request, array). An array of
    /// uint8 receives status codes. `fresh`: the arrays were never written to.
    #[pyo3(signature = (outputs, threads, chunk=None, progress=None, token=None, level=None, fresh=false))]
    #[allow(clippy::too_many_arguments)]
    fn run<'py>(
        &self,
        py: Python<'py>,
        outputs: Vec<(usize, Bound<'py, PyAny>)>,
        threads: usize,
        chunk: Option<usize>,
        progress: Option<Py<PyAny>>,
        token: Option<&CancelToken>,
        level: Option<&str>,
        fresh: bool,
    ) -> PyResult<()> {
        let level = level.map_or_else(Level::current, Level::parse);
        let is_large = self.job.cells() >= 32 * FRESH_CHUNK;
        let default_chunk = if fresh && is_large { FRESH_CHUNK } else { DEFAULT_CHUNK };
        let options = Options {
            threads,
            chunk: chunk.unwrap_or(default_chunk).max(1),
            level: level.map_err(|error| raise(py, error))?,
            fresh,
        };
        let mut borrowed = Vec::with_capacity(outputs.len());
        for (request, array) in &outputs {
            borrowed.push((*request, Output::borrow(array)?));
        }
        let mut buffers = Vec::with_capacity(outputs.len());
        for (request, output) in &mut borrowed {
            buffers.push((*request, output.buffer(py)?));
        }
        let control = token.map_or_else(Default::default, CancelToken::control);
        let total = self.job.evaluations();
        let work = || run(&self.job, buffers, options, &control);
        if total <= SMALL && progress.is_none() && !self.job.simulates() {
            return enter_briefly(py, work);
        }
        enter(py, &control, total, progress.as_ref(), work)
    }
}
