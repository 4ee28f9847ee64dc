//! What is refused, by name and with what would be allowed.

use super::*;

fn refused(case: &Case) -> String {
    match case.ask(&["final_position"]) {
        Ok(_) => panic!("{} is let in", case.name()),
        Err(error) => error.to_string(),
    }
}

#[test]
fn unknown_names_get_the_nearest() {
    let usual = Case::usual("lugre", DriveKind::Sine);
    let change = |change: fn(&mut Choice)| refused(&usual.clone().change(change));
    let text = change(|c| c.law = "lugree".to_owned());
    assert!(text.contains("'lugree'") && text.contains("did you mean 'lugre'"), "{text}");
    let text = change(|c| c.drive = "sinus".to_owned());
    assert!(text.contains("'sinus'") && text.contains("did you mean 'sine'"), "{text}");
    let text = refused(&usual.clone().by("rosenbrok"));
    assert!(text.contains("'rosenbrok'") && text.contains("rosenbrock"), "{text}");
    let robot = Case { choice: Choice { gait: "singel".to_owned(), ..Choice::default() }, ..usual };
    let error = robot.ask(&["gait_advance"]).err().unwrap().to_string();
    assert!(error.contains("'singel'") && error.contains("did you mean 'single'"), "{error}");
    // A gait that is not used is not looked at.
    assert!(robot.change(|c| c.law = "coulomb".to_owned()).ask(&["final_position"]).is_ok());
}

#[test]
fn methods_that_do_not_fit() {
    let allowed = |law: &str, drive: DriveKind, method: &str| {
        Case::usual(law, drive).by(method).ask(&["final_position"]).map(|_| ())
    };
    for law in LAWS {
        for drive in DriveKind::ALL {
            let fit = methods(law, *drive);
            for (_, method, _) in Method::ALL {
                let name = law.info.name;
                match allowed(name, *drive, method) {
                    Ok(()) => assert!(fit.contains(method), "{name} {method}"),
                    Err(Error::BadOption { name: "method", given, allowed }) => {
                        assert!(!fit.contains(method), "{name} {method}");
                        assert!(given.contains(method));
                        assert!(fit.iter().all(|one| allowed.contains(one)), "{allowed}");
                    }
                    Err(error) => panic!("{name} {method}: {error}"),
                }
            }
        }
    }
    // A spring bends what was straight.
    let sprung = Case::usual("coulomb", DriveKind::Pulse).with(&[("spring_stiffness", 1.0)]);
    assert!(sprung.ask(&["final_position"]).is_ok());
    assert!(refused(&sprung.by("exact")).contains("runge_kutta"));
}

#[test]
fn hostile_values_are_refused_with_their_range() {
    let usual = Case::usual("lugre", DriveKind::Sine);
    for id in ParamId::all() {
        let param = id.param();
        let (low, high) = param.range;
        for bad in [f64::NAN, low - 1.0, high * 2.0, f64::NEG_INFINITY, f64::INFINITY] {
            if param.allows(bad) {
                continue;
            }
            let text = refused(&usual.clone().with(&[(param.name, bad)]));
            assert!(text.contains(param.name) && text.contains(&param.allowed()), "{text}");
            let ok = usual_value(id);
            let text = refused(&usual.clone().over(param.name, vec![ok, bad]));
            assert!(text.contains(&format!("{}[1]", param.name)), "{text}");
        }
    }
}

#[test]
fn what_a_law_or_drive_needs_is_asked_for() {
    for law in LAWS {
        let mut case = Case::usual(law.info.name, DriveKind::Sine);
        let needed = ["mu_static", "mu_coulomb"];
        case.given.retain(|(name, _)| !needed.contains(name));
        let missing = needed.iter().find(|name| law.info.params.contains(name));
        match (missing, case.ask(&["final_position"])) {
            (None, Ok(_)) => {}
            (Some(_), Err(Error::MissingParameter { name, quantity })) => {
                assert!(law.info.params.contains(&name.as_str()) && quantity == "final_position");
            }
            (missing, Ok(_)) => panic!("{}: {missing:?} is not asked for", law.info.name),
            (_, Err(error)) => panic!("{}: {error}", law.info.name),
        }
    }
}

#[test]
fn tables_are_checked() {
    let given = |times: &[f64], values: &[f64]| {
        let case = Case::usual("coulomb", DriveKind::Table);
        let (times, values) = (times.to_vec(), values.to_vec());
        refused(&case.change(|c| (c.times, c.values) = (times, values)))
    };
    assert!(given(&[], &[]).contains("at least one"));
    assert!(given(&[0.0, 1.0], &[1.0]).contains("2 times and 1 values"));
    let text = given(&[0.0, 0.1, 0.1], &[1.0, 2.0, 3.0]);
    assert!(text.contains("index 2") && text.contains("rise"), "{text}");
    assert!(given(&[0.0, f64::NAN], &[1.0, 2.0]).contains("index 1"));
    assert!(given(&[0.0, 1.0], &[f64::INFINITY, 2.0]).contains("index 0"));
    let elsewhere = Case::usual("coulomb", DriveKind::Sine)
        .change(|c| (c.times, c.values) = (vec![0.0], vec![1.0]));
    assert!(refused(&elsewhere).contains("only with drive 'table'"));
}
