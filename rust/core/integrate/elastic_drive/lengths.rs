//! How long steps are: as long as the time between two looks, or to the end of a stretch. Maps
//! are kept for a few lengths only, a series takes any length and several times as long.

use super::{ElasticDrive, LOOKED};
use crate::lane::Lane;

/// Level of the smallest steps that an interval is divided into by maps where a series would do:
/// an eighth of the time between two looks, as a shorter reach is mostly that of an event. Not
/// derived.
const SMALLEST: usize = LOOKED - 3;
/// Shares of a step that are rounding: times of samples are differences of larger numbers.
const ROUNDING: f64 = 1e-7;

/// What a step may be.
pub(super) enum Length<L> {
    /// That of a level.
    Level(usize),
    /// Any short one, per lane.
    Short(L),
}

impl<L: Lane, F> ElasticDrive<'_, '_, L, F> {
    /// The longest step that any lane of `active` may take by a map from the levels below `at`,
    /// else what each may take by a series, and the lanes that take it. Lanes that are `calm`
    /// look for no events. Lowers `at` to the level.
    #[inline(always)]
    pub(super) fn longest(
        &self,
        at: &mut usize,
        active: L::Mask,
        left: L,
        calm: L::Mask,
    ) -> (Length<L>, L::Mask) {
        let zero = left.splat(0.0);
        let mut want = left;
        let mut slides = zero.lt(zero);
        if self.bent {
            slides = zero.lt(self.now.direction.abs());
            want = L::select(slides, left.min(self.reach), left);
        }
        while *at > self.mapped.0.min(SMALLEST) {
            let level = *at - 1;
            let span = self.levels[level].dt;
            let mut fits = L::and(active, (span * (1.0 - ROUNDING)).le(want));
            if level > LOOKED {
                // A step that knows its error looks at its middle, too.
                let twice = self.bent && level == LOOKED + 1;
                fits = L::and(fits, if twice { L::or(calm, slides) } else { calm });
            }
            // A series is as good, but where whole steps fill the rest.
            if level < self.mapped.1.min(LOOKED) && L::any(fits) {
                let long = self.short.lt(span);
                let even = level >= SMALLEST;
                let maps = if even { L::or(long, self.is_even(left)) } else { long };
                fits = L::and(fits, maps);
            }
            if L::any(fits) {
                return (Length::Level(level), fits);
            }
            *at -= 1;
        }
        let look = self.levels[LOOKED].dt;
        let look = if self.bent { L::select(slides, look * 2.0, look) } else { look };
        (Length::Short(want.min(self.short).min(look)), active)
    }

    /// Lanes of which the rest of a stretch is a number of smallest steps.
    #[inline(always)]
    fn is_even(&self, left: L) -> L::Mask {
        let parts = left.frozen() / self.levels[SMALLEST].dt;
        (parts - (parts + 0.5).floor()).abs().le(parts * ROUNDING)
    }
}
