//! Robots with ideal joints, from event to event: between two of them every
//! force is constant or fades with the speed, so motion is known in closed form
//! and nothing is lost to a step size. Events are a segment that comes to rest,
//! a joint that reaches its speed, its force limit or its length.

use super::chain::{Body, Chain, Link, Sliding, solve_with_break_away};
use super::flow::{Flow, Piece};
use super::motion::LONGEST;
use super::tally::{End, GaitTally, Ledger, ROUNDING_LOSS};
use super::trace::Observer;
use super::{Plan, RunOptions};
use crate::physics::Status;
use crate::physics::gait::Phase;
use crate::physics::robot::{Joint, Levels, Robot};

/// Events per phase before the run is given up.
const MOST_EVENTS: usize = 2_000;
/// Pieces of a phase between events, before it is given up: minutes at the usual step.
const MOST_PIECES: usize = 200_000;
/// Events this close to each other (relative to the time to the first) count as one.
const TIE: f64 = 1e-11;
/// Relative rounding of a length that has been reached.
const REACHED: f64 = 1e-12;
/// Rounding of a joint's length per position of its segments, of which it is the
/// difference: a few units in the last place.
const POSITION_ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Most that this rounding may take of a stroke. Beyond it a robot has gone so far (it
/// falls) that its strokes end by chance; travels of 1e7 m stay below.
const STROKE_ROUNDING: f64 = 1e-6;

/// What a joint does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Drive {
    Locked,
    /// Below (1) or above (-1) its speed: the full force, in this direction.
    Push(f64),
    /// At its speed, with what force that takes.
    Paced,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Actuator {
    pub drive: Drive,
    /// Speed of the gait's command, with its sign.
    pub rate: f64,
    /// Length to reach.
    pub target: f64,
    /// Force now.
    pub force: f64,
    /// Forces that it can give at its speed, backward and forward.
    range: (f64, f64),
    /// The supply allows less than its limit somewhere below its speed.
    starved: bool,
    /// Its limit has let it fall behind its speed, and no time has passed since.
    let_go: bool,
}

pub(super) struct Ideal<'a, O> {
    pub robot: &'a Robot<f64>,
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub levels: Vec<Levels<f64>>,
    pub joints: Vec<Actuator>,
    start: Vec<f64>,
    chain: Chain,
    bodies: Vec<Body>,
    sliding: Vec<Sliding>,
    links: Vec<Link>,
    pub ledger: Ledger<f64>,
    pub phase: usize,
    /// Force of a motor at a standstill, N, and what it loses per speed, N s/m.
    stall: f64,
    loss: f64,
    /// Longest piece under a force that falls with speed, s.
    piece: f64,
    pub observer: &'a mut O,
}

/// Runs a robot whose joints are all ideal.
pub(super) fn run<O: Observer<f64>>(
    robot: &Robot<f64>,
    plan: &Plan,
    options: &RunOptions<f64>,
    observer: &mut O,
) -> GaitTally<f64> {
    let stall = robot.motor.stall_force();
    let boundless =
        |j: &Joint<f64>| j.limit.is_infinite() && j.speed.is_infinite() && stall.is_infinite();
    if robot.joints.iter().any(boundless) {
        return GaitTally::none(0.0, Status::Unbounded);
    }
    let n = robot.segments.len();
    let idle = Actuator {
        drive: Drive::Locked,
        rate: 0.0,
        target: 0.0,
        force: 0.0,
        range: (0.0, 0.0),
        starved: false,
        let_go: false,
    };
    let lengths = robot.joints.iter().zip(&plan.schedule.start);
    let mut state = Ideal {
        robot,
        x: vec![0.0; n],
        v: vec![0.0; n],
        levels: robot.segments.iter().map(|s| s.levels(1.0)).collect(),
        joints: vec![idle; robot.joints.len()],
        start: lengths.map(|(joint, length)| joint.stroke * length).collect(),
        chain: Chain::default(),
        bodies: Vec::new(),
        sliding: Vec::new(),
        links: Vec::new(),
        ledger: Ledger::new(0.0),
        phase: 0,
        stall,
        loss: robot.motor.force_per_speed(),
        piece: options.time_step,
        observer,
    };
    for _ in 0..plan.cycles {
        for (p, phase) in plan.schedule.phases.iter().enumerate() {
            state.phase = p;
            if let Err(status) = state.phase(phase, options) {
                return GaitTally::none(0.0, status);
            }
        }
        state.ledger.cycle(&state.x);
    }
    let kinetic = state.kinetic();
    let cycles = plan.cycles as f64;
    let end = End { x: &state.x, kinetic, elastic: 0.0, cycles, status: 0.0, loss: ROUNDING_LOSS };
    state.ledger.close(robot, &end)
}

impl<O: Observer<f64>> Ideal<'_, O> {
    fn phase(&mut self, phase: &Phase, options: &RunOptions<f64>) -> Result<(), Status> {
        for (i, levels) in self.levels.iter_mut().enumerate() {
            *levels = self.robot.levels(i, phase, options.break_away);
        }
        self.command(phase);
        self.jerk(options.impact);
        let groups = Flow::roles(self, phase);
        let (mut events, mut pieces) = (0, 0);
        while self.joints.iter().any(|j| j.drive != Drive::Locked) {
            self.may_go_on(&mut events)?;
            let flow = self.flow();
            let (dt, happened) = self.next(&flow, self.longest(&flow));
            if dt.is_infinite() || (happened.is_empty() && self.never_arrives(&flow)) {
                // A drive that stalls on the way ends the phase where it stands.
                if events == 1 {
                    return Err(Status::DriveTooWeak);
                }
                self.joints.iter_mut().for_each(|j| j.drive = Drive::Locked);
                self.jerk(options.impact);
                break;
            }
            self.go(&flow, &groups, dt, true);
            self.apply(&happened, options.impact);
            if happened.is_empty() {
                (events, pieces) = (events - 1, pieces + 1);
                if pieces > MOST_PIECES {
                    return Err(Status::TooManySteps);
                }
            }
        }
        self.resolves_strokes()?;
        if options.impact == 0.0 {
            self.ledger.impact += self.kinetic();
            self.v.iter_mut().for_each(|v| *v = 0.0);
        }
        let mut left = if phase.rests { options.dwell } else { 0.0 };
        while left > 0.0 {
            self.may_go_on(&mut events)?;
            let flow = self.flow();
            let (dt, happened) = self.next(&flow, left);
            self.go(&flow, &groups, dt, false);
            self.apply(&happened, options.impact);
            left -= dt;
        }
        Ok(())
    }

    fn may_go_on(&self, events: &mut usize) -> Result<(), Status> {
        *events += 1;
        match (self.observer.go_on(), *events <= MOST_EVENTS) {
            (false, _) => Err(Status::NotFinite),
            (_, false) => Err(Status::TooManySteps),
            _ => Ok(()),
        }
    }

    pub fn length(&self, j: usize) -> f64 {
        self.start[j] + (self.x[j] - self.x[j + 1])
    }

    /// How far rounding of the positions can put a joint's length off.
    fn rounding(&self, j: usize) -> f64 {
        POSITION_ROUNDING * self.x[j].abs().max(self.x[j + 1].abs())
    }

    fn resolves_strokes(&self) -> Result<(), Status> {
        let lost =
            |(j, joint): (usize, &Joint<f64>)| self.rounding(j) > STROKE_ROUNDING * joint.stroke;
        if self.robot.joints.iter().enumerate().any(lost) {
            return Err(Status::Unresolved);
        }
        Ok(())
    }

    /// Hands the joints the lengths of a phase.
    fn command(&mut self, phase: &Phase) {
        let times = self.robot.joints.iter().map(|j| j.stroke / j.speed);
        let time = phase.pace * times.fold(0.0, f64::max);
        for (j, joint) in self.robot.joints.iter().enumerate() {
            let target = joint.stroke * phase.target[j];
            let direction = target - self.length(j);
            // A length that only rounding keeps from its target has no rate to be driven at.
            let here = direction.abs() <= (REACHED * joint.stroke).max(self.rounding(j));
            let rate =
                if time > 0.0 { direction / time } else { direction.signum() * f64::INFINITY };
            let drive = if here { Drive::Locked } else { Drive::Paced };
            let (range, starved) = self.supplied(joint.limit, rate);
            let force = 0.0;
            self.joints[j] = Actuator { drive, rate, target, force, range, starved, let_go: false };
        }
    }

    /// Forces that a joint can give at a speed, and whether its supply cuts into its limit
    /// anywhere on the way up to it.
    fn supplied(&self, limit: f64, rate: f64) -> ((f64, f64), bool) {
        if self.stall.is_infinite() {
            return ((-limit, limit), false);
        }
        let within = |force: f64| force.max(-limit).min(limit);
        let lost = self.loss * rate;
        let range = (within(-self.stall - lost), within(self.stall - lost));
        (range, self.stall - lost.abs() < limit)
    }

    fn starves(&self, j: usize) -> bool {
        self.joints[j].starved && matches!(self.joints[j].drive, Drive::Push(_))
    }

    /// Whether a joint goes away from its length, faster and faster.
    fn recedes(&self, flow: &Flow, j: usize) -> bool {
        let gap = flow.gap(self, j);
        let side = self.joints[j].rate.signum();
        side * gap.rate <= 0.0 && side * (gap.front.a - gap.rear.a) <= 0.0
    }

    /// Longest piece: a force that falls with speed is constant over each. Once the speeds
    /// have settled, or the limit holds for good, it is constant indeed.
    fn longest(&self, flow: &Flow) -> f64 {
        let mut starved = (0..self.joints.len()).filter(|j| self.starves(*j)).peekable();
        if starved.peek().is_none() {
            return f64::INFINITY;
        }
        let limited = |j: usize| self.joints[j].force.abs() >= self.robot.joints[j].limit;
        let settled =
            |j: usize| flow.gap(self, j).is_steady() || (limited(j) && self.recedes(flow, j));
        if starved.all(settled) { LONGEST } else { self.piece }
    }

    /// Whether joints that the supply holds back go away from their lengths, faster and
    /// faster, or have settled, and nothing else will happen.
    fn never_arrives(&self, flow: &Flow) -> bool {
        let lost = |j: usize| self.recedes(flow, j) || flow.gap(self, j).is_steady();
        (0..self.joints.len()).all(|j| !self.starves(j) || lost(j))
            && self.next(flow, LONGEST).1.is_empty()
    }

    /// Joins at once what no finite force keeps apart: locked joints, and those
    /// of unlimited force, whose rates jump. Momentum is kept; or, with
    /// `impact` 0, what is locked to a resting segment rests too.
    fn jerk(&mut self, impact: f64) {
        let before = self.kinetic();
        let n = self.x.len();
        let (robot, stall) = (self.robot, self.stall);
        let boundless = |j: usize| robot.joints[j].limit.is_infinite() && stall.is_infinite();
        let stiff = |joints: &[Actuator], j: usize| match joints[j].drive {
            Drive::Locked => Some(0.0),
            _ if boundless(j) => Some(joints[j].rate),
            _ => None,
        };
        let mut first = 0;
        while first < n {
            let mut last = first;
            // Speeds relative to the first segment of the rigid run.
            let mut offsets = vec![0.0];
            while let Some(rate) = (last + 1 < n).then(|| stiff(&self.joints, last)).flatten() {
                offsets.push(offsets[last - first] - rate);
                last += 1;
            }
            let (mut mass, mut momentum) = (0.0, 0.0);
            for i in first..=last {
                mass += self.robot.segments[i].mass;
                momentum += self.robot.segments[i].mass * (self.v[i] - offsets[i - first]);
            }
            // Rounding must not wake what rests.
            let driven = offsets.iter().any(|o| *o != 0.0);
            let speeds = &self.v[first..=last];
            let rests =
                speeds.iter().all(|v| *v == 0.0) || (impact == 0.0 && speeds.contains(&0.0));
            let moves = driven || !rests;
            for i in first..=last {
                self.v[i] = if moves { momentum / mass + offsets[i - first] } else { 0.0 };
            }
            first = last + 1;
        }
        for j in 0..self.joints.len() {
            if self.joints[j].drive != Drive::Locked && !boundless(j) {
                let short = self.joints[j].rate - (self.v[j] - self.v[j + 1]);
                let rate = self.joints[j].rate.abs();
                let paced = rate.is_finite() && short.abs() <= REACHED * rate;
                let push = Drive::Push(short.signum());
                self.joints[j].drive = if paced { Drive::Paced } else { push };
            }
        }
        self.ledger.impact += before - self.kinetic();
    }

    /// Decides who sticks and slides from now on, and how everything moves.
    fn flow(&mut self) -> Flow {
        let robot = self.robot;
        self.bodies.clear();
        self.sliding.clear();
        self.links.clear();
        for (i, segment) in robot.segments.iter().enumerate() {
            let (levels, v) = (&self.levels[i], self.v[i]);
            let slides = if v > 0.0 {
                -levels.ahead_slide
            } else if v < 0.0 {
                levels.back_slide
            } else {
                0.0
            };
            let (mut ahead, mut back) = (0.0, 0.0);
            if v == 0.0 {
                (ahead, back) = (levels.ahead_hold, levels.back_hold);
            }
            let push = slides - segment.pull - segment.viscous * v;
            self.bodies.push(Body { inertia: segment.mass, push, ahead, back });
            let (ahead, back) = (levels.ahead_slide.min(ahead), levels.back_slide.min(back));
            self.sliding.push(Sliding { ahead, back });
        }
        for (j, (joint, limits)) in self.joints.iter().zip(&robot.joints).enumerate() {
            self.links.push(match joint.drive {
                Drive::Locked => Link::RIGID,
                // The motor's line at the middle of the piece.
                Drive::Push(direction) if joint.starved => Link {
                    gain: 0.5 * self.piece * self.loss,
                    bias: direction * self.stall - self.loss * (self.v[j] - self.v[j + 1]),
                    low: -limits.limit,
                    high: limits.limit,
                },
                Drive::Push(direction) => Link::force(direction * limits.limit),
                Drive::Paced => Link::held(joint.range.0, joint.range.1),
            });
        }
        solve_with_break_away(&mut self.chain, &mut self.bodies, &self.sliding, &self.links);
        for (j, joint) in self.joints.iter_mut().enumerate() {
            joint.force = self.chain.q[j];
            let (low, high) = joint.range;
            // One that is at its speed again in the same instant needs just its limit,
            // as between equal segments under equal forces: it keeps its speed, or
            // rounding would let it go for ever.
            let at_end = joint.force <= low || joint.force >= high;
            // Beside a joint that has just changed, one with a supply can need more.
            let mass = robot.segments[j].mass.min(robot.segments[j + 1].mass);
            let short = mass * (self.chain.w[j] - self.chain.w[j + 1]).abs();
            let falls = joint.starved && short > REACHED * low.abs().max(high.abs());
            if joint.drive == Drive::Paced && at_end && (falls || !joint.let_go) {
                joint.drive = Drive::Push(if joint.force >= high { 1.0 } else { -1.0 });
                joint.let_go = true;
            }
        }
        Flow::new(self, &self.chain.w, &self.bodies)
    }

    /// Time to the next events, at most `left`, and which they are.
    fn next(&self, flow: &Flow, left: f64) -> (f64, Vec<Event>) {
        let mut all: Vec<(f64, Event)> = Vec::new();
        for (i, v) in self.v.iter().enumerate() {
            if *v != 0.0 {
                all.extend(flow.of(i).time_to(-v).map(|t| (t, Event::Rests(i))));
            }
        }
        for (j, joint) in self.joints.iter().enumerate() {
            if joint.drive == Drive::Locked {
                continue;
            }
            let forward = joint.rate > 0.0;
            let gap = flow.gap(self, j);
            let direction = (joint.target - self.length(j)) * joint.rate.signum();
            let gap_on = if forward { gap } else { gap.flipped() };
            let at = gap_on.time_to_length(direction.max(0.0));
            all.extend(at.map(|t| (t, Event::Reaches(j))));
            match joint.drive {
                Drive::Push(side) if joint.rate.is_finite() => {
                    let gap = if side > 0.0 { gap } else { gap.flipped() };
                    let short = side * (joint.rate - (self.v[j] - self.v[j + 1]));
                    all.extend(gap.time_to_rate(short).map(|t| (t, Event::Paced(j))));
                }
                Drive::Paced => {
                    let t = flow.time_to_limit(j, joint.force, joint.range);
                    all.extend(t.map(|(t, side)| (t, Event::Limited(j, side))));
                }
                _ => {}
            }
        }
        // What rounding has put into the past is due now: a step backward in time would
        // find it again and again.
        all.iter_mut().for_each(|event| event.0 = event.0.max(0.0));
        let first = all.iter().map(|e| e.0).fold(f64::INFINITY, f64::min);
        if first > left {
            return (left, Vec::new());
        }
        let tied = first * (1.0 + TIE);
        (first, all.into_iter().filter(|e| e.0 <= tied).map(|e| e.1).collect())
    }

    /// Moves on by `dt`.
    fn go(&mut self, flow: &Flow, roles: &Piece, dt: f64, driven: bool) {
        flow.watch(self, roles, dt);
        flow.enter(self, roles, dt, driven);
        for i in 0..self.x.len() {
            let drift = flow.of(i);
            self.x[i] += self.v[i] * dt + drift.path(dt);
            self.v[i] += drift.speed(dt);
        }
        if self.ledger.time + dt > self.ledger.time {
            self.joints.iter_mut().for_each(|joint| joint.let_go = false);
        }
        self.ledger.time += dt;
        self.ledger.steps += 1.0;
    }

    fn apply(&mut self, happened: &[Event], impact: f64) {
        let mut locked = false;
        for event in happened {
            match *event {
                Event::Rests(i) => self.v[i] = 0.0,
                Event::Paced(j) => self.joints[j].drive = Drive::Paced,
                Event::Limited(j, side) => {
                    self.joints[j].drive = Drive::Push(side);
                    self.joints[j].let_go = true;
                }
                Event::Reaches(j) => {
                    self.joints[j].drive = Drive::Locked;
                    locked = true;
                }
            }
        }
        if locked {
            self.jerk(impact);
        }
    }

    pub fn kinetic(&self) -> f64 {
        self.robot.segments.iter().zip(&self.v).map(|(s, v)| 0.5 * s.mass * v * v).sum()
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Event {
    /// A segment comes to rest.
    Rests(usize),
    /// A joint reaches its speed.
    Paced(usize),
    /// A joint at its speed needs its whole force.
    Limited(usize, f64),
    /// A joint reaches its length.
    Reaches(usize),
}
