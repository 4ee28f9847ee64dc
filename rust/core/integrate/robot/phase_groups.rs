//! Who moves and who anchors in each phase of a gait, and what anchors can hold.

use crate::lane::Lane;
use crate::physics::gait::Schedule;
use crate::physics::robot::Robot;

/// A phase, prepared.
pub(super) struct PhaseGroups<L> {
    /// Ends of the runs of moving segments.
    pub movers: Vec<(usize, usize)>,
    /// Ends of the runs of anchors, and one over what each can hold.
    pub anchors: Vec<(usize, usize, L)>,
}

impl<L: Lane> PhaseGroups<L> {
    #[inline(always)]
    pub fn of(robot: &Robot<L>, schedule: &Schedule, p: usize) -> PhaseGroups<L> {
        let phase = &schedule.phases[p];
        let one = robot.gravity.splat(1.0);
        let mut anchors = Vec::new();
        for (from, to) in Schedule::groups(phase, false) {
            let mut sum = robot.gravity.splat(0.0);
            for i in from..=to {
                let segment = &robot.segments[i];
                sum = sum + robot.levels(i, phase, one).back_hold - segment.pull;
            }
            // Anchors that hold nothing are overloaded without bound.
            anchors.push((from, to, sum.splat(1.0) / sum.max(sum.splat(0.0))));
        }
        PhaseGroups { movers: Schedule::groups(phase, true), anchors }
    }
}
