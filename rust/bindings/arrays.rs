//! NumPy arrays as slices: outputs are written in place, nothing is copied.

use crate::door::input_error;
use locosweep::sweep::Buffer;
use numpy::{PyReadwriteArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// A borrowed output array.
pub enum Output<'py> {
    F64(PyReadwriteArrayDyn<'py, f64>),
    F32(PyReadwriteArrayDyn<'py, f32>),
    Status(PyReadwriteArrayDyn<'py, u8>),
}

impl<'py> Output<'py> {
    pub fn borrow(array: &Bound<'py, PyAny>) -> PyResult<Output<'py>> {
        if let Ok(array) = array.extract() {
            return Ok(Output::F64(array));
        }
        if let Ok(array) = array.extract() {
            return Ok(Output::F32(array));
        }
        if let Ok(array) = array.extract() {
            return Ok(Output::Status(array));
        }
        let what = match array.cast::<PyUntypedArray>() {
            Ok(array) => format!("an array of {}", array.dtype()),
            Err(_) => format!("a {}", array.get_type()),
        };
        let message = format!(
            "out is {what}: allowed is a writeable array of float64, float32 or uint8 \
             that no other call is using"
        );
        Err(input_error(array.py(), message))
    }

    pub fn buffer(&mut self, py: Python<'py>) -> PyResult<Buffer<'_>> {
        let contiguous = |_| {
            input_error(
                py,
                "out is not C-contiguous: allowed is one unbroken block in C order".to_owned(),
            )
        };
        Ok(match self {
            Output::F64(array) => Buffer::F64(array.as_slice_mut().map_err(contiguous)?),
            Output::F32(array) => Buffer::F32(array.as_slice_mut().map_err(contiguous)?),
            Output::Status(array) => Buffer::Status(array.as_slice_mut().map_err(contiguous)?),
        })
    }
}
