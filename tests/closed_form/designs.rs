//! Results that hold for every design.

use super::*;

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
