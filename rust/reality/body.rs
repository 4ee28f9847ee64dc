//! The anchored rest of a robot, which slides where the drive exceeds its grip.

use crate::effects::Effect;
use crate::rig::Rig;

#[derive(Debug, Clone, Copy)]
pub struct Body {
    mass: f64,
    pull: f64,
    break_away: f64,
    coulomb: f64,
    /// Speed over which grip falls to its sliding level; 0 for at once.
    v0: f64,
}

#[derive(Debug, Clone, Copy, Default)]
pub struct BodyState {
    pub x: f64,
    pub v: f64,
}

impl Body {
    pub fn of(effects: &[Effect], rig: &Rig, alpha: f64) -> Option<Body> {
        let (mu_static, mu_coulomb, v0) = effects.iter().find_map(|effect| match *effect {
            Effect::AnchorSlip { mu_static, mu_coulomb } => Some((mu_static, mu_coulomb, 0.0)),
            Effect::AnchorSlipFalling { mu_static, mu_coulomb, v0 } => {
                Some((mu_static, mu_coulomb, v0))
            }
            _ => None,
        })?;
        let mass = (rig.segments - 1.0) * rig.mass;
        let normal = mass * rig.gravity * alpha.cos();
        Some(Body {
            mass,
            pull: mass * rig.gravity * alpha.sin(),
            break_away: (mu_static * normal).max(mu_coulomb * normal),
            coulomb: mu_coulomb * normal,
            v0,
        })
    }

    fn level(&self, speed: f64) -> f64 {
        if self.v0 == 0.0 {
            return self.coulomb;
        }
        self.coulomb + (self.break_away - self.coulomb) * (-speed / self.v0).exp()
    }

    /// Moves for `dt` under the reaction to a drive force.
    pub fn advance(&self, state: &mut BodyState, drive: f64, dt: f64) {
        let push = -drive - self.pull;
        let mut left = dt;
        while left > 0.0 {
            if state.v == 0.0 && push.abs() <= self.break_away {
                return;
            }
            let direction = if state.v == 0.0 { push.signum() } else { state.v.signum() };
            let a = (push - direction * self.level(state.v.abs())) / self.mass;
            let stops = if direction * a < 0.0 { -state.v / a } else { f64::INFINITY };
            let step = left.min(stops);
            state.x += step * (state.v + 0.5 * a * step);
            state.v = if stops <= left { 0.0 } else { state.v + a * step };
            left -= step;
            if step == 0.0 {
                return;
            }
        }
    }
}
