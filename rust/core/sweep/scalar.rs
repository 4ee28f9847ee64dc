//! Trajectories one by one, on plain numbers. Only what makes a method is compiled
//! per law; the loop over cells is the same for all.

use super::simulation::Simulation;
use super::trajectories::{Cells, Stretch, each_pack};
use crate::integrate::dormand_prince::DormandPrince;
use crate::integrate::{Advance, Method};
use crate::lane::scalar_token;
use crate::physics::friction::Dry;
use crate::physics::segment::Segment;
use std::sync::atomic::{AtomicBool, Ordering};

/// Makes the method of one trajectory.
type Make = for<'a> fn(
    &'a Segment<'a, f64>,
    &Cells<f64>,
    &Simulation,
    &'a AtomicBool,
) -> Box<dyn Advance<f64> + 'a>;

pub fn one_by_one(stretch: Stretch, make: Make) {
    let Stretch { simulation, watch, cancel, .. } = stretch;
    each_pack::<f64>(scalar_token(), stretch, |cells, segment, visit| {
        visit.drive(make(segment, cells, simulation, cancel), watch)
    });
}

pub fn dormand_prince<'a, Q: Dry>(
    segment: &'a Segment<'a, f64>,
    cells: &Cells<f64>,
    simulation: &Simulation,
    cancel: &'a AtomicBool,
) -> Box<dyn Advance<f64> + 'a> {
    let set = Q::set(&segment.contact, cells);
    let adaptive = simulation.method == Method::DormandPrince;
    let go_on = || !cancel.load(Ordering::Relaxed);
    let way = (adaptive, simulation.locate);
    Box::new(DormandPrince::<Q, _>::new(segment, set, way, go_on))
}
