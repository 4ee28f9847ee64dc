//! What small forces change of a motion, to first order: they move the head only while it
//! slides, a stop takes its change of speed away, and where it turns round without a rest it
//! keeps the ratio of the accelerations behind and before: its change of time is the same.

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

/// Change of position and speed at every sample under a force given at the samples.
pub fn linear_response(motion: Slides, force: &[f64], dx: &mut [f64], dv: &mut [f64]) {
    let (mut x, mut v) = (0.0, 0.0);
    for i in 0..force.len() {
        (dx[i], dv[i]) = (x, v);
        if motion.last[i] {
            (x, v) = (0.0, 0.0);
            continue;
        }
        let goes_on = motion.v[i + 1] != 0.0;
        if motion.v[i] == 0.0 && !goes_on {
            v = 0.0;
            continue;
        }
        let step = motion.step[i];
        let decay = libm::exp(-motion.damping * step / motion.mass);
        // Midway, so that a swing neither grows nor fades by the step.
        let pulled = force[i] - motion.stiffness[i] * (x + 0.5 * v * step);
        let after = v * decay + pulled * step / motion.mass;
        x += 0.5 * (v + after) * step;
        v = if goes_on { after * motion.keeps[i] } else { 0.0 };
    }
}
