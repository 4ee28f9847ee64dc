//! The engine: same bits however the work is cut, reductions against a slow
//! reference, refusals.

use locosweep::Error;
use locosweep::lane::Level;
use locosweep::physics::closed_form::*;
use locosweep::physics::{ParamId, Point, Quantity, Status};
use locosweep::sweep::{
    Buffer, Control, DEFAULT_CHUNK, Entry, Grid, Job, Options, QUANTITIES, Reduce, Request, run,
};
use std::sync::atomic::Ordering;
use std::time::Instant;

type Axes = Vec<(&'static str, Vec<f64>)>;
type Fixed = Vec<(&'static str, f64)>;

fn options(threads: usize, chunk: usize) -> Options {
    Options { threads, chunk, level: Level::current().unwrap(), fresh: false }
}

fn all() -> Vec<Request> {
    QUANTITIES.iter().map(|entry| Request { entry, reduce: None }).collect()
}

fn job(axes: &[(&str, Vec<f64>)], fixed: &[(&str, f64)], requests: Vec<Request>) -> Job {
    Job::new(Grid::new(axes, fixed).unwrap(), requests, None).unwrap()
}

fn reduced(axes: &[(&str, Vec<f64>)], fixed: &[(&str, f64)], over: &str, name: &str) -> Vec<Job> {
    let entry = Entry::parse(name).unwrap();
    let grid = || Grid::new(axes, fixed).unwrap();
    REDUCTIONS
        .iter()
        .map(|reduce| {
            let request = Request { entry, reduce: Some(*reduce) };
            Job::new(grid(), vec![request], Some(over)).unwrap()
        })
        .collect()
}

const REDUCTIONS: [Reduce; 10] = [
    Reduce::Max,
    Reduce::Min,
    Reduce::Argmax,
    Reduce::Argmin,
    Reduce::Mean,
    Reduce::Count,
    Reduce::LastFeasible,
    Reduce::Quantile(0.0),
    Reduce::Quantile(0.3),
    Reduce::Quantile(1.0),
];

/// Values and status codes of every request.
fn results(job: &Job, options: Options) -> (Vec<Vec<f64>>, Vec<Vec<u8>>) {
    let mut values = vec![vec![f64::MAX; job.cells()]; job.requests.len()];
    let mut codes = vec![vec![u8::MAX; job.cells()]; job.requests.len()];
    let mut buffers: Vec<_> = values.iter_mut().map(|v| Buffer::F64(v)).enumerate().collect();
    buffers.extend(codes.iter_mut().map(|c| Buffer::Status(c)).enumerate());
    run(job, buffers, options, &Control::default()).unwrap();
    (values, codes)
}

/// Values alone: the way that may write past the caches.
fn values(job: &Job, options: Options) -> Vec<f64> {
    let mut values = vec![f64::MAX; job.cells()];
    run(job, vec![(0, Buffer::F64(&mut values))], options, &Control::default()).unwrap();
    values
}

fn bits(values: &[f64]) -> Vec<u64> {
    // Every NaN means the same here.
    values.iter().map(|v| if v.is_nan() { f64::NAN.to_bits() } else { v.to_bits() }).collect()
}

#[track_caller]
fn same(a: &[f64], b: &[f64], what: &str) {
    assert_eq!(a.len(), b.len());
    if let Some(i) = (0..a.len()).find(|i| bits(&a[*i..=*i]) != bits(&b[*i..=*i])) {
        panic!("{what}: cell {i} is {:e} and {:e}", a[i], b[i]);
    }
}

fn steps(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
}

fn whole(low: u32, high: u32) -> Vec<f64> {
    (low..=high).map(f64::from).collect()
}

const OTHERS: [(&str, f64); 3] = [("time", 0.4), ("speed", -0.2), ("segments_max", 500.0)];

/// A grid that keeps the promise of plain points.
fn plain() -> (Axes, Fixed) {
    let axes = vec![
        ("mu_static", steps(0.05, 1.4, 7)),
        ("mu_coulomb", steps(0.02, 0.9, 5)),
        ("slope_deg", steps(0.0, 40.0, 23)),
        ("segments", whole(2, 20)),
    ];
    (axes, OTHERS.to_vec())
}

/// The same coefficients and counts with everything that plain points leave out.
fn general() -> (Axes, Fixed) {
    let axes = vec![
        ("viscous", vec![0.0, 0.3, 40.0]),
        ("drive_limit", vec![0.6, 3.0, f64::INFINITY]),
        ("brake", vec![0.0, 1.0]),
        ("speed_limit", vec![0.02, f64::INFINITY]),
        ("slope_deg", vec![-12.0, 0.0, 7.5, 21.0]),
        ("mu_static", vec![0.2, 0.55, 1.3]),
        ("segments", vec![1.0, 2.0, 3.0, 5.0, 11.0]),
    ];
    let mut fixed = OTHERS.to_vec();
    fixed.extend([("mu_coulomb", 0.17), ("wall_force", 0.7), ("anchors_ahead", 1.0)]);
    (axes, fixed)
}

#[test]
fn same_bits_for_every_cut() {
    for (axes, fixed) in [plain(), general()] {
        let job = job(&axes, &fixed, all());
        let (expected, codes) = results(&job, options(1, DEFAULT_CHUNK));
        for threads in [1, 2, 3, 8] {
            for chunk in [1, 7, 64, 4096, 65536] {
                // The finest cuts pay for a whole pack per cell.
                if chunk < 64 && threads != 2 && threads != 8 {
                    continue;
                }
                let (got, got_codes) = results(&job, options(threads, chunk));
                for (i, entry) in QUANTITIES.iter().enumerate() {
                    let what = format!("{} with {threads} threads, chunk {chunk}", entry.info.name);
                    same(&got[i], &expected[i], &what);
                    assert_eq!(got_codes[i], codes[i], "{what}");
                }
            }
        }
    }
}

#[test]
fn reductions_give_the_same_bits_for_every_cut() {
    let (mut axes, fixed) = plain();
    axes[2].1.truncate(11);
    for over in ["segments", "mu_coulomb"] {
        for job in reduced(&axes, &fixed, over, "mean_velocity") {
            let (expected, codes) = results(&job, options(1, DEFAULT_CHUNK));
            for (threads, chunk) in [(1, 1), (2, 7), (3, 64), (8, 4096), (2, 65536)] {
                let (got, got_codes) = results(&job, options(threads, chunk));
                same(&got[0], &expected[0], &format!("over {over}, {threads} threads, {chunk}"));
                assert_eq!(got_codes, codes);
            }
        }
    }
}

/// Runs the axes in the order given by `order` and puts the cells back.
fn reordered(axes: &Axes, order: &[usize], values: impl Fn(&Axes) -> Vec<f64>) -> Vec<f64> {
    let permuted: Axes = order.iter().map(|i| axes[*i].clone()).collect();
    let got = values(&permuted);
    let mut back = vec![f64::MAX; got.len()];
    for (cell, value) in got.iter().enumerate() {
        let mut rest = cell;
        let mut index = vec![0; axes.len()];
        for axis in order.iter().rev() {
            index[*axis] = rest % axes[*axis].1.len();
            rest /= axes[*axis].1.len();
        }
        let place = index.iter().zip(axes).fold(0, |n, (i, (_, v))| n * v.len() + i);
        back[place] = *value;
    }
    back
}

const ORDERS: [[usize; 4]; 5] =
    [[0, 1, 2, 3], [3, 2, 1, 0], [1, 3, 0, 2], [2, 0, 3, 1], [3, 0, 1, 2]];

#[test]
fn same_bits_for_every_order_of_axes() {
    let (mut axes, fixed) = plain();
    axes[1] = ("stroke", vec![0.01, 0.02, 0.3]);
    let fixed = [fixed, vec![("mu_coulomb", 0.25)]].concat();
    let all_of = |axes: &Axes| results(&job(axes, &fixed, all()), options(2, 1000)).0;
    let expected = all_of(&axes);
    for order in ORDERS {
        let permuted: Axes = order.iter().map(|i| axes[*i].clone()).collect();
        let got = all_of(&permuted);
        for (n, entry) in QUANTITIES.iter().enumerate() {
            let back = reordered(&axes, &order, |_| got[n].clone());
            same(&back, &expected[n], &format!("{} in order {order:?}", entry.info.name));
        }
    }
}

/// Ties at the optimum (mu_C = 0.2 mu_S ties 2 and 3 segments) bring out
/// kernels that disagree in the last bit.
#[test]
fn reductions_give_the_same_bits_for_every_order_of_axes() {
    let axes: Axes = vec![
        ("mu_static", steps(0.1, 1.3, 25)),
        ("stroke", steps(0.01, 0.4, 9)),
        ("slope_deg", vec![0.0, 3.0]),
        ("mu_coulomb", steps(0.02, 0.26, 25)),
    ];
    let segments = ("segments", whole(2, 12));
    for quantity in ["mean_velocity", "peak_power", "cycle_time"] {
        for reduce in REDUCTIONS {
            let entry = Entry::parse(quantity).unwrap();
            let values = |axes: &Axes| {
                let axes: Axes = axes.iter().cloned().chain([segments.clone()]).collect();
                let request = Request { entry, reduce: Some(reduce) };
                let grid = Grid::new(&axes, &[] as &[(&str, f64)]).unwrap();
                let job = Job::new(grid, vec![request], Some("segments")).unwrap();
                values(&job, options(2, 1000))
            };
            let expected = values(&axes);
            for order in ORDERS {
                let got = reordered(&axes, &order, values);
                same(&got, &expected, &format!("{quantity} {reduce:?} in order {order:?}"));
            }
        }
    }
}

#[test]
fn a_batch_is_its_points() {
    for (axes, fixed) in [plain(), general()] {
        let batch = job(&axes, &fixed, all());
        let (expected, codes) = results(&batch, options(2, 4096));
        for cell in (0..batch.cells()).step_by(37) {
            let mut rest = cell;
            let mut point = fixed.clone();
            for (name, values) in axes.iter().rev() {
                point.push((name, values[rest % values.len()]));
                rest /= values.len();
            }
            let (got, got_codes) = results(&job(&[], &point, all()), options(1, 1));
            for (n, entry) in QUANTITIES.iter().enumerate() {
                let what = format!("{} at {point:?}", entry.info.name);
                same(&got[n], &expected[n][cell..=cell], &what);
                assert_eq!(got_codes[n][0], codes[n][cell], "{what}");
            }
        }
    }
}

/// Large results are written past the caches, in whole lines from wherever the
/// buffer begins.
#[test]
fn large_and_shifted_results_have_the_same_bits() {
    let axes = vec![
        ("mu_static", steps(0.1, 1.4, 61)),
        ("slope_deg", steps(0.0, 40.0, 401)),
        ("segments", whole(2, 56)),
    ];
    let fixed = [("mu_coulomb", 0.2)];
    for name in ["mean_velocity", "optimal_segments"] {
        let request = || vec![Request { entry: Entry::parse(name).unwrap(), reduce: None }];
        let large = job(&axes, &fixed, request());
        assert!(large.cells() * 8 > 10 << 20);
        let expected = values(&large, options(2, DEFAULT_CHUNK));
        let (with_status, _) = results(&large, options(2, DEFAULT_CHUNK));
        same(&with_status[0], &expected, name);
        let fresh = Options { fresh: true, ..options(2, DEFAULT_CHUNK) };
        same(&values(&large, fresh), &expected, name);
        let mut room = vec![f64::MAX; large.cells() + 16];
        for (shift, chunk) in [(1, DEFAULT_CHUNK), (3, 1000), (5, 4097), (8, 31)] {
            room.fill(f64::MAX);
            let out = &mut room[shift..shift + large.cells()];
            let buffers = vec![(0, Buffer::F64(out))];
            run(&large, buffers, options(2, chunk), &Control::default()).unwrap();
            same(&room[shift..shift + large.cells()], &expected, name);
            let outside = room[..shift].iter().chain(&room[shift + large.cells()..]);
            assert!(outside.copied().all(|v| v == f64::MAX), "written outside of the buffer");
        }
        // Small pieces of it, which stay in the caches.
        for i in [0, 17, 60] {
            let mut piece = axes.clone();
            piece[0].1 = vec![axes[0].1[i]];
            let got = values(&job(&piece, &fixed, request()), options(1, 4096));
            same(&got, &expected[i * 401 * 55..(i + 1) * 401 * 55], name);
        }
    }
}

#[test]
fn single_precision_is_the_rounded_result() {
    let (axes, fixed) = plain();
    let request = vec![Request { entry: Entry::parse("mean_velocity").unwrap(), reduce: None }];
    let job = job(&axes, &fixed, request);
    let expected = values(&job, options(1, 4096));
    let mut got = vec![f32::MAX; job.cells()];
    run(&job, vec![(0, Buffer::F32(&mut got))], options(2, 100), &Control::default()).unwrap();
    for (got, expected) in got.iter().zip(expected) {
        assert!(got.to_bits() == (expected as f32).to_bits() || got.is_nan() && expected.is_nan());
    }
}

// SIMD levels.

struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Grids of random axes: about 45 000 points each, half of them plain.
fn random_grids(count: usize) -> Vec<(Axes, Fixed)> {
    let mut random = Random(3);
    (0..count)
        .map(|i| {
            let mut axis = |low: f64, high: f64, count: usize| {
                (0..count).map(|_| random.between(low, high)).collect::<Vec<f64>>()
            };
            let mut axes = vec![
                ("mu_static", axis(0.1, 1.5, 12)),
                ("mu_coulomb", axis(0.01, 0.6, 8)),
                ("slope_deg", axis(if i % 2 == 0 { 0.0 } else { -15.0 }, 30.0, 8)),
            ];
            let mut fixed = vec![
                ("mass", axis(0.1, 3.0, 1)[0]),
                ("gravity", axis(3.0, 12.0, 1)[0]),
                ("anchor_weight", axis(0.0, 1.0, 1)[0]),
                ("wall_force", axis(0.0, 4.0, 1)[0]),
                ("wall_release", axis(0.0, 1.0, 1)[0]),
                ("corner_deg", axis(0.0, 50.0, 1)[0]),
                ("skin_ratio", axis(0.8, 2.0, 1)[0]),
                ("time", axis(0.01, 3.0, 1)[0]),
                ("speed", axis(-1.0, 1.0, 1)[0]),
                ("segments_max", 400.0),
            ];
            if i % 2 == 0 {
                axes.push(("stroke", axis(0.005, 0.1, 4)));
                axes.push(("segments", whole(3, 17)));
                fixed.push(("moving", 2.0));
            } else {
                axes.push(("viscous", [vec![0.0], axis(0.01, 30.0, 2)].concat()));
                axes.push(("drive_limit", [vec![f64::INFINITY], axis(0.5, 9.0, 1)].concat()));
                axes.push(("speed_limit", [vec![f64::INFINITY], axis(0.01, 0.4, 1)].concat()));
                axes.push(("segments", vec![2.0, 3.0, 4.0, 7.0, 12.0]));
                fixed.push(("brake", f64::from(i as u32 / 2 % 2)));
                fixed.push(("coulomb_term", f64::from(i as u32 / 4 % 2)));
                fixed.push(("anchors_ahead", f64::from(i as u32 / 8 % 2)));
            }
            (axes, fixed)
        })
        .collect()
}

fn fused() -> Vec<Level> {
    let levels = Level::available().into_iter();
    levels.filter(|l| cfg!(target_arch = "aarch64") || *l != Level::Baseline).collect()
}

#[test]
fn fused_levels_give_the_same_bits() {
    let levels = fused();
    let mut points = 0;
    for (axes, fixed) in random_grids(4) {
        let job = job(&axes, &fixed, all());
        points += job.cells() * QUANTITIES.len();
        let at = |level| results(&job, Options { level, ..options(2, DEFAULT_CHUNK) });
        let Some(first) = levels.first() else { return };
        let (expected, codes) = at(*first);
        for level in &levels[1..] {
            let (got, got_codes) = at(*level);
            for (n, entry) in QUANTITIES.iter().enumerate() {
                same(&got[n], &expected[n], &format!("{} on {level:?}", entry.info.name));
                assert_eq!(got_codes[n], codes[n]);
            }
        }
    }
    println!("{points} values at {levels:?}");
    assert!(points >= 1_000_000);
}

#[test]
fn fused_levels_reduce_to_the_same_bits() {
    let levels = fused();
    for (axes, fixed) in random_grids(2) {
        for job in reduced(&axes, &fixed, "segments", "mean_velocity") {
            let at = |level| values(&job, Options { level, ..options(2, DEFAULT_CHUNK) });
            for level in &levels {
                same(&at(*level), &at(levels[0]), &format!("{level:?}"));
            }
        }
    }
}

type Scalar = (&'static str, bool, fn(&Point<f64>) -> f64);

macro_rules! scalars {
    ($($quantity:ident),+ $(,)?) => {
        vec![$((
            <$quantity as Quantity>::INFO.name,
            <$quantity as Quantity>::INFO.integer,
            $quantity::value::<f64, false> as fn(&Point<f64>) -> f64,
        )),+]
    };
}

fn scalars() -> Vec<Scalar> {
    locosweep::for_each_quantity!(scalars)
}

#[test]
fn engine_and_scalar_formula_give_the_same_bits() {
    if fused().is_empty() {
        return;
    }
    for (axes, fixed) in random_grids(2) {
        let job = job(&axes, &fixed, all());
        let (got, _) = results(&job, options(2, DEFAULT_CHUNK));
        for cell in (0..job.cells()).step_by(13) {
            let point = Point::of(&given(&axes, &fixed, cell));
            for (n, (name, _, value)) in scalars().into_iter().enumerate() {
                same(&got[n][cell..=cell], &[value(&point)], name);
            }
        }
    }
}

fn given(axes: &Axes, fixed: &Fixed, cell: usize) -> Vec<(ParamId, f64)> {
    let mut rest = cell;
    let mut all: Vec<_> =
        fixed.iter().map(|(name, v)| (ParamId::parse(name).unwrap(), *v)).collect();
    for (name, values) in axes.iter().rev() {
        all.push((ParamId::parse(name).unwrap(), values[rest % values.len()]));
        rest /= values.len();
    }
    all
}

/// How far a value moves, at most, when every input moves by its relative `h`,
/// over `h`; `None` at a border, where a value appears or vanishes.
fn sensitivity(value: fn(&Point<f64>) -> f64, given: &[(ParamId, f64)]) -> Option<f64> {
    let h = 1e-6;
    let here = value(&Point::of(given));
    let mut sum = here.abs();
    for (i, (id, x)) in given.iter().enumerate() {
        if id.param().integer || *x == 0.0 || x.is_infinite() {
            continue;
        }
        for sign in [-1.0, 1.0] {
            let mut moved = given.to_vec();
            moved[i].1 = x * (1.0 + sign * h);
            let change = (value(&Point::of(&moved)) - here).abs();
            if change.is_nan() != here.is_nan() {
                return None;
            }
            sum += change / h;
        }
    }
    Some(sum)
}

/// Without a fused multiply-add the last bits differ, by no more than if every
/// input had moved by `ALLOWED` units in its last place: a few ulp where nothing
/// cancels, relative to the terms where they do.
#[test]
fn baseline_stays_within_its_bound() {
    const ALLOWED: f64 = 4.0;
    if fused().is_empty() || cfg!(target_arch = "aarch64") {
        return;
    }
    let all_scalars = scalars();
    let mut worst = vec![(0.0f64, 0.0f64, 0.0f64); all_scalars.len()];
    let mut borders = 0;
    for (axes, fixed) in random_grids(4) {
        let job = job(&axes, &fixed, all());
        let (exact, codes) = results(&job, options(2, DEFAULT_CHUNK));
        let at_baseline = Options { level: Level::Baseline, ..options(2, DEFAULT_CHUNK) };
        let (got, got_codes) = results(&job, at_baseline);
        for (n, (name, integer, value)) in all_scalars.iter().enumerate() {
            // The sensitivity takes some thirty evaluations.
            for cell in (n % 7..job.cells()).step_by(7) {
                let (a, b) = (exact[n][cell], got[n][cell]);
                if codes[n][cell] == got_codes[n][cell] && (a == b || a.is_nan()) {
                    continue;
                }
                let point = given(&axes, &fixed, cell);
                let Some(size) = sensitivity(*value, &point) else {
                    borders += 1;
                    continue;
                };
                assert!(!integer, "{name}: {a} and {b} at {point:?}");
                let ulp = (a - b).abs() / (a.abs().next_up() - a.abs());
                let error = (a - b).abs() / (size * f64::EPSILON);
                let relative = (a - b).abs() / a.abs();
                let w = &mut worst[n];
                *w = (w.0.max(error), w.1.max(ulp), w.2.max(relative));
                assert!(error <= ALLOWED, "{name}: {a:e} and {b:e}, {error} at {point:?}");
            }
        }
    }
    println!("baseline against fused, {borders} border cells left out");
    println!("{:<20} {:>10} {:>12} {:>12}", "quantity", "of bound", "worst ulp", "relative");
    for ((name, ..), (error, ulp, relative)) in all_scalars.iter().zip(&worst) {
        println!("{name:<20} {:>9.0}% {ulp:>12.1} {relative:>12.1e}", 100.0 * error / ALLOWED);
    }
}

// Reductions against a slow reference.

fn reference(axis: &[f64], values: &[f64], reduce: Reduce) -> f64 {
    let works: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    if works.is_empty() && reduce != Reduce::Count {
        return f64::NAN;
    }
    let most = works.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = works.iter().copied().fold(f64::INFINITY, f64::min);
    let first = |wins: &dyn Fn(f64) -> bool| axis[values.iter().position(|v| wins(*v)).unwrap()];
    match reduce {
        Reduce::Max => most,
        Reduce::Min => least,
        Reduce::Argmax => first(&|v| v >= most - TIE * most.abs()),
        Reduce::Argmin => first(&|v| v <= least + TIE * least.abs()),
        Reduce::Mean => works.iter().fold(0.0, |sum, v| sum + v) / works.len() as f64,
        Reduce::Count => works.len() as f64,
        Reduce::LastFeasible => axis[values.iter().rposition(|v| !v.is_nan()).unwrap()],
        Reduce::Quantile(q) => {
            let mut sorted = works;
            sorted.sort_by(f64::total_cmp);
            let place = (sorted.len() - 1) as f64 * q;
            let (i, share) = (place.floor() as usize, place.fract());
            let next = sorted[(i + 1).min(sorted.len() - 1)];
            sorted[i] + (next - sorted[i]) * share
        }
    }
}

fn against_reference(axes: &Axes, fixed: &Fixed, over: &str, quantity: &str) {
    let place = axes.iter().position(|(name, _)| *name == over).unwrap();
    let axis = &axes[place].1;
    let entry = Entry::parse(quantity).unwrap();
    let dense = values(&job(axes, fixed, vec![Request { entry, reduce: None }]), options(2, 4096));
    let inner: usize = axes[place + 1..].iter().map(|(_, v)| v.len()).product();
    let cells = dense.len() / axis.len();
    for (job, reduce) in reduced(axes, fixed, over, quantity).iter().zip(REDUCTIONS) {
        let (got, codes) = results(job, options(2, 777));
        assert_eq!(job.cells(), cells);
        for cell in 0..cells {
            let (outer, rest) = (cell / inner, cell % inner);
            let along: Vec<f64> =
                (0..axis.len()).map(|i| dense[(outer * axis.len() + i) * inner + rest]).collect();
            let expected = reference(axis, &along, reduce);
            let value = got[0][cell];
            let what = format!("{reduce:?} of {quantity} over {over}, cell {cell}: {along:?}");
            let exact = !matches!(reduce, Reduce::Quantile(_));
            // Between two neighbours the terms may be larger than the result.
            let size = along.iter().fold(0.0, |size: f64, v| size.max(v.abs()));
            let close = (value - expected).abs() <= 2.0 * f64::EPSILON * size;
            assert!(
                value.to_bits() == expected.to_bits()
                    || value.is_nan() && expected.is_nan()
                    || !exact && close,
                "{value:e} for {expected:e}: {what}"
            );
            let code = if expected.is_nan() { Status::NoneFeasible } else { Status::Ok };
            assert_eq!(codes[0][cell], code as u8, "{what}");
        }
    }
}

#[test]
fn reductions_of_plain_grids() {
    let axes: Axes = vec![
        ("mu_static", steps(0.05, 1.3, 26)),
        ("slope_deg", steps(0.0, 36.0, 10)),
        ("segments", whole(2, 15)),
        // 0.2 mu_S and others tie neighbouring counts.
        ("mu_coulomb", steps(0.01, 0.26, 26)),
    ];
    for quantity in ["mean_velocity", "cost_of_transport", "cycle_time", "net_force", "feasible"] {
        for over in ["segments", "slope_deg", "mu_coulomb"] {
            against_reference(&axes, &vec![], over, quantity);
        }
    }
}

#[test]
fn reductions_with_other_axes_and_orders() {
    let mut axes: Axes = vec![
        ("segments", whole(2, 15)),
        ("stroke", vec![0.01, 0.05]),
        ("mu_static", steps(0.05, 1.3, 26)),
        ("mu_coulomb", steps(0.01, 0.26, 26)),
    ];
    for _ in 0..4 {
        against_reference(&axes, &vec![], "segments", "mean_velocity");
        axes.rotate_left(1);
    }
    against_reference(&axes, &vec![("moving", 1.0)], "stroke", "phase_time");
}

#[test]
fn reductions_of_general_grids() {
    let (mut axes, fixed) = general();
    axes[6].1 = whole(1, 9);
    for quantity in ["mean_velocity", "best_segments", "slip_ratio", "net_advance", "net_force"] {
        for over in ["segments", "viscous", "slope_deg"] {
            against_reference(&axes, &fixed, over, quantity);
        }
    }
}

#[test]
fn best_count_is_the_argmax_over_counts() {
    let (mut axes, fixed) = general();
    axes[6].1 = whole(1, 60);
    let fixed: Fixed = fixed
        .into_iter()
        .map(|(name, v)| (name, if name == "segments_max" { 60.0 } else { v }))
        .collect();
    let argmax = &reduced(&axes, &fixed, "segments", "mean_velocity")[2];
    axes.pop();
    let best = vec![Request { entry: Entry::parse("best_segments").unwrap(), reduce: None }];
    same(
        &values(argmax, options(2, 4096)),
        &values(&job(&axes, &fixed, best), options(2, 4096)),
        "argmax and best_segments",
    );
}

// Refusals.

#[test]
fn a_cancelled_run_stops() {
    let (axes, fixed) = plain();
    let job = job(&axes, &fixed, all());
    let control = Control::default();
    control.cancel.store(true, Ordering::Relaxed);
    let mut out = vec![0.0; job.cells()];
    let error = run(&job, vec![(0, Buffer::F64(&mut out))], options(2, 64), &control);
    assert_eq!(error, Err(Error::Cancelled { done: 0, total: job.evaluations() }));
}

#[test]
fn a_running_sweep_stops_soon() {
    let grid = || {
        let axes = [
            ("mu_static", steps(0.1, 1.3, 400)),
            ("mu_coulomb", steps(0.1, 1.3, 400)),
            ("viscous", steps(0.1, 1.3, 400)),
            ("segments", whole(2, 400)),
        ];
        Grid::new(&axes, &[]).unwrap()
    };
    let entry = Entry::parse("mean_velocity").unwrap();
    for reduce in [None, Some(Reduce::Mean), Some(Reduce::Quantile(0.5))] {
        let over = reduce.map(|_| "segments");
        let mut grid = grid();
        if reduce.is_none() {
            grid.axes[3].values.truncate(2);
        }
        let job = Job::new(grid, vec![Request { entry, reduce }], over).unwrap();
        let mut out = vec![0.0; job.cells()];
        let control = Control::default();
        let (result, waited) = std::thread::scope(|scope| {
            let sweep = scope.spawn(|| {
                run(&job, vec![(0, Buffer::F64(&mut out))], options(2, DEFAULT_CHUNK), &control)
            });
            while control.done.load(Ordering::Relaxed) == 0 {
                std::thread::yield_now();
            }
            let asked = Instant::now();
            control.cancel.store(true, Ordering::Relaxed);
            (sweep.join().unwrap(), asked.elapsed())
        });
        let Err(Error::Cancelled { done, total }) = result else {
            panic!("{reduce:?}: {result:?}");
        };
        assert!(done < total && total == job.evaluations());
        println!("{reduce:?}: stopped after {} ms", waited.as_millis());
        assert!(waited.as_millis() < 250, "{reduce:?}: {waited:?}");
    }
}

#[test]
fn progress_counts_every_evaluation() {
    let (axes, fixed) = plain();
    for job in [job(&axes, &fixed, all())].into_iter().chain(reduced(
        &axes,
        &fixed,
        "segments",
        "mean_velocity",
    )) {
        let control = Control::default();
        let mut out = vec![0.0; job.cells()];
        run(&job, vec![(0, Buffer::F64(&mut out))], options(3, 100), &control).unwrap();
        assert_eq!(control.done.load(Ordering::Relaxed), job.evaluations());
    }
}

#[test]
fn buffers_must_fit() {
    let (axes, fixed) = plain();
    let job = job(&axes, &fixed, all());
    for size in [0, job.cells() - 1, job.cells() + 1] {
        let (mut wide, mut narrow, mut codes) = (vec![0.0; size], vec![0.0; size], vec![0; size]);
        for buffer in [Buffer::F64(&mut wide), Buffer::F32(&mut narrow), Buffer::Status(&mut codes)]
        {
            let error = run(&job, vec![(1, buffer)], options(1, 64), &Control::default());
            let quantity = QUANTITIES[1].info.name.to_owned();
            assert_eq!(error, Err(Error::OutSize { quantity, given: size, needed: job.cells() }));
        }
    }
}

#[test]
fn grids_too_large_to_count_are_refused() {
    let long = |name| (name, vec![1.0; 1 << 20]);
    let axes = ["mu_static", "mu_coulomb", "mass", "stroke"].map(long);
    let sizes = vec![1 << 20; 4];
    assert_eq!(Grid::new(&axes, &[]).err(), Some(Error::GridTooLarge { sizes: sizes.clone() }));
    let text = Error::GridTooLarge { sizes }.to_string();
    assert!(text.contains("1048576 x 1048576 x 1048576 x 1048576"), "{text}");
    // 2^60 cells fit into 64 bits, 2^63 bytes do not fit into memory.
    assert!(matches!(Grid::new(&axes[..3], &[]).err(), Some(Error::GridTooLarge { .. })));
    assert_eq!(Grid::new(&axes[..2], &[]).unwrap().points(), Ok(1 << 40));
}

#[test]
fn requests_are_checked() {
    let grid = |axes: &[(&str, Vec<f64>)]| Grid::new(axes, &[("mu_static", 0.5)]).unwrap();
    let segments = ("segments", whole(2, 4));
    let request = |reduce| vec![Request { entry: Entry::parse("mean_velocity").unwrap(), reduce }];
    let error = Job::new(grid(std::slice::from_ref(&segments)), request(None), None).err();
    assert!(matches!(error, Some(Error::MissingParameter { name, .. }) if name == "mu_coulomb"));
    let axes = [segments, ("mu_coulomb", vec![0.3])];
    let error = Job::new(grid(&axes), request(Some(Reduce::Max)), None).err();
    assert!(matches!(error, Some(Error::BadOption { name: "reduce", .. })));
    let error = Job::new(grid(&axes), request(None), Some("segments")).err();
    assert!(matches!(error, Some(Error::BadOption { name: "reduce", .. })));
    let error = Job::new(grid(&axes), request(Some(Reduce::Max)), Some("mass")).err();
    assert!(matches!(error, Some(Error::NotAnAxis { axis, .. }) if axis == "mass"));
    let error = Job::new(grid(&axes), request(Some(Reduce::Max)), Some("masss")).err();
    assert!(matches!(error, Some(Error::UnknownName { kind: "parameter", .. })));
    for (name, q) in [("quantile", None), ("quantile", Some(1.5)), ("quantile", Some(f64::NAN))] {
        assert!(matches!(Reduce::parse(name, q), Err(Error::BadOption { name: "q", .. })));
    }
    assert!(matches!(Reduce::parse("max", Some(0.5)), Err(Error::BadOption { name: "q", .. })));
    for (name, _) in Reduce::ALL {
        let q = (*name == "quantile").then_some(0.5);
        assert!(Reduce::parse(name, q).is_ok());
    }
    for level in Level::available() {
        assert_eq!(Level::parse(level.name()), Ok(level));
    }
    assert!(matches!(Level::parse("avx1024"), Err(Error::BadOption { .. })));
}
