//! Logarithms, powers and sines against correctly rounded values (made by
//! `data/make_log_functions.py` with 400 digits), at every SIMD level.

use locosweep::lane::log::{ln, ln_1p, power};
use locosweep::lane::trig::{cos_turns, sin_turns};
use locosweep::lane::{Lane, Level, Pack, Task, run};

const TABLE: &str = include_str!("data/log_functions.csv");

/// Error allowed in units in the last place.
const FUNCTIONS: [(&str, f64); 5] =
    [("ln", 1.0), ("ln_1p", 1.0), ("sin_turns", 1.0), ("cos_turns", 1.0), ("power", 2.0)];

#[inline(always)]
fn apply<L: Lane>(function: &str, x: L, p: L) -> L {
    match function {
        "ln" => ln(x),
        "ln_1p" => ln_1p(x),
        "sin_turns" => sin_turns(x),
        "cos_turns" => cos_turns(x),
        _ => power(x, p),
    }
}

struct Apply<'a> {
    function: &'a str,
    x: &'a [f64],
    p: &'a [f64],
    out: &'a mut [f64],
}

impl Task for Apply<'_> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        for i in (0..self.x.len()).step_by(P::LANES) {
            let (x, p) = (P::load(token, &self.x[i..]), P::load(token, &self.p[i..]));
            apply(self.function, x, p).store(&mut self.out[i..]);
        }
    }
}

/// All arguments through the lanes of `level`.
fn wide(level: Level, function: &str, x: &[f64], p: &[f64]) -> Vec<f64> {
    let whole = x.len().next_multiple_of(32);
    let padded = |values: &[f64]| {
        let mut values = values.to_vec();
        values.resize(whole, 0.5);
        values
    };
    let mut out = vec![0.0; whole];
    run(level, Apply { function, x: &padded(x), p: &padded(p), out: &mut out });
    out.truncate(x.len());
    out
}

/// Arguments and value.
fn table(function: &str) -> Vec<[f64; 3]> {
    let read = |line: &str| {
        let mut cells = line.split(',').filter(|cell| *cell != function);
        let mut next = || cells.next()?.parse().ok();
        Some([next()?, next()?, next()?])
    };
    TABLE.lines().filter(|line| line.split(',').next() == Some(function)).filter_map(read).collect()
}

fn ulps(got: f64, expected: f64) -> f64 {
    if got == expected {
        return 0.0;
    }
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
fn errors_against_the_table() {
    for (function, allowed) in FUNCTIONS {
        let rows = table(function);
        assert!(rows.len() >= 200, "{function}: {} rows", rows.len());
        let x: Vec<f64> = rows.iter().map(|row| row[0]).collect();
        let p: Vec<f64> = rows.iter().map(|row| row[1]).collect();
        let scalar: Vec<f64> = rows.iter().map(|row| apply(function, row[0], row[1])).collect();
        let mut runs = vec![("scalar", scalar, allowed)];
        for level in Level::available() {
            runs.push((level.name(), wide(level, function, &x, &p), allowed));
        }
        for (name, got, allowed) in runs {
            let (mut worst, mut at) = (0.0, [0.0; 3]);
            for (got, row) in got.iter().zip(&rows) {
                let error = ulps(*got, row[2]);
                if error > worst || error.is_nan() {
                    (worst, at) = (error, *row);
                }
            }
            println!("{function} {name}: worst {worst} ulp at {at:?}, allowed {allowed}");
            assert!(worst <= allowed, "{function} {name}: {worst} ulp at {at:?}");
        }
    }
}

/// Friction laws raise ratios of speeds to small powers.
#[test]
fn powers_of_usual_size() {
    let mut worst = 0.0f64;
    for [x, p, value] in table("power") {
        if (p * x.ln()).abs() <= 30.0 {
            worst = worst.max(ulps(power(x, p), value));
        }
    }
    println!("power with |p ln x| <= 30: worst {worst} ulp");
    assert!(worst <= 1.0);
}

#[test]
fn lanes_give_the_bits_of_the_scalar() {
    for (function, ..) in FUNCTIONS {
        let mut x: Vec<f64> = table(function).iter().map(|row| row[0]).collect();
        x.extend(spread(100_000, -0.999, 3.0));
        x.extend(spread(50_000, -1e6, 1e6));
        x.extend([0.0, -0.0, -1.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, f64::MAX]);
        let p = spread(x.len(), -1.0, 4.0);
        for level in Level::available() {
            for ((x, p), got) in x.iter().zip(&p).zip(wide(level, function, &x, &p)) {
                let scalar = apply(function, *x, *p);
                let same = got.to_bits() == scalar.to_bits() || got.is_nan() && scalar.is_nan();
                assert!(same, "{function} {level:?} at {x:e}, {p}: {got:e} and {scalar:e}");
            }
        }
    }
}

/// libm's logarithms are good to one unit, so two together.
#[test]
fn logarithms_over_their_range() {
    let exponents = spread(300_000, -1000.0, 1000.0);
    let x: Vec<f64> = exponents.iter().map(|e| e.exp2()).collect();
    let near: Vec<f64> = exponents.iter().map(|e| (e / 10.0).exp2()).collect();
    let p = vec![1.0; x.len()];
    for level in Level::available() {
        for ((x, near), (log, log_1p)) in x
            .iter()
            .zip(&near)
            .zip(wide(level, "ln", &x, &p).into_iter().zip(wide(level, "ln_1p", &near, &p)))
        {
            assert!(ulps(log, libm::log(*x)) <= 2.0, "ln({x:e}) = {log:e}");
            assert!(ulps(log_1p, libm::log1p(*near)) <= 2.0, "ln_1p({near:e}) = {log_1p:e}");
        }
    }
}

#[test]
fn ends_and_exact_values() {
    let inf = f64::INFINITY;
    assert_eq!((ln(1.0), ln(0.0), ln(-0.0), ln(inf)), (0.0, -inf, -inf, inf));
    assert_eq!((ln_1p(0.0), ln_1p(-1.0), ln_1p(inf)), (0.0, -inf, inf));
    assert_eq!((ln_1p(1e-300), ln_1p(-5e-324), ln(5e-324)), (1e-300, -5e-324, libm::log(5e-324)));
    for nan in [ln(-1.0), ln(-inf), ln(f64::NAN), ln_1p(-1.5), ln_1p(f64::NAN)] {
        assert!(nan.is_nan());
    }
    assert!(power(f64::NAN, 1.0).is_nan() && sin_turns(f64::NAN).is_nan());
    assert_eq!((power(0.0, 0.5), power(0.0, 0.0), power(7.0, 0.0)), (0.0, 1.0, 1.0));
    assert_eq!((power(4.0, 0.5), power(3.0, 2.0), power(1.0, 3.3)), (2.0, 9.0, 1.0));
    assert_eq!(power(0.0, -1.0), inf);
    assert!((power(1e300, 4.0) / locosweep::lane::exp::exp(700.0) - 1.0).abs() < 1e-12);
    for turn in [0.0, 1.0, -3.0, 1e6, 4_503_599_627_370_496.0] {
        assert_eq!((sin_turns(turn), cos_turns(turn)), (0.0, 1.0));
        if turn < 1e7 {
            assert_eq!((sin_turns(turn + 0.25), cos_turns(turn + 0.25)), (1.0, 0.0));
            assert_eq!((sin_turns(turn + 0.5), cos_turns(turn + 0.5)), (0.0, -1.0));
            assert_eq!((sin_turns(turn - 0.25), cos_turns(turn - 0.25)), (-1.0, 0.0));
        }
    }
}
