//! Robots in a pipe: the wall force that makes a gait possible.

use super::Quantity;
use super::traction::or_else;
use crate::describe::Info;
use crate::lane::Lane;
use crate::{Point, Status};

/// Wall force per segment that the gait needs.
pub struct Preload;

impl Quantity for Preload {
    const INFO: Info = Info {
        name: "preload",
        symbol: r"Q_\mathrm{min}",
        unit: "N",
        formula: r"Q_\mathrm{min} = \frac{k m(\mu_C n_0 + g\sin\alpha) - (N-k)m(\mu_S n_0 - w g\sin\alpha)}{(N-k)\mu_S - k\mu_C(1-\lambda)},\quad n_0 = g\cos\alpha/\cos\beta",
        source: "derived; vertical pipe: N m g/((N-k) mu_S - k mu_C), or N m g/((N-k) mu_S) where movers release the wall",
        limits: "quasi-static; zero where the weight suffices; the given wall_force does not enter",
        meaning: "least force that must press each segment to the wall so that the gait moves",
        params: &[
            "mu_static",
            "mu_coulomb",
            "segments",
            "slope_deg",
            "mass",
            "gravity",
            "moving",
            "anchor_weight",
            "skin_ratio",
            "wall_release",
            "corner_deg",
        ],
        integer: false,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let zero = p.mass.splat(0.0);
        let mut bare = *p;
        bare.wall_force = zero;
        let anchors = p.segments - p.moving;
        let missing = p.mass * (p.moving * bare.drag() - anchors * bare.hold());
        let kept = p.mu_coulomb * (p.wall_release.splat(1.0) - p.wall_release);
        let gain = anchors * p.mu_anchor() - p.moving * kept;
        let needed = missing / L::select(gain.gt(zero), gain, zero.splat(1.0));
        let possible = L::or(gain.gt(zero), missing.le(zero));
        needed.max(zero).only_if(L::and(possible, anchors.gt(zero)))
    }

    fn status(p: &Point<f64>) -> Status {
        let status = if p.segments <= p.moving { Status::NothingAnchored } else { Status::Ok };
        or_else(status, Status::AnchorsTooWeak)
    }
}
