//! Forces: equations (1) to (4) of the paper and friction over velocity.

use super::traction::{anchored, has_room_ahead, or_else, why_not_anchored};
use super::{Quantity, anchors, ground};
use crate::describe::Info;
use crate::lane::Lane;
use crate::{Point, Status};

/// Gross force that all anchors together hold.
pub struct AnchorCapacity;

impl Quantity for AnchorCapacity {
    const INFO: Info = Info {
        name: "anchor_capacity",
        symbol: r"F_A",
        unit: "N",
        formula: r"F_A = (N-k)\,m\,(\mu_S n - w g\sin\alpha),\quad n = g\cos\alpha/\cos\beta + Q/m",
        source: "paper, equations (2) to (4) with k = 1; slope terms reconstructed (w = 1: variant A, w = 0: variant B)",
        limits: "static friction of the anchors only; no value where they slide on the slope by themselves",
        meaning: "force that the anchored segments hold together",
        params: anchors!(),
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let capacity = ((p.segments - p.moving) * p.mass) * p.hold();
        if PLAIN {
            return capacity.only_if(p.hold().gt(capacity.splat(0.0)));
        }
        capacity.only_if(anchored(p))
    }

    fn status(p: &Point<f64>) -> Status {
        or_else(why_not_anchored(p), Status::NotFinite)
    }
}

/// Force that drives the moving block.
pub struct PropulsiveForce;

impl Quantity for PropulsiveForce {
    const INFO: Info = Info {
        name: "propulsive_force",
        symbol: r"F_P",
        unit: "N",
        formula: r"F_P = \sum_{\mathrm{joints}}\min(F_\mathrm{max},\,F_A^{\mathrm{side}});\quad F_P = F_A \text{ without a limit}",
        source: "paper, equations (2) to (4); the limit of the joints: derived",
        limits: "the drive never pulls more than the anchors hold; see slip_ratio for a drive that does",
        meaning: "force that drives the moving segments, gross of their own friction",
        params: anchors!("drive_limit", "anchors_ahead"),
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        if PLAIN {
            return AnchorCapacity::value::<L, true>(p);
        }
        let behind = ((p.segments - p.moving - p.anchors_ahead) * p.mass) * p.hold();
        let ahead = (p.anchors_ahead * p.mass) * p.hold();
        let force = p.drive_limit.min(ahead) + p.drive_limit.min(behind);
        force.only_if(L::and(anchored(p), has_room_ahead(p)))
    }

    fn status(p: &Point<f64>) -> Status {
        AnchorCapacity::status(p)
    }
}

/// Friction and weight of the moving block.
pub struct Resistance;

impl Quantity for Resistance {
    const INFO: Info = Info {
        name: "resistance",
        symbol: r"F_R",
        unit: "N",
        formula: r"F_R = k\,m\,(\mu_C n + g\sin\alpha)",
        source: "paper, equation (1), the terms that oppose the motion",
        limits: "without viscous friction; negative where the slope itself drives",
        meaning: "force that the moving segments need to keep moving slowly",
        params: &[
            "mu_coulomb",
            "slope_deg",
            "mass",
            "gravity",
            "moving",
            "wall_force",
            "wall_release",
            "corner_deg",
        ],
        integer: false,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        (p.moving * p.mass) * p.drag()
    }

    fn status(_: &Point<f64>) -> Status {
        Status::NotFinite
    }
}

/// Propulsive force less friction and weight of the moving block.
pub struct NetForce;

impl Quantity for NetForce {
    const INFO: Info = Info {
        name: "net_force",
        symbol: r"F_\mathrm{net}",
        unit: "N",
        formula: r"F_\mathrm{net} = F_P - F_R",
        source: "paper, equation (1), right side; 3.19 N for the paper's robot (mu 0.5/0.3, four segments)",
        limits: "negative: that much is missing before anything moves",
        meaning: "force left to accelerate the moving segments",
        params: ground!("drive_limit", "anchors_ahead"),
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        PropulsiveForce::value::<L, PLAIN>(p) - Resistance::value::<L, PLAIN>(p)
    }

    fn status(p: &Point<f64>) -> Status {
        AnchorCapacity::status(p)
    }
}

/// Friction force of one sliding segment over its speed.
pub struct FrictionForce;

impl Quantity for FrictionForce {
    const INFO: Info = Info {
        name: "friction_force",
        symbol: r"F_f",
        unit: "N",
        formula: r"F_f = \mu_C\,m\,n\,\mathrm{sgn}(v) + \mu_V v",
        source: "paper, Figures 7 to 9 (Coulomb, and Coulomb with viscous friction)",
        limits: "sliding only: at v = 0 friction takes any value up to break-away",
        meaning: "friction force on one sliding segment, positive against forward motion",
        params: &[
            "mu_coulomb",
            "slope_deg",
            "mass",
            "gravity",
            "viscous",
            "wall_force",
            "wall_release",
            "corner_deg",
            "speed",
        ],
        integer: false,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let zero = p.speed.splat(0.0);
        let dry = p.mu_coulomb * (p.mass * p.mover_normal());
        let signed = L::select(p.speed.lt(zero), -dry, dry);
        let force = p.viscous.mul_add(p.speed, signed);
        force.only_if(L::or(p.speed.lt(zero), p.speed.gt(zero)))
    }

    fn status(p: &Point<f64>) -> Status {
        if p.speed == 0.0 { Status::SetValued } else { Status::NotFinite }
    }
}

/// Whether the robot moves at all.
pub struct Feasible;

impl Quantity for Feasible {
    const INFO: Info = Info {
        name: "feasible",
        symbol: r"\chi",
        unit: "1",
        formula: r"\chi = [\,a > 0\,]",
        source: "derived: N/k > ((\\mu_S+\\mu_C)n + (1-w) g sin a)/(\\mu_S n - w g sin a), half the optimal N/k",
        limits: "as acceleration; its mean over uncertain friction is the chance to move",
        meaning: "1 where the robot moves, 0 where it does not",
        params: ground!("drive_limit", "anchors_ahead"),
        integer: true,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let moves = super::traction::traction::<L, PLAIN>(p).acceleration.not_nan();
        L::select(moves, p.mu_static.splat(1.0), p.mu_static.splat(0.0))
    }

    fn status(_: &Point<f64>) -> Status {
        Status::NotFinite
    }
}

/// Anchor capacity over the resistance of the movers.
pub struct AnchorReserve;

impl Quantity for AnchorReserve {
    const INFO: Info = Info {
        name: "anchor_reserve",
        symbol: r"R_A",
        unit: "1",
        formula: r"R_A = F_A/F_R",
        source: "derived: the robot can move where it exceeds 1, that is N/k beyond half the optimum",
        limits: "quasi-static; unbounded where nothing opposes the movers",
        meaning: "how many times the anchors hold what the moving segments need",
        params: ground!(),
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let drag = p.drag();
        let opposed = L::and(anchored(p), drag.gt(drag.splat(0.0)));
        (p.anchor_ratio() * p.hold() / drag).only_if(opposed)
    }

    fn status(p: &Point<f64>) -> Status {
        or_else(why_not_anchored(p), Status::Unbounded)
    }
}

/// The joints' demand: what a drive without regard for the anchors pulls.
#[inline(always)]
pub fn demand<L: Lane>(p: &Point<L>) -> L {
    let zero = p.drive_limit.splat(0.0);
    let both = p.drive_limit + p.drive_limit;
    let asked = L::select(p.anchors_ahead.gt(zero), both, p.drive_limit);
    let capacity = ((p.segments - p.moving) * p.mass) * p.hold();
    // Without a limit the drive is one that pulls just what the anchors hold.
    let is_ideal = p.drive_limit.ge(zero.splat(f64::INFINITY));
    L::select(is_ideal, capacity, asked)
}

/// Anchor capacity over the drive force.
pub struct AnchorSafety;

impl Quantity for AnchorSafety {
    const INFO: Info = Info {
        name: "anchor_safety",
        symbol: r"S_A",
        unit: "1",
        formula: r"S_A = F_A/F,\quad F = F_\mathrm{max}\text{ per driven joint}",
        source: "derived; snakes in channels press four times harder than needed (Marvi and Hu 2012, doi 10.1098/rsif.2012.0132)",
        limits: "below 1 the anchors slip (see slip_ratio); without a drive limit the drive is taken to pull what the anchors hold, and the factor is 1",
        meaning: "safety factor of the anchors against the full drive force",
        params: anchors!("drive_limit", "anchors_ahead"),
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let capacity = ((p.segments - p.moving) * p.mass) * p.hold();
        let demand = demand(p);
        let anchored = L::and(anchored(p), has_room_ahead(p));
        let pulls = L::and(anchored, demand.gt(demand.splat(0.0)));
        (capacity / demand).only_if(pulls)
    }

    fn status(p: &Point<f64>) -> Status {
        or_else(why_not_anchored(p), Status::Unbounded)
    }
}

/// Keeps the unlimited and the limited force in step: both routes are tested
/// to agree where the limit is far away.
#[cfg(test)]
mod tests {
    use super::super::traction::limited;
    use super::*;
    use crate::ParamId::*;

    #[test]
    fn share_per_mass_and_total_force_agree() {
        let p = Point::of(&[
            (MuStatic, 0.5),
            (MuCoulomb, 0.3),
            (Segments, 7.0),
            (Moving, 2.0),
            (AnchorsAhead, 3.0),
            (DriveLimit, 1.5),
            (SlopeDeg, 7.0),
        ]);
        let total = PropulsiveForce::value::<f64, false>(&p);
        let share = limited(&p, p.hold()) * p.moving * p.mass;
        assert!((total / share - 1.0).abs() < 1e-14);
    }
}
