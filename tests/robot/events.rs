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

#[test]
fn strokes_end_while_a_robot_falls_down_a_pipe() {
    // The walls hold 2 % too little: each phase has its time, whatever the robot falls.
    let wall = 0.98 * 5.0 * MG / 2.0;
    let ground = [(SlopeDeg, 90.0), (WallForce, wall), (WallRelease, 1.0)];
    let drive = [(DriveLimit, 30.0), (SpeedLimit, 0.01), (Dwell, 0.05), (Cycles, 1.0)];
    let run = [(Segments, 5.0), (Moving, 1.0), (MuStatic, 0.5), (MuCoulomb, 0.3)];
    let falls = tally(Gait::Concertina, &with(&run, &with(&ground, &drive)));
    assert_eq!(falls.status(), Status::Ok);
    near(falls.time, 5.0 * (STROKE / 0.01 + 0.05), 1e-3);
    // All walls together hold back no more than a = g - mu_C Q/m.
    assert!(falls.advance < -0.5 * (G - 0.3 * wall / M) * falls.time * falls.time);
    assert!(falls.residual.abs() < 1e-9 * falls.friction, "{}", falls.residual);
}

#[test]
fn a_fall_beyond_the_digits_of_a_stroke_has_no_value() {
    // A day of free fall: what the joints do is lost beside the way.
    let ground = [(SlopeDeg, 90.0), (WallForce, 0.1), (WallRelease, 1.0)];
    let drive = [(DriveLimit, 30.0), (SpeedLimit, 1e-6), (Cycles, 1.0)];
    let given = with(&dry(5.0), &with(&ground, &drive));
    assert_eq!(tally(Gait::Concertina, &given).status(), Status::Unresolved);
}
