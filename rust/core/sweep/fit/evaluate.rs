//! Models at given values: how far they are from what was measured.

use super::super::replay::{Part, replay_into};
use super::coordinates::Fit;
use super::experiment::{Experiment, Point, Spot};
use super::job::{How, Request, replayed};
use super::misfit::{Measured, Misfit};
use super::rows::{Product, Reading, Whiten, whiten};
use crate::error::Result;
use crate::replays::packs::Column;
use nalgebra::DVector;

/// Requests of one replay each, of every model over every span.
fn each(spans: &[usize], count: usize, spot: impl Fn(usize, usize) -> Spot) -> Vec<Request> {
    let models = 0..count;
    let every = models.flat_map(|i| spans.iter().map(move |span| (i, *span)));
    every.map(|(i, span)| Request::new(span, &spot(i, span), 1)).collect()
}

/// Chi2 of a model, infinite where it has no value, and its residuals where they are kept.
pub struct Evaluated {
    pub chi2: f64,
    /// As in `residuals`, and last those of what is known before.
    pub residual: Option<Vec<f64>>,
}

/// Models at values of a fit's coordinates, over some spans.
pub fn evaluate(
    misfit: &Misfit,
    models: &[(&Fit, DVector<f64>)],
    spans: &[usize],
    keep: bool,
    how: &How,
) -> Result<Vec<Evaluated>> {
    let experiment = &*misfit.experiment;
    let spot = |i: usize, span: usize| models[i].0.spot(experiment, &models[i].1, span);
    let requests = each(spans, models.len(), spot);
    let parts = replayed(
        misfit,
        &requests,
        |i, to| to.push(spot(i / spans.len(), requests[i].span)),
        how,
        |i, columns, rows| {
            let measured = &misfit.measured[requests[i].span];
            let work = misfit.whiten(measured, columns, Product::Squares { keep }, rows);
            let square = whiten(how.level, work)[0];
            (square, keep.then(|| rows.clone()))
        },
    )?;
    let total = |(i, (fit, theta)): (usize, &(&Fit, DVector<f64>))| {
        let own = &parts[i * spans.len()..(i + 1) * spans.len()];
        let prior: f64 = fit.priors(theta).map(|e| e * e).sum();
        let chi2 = own.iter().map(|(square, _)| square).sum::<f64>() + prior;
        let residual = keep.then(|| {
            let mut residual = vec![0.0; misfit.residuals(spans)];
            for (rank, row) in own.iter().map(|(_, row)| row).enumerate() {
                misfit.place(row.as_deref().unwrap_or_default(), spans, rank, &mut residual);
            }
            residual.extend(fit.priors(theta));
            residual
        });
        Evaluated { chi2: if chi2.is_finite() { chi2 } else { f64::INFINITY }, residual }
    };
    Ok(models.iter().enumerate().map(total).collect())
}

/// Whitened residuals of models over some spans, a row of `Misfit::residuals` each, into
/// `to`. Shifts move by at most as many deviations.
pub fn residuals(
    misfit: &Misfit,
    points: &[Point],
    spans: &[usize],
    most: f64,
    how: &How,
    to: &mut [f64],
) -> Result<()> {
    let spot = |i: usize, span: usize| points[i].spot(span);
    let requests = each(spans, points.len(), spot);
    let length = misfit.residuals(spans);
    let found = replayed(
        misfit,
        &requests,
        |i, to| to.push(spot(i / spans.len(), requests[i].span)),
        how,
        |i, columns, rows| {
            let measured = &misfit.measured[requests[i].span];
            let work = misfit.whiten(measured, columns, Product::Rows, rows);
            whiten(how.level, Whiten { most, ..work });
            rows.clone()
        },
    )?;
    for (i, row) in found.iter().enumerate() {
        let (point, rank) = (i / spans.len(), i % spans.len());
        misfit.place(row, spans, rank, &mut to[point * length..(point + 1) * length]);
    }
    Ok(())
}

/// Readings of models over some spans into `to`, each with the samples of all spans of all
/// models, or empty where it is not asked for; starts of spans are `moved` by position and speed.
pub fn readings(
    experiment: &Experiment,
    points: &[Point],
    spans: &[usize],
    moved: Option<&[(f64, f64)]>,
    how: &How,
    to: Part,
) -> Result<()> {
    let pairs = points.iter().flat_map(|point| spans.iter().map(move |span| (point, *span)));
    let made: Vec<(Column, f64)> = pairs
        .map(|(point, span)| {
            let (mut column, added) = experiment.column(span, &point.spot(span));
            let (dx, dv) = moved.map_or((0.0, 0.0), |moved| moved[span]);
            column.start = (column.start.0 + dx, column.start.1 + dv);
            (column, added)
        })
        .collect();
    let columns: Vec<Column> = made.iter().map(|(column, _)| column.clone()).collect();
    let [x, v, x_rear, force] = to;
    replay_into(
        &experiment.nominal,
        &experiment.runs,
        &columns,
        (how.level, how.threads),
        how.control,
        [&mut *x, v, x_rear, force],
    )?;
    if x.is_empty() {
        return Ok(());
    }
    let mut first = 0;
    for (column, added) in &made {
        let last = first + column.window.1 - column.window.0;
        if *added != 0.0 {
            x[first..last].iter_mut().for_each(|x| *x += added);
        }
        first = last;
    }
    Ok(())
}

impl Misfit {
    pub(super) fn whiten<'a>(
        &'a self,
        measured: &'a Measured,
        columns: &'a [Reading<'a>],
        product: Product<'a>,
        rows: &'a mut Vec<f64>,
    ) -> Whiten<'a> {
        let (sources, motor) = (&self.sources[..], self.experiment.motor.as_ref());
        Whiten { measured, sources, motor, columns, most: f64::INFINITY, product, rows }
    }
}
