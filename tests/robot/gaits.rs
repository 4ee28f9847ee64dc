//! The paper's robot, the registry of gaits, and what has no value.

use super::*;

#[test]
fn the_rear_stands_still_below_the_anchoring_capacity() {
    for (mu_static, mu_coulomb) in [(0.5, 0.3), (0.3, 0.15)] {
        for limit in [0.85, 0.99 * 3.0 * mu_static * MG, 1.01 * 3.0 * mu_static * MG] {
            let part = Segment { mu_static, mu_coulomb, ..segment() };
            let run =
                once(&robot(vec![part; 4], ideal(limit, f64::INFINITY)), &head_phase(4), &OPTIONS);
            let holds = limit < 3.0 * mu_static * MG;
            assert_eq!(run.slip[3] == 0.0, holds, "{limit}");
            assert_eq!(run.anchor_safety > 1.0, holds);
            near(run.propulsive_mean, limit, 1e-12);
        }
    }
    near(PAPER_MOTOR.stall_force(), 0.85, 1e-15);
}

#[test]
fn three_surfaces_of_the_paper() {
    // Dry, oiled, and lubricated with more viscosity: nearly the same way, the
    // lubricated one later, the power nearly the same.
    let head = |viscous: f64| {
        let part = Segment { mu_static: 0.3, mu_coulomb: 0.15, viscous, ..segment() };
        let mut robot = robot(vec![part; 4], ideal(0.85, f64::INFINITY));
        robot.motor = PAPER_MOTOR;
        let mut trace = Trace::new(1e-3);
        let schedule = head_phase(4);
        let plan = Plan { schedule: &schedule, cycles: 1 };
        (simulate(&robot, &plan, &OPTIONS, &mut trace), trace)
    };
    let ((dry, on_dry), (oiled, _), (late, lubricated)) = (head(0.0), head(0.2), head(0.5));
    assert!(dry.time < oiled.time && oiled.time < late.time && late.time < 1.1 * dry.time);
    for run in [&dry, &oiled, &late] {
        near(run.advance, STROKE / 4.0, 1e-12);
        // At the voltage of the supply: U F/k_F, and the force falls with the speed.
        near(run.power_mean, 10.0 * run.propulsive_mean / 1.7, 1e-6);
        assert!(run.propulsive_mean > 0.95 * 0.85 && run.propulsive_mean < 0.85);
        assert_eq!(run.slip_max, 0.0);
    }
    let path = on_dry.segment(0);
    assert!(path.windows(2).all(|x| x[1] >= x[0]));
    assert!(lubricated.segment(0).iter().zip(&path).all(|(a, b)| a <= b));
}

// The registry, and what has no value.

#[test]
fn gaits_return_to_their_start_and_keep_within_a_stroke() {
    for gait in GAITS {
        assert_eq!(Gait::parse(gait.name()).unwrap(), *gait);
        for n in 2..=12usize {
            for k in 1..n {
                let schedule = gait.schedule(n, k).unwrap();
                let last = &schedule.phases[schedule.phases.len() - 1].target;
                for (j, last) in last.iter().enumerate() {
                    let each = || schedule.phases.iter().map(|p| p.target[j]);
                    let (low, high) =
                        (each().fold(f64::MAX, f64::min), each().fold(f64::MIN, f64::max));
                    assert!(high - low <= 1.0 + 1e-12, "{} {n} {k}", gait.name());
                    assert!((last - schedule.start[j]).abs() < 1e-12);
                }
                assert!(schedule.phases.iter().all(|p| p.moves.iter().any(|m| !m)));
                assert!(schedule.travel > 0.0);
            }
        }
        assert_eq!(gait.schedule(33, 2).unwrap_err(), Status::TooManySegments);
        assert_eq!(gait.schedule(1, 1).unwrap_err(), Status::NothingAnchored);
    }
    assert_eq!(Gait::Block.schedule(4, 4).unwrap_err(), Status::NothingAnchored);
    assert!(Gait::parse("concertin").unwrap_err().to_string().contains("concertina"));
    let window = Gait::Window.schedule(5, 2).unwrap();
    assert!((0..5).all(|i| window.phases.iter().filter(|p| p.moves[i]).count() == 2));
}

#[test]
fn concertina_in_a_vertical_pipe() {
    // Q >= N m g/((N - k) mu_S) where the movers release the wall.
    let needed = 4.0 * MG / (3.0 * 0.5);
    let climb = |wall: f64| {
        let pipe = [(SlopeDeg, 90.0), (WallForce, wall), (WallRelease, 1.0), (SpeedLimit, 1e-3)];
        // Gentle enough not to push the anchors off.
        let drive = [(DriveLimit, 1.5 * MG), (Cycles, 2.0), (MuCoulomb, 0.5)];
        tally(Gait::Concertina, &with(&dry(4.0), &with(&pipe, &drive)))
    };
    let holds = climb(2.0 * needed);
    near(holds.advance, STROKE, 1e-3);
    near(holds.potential, 4.0 * MG * 2.0 * holds.advance, 1e-9);
    let falls = climb(0.9 * needed);
    assert!(falls.status() != Status::Ok || falls.advance < 0.0, "{}", falls.advance);
    // The inchworm clamps with one segment only.
    let pipe = [(SlopeDeg, 90.0), (WallForce, 3.0 * MG / 0.5), (SpeedLimit, 1e-3), (Cycles, 2.0)];
    let drive = [(DriveLimit, 1.5 * MG), (Segments, 2.0)];
    let worm = tally(Gait::Inchworm, &with(&dry(4.0), &with(&pipe, &drive)));
    near(worm.last_advance, STROKE, 1e-3);
}

#[test]
fn what_cannot_run_says_why() {
    let status = |more: Given| tally(Gait::Block, &with(&dry(4.0), more)).status();
    assert_eq!(status(&[(DriveLimit, 0.5)]), Status::DriveTooWeak);
    assert_eq!(status(&[(Segments, 33.0)]), Status::TooManySegments);
    assert_eq!(status(&[(Moving, 4.0)]), Status::NothingAnchored);
    assert_eq!(status(&[]), Status::Unbounded);
    assert_eq!(status(&[(JointStiffness, 2e3)]), Status::NoPhaseTime);
    assert_eq!(status(&[(JointStiffness, 2e3), (Dwell, 0.1)]), Status::Ok);
    let mut mixed = robot(vec![segment(); 3], ideal(2.0, 0.1));
    mixed.joints[1].stiffness = 1e3;
    assert_eq!(once(&mixed, &head_phase(3), &OPTIONS).status(), Status::MixedJoints);
    // Static friction that the paper's model leaves out.
    assert_eq!(status(&[(DriveLimit, 0.85), (BreakAway, 1.0)]), Status::DriveTooWeak);
    assert_eq!(status(&[(DriveLimit, 0.85)]), Status::Ok);
}

#[test]
fn nothing_within_the_ranges_panics() {
    let mut random = Random(41);
    for i in 0..400 {
        let mut given: Vec<(ParamId, f64)> = Vec::new();
        for id in ParamId::all() {
            let (low, high) = id.param().range;
            let (low, high) = (low.max(-1e30), high.min(1e30));
            let edge = [low, high, id.param().default.unwrap_or(0.3)];
            let value = match random.whole(0, 5) as usize {
                i @ 0..=2 => edge[i].max(low),
                _ if low > 0.0 => {
                    (low.ln() + (high / low).ln() * random.unit()).exp().clamp(low, high)
                }
                _ => low + (high - low) * 10f64.powf(random.between(-30.0, 0.0)),
            };
            given.push((id, if id.param().integer { value.round() } else { value }));
        }
        given.extend([(Segments, random.whole(1, 5)), (Moving, random.whole(1, 3)), (Cycles, 1.0)]);
        let point = row(&given);
        let get = |id: ParamId| point[id.main()];
        let steps = (get(Stroke) / get(SpeedLimit)).max(get(Dwell)) / get(TimeStep);
        if get(JointStiffness).is_finite() && steps > 30.0 && steps < 1e9 {
            continue;
        }
        // Runs in steps may go on up to the limit of their number: one gait in turn.
        let stepped = get(JointStiffness).is_finite() || get(SupplyVoltage).is_finite();
        let gaits = if stepped { &GAITS[i % GAITS.len()..][..1] } else { GAITS };
        for gait in gaits {
            let run = gait_tally(*gait, &Values(point));
            assert!(run.status() != Status::Ok || run.advance.is_finite());
        }
    }
    let endless = [(TimeStep, 1e-12)];
    assert_eq!(tally(Gait::Single, &with(&servo(1.0), &endless)).status(), Status::TooManySteps);
}
