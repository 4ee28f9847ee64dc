//! Work and power of the drive.

use super::motion::{PhaseTime, why_no_phase};
use super::phase::{Phase, phase};
use super::traction::{Traction, traction};
use super::{Quantity, ground};
use crate::describe::Info;
use crate::lane::Lane;
use crate::{Point, Status};

/// Work of the drive on one moving segment in one phase, per mass: full force
/// on the driven path, just the resistance at the speed limit, none in braking.
#[inline(always)]
fn work<L: Lane, const PLAIN: bool>(p: &Point<L>, t: &Traction<L>, phase: &Phase<L>) -> L {
    if PLAIN {
        return t.push * p.stroke;
    }
    let zero = p.stroke.splat(0.0);
    let steady = (p.viscous * p.per_mass).mul_add(phase.peak_speed, t.drag);
    let cruise = L::select(phase.cruise_path.gt(zero), steady.max(zero) * phase.cruise_path, zero);
    t.push * phase.driven_path + cruise
}

/// Energy over weight and distance.
pub struct CostOfTransport;

impl Quantity for CostOfTransport {
    const INFO: Info = Info {
        name: "cost_of_transport",
        symbol: r"\mathrm{CoT}",
        unit: "1",
        formula: r"\mathrm{CoT} = \frac{W}{k m g\,\delta};\quad = \frac{F_P}{k m g} \text{ without limits}",
        source: "derived; flat, k = 1: (N-1) mu_S; floor mu_C cos a + sin a (quasi-static)",
        limits: "mechanical work of the drive; braking gives nothing back",
        meaning: "drive energy per weight of the robot and distance travelled",
        params: PhaseTime::INFO.params,
        integer: false,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let t = traction::<L, PLAIN>(p);
        let phase = phase::<L, PLAIN>(p, &t);
        let cost = work::<L, PLAIN>(p, &t, &phase) / (p.gravity * p.stroke);
        let moves = L::and(phase.mean_speed.not_nan(), p.gravity.gt(p.gravity.splat(0.0)));
        cost.only_if(moves)
    }

    fn status(p: &Point<f64>) -> Status {
        match why_no_phase(p) {
            Status::NotFinite => Status::Unbounded,
            other => other,
        }
    }
}

/// Mean mechanical power of the drive.
pub struct MeanPower;

impl Quantity for MeanPower {
    const INFO: Info = Info {
        name: "mean_power",
        symbol: r"\bar P",
        unit: "W",
        formula: r"\bar P = k W/t_p = \mathrm{CoT}\; N m g\,\bar v",
        source: "derived",
        limits: "mechanical power of all driven joints; electric power needs a motor model",
        meaning: "mean mechanical power of the drive over a cycle",
        params: PhaseTime::INFO.params,
        integer: false,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let t = traction::<L, PLAIN>(p);
        let phase = phase::<L, PLAIN>(p, &t);
        (p.moving * p.mass) * work::<L, PLAIN>(p, &t, &phase) * phase.mean_speed / p.stroke
    }

    fn status(p: &Point<f64>) -> Status {
        why_no_phase(p)
    }
}

/// Peak mechanical power on one moving segment.
pub struct PeakPower;

impl Quantity for PeakPower {
    const INFO: Info = Info {
        name: "peak_power",
        symbol: r"\hat P",
        unit: "W",
        formula: r"\hat P = (F_P/k)\,\hat v;\quad = (F_A/k)\sqrt{2 a\delta} \text{ without limits}",
        source: "derived",
        limits: "per moving segment, full force at the highest speed",
        meaning: "highest mechanical power that one moving segment takes",
        params: PhaseTime::INFO.params,
        integer: false,
        larger_is_better: false,
    };

    #[inline(always)]
    fn value<L: Lane, const PLAIN: bool>(p: &Point<L>) -> L {
        let t = traction::<L, PLAIN>(p);
        (t.push * p.mass) * phase::<L, PLAIN>(p, &t).peak_speed
    }

    fn status(p: &Point<f64>) -> Status {
        why_no_phase(p)
    }
}

/// Kinetic energy lost when a moving segment is stopped at the end of its stroke.
pub struct ImpactLoss;

impl Quantity for ImpactLoss {
    const INFO: Info = Info {
        name: "impact_loss",
        symbol: r"E_i",
        unit: "J",
        formula: r"E_i = \tfrac12 m\hat v^2;\quad = m a\delta \text{ without limits}",
        source: "derived: each phase starts at rest, so what is left of the speed is lost",
        limits: "per moving segment and stroke; zero with the brake",
        meaning: "kinetic energy of one segment lost at the end of each stroke",
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
        let peak = phase::<L, PLAIN>(p, &traction::<L, PLAIN>(p)).peak_speed;
        let loss = (p.mass * 0.5) * (peak * peak);
        if PLAIN {
            return loss;
        }
        let zero = peak.splat(0.0);
        let braked = L::and(p.brake.gt(zero), peak.not_nan());
        L::select(braked, zero, loss)
    }

    fn status(p: &Point<f64>) -> Status {
        why_no_phase(p)
    }
}
