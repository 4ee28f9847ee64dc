//! How the trajectories of a sweep are simulated: law, drive and method, chosen
//! once for all of them.

use crate::error::{Error, Result};
use crate::grid::{Axis, Grid};
use crate::integrate::Method;
use crate::integrate::smooth::LAST;
use crate::physics::ParamId;
use crate::physics::drive::{Drive, DriveKind, Table};
use crate::physics::friction::{Kind, LAWS, LawEntry, Parameters};
use crate::physics::point::columns;

/// Most steps over which the drive's shape is worked out ahead: 24 MB.
const MOST_AHEAD: f64 = 1e6;

/// What a user chooses; names as in the registries.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    pub law: String,
    pub drive: String,
    /// Gait of the whole robot.
    pub gait: String,
    /// `None`: the best one for law and drive.
    pub method: Option<String>,
    pub locate: bool,
    /// Whether the motion itself is wanted, of few trajectories.
    pub motion: bool,
    /// Samples of the drive `table`.
    pub times: Vec<f64>,
    pub values: Vec<f64>,
}

impl Default for Choice {
    fn default() -> Self {
        Choice {
            law: "coulomb_viscous".to_owned(),
            drive: "constant".to_owned(),
            gait: "single".to_owned(),
            method: None,
            locate: true,
            motion: false,
            times: Vec::new(),
            values: Vec::new(),
        }
    }
}

/// A checked choice for one grid.
pub struct Simulation {
    pub law: &'static LawEntry,
    /// Index of the law in the registry.
    pub law_index: usize,
    pub drive: DriveKind,
    pub method: Method,
    pub locate: bool,
    /// Whether any trajectory is pulled by a spring.
    pub sprung: bool,
    pub times: Vec<f64>,
    pub values: Vec<f64>,
    /// Largest sample in either direction.
    pub largest: f64,
    /// Shape of the drive over every step, where it is the same for all points.
    pub ahead: Vec<[f64; 3]>,
}

impl Simulation {
    pub fn new(choice: &Choice, grid: &Grid) -> Result<Simulation> {
        let law = LawEntry::parse(&choice.law)?;
        let law_index = LAWS.iter().position(|entry| entry.info.name == law.info.name);
        let drive = DriveKind::parse(&choice.drive)?;
        check_table(drive, choice)?;
        let sprung = [ParamId::SpringStiffness, ParamId::SpringDamping]
            .iter()
            .any(|id| grid.bounds(*id) != Some((0.0, 0.0)));
        let exact = law.linear && drive.is_stepwise() && !sprung;
        let method = match (law.kind, exact) {
            (Kind::Dry, true) => Method::Exact,
            (Kind::Dry, false) if choice.motion => Method::DormandPrince,
            (Kind::Dry, false) => Method::RungeKutta,
            // Smoothing makes laws steep at rest: explicit steps would have to be
            // as short as that.
            (Kind::Smooth | Kind::Bristle, _) => Method::Rosenbrock,
        };
        let method = match choice.method.as_deref() {
            None => method,
            Some(name) => allowed(name, law.kind, exact)?,
        };
        let mut simulation = Simulation {
            law,
            law_index: law_index.unwrap_or(0),
            drive,
            method,
            locate: choice.locate,
            sprung,
            times: choice.times.clone(),
            values: choice.values.clone(),
            largest: choice.values.iter().fold(0.0, |most, value| most.max(value.abs())),
            ahead: Vec::new(),
        };
        if method == Method::RungeKutta
            && law.kind == Kind::Smooth
            && !sprung
            && !drive.has_pieces()
        {
            simulation.look_ahead(grid);
        }
        Ok(simulation)
    }

    pub fn table(&self) -> Table<'_> {
        Table { times: &self.times, values: &self.values }
    }

    /// Names of the parameters that law and drive take.
    pub fn params(&self) -> impl Iterator<Item = &'static str> {
        self.law.info.params.iter().chain(self.drive.info().params).copied()
    }

    fn look_ahead(&mut self, grid: &Grid) {
        let mut names = self.drive.info().params.to_vec();
        // These two scale a shape.
        let scales = [ParamId::DriveForce, ParamId::DriveAmplitude].map(|id| id.param().name);
        names.retain(|name| !scales.contains(name));
        names.extend(["duration", "time_step"]);
        let varies = |name: &&str| {
            let mut members = grid.axes.iter().flat_map(Axis::members);
            members.any(|(id, _)| id.param().name == *name)
        };
        if names.iter().any(varies) {
            return;
        }
        let fixed = Fixed(grid);
        let (duration, h) = (fixed.get(ParamId::Duration), fixed.get(ParamId::TimeStep));
        if duration / h > MOST_AHEAD {
            return;
        }
        let drive = Drive::<f64>::new(self.drive, Table::EMPTY, &fixed);
        let mut t = 0.0;
        while t < duration {
            let left = duration - t;
            let last = left <= h * LAST;
            let dt = if last { left } else { h };
            let at = |t| drive.shape(t);
            self.ahead.push([at(t), at(t + dt * 0.5), at(t + dt)]);
            t = if last { duration } else { (self.ahead.len() as f64).mul_add(h, 0.0) };
        }
    }
}

/// The fixed values of a grid; NaN for its axes.
struct Fixed<'a>(&'a Grid);

impl Parameters<f64> for Fixed<'_> {
    fn get(&self, id: ParamId) -> f64 {
        self.0.fixed[id as usize].map_or(f64::NAN, |value| columns(id, value)[0])
    }
    fn derived(&self, id: ParamId) -> f64 {
        self.0.fixed[id as usize].map_or(f64::NAN, |value| columns(id, value)[1])
    }
}

fn allowed(name: &str, kind: Kind, exact: bool) -> Result<Method> {
    let known = Method::ALL.iter().filter(|(method, _, _)| match method {
        Method::Exact => kind == Kind::Dry && exact,
        Method::RungeKutta => kind != Kind::Bristle,
        Method::DormandPrince | Method::DormandPrinceFixed => kind == Kind::Dry,
        Method::Rosenbrock | Method::RosenbrockFixed => kind != Kind::Dry,
    });
    let known: Vec<_> = known.collect();
    known.iter().find(|m| m.1 == name).map(|m| m.0).ok_or_else(|| Error::BadOption {
        name: "method",
        given: format!("'{name}'"),
        allowed: format!(
            "{} for this law and drive",
            known.iter().map(|m| m.1).collect::<Vec<_>>().join(", ")
        ),
    })
}

fn check_table(drive: DriveKind, choice: &Choice) -> Result<()> {
    let bad = |given: String, allowed: &str| {
        Err(Error::BadOption { name: "table", given, allowed: allowed.to_owned() })
    };
    let (times, values) = (&choice.times, &choice.values);
    if drive != DriveKind::Table {
        return match times.len() + values.len() {
            0 => Ok(()),
            _ => bad("given".to_owned(), "only with drive 'table'"),
        };
    }
    if times.is_empty() || times.len() != values.len() {
        let given = format!("{} times and {} values", times.len(), values.len());
        return bad(given, "as many values as times, at least one");
    }
    for (i, (t, value)) in times.iter().zip(values).enumerate() {
        if !t.is_finite() || !value.is_finite() {
            return bad(format!("({t}, {value}) at index {i}"), "finite numbers");
        }
        if i > 0 && *t <= times[i - 1] {
            return bad(format!("{t} s at index {i} after {} s", times[i - 1]), "times that rise");
        }
    }
    Ok(())
}
