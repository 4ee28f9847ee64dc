//! Every parameter of a law, a drive, a run or a method moves some output, and
//! no other parameter moves any.

use super::*;
use std::collections::BTreeSet;

/// Names whose change by a few per cent is seen in some output.
fn seen(case: &Case, names: &[&'static str]) -> Vec<(&'static str, bool)> {
    let before = case.get(&outputs());
    let mut all = Vec::new();
    for name in names {
        let param = ParamId::parse(name).unwrap().param();
        let old = case.given.iter().find(|(known, _)| known == name).unwrap().1;
        let moved = if param.integer { [old + 1.0, old - 1.0] } else { [old * 1.07, old * 0.93] };
        // A limit is felt from one side only.
        let felt = moved.into_iter().filter(|value| param.allows(*value)).any(|value| {
            let after = case.clone().with(&[(name, value)]).get(&outputs());
            bits(&before) != bits(&after)
        });
        all.push((*name, felt));
    }
    all
}

/// What is wrong with the parameters that move anything in one of some cases.
fn report(cases: &[Case], expected: &BTreeSet<&str>) -> String {
    let names: Vec<&'static str> = ParamId::all()
        .map(|id| id.param().name)
        .filter(|name| usual_value(ParamId::parse(name).unwrap()).is_finite())
        .collect();
    let all: Vec<_> = cases.iter().map(|case| seen(case, &names)).collect();
    let mut report = String::new();
    for (i, name) in names.iter().enumerate() {
        let moved = all.iter().any(|case| case[i].1);
        if moved != expected.contains(name) {
            let what = if moved { "moves what it should not" } else { "moves nothing" };
            report += &format!("\n{}: {name} {what}", cases[0].name());
        }
    }
    report
}

/// What any run takes, beside law, drive and method.
const RUN: [&str; 11] = [
    "mass",
    "gravity",
    "slope_deg",
    "duration",
    "start_position",
    "start_speed",
    "stroke",
    "drive_limit",
    "spring_stiffness",
    "spring_damping",
    "pull_speed",
];

fn sprung(case: Case) -> Case {
    case.with(&[("spring_stiffness", 30.0), ("spring_damping", 1.0), ("drive_limit", 1.3)])
}

/// Pushed back first, so that it stops, and freed by a spring that is pulled faster.
fn freed(case: Case) -> Case {
    case.with(&[("start_speed", -0.05), ("pull_speed", 0.2)])
}

/// Forward just beyond the drive's limit, backward just beyond what holds.
fn just(case: Case, back: f64) -> Case {
    case.with(&[("drive_amplitude", 1.2), ("drive_limit", 1.49), ("drive_duty", 0.5)])
        .with(&[("drive_back", back)])
}

fn expected<'a>(law: &'a LawEntry, drive: DriveKind, method: &'a str) -> BTreeSet<&'a str> {
    let mut all: BTreeSet<&str> = RUN.into_iter().collect();
    all.extend(ParamId::all().filter(|id| law.uses(*id)).map(|id| id.param().name));
    all.extend(drive.info().params);
    if ["rosenbrock", "dormand_prince"].contains(&method) {
        all.insert("tolerance");
    }
    // Adaptive methods begin with the step, or a part of it.
    all.insert("time_step");
    all
}

#[test]
fn every_parameter_of_every_law() {
    let mut faults = String::new();
    for law in LAWS {
        for method in methods(law, DriveKind::Sine) {
            let mut case = sprung(Case::usual(law.info.name, DriveKind::Sine).by(method));
            if method == "dormand_prince" {
                // Friction along the way keeps steps below `time_step`: one beyond which
                // the tolerance asks for less.
                case = case.with(&[("tolerance", 1e-12)]);
            }
            faults += &report(&[case], &expected(law, DriveKind::Sine, method));
        }
    }
    assert!(faults.is_empty(), "{faults}");
}

#[test]
fn every_parameter_of_every_drive() {
    every_parameter_counts(&["static_viscous"]);
}

#[test]
#[ignore = "takes ten seconds"]
fn every_parameter_of_every_drive_of_steep_and_elastic_laws() {
    every_parameter_counts(&["tanh", "lugre"]);
}

fn every_parameter_counts(laws: &[&str]) {
    let mut faults = String::new();
    for &name in laws {
        let law = LawEntry::parse(name).unwrap();
        for drive in DriveKind::ALL {
            for method in methods(law, *drive).into_iter().filter(|method| *method != "exact") {
                let case = match drive {
                    DriveKind::Constant => {
                        // What is clipped would hide the force.
                        let force = [("drive_force", 1.0), ("drive_limit", 1.02)];
                        freed(sprung(Case::usual(name, *drive))).with(&force)
                    }
                    DriveKind::Ramp => freed(sprung(Case::usual(name, *drive))),
                    _ => sprung(Case::usual(name, *drive)),
                }
                .by(method);
                // Explicit steps have to be as short as a smoothed law is steep.
                let fine = name == "tanh" && method == "runge_kutta";
                let case = if fine { case.with(&[("time_step", 5e-5)]) } else { case };
                // Steps of the usual length are exact beyond the usual tolerance.
                let adaptive = method == "dormand_prince";
                let case = if adaptive { case.with(&[("tolerance", 1e-12)]) } else { case };
                let cases: Vec<Case> = match drive {
                    DriveKind::Pulse => [0.62, 0.66, 0.7, 0.74, 0.78, 0.82, 0.9, 1.1, 1.32]
                        .map(|b| just(case.clone(), b))
                        .to_vec(),
                    _ => vec![case],
                };
                faults += &report(&cases, &expected(law, *drive, method));
            }
        }
    }
    assert!(faults.is_empty(), "{faults}");
}

/// An exact run has neither step nor tolerance nor spring.
#[test]
fn every_parameter_of_exact_runs() {
    let mut faults = String::new();
    for law in LAWS.iter().filter(|law| law.linear) {
        for drive in [DriveKind::Pulse, DriveKind::Table] {
            let case = Case::usual(law.info.name, drive);
            // What is just freed differs with what else rubs: load, skin.
            let cases: Vec<Case> = match drive {
                DriveKind::Pulse => [1.22, 1.32, 1.62].map(|b| just(case.clone(), b)).to_vec(),
                _ => [1.5, 1.7]
                    .map(|gain| case.clone().with(&[("drive_limit", 1.3), ("gain", gain)]))
                    .to_vec(),
            };
            let mut all = expected(law, drive, "exact");
            for name in ["time_step", "spring_stiffness", "spring_damping", "pull_speed"] {
                all.remove(name);
            }
            faults += &report(&cases, &all);
        }
    }
    assert!(faults.is_empty(), "{faults}");
}
