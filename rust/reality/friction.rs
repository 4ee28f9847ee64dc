//! Friction of the head: a level that does not ask for the speed, and what
//! changes with it.

use crate::drive::late;
use crate::effects::Effect;

/// What the nominal model knows of the friction.
#[derive(Debug, Clone, Copy)]
pub struct Ground {
    /// Coulomb level that levels in effects refer to.
    pub reference: f64,
    pub viscous: f64,
}

/// Where and how the head moves.
#[derive(Debug, Clone, Copy)]
pub struct ContactState {
    /// Way of the motion, or of the push on a head at rest.
    pub direction: f64,
    /// Along `way`, never negative.
    pub speed: f64,
    pub x: f64,
    pub t: f64,
    /// Forward, since the head last rested or turned.
    pub swept: f64,
    /// Forward, how far a ridge at the head has been pushed; 0 behind it.
    pub pushed: f64,
    /// Force that the transmission delivers.
    pub drive: f64,
}

/// `coulomb` is the level at the run's own slope and mass.
fn dry(effects: &[Effect], ground: &Ground, coulomb: f64, contact: &ContactState) -> f64 {
    let reference = ground.reference;
    let side = |forward: f64, backward: f64| {
        (if contact.direction < 0.0 { backward } else { forward }) - reference
    };
    let mut level = coulomb;
    for effect in effects {
        level += match *effect {
            Effect::Direction { forward, backward } => side(forward, backward),
            Effect::DirectionFading { forward, backward, v0 } => {
                side(forward, backward) * -(-contact.speed / v0).exp_m1()
            }
            _ => 0.0,
        };
    }
    level = level.max(0.0);
    for effect in effects {
        level *= match *effect {
            Effect::Position { a, length, phase } => {
                1.0 + a * (std::f64::consts::TAU * contact.x / length + phase).sin()
            }
            Effect::PositionBump { a, at, width } => {
                1.0 + a * (-((contact.x - at) / width).powi(2)).exp()
            }
            Effect::PositionStep { a, at, width } => {
                1.0 + 0.5 * a * (1.0 + ((contact.x - at) / width).tanh())
            }
            Effect::Drift { a, time } => 1.0 - a * (-contact.t / time).exp_m1(),
            Effect::DriftLinear { a, time } => 1.0 + a * contact.t / time,
            Effect::DriftLate { a, time, width } => 1.0 + a * late(contact.t, time, width),
            Effect::Vibration { a, frequency } => {
                1.0 + a * (std::f64::consts::TAU * frequency * contact.t).sin()
            }
            _ => 1.0,
        };
    }
    level
}

fn load(effects: &[Effect], drive: f64) -> f64 {
    let mut more = 0.0;
    for effect in effects {
        more += match *effect {
            Effect::Load { mu_l } => mu_l * drive.abs(),
            Effect::LoadSquare { mu_l, f0 } => mu_l * drive * drive / f0,
            _ => 0.0,
        };
    }
    more
}

/// What falls from break-away to sliding.
fn fall(effects: &[Effect], ground: &Ground, speed: f64) -> f64 {
    let drop = |f_s: f64| f_s - ground.reference;
    let mut more = 0.0;
    for effect in effects {
        more += match *effect {
            Effect::Stribeck { f_s, v_s, delta } => drop(f_s) * (-(speed / v_s).powf(delta)).exp(),
            Effect::StribeckRational { f_s, v_s } => drop(f_s) / (1.0 + (speed / v_s).powi(2)),
            Effect::StribeckRamp { f_s, v_s } => drop(f_s) * (1.0 - speed / v_s).max(0.0),
            Effect::CoulombRate { d_force, a, v0 } => d_force * (1.0 + a * (speed / v0).ln_1p()),
            _ => 0.0,
        };
    }
    more
}

fn heap(effects: &[Effect], contact: &ContactState) -> f64 {
    if contact.direction <= 0.0 {
        return 0.0;
    }
    let mut more = 0.0;
    for effect in effects {
        more += match *effect {
            Effect::Buildup { k_b } => k_b * contact.swept,
            Effect::BuildupLevelling { k_b, s0 } => -k_b * s0 * (-contact.swept / s0).exp_m1(),
            Effect::DustRidge { amplitude, length } => {
                -amplitude * (-contact.pushed / length).exp_m1()
            }
            _ => 0.0,
        };
    }
    more
}

fn smooth(effects: &[Effect], ground: &Ground, speed: f64) -> f64 {
    let mut force = ground.viscous * speed;
    for effect in effects {
        force += match *effect {
            Effect::Viscous { c } => c * speed,
            Effect::ViscousPower { c, n, v0 } => c * v0 * (speed / v0).powf(n),
            Effect::Quadratic { c2 } => c2 * speed * speed,
            Effect::QuadraticPower { c2, n, v0 } => c2 * v0 * v0 * (speed / v0).powf(n),
            _ => 0.0,
        };
    }
    force
}

/// What resists at a place: of a head at rest, what has to be exceeded.
pub fn resistance(
    effects: &[Effect],
    ground: &Ground,
    coulomb: f64,
    contact: &ContactState,
) -> f64 {
    steady(effects, ground, coulomb, contact) + smooth(effects, ground, contact.speed)
}

/// The part that a bristle carries.
fn steady(effects: &[Effect], ground: &Ground, coulomb: f64, contact: &ContactState) -> f64 {
    let level = dry(effects, ground, coulomb, contact) + load(effects, contact.drive);
    level + fall(effects, ground, contact.speed) + heap(effects, contact)
}

/// A contact that gives way before it slides.
#[derive(Debug, Clone, Copy)]
pub struct Bristle {
    sigma0: f64,
    sigma1: f64,
    dahl: bool,
}

impl Bristle {
    pub fn of(effects: &[Effect]) -> Option<Bristle> {
        effects.iter().find_map(|effect| match *effect {
            Effect::Presliding { sigma0, sigma1 } => Some(Bristle { sigma0, sigma1, dahl: false }),
            Effect::PreslidingDahl { sigma0 } => Some(Bristle { sigma0, sigma1: 0.0, dahl: true }),
            _ => None,
        })
    }

    pub fn level(effects: &[Effect], ground: &Ground, coulomb: f64, contact: &ContactState) -> f64 {
        steady(effects, ground, coulomb, contact).max(1e-9)
    }

    /// Deflection after `dt` at a speed, exact for a speed that stays.
    pub fn after(&self, z: f64, v: f64, level: f64, dt: f64) -> f64 {
        if v == 0.0 {
            return z;
        }
        let most = v.signum() * level / self.sigma0;
        let turns = v.abs() * dt * self.sigma0 / level;
        if self.dahl {
            // 1 - z/most falls with its own square.
            let left = (1.0 - z / most).max(0.0);
            return most * (1.0 - left / (1.0 + turns * left));
        }
        most + (z - most) * (-turns).exp()
    }

    /// Force at a speed and deflection, without what is smooth.
    pub fn force(&self, z: f64, v: f64, level: f64) -> f64 {
        let rate = v - self.sigma0 * v.abs() * z / level;
        self.sigma0 * z + self.sigma1 * rate
    }

    /// Fastest oscillation on a mass, rad/s.
    pub fn fastest(&self, mass: f64) -> f64 {
        (self.sigma0 / mass).sqrt().max(self.sigma1 / mass)
    }
}

/// Smooth friction of a head on a bristle.
pub fn smooth_force(effects: &[Effect], ground: &Ground, v: f64) -> f64 {
    v.signum() * smooth(effects, ground, v.abs())
}
