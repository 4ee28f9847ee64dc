//! The same bits whoever is replayed beside whom.

use super::*;

#[test]
fn lanes_do_not_look_at_their_neighbours() {
    let run = run(400, 2e-3);
    for level in Level::available() {
        for effect in Effect::ALL {
            let active = Active::default().with(*effect);
            let make = |i: usize| {
                let mut values = on(*effect);
                for value in &mut values {
                    *value *= 1.0 + 0.02 * i as f64;
                }
                column(active, values, 400)
            };
            let many: Vec<Column> = (0..19).map(make).collect();
            let together = all(&many, &run, level);
            for (i, column) in many.iter().enumerate().step_by(6) {
                let alone = &all(std::slice::from_ref(column), &run, level)[0];
                let same = *alone == together[i];
                assert!(same, "{} {i} {}", effect.info().name, level.name());
            }
        }
    }
}

/// What steps that know their error are taken for.
pub(super) const REFINED: [[Effect; 2]; 4] = [
    [Effect::DriveLag, Effect::PositionDependentFriction],
    [Effect::TransmissionCompliance, Effect::PositionDependentFriction],
    [Effect::TransmissionBacklash, Effect::StribeckFriction],
    [Effect::TransmissionCompliance, Effect::LoadDependentFriction],
];

#[test]
fn steps_that_know_their_error_do_not_look_at_their_neighbours() {
    let run = run(400, 2e-3);
    for level in Level::available() {
        for pair in REFINED {
            let make = |i: usize| {
                let (mut active, mut values) = (Active::default(), [0.0; EFFECT_PARAMS]);
                for effect in pair {
                    active = active.with(effect);
                    let own = effect.first()..effect.first() + effect.info().params.len();
                    values[own.clone()].copy_from_slice(&on(effect)[own]);
                }
                // From hardly any friction along the way to much, and from slow to fast.
                for value in &mut values {
                    *value *= 0.5 + 0.05 * i as f64;
                }
                column(active, values, 400)
            };
            let many: Vec<Column> = (0..19).map(make).collect();
            let together = all(&many, &run, level);
            for (i, column) in many.iter().enumerate() {
                let alone = &all(std::slice::from_ref(column), &run, level)[0];
                let names = pair.map(|effect| effect.info().name);
                assert!(*alone == together[i], "{names:?} {i} {}", level.name());
                let first = &all(std::slice::from_ref(column), &run, Level::available()[1])[0];
                assert!(alone == first, "{names:?} {i} {}", level.name());
            }
        }
    }
}

/// Neighbours choose steps of other kinds: a lag of 0.1 ms leaves no series to any length, one of
/// 50 ms no map. Samples are even, and not.
#[test]
fn lags_of_any_length_do_not_look_at_their_neighbours() {
    let even = run(400, 2e-3);
    let mut uneven = even.clone();
    for (i, time) in uneven.times.iter_mut().enumerate() {
        *time += 5e-4 * libm::sin(i as f64);
    }
    let bent = [None, Some(Effect::StribeckFriction), Some(Effect::QuadraticDrag)];
    for (run, level) in [&even, &uneven]
        .into_iter()
        .flat_map(|run| Level::available().into_iter().map(move |level| (run, level)))
    {
        for bent in bent {
            let make = |i: usize| {
                let mut values = bent.map_or([0.0; EFFECT_PARAMS], on);
                values[Effect::DriveLag.first()] = 1e-4 * libm::pow(500.0, i as f64 / 18.0);
                let active = bent.into_iter().fold(Active::default(), |all, one| all.with(one));
                column(active.with(Effect::DriveLag), values, 400)
            };
            let many: Vec<Column> = (0..19).map(make).collect();
            let together = all(&many, run, level);
            for (i, column) in many.iter().enumerate() {
                let alone = &all(std::slice::from_ref(column), run, level)[0];
                assert!(*alone == together[i], "{bent:?} {i} {}", level.name());
            }
        }
    }
}

/// A column per effect and size, of two runs, in windows of several lengths.
fn mixed() -> Vec<Column> {
    let mut columns = Vec::new();
    for (i, effect) in Effect::ALL.iter().enumerate() {
        for k in 0..7 {
            let mut values = on(*effect);
            values.iter_mut().for_each(|value| *value *= 1.0 + 0.03 * f64::from(k));
            let mut column = column(Active::default().with(*effect), values, 300);
            column.run = (i + k as usize) % 2;
            column.window = [(0, 300), (40, 300), (40, 200)][k as usize % 3];
            column.start = (1e-3 * f64::from(k), 0.01);
            columns.push(column);
        }
    }
    columns
}

#[test]
fn threads_and_the_order_of_columns_do_not_change_bits() {
    let runs = [run(300, 2e-3), Run { slope_deg: -2.0, ..run(300, 1e-3) }];
    let columns = mixed();
    let level = Level::current().unwrap();
    let all = |columns: &[Column], threads: usize| {
        let found = replay(&NOMINAL, &runs, columns, (level, threads), &Control::default());
        apart(columns, found.unwrap())
    };
    let expected = all(&columns, 1);
    for threads in [2, 3] {
        assert!(all(&columns, threads) == expected, "{threads} threads");
    }
    // A stride that is coprime with the number of columns visits each.
    let order: Vec<usize> = (0..columns.len()).map(|i| i * 59 % columns.len()).collect();
    let shuffled: Vec<Column> = order.iter().map(|i| columns[*i].clone()).collect();
    for (i, found) in order.iter().zip(all(&shuffled, 2)) {
        assert!(found == expected[*i], "column {i}");
    }
    for readings in &expected {
        assert!(readings.x.iter().chain(&readings.v).all(|value| value.is_finite()));
    }
}

#[test]
fn levels_agree() {
    let runs = [run(300, 2e-3), run(300, 1e-3)];
    let levels = Level::available();
    let at = |level| replay(&NOMINAL, &runs, &mixed(), (level, 2), &Control::default()).unwrap();
    for level in &levels[1..] {
        assert!(at(*level) == at(levels[0]), "{level:?}");
    }
}

#[test]
fn a_cancelled_replay_stops() {
    let control = Control::default();
    control.cancel.store(true, std::sync::atomic::Ordering::Relaxed);
    let columns = [column(Active::default(), [0.0; EFFECT_PARAMS], 300)];
    let level = Level::current().unwrap();
    let found = replay(&NOMINAL, &[run(300, 2e-3)], &columns, (level, 1), &control);
    assert_eq!(found, Err(locosweep::Error::Cancelled { done: 0, total: 1 }));
}
