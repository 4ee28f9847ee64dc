//! GAIT PARAMETER REGISTRY: what the run of one robot takes, where it stands in
//! a gait file, and what may differ from part to part. One line per parameter.

use super::RunOptions;
use crate::error::{Error, Result};
use crate::physics::ParamId;
use crate::physics::friction::{Parameters, Values};
use crate::physics::lubricant::Lubricant;
use crate::physics::robot::{MOST_SEGMENTS, Robot};

/// What a value belongs to: the whole run, or one of the robot's parts, which
/// may then have values of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    Run,
    Segment,
    Joint,
}

impl Part {
    pub fn name(self) -> &'static str {
        match self {
            Part::Run => "run",
            Part::Segment => "segment",
            Part::Joint => "joint",
        }
    }
}

/// A parameter of a run and its table and key in a gait file.
#[derive(Debug, Clone, Copy)]
pub struct GaitParam {
    pub id: ParamId,
    pub part: Part,
    pub table: &'static str,
    pub key: &'static str,
}

macro_rules! params {
    ($($id:ident $part:ident $table:literal $key:literal;)+) => {
        pub const GAIT_PARAMS: &[GaitParam] = &[$(GaitParam {
            id: ParamId::$id, part: Part::$part, table: $table, key: $key,
        }),+];
    };
}

params! {
    Segments Run "robot" "segments";
    Mass Segment "robot" "mass";
    Gravity Run "robot" "gravity";
    SegmentPitch Run "robot" "segment_pitch";
    MuStatic Segment "surface" "mu_static";
    MuCoulomb Segment "surface" "mu_coulomb";
    Viscous Segment "surface" "viscous";
    SlopeDeg Segment "surface" "slope_deg";
    SkinRatio Segment "surface" "skin_ratio";
    WallForce Segment "surface" "wall_force";
    CornerDeg Segment "surface" "corner_deg";
    CoulombTerm Run "surface" "coulomb_term";
    StribeckTerm Segment "surface" "stribeck_term";
    StribeckSpeed Segment "surface" "stribeck_speed";
    StribeckExponent Segment "surface" "stribeck_exponent";
    Buildup Segment "surface" "buildup";
    BuildupRoot Segment "surface" "buildup_root";
    Snowplough Segment "surface" "snowplough";
    DriveLimit Joint "drive" "limit";
    SpeedLimit Joint "drive" "speed_limit";
    Stroke Joint "gait" "stroke";
    Moving Run "gait" "moving";
    Cycles Run "gait" "cycles";
    Dwell Run "gait" "dwell";
    WallRelease Run "gait" "wall_release";
    BreakAway Run "gait" "break_away";
    Impact Run "gait" "impact";
    TimeStep Run "gait" "time_step";
    JointStiffness Joint "joint" "stiffness";
    JointDamping Joint "joint" "damping";
    SupplyVoltage Run "motor" "supply_voltage";
    WindingResistance Run "motor" "resistance";
    ForceConstant Run "motor" "force_constant";
}

/// Values of a parameter for each part, from the head backward.
pub type PerPart = (String, Vec<f64>);

/// A robot and its run from named values.
#[derive(Debug, Clone)]
pub struct RunParameters {
    pub robot: Robot<f64>,
    pub options: RunOptions<f64>,
    pub segments: usize,
    pub moving: usize,
    pub cycles: usize,
}

fn find(name: &str) -> Result<&'static GaitParam> {
    let id = ParamId::parse(name)?;
    let found = GAIT_PARAMS.iter().find(|p| p.id == id);
    found.ok_or_else(|| Error::BadOption {
        name: "parameter",
        given: name.to_owned(),
        allowed: format!("one that a gait takes: {}", names(|_| true)),
    })
}

fn names(wanted: impl Fn(Part) -> bool) -> String {
    let all = GAIT_PARAMS.iter().filter(|p| wanted(p.part));
    all.map(|p| p.id.param().name).collect::<Vec<_>>().join(", ")
}

/// Checks the values of a part's parameter and returns them by index.
fn spread(part: Part, count: usize, given: &[PerPart]) -> Result<Vec<(ParamId, Vec<f64>)>> {
    let check = |(name, values): &PerPart| {
        let param = find(name)?;
        if param.part != part {
            return Err(Error::BadOption {
                name: "parameter",
                given: format!("{name}, with a value for each {}", part.name()),
                allowed: names(|p| p == part),
            });
        }
        if values.len() != count {
            return Err(Error::BadOption {
                name: param.id.param().name,
                given: format!("{} values", values.len()),
                allowed: format!("one, or {count}: a value for each {}", part.name()),
            });
        }
        let checked = values.iter().enumerate().map(|(i, v)| param.id.param().check(*v, Some(i)));
        Ok((param.id, checked.collect::<Result<Vec<_>>>()?))
    };
    given.iter().map(check).collect()
}

impl RunParameters {
    /// `parameters` hold for all parts alike; `per_segment` and `per_joint` have
    /// a value for each.
    pub fn new(
        parameters: &[(String, f64)],
        per_segment: &[PerPart],
        per_joint: &[PerPart],
    ) -> Result<RunParameters> {
        let mut shared = Vec::with_capacity(parameters.len());
        for (name, value) in parameters {
            let id = find(name)?.id;
            shared.push((id, id.param().check(*value, None)?));
        }
        let values = Values::of(&shared);
        let count = values.get(ParamId::Segments);
        if count.is_nan() {
            return Err(missing(ParamId::Segments));
        }
        if count > MOST_SEGMENTS as f64 {
            return Err(Error::BadOption {
                name: "segments",
                given: count.to_string(),
                allowed: format!("a whole number from 2 to {MOST_SEGMENTS}"),
            });
        }
        let segments = count as usize;
        let joints = segments.saturating_sub(1);
        let segment_values = spread(Part::Segment, segments, per_segment)?;
        let joint_values = spread(Part::Joint, joints, per_joint)?;
        for param in GAIT_PARAMS {
            let parts = segment_values.iter().chain(&joint_values);
            if values.get(param.id).is_nan() && !parts.into_iter().any(|(id, _)| *id == param.id) {
                return Err(missing(param.id));
            }
        }
        let own = |parts: &[(ParamId, Vec<f64>)], i: usize| {
            let mut given = shared.clone();
            given.extend(parts.iter().map(|(id, values)| (*id, values[i])));
            Values::of(&given)
        };
        let mut robot = Robot::uniform(&values, segments);
        for (i, segment) in robot.segments.iter_mut().enumerate() {
            *segment = Robot::uniform(&own(&segment_values, i), 1).segments[0];
        }
        for (j, joint) in robot.joints.iter_mut().enumerate() {
            *joint = Robot::uniform(&own(&joint_values, j), 2).joints[0];
        }
        let lubricant = |i: usize| Lubricant::of(&own(&segment_values, i));
        let lubricants: Vec<Lubricant<f64>> = (0..segments).map(lubricant).collect();
        let lubricated = lubricants.iter().any(|l| l.acts());
        robot.lubricants = if lubricated { lubricants } else { Vec::new() };
        let falls = |id| (0..segments).any(|i| own(&segment_values, i).get(id) > 0.0);
        if !falls(ParamId::StribeckTerm) {
            for id in STRIBECK {
                let own = (0..segments).map(|i| own(&segment_values, i).get(*id));
                stribeck_needs_its_term(*id, own)?;
            }
        }
        let get = |id| values.get(id);
        let options = RunOptions {
            time_step: get(ParamId::TimeStep),
            dwell: get(ParamId::Dwell),
            impact: get(ParamId::Impact),
            break_away: get(ParamId::BreakAway),
        };
        let (moving, cycles) = (get(ParamId::Moving) as usize, get(ParamId::Cycles) as usize);
        Ok(RunParameters { robot, options, segments, moving, cycles })
    }
}

/// Parameters that do nothing to a robot without [`ParamId::StribeckTerm`].
pub const STRIBECK: &[ParamId] = &[ParamId::StribeckSpeed, ParamId::StribeckExponent];

/// Refuses values other than the default of a parameter that has nothing to do.
pub fn stribeck_needs_its_term(id: ParamId, mut values: impl Iterator<Item = f64>) -> Result<()> {
    match values.find(|value| Some(*value) != id.param().default) {
        None => Ok(()),
        Some(value) => Err(Error::BadOption {
            name: id.param().name,
            given: format!("{value}, without stribeck_term"),
            allowed: "a value beside stribeck_term = 1, with which friction falls over speed"
                .to_owned(),
        }),
    }
}

fn missing(id: ParamId) -> Error {
    Error::BadOption {
        name: id.param().name,
        given: "not given".to_owned(),
        allowed: id.param().allowed(),
    }
}
