//! Trajectories one by one, on plain numbers.

use super::packs::{Cells, Stretch, each_pack};
use crate::integrate::Method;
use crate::integrate::dormand_prince::DormandPrince;
use crate::integrate::dry_contact::{Bound, PlainContact};
use crate::lane::scalar_token;
use crate::physics::friction::Dry;
use crate::physics::segment::Segment;
use std::sync::atomic::Ordering;

/// Takes the coefficients of one trajectory.
type Bind = fn(&Segment<f64>, &Cells<f64>) -> Box<dyn PlainContact>;

pub fn dormand_prince(stretch: Stretch, bind: Bind) {
    let Stretch { simulation, watch, cancel, .. } = stretch;
    let adaptive = simulation.method == Method::DormandPrince;
    let go_on = || !cancel.load(Ordering::Relaxed);
    each_pack::<f64>(scalar_token(), stretch, |cells, segment, visit| {
        let contact = bind(segment, cells);
        let direction = (adaptive, simulation.locate);
        visit.drive(DormandPrince::new(segment, &*contact, direction, go_on), watch)
    });
}

pub fn bind<Q: Dry>(segment: &Segment<f64>, cells: &Cells<f64>) -> Box<dyn PlainContact> {
    Box::new(Bound::<Q, f64>(Q::coefficients(&segment.contact, cells)))
}
