//! Which fits can be told apart.

use locosweep::friction_fit::ties::rank;

fn noise(count: usize) -> Vec<f64> {
    let mut state = 3_u64;
    let uniform = |state: &mut u64| {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (*state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    (0..count).map(|_| uniform(&mut state)).collect()
}

#[test]
fn a_clear_loser_and_a_tie() {
    let base = noise(2000);
    // The second misses a step of half the noise; the third differs by nothing
    // that lasts.
    let worse: Vec<f64> =
        base.iter().enumerate().map(|(i, r)| r + if i < 1000 { 0.15 } else { -0.15 }).collect();
    let alike: Vec<f64> =
        base.iter().zip(noise(4001).iter().skip(2001)).map(|(r, n)| r + 0.001 * n).collect();
    let found = rank(&[base, worse, alike], &[1000, 1000]);
    assert!(found[0].tied && !found[1].tied && found[2].tied, "{found:?}");
    assert!(found[1].sigmas > 5.0);
}

#[test]
fn what_has_no_value_never_ties() {
    let found = rank(&[noise(100), vec![f64::NAN; 100]], &[100]);
    assert!(found[0].tied && !found[1].tied);
}
