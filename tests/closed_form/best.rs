//! The best count.

use super::*;

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
