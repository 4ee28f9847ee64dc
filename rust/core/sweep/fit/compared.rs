//! What is asked about a model, and the answer: how far it is off, and how that changes.

use super::coordinates::{Fit, Replayed};
use nalgebra::{DMatrix, DVector};

/// A model to compare, at some values of its coordinates.
pub struct Asked<'a, M = Replayed> {
    pub fit: &'a Fit<M>,
    pub theta: DVector<f64>,
    /// Whether derivatives are asked for, too.
    pub slopes: bool,
}

impl Asked<'_> {
    /// Sum of squares with that of what is known of the values before, infinite where there is none.
    pub(super) fn chi2(&self, squares: f64) -> f64 {
        let prior: f64 = self.fit.priors(&self.theta).map(|e| e * e).sum();
        let chi2 = squares + prior;
        if chi2.is_finite() { chi2 } else { f64::INFINITY }
    }
}

/// How far a model is off, and its derivatives if they were asked for.
pub struct Compared {
    pub chi2: f64,
    pub normal: Option<Normal>,
}

/// Products of the derivatives of a fit's residuals.
pub struct Normal {
    pub matrix: DMatrix<f64>,
    /// Half the gradient of chi2.
    pub gradient: DVector<f64>,
}

/// Products with what is known of a fit's values before.
pub(super) fn with_priors(asked: &Asked, mut normal: Normal) -> Normal {
    for (j, coordinate) in asked.fit.coordinates.iter().enumerate() {
        if coordinate.deviation.is_finite() {
            normal.matrix[(j, j)] += coordinate.deviation.powi(-2);
            normal.gradient[j] += coordinate.prior(asked.theta[j]) / coordinate.deviation;
        }
    }
    normal
}
