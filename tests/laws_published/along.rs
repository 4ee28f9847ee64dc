//! Friction that varies along the track.

use super::*;

/// Friction along the track, at no viscous part.
fn along(name: &str, values: &Values, x: f64) -> f64 {
    (law(name).resistance)(values, 1.0, &ContactState { x, ..ContactState::start(1.0) }, &NONE)
}

#[test]
fn spline_of_the_track_is_smooth_periodic_and_never_negative() {
    let ratios = [0.2, 1.7, 0.6, 1.1, 2.5, 0.9];
    let names = ["track_1", "track_2", "track_3", "track_4", "track_5", "track_6"];
    let track = |ratios: [f64; 6]| {
        let mut given = vec![("mu_static", 1.0), ("mu_coulomb", 1.0), ("track_length", 0.75)];
        given.extend(names.into_iter().zip(ratios));
        contact(1.0, &given)
    };
    let values = track(ratios);
    for k in -12..12i32 {
        let x = 0.125 * f64::from(k);
        close(along("track", &values, x), ratios[k.rem_euclid(6) as usize], 1e-13);
        // Slope and curvature meet at the knots.
        let h = 1e-4;
        let at = |i: i32| along("track", &values, x + f64::from(i) * h);
        let slopes = [(at(0) - at(-1)) / h, (at(1) - at(0)) / h];
        assert!((slopes[0] - slopes[1]).abs() < 0.1, "kink at {x}: {slopes:?}");
        let bends = [at(-2) - 2.0 * at(-1) + at(0), at(0) - 2.0 * at(1) + at(2)];
        let jump = (bends[0] - bends[1]) / (h * h);
        assert!(jump.abs() < 3.0, "curvature jumps at {x} by {jump}");
        for s in [0.01, 0.05, 0.11] {
            let (here, next) =
                (along("track", &values, x + s), along("track", &values, x + s + 0.75));
            close(next, here, 1e-12);
        }
    }
    // Just below zero the position rounds to the end of the track.
    close(along("track", &values, -1e-300), ratios[0], 1e-14);
    let spike = track([0.0, 0.0, 0.0, 9.0, 0.0, 0.0]);
    for k in 0..1000 {
        assert!(along("track", &spike, f64::from(k) * 1e-3) >= 0.0);
    }
    assert_eq!(along("track", &spike, 0.2), 0.0);
}

#[test]
fn ripple_and_patch_along_the_track() {
    let given = [
        ("mu_static", 1.0),
        ("mu_coulomb", 1.0),
        ("ripple_amplitude", 1.0),
        ("ripple_length", 0.5),
        ("patch_start", 0.25),
        ("patch_length", 0.5),
        ("patch_ratio", 3.0),
    ];
    for (x, force) in [(0.0, 2.0), (0.125, 4.0), (0.375, 0.0), (1e6 + 0.125, 4.0)] {
        assert_eq!(along("ripple", &contact(2.0, &given), x), force);
    }
    for (x, force) in [(0.2, 2.0), (0.25, 6.0), (0.74, 6.0), (0.75, 2.0), (-0.3, 2.0)] {
        assert_eq!(along("patch", &contact(2.0, &given), x), force);
    }
}
