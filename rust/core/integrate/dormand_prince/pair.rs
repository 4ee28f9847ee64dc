//! One step of the pair of order 5 and 4 of Dormand and Prince 1980.

use super::dense::Quartic;

/// Where the stages stand within a step.
pub const NODES: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];

/// What each stage takes of the slopes before it; the last one is the step
/// itself, whose slope only serves the error and the dense output.
pub const STAGES: [[f64; 6]; 7] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    WEIGHTS,
];

pub const WEIGHTS: [f64; 6] =
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];

/// Fifth order less fourth.
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// What dense output takes beyond the cubic through both ends (Shampine 1986).
const BEYOND: [f64; 7] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];

/// Slopes of one component at all stages.
pub type Slopes = [f64; 7];

fn sum(weights: &[f64], slopes: &Slopes) -> f64 {
    weights.iter().zip(slopes).map(|(weight, slope)| weight * slope).sum()
}

/// Where stage `i` stands that starts from `from`.
pub fn stage(i: usize, from: f64, dt: f64, slopes: &Slopes) -> f64 {
    from + dt * sum(&STAGES[i][..i.min(6)], slopes)
}

/// By how much the fifth order differs from the fourth.
pub fn error(dt: f64, slopes: &Slopes) -> f64 {
    dt * sum(&ERROR, slopes)
}

/// The component over the step.
pub fn dense(from: f64, to: f64, dt: f64, slopes: &Slopes) -> Quartic {
    let ends = (dt * slopes[0], dt * slopes[6]);
    Quartic::new((from, to), ends, dt * sum(&BEYOND, slopes))
}
