//! DRIVE REGISTRY: the force that the actuator is told to give, over time. A new
//! drive is one line in `drives!` and its arms in `Drive`.
//!
//! A drive is a chain of pieces, smooth within each. Integrators step from piece
//! to piece, so no jump falls into a step; the number of the piece, kept beside
//! the time, says on which side of a jump a value is wanted.

mod frequency;
mod path;

pub use path::Path;

use super::friction::Parameters;
use super::params::ParamId;
use crate::describe::nearest;
use crate::error::{Error, Result};
use crate::lane::Lane;
use crate::lane::trig::{cos_turns, sin_turns};

/// What a drive is, for people and for the registry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveInfo {
    pub name: &'static str,
    /// TeX, in the symbols of the parameters.
    pub formula: &'static str,
    pub meaning: &'static str,
    /// Names of the parameters that enter.
    pub params: &'static [&'static str],
}

macro_rules! drives {
    ($($id:ident $name:literal $formula:literal $meaning:literal [$($param:literal)*];)+) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum DriveKind { $($id),+ }

        impl DriveKind {
            pub const ALL: &'static [DriveKind] = &[$(DriveKind::$id),+];

            pub fn info(self) -> &'static DriveInfo {
                match self { $(DriveKind::$id => &DriveInfo {
                    name: $name, formula: $formula, meaning: $meaning, params: &[$($param),*],
                }),+ }
            }
        }
    };
}

drives! {
    Constant "constant" r"F_0" "a constant force"
        ["drive_force"];
    Sine "sine" r"F_0 + A\sin(2\pi f t + \varphi)" "a sine about a constant force"
        ["drive_force" "drive_amplitude" "drive_frequency" "drive_phase_deg"];
    Multisine "multisine"
        r"F_0 + A\sqrt{2/n_h}\sum_{j=1}^{n_h}\sin\!\left(2\pi j f t + \varphi - \pi j(j-1)/n_h\right)"
        "harmonics with Schroeder's phases, which keep the peak low; A is the root mean square"
        ["drive_force" "drive_amplitude" "drive_frequency" "drive_phase_deg" "drive_harmonics"];
    Chirp "chirp" r"F_0 + A\sin\!\left(2\pi\left(f t + \frac{f_1 - f}{2T}t^2\right) + \varphi\right)"
        "a sine whose frequency rises evenly over the run"
        ["drive_force" "drive_amplitude" "drive_frequency" "drive_frequency_end" "drive_phase_deg"
         "duration"];
    Ramp "ramp" r"F_0 + \dot F t \text{ up to } F_0 + A,\ t_h \text{ there, down again}"
        "rises evenly, holds, falls evenly, then stays at the constant force"
        ["drive_force" "drive_amplitude" "drive_rate" "drive_hold"];
    Pulse "pulse" r"F_0 + A \text{ for } d\,T_p,\ F_0 - F_b \text{ for } (1-d)\,T_p"
        "the pulse train of a gait: forward, then backward or off"
        ["drive_force" "drive_amplitude" "drive_back" "drive_period" "drive_duty"];
    Table "table" r"F_0 + k_d\,u_i \text{ for } t_i \le t < t_{i+1}"
        "samples, each held until the next; before the first one it has its value"
        ["drive_force" "gain"];
}

impl DriveKind {
    pub fn parse(name: &str) -> Result<DriveKind> {
        let names = || Self::ALL.iter().map(|d| d.info().name);
        Self::ALL.iter().copied().find(|d| d.info().name == name).ok_or_else(|| {
            Error::UnknownName {
                kind: "drive",
                given: name.to_owned(),
                nearest: nearest(name, names()).map(str::to_owned),
                known: names().map(str::to_owned).collect(),
            }
        })
    }

    /// Whether every piece is constant, as exact propagation needs.
    pub fn is_stepwise(self) -> bool {
        matches!(self, DriveKind::Constant | DriveKind::Pulse | DriveKind::Table)
    }

    /// Whether it has more than one piece.
    pub fn has_pieces(self) -> bool {
        matches!(self, DriveKind::Ramp | DriveKind::Pulse | DriveKind::Table)
    }
}

/// Samples of a drive; times rise.
#[derive(Debug, Clone, Copy)]
pub struct Table<'a> {
    pub times: &'a [f64],
    pub values: &'a [f64],
}

impl Table<'_> {
    pub const EMPTY: Table<'static> = Table { times: &[], values: &[] };
}

/// The drive of one trajectory per lane.
#[derive(Clone, Copy)]
pub struct Drive<'a, L> {
    kind: DriveKind,
    offset: L,
    amplitude: L,
    /// Frequency, or the rate of a ramp.
    rate: L,
    /// Half the growth of frequency, the hold of a ramp, or the duty of a pulse.
    second: L,
    /// Phase in turns, or a pulse's force in the rest of its period.
    third: L,
    /// Number of harmonics, or the period of a pulse.
    fourth: L,
    table: Table<'a>,
    /// What becomes of the samples on their way, where that is not nothing.
    pub path: Option<&'a Path<L>>,
}

/// Time constants after which a lag has forgotten what was before, to the last digit of what it
/// holds: e^-37 < 2^-53.
const FORGOTTEN: f64 = 37.0;

/// Where a trajectory is in its drive.
#[derive(Clone, Copy)]
pub struct Clock<L> {
    /// Number of the piece, from 0.
    pub piece: L,
    /// When it began, and the force then: what a lag starts from.
    pub since: L,
    pub from: L,
}

impl<L: Lane> Clock<L> {
    /// `self` where the mask holds, `other` elsewhere.
    #[inline(always)]
    pub fn or(self, mask: L::Mask, other: Clock<L>) -> Clock<L> {
        Clock {
            piece: L::select(mask, self.piece, other.piece),
            since: L::select(mask, self.since, other.since),
            from: L::select(mask, self.from, other.from),
        }
    }
}

impl<'a, L: Lane> Drive<'a, L> {
    #[inline(always)]
    pub fn new(kind: DriveKind, table: Table<'a>, params: &impl Parameters<L>) -> Self {
        let zero = params.get(ParamId::DriveForce).splat(0.0);
        let mut drive = Drive {
            kind,
            offset: params.get(ParamId::DriveForce),
            amplitude: params.get(ParamId::DriveAmplitude),
            rate: zero,
            second: zero,
            third: zero,
            fourth: zero,
            table,
            path: None,
        };
        let turns = params.get(ParamId::DrivePhaseDeg) * (1.0 / 360.0);
        match kind {
            DriveKind::Constant => {}
            DriveKind::Table => drive.amplitude = params.get(ParamId::Gain),
            DriveKind::Sine => {
                drive.rate = params.get(ParamId::DriveFrequency);
                drive.third = turns;
            }
            DriveKind::Multisine => {
                drive.rate = params.get(ParamId::DriveFrequency);
                drive.third = turns;
                drive.fourth = params.get(ParamId::DriveHarmonics);
                drive.amplitude = drive.amplitude * (zero.splat(2.0) / drive.fourth).sqrt();
            }
            DriveKind::Chirp => {
                drive.rate = params.get(ParamId::DriveFrequency);
                let growth = params.get(ParamId::DriveFrequencyEnd) - drive.rate;
                drive.second = growth * 0.5 / params.get(ParamId::Duration);
                drive.third = turns;
            }
            DriveKind::Ramp => {
                drive.rate = params.get(ParamId::DriveRate);
                drive.second = params.get(ParamId::DriveHold);
            }
            DriveKind::Pulse => {
                drive.second = params.get(ParamId::DriveDuty);
                drive.third = params.get(ParamId::DriveBack);
                drive.fourth = params.get(ParamId::DrivePeriod);
            }
        }
        drive
    }

    /// The same force for ever.
    #[inline(always)]
    pub fn steady(force: L) -> Drive<'a, L> {
        let zero = force.splat(0.0);
        Drive {
            kind: DriveKind::Constant,
            offset: force,
            amplitude: zero,
            rate: zero,
            second: zero,
            third: zero,
            fourth: zero,
            table: Table::EMPTY,
            path: None,
        }
    }

    /// A force that the drive never exceeds in either direction, from the largest sample of
    /// its table.
    #[inline(always)]
    pub fn largest(&self, sample: f64) -> L {
        let factor = match self.kind {
            DriveKind::Constant => return self.offset.abs(),
            // All harmonics at once.
            DriveKind::Multisine => self.fourth,
            DriveKind::Pulse => {
                return self.offset.abs() + self.amplitude.abs().max(self.third.abs());
            }
            DriveKind::Table => self.offset.splat(sample),
            _ => self.offset.splat(1.0),
        };
        factor.mul_add(self.amplitude.abs(), self.offset.abs())
    }

    /// About how many pieces a run of a pulse train has; 0 of the others, which
    /// have few or as many as there are samples.
    #[inline(always)]
    pub fn pieces(&self, duration: L) -> L {
        match self.kind {
            DriveKind::Pulse => duration * 2.0 / self.fourth,
            _ => duration.splat(0.0),
        }
    }

    /// When piece number `piece` (from 0) ends; infinite for the last one.
    #[inline(always)]
    pub fn piece_end(&self, piece: L) -> L {
        if !self.kind.has_pieces() {
            return piece.splat(f64::INFINITY);
        }
        piece.outlined(
            #[inline(always)]
            || self.end_of(piece),
        )
    }

    #[inline(always)]
    fn end_of(&self, piece: L) -> L {
        let never = piece.splat(f64::INFINITY);
        match self.kind {
            DriveKind::Ramp => {
                let rise = self.amplitude.abs() / self.rate;
                let first = L::select(piece.lt(piece.splat(1.0)), rise, rise + self.second);
                let end = L::select(piece.lt(piece.splat(2.0)), first, rise + (rise + self.second));
                L::select(piece.lt(piece.splat(3.0)), end, never)
            }
            DriveKind::Pulse => {
                let period = (piece * 0.5).floor();
                let within = piece - period * 2.0;
                let share = L::select(within.lt(piece.splat(0.5)), self.second, piece.splat(1.0));
                (period + share) * self.fourth
            }
            DriveKind::Table => {
                let times = self.table.times;
                let end =
                    self.look_up(piece + 1.0, |i| times.get(i).copied().unwrap_or(f64::INFINITY));
                self.path.map_or(end, |path| end + path.delay)
            }
            _ => never,
        }
    }

    /// The same number for every lane, if they all ask for the same index.
    #[inline(always)]
    fn look_up(&self, index: L, value: impl Fn(usize) -> f64) -> L {
        let first = index.lane(0);
        let same = index.splat(first);
        let differ = L::or(index.lt(same), same.lt(index));
        if L::any(differ) {
            index.map(|p| value(p as usize))
        } else {
            index.splat(value(first as usize))
        }
    }

    /// Force at `t`, which lies within `piece` or at one of its ends.
    #[inline(always)]
    pub fn force(&self, t: L, clock: &Clock<L>) -> L {
        match self.kind {
            DriveKind::Constant => self.offset,
            _ => t.outlined(
                #[inline(always)]
                || {
                    let force = self.varying_force(t, clock.piece);
                    match self.path {
                        Some(path) => path.force(force, t, clock),
                        None => force,
                    }
                },
            ),
        }
    }

    /// Whether the force stays what it is from one jump to the next.
    #[inline(always)]
    pub fn is_steady(&self) -> bool {
        self.kind.is_stepwise() && self.path.is_none_or(|path| !path.sags && !path.lags)
    }

    /// Mean force from `t` on over `dt` within a piece.
    #[inline(always)]
    pub fn mean(&self, t: L, dt: L, clock: &Clock<L>) -> L {
        match self.path {
            Some(path) if path.lags => t.outlined(
                #[inline(always)]
                || path.mean(self.varying_force(t, clock.piece), t, dt, clock),
            ),
            _ => self.force(dt.mul_add(t.splat(0.5), t), clock),
        }
    }

    /// The clock of a run or a window that begins at `start`. Behind a lag the samples before it
    /// still act.
    #[inline(always)]
    pub fn clock(&self, start: L) -> Clock<L> {
        let lag = self.path.filter(|path| path.lags && self.kind == DriveKind::Table);
        let Some(path) = lag else {
            return self.settled_clock(start);
        };
        let first = start.splat(self.table.times[0]);
        let remembered = (start - start.splat(FORGOTTEN) / path.per_lag).max(first);
        let mut clock = self.settled_clock(remembered.frozen());
        loop {
            let end = self.piece_end(clock.piece);
            let over = end.le(start);
            if !L::any(over) {
                return clock;
            }
            self.turn_over(&mut clock, end, over);
        }
    }

    /// The clock at `start`, where the drive has had the same value for long.
    #[inline(always)]
    fn settled_clock(&self, start: L) -> Clock<L> {
        let mut clock = Clock { piece: start.splat(0.0), since: start, from: start.splat(0.0) };
        if self.kind == DriveKind::Table {
            let delay = self.path.map_or(start.splat(0.0), |path| path.delay);
            let at = start - delay;
            let index = |t: f64| self.table.times.partition_point(|time| *time <= t);
            clock.piece = at.map(|t| index(t).saturating_sub(1) as f64);
        }
        if let Some(path) = self.path {
            // Before its first sample the drive had its first value.
            clock.from = path.settled(self.varying_force(start, clock.piece), start);
        }
        clock
    }

    /// Goes on to the next piece, which begins at `end`, where `over` holds.
    #[inline(always)]
    pub fn turn_over(&self, clock: &mut Clock<L>, end: L, over: L::Mask) {
        if let Some(path) = self.path
            && path.lags
        {
            let from = self.force(end, clock);
            clock.from = L::select(over, from, clock.from);
        }
        clock.since = L::select(over, end, clock.since);
        clock.piece = L::select(over, clock.piece + 1.0, clock.piece);
    }

    #[inline(always)]
    fn varying_force(&self, t: L, piece: L) -> L {
        match self.kind {
            DriveKind::Constant => self.offset,
            DriveKind::Sine => {
                let turns = self.rate.mul_add(t, self.third);
                self.amplitude.mul_add(sin_turns(turns), self.offset)
            }
            DriveKind::Multisine => self.amplitude.mul_add(self.harmonics(t).0, self.offset),
            DriveKind::Chirp => {
                let turns = self.second.mul_add(t, self.rate).mul_add(t, self.third);
                self.amplitude.mul_add(sin_turns(turns), self.offset)
            }
            DriveKind::Ramp => {
                let size = self.amplitude.abs();
                let rise = self.rate * t;
                let end = size / self.rate;
                let fall = (end + (end + self.second) - t) * self.rate;
                let level = L::select(piece.lt(piece.splat(2.0)), size, fall);
                let level = L::select(piece.lt(piece.splat(1.0)), rise, level);
                let level = L::select(piece.lt(piece.splat(3.0)), level, t.splat(0.0));
                self.amplitude.sign().mul_add(level, self.offset)
            }
            DriveKind::Pulse => {
                let within = piece - (piece * 0.5).floor() * 2.0;
                let forward = within.lt(piece.splat(0.5));
                self.offset + L::select(forward, self.amplitude, -self.third)
            }
            DriveKind::Table => {
                let values = self.table.values;
                let value = self.look_up(piece, |i| values.get(i).copied().unwrap_or(0.0));
                self.amplitude.mul_add(value, self.offset)
            }
        }
    }

    /// What a drive without pieces is an offset and an amplitude of.
    pub fn shape(&self, t: L) -> L {
        let (zero, one) = (t.splat(0.0), t.splat(1.0));
        Drive { offset: zero, amplitude: one, ..*self }.varying_force(t, zero)
    }

    /// The force where the shape is known.
    #[inline(always)]
    pub fn shaped(&self, shape: L) -> L {
        match self.kind {
            DriveKind::Constant => self.offset,
            _ => self.amplitude.mul_add(shape, self.offset),
        }
    }

    /// Derivative of the force by time.
    #[inline(always)]
    pub fn slope(&self, t: L, clock: &Clock<L>) -> L {
        t.outlined(
            #[inline(always)]
            || {
                let slope = self.varying_slope(t, clock.piece);
                match self.path {
                    Some(path) => path.slope(self.varying_force(t, clock.piece), t, clock),
                    None => slope,
                }
            },
        )
    }

    #[inline(always)]
    fn varying_slope(&self, t: L, piece: L) -> L {
        let circle = std::f64::consts::TAU;
        match self.kind {
            DriveKind::Constant | DriveKind::Pulse | DriveKind::Table => t.splat(0.0),
            DriveKind::Sine => {
                let turns = self.rate.mul_add(t, self.third);
                (self.amplitude * self.rate) * (cos_turns(turns) * circle)
            }
            DriveKind::Multisine => self.amplitude * self.harmonics(t).1,
            DriveKind::Chirp => {
                let turns = self.second.mul_add(t, self.rate).mul_add(t, self.third);
                let frequency = (self.second * 2.0).mul_add(t, self.rate);
                (self.amplitude * frequency) * (cos_turns(turns) * circle)
            }
            DriveKind::Ramp => {
                let zero = t.splat(0.0);
                let rate = self.amplitude.sign() * self.rate;
                let falls = L::and(piece.gt(piece.splat(1.5)), piece.lt(piece.splat(2.5)));
                let rises = piece.lt(piece.splat(0.5));
                L::select(rises, rate, L::select(falls, -rate, zero))
            }
        }
    }

    /// Sum of the harmonics and its derivative.
    #[inline(always)]
    fn harmonics(&self, t: L) -> (L, L) {
        let zero = t.splat(0.0);
        let (mut sum, mut slope) = (zero, zero);
        let base = self.rate * t;
        let per_count = t.splat(1.0) / self.fourth;
        let mut j = 1.0;
        while L::any(t.splat(j).le(self.fourth)) {
            let phase = self.third - per_count * (0.5 * j * (j - 1.0));
            let turns = base.mul_add(t.splat(j), phase);
            let counts = t.splat(j).le(self.fourth);
            sum = sum + L::select(counts, sin_turns(turns), zero);
            let rate = cos_turns(turns) * self.rate * (j * std::f64::consts::TAU);
            slope = slope + L::select(counts, rate, zero);
            j += 1.0;
        }
        (sum, slope)
    }
}
