//! Events within a step: cubics through its two ends, and where they pass zero.

use crate::lane::Lane;

/// A cubic over a step, from values and slopes at its ends; theta from 0 to 1.
#[derive(Clone, Copy)]
pub struct Cubic<L> {
    c: [L; 4],
}

impl<L: Lane> Cubic<L> {
    #[inline(always)]
    pub fn new(dt: L, from: (L, L), to: (L, L)) -> Self {
        let rise = to.0 - from.0;
        let (start, end) = (dt * from.1, dt * to.1);
        let square = rise * 3.0 - (start + start + end);
        let cube = start + end - (rise + rise);
        Cubic { c: [from.0, start, square, cube] }
    }

    #[inline(always)]
    pub fn at(&self, theta: L) -> L {
        let [c0, c1, c2, c3] = self.c;
        c3.mul_add(theta, c2).mul_add(theta, c1).mul_add(theta, c0)
    }

    #[inline(always)]
    pub fn slope(&self, theta: L) -> L {
        let [_, c1, c2, c3] = self.c;
        (c3 * 3.0).mul_add(theta, c2 * 2.0).mul_add(theta, c1)
    }

    /// Where the cubic has its first extremum if its slope changes sign over the
    /// step; meaningless (but finite) elsewhere.
    #[inline(always)]
    pub fn turn(&self) -> L {
        let [_, c1, c2, c3] = self.c;
        let zero = c1.splat(0.0);
        let root = c2.mul_add(c2, -(c3 * c1 * 3.0)).max(zero).sqrt();
        // -c1/(c2 + root) where the slope starts negative, mirrored elsewhere.
        let falls = c1.lt(zero);
        let below = L::select(falls, c2 + root, root - c2);
        let theta = c1.abs() / below;
        L::select(L::and(theta.gt(zero), theta.lt(c1.splat(1.0))), theta, c1.splat(0.5))
    }

    /// The theta at which the cubic passes below zero before `end`, where it is
    /// negative; positive numbers come before.
    #[inline(always)]
    pub fn fall(&self, end: L) -> L {
        let theta = self.found(end);
        if !L::DERIVED {
            return theta;
        }
        // The search has no derivative, the root has: by the implicit function.
        let theta = theta.frozen();
        let value = self.at(theta);
        theta - (value - value.frozen()) / self.slope(theta).frozen()
    }

    #[inline(always)]
    fn found(&self, end: L) -> L {
        let zero = end.splat(0.0);
        let (mut low, mut high) = (zero, end);
        let mut theta = end * 0.5;
        // A lane that has settled stays, however long its neighbours take.
        let mut open = zero.le(zero);
        for _ in 0..60 {
            let value = self.at(theta);
            let above = zero.lt(value);
            low = L::select(above, theta, low);
            high = L::select(above, high, theta);
            let next = theta - value / self.slope(theta);
            let inside = L::and(low.lt(next), next.lt(high));
            let new = L::select(inside, next, (low + high) * 0.5);
            let moved = (end * 1e-15).lt((new - theta).abs());
            theta = L::select(open, new, theta);
            open = L::and(open, moved);
            if !L::any(open) {
                break;
            }
        }
        theta
    }
}

/// Width of the difference that gives the slope of an excess, as a share of the step:
/// rounding and bend both leave about 1e-9 of it. Held by
/// `cargo test --test replay sensitivities`.
const SLOPE_WIDTH: f64 = 1e-6;

/// The first theta in (0, 1] at which `excess` is positive, found by bisection and
/// secants, if it is positive at `end`; it is not at 0.
#[inline(always)]
pub fn rise<L: Lane>(end: L, excess: impl Fn(L) -> L) -> L {
    let theta = risen(end, &excess);
    if !L::DERIVED {
        return theta;
    }
    // The search has no derivative, the root has: by the implicit function.
    let theta = theta.frozen();
    let value = excess(theta);
    let width = theta.splat(SLOPE_WIDTH);
    let slope = (excess(theta + width) - excess(theta - width)).frozen() / (width * 2.0);
    let share = (value - value.frozen()) / slope;
    // A drive that jumps over the level gives way at its own time.
    L::select(share.splat(0.0).lt(slope), theta - share, theta)
}

#[inline(always)]
fn risen<L: Lane>(end: L, excess: &impl Fn(L) -> L) -> L {
    let zero = end.splat(0.0);
    let (mut low, mut high) = (zero, end);
    let (mut at_low, mut at_high) = (excess(low), excess(high));
    // A lane that has settled stays, however long its neighbours take.
    let mut open = zero.le(zero);
    for _ in 0..60 {
        let secant = low + (high - low) * (at_low / (at_low - at_high));
        let width = high - low;
        // A secant that hugs one end halves nothing: step off by a little.
        let margin = width * 1e-3;
        let inside = L::and((low + margin).lt(secant), secant.lt(high - margin));
        let theta = L::select(inside, secant, (low + high) * 0.5);
        let value = excess(theta);
        let over = L::and(open, zero.lt(value));
        let under = L::and(open, L::not(zero.lt(value)));
        high = L::select(over, theta, high);
        at_high = L::select(over, value, at_high);
        low = L::select(under, theta, low);
        at_low = L::select(under, value, at_low);
        open = L::and(open, (end * 1e-15).lt(high - low));
        if !L::any(open) {
            break;
        }
    }
    high
}
