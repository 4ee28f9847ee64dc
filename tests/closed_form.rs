//! The closed forms against numbers derived by hand and with independent tools,
//! their limits, symmetries and scaling, and the best count against brute force.

use locosweep::physics::ParamId::{self, *};
use locosweep::physics::closed_form::*;
use locosweep::physics::{Point, Quantity, Status};

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

/// Uniform in [0, 1), the same on every machine.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn log(&mut self, low: f64, high: f64) -> f64 {
        (self.between(low.ln(), high.ln())).exp()
    }

    fn whole(&mut self, low: u32, high: u32) -> f64 {
        self.between(f64::from(low), f64::from(high) + 1.0).floor()
    }

    fn one_in(&mut self, n: u32) -> bool {
        self.unit() * f64::from(n) < 1.0
    }
}

// What the paper's text fixes.

#[test]
fn four_segments_are_best_for_equal_coefficients() {
    for w in [0.0, 1.0] {
        for mu in [0.01, 0.1, 0.3, 0.5, 1.0, 7.0] {
            let given = with(&surface(mu, mu, 4.0), &[(AnchorWeight, w)]);
            assert_eq!(value::<OptimalSegments>(&given), 4.0, "mu = {mu}");
            assert_eq!(value::<BestSegments>(&given), 4.0, "mu = {mu}");
        }
    }
}

#[test]
fn forces_of_the_papers_robot() {
    shows(MG, "2.65851");
    shows(value::<NetForce>(&surface(0.5, 0.3, 4.0)), "3.19021");
    shows(value::<PropulsiveForce>(&surface(0.4, 0.3, 4.0)), "3.1902");
    shows(value::<PropulsiveForce>(&surface(0.5, 0.3, 4.0)), "3.988");
    shows(value::<PropulsiveForce>(&surface(0.3, 0.3, 4.0)), "2.393");
    shows(3.2 / value::<PropulsiveForce>(&surface(1.0, 0.3, 4.0)), "0.4012");
    shows(value::<Resistance>(&surface(0.5, 0.3, 4.0)), "0.7976");
}

#[test]
fn velocity_over_time_of_figure_5() {
    let base = surface(0.3, 0.15, 3.0);
    let at = |t: f64, viscous: f64, coulomb: f64| {
        let more = [(Time, t), (Viscous, viscous), (CoulombTerm, coulomb)];
        value::<Velocity>(&with(&base, &more))
    };
    let wet = |coulomb| with(&base, &[(Viscous, 0.5), (CoulombTerm, coulomb)]);
    shows(value::<Acceleration>(&base), "4.4145");
    shows(at(1.0, 0.0, 1.0), "4.4145");
    shows(value::<PropulsiveForce>(&base), "1.595106");
    shows(value::<TimeConstant>(&wet(0.0)), "0.542");
    shows(value::<VelocityLimit>(&wet(0.0)), "3.190212");
    shows(at(1.0, 0.5, 0.0), "2.686087");
    shows(value::<VelocityLimit>(&wet(1.0)), "2.392659");
    shows(at(1.0, 0.5, 1.0), "2.014565");

    let ahead = |t| at(t, 0.5, 0.0) - at(t, 0.0, 0.0);
    let (mut low, mut high) = (0.1, 1.0);
    assert!(ahead(low) > 0.0 && ahead(high) < 0.0, "the viscous one is the faster before");
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if ahead(middle) > 0.0 { low = middle } else { high = middle }
    }
    shows(low, "0.328376");
    shows(at(low, 0.0, 1.0), "1.449616");
}

#[test]
fn variants_of_figure_2() {
    let rows = [
        (0.0, "3.200", 3.0, "3.200", 3.0),
        (2.0, "3.440", 4.0, "3.340", 3.0),
        (4.0, "3.720", 4.0, "3.480", 4.0),
        (6.0, "4.052", 4.0, "3.620", 4.0),
        (8.0, "4.451", 5.0, "3.762", 4.0),
        (10.0, "4.943", 5.0, "3.905", 4.0),
        (12.0, "5.566", 6.0, "4.050", 4.0),
        (14.0, "6.383", 6.0, "4.197", 4.0),
        (16.0, "7.503", 8.0, "4.347", 4.0),
        (18.0, "9.139", 9.0, "4.500", 5.0),
        (20.0, "11.762", 12.0, "4.656", 5.0),
    ];
    let at = |slope, w| {
        with(&surface(0.5, 0.3, 4.0), &[(SlopeDeg, slope), (AnchorWeight, w), (SegmentsMax, 100.0)])
    };
    for (slope, shown_a, whole_a, shown_b, whole_b) in rows {
        for (w, shown, whole) in [(1.0, shown_a, whole_a), (0.0, shown_b, whole_b)] {
            shows(value::<OptimalSegments>(&at(slope, w)), shown);
            assert_eq!(value::<BestSegments>(&at(slope, w)), whole, "{slope} deg, w = {w}");
        }
    }
    for (w, low, high) in [(1.0, 1.909, 7.970), (0.0, 3.270, 17.281)] {
        let best = |slope| value::<BestSegments>(&at(slope, w));
        assert_eq!((best(low - 5e-4), best(low + 5e-4)), (3.0, 4.0));
        assert_eq!((best(high - 5e-4), best(high + 5e-4)), (4.0, 5.0));
    }
    let v = |n| value::<MeanVelocity>(&surface(0.5, 0.3, n));
    shows(100.0 * (v(3.0) / v(4.0) - 1.0), "1.8");
}

#[test]
fn anchors_that_slide_by_themselves() {
    let steep = |w| with(&surface(0.5, 0.5, 8.0), &[(SlopeDeg, 30.0), (AnchorWeight, w)]);
    assert!(value::<OptimalSegments>(&steep(1.0)).is_nan());
    assert_eq!(status::<OptimalSegments>(&steep(1.0)), Status::SlidesBack);
    let b = with(&surface(0.5, 0.3, 8.0), &[(SlopeDeg, 30.0), (AnchorWeight, 0.0)]);
    shows(value::<OptimalSegments>(&b), "5.5");
}

#[test]
fn variants_of_figure_4() {
    let optimum = |mu, slope, w| {
        let more = [(SlopeDeg, slope), (AnchorWeight, w)];
        value::<OptimalSegments>(&with(&surface(mu, mu, 4.0), &more))
    };
    let pole = (0.992f64 * 0.5).atan().to_degrees();
    shows(pole, "26.38");
    near(optimum(0.5, pole, 1.0), 500.0, 1e-11);
    let steep = (248f64 * 0.01).atan().to_degrees();
    shows(steep, "68.0");
    near(optimum(0.01, steep, 0.0), 500.0, 1e-12);
    shows(optimum(0.01, 70.0, 0.0), "553.5");
    shows(optimum(0.05, 85.0, 0.0), "461.2");

    let (mut most, mut least_drop) = (0.0f64, 0.0f64);
    for i in 1..=100 {
        for slope in [0.0, 5.0, 10.0, 15.0, 20.0] {
            let mu = f64::from(i) / 100.0;
            let formula = 4.0 * mu / (mu - tan_deg(slope));
            let got = optimum(mu, slope, 1.0);
            if formula > 0.0 {
                near(got, formula, 1e-11);
                most = most.max(got);
            } else {
                least_drop = least_drop.min(formula);
                assert!(got.is_nan(), "a negative optimum: {got}");
            }
            near(optimum(mu, slope, 0.0), 4.0 + 2.0 * tan_deg(slope) / mu, 1e-13);
        }
    }
    shows(most, "526.6");
    shows(least_drop, "-362.7");
}

#[test]
fn an_actuator_limit_changes_the_optimum() {
    let limited =
        |mu_static, mu_coulomb, n| with(&surface(mu_static, mu_coulomb, n), &[(DriveLimit, 0.85)]);
    for (n, shown) in [(2.0, "21.996"), (3.0, "14.664"), (4.0, "10.998")] {
        let given = limited(0.5, 0.3, n);
        shows(value::<Acceleration>(&given), "0.193531");
        shows(1e3 * value::<MeanVelocity>(&given), shown);
        assert_eq!(value::<BestSegments>(&given), 2.0);
    }
    shows(1.0 / value::<AnchorSafety>(&limited(0.5, 0.3, 2.0)), "0.639");
    shows(value::<PropulsiveForce>(&limited(0.3, 0.15, 2.0)), "0.79755");
    shows(value::<Acceleration>(&limited(0.3, 0.15, 4.0)), "1.665031");
    for (n, shown) in [(2.0, "60.653"), (3.0, "43.012"), (4.0, "32.259")] {
        shows(1e3 * value::<MeanVelocity>(&limited(0.3, 0.15, n)), shown);
    }
}

// Results that hold for every design.

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

#[test]
fn the_universal_curve() {
    let shown = [
        (0.75, "0.942809"),
        (1.0, "1.000000"),
        (1.25, "0.979796"),
        (1.5, "0.942809"),
        (2.0, "0.866025"),
        (3.0, "0.745356"),
    ];
    for d in designs(200) {
        for k in [1.0, 2.0, 5.0, 40.0] {
            let given = with(&design(d), &[(Moving, k)]);
            let best = value::<OptimalSegments>(&given);
            let v = |x: f64| value::<MeanVelocity>(&with(&given, &[(Segments, x * best)]));
            for (x, shown) in shown {
                shows(v(x) / v(1.0), shown);
                near(v(x) / v(1.0), (2.0 * x - 1.0).sqrt() / x, 1e-12);
            }
            // x = 0.5 is the border itself, where rounding decides.
            assert!(v(0.5 + 1e-13) / v(1.0) < 1e-5 || v(0.5 + 1e-13).is_nan());
            assert!(v(0.5 - 1e-13).is_nan());
            let [mu_static, mu_coulomb, slope, w] = d;
            let (s, c) = slope.to_radians().sin_cos();
            let sum = (mu_static + mu_coulomb) * c + (1.0 - w) * s;
            let at_best = with(&given, &[(Segments, best)]);
            near(value::<Acceleration>(&at_best), G * sum, 1e-11);
            near(v(1.0), k / best * (0.02 * G * sum / 2.0).sqrt(), 1e-12);
        }
    }
    let equal = surface(0.5, 0.5, 4.0);
    shows(value::<MeanVelocity>(&equal), "0.078302");
}

/// An error of +50 % or -25 % in r costs 5.7 %, one of -50 % everything.
#[test]
fn errors_of_the_optimum_cost_little_upward() {
    for d in designs(20) {
        let best = value::<OptimalSegments>(&design(d));
        let v = |x: f64| value::<MeanVelocity>(&with(&design(d), &[(Segments, x * best)]));
        shows(100.0 * (1.0 - v(1.5) / v(1.0)), "5.7");
        shows(100.0 * (1.0 - v(0.75) / v(1.0)), "5.7");
        assert!(v(0.499_999).is_nan());
    }
}

#[test]
fn speed_over_segments_and_its_tie() {
    let shown = ["70.0357", "87.3499", "85.7759", "81.6750", "77.4274", "73.5222", "70.0357"];
    let v = |n| value::<MeanVelocity>(&surface(0.5, 0.3, n));
    for (n, shown) in (2..).zip(shown) {
        shows(1e3 * v(f64::from(n)), shown);
    }
    near(v(2.0), v(8.0), TIE);
}

#[test]
fn integer_optimum_switches_where_derived() {
    for n in 2..200 {
        let n = f64::from(n);
        let switch = 2.0 * n * (n + 1.0) / (2.0 * n + 1.0);
        for w in [0.0, 1.0] {
            let best = |r: f64| {
                let mu_coulomb = 0.5 * (0.5 * r - 1.0);
                value::<BestSegments>(&with(&surface(0.5, mu_coulomb, 1.0), &[(AnchorWeight, w)]))
            };
            assert_eq!((best(switch * (1.0 - 1e-9)), best(switch * (1.0 + 1e-9))), (n, n + 1.0));
            assert_eq!(best(switch), n, "a tie goes to the lower count");
        }
    }
    for (n, exact) in [(2.0, 12.0 / 5.0), (3.0, 24.0 / 7.0), (4.0, 40.0 / 9.0), (5.0, 60.0 / 11.0)]
    {
        near(2.0 * n * (n + 1.0) / (2.0 * n + 1.0), exact, 1e-15);
    }
}

/// N of highest mean velocity as a real number, from the slope of the curve.
fn peak(given: Given, mut low: f64, mut high: f64) -> f64 {
    let v = |n: f64| value::<MeanVelocity>(&with(given, &[(Segments, n)]));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let rises = v(middle * (1.0 + 1e-5)) > v(middle * (1.0 - 1e-5));
        if rises { low = middle } else { high = middle }
    }
    low
}

#[test]
fn braking_to_rest_moves_the_optimum() {
    for mu in [0.1, 0.5, 2.0] {
        let given = with(&surface(mu, mu, 3.0), &[(Brake, 1.0)]);
        near(peak(&given, 2.1, 10.0), 2.0 + 2f64.sqrt(), 1e-8);
        assert_eq!(value::<BestSegments>(&given), 3.0);
    }
    let given = with(&surface(0.5, 0.3, 3.0), &[(Brake, 1.0)]);
    shows(peak(&given, 1.7, 10.0), "2.740");
    shows(1e3 * value::<MeanVelocity>(&given), "70.4237");
}

#[test]
fn accelerate_then_brake() {
    for d in designs(200) {
        let [mu_static, mu_coulomb, slope, w] = d;
        let (s, c) = slope.to_radians().sin_cos();
        for k in [1.0, 3.0] {
            let given = with(&design(d), &[(Moving, k), (Segments, 60.0), (Brake, 1.0)]);
            let a = value::<Acceleration>(&given);
            if a.is_nan() {
                continue;
            }
            let ratio = (60.0 - k) / k;
            let b = G * (ratio * (mu_static * c + w * s) + mu_coulomb * c + s);
            near(value::<PhaseTime>(&given), (0.04 * (a + b) / (a * b)).sqrt(), 1e-13);
            assert_eq!(value::<ImpactLoss>(&given), 0.0);
        }
    }
}

#[test]
fn anchors_that_slip() {
    let given = with(&surface(0.5, 0.3, 4.0), &[(DriveLimit, 5.0)]);
    shows(value::<AnchorCapacity>(&surface(0.5, 0.3, 4.0)), "3.98777");
    let forward = 5.0 / M - 0.3 * G;
    let backward = 5.0 / (3.0 * M) - 0.3 * G;
    shows(forward, "15.507185");
    shows(backward, "3.207062");
    shows(1e3 * (0.04 / (forward + backward)).sqrt(), "46.2321");
    let ratio = value::<SlipRatio>(&given);
    near(ratio, backward / (forward + backward), 1e-14);
    shows(1e3 * 0.02 * ratio, "3.4274");
    shows(1e3 * 0.02 * (1.0 - ratio), "16.5726");
    shows(1e3 * value::<NetAdvance>(&given), "6.2904");
    near(value::<AnchorSafety>(&given), 3.0 * 0.5 * MG / 5.0, 1e-15);
    let held = with(&surface(0.5, 0.3, 4.0), &[(DriveLimit, 3.9)]);
    assert_eq!((value::<SlipRatio>(&held), value::<NetAdvance>(&held)), (0.0, 0.02));
}

/// A drive without measure slips anchors and movers by the inverse of their
/// masses, whatever else holds them.
#[test]
fn slip_under_a_huge_drive() {
    for (limit, mass) in [(1e9, M), (1e20, M), (1e30, 1e-9), (1e30, M)] {
        for ahead in [0.0, 1.0] {
            let more = [(DriveLimit, limit), (Mass, mass), (AnchorsAhead, ahead)];
            let given = with(&surface(0.5, 0.3, 4.0), &more);
            near(value::<SlipRatio>(&given), 0.25, 1e-8);
        }
    }
}

#[test]
fn moving_more_segments_at_once() {
    let given = with(&surface(0.5, 0.3, 1.0), &[(SlopeDeg, 8.0)]);
    shows(value::<OptimalSegments>(&given), "4.45113");
    let v = |n, k| 1e3 * value::<MeanVelocity>(&with(&given, &[(Segments, n), (Moving, k)]));
    shows(v(value::<OptimalSegments>(&given), 1.0), "62.6304");
    shows(v(4.0, 1.0), "62.2308");
    shows(v(8.0, 2.0), "62.2308");
    shows(v(9.0, 2.0), "62.6267");
}

#[test]
fn slope_limits() {
    let rows = [
        (0.5, 0.3, ["5.711", "13.134", "16.699", "18.778", "21.801", "26.565"]),
        (0.3, 0.15, ["4.289", "8.531", "10.620", "11.860", "13.699", "16.699"]),
    ];
    for (mu_static, mu_coulomb, shown) in rows {
        for (n, shown) in [2.0, 3.0, 4.0, 5.0, 8.0, 1e9].into_iter().zip(shown) {
            let given = surface(mu_static, mu_coulomb, n);
            let limit = value::<SlopeLimitDeg>(&given);
            shows(limit, shown);
            near(tan_deg(limit), mu_static - (mu_static + mu_coulomb) / n, 1e-13);
            let at = |slope| value::<Feasible>(&with(&given, &[(SlopeDeg, slope)]));
            assert_eq!((at(limit - 1e-9), at(limit + 1e-9)), (1.0, 0.0));
        }
    }
}

/// Every slope from the flat to the limit works, none right above it.
#[test]
fn nothing_below_the_slope_limit_fails() {
    let mut random = Random(6);
    let mut limits = 0;
    for _ in 0..2000 {
        let k = random.whole(1, 3);
        let mut given = vec![
            (MuStatic, random.log(0.05, 5.0)),
            (MuCoulomb, random.log(0.05, 5.0)),
            (Moving, k),
            (Segments, k + random.whole(1, 20)),
            (AnchorWeight, random.unit()),
        ];
        if random.one_in(2) {
            given.push((WallForce, random.log(0.1, 100.0)));
            given.push((WallRelease, random.unit()));
        }
        if random.one_in(2) {
            given.push((DriveLimit, k * random.log(0.5, 20.0)));
        }
        let limit = value::<SlopeLimitDeg>(&given);
        let moves = |slope| value::<Feasible>(&with(&given, &[(SlopeDeg, slope)])) == 1.0;
        if limit.is_nan() {
            assert!(!moves(0.0), "{given:?}");
            continue;
        }
        limits += 1;
        for i in 0..200 {
            let slope = limit * (1.0 - 1e-9) * f64::from(i) / 199.0;
            assert!(moves(slope), "limit {limit}, but not {slope} deg: {given:?}");
        }
        assert!(limit == 90.0 || !moves(limit + 1e-9), "{given:?}");
    }
    assert!(limits > 800, "only {limits} designs had a limit");
}

#[test]
fn feasible_beyond_half_the_optimum() {
    for d in designs(300) {
        let half = 0.5 * value::<OptimalSegments>(&design(d));
        let feasible = |n| value::<Feasible>(&with(&design(d), &[(Segments, n)]));
        assert_eq!((feasible(half * (1.0 - 1e-12)), feasible(half * (1.0 + 1e-12))), (0.0, 1.0));
    }
}

#[test]
fn phases_with_a_speed_limit() {
    let base = surface(0.5, 0.3, 4.0);
    let a = value::<Acceleration>(&base);
    for v in [0.001, 0.01, 0.1, 0.2] {
        let given = with(&base, &[(SpeedLimit, v)]);
        assert!(0.02 > v * v / (2.0 * a));
        near(value::<PhaseTime>(&given), 0.02 / v + v / (2.0 * a), 1e-14);
        assert_eq!(value::<PeakSpeed>(&given), v);
        near(value::<ImpactLoss>(&given), 0.5 * M * v * v, 1e-15);
    }
    // Far below the free peak the limit alone sets the pace, k v_max/N ...
    for k in [1.0, 2.0, 4.0] {
        let given = with(&surface(0.5, 0.3, 12.0), &[(Moving, k), (SpeedLimit, 1e-6)]);
        near(value::<MeanVelocity>(&given), k * 1e-6 / 12.0, 1e-8);
    }
    // ... so the largest k that works is the fastest: k/N < mu_S/(mu_S + mu_C).
    let fastest = (1..12).map(f64::from).max_by(|a, b| {
        let v = |k| {
            let v = value::<MeanVelocity>(&with(
                &surface(0.5, 0.3, 12.0),
                &[(Moving, k), (SpeedLimit, 1e-4)],
            ));
            if v.is_nan() { 0.0 } else { v }
        };
        v(*a).total_cmp(&v(*b))
    });
    assert_eq!(fastest, Some((12.0f64 * 0.5 / 0.8).floor()));
}

#[test]
fn work_and_power() {
    near(value::<CostOfTransport>(&surface(0.5, 0.3, 4.0)), 1.5, 1e-15);
    for d in designs(100) {
        let [_, mu_coulomb, slope, _] = d;
        let (s, c) = slope.to_radians().sin_cos();
        for k in [1.0, 2.0] {
            let given = with(&design(d), &[(Segments, 80.0), (Moving, k)]);
            let v = value::<MeanVelocity>(&given);
            if v.is_nan() {
                continue;
            }
            let (a, force) = (value::<Acceleration>(&given), value::<AnchorCapacity>(&given));
            let cost = value::<CostOfTransport>(&given);
            near(cost, force / (k * MG), 1e-13);
            assert!(cost > mu_coulomb * c + s, "below the quasi-static floor");
            near(value::<MeanPower>(&given), cost * 80.0 * MG * v, 1e-13);
            near(value::<PeakPower>(&given), force / k * (2.0 * a * 0.02).sqrt(), 1e-13);
            near(value::<ImpactLoss>(&given), M * a * 0.02, 1e-13);
            let crawl = with(&given, &[(SpeedLimit, 1e-7)]);
            near(value::<CostOfTransport>(&crawl), mu_coulomb * c + s, 1e-6);
        }
    }
}

#[test]
fn cycle_time_is_shortest_where_derived() {
    for (mu_static, mu_coulomb) in [(0.5, 0.3), (0.4, 0.4), (0.9, 0.1)] {
        let best = 2.0 + 2.0 * mu_coulomb / mu_static;
        let time = |n: f64| value::<CycleTime>(&surface(mu_static, mu_coulomb, n));
        assert!(time(best) < time(best * 1.001) && time(best) < time(best * 0.999));
        // Far beyond it grows like the root of N.
        near(time(4e8) / time(1e8), 2.0, 1e-7);
    }
}

#[test]
fn robots_in_pipes() {
    let corner = |beta| with(&surface(0.5, 0.3, 4.0), &[(CornerDeg, beta)]);
    let force = |beta| value::<AnchorCapacity>(&corner(beta));
    shows(force(45.0) / force(0.0), "1.41421");
    near(force(45.0), 2f64.sqrt() * 3.0 * 0.5 * MG, 1e-15);
    near(force(60.0), 2.0 * force(0.0), 1e-15);

    for (n, k) in [(4.0, 1.0), (9.0, 2.0), (12.0, 3.0)] {
        for (mu_static, mu_coulomb) in [(0.5, 0.3), (0.8, 0.1)] {
            let base = with(&surface(mu_static, mu_coulomb, n), &[(Moving, k), (SlopeDeg, 90.0)]);
            let whole = n * MG / ((n - k) * mu_static - k * mu_coulomb);
            let released = n * MG / ((n - k) * mu_static);
            for (release, needed) in [(0.0, whole), (1.0, released)] {
                let given = with(&base, &[(WallRelease, release)]);
                near(value::<Preload>(&given), needed, 1e-14);
                let moves =
                    |share: f64| value::<Feasible>(&with(&given, &[(WallForce, share * needed)]));
                assert_eq!((moves(1.0 - 1e-12), moves(1.0 + 1e-12)), (0.0, 1.0));
            }
        }
    }
    assert_eq!(value::<Preload>(&surface(0.5, 0.3, 4.0)), 0.0);
    let weak = with(&surface(0.1, 0.5, 4.0), &[(SlopeDeg, 90.0)]);
    assert_eq!(status::<Preload>(&weak), Status::AnchorsTooWeak);
    assert!(value::<Preload>(&weak).is_nan());
}

#[test]
fn a_directional_skin_changes_the_anchors_only() {
    for (mu_static, ratio) in [(0.5, 2.0), (0.125, 4.0), (0.25, 0.5)] {
        let skin = with(&surface(mu_static, 0.1, 6.0), &[(SkinRatio, ratio)]);
        let plain = surface(mu_static * ratio, 0.1, 6.0);
        assert_eq!(value::<MeanVelocity>(&skin), value::<MeanVelocity>(&plain));
        assert_eq!(value::<OptimalSegments>(&skin), value::<OptimalSegments>(&plain));
        assert_eq!(value::<SlopeLimitDeg>(&skin), value::<SlopeLimitDeg>(&plain));
    }
}

#[test]
fn sensitivity_of_the_optimum() {
    let optimum = |mu_static, mu_coulomb, tangent: f64| {
        let slope = [(SlopeDeg, tangent.atan().to_degrees())];
        value::<OptimalSegments>(&with(&surface(mu_static, mu_coulomb, 1.0), &slope))
    };
    for (s, c, t) in [(0.5, 0.3, 0.1), (0.9, 0.2, 0.3), (0.3, 0.15, 0.05)] {
        let h = 1e-6;
        let slope = |f: &dyn Fn(f64) -> f64, x: f64| (f(x + h) - f(x - h)) / (2.0 * h);
        near(slope(&|c| optimum(s, c, t), c), 2.0 / (s - t), 1e-7);
        near(slope(&|s| optimum(s, c, t), s), -2.0 * (c + t) / (s - t).powi(2), 1e-7);
        near(slope(&|t| optimum(s, c, t), t), 2.0 * (s + c) / (s - t).powi(2), 1e-7);
    }
}

// Limits.

#[test]
fn one_segment_cannot_move() {
    let given = surface(0.5, 0.3, 1.0);
    assert!(value::<MeanVelocity>(&given).is_nan());
    for status in [
        status::<AnchorCapacity>(&given),
        status::<Acceleration>(&given),
        status::<MeanVelocity>(&given),
        status::<SlipRatio>(&given),
        status::<Preload>(&given),
    ] {
        assert_eq!(status, Status::NothingAnchored);
    }
}

#[test]
fn no_friction_and_much_of_it() {
    let none = surface(0.0, 0.0, 4.0);
    assert!(value::<Acceleration>(&none).is_nan() && value::<OptimalSegments>(&none).is_nan());
    let slick = surface(0.5, 0.0, 4.0);
    assert_eq!(value::<OptimalSegments>(&slick), 2.0);
    assert_eq!(value::<BestSegments>(&slick), 2.0);
    near(value::<Acceleration>(&slick), 3.0 * 0.5 * G, 1e-15);
    assert_eq!(value::<Resistance>(&slick), 0.0);
    let rough = surface(1000.0, 0.3, 4.0);
    near(value::<OptimalSegments>(&rough), 2.0, 1e-3);
    near(value::<Acceleration>(&rough), 3000.0 * G - 0.3 * G, 1e-15);
    near(value::<SlopeLimitDeg>(&rough), 90.0, 1e-3);
}

#[test]
fn a_vertical_wall_without_preload() {
    for w in [0.0, 1.0] {
        let given = with(&surface(0.5, 0.3, 4.0), &[(SlopeDeg, 90.0), (AnchorWeight, w)]);
        assert!(value::<AnchorCapacity>(&given).is_nan());
        assert_eq!(status::<Acceleration>(&given), Status::SlidesBack);
        assert_eq!(value::<Resistance>(&given), MG);
    }
}

#[test]
fn gravity_off() {
    let given = with(&surface(0.5, 0.3, 4.0), &[(Gravity, 0.0), (WallForce, 2.0)]);
    near(value::<AnchorCapacity>(&given), 3.0, 1e-15);
    near(value::<Acceleration>(&given), (3.0 - 0.6) / M, 1e-15);
    assert!(value::<CostOfTransport>(&given).is_nan());
    assert_eq!(status::<CostOfTransport>(&given), Status::Unbounded);
    assert_eq!(value::<SlopeLimitDeg>(&given), 90.0);
}

#[test]
fn little_viscosity_is_none() {
    for d in designs(100) {
        for brake in [0.0, 1.0] {
            for limit in [f64::INFINITY, 0.05] {
                let more = [(Segments, 90.0), (Brake, brake), (SpeedLimit, limit)];
                let dry = with(&design(d), &more);
                if value::<MeanVelocity>(&dry).is_nan() {
                    continue;
                }
                for viscous in [1e-300, 1e-18, 1e-14] {
                    let wet = with(&dry, &[(Viscous, viscous)]);
                    near(value::<PhaseTime>(&wet), value::<PhaseTime>(&dry), 1e-14);
                    near(value::<PeakSpeed>(&wet), value::<PeakSpeed>(&dry), 1e-14);
                    near(value::<MeanPower>(&wet), value::<MeanPower>(&dry), 1e-13);
                }
            }
        }
    }
}

#[test]
fn far_limits_do_not_matter() {
    for d in designs(100) {
        let free = with(&design(d), &[(Segments, 40.0)]);
        let far = with(&free, &[(SpeedLimit, 1e12), (DriveLimit, 1e12)]);
        let ahead = with(&free, &[(AnchorsAhead, 17.0)]);
        for brake in [0.0, 1.0] {
            for viscous in [0.0, 2.0] {
                let more = [(Brake, brake), (Viscous, viscous)];
                let v = value::<MeanVelocity>(&with(&free, &more));
                let same = |other: &[(ParamId, f64)]| value::<MeanVelocity>(&with(other, &more));
                assert_eq!(v.to_bits(), same(&far).to_bits());
                if !v.is_nan() {
                    near(same(&ahead), v, 1e-12);
                }
            }
        }
    }
}

/// Right below the speed that viscosity allows, the limit binds while the
/// logarithm in the phase time runs away.
#[test]
fn a_speed_limit_at_the_viscous_limit() {
    for viscous in [1.0, 30.0, 1e3, 1e6] {
        let free = with(&surface(0.5, 0.3, 4.0), &[(Viscous, viscous)]);
        let (time, peak) = (value::<PhaseTime>(&free), value::<PeakSpeed>(&free));
        let mut limit = peak;
        for _ in 0..50 {
            limit = limit.next_down();
            let limited = value::<PhaseTime>(&with(&free, &[(SpeedLimit, limit)]));
            near(limited, time, 1e-13);
        }
    }
}

// Symmetry and scaling.

#[test]
fn friction_is_odd_in_speed() {
    let mut random = Random(8);
    for _ in 0..1000 {
        let v = random.log(1e-9, 1e6);
        let at = |v| [(MuCoulomb, 0.3), (Viscous, 0.7), (SlopeDeg, 12.0), (Speed, v)];
        assert_eq!(value::<FrictionForce>(&at(v)), -value::<FrictionForce>(&at(-v)));
        near(value::<FrictionForce>(&at(v)), 0.3 * MG * 12f64.to_radians().cos() + 0.7 * v, 1e-14);
    }
    let rest = [(MuCoulomb, 0.3), (Speed, 0.0)];
    assert!(value::<FrictionForce>(&rest).is_nan());
    assert_eq!(status::<FrictionForce>(&rest), Status::SetValued);
}

/// Factors by which a scaled robot's parameters and quantities change.
struct Scale {
    mass: f64,
    length: f64,
    time: f64,
}

impl Scale {
    fn of(&self, unit: &str) -> f64 {
        let speed = self.length / self.time;
        let force = self.mass * speed / self.time;
        match unit {
            "1" | "deg" => 1.0,
            "kg" => self.mass,
            "m" => self.length,
            "s" => self.time,
            "m/s" => speed,
            "m/s^2" => speed / self.time,
            "N" => force,
            "J" => force * self.length,
            "W" => force * speed,
            "N s/m" => force / speed,
            other => panic!("unit {other} has no scale"),
        }
    }
}

fn scales_exactly<Q: Quantity>(given: Given) {
    let expected = value::<Q>(given);
    for (mass, length, time) in
        [(2.0, 1.0, 1.0), (1.0, 4.0, 1.0), (1.0, 1.0, 0.5), (8.0, 0.25, 4.0)]
    {
        let scale = Scale { mass, length, time };
        let scaled: Vec<_> =
            given.iter().map(|(id, v)| (*id, v * scale.of(id.param().unit))).collect();
        let got = value::<Q>(&scaled) / scale.of(Q::INFO.unit);
        let name = Q::INFO.name;
        assert_eq!(got.to_bits(), expected.to_bits(), "{name}: {got} for {expected} at {given:?}");
    }
}

#[test]
fn powers_of_two_scale_without_rounding() {
    let mut random = Random(10);
    for _ in 0..400 {
        let k = random.whole(1, 4);
        let optional = |random: &mut Random, low, high, none: f64| {
            if random.one_in(2) { none } else { random.log(low, high) }
        };
        let given = [
            (MuStatic, random.log(0.1, 2.0)),
            (MuCoulomb, random.log(0.02, 1.0)),
            (Moving, k),
            (Segments, k + random.whole(1, 30)),
            (SlopeDeg, random.between(-10.0, 30.0)),
            (AnchorWeight, random.unit()),
            (Mass, random.log(0.01, 10.0)),
            (Gravity, random.log(1.0, 20.0)),
            (Stroke, random.log(1e-3, 1.0)),
            (Viscous, optional(&mut random, 0.01, 100.0, 0.0)),
            (DriveLimit, optional(&mut random, 0.1, 100.0, f64::INFINITY)),
            (SpeedLimit, optional(&mut random, 1e-3, 10.0, f64::INFINITY)),
            (WallForce, optional(&mut random, 0.1, 100.0, 0.0)),
            (WallRelease, random.unit()),
            (AnchorsAhead, random.whole(0, 1)),
            (Brake, random.whole(0, 1)),
            (CoulombTerm, random.whole(0, 1)),
            (Time, random.log(1e-3, 10.0)),
            (Speed, random.between(-1.0, 1.0)),
            (SegmentsMax, 200.0),
        ];
        macro_rules! each {
            ($($quantity:ident),+ $(,)?) => { $(scales_exactly::<$quantity>(&given);)+ };
        }
        locosweep::for_each_quantity!(each);
    }
}

// The best count.

/// Smallest count within the tie margin of the highest velocity, by trying all.
fn tried(given: Given, low: u32, high: u32) -> Option<f64> {
    let v = |n: u32| value::<MeanVelocity>(&with(given, &[(Segments, f64::from(n))]));
    let all: Vec<f64> = (low..=high).map(v).collect();
    let most = all.iter().copied().filter(|v| !v.is_nan()).fold(f64::NAN, f64::max);
    let first = all.iter().position(|v| *v >= most * (1.0 - TIE));
    first.map(|i| f64::from(low) + i as f64)
}

fn best_is_tried(given: &[(ParamId, f64)], low: u32, high: u32) -> bool {
    let bounds = [(SegmentsMin, f64::from(low)), (SegmentsMax, f64::from(high))];
    let given = with(given, &bounds);
    let expected = tried(&given, low, high);
    let best = value::<BestSegments>(&given);
    match expected {
        Some(n) => {
            let v = value::<MeanVelocity>(&with(&given, &[(Segments, n)]));
            assert_eq!(best, n, "brute force against the search at {given:?}");
            assert_eq!(value::<BestVelocity>(&given).to_bits(), v.to_bits());
        }
        None => {
            assert!(best.is_nan(), "{best} where nothing moves: {given:?}");
            let why = status::<BestSegments>(&given);
            assert!(!matches!(why, Status::Ok | Status::NotFinite), "{why:?} at {given:?}");
        }
    }
    expected.is_some()
}

fn limited_design(random: &mut Random, slope: (f64, f64)) -> Vec<(ParamId, f64)> {
    let k = random.whole(1, 5);
    let mut given = vec![
        (MuStatic, random.log(0.1, 2.0)),
        (MuCoulomb, random.log(0.02, 1.0)),
        (Moving, k),
        (SlopeDeg, random.between(slope.0, slope.1)),
        (AnchorWeight, random.whole(0, 1)),
    ];
    if random.one_in(2) {
        given.push((Viscous, random.log(0.01, 300.0)));
    }
    if random.one_in(2) {
        given.push((DriveLimit, k * random.log(0.3, 30.0)));
    }
    if random.one_in(2) {
        given.push((SpeedLimit, random.log(1e-3, 1.0)));
    }
    if random.one_in(2) {
        given.push((WallForce, random.log(0.1, 30.0)));
        given.push((WallRelease, random.unit()));
    }
    given
}

#[test]
fn best_count_without_limits() {
    let mut random = Random(12);
    let mut found = 0;
    for _ in 0..1500 {
        let given = [
            (MuStatic, random.log(0.1, 2.0)),
            (MuCoulomb, random.log(0.02, 1.0)),
            (Moving, random.whole(1, 5)),
            (SlopeDeg, random.between(0.0, 30.0)),
            (AnchorWeight, random.whole(0, 1)),
        ];
        let (low, high) = (random.whole(1, 20) as u32, random.whole(20, 300) as u32);
        let plain = Point::of(&with(
            &given,
            &[(SegmentsMin, f64::from(low)), (SegmentsMax, f64::from(high))],
        ));
        assert_eq!(
            BestSegments::value::<f64, true>(&plain).to_bits(),
            BestSegments::value::<f64, false>(&plain).to_bits(),
            "both kernels at {given:?}, {low} to {high}"
        );
        found += usize::from(best_is_tried(&given, low, high));
    }
    assert!(found > 1000, "only {found} designs move");
}

#[test]
fn best_count_with_limits() {
    let mut random = Random(14);
    let mut found = 0;
    for _ in 0..2500 {
        let mut given = limited_design(&mut random, (-10.0, 30.0));
        // Braking down-hill has a test of its own.
        if random.one_in(2) && given[3].1 >= 0.0 {
            given.push((Brake, 1.0));
        }
        let (low, high) = (random.whole(1, 20) as u32, random.whole(20, 300) as u32);
        found += usize::from(best_is_tried(&given, low, high));
    }
    assert!(found > 1000, "only {found} designs move");
}

#[test]
fn best_count_with_anchors_ahead() {
    let mut random = Random(16);
    let mut found = 0;
    for _ in 0..1500 {
        let mut given = limited_design(&mut random, (0.0, 30.0));
        given.push((AnchorsAhead, random.whole(1, 12)));
        given.push((DriveLimit, given[2].1 * random.log(0.3, 30.0)));
        let (low, high) = (random.whole(1, 20) as u32, random.whole(20, 300) as u32);
        found += usize::from(best_is_tried(&given, low, high));
    }
    assert!(found > 400, "only {found} designs move");
}

#[test]
fn best_count_when_braking_down_hill() {
    let mut random = Random(18);
    let mut found = 0;
    for _ in 0..1500 {
        let mut given = limited_design(&mut random, (-30.0, 0.0));
        given.push((Brake, 1.0));
        let (low, high) = (random.whole(1, 20) as u32, random.whole(20, 300) as u32);
        found += usize::from(best_is_tried(&given, low, high));
    }
    assert!(found > 400, "only {found} designs move");
}

#[test]
fn crossed_bounds_of_the_count_have_no_value() {
    for limit in [f64::INFINITY, 100.0] {
        let more = [(SegmentsMin, 9.0), (SegmentsMax, 5.0), (DriveLimit, limit)];
        let p = Point::of(&with(&surface(0.5, 0.3, 4.0), &more));
        assert!(BestSegments::value::<f64, false>(&p).is_nan());
        if limit.is_infinite() {
            assert!(BestSegments::value::<f64, true>(&p).is_nan(), "the plain kernel differs");
        }
        assert_ne!(BestSegments::status(&p), Status::NotFinite, "no reason given");
    }
}

/// Near a large optimum many neighbours tie within the margin: both kernels
/// must agree on which is the lowest.
#[test]
fn large_counts_agree() {
    for optimum in [1e3, 1e5, 3e5, 4e5, 4.9e5] {
        let given = with(&surface(0.5, 0.25 * optimum - 0.5, 1.0), &[(SegmentsMax, 5e5)]);
        near(value::<OptimalSegments>(&given), optimum, 1e-14);
        let p = Point::of(&given);
        let (general, plain) =
            (BestSegments::value::<f64, false>(&p), BestSegments::value::<f64, true>(&p));
        assert_eq!(general, plain, "optimum {optimum}");
    }
}

#[test]
fn ties_go_to_the_lower_count() {
    // v(N) = v(N+1) exactly where mu_C/mu_S = N(N+1)/(2N+1) - 1.
    for n in 2..60 {
        let n = f64::from(n);
        for mu_static in [0.3, 0.5, 0.7, 1.1] {
            let mu_coulomb = mu_static * (n * (n + 1.0) / (2.0 * n + 1.0) - 1.0);
            let given = surface(mu_static, mu_coulomb, 1.0);
            let v = |n| value::<MeanVelocity>(&with(&given, &[(Segments, n)]));
            near(v(n), v(n + 1.0), TIE);
            assert_eq!(value::<BestSegments>(&given), n);
            let p = Point::of(&given);
            assert_eq!(BestSegments::value::<f64, true>(&p), n);
        }
    }
}
