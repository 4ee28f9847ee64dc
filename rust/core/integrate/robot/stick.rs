//! The same decision as `chain`, for many robots at once: guess the modes (those
//! of the step before), solve the tridiagonal system that they leave, and
//! correct what contradicts it. Nearly every step needs one or two rounds; the
//! few lanes that have not settled then are handed to the exact solver.

use super::chain::{Body, Chain, Link, Sliding, solve_with_break_away};
use crate::lane::Lane;
use crate::physics::robot::MOST_SEGMENTS;

/// Rounds before a lane goes to the exact solver. Guessing settles in about as
/// many rounds as there are changes along the chain.
const ROUNDS: usize = 12;

/// One step as a chain: impulses, and speeds after it.
pub struct Step<L> {
    pub n: usize,
    /// Mass, with what is implicit in the friction of the ground.
    pub inertia: [L; MOST_SEGMENTS],
    pub push: [L; MOST_SEGMENTS],
    pub ahead_slide: [L; MOST_SEGMENTS],
    pub ahead_hold: [L; MOST_SEGMENTS],
    pub back_slide: [L; MOST_SEGMENTS],
    pub back_hold: [L; MOST_SEGMENTS],
    pub gain: [L; MOST_SEGMENTS],
    pub bias: [L; MOST_SEGMENTS],
    pub limit: [L; MOST_SEGMENTS],
    /// Speeds before the step.
    pub v: [L; MOST_SEGMENTS],
    /// 1 slides forward, 0 sticks, -1 slides backward: the guess, then the answer.
    pub slide: [L; MOST_SEGMENTS],
    /// 1 or -1 at the limit of the joint's force, else 0.
    pub bound: [L; MOST_SEGMENTS],
    /// Speeds after the step.
    pub w: [L; MOST_SEGMENTS],
    /// Impulses of the joints.
    pub q: [L; MOST_SEGMENTS],
    /// Lanes times steps that went to the exact solver.
    pub handed_over: u64,
    /// Friction levels that count in this step.
    ahead: [L; MOST_SEGMENTS],
    back: [L; MOST_SEGMENTS],
    /// Forward elimination.
    y: [L; MOST_SEGMENTS],
    carry: [L; MOST_SEGMENTS],
    chain: Chain,
}

/// Modes and friction levels of one lane.
struct Answer {
    slide: [f64; MOST_SEGMENTS],
    bound: [f64; MOST_SEGMENTS],
    bodies: Vec<Body>,
}

impl<L: Lane> Step<L> {
    pub fn new(n: usize, like: L) -> Step<L> {
        let zero = [like.splat(0.0); MOST_SEGMENTS];
        Step {
            n,
            inertia: zero,
            push: zero,
            ahead_slide: zero,
            ahead_hold: zero,
            back_slide: zero,
            back_hold: zero,
            gain: zero,
            bias: zero,
            limit: zero,
            v: zero,
            slide: zero,
            bound: zero,
            w: zero,
            q: zero,
            handed_over: 0,
            ahead: zero,
            back: zero,
            y: zero,
            carry: zero,
            chain: Chain::default(),
        }
    }

    /// Friction levels that count: a segment that moved, or has broken away,
    /// meets the sliding level in its direction, all others the break-away level.
    #[inline(always)]
    fn levels(&mut self) {
        for i in 0..self.n {
            let v = self.v[i];
            let rest = v.splat(0.0);
            self.ahead[i] = L::select(v.gt(rest), self.ahead_slide[i], self.ahead_hold[i]);
            self.back[i] = L::select(v.lt(rest), self.back_slide[i], self.back_hold[i]);
        }
    }

    /// Speeds and impulses of the guessed modes.
    #[inline(always)]
    fn guess(&mut self) {
        let n = self.n;
        let zero = self.v[0].splat(0.0);
        let half = self.v[0].splat(0.5);
        let (mut inverse, mut gain_ahead, mut bias_ahead, mut y_ahead) = (zero, zero, zero, zero);
        for i in 0..n {
            let (slide, bound) = (self.slide[i], self.bound[i]);
            let free = bound.abs().lt(half);
            let (mut gain, mut bias) = (zero, zero);
            if i + 1 < n {
                gain = L::select(free, self.gain[i], zero);
                bias = L::select(free, self.bias[i], bound * self.limit[i]);
            }
            let friction = L::select(slide.gt(zero), self.ahead[i], -self.back[i]);
            let diagonal = self.inertia[i] + gain + gain_ahead - gain_ahead * gain_ahead * inverse;
            let right = self.push[i] + bias - bias_ahead - friction + gain_ahead * y_ahead;
            // A zero in place of the pivot's inverse pins w to zero.
            inverse = L::select(slide.abs().lt(half), zero, zero.splat(1.0) / diagonal);
            y_ahead = right * inverse;
            self.y[i] = y_ahead;
            self.carry[i] = gain * inverse;
            (gain_ahead, bias_ahead) = (gain, bias);
        }
        let mut behind = zero;
        for i in (0..n).rev() {
            behind = self.y[i] + self.carry[i] * behind;
            self.w[i] = behind;
        }
    }

    /// Corrects the modes by the guess; returns 1 where a lane had to.
    #[inline(always)]
    fn correct(&mut self) -> L {
        let n = self.n;
        let zero = self.v[0].splat(0.0);
        let half = self.v[0].splat(0.5);
        let one = self.v[0].splat(1.0);
        let mut changed = zero;
        let mut q_ahead = zero;
        for i in 0..n {
            let mut q = zero;
            if i + 1 < n {
                let limit = self.limit[i];
                let trial = self.bias[i] - self.gain[i] * (self.w[i] - self.w[i + 1]);
                q = trial.min(limit).max(-limit);
                let over = L::select((-limit).gt(trial), -one, zero);
                let bound = L::select(trial.gt(limit), one, over);
                changed = changed.max((bound - self.bound[i]).abs());
                self.bound[i] = bound;
                self.q[i] = q;
            }
            let (slide, w) = (self.slide[i], self.w[i]);
            let need = self.push[i] + q - q_ahead;
            let starts = L::select((-self.back[i]).gt(need), -one, zero);
            let starts = L::select(need.gt(self.ahead[i]), one, starts);
            let goes_on = L::select((slide * w).gt(zero), slide, zero);
            let mode = L::select(slide.abs().lt(half), starts, goes_on);
            changed = changed.max((mode - slide).abs());
            self.slide[i] = mode;
            q_ahead = q;
        }
        changed
    }

    /// Segments that broke away fall to the sliding level; 1 where one did.
    #[inline(always)]
    fn break_away(&mut self, settled: L::Mask) -> L {
        let zero = self.v[0].splat(0.0);
        let one = self.v[0].splat(1.0);
        let mut broke = zero;
        for i in 0..self.n {
            let (slide, ahead, back) = (self.slide[i], self.ahead[i], self.back[i]);
            let (a, b) = (self.ahead_slide[i], self.back_slide[i]);
            let forward = L::and(slide.gt(zero), ahead.gt(a));
            let backward = L::and(slide.lt(zero), back.gt(b));
            let falls = L::and(settled, L::or(forward, backward));
            self.ahead[i] = L::select(falls, a, ahead);
            self.back[i] = L::select(falls, b, back);
            broke = L::select(falls, one, broke);
        }
        broke
    }

    /// Solves the step.
    #[inline(always)]
    pub fn solve(&mut self) {
        let zero = self.v[0].splat(0.0);
        let half = self.v[0].splat(0.5);
        self.levels();
        let mut open = zero;
        for _ in 0..ROUNDS {
            self.guess();
            let changed = self.correct();
            open = changed.max(self.break_away(changed.lt(half)));
            if !L::any(open.gt(half)) {
                return;
            }
        }
        open.outlined(
            #[inline(always)]
            || self.exactly(open),
        );
    }

    /// Finishes the lanes that are still open one by one.
    #[inline(always)]
    fn exactly(&mut self, open: L) {
        // The open lanes begin anew, with nothing broken away.
        let (ahead, back) = (self.ahead, self.back);
        self.levels();
        let mut answers: Vec<Option<Answer>> = Vec::new();
        open.map(|is_open| {
            let answer = (is_open > 0.5).then(|| self.one_lane(answers.len()));
            answers.push(answer);
            is_open
        });
        self.handed_over += answers.iter().flatten().count() as u64;
        for i in 0..self.n {
            let pick = |old: L, new: &dyn Fn(&Answer) -> f64| {
                old.fill(|k| answers[k].as_ref().map_or(old.lane(k), new))
            };
            self.slide[i] = pick(self.slide[i], &|a| a.slide[i]);
            self.bound[i] = pick(self.bound[i], &|a| a.bound[i]);
            self.ahead[i] = pick(ahead[i], &|a| a.bodies[i].ahead);
            self.back[i] = pick(back[i], &|a| a.bodies[i].back);
        }
        let modes = (self.slide, self.bound);
        self.guess();
        // Joint impulses of these speeds; the modes stay what they are.
        self.correct();
        (self.slide, self.bound) = modes;
    }

    fn one_lane(&mut self, k: usize) -> Answer {
        let n = self.n;
        let body = |i: usize| Body {
            inertia: self.inertia[i].lane(k),
            push: self.push[i].lane(k),
            ahead: self.ahead[i].lane(k),
            back: self.back[i].lane(k),
        };
        let sliding = |i: usize| Sliding {
            ahead: self.ahead_slide[i].lane(k),
            back: self.back_slide[i].lane(k),
        };
        let link = |i: usize| Link {
            gain: self.gain[i].lane(k),
            bias: self.bias[i].lane(k),
            low: -self.limit[i].lane(k),
            high: self.limit[i].lane(k),
        };
        let mut bodies: Vec<Body> = (0..n).map(body).collect();
        let sliding: Vec<Sliding> = (0..n).map(sliding).collect();
        let links: Vec<Link> = (0..n - 1).map(link).collect();
        solve_with_break_away(&mut self.chain, &mut bodies, &sliding, &links);
        let sign = |x: f64| f64::from(i8::from(x > 0.0) - i8::from(x < 0.0));
        let (mut slide, mut bound) = ([0.0; MOST_SEGMENTS], [0.0; MOST_SEGMENTS]);
        for i in 0..n {
            slide[i] = sign(self.chain.w[i]);
            if i + 1 < n && self.chain.q[i].abs() >= links[i].high {
                bound[i] = sign(self.chain.q[i]);
            }
        }
        Answer { slide, bound, bodies }
    }
}
