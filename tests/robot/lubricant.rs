//! Lubricated ground: levels that fall with the speed, and heaps over fresh ground.

use super::elastic::order;
use super::*;
use engine::{options, results};
use locosweep::physics::lubricant::Lubricant;
use locosweep::sweep::{Choice, Entry, Grid, Job, Request};

const NONE: Lubricant<f64> = Lubricant {
    stribeck: 0.0,
    per_speed: 100.0,
    exponent: 1.0,
    buildup: 0.0,
    buildup_root: 0.0,
    snowplough: 0.0,
};

/// Lubricant of any kind.
pub fn any(random: &mut Random) -> Vec<(ParamId, f64)> {
    let some = |random: &mut Random, most: f64| {
        if random.one_in(2) { random.between(0.0, most) } else { 0.0 }
    };
    vec![
        (StribeckTerm, random.whole(0, 1)),
        (StribeckSpeed, random.log(1e-4, 0.3)),
        (StribeckExponent, random.between(0.3, 3.0)),
        (Buildup, some(random, 60.0)),
        (BuildupRoot, some(random, 4.0)),
        (Snowplough, some(random, 20.0)),
        (SegmentPitch, some(random, 0.03)),
    ]
}

/// A head that one joint's spring pulls off a firm anchor.
struct Pulled {
    head: Segment<f64>,
    lubricant: Lubricant<f64>,
    stiffness: f64,
    damping: f64,
    speed: f64,
    time: f64,
}

impl Pulled {
    /// Where the head is in the end, by the whole robot.
    fn robot(&self, time_step: f64) -> f64 {
        let anchor = Segment { mu_static: 1e3, ..segment() };
        let joint = Joint {
            stroke: self.speed * self.time,
            limit: f64::INFINITY,
            speed: self.speed,
            stiffness: self.stiffness,
            damping: self.damping,
        };
        let mut robot = robot(vec![self.head, anchor], joint);
        robot.lubricants = vec![self.lubricant, NONE];
        let how = RunOptions { time_step, break_away: 1.0, ..OPTIONS };
        let run = once(&robot, &head_phase(2), &how);
        assert_eq!(run.status(), Status::Ok);
        let all = run.work + run.friction + run.elastic;
        assert!((-1e-12..1e-2).contains(&(run.residual / all)), "{} {all}", run.residual);
        2.0 * run.advance
    }

    /// The same by a friction law of one segment.
    fn law(&self, law: &str, names: &[(&'static str, f64)]) -> f64 {
        let mut given = vec![
            ("mu_static", self.head.mu_static),
            ("mu_coulomb", self.head.mu_coulomb),
            ("viscous", self.head.viscous),
            ("spring_stiffness", self.stiffness),
            ("spring_damping", self.damping),
            ("pull_speed", self.speed),
            ("duration", self.time),
            ("time_step", 2e-5),
        ];
        given.extend_from_slice(names);
        of_law("final_position", law, &given)
    }
}

/// A quantity of one segment on a friction law.
fn of_law(quantity: &str, law: &str, given: &[(&'static str, f64)]) -> f64 {
    let choice = Choice { law: law.to_owned(), ..Choice::default() };
    let entry = Entry::parse(quantity).unwrap();
    let grid = Grid::new(&[], given).unwrap();
    let job = Job::new(grid, vec![Request { entry, reduce: None }], None, &choice).unwrap();
    results(&job, options(1, 1)).0[0][0]
}

/// Parameters of a segment's own law, by name.
type LawValues = Vec<(&'static str, f64)>;

/// Stick and slip under a falling level; a heap with all its terms.
fn pulled() -> [(Pulled, &'static str, LawValues); 3] {
    let spring = |head: Segment<f64>, lubricant| Pulled {
        head,
        lubricant,
        stiffness: 200.0,
        damping: 0.5,
        speed: 0.05,
        time: 0.5,
    };
    let bell = Lubricant { stribeck: 1.0, per_speed: 1.0 / 0.05, exponent: 2.0, ..NONE };
    let free = Lubricant { exponent: 0.8, ..bell };
    let heap = Lubricant { buildup: 20.0, buildup_root: 1.5, snowplough: 3.0, ..NONE };
    let even = Segment { mu_static: 0.3, viscous: 0.4, ..segment() };
    let heap_names = vec![("buildup", 20.0), ("buildup_root", 1.5), ("snowplough", 3.0)];
    let fall = ("stribeck_speed", 0.05);
    [
        (spring(segment(), bell), "stribeck", vec![fall]),
        (spring(segment(), free), "bo_pavelescu", vec![fall, ("stribeck_exponent", 0.8)]),
        (spring(even, heap), "buildup", heap_names),
    ]
}

#[test]
fn a_pulled_head_moves_as_a_segment_of_that_law() {
    for (pulled, law, names) in pulled() {
        let (whole, single) = (pulled.robot(1e-5), pulled.law(law, &names));
        assert!(single > 2e-3, "{single}");
        assert!((whole - single).abs() < 1e-8, "{law}: {whole} {single}");
        // Without the lubricant the head is elsewhere.
        let dry = Pulled { lubricant: NONE, ..pulled }.robot(1e-5);
        assert!((dry - single).abs() > 1e-4, "{law}: {dry} {single}");
    }
}

#[test]
fn lubricant_keeps_the_order_of_the_steps() {
    for (pulled, law, _) in pulled() {
        let finest = pulled.robot(2e-6);
        // Whole numbers of steps, so that only their length differs.
        let steps = [1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5];
        let errors: Vec<f64> = steps.iter().map(|h| (pulled.robot(*h) - finest).abs()).collect();
        let of_step = order(&steps, &errors);
        assert!((1.7..2.6).contains(&of_step), "{law}: {of_step} {errors:?}");
        assert!(errors[0] < 2e-5, "{law}: {errors:?}");
    }
}

#[test]
fn a_fall_over_no_speed_is_the_dry_law() {
    for gait in [Gait::Single, Gait::Block, Gait::Wave] {
        let given = with(&servo(1e-3), &[(SlopeDeg, 2.0), (Viscous, 0.5)]);
        let dry = tally(gait, &given);
        let steep = tally(gait, &with(&given, &[(StribeckTerm, 1.0), (StribeckSpeed, 1e-9)]));
        near(steep.advance, dry.advance, 1e-6);
        near(steep.friction, dry.friction, 1e-6);
        // And where nothing falls, it does not matter over what.
        let flat = with(&given, &[(MuStatic, 0.3)]);
        let level = tally(gait, &with(&flat, &[(StribeckTerm, 1.0)]));
        near(level.advance, tally(gait, &flat).advance, 1e-12);
    }
}

/// A slow robot on firm anchors, and the largest heap of each segment over the run.
fn slow(more: Given) -> (GaitTally<f64>, Trace) {
    let given = with(
        &[(MuStatic, 0.3), (MuCoulomb, 0.3), (Segments, 4.0), (SkinRatio, 2.0), (Dwell, 0.05)],
        &[(JointStiffness, 1e6), (JointDamping, 100.0), (SpeedLimit, 0.01), (Cycles, 1.0)],
    );
    let given = with(&given, more);
    let robot = from_point(&given, 4);
    let how = RunOptions { time_step: 1e-3, dwell: 0.05, impact: 1.0, break_away: 1.0 };
    let schedule = Gait::Single.schedule(4, 1).unwrap();
    let cycles = if given.contains(&(Cycles, 2.0)) { 2 } else { 1 };
    let mut trace = Trace::new(1e-3);
    let run = simulate(&robot, &Plan { schedule: &schedule, cycles }, &how, &mut trace);
    assert_eq!(run.status(), Status::Ok);
    (run, trace)
}

fn largest(heap: &[f64]) -> Vec<f64> {
    let most = |i: usize| heap.iter().skip(i).step_by(4).copied().fold(0.0, f64::max);
    (0..4).map(most).collect()
}

#[test]
fn the_head_pushes_what_it_has_swept_and_followers_what_nobody_has() {
    let (_, trace) = slow(&[(Buildup, 10.0)]);
    let mut moved = 0;
    for (x, heap) in trace.x.chunks(4).zip(trace.heap.chunks(4)) {
        assert!(heap[0] == 0.0 || heap[0] == x[0], "{} {}", heap[0], x[0]);
        assert_eq!(heap[1..], [0.0; 3]);
        moved += usize::from(heap[0] > 0.9 * STROKE);
    }
    assert!(moved > 10, "{moved}");
    // At rest nothing is pushed.
    assert_eq!(trace.heap[trace.heap.len() - 4], 0.0);
    for (pitch, expected) in [(0.005, 0.005), (0.05, STROKE)] {
        let (_, trace) = slow(&[(Buildup, 10.0), (SegmentPitch, pitch)]);
        let all = largest(&trace.heap);
        assert!((all[0] - STROKE).abs() < 1e-4, "{all:?}");
        all[1..].iter().for_each(|s| assert!((s - expected).abs() < 1e-4, "{pitch} {all:?}"));
    }
    // A second cycle goes over the rest of the gap.
    let (_, trace) = slow(&[(Buildup, 10.0), (SegmentPitch, 0.03), (Cycles, 2.0)]);
    let half = trace.heap.len() / 8 * 4;
    let all = largest(&trace.heap[half..]);
    assert!((all[0] - STROKE).abs() < 2e-4, "{all:?}");
    all[1..].iter().for_each(|s| assert!((s - 0.01).abs() < 2e-4, "{all:?}"));
}

#[test]
fn work_against_a_heap_by_hand() {
    // Slow, so that friction is what its forces do over the way.
    let dry = slow(&[(Buildup, 1e-9)]).0.friction;
    near(dry, 4.0 * 0.3 * MG * STROKE, 1e-3);
    let heap = 0.5 * 40.0 * STROKE * STROKE + 2.0 / 3.0 * 2.0 * STROKE.powf(1.5);
    let given = [(Buildup, 40.0), (BuildupRoot, 2.0)];
    let alone = slow(&given).0.friction;
    near(alone - dry, heap, 1e-3);
    let all = slow(&with(&given, &[(SegmentPitch, 1.0)])).0.friction;
    near(all - dry, 4.0 * heap, 1e-3);
    // Half of the stroke lies over fresh ground.
    let half = STROKE / 2.0;
    let heap_of_half = 0.5 * 40.0 * half * half + 2.0 / 3.0 * 2.0 * half.powf(1.5);
    // What has been piled up stays before the segment until it rests.
    let pushed_on = (40.0 * half + 2.0 * half.sqrt()) * half;
    let some = slow(&with(&given, &[(SegmentPitch, half)])).0.friction;
    near(some - dry, heap + 3.0 * (heap_of_half + pushed_on), 1e-3);
}

#[test]
fn a_stiff_joint_under_its_limit_takes_the_time_of_the_buildup_law() {
    let limit = 1.5;
    let names = [("buildup", 20.0), ("viscous", 0.3), ("drive_force", limit)];
    let given = [("mu_coulomb", 0.3), ("mu_static", 0.3), ("stroke", STROKE), ("time_step", 1e-5)];
    let time = of_law("stroke_time", "buildup", &[&names[..], &given].concat());
    let head = Segment { mu_static: 0.3, viscous: 0.3, ..segment() };
    let anchor = Segment { mu_static: 1e3, ..segment() };
    // The drive jumps ahead and slips at its limit until well beyond the stroke.
    let joint =
        Joint { stroke: 2.0 * STROKE, limit, speed: f64::INFINITY, stiffness: 1e6, damping: 0.0 };
    let mut pair = robot(vec![head, anchor], joint);
    pair.lubricants = vec![Lubricant { buildup: 20.0, ..NONE }, NONE];
    let how = RunOptions { time_step: 1e-5, dwell: time, ..OPTIONS };
    let mut trace = Trace::new(1e-5);
    let schedule = head_phase(2);
    simulate(&pair, &Plan { schedule: &schedule, cycles: 1 }, &how, &mut trace);
    let (x, v) = (trace.x[trace.x.len() - 2], trace.v[trace.v.len() - 2]);
    near(*trace.t.last().unwrap(), time, 1e-12);
    assert!((x - STROKE).abs() < 1e-7 && v > 0.1, "{x} {v}");
}

/// When each segment has gone 95 % of its stroke, from the start of its phase.
fn arrivals(more: Given) -> Vec<f64> {
    let given = [
        (MuStatic, 0.5),
        (MuCoulomb, 0.15),
        (Segments, 4.0),
        (Viscous, 0.2),
        (DriveLimit, 0.85),
        (JointStiffness, 2e3),
        (JointDamping, 20.0),
        (BreakAway, 0.0),
    ];
    let dwell = 0.4;
    let robot = from_point(&with(&given, more), 4);
    let how = RunOptions { time_step: 1e-4, dwell, ..OPTIONS };
    let schedule = Gait::Single.schedule(4, 1).unwrap();
    let mut trace = Trace::new(1e-4);
    let run = simulate(&robot, &Plan { schedule: &schedule, cycles: 1 }, &how, &mut trace);
    assert_eq!(run.status(), Status::Ok);
    let when = |i: usize| {
        let x = trace.segment(i);
        trace.t[x.iter().position(|x| *x > 0.95 * STROKE).unwrap()] - dwell * i as f64
    };
    (0..4).map(when).collect()
}

#[test]
fn the_head_arrives_later_and_a_follower_on_swept_ground_does_not() {
    let swept = arrivals(&[]);
    let led = arrivals(&[(Buildup, 5.0)]);
    assert!(led[0] > swept[0] * 1.015, "{led:?} {swept:?}");
    (1..4).for_each(|i| assert!((led[i] / swept[i] - 1.0).abs() < 1e-3, "{led:?} {swept:?}"));
    let fresh = arrivals(&[(Buildup, 5.0), (SegmentPitch, 0.1)]);
    (0..4).for_each(|i| assert!(fresh[i] > swept[i] * 1.004, "{fresh:?} {swept:?}"));
}

#[test]
fn ideal_joints_have_a_status() {
    let refused = |more: Given| tally(Gait::Single, &with(&dry(4.0), more)).status();
    assert_eq!(refused(&[(DriveLimit, 0.85)]), Status::Ok);
    for what in [StribeckTerm, Buildup, BuildupRoot, Snowplough] {
        assert_eq!(refused(&[(DriveLimit, 0.85), (what, 1.0)]), Status::ElasticJointsOnly);
    }
    // Nothing is pushed without them.
    let more = [(DriveLimit, 0.85), (SegmentPitch, 1.0)];
    assert_eq!(refused(&more), Status::Ok);
}

#[test]
fn parts_of_their_own_and_a_fall_that_is_off() {
    let shared: Vec<(String, f64)> = [
        ("mu_static", 0.5),
        ("mu_coulomb", 0.3),
        ("segments", 3.0),
        ("joint_stiffness", 2e3),
        ("segment_pitch", 0.1),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec();
    let list = |name: &str, values: [f64; 3]| vec![(name.to_owned(), values.to_vec())];
    let new = |own: &[PerPart]| RunParameters::new(&shared, own, &[]);
    assert!(new(&[]).unwrap().robot.lubricants.is_empty());
    let run = new(&list("buildup", [0.0, 7.0, 0.0])).unwrap();
    let found: Vec<f64> = run.robot.lubricants.iter().map(|l| l.buildup).collect();
    assert_eq!((found, run.robot.segment_pitch), (vec![0.0, 7.0, 0.0], 0.1));
    let own = [list("stribeck_term", [0.0, 1.0, 1.0]), list("stribeck_speed", [0.01, 0.02, 0.04])];
    let run = new(&own.concat()).unwrap();
    let found: Vec<f64> = run.robot.lubricants.iter().map(|l| 1.0 / l.per_speed).collect();
    assert_eq!(found, [0.01, 0.02, 0.04]);
    // A speed of the fall without a fall.
    let error = new(&list("stribeck_speed", [0.01, 0.02, 0.01])).unwrap_err().to_string();
    assert!(error.contains("stribeck_speed is 0.02, without stribeck_term"), "{error}");
    assert!(new(&list("buildup", [0.0, -1.0, 0.0])).is_err());
    let given = [("mu_static", 0.5), ("mu_coulomb", 0.3), ("segments", 3.0)];
    let axes = [("stribeck_exponent", vec![0.5, 2.0])];
    let ask = |more: &[(&'static str, f64)]| {
        let entry = Entry::parse("gait_advance").unwrap();
        let grid = Grid::new(&axes, &[&given[..], more].concat()).unwrap();
        Job::new(grid, vec![Request { entry, reduce: None }], None, &Choice::default())
    };
    assert!(ask(&[]).is_err());
    assert!(ask(&[("stribeck_term", 1.0)]).is_ok());
}
