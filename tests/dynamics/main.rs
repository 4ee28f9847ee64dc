//! Simulated quantities: every law, drive, method and output of the registries
//! through the engine.

mod adaptive;
mod bits;
mod effort;
mod energy;
#[path = "../common/engine.rs"]
mod engine;
mod hostile;
mod known;
mod parameters;
#[path = "../common/random.rs"]
mod random;
mod refusals;
mod robots;
mod scalar;
mod statuses;
mod traces;

use engine::*;
use locosweep::Error;
use locosweep::integrate::Method;
use locosweep::lane::Level;
use locosweep::physics::drive::DriveKind;
use locosweep::physics::friction::{Kind, LAWS, LawEntry};
use locosweep::physics::{ParamId, Status};
use locosweep::sweep::{
    Buffer, Choice, Control, Entry, Grid, Job, Options, Output, QUANTITIES, Reduce, Request,
    Traces, run, trace,
};
use random::Random;

type Given = Vec<(&'static str, f64)>;
type Axes = Vec<(&'static str, Vec<f64>)>;

/// One sweep of trajectories.
#[derive(Clone)]
struct Case {
    choice: Choice,
    given: Given,
    axes: Axes,
}

impl Case {
    fn new(law: &str, drive: &str, given: Given) -> Case {
        let choice = Choice { law: law.to_owned(), drive: drive.to_owned(), ..Choice::default() };
        Case { choice, given, axes: Vec::new() }
    }

    /// A segment with every parameter at a value where it matters.
    fn usual(law: &str, drive: DriveKind) -> Case {
        let mut case = Case::new(law, drive.info().name, usual());
        if drive == DriveKind::Table {
            (case.choice.times, case.choice.values) = samples();
        }
        case
    }

    fn with(mut self, more: &[(&'static str, f64)]) -> Case {
        for (name, value) in more {
            self.given.retain(|(known, _)| known != name);
            self.given.push((name, *value));
        }
        self
    }

    /// Without lubricant, which robots with ideal joints refuse.
    fn dry(self) -> Case {
        self.with(&[("buildup", 0.0), ("buildup_root", 0.0), ("snowplough", 0.0)])
    }

    fn over(mut self, name: &'static str, values: Vec<f64>) -> Case {
        self.given.retain(|(known, _)| *known != name);
        self.axes.push((name, values));
        self
    }

    fn by(mut self, method: &str) -> Case {
        self.choice.method = Some(method.to_owned());
        self
    }

    fn change(mut self, change: impl FnOnce(&mut Choice)) -> Case {
        change(&mut self.choice);
        self
    }

    fn ask(&self, names: &[&str]) -> Result<Job, Error> {
        let entry = |name: &&str| Entry::parse(name).unwrap();
        let requests = names.iter().map(entry).map(|entry| Request { entry, reduce: None });
        Job::new(Grid::new(&self.axes, &self.given)?, requests.collect(), None, &self.choice)
    }

    fn job(&self, names: &[&str]) -> Job {
        self.ask(names).unwrap_or_else(|error| panic!("{}: {error}", self.name()))
    }

    /// Every output of a trajectory.
    fn all(&self) -> Job {
        self.job(&outputs())
    }

    /// Values of one point.
    fn get(&self, names: &[&str]) -> Vec<f64> {
        results(&self.job(names), options(1, 64)).0.into_iter().map(|v| v[0]).collect()
    }

    fn one(&self, name: &str) -> f64 {
        self.get(&[name])[0]
    }

    fn name(&self) -> String {
        let Choice { law, drive, method, .. } = &self.choice;
        format!("{law} under {drive} by {}", method.as_deref().unwrap_or("default"))
    }
}

fn outputs() -> Vec<&'static str> {
    Output::ALL.iter().map(|output| output.info().name).collect()
}

/// What the methods are called that a law takes under a drive without a spring.
fn methods(law: &LawEntry, drive: DriveKind) -> Vec<&'static str> {
    let exact = law.linear && drive.is_stepwise();
    let fits = |method: Method| match method {
        Method::Exact => exact,
        Method::RungeKutta => law.kind != Kind::Bristle,
        Method::DormandPrince | Method::DormandPrinceFixed => law.kind == Kind::Dry,
        Method::Rosenbrock | Method::RosenbrockFixed => law.kind != Kind::Dry,
    };
    Method::ALL.iter().filter(|m| fits(m.0)).map(|m| m.1).collect()
}

/// Every law under every drive by every method that fits.
fn everything() -> Vec<Case> {
    let mut all = Vec::new();
    for law in LAWS {
        for drive in DriveKind::ALL {
            for method in methods(law, *drive) {
                all.push(Case::usual(law.info.name, *drive).by(method));
            }
        }
    }
    all
}

/// A quarter of a second of sliding to and fro, with stops: every parameter has a value at
/// which it changes the motion.
fn usual() -> Given {
    ParamId::all().map(|id| (id.param().name, usual_value(id))).collect()
}

fn usual_value(id: ParamId) -> f64 {
    use ParamId::*;
    match id {
        MuStatic => 0.3,
        MuCoulomb => 0.15,
        Segments => 3.0,
        SlopeDeg => 2.0,
        Stroke => 1e-3,
        Viscous => 0.2,
        DriveLimit => 1.6,
        SpeedLimit => 0.2,
        WallForce => 0.5,
        WallRelease => 0.5,
        CornerDeg => 20.0,
        SkinRatio => 1.4,
        Time => 0.1,
        Speed => 0.1,
        LoadFriction => 0.1,
        ViscousLoad => 0.3,
        LoadExponent => 0.8,
        Quadratic => 1.0,
        PowerDrag => 0.5,
        PowerExponent => 1.4,
        StribeckSpeed => 0.02,
        StribeckExponent => 0.9,
        ModelicaDecay => 60.0,
        BristleStiffness => 1e4,
        BristleDamping => 30.0,
        DampingSpeed => 0.1,
        DahlExponent => 1.2,
        ElasticShare => 0.6,
        Attraction => 50.0,
        StiffnessSpread => 2.5,
        DwellTime => 0.05,
        RippleAmplitude => 0.3,
        RippleLength => 3e-3,
        RipplePhaseDeg => 30.0,
        PatchStart => 0.011,
        PatchLength => 2e-3,
        PatchRatio => 1.6,
        TrackLength => 5e-3,
        Track1 => 0.8,
        Track2 => 1.3,
        Track3 => 0.9,
        Track4 => 1.2,
        Track5 => 1.1,
        Track6 => 0.7,
        Buildup => 20.0,
        BuildupRoot => 1.0,
        Snowplough => 2.0,
        MixedSpeed => 0.03,
        MixedExponent => 1.2,
        TransitionSpeed => 0.03,
        Gain => 1.5,
        DriveForce => 0.3,
        DriveAmplitude => 1.5,
        DriveFrequency => 7.0,
        DriveFrequencyEnd => 15.0,
        DrivePhaseDeg => 40.0,
        DriveHarmonics => 5.0,
        DriveRate => 25.0,
        DriveHold => 0.03,
        DrivePeriod => 0.1,
        DriveDuty => 0.6,
        DriveBack => 1.9,
        Duration => 0.25,
        StartPosition => 0.01,
        StartSpeed => 0.05,
        PullSpeed => 0.02,
        JointStiffness => 2e3,
        JointDamping => 20.0,
        Dwell => 0.02,
        Cycles => 2.0,
        _ => id.param().default.unwrap(),
    }
}

/// Samples of a drive that pushes, lets the segment come to rest, just frees it, and pulls.
fn samples() -> (Vec<f64>, Vec<f64>) {
    let times: Vec<f64> = (0..24).map(|i| 0.0117 * f64::from(i)).collect();
    let values = (0..24).map(|i| [0.9, -0.2, -0.2, -0.2, -0.2, 0.53, 0.9, -1.1][i % 8]).collect();
    (times, values)
}

#[track_caller]
fn near(value: f64, expected: f64, relative: f64) {
    let miss = (value - expected).abs();
    assert!(miss <= relative * expected.abs(), "{value} is not {expected}: off by {miss:e}");
}
