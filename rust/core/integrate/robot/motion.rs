//! Motion between events in closed form, and when it gets somewhere.
//!
//! With constant forces and viscous friction a body has the speed
//! v + a t E1(alpha t) and the path v t + a t^2 E2(alpha t) (see `lane::exp`,
//! which these are without its fused operations: one robot at a time is no place
//! for them); alpha = 0 is the parabola.

use crate::lane::exp::log_factor;

/// Longest time that a single piece of motion may take, s.
pub const LONGEST: f64 = 1e7;

/// The change of a body's speed from now on.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Drift {
    /// Acceleration now.
    pub a: f64,
    /// Rate at which it fades.
    pub alpha: f64,
}

impl Drift {
    pub fn speed(&self, t: f64) -> f64 {
        if self.alpha == 0.0 {
            return self.a * t;
        }
        self.a * t * first(self.alpha * t)
    }

    pub fn path(&self, t: f64) -> f64 {
        if self.alpha == 0.0 {
            return 0.5 * self.a * t * t;
        }
        self.a * t * t * second(self.alpha * t)
    }

    /// When the speed has changed by `change`.
    pub fn time_to(&self, change: f64) -> Option<f64> {
        let t = change / self.a;
        let x = -self.alpha * t;
        (t >= 0.0 && t.is_finite() && x > -1.0).then(|| t * log_factor(x))
    }

    /// Integral of the squared speed of a body that starts with `v`.
    pub fn square(&self, v: f64, t: f64) -> f64 {
        if self.alpha == 0.0 && self.a == 0.0 {
            return v * v * t;
        }
        v * v * t + 2.0 * v * self.path(t) + self.a * self.a * t * t * t * third(self.alpha * t)
    }
}

/// (1 - e^-x)/x for x > 0.
fn first(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { -libm::expm1(-x) / x }
}

/// (x + e^-x - 1)/x^2 for x > 0.
fn second(x: f64) -> f64 {
    if x > 0.5 {
        return (x + libm::expm1(-x)) / (x * x);
    }
    // Sum of (-x)^n/(n + 2)!; 14 terms leave less than 1e-17.
    (0..14).rev().fold(0.0, |sum, n| (1.0 - x * sum) / f64::from(n + 2))
}

/// Integral of (s E1(x s))^2 over s from 0 to 1.
fn third(x: f64) -> f64 {
    if x == 0.0 {
        return 1.0 / 3.0;
    }
    if x > 0.5 {
        let g = |x: f64| -libm::expm1(-x);
        return (x - 2.0 * g(x) + 0.5 * g(2.0 * x)) / (x * x * x);
    }
    // Sum of (-x)^m (2^(m+2) - 2)/((m+2)! (m+3)); 20 terms leave less than 1e-17.
    let (mut sum, mut power, mut factorial, mut two) = (0.0, 1.0, 2.0, 4.0);
    for m in 0..20 {
        let m = f64::from(m);
        sum += power * (two - 2.0) / (factorial * (m + 3.0));
        power *= -x;
        factorial *= m + 3.0;
        two *= 2.0;
    }
    sum
}

/// The distance of two bodies: rate now, and the drifts of the two.
#[derive(Debug, Clone, Copy)]
pub struct Gap {
    pub rate: f64,
    pub front: Drift,
    pub rear: Drift,
}

impl Gap {
    pub fn flipped(&self) -> Gap {
        Gap { rate: -self.rate, front: self.rear, rear: self.front }
    }

    /// Whether nothing but rounding still changes the rate.
    pub fn is_steady(&self) -> bool {
        (self.front.a - self.rear.a).abs() * LONGEST <= self.rate.abs()
    }

    fn gain(&self, t: f64) -> f64 {
        self.front.speed(t) - self.rear.speed(t)
    }

    fn path(&self, t: f64) -> f64 {
        self.rate * t + (self.front.path(t) - self.rear.path(t))
    }

    fn uniform(&self) -> bool {
        self.front.alpha == 0.0 && self.rear.alpha == 0.0
    }

    /// Times between which the rate is monotone.
    fn turns(&self) -> Vec<f64> {
        let (f, r) = (&self.front, &self.rear);
        let t = libm::log(f.a / r.a) / (f.alpha - r.alpha);
        if t > 0.0 && t < LONGEST { vec![0.0, t, LONGEST] } else { vec![0.0, LONGEST] }
    }

    /// When the rate has first grown by `change`; what rounding has left negative counts
    /// as nothing.
    pub fn time_to_rate(&self, change: f64) -> Option<f64> {
        let a = self.front.a - self.rear.a;
        if self.uniform() {
            return (a > 0.0).then(|| change / a);
        }
        if change <= 0.0 && a > 0.0 {
            return Some(0.0);
        }
        let turns = self.turns();
        turns.windows(2).find_map(|t| root(|x| self.gain(x) - change, t[0], t[1]))
    }

    /// When the gap has first grown by `length` >= 0.
    pub fn time_to_length(&self, length: f64) -> Option<f64> {
        if self.uniform() {
            return parabola(self.rate, self.front.a - self.rear.a, length);
        }
        // The path is monotone between the zeros of the rate.
        let mut ends = vec![0.0];
        for t in self.turns().windows(2) {
            let rate = |x: f64| self.gain(x) + self.rate;
            ends.extend(root(rate, t[0], t[1]).or_else(|| root(|x| -rate(x), t[0], t[1])));
            ends.push(t[1]);
        }
        ends.windows(2).find_map(|t| root(|x| self.path(x) - length, t[0], t[1]))
    }
}

/// First t > 0 with v t + a t^2/2 = length >= 0, without cancellation.
fn parabola(v: f64, a: f64, length: f64) -> Option<f64> {
    let square = v * v + 2.0 * a * length;
    if square < 0.0 || (a <= 0.0 && v <= 0.0) {
        return None;
    }
    let root = square.sqrt();
    Some(if v >= 0.0 { 2.0 * length / (v + root) } else { (root - v) / a })
}

/// The zero of a monotone function that rises through zero in (low, high], to
/// the last digit.
fn root(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> Option<f64> {
    let (mut at_low, mut at_high) = (f(low), f(high));
    if at_low >= 0.0 || at_high.is_nan() || at_high < 0.0 {
        return None;
    }
    // Bisection in orders of magnitude finds the scale, then the secant with
    // the Illinois rule takes over.
    let mut smallest = 1e-12;
    while low == 0.0 && high > smallest {
        let middle = (high * smallest).sqrt();
        let value = f(middle);
        if value < 0.0 {
            (low, at_low) = (middle, value);
        } else {
            (high, at_high) = (middle, value);
            smallest *= smallest;
        }
    }
    while high > 4.0 * low && low > 0.0 {
        let middle = (low * high).sqrt();
        let value = f(middle);
        if value < 0.0 {
            (low, at_low) = (middle, value)
        } else {
            (high, at_high) = (middle, value)
        }
    }
    let mut kept = 0;
    for _ in 0..200 {
        let t = high - at_high * ((high - low) / (at_high - at_low));
        let t = if t > low && t < high { t } else { 0.5 * (low + high) };
        if high - low <= 2.0 * f64::EPSILON * high || t <= low || t >= high {
            break;
        }
        let value = f(t);
        if value == 0.0 {
            return Some(t);
        }
        // An end that stays twice would stall the secant.
        if value < 0.0 {
            (low, at_low) = (t, value);
            at_high *= if kept == 1 { 0.5 } else { 1.0 };
            kept = 1;
        } else {
            (high, at_high) = (t, value);
            at_low *= if kept == -1 { 0.5 } else { 1.0 };
            kept = -1;
        }
    }
    Some(high)
}
