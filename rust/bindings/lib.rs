//! Python's view of the core: convert, enter the door, convert back.

mod arrays;
mod door;
mod sweep;
mod tables;

use pyo3::prelude::pymodule;

#[pymodule]
mod _core {
    #[pymodule_export]
    use super::sweep::{CancelToken, Sweep};
    #[pymodule_export]
    use super::tables::{
        Parameter, Quantity, file_choices, file_keys, parameters, quantities, reductions,
        simd_level, simd_levels, statuses, threads_to_use, version,
    };
}
