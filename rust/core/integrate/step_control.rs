//! How steps grow and shrink with their error.

use crate::lane::Lane;

/// What a step takes of the length that its error allows, so that the next is seldom cut
/// again; and how far one step may shrink or grow at a time, as its error is an estimate.
pub const SAFETY: f64 = 0.9;
pub const MOST_SHRINK: f64 = 0.1;
pub const MOST_GROWTH: f64 = 4.0;

/// Third root over lanes, good to a few percent: it only sizes steps.
#[inline(always)]
pub fn cube_root<L: Lane>(x: L) -> L {
    // x^(1/3) = x^(1/4) x^(1/16) x^(1/64) ..., four factors leave 0.4 %.
    let a = x.sqrt().sqrt();
    let b = a.sqrt().sqrt();
    let c = b.sqrt().sqrt();
    (a * b) * (c * c.sqrt().sqrt())
}
