//! Reductions against a slow reference.

use super::*;

fn reference(axis: &[f64], values: &[f64], reduce: Reduce) -> f64 {
    let works: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    if works.is_empty() && reduce != Reduce::Count {
        return f64::NAN;
    }
    let most = works.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = works.iter().copied().fold(f64::INFINITY, f64::min);
    let first = |wins: &dyn Fn(f64) -> bool| axis[values.iter().position(|v| wins(*v)).unwrap()];
    match reduce {
        Reduce::Max => most,
        Reduce::Min => least,
        Reduce::Argmax => first(&|v| v >= most - TIE * most.abs()),
        Reduce::Argmin => first(&|v| v <= least + TIE * least.abs()),
        Reduce::Mean => works.iter().fold(0.0, |sum, v| sum + v) / works.len() as f64,
        Reduce::Count => works.len() as f64,
        Reduce::LastFeasible => axis[values.iter().rposition(|v| !v.is_nan()).unwrap()],
        Reduce::Quantile(q) => {
            let mut sorted = works;
            sorted.sort_by(f64::total_cmp);
            let position = (sorted.len() - 1) as f64 * q;
            let (i, share) = (position.floor() as usize, position.fract());
            let next = sorted[(i + 1).min(sorted.len() - 1)];
            sorted[i] + (next - sorted[i]) * share
        }
    }
}

fn against_reference(axes: &Axes, fixed: &Fixed, over: &str, quantity: &str) {
    let position = axes.iter().position(|(name, _)| *name == over).unwrap();
    let axis = &axes[position].1;
    let entry = Entry::parse(quantity).unwrap();
    let dense = values(&job(axes, fixed, vec![Request { entry, reduce: None }]), options(2, 4096));
    let inner: usize = axes[position + 1..].iter().map(|(_, v)| v.len()).product();
    let cells = dense.len() / axis.len();
    for (job, reduce) in reduced(axes, fixed, over, quantity).iter().zip(REDUCTIONS) {
        let (got, codes) = results(job, options(2, 777));
        assert_eq!(job.cells(), cells);
        for cell in 0..cells {
            let (outer, rest) = (cell / inner, cell % inner);
            let along: Vec<f64> =
                (0..axis.len()).map(|i| dense[(outer * axis.len() + i) * inner + rest]).collect();
            let expected = reference(axis, &along, reduce);
            let value = got[0][cell];
            let what = format!("{reduce:?} of {quantity} over {over}, cell {cell}: {along:?}");
            let exact = !matches!(reduce, Reduce::Quantile(_));
            // Between two neighbours the terms may be larger than the result.
            let size = along.iter().fold(0.0, |size: f64, v| size.max(v.abs()));
            let close = (value - expected).abs() <= 2.0 * f64::EPSILON * size;
            assert!(
                value.to_bits() == expected.to_bits()
                    || value.is_nan() && expected.is_nan()
                    || !exact && close,
                "{value:e} for {expected:e}: {what}"
            );
            let code = if expected.is_nan() { Status::NoneFeasible } else { Status::Ok };
            assert_eq!(codes[0][cell], code as u8, "{what}");
        }
    }
}

#[test]
fn reductions_of_plain_grids() {
    let axes: Axes = vec![
        ("mu_static", steps(0.05, 1.3, 26)),
        ("slope_deg", steps(0.0, 36.0, 10)),
        ("segments", whole(2, 15)),
        // 0.2 mu_S and others tie neighbouring counts.
        ("mu_coulomb", steps(0.01, 0.26, 26)),
    ];
    for quantity in ["mean_velocity", "cost_of_transport", "cycle_time", "net_force", "feasible"] {
        for over in ["segments", "slope_deg", "mu_coulomb"] {
            against_reference(&axes, &vec![], over, quantity);
        }
    }
}

#[test]
fn reductions_with_other_axes_and_orders() {
    let mut axes: Axes = vec![
        ("segments", whole(2, 15)),
        ("stroke", vec![0.01, 0.05]),
        ("mu_static", steps(0.05, 1.3, 26)),
        ("mu_coulomb", steps(0.01, 0.26, 26)),
    ];
    for _ in 0..4 {
        against_reference(&axes, &vec![], "segments", "mean_velocity");
        axes.rotate_left(1);
    }
    against_reference(&axes, &vec![("moving", 1.0)], "stroke", "phase_time");
}

#[test]
fn reductions_of_general_grids() {
    let (mut axes, fixed) = general();
    axes[6].1 = whole(1, 9);
    for quantity in ["mean_velocity", "best_segments", "slip_ratio", "net_advance", "net_force"] {
        for over in ["segments", "viscous", "slope_deg"] {
            against_reference(&axes, &fixed, over, quantity);
        }
    }
}

#[test]
fn best_count_is_the_argmax_over_counts() {
    let (mut axes, fixed) = general();
    axes[6].1 = whole(1, 60);
    let fixed: Fixed = fixed
        .into_iter()
        .map(|(name, v)| (name, if name == "segments_max" { 60.0 } else { v }))
        .collect();
    let argmax = &reduced(&axes, &fixed, "segments", "mean_velocity")[2];
    axes.pop();
    let best = vec![Request { entry: Entry::parse("best_segments").unwrap(), reduce: None }];
    same(
        &values(argmax, options(2, 4096)),
        &values(&job(&axes, &fixed, best), options(2, 4096)),
        "argmax and best_segments",
    );
}
