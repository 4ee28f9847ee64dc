//! The closed forms with their compiled kernels, chosen once per sweep.

use crate::columns::{Columns, Vary};
use crate::describe::Info;
use crate::kernel::{Dense, Extremum, Rivals};
use crate::lane::{Level, run};
use crate::physics::closed_form::*;
use crate::physics::{Point, Quantity, Status, for_each_quantity};
use std::marker::PhantomData;

/// The kernels of a closed form.
#[derive(Clone, Copy)]
pub struct Closed {
    pub info: Info,
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

impl Closed {
    const fn of<Q: Quantity>() -> Closed {
        Closed {
            info: Q::INFO,
            score_power: Q::SCORE_POWER,
            score_floor: Q::SCORE_FLOOR,
            status: Q::status,
            dense: dense::<Q>,
            extremum: extremum::<Q>,
        }
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

macro_rules! all {
    ($($quantity:ident),+ $(,)?) => {
        /// In the order of the registry; static, so that they are compiled here and not
        /// by who asks.
        pub static CLOSED: &[Closed] = &[$(Closed::of::<$quantity>()),+];
    };
}
for_each_quantity!(all);
