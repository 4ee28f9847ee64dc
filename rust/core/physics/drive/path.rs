//! What a plant does to a command before it becomes a force.

use super::Clock;
use crate::lane::Lane;
use crate::lane::exp::{exp, exp_less_one, speed_factor};

/// What becomes of a stepwise command on its way to the segment, in this order:
/// delay, gain, dead zone, limit, lag.
#[derive(Debug, Clone, Copy)]
pub struct Path<L> {
    pub delay: L,
    /// Force per unit of the command, less `1 - sag (1 - e^(-t/sag_time))`.
    pub gain: L,
    pub sag: L,
    /// Inverse times; 0 where nothing fades.
    pub per_sag_time: L,
    pub deadzone: L,
    pub limit: L,
    pub per_lag: L,
    /// Which of them act at all.
    pub sags: bool,
    pub lags: bool,
}

impl<L: Lane> Path<L> {
    /// Gain left at a time.
    #[inline(always)]
    fn share(&self, t: L) -> L {
        if !self.sags {
            return t.splat(1.0);
        }
        // 1 - a (1 - e^-u)
        self.sag.mul_add(exp_less_one(-(t * self.per_sag_time)), t.splat(1.0))
    }

    /// Force without the lag.
    #[inline(always)]
    pub(super) fn settled(&self, command: L, t: L) -> L {
        let force = command * (self.gain * self.share(t));
        let size = (force.abs() - self.deadzone).max(t.splat(0.0)).min(self.limit);
        force.sign() * size
    }

    #[inline(always)]
    pub(super) fn force(&self, command: L, t: L, clock: &Clock<L>) -> L {
        let settled = self.settled(command, t);
        if !self.lags {
            return settled;
        }
        let gone = exp_less_one(-((t - clock.since) * self.per_lag));
        // from + (settled - from)(1 - e^-u)
        (clock.from - settled).mul_add(gone, clock.from)
    }

    /// Mean of the lagging force over `dt`: its impulse is exact.
    #[inline(always)]
    pub(super) fn mean(&self, command: L, t: L, dt: L, clock: &Clock<L>) -> L {
        let settled = self.settled(command, dt.mul_add(t.splat(0.5), t));
        let now = exp(-((t - clock.since) * self.per_lag));
        let left = now * speed_factor(dt * self.per_lag);
        (clock.from - settled).mul_add(left, settled)
    }

    #[inline(always)]
    pub(super) fn slope(&self, command: L, t: L, clock: &Clock<L>) -> L {
        if self.lags {
            return (self.settled(command, t) - self.force(command, t, clock)) * self.per_lag;
        }
        if !self.sags {
            return t.splat(0.0);
        }
        // Within dead zone or beyond the limit it is less; steps are short there.
        let fade = (self.sag * self.per_sag_time) * exp(-(t * self.per_sag_time));
        -((command * self.gain) * fade)
    }
}
