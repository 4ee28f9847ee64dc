//! One segment on its ground: the plant that integrators move.
//!
//! m dv/dt = F - R(v, ...) - m g sin(alpha), with the drive force
//! F = clip(drive(t)) + k_s (v_p t - x) + d_s (v_p - v) and friction R.

use super::drive::{Clock, Drive, DriveKind, Table};
use super::friction::{Contact, Parameters};
use super::params::ParamId;
use crate::lane::Lane;
use crate::lane::trig::{cos_turns, sin_turns};

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
    /// Distance moved forward since the last rest or turn, where the motion begins.
    pub sliding_distance: L,
    pub duration: L,
    pub step: L,
    pub tolerance: L,
    /// Position at which the stroke is complete.
    pub target: L,
}

impl<'a, L: Lane> Segment<'a, L> {
    #[inline(always)]
    pub fn new(kind: DriveKind, table: Table<'a>, params: &impl Parameters<L>) -> Self {
        let mass = params.get(ParamId::Mass);
        let x = params.get(ParamId::StartPosition);
        Segment {
            mass,
            per_mass: mass.splat(1.0) / mass,
            weight: (mass * params.get(ParamId::Gravity)) * params.derived(ParamId::SlopeDeg),
            swing: mass.splat(0.0),
            swings: false,
            limit: params.get(ParamId::DriveLimit),
            spring: params.get(ParamId::SpringStiffness),
            damper: params.get(ParamId::SpringDamping),
            pull: params.get(ParamId::PullSpeed),
            drive: Drive::new(kind, table, params),
            contact: Contact::of(params),
            x,
            v: params.get(ParamId::StartSpeed),
            sliding_distance: mass.splat(0.0),
            duration: params.get(ParamId::Duration),
            step: params.get(ParamId::TimeStep),
            tolerance: params.get(ParamId::Tolerance),
            target: x + params.get(ParamId::Stroke),
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

    /// Whether what pushes a segment at rest stays what it is from one jump of the drive to
    /// the next.
    #[inline(always)]
    pub fn is_steady(&self) -> bool {
        self.drive.is_steady() && !L::any(self.pull.splat(0.0).lt(self.pull.abs()))
    }

    /// What gravity pulls backward at a position.
    #[inline(always)]
    pub fn pull_back(&self, x: L) -> L {
        if !self.swings {
            return self.weight;
        }
        self.swing.mul_add(sin_turns(x * (0.5 / std::f64::consts::PI)), self.weight)
    }

    /// Derivative of `pull_back` by the position.
    #[inline(always)]
    pub fn pull_back_slope(&self, x: L) -> L {
        if !self.swings {
            return x.splat(0.0);
        }
        self.swing * cos_turns(x * (0.5 / std::f64::consts::PI))
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
        let held = self.spring * self.pull;
        if self.drive.is_steady() {
            return held;
        }
        let free = self.drive.force(t, clock).abs().lt(self.limit);
        held + L::select(free, self.drive.slope(t, clock), t.splat(0.0))
    }
}
