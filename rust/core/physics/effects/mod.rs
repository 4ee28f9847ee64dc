//! EFFECT REGISTRY: what a nominal model of a measured run may lack. A new
//! effect is one entry of `effects!` and its arms in the file of its site, where
//! the plant takes it up. Names, laws and parameters are those of the contract
//! that files and reports use.

mod friction;
mod plant;

pub use friction::{Coefficients, Measured};
pub use plant::{Body, Joint, Levels, Nominal, Plant, shortness};

use crate::describe::{Param, nearest};
use crate::error::{Error, Result};

/// Where an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Site {
    Friction,
    Drive,
    Body,
    Environment,
    Sensor,
}

impl Site {
    pub fn name(self) -> &'static str {
        match self {
            Site::Friction => "friction",
            Site::Drive => "drive",
            Site::Body => "body",
            Site::Environment => "environment",
            Site::Sensor => "sensor",
        }
    }
}

/// The value of a parameter at which its effect is not there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Off {
    At(f64),
    /// The nominal Coulomb level.
    Coulomb,
    /// No value does it: another parameter of the effect must be off.
    Never,
}

/// What an effect is, for people and for the registry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectInfo {
    pub name: &'static str,
    pub site: Site,
    /// TeX.
    pub formula: &'static str,
    pub meaning: &'static str,
    pub params: &'static [EffectParam],
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectParam {
    pub param: Param,
    pub off: Off,
}

macro_rules! effects {
    ($($id:ident $name:literal $site:ident $formula:literal $meaning:literal
       { $($param:literal $symbol:literal [$unit:literal] $off:expr, $low:expr => $high:expr,
           $text:literal;)+ })+) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(usize)]
        pub enum Effect { $($id),+ }

        impl Effect {
            pub const ALL: &'static [Effect] = &[$(Effect::$id),+];
        }

        /// In the order of `Effect::ALL`.
        pub const EFFECTS: &[EffectInfo] = &[$(EffectInfo {
            name: $name, site: Site::$site, formula: $formula, meaning: $meaning,
            params: &[$(EffectParam {
                param: Param {
                    name: $param, symbol: $symbol, unit: $unit, default: None,
                    range: ($low, $high), integer: false, file_key: None, meaning: $text,
                },
                off: $off,
            }),+],
        }),+];
    };
}

const INF: f64 = f64::INFINITY;
const ZERO: Off = Off::At(0.0);
const STIFF: Off = Off::At(INF);

effects! {
    ViscousFriction "viscous_friction" Friction r"F_f \mathrel{+}= c v"
        "friction that grows with speed" {
        "c" "c" ["N s/m"] ZERO, -1e9 => 1e9, "viscous coefficient beside the nominal one";
    }
    QuadraticDrag "quadratic_drag" Friction r"F_f \mathrel{+}= c_2 v|v|"
        "drag that grows with the square of speed" {
        "c2" "c_2" ["N s^2/m^2"] ZERO, -1e9 => 1e9, "quadratic coefficient";
    }
    StribeckFriction "stribeck_friction" Friction
        r"F_f \mathrel{+}= (F_s - F_c)\,e^{-|v/v_s|^\delta}\,\mathrm{sgn}\,v,\ \text{break-away at } F_s"
        "friction falls from a higher level at rest" {
        "F_s" "F_s" ["N"] Off::Coulomb, 0.0 => 1e9, "break-away level, at the nominal slope";
        "v_s" "v_s" ["m/s"] Off::Never, 1e-9 => 1e6, "speed over which it falls";
        "delta" r"\delta" ["1"] Off::Never, 0.1 => 4.0, "exponent of the fall";
    }
    PreslidingCompliance "presliding_compliance" Friction
        r"\dot z = v - \sigma_0 |v| z/g,\ F_f = \sigma_0 z + \sigma_1 \dot z"
        "the contact gives way elastically before it slides" {
        "sigma0" r"\sigma_0" ["N/m"] STIFF, 1e-3 => INF, "stiffness of the contact";
        "sigma1" r"\sigma_1" ["N s/m"] Off::Never, 0.0 => 1e9, "damping of the contact";
    }
    DirectionDependentFriction "direction_dependent_friction" Friction
        r"F_c = F_{c+} \text{ for } v > 0,\ F_{c-} \text{ for } v < 0"
        "friction differs between forward and backward" {
        "F_c_forward" r"F_{c+}" ["N"] Off::Coulomb, 0.0 => 1e9, "Coulomb level forward, at the nominal slope";
        "F_c_backward" r"F_{c-}" ["N"] Off::Coulomb, 0.0 => 1e9, "Coulomb level backward, at the nominal slope";
    }
    PositionDependentFriction "position_dependent_friction" Friction
        r"F_c\,(1 + a\sin(2\pi x/L + p))"
        "friction varies along the track" {
        "a" "a" ["1"] ZERO, -1.0 => 1.0, "relative amplitude";
        "L" "L" ["m"] Off::Never, 1e-6 => 1e6, "period along the track";
        "p" "p" ["rad"] Off::Never, -100.0 => 100.0, "phase at the column's zero";
    }
    LoadDependentFriction "load_dependent_friction" Friction
        r"F_f \mathrel{+}= \mu_l |F_d|\,\mathrm{sgn}\,v"
        "friction grows with the drive force" {
        "mu_l" r"\mu_l" ["1"] ZERO, -1.0 => 1e3, "friction per newton of drive force";
    }
    FrictionDrift "friction_drift" Friction r"F_c\,(1 + a(1 - e^{-t/T}))"
        "friction changes over the time of a run" {
        "a" "a" ["1"] ZERO, -1.0 => 1e3, "relative change in the end";
        "T" "T" ["s"] Off::Never, 1e-9 => 1e9, "time over which it changes";
    }
    LubricantBuildup "lubricant_buildup" Friction r"F_f \mathrel{+}= k_b s,\ v > 0"
        "lubricant piles up before the segment as it moves forward" {
        "k_b" "k_b" ["N/m"] ZERO, -1e6 => 1e9, "resistance per distance swept since the last rest or turn";
    }
    DriveSaturation "drive_saturation" Drive r"|F_d| \le F_\mathrm{max}"
        "the drive gives no more than a limit" {
        "F_max" r"F_\mathrm{max}" ["N"] STIFF, 0.0 => INF, "largest drive force";
    }
    DriveLag "drive_lag" Drive r"T\dot F_d + F_d = \mathrm{gain}\cdot\mathrm{drive}"
        "the drive force follows its command slowly" {
        "T" "T" ["s"] ZERO, 0.0 => 1e6, "time constant";
    }
    DriveDelay "drive_delay" Drive r"F_d(t) = \mathrm{gain}\cdot\mathrm{drive}(t - T)"
        "the drive force follows its command late" {
        "T" "T" ["s"] ZERO, -1e3 => 1e6, "delay";
    }
    DriveDeadzone "drive_deadzone" Drive
        r"F_d = 0 \text{ below } d, \text{ else shortened by } d"
        "small commands give no force" {
        "d" "d" ["N"] ZERO, 0.0 => 1e9, "half width of the dead zone";
    }
    DriveGainError "drive_gain_error" Drive r"F_d = (1 + e)\,\mathrm{gain}\cdot\mathrm{drive}"
        "the drive gives more or less than commanded, in proportion" {
        "e" "e" ["1"] ZERO, -1.0 => 1e3, "relative error of the gain";
    }
    BackEmf "back_emf" Drive r"F_d = \mathrm{gain}\cdot\mathrm{drive} - k_e v"
        "the drive gives less the faster it moves" {
        "k_e" "k_e" ["N s/m"] ZERO, -1e9 => 1e9, "loss of force per speed";
    }
    SupplySag "supply_sag" Drive r"\mathrm{gain}\,(1 - a(1 - e^{-t/T}))"
        "the supply sags over the time of a run" {
        "a" "a" ["1"] ZERO, -1e3 => 1.0, "relative loss in the end";
        "T" "T" ["s"] Off::Never, 1e-9 => 1e9, "time over which it sags";
    }
    TransmissionBacklash "transmission_backlash" Drive
        r"m_d \ddot x_d = F_d - F_c,\ F_c = 0 \text{ while } |x_d - x| < b"
        "play between drive and head" {
        "b" "b" ["m"] Off::Never, 0.0 => 1e6, "half the gap";
        "m_d" "m_d" ["kg"] Off::Never, 1e-9 => 1e9, "mass on the drive's side";
    }
    TransmissionCompliance "transmission_compliance" Drive
        r"m_d \ddot x_d = F_d - F_s,\ F_s = k (x_d - x) + d (\dot x_d - v)"
        "a spring between drive and head" {
        "k" "k" ["N/m"] STIFF, 1e-6 => INF, "stiffness";
        "d" "d" ["N s/m"] Off::Never, 0.0 => 1e9, "damping";
        "m_d" "m_d" ["kg"] Off::Never, 1e-9 => 1e9, "mass on the drive's side";
    }
    SlopeError "slope_error" Environment r"\alpha \to \alpha + \Delta\alpha"
        "the ground is steeper or flatter than assumed" {
        "d_alpha_deg" r"\Delta\alpha" ["deg"] ZERO, -90.0 => 90.0, "error of the slope";
    }
    PayloadMass "payload_mass" Body r"m \to m + \Delta m"
        "the head carries more or less mass than assumed" {
        "dm" r"\Delta m" ["kg"] ZERO, -1e9 => 1e9, "error of the mass";
    }
    CoulombError "coulomb_error" Friction r"\mu_C \to \mu_C + \Delta\mu"
        "friction is higher or lower than assumed" {
        "d_mu" r"\Delta\mu" ["1"] ZERO, -1e3 => 1e3, "error of the coefficient";
        "d_force" r"\Delta F" ["N"] ZERO, -1e9 => 1e9, "the same as a force, where the model gives coulomb_force";
    }
    AnchorSlip "anchor_slip" Body
        r"(N-1) m \dot v_r = -F_d - F_r - (N-1) m g \sin\alpha"
        "the anchored body slides where the drive exceeds its grip" {
        "mu_static" r"\mu_{S,r}" ["1"] STIFF, 0.0 => INF, "static friction coefficient of the body";
        "mu_coulomb" r"\mu_{C,r}" ["1"] Off::Never, 0.0 => 1e3, "Coulomb friction coefficient of the body";
    }
    SensorScale "sensor_scale" Sensor r"x \to x_0 + (1 + e)(x - x_0)"
        "the position is read too long or too short" {
        "e" "e" ["1"] ZERO, -1.0 => 1e3, "relative error of the scale";
    }
    SensorDrift "sensor_drift" Sensor r"x \to x + b t"
        "the position reading drifts" {
        "b" "b" ["m/s"] ZERO, -1e6 => 1e6, "drift";
    }
    SensorDelay "sensor_delay" Sensor r"x \to x(t - T)"
        "the position is read late" {
        "T" "T" ["s"] ZERO, -1e3 => 1e6, "delay";
    }
}

/// Number of all parameters of all effects.
pub const EFFECT_PARAMS: usize = {
    let (mut count, mut i) = (0, 0);
    while i < EFFECTS.len() {
        count += EFFECTS[i].params.len();
        i += 1;
    }
    count
};

impl Effect {
    pub fn info(self) -> &'static EffectInfo {
        &EFFECTS[self as usize]
    }

    /// Place of the effect's first parameter among those of all effects.
    pub const fn first(self) -> usize {
        let (mut place, mut i) = (0, 0);
        while i < self as usize {
            place += EFFECTS[i].params.len();
            i += 1;
        }
        place
    }

    pub fn parse(name: &str) -> Result<Effect> {
        let names = || EFFECTS.iter().map(|e| e.name);
        match EFFECTS.iter().position(|e| e.name == name) {
            Some(i) => Ok(Effect::ALL[i]),
            None => Err(Error::UnknownName {
                kind: "effect",
                given: name.to_owned(),
                nearest: nearest(name, names()).map(str::to_owned),
                known: names().map(str::to_owned).collect(),
            }),
        }
    }
}

/// A set of effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, PartialOrd, Ord)]
pub struct Active(u32);

impl Active {
    pub fn with(self, effect: Effect) -> Active {
        Active(self.0 | 1 << effect as usize)
    }

    #[inline(always)]
    pub fn has(self, effect: Effect) -> bool {
        self.0 >> effect as usize & 1 == 1
    }

    pub fn any(self, effects: &[Effect]) -> bool {
        effects.iter().any(|effect| self.has(*effect))
    }

    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.iter().copied().filter(move |effect| self.has(*effect))
    }
}
