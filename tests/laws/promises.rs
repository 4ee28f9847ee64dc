//! What every law promises.

use super::*;

#[test]
fn records_are_complete() {
    let mut names: Vec<_> = LAWS.iter().map(|law| law.info.name).collect();
    assert_eq!(LAWS.len(), laws().len());
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), LAWS.len(), "two laws share a name");
    for law in LAWS {
        let LawInfo { name, formula, source, limits, meaning, params, .. } = law.info;
        for text in [formula, source, limits, meaning] {
            assert!(text.len() > 8 && !text.ends_with('.'), "{name}: '{text}'");
        }
        assert_eq!(formula.matches('{').count(), formula.matches('}').count(), "{name}");
        assert_eq!(law.states > 0, law.kind == Kind::Bristle, "{name}");
        assert!(!law.linear || law.kind == Kind::Dry && !law.placed, "{name}");
        assert!(law.states <= MOST_STATES);
        assert_eq!(LawEntry::parse(name).unwrap().info, law.info);
        for param in params {
            assert!(ParamId::parse(param).is_ok(), "{name} names {param}");
        }
    }
}

#[test]
fn reference_values() {
    for law in LAWS {
        let ReferenceValue { parameters, speed, at, states, force, digits } = law.info.reference;
        let name = law.info.name;
        assert!(force != 0.0, "{name} has no reference value");
        let values = Values::named(parameters).unwrap();
        law.check(&values).unwrap_or_else(|error| panic!("{name}: {error}"));
        let direction = if speed < 0.0 { -1.0 } else { 1.0 };
        let contact_state =
            ContactState { direction, x: at.0, sliding_distance: at.1, drive: at.2, t: 0.0 };
        let got = match law.kind {
            Kind::Dry => {
                direction * (law.resistance)(&values, speed.abs(), &contact_state, &states)
            }
            _ => (law.resistance)(&values, speed, &contact_state, &states),
        };
        let error = (got / force - 1.0).abs();
        assert!(error <= digits, "{name}: {got:.17} and not {force:.17}");
    }
}

/// Integrators do not watch what rests under a law that does not age.
#[test]
fn a_dry_law_that_changes_with_time_says_so() {
    let mut random = Random(5);
    for law in laws().into_iter().filter(|law| law.entry.kind == Kind::Dry) {
        for _ in 0..100 {
            let mut case = random.usual_case(law.entry);
            let now = (law.outputs)(&case);
            case.ask.contact_state.t += 1.0;
            let name = law.entry.info.name;
            assert!(now[AGES] == 1.0 || now == (law.outputs)(&case), "{name} changes with time");
        }
    }
}

#[test]
fn every_named_parameter_counts_and_no_other() {
    let mut random = Random(3);
    for law in laws() {
        let cases: Vec<_> = (0..300)
            .map(|_| {
                let values = random.values(Random::usual);
                let case = random.usual_case(law.entry);
                (values, case.ask)
            })
            .collect();
        for id in ParamId::all() {
            let moved = cases.iter().any(|(values, ask)| {
                let mut other = values.clone();
                other[id as usize].1 = random.usual(id) * 1.01 + 0.003;
                let [before, after] = [values, &other]
                    .map(|values| (law.outputs)(&Case { values: Values::of(values), ask: *ask }));
                before.map(f64::to_bits) != after.map(f64::to_bits)
            });
            let name = law.entry.info.name;
            assert_eq!(moved, law.entry.uses(id), "{name} and {}", id.param().name);
        }
    }
}

#[test]
fn friction_never_drives() {
    let mut random = Random(5);
    for law in laws() {
        let LawEntry { info: LawInfo { name, .. }, resistance, steady, break_away, .. } = law.entry;
        for _ in 0..3000 {
            let mut case = random.usual_case(law.entry);
            let v = case.ask.speed;
            if random.unit() < 0.3 {
                case.values = Values::of(&random.values(Random::hostile));
            }
            let Case { values, ask } = &case;
            let force = resistance(values, v, &ask.contact_state, &ask.states);
            if law.entry.kind != Kind::Bristle {
                assert!(force * v >= 0.0, "{name}: {force} at {v}");
            }
            for v in [v, -v] {
                assert!(steady(values, v) * v >= 0.0, "{name}: {} at {v}", steady(values, v));
            }
            if law.entry.kind == Kind::Smooth {
                let back = resistance(values, -v, &ask.contact_state, &ask.states);
                assert_eq!(back, -force, "{name} is not odd at {v}");
                assert_eq!(resistance(values, 0.0, &ask.contact_state, &ask.states), 0.0, "{name}");
            }
            for direction in [1.0, -1.0] {
                let contact_state = ContactState { direction, ..ask.contact_state };
                assert!(break_away(values, &contact_state) >= 0.0, "{name}");
            }
        }
    }
}

#[test]
fn all_numbers_stay_finite() {
    let mut random = Random(9);
    for law in laws() {
        for k in 0..4000 {
            let values = random.values(Random::hostile);
            let mut ask = random.ask(1e-4);
            ask.speed = match (k % 4, law.entry.kind) {
                (0, Kind::Dry) => -random.log(1e-9, 1e3),
                (0, _) => 1e6 * random.sign(),
                (1, _) => 0.0,
                _ => ask.speed,
            };
            ask.contact_state.x *= [1.0, 1e6][k % 2];
            ask.contact_state.sliding_distance *= [1.0, -1e-3, 1e6][k % 3];
            let case = Case { values: Values::of(&values), ask };
            // At rest bristles have no steady state.
            let skip = if ask.speed == 0.0 { 8..12 } else { 0..0 };
            for (i, got) in (law.outputs)(&case).iter().enumerate() {
                let named: Vec<_> = values.iter().filter(|v| law.entry.uses(v.0)).collect();
                let name = law.entry.info.name;
                assert!(
                    skip.contains(&i) || got.is_finite(),
                    "{name}: output {i} is {got} at {ask:?}, {named:?}"
                );
            }
        }
    }
}

#[test]
fn lanes_give_the_bits_of_the_scalar() {
    let mut random = Random(11);
    for law in laws() {
        let mut cases: Vec<_> = (0..480).map(|_| random.usual_case(law.entry)).collect();
        cases.extend((0..160).map(|_| Case {
            values: Values::of(&random.values(Random::hostile)),
            ask: random.ask(1e-5),
        }));
        for level in Level::available() {
            let wide = (law.wide)(level, &cases);
            assert_eq!(wide.len(), cases.len());
            for (k, (got, case)) in wide.iter().zip(&cases).enumerate() {
                for (got, scalar) in got.iter().zip((law.outputs)(case)) {
                    let name = law.entry.info.name;
                    assert_eq!(got.to_bits(), scalar.to_bits(), "{name} {level:?} case {k}");
                }
            }
        }
    }
}

#[test]
fn linear_laws_are_linear() {
    let mut random = Random(13);
    for law in laws().iter().filter(|law| law.entry.linear) {
        for _ in 0..500 {
            let mut case = random.usual_case(law.entry);
            case.ask.contact_state.direction = random.sign();
            let [force, _, level, viscous, ..] = (law.outputs)(&case);
            let line = viscous.mul_add(case.ask.speed, level);
            assert_eq!(force, line, "{}", law.entry.info.name);
        }
    }
}

/// Without a static peak the contact holds exactly what it slides on.
#[test]
fn holding_meets_the_start_of_sliding() {
    let mut random = Random(17);
    for law in LAWS.iter().filter(|law| law.kind == Kind::Dry) {
        for _ in 0..500 {
            let mut values = random.values(Random::usual);
            if law.uses(ParamId::MuStatic) {
                values[ParamId::MuStatic as usize].1 = values[ParamId::MuCoulomb as usize].1;
            }
            let values = Values::of(&values);
            let contact_state =
                ContactState { direction: random.sign(), ..random.ask(0.0).contact_state };
            let start = (law.resistance)(&values, 0.0, &contact_state, &[0.0; MOST_STATES]);
            assert_eq!((law.break_away)(&values, &contact_state), start, "{}", law.info.name);
        }
    }
}

#[test]
fn partials_match_central_differences() {
    let mut random = Random(19);
    for law in laws().iter().filter(|law| law.entry.kind == Kind::Bristle) {
        let name = law.entry.info.name;
        let (mut seen, mut kinks) = (0, 0);
        for _ in 0..2000 {
            let case = random.usual_case(law.entry);
            let here = (law.outputs)(&case);
            for by in 0..=law.entry.states {
                let at = |step: f64| {
                    let mut moved = case.clone();
                    match by {
                        0 => moved.ask.speed += step,
                        j => moved.ask.states[j - 1] += step,
                    }
                    (law.outputs)(&moved)
                };
                let size = if by == 0 { case.ask.speed } else { case.ask.states[by - 1] };
                let step = 1e-5 * size.abs();
                let (low, high) = (at(-step), at(step));
                // Total force, then each rate: index of the value, of its derivative.
                let force = (0, if by == 0 { 2 } else { 15 + by });
                let rates = (0..law.entry.states)
                    .map(|i| (4 + i, if by == 0 { 12 + i } else { 20 + 4 * i + by - 1 }));
                for (value, derivative) in rates.chain([force]) {
                    let slopes =
                        [(high[value] - here[value]) / step, (here[value] - low[value]) / step];
                    let central = 0.5 * (slopes[0] + slopes[1]);
                    let noise = 1e-15 * (here[value].abs() + here[0].abs() * 10.0) / step;
                    let got = here[derivative];
                    let scale = got.abs().max(slopes[0].abs()).max(slopes[1].abs());
                    seen += 1;
                    if (slopes[0] - slopes[1]).abs() > 0.01 * scale + noise {
                        kinks += 1;
                        continue;
                    }
                    let error = (central - got).abs();
                    assert!(
                        error <= 1e-4 * scale + noise,
                        "{name}: d[{value}]/d[{by}] {got} and {central}"
                    );
                }
            }
        }
        assert!(kinks * 50 < seen, "{name}: {kinks} kinks in {seen}");
    }
}

/// In its steady state a bristle law does not change.
#[test]
fn steady_states_are_steady() {
    let mut random = Random(23);
    for law in laws().iter().filter(|law| law.entry.kind == Kind::Bristle) {
        for _ in 0..500 {
            let mut case = random.usual_case(law.entry);
            let steady = (law.outputs)(&case);
            case.ask.states.copy_from_slice(&steady[8..12]);
            let rates = &(law.outputs)(&case)[4..8];
            for (i, rate) in rates.iter().enumerate() {
                // Half of all digits where an exponent below 1 magnifies.
                let small = 1e-6 * case.ask.speed.abs().max(if i == 1 { 1.0 } else { 0.0 });
                assert!(
                    rate.abs() <= small,
                    "{}: rate {i} is {rate} {:?} {steady:?}",
                    law.entry.info.name,
                    case.ask
                );
            }
        }
    }
}

#[test]
fn hostile_values_are_refused_by_name() {
    for law in LAWS {
        for name in law.info.params {
            let param = ParamId::parse(name).unwrap().param();
            let (low, high) = param.range;
            for bad in [f64::NAN, low - 1.0, high * 2.0, f64::NEG_INFINITY] {
                if bad == f64::INFINITY {
                    continue;
                }
                let error = Values::named(&[(name, bad)]).unwrap_err().to_string();
                assert!(error.contains(name) && error.contains(&param.allowed()), "{error}");
            }
        }
        let none = Values::of(&[]);
        match law.check(&none) {
            Err(Error::MissingParameter { name, quantity }) => {
                assert!(name.starts_with("mu_") && quantity.contains(law.info.name));
            }
            other => panic!("{}: {other:?}", law.info.name),
        }
    }
    let error = LawEntry::parse("lugree").map(|law| law.info.name).unwrap_err().to_string();
    assert!(error.contains("did you mean 'lugre'"), "{error}");
    let error = Values::named(&[("mu_statik", 1.0)]).unwrap_err().to_string();
    assert!(error.contains("did you mean 'mu_static'"), "{error}");
    assert!(PARAMS.len() <= 128, "one bit per parameter");
}
