//! Each effect in its limit is the nominal model; of visible size it and each of
//! its parameters are seen.

use super::*;

#[test]
fn every_effect_vanishes_in_its_limit() {
    let run = run(1000, 2e-3);
    let nominal = column(Active::default(), [0.0; EFFECT_PARAMS], 1000);
    let base = &all(&[nominal], &run, Level::current().unwrap())[0];
    let span = base.x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    assert!(span > 0.01);
    for effect in Effect::ALL {
        let column = column(Active::default().with(*effect), off(*effect), 1000);
        let found = &all(&[column], &run, Level::current().unwrap())[0];
        let miss = largest(&found.x, &base.x) / span;
        let rear = largest(&found.x_rear, &base.x_rear);
        let name = effect.info().name;
        println!("{name}: {miss:.2e}");
        // Stiff limits are as near as a stiff number is; the rest is rounding.
        let stiff = matches!(
            effect,
            Effect::PreslidingCompliance
                | Effect::TransmissionBacklash
                | Effect::TransmissionCompliance
        );
        assert!(miss < if stiff { 2e-3 } else { 1e-9 }, "{name}: {miss:e}");
        assert_eq!(rear, 0.0, "{name}");
    }
}

#[test]
fn every_effect_and_each_of_its_parameters_is_seen() {
    let run = run(1000, 2e-3);
    let level = Level::current().unwrap();
    let base = &all(&[column(Active::default(), [0.0; EFFECT_PARAMS], 1000)], &run, level)[0];
    for effect in Effect::ALL {
        let active = Active::default().with(*effect);
        let info = &EFFECTS[*effect as usize];
        let mut columns = vec![column(active, on(*effect), 1000)];
        for k in 0..info.params.len() {
            let mut values = on(*effect);
            values[effect.first() + k] *= 1.1;
            columns.push(column(active, values, 1000));
        }
        let found = all(&columns, &run, level);
        let seen =
            |a: &Readings, b: &Readings| largest(&a.x, &b.x).max(largest(&a.x_rear, &b.x_rear));
        println!("{}: {:.2e} m", info.name, seen(&found[0], base));
        assert!(seen(&found[0], base) > 1e-5, "{}", info.name);
        for (k, param) in info.params.iter().enumerate() {
            if param.param.name == "d_force" {
                continue; // acts where the model gives coulomb_force
            }
            let moved = seen(&found[k + 1], &found[0]);
            assert!(moved > 1e-9, "{} {}: {moved:e}", info.name, param.param.name);
        }
    }
}
