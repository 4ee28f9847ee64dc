//! How fast a drive swings, for steps that have to follow it.

use super::{Drive, DriveKind};
use crate::lane::Lane;

impl<L: Lane> Drive<'_, L> {
    /// Whether it swings; else it is constant within a piece, or goes one way.
    pub fn swings(&self) -> bool {
        matches!(self.kind, DriveKind::Sine | DriveKind::Multisine | DriveKind::Chirp)
    }

    /// Highest frequency between two times, Hz; 0 where nothing swings.
    #[inline(always)]
    pub fn highest_frequency(&self, from: L, to: L) -> L {
        let zero = from.splat(0.0);
        let highest = match self.kind {
            DriveKind::Sine => self.rate,
            DriveKind::Multisine => self.rate * self.fourth.floor(),
            DriveKind::Chirp => {
                // The frequency changes evenly.
                let growth = self.second + self.second;
                let at = |t: L| growth.mul_add(t, self.rate).abs();
                at(from).max(at(to))
            }
            _ => zero,
        };
        L::select(zero.lt(self.amplitude.abs()), highest, zero)
    }
}
