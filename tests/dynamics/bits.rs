//! The same bits however a sweep of trajectories is cut, and whoever runs beside
//! whom.

use super::*;
use std::collections::BTreeSet;

/// Fifty cells that differ in law, run and drive.
fn fifty(case: Case) -> Case {
    let names = ["mu_coulomb", "start_speed"];
    case.over(names[0], steps(0.05, 0.3, 10)).over(names[1], vec![-0.2, 0.0, 0.01, 0.1, 0.3])
}

fn cell(case: &Case, i: usize) -> Case {
    let mut alone = Case { axes: Vec::new(), ..case.clone() };
    let mut rest = i;
    for (name, values) in case.axes.iter().rev() {
        alone.given.push((name, values[rest % values.len()]));
        rest /= values.len();
    }
    alone
}

#[track_caller]
fn same_results(a: &Results, b: &Results, what: &str) {
    for (k, name) in outputs().iter().enumerate() {
        same(&a.0[k], &b.0[k], &format!("{what} {name}"));
        assert_eq!(a.1[k], b.1[k], "{what} {name}");
    }
}

/// A fifth of all cases, in which every law, drive and method comes up.
#[test]
fn a_cell_alone_is_a_cell_in_company() {
    let some: Vec<Case> = everything().into_iter().step_by(5).collect();
    let parts: [fn(&Case) -> String; 3] = [
        |case| case.choice.law.clone(),
        |case| case.choice.drive.clone(),
        |case| case.choice.method.clone().unwrap(),
    ];
    for part in parts {
        let names = |cases: &[Case]| cases.iter().map(part).collect::<BTreeSet<_>>();
        assert_eq!(names(&some), names(&everything()));
    }
    alone_is_in_company(some);
}

#[test]
#[ignore = "takes half a minute"]
fn every_cell_alone_is_a_cell_in_company() {
    alone_is_in_company(everything());
}

fn alone_is_in_company(cases: impl IntoIterator<Item = Case>) {
    for case in cases {
        let case = fifty(case);
        let job = case.all();
        let mut first: Option<Results> = None;
        for level in Level::available() {
            let at = |threads, chunk| Options { level, ..options(threads, chunk) };
            let together = results(&job, at(1, 64));
            for i in [0, 17, 49] {
                let alone = results(&cell(&case, i).all(), at(1, 64));
                let what = format!("{} at {} cell {i}", case.name(), level.name());
                let taken = |all: &[Vec<f64>]| all.iter().map(|v| vec![v[i]]).collect::<Vec<_>>();
                let codes = together.1.iter().map(|v| vec![v[i]]).collect();
                same_results(&alone, &(taken(&together.0), codes), &what);
            }
            let what = format!("{} at {}", case.name(), level.name());
            match &first {
                None => first = Some(together),
                Some(first) => same_results(first, &together, &what),
            }
        }
    }
}

#[test]
fn any_cut_gives_the_same_bits() {
    for (law, drive) in [
        ("static_viscous", DriveKind::Pulse),
        ("stribeck", DriveKind::Sine),
        ("tanh", DriveKind::Chirp),
        ("lugre", DriveKind::Table),
    ] {
        // More than one block of cells that are simulated together, and rows that end
        // within one.
        let case = Case::usual(law, drive)
            .over("mu_coulomb", steps(0.05, 0.3, 9))
            .over("start_speed", steps(-0.2, 0.3, 67));
        let job = case.all();
        let expected = results(&job, options(1, 65536));
        for threads in [1, 2, 3] {
            for chunk in [1, 7, 64, 65536] {
                // A block of cells costs a whole pack each.
                if chunk < 64 && threads == 3 {
                    continue;
                }
                let got = results(&job, options(threads, chunk));
                let what = format!("{} with {threads} threads, chunk {chunk}", case.name());
                same_results(&got, &expected, &what);
            }
        }
    }
}

#[test]
fn any_order_of_axes_gives_the_same_bits() {
    for law in ["static_viscous", "tanh", "dahl"] {
        let (a, b, c) = (steps(0.05, 0.3, 4), vec![-0.1, 0.0, 0.2], vec![-3.0, 0.0, 2.0, 5.0, 8.0]);
        let case = Case::usual(law, DriveKind::Pulse);
        let axes = [("mu_coulomb", a), ("start_speed", b), ("slope_deg", c)];
        let build = |order: [usize; 3]| {
            order.iter().fold(case.clone(), |case, i| case.over(axes[*i].0, axes[*i].1.clone()))
        };
        let expected = results(&build([0, 1, 2]).all(), options(2, 7)).0;
        for order in [[2, 1, 0], [1, 2, 0], [2, 0, 1]] {
            let turned = build(order);
            let got = results(&turned.all(), options(2, 64)).0;
            let sizes = axes.each_ref().map(|(_, values)| values.len());
            for (k, name) in outputs().iter().enumerate() {
                let what = format!("{law} {name} in order {order:?}");
                for (at, value) in expected[k].iter().enumerate() {
                    let (row, rest) = (at / sizes[2], at % sizes[2]);
                    let index = [row / sizes[1], row % sizes[1], rest];
                    let there = order.iter().fold(0, |n, i| n * sizes[*i] + index[*i]);
                    same(&[got[k][there]], &[*value], &what);
                }
            }
        }
    }
}

/// What is asked for beside an output does not change it: a run that watches
/// more takes the same steps.
#[test]
fn company_of_requests_does_not_matter() {
    for case in everything() {
        let all = case.get(&outputs());
        for (name, value) in outputs().iter().zip(all) {
            // The first two need no watching, so the run may differ most there.
            if ["final_position", "final_speed", "stroke_time", "dissipated"].contains(name) {
                same(&[case.one(name)], &[value], &format!("{} {name}", case.name()));
            }
        }
    }
}

/// Closed forms, trajectories and whole robots of one job are those of three.
#[test]
fn one_job_of_all_kinds_is_three_jobs() {
    let case = Case::usual("static_viscous", DriveKind::Pulse)
        .dry()
        .over("slope_deg", steps(-3.0, 6.0, 19))
        .over("mu_static", steps(0.2, 0.7, 33));
    let names: Vec<&str> = QUANTITIES.iter().map(|entry| entry.info.name).collect();
    let (all, codes) = results(&case.job(&names), options(2, 64));
    for (k, name) in names.iter().enumerate() {
        let (one, code) = results(&case.job(&[name]), options(1, 65536));
        same(&all[k], &one[0], name);
        assert_eq!(codes[k], code[0], "{name}");
    }
}

/// Reductions of simulated values are reductions of what the dense sweep gives.
#[test]
fn reductions_of_trajectories() {
    let axis = steps(0.05, 0.3, 13);
    let case = Case::usual("static_viscous", DriveKind::Pulse)
        .over("slope_deg", steps(-3.0, 6.0, 21))
        .over("mu_coulomb", axis.clone());
    for name in ["final_position", "stroke_time", "stick_phases"] {
        let dense = &results(&case.job(&[name]), options(2, 64)).0[0];
        for reduce in [Reduce::Max, Reduce::Argmin, Reduce::Count, Reduce::Quantile(0.5)] {
            let entry = Entry::parse(name).unwrap();
            let grid = Grid::new(&case.axes, &case.given).unwrap();
            let request = Request { entry, reduce: Some(reduce) };
            let job = Job::new(grid, vec![request], Some("mu_coulomb"), &case.choice).unwrap();
            let (got, _) = results(&job, options(2, 7));
            same(&got[0], &results(&job, options(1, 64)).0[0], "cut");
            for (along, got) in dense.chunks(axis.len()).zip(&got[0]) {
                let works: Vec<f64> = along.iter().copied().filter(|v| !v.is_nan()).collect();
                let least = works.iter().copied().fold(f64::INFINITY, f64::min);
                let most = works.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let mut sorted = works.clone();
                sorted.sort_by(f64::total_cmp);
                let expected = match reduce {
                    Reduce::Count => works.len() as f64,
                    _ if works.is_empty() => f64::NAN,
                    Reduce::Max => most,
                    Reduce::Argmin => {
                        let tie = locosweep::physics::closed_form::TIE * least.abs();
                        axis[along.iter().position(|v| *v <= least + tie).unwrap()]
                    }
                    _ => {
                        let at = (sorted.len() - 1) as f64 * 0.5;
                        let (i, share) = (at.floor() as usize, at.fract());
                        let next = sorted[(i + 1).min(sorted.len() - 1)];
                        sorted[i] + (next - sorted[i]) * share
                    }
                };
                let close = (got - expected).abs() <= 1e-15 * expected.abs();
                assert!(close || got.is_nan() && expected.is_nan(), "{name} {reduce:?}");
            }
        }
    }
}
