//! What happens when the drive pulls more than the anchors hold.

use super::forces::demand;
use super::traction::{anchored, has_room_ahead, or_else, why_not_anchored};
use super::{Quantity, ground};
use crate::describe::Info;
use crate::lane::Lane;
use crate::{Point, Status};

const SLIP_PARAMS: &[&str] =
    ground!("drive_limit", "anchors_ahead", "stroke", "speed_limit", "viscous", "brake");

/// The two accelerations of a robot whose anchors slip, forward and backward, per full
/// drive force, and whether they do slip.
struct Slip<L: Lane> {
    forward: L,
    backward: L,
    slips: L::Mask,
}

#[inline(always)]
fn slip<L: Lane>(p: &Point<L>) -> Slip<L> {
    let force = demand(p);
    let anchors = p.segments - p.moving;
    let forward = (force * p.per_mass) * p.per_moving - p.drag();
    let kinetic = (p.mu_coulomb * p.skin_ratio).mul_add(p.anchor_normal(), -p.anchor_pull());
    let backward = (force * p.per_mass) / anchors - kinetic;
    let capacity = (anchors * p.mass) * p.hold();
    let slips = L::and(force.gt(capacity), backward.gt(force.splat(0.0)));
    Slip { forward, backward, slips }
}

/// Whether what the two accelerations leave out acts: a brake, viscosity, or the speed
/// limit that the joint reaches within its stroke.
#[inline(always)]
fn is_changed<L: Lane>(p: &Point<L>, slip: &Slip<L>) -> L::Mask {
    let zero = p.stroke.splat(0.0);
    let relative = slip.forward + slip.backward;
    let fast = (p.speed_limit * p.speed_limit).lt(relative * (p.stroke + p.stroke));
    L::or(fast, L::or(p.brake.gt(zero), p.viscous.gt(zero)))
}

/// Share of a stroke that the anchors lose by sliding back in one phase.
pub struct SlipRatio;

impl Quantity for SlipRatio {
    const INFO: Info = Info {
        name: "slip_ratio",
        symbol: r"s_b/\delta",
        unit: "1",
        formula: r"s_b/\delta = \frac{a_b}{a_f + a_b},\quad a_f = \frac{F}{km} - \mu_C n - g\sin\alpha,\quad a_b = \frac{F}{(N-k)m} - \rho\mu_C n + w g\sin\alpha",
        source: "derived; N = 4, mu 0.5/0.3, 5 N: mover +15.507, anchors -3.207 m/s^2",
        limits: "full drive force throughout; zero where the anchors hold; speeds left over at the end of a phase are ignored; no value where anchors slip and a brake, viscosity or the speed limit acts",
        meaning: "backward slip of the anchors in one phase over the stroke",
        params: SLIP_PARAMS,
        integer: false,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let zero = p.mass.splat(0.0);
        let slip = slip(p);
        let Slip { forward, backward, slips } = slip;
        let ratio = L::select(slips, backward / (forward + backward), zero);
        let anchored = L::and(anchored(p), has_room_ahead(p));
        let ratio = ratio.only_if(L::and(anchored, forward.gt(zero)));
        if PLAIN {
            return ratio;
        }
        ratio.only_if(L::not(L::and(slips, is_changed(p, &slip))))
    }

    fn status(p: &Point<f64>) -> Status {
        // Anchors that cannot hold slip here.
        let moves = slip(p).forward > 0.0;
        let otherwise = if moves { Status::NoClosedForm } else { Status::DriveTooWeak };
        or_else(why_not_anchored(p), otherwise)
    }
}

/// Advance of the robot in one cycle.
pub struct NetAdvance;

impl Quantity for NetAdvance {
    const INFO: Info = Info {
        name: "net_advance",
        symbol: r"\Delta x",
        unit: "m",
        formula: r"\Delta x = \delta - (N/k)\,s_b",
        source: "derived: a mover advances by d - s_b and loses s_b in every other phase; 6.290 mm for the case of slip_ratio at 20 mm",
        limits: "as slip_ratio; negative where the robot slides back more than it advances",
        meaning: "advance of the robot in one gait cycle",
        params: SLIP_PARAMS,
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let slip = SlipRatio::value::<L, PLAIN>(p) * p.stroke;
        (-(p.segments * p.per_moving)).mul_add(slip, p.stroke)
    }

    fn status(p: &Point<f64>) -> Status {
        SlipRatio::status(p)
    }
}
