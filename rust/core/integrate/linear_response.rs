//! What small forces change of a motion, to first order: they move the head only while it
//! slides, a stop takes its change of speed away, and where it turns round without a rest it
//! keeps the ratio of the accelerations behind and before: its change of time is the same.

use std::ops::Range;

/// A motion at its samples, of runs one after another.
#[derive(Debug, Clone, Copy)]
pub struct Slides<'a> {
    pub v: &'a [f64],
    /// Seconds to the next sample.
    pub step: &'a [f64],
    /// Whether the sample is the last one of its run.
    pub last: &'a [bool],
    pub mass: f64,
    /// Viscous coefficient, N s/m.
    pub damping: f64,
    /// Share of a change of speed that outlasts the time to the next sample, where neither ends
    /// at rest: 1 but where the head turns round.
    pub keeps: &'a [f64],
    /// What pulls the head back by gravity, N/m or N m/rad: minus the force's slope in the position.
    pub stiffness: &'a [f64],
}

impl Slides<'_> {
    /// The share of a change of speed that viscous friction leaves until the next sample.
    pub fn decays(&self) -> Vec<f64> {
        let (mut of, mut decay) = (f64::NAN, 1.0);
        let each = self.step.iter().map(|step| {
            // Samples of a run are mostly as far apart as the last ones.
            if *step != of {
                (of, decay) = (*step, libm::exp(-self.damping * step / self.mass));
            }
            decay
        });
        each.collect()
    }
}

/// Changes of position and speed at the samples of a range, one or several runs, under forces
/// given at all samples, side by side; the range begins a run. `decays` are those of the motion.
#[inline(always)]
pub fn linear_responses<const N: usize>(
    motion: Slides,
    decays: &[f64],
    range: Range<usize>,
    forces: [&[f64]; N],
    mut read: impl FnMut(usize, [f64; N], [f64; N]),
) {
    let (mut x, mut v) = ([0.0; N], [0.0; N]);
    for i in range {
        read(i, x, v);
        if motion.last[i] {
            (x, v) = ([0.0; N], [0.0; N]);
            continue;
        }
        let goes_on = motion.v[i + 1] != 0.0;
        if motion.v[i] == 0.0 && !goes_on {
            v = [0.0; N];
            continue;
        }
        let step = motion.step[i];
        for k in 0..N {
            // Midway, so that a swing neither grows nor fades by the step.
            let pulled = forces[k][i] - motion.stiffness[i] * (x[k] + 0.5 * v[k] * step);
            let after = v[k] * decays[i] + pulled * step / motion.mass;
            x[k] += 0.5 * (v[k] + after) * step;
            v[k] = if goes_on { after * motion.keeps[i] } else { 0.0 };
        }
    }
}

/// Change of position and speed at every sample under a force given at the samples.
pub fn linear_response(
    motion: Slides,
    decays: &[f64],
    force: &[f64],
    dx: &mut [f64],
    dv: &mut [f64],
) {
    linear_responses(motion, decays, 0..force.len(), [force], |i, [x], [v]| {
        (dx[i], dv[i]) = (x, v)
    });
}
