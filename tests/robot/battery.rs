//! Robots at random, over all gaits and sizes, grounds, slopes up to the vertical
//! pipe, drives and joints: each has a value with a closed ledger, or says why not.

use super::*;

/// A robot as its parameters.
fn any_robot(random: &mut Random) -> (Gait, Vec<(ParamId, f64)>) {
    let gait = GAITS[random.whole(0, GAITS.len() as u32 - 1) as usize];
    let segments = random.whole(2, 32);
    let mu_coulomb = random.between(0.02, 0.6);
    let more = if random.one_in(3) { 1.0 } else { random.between(1.0, 2.0) };
    let mut given = vec![
        (Segments, segments),
        (Moving, random.whole(1, segments as u32 - 1).min(8.0)),
        (Mass, random.between(0.05, 0.6)),
        (MuCoulomb, mu_coulomb),
        (MuStatic, mu_coulomb * more),
        (Stroke, random.between(0.005, 0.04)),
        (Cycles, random.whole(1, 2)),
        (Impact, random.whole(0, 1)),
        (BreakAway, random.whole(0, 1)),
        (DriveLimit, random.log(0.5, 80.0)),
        (SpeedLimit, random.log(2e-3, 0.4)),
    ];
    if random.one_in(2) {
        given.push((SkinRatio, random.between(0.4, 3.0)));
    }
    if random.one_in(3) {
        given.push((Viscous, random.between(0.0, 3.0)));
    }
    if random.one_in(2) {
        given.push((Dwell, random.between(0.0, 0.1)));
    }
    match random.whole(0, 3) as u32 {
        0 => {}
        1 => given.push((SlopeDeg, random.between(-25.0, 25.0))),
        2 => {
            // From walls that let the robot fall to walls that hold it well.
            let holds = segments * 0.3 * G / mu_coulomb / (segments - 1.0);
            let wall = holds * random.between(0.7, 3.0);
            given.extend([(SlopeDeg, 90.0), (WallForce, wall), (WallRelease, random.unit())]);
        }
        _ => given.extend([(WallForce, random.between(0.0, 20.0)), (WallRelease, random.unit())]),
    }
    if random.one_in(4) {
        given.push((JointStiffness, random.log(300.0, 2e4)));
        given.push((JointDamping, random.between(0.0, 40.0)));
    } else if random.one_in(8) {
        given.push((DriveLimit, f64::INFINITY));
    }
    if random.one_in(4) {
        // From motors that cannot give the drive's limit to motors that always can.
        let supply = random.log(1.0, 200.0);
        given.extend([(SupplyVoltage, supply), (WindingResistance, 5.0), (ForceConstant, 5.0)]);
    }
    (gait, given)
}

/// One with elastic joints on lubricant.
fn lubricated_robot(random: &mut Random) -> (Gait, Vec<(ParamId, f64)>) {
    let (gait, given) = any_robot(random);
    let joint =
        [(JointStiffness, random.log(300.0, 2e4)), (JointDamping, random.between(0.0, 40.0))];
    (gait, with(&with(&given, &joint), &lubricant::any(random)))
}

type Any = fn(&mut Random) -> (Gait, Vec<(ParamId, f64)>);

/// Runs `count` robots; returns how many have a value.
fn run_all(any: Any, seed: u64, count: usize) -> usize {
    let mut random = Random(seed);
    let mut ok = 0;
    for i in 0..count {
        let (gait, given) = any(&mut random);
        let run = tally(gait, &given);
        let who = || format!("robot {i} of {seed}: {} {given:?}", gait.name());
        let elastic = given.iter().any(|(id, _)| *id == JointStiffness);
        if run.status() != Status::Ok {
            // Limits are finite, so that only the drive or its supply may be too weak.
            let weak = if elastic { Status::SupplyTooWeak } else { Status::DriveTooWeak };
            // One whose supply lets it fall down a pipe far beyond its strokes may end without
            // a value: they are lost in rounding, or take more pieces than a phase may have.
            let supplied = given.iter().any(|(id, _)| *id == SupplyVoltage);
            let falls = supplied && given.contains(&(SlopeDeg, 90.0));
            let lost = matches!(run.status(), Status::Unresolved | Status::TooManySteps);
            let known = run.status() == weak || (falls && lost && !elastic);
            assert!(known, "{} {}", run.status().name(), who());
            continue;
        }
        ok += 1;
        let all = run.work.abs() + run.friction + run.impact.abs() + run.potential.abs();
        let lost = run.residual / (all + run.kinetic + run.elastic);
        assert!(lost >= -1e-12 && lost <= if elastic { 0.05 } else { 1e-12 }, "{lost} {}", who());
        assert!(run.friction >= 0.0 && run.time > 0.0 && run.advance.is_finite(), "{}", who());
    }
    ok
}

#[test]
fn robots_at_random_run_or_say_why_not() {
    let ok = run_all(any_robot, 78, 60);
    assert!(ok > 30, "{ok}");
}

#[test]
fn lubricated_robots_at_random_keep_a_closed_ledger() {
    let ok = run_all(lubricated_robot, 79, 40);
    assert!(ok > 35, "{ok}");
}

#[test]
#[ignore = "takes half a minute"]
fn many_lubricated_robots_at_random_keep_a_closed_ledger() {
    let ok = run_all(lubricated_robot, 80, 400);
    assert!(ok > 350, "{ok}");
}

#[test]
#[ignore = "takes half a minute"]
fn many_robots_at_random_run_or_say_why_not() {
    let ok = run_all(any_robot, 77, 900);
    assert!(ok > 600, "{ok}");
}
