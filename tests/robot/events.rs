//! Ideal joints from event to event where many events fall on one instant, or where
//! a robot falls so far that its lengths lose their digits.

use super::*;

/// All joints extend, all contract, under a limited force.
fn breathe(n: usize, limit: f64, speed: f64) -> GaitTally<f64> {
    let skin = Segment { skin_ratio: 3.0, mu_static: 0.3, ..segment() };
    let robot = robot(vec![skin; n], ideal(limit, speed));
    let phases = vec![phase(n, &vec![1.0; n - 1], 1.0, &[]), phase(n, &vec![0.0; n - 1], 1.0, &[])];
    let schedule = Schedule { start: vec![0.0; n - 1], phases, travel: 0.0 };
    let options = RunOptions { impact: 1.0, dwell: 1.0, break_away: 1.0, ..OPTIONS };
    simulate(&robot, &Plan { schedule: &schedule, cycles: 2 }, &options, &mut ())
}

#[test]
fn long_crawlers_run_at_any_drive_limit() {
    // Slow joints under forces far above friction: as if nothing limited them.
    for n in 11..=32 {
        let free = breathe(n, f64::INFINITY, 0.005);
        for limit in [10.0, 20.0, 50.0, 200.0] {
            let run = breathe(n, limit, 0.005);
            assert_eq!(run.status(), Status::Ok, "{n} segments at {limit} N");
            assert!(run.residual.abs() < 1e-10 * run.friction, "{n} {limit} {}", run.residual);
            // With one at rest between those that slide forward and backward.
            if limit >= 50.0 && n % 4 == 1 {
                near(run.last_advance, free.last_advance, 1e-3);
            }
        }
    }
}

#[test]
fn a_long_inchworm_runs_at_a_high_drive_limit() {
    let given = |limit: f64| {
        let ground = [(Segments, 12.0), (MuStatic, 0.3), (MuCoulomb, 0.3), (SkinRatio, 3.0)];
        let drive = [(DriveLimit, limit), (SpeedLimit, 0.005), (Cycles, 1.0)];
        tally(Gait::Inchworm, &with(&ground, &drive))
    };
    let run = given(50.0);
    assert_eq!(run.status(), Status::Ok);
    assert!(run.residual.abs() < 1e-10 * run.friction);
    near(run.advance, given(f64::INFINITY).advance, 1e-2);
}

#[test]
fn waves_of_long_robots_run() {
    for segments in 12..=32 {
        for limit in [5.0, 20.0, 80.0] {
            let drive = [(DriveLimit, limit), (SpeedLimit, 0.05), (Moving, 4.0), (Cycles, 1.0)];
            let run = tally(Gait::Wave, &with(&dry(f64::from(segments)), &drive));
            assert_eq!(run.status(), Status::Ok, "{segments} segments at {limit} N");
            assert!(run.residual.abs() < 1e-10 * run.friction, "{segments} {}", run.residual);
        }
    }
}
