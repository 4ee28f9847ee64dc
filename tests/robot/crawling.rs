//! Locomotion by friction alone.

use super::*;

/// Two phases: all joints extend, all contract; at most `speed`, no force limit.
fn breathe(segments: &[Segment<f64>], speed: f64, back: f64, cycles: usize) -> GaitTally<f64> {
    let n = segments.len();
    let robot = robot(segments.to_vec(), ideal(f64::INFINITY, speed));
    let phases =
        vec![phase(n, &vec![1.0; n - 1], 1.0, &[]), phase(n, &vec![0.0; n - 1], back, &[])];
    let schedule = Schedule { start: vec![0.0; n - 1], phases, travel: 0.0 };
    let options = RunOptions { impact: 1.0, dwell: 1.0, ..OPTIONS };
    simulate(&robot, &Plan { schedule: &schedule, cycles }, &options, &mut ())
}

#[test]
fn breathing_crawler() {
    let skin = |ratio: f64| Segment { skin_ratio: ratio, mu_static: 0.3, ..segment() };
    let net = |n: usize, ratio: f64| breathe(&vec![skin(ratio); n], 1e-4, 1.0, 2).last_advance;
    // dL (tau_b - tau_f)/(tau_b + tau_f) where the resting segment falls on one.
    let length = |n: usize| (n - 1) as f64 * STROKE;
    near(net(5, 3.0), length(5) / 2.0, 1e-6);
    near(net(9, 3.0), length(9) / 2.0, 1e-6);
    near(net(4, 2.0), length(4) / 3.0, 1e-6);
    near(net(6, 1.5), length(6) / 5.0, 1e-6);
    assert!(net(6, 1.0).abs() < 1e-12);
    near(net(5, 1.0 / 3.0), -length(5) / 2.0, 1e-6);
}

#[test]
fn two_body_ratchet_and_ideal_spikes() {
    let skin = |ratio: f64| Segment { skin_ratio: ratio, mu_static: 0.3, ..segment() };
    near(breathe(&[skin(1.5); 2], 1e-4, 1.0, 3).last_advance, STROKE, 1e-6);
    assert!(breathe(&[skin(1.0); 2], 1e-4, 1.0, 3).last_advance.abs() < 1e-15);
    // Spikes: no point moves backward, and the joints' strokes add up.
    for n in [2, 3, 6] {
        let run = breathe(&vec![skin(1e3); n], 1e-4, 1.0, 3);
        near(run.last_advance, (n - 1) as f64 * STROKE, 1e-5);
        assert!(run.slip_max < 1e-8, "{}", run.slip_max);
    }
}

#[test]
fn crawling_scallop() {
    let body = |mu: f64| Segment { mu_static: mu, mu_coulomb: mu, ..segment() };
    let net = |front: f64, rear: f64, back: f64, speed: f64| {
        breathe(&[body(front), body(rear)], speed, back, 20).last_advance
    };
    // Alike bodies, or a history that is the same backward: nothing.
    assert!(net(0.3, 0.3, 5.0, 0.5).abs() < 1e-9);
    assert!(net(0.3, 0.1, 1.0, 1e-4).abs() < 1e-9);
    assert!(net(0.3, 0.1, 1.0, 0.5).abs() < 1e-9);
    // Both broken, and fast enough to slide: it moves.
    assert!(net(0.3, 0.1, 5.0, 0.5).abs() > 1e-4);
}

#[test]
fn fast_vibration() {
    // Two bodies that swing against each other by +-u: V = u/2 at a ratio of 2.
    let (u, f, pieces) = (1.0, 5.0, 400);
    let body = Segment { mu_static: 0.003, mu_coulomb: 0.003, skin_ratio: 2.0, ..segment() };
    let stroke = 2.0 * u / (2.0 * PI * f);
    let joint = Joint { stroke, speed: 1.0, limit: f64::INFINITY, ..ideal(1.0, 1.0) };
    let robot = robot(vec![body; 2], joint);
    let pace = 1.0 / (f * f64::from(pieces)) / stroke;
    let swing = |q: i32| (2.0 * PI * f64::from(q) / f64::from(pieces)).sin();
    let mut phases: Vec<_> = (1..=pieces).map(|q| phase(2, &[swing(q)], pace, &[])).collect();
    // Rounding of the last sine must not leave a joint short of its start.
    phases[pieces as usize - 1].target = vec![0.0];
    let schedule = Schedule { start: vec![0.0], phases, travel: 0.0 };
    let options = RunOptions { impact: 1.0, ..OPTIONS };
    let plan = Plan { schedule: &schedule, cycles: 1500 };
    let run = simulate(&robot, &plan, &options, &mut ());
    near(run.last_advance * f, 0.5 * u, 5e-3);
}

#[test]
fn speed_wants_many_movers_and_economy_few() {
    let run = |k: f64| {
        let limits = [(DriveLimit, 7.5), (SpeedLimit, 0.02), (MuStatic, 3.0), (Moving, k)];
        let given = with(&dry(12.0), &with(&limits, &[(Cycles, 2.0)]));
        tally(Gait::Window, &given)
    };
    let runs: Vec<_> = (1..=6).map(|k| run(f64::from(k))).collect();
    for pair in runs.windows(2) {
        assert!(pair[0].velocity < pair[1].velocity);
        assert!(pair[0].electric_transport_cost < pair[1].electric_transport_cost);
    }
}
