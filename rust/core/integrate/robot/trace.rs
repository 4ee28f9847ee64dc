//! A run as it unfolds, sampled.

/// The robot at one instant.
pub struct Now<'a, L> {
    pub t: L,
    /// Phase of the cycle.
    pub phase: usize,
    pub x: &'a [L],
    pub v: &'a [L],
    /// Of the joints.
    pub force: &'a [L],
    /// 1 slides forward, 0 sticks, -1 slides backward.
    pub slide: &'a [L],
    /// Fresh ground whose lubricant each segment pushes along, m; empty where the robot
    /// meets none.
    pub heap: &'a [L],
    /// Electrical, of all motors.
    pub power: L,
    /// On the moving segments.
    pub propulsive: L,
}

/// Whoever looks on. The unit type does not, and costs nothing.
pub trait Observer<L> {
    const ON: bool;
    fn see(&mut self, now: &Now<L>);
    /// The next time that it wants to see.
    fn next(&self) -> f64 {
        f64::INFINITY
    }
    /// Whether the run is still wanted; asked at every step. One that is not ends
    /// at once and has no result.
    fn go_on(&self) -> bool {
        true
    }
}

impl<L> Observer<L> for () {
    const ON: bool = false;
    fn see(&mut self, _: &Now<L>) {}
}

/// One row per sample; the rows of `x`, `v` and `slide` have a number per
/// segment, those of `force` one per joint.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    pub segments: usize,
    /// s.
    pub t: Vec<f64>,
    pub phase: Vec<usize>,
    /// m, m/s, N.
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub force: Vec<f64>,
    /// 1 slides forward, 0 sticks, -1 slides backward.
    pub slide: Vec<i8>,
    /// Fresh ground whose lubricant each segment pushes along, m; empty where the robot
    /// meets none.
    pub heap: Vec<f64>,
    /// Electrical power of all motors, W.
    pub power: Vec<f64>,
    /// Force of the joints on the moving segments, N.
    pub propulsive: Vec<f64>,
    /// s between samples.
    every: f64,
}

impl Trace {
    /// A trace that keeps a sample every `every` seconds, or every step where
    /// that is longer.
    pub fn new(every: f64) -> Trace {
        Trace { every, ..Trace::default() }
    }

    pub fn len(&self) -> usize {
        self.t.len()
    }

    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Positions of one segment over time.
    pub fn segment(&self, i: usize) -> Vec<f64> {
        self.x.iter().skip(i).step_by(self.segments).copied().collect()
    }
}

impl Observer<f64> for Trace {
    const ON: bool = true;

    fn see(&mut self, now: &Now<f64>) {
        // A sample that rounding has put just before its time is meant.
        if now.t < self.next() - 1e-9 * self.every {
            return;
        }
        self.segments = now.x.len();
        self.t.push(now.t);
        self.phase.push(now.phase);
        self.x.extend_from_slice(now.x);
        self.v.extend_from_slice(now.v);
        self.force.extend_from_slice(now.force);
        self.slide.extend(now.slide.iter().map(|s| *s as i8));
        self.heap.extend_from_slice(now.heap);
        self.power.push(now.power);
        self.propulsive.push(now.propulsive);
    }

    fn next(&self) -> f64 {
        // From the last sample on, so that a coarse step leaves no backlog.
        self.t.last().map_or(0.0, |t| ((t / self.every + 1e-9).floor() + 1.0) * self.every)
    }
}
