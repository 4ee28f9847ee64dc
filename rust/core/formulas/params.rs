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
    // Friction laws.
    LoadFriction "load_friction" r"\mu_l" ["1"] Some(0.0), 0.0 => 1e3, real, None,
        "friction per newton of drive force, where the drive presses the segment to the ground";
    ViscousLoad "viscous_load" r"b_1" ["N s/m"] Some(0.0), 0.0 => 1e9, real, None,
        "viscous coefficient at a normal force of 1 N, beside the constant one";
    LoadExponent "load_exponent" r"q" ["1"] Some(1.0), 0.1 => 3.0, real, None,
        "exponent with which the viscous coefficient grows with the normal force";
    Quadratic "quadratic" r"c_2" ["N s^2/m^2"] Some(0.0), 0.0 => 1e9, real, None,
        "quadratic drag coefficient";
    PowerDrag "power_drag" r"c_p" ["N"] Some(0.0), 0.0 => 1e9, real, None,
        "power-law drag at 1 m/s";
    PowerExponent "power_exponent" r"p" ["1"] Some(1.5), 0.1 => 4.0, real, None,
        "exponent of power-law drag";
    StribeckSpeed "stribeck_speed" r"v_s" ["m/s"] Some(0.01), 1e-9 => 1e3, real, None,
        "speed over which friction falls from static to Coulomb";
    StribeckExponent "stribeck_exponent" r"\delta" ["1"] Some(1.0), 0.1 => 4.0, real, None,
        "exponent of the fall from static to Coulomb friction";
    ModelicaDecay "modelica_decay" r"f_\mathrm{exp}" ["s/m"] Some(100.0), 1e-6 => 1e9, real, None,
        "decay of the Stribeck part in the form of the Modelica library";
    BristleStiffness "bristle_stiffness" r"\sigma_0" ["N/m"] Some(1e5), 1e-3 => 1e12, real, None,
        "stiffness of the contact before it slides";
    BristleDamping "bristle_damping" r"\sigma_1" ["N s/m"] Some(300.0), 0.0 => 1e9, real, None,
        "damping of the contact before it slides";
    DampingSpeed "damping_speed" r"v_d" ["m/s"] Some(INF), 1e-9 => INF, real, None,
        "speed over which the damping of the contact fades, which keeps it passive; inf: it does not";
    DahlExponent "dahl_exponent" r"i" ["1"] Some(1.0), 0.1 => 3.0, real, None,
        "shape of Dahl's curve: below 1 brittle, above 1 ductile";
    ElasticShare "elastic_share" r"z_\mathrm{ba}/z_\mathrm{ss}" ["1"] Some(0.7), 0.0 => 0.99, real, None,
        "share of the deflection at sliding up to which the contact is purely elastic";
    Attraction "attraction" r"C" ["N/s"] Some(100.0), 1e-6 => 1e9, real, None,
        "rate at which a sliding element returns to its steady friction";
    StiffnessSpread "stiffness_spread" r"\kappa" ["1"] Some(2.0), 1.0 => 1e3, real, None,
        "stiffness of one element over that of the next softer one";
    DwellTime "dwell_time" r"\tau_\mathrm{dw}" ["s"] Some(1.0), 1e-6 => 1e6, real, None,
        "time at rest over which the contact gains its static friction";
    RippleAmplitude "ripple_amplitude" r"a" ["1"] Some(0.0), 0.0 => 1.0, real, None,
        "relative amplitude of friction along the track";
    RippleLength "ripple_length" r"L" ["m"] Some(0.01), 1e-9 => 1e6, real, None,
        "period of friction along the track";
    RipplePhaseDeg "ripple_phase_deg" r"\varphi_r" ["deg"] Some(0.0), -360.0 => 360.0, real, None,
        "phase of friction along the track at its zero";
    PatchStart "patch_start" r"x_p" ["m"] Some(0.0), -1e6 => 1e6, real, None,
        "where a patch of other friction begins";
    PatchLength "patch_length" r"L_p" ["m"] Some(0.01), 1e-9 => 1e6, real, None,
        "length of the patch";
    PatchRatio "patch_ratio" r"\rho_p" ["1"] Some(1.0), 0.0 => 1e3, real, None,
        "friction on the patch over friction elsewhere";
    TrackLength "track_length" r"L_t" ["m"] Some(0.1), 1e-9 => 1e6, real, None,
        "length of track over which the six friction ratios are spread, then repeated";
    Track1 "track_1" r"\rho_1" ["1"] Some(1.0), 0.0 => 1e3, real, None, "friction ratio at the track's zero";
    Track2 "track_2" r"\rho_2" ["1"] Some(1.0), 0.0 => 1e3, real, None, "friction ratio at 1/6 of the track";
    Track3 "track_3" r"\rho_3" ["1"] Some(1.0), 0.0 => 1e3, real, None, "friction ratio at 2/6 of the track";
    Track4 "track_4" r"\rho_4" ["1"] Some(1.0), 0.0 => 1e3, real, None, "friction ratio at 3/6 of the track";
    Track5 "track_5" r"\rho_5" ["1"] Some(1.0), 0.0 => 1e3, real, None, "friction ratio at 4/6 of the track";
    Track6 "track_6" r"\rho_6" ["1"] Some(1.0), 0.0 => 1e3, real, None, "friction ratio at 5/6 of the track";
    Buildup "buildup" r"k_b" ["N/m"] Some(0.0), 0.0 => 1e9, real, None,
        "resistance of the lubricant pushed along, per distance swept since the last rest or turn";
    BuildupRoot "buildup_root" r"c_1" ["N/m^0.5"] Some(0.0), 0.0 => 1e9, real, None,
        "resistance of the lubricant pushed along, per root of the distance swept (a yield stress)";
    Snowplough "snowplough" r"c_3" ["N s^2/m^2"] Some(0.0), 0.0 => 1e9, real, None,
        "momentum given to the lubricant scraped up, per square of the speed";
    MixedSpeed "mixed_speed" r"v_m" ["m/s"] Some(0.05), 1e-9 => 1e3, real, None,
        "speed over which the film takes over from the solid contact";
    MixedExponent "mixed_exponent" r"n" ["1"] Some(1.0), 0.1 => 4.0, real, None,
        "exponent with which the film takes over";
    TransitionSpeed "transition_speed" r"v_t" ["m/s"] Some(1e-3), 1e-9 => 1e3, real, None,
        "speed over which a regularised law rises from zero, at its peak where it has one: it creeps below";
    // The drive of one segment.
    Gain "gain" r"k_d" ["N"] Some(1.0), -1e9 => 1e9, real, Some(("drive", "gain")),
        "drive force per unit of a table of samples";
    DriveForce "drive_force" r"F_0" ["N"] Some(0.0), -1e9 => 1e9, real, None,
        "constant part of the drive force";
    DriveAmplitude "drive_amplitude" r"A" ["N"] Some(0.0), -1e9 => 1e9, real, None,
        "amplitude of the drive force";
    DriveFrequency "drive_frequency" r"f" ["Hz"] Some(1.0), 1e-9 => 1e6, real, None,
        "frequency of the drive; of a multisine the lowest, of a chirp the first";
    DriveFrequencyEnd "drive_frequency_end" r"f_1" ["Hz"] Some(10.0), 1e-9 => 1e6, real, None,
        "frequency of a chirp at the end of the run";
    DrivePhaseDeg "drive_phase_deg" r"\varphi" ["deg"] Some(0.0), -360.0 => 360.0, real, None,
        "phase of the drive at the start";
    DriveHarmonics "drive_harmonics" r"n_h" ["1"] Some(8.0), 1.0 => 64.0, whole, None,
        "number of components of a multisine";
    DriveRate "drive_rate" r"\dot F" ["N/s"] Some(1.0), 1e-9 => 1e9, real, None,
        "rate at which a ramp rises and falls";
    DriveHold "drive_hold" r"t_h" ["s"] Some(0.0), 0.0 => 1e6, real, None,
        "time that a ramp stays at its top";
    DrivePeriod "drive_period" r"T_p" ["s"] Some(1.0), 1e-9 => 1e6, real, None,
        "period of a pulse train";
    DriveDuty "drive_duty" r"d" ["1"] Some(0.5), 0.0 => 1.0, real, None,
        "share of the period in which a pulse train drives forward";
    DriveBack "drive_back" r"F_b" ["N"] Some(0.0), -1e9 => 1e9, real, None,
        "force of a pulse train in the rest of the period, backward positive";
    SpringStiffness "spring_stiffness" r"k_s" ["N/m"] Some(0.0), 0.0 => 1e9, real, None,
        "stiffness of a spring that pulls the segment";
    SpringDamping "spring_damping" r"d_s" ["N s/m"] Some(0.0), 0.0 => 1e9, real, None,
        "damping beside that spring";
    PullSpeed "pull_speed" r"v_p" ["m/s"] Some(0.0), -1e6 => 1e6, real, None,
        "speed of the spring's other end";
    // One run.
    Duration "duration" r"T" ["s"] Some(1.0), 1e-9 => 1e9, real, None,
        "time that is simulated";
    TimeStep "time_step" r"h" ["s"] Some(1e-3), 1e-12 => 1e6, real, None,
        "step of the fixed-step methods; of dormand_prince the first one, and at rest";
    Tolerance "tolerance" r"\epsilon" ["1"] Some(1e-6), 1e-14 => 0.1, real, None,
        "relative local error that the adaptive methods aim at";
    StartPosition "start_position" r"x_0" ["m"] Some(0.0), -1e6 => 1e6, real, None,
        "position at the start";
    StartSpeed "start_speed" r"v_0" ["m/s"] Some(0.0), -1e6 => 1e6, real, None,
        "speed at the start";
    // The whole robot.
    JointStiffness "joint_stiffness" r"k_\mathrm{j}" ["N/m"] Some(INF), 1e-3 => INF, real, None,
        "stiffness between a joint's drive and the joint; inf: ideal, and locked where it is not driven";
    JointDamping "joint_damping" r"d_\mathrm{j}" ["N s/m"] Some(0.0), 0.0 => 1e9, real, None,
        "damping beside that stiffness";
    Dwell "dwell" r"t_\mathrm{w}" ["s"] Some(0.0), 0.0 => 1e6, real, None,
        "rest after each phase of the gait";
    Cycles "cycles" r"n_\mathrm{c}" ["1"] Some(10.0), 1.0 => 1e6, whole, None,
        "cycles of the gait that are simulated";
    Impact "impact" r"\iota" ["1"] Some(1.0), 0.0 => 1.0, whole, None,
        "what becomes of the momentum left at the end of an ideal joint's stroke. 1: the robot keeps it (plastic impact); 0: it is dropped, as in the closed forms";
    StribeckTerm "stribeck_term" r"\sigma_\mathrm{s}" ["1"] Some(0.0), 0.0 => 1.0, whole, None,
        "1: friction of a whole robot's sliding segments falls from static to Coulomb over stribeck_speed; 0: it falls at once. Elastic joints only";
    SegmentPitch "segment_pitch" r"p" ["m"] Some(0.0), 0.0 => 1e6, real, None,
        "distance between neighbouring segments of a whole robot at the start, with fresh lubricant between them; 0: only the head finds any";
    BreakAway "break_away" r"\beta_\mathrm{s}" ["1"] Some(1.0), 0.0 => 1.0, whole, None,
        "1: a segment that the gait moves must first overcome its static friction; 0: it starts against Coulomb friction, as in the closed forms";
    SupplyVoltage "supply_voltage" "U" ["V"] Some(INF), 0.0 => INF, real, Some(("motor", "supply_voltage")),
        "supply voltage of each joint's motor, which limits its force as its speed grows";
    WindingResistance "winding_resistance" "R" ["ohm"] Some(20.0), 1e-9 => 1e9, real, Some(("motor", "resistance")),
        "winding resistance of the motor";
    ForceConstant "force_constant" r"k_F" ["N/A"] Some(1.7), 1e-9 => 1e9, real, Some(("motor", "force_constant")),
        "force per ampere, and back-EMF in V s/m";
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
    file_key: (&'static str, &'static str),
    meaning: &'static str,
) -> Param {
    Param {
        name,
        symbol: "",
        unit,
        default,
        range,
        integer: false,
        file_key: Some(file_key),
        meaning,
    }
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

/// One bit per parameter named.
pub const fn used_by(params: &[&str]) -> u128 {
    let (mut bits, mut i) = (0, 0);
    while i < params.len() {
        let (mut k, mut found) = (0, false);
        while k < PARAMS.len() {
            if same(params[i], PARAMS[k].name) {
                bits |= 1 << k;
                found = true;
            }
            k += 1;
        }
        assert!(found, "a quantity names a parameter that is not in the registry");
        i += 1;
    }
    bits
}

const fn same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}
