//! Weighted errors of replays over one span, and the products of them that fits need.

use super::misfit::{Measured, Source, WIDE};
use crate::lane::{Level, Pack, Task, run};
use crate::physics::robot::Motor;

/// Reading of a model that cannot be replayed to the end: far from everything.
const LOST: f64 = 1e60;

/// Share of a row's squares that has to be left for their difference to have ten digits.
const LEAST_LEFT: f64 = 1e-6;

/// One replay over a span: x, v, x_rear and force, empty where no channel asks for them, and what
/// the sensor adds to x.
#[derive(Clone, Copy)]
pub struct Reading<'a> {
    pub parts: [&'a [f64]; 4],
    pub added: f64,
}

impl Reading<'_> {
    fn is_lost(&self) -> bool {
        self.parts[0].iter().fold(false, |lost, x| lost | !x.is_finite())
    }
}

/// What is made of the rows.
#[derive(Clone, Copy)]
pub enum Product<'a> {
    /// Nothing more.
    Rows,
    /// The sum of squares of each; rows are of no use then, unless they are kept.
    Squares { keep: bool },
    /// Rows behind the first become slopes: their difference to it over a step.
    Slopes(&'a [f64]),
    /// The same, and the products of each row with itself and those before it; rows are of
    /// no use then.
    Normal(&'a [f64]),
}

impl Product<'_> {
    fn needs_rows(self) -> bool {
        !matches!(self, Product::Squares { keep: false } | Product::Normal(_))
    }
}

/// Replays of one span that become rows of whitened residuals.
pub struct Whiten<'a> {
    pub measured: &'a Measured,
    pub sources: &'a [Source],
    pub motor: Option<&'a Motor<f64>>,
    pub columns: &'a [Reading<'a>],
    /// Shifts are moved by as many deviations at most.
    pub most: f64,
    pub product: Product<'a>,
    /// A row for every column.
    pub rows: &'a mut Vec<f64>,
}

/// Fills the rows at a level; returns the products.
pub fn whiten(level: Level, work: Whiten) -> Vec<f64> {
    run(level, work)
}

impl Whiten<'_> {
    /// Measured less predicted in units of the noise, 0 where nothing counts.
    #[inline(always)]
    fn weigh(&self, column: &Reading, row: &mut [f64]) {
        let own = self.measured;
        let lost = column.is_lost();
        for (c, source) in self.sources.iter().enumerate() {
            let segment = c * own.padded..c * own.padded + own.samples;
            let to = &mut row[segment.clone()];
            let known = own.readings[segment.clone()].iter().zip(&own.weights[segment]);
            let [x, v, _, force] = column.parts;
            match (source, self.motor) {
                _ if lost => to.iter_mut().zip(known).for_each(
                    #[inline(always)]
                    |(e, (y, w))| *e = (y - LOST) * w,
                ),
                (Source::Replayed(0), _) => to.iter_mut().zip(known.zip(x)).for_each(
                    #[inline(always)]
                    |(e, ((y, w), x))| *e = (y - (x + column.added)) * w,
                ),
                (Source::Replayed(k), _) => {
                    to.iter_mut().zip(known.zip(column.parts[*k])).for_each(
                        #[inline(always)]
                        |(e, ((y, w), read))| *e = (y - read) * w,
                    )
                }
                (Source::Power, Some(motor)) => {
                    to.iter_mut().zip(known.zip(force.iter().zip(v))).for_each(
                        #[inline(always)]
                        |(e, ((y, w), (force, speed)))| *e = (y - motor.power(*force, *speed)) * w,
                    )
                }
                (Source::Power, None) => to.fill(0.0),
            }
        }
    }
}

/// Products of the directions of shifts with rows, those of each row in turn. Each direction is
/// read once for three rows.
#[inline(always)]
fn along_shifts<P: Pack>(token: P::Token, own: &Measured, rows: &[f64], to: &mut Vec<f64>) {
    let (stride, count) = (own.stride(), own.shifts.len());
    let columns = rows.len() / stride;
    to.clear();
    to.resize(columns * count, 0.0);
    for (k, (at, shift)) in own.shifts.rows.iter().enumerate() {
        let row = |i: usize| &rows[i * stride + at..i * stride + at + shift.len()];
        let mut i = 0;
        while i + 3 <= columns {
            let found = three_dots::<P>(token, shift, [row(i), row(i + 1), row(i + 2)]);
            for (j, value) in found.into_iter().enumerate() {
                to[(i + j) * count + k] = value;
            }
            i += 3;
        }
        while i < columns {
            to[i * count + k] = dot::<P>(token, shift, row(i));
            i += 1;
        }
    }
}

/// Takes the shifts out of a row that has such products with their directions, and puts their
/// sizes behind it, each at most `most` deviations.
#[inline(always)]
fn take_out(own: &Measured, along: &mut [f64], most: f64, row: &mut [f64]) {
    let (body, behind) = row.split_at_mut(own.readings.len());
    own.shifts.sizes(along, most, behind);
    for ((at, direction), size) in own.shifts.rows.iter().zip(along) {
        let body = &mut body[*at..*at + direction.len()];
        body.iter_mut().zip(direction).for_each(
            #[inline(always)]
            |(e, u)| *e -= *size * u,
        );
    }
}

/// The sum of squares of what is left of a row as its shifts are taken out, from its products with
/// their directions; from what is left itself where that is little.
#[inline(always)]
fn square<P: Pack>(token: P::Token, own: &Measured, row: &[f64], along: &[f64]) -> f64 {
    let square = dot::<P>(token, row, row);
    let left = square - along.iter().map(|a| a * a).sum::<f64>();
    if left >= LEAST_LEFT * square {
        return left;
    }
    let (mut row, mut along) = (row.to_vec(), along.to_vec());
    take_out(own, &mut along, f64::INFINITY, &mut row);
    dot::<P>(token, &row, &row)
}

/// A row of weighted changes, out of which shifts are taken.
pub struct Project<'a> {
    pub measured: &'a Measured,
    pub row: &'a mut [f64],
}

impl Task for Project<'_> {
    type Output = ();
    const AVX2_AT_MOST: bool = true;

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let mut along = Vec::new();
        along_shifts::<P>(token, self.measured, self.row, &mut along);
        take_out(self.measured, &mut along, f64::INFINITY, self.row);
    }
}

impl Task for Whiten<'_> {
    type Output = Vec<f64>;
    const AVX2_AT_MOST: bool = true;

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) -> Vec<f64> {
        let (stride, count) = (self.measured.stride(), self.columns.len());
        let mut rows = std::mem::take(self.rows);
        rows.clear();
        rows.resize(count * stride, 0.0);
        for (column, row) in self.columns.iter().zip(rows.chunks_exact_mut(stride)) {
            self.weigh(column, row);
        }
        if let Product::Slopes(steps) | Product::Normal(steps) = self.product {
            let (first, others) = rows.split_at_mut(stride);
            for (row, step) in others.chunks_exact_mut(stride).zip(steps) {
                let share = 1.0 / step;
                row.iter_mut().zip(&*first).for_each(
                    #[inline(always)]
                    |(e, base)| {
                        let slope = (*e - base) * share;
                        // Where one of two replays has no number nothing is known.
                        *e = if slope.is_finite() { slope } else { 0.0 };
                    },
                );
            }
        }
        let shifts = self.measured.shifts.len();
        let mut along = Vec::new();
        along_shifts::<P>(token, self.measured, &rows, &mut along);
        // With the shifts taken out, the product of two rows falls by what they have along these:
        // rows themselves are read once.
        let of = |j: usize| &along[j * shifts..(j + 1) * shifts];
        let fallen =
            |j: usize, k: usize| -> f64 { of(j).iter().zip(of(k)).map(|(a, b)| a * b).sum() };
        let mut found = Vec::new();
        match self.product {
            Product::Rows | Product::Slopes(_) => {}
            Product::Squares { .. } => {
                for (j, row) in rows.chunks_exact(stride).enumerate() {
                    found.push(square::<P>(token, self.measured, row, of(j)));
                }
            }
            Product::Normal(_) => {
                let own = &rows[..stride];
                found.push(square::<P>(token, self.measured, own, of(0)));
                for j in 1..count {
                    let at = |i: usize| &rows[i * stride..(i + 1) * stride];
                    let row = at(j);
                    // Three at a time, so that a row is read once for them.
                    let mut k = 0;
                    while k + 3 <= j + 1 {
                        let dots = three_dots::<P>(token, row, [at(k), at(k + 1), at(k + 2)]);
                        found.extend((k..).zip(dots).map(|(k, dot)| dot - fallen(j, k)));
                        k += 3;
                    }
                    while k <= j {
                        found.push(dot::<P>(token, row, at(k)) - fallen(j, k));
                        k += 1;
                    }
                }
            }
        }
        if self.product.needs_rows() {
            for (i, row) in rows.chunks_exact_mut(stride).enumerate() {
                let along = &mut along[i * shifts..(i + 1) * shifts];
                take_out(self.measured, along, self.most, row);
            }
        }
        *self.rows = rows;
        found
    }
}

/// Packs that `WIDE` numbers take at most: one each where packs are plain numbers.
const PACKS: usize = WIDE;

#[inline(always)]
fn total<P: Pack>(sums: [P; PACKS]) -> f64 {
    let mut wide = [0.0; WIDE];
    for (i, sum) in sums.iter().enumerate().take(WIDE / P::LANES) {
        sum.store(&mut wide[i * P::LANES..]);
    }
    let mut half = WIDE / 2;
    while half > 0 {
        for i in 0..half {
            wide[i] += wide[i + half];
        }
        half /= 2;
    }
    wide[0]
}

#[inline(always)]
fn dot<P: Pack>(token: P::Token, a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [P::broadcast(token, 0.0); PACKS];
    for (a, b) in a.chunks_exact(WIDE).zip(b.chunks_exact(WIDE)) {
        for (i, sum) in sums.iter_mut().enumerate().take(WIDE / P::LANES) {
            let at = i * P::LANES;
            *sum = P::load(token, &a[at..]).mul_add(P::load(token, &b[at..]), *sum);
        }
    }
    total(sums)
}

#[inline(always)]
fn three_dots<P: Pack>(token: P::Token, a: &[f64], [b, c, d]: [&[f64]; 3]) -> [f64; 3] {
    let none = [P::broadcast(token, 0.0); PACKS];
    let (mut ab, mut ac, mut ad) = (none, none, none);
    let others = b.chunks_exact(WIDE).zip(c.chunks_exact(WIDE)).zip(d.chunks_exact(WIDE));
    for (a, ((b, c), d)) in a.chunks_exact(WIDE).zip(others) {
        for i in 0..WIDE / P::LANES {
            let at = i * P::LANES;
            let a = P::load(token, &a[at..]);
            ab[i] = a.mul_add(P::load(token, &b[at..]), ab[i]);
            ac[i] = a.mul_add(P::load(token, &c[at..]), ac[i]);
            ad[i] = a.mul_add(P::load(token, &d[at..]), ad[i]);
        }
    }
    [total(ab), total(ac), total(ad)]
}
