//! Laws under imposed motion: the friction force that a law gives at the samples
//! of a motion that was measured instead of simulated. States of a bristle law
//! are integrated along the motion.

use super::values::Values;
use super::{Bristle, Contact, ContactState, Dry, Law, MOST_STATES, Smooth};
use nalgebra::{LU, Matrix4, U4, Vector4};

/// Imposed motion of one run, sample by sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motion {
    /// Seconds, strictly rising.
    pub t: Vec<f64>,
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    /// Force of the drive, where a law asks for it.
    pub drive: Vec<f64>,
    /// Normal force.
    pub normal: Vec<f64>,
    /// Direction of motion; at rest the one in which it goes on: 1 or -1.
    pub direction: Vec<f64>,
    pub rests: Vec<bool>,
    /// Distance moved forward since the last rest or turn.
    pub sliding_distance: Vec<f64>,
}

impl Motion {
    /// The motion through samples; slower than `rest_speed` is at rest.
    pub fn new(t: Vec<f64>, x: Vec<f64>, v: Vec<f64>, drive: Vec<f64>, rest_speed: f64) -> Motion {
        let count = t.len();
        let rests: Vec<bool> = v.iter().map(|v| v.abs() <= rest_speed).collect();
        let mut direction = vec![1.0; count];
        let mut ahead: Option<f64> = None;
        for i in (0..count).rev() {
            if !rests[i] {
                ahead = Some(v[i].signum());
            }
            direction[i] = ahead.unwrap_or(0.0);
        }
        // A rest that nothing follows belongs to the motion before it.
        let mut before = 1.0;
        for direction in &mut direction {
            if *direction == 0.0 {
                *direction = before;
            }
            before = *direction;
        }
        let mut sliding_distance = vec![0.0; count];
        let mut since = x.first().copied().unwrap_or(0.0);
        for i in 0..count {
            let forward = !rests[i] && direction[i] > 0.0;
            let goes_on = i > 0 && !rests[i - 1] && direction[i - 1] > 0.0;
            if !(forward && goes_on) {
                since = x[i];
            }
            sliding_distance[i] = (x[i] - since).max(0.0);
        }
        let normal = vec![1.0; count];
        Motion { t, x, v, drive, normal, direction, rests, sliding_distance }
    }

    pub fn len(&self) -> usize {
        self.t.len()
    }

    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    fn at(&self, i: usize) -> ContactState<f64> {
        let (x, sliding_distance) = (self.x[i], self.sliding_distance[i]);
        ContactState {
            direction: self.direction[i],
            x,
            sliding_distance,
            drive: self.drive[i],
            t: self.t[i] - self.t[0],
        }
    }
}

/// The coefficients of a law at a sample, made anew only where the normal force
/// differs from the one before.
struct Pressed<'a, T: Law> {
    values: &'a Values,
    normal: f64,
    law: T::Coefficients<f64>,
}

impl<'a, T: Law> Pressed<'a, T> {
    fn new(values: &'a Values, normal: f64) -> Self {
        let law = T::coefficients(&Contact::under(normal, values), values);
        Pressed { values, normal, law }
    }

    fn at(&mut self, normal: f64) -> &T::Coefficients<f64> {
        if normal != self.normal {
            *self = Pressed::new(self.values, normal);
        }
        &self.law
    }
}

/// The force of a dry law; at rest what it holds in the direction of the push.
pub(super) fn dry<D: Dry>(values: &Values, motion: &Motion, rows: &[usize], to: &mut [f64]) {
    let Some(first) = rows.first() else { return };
    let mut pressed = Pressed::<D>::new(values, motion.normal[*first]);
    for (i, to) in rows.iter().copied().zip(to) {
        let (law, at) = (pressed.at(motion.normal[i]), motion.at(i));
        let level = if motion.rests[i] {
            D::break_away(law, &at)
        } else {
            D::resistance(law, motion.v[i].abs(), &at)
        };
        *to = at.direction * level;
    }
}

pub(super) fn smooth<S: Smooth>(values: &Values, motion: &Motion, rows: &[usize], to: &mut [f64]) {
    let Some(first) = rows.first() else { return };
    let mut pressed = Pressed::<S>::new(values, motion.normal[*first]);
    for (i, to) in rows.iter().copied().zip(to) {
        *to = S::force(pressed.at(motion.normal[i]), motion.v[i]);
    }
}

/// The force of a bristle law. The states begin as after long sliding at the
/// first speed, undeflected where the run begins at rest.
pub(super) fn bristle<B: Bristle>(
    values: &Values,
    motion: &Motion,
    rows: &[usize],
    to: &mut [f64],
) {
    let Some(last) = rows.last() else { return };
    let mut pressed = Pressed::<B>::new(values, motion.normal[0]);
    let law = *pressed.at(motion.normal[0]);
    let mut z = [0.0; MOST_STATES];
    if !motion.rests[0] && motion.v[0] != 0.0 {
        z = B::steady(&law, motion.v[0]);
    }
    let mut step = f64::INFINITY;
    let mut next = 0;
    for i in 0..=*last {
        let law = B::placed(pressed.at(motion.normal[i]), &motion.at(i));
        if i > 0 {
            let (from, until) = (i - 1, i);
            let dt = motion.t[until] - motion.t[from];
            let (v0, v1) = (motion.v[from], motion.v[until]);
            // |v| has a kink where the motion turns.
            if v0 * v1 < 0.0 {
                let share = v0 / (v0 - v1);
                deflect::<B>(&law, &mut z, (v0, 0.0), dt * share, &mut step);
                deflect::<B>(&law, &mut z, (0.0, v1), dt * (1.0 - share), &mut step);
            } else {
                deflect::<B>(&law, &mut z, (v0, v1), dt, &mut step);
            }
        }
        while next < rows.len() && rows[next] == i {
            let v = motion.v[i];
            to[next] = B::force(&law, v, &z, &B::rates(&law, v, &z));
            next += 1;
        }
    }
}

/// Local error of a step, relative to the states of steady sliding.
const TOLERANCE: f64 = 1e-3;
/// Smallest step as a share of the interval: the method damps what is faster.
const SMALLEST: f64 = 1e-2;
/// 1 - 1/sqrt(2): the method is then L-stable.
const GAMMA: f64 = 0.292_893_218_813_452_5;

/// Takes the states through `span` seconds while the speed changes evenly.
///
/// ROS2 of Verwer, Spee, Blom and Hundsdorfer 1999, order 2 with an embedded one
/// of order 1: bristles a thousand times faster than the samples do not limit it.
fn deflect<B: Bristle>(
    law: &B::Coefficients<f64>,
    z: &mut [f64; MOST_STATES],
    (from, until): (f64, f64),
    span: f64,
    step: &mut f64,
) {
    if span <= 0.0 {
        return;
    }
    let rise = (until - from) / span;
    let direction = if from + until < 0.0 { -1.0 } else { 1.0 };
    let usual = B::steady(law, direction * SLOW);
    let mut at = 0.0;
    while at < span {
        let left = span - at;
        let h = step.min(left);
        let v = rise.mul_add(at, from);
        let (tried, error) = attempt::<B>(law, z, (v, rise), h, &usual);
        let fine = error <= 1.0;
        if fine || h <= span * SMALLEST {
            // Across a kink at the smallest step the method may overshoot.
            *z = if fine { tried } else { creep::<B>(law, z, rise.mul_add(h, v), h) };
            at = if h >= left { span } else { at + h };
        }
        // Error falls with the square of the step. What the end of an interval
        // cut short says nothing against the step before.
        let factor = if error.is_finite() { 0.9 / error.max(1e-6).sqrt() } else { 0.1 };
        let proposed = h * factor.clamp(0.1, 8.0);
        *step = if fine && h >= left { step.max(proposed) } else { proposed.max(span * SMALLEST) };
        if !step.is_finite() {
            *step = proposed;
        }
    }
}

/// A speed at which states of steady sliding have their largest sizes, m/s.
const SLOW: f64 = 1e-12;

fn attempt<B: Bristle>(
    law: &B::Coefficients<f64>,
    z: &[f64; MOST_STATES],
    (v, rise): (f64, f64),
    h: f64,
    usual: &[f64; MOST_STATES],
) -> ([f64; MOST_STATES], f64) {
    let partials = B::partials(law, v, z);
    let rate = Vector4::from(B::rates(law, v, z));
    let drift = Vector4::from(partials.rate_v) * (rise * h * GAMMA);
    let solve = Damped::new(&partials.rate_z, h * GAMMA);
    let k1 = solve.at(rate + drift);
    let middle = Vector4::from(*z) + k1 * h;
    let ahead = Vector4::from(B::rates(law, rise.mul_add(h, v), &middle.into()));
    let k2 = solve.at(ahead - k1 * 2.0 - drift);
    let next = Vector4::from(*z) + (k1 * 3.0 + k2) * (0.5 * h);
    let mut error: f64 = 0.0;
    for i in 0..B::STATES {
        let size = usual[i].abs().max(f64::MIN_POSITIVE) * TOLERANCE;
        let off = (0.5 * h * (k1[i] + k2[i])).abs() / size;
        error = if off.is_nan() { f64::INFINITY } else { error.max(off) };
    }
    (next.into(), error)
}

/// One step of the linearly implicit Euler method, which does not overshoot.
fn creep<B: Bristle>(
    law: &B::Coefficients<f64>,
    z: &[f64; MOST_STATES],
    v: f64,
    h: f64,
) -> [f64; MOST_STATES] {
    let solve = Damped::new(&B::partials(law, v, z).rate_z, h);
    (Vector4::from(*z) + solve.at(Vector4::from(B::rates(law, v, z))) * h).into()
}

/// The system I - h J.
struct Damped {
    diagonal: Vector4<f64>,
    /// Where states see each other; most laws have one, or several apart.
    whole: Option<LU<f64, U4, U4>>,
}

impl Damped {
    fn new(slopes: &[[f64; MOST_STATES]; MOST_STATES], h: f64) -> Damped {
        let m = Matrix4::from_fn(|i, j| if i == j { 1.0 } else { 0.0 } - h * slopes[i][j]);
        let all = 0..MOST_STATES;
        let coupled = all.clone().any(|i| all.clone().any(|j| i != j && m[(i, j)] != 0.0));
        Damped { diagonal: m.diagonal(), whole: coupled.then(|| m.lu()) }
    }

    fn at(&self, right: Vector4<f64>) -> Vector4<f64> {
        match &self.whole {
            None => right.component_div(&self.diagonal),
            Some(m) => m.solve(&right).unwrap_or_else(|| Vector4::from_element(f64::NAN)),
        }
    }
}
