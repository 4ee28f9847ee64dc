//! Where a step of a head behind a joint or a lag leads: matrix exponentials by Taylor's
//! series over a very short time, doubled to longer ones.

use crate::lane::Lane;

/// State (a, b, v) and inputs: constant acceleration of the head, drive force.
pub(super) type Inputs<L> = [L; 5];

/// Where a step leads: a, b, v and the distance gone, by state and inputs.
#[derive(Clone, Copy)]
pub(super) struct Map<L> {
    rows: [Inputs<L>; 4],
}

impl<L: Lane> Map<L> {
    #[inline(always)]
    pub(super) fn apply(&self, from: &Inputs<L>) -> [L; 4] {
        let [a, b, v, g, u] = *from;
        let mut to = [a; 4];
        for (to, c) in to.iter_mut().zip(&self.rows) {
            let near = c[1].mul_add(b, c[0] * a);
            let far = c[3].mul_add(g, c[2] * v);
            *to = c[4].mul_add(u, near + far);
        }
        to
    }

    /// The map of two such steps.
    #[inline(always)]
    pub(super) fn twice(&self) -> Map<L> {
        let mut rows = self.rows;
        for column in 0..5 {
            let zero = self.rows[0][0].splat(0.0);
            let mut half = [zero; 5];
            for (half, row) in half.iter_mut().zip(&self.rows[..3]) {
                *half = row[column];
            }
            if column > 2 {
                half[column] = zero.splat(1.0);
            }
            let end = self.apply(&half);
            for row in 0..3 {
                rows[row][column] = end[row];
            }
            rows[3][column] = self.rows[3][column] + end[3];
        }
        Map { rows }
    }
}

/// Changes of inputs over a step: of the head's acceleration with s and with s^2, of the drive's
/// force with s, which goes from 0 to 1 over the step.
pub(super) type Changes<L> = [L; 3];

/// What they add to where a step leads.
#[derive(Clone, Copy)]
pub(super) struct Bend<L> {
    columns: [[L; 4]; 3],
}

impl<L: Lane> Bend<L> {
    #[inline(always)]
    pub(super) fn add(&self, [rise, square, swell]: Changes<L>, to: [L; 4]) -> [L; 4] {
        let mut sum = to;
        for (row, sum) in sum.iter_mut().enumerate() {
            let near = self.columns[0][row].mul_add(rise, *sum);
            *sum = self.columns[2][row].mul_add(swell, self.columns[1][row].mul_add(square, near));
        }
        sum
    }

    /// That of two such steps, whose map is `map`: s is s/2 over the first one and 1/2 + s/2
    /// over the second.
    #[inline(always)]
    fn twice(&self, map: &Map<L>) -> Bend<L> {
        let zero = self.columns[0][0].splat(0.0);
        let one = zero.splat(1.0);
        let mut columns = self.columns;
        // Shares over the first step, constant inputs over the second one, shares over it.
        let parts = [
            ([0.5, 0.0, 0.0], [0.5, 0.0], [0.5, 0.0, 0.0]),
            ([0.0, 0.25, 0.0], [0.25, 0.0], [0.5, 0.25, 0.0]),
            ([0.0, 0.0, 0.5], [0.0, 0.5], [0.0, 0.0, 0.5]),
        ];
        for (column, (first, held, second)) in columns.iter_mut().zip(parts) {
            let shares = [one * first[0], one * first[1], one * first[2]];
            let [a, b, v, gone] = self.add(shares, [zero; 4]);
            let end = map.apply(&[a, b, v, one * held[0], one * held[1]]);
            let shares = [one * second[0], one * second[1], one * second[2]];
            *column = self.add(shares, end);
            column[3] = column[3] + gone;
        }
        Bend { columns }
    }
}

/// Rates of a head behind a joint or a lag.
#[derive(Clone, Copy)]
pub(super) struct Rates<L> {
    pub per_mass: L,
    /// Viscous rate of the head.
    pub viscous: L,
    /// Rate of a lag; of a joint its stiffness, damping and the inverse mass behind it.
    pub lag: L,
    pub stiffness: L,
    pub damping: L,
    pub per_side: L,
    pub is_lag: bool,
}

impl<L: Lane> Rates<L> {
    /// Derivatives of (a, b, v, distance gone).
    #[inline(always)]
    fn slope(&self, y: &Inputs<L>, slides: bool, joined: bool) -> [L; 4] {
        let [a, b, v, g, u] = *y;
        let zero = a.splat(0.0);
        let v = if slides { v } else { zero };
        let (da, db, push) = if self.is_lag {
            ((u - a) * self.lag, zero, a)
        } else {
            let rate = b - v;
            let force = self.damping.mul_add(rate, self.stiffness * a);
            let force = if joined { force } else { zero };
            (rate, (u - force) * self.per_side, force)
        };
        let dv = (-self.viscous).mul_add(v, push.mul_add(self.per_mass, g));
        [da, db, if slides { dv } else { zero }, v]
    }

    /// Where Taylor's series over a short time leads, with inputs that change over it, if any.
    #[inline(always)]
    pub(super) fn series(
        &self,
        from: &Inputs<L>,
        changes: Option<Changes<L>>,
        dt: L,
        (slides, joined): (bool, bool),
    ) -> [L; 4] {
        let zero = dt.splat(0.0);
        let mut sum = [from[0], from[1], if slides { from[2] } else { zero }, zero];
        let mut term = *from;
        for n in 1..=TERMS {
            let slope = self.slope(&term, slides, joined);
            let share = dt * (1.0 / n as f64);
            // Inputs enter with the terms of their order.
            let (g, u) = match (changes, n) {
                (Some([rise, _, swell]), 1) => (rise, swell),
                (Some([_, square, _]), 2) => (square, zero),
                _ => (zero, zero),
            };
            term = [slope[0] * share, slope[1] * share, slope[2] * share, g, u];
            for (sum, add) in sum.iter_mut().zip(&slope) {
                *sum = share.mul_add(*add, *sum);
            }
        }
        sum
    }

    #[inline(always)]
    fn bend(&self, dt: L, mode: (bool, bool)) -> Bend<L> {
        let zero = dt.splat(0.0);
        let still = [zero; 5];
        let mut columns = [[zero; 4]; 3];
        for (k, column) in columns.iter_mut().enumerate() {
            let mut unit = [zero; 3];
            unit[k] = zero.splat(1.0);
            *column = self.series(&still, Some(unit), dt, mode);
        }
        Bend { columns }
    }

    /// Longest time over which the series is good.
    #[inline(always)]
    pub(super) fn short(&self) -> L {
        let per_swing = self.per_side + self.per_mass;
        let joint = (self.stiffness * per_swing).sqrt() + self.damping * per_swing;
        self.lag.splat(SHORT) / (self.viscous + if self.is_lag { self.lag } else { joint })
    }

    #[inline(always)]
    pub(super) fn map(&self, dt: L, mode: (bool, bool)) -> Map<L> {
        let zero = dt.splat(0.0);
        let mut rows = [[zero; 5]; 4];
        for column in 0..5 {
            let mut unit = [zero; 5];
            unit[column] = zero.splat(1.0);
            let end = self.series(&unit, None, dt, mode);
            for row in 0..4 {
                rows[row][column] = end[row];
            }
        }
        Map { rows }
    }
}

/// Terms of the series, and the longest time of it in those of the fastest rate: it leaves
/// 0.2^9/9!, a part in 10^12.
const TERMS: usize = 8;
const SHORT: f64 = 0.2;

/// What a lane may be doing: whether it slides, and whether it is joined.
pub(super) const MODES: [(bool, bool); 4] =
    [(true, true), (false, true), (true, false), (false, false)];
/// Those of a joint that always transmits.
pub(super) const JOINED_MODES: usize = 2;

/// Maps of one step, of each of `MODES`.
#[derive(Clone, Copy)]
pub(super) struct Level<L> {
    pub dt: L,
    pub maps: [Map<L>; MODES.len()],
    /// Of each mode where inputs bend; nothing at rest.
    pub bends: [Bend<L>; MODES.len()],
}

/// Halvings of a step: rates up to a thousand per step are resolved.
pub(super) const HALVINGS: i32 = 13;

/// Doublings of a step where nothing happens: to 16 of the 18 looks that an interval has at most
/// (`MOST_LOOKS`).
const DOUBLINGS: i32 = 4;

/// Maps of a step of `dt`, twice that and so on, of the first so many modes; `bent` where inputs
/// change over a step.
#[inline(always)]
pub(super) fn levels<L: Lane>(rates: &Rates<L>, dt: L, modes: usize, bent: bool) -> Vec<Level<L>> {
    let still = Bend { columns: [[dt.splat(0.0); 4]; 3] };
    let mut level =
        Level { dt, maps: [rates.map(dt, MODES[0]); MODES.len()], bends: [still; MODES.len()] };
    for (map, mode) in level.maps.iter_mut().zip(MODES).take(modes).skip(1) {
        *map = rates.map(dt, mode);
    }
    let bends = |(slides, _): (bool, bool)| bent && slides;
    for (bend, mode) in level.bends.iter_mut().zip(MODES).take(modes) {
        if bends(mode) {
            *bend = rates.bend(dt, mode);
        }
    }
    let mut levels = vec![level];
    for _ in 0..HALVINGS + DOUBLINGS {
        level.dt = level.dt * 2.0;
        let halves = level.maps.iter_mut().zip(&mut level.bends);
        for ((map, bend), mode) in halves.zip(MODES).take(modes) {
            if bends(mode) {
                *bend = bend.twice(map);
            }
            *map = map.twice();
        }
        levels.push(level);
    }
    levels
}
