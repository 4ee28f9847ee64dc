//! A bristle under a head that a joint parts from its drive. The joint's stretch and the speed of
//! the drive's side are states beside the bristle, so that one stiff step takes all three.

use super::Effect;
use super::friction::{Coefficients, Measured};
use super::plant::Joint;
use crate::friction::{
    Bristle, Contact, ContactState, Law, LawInfo, MOST_STATES, Parameters, Partials, pressed,
};
use crate::lane::Lane;

/// The friction of a measured head, and the joint that pushes it.
pub struct BehindJoint;

/// Coefficients of both; the joint as integrators follow it (`Joint::followed`).
#[derive(Debug, Clone, Copy)]
pub struct Jointed<L> {
    pub friction: Coefficients<L>,
    pub joint: Joint<L>,
}

/// States beside the bristle, which is the first.
const STRETCH: usize = 1;
const SIDE_SPEED: usize = 2;

impl<L: Lane> Jointed<L> {
    /// States at the start: a spring is loaded by the first force, a gap in its middle, and the
    /// drive's side moves with the head.
    #[inline(always)]
    pub fn start(&self, force: L, v: L) -> [L; MOST_STATES] {
        let zero = v.splat(0.0);
        let stretch = if self.joint.is_spring { force / self.joint.stiffness } else { zero };
        [zero, stretch, v, zero]
    }

    /// The friction under the force that the joint gives.
    #[inline(always)]
    fn under(&self, push: L) -> Coefficients<L> {
        let friction = self.friction;
        if !friction.active.has(Effect::LoadDependentFriction) {
            return friction;
        }
        friction.with_level(pressed(friction.here, push, friction.load))
    }

    /// Momentum of the drive's side.
    #[inline(always)]
    pub fn held(&self, z: &[L; MOST_STATES]) -> L {
        self.joint.mass * z[SIDE_SPEED]
    }

    /// Force on the head, and whether the joint transmits: a contact does not pull.
    #[inline(always)]
    pub fn push(&self, v: L, z: &[L; MOST_STATES]) -> (L, L::Mask) {
        let zero = v.splat(0.0);
        let joint = &self.joint;
        let (stretch, rate) = (z[STRETCH], z[SIDE_SPEED] - v);
        if joint.is_spring {
            let force = joint.damping.mul_add(rate, joint.stiffness * stretch);
            return (force, zero.le(zero));
        }
        let side = stretch.sign();
        let depth = stretch - side * joint.gap;
        let force = joint.damping.mul_add(rate, joint.stiffness * depth);
        let touches = L::and(zero.lt(side * depth), zero.lt(side * force));
        (L::select(touches, force, zero), touches)
    }
}

impl Law for BehindJoint {
    const INFO: LawInfo = Measured::INFO;
    type Coefficients<L: Lane> = Jointed<L>;

    /// Parameters of laws have no joint: it is rigid.
    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Jointed<L> {
        let friction = Measured::coefficients(contact, params);
        Jointed { friction, joint: Joint::rigid(friction.forward) }
    }
}

impl Bristle for BehindJoint {
    const STATES: usize = 3;
    /// As those of the head's position and speed.
    const FLOORS: [f64; MOST_STATES] = [1e-8, 1e-6, 1e-3, 1.0];

    #[inline(always)]
    fn driven<L: Lane>(law: &Jointed<L>) -> Option<(usize, L)> {
        Some((SIDE_SPEED, law.joint.mass.splat(1.0) / law.joint.mass))
    }

    #[inline(always)]
    fn varies<L: Lane>(law: &Jointed<L>) -> bool {
        Measured::varies(&law.friction)
    }

    #[inline(always)]
    fn placed<L: Lane>(law: &Jointed<L>, at: &ContactState<L>) -> Jointed<L> {
        // What presses the bristle changes with the states: see `under`.
        let at = ContactState { drive: at.drive.splat(0.0), ..*at };
        Jointed { friction: Measured::placed(&law.friction, &at), joint: law.joint }
    }

    #[inline(always)]
    fn rates<L: Lane>(law: &Jointed<L>, v: L, z: &[L; MOST_STATES]) -> [L; MOST_STATES] {
        let (push, _) = law.push(v, z);
        let mut rates = Measured::rates(&law.under(push), v, z);
        rates[STRETCH] = z[SIDE_SPEED] - v;
        rates[SIDE_SPEED] = -(push / law.joint.mass);
        rates
    }

    #[inline(always)]
    fn force<L: Lane>(law: &Jointed<L>, v: L, z: &[L; MOST_STATES], rates: &[L; MOST_STATES]) -> L {
        Measured::force(&law.friction, v, z, rates) - law.push(v, z).0
    }

    #[inline(always)]
    fn partials<L: Lane>(law: &Jointed<L>, v: L, z: &[L; MOST_STATES]) -> Partials<L> {
        let zero = v.splat(0.0);
        let one = zero.splat(1.0);
        let (push, touches) = law.push(v, z);
        let friction = law.under(push);
        let mut partials = Measured::partials(&friction, v, z);
        let stiffness = L::select(touches, law.joint.stiffness, zero);
        let damping = L::select(touches, law.joint.damping, zero);
        let per_side = one / law.joint.mass;
        partials.rate_v[STRETCH] = -one;
        partials.rate_z[STRETCH][SIDE_SPEED] = one;
        partials.rate_v[SIDE_SPEED] = damping * per_side;
        partials.rate_z[SIDE_SPEED][STRETCH] = -(stiffness * per_side);
        partials.rate_z[SIDE_SPEED][SIDE_SPEED] = -(damping * per_side);
        partials.force_v = partials.force_v + damping;
        partials.force_z[STRETCH] = -stiffness;
        partials.force_z[SIDE_SPEED] = -damping;
        if law.friction.active.has(Effect::LoadDependentFriction) {
            let per_push = friction.per_level(v, z) * (law.friction.load * push.sign());
            let (along, across) = (per_push * stiffness, per_push * damping);
            partials.rate_v[0] = partials.rate_v[0] - across;
            partials.rate_z[0][STRETCH] = along;
            partials.rate_z[0][SIDE_SPEED] = across;
            let bristle = law.friction.damping;
            partials.force_v = (-bristle).mul_add(across, partials.force_v);
            partials.force_z[STRETCH] = bristle.mul_add(along, partials.force_z[STRETCH]);
            partials.force_z[SIDE_SPEED] = bristle.mul_add(across, partials.force_z[SIDE_SPEED]);
        }
        partials
    }

    #[inline(always)]
    fn stored<L: Lane>(law: &Jointed<L>, z: &[L; MOST_STATES]) -> L {
        let half = law.joint.stiffness * 0.5;
        let depth = z[STRETCH] - z[STRETCH].clip(law.joint.gap);
        half.mul_add(depth * depth, Measured::stored(&law.friction, z))
    }

    #[inline(always)]
    fn steady<L: Lane>(law: &Jointed<L>, v: L) -> [L; MOST_STATES] {
        let zero = v.splat(0.0);
        let z = Measured::steady(&law.friction, v);
        let unpressed = Measured::force(&law.friction, v, &z, &[zero; MOST_STATES]);
        // Friction grows with the force that it asks for.
        let force = unpressed / (zero.splat(1.0) - law.friction.load);
        let mut z = Measured::steady(&law.under(force), v);
        z[STRETCH] = force.sign().mul_add(law.joint.gap, force / law.joint.stiffness);
        z[SIDE_SPEED] = v;
        z
    }
}
