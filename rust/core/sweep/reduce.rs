//! REDUCTION REGISTRY: what one axis can be folded into.

use crate::describe::nearest;
use crate::error::{Error, Result};

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reduce {
    Max,
    Min,
    Argmax,
    Argmin,
    Mean,
    Quantile(f64),
    Count,
    LastFeasible,
}

impl Reduce {
    /// Names and meanings, in the order users see them.
    pub const ALL: &'static [(&'static str, &'static str)] = &[
        ("max", "largest value along the axis"),
        ("min", "smallest value along the axis"),
        (
            "argmax",
            "axis value of the largest value; a relative difference below 1e-12 is a tie, the earlier one wins",
        ),
        (
            "argmin",
            "axis value of the smallest value; a relative difference below 1e-12 is a tie, the earlier one wins",
        ),
        ("mean", "mean of the values that exist"),
        ("quantile", "quantile q of the values that exist, linear between neighbours"),
        ("count", "number of points along the axis that have a value"),
        (
            "last_feasible",
            "last axis value that has a value (the largest one that still works, on a rising axis)",
        ),
    ];

    pub fn parse(name: &str, q: Option<f64>) -> Result<Reduce> {
        if name != "quantile" && q.is_some() {
            return Err(Error::BadOption {
                name: "q",
                given: format!("given with reduce '{name}'"),
                allowed: "only with reduce 'quantile'".to_owned(),
            });
        }
        match name {
            "max" => Ok(Reduce::Max),
            "min" => Ok(Reduce::Min),
            "argmax" => Ok(Reduce::Argmax),
            "argmin" => Ok(Reduce::Argmin),
            "mean" => Ok(Reduce::Mean),
            "count" => Ok(Reduce::Count),
            "last_feasible" => Ok(Reduce::LastFeasible),
            "quantile" => match q {
                Some(q) if (0.0..=1.0).contains(&q) => Ok(Reduce::Quantile(q)),
                other => Err(Error::BadOption {
                    name: "q",
                    given: other.map_or("missing".to_owned(), |q| q.to_string()),
                    allowed: "a number from 0 to 1".to_owned(),
                }),
            },
            _ => Err(Error::UnknownName {
                kind: "reduction",
                given: name.to_owned(),
                nearest: nearest(name, Self::ALL.iter().map(|r| r.0)).map(str::to_owned),
                known: Self::ALL.iter().map(|r| r.0.to_owned()).collect(),
            }),
        }
    }

    /// Whether the result is a value of the axis, not of the quantity.
    pub fn gives_axis_value(self) -> bool {
        matches!(self, Reduce::Argmax | Reduce::Argmin | Reduce::LastFeasible)
    }
}

/// Quantile of sorted numbers, linear between neighbours (as NumPy's default).
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    if sorted.is_empty() {
        return f64::NAN;
    }
    let position = (sorted.len() - 1) as f64 * q;
    let below = libm::floor(position);
    let (a, share) = (sorted[below as usize], position - below);
    let b = sorted[(below as usize + 1).min(sorted.len() - 1)];
    // The two forms meet both ends exactly.
    if share < 0.5 { a + (b - a) * share } else { b - (b - a) * (1.0 - share) }
}
