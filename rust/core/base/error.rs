//! One error type: which argument, which value, what was allowed, at which index.

use thiserror::Error as ThisError;

pub type Result<T> = std::result::Result<T, Error>;

#[derive(Debug, Clone, PartialEq, ThisError)]
pub enum Error {
    #[error("unknown {kind} '{given}'{}", hint(.nearest, .known))]
    UnknownName { kind: &'static str, given: String, nearest: Option<String>, known: Vec<String> },

    #[error("{name}{} is {value:?}{}: allowed is {allowed}", bracketed(.index), with_space(.unit))]
    OutOfRange { name: String, value: f64, index: Option<usize>, allowed: String, unit: String },

    #[error("{name} is needed for {quantity} and has no default: give a value or an axis")]
    MissingParameter { name: String, quantity: String },

    #[error("{name} is given twice: as {first} and as {second}")]
    GivenTwice { name: String, first: &'static str, second: &'static str },

    #[error("axis {name} is empty: it needs at least one value")]
    EmptyAxis { name: String },

    #[error("the grid has {} points, more than can be counted in 64 bits", join(.sizes))]
    GridTooLarge { sizes: Vec<usize> },

    #[error("{axis} is not an axis of the grid: 'over' must be one of {}", list(.axes))]
    NotAnAxis { axis: String, axes: Vec<String> },

    #[error("{name} is {given}: allowed is {allowed}")]
    BadOption { name: &'static str, given: String, allowed: String },

    #[error("out has {given} elements, the result of {quantity} has {needed}")]
    OutSize { quantity: String, given: usize, needed: usize },

    #[error("interrupted after {done} of {total} points")]
    Cancelled { done: u64, total: u64 },
}

fn hint(nearest: &Option<String>, known: &[String]) -> String {
    match nearest {
        Some(name) => format!(": did you mean '{name}'? Known are {}", known.join(", ")),
        None => format!(": known are {}", known.join(", ")),
    }
}

fn bracketed(index: &Option<usize>) -> String {
    index.map_or(String::new(), |i| format!("[{i}]"))
}

/// A pure number is printed without its unit.
fn with_space(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

fn join(sizes: &[usize]) -> String {
    sizes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" x ")
}

fn list(axes: &[String]) -> String {
    if axes.is_empty() { "none (the grid has no axes)".to_owned() } else { axes.join(", ") }
}
