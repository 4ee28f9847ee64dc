//! The best segment count as a real number: equations (7) and (8), and beyond them.

use super::motion::why_no_phase;
use super::phase::{braking_works, phase};
use super::traction::{
    anchored_traction, grip_against_drive, is_limited, limited, limited_growth, traction,
};
use super::{Quantity, any_count};
use crate::describe::Info;
use crate::lane::Lane;
use crate::{Point, Status};

/// More segments than any answer has: what does not move with so many never does.
const ENDLESS: f64 = 1e300;
/// Doublings of a count from the least that moves before it is taken for endless.
const MOST_DOUBLINGS: u32 = 200;
/// Halvings that leave two neighbouring doubles of an interval whose upper end is
/// twice the lower one.
const HALVINGS: u32 = 54;

/// Continuous optimum of the segment count.
pub struct OptimalSegments;

impl Quantity for OptimalSegments {
    const INFO: Info = Info {
        name: "optimal_segments",
        symbol: r"N_\mathrm{opt}",
        unit: "1",
        formula: r"N_\mathrm{opt} = 2k\,\frac{(\mu_S + \mu_C)n + (1-w)g\sin\alpha}{\mu_S n - w g\sin\alpha};\quad \text{else } t_p = \frac{N}{\hat v}\left(\frac{s_a}{a}\frac{da}{dN} + \frac{s_b}{b}\frac{db}{dN}\right)",
        source: "paper, equations (7) and (8): the zero of d(mean velocity)/dN; with a brake, viscosity or a limit that acts: derived, s_a and s_b the paths of driving at a and braking at b",
        limits: "more than k and the anchors ahead; with a brake alone A G x^3 + (2(A - G)B - A G)x^2 - 3 B^2 x = B^2 for x = N/k - 1 (per mass: A what an anchor holds, G the same forward, B what drags a mover)",
        meaning: "segment count of highest mean velocity, as a real number",
        params: any_count!(
            "drive_limit",
            "anchors_ahead",
            "stroke",
            "speed_limit",
            "viscous",
            "brake"
        ),
        integer: false,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        if PLAIN {
            return ideal_optimum::<L, true>(p);
        }
        let ahead = p.anchors_ahead.gt(p.moving.splat(0.0));
        let least = p.moving + p.anchors_ahead;
        let ideal = unlimited(p);
        let ideal = L::select(ahead, ideal.max(least), ideal);
        let valid = L::and(anchors_stay(p), L::or(ahead, ideal.gt(p.moving)));
        let ideal = ideal.only_if(valid);
        let searched = L::and(anchors_stay(p), L::not(is_free(p, ideal)));
        if !L::any(searched) {
            return ideal;
        }
        let found = ideal.outlined(
            #[inline(always)]
            || search(p, least),
        );
        L::select(searched, found, ideal)
    }

    fn status(p: &Point<f64>) -> Status {
        // The count itself is what is asked for: too few segments are no reason.
        match why_no_phase(&p.with_segments(ENDLESS)) {
            Status::NotFinite => Status::NoOptimum,
            other => other,
        }
    }
}

/// Zero of d(mean velocity)/dN where nothing but the anchors limits the drive, be there
/// such a count or not.
#[inline(always)]
fn unlimited<L: Lane>(p: &Point<L>) -> L {
    let (hold, drag) = (p.hold(), p.drag());
    (p.moving + p.moving) * ((hold + drag) / hold)
}

/// The optimum without brake, viscosity and limits.
#[inline(always)]
pub fn ideal_optimum<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
    let optimum = unlimited(p);
    let stay = if PLAIN { p.hold().gt(p.hold().splat(0.0)) } else { anchors_stay(p) };
    // At N = k nothing moves: an "optimum" there or below is none.
    optimum.only_if(L::and(stay, optimum.gt(p.moving)))
}

/// Whether anchors, if there are some, stay where they are without a drive.
#[inline(always)]
fn anchors_stay<L: Lane>(p: &Point<L>) -> L::Mask {
    let zero = p.moving.splat(0.0);
    L::and(p.hold().gt(zero), grip_against_drive(p).gt(zero))
}

/// Anchors that hold the movers under an ideal drive, as a real number.
#[inline(always)]
pub fn needed_anchors<L: Lane>(p: &Point<L>) -> L {
    let zero = p.moving.splat(0.0);
    let need = p.moving * (p.drag() / p.hold());
    L::select(need.gt(zero), need, zero)
}

/// Whether nothing but the anchors limits the drive with `n` segments. The mean velocity
/// has one peak over N and limits only lower it, so a peak that they leave is the peak.
#[inline(always)]
fn is_free<L: Lane>(p: &Point<L>, n: L) -> L::Mask {
    let zero = n.splat(0.0);
    let at = p.with_segments(n);
    let mean_speed = (anchored_traction(&at).acceleration * (p.stroke * 0.5)).root();
    let is_fast = p.speed_limit.lt(mean_speed + mean_speed);
    let is_held = L::or(is_limited(&at, p.hold()), is_fast);
    let is_slowed = L::or(p.brake.gt(zero), p.viscous.gt(zero));
    L::not(L::or(is_slowed, is_held))
}

/// Whether the mean velocity rises with the segment count, or nothing moves yet.
///
/// It is k d/(N t) for a phase time t, so it rises where -dt/dN > t/N. With the top speed
/// V kept, driving at a up to V and braking from it at b take dv/(a - r v) and
/// dv/(b + r v) (r = viscous/mass); by parts that gives dt/da = -s_a/(a V) and
/// dt/db = -s_b/(b V) with the paths s_a and s_b, whether V is a limit or a peak.
#[inline(always)]
fn rises<L: Lane>(p: &Point<L>, n: L) -> L::Mask {
    let zero = n.splat(0.0);
    let at = p.with_segments(n);
    let traction = anchored_traction(&at);
    let phase = phase::<L, false>(&at, &traction);
    let driven = phase.driven_path / traction.acceleration;
    let mut gain = driven * limited_growth(&at, p.hold());
    let braked = p.brake.gt(zero);
    if L::any(braked) {
        let grip = grip_against_drive(p);
        let braking_path = p.stroke - phase.driven_path - phase.cruise_path;
        let stopped = braking_path / (limited(&at, grip) + traction.drag);
        gain = gain + L::select(braked, stopped * limited_growth(&at, grip), zero);
    }
    let time = p.stroke / phase.mean_speed;
    L::or(L::not(phase.mean_speed.not_nan()), (phase.peak_speed * time).lt(n * gain))
}

/// Bisection for the count beyond which the mean velocity falls, from `least` on.
#[inline(always)]
fn search<L: Lane>(p: &Point<L>, least: L) -> L {
    let zero = least.splat(0.0);
    let endless = p.with_segments(zero.splat(ENDLESS));
    let stops = L::or(p.brake.le(zero), braking_works(&endless));
    let moves = L::and(traction::<L, false>(&endless).acceleration.not_nan(), stops);
    let start = least.max(p.moving + needed_anchors(p));
    let has_peak = L::and(moves, rises(p, start));
    let (mut low, mut high) = (start, start + start);
    for _ in 0..MOST_DOUBLINGS {
        let open = L::and(has_peak, rises(p, high));
        if !L::any(open) {
            break;
        }
        low = L::select(open, high, low);
        high = L::select(open, high + high, high);
    }
    for _ in 0..HALVINGS {
        let middle = (low + high) * 0.5;
        let rises = rises(p, middle);
        low = L::select(rises, middle, low);
        high = L::select(rises, high, middle);
    }
    // Anchors ahead alone may move the robot: then none behind is best.
    let at_least = L::and(p.anchors_ahead.gt(zero), L::and(moves, start.le(least)));
    L::select(has_peak, high, least.only_if(at_least))
}
