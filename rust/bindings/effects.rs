//! The registry of effects as Python records.

use crate::tables::Parameter;
use locosweep::physics::effects::{
    EFFECT_PARAMS, Effect, EffectParam, LevelForm, Need, Off, Shape, Variable,
};
use pyo3::prelude::*;

/// An effect that a nominal model of a measured run may lack.
#[pyclass(frozen, get_all, module = "locosweep._core", name = "Effect")]
pub struct EffectRecord {
    name: &'static str,
    /// friction, drive, body, environment or sensor.
    site: &'static str,
    /// TeX.
    formula: &'static str,
    meaning: &'static str,
    parameters: Vec<Py<Parameter>>,
    /// Names of those that stand beside the nominal Coulomb level.
    levels: Vec<&'static str>,
    /// Place of the first parameter among those of all effects.
    first: usize,
    /// How fits treat each parameter.
    fits: Vec<Py<EffectFit>>,
    /// Variable that another law of the effect would follow; None where it is the
    /// error of a number, which has no other law.
    variable: Option<&'static str>,
    /// A second variable of another law, which no other effect follows.
    further: Option<&'static str>,
    /// Whether its law in `variable` rises all along, or falls, by whatever formula.
    monotone: bool,
    /// Whether its law in `variable` never jumps, by whatever formula.
    continuous: bool,
    /// Whether its law in `variable` stays near its mean, by whatever formula.
    steady: bool,
    /// What a rig must have for it: body, rear_sensor, slope.
    needs: Vec<&'static str>,
    /// Motion of the head without which it cannot show: at_rest (none), moving,
    /// forward or both_ways.
    shown: &'static str,
    /// Effects with fewer parameters that it contains as a limit.
    contains: Vec<&'static str>,
    /// Effects that stand in its place: a model has one of them.
    excludes: Vec<&'static str>,
    /// Value of [uncertainty] that it is an error of.
    error_of: Option<&'static str>,
    /// Beside it friction at rest may lie below the nominal Coulomb level.
    lowers_level: bool,
    /// Work of a replay with it, in replays of the nominal model.
    work: f64,
    /// Formula that starts must fulfil.
    keep: Option<&'static str>,
    /// Formulas of the smallest and the largest signed magnitude.
    magnitude: (&'static str, &'static str),
    /// Magnitude below which an integrator resolves no more than the nominal model.
    least: f64,
    shapes: Vec<Py<EffectShape>>,
    /// Whether the blind check's reality has it.
    drawn: bool,
    /// As a rival in the blind check it has strengths of one sign only.
    one_sided: bool,
    /// Numbers of a rival of which every value is tried: names and formulas.
    over: Vec<(&'static str, &'static str)>,
    /// Numbers of a rival whose values are fitted together.
    spanned: Vec<(&'static str, &'static str)>,
    /// The number of `over` that is looked at between its values, too.
    refined: Option<&'static str>,
}

#[pymethods]
impl EffectRecord {
    fn __repr__(&self) -> String {
        format!("Effect(name='{}', site='{}', meaning='{}')", self.name, self.site, self.meaning)
    }
}

/// How fits treat a parameter of an effect. Numbers that follow from a rig are
/// formulas in its sizes.
#[pyclass(frozen, get_all, module = "locosweep._core")]
pub struct EffectFit {
    name: &'static str,
    /// Value without the effect; None where none does it, or where it is the Coulomb level.
    off: Option<f64>,
    /// Without the effect it is the nominal Coulomb level.
    beside_level: bool,
    /// Key of the nominal Coulomb level with which it is used (mu_coulomb or
    /// coulomb_force); None with either.
    only_with: Option<&'static str>,
    /// Fits step its logarithm.
    log: bool,
    /// A large change of it (of its logarithm if `log`).
    unit: &'static str,
    /// First values, in `unit` unless `log`.
    starts: &'static str,
    /// What a start is in full, from its `value` and the other parameters.
    composed: Option<&'static str>,
    /// Smallest and largest value of fits.
    range: (&'static str, &'static str),
    /// The same where runs are replayed in windows.
    windows: (&'static str, &'static str),
    /// Its value at a magnitude `u` and the shapes.
    at: &'static str,
    /// Its value as a rival at a strength `s`.
    rival: &'static str,
    /// Data determine it well enough for its value to be judged.
    judged: bool,
}

#[pymethods]
impl EffectFit {
    fn __repr__(&self) -> String {
        format!("EffectFit(name='{}', unit='{}', starts='{}')", self.name, self.unit, self.starts)
    }
}

/// A number that the parameters of an effect follow from beside its magnitude.
#[pyclass(frozen, get_all, module = "locosweep._core")]
pub struct EffectShape {
    name: &'static str,
    /// Formulas of first values and of the range.
    starts: &'static str,
    range: (&'static str, &'static str),
    /// Fits step its logarithm.
    log: bool,
    /// Of a finite difference.
    step: f64,
}

#[pymethods]
impl EffectShape {
    fn __repr__(&self) -> String {
        format!("EffectShape(name='{}', starts='{}')", self.name, self.starts)
    }
}

fn fit(row: &EffectParam) -> EffectFit {
    EffectFit {
        name: row.param.name,
        off: match row.off {
            Off::At(value) if value.is_finite() => Some(value),
            _ => None,
        },
        beside_level: row.off == Off::Coulomb,
        only_with: row.only.map(|form| match form {
            LevelForm::Coefficient => "mu_coulomb",
            LevelForm::Force => "coulomb_force",
        }),
        log: row.log,
        unit: row.unit,
        starts: row.starts,
        composed: row.composed,
        range: (row.low, row.high),
        windows: row.windows.unwrap_or((row.low, row.high)),
        at: row.at,
        rival: row.rival,
        judged: row.judged,
    }
}

fn shape(row: &Shape) -> EffectShape {
    EffectShape {
        name: row.name,
        starts: row.starts,
        range: (row.low, row.high),
        log: row.log,
        step: row.step,
    }
}

/// All effects, in the order of the registry.
#[pyfunction]
pub fn effects(py: Python<'_>) -> PyResult<Vec<EffectRecord>> {
    let record = |effect: &Effect| {
        let info = effect.info();
        let levels = info.params.iter().filter(|p| p.off == Off::Coulomb);
        let parameters = info.params.iter().map(|p| Py::new(py, Parameter::from(&p.param)));
        let fits = info.params.iter().map(|p| Py::new(py, fit(p)));
        let shapes = info.magnitude.shapes.iter().map(|s| Py::new(py, shape(s)));
        Ok(EffectRecord {
            name: info.name,
            site: info.site.name(),
            formula: info.formula,
            meaning: info.meaning,
            parameters: parameters.collect::<PyResult<_>>()?,
            levels: levels.map(|p| p.param.name).collect(),
            first: effect.first(),
            fits: fits.collect::<PyResult<_>>()?,
            variable: info.variable.map(Variable::name),
            further: info.further.map(Variable::name),
            monotone: info.monotone,
            continuous: info.continuous,
            steady: info.steady,
            needs: info.needs.iter().copied().map(Need::name).collect(),
            shown: info.shown.name(),
            contains: info.contains.to_vec(),
            excludes: info.excludes.to_vec(),
            error_of: info.error_of,
            lowers_level: info.lowers_level,
            work: info.work,
            keep: info.keep,
            magnitude: (info.magnitude.low, info.magnitude.high),
            least: info.magnitude.least,
            shapes: shapes.collect::<PyResult<_>>()?,
            drawn: info.drawn,
            one_sided: info.one_sided,
            over: info.over.to_vec(),
            spanned: info.spanned.to_vec(),
            refined: info.refined,
        })
    };
    Effect::ALL.iter().map(record).collect()
}

/// Number of the parameters of all effects.
#[pyfunction]
pub fn effect_parameter_count() -> usize {
    EFFECT_PARAMS
}
