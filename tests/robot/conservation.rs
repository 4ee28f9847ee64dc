//! Laws that no robot escapes.

use super::*;

#[test]
fn energy_of_ideal_robots_balances_to_rounding() {
    let mut random = Random(11);
    let mut ran = 0;
    for _ in 0..300 {
        let n = random.whole(2, 7) as usize;
        let robot = random_robot(&mut random, n, false);
        let (gait, schedule) = random_plan(&mut random, n);
        let options = random_options(&mut random);
        let run = simulate(&robot, &Plan { schedule: &schedule, cycles: 2 }, &options, &mut ());
        if run.status() == Status::DriveTooWeak {
            continue;
        }
        assert_eq!(run.status(), Status::Ok, "{}", gait.name());
        ran += 1;
        assert!(run.residual.abs() < 1e-10 * run.friction, "{} {}", gait.name(), run.residual);
        assert!(run.friction > 0.0 && run.kinetic >= 0.0 && run.impact > -1e-12);
    }
    assert!(ran > 150, "{ran}");
}

#[test]
fn energy_of_elastic_robots_is_never_made_from_nothing() {
    let mut random = Random(12);
    for _ in 0..200 {
        let n = random.whole(2, 7) as usize;
        let robot = random_robot(&mut random, n, true);
        let (gait, schedule) = random_plan(&mut random, n);
        let options = random_options(&mut random);
        let plan = Plan { schedule: &schedule, cycles: 2 };
        let run = simulate(&robot, &plan, &options, &mut ());
        assert_eq!(run.status(), Status::Ok, "{}", gait.name());
        let scale = run.work.abs() + run.friction;
        assert!(run.residual > -1e-12 * scale, "{} {}", gait.name(), run.residual);
        assert!(run.residual < 0.2 * scale, "{} {} {scale}", gait.name(), run.residual);
        let fine = RunOptions { time_step: options.time_step / 64.0, ..options };
        let fine = simulate(&robot, &plan, &fine, &mut ());
        assert!(fine.residual < 2e-3 * scale, "{} {} {scale}", gait.name(), fine.residual);
    }
}

#[test]
fn momentum_without_friction() {
    let mut random = Random(13);
    for elastic in [false, true] {
        for _ in 0..20 {
            let mut robot = random_robot(&mut random, 5, elastic);
            for s in &mut robot.segments {
                (s.mu_static, s.mu_coulomb, s.viscous, s.pull) = (0.0, 0.0, 0.0, 0.0);
            }
            let (_, schedule) = random_plan(&mut random, 5);
            let options = RunOptions { impact: 1.0, dwell: 0.05, ..OPTIONS };
            let mut trace = Trace::new(0.01);
            let plan = Plan { schedule: &schedule, cycles: 2 };
            let run = simulate(&robot, &plan, &options, &mut trace);
            assert_eq!(run.status(), Status::Ok);
            for i in 0..trace.len() {
                let momentum = |i: usize| {
                    let each =
                        robot.segments.iter().zip(&trace.v[5 * i..]).map(|(s, v)| s.mass * v);
                    each.sum::<f64>()
                };
                let size = trace.v[5 * i..5 * i + 5].iter().fold(0.0f64, |a, v| a.max(v.abs()));
                assert!(momentum(i).abs() < 1e-13 + 1e-11 * size, "{} {size}", momentum(i));
            }
        }
    }
}

#[test]
fn a_mirrored_robot_moves_as_in_a_mirror() {
    let mut random = Random(14);
    for elastic in [false, true] {
        for round in 0..60 {
            let n = random.whole(2, 6) as usize;
            let robot = random_robot(&mut random, n, elastic);
            let (gait, schedule) = random_plan(&mut random, n);
            let options = random_options(&mut random);
            let mut seen = robot.clone();
            seen.segments.reverse();
            seen.joints.reverse();
            for s in &mut seen.segments {
                s.pull = -s.pull;
                s.mu_static *= s.skin_ratio;
                s.mu_coulomb *= s.skin_ratio;
                s.skin_ratio = 1.0 / s.skin_ratio;
            }
            let image = schedule.mirrored();
            let run =
                |robot, schedule| simulate(robot, &Plan { schedule, cycles: 1 }, &options, &mut ());
            let (a, b) = (run(&robot, &schedule), run(&seen, &image));
            assert_eq!(a.status(), b.status());
            if a.status() == Status::Ok {
                let close = |a: f64, b: f64| (a - b).abs() < 1e-9 * (a.abs() + b.abs()) + 1e-10;
                assert!(
                    close(a.advance, -b.advance),
                    "{round} {} {} {}",
                    gait.name(),
                    a.advance,
                    b.advance
                );
                assert!(
                    close(a.friction, b.friction) && close(a.work, b.work) && close(a.time, b.time)
                );
            }
        }
    }
}

#[test]
fn units_do_not_matter() {
    let mut random = Random(15);
    // Powers of two scale every operation exactly.
    let (length, time, mass) = (4.0, 0.5, 8.0);
    let (speed, force) = (length / time, mass * length / (time * time));
    for elastic in [false, true] {
        for _ in 0..40 {
            let n = random.whole(2, 6) as usize;
            let robot = random_robot(&mut random, n, elastic);
            let (_, schedule) = random_plan(&mut random, n);
            let options = random_options(&mut random);
            let mut other = robot.clone();
            for s in &mut other.segments {
                s.mass *= mass;
                (s.pull, s.load, s.wall) = (s.pull * force, s.load * force, s.wall * force);
                s.viscous *= force / speed;
            }
            for j in &mut other.joints {
                (j.stroke, j.speed, j.limit) =
                    (j.stroke * length, j.speed * speed, j.limit * force);
                j.stiffness *= force / length;
                j.damping *= force / speed;
            }
            let scaled = RunOptions {
                time_step: options.time_step * time,
                dwell: options.dwell * time,
                ..options
            };
            let plan = Plan { schedule: &schedule, cycles: 2 };
            let a = simulate(&robot, &plan, &options, &mut ());
            let b = simulate(&other, &plan, &scaled, &mut ());
            assert_eq!(a.status(), b.status());
            if a.status() == Status::Ok {
                let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs() + 1e-13;
                assert!(
                    close(a.advance * length, b.advance),
                    "{} {}",
                    a.advance * length,
                    b.advance
                );
                assert!(
                    close(a.time * time, b.time) && close(a.friction * force * length, b.friction)
                );
            }
        }
    }
}
