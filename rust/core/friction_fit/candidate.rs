//! What is fitted: a registered law, how its levels follow the load, and what the
//! force sensor adds; with the parameters that are free and where each may lie.

use crate::describe::nearest;
use crate::error::{Error, Result};
use crate::physics::friction::LawEntry;
use crate::physics::params::ParamId;

/// What presses the surfaces together, so how friction levels follow the load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pressing {
    /// The same normal force everywhere.
    Constant,
    /// The load is the normal force.
    Proportional,
    /// The load and a preload that is fitted.
    Affine,
}

impl Pressing {
    pub const ALL: &'static [(Pressing, &'static str, &'static str)] = &[
        (Pressing::Constant, "constant", "friction levels do not depend on the load"),
        (Pressing::Proportional, "proportional", "friction levels are coefficients of the load"),
        (Pressing::Affine, "affine", "friction levels are coefficients of load plus preload"),
    ];

    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|p| p.0 == self).map_or("", |p| p.1)
    }

    pub fn parse(name: &str) -> Result<Pressing> {
        let names = || Self::ALL.iter().map(|p| p.1);
        Self::ALL.iter().find(|p| p.1 == name).map(|p| p.0).ok_or_else(|| Error::UnknownName {
            kind: "load",
            given: name.to_owned(),
            nearest: nearest(name, names()).map(str::to_owned),
            known: names().map(str::to_owned).collect(),
        })
    }
}

#[derive(Clone, Copy)]
pub struct Candidate {
    pub law: &'static LawEntry,
    pub pressing: Pressing,
    /// The sensor adds a constant force.
    pub offset: bool,
    /// The sensor adds a share of the load, as a wrong area does.
    pub gain: bool,
}

/// One number that a fit finds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    Law(ParamId),
    Preload,
    Offset,
    Gain,
}

impl What {
    pub fn name(self) -> &'static str {
        match self {
            What::Law(id) => id.param().name,
            What::Preload => "preload",
            What::Offset => "force_offset",
            What::Gain => "load_gain",
        }
    }

    pub fn unit(self) -> &'static str {
        match self {
            What::Law(id) => id.param().unit,
            What::Preload | What::Offset => "N",
            What::Gain => "1",
        }
    }

    pub fn meaning(self) -> &'static str {
        match self {
            What::Law(id) => id.param().meaning,
            What::Preload => "force that presses beside the load",
            What::Offset => "force that the sensor shows without friction",
            What::Gain => "share of the load that the sensor shows as friction",
        }
    }
}

/// Sizes found in the data, from which ranges and steps are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    pub force: f64,
    pub speed: f64,
    /// The slowest motion that counts as motion.
    pub slowest: f64,
    /// First and last position.
    pub track: (f64, f64),
    pub duration: f64,
    /// Typical time between samples.
    pub interval: f64,
    pub normal: f64,
    /// Typical load, 0 without one.
    pub load: f64,
    pub drive: f64,
}

/// How a search begins with a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// Found at once beside others: the force is linear in it.
    Inner(f64),
    /// Spread over its range; evenly in its inverse where a period is meant.
    Spread,
    SpreadInverse,
}

/// A free parameter: the fit moves `u`, which is the value over `scale`, or its
/// logarithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Free {
    pub what: What,
    pub low: f64,
    pub high: f64,
    pub logarithmic: bool,
    pub scale: f64,
    pub start: Start,
    /// The force jumps where it moves: it has no derivative.
    pub edge: bool,
}

impl Free {
    fn linear(what: What, scale: f64) -> Free {
        let scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
        let start = Start::Inner(0.0);
        let (low, high) = (0.0, f64::INFINITY);
        Free { what, low, high, logarithmic: false, scale, start, edge: false }
    }

    fn range(what: What, low: f64, high: f64) -> Free {
        let scale = high - low;
        Free { what, low, high, logarithmic: false, scale, start: Start::Spread, edge: false }
    }

    fn ratio(what: What, start: f64, high: f64) -> Free {
        Free { start: Start::Inner(start), scale: 1.0, ..Free::range(what, 0.0, high) }
    }

    fn decades(what: What, low: f64, high: f64) -> Free {
        Free { logarithmic: true, scale: 1.0, ..Free::range(what, low, high) }
    }

    pub fn inner(self, value: f64) -> f64 {
        if self.logarithmic { value.ln() } else { value / self.scale }
    }

    pub fn outer(self, u: f64) -> f64 {
        if self.logarithmic { u.exp() } else { u * self.scale }
    }

    /// Both ends, as the fit sees them.
    pub fn bounds(self) -> (f64, f64) {
        (self.inner(self.low), self.inner(self.high))
    }

    /// The value at a share of the range.
    pub fn spread(self, share: f64) -> f64 {
        let (low, high) = (self.low, self.high);
        let between = |a: f64, b: f64| share.mul_add(b - a, a);
        match self.start {
            Start::Inner(value) => value,
            Start::SpreadInverse => 1.0 / between(1.0 / high, 1.0 / low),
            Start::Spread if self.logarithmic => between(low.ln(), high.ln()).exp(),
            Start::Spread => between(low, high),
        }
    }
}

impl Candidate {
    /// Whether the data have what the law needs to differ from a simpler one.
    pub fn lacks(&self, scales: &Scales) -> Option<&'static str> {
        let needs = |id| self.law.uses(id);
        if self.forgotten(scales).next().is_some() {
            return Some("the law has a parameter that no fit moves");
        }
        if scales.load == 0.0 && (self.pressing != Pressing::Constant || self.gain) {
            return Some("there is no load");
        }
        if needs(ParamId::LoadFriction)
            && (scales.drive == 0.0 || self.pressing != Pressing::Constant)
        {
            return Some("there is no drive force, or the load presses already");
        }
        if needs(ParamId::ViscousLoad) && self.pressing == Pressing::Constant {
            return Some("the normal force does not change");
        }
        None
    }

    fn own(&self) -> impl Iterator<Item = ParamId> {
        ParamId::all().filter(|id| self.law.info.params.contains(&id.param().name))
    }

    /// Parameters of the law that have neither a range to fit in nor a place among those
    /// `FROZEN`: a fit would leave them at their defaults without a word.
    pub fn forgotten(&self, scales: &Scales) -> impl Iterator<Item = ParamId> {
        let frozen = |id: ParamId| FROZEN.iter().any(|(known, _)| *known == id);
        self.own().filter(move |id| !frozen(*id) && range(*id, scales).is_none())
    }

    /// The free parameters.
    pub fn free(&self, scales: &Scales) -> Vec<Free> {
        let mut all: Vec<Free> = self.own().filter_map(|id| free(id, scales)).collect();
        if self.pressing == Pressing::Affine {
            let load = scales.load;
            all.push(Free::decades(What::Preload, load * 1e-3, load * 1e2));
        }
        let either = (f64::NEG_INFINITY, f64::INFINITY);
        if self.offset {
            let free = Free::linear(What::Offset, scales.force);
            all.push(Free { low: either.0, high: either.1, ..free });
        }
        if self.gain {
            let free = Free::linear(What::Gain, scales.force / scales.load);
            all.push(Free { low: either.0, high: either.1, ..free });
        }
        all
    }
}

/// Parameters of laws that fits leave at their defaults, each with its reason: the data
/// cannot tell it from another one of the same law, or from no effect at all.
pub const FROZEN: &[(ParamId, &str)] = &[
    (ParamId::Track1, "beside the level all six ratios of a track would be one too many"),
    (ParamId::DampingSpeed, "no data show how damping fades"),
    (ParamId::Attraction, "how fast elements follow a level that falls hardly shows"),
];

/// Parameters that say over which speeds friction passes from one level to the other, and
/// whether they are one over that speed.
pub const FALLS: &[(ParamId, bool)] = &[
    (ParamId::StribeckSpeed, false),
    (ParamId::ModelicaDecay, true),
    (ParamId::MixedSpeed, false),
    (ParamId::TransitionSpeed, false),
];

/// Where a parameter may lie; `None` where fits leave it alone, or the data leave it no
/// room.
fn free(id: ParamId, scales: &Scales) -> Option<Free> {
    use ParamId as P;
    let (least, most) = id.param().range;
    let free = range(id, scales)?;
    let (low, high) = match id {
        // Levels count under the normal force of the data, which may be 1 N.
        P::MuStatic | P::MuCoulomb => (least, f64::INFINITY),
        _ => (free.low.max(least), free.high.min(most)),
    };
    (low < high).then_some(Free { low, high, ..free })
}

/// The range that the data suggest for a parameter, `None` for one that no fit moves.
fn range(id: ParamId, scales: &Scales) -> Option<Free> {
    use ParamId as P;
    let Scales { force, speed, slowest, track, duration, interval, normal, drive, .. } = *scales;
    let length = track.1 - track.0;
    let direction = speed * interval;
    let what = What::Law(id);
    let slow = (slowest * 0.3).max(speed * 1e-3);
    let free = match id {
        P::MuStatic | P::MuCoulomb => Free::linear(what, force / normal),
        P::Viscous => Free::linear(what, force / speed),
        P::ViscousLoad => Free::linear(what, force / (speed * normal)),
        P::Quadratic | P::Snowplough => Free::linear(what, force / (speed * speed)),
        P::PowerDrag => Free::linear(what, force / speed),
        P::Buildup => Free::linear(what, force / length),
        P::BuildupRoot => Free::linear(what, force / length.sqrt()),
        P::LoadFriction => Free::linear(what, force / drive),
        P::SkinRatio | P::PatchRatio => Free::ratio(what, 1.0, 20.0),
        P::RippleAmplitude => Free::ratio(what, 0.2, 1.0),
        P::Track2 | P::Track3 | P::Track4 | P::Track5 | P::Track6 => Free::ratio(what, 1.0, 20.0),
        P::PowerExponent => Free::range(what, 0.2, 3.5),
        P::StribeckExponent => Free::range(what, 0.3, 3.0),
        P::MixedExponent => Free::range(what, 0.3, 4.0),
        P::LoadExponent => Free::range(what, 0.2, 2.5),
        P::DahlExponent => Free::range(what, 0.3, 2.5),
        P::ElasticShare => Free::range(what, 0.0, 0.95),
        P::StiffnessSpread => Free::decades(what, 1.0, 20.0),
        P::BristleStiffness => Free::decades(what, force / length, force / (direction * 0.01)),
        P::BristleDamping => Free::decades(what, force / speed * 1e-4, force / speed * 30.0),
        P::DwellTime => Free::decades(what, interval, duration),
        P::RippleLength => {
            let free = Free::decades(what, (length / 60.0).max(direction * 2.0), length * 2.0);
            Free { start: Start::SpreadInverse, ..free }
        }
        P::RipplePhaseDeg => {
            let turn = Free::range(what, -180.0, 180.0);
            Free { low: -360.0, high: 360.0, ..turn }
        }
        P::TrackLength => Free::decades(what, length * 0.5, length * 2.0),
        P::PatchStart => Free { edge: true, ..Free::range(what, track.0, track.1) },
        P::PatchLength => Free { edge: true, ..Free::decades(what, length / 50.0, length) },
        _ => match FALLS.iter().find(|(fall, _)| *fall == id)? {
            (_, false) => Free::decades(what, slow, speed * 3.0),
            (_, true) => Free::decades(what, 1.0 / (speed * 3.0), 1.0 / slow),
        },
    };
    Some(free)
}
