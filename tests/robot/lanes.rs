//! Lanes and traces.

use super::*;

/// Points of all kinds, side by side.
fn mixed_points(count: usize) -> Vec<Row> {
    let mut random = Random(31);
    let point = |random: &mut Random| {
        let n = random.whole(1, 5);
        let given = [
            (Segments, n),
            (Moving, random.whole(1, 3)),
            (Cycles, random.whole(1, 2)),
            (MuStatic, random.between(0.2, 0.6)),
            (MuCoulomb, random.between(0.1, 0.5)),
            (Viscous, if random.one_in(2) { 0.0 } else { random.between(0.1, 2.0) }),
            (SlopeDeg, random.between(-5.0, 5.0)),
            (SkinRatio, random.between(0.5, 2.0)),
            (WallForce, random.between(0.0, 2.0)),
            (WallRelease, random.unit()),
            (DriveLimit, random.between(0.5, 6.0)),
            (SpeedLimit, if random.one_in(4) { f64::INFINITY } else { random.between(0.05, 0.2) }),
            (
                JointStiffness,
                if random.one_in(4) { f64::INFINITY } else { random.between(500.0, 1e5) },
            ),
            (JointDamping, random.between(0.0, 50.0)),
            (Dwell, if random.one_in(3) { 0.0 } else { random.between(0.01, 0.1) }),
            (TimeStep, random.between(1e-3, 5e-3)),
            (Impact, random.whole(0, 1)),
            (BreakAway, random.whole(0, 1)),
        ];
        row(&given)
    };
    (0..count).map(|_| point(&mut random)).collect()
}

#[track_caller]
fn same(a: &GaitTally<f64>, b: &GaitTally<f64>) {
    assert_eq!(a.status(), b.status());
    let all = |t: &GaitTally<f64>| [t.values(), t.slip.to_vec()].concat();
    for (a, b) in all(a).into_iter().zip(all(b)) {
        assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()), "{a:e} is not {b:e}");
    }
}

struct Together<'a>(Gait, &'a [Row]);

struct Lanes<'a, P>(P, &'a [Row]);

impl<P: Pack> locosweep::physics::friction::Parameters<P> for Lanes<'_, P> {
    fn get(&self, id: ParamId) -> P {
        self.0.fill(|i| self.1[i][id.main()])
    }
    fn derived(&self, id: ParamId) -> P {
        self.0.fill(|i| self.1[i][id.derived()])
    }
}

impl Task for Together<'_> {
    type Output = Vec<GaitTally<f64>>;
    fn run<P: Pack>(self, token: P::Token) -> Self::Output {
        let mut all = Vec::new();
        for rows in self.1.chunks_exact(P::LANES) {
            let tally = gait_tally(self.0, &Lanes(P::broadcast(token, 0.0), rows));
            all.extend((0..P::LANES).map(|i| tally.lane(i)));
        }
        all
    }
}

#[test]
fn lanes_give_the_bits_of_a_single_robot_in_any_company() {
    let points = mixed_points(96);
    for gait in GAITS {
        let alone: Vec<_> = points.iter().map(|p| gait_tally(*gait, &Values(*p))).collect();
        assert!(alone.iter().filter(|t| t.status() == Status::Ok).count() > 30);
        for level in Level::available() {
            let mut out = vec![None; points.len()];
            let run_on = AtomicBool::new(false);
            ensemble(level, *gait, points.len(), &|i| points[i], &run_on, &mut |i, t| {
                out[i] = Some(t)
            });
            for (a, b) in alone.iter().zip(&out) {
                same(a, &b.unwrap());
            }
            for (a, b) in alone.iter().zip(&run(level, Together(*gait, &points))) {
                same(a, b);
            }
        }
    }
}

/// Robots with and without lubricant side by side. Its formulas multiply and add in one
/// rounding, for which a single robot is the reference where a processor has none.
#[test]
fn lubricated_lanes_give_the_bits_of_a_single_robot_in_any_company() {
    let mut random = Random(32);
    let mut points = mixed_points(64);
    let mut lubricated = 0;
    for point in &mut points {
        if point[JointStiffness.main()].is_finite() && random.one_in(2) {
            lubricated += 1;
            for (id, value) in lubricant::any(&mut random) {
                point[id.main()] = value;
            }
        }
    }
    assert!(lubricated > 15, "{lubricated}");
    for gait in GAITS {
        let alone: Vec<_> = points.iter().map(|p| gait_tally(*gait, &Values(*p))).collect();
        for level in Level::available() {
            let mut out = vec![None; points.len()];
            let run_on = AtomicBool::new(false);
            ensemble(level, *gait, points.len(), &|i| points[i], &run_on, &mut |i, t| {
                out[i] = Some(t)
            });
            for (a, b) in alone.iter().zip(&out) {
                same(a, &b.unwrap());
            }
        }
    }
}

#[test]
fn a_trace_changes_nothing_and_ends_where_the_tally_does() {
    let mut random = Random(33);
    for elastic in [false, true] {
        for _ in 0..10 {
            let robot = random_robot(&mut random, 4, elastic);
            let (_, schedule) = random_plan(&mut random, 4);
            let options = random_options(&mut random);
            let plan = Plan { schedule: &schedule, cycles: 2 };
            let mut trace = Trace::new(0.013);
            let seen = simulate(&robot, &plan, &options, &mut trace);
            same(&seen, &simulate(&robot, &plan, &options, &mut ()));
            if seen.status() != Status::Ok {
                continue;
            }
            assert_eq!(trace.x.len(), 4 * trace.len());
            assert_eq!((trace.force.len(), trace.slide.len()), (3 * trace.len(), 4 * trace.len()));
            assert!(trace.t.windows(2).all(|t| t[1] > t[0]));
            let last = *trace.t.last().unwrap();
            assert!(last <= seen.time + 1e-9 && last > seen.time - 0.02);
            // Sticking is rest, and nothing creeps.
            for (slide, v) in trace.slide.iter().zip(&trace.v) {
                assert!(*slide != 0 || *v == 0.0, "{slide} {v}");
            }
        }
    }
}
