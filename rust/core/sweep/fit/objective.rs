//! What fits are compared with: replays of measured runs, or the equation error.

use super::coordinates::Fit;
use super::derivatives::{Normal, normals};
use super::evaluate::chi2;
use super::job::How;
use super::misfit::Misfit;
use crate::error::Result;
use nalgebra::DVector;

/// Something that models are compared with.
pub trait Objective {
    /// Sums of squares of models at values of a fit's coordinates, what is known of these
    /// before included.
    fn chi2(&self, models: &[(&Fit, DVector<f64>)], how: &How) -> Result<Vec<f64>>;

    /// Normal matrices and gradients of fits at their values.
    fn normals(&self, fits: &[&Fit], how: &How) -> Result<Vec<Normal>>;

    /// Samples that one evaluation takes.
    fn samples(&self) -> u64;

    /// Samples that the derivatives of a fit take beyond.
    fn samples_of_derivatives(&self, fit: &Fit) -> u64;
}

/// Replays of some spans.
pub struct OverSpans<'a> {
    pub misfit: &'a Misfit,
    pub spans: &'a [usize],
}

impl Objective for OverSpans<'_> {
    fn chi2(&self, models: &[(&Fit, DVector<f64>)], how: &How) -> Result<Vec<f64>> {
        chi2(self.misfit, models, self.spans, how)
    }

    fn normals(&self, fits: &[&Fit], how: &How) -> Result<Vec<Normal>> {
        normals(self.misfit, fits, self.spans, how)
    }

    fn samples(&self) -> u64 {
        self.misfit.experiment.samples(self.spans) as u64
    }

    fn samples_of_derivatives(&self, fit: &Fit) -> u64 {
        let over = |span: &usize| {
            fit.acting(*span).len() * self.misfit.experiment.samples(std::slice::from_ref(span))
        };
        self.spans.iter().map(|span| over(span) as u64).sum()
    }
}
