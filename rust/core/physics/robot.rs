//! The whole robot: segments in a line, neighbours joined by prismatic
//! actuators. Segment 0 is the head and the foremost; joint j lies between the
//! segments j and j + 1, and its force pushes the first of them forward and the
//! other one backward.

use super::friction::Parameters;
use super::gait::{Grip, Phase};
use super::lubricant::Lubricant;
use super::params::ParamId;
use crate::lane::Lane;

pub use super::gait::MOST_SEGMENTS;

/// A segment and the ground under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment<L> {
    /// kg.
    pub mass: L,
    /// Weight along the slope, N, positive where it pulls backward.
    pub pull: L,
    /// Normal force from the weight, N.
    pub load: L,
    /// Force that presses the segment to the wall where it grips fully, N.
    pub wall: L,
    pub mu_static: L,
    pub mu_coulomb: L,
    /// N s/m.
    pub viscous: L,
    /// Backward over forward friction.
    pub skin_ratio: L,
}

/// Largest friction forces of a segment, N. `ahead` resists forward and `back`
/// backward motion, each while it slides and while it rests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Levels<L> {
    pub ahead_slide: L,
    pub ahead_hold: L,
    pub back_slide: L,
    pub back_hold: L,
}

impl<L: Lane> Segment<L> {
    /// Friction of a segment that keeps `share` of its wall force. A contact at
    /// rest holds at least what it resists in motion.
    #[inline(always)]
    pub fn levels(&self, share: L) -> Levels<L> {
        let normal = self.load + self.wall * share;
        let slide = self.mu_coulomb * normal;
        let hold = (self.mu_static * normal).max(slide);
        Levels {
            ahead_slide: slide,
            ahead_hold: hold,
            back_slide: slide * self.skin_ratio,
            back_hold: hold * self.skin_ratio,
        }
    }
}

impl<L: Lane> Levels<L> {
    /// The same where a contact at rest holds no more than in motion.
    #[inline(always)]
    pub fn without_break_away(mut self) -> Levels<L> {
        (self.ahead_hold, self.back_hold) = (self.ahead_slide, self.back_slide);
        self
    }

    #[inline(always)]
    fn select(mask: L::Mask, a: &Levels<L>, b: &Levels<L>) -> Levels<L> {
        Levels {
            ahead_slide: L::select(mask, a.ahead_slide, b.ahead_slide),
            ahead_hold: L::select(mask, a.ahead_hold, b.ahead_hold),
            back_slide: L::select(mask, a.back_slide, b.back_slide),
            back_hold: L::select(mask, a.back_hold, b.back_hold),
        }
    }
}

/// A prismatic actuator. Its drive follows the gait's command at `speed`; a
/// spring and a damper in parallel stand between the drive and the joint, whose
/// force never exceeds `limit`: the drive does not get farther from the joint than
/// the spring stretches under it (`held`), and is dragged along. An ideal joint
/// (infinite stiffness) extends under the force `limit`, or what the motor's supply
/// allows at its speed, up to `speed`, and is locked wherever the gait does not move it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint<L> {
    /// m.
    pub stroke: L,
    /// N.
    pub limit: L,
    /// m/s.
    pub speed: L,
    /// N/m.
    pub stiffness: L,
    /// N s/m.
    pub damping: L,
}

impl<L: Lane> Joint<L> {
    /// Stretch of the spring where the command is this far from the joint, m.
    #[inline(always)]
    pub fn held(&self, lead: L) -> L {
        let most = self.limit / self.stiffness;
        lead.min(most).max(-most)
    }
}

/// The DC motor that stands behind every joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motor<L> {
    /// V.
    pub supply: L,
    /// Ohm.
    pub resistance: L,
    /// N/A, and V s/m.
    pub force_constant: L,
}

impl<L: Lane> Motor<L> {
    /// Electrical power at a force and a joint speed, W; negative where the
    /// motor returns power. The voltage stays within the supply.
    #[inline(always)]
    pub fn power(&self, force: L, speed: L) -> L {
        let current = force / self.force_constant;
        let voltage = self.resistance * current + self.force_constant * speed;
        voltage.min(self.supply).max(-self.supply) * current
    }

    /// The same at the voltage that force and speed take: heat of the winding, and
    /// mechanical power.
    #[inline(always)]
    pub fn drawn(&self, force: L, speed: L) -> L {
        let current = force / self.force_constant;
        self.voltage(force, speed) * current
    }

    /// Voltage that a force takes at a joint speed, V.
    #[inline(always)]
    pub fn voltage(&self, force: L, speed: L) -> L {
        self.resistance * (force / self.force_constant) + self.force_constant * speed
    }

    /// Force that the motor loses per speed at a constant voltage, N s/m.
    pub fn force_per_speed(&self) -> L {
        self.force_constant * self.force_constant / self.resistance
    }

    /// Force at a standstill under the full supply, N.
    pub fn stall_force(&self) -> L {
        self.force_constant * self.supply / self.resistance
    }
}

/// A robot with everything that may differ between its parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot<L> {
    /// From the head backward.
    pub segments: Vec<Segment<L>>,
    /// One fewer.
    pub joints: Vec<Joint<L>>,
    pub motor: Motor<L>,
    /// Share of the wall force that moving segments let go, where the gait lets
    /// them.
    pub wall_release: L,
    pub gravity: L,
    /// One per segment, or none where no segment meets any.
    pub lubricants: Vec<Lubricant<L>>,
    /// Distance between neighbouring segments at the start, m.
    pub segment_pitch: L,
}

impl<L: Lane> Robot<L> {
    /// `segments` equal segments and joints from the parameters of a point.
    #[inline(always)]
    pub fn uniform(params: &impl Parameters<L>, segments: usize) -> Robot<L> {
        let mass = params.get(ParamId::Mass);
        let weight = mass * params.get(ParamId::Gravity);
        // The Coulomb term may be dropped beside viscous friction; break-away stays.
        let none = mass.splat(0.0);
        let viscous = params.get(ParamId::Viscous);
        let dropped =
            L::and(params.get(ParamId::CoulombTerm).lt(mass.splat(0.5)), viscous.gt(none));
        let segment = Segment {
            mass,
            pull: weight * params.derived(ParamId::SlopeDeg),
            load: weight * params.derived(ParamId::CornerDeg) * params.get(ParamId::SlopeDeg),
            wall: params.get(ParamId::WallForce),
            mu_static: params.get(ParamId::MuStatic),
            mu_coulomb: L::select(dropped, none, params.get(ParamId::MuCoulomb)),
            viscous,
            skin_ratio: params.get(ParamId::SkinRatio),
        };
        let joint = Joint {
            stroke: params.get(ParamId::Stroke),
            limit: params.get(ParamId::DriveLimit),
            speed: params.get(ParamId::SpeedLimit),
            stiffness: params.get(ParamId::JointStiffness),
            damping: params.get(ParamId::JointDamping),
        };
        let lubricant = Lubricant::of(params);
        let lubricated = L::any(lubricant.acts());
        Robot {
            segments: vec![segment; segments],
            joints: vec![joint; segments.saturating_sub(1)],
            motor: Motor {
                supply: params.get(ParamId::SupplyVoltage),
                resistance: params.get(ParamId::WindingResistance),
                force_constant: params.get(ParamId::ForceConstant),
            },
            wall_release: params.get(ParamId::WallRelease),
            gravity: params.get(ParamId::Gravity),
            lubricants: vec![lubricant; if lubricated { segments } else { 0 }],
            segment_pitch: params.get(ParamId::SegmentPitch),
        }
    }

    /// Friction of segment `i` during a phase. With `break_away` 0 the segments
    /// that the gait moves have no static friction of their own.
    #[inline(always)]
    pub fn levels(&self, i: usize, phase: &Phase, break_away: L) -> Levels<L> {
        let one = self.gravity.splat(1.0);
        let levels = self.segments[i].levels(match phase.grip[i] {
            Grip::Full => one,
            Grip::Eased => one - self.wall_release,
            Grip::Free => self.gravity.splat(0.0),
        });
        if !phase.moves[i] {
            return levels;
        }
        let must = break_away.gt(one * 0.5);
        Levels::select(must, &levels, &levels.without_break_away())
    }

    /// One lane as a robot of its own.
    pub fn lane(&self, i: usize) -> Robot<f64> {
        let segment = |s: &Segment<L>| Segment {
            mass: s.mass.lane(i),
            pull: s.pull.lane(i),
            load: s.load.lane(i),
            wall: s.wall.lane(i),
            mu_static: s.mu_static.lane(i),
            mu_coulomb: s.mu_coulomb.lane(i),
            viscous: s.viscous.lane(i),
            skin_ratio: s.skin_ratio.lane(i),
        };
        let joint = |j: &Joint<L>| Joint {
            stroke: j.stroke.lane(i),
            limit: j.limit.lane(i),
            speed: j.speed.lane(i),
            stiffness: j.stiffness.lane(i),
            damping: j.damping.lane(i),
        };
        Robot {
            segments: self.segments.iter().map(segment).collect(),
            joints: self.joints.iter().map(joint).collect(),
            motor: Motor {
                supply: self.motor.supply.lane(i),
                resistance: self.motor.resistance.lane(i),
                force_constant: self.motor.force_constant.lane(i),
            },
            wall_release: self.wall_release.lane(i),
            gravity: self.gravity.lane(i),
            lubricants: self.lubricants.iter().map(|l| l.lane(i)).collect(),
            segment_pitch: self.segment_pitch.lane(i),
        }
    }
}
