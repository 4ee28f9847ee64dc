//! Named values of one contact.

use super::{ParamId, Parameters};
use crate::error::Result;
use crate::point::{COLUMNS, columns};

/// Parameters of one contact: those given, defaults for the rest, NaN for what
/// has neither.
#[derive(Debug, Clone)]
pub struct Values([f64; COLUMNS]);

/// Weight, groove and wall: what the normal force is made of, for every law.
pub const NORMAL: &[ParamId] =
    &[ParamId::Mass, ParamId::Gravity, ParamId::SlopeDeg, ParamId::CornerDeg, ParamId::WallForce];

impl Values {
    pub fn of(parameters: &[(ParamId, f64)]) -> Values {
        let mut all = [f64::NAN; COLUMNS];
        for id in ParamId::all() {
            let value = parameters.iter().rev().find(|(g, _)| *g == id).map(|(_, v)| *v);
            if let Some(value) = value.or(id.param().default) {
                [all[id.main()], all[id.derived()]] = columns(id, value);
            }
        }
        Values(all)
    }

    /// The same from names, each value checked against its range.
    pub fn named(parameters: &[(&str, f64)]) -> Result<Values> {
        let mut pairs = Vec::with_capacity(parameters.len());
        for (name, value) in parameters {
            let id = ParamId::parse(name)?;
            pairs.push((id, id.param().check(*value, None)?));
        }
        Ok(Values::of(&pairs))
    }
}

impl Parameters<f64> for Values {
    fn get(&self, id: ParamId) -> f64 {
        self.0[id.main()]
    }
    fn derived(&self, id: ParamId) -> f64 {
        self.0[id.derived()]
    }
}
