//! The same bits for every cut and order.

use super::*;

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
                for (i, entry) in closed().into_iter().enumerate() {
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
        let found = index.iter().zip(axes).fold(0, |n, (i, (_, v))| n * v.len() + i);
        back[found] = *value;
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
        for (n, entry) in closed().into_iter().enumerate() {
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
                let job =
                    Job::new(grid, vec![request], Some("segments"), &Choice::default()).unwrap();
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
            for (n, entry) in closed().into_iter().enumerate() {
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
        for level in Level::available() {
            for (shift, chunk) in [(1, DEFAULT_CHUNK), (3, 1000), (5, 4097), (8, 31)] {
                room.fill(f64::MAX);
                let out = &mut room[shift..shift + large.cells()];
                let buffers = vec![(0, Buffer::F64(out))];
                let how = Options { level, ..options(2, chunk) };
                run(&large, buffers, how, &Control::default()).unwrap();
                let what = format!("{name} on {level:?} in chunks of {chunk}");
                same(&room[shift..shift + large.cells()], &expected, &what);
                let outside = room[..shift].iter().chain(&room[shift + large.cells()..]);
                assert!(outside.copied().all(|v| v == f64::MAX), "{what}: written outside");
            }
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
