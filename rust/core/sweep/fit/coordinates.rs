//! Free values of a model: how far each may go, and what is known about it before; and what
//! they are of a model that is replayed.

use super::experiment::{Experiment, Spot};
use crate::physics::effects::Active;
use nalgebra::{DMatrix, DVector};

/// What a free value of a replayed model is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// A parameter among those of all effects, or its logarithm.
    Parameter { index: usize, log: bool },
    /// A relative change of nominal mass, Coulomb level or gain, or the clock offset.
    Share(usize),
    /// Start speed of a span, beyond that of the nominal model.
    Speed(usize),
    /// Shift of a span's start position.
    Offset(usize),
}

/// The share that is no factor.
const CLOCK: usize = 3;

impl What {
    /// The span that it is about, if it is about one.
    fn span(self) -> Option<usize> {
        match self {
            What::Speed(span) | What::Offset(span) => Some(span),
            What::Parameter { .. } | What::Share(_) => None,
        }
    }

    fn set(self, spot: &mut Spot, value: f64) {
        match self {
            What::Parameter { index, log } => {
                spot.values[index] = if log { value.exp() } else { value };
            }
            What::Share(CLOCK) => spot.shares[CLOCK] = value,
            What::Share(k) => spot.shares[k] = 1.0 + value,
            What::Speed(_) => spot.speed += value,
            What::Offset(_) => spot.offset = value,
        }
    }
}

/// A free value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinate {
    pub low: f64,
    pub high: f64,
    /// A large change.
    pub size: f64,
    /// Deviation around 0 that is known before; infinite where nothing is.
    pub deviation: f64,
}

impl Coordinate {
    /// The known value 0 less `value`, in deviations.
    pub(super) fn prior(&self, value: f64) -> f64 {
        value / self.deviation
    }
}

/// A model that is replayed: its effects, and what each free value is.
#[derive(Debug, Clone, PartialEq)]
pub struct Replayed {
    pub active: Active,
    pub free: Vec<What>,
}

/// A model, its free values, and how well it fits.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit<M = Replayed> {
    pub model: M,
    pub coordinates: Vec<Coordinate>,
    pub theta: DVector<f64>,
    /// Sum of squares, infinite where there is no value; None where it is not known yet.
    pub chi2: Option<f64>,
    pub covariance: Option<DMatrix<f64>>,
    pub damping: f64,
    /// Chi2 above which the fit is of no interest, once derivatives promise no better.
    pub limit: f64,
}

impl Fit {
    /// The model over a span, at some of its values.
    pub(super) fn spot(&self, experiment: &Experiment, theta: &DVector<f64>, span: usize) -> Spot {
        let mut spot = Spot { active: self.model.active, ..experiment.plain(span) };
        for (what, value) in self.model.free.iter().zip(theta.iter()) {
            if what.span().is_none_or(|own| own == span) {
                what.set(&mut spot, *value);
            }
        }
        spot
    }

    /// Coordinates that change a span.
    pub(super) fn acting(&self, span: usize) -> Vec<usize> {
        let acts = |what: &What| what.span().is_none_or(|own| own == span);
        (0..self.model.free.len()).filter(|i| acts(&self.model.free[*i])).collect()
    }
}

impl<M> Fit<M> {
    /// Residuals of what is known before.
    pub(super) fn priors<'a>(&'a self, theta: &'a DVector<f64>) -> impl Iterator<Item = f64> + 'a {
        let known = self.coordinates.iter().zip(theta.iter());
        known.filter(|(c, _)| c.deviation.is_finite()).map(|(c, value)| c.prior(*value))
    }

    /// Widths of finite differences: a fraction of a standard deviation where that is
    /// known. None leads from `theta` beyond a bound above.
    pub(super) fn steps(&self, theta: &DVector<f64>) -> Vec<f64> {
        let width = |(i, coordinate): (usize, &Coordinate)| {
            let size = coordinate.size;
            let variance = self.covariance.as_ref().map_or(f64::NAN, |known| known[(i, i)]);
            let known = variance > 0.0 && variance.is_finite();
            let step = if known { STEP * variance.sqrt() } else { BLIND_STEP * size };
            let step = step.clamp(LEAST_STEP * size, MOST_STEP * size);
            if theta[i] + step > coordinate.high { -step } else { step }
        };
        self.coordinates.iter().enumerate().map(width).collect()
    }
}

/// Finite differences, in standard deviations; in sizes of the coordinate where those are
/// not known, and between these sizes.
const STEP: f64 = 0.3;
const BLIND_STEP: f64 = 1e-3;
const LEAST_STEP: f64 = 1e-7;
const MOST_STEP: f64 = 3e-3;
