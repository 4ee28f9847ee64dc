//! The single entry to Rust for calls that can last: releases the GIL, keeps
//! Ctrl-C and progress alive, turns errors and panics into exceptions.

use locosweep::Error;
use locosweep::sweep::Control;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, Once, PoisonError};
use std::time::{Duration, Instant};

/// How often the calling thread looks for signals.
const TICK: Duration = Duration::from_millis(50);
/// How often it reports progress.
const REPORT: Duration = Duration::from_millis(100);

/// Evaluations that end within a tick whatever they compute: these run on the
/// calling thread, where starting another would cost more than they do.
pub const SMALL: u64 = 4096;

type Outcome<T> = std::thread::Result<Result<T, Error>>;

/// Runs `work` without the GIL on the calling thread.
pub fn enter_briefly<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Error> + Send,
) -> PyResult<T> {
    keep_panics_quiet();
    let outcome = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    finish(py, outcome)
}

/// Runs `work` without the GIL on a thread of its own while this one watches.
pub fn enter<T: Send>(
    py: Python<'_>,
    control: &Control,
    total: u64,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce() -> Result<T, Error> + Send,
) -> PyResult<T> {
    keep_panics_quiet();
    let begin = Instant::now();
    // A token counts what all its calls have done.
    let before = control.done.load(Ordering::Relaxed);
    let mut interruption: Option<PyErr> = None;
    let report = |py: Python<'_>, done: u64| -> PyResult<()> {
        let Some(callback) = progress else { return Ok(()) };
        let rate = done as f64 / begin.elapsed().as_secs_f64().max(1e-9);
        callback.call1(py, (done, total, rate)).map(drop)
    };
    let outcome: Outcome<T> = py.detach(|| {
        std::thread::scope(|scope| {
            let (sender, receiver) = channel();
            scope.spawn(move || {
                // The receiver waits for this message, so it cannot be gone.
                let _ = sender.send(catch_unwind(AssertUnwindSafe(work)));
            });
            let mut reported = begin;
            loop {
                match receiver.recv_timeout(TICK) {
                    Ok(outcome) => return outcome,
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(Box::new("the worker thread ended without a result"));
                    }
                    Err(RecvTimeoutError::Timeout) if interruption.is_none() => {
                        let look = Python::attach(|py| {
                            py.check_signals()?;
                            if reported.elapsed() >= REPORT {
                                reported = Instant::now();
                                report(
                                    py,
                                    control.done.load(Ordering::Relaxed).saturating_sub(before),
                                )?;
                            }
                            Ok(())
                        });
                        if let Err(error) = look {
                            control.cancel.store(true, Ordering::Relaxed);
                            interruption = Some(error);
                        }
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                }
            }
        })
    });
    if let Some(error) = interruption {
        return Err(error);
    }
    let value = finish(py, outcome)?;
    report(py, total)?;
    Ok(value)
}

fn finish<T>(py: Python<'_>, outcome: Outcome<T>) -> PyResult<T> {
    match outcome {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(error)) => Err(raise(py, error)),
        Err(panic) => Err(internal(py, panic)),
    }
}

/// The Python exception for an error of the core.
pub fn raise(py: Python<'_>, error: Error) -> PyErr {
    let message = error.to_string();
    match error {
        Error::UnknownName { kind, given, known, .. } => unknown(py, kind, &given, known),
        Error::Cancelled { .. } => exception(py, "Cancelled", message),
        _ => exception(py, "InputError", message),
    }
}

/// The words for a name that is not known stand in Python, which has lists of its own.
fn unknown(py: Python<'_>, kind: &str, given: &str, known: Vec<String>) -> PyErr {
    let registry = py.import("locosweep.registry");
    match registry.and_then(|registry| registry.call_method1("unknown", (kind, given, known))) {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

pub fn input_error(py: Python<'_>, message: String) -> PyErr {
    exception(py, "InputError", message)
}

/// Where the last panic of this library happened.
static PLACE: Mutex<String> = Mutex::new(String::new());

/// Keeps the report of a panic for the exception that it becomes, instead of
/// printing it.
fn keep_panics_quiet() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        std::panic::set_hook(Box::new(|info| {
            let place = info.location().map_or_else(String::new, |l| format!(" ({l})"));
            *PLACE.lock().unwrap_or_else(PoisonError::into_inner) = place;
        }));
    });
}

fn internal(py: Python<'_>, panic: Box<dyn Any + Send>) -> PyErr {
    let what = panic
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("unknown");
    let place = PLACE.lock().unwrap_or_else(PoisonError::into_inner).clone();
    exception(py, "InternalError", format!("internal error, please report it: {what}{place}"))
}

/// The classes live in Python, where they can have two bases.
fn exception(py: Python<'_>, class: &'static str, message: String) -> PyErr {
    static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    let class = MODULE
        .get_or_try_init(py, || py.import("locosweep.errors").map(Bound::unbind))
        .and_then(|module| Ok(module.bind(py).getattr(class)?.cast_into::<PyType>()?));
    match class {
        Ok(class) => PyErr::from_type(class, message),
        Err(error) => error,
    }
}
