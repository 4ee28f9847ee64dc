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

    /// Taylor's series over a short time.
    #[inline(always)]
    pub(super) fn series(&self, from: &Inputs<L>, dt: L, slides: bool, joined: bool) -> [L; 4] {
        let zero = dt.splat(0.0);
        let mut sum = [from[0], from[1], if slides { from[2] } else { zero }, zero];
        let mut term = *from;
        for n in 1..=TERMS {
            let slope = self.slope(&term, slides, joined);
            let share = dt * (1.0 / n as f64);
            // Inputs stay as they are: they enter the first derivative only.
            term = [slope[0] * share, slope[1] * share, slope[2] * share, zero, zero];
            for (sum, add) in sum.iter_mut().zip(&slope) {
                *sum = share.mul_add(*add, *sum);
            }
        }
        sum
    }

    #[inline(always)]
    pub(super) fn map(&self, dt: L, slides: bool, joined: bool) -> Map<L> {
        let zero = dt.splat(0.0);
        let mut rows = [[zero; 5]; 4];
        for column in 0..5 {
            let mut unit = [zero; 5];
            unit[column] = zero.splat(1.0);
            let end = self.series(&unit, dt, slides, joined);
            for row in 0..4 {
                rows[row][column] = end[row];
            }
        }
        Map { rows }
    }
}

/// Terms of the series: it is taken over times far below those of any rate.
const TERMS: usize = 8;

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
}

/// Halvings of a step: rates up to a thousand per step are resolved.
pub(super) const HALVINGS: i32 = 13;

/// Doublings of a step where nothing happens: to 16 of the 18 looks that an interval has at most
/// (`MOST_LOOKS`).
const DOUBLINGS: i32 = 4;

/// Maps of a step of `dt`, twice that and so on, of the first so many modes.
#[inline(always)]
pub(super) fn levels<L: Lane>(rates: &Rates<L>, dt: L, modes: usize) -> Vec<Level<L>> {
    let mut level = Level { dt, maps: [rates.map(dt, true, true); MODES.len()] };
    for (map, (slides, joined)) in level.maps.iter_mut().zip(MODES).take(modes).skip(1) {
        *map = rates.map(dt, slides, joined);
    }
    let mut levels = vec![level];
    for _ in 0..HALVINGS + DOUBLINGS {
        level.dt = level.dt * 2.0;
        for map in level.maps.iter_mut().take(modes) {
            *map = map.twice();
        }
        levels.push(level);
    }
    levels
}
