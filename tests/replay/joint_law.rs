//! The bristle behind a joint as a law: what the stiff method is told of it.

use super::*;
use locosweep::physics::effects::{BehindJoint, Coefficients, Joint, Jointed};
use locosweep::physics::friction::Bristle;

type States = [f64; 4];

/// A pressed bristle behind a spring, or behind a gap whose contact is closed.
fn laws() -> [Jointed<f64>; 2] {
    let mut friction = Coefficients::nominal(0.4, 0.1);
    friction.active =
        Active::default().with(Effect::PreslidingCompliance).with(Effect::LoadDependentFriction);
    (friction.stiffness, friction.damping, friction.load) = (2e3, 5.0, 0.2);
    friction.here = 0.4;
    let spring = Joint { mass: 0.05, stiffness: 400.0, damping: 1.0, gap: 0.0, is_spring: true };
    let contact = Joint { gap: 1e-3, is_spring: false, ..spring };
    [spring, contact].map(|joint| Jointed { friction, joint })
}

fn force(law: &Jointed<f64>, v: f64, z: &States) -> f64 {
    BehindJoint::force(law, v, z, &BehindJoint::rates(law, v, z))
}

#[test]
fn derivatives_are_those_of_differences() {
    let (v, z): (f64, States) = (0.03, [1.2e-4, 4e-3, 0.08, 0.0]);
    for law in laws() {
        let partials = BehindJoint::partials(&law, v, &z);
        let near = |found: f64, expected: f64, what: &str| {
            assert!(
                (found - expected).abs() < 1e-5 * (1.0 + expected.abs()),
                "{what}: {found} {expected}"
            );
        };
        let h = 1e-7;
        let rise = (force(&law, v + h, &z) - force(&law, v - h, &z)) / (2.0 * h);
        near(partials.force_v, rise, "force by v");
        for j in 0..BehindJoint::STATES {
            let [mut up, mut down] = [z; 2];
            (up[j], down[j]) = (z[j] + h, z[j] - h);
            let rise = (force(&law, v, &up) - force(&law, v, &down)) / (2.0 * h);
            near(partials.force_z[j], rise, "force by state");
            let (above, below) =
                (BehindJoint::rates(&law, v, &up), BehindJoint::rates(&law, v, &down));
            for i in 0..BehindJoint::STATES {
                near(partials.rate_z[i][j], (above[i] - below[i]) / (2.0 * h), "rate by state");
            }
        }
        let (above, below) =
            (BehindJoint::rates(&law, v + h, &z), BehindJoint::rates(&law, v - h, &z));
        for i in 0..BehindJoint::STATES {
            near(partials.rate_v[i], (above[i] - below[i]) / (2.0 * h), "rate by v");
        }
    }
}

/// The joint carries just the friction, which grows with what it carries.
#[test]
fn steady_sliding_needs_no_further_force() {
    for law in laws() {
        for v in [0.05, -0.05] {
            let z = BehindJoint::steady(&law, v);
            assert!(force(&law, v, &z).abs() < 1e-12);
            assert!(BehindJoint::rates(&law, v, &z)[..2].iter().all(|rate| rate.abs() < 1e-12));
        }
    }
}
