//! Values at points: which parameters move them, and that they hold.

use super::*;

#[test]
fn every_declared_parameter_matters() {
    let mut random = Random(1);
    let mut silent = Vec::new();
    for formula in formulas() {
        for id in ParamId::all().filter(|id| formula.uses(*id)) {
            let moves = (0..20_000).any(|_| {
                let mut values = random.values(Random::usual);
                let before = formula.value(&values);
                values.0[id as usize] = random.usual(id);
                formula.value(&values).to_bits() != before.to_bits()
            });
            if !moves {
                silent.push(format!("{} of {}", id.param().name, formula.name));
            }
        }
    }
    assert!(silent.is_empty(), "declared, but without effect: {}", silent.join(", "));
}

#[test]
fn no_other_parameter_does() {
    let mut random = Random(2);
    let mut wrong = BTreeSet::new();
    for _ in 0..3000 {
        let values = random.values(Random::usual);
        for formula in formulas() {
            let full = (formula.general)(&values.point(|_| true));
            if full.to_bits() != formula.value(&values).to_bits() {
                wrong.insert(formula.name);
            }
        }
    }
    assert!(wrong.is_empty(), "these read what they don't declare: {wrong:?}");
}

#[test]
fn every_quantity_has_values() {
    let mut random = Random(3);
    let mut found = vec![0; closed().count()];
    for _ in 0..2000 {
        let values = random.values(Random::usual);
        for (found, formula) in found.iter_mut().zip(formulas()) {
            *found += usize::from(!formula.value(&values).is_nan());
        }
    }
    for (found, entry) in found.iter().zip(closed()) {
        assert!(*found > 100, "{} has {found} values in 2000 usual points", entry.info.name);
    }
}

/// What is wrong with the value of one point, if anything.
fn fault(formula: &Formula, values: &Values) -> Option<String> {
    let value = formula.value(values);
    if value.is_nan() {
        let status = (formula.status)(&values.point(|_| true));
        return (matches!(status, Status::Ok | Status::NotFinite))
            .then(|| format!("no reason for no value ({})", status.name()));
    }
    let least = match formula.name {
        "optimal_segments" | "best_segments" => f64::MIN_POSITIVE,
        "resistance" | "net_force" | "net_advance" | "friction_force" => f64::NEG_INFINITY,
        _ => 0.0,
    };
    (!value.is_finite() || value < least).then(|| format!("value {value}"))
}

fn assert_no_fault(points: &[Values]) {
    let all = formulas();
    let faults: Vec<(&str, String, &Values)> = points
        .par_iter()
        .flat_map_iter(|values| {
            all.iter().filter_map(move |f| Some((f.name, fault(f, values)?, values)))
        })
        .collect();
    let mut first = BTreeSet::new();
    let mut report = String::new();
    for (name, what, values) in &faults {
        let kind = what.split(' ').take(3).collect::<Vec<_>>().join(" ");
        if first.insert((*name, kind)) {
            let count = faults.iter().filter(|f| f.0 == *name && f.1 == *what).count();
            report += &format!("\n{name}: {what}, {count} times, first at {:?}\n", values.named());
        }
    }
    assert!(faults.is_empty(), "{} faults{report}", faults.len());
}

/// Points at random: those of the quick tests, and those that take a quarter of a minute.
const FEW: usize = 20_000;
const MANY: usize = 200_000;

fn a_value_or_a_reason(count: usize, seed: u64, draw: fn(&mut Random, ParamId) -> f64) {
    let mut random = Random(seed);
    assert_no_fault(&(0..count).map(|_| random.values(draw)).collect::<Vec<_>>());
}

#[test]
fn a_value_or_a_reason_at_usual_points() {
    a_value_or_a_reason(FEW, 4, Random::usual);
}

#[test]
fn a_value_or_a_reason_at_extreme_points() {
    a_value_or_a_reason(FEW, 5, Random::allowed);
}

#[test]
#[ignore = "takes a quarter of a minute"]
fn a_value_or_a_reason_at_many_points() {
    a_value_or_a_reason(MANY, 4, Random::usual);
    a_value_or_a_reason(MANY, 5, Random::allowed);
}

#[test]
fn plain_and_general_give_the_same_bits() {
    plain_is_general(FEW);
}

#[test]
#[ignore = "takes five seconds"]
fn plain_and_general_give_the_same_bits_at_many_points() {
    plain_is_general(MANY);
}

fn plain_is_general(count: usize) {
    let mut random = Random(6);
    let mut wrong = BTreeSet::new();
    let mut report = String::new();
    for i in 0..count {
        let mut values = random.values(if i % 2 == 0 { Random::usual } else { Random::allowed });
        for (id, value) in [
            (ParamId::Viscous, 0.0),
            (ParamId::Brake, 0.0),
            (ParamId::AnchorsAhead, 0.0),
            (ParamId::DriveLimit, f64::INFINITY),
            (ParamId::SpeedLimit, f64::INFINITY),
        ] {
            values.0[id as usize] = value;
        }
        let slope = &mut values.0[ParamId::SlopeDeg as usize];
        *slope = slope.abs();
        let moving = values.0[ParamId::Moving as usize];
        let segments = &mut values.0[ParamId::Segments as usize];
        *segments = segments.max(moving + 1.0);
        for formula in formulas() {
            let point = values.point(|id| formula.uses(id));
            let (general, plain) = ((formula.general)(&point), (formula.plain)(&point));
            if general.to_bits() != plain.to_bits() && wrong.insert(formula.name) {
                report += &format!(
                    "\n{}: general {general}, plain {plain} at {:?}\n",
                    formula.name,
                    values.named()
                );
            }
        }
    }
    assert!(wrong.is_empty(), "{report}");
}
