//! Limits.

use super::*;

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
