//! Which segments of a chain stick, decided for all of them together and
//! exactly.
//!
//! With w_i the speeds after a step (or the accelerations at an instant), each
//! segment obeys `inertia w_i = push + q_i - q_(i-1) - friction(w_i)` and each
//! joint `q = clamp(bias - gain (w_i - w_(i+1)), low, high)`. Friction and
//! joints are monotone, so what the chain ahead of a joint does to it is one
//! monotone polyline "force over speed", and polylines pass from segment to
//! segment: no guess, no iteration, one answer.

use crate::physics::robot::MOST_SEGMENTS;

/// A segment of the chain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    pub inertia: f64,
    pub push: f64,
    /// Friction levels where it slides forward and backward. At w = 0 friction
    /// is anything between them.
    pub ahead: f64,
    pub back: f64,
}

/// A joint of the chain. One without limits and with an infinite gain is rigid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    pub gain: f64,
    pub bias: f64,
    /// Largest force backward and forward, both finite or both infinite.
    pub low: f64,
    pub high: f64,
}

impl Link {
    pub const RIGID: Link = Link::held(f64::NEG_INFINITY, f64::INFINITY);
    /// A force that does not depend on the speeds.
    pub fn force(bias: f64) -> Link {
        Link { gain: 0.0, bias, low: f64::NEG_INFINITY, high: f64::INFINITY }
    }
    /// Rigid between two forces.
    pub const fn held(low: f64, high: f64) -> Link {
        Link { gain: f64::INFINITY, bias: 0.0, low, high }
    }
}

#[derive(Debug, Clone, Copy)]
struct Vertex {
    w: f64,
    q: f64,
}

/// A monotone polyline, with rays of slope `before` and `after` at its ends.
#[derive(Debug, Clone, Default)]
struct Line {
    at: Vec<Vertex>,
    before: f64,
    after: f64,
}

/// Working memory, and the answer.
#[derive(Debug, Clone, Default)]
pub struct Chain {
    lines: Vec<Line>,
    joints: Vec<Line>,
    /// Speeds (or accelerations). Exactly zero where a segment sticks.
    pub w: Vec<f64>,
    /// Forces of the joints.
    pub q: Vec<f64>,
}

impl Line {
    /// The force at `w`; of a vertical piece the point nearest to `wanted`.
    fn force(&self, w: f64, wanted: f64) -> f64 {
        let first = self.at.partition_point(|v| v.w < w);
        let last = self.at.partition_point(|v| v.w <= w);
        if first < last {
            return wanted.max(self.at[first].q).min(self.at[last - 1].q);
        }
        match (first.checked_sub(1).map(|i| self.at[i]), self.at.get(first)) {
            (None, Some(b)) => b.q + self.before * (w - b.w),
            (Some(a), None) => a.q + self.after * (w - a.w),
            (Some(a), Some(b)) => a.q + (b.q - a.q) * ((w - a.w) / (b.w - a.w)),
            (None, None) => self.before * w,
        }
    }

    /// The speed at force `q`; on a vertical piece exactly its speed.
    fn speed(&self, q: f64) -> f64 {
        let next = self.at.partition_point(|v| v.q < q);
        match (next.checked_sub(1).map(|i| self.at[i]), self.at.get(next)) {
            (None, Some(b)) if q == b.q => b.w,
            (None, Some(b)) => b.w + (q - b.q) / self.before,
            (Some(a), None) => a.w + (q - a.q) / self.after,
            (Some(a), Some(b)) if a.w == b.w || b.q == q => b.w,
            (Some(a), Some(b)) => a.w + (b.w - a.w) * ((q - a.q) / (b.q - a.q)),
            (None, None) => q / self.before,
        }
    }

    /// Adds what a segment takes for itself.
    fn add(&mut self, body: &Body) {
        let own = |w: f64| body.inertia * w - body.push;
        let jump = body.ahead != 0.0 || body.back != 0.0;
        if !jump {
            if self.at.is_empty() {
                self.at.push(Vertex { w: 0.0, q: 0.0 });
            }
            self.at.iter_mut().for_each(|v| v.q += own(v.w));
        } else {
            let first = self.at.partition_point(|v| v.w < 0.0);
            // Numbers out of range lose their order; they must not lose the process.
            let last = self.at.partition_point(|v| v.w <= 0.0).max(first);
            let low = self.force(0.0, f64::NEG_INFINITY);
            let high = self.force(0.0, f64::INFINITY);
            self.at[..first].iter_mut().for_each(|v| v.q += own(v.w) - body.back);
            self.at[last..].iter_mut().for_each(|v| v.q += own(v.w) + body.ahead);
            let kink = [
                Vertex { w: 0.0, q: low - body.push - body.back },
                Vertex { w: 0.0, q: high - body.push + body.ahead },
            ];
            self.at.splice(first..last, kink);
        }
        self.before += body.inertia;
        self.after += body.inertia;
    }

    /// What the joint behind passes on to the next segment, whose speed lies between
    /// `-bound` and `bound`.
    fn pass(&self, link: &Link, bound: f64, to: &mut Line) {
        to.at.clear();
        (to.before, to.after) = (0.0, 0.0);
        if link.gain == 0.0 {
            // Kept where the next kink may come, so that the ray needs no place.
            to.at.push(Vertex { w: 0.0, q: link.bias });
            return;
        }
        let yields = link.gain.is_finite();
        let (low, high) = (link.low, link.high);
        let behind = |v: &Vertex| Vertex {
            w: v.w + if yields { (v.q - link.bias) / link.gain } else { 0.0 },
            q: v.q,
        };
        let vertex = |q: f64| behind(&Vertex { w: self.speed(q), q });
        if high.is_infinite() {
            let series = |slope: f64| 1.0 / (1.0 / slope + 1.0 / link.gain);
            (to.before, to.after) = (series(self.before), series(self.after));
            to.at.extend(self.at.iter().map(behind));
        } else {
            to.at.push(vertex(low));
            to.at.extend(self.at.iter().filter(|v| v.q > low && v.q < high).map(behind));
            to.at.push(vertex(high));
        }
        if yields && bound.is_finite() {
            // A gain far below the inertia moves kinks outward by their ratio, at every
            // joint anew; between two that lie so far out a force has no digits left.
            let ends = [-bound, bound].map(|w| Vertex { w, q: self.force_behind(link, w) });
            to.at.retain(|v| v.w.abs() < bound);
            to.at.insert(0, ends[0]);
            to.at.push(ends[1]);
        }
    }

    /// Force of the joint behind where the next segment has the speed `w`.
    fn force_behind(&self, link: &Link, w: f64) -> f64 {
        let next = self.at.partition_point(|v| v.w + (v.q - link.bias) / link.gain < w);
        let (near, slope) = match (next.checked_sub(1), self.at.get(next)) {
            (None, _) => (self.at[0], self.before),
            (Some(a), None) => (self.at[a], self.after),
            (Some(a), Some(b)) => {
                let a = self.at[a];
                (a, (b.q - a.q) / (b.w - a.w))
            }
        };
        // Line and joint in series: a weighted mean, in which nothing cancels.
        let joint = link.bias + link.gain * (w - near.w);
        let share = if slope.is_finite() { slope / (slope + link.gain) } else { 1.0 };
        (near.q * (1.0 - share) + joint * share).max(link.low).min(link.high)
    }
}

/// Bound of every joint's force: what the joints want, and what the segments add to it
/// on the way. Forces spread along the chain by means of neighbours, which exceed nothing.
fn strongest(bodies: &[Body], links: &[Link]) -> f64 {
    let limit = |x: f64| if x.is_finite() { x.abs() } else { 0.0 };
    let given = |link: &Link| link.bias.abs().max(limit(link.low)).max(limit(link.high));
    links.iter().map(given).fold(0.0, f64::max) + bodies.iter().map(load).sum::<f64>()
}

/// Most that a segment takes or gives by itself at rest.
fn load(body: &Body) -> f64 {
    body.push.abs() + body.ahead.abs().max(body.back.abs())
}

/// Room for rounding in the bound of a segment's speed: any factor above 1 will do, as
/// kinks beyond the bound only cost digits.
const ROOM: f64 = 2.0;

/// Bound of a segment's speed where joints have at most this force.
fn fastest(body: &Body, force: f64) -> f64 {
    ROOM * (load(body) + 2.0 * force) / body.inertia
}

impl Chain {
    /// Solves for `w` and `q`. Where rigid joints leave the share of each
    /// sticking segment open, those nearest to the tail take the least.
    pub fn solve(&mut self, bodies: &[Body], links: &[Link]) {
        let n = bodies.len();
        self.lines.resize_with(n, Line::default);
        self.joints.resize_with(n, Line::default);
        self.w.resize(n, 0.0);
        self.q.resize(n, 0.0);
        let force = strongest(bodies, links);
        for i in 0..n {
            let line = &mut self.lines[i];
            if i == 0 {
                line.at.clear();
                (line.before, line.after) = (0.0, 0.0);
            } else {
                line.clone_from(&self.joints[i - 1]);
            }
            line.add(&bodies[i]);
            if i + 1 < n {
                let bound = fastest(&bodies[i + 1], force);
                line.pass(&links[i], bound, &mut self.joints[i]);
            }
        }
        let mut q = 0.0;
        for i in (0..n).rev() {
            let w = self.lines[i].speed(q);
            self.w[i] = w;
            self.q[i] = q;
            if i > 0 {
                // With no friction of its own the segment would pass on this much.
                let free = q + bodies[i].push - bodies[i].inertia * w;
                q = self.joints[i - 1].force(w, free);
            }
        }
        self.q.truncate(n.saturating_sub(1));
    }
}

/// Friction of a body once it slides, where more than that holds it at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sliding {
    pub ahead: f64,
    pub back: f64,
}

/// Solves a chain whose segments may break away: those that cannot hold at the
/// levels in `bodies` fall to their sliding levels, which may take others with
/// them, until none follows.
pub fn solve_with_break_away(
    chain: &mut Chain,
    bodies: &mut [Body],
    slide: &[Sliding],
    links: &[Link],
) {
    let mut broken = [false; MOST_SEGMENTS];
    // One more falls in every round but the last.
    for _ in 0..=bodies.len() {
        chain.solve(bodies, links);
        let mut more = false;
        for (i, body) in bodies.iter_mut().enumerate() {
            let falls = (chain.w[i] > 0.0 && body.ahead > slide[i].ahead)
                || (chain.w[i] < 0.0 && body.back > slide[i].back);
            if falls && !broken[i] {
                broken[i] = true;
                body.ahead = slide[i].ahead;
                body.back = slide[i].back;
                more = true;
            }
        }
        if !more {
            return;
        }
    }
}
