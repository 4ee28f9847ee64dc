//! A trajectory in a lane is the same trajectory on plain numbers, bit for bit.

use super::*;
use locosweep::integrate::bristle::{self, BristleContact, Rosenbrock};
use locosweep::integrate::dormand_prince::DormandPrince;
use locosweep::integrate::dry_contact::{self, DryContact};
use locosweep::integrate::exact::{self, Exact};
use locosweep::integrate::runge_kutta::RungeKutta;
use locosweep::integrate::smooth::{self, Ahead, Steps};
use locosweep::integrate::{Advance, Tally, Watch, drive};
use locosweep::physics::drive::Table;
use locosweep::physics::friction::*;
use locosweep::physics::segment::Segment;

type One = fn(&Segment<f64>, &Values, &str) -> Tally<f64>;

fn go_on() -> bool {
    true
}

fn end(segment: &Segment<f64>, method: impl Advance<f64>) -> Tally<f64> {
    drive(segment, method, &[], |_, _| {}, Watch { energy: true, stroke: true, peaks: true })
}

fn dry<Q: Dry>(segment: &Segment<f64>, values: &Values, method: &str) -> Tally<f64> {
    let bound = dry_contact::Bound::<Q, f64>(Q::coefficients(&segment.contact, values));
    let contact: &dyn DryContact<f64> = &bound;
    match method {
        "exact" => {
            let contact = &exact::Bound::<Q, f64>(Q::coefficients(&segment.contact, values));
            end(segment, Exact { segment, contact, go_on })
        }
        "dormand_prince" => end(segment, DormandPrince::new(segment, &bound, (true, true), go_on)),
        "dormand_prince_fixed" => {
            end(segment, DormandPrince::new(segment, &bound, (false, true), go_on))
        }
        _ => {
            let step = segment.step;
            end(segment, RungeKutta::<_, _, _>::new(segment, contact, true, step, go_on))
        }
    }
}

fn smooth<Q: Smooth>(segment: &Segment<f64>, values: &Values, method: &str) -> Tally<f64> {
    if method != "runge_kutta" {
        return bristle::<Stiff<Q>>(segment, values, method);
    }
    let contact = smooth::Bound::<Q, f64>(Q::coefficients(&segment.contact, values));
    end(segment, Steps::new(segment, &contact, true, Ahead(&[]), go_on))
}

fn bristle<Q: Bristle>(segment: &Segment<f64>, values: &Values, method: &str) -> Tally<f64> {
    let bound = bristle::Bound::<Q, f64>(Q::coefficients(&segment.contact, values));
    let contact: &dyn BristleContact<f64> = &bound;
    end(segment, Rosenbrock::new(segment, contact, method == "rosenbrock", go_on))
}

macro_rules! scalars {
    ($($kind:ident $file:ident::$law:ident),+ $(,)?) => {
        &[$(($law::INFO.name, $kind::<$law> as One)),+]
    };
}

const SCALARS: &[(&str, One)] = locosweep::for_each_law!(scalars);

#[test]
fn lanes_give_the_bits_of_the_scalar() {
    assert_eq!(SCALARS.len(), LAWS.len());
    for case in everything() {
        let given = case.given.iter().map(|(name, v)| (ParamId::parse(name).unwrap(), *v));
        let values = Values::of(&given.collect::<Vec<_>>());
        let kind = DriveKind::parse(&case.choice.drive).unwrap();
        let table = Table { times: &case.choice.times, values: &case.choice.values };
        let segment = Segment::new(kind, table, &values);
        let one = SCALARS.iter().find(|one| one.0 == case.choice.law).unwrap().1;
        let tally = one(&segment, &values, case.choice.method.as_deref().unwrap());
        for level in Level::available() {
            let (got, _) = results(&case.all(), Options { level, ..options(1, 64) });
            for (output, got) in Output::ALL.iter().zip(got) {
                let what = format!("{} {} {level:?}", case.name(), output.info().name);
                same(&got, &[output.of(&segment, &tally)], &what);
            }
        }
    }
}
