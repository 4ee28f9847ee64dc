//! What every registered quantity promises, whatever it computes.

mod hostile;
mod names;
mod points;
#[path = "../common/random.rs"]
mod random;
mod records;

use locosweep::Error;
use locosweep::describe::Param;
use locosweep::lane::Level;
use locosweep::physics::closed_form::*;
use locosweep::physics::drive::DriveKind;
use locosweep::physics::effects::EFFECTS;
use locosweep::physics::friction::LAWS;
use locosweep::physics::point::{COLUMNS, columns};
use locosweep::physics::{PARAMS, ParamId, Point, Quantity, Status};
use locosweep::sweep::{
    Buffer, Choice, Control, Entry, Grid, Job, Options, QUANTITIES, Reduce, Request, run,
};
use proptest::prelude::*;
use random::Random;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// A quantity's scalar functions.
struct Formula {
    name: &'static str,
    params: &'static [&'static str],
    general: fn(&Point<f64>) -> f64,
    plain: fn(&Point<f64>) -> f64,
    status: fn(&Point<f64>) -> Status,
}

fn formula<Q: Quantity>() -> Formula {
    Formula {
        name: Q::INFO.name,
        params: Q::INFO.params,
        general: Q::value::<f64, false>,
        plain: Q::value::<f64, true>,
        status: Q::status,
    }
}

macro_rules! formulas {
    ($($quantity:ident),+ $(,)?) => { vec![$(formula::<$quantity>()),+] };
}

/// Formulas of one point; what is simulated stands beside them.
fn closed() -> impl Iterator<Item = &'static Entry> {
    QUANTITIES.iter().filter(|entry| entry.closed().is_some())
}

fn formulas() -> Vec<Formula> {
    locosweep::for_each_quantity!(formulas)
}

impl Formula {
    fn uses(&self, id: ParamId) -> bool {
        self.params.contains(&id.param().name)
    }

    /// The value as the engine computes it: what is not declared is NaN.
    fn value(&self, values: &Values) -> f64 {
        (self.general)(&values.point(|id| self.uses(id)))
    }
}

/// One number per parameter.
#[derive(Debug, Clone)]
struct Values(Vec<f64>);

impl Values {
    fn point(&self, uses: impl Fn(ParamId) -> bool) -> Point<f64> {
        let mut all = [f64::NAN; COLUMNS];
        for id in ParamId::all().filter(|id| uses(*id)) {
            [all[id.main()], all[id.derived()]] = columns(id, self.0[id as usize]);
        }
        Point::gather(|c| all[c])
    }

    fn named(&self) -> Vec<(&'static str, f64)> {
        PARAMS.iter().zip(&self.0).map(|(p, v)| (p.name, *v)).collect()
    }
}

impl Random {
    /// A value that robots have.
    fn usual(&mut self, id: ParamId) -> f64 {
        use ParamId::*;
        match id {
            MuStatic => self.log(0.1, 2.0),
            MuCoulomb => self.log(0.02, 1.0),
            Segments => (2.0 + 18.0 * self.unit()).floor(),
            SlopeDeg => -15.0 + 40.0 * self.unit(),
            Mass => self.log(0.05, 5.0),
            Gravity => self.log(1.0, 20.0),
            Stroke => self.log(1e-3, 0.2),
            Viscous => {
                if self.unit() < 0.4 {
                    0.0
                } else {
                    self.log(0.01, 100.0)
                }
            }
            Moving => (1.0 + 3.0 * self.unit()).floor(),
            AnchorWeight | WallRelease => self.unit(),
            DriveLimit => {
                if self.unit() < 0.4 {
                    f64::INFINITY
                } else {
                    self.log(0.1, 100.0)
                }
            }
            SpeedLimit => {
                if self.unit() < 0.4 {
                    f64::INFINITY
                } else {
                    self.log(1e-3, 1.0)
                }
            }
            AnchorsAhead => (3.0 * self.unit()).floor(),
            Brake | CoulombTerm => (2.0 * self.unit()).floor(),
            SkinRatio => self.log(0.5, 3.0),
            WallForce => {
                if self.unit() < 0.4 {
                    0.0
                } else {
                    self.log(0.01, 20.0)
                }
            }
            CornerDeg => 60.0 * self.unit(),
            Time => self.log(1e-3, 10.0),
            Speed => -1.0 + 2.0 * self.unit(),
            SegmentsMin => (1.0 + 9.0 * self.unit()).floor(),
            SegmentsMax => (10.0 + 50.0 * self.unit()).floor(),
            // No formula takes them: what a formula takes must vary, or it would
            // seem without effect.
            _ => id.param().default.unwrap_or(1.0),
        }
    }

    /// Anything the registry allows, its ends and extremes among them.
    fn allowed(&mut self, id: ParamId) -> f64 {
        let param = id.param();
        let (low, high) = param.range;
        let top = if high.is_infinite() { 1e30 } else { high };
        let sign = if low < 0.0 && self.unit() < 0.5 { -1.0 } else { 1.0 };
        let size = match self.unit() {
            u if u < 0.35 => return self.usual(id),
            u if u < 0.45 => return self.pick(&[low, high, param.default.unwrap_or(low)]),
            u if u < 0.55 => self.log(1e-30, top),
            _ => self.log(low.clamp(1e-9, 1.0), top),
        };
        let value = (sign * size).clamp(low, high);
        if param.integer { value.floor().max(low) } else { value }
    }

    fn values(&mut self, mut one: impl FnMut(&mut Random, ParamId) -> f64) -> Values {
        Values(ParamId::all().map(|id| one(self, id)).collect())
    }
}
