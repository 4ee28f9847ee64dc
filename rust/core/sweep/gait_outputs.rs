//! GAIT OUTPUT REGISTRY: what a sweep keeps of each simulated whole robot. A new
//! one is one line in `gait_outputs!`.

use crate::describe::Info;
use crate::integrate::robot::GaitTally;

/// Parameters of every whole robot.
const ROBOT: &[&str] = &[
    "mu_static",
    "mu_coulomb",
    "segments",
    "slope_deg",
    "mass",
    "gravity",
    "stroke",
    "viscous",
    "moving",
    "drive_limit",
    "speed_limit",
    "skin_ratio",
    "wall_force",
    "wall_release",
    "corner_deg",
    "supply_voltage",
    "winding_resistance",
    "force_constant",
    "joint_stiffness",
    "joint_damping",
    "dwell",
    "cycles",
    "impact",
    "break_away",
    "time_step",
    "stribeck_term",
    "stribeck_speed",
    "stribeck_exponent",
    "buildup",
    "buildup_root",
    "snowplough",
    "segment_pitch",
];

macro_rules! gait_outputs {
    ($($id:ident $name:literal $symbol:literal [$unit:literal] $formula:literal $meaning:literal
       $field:ident $larger_is_better:literal;)+) => {
        /// One number of a gait.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum GaitOutput { $($id),+ }

        impl GaitOutput {
            pub const ALL: &'static [GaitOutput] = &[$(GaitOutput::$id),+];

            pub const fn info(self) -> Info {
                match self { $(GaitOutput::$id => Info {
                    name: $name, symbol: $symbol, unit: $unit, formula: $formula,
                    source: "simulation of N segments joined by actuators, sticking decided together",
                    limits: "up to 32 segments; lubricant with elastic joints only", meaning: $meaning, params: ROBOT, integer: false,
                    larger_is_better: $larger_is_better,
                }),+ }
            }

            pub fn of(self, tally: &GaitTally<f64>) -> f64 {
                match self { $(GaitOutput::$id => tally.$field),+ }
            }
        }
    };
}

gait_outputs! {
    Advance "gait_advance" r"\Delta x" ["m"] r"\frac1{n_c N}\sum_i \Delta x_i"
        "mean advance of the segments per cycle" advance true;
    LastAdvance "gait_last_advance" r"\Delta x_n" ["m"] r"\frac1N\sum_i \Delta x_i \text{ in the last cycle}"
        "mean advance of the segments in the last cycle" last_advance true;
    Duration "gait_time" r"t_g" ["s"] r"t_g" "duration of all cycles" time false;
    Velocity "gait_velocity" r"v_g" ["m/s"] r"n_c \Delta x/t_g" "advance over time" velocity true;
    Slip "gait_slip" r"s_b" ["m"] r"\max_i \frac1{n_c}\int [v_i < 0]\,|v_i|\,dt"
        "way that the worst segment slides backward per cycle" slip_max false;
    AnchorSafety "gait_anchor_safety" r"S_a" ["1"] r"\min_t F_A/F"
        "what the anchors could hold over what they must, at worst" anchor_safety true;
    PropulsiveMean "gait_propulsive_mean" r"\bar F_P" ["N"] r"\frac1t\int F_P\,dt"
        "mean force of the joints on the moving segments" propulsive_mean true;
    PropulsivePeak "gait_propulsive_peak" r"\hat F_P" ["N"] r"\max_t F_P"
        "largest force of the joints on the moving segments" propulsive_peak false;
    ActuatorPeak "gait_actuator_peak" r"\hat F_j" ["N"] r"\max_{t,j} |F_j|"
        "largest force of any actuator" actuator_peak false;
    PowerMean "gait_power_mean" r"\bar P_e" ["W"] r"\frac1t\int \sum_j U_j I_j\,dt"
        "mean electrical power of all motors" power_mean false;
    PowerPeak "gait_power_peak" r"\hat P_e" ["W"] r"\max_t \sum_j U_j I_j"
        "largest electrical power of all motors" power_peak false;
    Friction "gait_friction" r"Q_f" ["J"] r"\int \sum_i R_i v_i\,dt" "energy lost in friction" friction false;
    Work "gait_work" r"W_g" ["J"] r"\int \sum_j F_j \dot e_j\,dt" "work of the drives" work false;
    TransportCost "gait_transport_cost" r"c_t" ["1"] r"W/(N m g\, n_c \Delta x)"
        "work over weight and distance" transport_cost false;
    ElectricTransportCost "gait_electric_transport_cost" r"c_e" ["1"] r"E_e/(N m g\, n_c \Delta x)"
        "electrical energy over weight and distance" electric_transport_cost false;
}
