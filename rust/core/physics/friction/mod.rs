//! LAW REGISTRY: friction between a segment and the ground. A new law is one
//! file here, its `mod` line, and one line in `for_each_law!`; `tests/friction_fit/laws.rs` tells
//! whether fits know its parameters.
//!
//! There are three kinds. A *dry* law is set-valued at rest: it gives levels,
//! never a signed force, and the integrator owns the sign and the sticking. A
//! *smooth* law is a function of speed that passes through zero, so it creeps
//! where a real contact holds. A *bristle* law has states of its own, whose
//! deflection is the sticking.

mod bengisu_akay;
mod bo_pavelescu;
mod brown_mcphee;
mod buildup;
mod coulomb;
mod coulomb_viscous;
mod dahl;
mod directional;
mod elasto_plastic;
mod entry;
mod fall;
mod gonthier;
mod hess_soom;
pub mod imposed;
mod load_friction;
mod load_viscous;
mod lugre;
mod maxwell_slip;
mod mixed;
mod modelica;
mod patch;
mod power_drag;
mod quadratic;
mod ripple;
mod simscape;
mod static_coulomb;
mod static_viscous;
mod stribeck;
mod tanh;
mod threlfall;
mod track;
mod tustin;
mod values;

pub use entry::*;
pub use values::*;

/// Calls a macro with the kind, the file and the type of every law, in the order users
/// see them.
#[macro_export]
macro_rules! for_each_law {
    ($mac:ident) => {
        $mac! {
            dry coulomb::Coulomb,
            dry coulomb_viscous::CoulombViscous,
            dry quadratic::Quadratic,
            dry power_drag::PowerDrag,
            dry static_coulomb::StaticCoulomb,
            dry static_viscous::StaticViscous,
            dry tustin::Tustin,
            dry bo_pavelescu::BoPavelescu,
            dry stribeck::Stribeck,
            dry hess_soom::HessSoom,
            dry modelica::Modelica,
            dry load_friction::LoadFriction,
            dry load_viscous::LoadViscous,
            dry directional::Directional,
            dry ripple::Ripple,
            dry patch::Patch,
            dry track::Track,
            dry buildup::Buildup,
            dry mixed::Mixed,
            smooth tanh::Tanh,
            smooth threlfall::Threlfall,
            smooth bengisu_akay::BengisuAkay,
            smooth brown_mcphee::BrownMcphee,
            smooth simscape::Simscape,
            bristle dahl::Dahl,
            bristle lugre::Lugre,
            bristle elasto_plastic::ElastoPlastic,
            bristle maxwell_slip::MaxwellSlip,
            bristle gonthier::Gonthier,
        }
    };
}

macro_rules! reexport {
    ($($kind:ident $file:ident::$law:ident),+ $(,)?) => { $(pub use $file::*;)+ };
}
crate::for_each_law!(reexport);

use super::params::ParamId;
use crate::lane::Lane;

/// Most states that a bristle law has.
pub const MOST_STATES: usize = 4;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Dry,
    Smooth,
    Bristle,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Kind::Dry => "dry",
            Kind::Smooth => "smooth",
            Kind::Bristle => "bristle",
        }
    }
}

/// What a law is, for people and for the registry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawInfo {
    pub name: &'static str,
    /// TeX, in the symbols of the parameters; v is the speed, F_C and F_S are
    /// the Coulomb and the static level (coefficient times normal force).
    pub formula: &'static str,
    /// Who wrote it down, and when.
    pub source: &'static str,
    /// Where it holds, what it leaves out, and its trap.
    pub limits: &'static str,
    pub meaning: &'static str,
    /// Names of the parameters that enter beside the normal force.
    pub params: &'static [&'static str],
    pub reference: ReferenceValue,
}

/// A value of a law's force, calculated by hand or printed in its source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceValue {
    /// Parameters that differ from their defaults, by name.
    pub parameters: &'static [(&'static str, f64)],
    pub speed: f64,
    /// Position, sliding distance since reversal, drive force.
    pub at: (f64, f64, f64),
    /// Bristle states.
    pub states: [f64; MOST_STATES],
    /// The force that opposes motion, with the sign of `speed`, N.
    pub force: f64,
    /// Relative error up to which `force` is known.
    pub digits: f64,
}

impl ReferenceValue {
    /// No parameters, at rest at the origin; a start for `..ReferenceValue::NONE`.
    pub const NONE: ReferenceValue = ReferenceValue {
        parameters: &[],
        speed: 0.0,
        at: (0.0, 0.0, 0.0),
        states: [0.0; MOST_STATES],
        force: 0.0,
        digits: 1e-12,
    };
}

/// The parameters of one trajectory (or one per lane).
pub trait Parameters<L> {
    /// The value; of an angle its cosine (`slope_deg`) or the value in degrees.
    fn get(&self, id: ParamId) -> L;
    /// The number derived from it (see `point::columns`).
    fn derived(&self, id: ParamId) -> L;
}

/// What every law starts from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact<L> {
    /// Normal force, N.
    pub normal: L,
    /// Coulomb level F_C, N.
    pub coulomb: L,
    /// Static level F_S, N.
    pub break_away: L,
    /// Viscous coefficient, N s/m.
    pub viscous: L,
}

impl<L: Lane> Contact<L> {
    /// Weight in a groove, and the force that presses the segment to the wall.
    #[inline(always)]
    pub fn of(params: &impl Parameters<L>) -> Self {
        let weight = params.get(ParamId::Mass) * params.get(ParamId::Gravity);
        let across = params.get(ParamId::SlopeDeg) * params.derived(ParamId::CornerDeg);
        Contact::under(weight.mul_add(across, params.get(ParamId::WallForce)), params)
    }

    /// Under a normal force that is given.
    #[inline(always)]
    pub fn under(normal: L, params: &impl Parameters<L>) -> Self {
        Contact {
            normal,
            coulomb: params.get(ParamId::MuCoulomb) * normal,
            break_away: params.get(ParamId::MuStatic) * normal,
            viscous: params.get(ParamId::Viscous),
        }
    }
}

/// State of the contact, on which a dry law may depend beside the speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactState<L> {
    /// Direction of motion, or of the push at rest: 1 or -1.
    pub direction: L,
    pub x: L,
    /// Distance moved forward since the last rest or turn.
    pub sliding_distance: L,
    /// Force of the drive.
    pub drive: L,
    /// Time since the run began.
    pub t: L,
}

/// What all laws have.
pub trait Law: 'static {
    const INFO: LawInfo;
    /// Its coefficients, made once per trajectory.
    type Coefficients<L: Lane>: Copy;
    fn coefficients<L: Lane>(
        contact: &Contact<L>,
        params: &impl Parameters<L>,
    ) -> Self::Coefficients<L>;
}

/// A law that is set-valued at rest.
pub trait Dry: Law {
    /// Resistance is `level + viscous * speed` with both constant while neither
    /// direction nor drive force changes: motion between events is then known
    /// in closed form.
    const LINEAR: bool = false;
    /// Resistance depends on `x` or on `sliding_distance`.
    const PLACED: bool = false;

    /// Whether what holds a segment at rest changes with time (`ContactState::t`): if it does not,
    /// integrators watch a resting segment at jumps of the drive only. Held by `tests/laws`.
    #[inline(always)]
    fn ages<L: Lane>(_law: &Self::Coefficients<L>) -> bool {
        false
    }

    /// Force against the motion at `speed` = direction * v. Below zero, where a trial
    /// step may look, it must go on finite.
    fn resistance<L: Lane>(law: &Self::Coefficients<L>, speed: L, at: &ContactState<L>) -> L;

    /// The largest force in `direction` that does not start motion.
    fn break_away<L: Lane>(law: &Self::Coefficients<L>, at: &ContactState<L>) -> L;

    /// Level and viscous coefficient of a linear law.
    #[inline(always)]
    fn linear<L: Lane>(law: &Self::Coefficients<L>, at: &ContactState<L>) -> (L, L) {
        let none = at.x.splat(f64::NAN);
        let _ = law;
        (none, none)
    }
}

/// A law that is a function of speed alone, odd and without a jump.
pub trait Smooth: Law {
    /// Force against the motion, with the sign of `v`.
    fn force<L: Lane>(law: &Self::Coefficients<L>, v: L) -> L;
}

/// Derivatives of a bristle law, for stiff methods. Only the first `STATES`
/// entries count.
#[derive(Debug, Clone, Copy)]
pub struct Partials<L> {
    pub rate_v: [L; MOST_STATES],
    /// `rate_z[i][j]` is d(rate of state i)/d(state j).
    pub rate_z: [[L; MOST_STATES]; MOST_STATES],
    /// Total derivative of the force by the speed, the rates included.
    pub force_v: L,
    /// The same by each state.
    pub force_z: [L; MOST_STATES],
}

impl<L: Lane> Partials<L> {
    /// All zero; `like` only says how many lanes there are.
    #[inline(always)]
    pub fn zero(like: L) -> Self {
        let zero = [like.splat(0.0); MOST_STATES];
        Partials { rate_v: zero, rate_z: [zero; MOST_STATES], force_v: zero[0], force_z: zero }
    }
}

/// A law with states of its own.
pub trait Bristle: Law {
    const STATES: usize;
    /// Size of each state below which its error counts as that of this size.
    const FLOORS: [f64; MOST_STATES] = [1e-8; MOST_STATES];

    /// The state that the drive accelerates in place of the head, a speed, and the inverse of
    /// its mass.
    #[inline(always)]
    fn driven<L: Lane>(law: &Self::Coefficients<L>) -> Option<(usize, L)> {
        let _ = law;
        None
    }

    /// Rates of the states, 1/s of their unit.
    fn rates<L: Lane>(law: &Self::Coefficients<L>, v: L, z: &[L; MOST_STATES]) -> [L; MOST_STATES];

    /// Force against the motion, with the sign of `v` in steady sliding.
    fn force<L: Lane>(
        law: &Self::Coefficients<L>,
        v: L,
        z: &[L; MOST_STATES],
        rates: &[L; MOST_STATES],
    ) -> L;

    fn partials<L: Lane>(law: &Self::Coefficients<L>, v: L, z: &[L; MOST_STATES]) -> Partials<L>;

    /// Whether it is another law at another place, time, direction or drive: see `placed`.
    #[inline(always)]
    fn varies<L: Lane>(law: &Self::Coefficients<L>) -> bool {
        let _ = law;
        false
    }

    /// The law where and when it acts; most are the same everywhere.
    #[inline(always)]
    fn placed<L: Lane>(law: &Self::Coefficients<L>, at: &ContactState<L>) -> Self::Coefficients<L> {
        let _ = at;
        *law
    }

    /// Elastic energy in the states, J.
    fn stored<L: Lane>(law: &Self::Coefficients<L>, z: &[L; MOST_STATES]) -> L;

    /// States after long sliding at `v` (not 0).
    fn steady<L: Lane>(law: &Self::Coefficients<L>, v: L) -> [L; MOST_STATES];
}

/// A smooth law for the stiff method: a bristle law without bristles.
pub struct Stiff<S>(std::marker::PhantomData<S>);

impl<S: Smooth> Law for Stiff<S> {
    const INFO: LawInfo = S::INFO;
    type Coefficients<L: Lane> = S::Coefficients<L>;

    #[inline(always)]
    fn coefficients<L: Lane>(
        contact: &Contact<L>,
        params: &impl Parameters<L>,
    ) -> S::Coefficients<L> {
        S::coefficients(contact, params)
    }
}

impl<S: Smooth> Bristle for Stiff<S> {
    const STATES: usize = 0;

    #[inline(always)]
    fn rates<L: Lane>(_: &S::Coefficients<L>, v: L, _: &[L; MOST_STATES]) -> [L; MOST_STATES] {
        [v.splat(0.0); MOST_STATES]
    }

    #[inline(always)]
    fn force<L: Lane>(
        law: &S::Coefficients<L>,
        v: L,
        _: &[L; MOST_STATES],
        _: &[L; MOST_STATES],
    ) -> L {
        S::force(law, v)
    }

    #[inline(always)]
    fn partials<L: Lane>(law: &S::Coefficients<L>, v: L, _: &[L; MOST_STATES]) -> Partials<L> {
        // A central difference far below the speeds over which laws bend: the
        // method only needs the steepness.
        let width = (v.abs() + 1e-6) * 1e-6;
        let rise = S::force(law, v + width) - S::force(law, v - width);
        Partials { force_v: rise / (width + width), ..Partials::zero(v) }
    }

    #[inline(always)]
    fn stored<L: Lane>(_: &S::Coefficients<L>, z: &[L; MOST_STATES]) -> L {
        z[0].splat(0.0)
    }

    #[inline(always)]
    fn steady<L: Lane>(_: &S::Coefficients<L>, v: L) -> [L; MOST_STATES] {
        [v.splat(0.0); MOST_STATES]
    }
}
