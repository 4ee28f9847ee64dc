//! Work of an elastic joint's drive.
//!
//! Between a drive and its joint stands a spring. Up to the stretch at which the spring
//! alone takes all of the drive's force, the drive follows its command; beyond, the joint
//! drags it along at that stretch. Either way a drive gives its force times its own pace:
//! what the joint takes, and what the spring and the damper take on top of that.

use crate::lane::Lane;
use crate::physics::robot::Joint;

/// What a drive gives in a step.
pub(super) struct Given<L> {
    /// J.
    pub work: L,
    /// Mean speed of the drive, m/s.
    pub pace: L,
}

/// A joint over a step at whose start or end the command is farther from it than its drive
/// can be.
pub(super) struct Dragged<'a, L> {
    pub joint: &'a Joint<L>,
    /// From the joint to the command at the end of the step, and what it has gained, m.
    pub lead: L,
    pub gained: L,
    /// Of the joint's force, and the joint's pace.
    pub impulse: L,
    pub pace: L,
    /// Length of the step, and the intermediate time at which it takes its forces.
    pub h: L,
    pub theta: L,
}

impl<L: Lane> Dragged<'_, L> {
    #[inline(always)]
    pub fn given(&self) -> Given<L> {
        let &Dragged { joint, lead, gained, impulse, pace, h, theta } = self;
        let (before, after) = (joint.held(lead - gained), joint.held(lead));
        let change = after - before;
        // Against its joint the drive moves from one stretch to the other, with the force of the
        // stretch at the intermediate time theta, at which the step takes all its forces. As
        // theta is 1/2 or more, it gives at least what the spring gains.
        let stretch = (before + after) * 0.5 + (theta - 0.5) * change;
        let force = joint.stiffness * stretch + joint.damping * (gained / h);
        let force = force.min(joint.limit).max(-joint.limit);
        Given { work: impulse * pace + force * change, pace: pace + change / h }
    }
}
