//! What small forces along a motion, or errors of its readings, change of whitened residuals.

use super::super::replay::{finished, spread_over};
use super::job::How;
use super::misfit::{Measured, Misfit, Source};
use super::rows::Project;
use crate::error::Result;
use crate::integrate::linear_response::{Slides, linear_responses};
use crate::lane::{Pack, Task, run};
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};

/// Terms that are worked out side by side: two vectors of the widest level that is used here, so
/// that one does not wait for the other. Changes no bit; not tuned.
const TERMS: usize = 8;

/// Terms at the samples of some spans, one span after another.
#[derive(Clone, Copy)]
pub enum Terms<'a> {
    /// Forces on a head that moves so.
    Forces(Slides<'a>),
    /// Errors of the position that is read.
    Readings,
}

/// Changes of residuals over some spans under terms, in the form of `Misfit::residuals`: each into
/// the front of a row of `to`.
pub fn corrections(
    misfit: &Misfit,
    terms: &[&[f64]],
    what: Terms,
    spans: &[usize],
    how: &How,
    to: &mut [&mut [f64]],
) -> Result<()> {
    let decays = match what {
        Terms::Forces(motion) => motion.decays(),
        Terms::Readings => vec![],
    };
    let queue = Mutex::new(terms.chunks(TERMS).zip(to.chunks_mut(TERMS)));
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let take = || {
        let mut rows = Vec::new();
        while let Some((terms, to)) = next() {
            let mut first = 0;
            for (rank, span) in spans.iter().enumerate() {
                if how.control.cancel.load(Ordering::Relaxed) {
                    return;
                }
                let measured = &misfit.measured[*span];
                let rows = &mut rows;
                let (sources, decays) = (&misfit.sources[..], &decays[..]);
                run(how.level, Weigh { measured, sources, terms, what, decays, first, rows });
                for (row, to) in rows.chunks_exact_mut(measured.stride()).zip(&mut *to) {
                    run(how.level, Project { measured, row });
                    misfit.place(row, spans, rank, to);
                }
                first += measured.samples;
            }
        }
    };
    spread_over(how.threads.min(terms.len().div_ceil(TERMS)), take)?;
    finished(how.control, terms.len())
}

/// Terms over one span, whose samples begin at the `first` of all, as rows of weighted changes.
struct Weigh<'a> {
    measured: &'a Measured,
    sources: &'a [Source],
    /// At most `TERMS`.
    terms: &'a [&'a [f64]],
    what: Terms<'a>,
    decays: &'a [f64],
    first: usize,
    /// One for each term.
    rows: &'a mut Vec<f64>,
}

impl Task for Weigh<'_> {
    type Output = ();
    const AVX2_AT_MOST: bool = true;

    #[inline(always)]
    fn run<P: Pack>(self, _: P::Token) {
        let Weigh { measured, sources, terms, what, decays, first, rows } = self;
        let stride = measured.stride();
        rows.clear();
        rows.resize(terms.len() * stride, 0.0);
        let channel = |part| {
            let of = |source: &Source| *source == Source::Replayed(part);
            sources.iter().position(of).map(|c| c * measured.padded)
        };
        let (of_x, of_v) = (channel(0), channel(1));
        let own = first..first + measured.samples;
        match what {
            Terms::Readings => {
                let Some(at) = of_x else { return };
                let weights = &measured.weights[at..at + own.len()];
                for (row, term) in rows.chunks_exact_mut(stride).zip(terms) {
                    let changes = term[own.clone()].iter().zip(weights);
                    for (e, (change, weight)) in row[at..].iter_mut().zip(changes) {
                        *e = change * weight;
                    }
                }
            }
            Terms::Forces(motion) => {
                let mut write = |at: Option<usize>, i: usize, changes: &[f64]| {
                    let Some(at) = at else { return };
                    let weight = measured.weights[at + i];
                    for (k, change) in changes.iter().enumerate() {
                        rows[k * stride + at + i] = change * weight;
                    }
                };
                // What is missing of the last ones is a term again, and is not read.
                let forces = std::array::from_fn(|k| terms[k.min(terms.len() - 1)]);
                linear_responses::<TERMS>(
                    motion,
                    decays,
                    own,
                    forces,
                    #[inline(always)]
                    |i, x, v| {
                        write(of_x, i - first, &x[..terms.len()]);
                        write(of_v, i - first, &v[..terms.len()]);
                    },
                );
            }
        }
    }
}
