//! Work of elastic joints' drives whose force is at its limit.

use super::*;

const LIMIT: f64 = 2.0;
const STIFFNESS: f64 = 2e3;

/// Two segments, the rear one held firmly; this joint drives the head forward once.
fn push(joint: Joint<f64>, options: &RunOptions<f64>) -> GaitTally<f64> {
    let firm = Segment { wall: 100.0, ..segment() };
    once(&robot(vec![segment(), firm], joint), &head_phase(2), options)
}

fn elastic(limit: f64, speed: f64) -> Joint<f64> {
    Joint { stiffness: STIFFNESS, ..ideal(limit, speed) }
}

#[test]
fn a_drive_at_its_limit_works_along_the_joint() {
    // The command jumps and stays out of reach: a constant force all the way.
    let options = RunOptions { dwell: 0.05, ..OPTIONS };
    let run = push(elastic(LIMIT, f64::INFINITY), &options);
    let way = 2.0 * run.advance;
    let stored = LIMIT * LIMIT / (2.0 * STIFFNESS);
    near(way, (LIMIT - 0.3 * MG) / M * 0.05 * 0.05 / 2.0, 0.05);
    near(run.work, LIMIT * way + stored, 1e-12);
    near(run.elastic, stored, 1e-12);
    near(run.friction, 0.3 * MG * way, 1e-12);
    assert!(run.damping.abs() < 1e-15, "{}", run.damping);
    near(run.transport_cost, run.work / (2.0 * MG * run.advance), 1e-12);
}

#[test]
fn a_drive_that_moves_nothing_only_stretches_its_spring() {
    // Less than what holds the head. The command goes 20 mm, the spring 0.5 mm.
    let (limit, speed, damping) = (1.0, 0.02, 10.0);
    let joint = Joint { damping, ..elastic(limit, speed) };
    let options = RunOptions { time_step: 1e-5, break_away: 1.0, ..OPTIONS };
    let run = push(joint, &options);
    assert_eq!(run.advance, 0.0);
    near(run.elastic, limit * limit / (2.0 * STIFFNESS), 1e-12);
    // The damper takes its full force until both reach the limit, then what the spring leaves.
    let drag = damping * speed;
    let full = drag * (limit - drag) / STIFFNESS;
    near(run.damping, full + drag * drag / (2.0 * STIFFNESS), 1e-4);
    near(run.work, run.elastic + run.damping, 1e-12);
}

#[test]
fn stiff_drives_cost_what_ideal_ones_do() {
    // Slow by viscous friction, so that no momentum is left at the end of the stroke, and
    // driven at the limit all the way.
    let thick = Segment { viscous: 100.0, ..segment() };
    let firm = Segment { wall: 100.0, ..segment() };
    let run = |joint: Joint<f64>| {
        let options = RunOptions { time_step: 5e-5, dwell: 2.5, ..OPTIONS };
        once(&robot(vec![thick, firm], joint), &head_phase(2), &options)
    };
    let ideal = run(ideal(LIMIT, f64::INFINITY));
    near(ideal.work, LIMIT * STROKE, 1e-9);
    for speed in [f64::INFINITY, 0.1] {
        let cost = |stiffness: f64| {
            let run = run(Joint { stiffness, ..elastic(LIMIT, speed) });
            (run.transport_cost / ideal.transport_cost - 1.0).abs()
        };
        let (soft, stiff) = (cost(1e4), cost(1e6));
        assert!(stiff < 2e-4 && stiff < 0.1 * soft, "{soft} {stiff}");
    }
}

/// Elastic robots at random whose drives are often at their limit, half of them without a
/// speed limit; returns how many are.
fn never_made_from_nothing(seed: u64, count: usize) -> usize {
    let mut random = Random(seed);
    let mut limited = 0;
    for i in 0..count {
        let n = random.whole(2, 7) as usize;
        let mut robot = random_robot(&mut random, n, true);
        let jumps = random.one_in(2);
        for joint in &mut robot.joints {
            joint.limit = random.log(0.2, 20.0);
            joint.stiffness = random.log(100.0, 1e5);
            joint.speed = if jumps { f64::INFINITY } else { random.log(0.02, 1.0) };
        }
        let (gait, schedule) = random_plan(&mut random, n);
        let options = random_options(&mut random);
        let options = RunOptions { dwell: options.dwell + 0.01, ..options };
        let plan = Plan { schedule: &schedule, cycles: 2 };
        let mut run = simulate(&robot, &plan, &options, &mut ());
        if jumps && run.status() == Status::NoPhaseTime {
            // A wave has no rests, in which alone such a drive takes time.
            continue;
        }
        if run.status() == Status::EnergyOpen {
            // Stiff springs that jump ring faster than a long step resolves.
            let fine = RunOptions { time_step: options.time_step / 64.0, ..options };
            run = simulate(&robot, &plan, &fine, &mut ());
        }
        assert_eq!(run.status(), Status::Ok, "{i} {}", gait.name());
        // Springs that are stretched and let go again round even where nothing moves.
        let turned: f64 = robot.joints.iter().map(|j| j.limit * j.limit / j.stiffness).sum();
        let all = turned + run.work.abs() + run.friction + run.potential.abs();
        assert!(run.damping >= -1e-12 * all, "{i} {} {}", gait.name(), run.damping / all);
        let spent = run.friction + run.damping + run.kinetic + run.potential + run.elastic;
        assert!((run.work - spent - run.residual).abs() < 1e-12 * all, "{i}");
        assert!(run.residual > -1e-12 * all && run.residual < 0.5 * all, "{i} {}", run.residual);
        // What a motor draws beyond the work is heat.
        assert!(run.electric_energy >= run.work - 1e-12 * all, "{i}");
        let weakest = robot.joints.iter().fold(f64::INFINITY, |least, j| least.min(j.limit));
        limited += usize::from(run.actuator_peak >= weakest);
    }
    limited
}

#[test]
fn dampers_of_limited_drives_make_no_energy() {
    let limited = never_made_from_nothing(61, 300);
    assert!(limited > 200, "{limited}");
}

#[test]
#[ignore = "takes half a minute"]
fn dampers_of_many_limited_drives_make_no_energy() {
    let limited = never_made_from_nothing(62, 3000);
    assert!(limited > 2000, "{limited}");
}
