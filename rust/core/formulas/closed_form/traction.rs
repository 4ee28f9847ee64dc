//! What pushes a moving segment and whether it moves at all.

use crate::lane::Lane;
use crate::{Point, Status};

/// Accelerations at or below this are no motion: the stroke would take longer
/// than any number can tell.
const LEAST_ACCELERATION: f64 = 1e-150;

/// Forces on one moving segment, per mass.
pub struct Traction<L> {
    /// Share of the drive force.
    pub push: L,
    /// Friction and weight that oppose it.
    pub drag: L,
    /// Acceleration; NaN where the robot cannot move.
    pub acceleration: L,
}

/// Acceleration by a drive that pulls what the anchors hold, for comparisons
/// between PLAIN points: negative where the robot does not move, -inf where the
/// anchors slide. Both decisions then leave the loop over rivals.
#[inline(always)]
pub fn plain_acceleration<L: Lane>(p: &Point<L>) -> L {
    let hold = p.hold();
    let hold = L::select(hold.gt(hold.splat(0.0)), hold, hold.splat(f64::NEG_INFINITY));
    p.anchor_ratio().mul_add(hold, -p.drag())
}

/// Traction of movers that have anchors, or none but are thought to.
#[inline(always)]
pub fn anchored_traction<L: Lane>(p: &Point<L>) -> Traction<L> {
    let (hold, drag) = (p.hold(), p.drag());
    let push = limited(p, hold);
    // Where no joint is at its limit the push is what the anchors hold, and one
    // rounding less gives the bits of a plain point.
    let free = p.anchor_ratio().mul_add(hold, -drag);
    let acceleration = L::select(is_limited(p, hold), push - drag, free);
    let moves = acceleration.gt(drag.splat(LEAST_ACCELERATION));
    Traction { push, drag, acceleration: acceleration.only_if(moves) }
}

#[inline(always)]
pub fn traction<L: Lane, const PLAIN: bool>(p: &Point<L>) -> Traction<L> {
    let (hold, drag) = (p.hold(), p.drag());
    let (push, acceleration, anchored) = if PLAIN {
        let free = p.anchor_ratio().mul_add(hold, -drag);
        (p.anchor_ratio() * hold, free, hold.gt(hold.splat(0.0)))
    } else {
        let Traction { push, acceleration, .. } = anchored_traction(p);
        (push, acceleration, L::and(anchored(p), has_room_ahead(p)))
    };
    let moves = L::and(anchored, acceleration.gt(drag.splat(LEAST_ACCELERATION)));
    Traction { push, drag, acceleration: acceleration.only_if(moves) }
}

/// The force that the joints at both ends of the moving block put on one
/// moving segment, per mass: each joint gives at most its actuator's limit and
/// at most what the anchors on its side hold (`grip` per anchor).
#[inline(always)]
pub fn limited<L: Lane>(p: &Point<L>, grip: L) -> L {
    let (limit, ahead, behind) = joints(p, grip);
    limit.min(ahead) + limit.min(behind)
}

/// Whether a joint's actuator, not the anchors, decides its force.
#[inline(always)]
pub fn is_limited<L: Lane>(p: &Point<L>, grip: L) -> L::Mask {
    let (limit, ahead, behind) = joints(p, grip);
    L::or(limit.lt(ahead), limit.lt(behind))
}

/// Growth by the segment count of what `limited` gives: that of the anchors behind,
/// until their joint is at its limit.
#[inline(always)]
pub fn limited_growth<L: Lane>(p: &Point<L>, grip: L) -> L {
    let (limit, _, behind) = joints(p, grip);
    L::select(behind.lt(limit), p.per_moving * grip, grip.splat(0.0))
}

/// Limit of a joint and what the anchors on either side hold, per moving mass.
#[inline(always)]
fn joints<L: Lane>(p: &Point<L>, grip: L) -> (L, L, L) {
    let limit = (p.drive_limit * p.per_mass) * p.per_moving;
    let ahead = (p.anchors_ahead * p.per_moving) * grip;
    let behind = ((p.segments - p.moving - p.anchors_ahead) * p.per_moving) * grip;
    (limit, ahead, behind)
}

/// Whether there are anchors and they stay where they are without a drive.
#[inline(always)]
pub fn anchored<L: Lane>(p: &Point<L>) -> L::Mask {
    let zero = p.segments.splat(0.0);
    let stay = L::and(p.hold().gt(zero), grip_against_drive(p).gt(zero));
    L::and(stay, p.segments.gt(p.moving))
}

/// Whether the block can have as many anchors ahead as asked for.
#[inline(always)]
pub fn has_room_ahead<L: Lane>(p: &Point<L>) -> L::Mask {
    p.anchors_ahead.le(p.segments - p.moving)
}

/// What one anchor holds against being pulled forward, per mass.
#[inline(always)]
pub fn grip_against_drive<L: Lane>(p: &Point<L>) -> L {
    p.mu_anchor().mul_add(p.anchor_normal(), p.anchor_pull())
}

/// Why the anchors are none, or `Ok`.
pub fn why_not_anchored(p: &Point<f64>) -> Status {
    let anchors = p.segments - p.moving;
    if anchors <= 0.0 {
        Status::NothingAnchored
    } else if p.anchors_ahead > anchors {
        Status::NoRoomAhead
    } else if p.hold() <= 0.0 {
        Status::SlidesBack
    } else if grip_against_drive(p) <= 0.0 {
        Status::SlidesDown
    } else {
        Status::Ok
    }
}

/// Why the robot does not move, or `Ok`.
pub fn why_no_motion(p: &Point<f64>) -> Status {
    match why_not_anchored(p) {
        Status::Ok => {}
        other => return other,
    }
    if p.anchor_ratio() * p.hold() - p.drag() <= LEAST_ACCELERATION {
        Status::AnchorsTooWeak
    } else if traction::<f64, false>(p).acceleration.is_nan() {
        Status::DriveTooWeak
    } else {
        Status::Ok
    }
}

/// `status`, or `otherwise` where nothing stands in the way of a value but the
/// formula itself.
pub fn or_else(status: Status, otherwise: Status) -> Status {
    if status == Status::Ok { otherwise } else { status }
}
