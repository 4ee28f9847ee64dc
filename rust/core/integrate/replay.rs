//! Replays of measured drives through the measured plant: what the sensors would
//! read at every sample, a trajectory per lane.

use super::anchored_body::AnchoredBody;
use super::bristle::{self, Rosenbrock};
use super::dry_contact::Bound;
use super::elastic_drive::{Bent, ElasticDrive, Link};
use super::event_location::Cubic;
use super::exact::{self, Exact};
use super::runge_kutta::RungeKutta;
use super::{Advance, State, Tally, Watch};
use crate::lane::Lane;
use crate::physics::drive::{Clock, Drive, DriveKind, Path, Table};
use crate::physics::effects::{BehindJoint, Effect, Joint, Jointed, Measured, Plant};
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

/// Largest error of the speed in a step of a head without a link, m/s, as a solution of third
/// order shows it; the step itself is of fourth order. Both set by `cargo test --test replay`: the
/// position stays within a micrometre over seconds, where steep friction leaves three with 1e-9.
const STEEP_ERROR: f64 = 1e-10;
const SMOOTH_ERROR: f64 = 1e-7;
/// Acceleration that the drive makes at most in that test, m/s^2. Where it makes more, errors may be
/// larger in the same ratio: 35 microradians for an arm at 90 rad/s^2, a fortieth of a step of its
/// encoder.
const ACCELERATION: f64 = 2.5;
/// Longest way of a step as a share of the wavelength of friction along the track. A step that
/// spans a wave can miss it, and so can the estimate of its error. Set by
/// `cargo test --test replay fast_waves`.
const STRIDE: f64 = 0.125;
/// Local error of the stiff method: what it leaves is far below what sensors see.
const TOLERANCE: f64 = 1e-4;

/// What the sensors would read at one sample; the position without its sensor's
/// own effects.
#[derive(Debug, Clone, Copy)]
pub struct Reading<L> {
    pub x: L,
    pub v: L,
    pub force: L,
    pub x_rear: L,
}

/// State of a head where its replay begins.
#[derive(Debug, Clone, Copy)]
pub struct Start<L> {
    pub x: L,
    pub v: L,
    /// Distance moved forward since the last rest or turn.
    pub sliding_distance: L,
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

/// A drive that holds the samples, behind `path`.
#[inline(always)]
fn driven<'a, L: Lane>(path: &'a Path<L>, samples: Samples<'a>, zero: L) -> Drive<'a, L> {
    let table = Table { times: samples.times, values: samples.drive };
    let mut drive = Drive::new(DriveKind::Table, table, &Plain(zero));
    drive.path = Some(path);
    drive
}

#[inline(always)]
pub(super) fn segment<'a, L: Lane>(
    plant: &Plant<L>,
    path: &'a Path<L>,
    samples: Samples<'a>,
    start: Start<L>,
) -> Segment<'a, L> {
    let Start { x, v, sliding_distance } = start;
    let zero = x.splat(0.0);
    let one = zero.splat(1.0);
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
        drive: driven(path, samples, zero),
        contact: Contact { normal: zero, coulomb: zero, break_away: zero, viscous: zero },
        x,
        v,
        sliding_distance,
        duration: zero.splat(samples.times.last().copied().unwrap_or(0.0)),
        step: zero.splat(samples.interval),
        tolerance: zero.splat(TOLERANCE),
        target: zero.splat(f64::INFINITY),
    }
}

/// Runs head and body over all samples; `read` gets the number of each. Every method is a
/// function of its own: in one, they take the compiler several times as long.
#[inline(always)]
pub fn head<L: Lane>(
    plant: &Plant<L>,
    samples: Samples,
    start: Start<L>,
    go_on: impl FnMut() -> bool + Copy,
    read: impl FnMut(usize, Reading<L>),
) {
    let bristles = plant.active.has(Effect::PreslidingCompliance);
    // A lag is part of the state, except of the bristle's.
    let link = match plant.joint {
        Some(joint) => Some(Link::Joint(joint)),
        None if plant.path.lags && !bristles => Some(Link::Lag(plant.path.per_lag)),
        _ => None,
    };
    let lags = plant.path.lags && !matches!(link, Some(Link::Lag(_)));
    let path = Path { lags, ..plant.path };
    let segment = &segment(plant, &path, samples, start);
    let zero = start.x.splat(0.0);
    if let (Some(joint), true) = (plant.joint, bristles) {
        zero.outlined(
            #[inline(always)]
            || bristles_behind_joint(plant, segment, joint, samples, go_on, read),
        );
    } else if let Some(link) = link {
        zero.outlined(
            #[inline(always)]
            || behind_link(plant, segment, link, samples, go_on, read),
        );
    } else if bristles {
        zero.outlined(
            #[inline(always)]
            || {
                let contact = bristle::Bound::<Measured, L>(plant.friction);
                let method = Rosenbrock::new(segment, &contact, true, go_on);
                unlinked(plant, segment, method, samples, read);
            },
        );
    } else if plant.is_linear() {
        zero.outlined(
            #[inline(always)]
            || {
                let contact = exact::Bound::<Measured, L>(plant.friction);
                let method = Exact { segment, contact: &contact, go_on };
                unlinked(plant, segment, method, samples, read);
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
    go_on: impl FnMut() -> bool + Copy,
    read: impl FnMut(usize, Reading<L>),
) {
    let state = samples.start(segment);
    let first = match link {
        // The link stands for the lag, so the drive of `segment` has none.
        Link::Lag(_) => {
            let drive = driven(&plant.path, samples, state.x.splat(0.0));
            drive.force(state.t, &drive.clock(state.t))
        }
        Link::Joint(_) => segment.commanded(state.t, &state.clock),
    };
    let mut bent = None;
    if !plant.is_linear() {
        let steep = plant.is_steep() || plant.has_varying_load();
        let (allowed, stride) = (scale(plant, samples), plant.wavelength() * STRIDE);
        bent = Some(Bent { steep, allowed, stride: stride.frozen() });
    }
    let method = state.x.outlined(
        #[inline(always)]
        || {
            ElasticDrive::new(
                segment,
                plant.friction,
                link,
                (&state, first),
                (samples.interval, bent, go_on),
            )
        },
    );
    over_samples(
        plant,
        segment,
        (state, method),
        #[inline(always)]
        |method: &ElasticDrive<L, _>, _, _| (method.force(), method.held()),
        samples,
        read,
    );
}

/// A head on bristles that a joint parts from its drive.
#[inline(always)]
fn bristles_behind_joint<L: Lane>(
    plant: &Plant<L>,
    segment: &Segment<L>,
    joint: Joint<L>,
    samples: Samples,
    go_on: impl FnMut() -> bool + Copy,
    read: impl FnMut(usize, Reading<L>),
) {
    let (joint, _) = joint.followed(segment.mass);
    let law = Jointed { friction: plant.friction, joint };
    let mut state = samples.start(segment);
    state.z = law.start(segment.commanded(state.t, &state.clock), state.v);
    let contact = bristle::Bound::<BehindJoint, L>(law);
    let method = Rosenbrock::new(segment, &contact, true, go_on);
    over_samples(
        plant,
        segment,
        (state, method),
        #[inline(always)]
        |_: &Rosenbrock<_, L, _>, state, _| (law.push(state.v, &state.z).0, law.held(&state.z)),
        samples,
        read,
    );
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
    let speed_error =
        scale(plant, samples) * if plant.is_steep() { STEEP_ERROR } else { SMOOTH_ERROR };
    let method = RungeKutta::<_, _, _, true>::new(segment, contact, true, segment.step, go_on)
        .within(plant.wavelength() * STRIDE, speed_error);
    unlinked(plant, segment, method, samples, read);
}

/// Factor on the errors of the speed that steps may make, see `ACCELERATION`.
#[inline(always)]
fn scale<L: Lane>(plant: &Plant<L>, samples: Samples) -> L {
    let largest = samples.drive.iter().fold(0.0, |most: f64, drive| most.max(drive.abs()));
    let fastest = plant.path.gain.abs() * largest / plant.mass;
    (fastest * (1.0 / ACCELERATION)).max(fastest.splat(1.0)).frozen()
}

/// A head that nothing parts from its drive.
#[inline(always)]
fn unlinked<L: Lane, M: Advance<L>>(
    plant: &Plant<L>,
    segment: &Segment<L>,
    method: M,
    samples: Samples,
    read: impl FnMut(usize, Reading<L>),
) {
    let start = samples.start(segment);
    let none = plant.mass.splat(0.0);
    over_samples(
        plant,
        segment,
        (start, method),
        #[inline(always)]
        |_: &M, state, clock| (segment.force(state.t, clock, state.x, state.v), none),
        samples,
        read,
    );
}

/// Force on the head, and the impulse that is not received, with back-EMF.
#[inline(always)]
fn felt<L: Lane, M>(
    plant: &Plant<L>,
    given: &impl Fn(&M, &State<L>, &Clock<L>) -> (L, L),
    method: &M,
    state: &State<L>,
    clock: &Clock<L>,
) -> (L, L) {
    let (force, held) = given(method, state, clock);
    ((-plant.emf).mul_add(state.v, force), plant.emf.mul_add(state.x, held))
}

/// Takes head and body from sample to sample; `given` is the force that the drive gives
/// without back-EMF, and the impulse that it has given and the head has not received.
#[inline(always)]
fn over_samples<L: Lane, M: Advance<L>>(
    plant: &Plant<L>,
    segment: &Segment<L>,
    (mut state, mut method): (State<L>, M),
    given: impl Fn(&M, &State<L>, &Clock<L>) -> (L, L),
    samples: Samples,
    mut read: impl FnMut(usize, Reading<L>),
) {
    let mut tally = Tally::start(segment, Watch::NOTHING);
    let zero = state.t.splat(0.0);
    let mut body = plant.body.as_ref().map(AnchoredBody::new);
    let longest = longest_under_body(plant, samples.interval).frozen();
    for (i, t) in samples.instants() {
        let until = zero.splat(t);
        loop {
            // The body feels the force between the samples: to the next jump at most.
            let (mut next, begin) = (until, state);
            let mut from = (zero, zero);
            if body.is_some() {
                let end = segment.drive.piece_end(begin.clock.piece).min(until);
                let far = (longest * (1.0 + 1e-9)).lt(end - begin.t);
                next = L::select(far, begin.t + longest, end);
                from = felt(plant, &given, &method, &begin, &begin.clock);
            }
            if !method.advance(&mut state, &mut tally, next) {
                return;
            }
            let Some(body) = &mut body else { break };
            let to = felt(plant, &given, &method, &state, &begin.clock);
            zero.outlined(
                #[inline(always)]
                || {
                    let dt = (next - begin.t).max(zero);
                    let drive = segment.drive.mean(begin.t, dt, &begin.clock);
                    let mean = drive - L::select(zero.lt(dt), (to.1 - from.1) / dt, zero);
                    // Evenly, with the impulse that was given whatever happened on the way.
                    let half = (to.0 - from.0) * 0.5;
                    body.advance(dt, mean - half, mean + half);
                },
            );
            if !L::any(state.t.lt(until)) {
                break;
            }
        }
        let (force, _) = felt(plant, &given, &method, &state, &state.clock);
        let x_rear = body.as_ref().map_or(zero, |body| body.x);
        read(i, Reading { x: state.x, v: state.v, force, x_rear });
    }
}

/// Steps of the body within the time over which its force changes, and the fewest and the
/// most between two samples: the force is taken to change evenly over each. Set by
/// `cargo test --test replay`: below a micrometre against a plain integration.
const PER_CHANGE: f64 = 16.0;
const FEWEST: f64 = 4.0;
const MOST: f64 = 64.0;

/// Longest step over which the drive force may be taken to change evenly: it is constant
/// from jump to jump unless a lag, a joint, back-EMF or a sagging supply shape it.
#[inline(always)]
fn longest_under_body<L: Lane>(plant: &Plant<L>, interval: f64) -> L {
    let zero = plant.mass.splat(0.0);
    let shaped = plant.joint.is_some()
        || plant.path.lags
        || plant.path.sags
        || plant.active.has(Effect::BackEmf);
    if !shaped {
        return zero.splat(f64::INFINITY);
    }
    let mut rate = plant.friction.viscous / plant.mass;
    if plant.path.lags {
        rate = rate + plant.path.per_lag;
    }
    if let Some(joint) = plant.joint {
        if !joint.is_spring {
            // A gap closes with a blow, whenever that is.
            return zero.splat(interval / MOST);
        }
        let (joint, reduced) = joint.followed(plant.mass);
        rate = rate + (joint.stiffness / reduced).sqrt();
    }
    let count = (rate * (interval * PER_CHANGE)).max(zero.splat(FEWEST)).min(zero.splat(MOST));
    zero.splat(interval) / count
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
        let between = |at: f64| {
            let after = times.partition_point(|time| *time <= at).clamp(1, times.len() - 1);
            (after - 1, after)
        };
        let x = if L::DERIVED {
            let (a, b) = between(late.lane(0));
            let dt = t.splat(times[b] - times[a]);
            let cubic = Cubic::new(dt, motion(a), motion(b));
            cubic.at((late - times[a]) / dt)
        } else {
            // Each lane looks between its own two samples.
            t.fill(|lane| {
                let at = late.lane(lane);
                let (a, b) = between(at);
                let dt = times[b] - times[a];
                let (from, to) = (motion(a), motion(b));
                let cubic = Cubic::new(
                    dt,
                    (from.0.lane(lane), from.1.lane(lane)),
                    (to.0.lane(lane), to.1.lane(lane)),
                );
                cubic.at((at - times[a]) / dt)
            })
        };
        (late, x)
    } else {
        (t, motion(i).0)
    };
    let scaled = (scale + 1.0).mul_add(x - start, start);
    drift.mul_add(late, scaled)
}
