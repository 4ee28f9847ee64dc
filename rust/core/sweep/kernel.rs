//! The hot loops: one stretch of cells, pack by pack, compiled per quantity,
//! per set of varying parameters and per SIMD level.

use super::columns::{Columns, Vary};
use super::registry::used_by;
use crate::lane::{Pack, Task};
use crate::physics::Quantity;
use crate::physics::point::COLUMNS;
use std::marker::PhantomData;

/// Values of a stretch of cells; `out` is padded to whole packs.
pub struct Dense<'a, Q, const PLAIN: bool, const VARY: u8> {
    pub columns: &'a Columns<'a>,
    pub out: &'a mut [f64],
    pub quantity: PhantomData<Q>,
}

impl<Q: Quantity, const PLAIN: bool, const VARY: u8> Task for Dense<'_, Q, PLAIN, VARY> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let used = const { used_by(Q::INFO.params) };
        let len = self.out.len() / P::LANES * P::LANES;
        let columns = trimmed::<VARY>(self.columns, len, used);
        let out = &mut self.out[..len];
        let mut i = 0;
        while i < len {
            let point = columns.gather::<P, VARY>(token, i, used);
            Q::value::<P, PLAIN>(&point).store(&mut out[i..]);
            i += P::LANES;
        }
    }
}

/// Cuts the columns that a kernel reads to one length, which lets the compiler
/// check bounds once instead of per pack.
#[inline(always)]
fn trimmed<'a, const VARY: u8>(columns: &Columns<'a>, len: usize, used: u64) -> Columns<'a> {
    let mut trimmed = columns.clone();
    if VARY != Vary::ANY {
        for c in 0..COLUMNS {
            if used >> (c / 2) & 1 == 1 && super::columns::is_wide(VARY, c) {
                trimmed.data[c] = &columns.data[c][..len];
            }
        }
    }
    trimmed
}

/// Segment counts to choose from: N and 1/N.
#[derive(Clone, Copy)]
pub struct Rivals<'a> {
    pub main: &'a [f64],
    pub derived: &'a [f64],
    /// Place of the first one on the axis.
    pub first: usize,
}

/// Running best over segment counts of plain points, the case that decides how
/// fast a design sweep is: with the parameter known at compile time, all that
/// does not depend on it leaves the loop. `best` holds the score that a rival
/// must beat, `at` its place on the axis (NaN while there is none); a rival must
/// exceed the best so far by the factor `ahead`.
pub struct Extremum<'a, Q, const MIN: bool> {
    pub columns: &'a Columns<'a>,
    pub rivals: Rivals<'a>,
    pub ahead: f64,
    pub best: &'a mut [f64],
    pub at: &'a mut [f64],
    pub quantity: PhantomData<Q>,
}

impl<Q: Quantity, const MIN: bool> Task for Extremum<'_, Q, MIN> {
    type Output = ();
    const CHAINED: bool = true;

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let used = const { used_by(Q::INFO.params) };
        let main = self.rivals.main;
        let derived = &self.rivals.derived[..main.len()];
        let ahead = P::splat(token, self.ahead);
        let mut i = 0;
        while i + P::LANES <= self.best.len() {
            let mut point = self.columns.gather::<P, { Vary::MAIN }>(token, i, used);
            let mut best = P::load(token, &self.best[i..]);
            let mut at = P::load(token, &self.at[i..]);
            for j in 0..main.len() {
                point.segments = P::splat(token, main[j]);
                point.per_segments = P::splat(token, derived[j]);
                let score =
                    if MIN { -Q::value::<P, true>(&point) } else { Q::score::<P, true>(&point) };
                let wins = best.lt(score);
                // A score that cannot be negative needs no absolute value for
                // a margin of one sign.
                let size = if Q::SCORE_FLOOR >= 0.0 && !MIN { score } else { score.abs() };
                best = P::select(wins, size.mul_add(ahead, score), best);
                at = P::select(wins, best.with((self.rivals.first + j) as f64), at);
            }
            best.store(&mut self.best[i..]);
            at.store(&mut self.at[i..]);
            i += P::LANES;
        }
    }
}

/// What a fold over rivals keeps per cell.
pub struct Kept<'a> {
    /// Score that a rival must beat, or the sum so far.
    pub best: &'a mut [f64],
    /// Place of the best rival, or the last one that has a value.
    pub at: &'a mut [f64],
    pub count: &'a mut [f64],
}

/// Takes one rival's values into a running best (`sign` -1 for the smallest).
pub struct FoldBest<'a> {
    pub values: &'a [f64],
    pub kept: Kept<'a>,
    pub place: usize,
    pub ahead: f64,
    pub sign: f64,
}

impl Task for FoldBest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let (sign, ahead) = (P::splat(token, self.sign), P::splat(token, self.ahead));
        let place = P::splat(token, self.place as f64);
        let mut i = 0;
        while i + P::LANES <= self.values.len() {
            let score = P::load(token, &self.values[i..]) * sign;
            let best = P::load(token, &self.kept.best[i..]);
            let wins = best.lt(score);
            P::select(wins, score.abs().mul_add(ahead, score), best)
                .store(&mut self.kept.best[i..]);
            let at = P::load(token, &self.kept.at[i..]);
            P::select(wins, place, at).store(&mut self.kept.at[i..]);
            i += P::LANES;
        }
    }
}

/// Takes one rival's values into sum, count and last place.
pub struct FoldAll<'a> {
    pub values: &'a [f64],
    pub kept: Kept<'a>,
    pub place: usize,
}

impl Task for FoldAll<'_> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let place = P::splat(token, self.place as f64);
        let mut i = 0;
        while i + P::LANES <= self.values.len() {
            let value = P::load(token, &self.values[i..]);
            let works = value.not_nan();
            let sum = P::load(token, &self.kept.best[i..]);
            P::select(works, sum + value, sum).store(&mut self.kept.best[i..]);
            let at = P::load(token, &self.kept.at[i..]);
            P::select(works, place, at).store(&mut self.kept.at[i..]);
            let count = P::load(token, &self.kept.count[i..]);
            P::select(works, count + 1.0, count).store(&mut self.kept.count[i..]);
            i += P::LANES;
        }
    }
}
