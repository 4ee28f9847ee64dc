//! Derivatives of noisy samples.

use locosweep::friction_fit::velocity::derivative;

fn times(count: usize) -> Vec<f64> {
    // Uneven on purpose.
    (0..count).map(|i| 0.01 * i as f64 + 0.003 * ((i * 7) % 5) as f64 / 5.0).collect()
}

#[test]
fn polynomials_have_exact_derivatives() {
    let t = times(60);
    let y: Vec<f64> = t.iter().map(|t| 2.0 - 3.0 * t + 4.0 * t * t).collect();
    let first = derivative(&t, &y, 1).unwrap();
    for (t, v) in t.iter().zip(&first.values) {
        assert!((v - (8.0 * t - 3.0)).abs() < 1e-10);
    }
    let cubic: Vec<f64> = t.iter().map(|t| t * t * t).collect();
    let second = derivative(&t, &cubic, 2).unwrap();
    for (t, a) in t.iter().zip(&second.values) {
        assert!((a - 6.0 * t).abs() < 1e-7, "{a} at {t}");
    }
}

#[test]
fn noise_is_found_and_mostly_taken_out() {
    let t = times(4000);
    let mut state = 7_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    // Uniform within 1: standard deviation 1/sqrt(12).
    let width = 2e-3;
    let y: Vec<f64> = t.iter().map(|t| (2.0 * t).sin() + width * uniform()).collect();
    let found = derivative(&t, &y, 1).unwrap();
    let noise = width / 12.0_f64.sqrt();
    assert!((found.noise / noise - 1.0).abs() < 0.15, "{} for {noise}", found.noise);
    let off: f64 =
        t.iter().zip(&found.values).map(|(t, v)| (v - 2.0 * (2.0 * t).cos()).powi(2)).sum();
    let off = (off / t.len() as f64).sqrt();
    assert!(off < 0.02, "{off}");
    assert!((found.error / off - 1.0).abs() < 0.5, "says {}, is {off}", found.error);
}
