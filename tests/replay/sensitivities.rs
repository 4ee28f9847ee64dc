//! Forward sensitivities against differences of the replay, and what they leave alone.

use super::*;
use locosweep::sweep::replay::{DIRECTIONS, replay_with_sensitivities};

const SHARES: usize = EFFECT_PARAMS;
const START: usize = SHARES + 4;

fn level() -> Level {
    *Level::available().last().unwrap()
}

/// Where a direction stands in a column.
fn value(column: &mut Column, direction: usize) -> &mut f64 {
    match direction {
        d if d < SHARES => &mut column.values[d],
        d if d < START => &mut column.shares[d - SHARES],
        START => &mut column.start.0,
        _ => &mut column.start.1,
    }
}

/// A clock offset that keeps the edges of the drive off the samples, where there is no
/// derivative.
fn column(effects: &[Effect], count: usize) -> Column {
    let mut values = [0.0; EFFECT_PARAMS];
    let mut active = Active::default();
    for effect in effects {
        active = active.with(*effect);
        let own = on(*effect);
        let last = effect.first() + effect.info().params.len();
        values[effect.first()..last].copy_from_slice(&own[effect.first()..last]);
    }
    let shares = [1.0, 1.0, 1.0, 3.7e-4];
    let window = (0, count);
    Column { run: 0, window, active, values, shares, start: (0.01, 0.02), sliding_distance: 0.03 }
}

fn derived(runs: &[Run], column: &Column, directions: &[usize], level: Level) -> [Readings; 2] {
    let count = column.window.1 - column.window.0;
    let of = |count: usize| {
        let new = || vec![0.0; count];
        Readings { x: new(), v: new(), x_rear: new(), force: new() }
    };
    let (mut a, mut b) = (of(count), of(count * directions.len()));
    let to = [&mut a.x[..], &mut a.v, &mut a.x_rear, &mut a.force];
    let slopes = [&mut b.x[..], &mut b.v, &mut b.x_rear, &mut b.force];
    let columns = [(column.clone(), directions.to_vec())];
    let control = Control::default();
    replay_with_sensitivities(&NOMINAL, runs, &columns, (level, 1), &control, (to, slopes))
        .unwrap();
    [a, b]
}

/// Largest and worst value of a derivative of x that differences of some width confirm: one
/// that is too wide leaves their bend, too narrow a one the steps of the replay itself.
fn worst(runs: &[Run], column: &Column, direction: usize, slope: &[f64]) -> (f64, f64) {
    let at = *value(&mut column.clone(), direction);
    let mut best = (0.0, f64::INFINITY);
    for width in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
        let h = width * at.abs().max(1e-2);
        let moved = |by: f64| {
            let mut column = column.clone();
            *value(&mut column, direction) += by;
            replay(&NOMINAL, runs, &[column], (level(), 1), &Control::default()).unwrap().x
        };
        let (up, down) = (moved(h), moved(-h));
        let (mut size, mut error) = (0.0_f64, 0.0_f64);
        for ((up, down), slope) in up.iter().zip(&down).zip(slope) {
            let difference = (up - down) / (2.0 * h);
            assert!(slope.is_finite());
            size = size.max(difference.abs());
            error = error.max((difference - slope).abs());
        }
        if error < best.1 {
            best = (size, error);
        }
    }
    best
}

/// All directions that act on a column.
fn directions(effects: &[Effect]) -> Vec<usize> {
    let own = |e: &Effect| e.first()..e.first() + e.info().params.len();
    effects.iter().flat_map(own).chain(SHARES..DIRECTIONS).collect()
}

#[track_caller]
fn confirmed(effects: &[Effect], runs: &[Run], tolerance: f64) {
    let column = column(effects, runs[0].times.len());
    let count = runs[0].times.len();
    let directions = directions(effects);
    let [_, slopes] = derived(runs, &column, &directions, level());
    for (d, direction) in directions.iter().enumerate() {
        let (size, error) = worst(runs, &column, *direction, &slopes.x[d * count..(d + 1) * count]);
        let names: Vec<&str> = effects.iter().map(|e| e.info().name).collect();
        // What hardly moves the head at all is compared with a nanometre per unit.
        println!(
            "{names:?} {direction}: {error:.1e} of {size:.1e}, {:.1e}",
            error / size.max(1e-30)
        );
        assert!(
            error <= tolerance * size + 1e-9,
            "{names:?} by direction {direction}: {error:e} of {size:e}"
        );
    }
}

#[test]
fn derivatives_of_every_effect_are_those_of_differences() {
    let runs = [run(1000, 1e-3)];
    for info in EFFECTS {
        let effect = Effect::parse(info.name).unwrap();
        // The stiff method chooses its steps by their error, which differences show too.
        let rough = effect == Effect::PreslidingCompliance;
        confirmed(&[effect], &runs, if rough { 2e-3 } else { 2e-5 });
    }
}

#[test]
fn derivatives_behind_links_are_those_of_differences() {
    let runs = [run(1000, 1e-3)];
    for pair in bits::REFINED {
        confirmed(&pair, &runs, 5e-5);
    }
}

#[test]
fn values_are_those_of_the_replay_at_every_level() {
    let runs = [run(700, 2e-3)];
    let singles = EFFECTS.iter().map(|info| vec![Effect::parse(info.name).unwrap()]);
    for effects in singles.chain(bits::REFINED.map(|pair| pair.to_vec())) {
        let column = column(&effects, 700);
        for level in Level::available() {
            let [read, _] = derived(&runs, &column, &directions(&effects), level);
            let columns = [column.clone()];
            let plain = replay(&NOMINAL, &runs, &columns, (level, 1), &Control::default()).unwrap();
            for (a, b) in [(&read.x, &plain.x), (&read.v, &plain.v), (&read.force, &plain.force)] {
                let same = a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
                let names: Vec<&str> = effects.iter().map(|e| e.info().name).collect();
                assert!(same, "{names:?} at {}", level.name());
            }
        }
    }
}

#[test]
fn levels_and_company_do_not_change_a_derivative() {
    let runs = [run(300, 2e-3)];
    let effects = [Effect::ViscousFriction, Effect::DriveDelay];
    let (column, all) = (column(&effects, 300), directions(&effects));
    let [_, together] = derived(&runs, &column, &all, level());
    for (d, direction) in all.iter().enumerate() {
        for level in Level::available() {
            let [_, alone] = derived(&runs, &column, &[*direction], level);
            let [read, _] = derived(&runs, &column, &[], level);
            let plain = replay(
                &NOMINAL,
                &runs,
                std::slice::from_ref(&column),
                (level, 1),
                &Control::default(),
            );
            assert_eq!(read.x, plain.unwrap().x, "no direction");
            assert_eq!(alone.x, together.x[d * 300..(d + 1) * 300], "direction {direction}");
        }
    }
}

/// A mass that stops under Coulomb friction: every derivative has a closed form.
#[test]
fn a_stop_passes_on_the_closed_forms_derivative() {
    let times: Vec<f64> = (0..200).map(|i| f64::from(i) * 1e-2).collect();
    let run = Run { drive: vec![0.0; 200], times, slope_deg: 0.0 };
    let mut column = column(&[], 200);
    column.shares[3] = 0.0;
    column.start = (0.0, 0.5);
    let nominal = Nominal { viscous: 0.0, slope_deg: 0.0, limit: f64::INFINITY, ..NOMINAL };
    let directions = [SHARES, SHARES + 1, START, START + 1];
    let mut slopes = [vec![0.0; 800], vec![0.0; 800], vec![0.0; 800], vec![0.0; 800]];
    let mut read = slopes.clone().map(|all| all[..200].to_vec());
    let columns = [(column, directions.to_vec())];
    let (to, by) = (read.each_mut().map(|r| &mut r[..]), slopes.each_mut().map(|s| &mut s[..]));
    let control = Control::default();
    replay_with_sensitivities(&nominal, &[run], &columns, (level(), 1), &control, (to, by))
        .unwrap();
    // Stopping distance v^2/(2 mu g), whatever the mass.
    let (v, pull) = (0.5, NOMINAL.mu_coulomb * NOMINAL.gravity);
    let far = v * v / (2.0 * pull);
    assert!((read[0][199] - far).abs() < 1e-15);
    for (d, expected) in [0.0, -far, 1.0, v / pull].into_iter().enumerate() {
        let found = slopes[0][d * 200 + 199];
        assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        // At rest nothing moves the speed.
        assert_eq!(slopes[1][d * 200 + 199], 0.0);
    }
}
