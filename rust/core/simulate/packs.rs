//! Trajectories of a stretch of cells, pack by pack.

use super::bounds::Bounds;
use super::outputs::Output;
use super::simulation::Simulation;
use crate::columns::Columns;
use crate::integrate::{Advance, State, Tally, Watch, drive};
use crate::lane::{Lane, Pack};
use crate::physics::ParamId;
use crate::physics::friction::{Kind, Parameters};
use crate::physics::segment::Segment;
use std::sync::atomic::{AtomicBool, Ordering};

/// Cells to simulate and where their numbers go.
pub struct Stretch<'a> {
    pub columns: Columns<'a>,
    pub simulation: &'a Simulation,
    pub watch: Watch,
    /// Cells that count, and how many there are with those that fill the widest
    /// pack.
    pub count: usize,
    pub len: usize,
    /// What is wanted, with a buffer of `len` each.
    pub outputs: &'a mut [(Output, Vec<f64>)],
    /// What became of each trajectory, see `Fate`; `len` cells.
    pub fates: &'a mut [f64],
    /// Empty, or where states at the stations go.
    pub trace: Option<Trace<'a>>,
    pub cancel: &'a AtomicBool,
}

/// States at the stations, station by station, `len` cells each.
pub struct Trace<'a> {
    /// As shares of the duration.
    pub stations: &'a [f64],
    pub x: &'a mut [f64],
    pub v: &'a mut [f64],
    /// Drive force on the segment.
    pub force: &'a mut [f64],
    /// Direction of sliding, 0 at rest.
    pub direction: &'a mut [f64],
}

/// The parameters of the cells from `start` on, a pack of them.
pub(super) struct Cells<'a, P: Pack> {
    token: P::Token,
    columns: Columns<'a>,
    start: usize,
}

impl<P: Pack> Parameters<P> for Cells<'_, P> {
    #[inline(always)]
    fn get(&self, id: ParamId) -> P {
        self.columns.load(self.token, id.main(), self.start)
    }
    #[inline(always)]
    fn derived(&self, id: ParamId) -> P {
        self.columns.load(self.token, id.derived(), self.start)
    }
}

/// Runs the packs of a stretch, each by `one`.
#[inline(always)]
pub(super) fn each_pack<P: Pack>(
    token: P::Token,
    mut stretch: Stretch,
    mut one: impl FnMut(&Cells<P>, &Segment<P>, &mut Visit<P>) -> Tally<P>,
) {
    let simulation = stretch.simulation;
    let mut start = 0;
    while start < stretch.count && !stretch.cancel.load(Ordering::Relaxed) {
        let cells = Cells { token, columns: stretch.columns, start };
        let segment = segment_of(simulation, &cells);
        let mut visit = Visit {
            trace: stretch.trace.as_mut(),
            len: stretch.len,
            start,
            segment: &segment,
            simulation,
        };
        let tally = one(&cells, &segment, &mut visit);
        keep(&segment, &tally, start, &mut stretch);
        start += P::LANES;
    }
}

/// Not a closure within `each_pack`, which would be compiled anew for each of its callers.
#[inline(always)]
fn segment_of<'a, P: Pack>(simulation: &'a Simulation, cells: &Cells<P>) -> Segment<'a, P> {
    P::broadcast(cells.token, 0.0).outlined(
        #[inline(always)]
        || Segment::new(simulation.drive, simulation.table(), cells),
    )
}

/// Hands the numbers of a pack on.
#[inline(always)]
fn keep<P: Pack>(segment: &Segment<P>, tally: &Tally<P>, start: usize, stretch: &mut Stretch) {
    tally.x.outlined(
        #[inline(always)]
        || keep_here(segment, tally, start, stretch),
    );
}

#[inline(always)]
fn keep_here<P: Pack>(segment: &Segment<P>, tally: &Tally<P>, start: usize, stretch: &mut Stretch) {
    let bounds = Bounds::new(stretch.simulation, segment);
    let fate = Fate::of(tally, bounds.hold(segment.duration, tally.x, tally.v));
    fate.store(&mut stretch.fates[start..]);
    let found = fate.le(fate.splat(Fate::FOUND));
    for (output, to) in stretch.outputs.iter_mut() {
        let value = output.of(segment, tally).only_if(found);
        // Beyond what a double holds is no value either.
        value.only_if(value.is_finite()).store(&mut to[start..]);
    }
}

/// What became of a trajectory.
pub struct Fate;

impl Fate {
    pub const FOUND: f64 = 0.0;
    pub const LOST: f64 = 1.0;
    pub const DIVERGED: f64 = 2.0;
    pub const LONG: f64 = 3.0;

    #[inline(always)]
    fn of<L: Lane>(tally: &Tally<L>, bounded: L::Mask) -> L {
        let size = tally.x;
        let followed = tally.lost.le(size.splat(0.0));
        let code = L::select(followed, size.splat(Fate::FOUND), size.splat(Fate::LOST));
        let code = L::select(bounded, code, size.splat(Fate::DIVERGED));
        L::select(tally.long.le(size.splat(0.0)), code, size.splat(Fate::LONG))
    }
}

/// Stores states at stations, where that is wanted.
pub(super) struct Visit<'a, 'b, 'c, P> {
    trace: Option<&'b mut Trace<'a>>,
    len: usize,
    start: usize,
    segment: &'b Segment<'c, P>,
    simulation: &'a Simulation,
}

impl<P: Pack> Visit<'_, '_, '_, P> {
    #[inline(always)]
    pub fn drive(&mut self, method: impl Advance<P>, watch: Watch) -> Tally<P> {
        let (segment, len, start) = (self.segment, self.len, self.start);
        let simulation = self.simulation;
        let dry = simulation.law.kind == Kind::Dry;
        let stations = self.trace.as_ref().map_or(&[][..], |trace| trace.stations);
        let trace = &mut self.trace;
        let bounds = trace.is_some().then(|| Bounds::new(simulation, segment));
        let (one, mut gone) = (segment.x.splat(1.0), segment.x.splat(0.0));
        drive(
            segment,
            method,
            stations,
            #[inline(always)]
            |i: usize, state: &State<P>| {
                let (Some(trace), Some(bounds)) = (trace.as_deref_mut(), &bounds) else {
                    return;
                };
                let Trace { x, v, force, direction, .. } = trace;
                let at = i * len + start;
                // What has diverged has no value any more, also where it comes back.
                gone = P::select(bounds.hold(state.t, state.x, state.v), gone, one);
                let there = gone.lt(one);
                state.x.only_if(there).store(&mut x[at..]);
                state.v.only_if(there).store(&mut v[at..]);
                let given = segment.force(state.t, &state.clock, state.x, state.v);
                given.only_if(there).store(&mut force[at..]);
                // Only dry friction holds: the others slide whenever they move.
                let sliding = if dry { state.direction } else { state.v.sign() };
                sliding.only_if(there).store(&mut direction[at..]);
            },
            watch,
        )
    }
}
