//! The quantities with their compiled kernels, chosen once per sweep.

use super::columns::{Columns, Vary};
use super::gait_outputs::GaitOutput;
use super::kernel::{Dense, Extremum, Rivals};
use super::outputs::Output;
use crate::describe::{Info, nearest};
use crate::error::{Error, Result};
use crate::for_each_quantity;
use crate::lane::{Level, run};
use crate::physics::closed_form::*;
use crate::physics::{PARAMS, ParamId, Point, Quantity, Status};
use std::marker::PhantomData;
use std::sync::LazyLock;

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

/// A quantity as the engine sees it.
pub struct Entry {
    pub info: Info,
    pub used: u128,
    pub way: Way,
}

/// How a quantity is computed.
#[derive(Clone, Copy)]
pub enum Way {
    Closed(Closed),
    /// By simulating the trajectory of one segment.
    Run(Output),
    /// By simulating the whole robot.
    Gait(GaitOutput),
}

/// The kernels of a closed form.
#[derive(Clone, Copy)]
pub struct Closed {
    pub score_power: f64,
    pub score_floor: f64,
    pub status: fn(&Point<f64>) -> Status,
    pub dense: fn(Level, Points, &mut [f64], bool),
    /// Best segment count of plain points that vary in the main parameters.
    pub extremum: fn(Level, Search, &mut [f64], &mut [f64]),
}

/// The points that a dense kernel is called for.
#[derive(Clone, Copy)]
pub struct Points<'a> {
    pub columns: Columns<'a>,
    pub plain: bool,
    pub vary: Vary,
}

/// Arguments of a search for the best rival.
pub struct Search<'a> {
    pub columns: Columns<'a>,
    pub rivals: Rivals<'a>,
    pub ahead: f64,
    pub min: bool,
}

impl Entry {
    const fn of<Q: Quantity>() -> Entry {
        let closed = Closed {
            score_power: Q::SCORE_POWER,
            score_floor: Q::SCORE_FLOOR,
            status: Q::status,
            dense: dense::<Q>,
            extremum: extremum::<Q>,
        };
        Entry { info: Q::INFO, used: used_by(Q::INFO.params), way: Way::Closed(closed) }
    }

    fn of_run(output: Output) -> Entry {
        let info = output.info();
        Entry { info, used: used_by(info.params), way: Way::Run(output) }
    }

    fn of_gait(output: GaitOutput) -> Entry {
        let info = output.info();
        Entry { info, used: used_by(info.params), way: Way::Gait(output) }
    }

    pub fn closed(&self) -> Option<&Closed> {
        match &self.way {
            Way::Closed(closed) => Some(closed),
            Way::Run(_) | Way::Gait(_) => None,
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

fn dense<Q: Quantity>(level: Level, points: Points, out: &mut [f64], streamed: bool) {
    const NARROW: u8 = Vary::SLOPE_AND_SEGMENTS;
    const MAIN: u8 = Vary::MAIN;
    const ANY: u8 = Vary::ANY;
    let quantity = PhantomData::<Q>;
    let Points { columns, plain, vary } = points;
    match (plain, vary) {
        (true, Vary::SlopeAndSegments) => {
            run(level, Dense::<Q, true, NARROW> { columns, out, streamed, quantity })
        }
        (true, Vary::Main) => {
            run(level, Dense::<Q, true, MAIN> { columns, out, streamed, quantity })
        }
        _ => run(level, Dense::<Q, false, ANY> { columns, out, streamed, quantity }),
    }
}

fn extremum<Q: Quantity>(level: Level, search: Search, best: &mut [f64], at: &mut [f64]) {
    let Search { columns, rivals, ahead, min } = search;
    let quantity = PhantomData::<Q>;
    if min {
        run(level, Extremum::<Q, true> { columns, rivals, ahead, best, at, quantity });
    } else {
        run(level, Extremum::<Q, false> { columns, rivals, ahead, best, at, quantity });
    }
}

macro_rules! entries {
    ($($quantity:ident),+ $(,)?) => {
        const CLOSED: &[Entry] = &[$(Entry::of::<$quantity>()),+];
    };
}
for_each_quantity!(entries);

/// Closed forms first, then what simulated segments and robots give.
pub static QUANTITIES: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    let runs = Output::ALL.iter().map(|output| Entry::of_run(*output));
    let gaits = GaitOutput::ALL.iter().map(|output| Entry::of_gait(*output));
    CLOSED.iter().map(|entry| Entry { ..*entry }).chain(runs).chain(gaits).collect()
});
