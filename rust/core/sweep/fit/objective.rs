//! What fits are compared with: replays of measured runs, the equation error, or a law's force.

use super::compared::{Asked, Compared};
use super::coordinates::{Fit, Replayed};
use super::derivatives::compared;
use super::job::How;
use super::misfit::Misfit;
use crate::error::Result;

/// Something that models are compared with.
pub trait Objective {
    /// What a fit says of its model beside the values of its coordinates.
    type Model;

    /// Sums of squares of models, what is known of their values before included.
    fn compare(&self, asked: &[Asked<Self::Model>], how: &How) -> Result<Vec<Compared>>;

    /// At how many of `trials` values of a fit derivatives cost nothing beside the evaluation of
    /// all of them.
    fn room(&self, fit: &Fit<Self::Model>, trials: usize) -> usize;

    /// Samples that one evaluation takes.
    fn samples(&self) -> u64;

    /// Samples that the derivatives of a fit take beyond.
    fn samples_of_derivatives(&self, fit: &Fit<Self::Model>) -> u64;
}

/// Replays of some spans.
pub struct OverSpans<'a> {
    pub misfit: &'a Misfit,
    pub spans: &'a [usize],
}

/// Trajectories of a pack of replays, at every level that has vectors (`EIGHT_LANES` of
/// `replay/packs.rs`): fewer take as long.
const LANES: usize = 8;

impl Objective for OverSpans<'_> {
    type Model = Replayed;

    fn compare(&self, asked: &[Asked], how: &How) -> Result<Vec<Compared>> {
        compared(self.misfit, asked, self.spans, how)
    }

    fn room(&self, fit: &Fit, trials: usize) -> usize {
        let acting = self.spans.iter().map(|span| fit.acting(*span).len()).max().unwrap_or(0);
        (LANES.saturating_sub(trials) / acting.max(1)).min(trials)
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
