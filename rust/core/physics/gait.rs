//! GAIT REGISTRY: which segments move, which joints are driven and who grips,
//! phase by phase. A new gait is one line here and the function that it names.

use super::status::Status;

/// Most segments of a simulated robot.
pub const MOST_SEGMENTS: usize = 32;
use crate::describe::nearest;
use crate::error::{Error, Result};
use std::f64::consts::PI;

/// How a segment holds on to the wall during a phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grip {
    /// With the whole wall force.
    Full,
    /// Without the share `wall_release` of it.
    Eased,
    /// Not at all.
    Free,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    /// Lengths that the joints reach, in strokes.
    pub target: Vec<f64>,
    /// Duration in units of stroke over speed.
    pub pace: f64,
    /// Which segments are meant to move; the others are the anchors.
    pub moves: Vec<bool>,
    pub grip: Vec<Grip>,
    /// Whether the robot rests after it.
    pub rests: bool,
}

/// One cycle of a gait.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    /// Lengths of the joints before the first phase, in strokes.
    pub start: Vec<f64>,
    pub phases: Vec<Phase>,
    /// Advance per cycle on perfect anchors, in strokes.
    pub travel: f64,
}

/// What a gait is, for people and for the registry.
#[derive(Debug)]
pub struct GaitInfo {
    pub name: &'static str,
    pub meaning: &'static str,
    build: fn(usize, usize) -> Schedule,
}

macro_rules! gaits {
    ($($id:ident $name:literal $build:ident, $meaning:literal;)+) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Gait { $($id),+ }

        pub const GAITS: &[Gait] = &[$(Gait::$id),+];

        impl Gait {
            pub fn info(self) -> &'static GaitInfo {
                match self {
                    $(Gait::$id => &GaitInfo { name: $name, meaning: $meaning, build: $build }),+
                }
            }
        }
    };
}

gaits! {
    Single "single" single,
        "one segment after another moves forward by a stroke, from head to tail (the paper's gait)";
    Block "block" block,
        "blocks of `moving` segments move forward by a stroke, one block after another from head to tail";
    Window "window" window,
        "a window of `moving` segments, shifted by one from phase to phase, moves forward by a stroke: each segment moves `moving` times in a cycle";
    Wave "wave" wave,
        "a smooth wave of joint lengths travels from head to tail; at any time about `moving` segments move, and no joint changes by more than a stroke";
    Inchworm "inchworm" inchworm,
        "the rear segment grips the wall while all joints extend by a stroke, then the head grips while they contract; the others press on nothing but the ground";
    Concertina "concertina" concertina,
        "as `block`, and the moving segments let go the share `wall_release` of the force that presses them to the wall";
}

impl Gait {
    pub fn name(self) -> &'static str {
        self.info().name
    }

    pub fn parse(name: &str) -> Result<Gait> {
        let names = || GAITS.iter().map(|g| g.name());
        GAITS.iter().copied().find(|g| g.name() == name).ok_or_else(|| Error::UnknownName {
            kind: "gait",
            given: name.to_owned(),
            nearest: nearest(name, names()).map(str::to_owned),
            known: names().map(str::to_owned).collect(),
        })
    }

    /// The cycle of a robot of `segments` segments, `moving` of them at once.
    pub fn schedule(self, segments: usize, moving: usize) -> std::result::Result<Schedule, Status> {
        if segments > MOST_SEGMENTS {
            return Err(Status::TooManySegments);
        }
        let moving = if matches!(self, Gait::Single | Gait::Inchworm) { 1 } else { moving };
        if segments < 2 || moving < 1 || moving >= segments {
            return Err(Status::NothingAnchored);
        }
        Ok((self.info().build)(segments, moving))
    }
}

impl Schedule {
    /// A schedule from the displacements (in strokes) that each segment has
    /// reached after each phase, the first row being the start.
    fn of(rows: &[Vec<f64>], moves: &[Vec<bool>], grip: Grip, rests: bool) -> Schedule {
        let lengths = |row: &Vec<f64>| row.windows(2).map(|w| w[0] - w[1]).collect::<Vec<_>>();
        let phase = |(rows, moves): (&[Vec<f64>], &Vec<bool>)| {
            let (before, target) = (lengths(&rows[0]), lengths(&rows[1]));
            let pace = before.iter().zip(&target).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
            let grip = moves.iter().map(|m| if *m { grip } else { Grip::Full }).collect();
            Phase { target, pace, moves: moves.clone(), grip, rests }
        };
        let phases: Vec<Phase> = rows.windows(2).zip(moves).map(phase).collect();
        let last = rows.len() - 1;
        Schedule { start: lengths(&rows[0]), phases, travel: rows[last][0] - rows[0][0] }
    }

    /// From the segments that move forward by a stroke in each phase.
    fn steps(moves: &[Vec<bool>], grip: Grip) -> Schedule {
        let mut rows = vec![vec![0.0; moves[0].len()]];
        for movers in moves {
            let before = &rows[rows.len() - 1];
            let after = before.iter().zip(movers).map(|(x, m)| x + f64::from(u8::from(*m)));
            rows.push(after.collect());
        }
        Schedule::of(&rows, moves, grip, true)
    }

    /// Ends of the runs of neighbouring segments that move (or do not) in a
    /// phase.
    pub fn groups(phase: &Phase, moving: bool) -> Vec<(usize, usize)> {
        let mut groups: Vec<(usize, usize)> = Vec::new();
        for (i, moves) in phase.moves.iter().enumerate() {
            if *moves != moving {
                continue;
            }
            match groups.last_mut() {
                Some(last) if last.1 + 1 == i => last.1 = i,
                _ => groups.push((i, i)),
            }
        }
        groups
    }

    /// The gait of the robot seen in a mirror: the head is the rear.
    pub fn mirrored(&self) -> Schedule {
        let flip = |list: &Vec<f64>| list.iter().rev().copied().collect::<Vec<_>>();
        let phase = |p: &Phase| Phase {
            target: flip(&p.target),
            pace: p.pace,
            moves: p.moves.iter().rev().copied().collect(),
            grip: p.grip.iter().rev().copied().collect(),
            rests: p.rests,
        };
        Schedule {
            start: flip(&self.start),
            phases: self.phases.iter().map(phase).collect(),
            travel: -self.travel,
        }
    }
}

fn blocks(segments: usize, moving: usize) -> Vec<Vec<bool>> {
    let starts = (0..segments).step_by(moving);
    starts.map(|s| (0..segments).map(|i| i >= s && i < s + moving).collect()).collect()
}

fn single(segments: usize, _: usize) -> Schedule {
    Schedule::steps(&blocks(segments, 1), Grip::Full)
}

fn block(segments: usize, moving: usize) -> Schedule {
    Schedule::steps(&blocks(segments, moving), Grip::Full)
}

fn concertina(segments: usize, moving: usize) -> Schedule {
    Schedule::steps(&blocks(segments, moving), Grip::Eased)
}

fn windows(segments: usize, moving: usize) -> Vec<Vec<bool>> {
    let inside = |p: usize, i: usize| (i + segments - p) % segments < moving;
    (0..segments).map(|p| (0..segments).map(|i| inside(p, i)).collect()).collect()
}

fn window(segments: usize, moving: usize) -> Schedule {
    Schedule::steps(&windows(segments, moving), Grip::Full)
}

/// Straight pieces that stand for the curve between two anchor changes.
const PIECES: usize = 8;

fn wave(segments: usize, moving: usize) -> Schedule {
    let (n, k) = (segments as f64, moving as f64);
    // A segment moves over k/N of the cycle along s(x) = x - sin(2 pi x)/(2 pi).
    // Its neighbour lags by 1/k in x, so their distance peaks at
    // 1/k + sin(pi/k)/pi of the travel; that is to be one stroke.
    let travel = 1.0 / (1.0 / k + (PI / k).sin() / PI);
    let position = |time: f64, segment: usize| {
        let lag = time - segment as f64;
        let turns = (lag / n).floor();
        let x = ((lag - turns * n) / k).min(1.0);
        travel * (turns + x - (2.0 * PI * x).sin() / (2.0 * PI))
    };
    let count = segments * PIECES;
    let row = |q: usize| {
        let time = q as f64 / PIECES as f64;
        (0..segments).map(|i| position(time, i)).collect::<Vec<_>>()
    };
    let rows: Vec<_> = (0..=count).map(row).collect();
    let active = |q: usize, i: usize| (q / PIECES + segments - i) % segments < moving;
    let moves: Vec<Vec<bool>> =
        (0..count).map(|q| (0..segments).map(|i| active(q, i)).collect()).collect();
    let mut schedule = Schedule::of(&rows, &moves, Grip::Full, false);
    let pace = schedule.phases.iter().map(|p| p.pace).fold(0.0, f64::max);
    schedule.phases.iter_mut().for_each(|p| p.pace = pace);
    schedule.travel = travel;
    schedule
}

fn inchworm(segments: usize, _: usize) -> Schedule {
    let last = segments - 1;
    let grips = |anchor: usize, target: f64| Phase {
        target: vec![target; last],
        pace: 1.0,
        moves: (0..segments).map(|i| i != anchor).collect(),
        grip: (0..segments).map(|i| if i == anchor { Grip::Full } else { Grip::Free }).collect(),
        rests: true,
    };
    Schedule {
        start: vec![0.0; last],
        phases: vec![grips(last, 1.0), grips(0, 0.0)],
        travel: last as f64,
    }
}
