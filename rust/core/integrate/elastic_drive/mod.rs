//! Exact propagation of a head behind a lag, a spring or a gap, under Coulomb and
//! viscous friction: linear between events, so a step is one product with a matrix
//! exponential worked out beforehand. Where friction and gravity bend with the motion, steps
//! know their error (see `refinement`); in one with an event they are taken at its middle.
//!
//! The state besides the head's position is (a, b, v): of a lag its force a; of a
//! joint the stretch a and the speed b of the drive's side; v is the head's speed.
//! Exponentials are kept for steps of h, h/2, h/4, ... (see `propagation`): events are
//! found by halving (see `events`). The rest of an interval is a step by a series (see `lengths`).

mod calm;
mod events;
mod lengths;
mod one_step;
mod propagation;
mod refinement;

use super::{Advance, State, Tally};
use crate::lane::Lane;
use crate::physics::effects::{Coefficients, Joint, Measured};
use crate::physics::friction::{ContactState, Dry};
use crate::physics::segment::Segment;
use lengths::Length;
use one_step::{ByMap, BySeries, Step};
use propagation::{HALVINGS, JOINED_MODES, Level, MODES, Rates, levels};
pub use refinement::Bent;

/// What stands between the drive and the head.
#[derive(Clone, Copy)]
pub enum Link<L> {
    /// A lag of this rate, 1/s.
    Lag(L),
    Joint(Joint<L>),
}

/// Level of steps between two looks for events.
const LOOKED: usize = HALVINGS as usize;
/// Length of these at most, in radians of the joint's oscillation.
const LOOK: f64 = 0.35;
/// Looks between two samples, at most: as many as an oscillation has that lasts from one to the
/// next. What is faster sways too little for its events to matter. Set by
/// `cargo test --release --test replay few_looks`: 64 times as many move the head by 1e-9 m at
/// most, by 3e-7 m where friction bends, which is what its steps leave.
const MOST_LOOKS: f64 = 18.0;
/// Looks between two samples behind a lag: its force bends, and the speed may dip.
const LAG_LOOKS: f64 = 2.0;

/// Fastest lag, in rates of the samples: shorter ones are none.
const FASTEST_LAG: f64 = 1e3;

/// Where a lane is between events.
#[derive(Clone, Copy)]
struct Now<L> {
    x: L,
    a: L,
    b: L,
    v: L,
    /// Direction of sliding, 0 at rest.
    direction: L,
    /// 1 where the joint transmits, 0 in free flight.
    joined: L,
    /// Distance moved forward since the last rest or turn.
    sliding_distance: L,
}

impl<L: Lane> Now<L> {
    #[inline(always)]
    fn or(self, mask: L::Mask, other: Now<L>) -> Now<L> {
        Now {
            x: L::select(mask, self.x, other.x),
            a: L::select(mask, self.a, other.a),
            b: L::select(mask, self.b, other.b),
            v: L::select(mask, self.v, other.v),
            direction: L::select(mask, self.direction, other.direction),
            joined: L::select(mask, self.joined, other.joined),
            sliding_distance: L::select(mask, self.sliding_distance, other.sliding_distance),
        }
    }
}

pub struct ElasticDrive<'a, 'b, L: Lane, F> {
    segment: &'b Segment<'a, L>,
    law: Coefficients<L>,
    rates: Rates<L>,
    gap: L,
    is_gap: bool,
    /// 1 where a lag is too short to be one.
    at_once: L,
    /// Whether friction and gravity are more than numbers: steps know their error then, see
    /// `refinement`.
    bent: bool,
    /// In what way.
    bends: Bent<L>,
    /// Longest step that the error of the last one allows a lane that slides, s.
    reach: L,
    /// Longest step by a series, s.
    short: L,
    /// Levels from which on some lanes, and all, have no series.
    mapped: (usize, usize),
    /// Whether there may be stretches in which nothing happens, see `calm`.
    calms: bool,
    /// Modes that a lane may be in, the first so many of `MODES`.
    modes: usize,
    /// Whether the drive gives the same over all of a stretch, and what it gives then.
    steady: bool,
    steady_force: L,
    now: Now<L>,
    levels: Vec<Level<L>>,
    /// Whether to go on; asked at the end of every stretch.
    go_on: F,
}

impl<L: Lane, F: FnMut() -> bool> Advance<L> for ElasticDrive<'_, '_, L, F> {
    #[inline(always)]
    fn advance(&mut self, state: &mut State<L>, tally: &mut Tally<L>, until: L) -> bool {
        let mut events = until.splat(0.0);
        while L::any(state.t.lt(until)) {
            let piece_end = self.segment.drive.piece_end(state.clock.piece);
            let active = state.t.lt(until);
            let end = piece_end.min(until);
            self.stretch(state, tally, (end - state.t).max(end.splat(0.0)), &mut events);
            state.t = L::select(active, end, state.t);
            let over = L::and(active, piece_end.le(until));
            self.segment.drive.turn_over(&mut state.clock, piece_end, over);
        }
        (state.x, state.v) = (self.now.x, self.now.v);
        (self.go_on)()
    }
}

impl<'a, 'b, L: Lane, F> ElasticDrive<'a, 'b, L, F> {
    /// The link gives the force `first` at the start. `interval` is the usual time between
    /// samples. Friction or gravity may be `bent` by the motion.
    #[inline(always)]
    pub fn new(
        segment: &'b Segment<'a, L>,
        law: Coefficients<L>,
        link: Link<L>,
        (start, first): (&State<L>, L),
        (interval, bent, go_on): (f64, Option<Bent<L>>, F),
    ) -> Self {
        let zero = start.x.splat(0.0);
        let one = zero.splat(1.0);
        let mut rates = Rates {
            per_mass: segment.per_mass,
            viscous: law.viscous * segment.per_mass,
            lag: zero,
            stiffness: zero,
            damping: zero,
            per_side: zero,
            is_lag: false,
        };
        let (mut gap, mut is_gap, mut at_once) = (zero, false, zero);
        let mut now = Now {
            x: start.x,
            a: first,
            b: zero,
            v: start.v,
            direction: start.direction,
            joined: one,
            sliding_distance: start.sliding_distance,
        };
        // Steps are per lane, their halvings the same for all: no lane's result hangs on
        // its neighbours.
        let look = match link {
            Link::Lag(rate) => {
                let fastest = zero.splat(FASTEST_LAG / interval);
                (rates.is_lag, rates.lag) = (true, rate.min(fastest));
                at_once = L::select(fastest.lt(rate), one, zero);
                zero.splat(LAG_LOOKS)
            }
            Link::Joint(joint) => {
                let (joint, reduced) = joint.followed(segment.mass);
                (rates.stiffness, rates.damping) = (joint.stiffness, joint.damping);
                rates.per_side = one / joint.mass;
                (gap, is_gap) = (joint.gap, !joint.is_spring);
                // A spring starts loaded by the first force, a gap in its middle.
                now.a = if is_gap { zero } else { first / rates.stiffness };
                now.b = start.v;
                now.joined = if is_gap { zero } else { one };
                let turn = (rates.stiffness / reduced).sqrt();
                (turn * (interval / LOOK)).min(zero.splat(MOST_LOOKS))
            }
        };
        // As many equal steps as fill an interval.
        let looks = (look.max(one) * (1.0 - 1e-9)).floor() + 1.0;
        let dt = one * interval / looks * 0.5_f64.powi(HALVINGS);
        let modes = if is_gap { MODES.len() } else { JOINED_MODES };
        let straight = Bent { steep: false, allowed: one, stride: zero };
        let (bent, bends) = (bent.is_some(), bent.unwrap_or(straight));
        let levels = levels(&rates, dt, modes, bent);
        let reach = zero.splat(f64::INFINITY);
        let short = rates.short().max(levels[0].dt).frozen();
        let mut mapped = (levels.len(), levels.len());
        for (i, level) in levels.iter().enumerate().rev() {
            if L::any(short.lt(level.dt)) {
                mapped.0 = i;
            }
            if !L::any(level.dt.le(short)) {
                mapped.1 = i;
            }
        }
        let steady = segment.drive.is_steady();
        let calms = !rates.is_lag && steady && calm::is_possible(law.active);
        ElasticDrive {
            segment,
            law,
            rates,
            gap,
            is_gap,
            at_once,
            bent,
            bends,
            reach,
            short,
            mapped,
            calms,
            modes,
            steady,
            steady_force: zero,
            now,
            levels,
            go_on,
        }
    }

    /// Force of the link on the head.
    #[inline(always)]
    pub fn force(&self) -> L {
        self.push(&self.now)
    }

    /// Impulse that the drive has given and the head has not received.
    #[inline(always)]
    pub fn held(&self) -> L {
        let zero = self.now.a.splat(0.0);
        if self.rates.is_lag {
            return L::select(zero.lt(self.at_once), zero, self.now.a / self.rates.lag);
        }
        self.now.b / self.rates.per_side
    }

    #[inline(always)]
    fn push(&self, now: &Now<L>) -> L {
        if self.rates.is_lag {
            return now.a;
        }
        let force = self.contact(now);
        if self.is_gap { force * now.joined } else { force }
    }

    /// Stretch beyond the gap.
    #[inline(always)]
    fn depth(&self, now: &Now<L>) -> L {
        if self.is_gap { now.a - now.a.sign() * self.gap } else { now.a }
    }

    /// What the joint gives where it transmits.
    #[inline(always)]
    fn contact(&self, now: &Now<L>) -> L {
        self.rates.damping.mul_add(now.b - now.v, self.rates.stiffness * self.depth(now))
    }

    /// Friction against `direction` without its viscous part, while the link gives `drive`.
    #[inline(always)]
    fn level(&self, now: &Now<L>, direction: L, drive: L, t: L) -> L {
        let zero = t.splat(0.0);
        let contact_state =
            ContactState { direction, x: now.x, sliding_distance: now.sliding_distance, drive, t };
        if !self.bent {
            return Measured::linear(&self.law, &contact_state).0;
        }
        let speed = (direction * now.v).max(zero);
        (-self.law.viscous).mul_add(speed, Measured::resistance(&self.law, speed, &contact_state))
    }

    /// Acceleration of the head by friction without its viscous part and by gravity.
    #[inline(always)]
    fn pull(&self, now: &Now<L>, t: L) -> L {
        let level = self.level(now, now.direction, self.push(now), t);
        -now.direction.mul_add(level, self.segment.pull_back(now.x)) * self.segment.per_mass
    }

    /// What pushes the head at rest, and by how much it exceeds what holds it.
    #[inline(always)]
    fn excess(&self, now: &Now<L>, t: L) -> (L, L) {
        let zero = t.splat(0.0);
        let still = Now { v: zero, sliding_distance: zero, ..*now };
        let drive = self.push(&still);
        let push = drive - self.segment.pull_back(now.x);
        (push, push.abs() - self.holds(&still, push.sign(), drive, t))
    }

    /// What holds the head at rest against a push in a direction, while the link gives `drive`.
    #[inline(always)]
    fn holds(&self, still: &Now<L>, direction: L, drive: L, t: L) -> L {
        let holds = self.level(still, direction, drive, t);
        if !self.bent {
            return holds;
        }
        let sliding_distance = t.splat(0.0);
        let contact_state = ContactState { direction, x: still.x, sliding_distance, drive, t };
        holds.max(Measured::break_away(&self.law, &contact_state))
    }

    /// Positive where an event of a lane's mode has happened: the speed passed zero
    /// or the push what holds; and the contact's: it closed or would pull.
    #[inline(always)]
    fn overruns(&self, now: &Now<L>, t: L) -> (L, L) {
        let zero = t.splat(0.0);
        let slides = zero.lt(now.direction.abs());
        let mut own = -(now.direction * now.v);
        if L::any(L::not(slides)) {
            own = L::select(slides, own, self.excess(now, t).1);
        }
        (own, self.touches(now))
    }

    /// The contact's part of it.
    #[inline(always)]
    fn touches(&self, now: &Now<L>) -> L {
        let zero = now.x.splat(0.0);
        if !self.is_gap {
            return zero.splat(-1.0);
        }
        let side = now.a.sign();
        let (deep, push) = (side * self.depth(now), side * self.contact(now));
        L::select(zero.lt(now.joined), -push, deep.min(push))
    }

    /// Mean of what the drive gives from `t` on over `dt`, within a stretch.
    #[inline(always)]
    fn mean(&self, t: L, dt: L, state: &State<L>) -> L {
        if self.steady { self.steady_force } else { self.segment.drive.mean(t, dt, &state.clock) }
    }

    /// Over `left` seconds of one piece.
    #[inline(always)]
    fn stretch(&mut self, state: &State<L>, tally: &mut Tally<L>, left: L, events: &mut L) {
        let zero = left.splat(0.0);
        let (mut t, mut left) = (state.t, left);
        let drive = self.segment.drive.mean(t, left, &state.clock);
        self.steady_force = drive;
        self.now.a = L::select(zero.lt(self.at_once), drive, self.now.a);
        let mut calm = zero.lt(zero);
        if self.calms {
            self.release(zero.lt(left), t);
            calm = zero.outlined(
                #[inline(always)]
                || self.is_calm(&self.now, t, left, drive),
            );
        }
        // Steps of levels above go beyond a look: where nothing happens, or as one that is bent
        // looks at its middle.
        let top = if L::any(calm) { self.levels.len() } else { LOOKED + 1 + self.bent as usize };
        let mut at = top;
        // What rounding leaves is no step.
        let least = self.levels[0].dt * 1e-6;
        loop {
            let active = least.lt(left);
            if !L::any(active) {
                break;
            }
            let (length, takes) = self.longest(&mut at, active, left, calm);
            let used = match length {
                Length::Level(level) => {
                    // The time of a whole step is that of its map, whatever the end hangs on.
                    let dt = left.min(self.levels[level].dt).frozen();
                    let dt = L::select(takes, dt, zero);
                    self.step(ByMap(level), takes, (t, state), tally, dt, events)
                }
                Length::Short(dt) => {
                    let dt = L::select(takes, dt, zero);
                    zero.outlined(
                        #[inline(always)]
                        || self.step(BySeries(dt), takes, (t, state), tally, dt, events),
                    )
                }
            };
            if self.bent {
                // The next one may be longer.
                at = top;
            }
            let rest = left - used;
            // What is left of nothing may still hang on when an event was.
            let nothing = if L::DERIVED { rest - rest.frozen() } else { zero };
            let rest = L::select(zero.lt(rest), rest, nothing);
            left = L::select(takes, rest, left);
            t = t + used;
        }
        if L::DERIVED {
            let drive = self.mean(t, left, state);
            let inputs = self.inputs(&self.now, (t, left), drive);
            let end = self.moved(BySeries(left - left.frozen()), &self.now, inputs, None);
            let now = &mut self.now;
            for (own, end) in [
                (&mut now.x, end.x),
                (&mut now.a, end.a),
                (&mut now.b, end.b),
                (&mut now.v, end.v),
                (&mut now.sliding_distance, end.sliding_distance),
            ] {
                *own = own.frozen() + (end - end.frozen());
            }
        }
    }

    /// Lets go at once what rests and is free to.
    #[inline(always)]
    fn release(&mut self, mask: L::Mask, t: L) {
        let zero = t.splat(0.0);
        let rests = L::and(mask, self.now.direction.abs().le(zero));
        if L::any(rests) {
            let (push, over) = self.excess(&self.now, t);
            let goes = L::and(rests, zero.lt(over));
            self.now.direction = L::select(goes, push.sign(), self.now.direction);
        }
    }

    /// One step on the lanes of `mask`, to the first event of each;
    /// returns the time that this took.
    #[inline(always)]
    fn step(
        &mut self,
        step: impl Step<L>,
        mask: L::Mask,
        (t, state): (L, &State<L>),
        tally: &mut Tally<L>,
        dt: L,
        events: &mut L,
    ) -> L {
        let zero = dt.splat(0.0);
        let (mut used, mut mask) = (zero, mask);
        if self.bent {
            (used, mask) = zero.outlined(
                #[inline(always)]
                || self.refined(step, mask, (t, state), dt),
            );
            if !L::any(mask) {
                return used;
            }
        }
        self.release(mask, t);
        let from = self.now;
        let drive = self.mean(t, dt, state);
        let (to, inputs) = self.midpoint(step, &from, (t, dt), drive);
        let (own, touch) = self.overruns(&to, t + dt);
        let happens = L::and(mask, zero.lt(own.max(touch)));
        self.now = to.or(mask, from);
        if !L::any(happens) {
            return used + L::select(mask, dt, zero);
        }
        let met = zero.outlined(
            #[inline(always)]
            || self.meet((mask, happens), &from, inputs, (t, dt), tally, events),
        );
        used + met
    }
}
