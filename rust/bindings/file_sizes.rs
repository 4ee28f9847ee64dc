//! Sizes of the files of folders. A run of a hundred thousand chunks compares two hundred
//! thousand of them when it is opened, which takes Python several times as long.

use crate::door::enter;
use locosweep::sweep::Control;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use std::collections::HashMap;
use std::ffi::OsString;
use std::io::ErrorKind::NotFound;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

type Sizes = HashMap<OsString, u64>;
/// Size found by index of a name; none where there is no such file.
type Other = HashMap<usize, Option<u64>>;

/// Files of folders that have not the sizes that they should have.
///
/// `names` are those of the files of each folder, `sizes` for each folder what they should be;
/// links are not followed. Returns for each folder, by index of a name, the size that was found,
/// None where there is no such file.
///
/// OSError, with its number and its folder, where one cannot be read.
#[pyfunction]
pub fn other_sizes(
    py: Python<'_>,
    folders: Vec<PathBuf>,
    names: Vec<OsString>,
    sizes: Vec<Vec<u64>>,
) -> PyResult<Vec<Other>> {
    let control = Control::default();
    // A thread each: on a disk of the network they wait rather than work.
    let found = enter(py, &control, 0, None, || {
        Ok(std::thread::scope(|scope| {
            let (cancel, names) = (&control.cancel, &names);
            let running: Vec<_> = folders
                .iter()
                .zip(&sizes)
                .map(|(folder, sizes)| {
                    scope.spawn(move || {
                        listed(folder, cancel).map(|at| differing(&at, names, sizes))
                    })
                })
                .collect();
            running.into_iter().map(|one| one.join().unwrap_or_else(|p| resume_unwind(p))).collect()
        }))
    })?;
    let found: Vec<std::io::Result<Other>> = found;
    found
        .into_iter()
        .zip(folders)
        .map(|(other, folder)| other.map_err(|e| raised(&e, folder)))
        .collect()
}

fn differing(found: &Sizes, names: &[OsString], sizes: &[u64]) -> Other {
    let there = names.iter().map(|name| found.get(name).copied());
    let pairs = there.zip(sizes).enumerate();
    pairs.filter(|(_, (at, size))| *at != Some(**size)).map(|(i, (at, _))| (i, at)).collect()
}

fn raised(error: &std::io::Error, folder: PathBuf) -> PyErr {
    let text = error.to_string();
    let words = text.split(" (os error").next().unwrap_or_default().to_owned();
    PyOSError::new_err((error.raw_os_error(), words, folder.into_os_string()))
}

fn listed(folder: &Path, cancel: &AtomicBool) -> std::io::Result<Sizes> {
    let mut found = Sizes::new();
    let entries = match std::fs::read_dir(folder) {
        Err(error) if error.kind() == NotFound => return Ok(found),
        entries => entries?,
    };
    for entry in entries {
        if cancel.load(Ordering::Relaxed) {
            break;
        }
        let entry = entry?;
        // On Linux relative to the folder's handle: no search for the folder.
        match entry.metadata() {
            // A file that another process renamed meanwhile.
            Err(error) if error.kind() == NotFound => {}
            about => {
                found.insert(entry.file_name(), about?.len());
            }
        }
    }
    Ok(found)
}
