//! GAIT OUTPUT REGISTRY: what the run of a gait tells, one line per output.

use super::GaitTally;

/// A number that a run leaves, with everything a user may ask about it.
#[derive(Debug, Clone, Copy)]
pub struct GaitOutput {
    pub name: &'static str,
    /// TeX.
    pub symbol: &'static str,
    pub unit: &'static str,
    pub meaning: &'static str,
    pub value: fn(&GaitTally<f64>) -> f64,
}

macro_rules! outputs {
    ($($field:ident $symbol:literal [$unit:literal], $meaning:literal;)+) => {
        pub const GAIT_OUTPUTS: &[GaitOutput] = &[$(GaitOutput {
            name: stringify!($field),
            symbol: $symbol,
            unit: $unit,
            meaning: $meaning,
            value: |tally| tally.$field,
        }),+];
    };
}

outputs! {
    velocity r"\bar v" ["m/s"], "mean speed of the robot";
    advance r"\Delta x" ["m"], "mean advance of the segments per cycle";
    last_advance r"\Delta x_n" ["m"], "mean advance of the segments in the last cycle";
    time "T" ["s"], "duration of the run";
    slip_max r"s_\mathrm{b}" ["m"], "way that a segment slides backward per cycle, of the worst segment";
    anchor_safety r"S_\mathrm{a}" ["1"], "what a group of anchors can hold over what it has to, the smallest over time; inf where nothing pushes them back";
    propulsive_mean r"\bar F_P" ["N"], "force of the joints on the moving segments, mean while the gait drives a joint";
    propulsive_peak r"\hat F_P" ["N"], "force of the joints on the moving segments, largest";
    actuator_peak r"\hat F_\mathrm{j}" ["N"], "largest force of any joint's actuator";
    power_mean r"\bar P" ["W"], "electrical power of all motors, mean";
    power_peak r"\hat P" ["W"], "electrical power of all motors, largest";
    electric_energy "E" ["J"], "electrical energy of all motors";
    work "W" ["J"], "work of the drives";
    friction r"W_f" ["J"], "energy lost in friction between segments and ground";
    damping r"W_d" ["J"], "energy lost between drive and joint";
    impact r"W_\iota" ["J"], "energy lost in impacts at the end of strokes; negative where a drive of unlimited force starts with a jerk";
    kinetic r"\Delta E_k" ["J"], "kinetic energy gained";
    potential r"\Delta E_p" ["J"], "potential energy gained on a slope";
    elastic r"\Delta E_e" ["J"], "energy gained in the joints' springs";
    residual r"\varepsilon" ["J"], "work less all losses and gains: what the method itself loses";
    transport_cost r"C_w" ["1"], "work of the drives per weight and distance";
    electric_transport_cost r"C_e" ["1"], "electrical energy per weight and distance";
    steps "n" ["1"], "steps or events of the simulation";
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::Status;

    #[test]
    fn every_result_of_a_run_has_its_line() {
        let tally = GaitTally::none(0.0, Status::NotFinite);
        assert_eq!(GAIT_OUTPUTS.len(), GaitTally::NAMES.len());
        for name in GaitTally::NAMES {
            let output = GAIT_OUTPUTS.iter().find(|o| o.name == *name);
            let output = output.unwrap_or_else(|| panic!("{name} has no line"));
            assert!((output.value)(&tally).is_nan() && !output.meaning.is_empty());
        }
    }
}
