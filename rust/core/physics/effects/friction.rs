//! Friction of the measured head: the nominal Coulomb and viscous law with the
//! friction effects on top, each left out where it is not active.

use super::{Active, Effect};
use crate::friction::{
    Bristle, Contact, Dry, Given, Law, LawInfo, MOST_STATES, Partials, Place, Worked, directed,
    dragged, ploughed, pressed, rippled, share_left,
};
use crate::lane::Lane;
use crate::lane::exp::exp_less_one;

/// The friction of one measured head.
pub struct Measured;

/// Its coefficients. Levels are those of the run at hand.
#[derive(Debug, Clone, Copy)]
pub struct Coefficients<L> {
    pub active: Active,
    /// Coulomb level forward and backward.
    pub forward: L,
    pub backward: L,
    /// Viscous coefficient, back-EMF included.
    pub viscous: L,
    pub quadratic: L,
    /// Static less Coulomb level.
    pub drop: L,
    pub per_stribeck: L,
    pub exponent: L,
    pub ripple: L,
    pub per_length: L,
    /// In turns.
    pub phase: L,
    pub drift: L,
    pub per_drift_time: L,
    pub load: L,
    pub buildup: L,
    pub stiffness: L,
    pub damping: L,
    /// What the place adds to the level, for a bristle that was put there.
    pub here: L,
}

impl<L: Lane> Coefficients<L> {
    /// Dry level at rest's edge, without the fall and the buildup.
    #[inline(always)]
    fn level(&self, place: &Place<L>) -> L {
        let mut level = self.forward;
        if self.active.has(Effect::DirectionDependentFriction) {
            level = directed(place.way, self.forward, self.backward);
        }
        if self.active.has(Effect::PositionDependentFriction) {
            level = rippled(level, place.x, self.ripple, self.per_length, self.phase);
        }
        if self.active.has(Effect::FrictionDrift) {
            let gone = exp_less_one(-(place.t * self.per_drift_time));
            level = level * (-self.drift).mul_add(gone, level.with(1.0));
        }
        if self.active.has(Effect::LoadDependentFriction) {
            level = pressed(level, place.drive, self.load);
        }
        level
    }

    #[inline(always)]
    fn heap(&self, place: &Place<L>) -> L {
        ploughed(self.buildup * place.swept, place)
    }

    /// Level of sliding at a speed, without what is smooth in it.
    #[inline(always)]
    fn sliding(&self, speed: L, level: L) -> L {
        if self.active.has(Effect::StribeckFriction) {
            let share = share_left(speed * self.per_stribeck, self.exponent);
            self.drop.mul_add(share, level)
        } else {
            level
        }
    }
}

impl Law for Measured {
    const INFO: LawInfo = LawInfo {
        name: "measured",
        formula: r"F_c\,\mathrm{sgn}\,v + c v \text{ and the active effects}",
        source: "nominal model and effects of a measured run",
        limits: "",
        meaning: "friction of a measured head",
        params: &["mu_coulomb", "viscous"],
        worked: Worked::NONE,
    };
    type Set<L: Lane> = Coefficients<L>;

    #[inline(always)]
    fn set<L: Lane>(contact: &Contact<L>, _: &impl Given<L>) -> Coefficients<L> {
        Coefficients::nominal(contact.coulomb, contact.viscous)
    }
}

impl<L: Lane> Coefficients<L> {
    /// Coulomb and viscous friction alone.
    #[inline(always)]
    pub fn nominal(coulomb: L, viscous: L) -> Self {
        let zero = coulomb.with(0.0);
        Coefficients {
            active: Active::default(),
            forward: coulomb,
            backward: coulomb,
            viscous,
            quadratic: zero,
            drop: zero,
            per_stribeck: zero,
            exponent: zero.with(1.0),
            ripple: zero,
            per_length: zero,
            phase: zero,
            drift: zero,
            per_drift_time: zero,
            load: zero,
            buildup: zero,
            stiffness: zero.with(1.0),
            damping: zero,
            here: zero,
        }
    }
}

impl Dry for Measured {
    const LINEAR: bool = true;
    const PLACED: bool = true;

    #[inline(always)]
    fn resistance<L: Lane>(set: &Coefficients<L>, speed: L, place: &Place<L>) -> L {
        let mut level = set.sliding(speed, set.level(place));
        if set.active.has(Effect::LubricantBuildup) {
            level = level + set.heap(place);
        }
        if set.active.has(Effect::QuadraticDrag) {
            level = dragged(level, set.quadratic, speed, speed.abs());
        }
        set.viscous.mul_add(speed, level)
    }

    #[inline(always)]
    fn holding<L: Lane>(set: &Coefficients<L>, place: &Place<L>) -> L {
        let level = set.level(place);
        if set.active.has(Effect::StribeckFriction) { level + set.drop } else { level }
    }

    #[inline(always)]
    fn linear<L: Lane>(set: &Coefficients<L>, place: &Place<L>) -> (L, L) {
        (set.level(place), set.viscous)
    }
}

impl Bristle for Measured {
    const STATES: usize = 1;

    #[inline(always)]
    fn placed<L: Lane>(set: &Coefficients<L>, place: &Place<L>) -> Coefficients<L> {
        let mut set = *set;
        set.here = set.level(place);
        if set.active.has(Effect::LubricantBuildup) {
            set.here = set.here + set.heap(place);
        }
        set
    }

    #[inline(always)]
    fn rates<L: Lane>(set: &Coefficients<L>, v: L, z: &[L; MOST_STATES]) -> [L; MOST_STATES] {
        let zero = v.with(0.0);
        let level = set.sliding(v.abs(), set.here).max(zero.with(1e-9));
        let rate = v - (set.stiffness * v.abs()) * (z[0] / level);
        [rate, zero, zero, zero]
    }

    #[inline(always)]
    fn force<L: Lane>(
        set: &Coefficients<L>,
        v: L,
        z: &[L; MOST_STATES],
        rates: &[L; MOST_STATES],
    ) -> L {
        let bristle = set.damping.mul_add(rates[0], set.stiffness * z[0]);
        let smooth = dragged(set.viscous * v, set.quadratic, v, v.abs());
        bristle + smooth
    }

    #[inline(always)]
    fn partials<L: Lane>(set: &Coefficients<L>, v: L, z: &[L; MOST_STATES]) -> Partials<L> {
        let zero = v.with(0.0);
        let floor = zero.with(1e-9);
        let speed = v.abs();
        let level = set.sliding(speed, set.here).max(floor);
        let sign = L::select(v.lt(zero), zero.with(-1.0), zero.with(1.0));
        let fall = if set.active.has(Effect::StribeckFriction) {
            // The fall has no derivative at rest for exponents below 1: a
            // difference over a small share of the Stribeck speed.
            let width = zero.with(1e-4) / set.per_stribeck;
            let after = set.sliding(speed + width, set.here);
            (after - set.sliding(speed, set.here)) / width
        } else {
            zero
        };
        let per_level = zero.with(1.0) / level;
        let pull = (set.stiffness * speed) * per_level;
        let pull_v =
            (set.stiffness * per_level) * sign * (zero.with(1.0) - (speed * per_level) * fall);
        let rate_v = zero.with(1.0) - pull_v * z[0];
        let mut partials = Partials::zero(v);
        partials.rate_v[0] = rate_v;
        partials.rate_z[0][0] = -pull;
        let smooth = (set.quadratic * 2.0).mul_add(speed, set.viscous);
        partials.force_v = set.damping.mul_add(rate_v, smooth);
        partials.force_z[0] = set.stiffness - set.damping * pull;
        partials
    }

    #[inline(always)]
    fn stored<L: Lane>(set: &Coefficients<L>, z: &[L; MOST_STATES]) -> L {
        (set.stiffness * 0.5) * (z[0] * z[0])
    }

    #[inline(always)]
    fn steady<L: Lane>(set: &Coefficients<L>, v: L) -> [L; MOST_STATES] {
        let zero = v.with(0.0);
        let level = set.sliding(v.abs(), set.here);
        [v.sign() * (level / set.stiffness), zero, zero, zero]
    }
}
