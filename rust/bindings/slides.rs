//! Motions that small forces change, as Python has them.

use crate::door::{enter, input_error};
use locosweep::integrate::linear_response::{Slides, linear_response as respond};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// A motion at its samples, of runs one after another: see `Slides` of the core.
#[derive(FromPyObject)]
pub struct GivenSlides<'py> {
    v: PyReadonlyArray1<'py, f64>,
    step: PyReadonlyArray1<'py, f64>,
    last: PyReadonlyArray1<'py, bool>,
    mass: f64,
    damping: f64,
    keeps: PyReadonlyArray1<'py, f64>,
    stiffness: PyReadonlyArray1<'py, f64>,
}

impl GivenSlides<'_> {
    /// The motion, which has to have so many samples.
    pub fn slides(&self, py: Python<'_>, count: usize) -> PyResult<Slides<'_>> {
        let whole = |_| input_error(py, "a motion must be contiguous".to_owned());
        let motion = Slides {
            v: self.v.as_slice().map_err(whole)?,
            step: self.step.as_slice().map_err(whole)?,
            last: self.last.as_slice().map_err(whole)?,
            mass: self.mass,
            damping: self.damping,
            keeps: self.keeps.as_slice().map_err(whole)?,
            stiffness: self.stiffness.as_slice().map_err(whole)?,
        };
        let Slides { v, step, last, keeps, stiffness, .. } = motion;
        let lengths = [v.len(), step.len(), last.len(), keeps.len(), stiffness.len()];
        if lengths != [count; 5] || !(count == 0 || last.last() == Some(&true)) {
            let message = format!(
                "v, step, last, keeps and stiffness must have {count} samples, and the last sample must end a run"
            );
            return Err(input_error(py, message));
        }
        Ok(motion)
    }
}

/// First-order change of position and speed of a motion under small forces, a row a force.
///
/// The motion is given by speed, seconds to the next sample and whether it is the last of its
/// run, sample by sample, by the head's mass in kg and viscous coefficient in N s/m, by the share
/// of a change of speed that is left at the next sample, 1 but where the head turns round, and by
/// the stiffness with which gravity pulls the head back, in N/m.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn linear_response<'py>(
    py: Python<'py>,
    forces: PyReadonlyArray2<'py, f64>,
    motion: GivenSlides<'py>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
    let whole = |_| input_error(py, "forces must be contiguous".to_owned());
    let (rows, count) = forces.as_array().dim();
    let forces = forces.as_slice().map_err(whole)?;
    let motion = motion.slides(py, count)?;
    let (dx, dv) = (
        PyArray2::<f64>::zeros(py, [rows, count], false),
        PyArray2::<f64>::zeros(py, [rows, count], false),
    );
    let (mut to_x, mut to_v) = (dx.readwrite(), dv.readwrite());
    let (to_x, to_v) = (to_x.as_slice_mut().map_err(whole)?, to_v.as_slice_mut().map_err(whole)?);
    let work = || {
        let decays = motion.decays();
        let parts = to_x.chunks_mut(count.max(1)).zip(to_v.chunks_mut(count.max(1)));
        for (force, (x, v)) in forces.chunks(count.max(1)).zip(parts) {
            respond(motion, &decays, force, x, v);
        }
        Ok(())
    };
    enter(py, &Default::default(), rows as u64, None, work)?;
    Ok((dx, dv))
}
