//! SIMD levels agree in every bit.

use super::*;

/// Grids of random axes: about 45 000 points each, half of them plain.
fn random_grids(count: usize) -> Vec<(Axes, Fixed)> {
    let mut random = Random(3);
    (0..count)
        .map(|i| {
            let mut axis = |low: f64, high: f64, count: usize| {
                (0..count).map(|_| random.between(low, high)).collect::<Vec<f64>>()
            };
            let mut axes = vec![
                ("mu_static", axis(0.1, 1.5, 12)),
                ("mu_coulomb", axis(0.01, 0.6, 8)),
                ("slope_deg", axis(if i % 2 == 0 { 0.0 } else { -15.0 }, 30.0, 8)),
            ];
            let mut fixed = vec![
                ("mass", axis(0.1, 3.0, 1)[0]),
                ("gravity", axis(3.0, 12.0, 1)[0]),
                ("anchor_weight", axis(0.0, 1.0, 1)[0]),
                ("wall_force", axis(0.0, 4.0, 1)[0]),
                ("wall_release", axis(0.0, 1.0, 1)[0]),
                ("corner_deg", axis(0.0, 50.0, 1)[0]),
                ("skin_ratio", axis(0.8, 2.0, 1)[0]),
                ("time", axis(0.01, 3.0, 1)[0]),
                ("speed", axis(-1.0, 1.0, 1)[0]),
                ("segments_max", 400.0),
            ];
            if i % 2 == 0 {
                axes.push(("stroke", axis(0.005, 0.1, 4)));
                axes.push(("segments", whole(3, 17)));
                fixed.push(("moving", 2.0));
            } else {
                axes.push(("viscous", [vec![0.0], axis(0.01, 30.0, 2)].concat()));
                axes.push(("drive_limit", [vec![f64::INFINITY], axis(0.5, 9.0, 1)].concat()));
                axes.push(("speed_limit", [vec![f64::INFINITY], axis(0.01, 0.4, 1)].concat()));
                axes.push(("segments", vec![2.0, 3.0, 4.0, 7.0, 12.0]));
                fixed.push(("brake", f64::from(i as u32 / 2 % 2)));
                fixed.push(("coulomb_term", f64::from(i as u32 / 4 % 2)));
                fixed.push(("anchors_ahead", f64::from(i as u32 / 8 % 2)));
            }
            (axes, fixed)
        })
        .collect()
}

#[test]
fn levels_give_the_same_bits() {
    let levels = Level::available();
    let mut points = 0;
    for (axes, fixed) in random_grids(4) {
        let job = job(&axes, &fixed, all());
        points += job.cells() * closed().len();
        let at = |level| results(&job, Options { level, ..options(2, DEFAULT_CHUNK) });
        let (expected, codes) = at(levels[0]);
        for level in &levels[1..] {
            let (got, got_codes) = at(*level);
            for (n, entry) in closed().into_iter().enumerate() {
                same(&got[n], &expected[n], &format!("{} on {level:?}", entry.info.name));
                assert_eq!(got_codes[n], codes[n]);
            }
        }
    }
    println!("{points} values at {levels:?}");
    assert!(points >= 1_000_000);
}

#[test]
fn levels_reduce_to_the_same_bits() {
    let levels = Level::available();
    for (axes, fixed) in random_grids(2) {
        for job in reduced(&axes, &fixed, "segments", "mean_velocity") {
            let at = |level| values(&job, Options { level, ..options(2, DEFAULT_CHUNK) });
            for level in &levels {
                same(&at(*level), &at(levels[0]), &format!("{level:?}"));
            }
        }
    }
}

type Scalar = (&'static str, bool, fn(&Point<f64>) -> f64);

macro_rules! scalars {
    ($($quantity:ident),+ $(,)?) => {
        vec![$((
            <$quantity as Quantity>::INFO.name,
            <$quantity as Quantity>::INFO.integer,
            $quantity::value::<f64, false> as fn(&Point<f64>) -> f64,
        )),+]
    };
}

fn scalars() -> Vec<Scalar> {
    locosweep::for_each_quantity!(scalars)
}

#[test]
fn engine_and_scalar_formula_give_the_same_bits() {
    for (axes, fixed) in random_grids(2) {
        let job = job(&axes, &fixed, all());
        let (got, _) = results(&job, options(2, DEFAULT_CHUNK));
        for cell in (0..job.cells()).step_by(13) {
            let point = Point::of(&given(&axes, &fixed, cell));
            for (n, (name, _, value)) in scalars().into_iter().enumerate() {
                same(&got[n][cell..=cell], &[value(&point)], name);
            }
        }
    }
}

fn given(axes: &Axes, fixed: &Fixed, cell: usize) -> Vec<(ParamId, f64)> {
    let mut rest = cell;
    let mut all: Vec<_> =
        fixed.iter().map(|(name, v)| (ParamId::parse(name).unwrap(), *v)).collect();
    for (name, values) in axes.iter().rev() {
        all.push((ParamId::parse(name).unwrap(), values[rest % values.len()]));
        rest /= values.len();
    }
    all
}
