//! Quantities of whole robots through a sweep.

use super::*;
use locosweep::integrate::robot::{GaitTally, ensemble};
use locosweep::physics::gait::{GAITS, Gait};
use locosweep::physics::point::row;
use locosweep::sweep::GaitOutput;
use std::sync::atomic::AtomicBool;

fn names() -> Vec<&'static str> {
    GaitOutput::ALL.iter().map(|output| output.info().name).collect()
}

/// Elastic and ideal joints, counts that some gaits cannot walk, drives too weak.
fn robots(gait: Gait) -> Case {
    Case::usual("coulomb", DriveKind::Constant)
        .change(|c| c.gait = gait.name().to_owned())
        .dry()
        .with(&[("joint_damping", 20.0), ("stroke", 0.02), ("drive_limit", 5.0)])
        .over("segments", vec![1.0, 2.0, 4.0, 5.0, 33.0])
        .over("joint_stiffness", vec![2e3, f64::INFINITY])
        .over("moving", vec![1.0, 2.0])
        .over("mu_static", steps(0.2, 0.6, 13))
}

#[test]
fn sweeps_give_the_ensembles_own_numbers() {
    for gait in GAITS {
        let case = robots(*gait);
        let job = case.job(&names());
        let (values, codes) = results(&job, options(2, 64));
        let point = |cell: usize| {
            let mut rest = cell;
            let mut given: Vec<_> =
                case.given.iter().map(|(name, v)| (ParamId::parse(name).unwrap(), *v)).collect();
            for (name, values) in case.axes.iter().rev() {
                given.push((ParamId::parse(name).unwrap(), values[rest % values.len()]));
                rest /= values.len();
            }
            row(&given)
        };
        let mut tallies: Vec<Option<GaitTally<f64>>> = vec![None; job.cells()];
        let level = Level::current().unwrap();
        let run_on = AtomicBool::new(false);
        ensemble(level, *gait, job.cells(), &point, &run_on, &mut |i, t| tallies[i] = Some(t));
        let mut walk = 0;
        for (i, tally) in tallies.iter().enumerate() {
            let tally = tally.unwrap();
            walk += usize::from(tally.status() == Status::Ok);
            for (k, output) in GaitOutput::ALL.iter().enumerate() {
                let what = format!("{} {} cell {i}", gait.name(), output.info().name);
                same(&[values[k][i]], &[output.of(&tally)], &what);
                assert_eq!(values[k][i].is_nan(), codes[k][i] != 0, "{what}");
                if tally.status() != Status::Ok {
                    assert_eq!(codes[k][i], tally.status() as u8, "{what}");
                }
            }
        }
        assert!(walk > job.cells() / 4, "{}: {walk} of {}", gait.name(), job.cells());
    }
}

#[test]
fn any_cut_and_level_gives_the_same_bits() {
    for gait in [Gait::Single, Gait::Wave] {
        let lubricated = robots(gait)
            .with(&[("buildup", 8.0), ("buildup_root", 0.5), ("segment_pitch", 0.01)])
            .with(&[("stribeck_term", 1.0)]);
        for job in [robots(gait), lubricated].map(|case| case.job(&names())) {
            let expected = results(&job, options(1, 65536));
            for (threads, chunk) in [(1, 64), (2, 7), (2, 65536), (3, 64)] {
                assert!(bits_of(&results(&job, options(threads, chunk))) == bits_of(&expected));
            }
            for level in Level::available() {
                let got = results(&job, Options { level, ..options(2, 64) });
                assert!(bits_of(&got) == bits_of(&expected), "{} {level:?}", gait.name());
            }
        }
    }
}

fn bits_of((values, codes): &Results) -> (Vec<Vec<u64>>, Vec<Vec<u8>>) {
    (values.iter().map(|v| bits(v)).collect(), codes.clone())
}

#[test]
fn every_parameter_of_a_robot_moves_some_output() {
    let entry = Entry::parse("gait_advance").unwrap();
    let mut silent: Vec<&str> = Vec::new();
    for id in ParamId::all().filter(|id| entry.uses(*id)) {
        let param = id.param();
        let moves = [Gait::Concertina, Gait::Single].into_iter().any(|gait| {
            [f64::INFINITY, 2e3].into_iter().any(|stiffness| {
                let base = Case::usual("coulomb", DriveKind::Constant)
                    .change(|c| c.gait = gait.name().to_owned())
                    .with(&[("stroke", 0.02), ("drive_limit", 3.0), ("segments", 4.0)])
                    .with(&[("joint_stiffness", stiffness), ("skin_ratio", 1.1), ("moving", 2.0)])
                    .with(&[("wall_force", 1.0), ("mu_coulomb", 0.2), ("speed_limit", 0.1)])
                    .with(&[("supply_voltage", 4.0), ("winding_resistance", 2.0)]);
                let base = match stiffness.is_infinite() {
                    true => base.dry(),
                    false => base
                        .with(&[("buildup", 5.0), ("buildup_root", 0.3), ("snowplough", 0.2)])
                        .with(&[("stribeck_term", 1.0), ("segment_pitch", 0.01)]),
                };
                let old = base.given.iter().find(|(name, _)| *name == param.name).unwrap().1;
                let moved: &[f64] = match (param.integer, old.is_infinite()) {
                    (_, true) => &[1e3],
                    (true, _) => &[old + 1.0, old - 1.0],
                    _ => &[old * 1.2, old * 0.8],
                };
                let before = bits(&base.get(&names()));
                moved.iter().filter(|value| param.allows(**value)).any(|value| {
                    bits(&base.clone().with(&[(param.name, *value)]).get(&names())) != before
                })
            })
        });
        if !moves {
            silent.push(param.name);
        }
    }
    assert!(silent.is_empty(), "without effect: {silent:?}");
}

#[test]
fn reductions_of_robots() {
    let counts = vec![2.0, 3.0, 4.0, 5.0, 33.0];
    let case = Case::usual("coulomb", DriveKind::Constant)
        .dry()
        .with(&[("stroke", 0.02), ("drive_limit", 3.0)])
        .over("mu_static", steps(0.2, 0.6, 9))
        .over("segments", counts.clone());
    let dense = &results(&case.job(&["gait_velocity"]), options(2, 64)).0[0];
    let entry = Entry::parse("gait_velocity").unwrap();
    let request = Request { entry, reduce: Some(Reduce::Argmax) };
    let grid = Grid::new(&case.axes, &case.given).unwrap();
    let job = Job::new(grid, vec![request], Some("segments"), &case.choice).unwrap();
    let (best, _) = results(&job, options(2, 64));
    for (along, best) in dense.chunks(counts.len()).zip(&best[0]) {
        let most = along.iter().copied().filter(|v| !v.is_nan()).fold(f64::MIN, f64::max);
        let at = counts.iter().position(|n| n == best).unwrap();
        assert!(along[at] >= most * (1.0 - 1e-12), "{along:?}: {best}");
    }
}
