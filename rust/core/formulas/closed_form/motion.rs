//! Motion: acceleration, phase time, mean velocity, velocity over time and its
//! limit, equations (1), (5), (6), (9) to (11) of the paper.

use super::phase::{braking_works, phase};
use super::traction::{or_else, plain_acceleration, traction, why_no_motion};
use super::{Quantity, ground};
use crate::describe::Info;
use crate::lane::Lane;
use crate::lane::exp::speed_factor;
use crate::{Point, Status};

/// Acceleration of the moving segments.
pub struct Acceleration;

impl Quantity for Acceleration {
    const INFO: Info = Info {
        name: "acceleration",
        symbol: "a",
        unit: "m/s^2",
        formula: r"a = F_P/(k m) - \mu_C n - g\sin\alpha",
        source: "paper, equation (1)",
        limits: "at the start of a phase, before viscous friction acts",
        meaning: "acceleration of the moving segments from rest",
        params: ground!("drive_limit", "anchors_ahead"),
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        traction::<L, PLAIN>(p).acceleration
    }

    fn status(p: &Point<f64>) -> Status {
        or_else(why_no_motion(p), Status::NotFinite)
    }
}

/// Why a phase does not end, or `NotFinite`.
pub fn why_no_phase(p: &Point<f64>) -> Status {
    let brake_fails = p.brake > 0.0 && !braking_works(p);
    let otherwise = if brake_fails { Status::CannotBrake } else { Status::NotFinite };
    or_else(why_no_motion(p), otherwise)
}

/// Time of one phase.
pub struct PhaseTime;

impl Quantity for PhaseTime {
    const INFO: Info = Info {
        name: "phase_time",
        symbol: r"t_p",
        unit: "s",
        formula: r"t_p = \sqrt{2\delta/a};\ \text{speed limit: } \delta/v_\mathrm{max} + v_\mathrm{max}/(2a);\ \text{brake: } 1/a \to 1/a + 1/b;\ \text{viscous: } \delta = a t_p^2 E_2(t_p\mu_V/m)",
        source: "paper, before equation (6); the rest derived, viscous path from the solution (10)",
        limits: "each phase starts at rest; E_2(x) = (x + e^{-x} - 1)/x^2 (1/2 at x = 0)",
        meaning: "time in which the moving segments cover one stroke",
        params: ground!(
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
        p.stroke / phase::<L, PLAIN>(p, &traction::<L, PLAIN>(p)).mean_speed
    }

    fn status(p: &Point<f64>) -> Status {
        why_no_phase(p)
    }
}

/// Time in which every segment has moved once.
pub struct CycleTime;

impl Quantity for CycleTime {
    const INFO: Info = Info {
        name: "cycle_time",
        symbol: r"T",
        unit: "s",
        formula: r"T = (N/k)\,t_p",
        source: "paper, denominator of equation (5)",
        limits: "as phase_time; without force limits shortest at (N-1) = 1 + 2 mu_C/mu_S on the flat",
        meaning: "time in which every segment has advanced by one stroke",
        params: PhaseTime::INFO.params,
        integer: false,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        (p.segments * p.per_moving) * PhaseTime::value::<L, PLAIN>(p)
    }

    fn status(p: &Point<f64>) -> Status {
        why_no_phase(p)
    }
}

/// Mean velocity of the whole robot.
pub struct MeanVelocity;

impl Quantity for MeanVelocity {
    const INFO: Info = Info {
        name: "mean_velocity",
        symbol: r"\bar v",
        unit: "m/s",
        formula: r"\bar v = \frac{k\,\delta}{N t_p};\quad \bar v = \frac{k}{N}\sqrt{\frac{\delta a}{2}} \text{ without limits}",
        source: "paper, equations (5) and (6)",
        limits: "as phase_time; the paper leaves the constant in t_p open (the optimum does not depend on it)",
        meaning: "mean velocity of the robot over a gait cycle",
        params: PhaseTime::INFO.params,
        integer: false,
        larger_is_better: true,
    };
    const SCORE_POWER: f64 = 2.0;
    const SCORE_FLOOR: f64 = 0.0;

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let phase = phase::<L, PLAIN>(p, &traction::<L, PLAIN>(p));
        (p.moving * p.per_segments) * phase.mean_speed
    }

    /// The square saves the root where rivals are only compared.
    #[inline(always)]
    fn score<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        if PLAIN {
            let share = p.moving * p.per_segments;
            return plain_acceleration(p) * (share * share * p.stroke);
        }
        let v = Self::value::<L, false>(p);
        v * v
    }

    fn status(p: &Point<f64>) -> Status {
        why_no_phase(p)
    }
}

/// Highest speed in a phase.
pub struct PeakSpeed;

impl Quantity for PeakSpeed {
    const INFO: Info = Info {
        name: "peak_speed",
        symbol: r"\hat v",
        unit: "m/s",
        formula: r"\hat v = \min(v_\mathrm{max}, \sqrt{2 a \delta})",
        source: "derived from equation (1)",
        limits: "as phase_time",
        meaning: "highest speed of a moving segment within a phase",
        params: PhaseTime::INFO.params,
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        phase::<L, PLAIN>(p, &traction::<L, PLAIN>(p)).peak_speed
    }

    fn status(p: &Point<f64>) -> Status {
        why_no_phase(p)
    }
}

/// Acceleration with the Coulomb term kept or dropped as `coulomb_term` says.
#[inline(always)]
fn start_acceleration<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
    if PLAIN {
        return traction::<L, true>(p).acceleration;
    }
    let zero = p.viscous.splat(0.0);
    let drop = L::and(p.viscous.gt(zero), p.coulomb_term.le(zero));
    let mut kept = *p;
    kept.mu_coulomb = L::select(drop, zero, p.mu_coulomb);
    traction::<L, false>(&kept).acceleration
}

fn why_no_start(p: &Point<f64>) -> Status {
    let mut kept = *p;
    if p.viscous > 0.0 && p.coulomb_term <= 0.0 {
        kept.mu_coulomb = 0.0;
    }
    why_no_motion(&kept)
}

/// Velocity of the moving segments at a time after the start.
pub struct Velocity;

impl Quantity for Velocity {
    const INFO: Info = Info {
        name: "velocity",
        symbol: "v",
        unit: "m/s",
        formula: r"v(t) = a t \text{ (dry)},\quad v(t) = a\tau(1 - e^{-t/\tau}),\ \tau = m/\mu_V \text{ (viscous)}",
        source: "paper, equations (9) and (10); whether (10) keeps the Coulomb term is open: coulomb_term",
        limits: "from rest under constant force, never above speed_limit; the end of the stroke is not applied",
        meaning: "velocity of a moving segment at a time after its start",
        params: ground!(
            "drive_limit",
            "anchors_ahead",
            "viscous",
            "coulomb_term",
            "speed_limit",
            "time"
        ),
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let free = start_acceleration::<L, PLAIN>(p) * p.time;
        if PLAIN {
            return free;
        }
        let v = free * speed_factor(p.viscous * p.per_mass * p.time);
        let slowed = L::select(p.viscous.gt(p.time.splat(0.0)), v, free);
        L::select(p.speed_limit.lt(slowed), p.speed_limit, slowed)
    }

    fn status(p: &Point<f64>) -> Status {
        or_else(why_no_start(p), Status::NotFinite)
    }
}

/// Velocity that viscous friction lets the segments approach.
pub struct VelocityLimit;

impl Quantity for VelocityLimit {
    const INFO: Info = Info {
        name: "velocity_limit",
        symbol: r"v_\mathrm{lim}",
        unit: "m/s",
        formula: r"v_\mathrm{lim} = (F_P/k - \mu_C m n - m g\sin\alpha)/\mu_V",
        source: "paper, equation (11): F_P/mu_V, the Coulomb term dropped; coulomb_term = 0 gives that",
        limits: "unbounded without viscous friction and speed limit",
        meaning: "velocity that a moving segment approaches under constant force",
        params: ground!("drive_limit", "anchors_ahead", "viscous", "coulomb_term", "speed_limit"),
        integer: false,
        larger_is_better: true,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let infinite = p.viscous.splat(f64::INFINITY);
        let free = start_acceleration::<L, PLAIN>(p) * p.mass / p.viscous;
        let v = L::select(p.speed_limit.lt(free), p.speed_limit, free);
        v.only_if(v.lt(infinite))
    }

    fn status(p: &Point<f64>) -> Status {
        or_else(why_no_start(p), Status::Unbounded)
    }
}

/// Time constant of the viscous approach.
pub struct TimeConstant;

impl Quantity for TimeConstant {
    const INFO: Info = Info {
        name: "time_constant",
        symbol: r"\tau",
        unit: "s",
        formula: r"\tau = m/\mu_V",
        source: "paper, exponent of equation (10)",
        limits: "unbounded without viscous friction",
        meaning: "time in which the velocity comes within 1/e of its limit",
        params: &["mass", "viscous"],
        integer: false,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let tau = p.mass / p.viscous;
        tau.only_if(tau.lt(tau.splat(f64::INFINITY)))
    }

    fn status(_: &Point<f64>) -> Status {
        Status::Unbounded
    }
}

#[cfg(test)]
mod tests {
    use super::super::traction::limited;
    use super::*;
    use crate::ParamId::*;

    #[test]
    fn force_per_mass_is_the_propulsive_force() {
        let p =
            Point::of(&[(MuStatic, 0.5), (MuCoulomb, 0.3), (Segments, 4.0), (DriveLimit, 0.85)]);
        let push = limited(&p, p.hold());
        assert!((push * 0.271 - 0.85).abs() < 1e-15);
    }
}
