//! What no motion of a segment exceeds, whatever its friction: a trajectory beyond it
//! has diverged, also where its numbers are still finite.
//!
//! Friction only takes energy, so with E = m v^2/2 + k_s (v_p t - x)^2/2 and
//! e = sqrt(2 E/m), which is at least |v|, the work that forces can do gives
//! de/dt <= (|F| + |W|)/m + |v_p| (sqrt(k_s/m) + d_s/(4 m)) while e > |v_p|.

use super::simulation::Simulation;
use crate::integrate::Method;
use crate::lane::Lane;
use crate::physics::segment::Segment;

/// Factor on the bound. The motion itself keeps within 1; steps that are coarse but stable
/// overshoot, and their open energy ledger is what tells of them. Divergence passes any factor.
const SLACK: f64 = 2.0;
/// Rounding of positions over a run, as a share of the start position.
const ROUNDING: f64 = 1e-6;

pub struct Bounds<L> {
    /// Position at the start, m.
    x: L,
    /// None where a closed form propagates: it has no step that could be too long.
    reach: Option<Reach<L>>,
}

struct Reach<L> {
    /// Speed at the start, m/s, and how much it may grow in a second, m/s^2.
    speed: L,
    growth: L,
}

impl<L: Lane> Bounds<L> {
    #[inline(always)]
    pub fn new(simulation: &Simulation, segment: &Segment<L>) -> Self {
        let stepped = simulation.method != Method::Exact;
        Bounds { x: segment.x, reach: stepped.then(|| Reach::new(simulation, segment)) }
    }

    /// Lanes that are within at time `t`; not those that are no numbers.
    #[inline(always)]
    pub fn hold(&self, t: L, x: L, v: L) -> L::Mask {
        let finite = L::and(x.is_finite(), v.is_finite());
        let Some(Reach { speed, growth }) = self.reach else { return finite };
        let speed = growth.mul_add(t, speed);
        let far = self.x.abs().mul_add(t.splat(ROUNDING), speed * t);
        L::and(finite, L::and(v.abs().le(speed), (x - self.x).abs().le(far)))
    }
}

impl<L: Lane> Reach<L> {
    #[inline(always)]
    fn new(simulation: &Simulation, segment: &Segment<L>) -> Self {
        // Bristles hold at most what breaks them away; a law that has no such level leaves
        // it open.
        let known = |level: L| L::select(level.not_nan(), level.abs(), level.splat(0.0));
        let held = known(segment.contact.break_away) + known(segment.contact.coulomb);
        let drive = segment.drive.largest(simulation.largest).min(segment.limit);
        let push = drive + segment.weight.abs() + held;
        let mut growth = push * segment.per_mass;
        let mut speed = segment.v.abs();
        if simulation.sprung {
            let rate = (segment.spring * segment.per_mass).sqrt();
            let pull = segment.pull.abs();
            let damped = segment.damper * segment.per_mass * 0.25;
            speed = rate.mul_add(segment.x.abs(), speed).max(pull);
            growth = pull.mul_add(rate + damped, growth);
        }
        Reach { speed: speed * SLACK, growth: growth * SLACK }
    }
}
