//! What joins the drive to the head.

use crate::effects::Effect;

/// A mass on the drive's side and what lies between it and the head.
#[derive(Debug, Clone, Copy)]
pub struct Joint {
    pub mass: f64,
    k: f64,
    d: f64,
    /// Half the play; 0 of a spring, which also pulls.
    gap: f64,
    spring: bool,
    /// Stretch at which a spring is twice as stiff.
    hardens: f64,
}

/// Stiffness of a play's stops, N/m per kg of head, and their damping as a share
/// of the critical one.
const STOP: f64 = 2e4;

impl Joint {
    pub fn of(effects: &[Effect], head: f64) -> Option<Joint> {
        effects.iter().find_map(|effect| match *effect {
            Effect::Compliance { k, d, m_d } => {
                Some(Joint { mass: m_d, k, d, gap: 0.0, spring: true, hardens: f64::INFINITY })
            }
            Effect::ComplianceHardening { k, d, m_d, s0 } => {
                Some(Joint { mass: m_d, k, d, gap: 0.0, spring: true, hardens: s0 })
            }
            Effect::Backlash { b, m_d } => {
                let k = STOP * head;
                let reduced = head * m_d / (head + m_d);
                let d = 2.0 * (k * reduced).sqrt();
                Some(Joint { mass: m_d, k, d, gap: b, spring: false, hardens: f64::INFINITY })
            }
            Effect::BacklashSoft { b, m_d, k, d } => {
                Some(Joint { mass: m_d, k, d, gap: b, spring: false, hardens: f64::INFINITY })
            }
            _ => None,
        })
    }

    /// Force on the head; `stretch` is how far the drive's side is ahead.
    pub fn force(&self, stretch: f64, rate: f64) -> f64 {
        if self.spring {
            let harder = 1.0 + (stretch / self.hardens).powi(2);
            return self.k * stretch * harder + self.d * rate;
        }
        let depth = stretch.abs() - self.gap;
        if depth <= 0.0 {
            return 0.0;
        }
        let direction = stretch.signum();
        direction * (self.k * depth + self.d * direction * rate).max(0.0)
    }

    /// Stretch of a spring that carries a force at rest; a play starts in its middle.
    pub fn loaded(&self, force: f64) -> f64 {
        if !self.spring {
            return 0.0;
        }
        let mut stretch = force / self.k;
        for _ in 0..50 {
            let harder = (stretch / self.hardens).powi(2);
            let slope = self.k * (1.0 + 3.0 * harder);
            stretch -= (self.k * stretch * (1.0 + harder) - force) / slope;
        }
        stretch
    }

    /// Fastest rate against a head, rad/s.
    pub fn fastest(&self, head: f64) -> f64 {
        let reduced = head * self.mass / (head + self.mass);
        (2.0 * self.k / reduced).sqrt().max(self.d / reduced)
    }
}
