//! A run stops soon after it is asked to, and counts what it has done.

use super::*;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// How long a run goes on after its flag is raised; `None` if it was done before.
fn stops(work: impl FnOnce(&Control) -> Result<(), Error> + Send) -> Option<Duration> {
    let control = Control::default();
    std::thread::scope(|scope| {
        let sweep = scope.spawn(|| work(&control));
        std::thread::sleep(Duration::from_millis(60));
        let asked = Instant::now();
        control.cancel.store(true, Ordering::Relaxed);
        match sweep.join().unwrap() {
            Ok(()) => None,
            Err(Error::Cancelled { done, total }) => {
                assert!(done <= total);
                Some(asked.elapsed())
            }
            Err(error) => panic!("{error}"),
        }
    })
}

/// Long runs of each method: many steps per trajectory, many trajectories.
fn long() -> Vec<Case> {
    // Long, but not so long that a run is given up at once.
    let long = [("duration", 5.0), ("time_step", 1e-6), ("tolerance", 1e-9)];
    let short = [("drive_period", 1e-5), ("duration", 5.0)];
    let sine = |law: &str| Case::usual(law, DriveKind::Sine).with(&long);
    vec![
        Case::usual("static_viscous", DriveKind::Pulse).with(&short),
        sine("stribeck"),
        sine("stribeck").by("dormand_prince_fixed"),
        sine("tanh").by("runge_kutta"),
        // Few enough steps for the drive to be worked out ahead.
        sine("tanh").by("runge_kutta").with(&[("duration", 0.9)]),
        sine("tanh"),
        sine("lugre"),
        sine("gonthier").by("rosenbrock_fixed"),
    ]
}

#[test]
fn running_sweeps_stop_soon() {
    for case in long() {
        let case = case.over("mu_coulomb", steps(0.05, 0.3, 4000));
        let job = case.job(&["final_position"]);
        for threads in [1, 2] {
            let waited = stops(|control| {
                let mut out = vec![0.0; job.cells()];
                run(&job, vec![(0, Buffer::F64(&mut out))], options(threads, 64), control)
            });
            let waited = waited.unwrap_or_else(|| panic!("{} was too short", case.name()));
            assert!(waited.as_millis() < 250, "{}: {waited:?}", case.name());
        }
        let waited = stops(|control| trace(&job, &[0.5, 1.0], options(2, 64), control).map(|_| ()));
        let waited = waited.unwrap_or_else(|| panic!("{} was too short", case.name()));
        assert!(waited.as_millis() < 250, "trace of {}: {waited:?}", case.name());
    }
}

#[test]
fn running_robots_stop_soon() {
    let mut late = String::new();
    for (stiffness, cycles) in [(2e3, 300.0), (f64::INFINITY, 1e3)] {
        let case = Case::usual("coulomb", DriveKind::Constant)
            .with(&[("stroke", 0.02), ("drive_limit", 3.0), ("segments", 6.0)])
            .dry()
            .with(&[("joint_stiffness", stiffness), ("cycles", cycles)])
            .over("mu_static", steps(0.3, 0.6, 1000));
        let job = case.job(&["gait_advance"]);
        let waited = stops(|control| {
            let mut out = vec![0.0; job.cells()];
            run(&job, vec![(0, Buffer::F64(&mut out))], options(1, 64), control)
        });
        let waited = waited.expect("a long run");
        if waited.as_millis() >= 250 {
            late += &format!("\nstiffness {stiffness}: {waited:?}");
        }
    }
    assert!(late.is_empty(), "{late}");
}

#[test]
fn progress_counts_every_trajectory() {
    let case = Case::usual("tanh", DriveKind::Sine).over("mu_coulomb", steps(0.05, 0.3, 700));
    let job = case.all();
    let control = Control::default();
    let mut out = vec![0.0; job.cells()];
    run(&job, vec![(0, Buffer::F64(&mut out))], options(3, 100), &control).unwrap();
    assert_eq!(control.done.load(Ordering::Relaxed), job.evaluations());
    let control = Control::default();
    trace(&job, &[0.0, 1.0], options(3, 100), &control).unwrap();
    assert_eq!(control.done.load(Ordering::Relaxed), job.cells() as u64);
}

/// A flag that is up before the start.
#[test]
fn a_cancelled_run_does_nothing() {
    let job = Case::usual("lugre", DriveKind::Sine).all();
    let control = Control::default();
    control.cancel.store(true, Ordering::Relaxed);
    let mut out = vec![0.0; job.cells()];
    let error = run(&job, vec![(0, Buffer::F64(&mut out))], options(2, 64), &control);
    assert_eq!(error, Err(Error::Cancelled { done: 0, total: job.evaluations() }));
    assert!(trace(&job, &[1.0], options(1, 64), &control).is_err());
}

/// What is kept beside the results does not grow with the length of a run.
#[test]
fn long_runs_take_no_more_memory() {
    let bytes = |duration: f64| {
        let case = Case::usual("lugre", DriveKind::Sine).with(&[("duration", duration)]);
        case.over("mu_coulomb", steps(0.05, 0.3, 100)).all().working_bytes(2)
    };
    assert_eq!(bytes(0.1), bytes(1e6));
}
