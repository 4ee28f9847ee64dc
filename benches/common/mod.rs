//! What every bench needs: levels and threads to try, groups of criterion, grids.

// Each bench takes what it needs.
#![allow(dead_code)]

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput};
use locosweep::lane::Level;
use locosweep::sweep::{Buffer, Control, DEFAULT_CHUNK, Job, Options, run};
use std::hint::black_box;
use std::time::Duration;

/// Evenly spaced numbers, both ends included.
pub fn linspace(from: f64, to: f64, count: usize) -> Vec<f64> {
    let step = (to - from) / (count - 1) as f64;
    (0..count).map(|i| from + step * i as f64).collect()
}

pub fn whole(from: u32, to: u32) -> Vec<f64> {
    (from..=to).map(f64::from).collect()
}

pub fn fill(job: &Job, buffer: Buffer, threads: usize, level: Level) {
    let options = Options { threads, chunk: DEFAULT_CHUNK, level, fresh: false };
    run(job, vec![(0, buffer)], options, &Control::default()).expect("the sweep runs");
}

pub fn best_level() -> Level {
    Level::current().expect("a valid LOCOSWEEP_SIMD")
}

pub fn two_threads_pay() -> bool {
    std::thread::available_parallelism().is_ok_and(|n| n.get() > 1)
}

/// Every level on one thread, then the best one on two.
pub fn variants() -> Vec<(Level, usize)> {
    let mut all: Vec<_> = Level::available().into_iter().map(|level| (level, 1)).collect();
    if two_threads_pay() {
        all.push((best_level(), 2));
    }
    all
}

pub fn group<'a>(c: &'a mut Criterion, name: &str, count: usize) -> BenchmarkGroup<'a, WallTime> {
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(count as u64));
    group.sample_size(20);
    group.warm_up_time(Duration::from_millis(500));
    group.measurement_time(Duration::from_secs(2));
    group
}

pub fn id(level: Level, threads: usize) -> BenchmarkId {
    let noun = if threads == 1 { "thread" } else { "threads" };
    BenchmarkId::new(level.name(), format!("{threads} {noun}"))
}

/// Benches one job into a reused buffer, per level and number of threads.
pub fn bench_job(c: &mut Criterion, name: &str, job: &Job, variants: &[(Level, usize)]) {
    let mut out = vec![0.0; job.cells()];
    let mut group = group(c, name, job.cells());
    for &(level, threads) in variants {
        group.bench_function(id(level, threads), |b| {
            b.iter(|| fill(job, Buffer::F64(black_box(&mut out)), threads, level));
        });
    }
    group.finish();
}
