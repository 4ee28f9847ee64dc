//! The linear system of a stiff step: x, v and the bristles, and the work and heat
//! that follow from them.

use super::{State, Vector};
use crate::lane::Lane;
use crate::physics::friction::{Bristle, MOST_STATES, Partials};
use crate::physics::segment::Segment;

/// How work and friction respond to speed and bristles over a step.
#[derive(Clone, Copy)]
pub struct Ledger<L> {
    per_gamma: L,
    work_x: L,
    work_v: L,
    heat_v: L,
    heat_z: [L; MOST_STATES],
}

impl<L: Lane> Ledger<L> {
    #[inline(always)]
    pub fn new<Q: Bristle>(
        segment: &Segment<L>,
        partials: &Partials<L>,
        (force, against): (L, L),
        v: L,
        per_gamma: L,
    ) -> Self {
        let mut heat_z = partials.force_z;
        for part in heat_z.iter_mut().take(Q::STATES) {
            *part = *part * v;
        }
        Ledger {
            per_gamma,
            work_x: -(segment.spring * v),
            work_v: force - segment.damper * v,
            heat_v: partials.force_v.mul_add(v, against),
            heat_z,
        }
    }

    #[inline(always)]
    pub fn solve<Q: Bristle>(&self, right: (L, L), k: &Vector<L>) -> (L, L) {
        let work = self.work_x.mul_add(k[0], self.work_v.mul_add(k[1], right.0));
        let mut heat = self.heat_v.mul_add(k[1], right.1);
        for i in 0..Q::STATES {
            heat = self.heat_z[i].mul_add(k[2 + i], heat);
        }
        (work * self.per_gamma, heat * self.per_gamma)
    }
}

/// How a law changes with the place, or with time, while speed and bristles stay.
pub struct Change<L> {
    pub rates: [L; MOST_STATES],
    pub force: L,
}

impl<L: Lane> Change<L> {
    #[inline(always)]
    pub fn none(zero: L) -> Self {
        Change { rates: [zero; MOST_STATES], force: zero }
    }

    /// From one law to another that is `apart`, per unit of that.
    #[inline(always)]
    pub fn between<Q: Bristle>(
        from: &Q::Coefficients<L>,
        to: &Q::Coefficients<L>,
        state: &State<L>,
        apart: L,
    ) -> Self {
        let per = apart.splat(1.0) / apart;
        let (v, z) = (state.v, &state.z);
        let (before, mut rates) = (Q::rates(from, v, z), Q::rates(to, v, z));
        let force = Q::force(to, v, z, &rates) - Q::force(from, v, z, &before);
        for (after, before) in rates.iter_mut().zip(&before) {
            *after = (*after - *before) * per;
        }
        Change { rates, force: force * per }
    }
}

/// Solves (I/g - J) k = r, where g is the step times the method's own share, with the unknowns x, v
/// and the bristles: dx follows from dv, and dv and the bristles are eliminated in order.
pub struct Solver<L> {
    per_gamma: L,
    /// Derivatives by x: of the acceleration, and of the bristles' rates.
    pull_x: L,
    rates_x: [L; MOST_STATES],
    /// Rows of the remaining system after elimination; see `new`.
    lower: [[L; MOST_STATES + 1]; MOST_STATES + 1],
}

// Elimination reads best in rows and columns.
#[allow(clippy::needless_range_loop)]
impl<L: Lane> Solver<L> {
    #[inline(always)]
    pub fn new<Q: Bristle>(
        segment: &Segment<L>,
        partials: &Partials<L>,
        along: &Change<L>,
        x: L,
        (gamma, per_gamma): (L, L),
    ) -> Self {
        let zero = gamma.splat(0.0);
        let n = Q::STATES;
        let stiffness = segment.spring + segment.pull_back_slope(x) + along.force;
        let pull_x = -(stiffness * segment.per_mass);
        let mut m = [[zero; MOST_STATES + 1]; MOST_STATES + 1];
        // Bristles first, the speed last: bristles are the stiff part, so their
        // pivots are large.
        for i in 0..n {
            for j in 0..n {
                m[i][j] = -partials.rate_z[i][j];
            }
            m[i][i] = m[i][i] + gamma;
            m[i][n] = -along.rates[i].mul_add(per_gamma, partials.rate_v[i]);
            m[n][i] = partials.force_z[i] * segment.per_mass;
        }
        let drag = (partials.force_v + segment.damper) * segment.per_mass;
        m[n][n] = (gamma + drag) - pull_x * per_gamma;
        for p in 0..n {
            let pivot = zero.splat(1.0) / m[p][p];
            for i in p + 1..=n {
                let factor = m[i][p] * pivot;
                for j in p + 1..=n {
                    m[i][j] = (-factor).mul_add(m[p][j], m[i][j]);
                }
                m[i][p] = factor;
            }
            m[p][p] = pivot;
        }
        m[n][n] = zero.splat(1.0) / m[n][n];
        Solver { per_gamma, pull_x, rates_x: along.rates, lower: m }
    }

    #[inline(always)]
    pub fn solve<Q: Bristle>(&self, right: &Vector<L>) -> Vector<L> {
        let n = Q::STATES;
        let zero = self.per_gamma.splat(0.0);
        let m = &self.lower;
        let mut b = [zero; MOST_STATES + 1];
        let ahead = self.per_gamma * right[0];
        for i in 0..n {
            b[i] = self.rates_x[i].mul_add(ahead, right[2 + i]);
        }
        b[n] = self.pull_x.mul_add(ahead, right[1]);
        for p in 0..n {
            for i in p + 1..=n {
                b[i] = (-m[i][p]).mul_add(b[p], b[i]);
            }
        }
        for p in (0..=n).rev() {
            for j in p + 1..=n {
                b[p] = (-m[p][j]).mul_add(b[j], b[p]);
            }
            b[p] = b[p] * m[p][p];
        }
        let mut k = [zero; MOST_STATES + 2];
        k[0] = (right[0] + b[n]) * self.per_gamma;
        k[1] = b[n];
        k[2..2 + n].copy_from_slice(&b[..n]);
        k
    }
}
