//! What the registry says of an effect: the vocabulary of its rows.
//!
//! Numbers that follow from a rig are formulas in its sizes, as text, so that a row
//! is data: `"force / speed"`, `"travel * [0.01, 0.1]"`. They know `+ - * / **`,
//! comparison, lists, `pi` and the functions `min`, `max`, `sqrt`, `degrees`,
//! `geomspace(low, high, count)`, `both(x)` (x and its negative) and
//! `critical(stiffness, mass)` (critical damping). The sizes are
//!
//! | name | unit | size |
//! |---|---|---|
//! | `mass`, `weight` | kg, N | of the head |
//! | `grip` | N | weight of the anchored body on the ground |
//! | `nominal_level` | N | Coulomb level at the nominal slope |
//! | `level` | N | the same, but at least a thousandth of `force` |
//! | `least_level` | N | what `level` may be where it is uncertain |
//! | `mu` | 1 | Coulomb coefficient (rivals of the blind check) |
//! | `force` | N | large drive force |
//! | `peak` | N | largest drive force, which a single run may hold |
//! | `viscous` | N s/m | nominal viscous coefficient |
//! | `speed`, `travel` | m/s, m | of the head in a run |
//! | `duration`, `replayed` | s | of a run, of what is replayed at once |
//! | `interval` | s | between samples |

use crate::describe::Param;

/// Where an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Site {
    Friction,
    Drive,
    Body,
    Environment,
    Sensor,
}

impl Site {
    pub fn name(self) -> &'static str {
        match self {
            Site::Friction => "friction",
            Site::Drive => "drive",
            Site::Body => "body",
            Site::Environment => "environment",
            Site::Sensor => "sensor",
        }
    }
}

/// The value of a parameter at which its effect is not there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Off {
    At(f64),
    /// The nominal Coulomb level.
    Coulomb,
    /// No value does it: another parameter of the effect must be off.
    Never,
}

/// How the nominal model gives its Coulomb level, where that decides between two
/// parameters of one meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LevelForm {
    /// `mu_coulomb`.
    Coefficient,
    /// `coulomb_force`.
    Force,
}

/// What a rig must have for an effect to have a meaning there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// An anchored body: no bench, more than one segment.
    Body,
    /// The sensor of the body's position.
    RearSensor,
    /// Ground that can slope: no rotary bench.
    Slope,
}

impl Need {
    pub fn name(self) -> &'static str {
        match self {
            Need::Body => "body",
            Need::RearSensor => "rear_sensor",
            Need::Slope => "slope",
        }
    }
}

/// Motion of the head without which runs cannot show an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shown {
    /// The head may stay at rest.
    AtRest,
    Moving,
    Forward,
    /// Forward and backward.
    BothWays,
}

impl Shown {
    pub fn name(self) -> &'static str {
        match self {
            Shown::AtRest => "at_rest",
            Shown::Moving => "moving",
            Shown::Forward => "forward",
            Shown::BothWays => "both_ways",
        }
    }
}

/// The variable that another law of an effect would follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    Speed,
    /// Distance moved since the last reversal.
    Turned,
    ContactState,
    /// Position, in either direction alike.
    Terrain,
    /// Drive force, against the motion.
    Load,
    Time,
    /// Distance moved forward since the last rest or turn.
    Swept,
    /// Drive command.
    Drive,
    /// Drive command of a while ago.
    History,
    /// Single changes of the drive command, each for itself.
    Change,
    /// Time, in proportion to the drive command.
    Sag,
    /// Position, in the reading alone.
    Reading,
    /// Time, in the reading alone.
    Clock,
    /// Speed, in the reading alone.
    Late,
}

impl Variable {
    pub fn name(self) -> &'static str {
        match self {
            Variable::Speed => "speed",
            Variable::Turned => "turned",
            Variable::ContactState => "place",
            Variable::Terrain => "terrain",
            Variable::Load => "load",
            Variable::Time => "time",
            Variable::Swept => "swept",
            Variable::Drive => "drive",
            Variable::History => "history",
            Variable::Change => "change",
            Variable::Sag => "sag",
            Variable::Reading => "reading",
            Variable::Clock => "clock",
            Variable::Late => "late",
        }
    }
}

/// A row of the registry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectInfo {
    pub name: &'static str,
    pub site: Site,
    /// TeX.
    pub formula: &'static str,
    pub meaning: &'static str,
    pub params: &'static [EffectParam],
    /// None where the effect is the error of a number, which has no other law.
    pub variable: Option<Variable>,
    /// A second variable that another law may follow, and no other effect.
    pub further: Option<Variable>,
    /// Whether its law in `variable` rises all along, or falls, by whatever formula.
    pub monotone: bool,
    /// Whether its law in `variable` never jumps, by whatever formula.
    pub continuous: bool,
    /// Whether its law in `variable` stays near its mean, by whatever formula.
    pub steady: bool,
    pub needs: &'static [Need],
    pub shown: Shown,
    /// Effects with fewer parameters that this one contains as a limit.
    pub contains: &'static [&'static str],
    /// Effects that stand in its place: a model has one of them.
    pub excludes: &'static [&'static str],
    /// Value of `[uncertainty]` that the effect is an error of.
    pub error_of: Option<&'static str>,
    /// Beside it friction at rest may lie below the nominal Coulomb level.
    pub lowers_level: bool,
    /// Work of a replay with it, in replays of the nominal model; with several effects the
    /// product, about. Set by `cargo bench --bench dynamics -- replay`.
    pub work: f64,
    /// What starts must fulfil, in the parameters.
    pub keep: Option<&'static str>,
    /// Magnitudes of parameters given by `u`: 0 is the nominal model, about 1 as
    /// large as a rig allows.
    pub magnitude: Magnitude,
    /// Whether the blind check's reality has the effect; there its rivals are
    pub drawn: bool,
    /// parameters given by a strength `s` of either sign, or of one sign only,
    pub one_sided: bool,
    /// and by further numbers, each a list: all are tried,
    pub over: &'static [(&'static str, &'static str)],
    /// or fitted together, as what they change spans a plane.
    pub spanned: &'static [(&'static str, &'static str)],
    /// The number of `over` that is looked at between its values, too.
    pub refined: Option<&'static str>,
}

/// The signed magnitude of an effect and the shapes that it may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Magnitude {
    pub low: &'static str,
    pub high: &'static str,
    /// Below it an integrator resolves no more than the nominal model.
    pub least: f64,
    pub shapes: &'static [Shape],
}

/// A further number that the parameters of an effect follow from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    pub name: &'static str,
    pub starts: &'static str,
    pub low: &'static str,
    pub high: &'static str,
    /// Fits step its logarithm.
    pub log: bool,
    /// Of a finite difference.
    pub step: f64,
}

/// A parameter of an effect, and how fits treat it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectParam {
    pub param: Param,
    pub off: Off,
    /// The form of the nominal level with which it is used; None with either.
    pub only: Option<LevelForm>,
    /// Fits step its logarithm.
    pub log: bool,
    /// A large change of it (of its logarithm if `log`).
    pub unit: &'static str,
    /// First values, in `unit` unless `log`.
    pub starts: &'static str,
    /// What a start is in full, from its `value` and the other parameters.
    pub composed: Option<&'static str>,
    /// Range of fits.
    pub low: &'static str,
    pub high: &'static str,
    /// The same where runs are replayed in windows.
    pub windows: Option<(&'static str, &'static str)>,
    /// Its value at a magnitude `u` and the shapes.
    pub at: &'static str,
    /// Its value as a rival at a strength `s`.
    pub rival: &'static str,
    /// Data determine it well enough for its value to be judged.
    pub judged: bool,
}

/// What most rows say.
pub(super) const EFFECT: EffectInfo = EffectInfo {
    name: "",
    site: Site::Friction,
    formula: "",
    meaning: "",
    params: &[],
    variable: None,
    further: None,
    monotone: false,
    continuous: false,
    steady: false,
    needs: &[],
    shown: Shown::Moving,
    contains: &[],
    excludes: &[],
    error_of: None,
    lowers_level: false,
    work: 1.0,
    keep: None,
    magnitude: Magnitude { low: "-1", high: "10", least: 1e-9, shapes: &[] },
    drawn: true,
    one_sided: false,
    over: &[],
    spanned: &[],
    refined: None,
};

/// What most parameters say.
pub(super) const PARAM: EffectParam = EffectParam {
    param: Param {
        name: "",
        symbol: "",
        unit: "1",
        default: None,
        range: (0.0, 0.0),
        integer: false,
        file_key: None,
        meaning: "",
    },
    off: Off::At(0.0),
    only: None,
    log: false,
    unit: "1",
    starts: EITHER_SIGN,
    composed: None,
    low: "0",
    high: "inf",
    windows: None,
    at: "u",
    rival: "s",
    judged: true,
};

pub(super) const SHAPE: Shape =
    Shape { name: "", starts: "[1]", low: "0", high: "1", log: true, step: 0.02 };

pub(super) const EITHER_SIGN: &str = "both([0.003, 0.01, 0.03, 0.1, 0.3])";
pub(super) const POSITIVE: &str = "[0.003, 0.01, 0.03, 0.1, 0.3]";

pub(super) const fn param(
    name: &'static str,
    symbol: &'static str,
    unit: &'static str,
    range: (f64, f64),
    meaning: &'static str,
) -> Param {
    Param { name, symbol, unit, default: None, range, integer: false, file_key: None, meaning }
}
