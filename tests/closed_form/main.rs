//! The closed forms against numbers derived by hand and with independent tools,
//! their limits, symmetries and scaling, and the best count against brute force.

mod best;
mod continuous;
mod designs;
mod limits;
mod paper;
#[path = "../common/random.rs"]
mod random;
mod scaling;

use locosweep::physics::ParamId::{self, *};
use locosweep::physics::closed_form::*;
use locosweep::physics::{Point, Quantity, Status};
use random::Random;

const G: f64 = 9.81;
const M: f64 = 0.271;
const MG: f64 = M * G;

type Given<'a> = &'a [(ParamId, f64)];

fn value<Q: Quantity>(given: Given) -> f64 {
    Q::value::<f64, false>(&Point::of(given))
}

fn status<Q: Quantity>(given: Given) -> Status {
    Q::status(&Point::of(given))
}

fn with(base: Given, more: Given) -> Vec<(ParamId, f64)> {
    [base, more].concat()
}

fn surface(mu_static: f64, mu_coulomb: f64, segments: f64) -> Vec<(ParamId, f64)> {
    vec![(MuStatic, mu_static), (MuCoulomb, mu_coulomb), (Segments, segments)]
}

/// Asserts that `got` rounds to the decimal number `shown`.
#[track_caller]
fn shows(got: f64, shown: &str) {
    let digits = shown.split_once('.').map_or(0, |(_, digits)| digits.len());
    let expected: f64 = shown.parse().unwrap();
    let half = 0.5 * 10f64.powi(-(digits as i32)) * (1.0 + 1e-9);
    assert!((got - expected).abs() <= half, "{got} does not show {shown}");
}

#[track_caller]
fn near(got: f64, expected: f64, relative: f64) {
    let size = expected.abs().max(f64::MIN_POSITIVE);
    assert!((got - expected).abs() <= relative * size, "{got} is not {expected}");
}

fn tan_deg(degrees: f64) -> f64 {
    degrees.to_radians().tan()
}

/// Designs where a wide range of N/k works: coefficients, slope, w.
fn designs(count: usize) -> Vec<[f64; 4]> {
    let mut random = Random(4);
    let mut all = Vec::new();
    while all.len() < count {
        let design = [
            random.log(0.05, 2.0),
            random.log(0.01, 2.0),
            random.between(0.0, 40.0),
            random.unit(),
        ];
        if design[0] > 1.2 * design[3] * tan_deg(design[2]) {
            all.push(design);
        }
    }
    all
}

fn design([mu_static, mu_coulomb, slope, w]: [f64; 4]) -> Vec<(ParamId, f64)> {
    with(&surface(mu_static, mu_coulomb, 1.0), &[(SlopeDeg, slope), (AnchorWeight, w)])
}
