//! What is kept of a run: sums and extremes, the same for both integrators.

use crate::lane::Lane;
use crate::physics::Status;
use crate::physics::robot::{MOST_SEGMENTS, Robot};

/// Results of a run of several cycles. Energies count over the whole run.
#[derive(Debug, Clone, Copy)]
pub struct GaitTally<L> {
    /// Mean advance of the segments per cycle, m.
    pub advance: L,
    /// The same in the last cycle, m.
    pub last_advance: L,
    /// Duration of the run, s.
    pub time: L,
    /// Advance over time, m/s.
    pub velocity: L,
    /// Distance that each segment slides backward per cycle, m.
    pub slip: [L; MOST_SEGMENTS],
    /// The largest of them, m.
    pub slip_max: L,
    /// What a group of anchors could hold over what it has to, the smallest
    /// over time and groups; inf where nothing pushes them back.
    pub anchor_safety: L,
    /// Force of the joints on the moving segments, N: mean while the gait
    /// drives a joint, and largest.
    pub propulsive_mean: L,
    pub propulsive_peak: L,
    /// Largest force of any joint's actuator, N.
    pub actuator_peak: L,
    /// Electrical power of all motors, W.
    pub power_mean: L,
    pub power_peak: L,
    /// J.
    pub electric_energy: L,
    /// Work of the drives, J.
    pub work: L,
    /// Lost in friction between segments and ground, J.
    pub friction: L,
    /// Lost between drive and joint, in the damper.
    pub damping: L,
    /// Lost in impacts at the end of a stroke, J; negative where a drive of
    /// unlimited force starts with a jerk.
    pub impact: L,
    /// Change of the stored energies, J.
    pub kinetic: L,
    pub potential: L,
    pub elastic: L,
    /// Work less all of the above: what the method itself loses, J.
    pub residual: L,
    /// Work and electrical energy per weight and distance.
    pub transport_cost: L,
    pub electric_transport_cost: L,
    /// Steps or events.
    pub steps: L,
    /// Code of the status; every value is NaN where it is not `Ok`.
    pub status: L,
}

/// Sums and extremes so far.
#[derive(Debug, Clone)]
pub(super) struct Ledger<L> {
    pub time: L,
    pub driven_time: L,
    pub back: [L; MOST_SEGMENTS],
    pub overload: L,
    pub propulsive: L,
    pub propulsive_peak: L,
    pub actuator_peak: L,
    pub electric: L,
    pub power_peak: L,
    /// Largest voltage that a motor takes in either direction, V.
    pub voltage_peak: L,
    /// Of the drives and at the joints.
    pub work: L,
    pub joint_work: L,
    pub friction: L,
    pub impact: L,
    pub potential: L,
    pub steps: L,
    pub cycle_start: L,
    pub last_advance: L,
}

/// Most that rounding takes from the energies of a run: some 1e-16 of them per entry,
/// and no run has more than 1e7 entries.
pub(super) const ROUNDING_LOSS: f64 = 1e-9;
/// Most that steps over elastic joints take. A step that does not resolve the springs
/// damps them out on purpose, and their energy is a part of what the drives give; a run
/// that loses more is about its step.
pub(super) const STEP_LOSS: f64 = 0.25;

/// State at the end of a run.
pub(super) struct End<'a, L> {
    pub x: &'a [L],
    pub kinetic: L,
    pub elastic: L,
    pub cycles: L,
    pub status: L,
    /// Share of the run's energies that its method may lose.
    pub loss: f64,
}

impl<L: Lane> Ledger<L> {
    pub fn new(like: L) -> Ledger<L> {
        let zero = like.splat(0.0);
        Ledger {
            time: zero,
            driven_time: zero,
            back: [zero; MOST_SEGMENTS],
            overload: zero,
            propulsive: zero,
            propulsive_peak: zero,
            actuator_peak: zero,
            electric: zero,
            power_peak: zero,
            voltage_peak: zero,
            work: zero,
            joint_work: zero,
            friction: zero,
            impact: zero,
            potential: zero,
            steps: zero,
            cycle_start: zero,
            last_advance: zero,
        }
    }

    /// Notes where a cycle ends.
    #[inline(always)]
    pub fn cycle(&mut self, x: &[L]) {
        let here = mean(x);
        self.last_advance = here - self.cycle_start;
        self.cycle_start = here;
    }

    #[inline(always)]
    pub fn close(&self, robot: &Robot<L>, end: &End<L>) -> GaitTally<L> {
        let zero = self.time.splat(0.0);
        let total = mean(end.x);
        let damping = self.work - self.joint_work - end.elastic;
        let stored = end.kinetic + self.potential;
        let mut mass = zero;
        for segment in &robot.segments {
            mass = mass + segment.mass;
        }
        let weight = mass * robot.gravity;
        let (mut slip, mut slip_max) = (self.back, zero);
        for slip in &mut slip {
            *slip = *slip / end.cycles;
            slip_max = slip_max.max(*slip);
        }
        let tally = GaitTally {
            advance: total / end.cycles,
            last_advance: self.last_advance,
            time: self.time,
            velocity: total / self.time,
            slip,
            slip_max,
            anchor_safety: zero.splat(1.0) / self.overload,
            propulsive_mean: self.propulsive / self.driven_time,
            propulsive_peak: self.propulsive_peak,
            actuator_peak: self.actuator_peak,
            power_mean: self.electric / self.time,
            power_peak: self.power_peak,
            electric_energy: self.electric,
            work: self.work,
            friction: self.friction,
            damping,
            impact: self.impact,
            kinetic: end.kinetic,
            potential: self.potential,
            elastic: end.elastic,
            residual: self.joint_work - self.friction - self.impact - stored,
            transport_cost: self.work / (weight * total),
            electric_transport_cost: self.electric / (weight * total),
            steps: self.steps,
            status: end.status,
        };
        // A run that has left the range of numbers shows it in its position.
        let finite = total.abs().lt(zero.splat(f64::INFINITY));
        let lost = zero.splat(f64::from(Status::NotFinite as u8));
        let open = zero.splat(f64::from(Status::EnergyOpen as u8));
        let status = L::select(tally.balances(end.loss), zero, open);
        let status = L::select(finite, status, lost);
        let status = L::select(zero.lt(end.status), end.status, status);
        tally.only_if(status.lt(zero.splat(0.5)), status)
    }
}

impl<L: Lane> GaitTally<L> {
    /// Whether the energies of the run add up: the method makes none, and loses no more
    /// than the share `loss` of all that was turned over.
    #[inline(always)]
    fn balances(&self, loss: f64) -> L::Mask {
        let lost = self.friction + self.impact.abs();
        let stored = self.kinetic + self.potential.abs() + self.elastic;
        let all = self.work.abs() + lost + stored;
        let made = (-(all * ROUNDING_LOSS)).le(self.residual);
        L::and(made, self.residual.le(all * loss))
    }
}

#[inline(always)]
pub(super) fn mean<L: Lane>(x: &[L]) -> L {
    let mut sum = x[0];
    for x in &x[1..] {
        sum = sum + *x;
    }
    sum / sum.splat(x.len() as f64)
}

macro_rules! fields {
    ($($field:ident),+) => {
        impl<L: Lane> GaitTally<L> {
            /// NaN where `mask` does not hold, with the status given there.
            #[inline(always)]
            fn only_if(self, mask: L::Mask, status: L) -> GaitTally<L> {
                let mut slip = self.slip;
                for slip in &mut slip {
                    *slip = slip.only_if(mask);
                }
                GaitTally { $($field: self.$field.only_if(mask),)+ slip, status }
            }

            /// No run at all, for this reason.
            #[inline(always)]
            pub fn none(like: L, status: Status) -> GaitTally<L> {
                let nan = like.splat(f64::NAN);
                GaitTally {
                    $($field: nan,)+
                    slip: [nan; MOST_SEGMENTS],
                    status: like.splat(f64::from(status as u8)),
                }
            }

            /// The results of one lane.
            pub fn lane(&self, i: usize) -> GaitTally<f64> {
                GaitTally {
                    $($field: self.$field.lane(i),)+
                    slip: self.slip.map(|s| s.lane(i)),
                    status: self.status.lane(i),
                }
            }

            /// Lanes from their results.
            pub fn fill(like: L, lanes: impl Fn(usize) -> GaitTally<f64>) -> GaitTally<L> {
                GaitTally {
                    $($field: like.fill(|i| lanes(i).$field),)+
                    slip: std::array::from_fn(|s| like.fill(|i| lanes(i).slip[s])),
                    status: like.fill(|i| lanes(i).status),
                }
            }
        }

        impl GaitTally<f64> {
            /// Names of the results, one number each.
            pub const NAMES: &'static [&'static str] = &[$(stringify!($field)),+];

            /// The results in the order of their names.
            pub fn values(&self) -> Vec<f64> {
                vec![$(self.$field),+]
            }

            pub fn status(&self) -> Status {
                let code = self.status as usize;
                Status::ALL.get(code).copied().unwrap_or(Status::NotFinite)
            }
        }
    };
}
fields! {
    advance, last_advance, time, velocity, slip_max, anchor_safety, propulsive_mean,
    propulsive_peak, actuator_peak, power_mean, power_peak, electric_energy, work, friction,
    damping, impact, kinetic, potential, elastic, residual, transport_cost,
    electric_transport_cost, steps
}

macro_rules! ledger {
    ($($field:ident),+) => {
        impl<L: Lane> Ledger<L> {
            /// Takes back what does not belong to `mask`.
            #[inline(always)]
            pub fn keep(&mut self, mask: L::Mask, before: &Ledger<L>) {
                $(self.$field = L::select(mask, self.$field, before.$field);)+
                for (now, before) in self.back.iter_mut().zip(&before.back) {
                    *now = L::select(mask, *now, *before);
                }
            }
        }
    };
}
ledger! {
    time, driven_time, overload, propulsive, propulsive_peak, actuator_peak, electric,
    power_peak, voltage_peak, work, joint_work, friction, impact, potential, steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::robot::Motor;

    /// A run that turned over a joule, and whose balance is `open` by so much.
    fn closed(open: f64, loss: f64) -> GaitTally<f64> {
        let mut ledger = Ledger::new(0.0);
        (ledger.time, ledger.friction) = (1.0, 0.5);
        (ledger.work, ledger.joint_work) = (0.5 + open, 0.5 + open);
        let robot = Robot {
            segments: Vec::new(),
            joints: Vec::new(),
            motor: Motor { supply: 10.0, resistance: 20.0, force_constant: 1.7 },
            wall_release: 0.0,
            gravity: 9.81,
            lubricants: Vec::new(),
            segment_pitch: 0.0,
        };
        let end = End { x: &[1.0], kinetic: 0.0, elastic: 0.0, cycles: 1.0, status: 0.0, loss };
        ledger.close(&robot, &end)
    }

    #[test]
    fn an_open_ledger_is_never_ok() {
        for (open, loss, status) in [
            (0.0, ROUNDING_LOSS, Status::Ok),
            (1e-10, ROUNDING_LOSS, Status::Ok),
            (-1e-10, STEP_LOSS, Status::Ok),
            (0.1, STEP_LOSS, Status::Ok),
            (1e-8, ROUNDING_LOSS, Status::EnergyOpen),
            (-1e-8, ROUNDING_LOSS, Status::EnergyOpen),
            (-1e-8, STEP_LOSS, Status::EnergyOpen),
            (1.0, STEP_LOSS, Status::EnergyOpen),
            (f64::NAN, STEP_LOSS, Status::EnergyOpen),
        ] {
            let tally = closed(open, loss);
            assert_eq!(tally.status(), status, "{open} {loss}");
            assert_eq!(tally.work.is_nan(), status != Status::Ok);
        }
    }
}
