//! Robots with elastic joints, step by step.
//!
//! One set-wise decision per step, on speeds: joints and viscous friction at an
//! intermediate time theta of the step, dry friction as an impulse that may
//! stop a segment but never turn it. theta is fitted to the stiffest mode: near
//! 1/2 (second order) where the step resolves it, towards 1 (which damps it
//! out) where it does not, so no stiffness asks for a smaller step.

use super::drive_work::Dragged;
use super::lubrication::{Heaps, Levels, Lubrication, Span};
use super::phase_groups::PhaseGroups;
use super::stick::Step;
use super::tally::{End, GaitTally, Ledger, STEP_LOSS};
use super::trace::{Now, Observer};
use super::{Plan, RunOptions};
use crate::lane::Lane;
use crate::physics::Status;
use crate::physics::gait::Schedule;
use crate::physics::robot::{MOST_SEGMENTS, Robot};

/// Most steps of one stretch, beyond which a run is refused.
const MOST_STEPS: f64 = 1e7;

/// Rounding of the voltage that a joint at its limit takes.
const VOLTAGE_ROUNDING: f64 = 1e-12;

/// Steps of equal length under constant command rates.
struct Stretch<'a, L> {
    roles: &'a PhaseGroups<L>,
    h: L,
    theta: L,
    /// 1 while the gait drives joints.
    driven: L,
    /// Commands at its start.
    from: [L; MOST_SEGMENTS],
}

/// What a step changes.
struct Saved<L> {
    x: [L; MOST_SEGMENTS],
    command: [L; MOST_SEGMENTS],
    v: [L; MOST_SEGMENTS],
    slide: [L; MOST_SEGMENTS],
    bound: [L; MOST_SEGMENTS],
    ledger: Ledger<L>,
    heaps: Option<Heaps<L>>,
}

struct Elastic<'a, L, O> {
    robot: &'a Robot<L>,
    n: usize,
    x: [L; MOST_SEGMENTS],
    /// Lengths that the drives have reached.
    command: [L; MOST_SEGMENTS],
    rate: [L; MOST_SEGMENTS],
    start: [L; MOST_SEGMENTS],
    step: Step<L>,
    ledger: Ledger<L>,
    /// By how much a joint is stretched beyond what its drive's force holds, as a force,
    /// N; the most of all joints, negative where every drive keeps its command.
    overstretch: L,
    /// Electrical power of the motors whose drives are dragged, beyond what they would draw
    /// at their commands' speed, W.
    power_dragged: L,
    theta_rate: L,
    time_step: L,
    break_away: L,
    /// 1 where a run is refused.
    endless: L,
    /// Whether any lane's supply bounds its voltage.
    supplied: bool,
    lubrication: Option<Box<Lubrication<L>>>,
    phase: usize,
    observer: &'a mut O,
}

/// Runs a robot whose joints are all elastic.
#[inline(always)]
pub(super) fn run<L: Lane, O: Observer<L>>(
    robot: &Robot<L>,
    plan: &Plan,
    options: &RunOptions<L>,
    observer: &mut O,
) -> GaitTally<L> {
    let schedule = plan.schedule;
    let like = options.time_step;
    let zero = like.splat(0.0);
    let n = robot.segments.len();
    let mut state = Elastic {
        robot,
        n,
        x: [zero; MOST_SEGMENTS],
        command: [zero; MOST_SEGMENTS],
        rate: [zero; MOST_SEGMENTS],
        start: [zero; MOST_SEGMENTS],
        step: Step::new(n, like),
        ledger: Ledger::new(like),
        overstretch: zero,
        power_dragged: zero,
        theta_rate: stiffest(robot),
        time_step: options.time_step,
        break_away: options.break_away,
        endless: zero,
        supplied: L::any(robot.motor.supply.lt(zero.splat(f64::INFINITY))),
        lubrication: Lubrication::of(robot),
        phase: 0,
        observer,
    };
    for (j, joint) in robot.joints.iter().enumerate() {
        state.start[j] = joint.stroke * schedule.start[j];
        state.command[j] = state.start[j];
    }
    let mut all: Vec<PhaseGroups<L>> = Vec::with_capacity(schedule.phases.len());
    for p in 0..schedule.phases.len() {
        all.push(PhaseGroups::of(robot, schedule, p));
    }
    let mut moved = zero;
    for _ in 0..plan.cycles {
        for (p, role) in all.iter().enumerate() {
            state.phase = p;
            state.phase(schedule, role, options);
            if !state.observer.go_on() {
                return GaitTally::none(zero, Status::NotFinite);
            }
        }
        moved = moved.max(state.ledger.time);
        let (x, ledger) = (&state.x, &mut state.ledger);
        ledger.cycle(&x[..n]);
    }
    let code = |status: Status| zero.splat(f64::from(status as u8));
    let status = L::select(zero.lt(moved), zero, code(Status::NoPhaseTime));
    let supply = robot.motor.supply * (1.0 + VOLTAGE_ROUNDING);
    let starved = supply.lt(state.ledger.voltage_peak);
    let status = L::select(starved, code(Status::SupplyTooWeak), status);
    let status = L::select(zero.lt(state.endless), code(Status::TooManySteps), status);
    let end = End {
        x: &state.x[..n],
        kinetic: state.kinetic(),
        elastic: state.elastic(),
        cycles: zero.splat(plan.cycles as f64),
        status,
        loss: STEP_LOSS,
    };
    state.ledger.close(robot, &end)
}

/// Bound of the fastest rate of any mode, 1/s.
#[inline(always)]
fn stiffest<L: Lane>(robot: &Robot<L>) -> L {
    let mut mass = robot.segments[0].mass;
    for segment in &robot.segments {
        mass = mass.min(segment.mass);
    }
    let zero = mass.splat(0.0);
    let (mut stiffness, mut damping) = (zero, zero);
    for joint in &robot.joints {
        stiffness = stiffness.max(joint.stiffness);
        damping = damping.max(joint.damping);
    }
    // A segment between two joints, its neighbours in opposite phase.
    let (per_mass, four) = (mass.splat(1.0) / mass, 4.0);
    (stiffness * per_mass * four).sqrt() + damping * per_mass * four
}

impl<L: Lane, O: Observer<L>> Elastic<'_, L, O> {
    #[inline(always)]
    fn phase(&mut self, schedule: &Schedule, roles: &PhaseGroups<L>, options: &RunOptions<L>) {
        let phase = &schedule.phases[self.phase];
        let zero = options.time_step.splat(0.0);
        let mut ramp = zero;
        for joint in &self.robot.joints {
            ramp = ramp.max(joint.stroke / joint.speed);
        }
        let ramp = ramp * phase.pace;
        let gradual = zero.lt(ramp);
        let before = self.elastic();
        let mut jumps = zero;
        for (j, joint) in self.robot.joints.iter().enumerate() {
            let target = joint.stroke * phase.target[j];
            self.rate[j] = L::select(gradual, (target - self.command[j]) / ramp, zero);
            // Without a speed limit the command jumps, and the drive as far as its force goes.
            let length = self.start[j] + (self.x[j] - self.x[j + 1]);
            let (from, to) = (self.command[j] - length, target - length);
            jumps = jumps.max((joint.held(to) - joint.held(from)).abs());
            self.command[j] = L::select(gradual, self.command[j], target);
        }
        // A jump has no time for heat; no voltage but an infinite one is fast enough.
        let given = self.elastic() - before;
        self.ledger.work = self.ledger.work + given;
        self.ledger.electric = self.ledger.electric + given;
        let jumps = L::and(L::not(gradual), zero.lt(jumps));
        let infinite = L::select(jumps, zero.splat(f64::INFINITY), zero);
        self.ledger.voltage_peak = self.ledger.voltage_peak.max(infinite);
        self.stretch(schedule, roles, ramp, zero.splat(1.0));
        for (j, joint) in self.robot.joints.iter().enumerate() {
            self.command[j] = joint.stroke * phase.target[j];
            self.rate[j] = zero;
        }
        if phase.rests {
            let driven = L::select(gradual, zero, zero.splat(1.0));
            self.stretch(schedule, roles, options.dwell, driven);
        }
    }

    /// A stretch of constant command rates, in equal steps. Every lane has its
    /// own number of them; those that are through wait for the others.
    #[inline(always)]
    fn stretch(&mut self, schedule: &Schedule, roles: &PhaseGroups<L>, duration: L, driven: L) {
        let half = duration.splat(0.5);
        // A quotient that rounding has put just above a whole number is meant.
        let count = -(-(duration / self.time_step - 1e-9)).floor();
        let endless = count.gt(half.splat(MOST_STEPS));
        self.endless = L::select(endless, half.splat(1.0), self.endless);
        let count = L::select(endless, half.splat(0.0), count);
        if !L::any(count.gt(half)) {
            return;
        }
        let h = L::select(count.gt(half), duration / count, duration.splat(0.0));
        let z = h * self.theta_rate;
        let theta = (z / (z + 6.0)) * 0.5 + 0.5;
        let stretch = Stretch { roles, h, theta, driven, from: self.command };
        // The hot loop has to be compiled for the level's instructions.
        duration.outlined(
            #[inline(always)]
            || self.steps(schedule, &stretch, count),
        );
    }

    #[inline(always)]
    fn steps(&mut self, schedule: &Schedule, stretch: &Stretch<L>, count: L) {
        let one = count.splat(1.0);
        let half = count.splat(0.5);
        self.prepare(schedule, stretch.h, stretch.theta);
        // A command may have jumped since the last step.
        self.overstretch = count.splat(f64::INFINITY);
        let mut left = count;
        while L::any(left.gt(half)) && self.observer.go_on() {
            let waiting = L::any((one - left).gt(half)).then(|| self.saved());
            self.advance(stretch, count - left);
            if let Some(saved) = waiting {
                self.restore(left.gt(half), &saved);
            }
            left = left - 1.0;
        }
    }

    #[inline(always)]
    fn saved(&self) -> Saved<L> {
        Saved {
            x: self.x,
            command: self.command,
            v: self.step.v,
            slide: self.step.slide,
            bound: self.step.bound,
            ledger: self.ledger.clone(),
            heaps: self.lubrication.as_ref().map(|all| all.heaps.clone()),
        }
    }

    /// Takes back a step where the mask does not hold.
    #[inline(always)]
    fn restore(&mut self, mask: L::Mask, saved: &Saved<L>) {
        for i in 0..self.n {
            self.x[i] = L::select(mask, self.x[i], saved.x[i]);
            self.command[i] = L::select(mask, self.command[i], saved.command[i]);
            self.step.v[i] = L::select(mask, self.step.v[i], saved.v[i]);
            self.step.slide[i] = L::select(mask, self.step.slide[i], saved.slide[i]);
            self.step.bound[i] = L::select(mask, self.step.bound[i], saved.bound[i]);
        }
        self.ledger.keep(mask, &saved.ledger);
        if let (Some(all), Some(heaps)) = (&mut self.lubrication, &saved.heaps) {
            all.restore(mask, heaps);
        }
    }

    /// What stays the same over a stretch.
    #[inline(always)]
    fn prepare(&mut self, schedule: &Schedule, h: L, theta: L) {
        let phase = &schedule.phases[self.phase];
        let (step, robot) = (&mut self.step, self.robot);
        for (i, segment) in robot.segments.iter().enumerate() {
            let levels = robot.levels(i, phase, self.break_away);
            step.inertia[i] = segment.mass + h * theta * segment.viscous;
            step.ahead_slide[i] = levels.ahead_slide * h;
            step.ahead_hold[i] = levels.ahead_hold * h;
            step.back_slide[i] = levels.back_slide * h;
            step.back_hold[i] = levels.back_hold * h;
        }
        for (j, joint) in robot.joints.iter().enumerate() {
            step.gain[j] = h * theta * (joint.stiffness * h * theta + joint.damping);
            step.limit[j] = h * joint.limit;
        }
        if let Some(all) = &mut self.lubrication {
            all.prepare(step);
        }
    }

    /// One step.
    #[inline(always)]
    fn advance(&mut self, stretch: &Stretch<L>, done: L) {
        let n = self.n;
        let Stretch { h, theta, from, .. } = stretch;
        let (h, theta) = (*h, *theta);
        let robot = self.robot;
        let step = &mut self.step;
        let rest = -(theta - 1.0);
        for (i, segment) in robot.segments.iter().enumerate() {
            step.push[i] =
                (segment.mass - h * rest * segment.viscous) * step.v[i] - h * segment.pull;
        }
        // From the start of the stretch, so that rounding does not pile up.
        let (at, next) = (h * (done + theta), h * (done + 1.0));
        for (j, joint) in robot.joints.iter().enumerate() {
            let length = self.start[j] + (self.x[j] - self.x[j + 1]);
            let drift = rest * (step.v[j] - step.v[j + 1]);
            let stretch = from[j] + self.rate[j] * at - length - h * theta * drift;
            let pace = self.rate[j] - drift;
            step.bias[j] = h * (joint.stiffness * stretch + joint.damping * pace);
            self.command[j] = from[j] + self.rate[j] * next;
        }
        self.lubricate(Levels::Start, stretch);
        // A second time with levels from the middle of the first solution.
        let rounds = if self.lubrication.is_some() { 2 } else { 1 };
        for round in 0..rounds {
            if round > 0 {
                self.lubricate(Levels::Middle, stretch);
            }
            self.step.solve();
        }
        self.account(stretch);
        self.sweep(stretch);
        for i in 0..n {
            self.step.v[i] = self.step.w[i];
        }
        if O::ON {
            self.show(stretch);
        }
    }

    /// Levels of friction under lubricant; dry ones stay as they are.
    #[inline(always)]
    fn lubricate(&mut self, levels: Levels, stretch: &Stretch<L>) {
        if let Some(all) = &mut self.lubrication {
            let Stretch { h, theta, .. } = *stretch;
            let (robot, x, step) = (self.robot, &self.x[..self.n], &mut self.step);
            h.outlined(
                #[inline(always)]
                || all.levels(levels, robot, Span { h, theta }, x, step),
            );
        }
    }

    /// Sweeps the ground that the segments have moved over.
    #[inline(always)]
    fn sweep(&mut self, stretch: &Stretch<L>) {
        if let Some(all) = &mut self.lubrication {
            let Stretch { h, theta, .. } = *stretch;
            let (robot, x, step) = (self.robot, &self.x[..self.n], &self.step);
            let lost = h.outlined(
                #[inline(always)]
                || all.sweep(robot, Span { h, theta }, x, step),
            );
            self.ledger.friction = self.ledger.friction + lost;
        }
    }

    /// Moves the segments and enters the step into the ledger.
    #[inline(always)]
    fn account(&mut self, stretch: &Stretch<L>) {
        let Stretch { roles, h, theta, driven, .. } = stretch;
        let (h, theta, driven) = (*h, *theta, *driven);
        let n = self.n;
        let (robot, step, sums) = (self.robot, &self.step, &mut self.ledger);
        let zero = h.splat(0.0);
        let rest = -(theta - 1.0);
        let per_h = h.splat(1.0) / h;
        let mut q_ahead = zero;
        let mut power = zero;
        let mut u_ahead = zero;
        let mut overstretch = zero.splat(f64::NEG_INFINITY);
        for i in 0..n {
            let segment = &robot.segments[i];
            let (v, w) = (step.v[i], step.w[i]);
            let u = theta * w + rest * v;
            let direction = h * u;
            let q = if i + 1 < n { step.q[i] } else { zero };
            let impulse = step.inertia[i] * w - step.push[i] - q + q_ahead;
            sums.friction = sums.friction + (segment.viscous * direction - impulse) * u;
            sums.potential = sums.potential + segment.pull * direction;
            sums.back[i] = sums.back[i] - direction.min(zero);
            self.x[i] = self.x[i] + direction;
            if i > 0 {
                let pace = u_ahead - u;
                let force = q_ahead * per_h;
                let joint = &robot.joints[i - 1];
                let length = self.start[i - 1] + (self.x[i - 1] - self.x[i]);
                let lead = (self.command[i - 1] - length).abs();
                overstretch = overstretch.max(joint.stiffness * lead - joint.limit);
                sums.joint_work = sums.joint_work + q_ahead * pace;
                sums.work = sums.work + q_ahead * self.rate[i - 1];
                sums.actuator_peak = sums.actuator_peak.max(force.abs());
                power = power + robot.motor.drawn(force, self.rate[i - 1]);
            }
            (q_ahead, u_ahead) = (q, u);
        }
        let dragged = L::any(zero.lt(self.overstretch.max(overstretch)));
        self.overstretch = overstretch;
        self.power_dragged = zero;
        if dragged || self.supplied {
            h.outlined(
                #[inline(always)]
                || self.account_drives(stretch),
            );
            power = power + self.power_dragged;
        }
        let (step, sums) = (&self.step, &mut self.ledger);
        sums.electric = sums.electric + power * h;
        sums.power_peak = sums.power_peak.max(power);
        let between = |from: usize, to: usize| {
            let behind = if to + 1 < n { step.q[to] } else { zero };
            let ahead = if from > 0 { step.q[from - 1] } else { zero };
            behind - ahead
        };
        let mut drive = zero;
        for (from, to) in &roles.movers {
            drive = drive + between(*from, *to);
        }
        sums.propulsive = sums.propulsive + drive * driven;
        sums.propulsive_peak = sums.propulsive_peak.max(drive * per_h);
        for (from, to, per_hold) in &roles.anchors {
            let demand = -between(*from, *to);
            // Nothing over nothing is no load.
            let load = L::select(zero.lt(demand), demand * per_h * *per_hold, zero);
            sums.overload = sums.overload.max(load);
        }
        sums.time = sums.time + h;
        sums.driven_time = sums.driven_time + h * driven;
        sums.steps = sums.steps + 1.0;
    }

    /// Enters what the drives that their joints drag along give beyond what `account` took
    /// for them, and the voltage that a bounded supply has to give. Both are rare, hence not
    /// in the loop of every step.
    #[inline(always)]
    fn account_drives(&mut self, stretch: &Stretch<L>) {
        let Stretch { h, theta, .. } = *stretch;
        let (robot, step, sums) = (self.robot, &self.step, &mut self.ledger);
        let zero = h.splat(0.0);
        let per_h = h.splat(1.0) / h;
        let rest = -(theta - 1.0);
        for (j, joint) in robot.joints.iter().enumerate() {
            let ahead = theta * step.w[j] + rest * step.v[j];
            let pace = ahead - (theta * step.w[j + 1] + rest * step.v[j + 1]);
            let (impulse, rate) = (step.q[j], self.rate[j]);
            let force = impulse * per_h;
            let length = self.start[j] + (self.x[j] - self.x[j + 1]);
            let lead = self.command[j] - length;
            let gained = h * (rate - pace);
            let most = lead.abs().max((lead - gained).abs());
            let slips = (joint.stiffness * most).gt(joint.limit);
            let given = Dragged { joint, lead, gained, impulse, pace, h, theta }.given();
            let more = given.work - impulse * rate;
            sums.work = sums.work + L::select(slips, more, zero);
            let drawn = robot.motor.drawn(force, zero) + given.work * per_h;
            let more = drawn - robot.motor.drawn(force, rate);
            self.power_dragged = self.power_dragged + L::select(slips, more, zero);
            if self.supplied {
                let pace = L::select(slips, given.pace, rate);
                let voltage = robot.motor.voltage(force, pace);
                sums.voltage_peak = sums.voltage_peak.max(voltage.abs());
            }
        }
    }

    #[inline(never)]
    fn show(&mut self, stretch: &Stretch<L>) {
        let Stretch { roles, h, .. } = stretch;
        let n = self.n;
        let zero = self.x[0].splat(0.0);
        let mut force = [zero; MOST_SEGMENTS];
        let mut power = zero;
        for (j, force) in force.iter_mut().enumerate().take(n - 1) {
            *force = self.step.q[j] / *h;
            power = power + self.robot.motor.drawn(*force, self.rate[j]);
        }
        let mut drive = zero;
        for (from, to) in &roles.movers {
            drive = drive + if to + 1 < n { force[*to] } else { zero };
            drive = drive - if *from > 0 { force[*from - 1] } else { zero };
        }
        self.observer.see(&Now {
            t: self.ledger.time,
            phase: self.phase,
            x: &self.x[..n],
            v: &self.step.w[..n],
            force: &force[..n - 1],
            slide: &self.step.slide[..n],
            heap: self.lubrication.as_ref().map_or(&[], |all| &all.heaps.swept[..n]),
            power: power + self.power_dragged,
            propulsive: drive,
        });
    }

    #[inline(always)]
    fn kinetic(&self) -> L {
        let mut sum = self.ledger.time.splat(0.0);
        for (i, segment) in self.robot.segments.iter().enumerate() {
            sum = sum + segment.mass * self.step.v[i] * self.step.v[i] * 0.5;
        }
        sum
    }

    /// Energy in the joints' springs.
    #[inline(always)]
    fn elastic(&self) -> L {
        let mut sum = self.ledger.time.splat(0.0);
        for (j, joint) in self.robot.joints.iter().enumerate() {
            let length = self.start[j] + (self.x[j] - self.x[j + 1]);
            let stretch = joint.held(self.command[j] - length);
            sum = sum + joint.stiffness * stretch * stretch * 0.5;
        }
        sum
    }
}
