//! Least squares: certified values, bounds.

use locosweep::friction_fit::squares::{Minimum, Residuals, minimise};
use locosweep::lane::Level;
use locosweep::sweep::Control;
use locosweep::sweep::fit::How;

/// Misra1a of NIST's reference datasets: y = b1 (1 - exp(-b2 x)), certified
/// b1 = 238.94212918, b2 = 5.5015643181e-4, sum of squares 0.12455138894.
struct Misra1a;

const X: [f64; 14] = [
    77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0,
];
const Y: [f64; 14] = [
    10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47,
    81.78,
];

impl Residuals for Misra1a {
    fn at(&self, u: &[f64]) -> Vec<f64> {
        let value = |x: f64| u[0] * 1e2 * -f64::exp_m1(-u[1] * 1e-4 * x);
        X.iter().zip(Y).map(|(x, y)| value(*x) - y).collect()
    }
    fn bounds(&self, _: usize) -> (f64, f64) {
        (0.0, f64::INFINITY)
    }
    fn width(&self, _: usize) -> f64 {
        1e-6
    }
}

fn searched(model: &impl Residuals, start: &[f64], steps: usize) -> Minimum {
    let control = Control::default();
    let how = How { level: Level::Baseline, threads: 1, control: &control };
    minimise(model, start, &[0, 1], steps, &how).unwrap()
}

#[test]
fn certified_values_of_a_reference_problem() {
    for start in [[5.0, 1.0], [2.5, 5.0]] {
        let found = searched(&Misra1a, &start, 200);
        assert!(found.settled);
        assert!((found.u[0] * 1e2 / 238.942_129_18 - 1.0).abs() < 1e-6, "{:?}", found.u);
        assert!((found.u[1] * 1e-4 / 5.501_564_318_1e-4 - 1.0).abs() < 1e-6);
        assert!((found.cost / 0.124_551_388_94 - 1.0).abs() < 1e-8);
    }
}

#[test]
fn a_bound_holds_and_the_others_go_on() {
    struct Line;
    impl Residuals for Line {
        fn at(&self, u: &[f64]) -> Vec<f64> {
            // Best without bounds: 3 - 2 x.
            (0..5).map(|i| u[0] + u[1] * f64::from(i) - (3.0 - 2.0 * f64::from(i))).collect()
        }
        fn bounds(&self, _: usize) -> (f64, f64) {
            (0.0, f64::INFINITY)
        }
        fn width(&self, _: usize) -> f64 {
            1e-6
        }
    }
    // With a slope of 0 at least, the level is the mean, -1, so 0.
    let found = searched(&Line, &[5.0, 5.0], 100);
    assert_eq!(found.u, [0.0, 0.0]);
}
