//! The reality against closed forms, against itself at half the step, and with
//! every effect at the value at which it is not there.

use reality::{Effect, FORMS, Readings, Rig, Samples, simulate};
use std::collections::BTreeMap;

const STEP: f64 = 1e-5;

fn rig() -> Rig {
    Rig {
        segments: 4.0,
        mass: 0.8,
        gravity: 9.81,
        mu_coulomb: 0.3,
        coulomb_force: None,
        viscous: 0.0,
        slope_deg: 0.0,
        gain: 1.0,
        limit: f64::INFINITY,
        gravity_torque: None,
        clock: 0.0,
    }
}

fn level() -> f64 {
    rig().reference_level()
}

fn effect(name: &str, form: &str, values: &[(&str, f64)]) -> Effect {
    let values = values.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect::<BTreeMap<_, _>>();
    Effect::new(name, form, &values).unwrap()
}

/// `drive` over four seconds at 200 Hz.
fn samples(drive: impl Fn(f64) -> f64) -> Samples {
    first_samples(800, drive)
}

fn first_samples(count: u32, drive: impl Fn(f64) -> f64) -> Samples {
    let times: Vec<f64> = (0..count).map(|i| f64::from(i) * 0.005).collect();
    let drive = times.iter().map(|t| drive(*t)).collect();
    Samples { times, drive, slope_deg: 0.0 }
}

fn run(rig: &Rig, effects: &[Effect], samples: &Samples) -> Readings {
    simulate(rig, effects, samples, (0.0, 0.0), STEP, 7)
}

fn worst(a: &[f64], b: impl Fn(usize) -> f64) -> f64 {
    a.iter().enumerate().map(|(i, a)| (a - b(i)).abs()).fold(0.0, f64::max)
}

fn step(t: f64) -> f64 {
    if (0.5..1.5).contains(&t) { 4.0 } else { 0.0 }
}

/// There and back, with rests: what excites every effect.
fn rich(t: f64) -> f64 {
    let wave = |f: f64, p: f64| (std::f64::consts::TAU * f * t + p).sin();
    if t < 0.1 { 0.0 } else { 2.1 * (wave(0.7, 0.3) + wave(1.9, 1.0) + wave(3.1, 2.0)) }
}

#[test]
fn coulomb_friction_gives_parabolas_and_an_exact_stop() {
    let found = run(&rig(), &[], &samples(step));
    let (up, down) = ((4.0 - level()) / 0.8, level() / 0.8);
    let stop = 1.5 + up / down;
    let at = |i: usize| {
        let t = f64::from(i as u32) * 0.005;
        let rise = (t - 0.5).clamp(0.0, 1.0);
        let fall = (t.min(stop) - 1.5).max(0.0);
        0.5 * up * rise * rise + up * fall - 0.5 * down * fall * fall
    };
    assert!(worst(&found.x, at) < 1e-10);
    assert_eq!(found.v[799], 0.0);
}

#[test]
fn viscous_friction_gives_an_exponential() {
    let c = 1.7;
    let known = Rig { viscous: 0.7, ..rig() };
    let found = run(&known, &[effect("viscous_friction", "law", &[("c", 1.0)])], &samples(|_| 4.0));
    let end = (4.0 - level()) / c;
    let at = |i: usize| {
        let t = f64::from(i as u32) * 0.005;
        end * (t + 0.8 / c * (-c * t / 0.8).exp_m1())
    };
    assert!(worst(&found.x, at) < 1e-9);
}

#[test]
fn quadratic_drag_gives_a_logarithm_of_a_cosh() {
    let c2: f64 = 3.0;
    let found = run(&rig(), &[effect("quadratic_drag", "law", &[("c2", c2)])], &samples(|_| 4.0));
    let net = 4.0 - level();
    let rate = (net * c2).sqrt() / 0.8;
    let at = |i: usize| 0.8 / c2 * (rate * f64::from(i as u32) * 0.005).cosh().ln();
    assert!(worst(&found.x, at) < 1e-9);
}

#[test]
fn a_head_rests_up_to_its_level_and_on_a_slope_not_further() {
    let flat = run(&rig(), &[], &samples(|_| level() - 1e-9));
    assert_eq!(worst(&flat.x, |_| 0.0), 0.0);
    let slides = run(&rig(), &[], &samples(|_| level() + 1e-3));
    assert!(slides.x[799] > 1e-3);
    // Steeper than the friction angle of 16.7 degrees: it starts by itself, down-hill.
    let steep = Samples { slope_deg: 20.0, ..samples(|_| 0.0) };
    assert!(run(&rig(), &[], &steep).x[799] < -0.1);
}

#[test]
fn a_higher_break_away_holds_longer_than_it_resists() {
    let f_s = level() * 1.3;
    let fall = effect("stribeck_friction", "law", &[("F_s", f_s), ("v_s", 1e-9), ("delta", 2.0)]);
    let held = run(&rig(), &[fall], &samples(|_| f_s - 1e-6));
    assert_eq!(held.x[799], 0.0);
    let found = run(&rig(), &[fall], &samples(|_| f_s + 1e-6));
    let a = (f_s - level()) / 0.8;
    assert!((found.x[799] / (0.5 * a * 3.995 * 3.995) - 1.0).abs() < 1e-3);
}

#[test]
fn a_drive_read_in_step_with_its_samples_is_a_delay() {
    // Samples lie five periods apart, each read 0.3 of one later.
    let polled = effect("drive_delay", "polled", &[("T", 1e-3), ("p", 0.3)]);
    let late = effect("drive_delay", "law", &[("T", 3e-4)]);
    let (found, same) =
        (run(&rig(), &[polled], &samples(rich)), run(&rig(), &[late], &samples(rich)));
    assert!(worst(&found.x, |i| same.x[i]) < 1e-9);
    let prompt = run(&rig(), &[], &samples(rich));
    assert!(worst(&found.x, |i| prompt.x[i]) > 1e-6);
}

#[test]
fn a_lag_is_an_exponential_and_a_delay_a_shift() {
    let held = samples(|t| if t < 0.1 { 0.0 } else { 2.0 });
    let lag = run(&rig(), &[effect("drive_lag", "law", &[("T", 0.05)])], &held);
    let at = |i: usize| {
        let t = (f64::from(i as u32) * 0.005 - 0.1).max(0.0);
        -2.0 * (-t / 0.05).exp_m1()
    };
    assert!(worst(&lag.force, at) < 1e-6);
    let late = run(&rig(), &[effect("drive_delay", "law", &[("T", 0.0317)])], &samples(step));
    let shifted = |t: f64| step(t - 0.0317);
    let (up, down) = ((4.0 - level()) / 0.8, level() / 0.8);
    let at = |i: usize| {
        let t = f64::from(i as u32) * 0.005 - 0.0317;
        let rise = (t - 0.5).clamp(0.0, 1.0);
        let fall = (t.min(1.5 + up / down) - 1.5).max(0.0);
        0.5 * up * rise * rise + up * fall - 0.5 * down * fall * fall
    };
    assert!(worst(&late.x, at) < 1e-10);
    assert!(worst(&late.force, |i| shifted(f64::from(i as u32) * 0.005)) < 1e-12);
}

#[test]
fn a_spring_swings_at_its_own_frequency_against_a_head_at_rest() {
    let (k, m_d) = (300.0, 0.1);
    let spring = effect("transmission_compliance", "law", &[("k", k), ("d", 0.0), ("m_d", m_d)]);
    // From loaded by 1 N to 1.5 N and back at most 2 N: the head stays.
    let found = run(&rig(), &[spring], &samples(|t| if t < 0.1 { 1.0 } else { 1.5 }));
    let omega = f64::sqrt(k / m_d);
    let at = |i: usize| {
        let t = (f64::from(i as u32) * 0.005 - 0.1).max(0.0);
        1.5 - 0.5 * (omega * t).cos()
    };
    assert_eq!(worst(&found.x, |_| 0.0), 0.0);
    assert!(worst(&found.force, at) < 2e-4);
}

#[test]
fn a_bristle_is_a_spring_before_it_slides() {
    let sigma0 = 5e3;
    let bristle = effect("presliding_compliance", "law", &[("sigma0", sigma0), ("sigma1", 200.0)]);
    let push = 0.05 * level();
    let found = run(&rig(), &[bristle], &samples(|_| push));
    assert!((found.x[799] / (push / sigma0) - 1.0).abs() < 0.06);
}

#[test]
fn the_body_slides_under_the_reaction_to_the_drive() {
    let grip = [("mu_static", 0.15), ("mu_coulomb", 0.1)];
    let found = run(&rig(), &[effect("anchor_slip", "law", &grip)], &samples(step));
    let mass = 3.0 * 0.8;
    let (up, down) = (4.0 / mass - 0.1 * 9.81, 0.1 * 9.81);
    let at = |i: usize| {
        let t = f64::from(i as u32) * 0.005;
        let rise = (t - 0.5).clamp(0.0, 1.0);
        let fall = (t.min(1.5 + up / down) - 1.5).max(0.0);
        -(0.5 * up * rise * rise + up * fall - 0.5 * down * fall * fall)
    };
    assert!(worst(&found.x_rear, at) < 1e-10);
}

#[test]
fn a_pendulum_swings_at_its_own_frequency() {
    let pendulum = Rig { coulomb_force: Some(0.0), gravity_torque: Some(3.0), mass: 0.05, ..rig() };
    let found = simulate(&pendulum, &[], &samples(|_| 0.0), (1e-3, 0.0), STEP, 0);
    let omega = f64::sqrt(3.0 / 0.05);
    assert!(worst(&found.x, |i| 1e-3 * (omega * f64::from(i as u32) * 0.005).cos()) < 1e-7);
}

#[test]
fn sensors_scale_drift_and_read_late() {
    let plain = run(&rig(), &[], &samples(step));
    let scaled = run(&rig(), &[effect("sensor_scale", "law", &[("e", 0.1)])], &samples(step));
    assert!(worst(&scaled.x, |i| 1.1 * plain.x[i]) < 1e-12);
    let drifts = run(&rig(), &[effect("sensor_drift", "law", &[("b", 0.01)])], &samples(step));
    assert!(worst(&drifts.x, |i| plain.x[i] + 0.01 * f64::from(i as u32) * 0.005) < 1e-12);
    let late = run(&rig(), &[effect("sensor_delay", "law", &[("T", 0.05)])], &samples(step));
    assert!(worst(&late.x[10..], |i| plain.x[i]) < 1e-9);
}

/// A value for every parameter, plain enough to show.
fn strong(name: &str) -> f64 {
    match name {
        "c" | "c2" | "k_e" | "k_b" => 2.0,
        "F_s" => level() * 1.3,
        "F_c_forward" => level() * 1.2,
        "F_c_backward" => level() * 0.8,
        "delta" | "n" => 1.5,
        "sigma0" => 2e4,
        "sigma1" => 60.0,
        "k" => 500.0,
        "d" | "F0" | "F_max" => 3.0,
        "v0" | "v_s" => 0.05,
        "T" | "T_rise" | "t0" => 0.3,
        "T_fall" | "d_open" => 0.4,
        "d_alpha_deg" | "A_deg" | "f" => 2.0,
        "b" => 1e-3,
        "x0" => 0.02,
        _ => 0.1,
    }
}

/// Discontinuous contacts converge with the step, not with its square.
fn allowed(name: &str) -> f64 {
    if name == "transmission_backlash" { 1e-4 } else { 2e-6 }
}

#[test]
fn every_law_agrees_with_itself_at_half_the_step() {
    let samples = first_samples(300, rich);
    let plain = run(&rig(), &[], &samples);
    for form in FORMS {
        let mut values: Vec<_> = form.params.iter().map(|p| (*p, strong(p))).collect();
        if form.name == "transmission_compliance" || form.name == "transmission_backlash" {
            values.iter_mut().filter(|(p, _)| *p == "d").for_each(|(_, v)| *v = 5.0);
        }
        let one = [effect(form.name, form.form, &values)];
        let [coarse, fine] =
            [STEP, 0.5 * STEP].map(|h| simulate(&rig(), &one, &samples, (0.0, 0.0), h, 7));
        let off = worst(&coarse.x, |i| fine.x[i]);
        assert!(off < allowed(form.name), "{} ({}): {off:.1e} m", form.name, form.form);
        let seen = worst(&coarse.x, |i| plain.x[i]).max(worst(&coarse.x_rear, |i| plain.x_rear[i]));
        assert!(seen > 1e-5, "{} ({}) changes nothing", form.name, form.form);
    }
}

#[test]
fn every_law_vanishes_at_its_off_value() {
    let off = |name: &str, form: &str, param: &str| match param {
        "F_s" | "F_c_forward" | "F_c_backward" => level(),
        "F_max" => 1e9,
        "sigma0" => 1e7,
        "sigma1" => 0.0,
        "mu_static" => 1e9,
        "x0" if name == "wall" || name == "tether" => 1e9,
        "k" if matches!(name, "tether" | "cable_reel") => 0.0,
        "T_rise" | "T_fall" => 1e-5,
        "T" if name == "drive_lag" || form == "filter" => 1e-5,
        "T" if matches!(name, "drive_delay" | "sensor_delay") => 0.0,
        "d" if name == "drive_deadzone" => 1e-12,
        "w" if name == "reading_freezes" => 0.0,
        "c" | "c2" | "k_e" | "k_b" | "mu_l" | "d_open" | "d_close" | "e" | "e_forward"
        | "e_backward" | "d_alpha_deg" | "A_deg" | "dm" | "d_mu" | "d_force" | "A" | "r" | "J" => {
            0.0
        }
        "a" => 0.0,
        "b" => 0.0,
        other => strong(other),
    };
    let samples = first_samples(300, rich);
    let plain = run(&rig(), &[], &samples);
    for form in FORMS {
        // A drive side keeps its mass and a swing needs one: they have no off value.
        let stays = form.name.starts_with("transmission_") || form.form == "swinging";
        if stays {
            continue;
        }
        let values: Vec<_> =
            form.params.iter().map(|p| (*p, off(form.name, form.form, p))).collect();
        // What is stiff or fast where it is off is only near to nothing.
        let bar = match form.name {
            // What a stiff bristle stores while it is bent turns into speed, as a root.
            "presliding_compliance" => 2e-3,
            "drive_lag" | "sensor_delay" => 1e-5,
            _ => 1e-12,
        };
        let found = run(&rig(), &[effect(form.name, form.form, &values)], &samples);
        let left = worst(&found.x, |i| plain.x[i]).max(worst(&found.x_rear, |i| plain.x_rear[i]));
        assert!(left <= bar, "{} ({}): {left:.1e} m left", form.name, form.form);
    }
}

#[test]
fn unknown_effects_forms_and_parameters_are_refused() {
    let none = BTreeMap::new();
    assert!(Effect::new("gravity_wave", "law", &none).unwrap_err().contains("no effect"));
    assert!(Effect::new("drive_lag", "odd", &none).unwrap_err().contains("second_order"));
    assert!(Effect::new("drive_lag", "law", &none).unwrap_err().contains("needs T"));
    let odd = BTreeMap::from([("tau".to_owned(), 1.0)]);
    assert!(Effect::new("drive_lag", "law", &odd).unwrap_err().contains("tau"));
}

#[test]
fn threads_do_not_change_a_bit() {
    use reality::{Job, run_all};
    use std::sync::atomic::{AtomicBool, AtomicU64};
    let runs = [samples(rich), samples(step)];
    let push = effect("coloured_push", "outside", &[("A", 1.0), ("T", 0.1)]);
    let job = |i: usize| Job {
        run: i % 2,
        rig: rig(),
        effects: vec![push],
        start: (0.0, 0.0),
        step: 1e-4,
        seed: i as u64,
    };
    let jobs: Vec<Job> = (0..6).map(job).collect();
    let of = |threads| {
        let done = AtomicU64::new(0);
        let found = run_all(&runs, &jobs, threads, &AtomicBool::new(false), &done);
        assert_eq!(done.into_inner(), 6);
        found
    };
    assert_eq!(of(1), of(3));
    assert_ne!(of(1)[0], of(1)[2]);
    let none = run_all(&runs, &jobs, 2, &AtomicBool::new(true), &AtomicU64::new(0));
    assert!(none.iter().all(Option::is_none));
}
