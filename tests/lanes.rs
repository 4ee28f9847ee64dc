//! The functions of viscous motion against correctly rounded values (made by
//! `data/make_exp_functions.py` with 60 digits), at every SIMD level.

use locosweep::lane::exp::{exp, log_factor, log_path_factor, path_factor, speed_factor};
use locosweep::lane::{Lane, Level, Pack, Task, run};

const TABLE: &str = include_str!("data/exp_functions.csv");

#[derive(Debug, Clone, Copy)]
enum Function {
    Exp,
    Path,
    Speed,
    Log,
    LogPath,
}

/// In the order of the table, with the error allowed in units in the last
/// place. The logarithms divide by an argument that is rounded already.
const FUNCTIONS: [(Function, f64); 5] = [
    (Function::Exp, 1.0),
    (Function::Path, 2.0),
    (Function::Speed, 2.0),
    (Function::Log, 2.0),
    (Function::LogPath, 4.0),
];

#[inline(always)]
fn apply<L: Lane>(function: Function, x: L) -> L {
    match function {
        Function::Exp => exp(x),
        Function::Path => path_factor(x),
        Function::Speed => speed_factor(x),
        Function::Log => log_factor(x),
        Function::LogPath => log_path_factor(x),
    }
}

struct Apply<'a> {
    function: Function,
    x: &'a [f64],
    out: &'a mut [f64],
}

impl Task for Apply<'_> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let whole = self.x.len() / P::LANES * P::LANES;
        assert_eq!(whole, self.x.len());
        for i in (0..whole).step_by(P::LANES) {
            apply(self.function, P::load(token, &self.x[i..])).store(&mut self.out[i..]);
        }
    }
}

/// All of `x` through the lanes of `level`.
fn wide(level: Level, function: Function, x: &[f64]) -> Vec<f64> {
    let mut padded = x.to_vec();
    padded.resize(x.len().next_multiple_of(32), 0.5);
    let mut out = vec![0.0; padded.len()];
    run(level, Apply { function, x: &padded, out: &mut out });
    out.truncate(x.len());
    out
}

fn table(function: Function) -> Vec<(f64, f64)> {
    let read = |line: &str| {
        let mut cells = line.split(',');
        let x = cells.next()?.parse().ok()?;
        Some((x, cells.nth(function as usize)?.parse().ok()?))
    };
    TABLE.lines().skip(1).filter_map(read).collect()
}

/// Distance in units in the last place of the expected value.
fn ulps(got: f64, expected: f64) -> f64 {
    let size = expected.abs().max(f64::MIN_POSITIVE);
    (got - expected).abs() / (size.next_up() - size)
}

/// Uniform in [low, high), the same on every machine.
fn spread(count: usize, low: f64, high: f64) -> Vec<f64> {
    let mut state = 7u64;
    let step = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (state >> 11) as f64 / (1u64 << 53) as f64
    };
    std::iter::repeat_with(step).take(count).collect()
}

#[test]
fn table_is_whole() {
    assert_eq!(TABLE.lines().count(), 401);
    for (function, least) in FUNCTIONS.iter().map(|f| f.0).zip([370, 200, 200, 280, 280]) {
        assert!(table(function).len() >= least, "{function:?}: {}", table(function).len());
    }
}

#[test]
fn errors_against_the_table() {
    for (function, allowed) in FUNCTIONS {
        let rows = table(function);
        let x: Vec<f64> = rows.iter().map(|row| row.0).collect();
        let scalar: Vec<f64> = x.iter().map(|x| apply(function, *x)).collect();
        let mut runs = vec![("scalar", scalar, allowed)];
        for level in Level::available() {
            runs.push((level.name(), wide(level, function, &x), allowed));
        }
        for (name, got, allowed) in runs {
            let (mut worst, mut at) = (0.0, 0.0);
            for (got, (x, expected)) in got.iter().zip(&rows) {
                let error = ulps(*got, *expected);
                if error > worst || error.is_nan() {
                    (worst, at) = (error, *x);
                }
            }
            println!("{function:?} {name}: worst {worst} ulp at {at:e}, allowed {allowed}");
            assert!(worst <= allowed, "{function:?} {name}: {worst} ulp at x = {at:e}");
        }
    }
}

#[test]
fn lanes_give_the_bits_of_the_scalar() {
    for (function, _) in FUNCTIONS {
        let low = match function {
            Function::Exp => -710.0,
            Function::Path | Function::Speed => 0.0,
            Function::Log | Function::LogPath => -0.999,
        };
        let mut x: Vec<f64> = table(function).iter().map(|row| row.0).collect();
        x.extend(spread(200_000, low, 2.0));
        x.extend(spread(100_000, low, 710.0));
        for level in Level::available() {
            for (x, got) in x.iter().zip(wide(level, function, &x)) {
                let scalar = apply(function, *x);
                assert_eq!(got.to_bits(), scalar.to_bits(), "{function:?} {level:?} at {x:e}");
            }
        }
    }
}

/// libm's exp is good to one unit, so two together.
#[test]
fn exp_over_its_whole_range() {
    let x = spread(2_000_000, -700.0, 700.0);
    for level in Level::available() {
        let mut worst = 0.0f64;
        for (x, got) in x.iter().zip(wide(level, Function::Exp, &x)) {
            worst = worst.max(ulps(got, libm::exp(*x)));
        }
        println!("exp {level:?}: {worst} ulp from libm over the whole range");
        assert!(worst <= 2.0, "{level:?}: {worst}");
    }
}

#[test]
fn exp_is_clamped_and_rises_across_its_seams() {
    let ends = [(-1e308, -700.0), (-700.5, -700.0), (700.5, 700.0), (1e308, 700.0)];
    for (beyond, end) in ends {
        assert_eq!(exp(beyond), exp(end));
    }
    assert_eq!(exp(f64::NEG_INFINITY), exp(-700.0));
    assert_eq!(exp(f64::INFINITY), exp(700.0));
    assert_eq!((exp(0.0), exp(-0.0)), (1.0, 1.0));
    for k in -1009..=1009 {
        let seam = (f64::from(k) + 0.5) * std::f64::consts::LN_2;
        let mut x = seam * (1.0 - 20.0 * f64::EPSILON);
        for _ in 0..40 {
            let (next, here) = (x.next_up(), x);
            // One unit of x moves exp by |x| units of its own: never backward
            // by more than its error of one.
            assert!(exp(next) >= exp(here).next_down(), "exp falls at {here:e}");
            x = next;
        }
    }
}

/// At x = 1 a series hands over to the direct formula.
#[test]
fn factors_fit_together_at_their_seams() {
    for (function, seams) in [
        (Function::Path, [1.0f64, 1.0]),
        (Function::Speed, [1.0, 1.0]),
        (Function::LogPath, [0.25, -0.25]),
    ] {
        for seam in seams {
            let (below, above) = (seam.next_down(), seam.next_up());
            let at = apply(function, seam);
            for near in [apply(function, below), apply(function, above)] {
                assert!(ulps(near, at) <= 4.0, "{function:?} jumps at {seam}");
            }
        }
    }
    assert_eq!((path_factor(0.0), speed_factor(0.0)), (0.5, 1.0));
    assert_eq!((log_factor(0.0), log_path_factor(0.0)), (1.0, 0.5));
}

#[test]
fn factors_of_motion_are_bounded() {
    let mut x = spread(100_000, 0.0, 50.0);
    x.extend(spread(1000, 0.0, 1e12));
    x.extend([f64::MIN_POSITIVE, 5e-324, 1e300, f64::MAX]);
    for x in x {
        let (path, speed) = (path_factor(x), speed_factor(x));
        assert!((0.0..=0.5).contains(&path), "E2({x:e}) = {path}");
        assert!((0.0..=1.0).contains(&speed), "E1({x:e}) = {speed}");
    }
}
