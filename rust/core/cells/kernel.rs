//! The hot loops: one stretch of cells, pack by pack, compiled per quantity,
//! per set of varying parameters and per SIMD level.

use super::columns::{Columns, PADDING, Vary};
use crate::lane::{Pack, Task, stream};
use crate::physics::Quantity;
use std::marker::PhantomData;

/// Values of a stretch of cells.
pub struct Dense<'a, Q, const PLAIN: bool, const VARY: u8> {
    pub columns: Columns<'a>,
    pub out: &'a mut [f64],
    /// Store past the caches.
    pub streamed: bool,
    pub quantity: PhantomData<Q>,
}

impl<Q: Quantity, const PLAIN: bool, const VARY: u8> Task for Dense<'_, Q, PLAIN, VARY> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let used = Q::USED;
        let len = self.out.len();
        let points = self.columns.reader::<P, VARY>(token, used, 0, len);
        // Streaming wants whole cache lines: the cells before the first one and
        // after the last pack go through a pack's worth of scratch.
        let head = if self.streamed { stream::cells_to_line(self.out).min(len) } else { 0 };
        let mut edge = [0.0; PADDING];
        let mut i = 0;
        while i < len {
            let value = Q::value::<P, PLAIN>(&points.at(i));
            let count = P::LANES.min(if i < head { head } else { len } - i);
            if count < P::LANES {
                value.store(&mut edge);
                self.out[i..i + count].copy_from_slice(&edge[..count]);
            } else if self.streamed {
                value.stream(&mut self.out[i..]);
            } else {
                value.store(&mut self.out[i..]);
            }
            i += count;
        }
    }
}

/// Segment counts to choose from: N, 1/N and their indices on the axis.
#[derive(Clone, Copy)]
pub struct Rivals<'a> {
    pub main: &'a [f64],
    pub derived: &'a [f64],
    pub indices: &'a [f64],
}

/// Running best over segment counts of plain points, the case that decides how
/// fast a design sweep is: with the parameter known at compile time, all that
/// does not depend on it leaves the loop. `best` holds the score that a rival
/// must beat, `at` its index on the axis (NaN while there is none); a rival must
/// exceed the best so far by the factor `ahead`.
pub struct Extremum<'a, Q, const MIN: bool> {
    pub columns: Columns<'a>,
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
        let used = Q::USED;
        let main = self.rivals.main;
        let derived = &self.rivals.derived[..main.len()];
        let indices = &self.rivals.indices[..main.len()];
        let ahead = P::broadcast(token, self.ahead);
        let factor = P::broadcast(token, 1.0 + self.ahead);
        let points =
            self.columns.reader_in_place::<P, { Vary::MAIN }>(token, used, 0, self.best.len());
        let mut i = 0;
        while i + P::LANES <= self.best.len() {
            let mut point = points.at(i);
            let mut best = P::load(token, &self.best[i..]);
            let mut at = P::load(token, &self.at[i..]);
            for j in 0..main.len() {
                point.segments = P::broadcast(token, main[j]);
                point.per_segments = P::broadcast(token, derived[j]);
                let score =
                    if MIN { -Q::value::<P, true>(&point) } else { Q::score::<P, true>(&point) };
                let wins = best.lt(score);
                // A score that cannot be negative needs no absolute value for
                // a margin of one sign.
                let mark = if Q::SCORE_FLOOR >= 0.0 && !MIN {
                    score * factor
                } else {
                    score.abs().mul_add(ahead, score)
                };
                best = P::select(wins, mark, best);
                at = P::select(wins, P::broadcast(token, indices[j]), at);
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
    pub index: usize,
    pub ahead: f64,
    pub sign: f64,
}

impl Task for FoldBest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let (sign, ahead) = (P::broadcast(token, self.sign), P::broadcast(token, self.ahead));
        let index = P::broadcast(token, self.index as f64);
        let mut i = 0;
        while i + P::LANES <= self.values.len() {
            let score = P::load(token, &self.values[i..]) * sign;
            let best = P::load(token, &self.kept.best[i..]);
            let wins = best.lt(score);
            P::select(wins, score.abs().mul_add(ahead, score), best)
                .store(&mut self.kept.best[i..]);
            let at = P::load(token, &self.kept.at[i..]);
            P::select(wins, index, at).store(&mut self.kept.at[i..]);
            i += P::LANES;
        }
    }
}

/// Takes one rival's values into sum, count and last index.
pub struct FoldAll<'a> {
    pub values: &'a [f64],
    pub kept: Kept<'a>,
    pub index: usize,
}

impl Task for FoldAll<'_> {
    type Output = ();

    #[inline(always)]
    fn run<P: Pack>(self, token: P::Token) {
        let index = P::broadcast(token, self.index as f64);
        let mut i = 0;
        while i + P::LANES <= self.values.len() {
            let value = P::load(token, &self.values[i..]);
            let works = value.not_nan();
            let sum = P::load(token, &self.kept.best[i..]);
            P::select(works, sum + value, sum).store(&mut self.kept.best[i..]);
            let at = P::load(token, &self.kept.at[i..]);
            P::select(works, index, at).store(&mut self.kept.at[i..]);
            let count = P::load(token, &self.kept.count[i..]);
            P::select(works, count + 1.0, count).store(&mut self.kept.count[i..]);
            i += P::LANES;
        }
    }
}
