//! Integrators of one segment (and, in `robot`, of the whole robot), over lanes: each lane is a trajectory of its own,
//! with its own time, step and events; none looks at its neighbours.
//!
//! Sticking is a mode (`State::direction` is 0), entered when the speed passes zero and
//! left when the applied force exceeds what friction holds. Jumps of the drive
//! are ends of its pieces, which no step crosses.

mod anchored_body;
pub mod bristle;
pub mod dormand_prince;
mod drive_resolution;
mod driven_side;
pub mod dry_contact;
pub mod elastic_drive;
mod event_location;
pub mod exact;
pub mod linear_response;
pub mod measured_motion;
pub mod replay;
pub mod robot;
pub mod runge_kutta;
pub mod smooth;
mod step_control;
mod tally;

pub use tally::{Tally, Watch};

use lane::Lane;
use locosweep_base::{error, lane};
use locosweep_physics as physics;
use physics::drive::Clock;
use physics::friction::MOST_STATES;
use physics::segment::Segment;

/// Where a trajectory is.
#[derive(Clone, Copy)]
pub struct State<L> {
    pub t: L,
    pub x: L,
    pub v: L,
    /// Direction of sliding, 1 or -1; 0 at rest. Of a law that never rests the
    /// sign of the speed does not matter, and it stays 1.
    pub direction: L,
    /// Distance moved forward since the last rest or turn.
    pub sliding_distance: L,
    pub clock: Clock<L>,
    pub z: [L; MOST_STATES],
}

impl<L: Lane> State<L> {
    #[inline(always)]
    pub fn start(segment: &Segment<L>) -> Self {
        let zero = segment.x.splat(0.0);
        State {
            t: zero,
            x: segment.x,
            v: segment.v,
            direction: segment.v.sign(),
            sliding_distance: L::select(zero.lt(segment.v), segment.sliding_distance, zero),
            clock: segment.drive.clock(zero),
            z: [zero; MOST_STATES],
        }
    }

    /// `self` where the mask holds, `other` elsewhere.
    #[inline(always)]
    pub fn or(self, mask: L::Mask, other: State<L>) -> State<L> {
        let mut z = self.z;
        for (z, other) in z.iter_mut().zip(other.z) {
            *z = L::select(mask, *z, other);
        }
        State {
            t: L::select(mask, self.t, other.t),
            x: L::select(mask, self.x, other.x),
            v: L::select(mask, self.v, other.v),
            direction: L::select(mask, self.direction, other.direction),
            sliding_distance: L::select(mask, self.sliding_distance, other.sliding_distance),
            clock: self.clock.or(mask, other.clock),
            z,
        }
    }
}

/// METHOD REGISTRY.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    Exact,
    RungeKutta,
    DormandPrince,
    DormandPrinceFixed,
    Rosenbrock,
    RosenbrockFixed,
}

impl Method {
    /// Names and meanings, in the order users see them.
    pub const ALL: &'static [(Method, &'static str, &'static str)] = &[
        (
            Method::Exact,
            "exact",
            "closed form from event to event: Coulomb and viscous friction under a stepwise drive",
        ),
        (
            Method::RungeKutta,
            "runge_kutta",
            "classical fourth-order steps of time_step with located events",
        ),
        (
            Method::DormandPrince,
            "dormand_prince",
            "fifth-order steps, their size from tolerance (at rest time_step), with located events and dense output: dry laws, one trajectory at a time",
        ),
        (Method::DormandPrinceFixed, "dormand_prince_fixed", "the same with steps of time_step"),
        (
            Method::Rosenbrock,
            "rosenbrock",
            "stiff fourth-order steps, their size from tolerance: bristle and smooth laws",
        ),
        (Method::RosenbrockFixed, "rosenbrock_fixed", "the same with steps of time_step"),
    ];

    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|m| m.0 == self).map_or("", |m| m.1)
    }

    /// Whether it takes trajectories one by one, not in lanes.
    pub fn is_scalar(self) -> bool {
        matches!(self, Method::DormandPrince | Method::DormandPrinceFixed)
    }
}

/// Most steps or pieces of one trajectory.
pub const MOST_STEPS: f64 = 2e7;
/// The same for the stiff method, whose steps take longer.
pub const MOST_STIFF_STEPS: f64 = 2e6;

/// Moves trajectories on; what differs between methods.
pub trait Advance<L: Lane> {
    /// Takes every lane to its time `until`; false if the run was given up.
    fn advance(&mut self, state: &mut State<L>, tally: &mut Tally<L>, until: L) -> bool;

    /// Steps that a run will take at least, where that is known before.
    #[inline(always)]
    fn steps(&self, duration: L) -> L {
        duration.splat(0.0)
    }

    /// Energy in the bristles, for laws that have some.
    #[inline(always)]
    fn elastic(&self, state: &State<L>) -> L {
        state.x.splat(0.0)
    }
}

impl<L: Lane> Advance<L> for Box<dyn Advance<L> + '_> {
    fn advance(&mut self, state: &mut State<L>, tally: &mut Tally<L>, until: L) -> bool {
        (**self).advance(state, tally, until)
    }
    fn steps(&self, duration: L) -> L {
        (**self).steps(duration)
    }
    fn elastic(&self, state: &State<L>) -> L {
        (**self).elastic(state)
    }
}

/// Runs from start to end, with a visit to each station.
#[inline(always)]
pub fn drive<L: Lane>(
    segment: &Segment<L>,
    mut method: impl Advance<L>,
    stations: &[f64],
    mut visit: impl FnMut(usize, &State<L>),
    watch: Watch,
) -> Tally<L> {
    let mut state = State::start(segment);
    let mut tally = Tally::start(segment, watch);
    // What would take for ever is not begun.
    let zero = segment.duration.splat(0.0);
    let long = zero.splat(MOST_STEPS).lt(method.steps(segment.duration));
    let duration = L::select(long, zero, segment.duration);
    tally.long = L::select(long, zero.splat(1.0), zero);
    for (i, share) in stations.iter().enumerate() {
        if !method.advance(&mut state, &mut tally, duration * *share) {
            break;
        }
        visit(i, &state);
    }
    method.advance(&mut state, &mut tally, duration);
    let elastic = method.elastic(&state);
    tally.end(segment, &state, elastic)
}
