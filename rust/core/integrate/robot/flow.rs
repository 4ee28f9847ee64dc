//! One piece of motion between two events: which segments move as one, how
//! their speed fades, and what enters the ledger.

use super::chain::Body;
use super::ideal::{Drive, Ideal};
use super::motion::{Drift, Gap};
use super::trace::{Now, Observer};
use crate::physics::gait::{Phase, Schedule};

/// Nodes and weights of Gauss and Legendre on [0, 1], for the power and the force on
/// the moving segments.
const NODES: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_55),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
    (0.953_089_922_969_332, 0.118_463_442_528_094_55),
];

/// Movers and anchors of a phase.
pub(super) struct Piece {
    pub movers: Vec<(usize, usize)>,
    /// With what each group can hold.
    pub anchors: Vec<(usize, usize, f64)>,
    pub phase: usize,
}

pub(super) struct Flow {
    /// Per segment.
    drift: Vec<Drift>,
    /// 1, 0 or -1 per segment.
    slide: Vec<f64>,
    /// Change of each joint's force per change of its segments' speed.
    slope: Vec<f64>,
}

impl Flow {
    pub fn roles<O: Observer<f64>>(state: &Ideal<O>, phase: &Phase) -> Piece {
        let held = |(from, to): (usize, usize)| {
            let each = |i: usize| state.levels[i].back_hold - state.robot.segments[i].pull;
            (from, to, (from..=to).map(each).sum::<f64>())
        };
        Piece {
            movers: Schedule::groups(phase, true),
            anchors: Schedule::groups(phase, false).into_iter().map(held).collect(),
            phase: state.phase,
        }
    }

    /// From the accelerations `a` that the set-wise decision has found.
    pub fn new<O: Observer<f64>>(state: &Ideal<O>, a: &[f64], bodies: &[Body]) -> Flow {
        let n = a.len();
        let segments = &state.robot.segments;
        let sign = |x: f64| f64::from(i8::from(x > 0.0) - i8::from(x < 0.0));
        let slide = |i: usize| sign(if state.v[i] == 0.0 { a[i] } else { state.v[i] });
        let slide: Vec<f64> = (0..n).map(slide).collect();
        let mut drift = vec![Drift::default(); n];
        let mut slope = vec![0.0; n.saturating_sub(1)];
        let mut first = 0;
        while first < n {
            let mut last = first;
            while last + 1 < n && !matches!(state.joints[last].drive, Drive::Push(_)) {
                last += 1;
            }
            let group = first..=last;
            let sticks =
                group.clone().any(|i| state.v[i] == 0.0 && a[i] == 0.0 && holds(&bodies[i]));
            if !sticks {
                let friction = |i: usize| match state.v[i] == 0.0 {
                    true if a[i] > 0.0 => -bodies[i].ahead,
                    true if a[i] < 0.0 => bodies[i].back,
                    _ => 0.0,
                };
                let mass: f64 = group.clone().map(|i| segments[i].mass).sum();
                let fade: f64 = group.clone().map(|i| segments[i].viscous).sum::<f64>() / mass;
                let own: f64 = group.clone().map(|i| bodies[i].push + friction(i)).sum();
                let behind = if last + 1 < n { state.joints[last].force } else { 0.0 };
                let ahead = if first > 0 { state.joints[first - 1].force } else { 0.0 };
                let common = Drift { a: (own + behind - ahead) / mass, alpha: fade };
                let mut sum = 0.0;
                for i in group {
                    drift[i] = common;
                    sum += segments[i].viscous - fade * segments[i].mass;
                    if i < last {
                        slope[i] = sum;
                    }
                }
            }
            first = last + 1;
        }
        Flow { drift, slide, slope }
    }

    pub fn of(&self, i: usize) -> Drift {
        self.drift[i]
    }

    pub fn gap<O: Observer<f64>>(&self, state: &Ideal<O>, j: usize) -> Gap {
        Gap { rate: state.v[j] - state.v[j + 1], front: self.drift[j], rear: self.drift[j + 1] }
    }

    /// When the force of a joint at its speed reaches an end of its range, and which.
    pub fn time_to_limit(&self, j: usize, force: f64, range: (f64, f64)) -> Option<(f64, f64)> {
        let slope = self.slope[j];
        if slope == 0.0 || range.1.is_infinite() {
            return None;
        }
        // Only the change that the drift brings about leads anywhere.
        let side = (slope * self.drift[j].a).signum();
        let end = if side < 0.0 { range.0 } else { range.1 };
        let change = (end - force) / slope;
        self.drift[j].time_to(change).map(|t| (t, side))
    }

    /// Force of a joint after `t`.
    fn force(&self, now: f64, j: usize, t: f64) -> f64 {
        if self.slope[j] == 0.0 { now } else { now + self.slope[j] * self.drift[j].speed(t) }
    }

    fn power<O: Observer<f64>>(&self, state: &Ideal<O>, t: f64) -> f64 {
        let mut sum = 0.0;
        for (j, joint) in state.joints.iter().enumerate() {
            if joint.drive != Drive::Locked {
                let pace = state.v[j] - state.v[j + 1];
                let pace = pace + self.drift[j].speed(t) - self.drift[j + 1].speed(t);
                sum += state.robot.motor.drawn(self.force(joint.force, j, t), pace);
            }
        }
        sum
    }

    /// Force of the joints on the segments from `from` to `to`.
    fn between<O: Observer<f64>>(&self, state: &Ideal<O>, from: usize, to: usize, t: f64) -> f64 {
        let force = |j: usize| self.force(state.joints[j].force, j, t);
        let behind = if to + 1 < state.x.len() { force(to) } else { 0.0 };
        let ahead = if from > 0 { force(from - 1) } else { 0.0 };
        behind - ahead
    }

    fn propulsive<O: Observer<f64>>(&self, state: &Ideal<O>, roles: &Piece, t: f64) -> f64 {
        roles.movers.iter().map(|(from, to)| self.between(state, *from, *to, t)).sum()
    }

    /// Enters the piece into the ledger.
    pub fn enter<O: Observer<f64>>(
        &self,
        state: &mut Ideal<O>,
        roles: &Piece,
        dt: f64,
        driven: bool,
    ) {
        let mut sums = state.ledger.clone();
        for (i, segment) in state.robot.segments.iter().enumerate() {
            let (v, drift) = (state.v[i], &self.drift[i]);
            let direction = v * dt + drift.path(dt);
            let levels = &state.levels[i];
            let level = if self.slide[i] > 0.0 { levels.ahead_slide } else { levels.back_slide };
            sums.friction += level * direction.abs() + segment.viscous * drift.square(v, dt);
            sums.potential += segment.pull * direction;
            sums.back[i] -= direction.min(0.0);
        }
        for (j, joint) in state.joints.iter().enumerate() {
            if joint.drive == Drive::Locked {
                continue;
            }
            let gap = state.v[j] - state.v[j + 1];
            let grown = gap * dt + self.drift[j].path(dt) - self.drift[j + 1].path(dt);
            // Where the force changes at all, the rate does not.
            sums.work += joint.force * grown + gap * self.slope[j] * self.drift[j].path(dt);
            let last = self.force(joint.force, j, dt);
            sums.actuator_peak = sums.actuator_peak.max(joint.force.abs()).max(last.abs());
        }
        sums.joint_work = sums.work;
        for (node, weight) in NODES {
            sums.electric += dt * weight * self.power(state, node * dt);
            if driven {
                sums.propulsive += dt * weight * self.propulsive(state, roles, node * dt);
            }
        }
        for t in [0.0, dt] {
            sums.power_peak = sums.power_peak.max(self.power(state, t));
            sums.propulsive_peak = sums.propulsive_peak.max(self.propulsive(state, roles, t));
            for (from, to, hold) in &roles.anchors {
                let demand = -self.between(state, *from, *to, t);
                if demand > 0.0 {
                    sums.overload = sums.overload.max(demand / hold.max(0.0));
                }
            }
        }
        if driven {
            sums.driven_time += dt;
        }
        state.ledger = sums;
    }

    /// Shows the samples that fall into the piece.
    pub fn watch<O: Observer<f64>>(&self, state: &mut Ideal<O>, roles: &Piece, dt: f64) {
        if !O::ON {
            return;
        }
        let n = state.x.len();
        loop {
            let t = (state.observer.next() - state.ledger.time).max(0.0);
            if t > dt || !state.observer.go_on() {
                return;
            }
            let at = |i: usize| state.x[i] + state.v[i] * t + self.drift[i].path(t);
            let force = |j: usize| self.force(state.joints[j].force, j, t);
            let x: Vec<f64> = (0..n).map(at).collect();
            let v: Vec<f64> = (0..n).map(|i| state.v[i] + self.drift[i].speed(t)).collect();
            let force: Vec<f64> = (0..n - 1).map(force).collect();
            let power = self.power(state, t);
            let propulsive = self.propulsive(state, roles, t);
            state.observer.see(&Now {
                t: state.ledger.time + t,
                phase: roles.phase,
                x: &x,
                v: &v,
                force: &force,
                slide: &self.slide,
                heap: &[],
                power,
                propulsive,
            });
        }
    }
}

/// Whether a body has friction that can keep it where it is.
fn holds(body: &Body) -> bool {
    body.ahead > 0.0 || body.back > 0.0
}
