//! The motors behind the joints: what they draw, and what their supply cannot deliver.

use super::*;

/// Heat in the windings, J: what the motors draw beyond the work of the drives.
fn heat(run: &GaitTally<f64>) -> f64 {
    run.electric_energy - run.work
}

#[test]
fn what_motors_draw_is_heat_and_work() {
    // Without a bound on the voltage the motion does not depend on the resistance, and
    // heat is proportional to it.
    let mut random = Random(51);
    let mut ran = 0;
    for round in 0..60 {
        let n = random.whole(2, 7) as usize;
        let mut robot = random_robot(&mut random, n, round % 3 == 0);
        let (gait, schedule) = random_plan(&mut random, n);
        let options = random_options(&mut random);
        let plan = Plan { schedule: &schedule, cycles: 2 };
        let mut run = |resistance: f64| {
            robot.motor = Motor { supply: f64::INFINITY, resistance, force_constant: 1.7 };
            simulate(&robot, &plan, &options, &mut ())
        };
        let (one, two) = (run(20.0), run(40.0));
        assert_eq!(one.status(), two.status());
        if one.status() != Status::Ok {
            continue;
        }
        ran += 1;
        assert_eq!(one.work.to_bits(), two.work.to_bits());
        assert!(heat(&one) >= 0.0, "{} {}", gait.name(), heat(&one));
        // Forces that fade with viscous friction are integrated to 1e-6.
        let scale = one.electric_energy.abs() + one.work.abs();
        assert!((heat(&two) - 2.0 * heat(&one)).abs() < 1e-6 * scale, "{}", gait.name());
    }
    assert!(ran > 30, "{ran}");
}

/// The paper's gait on Figure 2's surface, with this motor.
fn paper(motor: Given) -> GaitTally<f64> {
    let run = [(DriveLimit, 0.85), (Dwell, 0.05), (Cycles, 1.0)];
    tally(Gait::Single, &with(&with(&dry(4.0), &run), motor))
}

const SUPPLY: &[(ParamId, f64)] =
    &[(SupplyVoltage, 10.0), (WindingResistance, 20.0), (ForceConstant, 1.7)];

#[test]
fn energy_of_the_paper_gait() {
    // An inner segment is driven by two joints of 0.85 N.
    let free = paper(&[]);
    near(free.work, (2.0 + 2.0 * 2.0) * 0.85 * STROKE, 1e-12);
    let run = paper(SUPPLY);
    near(run.advance, free.advance, 1e-9);
    assert!(run.time > free.time && run.work < free.work && run.actuator_peak <= 0.85);
    assert!(run.residual.abs() < 1e-12 * run.work);
    shows(free.electric_energy, "6.840");
    // In closed form: the supply's voltage times what the impulses take of current.
    near(run.electric_energy, 6.871_111_513, 1e-6);
    shows(run.work, "0.0990");
}

#[test]
fn a_supply_limits_the_force_by_the_motor_line() {
    // The head alone: m v' = F_0 - F_C - (b + c) v, in closed form.
    let (stall, loss) = (0.85, 1.7 * 1.7 / 20.0);
    for viscous in [0.0, 0.4] {
        let part = Segment { mu_static: 0.3, mu_coulomb: 0.15, viscous, ..segment() };
        let mut robot = robot(vec![part; 4], ideal(f64::INFINITY, f64::INFINITY));
        robot.motor = PAPER_MOTOR;
        let run =
            |time_step: f64| once(&robot, &head_phase(4), &RunOptions { time_step, ..OPTIONS });
        let fade = (viscous + loss) / M;
        let end = (stall - 0.15 * MG) / (viscous + loss);
        let way = |t: f64| end * (t + (-fade * t).exp_m1() / fade);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if way(middle) < STROKE { low = middle } else { high = middle }
        }
        near(run(1e-3).time, high, 1e-6);
        // Of second order in the step.
        let wrong = |step: f64| (run(step).time - high).abs();
        assert!(wrong(2.5e-3) < 0.1 * wrong(1e-2), "{} {}", wrong(1e-2), wrong(2.5e-3));
        // Impulse: all of it at 10 V.
        let fine = run(1e-3);
        let impulse = fine.propulsive_mean * fine.time;
        near(fine.electric_energy, 10.0 / 1.7 * impulse, 1e-6);
        near(fine.time * stall - loss * STROKE, impulse, 1e-6);
    }
}

#[test]
fn no_motor_takes_more_than_its_supply() {
    let mut random = Random(52);
    let mut starved = 0;
    for _ in 0..200 {
        let n = random.whole(2, 7) as usize;
        let mut robot = random_robot(&mut random, n, false);
        let supply = random.between(4.0, 15.0);
        robot.motor = Motor { supply, resistance: 4.0, force_constant: 4.0 };
        let (gait, schedule) = random_plan(&mut random, n);
        // No energy of impacts that could drive a joint as a generator.
        let options = RunOptions { impact: 0.0, time_step: 5e-4, ..random_options(&mut random) };
        let plan = Plan { schedule: &schedule, cycles: 1 };
        let mut trace = Trace::new(1e-3);
        let run = simulate(&robot, &plan, &options, &mut trace);
        if run.status() != Status::Ok {
            assert_eq!(run.status(), Status::DriveTooWeak, "{}", gait.name());
            continue;
        }
        for (force, v) in trace.force.chunks(n - 1).zip(trace.v.chunks(n)) {
            for (j, force) in force.iter().enumerate() {
                // A locked joint holds without current.
                let pace = v[j] - v[j + 1];
                let voltage =
                    if pace.abs() > 1e-9 { robot.motor.voltage(*force, pace) } else { 0.0 };
                // A force is constant over a step, within which the speed goes on.
                assert!(voltage.abs() < 1.05 * supply, "{voltage} {supply} {}", gait.name());
            }
        }
        let unlimited =
            Robot { motor: Motor { supply: f64::INFINITY, ..robot.motor }, ..robot.clone() };
        let free = simulate(&unlimited, &plan, &options, &mut ());
        starved += usize::from(free.time < run.time);
        let all = run.friction + run.impact.abs();
        assert!(run.residual.abs() < 1e-9 * all, "{} {}", gait.name(), run.residual);
        assert!(heat(&run) > 0.0, "{}", gait.name());
    }
    assert!(starved > 10, "{starved}");
}

#[test]
fn a_supply_that_suffices_changes_no_bit() {
    let mut random = Random(53);
    for round in 0..40 {
        let n = random.whole(2, 7) as usize;
        let mut robot = random_robot(&mut random, n, round % 2 == 0);
        let (_, schedule) = random_plan(&mut random, n);
        let options = random_options(&mut random);
        let plan = Plan { schedule: &schedule, cycles: 1 };
        let mut run = |supply: f64| {
            robot.motor = Motor { supply, resistance: 4.0, force_constant: 4.0 };
            simulate(&robot, &plan, &options, &mut ())
        };
        let (free, ample) = (run(f64::INFINITY), run(60.0));
        let bits =
            |run: &GaitTally<f64>| run.values().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&free), bits(&ample));
    }
}

#[test]
fn a_supply_too_weak_for_an_elastic_drive_has_a_status() {
    let motor =
        |supply: f64| [(SupplyVoltage, supply), (WindingResistance, 4.0), (ForceConstant, 4.0)];
    let run = |supply: f64| tally(Gait::Single, &with(&servo(1e-3), &motor(supply)));
    let ample = run(12.0);
    assert_eq!(ample.status(), Status::Ok);
    assert!(heat(&ample) > 0.0);
    assert_eq!(run(1.0).status(), Status::SupplyTooWeak);
    // A command that jumps asks for more than any voltage.
    let jumps = [(SpeedLimit, f64::INFINITY)];
    let jump = |supply| tally(Gait::Single, &with(&with(&servo(1e-3), &jumps), &motor(supply)));
    assert_eq!(jump(12.0).status(), Status::SupplyTooWeak);
    assert!(heat(&jump(f64::INFINITY)) > 0.0);
}
