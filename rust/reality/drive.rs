//! From the command to the force that the drive would give: when a sample takes
//! effect, gain, dead zone, limits, lag, in that order.

use crate::effects::Effect;
use crate::rig::Rig;

/// When each sample of the command takes effect.
pub fn effective_times(effects: &[Effect], rig: &Rig, times: &[f64]) -> Vec<f64> {
    let mut effective: Vec<f64> = times.iter().map(|t| t + rig.clock).collect();
    for effect in effects {
        for t in &mut effective {
            *t = match *effect {
                Effect::Delay { time } => *t + time,
                // Read once a period, from a share of one on: late by half a period in the mean.
                Effect::DelayPolled { period, phase } if period > 0.0 => {
                    ((*t / period - phase).ceil() + phase) * period
                }
                _ => *t,
            };
        }
    }
    // What was sent before the run's first sample is that sample's value.
    if let Some(first) = effective.first_mut() {
        *first = f64::NEG_INFINITY;
    }
    effective
}

/// Share of a change that has happened, from 0 at the start: fast, steady or late.
fn levelling(t: f64, time: f64) -> f64 {
    -(-t / time).exp_m1()
}

pub fn late(t: f64, time: f64, width: f64) -> f64 {
    let rise = |t: f64| 1.0 / (1.0 + (-(t - time) / width).exp());
    (rise(t) - rise(0.0)) / (1.0 - rise(0.0))
}

fn gain(effects: &[Effect], t: f64, force: f64) -> f64 {
    let mut force = force;
    for effect in effects {
        force *= match *effect {
            Effect::Gain { e } => 1.0 + e,
            Effect::GainAsymmetric { forward, backward } => {
                1.0 + if force < 0.0 { backward } else { forward }
            }
            Effect::Sag { a, time } => 1.0 - a * levelling(t, time),
            Effect::SagLinear { a, time } => 1.0 - a * t / time,
            Effect::SagLate { a, time, width } => 1.0 - a * late(t, time, width),
            _ => 1.0,
        };
    }
    force
}

/// `open` is the memory of a dead zone with hysteresis.
fn deadzone(effects: &[Effect], force: f64, open: &mut bool) -> f64 {
    for effect in effects {
        match *effect {
            Effect::Deadzone { d } => return force.signum() * (force.abs() - d).max(0.0),
            Effect::DeadzoneSoft { d } if d > 0.0 => return force - d * (force / d).tanh(),
            Effect::DeadzoneHysteresis { open: above, close } => {
                *open = force.abs() > if *open { close } else { above };
                return if *open { force.signum() * (force.abs() - close).max(0.0) } else { 0.0 };
            }
            _ => {}
        }
    }
    force
}

fn saturation(effects: &[Effect], force: f64) -> f64 {
    for effect in effects {
        match *effect {
            Effect::Saturation { f_max } => return force.clamp(-f_max, f_max),
            Effect::SaturationTanh { f_max } => return f_max * (force / f_max).tanh(),
            Effect::SaturationKnee { f_max, sharpness } => {
                let over = (force / f_max).abs().powf(sharpness);
                return force / (1.0 + over).powf(1.0 / sharpness);
            }
            _ => {}
        }
    }
    force
}

/// Force that the drive is told to give for a command, before any lag.
pub fn told(effects: &[Effect], rig: &Rig, t: f64, command: f64, open: &mut bool) -> f64 {
    let force = gain(effects, t, rig.gain * command);
    let force = saturation(effects, deadzone(effects, force, open));
    force.clamp(-rig.limit, rig.limit) + hum(effects, t)
}

/// What the mains add behind the drive's limit.
fn hum(effects: &[Effect], t: f64) -> f64 {
    let of = |effect: &Effect| match *effect {
        Effect::MainsHum { amplitude, frequency, phase } => {
            amplitude * (std::f64::consts::TAU * frequency * t + phase).sin()
        }
        _ => 0.0,
    };
    effects.iter().map(of).sum()
}

/// Rates of the lag's two states towards what is told; the second is the force.
pub fn lag_rates(effects: &[Effect], told: f64, lag: [f64; 2]) -> Option<[f64; 2]> {
    effects.iter().find_map(|effect| match *effect {
        Effect::Lag { time } => Some([0.0, (told - lag[1]) / time]),
        Effect::LagAsymmetric { rise, fall } => {
            let time = if told.abs() > lag[1].abs() { rise } else { fall };
            Some([0.0, (told - lag[1]) / time])
        }
        Effect::LagTwice { time } => {
            Some([(told - lag[0]) / (0.5 * time), (lag[0] - lag[1]) / (0.5 * time)])
        }
        _ => None,
    })
}

/// What the drive loses to its own motion.
pub fn back_emf(effects: &[Effect], v: f64) -> f64 {
    let mut lost = 0.0;
    for effect in effects {
        lost += match *effect {
            Effect::BackEmf { k_e } => k_e * v,
            Effect::BackEmfSaturating { k_e, v0 } => k_e * v / (1.0 + v.abs() / v0),
            _ => 0.0,
        };
    }
    lost
}

/// Fastest rate of the drive, 1/s.
pub fn fastest(effects: &[Effect]) -> f64 {
    let of = |effect: &Effect| match *effect {
        Effect::Lag { time } => 1.0 / time,
        Effect::LagTwice { time } => 2.0 / time,
        Effect::MainsHum { frequency, .. } => std::f64::consts::TAU * frequency,
        Effect::LagAsymmetric { rise, fall } => 1.0 / rise.min(fall),
        _ => 0.0,
    };
    effects.iter().map(of).fold(0.0, f64::max)
}
