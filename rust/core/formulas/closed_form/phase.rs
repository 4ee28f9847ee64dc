//! One phase: from rest over the stroke, with or without viscous friction, a
//! speed limit and a brake.

use super::traction::{Traction, grip_against_drive, limited};
use crate::Point;
use crate::lane::Lane;
use crate::lane::exp::{log_factor, log_path_factor, path_factor, speed_factor};

/// How the moving segments cover one stroke. All NaN where they don't.
pub struct Phase<L> {
    /// Stroke over phase time.
    pub mean_speed: L,
    pub peak_speed: L,
    /// Path under full drive force.
    pub driven_path: L,
    /// Path at the speed limit.
    pub cruise_path: L,
}

#[inline(always)]
pub fn phase<L: Lane, const PLAIN: bool>(p: &Point<L>, traction: &Traction<L>) -> Phase<L> {
    let acceleration = traction.acceleration;
    let half_stroke = p.stroke * 0.5;
    if PLAIN {
        let mean_speed = (acceleration * half_stroke).root();
        return Phase {
            mean_speed,
            peak_speed: mean_speed + mean_speed,
            driven_path: p.stroke,
            cruise_path: p.stroke.splat(0.0),
        };
    }
    p.stroke.outlined(
        #[inline(always)]
        || general_phase(p, traction),
    )
}

#[inline(always)]
fn general_phase<L: Lane>(p: &Point<L>, traction: &Traction<L>) -> Phase<L> {
    let acceleration = traction.acceleration;
    let zero = p.stroke.splat(0.0);
    let braked = p.brake.gt(zero);
    let braking = (limited(p, grip_against_drive(p)) + traction.drag).only_if(
        // Only a brake that is used may fail.
        L::or(p.brake.le(zero), braking_works(p)),
    );
    let dry = dry_phase(p, acceleration, L::select(braked, braking, zero), braked);
    if !L::any(p.viscous.gt(zero)) {
        return dry;
    }
    let wet = viscous_phase(p, acceleration, braking, braked);
    let is_wet = p.viscous.gt(zero);
    Phase {
        mean_speed: L::select(is_wet, wet.mean_speed, dry.mean_speed),
        peak_speed: L::select(is_wet, wet.peak_speed, dry.peak_speed),
        driven_path: L::select(is_wet, wet.driven_path, dry.driven_path),
        cruise_path: L::select(is_wet, wet.cruise_path, dry.cruise_path),
    }
}

/// Whether anchors, capped by the actuator, could stop the movers.
#[inline(always)]
pub fn braking_works<L: Lane>(p: &Point<L>) -> L::Mask {
    (limited(p, grip_against_drive(p)) + p.drag()).gt(p.stroke.splat(0.0))
}

/// Constant acceleration, cruise at the speed limit, constant braking. With
/// 1/a' = 1/a + 1/b the braked phase has the same formulas as the unbraked one.
#[inline(always)]
fn dry_phase<L: Lane>(p: &Point<L>, acceleration: L, braking: L, braked: L::Mask) -> Phase<L> {
    let both = acceleration * braking / (acceleration + braking);
    let effective = L::select(braked, both, acceleration);
    let free_mean = (effective * (p.stroke * 0.5)).root();
    let free_peak = free_mean + free_mean;
    let limited = p.speed_limit.lt(free_peak);
    let top = L::select(limited, p.speed_limit, free_peak);
    let time = p.stroke / top + top / (effective + effective);
    Phase {
        mean_speed: L::select(limited, p.stroke / time, free_mean),
        peak_speed: top,
        driven_path: L::select(
            limited,
            top * top / (acceleration + acceleration),
            p.stroke * (effective / acceleration),
        ),
        cruise_path: L::select(
            limited,
            p.stroke - top * top / (effective + effective),
            p.stroke.splat(0.0),
        ),
    }
}

/// The same with viscous friction: path(t) = a t^2 E2(t/tau) under drive, then
/// v^2/b M(v/(b tau)) under the brake, solved for the driven time t.
///
/// The path is convex in t, so Newton's method overshoots at most once and then
/// falls on the root from above; it needs no bracket.
#[inline(always)]
fn viscous_phase<L: Lane>(p: &Point<L>, acceleration: L, braking: L, braked: L::Mask) -> Phase<L> {
    let zero = p.stroke.splat(0.0);
    let rate = p.viscous * p.per_mass;
    let brake = (rate, braking, braked, L::any(braked));
    // Without viscosity and limits the stroke would take this long.
    let mut t = ((p.stroke + p.stroke) / acceleration).sqrt();
    for _ in 0..100 {
        let v = acceleration * t * speed_factor(rate * t);
        let path = acceleration * t * t * path_factor(rate * t) + braking_path(brake, v);
        let braked_slope = v * (acceleration + braking) / rate.mul_add(v, braking);
        let step = (path - p.stroke) / L::select(braked, braked_slope, v);
        // A lane that is done stays as it is, or its bits would depend on how
        // long its neighbours take.
        let open = step.abs().gt(t * 1e-15);
        t = L::select(open, t - step, t);
        if !L::any(open) {
            break;
        }
    }
    let free_peak = acceleration * t * speed_factor(rate * t);
    // Below a tau, which rounding may have let the peak reach: at a tau and
    // beyond the segments never get to the limit.
    let reached = (rate * p.speed_limit).lt(acceleration);
    let limited = L::and(p.speed_limit.lt(free_peak), reached);
    let top = L::select(limited, p.speed_limit, free_peak);
    let mut driven_time = t;
    if L::any(limited) {
        let rise = L::select(limited, -(rate * top / acceleration), zero);
        driven_time = L::select(limited, top / acceleration * log_factor(rise), t);
    }
    let driven_path = acceleration * driven_time * driven_time * path_factor(rate * driven_time);
    let cruise_path =
        L::select(limited, p.stroke - driven_path - braking_path(brake, top), zero).max(zero);
    let mut time = driven_time + cruise_path / top;
    if brake.3 {
        let braking_time = top / braking * log_factor(rate * top / braking);
        time = L::select(braked, time + braking_time, time);
    }
    Phase { mean_speed: p.stroke / time, peak_speed: top, driven_path, cruise_path }
}

/// Distance of braking from a speed, where something brakes.
#[inline(always)]
fn braking_path<L: Lane>((rate, braking, braked, any): (L, L, L::Mask, bool), v: L) -> L {
    let zero = v.splat(0.0);
    // Logarithms go lane by lane: only where they are needed.
    if !any {
        return zero;
    }
    let path = v * v / braking * log_path_factor(rate * v / braking);
    L::select(braked, path, zero)
}
