//! The best count as a real number, with what slows a phase.

use super::*;

fn optimum(given: Given) -> f64 {
    value::<OptimalSegments>(given)
}

#[test]
fn a_brake_moves_the_optimum() {
    near(optimum(&with(&surface(0.4, 0.4, 4.0), &[(Brake, 1.0)])), 2.0 + 2f64.sqrt(), 1e-14);
    shows(optimum(&with(&surface(0.5, 0.3, 4.0), &[(Brake, 1.0)])), "2.740");
    let mut random = Random(21);
    for _ in 0..500 {
        let k = random.whole(1, 5);
        let given = [
            (MuStatic, random.log(0.2, 2.0)),
            (MuCoulomb, random.log(0.02, 1.0)),
            (Moving, k),
            (SlopeDeg, random.between(0.0, 10.0)),
            (AnchorWeight, random.unit()),
            (Brake, 1.0),
        ];
        let p = Point::of(&given);
        let (hold, drag) = (p.hold(), p.drag());
        let grip = hold + 2.0 * p.anchor_pull();
        let x = optimum(&given) / k - 1.0;
        let terms = [
            hold * grip * x * x * x,
            (2.0 * (hold - grip) * drag - hold * grip) * x * x,
            -3.0 * drag * drag * x,
            -drag * drag,
        ];
        let sum: f64 = terms.iter().sum();
        let size: f64 = terms.iter().map(|t| t.abs()).sum();
        assert!(sum.abs() < 1e-13 * size, "{sum} of {size} at {given:?}");
    }
}

/// No count is faster, near or far; whole ones lie on either side.
#[test]
fn no_count_is_faster_than_the_optimum() {
    let mut random = Random(22);
    let (mut found, mut moved) = (0, 0);
    for _ in 0..1500 {
        let k = random.whole(1, 5);
        let mut given = vec![
            (MuStatic, random.log(0.1, 2.0)),
            (MuCoulomb, random.log(0.02, 1.0)),
            (Moving, k),
            (SlopeDeg, random.between(-15.0, 25.0)),
            (AnchorWeight, random.unit()),
            (Brake, random.whole(0, 1)),
        ];
        let extras = [
            (Viscous, random.log(0.01, 300.0)),
            (DriveLimit, k * random.log(0.3, 30.0)),
            (SpeedLimit, random.log(1e-3, 1.0)),
            (AnchorsAhead, random.whole(1, 6)),
        ];
        given.extend(extras.into_iter().filter(|_| random.one_in(2)));
        let v = |n: f64| value::<MeanVelocity>(&with(&given, &[(Segments, n)]));
        let best = optimum(&given);
        if best.is_nan() {
            let why = status::<OptimalSegments>(&given);
            assert!(!matches!(why, Status::Ok | Status::NotFinite), "{why:?} at {given:?}");
            let best = value::<BestSegments>(&with(&given, &[(SegmentsMax, 1e4)]));
            // Without an optimum the fewest that leave an anchor are best, if any move.
            assert!(best.is_nan() || best == k + 1.0, "{best} at {given:?}");
            continue;
        }
        found += 1;
        let most = v(best);
        assert!(most > 0.0, "no speed at {best} for {given:?}");
        for i in -100..100 {
            let far = best * 1.08f64.powi(i);
            let near = best * (1.0 + 1e-6 * f64::from(i));
            for n in [far, near] {
                let faster = v(n) > most * (1.0 + 1e-12);
                assert!(!faster, "{n} is faster than {best}: {given:?}");
            }
        }
        let whole = value::<BestSegments>(&with(&given, &[(SegmentsMax, 5e5)]));
        if best < 1e5 && !whole.is_nan() {
            let near = (whole - best).abs() < 1.0 + 1e-6 * best || v(whole) >= v(whole - 1.0);
            assert!(near, "{whole} beside {best} at {given:?}");
        }
        let bare: Vec<_> = given[..5].to_vec();
        moved += usize::from((optimum(&bare) - best).abs() > 1e-3 * best);
    }
    assert!(found > 700 && moved > 350, "{found} found, {moved} moved by what slows a phase");
}

#[test]
fn limits_that_do_not_act_leave_the_bits() {
    for d in super::designs(100) {
        let [mu_static, mu_coulomb, slope, w] = d;
        let bare = vec![
            (MuStatic, mu_static),
            (MuCoulomb, mu_coulomb),
            (SlopeDeg, slope),
            (AnchorWeight, w),
        ];
        let far = with(&bare, &[(DriveLimit, 1e6), (SpeedLimit, 1e6)]);
        assert_eq!(optimum(&far).to_bits(), optimum(&bare).to_bits());
    }
}

#[test]
fn the_papers_drive_wants_two_segments() {
    // 0.85 N: anchors hold more from N - 1 = 0.639 on.
    let given = with(&surface(0.5, 0.3, 4.0), &[(DriveLimit, 0.85)]);
    near(optimum(&given), 1.0 + 0.85 / (0.5 * MG), 1e-12);
    let weak = with(&surface(0.5, 0.4, 4.0), &[(DriveLimit, 0.85)]);
    assert_eq!(status::<OptimalSegments>(&weak), Status::DriveTooWeak);
    assert!(optimum(&weak).is_nan());
}

#[test]
fn slip_beside_what_its_formula_leaves_out_is_refused() {
    let slips = with(&surface(0.5, 0.3, 4.0), &[(DriveLimit, 5.0)]);
    let holds = with(&surface(0.5, 0.3, 4.0), &[(DriveLimit, 3.0)]);
    for extra in [(Brake, 1.0), (Viscous, 0.5), (SpeedLimit, 0.1)] {
        assert!(value::<SlipRatio>(&with(&slips, &[extra])).is_nan());
        assert_eq!(status::<SlipRatio>(&with(&slips, &[extra])), Status::NoClosedForm);
        assert_eq!(status::<NetAdvance>(&with(&slips, &[extra])), Status::NoClosedForm);
        assert_eq!(value::<SlipRatio>(&with(&holds, &[extra])), 0.0);
    }
    // The joint opens at 15.507 + 3.207 m/s^2 over 20 mm: 0.865 m/s at its end.
    assert!(value::<SlipRatio>(&with(&slips, &[(SpeedLimit, 0.87)])) > 0.0);
}
