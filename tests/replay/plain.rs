//! A plain integration of the contract's equations, as anybody would write it down:
//! midpoint steps of a microsecond or less, what rests is looked at every step. It shares
//! no code with the replay, only the numbers of a rig.

use locosweep::physics::effects::{Active, EFFECT_PARAMS, Effect, Nominal};

/// What the sensors would read without their own effects.
#[derive(Default)]
pub struct Motion {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub x_rear: Vec<f64>,
    pub force: Vec<f64>,
}

/// Head, drive side, lag, bristle, body.
#[derive(Clone, Copy, Default)]
struct State {
    x: f64,
    v: f64,
    side: f64,
    side_v: f64,
    lagged: f64,
    bristle: f64,
    rear: f64,
    rear_v: f64,
}

impl State {
    fn plus(&self, h: f64, rate: &State) -> State {
        State {
            x: self.x + h * rate.x,
            v: self.v + h * rate.v,
            side: self.side + h * rate.side,
            side_v: self.side_v + h * rate.side_v,
            lagged: self.lagged + h * rate.lagged,
            bristle: self.bristle + h * rate.bristle,
            rear: self.rear + h * rate.rear,
            rear_v: self.rear_v + h * rate.rear_v,
        }
    }
}

/// What holds between two looks.
#[derive(Clone, Copy)]
struct Mode {
    t: f64,
    command: f64,
    direction: f64,
    rear_direction: f64,
    /// Where the head last rested or turned.
    from: f64,
}

pub struct Rig<'a> {
    pub nominal: &'a Nominal,
    pub active: Active,
    pub values: &'a [f64; EFFECT_PARAMS],
    pub slope_deg: f64,
}

impl Rig<'_> {
    fn has(&self, effect: Effect) -> bool {
        self.active.has(effect)
    }

    fn value(&self, effect: Effect, k: usize) -> f64 {
        if self.has(effect) { self.values[effect.first() + k] } else { 0.0 }
    }

    fn mass(&self) -> f64 {
        self.nominal.mass + self.value(Effect::PayloadMass, 0)
    }

    fn slope(&self) -> f64 {
        (self.slope_deg + self.value(Effect::SlopeError, 0)).to_radians()
    }

    fn command(&self, sample: f64, t: f64) -> f64 {
        let mut force = sample * self.nominal.gain * (1.0 + self.value(Effect::DriveGainError, 0));
        if self.has(Effect::SupplySag) {
            let time = self.value(Effect::SupplySag, 1);
            force *= 1.0 - self.value(Effect::SupplySag, 0) * (1.0 - (-t / time).exp());
        }
        let size = (force.abs() - self.value(Effect::DriveDeadzone, 0)).max(0.0);
        let limit = if self.has(Effect::DriveSaturation) {
            self.value(Effect::DriveSaturation, 0)
        } else {
            f64::INFINITY
        };
        force.signum() * size.min(limit).min(self.nominal.limit)
    }

    /// Force on the head before back-EMF.
    fn delivered(&self, y: &State, command: f64) -> f64 {
        let settled = if self.has(Effect::DriveLag) { y.lagged } else { command };
        if self.has(Effect::TransmissionCompliance) {
            let effect = Effect::TransmissionCompliance;
            let stretch = self.value(effect, 0) * (y.side - y.x);
            return stretch + self.value(effect, 1) * (y.side_v - y.v);
        }
        if self.has(Effect::TransmissionBacklash) {
            let (gap, side) = (
                self.value(Effect::TransmissionBacklash, 0),
                self.value(Effect::TransmissionBacklash, 1),
            );
            let stiffness = 2e4 * self.mass();
            let reduced = self.mass() * side / (self.mass() + side);
            let apart = y.side - y.x;
            if apart.abs() <= gap {
                return 0.0;
            }
            let deep = apart - apart.signum() * gap;
            let force = stiffness * deep + 2.0 * (stiffness * reduced).sqrt() * (y.side_v - y.v);
            // A contact does not pull.
            return if force * apart > 0.0 { force } else { 0.0 };
        }
        settled
    }

    fn drive(&self, y: &State, command: f64) -> f64 {
        self.delivered(y, command) - self.value(Effect::BackEmf, 0) * y.v
    }

    fn coulomb(&self) -> f64 {
        let mu = self.nominal.mu_coulomb + self.value(Effect::CoulombError, 0);
        (mu * self.mass() * self.nominal.gravity * self.slope().cos()).max(0.0)
    }

    fn reference(&self) -> f64 {
        let slope = self.nominal.slope_deg.to_radians();
        self.nominal.mu_coulomb * self.nominal.mass * self.nominal.gravity * slope.cos()
    }

    /// Coulomb level towards `direction`, the fall of the level by speed left out.
    fn level(&self, y: &State, mode: &Mode, direction: f64) -> f64 {
        let mut level = self.coulomb();
        if self.has(Effect::DirectionDependentFriction) {
            let k = if direction < 0.0 { 1 } else { 0 };
            level += self.value(Effect::DirectionDependentFriction, k) - self.reference();
        }
        if self.has(Effect::PositionDependentFriction) {
            let value = |k| self.value(Effect::PositionDependentFriction, k);
            let turn = 2.0 * std::f64::consts::PI * y.x / value(1);
            level *= 1.0 + value(0) * (turn + value(2)).sin();
        }
        if self.has(Effect::FrictionDrift) {
            let value = |k| self.value(Effect::FrictionDrift, k);
            level *= 1.0 + value(0) * (1.0 - (-mode.t / value(1)).exp());
        }
        let load = self.value(Effect::LoadDependentFriction, 0);
        level + load * self.delivered(y, mode.command).abs()
    }

    fn fall(&self, speed: f64) -> f64 {
        if !self.has(Effect::StribeckFriction) {
            return 0.0;
        }
        let value = |k| self.value(Effect::StribeckFriction, k);
        (value(0) - self.reference()) * (-(speed / value(1)).powf(value(2))).exp()
    }

    fn rate(&self, y: &State, mode: &Mode) -> State {
        let mut rate = State::default();
        let (mass, slope) = (self.mass(), self.slope());
        let force = self.drive(y, mode.command);
        let pull = mass * self.nominal.gravity * slope.sin();
        let speed = y.v.abs();
        let viscous = self.nominal.viscous + self.value(Effect::ViscousFriction, 0);
        let mut smooth = viscous * y.v + self.value(Effect::QuadraticDrag, 0) * y.v * speed;
        if y.v > 0.0 || mode.direction > 0.0 {
            smooth += self.value(Effect::LubricantBuildup, 0) * (y.x - mode.from).max(0.0);
        }
        if self.has(Effect::PreslidingCompliance) {
            let value = |k| self.value(Effect::PreslidingCompliance, k);
            let level = self.level(y, mode, y.v) + self.fall(speed);
            rate.bristle = y.v - value(0) * speed * y.bristle / level;
            rate.x = y.v;
            let bristle = value(0) * y.bristle + value(1) * rate.bristle;
            rate.v = (force - pull - smooth - bristle) / mass;
        } else if mode.direction != 0.0 {
            let dry = self.level(y, mode, mode.direction) + self.fall(speed);
            rate.x = y.v;
            rate.v = (force - pull - smooth - mode.direction * dry) / mass;
        }
        let settled = if self.has(Effect::DriveLag) {
            rate.lagged = (mode.command - y.lagged) / self.value(Effect::DriveLag, 0);
            y.lagged
        } else {
            mode.command
        };
        let side = if self.has(Effect::TransmissionCompliance) {
            self.value(Effect::TransmissionCompliance, 2)
        } else {
            self.value(Effect::TransmissionBacklash, 1)
        };
        if side > 0.0 {
            rate.side = y.side_v;
            rate.side_v = (settled - self.delivered(y, mode.command)) / side;
        }
        if mode.rear_direction != 0.0 {
            let (mass, weight) = self.body();
            let friction = self.value(Effect::AnchorSlip, 1) * weight * slope.cos();
            rate.rear = y.rear_v;
            rate.rear_v = (-force - weight * slope.sin() - mode.rear_direction * friction) / mass;
        }
        rate
    }

    fn body(&self) -> (f64, f64) {
        let mass = (self.nominal.segments - 1.0) * self.nominal.mass;
        (mass, mass * self.nominal.gravity)
    }

    /// Directions of what is at rest.
    fn release(&self, y: &State, mode: &mut Mode) {
        let slope = self.slope();
        let force = self.drive(y, mode.command);
        if mode.direction == 0.0 && !self.has(Effect::PreslidingCompliance) {
            let push = force - self.mass() * self.nominal.gravity * slope.sin();
            let holds = self.level(y, mode, push) + self.fall(0.0).max(0.0);
            if push.abs() > holds {
                mode.direction = push.signum();
                mode.from = y.x;
            }
        }
        if self.has(Effect::AnchorSlip) && mode.rear_direction == 0.0 {
            let (_, weight) = self.body();
            let push = -force - weight * slope.sin();
            let value = |k| self.value(Effect::AnchorSlip, k) * weight * slope.cos();
            if push.abs() > value(0).max(value(1)) {
                mode.rear_direction = push.signum();
            }
        }
    }

    /// Steps of at most `longest` from sample to sample.
    pub fn motion(&self, times: &[f64], drive: &[f64], longest: f64) -> Motion {
        let delay = self.value(Effect::DriveDelay, 0);
        let held = |t: f64| {
            let at = times.partition_point(|time| time + delay <= t + 1e-12);
            drive[at.saturating_sub(1)]
        };
        let first = self.command(held(times[0]), times[0]);
        let mut y = State { lagged: first, ..State::default() };
        if self.has(Effect::TransmissionCompliance) {
            y.side = first / self.value(Effect::TransmissionCompliance, 0);
        }
        let mut mode =
            Mode { t: 0.0, command: first, direction: 0.0, rear_direction: 0.0, from: 0.0 };
        let mut all = Motion::default();
        for (i, t) in times.iter().enumerate() {
            mode.command = self.command(held(*t), *t);
            mode.t = *t;
            all.x.push(y.x);
            all.v.push(y.v);
            all.x_rear.push(y.rear);
            all.force.push(self.drive(&y, mode.command));
            let Some(next) = times.get(i + 1) else { break };
            let count = ((next - t) / longest).ceil();
            let h = (next - t) / count;
            for k in 0..count as usize {
                let now = t + k as f64 * h;
                let at = |share: f64| {
                    let t = now + share * h;
                    (t, self.command(held(t), t))
                };
                (mode.t, mode.command) = at(0.0);
                self.release(&y, &mut mode);
                let start = self.rate(&y, &mode);
                let middle = y.plus(0.5 * h, &start);
                (mode.t, mode.command) = at(0.5);
                let to = y.plus(h, &self.rate(&middle, &mode));
                let (before, rear) = (y, y.rear_v);
                y = to;
                if self.has(Effect::PreslidingCompliance) && y.v <= 0.0 {
                    // A bristle never rests: the heap levels out when the head turns.
                    mode.from = y.x;
                }
                if mode.direction * y.v < 0.0 {
                    let share = before.v / (before.v - y.v);
                    y.x = before.x + 0.5 * before.v * share * h;
                    (y.v, mode.direction) = (0.0, 0.0);
                }
                if mode.rear_direction * y.rear_v < 0.0 {
                    y.rear = before.rear + 0.5 * rear * rear / (rear - y.rear_v) * h;
                    (y.rear_v, mode.rear_direction) = (0.0, 0.0);
                }
            }
        }
        all
    }
}
