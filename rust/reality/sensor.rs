//! What the position sensor makes of the head's motion.

use crate::disturbances::Random;
use crate::effects::{Effect, first};

/// Readings that slip or freeze, drawn anew for each run.
pub struct Sensor<'a> {
    effects: &'a [Effect],
    slips: Vec<f64>,
    freezes: Vec<f64>,
}

impl<'a> Sensor<'a> {
    pub fn new(effects: &'a [Effect], seed: u64, duration: f64) -> Sensor<'a> {
        // Another stream than that of the forces.
        let mut random = Random::new(!seed);
        let (mut slips, mut freezes) = (Vec::new(), Vec::new());
        for effect in effects {
            match *effect {
                Effect::ReadingSlips { every, .. } => slips = random.instants(every, duration),
                Effect::ReadingFreezes { every, .. } => freezes = random.instants(every, duration),
                _ => {}
            }
        }
        Sensor { effects, slips, freezes }
    }

    /// The instant whose position is read at `t`.
    pub fn instant(&self, t: f64) -> f64 {
        let delay = first(self.effects, |e| match *e {
            Effect::SensorDelay { time } => Some(time),
            _ => None,
        });
        let width = first(self.effects, |e| match *e {
            Effect::ReadingFreezes { width, .. } => Some(width),
            _ => None,
        });
        let frozen =
            self.freezes.iter().find(|from| (**from..**from + width.unwrap_or(0.0)).contains(&t));
        (frozen.copied().unwrap_or(t) - delay.unwrap_or(0.0)).max(0.0)
    }

    /// Reading of a position `x` at its instant; the run began at `x0`.
    pub fn reading(&self, t: f64, x: f64, filtered: f64, x0: f64) -> f64 {
        let filters = |e: &Effect| {
            matches!(e, Effect::SensorDelayFilter { .. } | Effect::LooseEncoder { .. })
        };
        let mut reading = if self.effects.iter().any(filters) { filtered } else { x };
        for effect in self.effects {
            let moved = reading - x0;
            reading = match *effect {
                Effect::SensorScale { e } => x0 + (1.0 + e) * moved,
                Effect::SensorScaleBent { e, length } => {
                    x0 + (1.0 + e * moved.abs() / length) * moved
                }
                _ => reading,
            };
        }
        for effect in self.effects {
            reading += match *effect {
                Effect::SensorDrift { b } => b * t,
                Effect::SensorDriftLevelling { b, time } => -b * time * (-t / time).exp_m1(),
                Effect::ReadingSlips { jump, .. } => {
                    jump * self.slips.iter().filter(|at| **at <= t).count() as f64
                }
                _ => 0.0,
            };
        }
        reading
    }
}
