//! The blind check's reality as a Python function: it shares the door with the
//! engine, and nothing else.

use crate::door::{enter, input_error};
use crate::sweep::CancelToken;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use reality::{Effect, FORMS, Job, Readings, Rig, SOURCE, Samples, run_all};
use std::collections::{BTreeMap, HashMap};

type RunParameters<'py> = (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>, f64);
type GivenEffect = (String, String, BTreeMap<String, f64>);
type GivenJob = (usize, HashMap<String, f64>, Vec<GivenEffect>, (f64, f64), f64, u64);

/// All laws of the blind check: cause, form, parameters. The form `law` is the
/// one that the cause's name stands for, `outside` is nobody's cause.
#[pyfunction]
pub fn reality_forms() -> Vec<(&'static str, &'static str, Vec<&'static str>)> {
    FORMS.iter().map(|f| (f.name, f.form, f.params.to_vec())).collect()
}

/// The text of all that makes the reality: cases drawn with other text are other cases.
#[pyfunction]
pub fn reality_source() -> &'static str {
    SOURCE
}

fn rig(py: Python<'_>, given: &HashMap<String, f64>) -> PyResult<Rig> {
    let need = |name: &str| {
        given.get(name).copied().ok_or_else(|| input_error(py, format!("the rig has no {name}")))
    };
    let coulomb_force = given.get("coulomb_force").copied();
    Ok(Rig {
        segments: need("segments")?,
        mass: need("mass")?,
        gravity: need("gravity")?,
        mu_coulomb: if coulomb_force.is_some() { 0.0 } else { need("mu_coulomb")? },
        coulomb_force,
        viscous: need("viscous")?,
        slope_deg: need("slope_deg")?,
        gain: need("gain")?,
        limit: need("limit")?,
        gravity_torque: given.get("gravity_torque").copied(),
        clock: given.get("clock").copied().unwrap_or(0.0),
    })
}

/// Run drives through realities: what the sensors would read, without noise.
///
/// `runs` are (times in s from 0, drive, slope in degrees); each job is (run,
/// rig, effects as (name, form, parameters), start position and speed, longest
/// step in s, seed of what is random in it). Returns x, v, x_rear and force for
/// each job.
#[pyfunction]
#[pyo3(signature = (runs, jobs, threads, token=None))]
#[allow(clippy::type_complexity)]
pub fn reality_run<'py>(
    py: Python<'py>,
    runs: Vec<RunParameters<'py>>,
    jobs: Vec<GivenJob>,
    threads: usize,
    token: Option<&CancelToken>,
) -> PyResult<Vec<[Bound<'py, PyArray1<f64>>; 4]>> {
    let mut samples = Vec::with_capacity(runs.len());
    for (i, (times, drive, slope_deg)) in runs.into_iter().enumerate() {
        let times = times.as_array().to_vec();
        let drive = drive.as_array().to_vec();
        let rises = times.first() == Some(&0.0) && times.windows(2).all(|pair| pair[0] < pair[1]);
        let finite = times.iter().chain(&drive).all(|value| value.is_finite());
        if times.len() != drive.len() || !rises || !finite {
            let message = format!(
                "run {i}: allowed are as many finite drive values as times that rise from 0"
            );
            return Err(input_error(py, message));
        }
        samples.push(Samples { times, drive, slope_deg });
    }
    let mut made = Vec::with_capacity(jobs.len());
    for (i, (run, given, effects, start, step, seed)) in jobs.into_iter().enumerate() {
        let in_place =
            run < samples.len() && step > 0.0 && start.0.is_finite() && start.1.is_finite();
        if !in_place {
            let message = format!(
                "job {i}: allowed is a run below {}, a finite start and a step above 0",
                samples.len()
            );
            return Err(input_error(py, message));
        }
        let effects = effects.iter().map(|(name, form, values)| Effect::new(name, form, values));
        let effects =
            effects.collect::<Result<Vec<_>, _>>().map_err(|text| input_error(py, text))?;
        made.push(Job { run, rig: rig(py, &given)?, effects, start, step, seed });
    }
    let control = token.map_or_else(Default::default, CancelToken::control);
    let count = made.len() as u64;
    let work = || {
        let found = run_all(&samples, &made, threads, &control.cancel, &control.done);
        Ok(found.into_iter().collect::<Option<Vec<Readings>>>().unwrap_or_default())
    };
    let found = enter(py, &control, count, None, work)?;
    let arrays = |r: Readings| [r.x, r.v, r.x_rear, r.force].map(|field| field.into_pyarray(py));
    Ok(found.into_iter().map(arrays).collect())
}
