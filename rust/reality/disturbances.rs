//! Forces that no effect of the list stands for.

use crate::effects::Effect;
use std::f64::consts::TAU;

/// SplitMix64: small, and the same everywhere.
#[derive(Debug, Clone, Copy)]
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }

    /// Instants of events that come every `mean` seconds on average.
    pub fn instants(&mut self, mean: f64, until: f64) -> Vec<f64> {
        let mut found = Vec::new();
        let mut t = 0.0;
        loop {
            t += -mean * (1.0 - self.uniform()).ln();
            if t >= until {
                return found;
            }
            found.push(t);
        }
    }
}

/// Spacing of a random force's table, s.
const SPACING: f64 = 1e-3;

/// What of the disturbances is drawn anew for each run.
#[derive(Debug, Clone, Default)]
pub struct Drawn {
    noise: Vec<f64>,
    gusts: Vec<(f64, f64)>,
}

impl Drawn {
    pub fn new(effects: &[Effect], seed: u64, duration: f64) -> Drawn {
        let mut random = Random::new(seed);
        let mut drawn = Drawn::default();
        for effect in effects {
            match *effect {
                Effect::ColouredPush { time, .. } => {
                    let keep = (-SPACING / time).exp();
                    let fresh = (1.0 - keep * keep).sqrt();
                    let mut z = random.normal();
                    drawn.noise = (0..(duration / SPACING) as usize + 3)
                        .map(|_| {
                            z = keep * z + fresh * random.normal();
                            z
                        })
                        .collect();
                }
                Effect::Gusts { every, .. } => {
                    let instants = random.instants(every, duration);
                    drawn.gusts =
                        instants.iter().map(|t| (*t, 2.0 * random.uniform() - 1.0)).collect();
                }
                _ => {}
            }
        }
        drawn
    }

    fn noise(&self, t: f64) -> f64 {
        let at = t / SPACING;
        let i = at as usize;
        let share = at - i as f64;
        self.noise[i] * (1.0 - share) + self.noise[i + 1] * share
    }
}

/// Force on the head beside drive, friction and gravity.
pub fn force(effects: &[Effect], drawn: &Drawn, t: f64, x: f64, v: f64) -> f64 {
    let mut sum = 0.0;
    for effect in effects {
        sum += match *effect {
            Effect::Tether { k, slack } => -k * (x - slack).max(0.0),
            Effect::PeriodicPush { amplitude, frequency, phase } => {
                amplitude * (TAU * frequency * t + phase).sin()
            }
            Effect::ColouredPush { amplitude, .. } => amplitude * drawn.noise(t),
            Effect::Gusts { amplitude, width, .. } => {
                let near = |(at, size): &(f64, f64)| size * (-((t - at) / width).powi(2)).exp();
                amplitude * drawn.gusts.iter().map(near).sum::<f64>()
            }
            Effect::Magnet { amplitude, at, width } => {
                let u = (x - at) / width;
                -amplitude * u * (-u * u).exp()
            }
            // A spring drum: what it pulls with depends on whether the cable pays out or winds up.
            Effect::CableReel { pull, k, at, loss, v0 } => {
                -(pull + k * (x - at)) * (1.0 + loss * (v / v0).tanh())
            }
            Effect::Wall { at, k, d } => {
                let depth = x - at;
                if depth > 0.0 { -(k * depth + d * v).max(0.0) } else { 0.0 }
            }
            _ => 0.0,
        };
    }
    sum
}

/// Angle added to the slope, rad.
pub fn tilt(effects: &[Effect], t: f64, x: f64) -> f64 {
    let mut sum = 0.0;
    for effect in effects {
        sum += match *effect {
            Effect::Rocking { amplitude, frequency, phase } => {
                amplitude.to_radians() * ((TAU * frequency * t + phase).sin() - phase.sin())
            }
            // A rail that hangs through: downhill towards its middle.
            Effect::SaggingRail { amplitude, at, length } => {
                amplitude.to_radians() * (x - at) / length
            }
            Effect::SlopeUneven { d_alpha_deg, a, length } => {
                d_alpha_deg.to_radians() * (1.0 + a * (TAU * x / length).sin())
            }
            _ => 0.0,
        };
    }
    sum
}

/// Factor on the head's mass.
pub fn mass_share(effects: &[Effect], t: f64) -> f64 {
    let of = |effect: &Effect| match *effect {
        Effect::MassStep { share, at } if t >= at => 1.0 + share,
        _ => 1.0,
    };
    effects.iter().map(of).product()
}

/// Fastest rate on a mass, rad/s.
pub fn fastest(effects: &[Effect], mass: f64) -> f64 {
    let of = |effect: &Effect| match *effect {
        Effect::Wall { k, d, .. } => (k / mass).sqrt().max(d / mass),
        Effect::Vibration { frequency, .. } => TAU * frequency,
        _ => 0.0,
    };
    effects.iter().map(of).fold(0.0, f64::max)
}
