//! Spread, spikes, memory, blocks and what they make of uncertainty.

use locosweep::friction_fit::spread::{blocks, memory, robust, spikes, uncertainty};
use nalgebra::DMatrix;

#[test]
fn outliers_do_not_move_the_robust_spread() {
    let mut values: Vec<f64> = (0..101).map(|i| f64::from(i) - 50.0).collect();
    let clean = robust(&values);
    assert!((clean - 25.0 * 1.482_602_218_505_602).abs() < 1e-12);
    values[100] = 1e9;
    assert!((robust(&values) - clean).abs() < 0.1 * clean);
}

#[test]
fn a_spike_is_found_and_a_step_is_none() {
    let noise = |i: usize| 0.01 * ((i * 7919) % 13) as f64;
    let mut values: Vec<f64> =
        (0..200).map(|i| if i < 100 { -1.0 } else { 1.0 } + noise(i)).collect();
    assert_eq!(spikes(&values, 10.0), []);
    values[42] = 7.0;
    values[150] = -7.0;
    assert_eq!(spikes(&values, 10.0), [42, 150]);
}

#[test]
fn memory_of_a_first_order_process() {
    // Theory: (1 + a)/(1 - a).
    let mut state = 1_u64;
    let mut noise = || {
        let mut sum = -6.0;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    };
    for a in [0.0, 0.5, 0.9] {
        let mut now = 0.0;
        let values: Vec<f64> = (0..20_000)
            .map(|_| {
                now = a * now + noise();
                now
            })
            .collect();
        let found = memory(&values, &[20_000]);
        let theory = (1.0 + a) / (1.0 - a);
        assert!((found / theory - 1.0).abs() < 0.15, "{a}: {found} for {theory}");
    }
}

#[test]
fn blocks_stay_within_runs() {
    let found = blocks(&[10, 4], 0.5);
    assert_eq!(found, [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 3]);
}

#[test]
fn a_direction_without_data_has_no_bounds() {
    let j = DMatrix::from_fn(40, 2, |i, _| 1.0 + i as f64);
    let residuals: Vec<f64> = (0..40).map(|i| if i % 2 == 0 { 0.1 } else { -0.1 }).collect();
    let found = uncertainty(&j, &residuals, &(0..40).collect::<Vec<_>>());
    assert!(found.std.iter().all(|s| s.is_infinite()));
    let one = uncertainty(&j.columns(0, 1).into_owned(), &residuals, &(0..40).collect::<Vec<_>>());
    assert!(one.std[0] < 1e-3);
}
