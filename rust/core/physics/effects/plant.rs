//! The measured head with its effects: nominal model in, segment, friction,
//! drive path, body and sensor out.

use super::friction::Coefficients;
use super::{Active, EFFECT_PARAMS, Effect};
use crate::drive::Path;
use crate::lane::Lane;
use crate::lane::trig::{cos_turns, sin_turns};

/// What is known of a rig before it is measured; one value per file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nominal {
    pub segments: f64,
    pub mass: f64,
    pub gravity: f64,
    /// Coefficient, unless `coulomb_force` is given.
    pub mu_coulomb: f64,
    pub coulomb_force: Option<f64>,
    pub viscous: f64,
    pub slope_deg: f64,
    pub gain: f64,
    pub limit: f64,
    /// A pendulum: x in rad, mass the moment of inertia.
    pub rotary: bool,
    pub gravity_torque: f64,
}

/// Friction levels, N.
#[derive(Debug, Clone, Copy)]
pub struct Levels<L> {
    pub break_away: L,
    pub coulomb: L,
}

/// The anchored rest of the robot, where it may slide.
#[derive(Debug, Clone, Copy)]
pub struct Body<L> {
    pub mass: L,
    pub weight: L,
    pub levels: Levels<L>,
}

/// How the drive is joined to the head.
#[derive(Debug, Clone, Copy)]
pub struct Joint<L> {
    /// Mass on the drive's side.
    pub mass: L,
    pub stiffness: L,
    pub damping: L,
    /// Half the gap; of a spring 0, which then also pulls.
    pub gap: L,
    pub is_spring: bool,
}

/// Lightest drive side, as a share of the head's mass.
const LIGHTEST: f64 = 1e-3;
/// Fastest oscillation of a joint, rad/s: what is stiffer gives way by about ten
/// nanometres at ten metres per second squared.
const FASTEST: f64 = 3e4;

impl<L: Lane> Joint<L> {
    /// A joint that does not give, with nothing on the drive's side.
    #[inline(always)]
    pub fn rigid(like: L) -> Joint<L> {
        let (zero, endless) = (like.splat(0.0), like.splat(f64::INFINITY));
        Joint { mass: zero, stiffness: endless, damping: endless, gap: zero, is_spring: true }
    }

    /// The joint as integrators follow it, and the reduced mass of both sides: a mass
    /// that no longer matters and a joint that no longer gives are as light and as
    /// stiff as steps can follow.
    #[inline(always)]
    pub fn followed(mut self, head: L) -> (Joint<L>, L) {
        self.mass = self.mass.max(head * LIGHTEST);
        let reduced = (head * self.mass) / (head + self.mass);
        self.stiffness = self.stiffness.min(reduced * (FASTEST * FASTEST));
        self.damping = self.damping.min(reduced * (2.0 * FASTEST));
        (self, reduced)
    }
}

/// The plant of one trajectory per lane.
#[derive(Debug, Clone, Copy)]
pub struct Plant<L> {
    pub active: Active,
    pub mass: L,
    /// Pull of the slope, or largest pull of gravity on a pendulum.
    pub weight: L,
    pub swing: L,
    pub rotary: bool,
    pub friction: Coefficients<L>,
    pub path: Path<L>,
    pub emf: L,
    pub joint: Option<Joint<L>>,
    pub body: Option<Body<L>>,
    /// Scale error, drift and delay of the position sensor.
    pub sensor: [L; 3],
}

/// Stiffness of a backlash contact per kilogram of head, N/(m kg): far above
/// what is measured.
const CONTACT_STIFFNESS: f64 = 2e4;

/// Parameters of effects, off where an effect is not active.
struct Values<'a, L> {
    active: Active,
    values: &'a [L; EFFECT_PARAMS],
    zero: L,
}

impl<L: Lane> Values<'_, L> {
    #[inline(always)]
    fn get(&self, effect: Effect, i: usize, off: f64) -> L {
        if self.active.has(effect) { self.values[effect.first() + i] } else { self.zero.splat(off) }
    }
}

/// Least mass of a plant in that of the nominal model: the bound of `payload_mass` lies above.
const LEAST_MASS: f64 = 0.02;

impl<L: Lane> Plant<L> {
    /// `values` are the parameters of all effects in the order of the registry;
    /// those of effects that are not active do not count. `share` multiplies the
    /// nominal mass, Coulomb level and gain, `clock` delays the drive: what an
    /// uncertain nominal model leaves open. `slope_deg` is that of the run.
    #[inline(always)]
    pub fn new(
        nominal: &Nominal,
        slope_deg: f64,
        active: Active,
        values: &[L; EFFECT_PARAMS],
        (share, clock): ([L; 3], L),
    ) -> Self {
        let zero = clock.splat(0.0);
        let one = zero.splat(1.0);
        let given = Values { active, values, zero };
        // Steps of a fit may leave no mass at all, whose motion no replay comes to the end of.
        let least = zero.splat(LEAST_MASS * nominal.mass);
        let known_mass = (share[0] * nominal.mass).max(least);
        let mass = (known_mass + given.get(Effect::PayloadMass, 0, 0.0)).max(least);
        let grown = mass / known_mass;
        let turns = (given.get(Effect::SlopeError, 0, 0.0) + slope_deg) * (1.0 / 360.0);
        let (sine, cosine) = (sin_turns(turns), cos_turns(turns));
        let nominal_cosine = libm::cos(nominal.slope_deg.to_radians());
        // Levels of effects are given at the nominal slope.
        let reference = zero.splat(match nominal.coulomb_force {
            Some(force) => force,
            None => nominal.mu_coulomb * nominal.mass * nominal.gravity * nominal_cosine,
        });
        let coulomb = match nominal.coulomb_force {
            Some(force) => {
                let level = share[1] * force + given.get(Effect::CoulombError, 1, 0.0);
                if nominal.rotary { level } else { level * grown }
            }
            None => {
                let mu = share[1] * nominal.mu_coulomb + given.get(Effect::CoulombError, 0, 0.0);
                mu * (mass * nominal.gravity) * cosine
            }
        };
        let coulomb = coulomb.max(zero);
        let emf = given.get(Effect::BackEmf, 0, 0.0);
        let viscous = given.get(Effect::ViscousFriction, 0, 0.0) + (emf + nominal.viscous);
        let mut friction = Coefficients::nominal(coulomb, viscous).with_effects(active);
        friction.quadratic = given.get(Effect::QuadraticDrag, 0, 0.0);
        friction.drop = values[Effect::StribeckFriction.first()] - reference;
        friction.per_stribeck = one / given.get(Effect::StribeckFriction, 1, 1.0);
        friction.exponent = given.get(Effect::StribeckFriction, 2, 1.0);
        if active.has(Effect::DirectionDependentFriction) {
            let at = Effect::DirectionDependentFriction.first();
            friction.forward = (coulomb + (values[at] - reference)).max(zero);
            friction.backward = (coulomb + (values[at + 1] - reference)).max(zero);
        }
        friction.ripple = given.get(Effect::PositionDependentFriction, 0, 0.0);
        friction.per_length = one / given.get(Effect::PositionDependentFriction, 1, 1.0);
        let phase = given.get(Effect::PositionDependentFriction, 2, 0.0);
        friction.phase = phase * (0.5 / std::f64::consts::PI);
        friction.load = given.get(Effect::LoadDependentFriction, 0, 0.0);
        friction.drift = given.get(Effect::FrictionDrift, 0, 0.0);
        friction.per_drift_time = one / given.get(Effect::FrictionDrift, 1, 1.0);
        friction.buildup = given.get(Effect::LubricantBuildup, 0, 0.0);
        friction.stiffness = given.get(Effect::PreslidingCompliance, 0, 1.0);
        friction.damping = given.get(Effect::PreslidingCompliance, 1, 0.0);

        let lag = given.get(Effect::DriveLag, 0, 0.0);
        let gain = (given.get(Effect::DriveGainError, 0, 0.0) + 1.0) * (share[2] * nominal.gain);
        let path = Path {
            delay: given.get(Effect::DriveDelay, 0, 0.0) + clock,
            gain,
            sag: given.get(Effect::SupplySag, 0, 0.0),
            per_sag_time: one / given.get(Effect::SupplySag, 1, 1.0),
            deadzone: given.get(Effect::DriveDeadzone, 0, 0.0),
            limit: given
                .get(Effect::DriveSaturation, 0, f64::INFINITY)
                .min(zero.splat(nominal.limit)),
            // No lag is the limit of a fast one.
            per_lag: one / lag.max(zero.splat(1e-12)),
            sags: active.has(Effect::SupplySag),
            lags: active.has(Effect::DriveLag),
        };
        let joint = if active.has(Effect::TransmissionCompliance) {
            Some(Joint {
                stiffness: given.get(Effect::TransmissionCompliance, 0, 1.0),
                damping: given.get(Effect::TransmissionCompliance, 1, 0.0),
                mass: given.get(Effect::TransmissionCompliance, 2, 1.0),
                gap: zero,
                is_spring: true,
            })
        } else if active.has(Effect::TransmissionBacklash) {
            let side = given.get(Effect::TransmissionBacklash, 1, 1.0);
            let stiffness = mass * CONTACT_STIFFNESS;
            // Critical for the two masses against each other.
            let reduced = (mass * side) / (mass + side);
            Some(Joint {
                stiffness,
                damping: (stiffness * reduced).sqrt() * 2.0,
                mass: side,
                gap: given.get(Effect::TransmissionBacklash, 0, 0.0),
                is_spring: false,
            })
        } else {
            None
        };
        let others = zero.splat((nominal.segments - 1.0) * nominal.mass * nominal.gravity);
        let body = if active.has(Effect::AnchorSlip) {
            Some(Body {
                mass: zero.splat((nominal.segments - 1.0) * nominal.mass),
                weight: others * sine,
                levels: Levels {
                    break_away: given.get(Effect::AnchorSlip, 0, 0.0) * others * cosine,
                    coulomb: given.get(Effect::AnchorSlip, 1, 0.0) * others * cosine,
                },
            })
        } else {
            None
        };
        let (weight, swing) = if nominal.rotary {
            (zero, grown * nominal.gravity_torque)
        } else {
            (mass * nominal.gravity * sine, zero)
        };
        Plant {
            active,
            mass,
            weight,
            swing,
            rotary: nominal.rotary,
            friction,
            path,
            emf,
            joint,
            body,
            sensor: [
                given.get(Effect::SensorScale, 0, 0.0),
                given.get(Effect::SensorDrift, 0, 0.0),
                given.get(Effect::SensorDelay, 0, 0.0),
            ],
        }
    }

    /// Whether friction and gravity leave motion linear between events, so that it is
    /// known in closed form.
    pub fn is_linear(&self) -> bool {
        let bent = [
            Effect::QuadraticDrag,
            Effect::StribeckFriction,
            Effect::PreslidingCompliance,
            Effect::PositionDependentFriction,
            Effect::LubricantBuildup,
        ];
        !self.rotary && !self.has_varying_load() && !self.active.any(&bent)
    }

    /// Whether friction hangs on a load that changes between events: behind a joint or a lag.
    pub fn has_varying_load(&self) -> bool {
        let linked = self.joint.is_some() || self.path.lags;
        linked && self.active.has(Effect::LoadDependentFriction)
    }

    /// Wavelength of friction along the track, m; infinite where it does not vary there.
    #[inline(always)]
    pub fn wavelength(&self) -> L {
        let like = self.friction.per_length;
        let waves = self.active.has(Effect::PositionDependentFriction);
        if waves { like.splat(1.0) / like } else { like.splat(f64::INFINITY) }
    }

    /// Whether friction changes over speeds or ways that a step may jump over.
    pub fn is_steep(&self) -> bool {
        self.active.any(&[Effect::StribeckFriction, Effect::PositionDependentFriction])
    }
}

/// Grows with how short the steps are that these effects need.
pub fn shortness(active: Active, values: &[f64; EFFECT_PARAMS]) -> f64 {
    let value = |effect: Effect, i: usize| {
        let value = values[effect.first() + i].abs();
        if active.has(effect) && value > 0.0 { value.ln() } else { 0.0 }
    };
    value(Effect::PreslidingCompliance, 0)
        - value(Effect::StribeckFriction, 1)
        - value(Effect::PositionDependentFriction, 1)
        + value(Effect::TransmissionCompliance, 0)
        - value(Effect::TransmissionCompliance, 2)
        - value(Effect::TransmissionBacklash, 1)
}
