//! Elastic joints.

use super::*;

/// Slope of ln(error) over ln(step).
pub fn order(steps: &[f64], errors: &[f64]) -> f64 {
    let n = steps.len() as f64;
    let (x, y): (Vec<f64>, Vec<f64>) =
        steps.iter().zip(errors).map(|(h, e)| (h.ln(), e.ln())).unzip();
    let (sx, sy) = (x.iter().sum::<f64>(), y.iter().sum::<f64>());
    let xy: f64 = x.iter().zip(&y).map(|(x, y)| x * y).sum();
    let xx: f64 = x.iter().map(|x| x * x).sum();
    (n * xy - sx * sy) / (n * xx - sx * sx)
}

#[test]
fn order_of_the_steps() {
    let run = |h: f64| tally(Gait::Single, &servo(h));
    let finest = run(1e-5);
    let steps = [2.5e-4, 5e-4, 1e-3, 1.25e-3, 2e-3, 2.5e-3];
    let error = |h: &f64| (run(*h).advance - finest.advance).abs();
    let errors: Vec<f64> = steps.iter().map(error).collect();
    let lost: Vec<f64> = steps.iter().map(|h| run(*h).residual).collect();
    let (of_advance, of_energy) = (order(&steps, &errors), order(&steps, &lost));
    assert!((1.7..2.6).contains(&of_advance), "{of_advance} {errors:?}");
    assert!((1.7..2.2).contains(&of_energy), "{of_energy} {lost:?}");
    // One per cent of the small-step limit, at a step that a servo would have.
    near(run(5e-3).advance, finest.advance, 0.01);
}

#[test]
fn no_stiffness_asks_for_a_smaller_step() {
    for stiffness in [1e4, 1e5, 1e6, 1e9] {
        for damping in [0.0, 20.0, 1e4] {
            for h in [1e-3, 5e-3] {
                let joint = [(JointStiffness, stiffness), (JointDamping, damping)];
                let run = tally(Gait::Block, &with(&servo(h), &joint));
                assert_eq!(run.status(), Status::Ok);
                assert!(run.residual > -1e-12 && run.residual < run.work, "{}", run.residual);
                assert!(
                    (0.015..0.021).contains(&run.advance),
                    "{stiffness} {damping} {h} {}",
                    run.advance
                );
            }
        }
    }
}

#[test]
fn stiff_joints_move_as_ideal_ones() {
    // Slow and free of impacts: both only follow the gait.
    let given = [(MuStatic, 0.5), (MuCoulomb, 0.3), (Segments, 4.0), (SpeedLimit, 1e-3)];
    let more = [(Cycles, 1.0), (TimeStep, 5e-3), (DriveLimit, 3.0), (JointDamping, 100.0)];
    let given = with(&given, &more);
    for gait in [Gait::Single, Gait::Wave] {
        let ideal = tally(gait, &given);
        let stiff = tally(gait, &with(&given, &[(JointStiffness, 1e6)]));
        near(stiff.advance, ideal.advance, 2e-3);
        near(stiff.time, ideal.time, 1e-2);
        near(stiff.friction, ideal.friction, 1e-2);
    }
}
