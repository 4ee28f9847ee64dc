//! EFFECT LIST: every cause with the law of its name and with other laws of the
//! same cause, and the disturbances that are nobody's effect. One line each; what
//! a law does stands in the file of its place in the plant.

use std::collections::BTreeMap;

/// One law of one cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Form {
    /// The cause.
    pub name: &'static str,
    /// `law` for the law that the name stands for.
    pub form: &'static str,
    pub params: &'static [&'static str],
}

macro_rules! effects {
    ($($id:ident $name:literal $form:literal { $($field:ident $param:literal),+ })+) => {
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Effect { $($id { $($field: f64),+ }),+ }

        /// In the order of the list.
        pub const FORMS: &[Form] = &[$(Form { name: $name, form: $form, params: &[$($param),+] }),+];

        impl Effect {
            /// Looks an effect up and fills in its parameters.
            pub fn new(
                name: &str,
                form: &str,
                values: &BTreeMap<String, f64>,
            ) -> Result<Effect, String> {
                $(if name == $name && form == $form {
                    let known: &[&str] = &[$($param),+];
                    if let Some(odd) = values.keys().find(|key| !known.contains(&key.as_str())) {
                        return Err(format!("{name} ({form}) has no parameter {odd}: allowed are {known:?}"));
                    }
                    return Ok(Effect::$id { $($field: *values.get($param).ok_or_else(|| {
                        format!("{name} ({form}) needs {}", $param)
                    })?),+ });
                })+
                let forms: Vec<&str> = FORMS.iter().filter(|f| f.name == name).map(|f| f.form).collect();
                Err(if forms.is_empty() {
                    format!("no effect {name}")
                } else {
                    format!("{name} has no form {form}: allowed are {forms:?}")
                })
            }
        }
    };
}

effects! {
    Viscous "viscous_friction" "law" { c "c" }
    ViscousPower "viscous_friction" "power" { c "c", n "n", v0 "v0" }
    Quadratic "quadratic_drag" "law" { c2 "c2" }
    QuadraticPower "quadratic_drag" "power" { c2 "c2", n "n", v0 "v0" }
    Stribeck "stribeck_friction" "law" { f_s "F_s", v_s "v_s", delta "delta" }
    StribeckRational "stribeck_friction" "rational" { f_s "F_s", v_s "v_s" }
    StribeckRamp "stribeck_friction" "ramp" { f_s "F_s", v_s "v_s" }
    Presliding "presliding_compliance" "law" { sigma0 "sigma0", sigma1 "sigma1" }
    PreslidingDahl "presliding_compliance" "dahl" { sigma0 "sigma0" }
    Direction "direction_dependent_friction" "law" { forward "F_c_forward", backward "F_c_backward" }
    DirectionFading "direction_dependent_friction" "fading" { forward "F_c_forward", backward "F_c_backward", v0 "v0" }
    Position "position_dependent_friction" "law" { a "a", length "L", phase "p" }
    PositionBump "position_dependent_friction" "bump" { a "a", at "x0", width "w" }
    PositionStep "position_dependent_friction" "step" { a "a", at "x0", width "w" }
    Load "load_dependent_friction" "law" { mu_l "mu_l" }
    LoadSquare "load_dependent_friction" "square" { mu_l "mu_l", f0 "F0" }
    Drift "friction_drift" "law" { a "a", time "T" }
    DriftLinear "friction_drift" "linear" { a "a", time "T" }
    DriftLate "friction_drift" "late" { a "a", time "T", width "w" }
    Buildup "lubricant_buildup" "law" { k_b "k_b" }
    BuildupLevelling "lubricant_buildup" "levelling" { k_b "k_b", s0 "s0" }
    Saturation "drive_saturation" "law" { f_max "F_max" }
    SaturationKnee "drive_saturation" "knee" { f_max "F_max", sharpness "n" }
    SaturationTanh "drive_saturation" "tanh" { f_max "F_max" }
    Lag "drive_lag" "law" { time "T" }
    LagAsymmetric "drive_lag" "asymmetric" { rise "T_rise", fall "T_fall" }
    LagTwice "drive_lag" "second_order" { time "T" }
    Delay "drive_delay" "law" { time "T" }
    DelayPolled "drive_delay" "polled" { period "T", phase "p" }
    Deadzone "drive_deadzone" "law" { d "d" }
    DeadzoneHysteresis "drive_deadzone" "hysteresis" { open "d_open", close "d_close" }
    DeadzoneSoft "drive_deadzone" "soft" { d "d" }
    Gain "drive_gain_error" "law" { e "e" }
    GainAsymmetric "drive_gain_error" "asymmetric" { forward "e_forward", backward "e_backward" }
    BackEmf "back_emf" "law" { k_e "k_e" }
    BackEmfSaturating "back_emf" "saturating" { k_e "k_e", v0 "v0" }
    Sag "supply_sag" "law" { a "a", time "T" }
    SagLinear "supply_sag" "linear" { a "a", time "T" }
    SagLate "supply_sag" "late" { a "a", time "T", width "w" }
    Backlash "transmission_backlash" "law" { b "b", m_d "m_d" }
    BacklashSoft "transmission_backlash" "soft" { b "b", m_d "m_d", k "k", d "d" }
    Compliance "transmission_compliance" "law" { k "k", d "d", m_d "m_d" }
    ComplianceHardening "transmission_compliance" "hardening" { k "k", d "d", m_d "m_d", s0 "s0" }
    Slope "slope_error" "law" { d_alpha_deg "d_alpha_deg" }
    SlopeUneven "slope_error" "uneven" { d_alpha_deg "d_alpha_deg", a "a", length "L" }
    Payload "payload_mass" "law" { dm "dm" }
    PayloadSwinging "payload_mass" "swinging" { dm "dm", frequency "f", zeta "zeta" }
    CoulombMu "coulomb_error" "law" { d_mu "d_mu" }
    CoulombForce "coulomb_error" "force" { d_force "d_force" }
    CoulombRate "coulomb_error" "rate" { d_force "d_force", a "a", v0 "v0" }
    AnchorSlip "anchor_slip" "law" { mu_static "mu_static", mu_coulomb "mu_coulomb" }
    AnchorSlipFalling "anchor_slip" "falling" { mu_static "mu_static", mu_coulomb "mu_coulomb", v0 "v0" }
    SensorScale "sensor_scale" "law" { e "e" }
    SensorScaleBent "sensor_scale" "bent" { e "e", length "L" }
    SensorDrift "sensor_drift" "law" { b "b" }
    SensorDriftLevelling "sensor_drift" "levelling" { b "b", time "T" }
    SensorDelay "sensor_delay" "law" { time "T" }
    SensorDelayFilter "sensor_delay" "filter" { time "T" }

    Tether "tether" "outside" { k "k", slack "x0" }
    PeriodicPush "periodic_push" "outside" { amplitude "A", frequency "f", phase "p" }
    ColouredPush "coloured_push" "outside" { amplitude "A", time "T" }
    Gusts "gusts" "outside" { amplitude "A", every "T", width "w" }
    MassStep "mass_step" "outside" { share "r", at "t0" }
    Magnet "magnet" "outside" { amplitude "A", at "x0", width "w" }
    Vibration "vibration" "outside" { a "a", frequency "f" }
    Rocking "rocking" "outside" { amplitude "A_deg", frequency "f", phase "p" }
    Wall "wall" "outside" { at "x0", k "k", d "d" }
    ReadingSlips "reading_slips" "outside" { jump "J", every "T" }
    ReadingFreezes "reading_freezes" "outside" { width "w", every "T" }
    DustRidge "dust_ridge" "outside" { amplitude "A", length "L" }
    CableReel "cable_reel" "outside" { pull "A", k "k", at "x0", loss "h", v0 "v0" }
    MainsHum "mains_hum" "outside" { amplitude "A", frequency "f", phase "p" }
    SaggingRail "sagging_rail" "outside" { amplitude "A_deg", at "x0", length "L" }
    LooseEncoder "loose_encoder" "outside" { play "b" }
}

/// The first of `effects` for which `found` has an answer.
pub fn first<T>(effects: &[Effect], found: impl FnMut(&Effect) -> Option<T>) -> Option<T> {
    effects.iter().find_map(found)
}
