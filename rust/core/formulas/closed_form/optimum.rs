//! The best whole segment count and the steepest slope.

use super::continuous::{ideal_optimum, needed_anchors};
use super::motion::{MeanVelocity, why_no_phase};
use super::phase::braking_works;
use super::traction::{or_else, traction};
use super::{Quantity, any_count};
use crate::describe::Info;
use crate::lane::Lane;
use crate::point::columns;
use crate::{ParamId, Point, Status};

/// Relative difference below which two velocities are a tie; the lower count wins.
pub const TIE: f64 = 1e-12;

/// Best whole segment count.
pub struct BestSegments;

impl Quantity for BestSegments {
    const INFO: Info = Info {
        name: "best_segments",
        symbol: r"N^*",
        unit: "1",
        formula: r"N^* = \min\{N : \bar v(N) \ge (1-10^{-12})\,\bar v(M)\ \forall M\},\quad N_\mathrm{min} \le N, M \le N_\mathrm{max}",
        source: "derived: mean velocity has one peak over N, so the first N that its successor does not beat is the best",
        limits: "segments_min and segments_max bound the search; a tie goes to the lower count",
        meaning: "whole segment count of highest mean velocity",
        params: any_count!(
            "drive_limit",
            "anchors_ahead",
            "stroke",
            "speed_limit",
            "viscous",
            "brake",
            "segments_min",
            "segments_max"
        ),
        integer: true,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        if PLAIN { plain_best(p) } else { searched_best(p) }
    }

    fn status(p: &Point<f64>) -> Status {
        if p.segments_min > p.segments_max {
            return Status::EmptyRange;
        }
        why_no_phase(&p.with_segments(p.segments_max))
    }
}

/// Floor or ceiling of the continuous optimum, by comparing both. The optimum
/// is at least 2k here, and both neighbours lie above half of it, so both move.
#[inline(always)]
fn plain_best<L: Lane>(p: &Point<L>) -> L {
    let one = p.moving.splat(1.0);
    let (hold, drag) = (p.hold(), p.drag());
    let both = hold + drag;
    let optimum = (p.moving + p.moving) * (both / hold);
    let low = optimum.floor().max(p.segments_min).min(p.segments_max);
    let high = (low + one).min(p.segments_max);
    // v^2 is proportional to (A N/k - A - B)/N^2: compared without a division.
    let hold = hold * p.per_moving;
    let push = |n: L| hold.mul_add(n, -both);
    let (low_push, high_push) = (push(low), push(high));
    let rises = (high_push * (low * low)).gt(low_push * (high * high) * (1.0 + 2.0 * TIE));
    let best = L::select(rises, high, low);
    let pushed = L::select(rises, high_push, low_push).gt(one.splat(0.0));
    let moves = L::and(pushed, best.gt(p.moving));
    best.only_if(L::and(L::and(moves, hold.gt(one.splat(0.0))), p.segments_min.le(p.segments_max)))
}

/// Whether a robot of `n` segments moves at all.
#[inline(always)]
fn moves<L: Lane>(p: &Point<L>, n: L) -> L::Mask {
    traction::<L, false>(&p.with_segments(n)).acceleration.not_nan()
}

/// Bisection for the first count that its successor does not beat, above the
/// last one that cannot move.
#[inline(always)]
fn searched_best<L: Lane>(p: &Point<L>) -> L {
    let one = p.moving.splat(1.0);
    let zero = one.splat(0.0);
    let never = zero.splat(f64::NEG_INFINITY);
    // Rounding may have put it one too low.
    let least = (p.moving + needed_anchors(p)).floor() + one;
    let least = least.max(p.moving + p.anchors_ahead.max(one)).max(p.segments_min);
    let least = L::select(moves(p, least), least, least + one);
    let (mut low, mut high) = (least, p.segments_max.min(most(p)).max(least));
    // 2^20 is above the largest count allowed.
    for _ in 0..20 {
        let open = low.lt(high);
        if !L::any(open) {
            break;
        }
        let middle = ((low + high) * 0.5).floor();
        // Too few anchors to move: the best count is a larger one.
        let slow = MeanVelocity::value::<L, false>(&p.with_segments(middle));
        let slow = L::select(slow.not_nan(), slow, never);
        let fast = MeanVelocity::value::<L, false>(&p.with_segments(middle + one));
        let rises = L::or(slow.le(never), fast.gt(slow * (1.0 + TIE)));
        low = L::select(L::and(open, rises), middle + one, low);
        high = L::select(L::and(open, rises), high, L::select(open, middle, high));
    }
    let stops = L::or(p.brake.le(zero), braking_works(&p.with_segments(low)));
    let in_range = L::and(low.le(p.segments_max), p.segments_min.le(p.segments_max));
    low.only_if(L::and(L::and(moves(p, low), stops), in_range))
}

/// A count that is surely not below the best one. A head block under limits of
/// force and speed gains less from a further segment than one without, so its
/// optimum lies below the continuous one; viscosity, a brake or a second joint
/// may move it beyond any bound.
#[inline(always)]
fn most<L: Lane>(p: &Point<L>) -> L {
    let zero = p.moving.splat(0.0);
    let ideal = ideal_optimum::<L, false>(p).floor() + 2.0;
    let others = L::or(p.brake.gt(zero), p.anchors_ahead.gt(zero));
    let bounded = L::and(ideal.not_nan(), p.viscous.le(zero));
    let bound = L::select(bounded, ideal, zero.splat(f64::INFINITY));
    L::select(others, zero.splat(f64::INFINITY), bound)
}

/// Mean velocity at the best whole segment count.
pub struct BestVelocity;

impl Quantity for BestVelocity {
    const INFO: Info = Info {
        name: "best_velocity",
        symbol: r"\bar v^*",
        unit: "m/s",
        formula: r"\bar v^* = \bar v(N^*)",
        source: "derived from equations (5) to (8)",
        limits: "as best_segments",
        meaning: "mean velocity with the best whole segment count",
        params: BestSegments::INFO.params,
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let best = BestSegments::value::<L, PLAIN>(p);
        MeanVelocity::value::<L, PLAIN>(&p.with_segments(best))
    }

    fn status(p: &Point<f64>) -> Status {
        BestSegments::status(p)
    }
}

/// Steepest slope that the robot climbs.
pub struct SlopeLimitDeg;

impl Quantity for SlopeLimitDeg {
    const INFO: Info = Info {
        name: "slope_limit_deg",
        symbol: r"\alpha_\mathrm{max}",
        unit: "deg",
        formula: r"\tan\alpha_\mathrm{max} = \frac{(N-k)\mu_S - k\mu_C}{k + w(N-k)} \text{ without wall force and drive limit}",
        source: "derived: acceleration zero; w = 1: tan a = mu_S - (k/N)(mu_S + mu_C)",
        limits: "the lower one of what the anchors hold and what the drive lifts; no value where the robot cannot move on the flat; 90 where nothing limits it",
        meaning: "steepest slope on which the robot still moves up",
        params: &[
            "mu_static",
            "mu_coulomb",
            "segments",
            "mass",
            "gravity",
            "moving",
            "anchor_weight",
            "skin_ratio",
            "wall_force",
            "wall_release",
            "corner_deg",
            "drive_limit",
            "anchors_ahead",
        ],
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        p.segments.fill(
            #[inline(always)]
            |i| slope_limit(&p.lane(i)),
        )
    }

    fn status(p: &Point<f64>) -> Status {
        let mut flat = *p;
        (flat.cos_slope, flat.sin_slope) = (1.0, 0.0);
        or_else(super::traction::why_no_motion(&flat), Status::NotFinite)
    }
}

/// Never inlined into a vector kernel: it is scalar and not on a hot path.
#[inline(never)]
fn slope_limit(p: &Point<f64>) -> f64 {
    let moves = |degrees: f64| {
        let [cos, sin] = columns(ParamId::SlopeDeg, degrees);
        let mut at = *p;
        (at.cos_slope, at.sin_slope) = (cos, sin);
        !traction::<f64, false>(&at).acceleration.is_nan()
    };
    if !moves(0.0) {
        return f64::NAN;
    }
    let ratio = p.anchor_ratio();
    if p.drive_limit.is_infinite() && p.wall_force == 0.0 {
        let lift = ratio * p.mu_anchor() - p.mu_coulomb;
        let pull = ratio.mul_add(p.anchor_weight, 1.0);
        return libm::atan(lift * p.per_cos_corner / pull).to_degrees();
    }
    // Push less drag is X cos + Y sin + Z with other coefficients according to
    // which joints are at their limit. The limits only cut it off (they add no
    // minimum), so it has its minima where a piece has one; between those it
    // crosses zero once at the most on its way down.
    let ahead = p.anchors_ahead * p.per_moving;
    let mut minima = [0.0, ahead, ratio - ahead, ratio].map(|held| {
        let along_cos = p.per_cos_corner * (held * p.mu_anchor() - p.mu_coulomb);
        let along_sin = held.mul_add(p.anchor_weight, 1.0);
        if along_cos < 0.0 { libm::atan2(along_sin, -along_cos).to_degrees() } else { 90.0 }
    });
    minima.sort_unstable_by(f64::total_cmp);
    let mut low = 0.0;
    for high in minima.into_iter().chain([90.0]) {
        if !moves(high) {
            return last_that(moves, low, high);
        }
        low = high;
    }
    90.0
}

/// Last number between `low`, for which `holds`, and `high`, for which it does
/// not: bisected down to neighbouring doubles.
fn last_that(holds: impl Fn(f64) -> bool, mut low: f64, mut high: f64) -> f64 {
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return low;
        }
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::traction::limited;
    use super::*;
    use crate::ParamId::*;

    #[test]
    fn limit_by_formula_and_by_bisection_agree() {
        for n in 2..30 {
            let given = [(MuStatic, 0.5), (MuCoulomb, 0.3), (Segments, f64::from(n))];
            let formula = slope_limit(&Point::of(&given));
            let mut limited = Point::of(&given);
            limited.drive_limit = 1e9;
            assert!((formula - slope_limit(&limited)).abs() < 1e-12, "N = {n}");
        }
        let stuck = Point::of(&[(MuStatic, 0.2), (MuCoulomb, 0.9), (Segments, 3.0)]);
        assert!(slope_limit(&stuck).is_nan());
        assert_eq!(SlopeLimitDeg::status(&stuck), Status::AnchorsTooWeak);
    }

    #[test]
    fn a_limited_drive_lifts_its_force() {
        // Frictionless mover: F = m g sin(alpha).
        let p = Point::of(&[(MuStatic, 5.0), (MuCoulomb, 0.0), (Segments, 4.0), (DriveLimit, 1.0)]);
        let expected = libm::asin(1.0 / (0.271 * 9.81)).to_degrees();
        assert!((slope_limit(&p) - expected).abs() < 1e-12);
        assert!((limited(&p, p.hold()) * 0.271 - 1.0).abs() < 1e-15);
    }
}
