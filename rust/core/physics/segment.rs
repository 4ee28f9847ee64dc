//! One segment on its ground: the plant that integrators move.
//!
//! m dv/dt = F - R(v, ...) - m g sin(alpha), with the drive force
//! F = clip(drive(t)) + k_s (v_p t - x) + d_s (v_p - v) and friction R.

use super::drive::{Clock, Drive, DriveKind, Table};
use super::friction::{Contact, Given};
use super::params::ParamId;
use crate::lane::Lane;
use crate::lane::trig::sin_turns;

#[derive(Clone, Copy)]
pub struct Segment<'a, L> {
    pub mass: L,
    pub per_mass: L,
    /// Pull of the slope, backward positive, N.
    pub weight: L,
    pub limit: L,
    /// Largest pull of gravity on a pendulum, N m; 0 elsewhere.
    pub swing: L,
    pub swings: bool,
    pub spring: L,
    pub damper: L,
    pub pull: L,
    pub drive: Drive<'a, L>,
    pub contact: Contact<L>,
    pub x: L,
    pub v: L,
    pub duration: L,
    pub step: L,
    pub tolerance: L,
    /// Position at which the stroke is complete.
    pub target: L,
}

impl<'a, L: Lane> Segment<'a, L> {
    #[inline(always)]
    pub fn new(kind: DriveKind, table: Table<'a>, given: &impl Given<L>) -> Self {
        let mass = given.get(ParamId::Mass);
        let x = given.get(ParamId::StartPosition);
        Segment {
            mass,
            per_mass: mass.with(1.0) / mass,
            weight: (mass * given.get(ParamId::Gravity)) * given.derived(ParamId::SlopeDeg),
            swing: mass.with(0.0),
            swings: false,
            limit: given.get(ParamId::DriveLimit),
            spring: given.get(ParamId::SpringStiffness),
            damper: given.get(ParamId::SpringDamping),
            pull: given.get(ParamId::PullSpeed),
            drive: Drive::new(kind, table, given),
            contact: Contact::of(given),
            x,
            v: given.get(ParamId::StartSpeed),
            duration: given.get(ParamId::Duration),
            step: given.get(ParamId::TimeStep),
            tolerance: given.get(ParamId::Tolerance),
            target: x + given.get(ParamId::Stroke),
        }
    }

    /// Force of the drive, spring included, on the segment.
    #[inline(always)]
    pub fn force(&self, t: L, clock: &Clock<L>, x: L, v: L) -> L {
        self.with_spring(self.commanded(t, clock), t, x, v)
    }

    /// Force of the drive alone, within its limit.
    #[inline(always)]
    pub fn commanded(&self, t: L, clock: &Clock<L>) -> L {
        self.drive.force(t, clock).clip(self.limit)
    }

    /// What gravity pulls backward at a position.
    #[inline(always)]
    pub fn pull_back(&self, x: L) -> L {
        if !self.swings {
            return self.weight;
        }
        self.swing.mul_add(sin_turns(x * (0.5 / std::f64::consts::PI)), self.weight)
    }

    /// The same where the drive's own force is already known.
    #[inline(always)]
    pub fn with_spring(&self, drive: L, t: L, x: L, v: L) -> L {
        let stretch = self.pull.mul_add(t, -x);
        self.damper.mul_add(self.pull - v, self.spring.mul_add(stretch, drive))
    }

    /// Derivative of the force by time at fixed position and speed.
    #[inline(always)]
    pub fn force_slope(&self, t: L, clock: &Clock<L>) -> L {
        let free = self.drive.force(t, clock).abs().lt(self.limit);
        let slope = L::select(free, self.drive.slope(t, clock), t.with(0.0));
        self.spring.mul_add(self.pull, slope)
    }
}
