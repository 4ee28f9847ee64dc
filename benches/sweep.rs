//! What the sweep engine costs, per point or cell, beside what the machine could
//! do: a plain fill of the same buffer and the rate of its multiply-adds.
//! `cargo bench -- --test` runs everything once.

mod common;

use common::*;
use criterion::{Criterion, criterion_group, criterion_main};
use locosweep::lane::{self, Level, Pack, Task};
use locosweep::sweep::{Buffer, Choice, Entry, Grid, Job, Reduce, Request};
use rayon::prelude::*;
use std::hint::black_box;

type Axes<'a> = &'a [(&'a str, Vec<f64>)];

/// A job over `axes`; `over` names the folded axis and how.
fn job(quantity: &str, axes: Axes, fixed: &[(&str, f64)], over: Option<(&str, Reduce)>) -> Job {
    let entry = Entry::parse(quantity).expect("a known quantity");
    let request = Request { entry, reduce: over.map(|(_, reduce)| reduce) };
    let grid = Grid::new(axes, fixed).expect("a valid grid");
    let over = over.map(|(axis, _)| axis);
    Job::new(grid, vec![request], over, &Choice::default()).expect("a valid job")
}

/// W1 at a tenth: 200 x 20 x 100 x 25 points, 80 MB.
fn dense_axes() -> Vec<(&'static str, Vec<f64>)> {
    vec![
        ("mu_static", linspace(0.1013, 0.997, 200)),
        ("mu_coulomb", linspace(0.0507, 0.793, 20)),
        ("slope_deg", linspace(0.0, 25.0, 100)),
        ("segments", whole(2, 26)),
    ]
}

/// 50 x 20 x 100 cells, without the segment count.
fn design_axes() -> Vec<(&'static str, Vec<f64>)> {
    vec![
        ("mu_static", linspace(0.1013, 0.997, 50)),
        ("mu_coulomb", linspace(0.0507, 0.793, 20)),
        ("slope_deg", linspace(0.0, 25.0, 100)),
    ]
}

fn dense(c: &mut Criterion) {
    let job = job("mean_velocity", &dense_axes(), &[], None);
    bench_job(c, "W1 mean_velocity", &job, &variants());
}

/// The limit of W1: its buffer, filled with one number.
fn plain_fill(c: &mut Criterion) {
    let count = dense_axes().iter().map(|(_, values)| values.len()).product();
    let mut out = vec![0.0; count];
    let mut group = group(c, "limit plain fill", count);
    for threads in if two_threads_pay() { vec![1, 2] } else { vec![1] } {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        group.bench_function(format!("{threads}"), |b| {
            b.iter(|| {
                let part = count.div_ceil(threads);
                pool.install(|| {
                    out.par_chunks_mut(part).for_each(|part| part.fill(black_box(1.25)));
                });
                black_box(&mut out);
            });
        });
    }
    group.finish();
}

/// Multiply-adds in registers.
struct MultiplyAdds {
    rounds: usize,
}

impl MultiplyAdds {
    /// Enough independent chains to hide the latency, few enough for registers.
    const CHAINS: usize = 4;
    const LANES: usize = 32;
}

impl Task for MultiplyAdds {
    type Output = f64;

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) -> f64 {
        let (a, b) = (P::broadcast(token, black_box(0.999)), P::broadcast(token, black_box(0.001)));
        let mut chains = [P::broadcast(token, black_box(1.0)); Self::CHAINS];
        // A pack is 8 to 32 lanes wide: the same work whatever the level.
        for _ in 0..self.rounds * Self::LANES / P::LANES {
            for chain in &mut chains {
                *chain = chain.mul_add(a, b);
            }
        }
        chains.iter().map(|chain| chain.lane(0)).sum()
    }
}

/// The limit of W2, which takes one multiply-add, two products, a comparison and
/// two selections per candidate. Two processors that share one core show here: no
/// arithmetic gains from the second.
fn multiply_adds(c: &mut Criterion) {
    let rounds = 10_000;
    let count = rounds * MultiplyAdds::CHAINS * MultiplyAdds::LANES;
    for (level, threads) in variants() {
        // Without AVX2 a multiply-add is a call of the C library, no limit of the processor.
        if level == Level::Baseline {
            continue;
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let mut group = group(c, "limit multiply-adds", threads * count);
        group.bench_function(id(level, threads), |b| {
            let work = |_: rayon::BroadcastContext| {
                lane::run(level, MultiplyAdds { rounds: black_box(rounds) })
            };
            b.iter(|| pool.broadcast(work));
        });
    }
}

fn search(c: &mut Criterion) {
    let mut axes = design_axes();
    axes.push(("segments", whole(2, 64)));
    let brute = job("mean_velocity", &axes, &[], Some(("segments", Reduce::Argmax)));
    bench_job(c, "W2 argmax over 63 segments", &brute, &variants());
    let bounds = [("segments_min", 2.0), ("segments_max", 64.0)];
    let closed = job("best_segments", &design_axes(), &bounds, None);
    bench_job(c, "W2 closed form", &closed, &variants());
}

/// Other quantities and folds over the segment count.
fn folds(c: &mut Criterion) {
    let mut axes = design_axes();
    axes.push(("segments", whole(2, 64)));
    for (quantity, name, reduce) in [
        ("cost_of_transport", "argmin", Reduce::Argmin),
        ("acceleration", "max", Reduce::Max),
        ("mean_power", "mean", Reduce::Mean),
    ] {
        let job = job(quantity, &axes, &[], Some(("segments", reduce)));
        bench_job(c, &format!("fold {quantity} {name}"), &job, &[(best_level(), 1)]);
    }
}

/// A general kernel: viscous friction takes a root search per point.
fn viscous(c: &mut Criterion) {
    let mut axes = design_axes();
    axes.push(("segments", whole(4, 8)));
    let job = job("phase_time", &axes, &[("viscous", 2.0)], None);
    bench_job(c, "viscous phase_time", &job, &[(best_level(), 1)]);
}

fn statuses(c: &mut Criterion) {
    let mut axes = design_axes();
    axes.push(("segments", whole(2, 6)));
    let job = job("mean_velocity", &axes, &[], None);
    let mut codes = vec![0; job.cells()];
    group(c, "statuses", job.cells()).bench_function(id(best_level(), 1), |b| {
        b.iter(|| fill(&job, Buffer::Status(black_box(&mut codes)), 1, best_level()));
    });
}

/// From names and numbers to one value.
fn one_point(c: &mut Criterion) {
    let fixed = [("mu_static", 0.5), ("mu_coulomb", 0.3), ("segments", 4.0)];
    let mut group = group(c, "one point", 1);
    group.bench_function("checked and run", |b| {
        b.iter(|| {
            let mut out = [0.0];
            let job = job("mean_velocity", &[], black_box(&fixed), None);
            fill(&job, Buffer::F64(&mut out), 1, best_level());
            out
        });
    });
    group.finish();
}

criterion_group!(limits, plain_fill, multiply_adds);
criterion_group!(work, dense, search, folds, viscous, statuses, one_point);
criterion_main!(limits, work);
