//! The quantities with their compiled kernels, chosen once per sweep.

use super::gait_outputs::GaitOutput;
use crate::cells::closed::{CLOSED, Closed};
use crate::describe::{Info, nearest};
use crate::error::{Error, Result};
use crate::physics::ParamId;
use crate::physics::params::used_by;
use crate::simulate::outputs::Output;
use std::sync::LazyLock;

/// A quantity as the engine sees it.
pub struct Entry {
    pub info: Info,
    pub used: u128,
    pub evaluation: Evaluation,
}

/// How a quantity is computed.
#[derive(Clone, Copy)]
pub enum Evaluation {
    Closed(Closed),
    /// By simulating the trajectory of one segment.
    Trajectory(Output),
    /// By simulating the whole robot.
    Gait(GaitOutput),
}

impl Entry {
    fn of_closed(closed: &Closed) -> Entry {
        Entry {
            info: closed.info,
            used: used_by(closed.info.params),
            evaluation: Evaluation::Closed(*closed),
        }
    }

    fn of_run(output: Output) -> Entry {
        let info = output.info();
        Entry { info, used: used_by(info.params), evaluation: Evaluation::Trajectory(output) }
    }

    fn of_gait(output: GaitOutput) -> Entry {
        let info = output.info();
        Entry { info, used: used_by(info.params), evaluation: Evaluation::Gait(output) }
    }

    pub fn closed(&self) -> Option<&Closed> {
        match &self.evaluation {
            Evaluation::Closed(closed) => Some(closed),
            Evaluation::Trajectory(_) | Evaluation::Gait(_) => None,
        }
    }

    pub fn uses(&self, id: ParamId) -> bool {
        self.used >> (id as usize) & 1 == 1
    }

    pub fn parse(name: &str) -> Result<&'static Entry> {
        let names = || QUANTITIES.iter().map(|q| q.info.name);
        QUANTITIES.iter().find(|q| q.info.name == name).ok_or_else(|| Error::UnknownName {
            kind: "quantity",
            given: name.to_owned(),
            nearest: nearest(name, names()).map(str::to_owned),
            known: names().map(str::to_owned).collect(),
        })
    }
}

/// Closed forms first, then what simulated segments and robots give.
pub static QUANTITIES: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    let runs = Output::ALL.iter().map(|output| Entry::of_run(*output));
    let gaits = GaitOutput::ALL.iter().map(|output| Entry::of_gait(*output));
    CLOSED.iter().map(Entry::of_closed).chain(runs).chain(gaits).collect()
});
