//! Friction that varies periodically along the track.

use super::{Contact, ContactState, Dry, Law, LawInfo, Parameters, ReferenceValue};
use crate::lane::Lane;
use crate::lane::trig::sin_turns;
use crate::params::ParamId;

pub struct Ripple;

#[derive(Clone, Copy)]
pub struct Wave<L> {
    contact: Contact<L>,
    amplitude: L,
    per_length: L,
    /// In turns.
    phase: L,
}

/// A level at `x` on a track with a ripple of relative `amplitude`, of a length and
/// at a phase in turns.
#[inline(always)]
pub fn rippled<L: Lane>(level: L, x: L, amplitude: L, per_length: L, phase: L) -> L {
    let turns = x.mul_add(per_length, phase);
    level * amplitude.mul_add(sin_turns(turns), level.splat(1.0))
}

impl<L: Lane> Wave<L> {
    #[inline(always)]
    fn at(&self, level: L, at: &ContactState<L>) -> L {
        rippled(level, at.x, self.amplitude, self.per_length, self.phase)
    }
}

impl Law for Ripple {
    const INFO: LawInfo = LawInfo {
        name: "ripple",
        formula: r"F = F_C\left[1 + a \sin(2\pi x/L + \varphi_r)\right]\mathrm{sgn}\,v + \mu_V v",
        source: "position-dependent friction of guideways and gears (Armstrong-Helouvry 1991)",
        limits: "steps must resolve the period; static friction varies alike",
        meaning: "levels that vary along the track as a sine",
        params: &[
            "mu_static",
            "mu_coulomb",
            "viscous",
            "ripple_amplitude",
            "ripple_length",
            "ripple_phase_deg",
        ],
        reference: ReferenceValue {
            // 4.2*(1 + 0.5 sin(30 deg)) + 0.5*2 a quarter of the period ahead
            // of the phase.
            parameters: &[
                ("mu_static", 0.5),
                ("mu_coulomb", 0.35),
                ("mass", 1.0),
                ("gravity", 12.0),
                ("viscous", 0.5),
                ("ripple_amplitude", 0.5),
                ("ripple_length", 0.25),
                ("ripple_phase_deg", -60.0),
            ],
            speed: 2.0,
            at: (0.0625, 0.0, 0.0),
            force: 6.25,
            ..ReferenceValue::NONE
        },
    };
    type Coefficients<L: Lane> = Wave<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, params: &impl Parameters<L>) -> Wave<L> {
        let length = params.get(ParamId::RippleLength);
        Wave {
            contact: *contact,
            amplitude: params.get(ParamId::RippleAmplitude),
            per_length: length.splat(1.0) / length,
            phase: params.get(ParamId::RipplePhaseDeg) * (1.0 / 360.0),
        }
    }
}

impl Dry for Ripple {
    const PLACED: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(law: &Wave<L>, speed: L, at: &ContactState<L>) -> L {
        law.contact.viscous.mul_add(speed, law.at(law.contact.coulomb, at))
    }
    #[inline(always)]
    fn break_away<L: Lane>(law: &Wave<L>, at: &ContactState<L>) -> L {
        law.at(law.contact.break_away, at)
    }
}
