//! Lubricant under a robot with elastic joints: friction levels that follow speed
//! and heap, made anew in every step.
//!
//! A step is solved twice, first with the levels at its start, then with those at its
//! mean speed and half of its way: of second order where the motion is smooth. Whatever
//! the levels are, the ledger takes the impulse that acted times the speed.
//!
//! A heap grows over fresh ground only. Before the run, what lies ahead of the head is
//! fresh, and so is what lies between the places where two neighbours start; whoever
//! comes there first sweeps it. Segments keep their order, so a follower can be the
//! first only on the way to where the segment ahead has started.

use super::stick::Step;
use crate::lane::Lane;
use crate::physics::robot::{MOST_SEGMENTS, Robot};

/// Speed and way from which levels are made.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Levels {
    /// At the start of the step.
    Start,
    /// In the middle of the step that has just been solved.
    Middle,
}

/// Length and implicitness of a step.
#[derive(Clone, Copy)]
pub(super) struct Span<L> {
    pub h: L,
    pub theta: L,
}

impl<L: Lane> Span<L> {
    /// Speed of the segments' motion over the step.
    #[inline(always)]
    fn speed(&self, step: &Step<L>, i: usize) -> L {
        self.theta * step.w[i] + -(self.theta - 1.0) * step.v[i]
    }
}

/// What a step changes.
#[derive(Clone)]
pub(super) struct Heaps<L> {
    /// Fresh ground that each segment has swept since its last rest or turn, m.
    pub swept: [L; MOST_SEGMENTS],
    /// The farthest that each has been from its start, m.
    farthest: [L; MOST_SEGMENTS],
}

pub(super) struct Lubrication<L> {
    pub heaps: Heaps<L>,
    /// Sliding levels of dry friction, as impulses.
    ahead: [L; MOST_SEGMENTS],
    back: [L; MOST_SEGMENTS],
    /// Drag of the lubricant thrown ahead, N s/m.
    plough: [L; MOST_SEGMENTS],
}

impl<L: Lane> Lubrication<L> {
    /// `None` where no segment meets any.
    #[inline(always)]
    pub fn of(robot: &Robot<L>) -> Option<Box<Lubrication<L>>> {
        let zero = [robot.gravity.splat(0.0); MOST_SEGMENTS];
        let heaps = Heaps { swept: zero, farthest: zero };
        let new = || Box::new(Lubrication { heaps, ahead: zero, back: zero, plough: zero });
        (!robot.lubricants.is_empty()).then(new)
    }

    /// Keeps the dry levels of a stretch.
    #[inline(always)]
    pub fn prepare(&mut self, step: &Step<L>) {
        (self.ahead, self.back) = (step.ahead_slide, step.back_slide);
    }

    /// Fresh ground between the farthest that a segment has been and `x`.
    #[inline(always)]
    fn fresh(&self, robot: &Robot<L>, i: usize, x: L) -> L {
        let end = if i == 0 { x } else { x.min(robot.segment_pitch) };
        (end - self.heaps.farthest[i]).max(x.splat(0.0))
    }

    /// Makes the levels of a step, and with them its push and inertia.
    #[inline(always)]
    pub fn levels(
        &mut self,
        levels: Levels,
        robot: &Robot<L>,
        span: Span<L>,
        x: &[L],
        step: &mut Step<L>,
    ) {
        let Span { h, theta } = span;
        let rest = -(theta - 1.0);
        for (i, lubricant) in robot.lubricants.iter().enumerate() {
            let (v, mut swept) = (step.v[i], self.heaps.swept[i]);
            let mut speed = v;
            if levels == Levels::Middle {
                speed = span.speed(step, i);
                swept = swept + self.fresh(robot, i, x[i] + h * speed) * 0.5;
            }
            let share = lubricant.share(speed);
            let (ahead, back) = (self.ahead[i], self.back[i]);
            step.ahead_slide[i] =
                ahead + (step.ahead_hold[i] - ahead) * share + lubricant.heap(swept) * h;
            step.back_slide[i] = back + (step.back_hold[i] - back) * share;
            // Linear in the step's own speed: no step is too long for the square.
            self.plough[i] = lubricant.snowplough * speed.max(v.splat(0.0));
            let segment = &robot.segments[i];
            let drag = segment.viscous + self.plough[i];
            step.inertia[i] = segment.mass + h * theta * drag;
            step.push[i] = (segment.mass - h * rest * drag) * v - h * segment.pull;
        }
    }

    /// Sweeps the ground of a step that has led to `x`; returns what the lubricant thrown
    /// ahead has taken, J.
    #[inline(always)]
    pub fn sweep(&mut self, robot: &Robot<L>, span: Span<L>, x: &[L], step: &Step<L>) -> L {
        let zero = span.h.splat(0.0);
        let mut lost = zero;
        for (i, x) in x.iter().enumerate() {
            let fresh = self.fresh(robot, i, *x);
            let swept = self.heaps.swept[i] + fresh;
            self.heaps.swept[i] = L::select(zero.lt(step.w[i]), swept, zero);
            self.heaps.farthest[i] = self.heaps.farthest[i].max(*x);
            let speed = span.speed(step, i);
            lost = lost + self.plough[i] * (span.h * speed) * speed;
        }
        lost
    }

    /// Takes back a step where the mask does not hold.
    #[inline(always)]
    pub fn restore(&mut self, mask: L::Mask, saved: &Heaps<L>) {
        for i in 0..MOST_SEGMENTS {
            let heaps = &mut self.heaps;
            heaps.swept[i] = L::select(mask, heaps.swept[i], saved.swept[i]);
            heaps.farthest[i] = L::select(mask, heaps.farthest[i], saved.farthest[i]);
        }
    }
}
