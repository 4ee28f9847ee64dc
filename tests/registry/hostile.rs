//! Hostile input.

use super::*;

fn hostile() -> impl Strategy<Value = f64> {
    let fixed = prop::sample::select(vec![
        f64::NAN,
        -f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        0.0,
        -0.0,
        -1.0,
        0.5,
        1.0,
        2.0,
        3.0,
        90.0,
        -90.0,
        90.000_001,
        5e-324,
        -5e-324,
        1e-310,
        f64::MIN_POSITIVE,
        1e-9,
        1e6,
        1e9,
        1e9 + 1.0,
        1e308,
        -1e308,
        f64::MAX,
        9_007_199_254_740_993.0,
    ]);
    prop_oneof![3 => fixed, 1 => any::<f64>(), 2 => 0.0..3.0f64]
}

fn name() -> impl Strategy<Value = String> {
    let known = prop::sample::select(PARAMS.iter().map(|p| p.name.to_owned()).collect::<Vec<_>>());
    prop_oneof![20 => known, 1 => ".*"]
}

/// The first thing that must be refused, as (name, index).
fn first_fault(
    axes: &[(String, Vec<f64>)],
    fixed: &[(String, f64)],
) -> Option<(String, Option<usize>)> {
    let mut seen: Vec<&str> = Vec::new();
    let find = |name: &str| -> Option<&'static Param> { PARAMS.iter().find(|p| p.name == name) };
    for (name, values) in axes {
        let Some(param) = find(name) else { return Some((name.clone(), None)) };
        if seen.contains(&name.as_str()) || values.is_empty() {
            return Some((name.clone(), None));
        }
        if let Some(i) = values.iter().position(|v| !param.allows(*v)) {
            return Some((name.clone(), Some(i)));
        }
        seen.push(name);
    }
    for (name, value) in fixed {
        let Some(param) = find(name) else { return Some((name.clone(), None)) };
        if seen.contains(&name.as_str()) || !param.allows(*value) {
            return Some((name.clone(), None));
        }
        seen.push(name);
    }
    None
}

fn refused(error: &Error) -> (String, Option<usize>) {
    match error {
        Error::UnknownName { given, .. } => (given.clone(), None),
        Error::OutOfRange { name, index, .. } => (name.clone(), *index),
        Error::GivenTwice { name, .. } | Error::EmptyAxis { name } => (name.clone(), None),
        other => panic!("not an error of a grid: {other}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..Default::default() })]

    #[test]
    fn grids_refuse_by_name_and_index(
        axes in prop::collection::vec((name(), prop::collection::vec(hostile(), 0..4)), 0..4),
        fixed in prop::collection::vec((name(), hostile()), 0..4),
    ) {
        let grid = Grid::new(&axes, &fixed);
        match first_fault(&axes, &fixed) {
            Some(expected) => {
                let error = grid.unwrap_err();
                prop_assert_eq!(refused(&error), expected.clone());
                let text = error.to_string();
                prop_assert!(text.contains(&expected.0), "{}", text);
                if let Some(index) = expected.1 {
                    let place = format!("[{}]", index);
                    prop_assert!(text.contains(&place), "{}", text);
                }
            }
            None => prop_assert!(grid.is_ok()),
        }
    }

    /// What a grid lets in is computed: a finite value or a reason.
    #[test]
    fn what_is_let_in_is_computed(
        given in prop::collection::vec((0..PARAMS.len(), prop::collection::vec(hostile(), 1..4)), 0..6),
        friction in (0.0..2.0f64, 0.0..2.0f64),
    ) {
        let mut axes: Vec<(&str, Vec<f64>)> = Vec::new();
        for (i, values) in given {
            let param = &PARAMS[i];
            let values: Vec<f64> = values.into_iter().filter(|v| param.allows(*v)).collect();
            if !values.is_empty() && axes.iter().all(|(name, _)| *name != param.name) {
                axes.push((param.name, values));
            }
        }
        let fixed: Vec<(&str, f64)> = [
            ("mu_static", friction.0), ("mu_coulomb", friction.1), ("segments", 4.0),
            ("time", 0.5), ("speed", 0.1),
        ].into_iter().filter(|(name, _)| axes.iter().all(|(axis, _)| axis != name)).collect();
        let requests = || closed().map(|entry| Request { entry, reduce: None }).collect();
        let job = Job::new(Grid::new(&axes, &fixed).unwrap(), requests(), None, &Choice::default()).unwrap();
        let mut values = vec![vec![0.0; job.cells()]; closed().count()];
        let mut codes = vec![vec![0u8; job.cells()]; closed().count()];
        let mut buffers: Vec<_> = values.iter_mut().map(|v| Buffer::F64(v)).enumerate().collect();
        buffers.extend(codes.iter_mut().map(|c| Buffer::Status(c)).enumerate());
        let options = Options { threads: 1, chunk: 64, level: Level::current().unwrap(), fresh: false };
        run(&job, buffers, options, &Control::default()).unwrap();
        for ((entry, values), codes) in closed().zip(&values).zip(&codes) {
            for (value, code) in values.iter().zip(codes) {
                prop_assert_eq!(value.is_nan(), *code != 0, "{}: {} with {}", entry.info.name, value, code);
                prop_assert!(!value.is_infinite(), "{} is {} on {:?}", entry.info.name, value, &axes);
                prop_assert!(
                    *code != Status::NotFinite as u8,
                    "{} gives no reason on {:?} {:?}", entry.info.name, &axes, &fixed
                );
            }
        }
    }
}
