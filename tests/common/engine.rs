//! Running jobs and comparing what they give, bit for bit.

// Each test takes what it needs.
#![allow(dead_code)]

use locosweep::lane::Level;
use locosweep::sweep::{Buffer, Control, Job, Options, run};

pub fn options(threads: usize, chunk: usize) -> Options {
    Options { threads, chunk, level: Level::current().unwrap(), fresh: false }
}

/// Values and status codes, request by request.
pub type Results = (Vec<Vec<f64>>, Vec<Vec<u8>>);

pub fn results(job: &Job, options: Options) -> Results {
    let mut values = vec![vec![f64::MAX; job.cells()]; job.requests.len()];
    let mut codes = vec![vec![u8::MAX; job.cells()]; job.requests.len()];
    let mut buffers: Vec<_> = values.iter_mut().map(|v| Buffer::F64(v)).enumerate().collect();
    buffers.extend(codes.iter_mut().map(|c| Buffer::Status(c)).enumerate());
    run(job, buffers, options, &Control::default()).unwrap();
    (values, codes)
}

pub fn bits(values: &[f64]) -> Vec<u64> {
    // Every NaN means the same here.
    values.iter().map(|v| if v.is_nan() { f64::NAN.to_bits() } else { v.to_bits() }).collect()
}

#[track_caller]
pub fn same(a: &[f64], b: &[f64], what: &str) {
    assert_eq!(a.len(), b.len());
    if let Some(i) = (0..a.len()).find(|i| bits(&a[*i..=*i]) != bits(&b[*i..=*i])) {
        panic!("{what}: cell {i} is {:e} and {:e}", a[i], b[i]);
    }
}

pub fn steps(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
}

pub fn whole(low: u32, high: u32) -> Vec<f64> {
    (low..=high).map(f64::from).collect()
}
