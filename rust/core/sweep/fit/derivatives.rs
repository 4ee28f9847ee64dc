//! Derivatives of residuals by one-sided differences, summed up over samples where they
//! arise.

use super::compared::{Asked, Compared, Normal, with_priors};
use super::coordinates::Fit;
use super::experiment::Spot;
use super::job::{How, Request, replayed};
use super::misfit::Misfit;
use super::rows::{Product, Reading, whiten};
use crate::error::Result;
use nalgebra::{DMatrix, DVector};

/// A request for each model and span: its own values, and where slopes are asked for, each that
/// acts there moved.
struct Moved<'a> {
    misfit: &'a Misfit,
    asked: &'a [Asked<'a>],
    spans: &'a [usize],
    steps: Vec<Vec<f64>>,
    requests: Vec<Request>,
}

impl Moved<'_> {
    fn new<'a>(misfit: &'a Misfit, asked: &'a [Asked<'a>], spans: &'a [usize]) -> Moved<'a> {
        let experiment = &*misfit.experiment;
        let steps = asked.iter().map(|one| one.fit.steps(&one.theta)).collect();
        let every = asked.iter().flat_map(|one| spans.iter().map(move |span| (one, *span)));
        let requests = every
            .map(|(one, span)| {
                let spot = one.fit.spot(experiment, &one.theta, span);
                let moved = if one.slopes { one.fit.acting(span).len() } else { 0 };
                Request::new(span, &spot, 1 + moved)
            })
            .collect();
        Moved { misfit, asked, spans, steps, requests }
    }

    fn asked(&self, request: usize) -> &Asked<'_> {
        &self.asked[request / self.spans.len()]
    }

    fn spots(&self, request: usize, to: &mut Vec<Spot>) {
        let (Asked { fit, theta, slopes }, span) =
            (self.asked(request), self.requests[request].span);
        let experiment = &*self.misfit.experiment;
        to.push(fit.spot(experiment, theta, span));
        for i in fit.acting(span).into_iter().filter(|_| *slopes) {
            let mut theta = theta.clone();
            theta[i] += self.steps[request / self.spans.len()][i];
            to.push(fit.spot(experiment, &theta, span));
        }
    }

    /// What `work` makes of the rows and their products, request by request.
    fn each<T: Send>(
        &self,
        product: impl Fn(&[f64]) -> Product<'_> + Sync,
        how: &How,
        work: impl Fn(&[f64], &[f64]) -> T + Sync,
    ) -> Result<Vec<T>> {
        replayed(
            self.misfit,
            &self.requests,
            |i, to| self.spots(i, to),
            how,
            |i, columns: &[Reading], rows: &mut Vec<f64>| {
                let (asked, span) = (self.asked(i), self.requests[i].span);
                let all = &self.steps[i / self.spans.len()];
                let acting = asked.fit.acting(span).into_iter();
                let steps: Vec<f64> = acting.take(columns.len() - 1).map(|k| all[k]).collect();
                let measured = &self.misfit.measured[span];
                let work_at = self.misfit.whiten(measured, columns, product(&steps), rows);
                let products = whiten(how.level, work_at);
                work(rows, &products)
            },
        )
    }
}

/// Sums of squares of models over some spans, and their normal matrices and gradients.
pub(super) fn compared(
    misfit: &Misfit,
    asked: &[Asked],
    spans: &[usize],
    how: &How,
) -> Result<Vec<Compared>> {
    let moved = Moved::new(misfit, asked, spans);
    let parts = moved.each(|steps| Product::Normal(steps), how, |_, products| products.to_vec())?;
    let found = asked.iter().zip(parts.chunks_exact(spans.len().max(1))).map(|(one, parts)| {
        // Span after span, so that the bits are those of any number of threads.
        let chi2 = one.chi2(parts.iter().map(|part| part[0]).sum());
        let normal = one.slopes.then(|| normal(one, spans, parts));
        Compared { chi2, normal }
    });
    Ok(found.collect())
}

/// The sum of the products of all spans.
fn normal(asked: &Asked, spans: &[usize], parts: &[Vec<f64>]) -> Normal {
    let fit = asked.fit;
    let count = fit.coordinates.len();
    let mut matrix = DMatrix::zeros(count, count);
    let mut gradient = DVector::zeros(count);
    for (span, part) in spans.iter().zip(parts) {
        for (j, row) in fit.acting(*span).into_iter().enumerate() {
            // The products of row j + 1 with all before it, of which the first is the fit's own.
            let own = &part[(j + 1) * (j + 2) / 2..];
            gradient[row] += own[0];
            for (k, column) in fit.acting(*span).into_iter().enumerate().take(j + 1) {
                matrix[(row, column)] += own[k + 1];
            }
        }
    }
    matrix.fill_upper_triangle_with_lower_triangle();
    with_priors(asked, Normal { matrix, gradient })
}

/// Derivatives of a fit's residuals over some spans, a row for every coordinate: those of
/// `Misfit::residuals`, and last those of what is known before.
pub fn jacobian(misfit: &Misfit, fit: &Fit, spans: &[usize], how: &How) -> Result<Vec<Vec<f64>>> {
    let asked = [Asked { fit, theta: fit.theta.clone(), slopes: true }];
    let moved = Moved::new(misfit, &asked, spans);
    let parts = moved.each(|steps| Product::Slopes(steps), how, |rows, _| rows.to_vec())?;
    let mut found = vec![vec![0.0; misfit.residuals(spans)]; fit.coordinates.len()];
    for (rank, span) in spans.iter().enumerate() {
        let stride = misfit.measured[*span].stride();
        for (row, i) in parts[rank].chunks_exact(stride).skip(1).zip(fit.acting(*span)) {
            misfit.place(row, spans, rank, &mut found[i]);
        }
    }
    for (i, coordinate) in fit.coordinates.iter().enumerate() {
        if coordinate.deviation.is_finite() {
            for (k, row) in found.iter_mut().enumerate() {
                row.push(if k == i { 1.0 / coordinate.deviation } else { 0.0 });
            }
        }
    }
    Ok(found)
}
