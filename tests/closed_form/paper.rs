//! What the paper's text fixes.

use super::*;

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
