//! Measured runs as they are replayed: where each begins and what it carries.

use super::super::replay::interval;
use crate::physics::effects::{Active, EFFECT_PARAMS, Effect, Nominal};
use crate::physics::robot::Motor;
use crate::replays::packs::{Column, Run};

/// How a replay begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Begin {
    /// With the run: position, and the speed where a model does not say another one.
    Run { position: f64, speed: f64 },
    /// Within it, in the state that the position sensor saw: position, speed, acceleration,
    /// seconds since the run's start, the position there, and the distance moved forward since
    /// the last rest or turn.
    Seen { state: [f64; 3], since: f64, base: f64, sliding_distance: f64 },
}

/// What is replayed at a time, a run or a window of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// The drive's number.
    pub run: usize,
    /// First sample and one beyond the last.
    pub window: (usize, usize),
    pub begin: Begin,
    /// Factor on the nominal mass, of a run with a payload.
    pub payload: f64,
    /// Whether the robot was turned round: an error of the slope has the other sign.
    pub reversed: bool,
}

impl Span {
    pub fn samples(&self) -> usize {
        self.window.1 - self.window.0
    }
}

/// Drives, spans of them, and the nominal model.
pub struct Experiment {
    pub(super) nominal: Nominal,
    pub(super) runs: Vec<Run>,
    pub(super) intervals: Vec<f64>,
    pub(super) spans: Vec<Span>,
    /// Where there is one, electric power follows from force and speed.
    pub(super) motor: Option<Motor<f64>>,
}

/// A model with values, as it is replayed over one span.
#[derive(Debug, Clone, PartialEq)]
pub struct Spot {
    pub active: Active,
    pub values: [f64; EFFECT_PARAMS],
    pub shares: [f64; 4],
    /// Start speed, of a span that begins with its run.
    pub speed: f64,
    /// Shift of the start position.
    pub offset: f64,
}

/// A model with values: parameters of all effects, factors on nominal mass, Coulomb level
/// and gain, the clock offset, and how every span begins that begins with its run.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    pub active: Active,
    pub values: [f64; EFFECT_PARAMS],
    pub shares: [f64; 4],
    pub speeds: Vec<f64>,
    pub offsets: Vec<f64>,
}

impl Point {
    pub(super) fn spot(&self, span: usize) -> Spot {
        Spot {
            active: self.active,
            values: self.values,
            shares: self.shares,
            speed: self.speeds.get(span).copied().unwrap_or_default(),
            offset: self.offsets.get(span).copied().unwrap_or_default(),
        }
    }
}

impl Experiment {
    pub fn new(
        nominal: Nominal,
        runs: Vec<Run>,
        spans: Vec<Span>,
        motor: Option<Motor<f64>>,
    ) -> Experiment {
        let intervals = runs.iter().map(interval).collect();
        Experiment { nominal, runs, intervals, spans, motor }
    }

    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// Whether some spans begin with their runs, as models say.
    pub fn begins_with_runs(&self) -> bool {
        self.spans.iter().any(|span| matches!(span.begin, Begin::Run { .. }))
    }

    /// Samples of some spans.
    pub fn samples(&self, spans: &[usize]) -> usize {
        spans.iter().map(|span| self.spans[*span].samples()).sum()
    }

    /// The nominal model over a span.
    pub(super) fn plain(&self, span: usize) -> Spot {
        let speed = match self.spans[span].begin {
            Begin::Run { speed, .. } => speed,
            Begin::Seen { state, .. } => state[1],
        };
        Spot {
            active: Active::default(),
            values: [0.0; EFFECT_PARAMS],
            shares: [1.0, 1.0, 1.0, 0.0],
            speed,
            offset: 0.0,
        }
    }

    /// What is replayed, and what the sensor adds to its position.
    pub(super) fn column(&self, number: usize, spot: &Spot) -> (Column, f64) {
        let span = &self.spans[number];
        let (start, added, sliding_distance) = match span.begin {
            Begin::Run { position, .. } => ((position + spot.offset, spot.speed), 0.0, 0.0),
            Begin::Seen { state, since, base, sliding_distance } => {
                let (start, added) = before_sensor(spot, state, since, base);
                (start, added, sliding_distance)
            }
        };
        let (mut values, mut shares) = (spot.values, spot.shares);
        shares[0] *= span.payload;
        if span.reversed {
            values[Effect::SlopeError.first()] *= -1.0;
        }
        let Span { run, window, .. } = *span;
        let active = spot.active;
        (Column { run, window, active, values, shares, start, sliding_distance }, added)
    }
}

/// The true state that a sensor saw, and what its scale, which counts from the start of the
/// run, adds to the readings that follow.
fn before_sensor(spot: &Spot, state: [f64; 3], since: f64, base: f64) -> ((f64, f64), f64) {
    let value = |effect: Effect| {
        if spot.active.has(effect) { spot.values[effect.first()] } else { 0.0 }
    };
    let (scale, drift, delay) =
        (value(Effect::SensorScale), value(Effect::SensorDrift), value(Effect::SensorDelay));
    let [x, v, rate] = state;
    let read = x + v * delay + 0.5 * rate * delay * delay - drift * since;
    let position = base + (read - base) / (1.0 + scale);
    // A head that was seen at rest is at rest.
    let speed = if v == 0.0 { 0.0 } else { (v + rate * delay - drift) / (1.0 + scale) };
    ((position, speed), scale * (position - base))
}
