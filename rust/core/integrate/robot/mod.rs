//! The whole robot over time. Ideal joints run from event to event (`ideal`),
//! elastic ones step by step (`step`); who sticks is decided for all segments
//! together in both (`chain`, `stick`).

mod chain;
mod drive_work;
mod ensemble;
mod flow;
mod gait_parameters;
mod ideal;
mod lubrication;
mod motion;
mod outputs;
mod phase_groups;
mod step;
mod stick;
mod tally;
mod trace;

pub use chain::{Body, Chain, Link, Sliding, solve_with_break_away};
pub use ensemble::{Row, ensemble, gait_tally};
pub use gait_parameters::{
    GAIT_PARAMS, GaitParam, Part, PerPart, RunParameters, STRIBECK, stribeck_needs_its_term,
};
pub use outputs::{GAIT_OUTPUTS, GaitOutput};
pub use stick::Step;
pub use tally::GaitTally;
pub use trace::{Now, Observer, Trace};

use crate::lane::Lane;
use crate::physics::Status;
use crate::physics::gait::Schedule;
use crate::physics::robot::Robot;

/// How a run goes, beside robot and gait.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunOptions<L> {
    /// Longest step, s; ideal joints need none.
    pub time_step: L,
    /// Rest after each phase, s.
    pub dwell: L,
    /// 1: the momentum left at the end of an ideal stroke stays in the robot.
    pub impact: L,
    /// 0: segments that the gait moves have no static friction of their own.
    pub break_away: L,
}

/// What the robot does.
#[derive(Debug, Clone, Copy)]
pub struct Plan<'a> {
    pub schedule: &'a Schedule,
    pub cycles: usize,
}

/// Runs one robot; `observer` may be a [`Trace`], or `()`. A run that it calls off has
/// no result.
pub fn simulate<O: Observer<f64>>(
    robot: &Robot<f64>,
    plan: &Plan,
    options: &RunOptions<f64>,
    observer: &mut O,
) -> GaitTally<f64> {
    let ideal = robot.joints.iter().filter(|j| j.stiffness.is_infinite()).count();
    if robot.segments.len() > crate::physics::robot::MOST_SEGMENTS {
        GaitTally::none(0.0, Status::TooManySegments)
    } else if ideal == robot.joints.len() && !robot.lubricants.is_empty() {
        // Between two events of an ideal joint friction is constant but for its viscous
        // part; heaps and falling levels have no such closed form.
        GaitTally::none(0.0, Status::ElasticJointsOnly)
    } else if ideal == robot.joints.len() {
        ideal::run(robot, plan, options, observer)
    } else if ideal == 0 {
        step::run(robot, plan, options, observer)
    } else {
        GaitTally::none(0.0, Status::MixedJoints)
    }
}

/// Runs robots with elastic joints, one per lane.
#[inline(always)]
fn simulate_lanes<L: Lane, O: Observer<L>>(
    robot: &Robot<L>,
    plan: &Plan,
    options: &RunOptions<L>,
    observer: &mut O,
) -> GaitTally<L> {
    step::run(robot, plan, options, observer)
}
