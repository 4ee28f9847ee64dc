//! Friction laws against published numbers, and against each other where one
//! turns into a simpler one.

mod along;
mod limits;

use locosweep::physics::ParamId;
use locosweep::physics::friction::*;

type States = [f64; MOST_STATES];
const NONE: States = [0.0; MOST_STATES];

/// Mass and gravity for a normal force.
fn contact(normal: f64, given: &[(&str, f64)]) -> Values {
    let mut all = vec![("mass", 1.0), ("gravity", normal)];
    all.extend_from_slice(given);
    Values::named(&all).unwrap()
}

fn law(name: &str) -> &'static LawEntry {
    LawEntry::parse(name).unwrap()
}

/// Resistance at the origin.
fn force(name: &str, values: &Values, v: f64) -> f64 {
    (law(name).resistance)(values, v, &ContactState::start(v.signum()), &NONE)
}

fn steady(name: &str, values: &Values, v: f64) -> f64 {
    (law(name).steady)(values, v)
}

#[track_caller]
fn close(got: f64, expected: f64, relative: f64) {
    let error = (got - expected).abs();
    assert!(error <= relative * expected.abs(), "{got:.12} and not {expected:.12}");
}

fn coefficients<B: Bristle>(values: &Values) -> B::Coefficients<f64> {
    B::coefficients(&Contact::of(values), values)
}

/// Force and work after moving slowly through `turns` from `z`: Runge-Kutta
/// along the path, where only the direction of the speed counts.
struct Path<B: Bristle> {
    law: B::Coefficients<f64>,
    x: f64,
    z: States,
    work: f64,
}

impl<B: Bristle> Path<B> {
    fn start(values: &Values) -> Self {
        Path { law: coefficients::<B>(values), x: 0.0, z: NONE, work: 0.0 }
    }

    fn slope(&self, direction: f64, z: &States) -> (States, f64) {
        let v = direction * 1e-12;
        let rates = B::rates(&self.law, v, z);
        (rates.map(|rate| rate / v), B::force(&self.law, 0.0, z, &NONE))
    }

    fn to(&mut self, x: f64, steps: usize) -> f64 {
        let step = (x - self.x) / steps as f64;
        let direction = step.signum();
        for _ in 0..steps {
            let along = |k: &(States, f64), share: f64| {
                std::array::from_fn(|i| self.z[i] + share * step * k.0[i])
            };
            let a = self.slope(direction, &self.z);
            let b = self.slope(direction, &along(&a, 0.5));
            let c = self.slope(direction, &along(&b, 0.5));
            let d = self.slope(direction, &along(&c, 1.0));
            let mean = |a: f64, b: f64, c: f64, d: f64| (a + 2.0 * b + 2.0 * c + d) / 6.0;
            for i in 0..B::STATES {
                self.z[i] += step * mean(a.0[i], b.0[i], c.0[i], d.0[i]);
            }
            self.work += step * mean(a.1, b.1, c.1, d.1);
        }
        self.x = x;
        B::force(&self.law, 0.0, &self.z, &NONE)
    }
}

#[test]
fn numbers_of_a_friction_library() {
    let values = contact(12.0, &[("mu_coulomb", 0.35)]);
    close(force("coulomb", &values, 1.0), 4.2, 1e-15);
    let given = [("mu_static", 0.8), ("mu_coulomb", 0.4), ("stribeck_speed", 0.5)];
    let values = contact(10.0, &[&given[..], &[("viscous", 2.0)]].concat());
    close(force("stribeck", &values, 0.25), 7.6152031, 1e-8);
    // That library's LuGre falls along a rational curve: the bell that agrees
    // with it at this speed.
    let stribeck = 0.2 / 1.16f64.ln().sqrt();
    let values = contact(
        10.0,
        &[
            ("mu_static", 0.8),
            ("mu_coulomb", 0.4),
            ("stribeck_speed", stribeck),
            ("bristle_stiffness", 100.0),
            ("bristle_damping", 1.5),
            ("viscous", 0.2),
        ],
    );
    let law = coefficients::<Lugre>(&values);
    let z = [0.01, 0.0, 0.0, 0.0];
    for (v, rate, force) in [(0.2, 0.1731481, 1.2997222), (-0.2, -0.2268519, 0.6197222)] {
        let rates = Lugre::rates(&law, v, &z);
        close(rates[0], rate, 1e-6);
        close(Lugre::force(&law, v, &z, &rates), force, 1e-7);
    }
}

/// A spring that slides: four alike of a quarter each, elastic to 99 %.
#[test]
fn maxwell_slip_has_the_numbers_of_one_element() {
    let alike = [
        ("bristle_stiffness", 100.0),
        ("stiffness_spread", 1.0),
        ("elastic_share", 0.99),
        ("mu_coulomb", 0.3),
    ];
    for (mu_static, path, forces) in [
        (0.3, [0.01, 0.2, 0.19, 0.0], [1.0, 3.0, 2.0, -3.0]),
        (0.8, [0.03, 0.2, 0.18, 0.0], [3.0, 8.0, 6.0, -8.0]),
    ] {
        let values = contact(10.0, &[&alike[..], &[("mu_static", mu_static)]].concat());
        let mut element = Path::<MaxwellSlip>::start(&values);
        for (x, force) in path.into_iter().zip(forces) {
            close(element.to(x, 20_000), force, 1e-6);
        }
    }
}

#[test]
fn maxwell_slip_elements_slide_one_after_the_other() {
    let values = contact(
        1.0,
        &[
            ("mu_static", 1.5),
            ("mu_coulomb", 1.0),
            ("bristle_stiffness", 1.5e5),
            ("elastic_share", 0.99),
            ("attraction", 100.0),
            ("stribeck_speed", 1e-3),
        ],
    );
    // Stiffness 1, 2, 4, 8 e4 N/m, each slides at 0.375 N: after 37.5, 18.75,
    // 9.375 and 4.6875 um; between those corners the slope is what still bends.
    let mut path = Path::<MaxwellSlip>::start(&values);
    for (um, force) in [(4.0, 0.6), (7.0, 0.375 + 0.49), (14.0, 0.75 + 0.42), (30.0, 1.125 + 0.3)] {
        close(path.to(um * 1e-6, 20_000), force, 1e-6);
    }
    close(path.to(1e-3, 100_000), 1.5, 1e-9);
    // Masing: on the way back each element bends by twice its limit, so that
    // the curve is the first one at double scale.
    let turn = path.x;
    close(path.to(turn - 28e-6, 20_000), 1.5 - 2.0 * (0.75 + 0.42), 1e-6);
    // At speed the level has fallen to 1 N: what is above decays at C (w - 1).
    let law = coefficients::<MaxwellSlip>(&values);
    let z = [1e4, 2e4, 4e4, 8e4].map(|k| 0.375 / k);
    let rates = MaxwellSlip::rates(&law, 0.1, &z);
    for (rate, k) in rates.iter().zip([1e4, 2e4, 4e4, 8e4]) {
        close(k * rate, -100.0 * 0.25 * 0.5, 1e-12);
    }
    // Back and stopped elements bend elastically.
    assert_eq!(MaxwellSlip::rates(&law, -0.1, &z), [-0.1; 4]);
    assert_eq!(MaxwellSlip::rates(&law, 0.0, &z), NONE);
}

fn standard(more: &[(&str, f64)]) -> Values {
    let given = [
        ("mu_static", 1.5),
        ("mu_coulomb", 1.0),
        ("stribeck_speed", 1e-3),
        ("bristle_stiffness", 1e5),
        ("bristle_damping", 316.227_766_016_837_94),
        ("viscous", 0.4),
    ];
    contact(1.0, &[&given[..], more].concat())
}

#[test]
fn standard_set_of_lugre() {
    let values = standard(&[]);
    for (mm, force) in
        [(0.5, 1.3896004), (1.0, 1.1843397), (2.0, 1.0099578), (5.0, 1.0020000), (100.0, 1.04)]
    {
        for name in ["lugre", "elasto_plastic", "maxwell_slip"] {
            close(steady(name, &values, mm * 1e-3), force, 1e-7);
            close(steady(name, &values, -mm * 1e-3), -force, 1e-7);
        }
    }
    // Damping ratio of a unit mass on the bristles, and their time constant in
    // sliding.
    let law = coefficients::<Lugre>(&values);
    let rest = Lugre::partials(&law, 0.0, &NONE);
    close(rest.force_v / (2.0 * rest.force_z[0].sqrt()), 0.50063, 1e-5);
    let sliding = Lugre::partials(&law, 0.1, &NONE);
    close(-1.0 / sliding.rate_z[0][0], 1e-4, 1e-12);
}

#[test]
fn presliding_curves() {
    let values = standard(&[("viscous", 0.0)]);
    let mut path = Path::<Lugre>::start(&values);
    for (um, share) in [(10.3972, 0.5), (24.1416, 0.8), (44.9360, 0.95)] {
        close(path.to(um * 1e-6, 500), share * 1.5, 1e-5);
        close(path.to(path.x, 1), 1.5 * (1.0 - (-1e5 * path.x / 1.5).exp()), 1e-9);
    }
    for (amplitude, tip, work) in [(1e-5, 0.7615942, 9.536234e-6), (1e-4, 1.0, 3.6e-4)] {
        let mut loops = Path::<Dahl>::start(&values);
        loops.to(amplitude, 2000);
        for _ in 0..10 {
            loops.to(-amplitude, 2000);
            loops.to(amplitude, 2000);
        }
        loops.work = 0.0;
        close(loops.to(-amplitude, 2000), -tip, 1e-7);
        close(loops.to(amplitude, 2000), tip, 1e-7);
        close(loops.work, work, 1e-6);
    }
    // Exponent 2: dF/dx = sigma_0 (1 - F)^2, F = s/(1 + s) with s = sigma_0 x.
    let mut ductile = Path::<Dahl>::start(&standard(&[("viscous", 0.0), ("dahl_exponent", 2.0)]));
    close(ductile.to(3e-5, 2000), 0.75, 1e-9);
    // Exponent 1/2: 1 - (1 - s/2)^2, at its level from s = 2 on.
    let mut brittle = Path::<Dahl>::start(&standard(&[("viscous", 0.0), ("dahl_exponent", 0.5)]));
    close(brittle.to(1e-5, 2000), 0.75, 1e-9);
}

#[test]
fn regularised_laws_creep_at_half_the_level() {
    let given = [("mu_static", 0.3), ("mu_coulomb", 0.3), ("transition_speed", 2e-3)];
    let values = contact(10.0, &given);
    close(force("tanh", &values, 0.549306 * 2e-3), 1.5, 1e-6);
    close(force("threlfall", &values, 0.231049 * 2e-3), 1.5, 1e-6);
    for v in [2e-3, 5e-3, 1.0] {
        close(force("threlfall", &values, v), 3.0 * 0.950213, 1e-6);
    }
    for law in LAWS {
        let held = (law.break_away)(&values, &ContactState::start(1.0));
        assert_eq!(held == 0.0, law.kind == Kind::Smooth, "{} holds {held}", law.info.name);
    }
}

#[test]
fn identities_of_smooth_laws_at_their_peak() {
    let given =
        [("mu_static", 0.8), ("mu_coulomb", 0.5), ("transition_speed", 1e-3), ("viscous", 3.0)];
    let values = contact(10.0, &given);
    assert!((force("simscape", &values, 1e-3) - (8.0 + 3e-3)).abs() <= 4.2e-9 * 5.0);
    let below = 8.0 - 5.0 * (1.0 - 0.999329) + 3e-3;
    close(force("brown_mcphee", &values, 1e-3), below, 1e-6);
    close(force("bengisu_akay", &values, 1e-3), 8.0 + 3e-3, 1e-14);
    let (left, right) = (1e-3f64.next_down(), 1e-3f64.next_up());
    close(force("bengisu_akay", &values, left), force("bengisu_akay", &values, right), 1e-12);
}

/// A law, what it is given, and the law that it then is.
type Limit<'a> = (&'a str, &'a [(&'a str, f64)], &'a str);
