//! Friction laws against published numbers, and against each other where one
//! turns into a simpler one.

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
    (law(name).resistance)(values, v, &Place::start(v.signum()), &NONE)
}

fn steady(name: &str, values: &Values, v: f64) -> f64 {
    (law(name).steady)(values, v)
}

#[track_caller]
fn close(got: f64, expected: f64, relative: f64) {
    let error = (got - expected).abs();
    assert!(error <= relative * expected.abs(), "{got:.12} and not {expected:.12}");
}

fn set<B: Bristle>(values: &Values) -> B::Set<f64> {
    B::set(&Contact::of(values), values)
}

/// Force and work after moving slowly through `turns` from `z`: Runge-Kutta
/// along the path, where only the direction of the speed counts.
struct Path<B: Bristle> {
    set: B::Set<f64>,
    x: f64,
    z: States,
    work: f64,
}

impl<B: Bristle> Path<B> {
    fn start(values: &Values) -> Self {
        Path { set: set::<B>(values), x: 0.0, z: NONE, work: 0.0 }
    }

    fn slope(&self, way: f64, z: &States) -> (States, f64) {
        let v = way * 1e-12;
        let rates = B::rates(&self.set, v, z);
        (rates.map(|rate| rate / v), B::force(&self.set, 0.0, z, &NONE))
    }

    fn to(&mut self, x: f64, steps: usize) -> f64 {
        let step = (x - self.x) / steps as f64;
        let way = step.signum();
        for _ in 0..steps {
            let along = |k: &(States, f64), share: f64| {
                std::array::from_fn(|i| self.z[i] + share * step * k.0[i])
            };
            let a = self.slope(way, &self.z);
            let b = self.slope(way, &along(&a, 0.5));
            let c = self.slope(way, &along(&b, 0.5));
            let d = self.slope(way, &along(&c, 1.0));
            let mean = |a: f64, b: f64, c: f64, d: f64| (a + 2.0 * b + 2.0 * c + d) / 6.0;
            for i in 0..B::STATES {
                self.z[i] += step * mean(a.0[i], b.0[i], c.0[i], d.0[i]);
            }
            self.work += step * mean(a.1, b.1, c.1, d.1);
        }
        self.x = x;
        B::force(&self.set, 0.0, &self.z, &NONE)
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
    let set = set::<Lugre>(&values);
    let z = [0.01, 0.0, 0.0, 0.0];
    for (v, rate, force) in [(0.2, 0.1731481, 1.2997222), (-0.2, -0.2268519, 0.6197222)] {
        let rates = Lugre::rates(&set, v, &z);
        close(rates[0], rate, 1e-6);
        close(Lugre::force(&set, v, &z, &rates), force, 1e-7);
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
    let set = set::<MaxwellSlip>(&values);
    let z = [1e4, 2e4, 4e4, 8e4].map(|k| 0.375 / k);
    let rates = MaxwellSlip::rates(&set, 0.1, &z);
    for (rate, k) in rates.iter().zip([1e4, 2e4, 4e4, 8e4]) {
        close(k * rate, -100.0 * 0.25 * 0.5, 1e-12);
    }
    // Back and stopped elements bend elastically.
    assert_eq!(MaxwellSlip::rates(&set, -0.1, &z), [-0.1; 4]);
    assert_eq!(MaxwellSlip::rates(&set, 0.0, &z), NONE);
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
    let set = set::<Lugre>(&values);
    let rest = Lugre::partials(&set, 0.0, &NONE);
    close(rest.force_v / (2.0 * rest.force_z[0].sqrt()), 0.50063, 1e-5);
    let sliding = Lugre::partials(&set, 0.1, &NONE);
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
        let held = (law.holding)(&values, &Place::start(1.0));
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

/// Pairs that agree to the last bit where a parameter leaves its term out.
#[test]
fn laws_without_their_term_are_simpler_laws() {
    let base = [("mu_static", 0.7), ("mu_coulomb", 0.4), ("viscous", 1.3)];
    let equal = [("mu_static", 0.4), ("mu_coulomb", 0.4), ("viscous", 1.3)];
    let dry = [("mu_static", 0.7), ("mu_coulomb", 0.4), ("viscous", 0.0)];
    let cases: [Limit; 18] = [
        ("coulomb_viscous", &dry, "coulomb"),
        ("static_coulomb", &base, "coulomb"),
        ("quadratic", &base, "coulomb_viscous"),
        ("power_drag", &base, "coulomb"),
        ("static_viscous", &dry, "static_coulomb"),
        ("static_viscous", &base, "coulomb_viscous"),
        ("load_friction", &base, "static_viscous"),
        ("load_viscous", &base, "coulomb_viscous"),
        ("directional", &base, "static_viscous"),
        ("ripple", &base, "static_viscous"),
        ("patch", &base, "static_viscous"),
        ("track", &base, "static_viscous"),
        ("buildup", &base, "coulomb_viscous"),
        ("tustin", &equal, "coulomb_viscous"),
        ("bo_pavelescu", &equal, "coulomb_viscous"),
        ("stribeck", &equal, "coulomb_viscous"),
        ("hess_soom", &equal, "coulomb_viscous"),
        ("modelica", &equal, "coulomb_viscous"),
    ];
    for (name, given, simpler) in cases {
        let values = contact(9.81, given);
        for way in [1.0, -1.0] {
            let place = Place { way, x: 0.37, swept: 0.2, drive: 4.0, t: 0.0 };
            for speed in [0.0, 1e-4, 0.03, 2.0] {
                let [got, expected] =
                    [name, simpler].map(|n| (law(n).resistance)(&values, speed, &place, &NONE));
                assert_eq!(got.to_bits(), expected.to_bits(), "{name} and {simpler} at {speed}");
            }
        }
    }
}

#[test]
fn limits_between_laws() {
    let base = [
        ("mu_static", 0.8),
        ("mu_coulomb", 0.5),
        ("viscous", 2.0),
        ("stribeck_speed", 0.0625),
        ("modelica_decay", 16.0),
        ("power_drag", 2.0),
        ("power_exponent", 1.0),
        ("transition_speed", 1e-7),
    ];
    let with = |more: &[(&str, f64)]| contact(10.0, &[&base[..], more].concat());
    let values = with(&[("stribeck_exponent", 1.0)]);
    let bell = with(&[("stribeck_exponent", 2.0)]);
    for v in [1e-3, 0.02, 0.1, 0.5, 3.0] {
        assert_eq!(force("modelica", &values, v), force("tustin", &values, v));
        close(force("bo_pavelescu", &values, v), force("tustin", &values, v), 1e-15);
        close(force("bo_pavelescu", &bell, v), force("stribeck", &bell, v), 1e-15);
        close(force("power_drag", &values, v), force("coulomb_viscous", &values, v), 1e-15);
        // Regularised laws far above their transition, bristles in steady sliding.
        close(force("tanh", &values, v), force("stribeck", &values, v), 1e-15);
        close(force("bengisu_akay", &values, v), force("tustin", &values, v), 1e-5);
        for name in ["brown_mcphee", "simscape"] {
            close(force(name, &values, v), force("coulomb_viscous", &values, v), 1e-9);
        }
        for name in ["lugre", "elasto_plastic", "maxwell_slip"] {
            close(steady(name, &values, v), force("stribeck", &values, v), 1e-14);
        }
        close(steady("dahl", &values, v), force("coulomb_viscous", &values, v), 1e-14);
        // A thick film: only its shear is left.
        let film = with(&[("mixed_speed", 1e-6)]);
        close(force("mixed", &film, v), 2.0 * v, 1e-15);
    }
    // Equal levels and no damping: LuGre is Dahl's curve with exponent 1.
    let plain = contact(10.0, &[("mu_static", 0.5), ("mu_coulomb", 0.5), ("bristle_damping", 0.0)]);
    let (lugre, dahl) = (set::<Lugre>(&plain), set::<Dahl>(&plain));
    for z in [-4e-5, -1e-6, 0.0, 3e-5, 4.9e-5] {
        for v in [-0.3, 0.01] {
            let z = [z, 0.0, 0.0, 0.0];
            let [a, b] = [Lugre::rates(&lugre, v, &z), Dahl::rates(&dahl, v, &z)];
            assert!((a[0] - b[0]).abs() <= 1e-14 * v.abs(), "{a:?} {b:?}");
        }
    }
    for law in LAWS.iter().filter(|law| law.kind == Kind::Bristle) {
        let mu = if law.uses(ParamId::MuStatic) { 0.8 } else { 0.5 };
        close((law.holding)(&values, &Place::start(-1.0)), 10.0 * mu, 1e-9);
    }
}

#[test]
fn elasto_plastic_bristles_do_not_slide_below_their_share() {
    let values = standard(&[("elastic_share", 0.7)]);
    let set = set::<ElastoPlastic>(&values);
    // 0.7 F_C/sigma_0 is 7 um; g at rest 15 um.
    for v in [-1e-3, 1e-6, 0.2] {
        for um in [-6.9, -1.0, 0.0, 5.0, 6.9] {
            let z = [um * 1e-6, 0.0, 0.0, 0.0];
            assert_eq!(ElastoPlastic::rates(&set, v, &z)[0], v);
        }
        let back = [-v.signum() * 14e-6, 0.0, 0.0, 0.0];
        assert_eq!(ElastoPlastic::rates(&set, v, &back)[0], v);
        let beyond = [v.signum() * 20e-6, 0.0, 0.0, 0.0];
        assert!(ElastoPlastic::rates(&set, v, &beyond)[0] / v < 0.0);
    }
}

#[test]
fn gonthier_breaks_away_at_what_it_dwelled_for() {
    let set = set::<Gonthier>(&standard(&[("viscous", 0.0), ("dwell_time", 2.0)]));
    for (dwell, level) in [(0.0, 1.0), (0.5, 1.25), (1.0, 1.5)] {
        let z = [1.0, dwell, 0.0, 0.0];
        let rates = Gonthier::rates(&set, 1e-9, &z);
        close(Gonthier::force(&set, 1e-9, &z, &rates), level, 1e-9);
        assert!((rates[1] - (1.0 - dwell) / 2.0).abs() < 1e-8);
    }
    // Sliding forgets at the relaxation time of the bristles.
    let rates = Gonthier::rates(&set, 0.1, &[1e-5, 1.0, 0.0, 0.0]);
    close(rates[1], -(1e5 / 316.227_766_016_837_94), 1e-12);
}

#[test]
fn directional_skin_holds_both_ways() {
    let given = [("mu_static", 0.5), ("mu_coulomb", 0.25), ("skin_ratio", 3.0), ("viscous", 2.0)];
    let values = contact(8.0, &given);
    let skin = law("directional");
    for (way, holds, slides) in [(1.0, 4.0, 2.2), (-1.0, 12.0, 6.2)] {
        assert_eq!((skin.holding)(&values, &Place::start(way)), holds);
        close((skin.resistance)(&values, 0.1, &Place::start(way), &NONE), slides, 1e-15);
    }
}

/// Friction along the track, at no viscous part.
fn along(name: &str, values: &Values, x: f64) -> f64 {
    (law(name).resistance)(values, 1.0, &Place { x, ..Place::start(1.0) }, &NONE)
}

#[test]
fn spline_of_the_track_is_smooth_periodic_and_never_negative() {
    let ratios = [0.2, 1.7, 0.6, 1.1, 2.5, 0.9];
    let names = ["track_1", "track_2", "track_3", "track_4", "track_5", "track_6"];
    let track = |ratios: [f64; 6]| {
        let mut given = vec![("mu_static", 1.0), ("mu_coulomb", 1.0), ("track_length", 0.75)];
        given.extend(names.into_iter().zip(ratios));
        contact(1.0, &given)
    };
    let values = track(ratios);
    for k in -12..12i32 {
        let x = 0.125 * f64::from(k);
        close(along("track", &values, x), ratios[k.rem_euclid(6) as usize], 1e-13);
        // Slope and curvature meet at the knots.
        let h = 1e-4;
        let at = |i: i32| along("track", &values, x + f64::from(i) * h);
        let slopes = [(at(0) - at(-1)) / h, (at(1) - at(0)) / h];
        assert!((slopes[0] - slopes[1]).abs() < 0.1, "kink at {x}: {slopes:?}");
        let bends = [at(-2) - 2.0 * at(-1) + at(0), at(0) - 2.0 * at(1) + at(2)];
        let jump = (bends[0] - bends[1]) / (h * h);
        assert!(jump.abs() < 3.0, "curvature jumps at {x} by {jump}");
        for s in [0.01, 0.05, 0.11] {
            let (here, next) =
                (along("track", &values, x + s), along("track", &values, x + s + 0.75));
            close(next, here, 1e-12);
        }
    }
    // Just below zero the place rounds to the end of the track.
    close(along("track", &values, -1e-300), ratios[0], 1e-14);
    let spike = track([0.0, 0.0, 0.0, 9.0, 0.0, 0.0]);
    for k in 0..1000 {
        assert!(along("track", &spike, f64::from(k) * 1e-3) >= 0.0);
    }
    assert_eq!(along("track", &spike, 0.2), 0.0);
}

#[test]
fn ripple_and_patch_along_the_track() {
    let given = [
        ("mu_static", 1.0),
        ("mu_coulomb", 1.0),
        ("ripple_amplitude", 1.0),
        ("ripple_length", 0.5),
        ("patch_start", 0.25),
        ("patch_length", 0.5),
        ("patch_ratio", 3.0),
    ];
    for (x, force) in [(0.0, 2.0), (0.125, 4.0), (0.375, 0.0), (1e6 + 0.125, 4.0)] {
        assert_eq!(along("ripple", &contact(2.0, &given), x), force);
    }
    for (x, force) in [(0.2, 2.0), (0.25, 6.0), (0.74, 6.0), (0.75, 2.0), (-0.3, 2.0)] {
        assert_eq!(along("patch", &contact(2.0, &given), x), force);
    }
}
