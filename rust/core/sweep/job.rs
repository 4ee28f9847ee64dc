//! A job: a checked grid, what to compute on it, and how much memory that takes.

use super::reduce::Reduce;
use super::registry::{Entry, Evaluation};
use crate::cells::columns::{Layout, PADDING};
use crate::cells::grid::{Axis, Grid};
use crate::error::{Error, Result};
use crate::integrate::robot::{STRIBECK, stribeck_needs_its_term};
use crate::physics::point::{COLUMNS, columns};
use crate::physics::{Gait, ParamId};
use crate::simulate::simulation::{Choice, Simulation};

/// One quantity, reduced along the job's reduced axis or not.
pub struct Request {
    pub entry: &'static Entry,
    pub reduce: Option<Reduce>,
}

pub struct Job {
    pub grid: Grid,
    pub requests: Vec<Request>,
    pub(super) over: Option<usize>,
    pub(super) layout: Layout,
    pub(super) fixed: [f64; COLUMNS],
    /// The reduced axis as columns.
    pub(super) rivals: [Vec<f64>; 2],
    /// Its indices, 0, 1, 2, ..., as the kernels count them.
    pub(super) indices: Vec<f64>,
    pub(super) plain: bool,
    /// For quantities that are simulated.
    pub(super) simulation: Option<Simulation>,
    /// For quantities of whole robots.
    pub(super) gait: Option<Gait>,
    cells: usize,
    evaluations: u64,
}

impl Job {
    /// `over` names the reduced axis; every request then needs a reduction, and
    /// none may have one without it.
    pub fn new(
        grid: Grid,
        requests: Vec<Request>,
        over: Option<&str>,
        choice: &Choice,
    ) -> Result<Job> {
        let is_run =
            |request: &Request| matches!(request.entry.evaluation, Evaluation::Trajectory(_));
        let is_gait = |request: &Request| matches!(request.entry.evaluation, Evaluation::Gait(_));
        let gait = match requests.iter().any(is_gait) {
            true => Some(Gait::parse(&choice.gait)?),
            false => None,
        };
        let simulation = match requests.iter().any(is_run) {
            true => Some(Simulation::new(choice, &grid)?),
            false => None,
        };
        let names = || grid.axes.iter().map(|a| a.id.param().name.to_owned()).collect::<Vec<_>>();
        let over = match over {
            None => None,
            Some(name) => {
                let id = ParamId::parse(name)?;
                let is_it = |axis: &Axis| axis.id == id && axis.linked.is_empty();
                let position = grid.axes.iter().position(is_it);
                Some(position.ok_or(Error::NotAnAxis { axis: name.to_owned(), axes: names() })?)
            }
        };
        if gait.is_some() && simulation.is_none() {
            // A fixed value may be there for other sweeps; an axis is there to be seen.
            let axis = |id| grid.along(id).unwrap_or_default();
            let fixed = grid.fixed[ParamId::StribeckTerm as usize];
            if !axis(ParamId::StribeckTerm).iter().chain(&fixed).any(|on| *on > 0.0) {
                for id in STRIBECK {
                    stribeck_needs_its_term(*id, axis(*id).iter().copied())?;
                }
            }
        }
        for request in &requests {
            if over.is_some() != request.reduce.is_some() {
                return Err(Error::BadOption {
                    name: "reduce",
                    given: if over.is_some() { "missing" } else { "given without 'over'" }
                        .to_owned(),
                    allowed: "'over' (the axis) and 'reduce' (how) go together".to_owned(),
                });
            }
            for id in ParamId::all() {
                let missing = grid.along(id).is_none() && grid.fixed[id as usize].is_none();
                let simulated = simulation.as_ref().filter(|_| is_run(request));
                let taken = || simulated.is_some_and(|s| s.params().any(|p| p == id.param().name));
                if missing && (request.entry.uses(id) || taken()) {
                    return Err(Error::MissingParameter {
                        name: id.param().name.to_owned(),
                        quantity: request.entry.info.name.to_owned(),
                    });
                }
            }
        }
        let mut fixed = [f64::NAN; COLUMNS];
        for id in ParamId::all() {
            if let Some(value) = grid.fixed[id as usize] {
                [fixed[id.main()], fixed[id.derived()]] = columns(id, value);
            }
        }
        let mut rivals = [Vec::new(), Vec::new()];
        if let Some(over) = over {
            let axis = &grid.axes[over];
            for value in &axis.values {
                let pair = columns(axis.id, *value);
                rivals[0].push(pair[0]);
                rivals[1].push(pair[1]);
            }
        }
        let indices = (0..rivals[0].len()).map(|index| index as f64).collect();
        let kept = kept(&grid, over);
        let cells = kept.iter().map(|axis| axis.values.len()).product();
        let points = grid.points()? as u64;
        let evaluations = points.saturating_mul(requests.len() as u64);
        // Without requests a job only checks its grid.
        let layout = if requests.is_empty() { Layout::new(&[]) } else { Layout::new(&kept) };
        let plain = grid.is_plain();
        Ok(Job {
            simulation,
            gait,
            layout,
            plain,
            cells,
            evaluations,
            over,
            fixed,
            rivals,
            indices,
            requests,
            grid,
        })
    }

    /// The axes of the result, in order.
    pub fn kept(&self) -> Vec<&Axis> {
        kept(&self.grid, self.over)
    }

    pub fn shape(&self) -> Vec<usize> {
        self.kept().iter().map(|axis| axis.values.len()).collect()
    }

    /// Cells of the result.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// How often a formula is evaluated.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Gait in use, where whole robots are simulated.
    pub fn gait(&self) -> Option<&'static str> {
        self.gait.map(Gait::name)
    }

    /// Law, drive and method in use, where trajectories are simulated.
    pub fn choice(&self) -> Option<(&'static str, &'static str, &'static str)> {
        let used = self.simulation.as_ref()?;
        Some((used.law.info.name, used.drive.info().name, used.method.name()))
    }

    /// Whether trajectories are simulated, each of which takes its time.
    pub fn simulates(&self) -> bool {
        self.simulation.is_some() || self.gait.is_some()
    }

    pub(super) fn rival_count(&self) -> usize {
        self.rivals[0].len()
    }

    /// Bytes needed beside the results: expanded axes and, for quantiles, the
    /// rivals of a pack of cells per thread.
    pub fn working_bytes(&self, threads: usize) -> usize {
        let quantile = self.requests.iter().any(|r| matches!(r.reduce, Some(Reduce::Quantile(_))));
        let trace = if quantile { self.rival_count() * PADDING * size_of::<f64>() } else { 0 };
        Layout::bytes(&self.kept()).saturating_add(threads.saturating_mul(trace))
    }
}

fn kept(grid: &Grid, over: Option<usize>) -> Vec<&Axis> {
    grid.axes.iter().enumerate().filter(|(i, _)| Some(*i) != over).map(|(_, axis)| axis).collect()
}
