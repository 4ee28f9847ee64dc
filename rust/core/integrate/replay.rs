//! Replays of measured drives through the measured plant: what the sensors would
//! read at every sample, a trajectory per lane.

use super::bristle::{self, Rosenbrock};
use super::dry_contact::Bound;
use super::elastic_drive::{ElasticDrive, Link};
use super::event_location::Cubic;
use super::exact::{self, Exact};
use super::runge_kutta::RungeKutta;
use super::{Advance, State, Tally, Watch};
use crate::lane::Lane;
use crate::physics::drive::{Drive, DriveKind, Path, Table};
use crate::physics::effects::{Active, Body, Effect, Measured, Plant};
use crate::physics::friction::{Contact, Parameters};
use crate::physics::params::ParamId;
use crate::physics::segment::Segment;

/// One run: samples of the drive and where the head starts.
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    /// Seconds since the first sample of the run.
    pub times: &'a [f64],
    pub drive: &'a [f64],
    /// The window that is replayed: first sample and one beyond the last.
    pub window: (usize, usize),
    /// The usual time between samples.
    pub interval: f64,
}

impl Samples<'_> {
    /// Numbers within the window and times.
    #[inline(always)]
    fn instants(&self) -> impl Iterator<Item = (usize, f64)> {
        let (from, to) = self.window;
        self.times[from..to].iter().copied().enumerate()
    }

    /// State at the window's start.
    #[inline(always)]
    fn start<L: Lane>(&self, segment: &Segment<L>) -> State<L> {
        let mut state = State::start(segment);
        state.t = state.t.splat(self.times[self.window.0]);
        state.clock = segment.drive.clock(state.t);
        state
    }
}

/// Longest step of smooth motion, as a share of the time over which it changes.
const SHARE: f64 = 0.25;
/// Shortest step for the sake of friction that is steep along speed or track, and the
/// longest where a joint or a lag stands beside it, s.
const STEEP: f64 = 1e-3;
/// Longest step where a joint or a lag stands beside friction that bends smoothly, s.
const BENT: f64 = 2e-3;
/// Local error of the stiff method: what it leaves is far below what sensors see.
const TOLERANCE: f64 = 1e-4;

/// What the sensors would read at one sample; the position without its sensor's
/// own effects.
#[derive(Debug, Clone, Copy)]
pub struct Reading<L> {
    pub x: L,
    pub v: L,
    pub force: L,
}

/// A drive that only holds the samples; everything else is in the path.
struct Plain<L>(L);

impl<L: Lane> Parameters<L> for Plain<L> {
    #[inline(always)]
    fn get(&self, id: ParamId) -> L {
        self.0.splat(if id == ParamId::Gain { 1.0 } else { 0.0 })
    }
    #[inline(always)]
    fn derived(&self, _: ParamId) -> L {
        self.0.splat(0.0)
    }
}

#[inline(always)]
fn segment<'a, L: Lane>(
    plant: &Plant<L>,
    path: &'a Path<L>,
    samples: Samples<'a>,
    (x, v): (L, L),
) -> Segment<'a, L> {
    let zero = x.splat(0.0);
    let one = zero.splat(1.0);
    let table = Table { times: samples.times, values: samples.drive };
    let mut drive = Drive::new(DriveKind::Table, table, &Plain(zero));
    drive.path = Some(path);
    Segment {
        mass: plant.mass,
        per_mass: one / plant.mass,
        weight: plant.weight,
        limit: zero.splat(f64::INFINITY),
        swing: plant.swing,
        swings: plant.rotary,
        spring: zero,
        damper: zero,
        pull: zero,
        drive,
        contact: Contact { normal: zero, coulomb: zero, break_away: zero, viscous: zero },
        x,
        v,
        duration: zero.splat(samples.times.last().copied().unwrap_or(0.0)),
        step: zero.splat(STEEP.min(samples.interval)),
        tolerance: zero.splat(TOLERANCE),
        target: zero.splat(f64::INFINITY),
    }
}

/// Runs the head over all samples; `read` gets the number of each. Every method is a
/// function of its own: in one, they take the compiler several times as long.
#[inline(always)]
pub fn head<L: Lane>(
    plant: &Plant<L>,
    samples: Samples,
    start: (L, L),
    go_on: impl FnMut() -> bool + Copy,
    read: impl FnMut(usize, Reading<L>),
) {
    // A lag is part of the state, except of the bristle's.
    let link = match plant.joint {
        Some(joint) => Some(Link::Joint(joint)),
        None if plant.path.lags && !plant.active.has(Effect::PreslidingCompliance) => {
            Some(Link::Lag(plant.path.per_lag))
        }
        _ => None,
    };
    let lags = plant.path.lags && !matches!(link, Some(Link::Lag(_)));
    let path = Path { lags, ..plant.path };
    let segment = &segment(plant, &path, samples, start);
    let zero = start.0.splat(0.0);
    if let Some(link) = link {
        zero.outlined(
            #[inline(always)]
            || behind_link(plant, segment, link, samples, go_on, read),
        );
    } else if plant.active.has(Effect::PreslidingCompliance) {
        zero.outlined(
            #[inline(always)]
            || {
                let contact = bristle::Bound::<Measured, L>(plant.friction);
                let method = Rosenbrock::new(segment, &contact, true, go_on);
                over_samples(plant, segment, method, |_, _| {}, samples, read);
            },
        );
    } else if plant.is_linear() {
        zero.outlined(
            #[inline(always)]
            || {
                let contact = exact::Bound::<Measured, L>(plant.friction);
                let method = Exact { segment, contact: &contact, go_on };
                over_samples(plant, segment, method, |_, _| {}, samples, read);
            },
        );
    } else {
        zero.outlined(
            #[inline(always)]
            || in_steps(plant, segment, samples, go_on, read),
        );
    }
}

/// A head that a joint or a lag parts from its drive.
#[inline(always)]
fn behind_link<L: Lane>(
    plant: &Plant<L>,
    segment: &Segment<L>,
    link: Link<L>,
    samples: Samples,
    mut go_on: impl FnMut() -> bool + Copy,
    mut read: impl FnMut(usize, Reading<L>),
) {
    let mut state = samples.start(segment);
    let mut tally = Tally::start(segment, Watch::NOTHING);
    let longest = if plant.is_steep() { STEEP } else { BENT };
    let longest = (!plant.is_linear()).then_some(longest.min(samples.interval));
    let times = (samples.interval, longest);
    let mut method = state.x.outlined(
        #[inline(always)]
        || ElasticDrive::new(segment, plant.friction, link, &state, times),
    );
    for (i, t) in samples.instants() {
        let until = state.x.splat(t);
        method.advance(&mut state, &mut tally, until);
        let force = (-plant.emf).mul_add(state.v, method.force());
        read(i, Reading { x: state.x, v: state.v, force });
        if !go_on() {
            return;
        }
    }
}

/// A head whose motion has no closed form: every lane takes the steps that its own needs.
#[inline(always)]
fn in_steps<L: Lane>(
    plant: &Plant<L>,
    segment: &Segment<L>,
    samples: Samples,
    go_on: impl FnMut() -> bool + Copy,
    read: impl FnMut(usize, Reading<L>),
) {
    let contact = &Bound::<Measured, L>(plant.friction);
    let method = RungeKutta { segment, contact, locate: true, step: segment.step, go_on };
    let zero = segment.step.splat(0.0);
    let (long, least) = (zero.splat(samples.interval), zero.splat(STEEP));
    let steep = plant.is_steep();
    over_samples(
        plant,
        segment,
        method,
        #[inline(always)]
        |method: &mut RungeKutta<Bound<Measured, L>, L, _>, state: &State<L>| {
            let a = if steep { method.acceleration(state) } else { zero };
            let step = (zero.splat(SHARE) / plant.pace(state.v, a, long)).max(least);
            // As many equal ones as fill an interval.
            let count = (long / step.min(long) * (1.0 - 1e-9)).floor() + 1.0;
            method.step = long / count;
        },
        samples,
        read,
    );
}

#[inline(always)]
fn over_samples<L: Lane, M: Advance<L>>(
    plant: &Plant<L>,
    segment: &Segment<L>,
    mut method: M,
    ready: impl Fn(&mut M, &State<L>),
    samples: Samples,
    mut read: impl FnMut(usize, Reading<L>),
) {
    let mut state = samples.start(segment);
    let mut tally = Tally::start(segment, Watch::NOTHING);
    for (i, t) in samples.instants() {
        ready(&mut method, &state);
        let until = state.x.splat(t);
        if !method.advance(&mut state, &mut tally, until) {
            return;
        }
        let force = segment.force(state.t, &state.clock, state.x, state.v);
        let force = (-plant.emf).mul_add(state.v, force);
        read(i, Reading { x: state.x, v: state.v, force });
    }
}

/// Runs the body under the reaction to `force`, the drive forces just after each
/// sample; `read` gets its position at each.
#[inline(always)]
pub fn body<L: Lane>(
    plant: &Plant<L>,
    body: &Body<L>,
    samples: Samples,
    forces: impl Fn(usize) -> L,
    go_on: impl FnMut() -> bool + Copy,
    mut read: impl FnMut(usize, L),
) {
    let zero = body.mass.splat(0.0);
    let mut friction = plant.friction;
    friction.active = Active::default().with(Effect::StribeckFriction);
    (friction.forward, friction.backward) = (body.levels.coulomb, body.levels.coulomb);
    friction.viscous = zero;
    friction.drop = (body.levels.break_away - body.levels.coulomb).max(zero);
    friction.per_stribeck = zero.splat(1e30);
    friction.exponent = zero.splat(1.0);
    let back = Path { gain: -plant.path.gain, ..plant.path };
    let friction = exact::Bound::<Measured, L>(friction);
    let mut own = segment(plant, &back, samples, (zero, zero));
    own.mass = body.mass;
    own.per_mass = zero.splat(1.0) / body.mass;
    own.weight = body.weight;
    (own.swing, own.swings) = (zero, false);
    let mut state = samples.start(&own);
    let mut tally = Tally::start(&own, Watch::NOTHING);
    read(0, zero);
    // The force between two samples is what the drive's path gives there; what
    // depends on the head's motion is taken at the interval's middle.
    let follows = plant.joint.is_some() || plant.active.has(Effect::BackEmf) || plant.path.lags;
    for (i, t) in samples.instants().skip(1) {
        let until = zero.splat(t);
        let mut now = own;
        if follows {
            let mean = (forces(i - 1) + forces(i)) * -0.5;
            now.drive = Drive::steady(mean);
        }
        let mut method = Exact { segment: &now, contact: &friction, go_on };
        if !method.advance(&mut state, &mut tally, until) {
            return;
        }
        read(i, state.x);
    }
}

/// The position that the sensor reads at sample `i`, from the head's own motion.
#[inline(always)]
pub fn sensed<L: Lane>(
    plant: &Plant<L>,
    samples: Samples,
    i: usize,
    motion: impl Fn(usize) -> (L, L),
) -> L {
    let times = &samples.times[samples.window.0..samples.window.1];
    let [scale, drift, delay] = plant.sensor;
    let t = delay.splat(times[i]);
    let start = motion(0).0;
    let (late, x) = if plant.active.has(Effect::SensorDelay) {
        let last = t.splat(times[times.len() - 1]);
        let late = (t - delay).max(t.splat(times[0])).min(last);
        // Each lane looks between its own two samples.
        let x = t.fill(|lane| {
            let at = late.lane(lane);
            let after = times.partition_point(|time| *time <= at).clamp(1, times.len() - 1);
            let (a, b) = (after - 1, after);
            let dt = times[b] - times[a];
            let (from, to) = (motion(a), motion(b));
            let cubic = Cubic::new(
                dt,
                (from.0.lane(lane), from.1.lane(lane)),
                (to.0.lane(lane), to.1.lane(lane)),
            );
            cubic.at((at - times[a]) / dt)
        });
        (late, x)
    } else {
        (t, motion(i).0)
    };
    let scaled = (scale + 1.0).mul_add(x - start, start);
    drift.mul_add(late, scaled)
}
