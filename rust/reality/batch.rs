//! Many runs on several threads.

use crate::effects::Effect;
use crate::rig::Rig;
use crate::run::{Readings, Samples, simulate};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

/// One run through one reality.
#[derive(Debug, Clone)]
pub struct Job {
    /// Which of the samples.
    pub run: usize,
    pub rig: Rig,
    pub effects: Vec<Effect>,
    pub start: (f64, f64),
    pub step: f64,
    pub seed: u64,
}

/// Runs all jobs, in their order whatever the threads; `None` where `cancel` came
/// before one's turn.
pub fn run_all(
    runs: &[Samples],
    jobs: &[Job],
    threads: usize,
    cancel: &AtomicBool,
    done: &AtomicU64,
) -> Vec<Option<Readings>> {
    let next = AtomicUsize::new(0);
    let found: Vec<Mutex<Option<Readings>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let work = || {
        while !cancel.load(Ordering::Relaxed) {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = jobs.get(i) else { return };
            let samples = &runs[job.run];
            let readings = simulate(&job.rig, &job.effects, samples, job.start, job.step, job.seed);
            if let Ok(mut slot) = found[i].lock() {
                *slot = Some(readings);
            }
            done.fetch_add(1, Ordering::Relaxed);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.clamp(1, jobs.len().max(1)) {
            scope.spawn(work);
        }
        work();
    });
    found.into_iter().map(|slot| slot.into_inner().unwrap_or(None)).collect()
}
