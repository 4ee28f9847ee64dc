//! Against the closed forms of phases and gaits.

use super::*;

#[test]
fn phase_times_and_mean_speed_of_the_papers_gait() {
    for limit in [0.85, 1.2, 1.3] {
        for n in [3.0, 4.0, 8.0] {
            for slope in [-5.0, 0.0, 5.0] {
                let angle = f64::to_radians(slope);
                if limit > MG * (0.5 * angle.cos() - angle.sin()) {
                    // A single anchor would slide back: not the closed form's case.
                    continue;
                }
                let given = with(&dry(n), &[(DriveLimit, limit), (SlopeDeg, slope)]);
                let run = tally(Gait::Single, &given);
                // An inner segment is driven by two joints, head and rear by one.
                let t = |ahead: f64| {
                    let given = with(&given, &[(AnchorsAhead, ahead)]);
                    closed_form::PhaseTime::value::<f64, false>(&Point::of(&given))
                };
                let (end, inner) = (t(0.0), t(1.0));
                if end.is_nan() {
                    assert_eq!(run.status(), Status::DriveTooWeak);
                    continue;
                }
                let time = 2.0 * end + (n - 2.0) * inner;
                near(run.time, 10.0 * time, 1e-12);
                near(run.advance, STROKE, 1e-12);
                near(run.velocity, STROKE / time, 1e-12);
                assert!(run.slip_max == 0.0, "{}", run.slip_max);
            }
        }
    }
}

#[test]
fn slip_case() {
    let strong = robot(vec![segment(); 4], ideal(5.0, f64::INFINITY));
    let mut trace = Trace::new(1.0);
    let schedule = head_phase(4);
    let run = simulate(&strong, &Plan { schedule: &schedule, cycles: 1 }, &OPTIONS, &mut trace);
    near(run.time, (2.0 * STROKE / (15.507_185_f64 + 3.207_062)).sqrt(), 1e-7);
    shows(1e3 * run.time, "46.2321");
    shows(1e3 * run.slip[1], "3.4274");
    shows(1e3 * run.slip[3], "3.4274");
    shows(run.anchor_safety, &format!("{:.9}", 3.0 * 0.5 * MG / 5.0));
    let mover = 4.0 * run.advance + 3.0 * run.slip[1];
    shows(1e3 * mover, "16.5726");
}

#[test]
fn first_phase_of_any_block_on_any_ground() {
    // Speed limit, viscous ground, skin, slope, wall and corner, one block that moves.
    let mut random = Random(3);
    let mut compared = 0;
    for _ in 0..400 {
        let n = random.whole(2, 9);
        let k = random.whole(1, n as u32 - 1);
        let given = with(
            &dry(n),
            &[
                (Moving, k),
                (SlopeDeg, random.between(-8.0, 12.0)),
                (DriveLimit, random.between(0.5, 6.0)),
                (
                    SpeedLimit,
                    if random.one_in(2) { random.between(0.02, 0.3) } else { f64::INFINITY },
                ),
                (Viscous, if random.one_in(2) { random.between(0.01, 5.0) } else { 0.0 }),
                (SkinRatio, random.between(1.0, 2.0)),
                (WallForce, random.between(0.0, 2.0)),
                (WallRelease, random.unit()),
                (CornerDeg, random.between(0.0, 45.0)),
                (Cycles, 1.0),
            ],
        );
        let point = Point::of(&given);
        let time = closed_form::PhaseTime::value::<f64, false>(&point);
        let safety = closed_form::AnchorSafety::value::<f64, false>(&point);
        if time.is_nan() || safety < 1.0 {
            continue;
        }
        let gait = Gait::Concertina;
        let all = gait.schedule(n as usize, k as usize).unwrap();
        let first = Schedule { phases: all.phases[..1].to_vec(), ..all };
        let robot = from_point(&given, n as usize);
        let run = once(&robot, &first, &OPTIONS);
        compared += 1;
        near(run.time, time, 1e-10);
        near(run.advance, k / n * STROKE, 1e-11);
        near(run.anchor_safety, safety, 1e-9);
        assert!(run.residual.abs() < 1e-13 + 1e-11 * run.work, "{} {}", run.residual, run.work);
    }
    assert!(compared > 60, "{compared}");
}

#[test]
fn windows_and_blocks_advance_by_what_moves() {
    for (n, k) in [(4, 1), (4, 2), (6, 2), (6, 3), (9, 3), (8, 2)] {
        // Slow and strong, but below what the anchors on either side hold.
        let limits = [(DriveLimit, 1.3 * f64::from(k)), (SpeedLimit, 0.05), (MuStatic, 5.0)];
        let given = with(&dry(f64::from(n)), &limits);
        let given = with(&given, &[(Moving, f64::from(k)), (Cycles, 3.0)]);
        let window = tally(Gait::Window, &given);
        let block = tally(Gait::Block, &given);
        near(window.advance, f64::from(k) * STROKE, 1e-12);
        near(block.advance, STROKE, 1e-12);
        assert_eq!((window.slip_max, block.slip_max), (0.0, 0.0));
        // Speed-limited: t = d/v + v/(2 a), the head's block on one joint, the rest on two.
        let point = |ahead: f64| Point::of(&with(&given, &[(AnchorsAhead, ahead)]));
        let t = |ahead: f64| closed_form::PhaseTime::value::<f64, false>(&point(ahead));
        let phases = f64::from(n / k);
        near(block.time / 3.0, 2.0 * t(0.0) + (phases - 2.0) * t(1.0), 1e-11);
        near(block.velocity, block.advance * 3.0 / block.time, 1e-12);
    }
}

#[test]
fn a_wave_travels_by_strain_times_wave_speed_on_perfect_anchors() {
    for (n, k) in [(4.0, 1.0), (6.0, 2.0), (7.0, 3.0)] {
        let given =
            with(&dry(n), &[(Moving, k), (MuStatic, 1e3), (SpeedLimit, 1e-4), (Cycles, 2.0)]);
        let schedule = Gait::Wave.schedule(n as usize, k as usize).unwrap();
        let run = tally(Gait::Wave, &given);
        near(run.last_advance, schedule.travel * STROKE, 1e-5);
        near(schedule.travel, 1.0 / (1.0 / k + (PI / k).sin() / PI), 1e-15);
        // Cycle: the fastest joint sets the pace.
        let pace: f64 = schedule.phases.iter().map(|p| p.pace).sum();
        near(run.time / 2.0, pace * STROKE / 1e-4, 1e-9);
    }
}

#[test]
fn a_robot_on_ideal_anchors_is_a_single_segment() {
    use locosweep::lane::exp::{path_factor, speed_factor};
    let viscous = 0.5;
    let head = Segment { viscous, mu_coulomb: 0.15, ..segment() };
    let anchor = Segment { mu_static: 1e3, ..segment() };
    let pair = robot(vec![head, anchor], ideal(1.595106, f64::INFINITY));
    let schedule =
        Schedule { start: vec![0.0], phases: vec![phase(2, &[100.0], 1.0, &[0])], travel: 0.0 };
    let mut trace = Trace::new(0.05);
    simulate(&pair, &Plan { schedule: &schedule, cycles: 1 }, &OPTIONS, &mut trace);
    assert!(trace.len() > 10);
    for (i, t) in trace.t.iter().enumerate() {
        let (a, x) = ((1.595106 - 0.15 * MG) / M, viscous / M * t);
        near(trace.v[2 * i], a * t * speed_factor(x), 1e-12);
        near(trace.x[2 * i], a * t * t * path_factor(x), 1e-12);
        assert_eq!((trace.x[2 * i + 1], trace.slide[2 * i + 1]), (0.0, 0));
    }
    // Physics of the paper's Figure 5 with the Coulomb term kept.
    shows(trace.v[2 * 20], "2.014565");
}
