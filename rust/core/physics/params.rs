//! PARAMETER REGISTRY: every number that a sweep can take, and every key of a
//! robot file that is not one of them. One line here is all a new one needs.

use crate::describe::{Param, nearest};
use crate::error::{Error, Result};

macro_rules! params {
    ($($id:ident $name:literal $symbol:literal [$unit:literal] $default:expr, $low:expr => $high:expr,
       $kind:ident, $key:expr, $meaning:literal;)+) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(usize)]
        pub enum ParamId { $($id),+ }

        const ALL: &[ParamId] = &[$(ParamId::$id),+];

        pub const PARAMS: &[Param] = &[$(Param {
            name: $name, symbol: $symbol, unit: $unit, default: $default,
            range: ($low, $high), integer: params!(@$kind), file_key: $key, meaning: $meaning,
        }),+];
    };
    (@whole) => { true };
    (@real) => { false };
}

const INF: f64 = f64::INFINITY;
/// Beyond 7e5 segments the two neighbours of an optimum lie within the margin of
/// a tie, and "the" best count loses its meaning.
const MOST_SEGMENTS: f64 = 5e5;

params! {
    MuStatic "mu_static" r"\mu_S" ["1"] None, 0.0 => 1e3, real, Some(("surface", "mu_static")),
        "static friction coefficient of the anchors";
    MuCoulomb "mu_coulomb" r"\mu_C" ["1"] None, 0.0 => 1e3, real, Some(("surface", "mu_coulomb")),
        "Coulomb friction coefficient of the moving segments";
    Segments "segments" "N" ["1"] None, 1.0 => 1e9, whole, Some(("robot", "segments")),
        "number of segments of the robot";
    SlopeDeg "slope_deg" r"\alpha" ["deg"] Some(0.0), -90.0 => 90.0, real, Some(("surface", "slope_deg")),
        "slope of the ground, positive up-hill";
    Mass "mass" "m" ["kg"] Some(0.271), 1e-9 => 1e9, real, Some(("robot", "mass")),
        "mass of one segment";
    Gravity "gravity" "g" ["m/s^2"] Some(9.81), 0.0 => 1e6, real, Some(("robot", "gravity")),
        "gravitational acceleration";
    Stroke "stroke" r"\delta" ["m"] Some(0.02), 1e-9 => 1e6, real, Some(("gait", "stroke")),
        "distance that a segment moves in one phase";
    Viscous "viscous" r"\mu_V" ["N s/m"] Some(0.0), 0.0 => 1e9, real, Some(("surface", "viscous")),
        "viscous friction coefficient of one moving segment";
    Moving "moving" "k" ["1"] Some(1.0), 1.0 => 1e9, whole, Some(("gait", "moving")),
        "number of segments that move at once";
    AnchorWeight "anchor_weight" "w" ["1"] Some(1.0), 0.0 => 1.0, real, Some(("gait", "anchor_weight")),
        "share of the anchors' own weight that they must hold on a slope: 1 is physical, 0 is closer to the paper's Figure 2";
    DriveLimit "drive_limit" r"F_\mathrm{max}" ["N"] Some(INF), 0.0 => INF, real, Some(("drive", "limit")),
        "largest force of one joint's actuator";
    SpeedLimit "speed_limit" r"v_\mathrm{max}" ["m/s"] Some(INF), 1e-9 => INF, real, Some(("drive", "speed_limit")),
        "largest speed of the actuator";
    AnchorsAhead "anchors_ahead" r"n_\mathrm{a}" ["1"] Some(0.0), 0.0 => 1e9, whole, None,
        "anchors ahead of the moving block: 0 is the head block with one driven joint, more adds the second joint";
    Brake "brake" "q" ["1"] Some(0.0), 0.0 => 1.0, whole, None,
        "1: the anchors also brake each phase to rest; 0: acceleration only, as in the paper";
    SkinRatio "skin_ratio" r"\rho" ["1"] Some(1.0), 1e-3 => 1e3, real, None,
        "backward over forward friction of a directional skin (scales, bristles); multiplies the friction of the anchors";
    WallForce "wall_force" "Q" ["N"] Some(0.0), 0.0 => 1e9, real, None,
        "force that presses each segment to the pipe wall, beside its weight";
    WallRelease "wall_release" r"\lambda" ["1"] Some(0.0), 0.0 => 1.0, real, None,
        "share of the wall force that moving segments let go: 1 is a concertina gait";
    CornerDeg "corner_deg" r"\beta" ["deg"] Some(0.0), 0.0 => 89.0, real, None,
        "half angle of the groove that carries the robot: 0 on a plane, 45 in the corner of a square pipe";
    CoulombTerm "coulomb_term" r"\kappa" ["1"] Some(1.0), 0.0 => 1.0, whole, None,
        "1: Coulomb friction acts beside the viscous one; 0: dropped where viscous > 0 (the paper's (10) allows both readings)";
    Time "time" "t" ["s"] None, 0.0 => 1e9, real, None,
        "time since the phase began";
    Speed "speed" "v" ["m/s"] None, -1e6 => 1e6, real, None,
        "speed of the segment";
    SegmentsMin "segments_min" r"N_\mathrm{min}" ["1"] Some(1.0), 1.0 => MOST_SEGMENTS, whole, None,
        "smallest segment count to consider";
    SegmentsMax "segments_max" r"N_\mathrm{max}" ["1"] Some(MOST_SEGMENTS), 1.0 => MOST_SEGMENTS, whole, None,
        "largest segment count to consider";
}

pub const PARAM_COUNT: usize = PARAMS.len();

/// Keys of a robot file that no closed form takes: the measured plant, its
/// sensors and motor, used by simulation and diagnosis.
pub const FILE_KEYS: &[Param] = &[
    key(
        "coulomb_force",
        "N",
        None,
        (0.0, 1e9),
        ("surface", "coulomb_force"),
        "Coulomb friction as a force (N, or N m on a rotary bench), in place of mu_coulomb",
    ),
    key(
        "gain",
        "N",
        Some(1.0),
        (-1e9, 1e9),
        ("drive", "gain"),
        "drive force per unit of the drive column",
    ),
    key(
        "position_noise",
        "m",
        Some(0.0),
        (0.0, 1e6),
        ("sensor", "position_noise"),
        "standard deviation of x and x_rear",
    ),
    key(
        "position_resolution",
        "m",
        Some(0.0),
        (0.0, 1e6),
        ("sensor", "position_resolution"),
        "quantisation step of x and x_rear",
    ),
    key(
        "force_noise",
        "N",
        Some(0.0),
        (0.0, 1e9),
        ("sensor", "force_noise"),
        "standard deviation of force",
    ),
    key(
        "velocity_noise",
        "m/s",
        Some(0.0),
        (0.0, 1e6),
        ("sensor", "velocity_noise"),
        "standard deviation of v",
    ),
    key(
        "power_noise",
        "W",
        Some(0.0),
        (0.0, 1e9),
        ("sensor", "power_noise"),
        "standard deviation of power",
    ),
    key(
        "supply_voltage",
        "V",
        Some(10.0),
        (0.0, 1e6),
        ("motor", "supply_voltage"),
        "supply voltage of the motor",
    ),
    key(
        "resistance",
        "ohm",
        Some(20.0),
        (1e-9, 1e9),
        ("motor", "resistance"),
        "winding resistance of the motor",
    ),
    key(
        "force_constant",
        "N/A",
        Some(1.7),
        (0.0, 1e9),
        ("motor", "force_constant"),
        "force per ampere, and back-EMF in V s/m",
    ),
    key(
        "mass_uncertainty",
        "1",
        None,
        (0.0, 1.0),
        ("uncertainty", "mass"),
        "relative standard deviation of mass",
    ),
    key(
        "mu_coulomb_uncertainty",
        "1",
        None,
        (0.0, 1.0),
        ("uncertainty", "mu_coulomb"),
        "relative standard deviation of mu_coulomb",
    ),
    key(
        "gain_uncertainty",
        "1",
        None,
        (0.0, 1.0),
        ("uncertainty", "gain"),
        "relative standard deviation of the drive gain",
    ),
    key(
        "clock_uncertainty",
        "s",
        None,
        (0.0, 1e3),
        ("uncertainty", "clock"),
        "offset between drive and sensor time stamps",
    ),
    key(
        "gravity_torque",
        "N m",
        None,
        (0.0, 1e9),
        ("bench", "gravity_torque"),
        "rotary bench: adds -gravity_torque sin(x)",
    ),
];

/// Keys of a robot file whose value is one of a few words.
pub const FILE_CHOICES: &[(&str, &str, &[&str])] = &[("bench", "kind", &["linear", "rotary"])];

const fn key(
    name: &'static str,
    unit: &'static str,
    default: Option<f64>,
    range: (f64, f64),
    place: (&'static str, &'static str),
    meaning: &'static str,
) -> Param {
    Param { name, symbol: "", unit, default, range, integer: false, file_key: Some(place), meaning }
}

impl ParamId {
    pub fn all() -> impl Iterator<Item = ParamId> {
        ALL.iter().copied()
    }

    pub fn param(self) -> &'static Param {
        &PARAMS[self as usize]
    }

    pub fn parse(name: &str) -> Result<ParamId> {
        let names = || PARAMS.iter().map(|p| p.name);
        match PARAMS.iter().position(|p| p.name == name) {
            Some(i) => Ok(ALL[i]),
            None => Err(Error::UnknownName {
                kind: "parameter",
                given: name.to_owned(),
                nearest: nearest(name, names()).map(str::to_owned),
                known: names().map(str::to_owned).collect(),
            }),
        }
    }

    /// Column of the value itself (see `point`).
    pub const fn main(self) -> usize {
        2 * self as usize
    }

    /// Column of the number derived from it.
    pub const fn derived(self) -> usize {
        2 * self as usize + 1
    }
}
