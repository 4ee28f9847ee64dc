//! One run from its first sample to its last.

use crate::body::{Body, BodyState};
use crate::drive::effective_times;
use crate::effects::Effect;
use crate::head::Head;
use crate::rig::Rig;
use crate::sensor::Sensor;

/// The command of a run.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// s, rising from 0.
    pub times: Vec<f64>,
    pub drive: Vec<f64>,
    pub slope_deg: f64,
}

/// What the sensors would read at each sample, without noise.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Readings {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub x_rear: Vec<f64>,
    pub force: Vec<f64>,
}

/// Runs the head from `start` (position and speed) in steps of at most `step`
/// seconds; `seed` draws what is random in it.
pub fn simulate(
    rig: &Rig,
    effects: &[Effect],
    samples: &Samples,
    start: (f64, f64),
    step: f64,
    seed: u64,
) -> Readings {
    let mut readings = Readings::default();
    let Some(last) = samples.times.last() else { return readings };
    let head = Head::new(rig, effects, samples.slope_deg, (*last, seed), step);
    let sensor = Sensor::new(effects, seed, *last);
    let alpha =
        samples.slope_deg.to_radians()
            + effects
                .iter()
                .map(|e| {
                    if let Effect::Slope { d_alpha_deg } = e {
                        d_alpha_deg.to_radians()
                    } else {
                        0.0
                    }
                })
                .sum::<f64>();
    let body = Body::of(effects, rig, alpha);
    let effective = effective_times(effects, rig, &samples.times);
    let instants: Vec<f64> = samples.times.iter().map(|t| sensor.instant(*t)).collect();
    let mut events: Vec<f64> = samples.times.clone();
    events.extend(effective.iter().filter(|t| (0.0..*last).contains(*t)));
    events.extend(&instants);
    events.sort_by(f64::total_cmp);
    events.dedup();

    let mut at = 0;
    while at + 1 < effective.len() && effective[at + 1] <= 0.0 {
        at += 1;
    }
    let mut state = head.start(samples.drive[at], start);
    let mut rear = BodyState::default();
    for event in events {
        if event > state.t {
            let command = samples.drive[at];
            head.advance(&mut state, command, event, |state, dt| {
                if let Some(body) = &body {
                    body.advance(&mut rear, head.force(state, command), dt);
                }
            });
        }
        while at + 1 < effective.len() && effective[at + 1] <= event {
            at += 1;
        }
        while readings.x.len() < instants.len() && instants[readings.x.len()] <= event {
            let instant = instants[readings.x.len()];
            readings.x.push(sensor.reading(instant, state.x, state.filtered, start.0));
        }
        while readings.v.len() < samples.times.len() && samples.times[readings.v.len()] <= event {
            readings.v.push(state.v);
            readings.x_rear.push(rear.x);
            readings.force.push(head.force(&state, samples.drive[at]));
        }
    }
    readings
}
