//! Whether steps and waits follow a drive that swings.

use crate::lane::Lane;
use crate::physics::segment::Segment;

/// Fewest steps in a period of the drive's highest frequency. A step takes the impulse
/// of the force by Simpson's rule, which at a quarter period errs by
/// (pi/2)^4/2880 = 0.2 %; with fewer the drive may look like a slower one.
const LEAST_STEPS: f64 = 4.0;
/// Looks at a resting contact in such a period: no two extremes of the drive fall
/// between two of them, and a parabola follows each (see `wait`).
const LOOKS: f64 = 8.0;
/// Most such periods in one wait: 64 times 8 looks cost as much as a hundred steps.
const MOST_PERIODS: f64 = 64.0;

/// Periods of the drive's highest frequency in `dt` from `t` on.
#[inline(always)]
fn periods<L: Lane>(segment: &Segment<L>, t: L, dt: L) -> L {
    dt * segment.drive.highest_frequency(t, t + dt)
}

/// Whether the drive swings faster than a step of `dt` follows.
#[inline(always)]
pub fn outruns_step<L: Lane>(segment: &Segment<L>, t: L, dt: L) -> L::Mask {
    dt.splat(1.0 / LEAST_STEPS).lt(periods(segment, t, dt))
}

/// Whether it swings too often for a wait of `dt`.
#[inline(always)]
pub fn outruns_wait<L: Lane>(segment: &Segment<L>, t: L, dt: L) -> L::Mask {
    dt.splat(MOST_PERIODS).lt(periods(segment, t, dt))
}

/// Number of looks that a wait of `dt` takes to miss no extreme of the drive.
#[inline(always)]
pub fn looks<L: Lane>(segment: &Segment<L>, t: L, dt: L) -> L {
    let one = dt.splat(1.0);
    if !segment.drive.swings() {
        return one;
    }
    let looks = periods(segment, t, dt).min(one * MOST_PERIODS) * LOOKS;
    // The next whole number.
    (-((-looks).floor())).max(one)
}
