//! The words every registry is made of: what a parameter, a quantity or a
//! status is called, measured in and where it comes from. Python, the command
//! line and the documentation read these records and hold none of their own.

use crate::error::{Error, Result};

/// Largest finite size of a parameter.
const LARGEST: f64 = 1e30;
/// Smallest size that is not zero.
const SMALLEST: f64 = 1e-30;

/// A named number that a formula takes, with everything a user may ask about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Param {
    pub name: &'static str,
    /// The symbol used in formulas and on plots, in TeX.
    pub symbol: &'static str,
    /// SI unit, or `deg` where the name ends in `_deg`; `1` for a pure number.
    pub unit: &'static str,
    /// `None`: the user must give it where a quantity needs it.
    pub default: Option<f64>,
    /// Allowed values, both ends included.
    pub range: (f64, f64),
    pub integer: bool,
    /// Table and key in a robot file, if the parameter has one there.
    pub file_key: Option<(&'static str, &'static str)>,
    pub meaning: &'static str,
}

impl Param {
    /// Whether `value` is inside the range and whole where it must be. It may be
    /// zero or infinite where the range says so, but not so small or so large
    /// that products and quotients leave what a double can hold.
    pub fn allows(&self, value: f64) -> bool {
        let (low, high) = self.range;
        let in_range = value >= low && value <= high;
        let size = value.abs();
        let usable = size == 0.0 || size == f64::INFINITY || (SMALLEST..=LARGEST).contains(&size);
        in_range && usable && (!self.integer || value.fract() == 0.0)
    }

    /// What is allowed, in the words of an error message.
    pub fn allowed(&self) -> String {
        let (low, high) = self.range;
        let kind = if self.integer { "a whole number" } else { "a number" };
        let mut allowed = if high.is_infinite() {
            format!("{kind} from {low} to {LARGEST:e}, or inf")
        } else {
            format!("{kind} from {low} to {high}")
        };
        if !self.integer && low <= 0.0 {
            allowed.push_str(&format!(" (0 or at least {SMALLEST:e} in size)"));
        }
        allowed
    }

    /// Checks one value; `index` is its position on an axis.
    pub fn check(&self, value: f64, index: Option<usize>) -> Result<f64> {
        if self.allows(value) {
            // `-0.0` would print as an odd axis label and split symmetric cases.
            return Ok(value + 0.0);
        }
        Err(Error::OutOfRange {
            name: self.name.to_owned(),
            value,
            index,
            allowed: self.allowed(),
            unit: self.unit.to_owned(),
        })
    }
}

/// What a quantity is, for people and for the registry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Info {
    pub name: &'static str,
    /// The symbol used on plots, in TeX.
    pub symbol: &'static str,
    pub unit: &'static str,
    /// TeX, in the symbols of the parameters.
    pub formula: &'static str,
    /// Paper and equation, or how it was derived.
    pub source: &'static str,
    /// Where it holds and what it leaves out.
    pub limits: &'static str,
    pub meaning: &'static str,
    /// Names of the parameters that enter.
    pub params: &'static [&'static str],
    /// A whole number (drawn with discrete colours).
    pub integer: bool,
    /// More is better: of times, losses and costs less is.
    pub larger_is_better: bool,
}

/// The known name closest to `given`, if one is close enough to be meant.
pub fn nearest<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|name| (strsim::jaro_winkler(given, name), name))
        .filter(|(score, _)| *score > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
