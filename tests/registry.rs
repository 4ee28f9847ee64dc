//! What every registered quantity promises, whatever it computes.

use locosweep::Error;
use locosweep::describe::Param;
use locosweep::lane::Level;
use locosweep::physics::closed_form::*;
use locosweep::physics::point::{COLUMNS, columns};
use locosweep::physics::{PARAMS, ParamId, Point, Quantity, Status};
use locosweep::sweep::{
    Buffer, Control, Entry, Grid, Job, Options, QUANTITIES, Reduce, Request, run,
};
use proptest::prelude::*;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// A quantity's scalar functions.
struct Formula {
    name: &'static str,
    params: &'static [&'static str],
    general: fn(&Point<f64>) -> f64,
    plain: fn(&Point<f64>) -> f64,
    status: fn(&Point<f64>) -> Status,
}

fn formula<Q: Quantity>() -> Formula {
    Formula {
        name: Q::INFO.name,
        params: Q::INFO.params,
        general: Q::value::<f64, false>,
        plain: Q::value::<f64, true>,
        status: Q::status,
    }
}

macro_rules! formulas {
    ($($quantity:ident),+ $(,)?) => { vec![$(formula::<$quantity>()),+] };
}

fn formulas() -> Vec<Formula> {
    locosweep::for_each_quantity!(formulas)
}

impl Formula {
    fn uses(&self, id: ParamId) -> bool {
        self.params.contains(&id.param().name)
    }

    /// The value as the engine computes it: what is not declared is NaN.
    fn value(&self, values: &Values) -> f64 {
        (self.general)(&values.point(|id| self.uses(id)))
    }
}

/// One number per parameter.
#[derive(Debug, Clone)]
struct Values(Vec<f64>);

impl Values {
    fn point(&self, uses: impl Fn(ParamId) -> bool) -> Point<f64> {
        let mut all = [f64::NAN; COLUMNS];
        for id in ParamId::all().filter(|id| uses(*id)) {
            [all[id.main()], all[id.derived()]] = columns(id, self.0[id as usize]);
        }
        Point::gather(|c| all[c])
    }

    fn named(&self) -> Vec<(&'static str, f64)> {
        PARAMS.iter().zip(&self.0).map(|(p, v)| (p.name, *v)).collect()
    }
}

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn log(&mut self, low: f64, high: f64) -> f64 {
        (low.ln() + (high.ln() - low.ln()) * self.unit()).exp().clamp(low, high)
    }

    fn pick(&mut self, from: &[f64]) -> f64 {
        from[((self.unit() * from.len() as f64) as usize).min(from.len() - 1)]
    }

    /// A value that robots have.
    fn usual(&mut self, id: ParamId) -> f64 {
        use ParamId::*;
        match id {
            MuStatic => self.log(0.1, 2.0),
            MuCoulomb => self.log(0.02, 1.0),
            Segments => (2.0 + 18.0 * self.unit()).floor(),
            SlopeDeg => -15.0 + 40.0 * self.unit(),
            Mass => self.log(0.05, 5.0),
            Gravity => self.log(1.0, 20.0),
            Stroke => self.log(1e-3, 0.2),
            Viscous => {
                if self.unit() < 0.4 {
                    0.0
                } else {
                    self.log(0.01, 100.0)
                }
            }
            Moving => (1.0 + 3.0 * self.unit()).floor(),
            AnchorWeight | WallRelease => self.unit(),
            DriveLimit => {
                if self.unit() < 0.4 {
                    f64::INFINITY
                } else {
                    self.log(0.1, 100.0)
                }
            }
            SpeedLimit => {
                if self.unit() < 0.4 {
                    f64::INFINITY
                } else {
                    self.log(1e-3, 1.0)
                }
            }
            AnchorsAhead => (3.0 * self.unit()).floor(),
            Brake | CoulombTerm => (2.0 * self.unit()).floor(),
            SkinRatio => self.log(0.5, 3.0),
            WallForce => {
                if self.unit() < 0.4 {
                    0.0
                } else {
                    self.log(0.01, 20.0)
                }
            }
            CornerDeg => 60.0 * self.unit(),
            Time => self.log(1e-3, 10.0),
            Speed => -1.0 + 2.0 * self.unit(),
            SegmentsMin => (1.0 + 9.0 * self.unit()).floor(),
            SegmentsMax => (10.0 + 50.0 * self.unit()).floor(),
        }
    }

    /// Anything the registry allows, its ends and extremes among them.
    fn allowed(&mut self, id: ParamId) -> f64 {
        let param = id.param();
        let (low, high) = param.range;
        let top = if high.is_infinite() { 1e30 } else { high };
        let sign = if low < 0.0 && self.unit() < 0.5 { -1.0 } else { 1.0 };
        let size = match self.unit() {
            u if u < 0.35 => return self.usual(id),
            u if u < 0.45 => return self.pick(&[low, high, param.default.unwrap_or(low)]),
            u if u < 0.55 => self.log(1e-30, top),
            _ => self.log(low.clamp(1e-9, 1.0), top),
        };
        let value = (sign * size).clamp(low, high);
        if param.integer { value.floor().max(low) } else { value }
    }

    fn values(&mut self, mut one: impl FnMut(&mut Random, ParamId) -> f64) -> Values {
        Values(ParamId::all().map(|id| one(self, id)).collect())
    }
}

#[test]
fn records_are_complete() {
    let mut names = BTreeSet::new();
    for entry in QUANTITIES {
        let info = entry.info;
        for (what, text) in [
            ("name", info.name),
            ("symbol", info.symbol),
            ("unit", info.unit),
            ("formula", info.formula),
            ("source", info.source),
            ("limits", info.limits),
            ("meaning", info.meaning),
        ] {
            assert!(!text.trim().is_empty(), "{} has no {what}", info.name);
        }
        assert!(names.insert(info.name), "{} stands twice", info.name);
        let unique: BTreeSet<_> = info.params.iter().collect();
        assert_eq!(unique.len(), info.params.len(), "{} names a parameter twice", info.name);
        assert!(!info.params.is_empty());
        for id in ParamId::all() {
            assert_eq!(entry.uses(id), info.params.contains(&id.param().name));
        }
        assert!(std::ptr::eq(Entry::parse(info.name).unwrap(), entry));
    }
    for id in ParamId::all() {
        let param = id.param();
        assert!(names.insert(param.name), "{} is a name of two things", param.name);
        assert!(!param.meaning.is_empty() && !param.symbol.is_empty() && !param.unit.is_empty());
        assert_eq!(ParamId::parse(param.name), Ok(id));
        assert!(param.range.0 < param.range.1);
        assert!(param.default.is_none_or(|v| param.allows(v)), "{}: default", param.name);
        assert_eq!(param.name.ends_with("_deg"), param.unit == "deg");
        let used = QUANTITIES.iter().any(|entry| entry.uses(id));
        assert!(used, "nothing takes {}", param.name);
    }
    let mut codes = BTreeSet::new();
    for status in Status::ALL {
        assert!(codes.insert(*status as u8) && names.insert(status.name()));
        assert!(!status.sentence().is_empty());
    }
}

#[test]
fn formulas_are_balanced() {
    let balanced = |text: &str, open: &str, close: &str| {
        let mut depth = 0i32;
        let mut rest = text;
        while !rest.is_empty() {
            if let Some(after) = rest.strip_prefix(open) {
                (depth, rest) = (depth + 1, after);
            } else if let Some(after) = rest.strip_prefix(close) {
                (depth, rest) = (depth - 1, after);
            } else {
                rest = &rest[rest.chars().next().map_or(1, char::len_utf8)..];
            }
            if depth < 0 {
                return false;
            }
        }
        depth == 0
    };
    let texts = QUANTITIES
        .iter()
        .flat_map(|e| [e.info.formula, e.info.symbol])
        .chain(PARAMS.iter().map(|p| p.symbol));
    for text in texts {
        assert!(balanced(text, "{", "}"), "{text}");
        assert!(balanced(text, r"\left", r"\right"), "{text}");
        assert!(balanced(text, "(", ")"), "{text}");
        assert!(!text.contains('$') && !text.contains("  "), "{text}");
    }
    assert!(!balanced("}{", "{", "}") && !balanced("{{}", "{", "}"), "the check sees nothing");
}

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
    let mut found = vec![0; QUANTITIES.len()];
    for _ in 0..2000 {
        let values = random.values(Random::usual);
        for (found, formula) in found.iter_mut().zip(formulas()) {
            *found += usize::from(!formula.value(&values).is_nan());
        }
    }
    for (found, entry) in found.iter().zip(QUANTITIES) {
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

#[test]
fn a_value_or_a_reason_at_usual_points() {
    let mut random = Random(4);
    let points: Vec<_> = (0..100_000).map(|_| random.values(Random::usual)).collect();
    assert_no_fault(&points);
}

#[test]
fn a_value_or_a_reason_at_extreme_points() {
    let mut random = Random(5);
    let points: Vec<_> = (0..100_000).map(|_| random.values(Random::allowed)).collect();
    assert_no_fault(&points);
}

#[test]
fn plain_and_general_give_the_same_bits() {
    let mut random = Random(6);
    let mut wrong = BTreeSet::new();
    let mut report = String::new();
    for i in 0..200_000 {
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

#[test]
fn unknown_names_get_a_hint() {
    let error = Entry::parse("mean_velocty").err().unwrap().to_string();
    assert!(error.contains("mean_velocty") && error.contains("did you mean 'mean_velocity'"));
    let error = ParamId::parse("mu_statc").unwrap_err().to_string();
    assert!(error.contains("'mu_static'"), "{error}");
    let error = Reduce::parse("agmax", None).unwrap_err().to_string();
    assert!(error.contains("'argmax'"), "{error}");
    let error = Entry::parse("Ω").err().unwrap().to_string();
    assert!(error.contains("known are") && error.contains("anchor_capacity"), "{error}");
}

// Hostile input.

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
        let requests = || QUANTITIES.iter().map(|entry| Request { entry, reduce: None }).collect();
        let job = Job::new(Grid::new(&axes, &fixed).unwrap(), requests(), None).unwrap();
        let mut values = vec![vec![0.0; job.cells()]; QUANTITIES.len()];
        let mut codes = vec![vec![0u8; job.cells()]; QUANTITIES.len()];
        let mut buffers: Vec<_> = values.iter_mut().map(|v| Buffer::F64(v)).enumerate().collect();
        buffers.extend(codes.iter_mut().map(|c| Buffer::Status(c)).enumerate());
        let options = Options { threads: 1, chunk: 64, level: Level::current().unwrap(), fresh: false };
        run(&job, buffers, options, &Control::default()).unwrap();
        for ((entry, values), codes) in QUANTITIES.iter().zip(&values).zip(&codes) {
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
