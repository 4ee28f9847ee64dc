//! Friction of the measured head: the nominal Coulomb and viscous law with the
//! friction effects on top, each left out where it is not active.

use super::{Active, Effect, Variable};
use crate::friction::{
    Bristle, Contact, ContactState, Dry, Law, LawInfo, MOST_STATES, Parameters, Partials,
    ReferenceValue, directed, dragged, ploughed, pressed, rippled, share_left,
};
use crate::lane::Lane;
use crate::lane::exp::exp_less_one;

/// Level of a bristle at least, N: it divides.
const LEAST_LEVEL: f64 = 1e-9;

/// The friction of one measured head.
pub struct Measured;

/// Its coefficients. Levels are those of the run at hand.
#[derive(Debug, Clone, Copy)]
pub struct Coefficients<L> {
    pub active: Active,
    /// Whether the level of a bristle changes with place, time, load or direction.
    pub varies: bool,
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
    /// Level of a bristle where it is, without the fall; and its stiffness over that level.
    pub here: L,
    pub per_way: L,
}

impl<L: Lane> Coefficients<L> {
    /// The same with effects.
    #[inline(always)]
    pub fn with_effects(self, active: Active) -> Self {
        let along = |effect: Effect| {
            let variable = effect.info().variable;
            effect == Effect::DirectionDependentFriction
                || matches!(
                    variable,
                    Some(
                        Variable::ContactState | Variable::Time | Variable::Load | Variable::Swept
                    )
                )
        };
        Coefficients { active, varies: active.iter().any(along), ..self }
    }

    /// Dry level at rest's edge, without the fall and the buildup.
    #[inline(always)]
    fn level(&self, at: &ContactState<L>) -> L {
        let mut level = self.forward;
        if self.active.has(Effect::DirectionDependentFriction) {
            level = directed(at.direction, self.forward, self.backward);
        }
        if self.active.has(Effect::PositionDependentFriction) {
            level = rippled(level, at.x, self.ripple, self.per_length, self.phase);
        }
        if self.active.has(Effect::FrictionDrift) {
            let gone = exp_less_one(-(at.t * self.per_drift_time));
            level = level * (-self.drift).mul_add(gone, level.splat(1.0));
        }
        if self.active.has(Effect::LoadDependentFriction) {
            level = pressed(level, at.drive, self.load);
        }
        level
    }

    #[inline(always)]
    fn heap(&self, at: &ContactState<L>) -> L {
        ploughed(self.buildup * at.sliding_distance, at)
    }

    /// The law with a bristle at a level.
    #[inline(always)]
    pub(super) fn with_level(self, level: L) -> Self {
        let per_way = self.stiffness / level.max(level.splat(LEAST_LEVEL));
        Coefficients { here: level, per_way, ..self }
    }

    /// Stiffness of the bristle over the level of sliding at a speed.
    #[inline(always)]
    fn bend(&self, speed: L) -> L {
        if self.active.has(Effect::StribeckFriction) {
            let level = self.sliding(speed, self.here);
            self.stiffness / level.max(level.splat(LEAST_LEVEL))
        } else {
            self.per_way
        }
    }

    /// Derivative of the bristle's rate by its level.
    #[inline(always)]
    pub(super) fn per_level(&self, v: L, z: &[L; MOST_STATES]) -> L {
        let bend = self.bend(v.abs());
        (bend * bend) * (v.abs() * (z[0] / self.stiffness))
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
        reference: ReferenceValue::NONE,
    };
    type Coefficients<L: Lane> = Coefficients<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(contact: &Contact<L>, _: &impl Parameters<L>) -> Coefficients<L> {
        Coefficients::nominal(contact.coulomb, contact.viscous)
    }
}

impl<L: Lane> Coefficients<L> {
    /// Coulomb and viscous friction alone.
    #[inline(always)]
    pub fn nominal(coulomb: L, viscous: L) -> Self {
        let zero = coulomb.splat(0.0);
        Coefficients {
            active: Active::default(),
            varies: false,
            forward: coulomb,
            backward: coulomb,
            viscous,
            quadratic: zero,
            drop: zero,
            per_stribeck: zero,
            exponent: zero.splat(1.0),
            ripple: zero,
            per_length: zero,
            phase: zero,
            drift: zero,
            per_drift_time: zero,
            load: zero,
            buildup: zero,
            stiffness: zero.splat(1.0),
            damping: zero,
            here: zero,
            per_way: zero,
        }
    }
}

impl Dry for Measured {
    const LINEAR: bool = true;
    const PLACED: bool = true;

    #[inline(always)]
    fn ages<L: Lane>(law: &Coefficients<L>) -> bool {
        law.active.iter().any(|effect| effect.info().variable == Some(Variable::Time))
    }

    #[inline(always)]
    fn resistance<L: Lane>(law: &Coefficients<L>, speed: L, at: &ContactState<L>) -> L {
        let mut level = law.sliding(speed, law.level(at));
        if law.active.has(Effect::LubricantBuildup) {
            level = level + law.heap(at);
        }
        if law.active.has(Effect::QuadraticDrag) {
            level = dragged(level, law.quadratic, speed, speed.abs());
        }
        law.viscous.mul_add(speed, level)
    }

    #[inline(always)]
    fn break_away<L: Lane>(law: &Coefficients<L>, at: &ContactState<L>) -> L {
        let level = law.level(at);
        if law.active.has(Effect::StribeckFriction) { level + law.drop } else { level }
    }

    #[inline(always)]
    fn linear<L: Lane>(law: &Coefficients<L>, at: &ContactState<L>) -> (L, L) {
        (law.level(at), law.viscous)
    }
}

impl Bristle for Measured {
    const STATES: usize = 1;

    #[inline(always)]
    fn varies<L: Lane>(law: &Coefficients<L>) -> bool {
        law.varies
    }

    #[inline(always)]
    fn placed<L: Lane>(law: &Coefficients<L>, at: &ContactState<L>) -> Coefficients<L> {
        let mut level = law.level(at);
        if law.active.has(Effect::LubricantBuildup) {
            level = level + law.heap(at);
        }
        law.with_level(level)
    }

    #[inline(always)]
    fn rates<L: Lane>(law: &Coefficients<L>, v: L, z: &[L; MOST_STATES]) -> [L; MOST_STATES] {
        let zero = v.splat(0.0);
        let speed = v.abs();
        let rate = (-(law.bend(speed) * z[0])).mul_add(speed, v);
        [rate, zero, zero, zero]
    }

    #[inline(always)]
    fn force<L: Lane>(
        law: &Coefficients<L>,
        v: L,
        z: &[L; MOST_STATES],
        rates: &[L; MOST_STATES],
    ) -> L {
        let bristle = law.damping.mul_add(rates[0], law.stiffness * z[0]);
        let smooth = dragged(law.viscous * v, law.quadratic, v, v.abs());
        bristle + smooth
    }

    #[inline(always)]
    fn partials<L: Lane>(law: &Coefficients<L>, v: L, z: &[L; MOST_STATES]) -> Partials<L> {
        let zero = v.splat(0.0);
        let speed = v.abs();
        let bend = law.bend(speed);
        let sign = L::select(v.lt(zero), zero.splat(-1.0), zero.splat(1.0));
        let pull = bend * speed;
        let mut pull_v = bend * sign;
        if law.active.has(Effect::StribeckFriction) {
            // The fall has no derivative at rest for exponents below 1: a
            // difference over a small share of the Stribeck speed.
            let width = zero.splat(1e-4) / law.per_stribeck;
            let after = law.sliding(speed + width, law.here);
            let fall = (after - law.sliding(speed, law.here)) / width;
            pull_v = pull_v * (zero.splat(1.0) - pull * (fall / law.stiffness));
        }
        let rate_v = zero.splat(1.0) - pull_v * z[0];
        let mut partials = Partials::zero(v);
        partials.rate_v[0] = rate_v;
        partials.rate_z[0][0] = -pull;
        let smooth = (law.quadratic * 2.0).mul_add(speed, law.viscous);
        partials.force_v = law.damping.mul_add(rate_v, smooth);
        partials.force_z[0] = law.stiffness - law.damping * pull;
        partials
    }

    #[inline(always)]
    fn stored<L: Lane>(law: &Coefficients<L>, z: &[L; MOST_STATES]) -> L {
        (law.stiffness * 0.5) * (z[0] * z[0])
    }

    #[inline(always)]
    fn steady<L: Lane>(law: &Coefficients<L>, v: L) -> [L; MOST_STATES] {
        let zero = v.splat(0.0);
        let level = law.sliding(v.abs(), law.here);
        [v.sign() * (level / law.stiffness), zero, zero, zero]
    }
}
