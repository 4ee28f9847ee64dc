//! Motion of the head: small midpoint steps, each stop and break-away located
//! inside its step, sticking decided from what pushes a head at rest.

use crate::disturbances::{self, Drawn};
use crate::drive;
use crate::effects::{Effect, first};
use crate::friction::{self, Bristle, ContactState, Ground};
use crate::rig::Rig;
use crate::transmission::Joint;

#[derive(Debug, Clone, Copy, Default)]
pub struct State {
    pub t: f64,
    pub x: f64,
    pub v: f64,
    /// 0 at rest.
    direction: f64,
    /// Where the head last rested or turned.
    origin: f64,
    /// Where it began, and the furthest that it has come from there.
    began: f64,
    furthest: f64,
    bristle: f64,
    lag: [f64; 2],
    /// Memory of a dead zone with hysteresis.
    open: bool,
    /// Drive's side of a transmission.
    side: (f64, f64),
    /// A payload that swings.
    load: (f64, f64),
    /// A position reading that follows slowly, or with play.
    pub filtered: f64,
}

/// Rates of everything but the bristle.
struct Rates {
    x: f64,
    v: f64,
    lag: [f64; 2],
    side: (f64, f64),
    load: (f64, f64),
    filtered: f64,
}

struct Swing {
    mass: f64,
    k: f64,
    c: f64,
}

pub struct Head<'a> {
    effects: &'a [Effect],
    rig: &'a Rig,
    ground: Ground,
    drawn: Drawn,
    alpha: f64,
    /// Sine and cosine of `alpha`.
    incline: (f64, f64),
    tilts: bool,
    remembers: bool,
    /// Inertia, and what weighs on the ground, before any change in a run.
    inertia: f64,
    weighs: f64,
    d_mu: f64,
    d_force: f64,
    bristle: Option<Bristle>,
    joint: Option<Joint>,
    swing: Option<Swing>,
    filter: Option<f64>,
    play: Option<f64>,
    step: f64,
}

/// Events within one step before the rest of it is spent at rest.
const MOST_EVENTS: usize = 50;
/// Steps up to here follow a joint's oscillation closely, s.
const FINE: f64 = 1e-5;

impl<'a> Head<'a> {
    pub fn new(
        rig: &'a Rig,
        effects: &'a [Effect],
        slope_deg: f64,
        (duration, seed): (f64, u64),
        step: f64,
    ) -> Head<'a> {
        let dm = first(effects, |e| match *e {
            Effect::Payload { dm } | Effect::PayloadSwinging { dm, .. } => Some(dm),
            _ => None,
        });
        let dm = dm.unwrap_or(0.0);
        let swing = first(effects, |e| match *e {
            Effect::PayloadSwinging { dm, frequency, zeta } => {
                let omega = std::f64::consts::TAU * frequency;
                Some(Swing { mass: dm, k: dm * omega * omega, c: 2.0 * zeta * dm * omega })
            }
            _ => None,
        });
        let weighs = rig.mass + dm;
        let inertia = if swing.is_some() { rig.mass } else { weighs };
        let d_alpha = first(effects, |e| match *e {
            Effect::Slope { d_alpha_deg } => Some(d_alpha_deg),
            _ => None,
        });
        let bristle = Bristle::of(effects);
        let joint = Joint::of(effects, inertia);
        let filter = first(effects, |e| match *e {
            Effect::SensorDelayFilter { time } if time > 0.0 => Some(time),
            _ => None,
        });
        let fastest = [
            drive::fastest(effects),
            disturbances::fastest(effects, inertia),
            bristle.map_or(0.0, |b| b.fastest(inertia)),
            joint.map_or(0.0, |j| j.fastest(inertia)),
            swing.as_ref().map_or(0.0, |s| (s.k / s.mass.min(inertia)).sqrt()),
            filter.map_or(0.0, |time| 1.0 / time),
        ];
        let fastest = fastest.into_iter().fold(1e-9, f64::max);
        let tilts = |e: &Effect| {
            matches!(
                e,
                Effect::Rocking { .. } | Effect::SlopeUneven { .. } | Effect::SaggingRail { .. }
            )
        };
        let remembers = |e: &Effect| matches!(e, Effect::DeadzoneHysteresis { .. });
        let alpha = (slope_deg + d_alpha.unwrap_or(0.0)).to_radians();
        // Coarse steps are for comparisons: they resolve a joint less finely.
        let share = (step / FINE).clamp(1.0, 5.0) * 0.1;
        Head {
            effects,
            rig,
            ground: Ground { reference: rig.reference_level(), viscous: rig.viscous },
            drawn: Drawn::new(effects, seed, duration),
            alpha,
            incline: alpha.sin_cos(),
            remembers: effects.iter().any(remembers),
            tilts: effects.iter().any(tilts),
            inertia,
            weighs,
            d_mu: first(effects, |e| match *e {
                Effect::CoulombMu { d_mu } => Some(d_mu),
                _ => None,
            })
            .unwrap_or(0.0),
            d_force: first(effects, |e| match *e {
                Effect::CoulombForce { d_force } => Some(d_force),
                _ => None,
            })
            .unwrap_or(0.0),
            bristle,
            joint,
            swing,
            filter,
            play: first(effects, |e| match *e {
                Effect::LooseEncoder { play } => Some(play),
                _ => None,
            }),
            step: step.min(share / fastest).max(1e-7),
        }
    }

    pub fn start(&self, command: f64, (x, v): (f64, f64)) -> State {
        let mut open = false;
        let told = drive::told(self.effects, self.rig, 0.0, command, &mut open);
        let loaded = self.joint.map_or(0.0, |joint| joint.loaded(told));
        let hangs = self
            .swing
            .as_ref()
            .map_or(0.0, |swing| -swing.mass * self.rig.gravity * self.alpha.sin() / swing.k);
        State {
            x,
            v,
            direction: if v == 0.0 { 0.0 } else { v.signum() },
            origin: x,
            began: x,
            furthest: x,
            lag: [told; 2],
            open,
            side: (x + loaded, v),
            load: (x + hangs, v),
            filtered: x,
            ..State::default()
        }
    }

    /// Sine and cosine of the slope.
    fn incline(&self, state: &State) -> (f64, f64) {
        if !self.tilts {
            return self.incline;
        }
        (self.alpha + disturbances::tilt(self.effects, state.t, state.x)).sin_cos()
    }

    fn told(&self, state: &State, command: f64) -> (f64, bool) {
        let mut open = state.open;
        let told = drive::told(self.effects, self.rig, state.t, command, &mut open);
        (told, open)
    }

    /// Force that the drive's side of the transmission gets, and the one that it
    /// hands on.
    fn drive(&self, state: &State, command: f64) -> (f64, f64) {
        self.handed(state, self.told(state, command).0)
    }

    fn handed(&self, state: &State, told: f64) -> (f64, f64) {
        let lagged = match drive::lag_rates(self.effects, told, state.lag) {
            Some(_) => state.lag[1],
            None => told,
        };
        let handed = match self.joint {
            Some(joint) => joint.force(state.side.0 - state.x, state.side.1 - state.v),
            None => lagged,
        };
        (lagged, handed)
    }

    /// Force on the head from the drive.
    pub fn force(&self, state: &State, command: f64) -> f64 {
        self.drive(state, command).1 - drive::back_emf(self.effects, state.v)
    }

    /// What pushes the head beside friction.
    fn push(&self, state: &State, handed: f64, share: f64) -> f64 {
        let pull = match self.rig.gravity_torque {
            Some(torque) => torque * share * (self.weighs / self.rig.mass) * state.x.sin(),
            None => self.inertia * share * self.rig.gravity * self.incline(state).0,
        };
        let swung = self.swing.as_ref().map_or(0.0, |swing| {
            swing.k * (state.load.0 - state.x) + swing.c * (state.load.1 - state.v)
        });
        let other = disturbances::force(self.effects, &self.drawn, state.t, state.x, state.v);
        handed - drive::back_emf(self.effects, state.v) - pull + swung + other
    }

    fn coulomb(&self, state: &State, share: f64) -> f64 {
        let grown = self.weighs * share / self.rig.mass;
        let level = match self.rig.coulomb_force {
            Some(force) if self.rig.is_rotary() => force + self.d_force,
            Some(force) => (force + self.d_force) * grown,
            None => {
                let normal = self.weighs * share * self.rig.gravity * self.incline(state).1;
                (self.rig.mu_coulomb + self.d_mu) * normal + self.d_force
            }
        };
        level.max(0.0)
    }

    fn contact(&self, state: &State, direction: f64, handed: f64) -> ContactState {
        ContactState {
            direction,
            speed: (direction * state.v).max(0.0),
            x: state.x,
            t: state.t,
            swept: (state.x - state.origin).max(0.0),
            pushed: if state.x >= state.furthest { state.x - state.began } else { 0.0 },
            drive: handed,
        }
    }

    fn bristle_level(&self, state: &State, handed: f64, share: f64) -> f64 {
        let contact = self.contact(state, state.direction, handed);
        Bristle::level(self.effects, &self.ground, self.coulomb(state, share), &contact)
    }

    fn rates(&self, state: &State, command: f64, slides: bool) -> Rates {
        let (told, _) = self.told(state, command);
        let (lagged, handed) = self.handed(state, told);
        let share = disturbances::mass_share(self.effects, state.t);
        let mut v = 0.0;
        if slides {
            let friction = if let Some(bristle) = self.bristle {
                let level = self.bristle_level(state, handed, share);
                bristle.force(state.bristle, state.v, level)
                    + friction::smooth_force(self.effects, &self.ground, state.v)
            } else {
                let contact = self.contact(state, state.direction, handed);
                let coulomb = self.coulomb(state, share);
                state.direction
                    * friction::resistance(self.effects, &self.ground, coulomb, &contact)
            };
            v = (self.push(state, handed, share) - friction) / (self.inertia * share);
        }
        let side =
            self.joint.map_or((0.0, 0.0), |joint| (state.side.1, (lagged - handed) / joint.mass));
        let load = self.swing.as_ref().map_or((0.0, 0.0), |swing| {
            let back = swing.k * (state.load.0 - state.x) + swing.c * (state.load.1 - state.v);
            let pull = swing.mass * self.rig.gravity * self.incline(state).0;
            (state.load.1, (-back - pull) / swing.mass)
        });
        Rates {
            x: if slides { state.v } else { 0.0 },
            v,
            lag: drive::lag_rates(self.effects, told, state.lag).unwrap_or_default(),
            side,
            load,
            filtered: self.filter.map_or(0.0, |time| (state.x - state.filtered) / time),
        }
    }

    fn along(&self, state: &State, rates: &Rates, dt: f64) -> State {
        State {
            t: state.t + dt,
            x: state.x + dt * rates.x,
            v: state.v + dt * rates.v,
            lag: [state.lag[0] + dt * rates.lag[0], state.lag[1] + dt * rates.lag[1]],
            side: (state.side.0 + dt * rates.side.0, state.side.1 + dt * rates.side.1),
            load: (state.load.0 + dt * rates.load.0, state.load.1 + dt * rates.load.1),
            filtered: state.filtered + dt * rates.filtered,
            ..*state
        }
    }

    /// One midpoint step without events.
    fn moved(&self, state: &State, command: f64, dt: f64, slides: bool) -> State {
        let deflect = |from: &State, at: &State, dt: f64| match self.bristle {
            Some(bristle) if slides => {
                let (_, handed) = self.drive(at, command);
                let share = disturbances::mass_share(self.effects, at.t);
                bristle.after(from.bristle, at.v, self.bristle_level(at, handed, share), dt)
            }
            _ => from.bristle,
        };
        let rates = self.rates(state, command, slides);
        let mut middle = self.along(state, &rates, 0.5 * dt);
        middle.bristle = deflect(state, state, 0.5 * dt);
        let rates = self.rates(&middle, command, slides);
        let mut end = self.along(state, &rates, dt);
        end.bristle = deflect(state, &middle, dt);
        if self.remembers {
            end.open = self.told(&end, command).1;
        }
        end
    }

    /// Push on a head at rest, and by how much it exceeds what holds.
    fn excess(&self, state: &State, command: f64) -> (f64, f64) {
        let (_, handed) = self.drive(state, command);
        let share = disturbances::mass_share(self.effects, state.t);
        let push = self.push(state, handed, share);
        let contact =
            ContactState { swept: 0.0, speed: 0.0, ..self.contact(state, push.signum(), handed) };
        let coulomb = self.coulomb(state, share);
        (push, push.abs() - friction::resistance(self.effects, &self.ground, coulomb, &contact))
    }

    fn step(&self, state: &mut State, command: f64, dt: f64) {
        if self.bristle.is_some() {
            let moved = self.moved(state, command, dt, true);
            let turned = moved.v.signum() != state.direction;
            *state = moved;
            if turned {
                (state.direction, state.origin) = (moved.v.signum(), moved.x);
            }
            return;
        }
        let mut left = dt;
        for _ in 0..MOST_EVENTS {
            if left <= 0.0 {
                return;
            }
            if state.direction == 0.0 {
                let (push, before) = self.excess(state, command);
                if before > 0.0 {
                    state.direction = push.signum();
                    continue;
                }
                let held = self.moved(state, command, left, false);
                let (push, after) = self.excess(&held, command);
                if after <= 0.0 {
                    *state = held;
                    return;
                }
                let share = before / (before - after);
                *state = self.moved(state, command, share * left, false);
                state.direction = push.signum();
                left *= 1.0 - share;
                continue;
            }
            let moved = self.moved(state, command, left, true);
            if state.direction * moved.v > 0.0 {
                *state = moved;
                return;
            }
            if state.v == 0.0 {
                // Let go, and held again at once.
                state.direction = 0.0;
                break;
            }
            let share = state.v / (state.v - moved.v);
            *state = self.moved(state, command, share * left, true);
            (state.v, state.direction, state.origin) = (0.0, 0.0, state.x);
            left *= 1.0 - share;
        }
        let direction = state.direction;
        *state = self.moved(state, command, left, false);
        state.direction = if state.v == 0.0 { 0.0 } else { direction };
    }

    /// Moves until an instant; `each` sees the state and the length of each step.
    pub fn advance(
        &self,
        state: &mut State,
        command: f64,
        until: f64,
        mut each: impl FnMut(&State, f64),
    ) {
        let span = until - state.t;
        let steps = (span / self.step).ceil().max(1.0);
        let dt = span / steps;
        for _ in 0..steps as u64 {
            each(state, dt);
            self.step(state, command, dt);
            state.furthest = state.furthest.max(state.x);
            if let Some(play) = self.play {
                let half = 0.5 * play;
                state.filtered = state.filtered.clamp(state.x - half, state.x + half);
            }
        }
        state.t = until;
    }
}
