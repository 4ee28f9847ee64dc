//! Friction makes heat, and the ledger closes as well as each method promises.

use super::*;

/// What a ledger may leave open at the usual step and tolerance.
fn allowed(method: &str) -> f64 {
    match method {
        "exact" => 1e-12,
        "runge_kutta" => 2e-3,
        "dormand_prince" => 1e-4,
        "dormand_prince_fixed" => 2e-3,
        "rosenbrock" => 1e-6,
        _ => 1e-4,
    }
}

#[test]
fn every_law_turns_work_into_heat() {
    let mut report = String::new();
    let mut worst = std::collections::BTreeMap::new();
    for case in everything() {
        // One pass of the ledger over all kinds of motion: pushed, sliding freely, pulled.
        let case = case.over("start_speed", vec![-0.3, 0.0, 0.05, 0.4]);
        let mut case = case.over("slope_deg", vec![-6.0, 2.0]);
        let method = case.choice.method.clone().unwrap();
        if method == "rosenbrock_fixed" {
            // Bristles that are dragged along from rest bend within microseconds.
            case = case.with(&[("time_step", 2e-4)]);
        }
        let (values, codes) =
            results(&case.job(&["dissipated", "energy_residual", "work_in"]), options(1, 64));
        for i in 0..values[0].len() {
            let [heat, open, work] = [0, 1, 2].map(|k| values[k][i]);
            if codes[0][i] != 0 {
                report += &format!("\n{}: status {}", case.name(), codes[0][i]);
                continue;
            }
            let worst: &mut f64 = worst.entry(method.clone()).or_default();
            *worst = worst.max(open.abs());
            // A ledger of some steps is open by that much of the work done.
            let slack = allowed(&method) * (heat.abs() + work.abs());
            if heat < -slack || open.abs() > allowed(&method) {
                report += &format!("\n{} cell {i}: heat {heat:e}, open {open:e}", case.name());
            }
        }
    }
    println!("{worst:?}");
    assert!(report.is_empty(), "{report}");
}

/// Finer steps close the ledger further.
#[test]
fn the_ledger_closes_with_finer_steps() {
    for law in LAWS {
        let case = Case::usual(law.info.name, DriveKind::Sine);
        let open = |given: &[(&'static str, f64)], method: &str| {
            case.clone().with(given).by(method).one("energy_residual").abs()
        };
        let (coarse, fine, limit) = match law.kind {
            Kind::Dry | Kind::Smooth => (
                open(&[("time_step", 1e-3)], "runge_kutta"),
                open(&[("time_step", 3e-5)], "runge_kutta"),
                1e-5,
            ),
            Kind::Bristle => (
                open(&[("tolerance", 1e-4)], "rosenbrock"),
                open(&[("tolerance", 1e-9)], "rosenbrock"),
                1e-6,
            ),
        };
        let name = law.info.name;
        assert!(fine < limit && fine <= coarse + 1e-12, "{name}: {coarse:e} then {fine:e}");
    }
}

/// A free segment on the flat loses what it had, and nothing else.
#[test]
fn a_free_segment_loses_its_own_energy() {
    for law in LAWS {
        let flat = [
            ("slope_deg", 0.0),
            ("drive_force", 0.0),
            ("start_speed", 0.3),
            ("duration", 6.0),
            ("tolerance", 1e-8),
            ("time_step", 1e-4),
        ];
        let case = Case::usual(law.info.name, DriveKind::Constant).with(&flat);
        let found = case.get(&["dissipated", "stored", "work_in", "final_speed"]);
        let name = law.info.name;
        assert_eq!(found[2], 0.0, "{name}");
        near(found[0], -found[1], 1e-5);
        let had = 0.5 * 0.271 * 0.09;
        assert!(found[0] <= had * (1.0 + 1e-6), "{name}: {} of {had}", found[0]);
        assert!(found[3].abs() < 1e-3, "{name} still moves at {}", found[3]);
    }
}
