//! OUTPUT REGISTRY: what a sweep keeps of each simulated trajectory. A new one
//! is one line in `outputs!` and its arm in `Output::of`.

use crate::describe::Info;
use crate::integrate::{Tally, Watch};
use crate::lane::Lane;
use crate::physics::segment::Segment;

macro_rules! outputs {
    ($($id:ident $name:literal $symbol:literal [$unit:literal] $formula:literal $meaning:literal
       $limits:literal $larger_is_better:literal;)+) => {
        /// One number of a trajectory.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Output { $($id),+ }

        impl Output {
            pub const ALL: &'static [Output] = &[$(Output::$id),+];

            pub const fn info(self) -> Info {
                match self { $(Output::$id => Info {
                    name: $name, symbol: $symbol, unit: $unit, formula: $formula,
                    source: "simulation of m dv/dt = F - R - m g sin(alpha)",
                    limits: $limits, meaning: $meaning,
                    params: if matches!(Output::$id, Output::StrokeTime) { STROKE } else { RUN },
                    integer: matches!(Output::$id, Output::StickPhases),
                    larger_is_better: $larger_is_better,
                }),+ }
            }
        }
    };
}

macro_rules! run {
    ($($more:literal)*) => {
        &["slope_deg", "mass", "gravity", "wall_force", "corner_deg", "drive_limit",
          "spring_stiffness", "spring_damping", "pull_speed", "duration", "time_step",
          "tolerance", "start_position", "start_speed" $(, $more)*]
    };
}

/// Parameters of every run; those of its law and drive come beside.
const RUN: &[&str] = run![];
const STROKE: &[&str] = run!["stroke"];

outputs! {
    FinalPosition "final_position" r"x(T)" ["m"] r"x(T)"
        "position at the end of the run" "one segment on an anchored body" true;
    FinalSpeed "final_speed" r"v(T)" ["m/s"] r"v(T)"
        "speed at the end of the run" "one segment on an anchored body" true;
    PeakPosition "peak_position" r"x_\mathrm{max}" ["m"] r"\max_t x(t)"
        "largest position during the run" "one segment on an anchored body" true;
    PeakMotion "peak_motion" r"|v|_\mathrm{max}" ["m/s"] r"\max_t |v(t)|"
        "largest speed in either direction during the run" "one segment on an anchored body" true;
    AverageVelocity "average_velocity" r"\bar v" ["m/s"] r"(x(T) - x_0)/T"
        "displacement over the time of the run" "one segment on an anchored body" true;
    StrokeTime "stroke_time" r"t_\delta" ["s"] r"\min\{t: x(t) \ge x_0 + \delta\}"
        "time until the stroke is complete" "no value where the run ends before" false;
    StuckTime "stuck_time" r"t_s" ["s"] r"\int [v = 0]\,dt"
        "time at rest, held by friction" "dry laws only: the others never rest" false;
    StickPhases "stick_phases" r"n_s" ["1"] r"\#\{v \to 0, \text{ held}\}"
        "how often motion stopped and friction held" "dry laws only: the others never rest" false;
    WorkIn "work_in" r"W" ["J"] r"\int F v\,dt"
        "work of the drive, its spring included" "one segment on an anchored body" false;
    Dissipated "dissipated" r"Q" ["J"] r"\int R v\,dt - E_\mathrm{el}"
        "energy that friction turned into heat" "one segment on an anchored body" false;
    Stored "stored" r"\Delta E" ["J"]
        r"\tfrac12 m(v^2 - v_0^2) + m g \sin\alpha\,(x - x_0) + E_\mathrm{el}"
        "kinetic, potential and elastic energy gained" "one segment on an anchored body" false;
    EnergyResidual "energy_residual" r"\varepsilon_E" ["1"]
        r"(W - Q - \Delta E)/\left(\int|dW| + \int|dQ|\right)"
        "what the energy ledger leaves open, over all work done"
        "rounding for exact propagation, else the order of the step" false;
}

impl Output {
    #[inline(always)]
    pub fn of<L: Lane>(self, segment: &Segment<L>, tally: &Tally<L>) -> L {
        match self {
            Output::FinalPosition => tally.x,
            Output::FinalSpeed => tally.v,
            Output::PeakPosition => tally.peak_x,
            Output::PeakMotion => tally.peak_v,
            Output::AverageVelocity => (tally.x - segment.x) / segment.duration,
            Output::StrokeTime => tally.stroke_time,
            Output::StuckTime => tally.stuck,
            Output::StickPhases => tally.sticks,
            Output::WorkIn => tally.work,
            Output::Dissipated => tally.heat,
            Output::Stored => tally.stored,
            Output::EnergyResidual => {
                let open = tally.work - tally.heat - tally.stored;
                let zero = open.splat(0.0);
                // Nothing moved, nothing is open.
                L::select(zero.lt(tally.moved), open / tally.moved, zero)
            }
        }
    }

    /// What has to be watched for a set of outputs.
    pub fn watch(wanted: impl Iterator<Item = Output>) -> Watch {
        let mut watch = Watch { energy: false, stroke: false, peaks: false };
        for output in wanted {
            match output {
                Output::StrokeTime => watch.stroke = true,
                Output::PeakPosition | Output::PeakMotion => watch.peaks = true,
                Output::WorkIn | Output::Dissipated | Output::Stored | Output::EnergyResidual => {
                    watch.energy = true
                }
                _ => {}
            }
        }
        watch
    }
}
