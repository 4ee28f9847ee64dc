//! Fits of models to measured runs: the values come back, with the same bits on any number
//! of threads and at any level, and a job that is cancelled ends.

use locosweep::Error;
use locosweep::Result;
use locosweep::lane::Level;
use locosweep::physics::effects::{Active, EFFECT_PARAMS, Effect, Nominal};
use locosweep::sweep::Control;
use locosweep::sweep::fit::{
    Asked, Begin, Compared, Coordinate, DVector, Experiment, FINE, Fit, How, Misfit, Objective,
    OverSpans, Point, Replayed, Rule, Shift, Signal, Source, Span, What, evaluate, fit, jacobian,
    readings, residuals,
};
use locosweep::sweep::replay::Run;
use std::sync::Arc;
use std::sync::atomic::Ordering;

const NOMINAL: Nominal = Nominal {
    segments: 1.0,
    mass: 0.25,
    gravity: 9.81,
    mu_coulomb: 0.2,
    coulomb_force: None,
    viscous: 0.05,
    slope_deg: 0.0,
    gain: 1.0,
    limit: f64::INFINITY,
    rotary: false,
    gravity_torque: 0.0,
};
const SAMPLES: usize = 301;
const RUNS: usize = 3;
const DEVIATION: f64 = 2e-5;
const DAMPING: f64 = 0.08;
const GAIN: f64 = -0.03;
/// Start speed of the last run, which a model that begins at rest lacks.
const SPEED: f64 = 0.02;

fn experiment() -> Arc<Experiment> {
    let times: Vec<f64> = (0..SAMPLES).map(|i| i as f64 * 5e-3).collect();
    let runs: Vec<Run> = (0..RUNS)
        .map(|k| {
            let pulse = |t: &f64| (1.0 + 0.2 * k as f64) * (6.0 * t + k as f64).sin().signum();
            Run { times: times.clone(), drive: times.iter().map(pulse).collect(), slope_deg: 0.0 }
        })
        .collect();
    let begin = Begin::Run { position: 0.0, speed: 0.0 };
    let window = (0, SAMPLES);
    let span = |run| Span { run, window, begin, payload: 1.0, reversed: run == 1 };
    Arc::new(Experiment::new(NOMINAL, runs, (0..RUNS).map(span).collect(), None))
}

fn active() -> Active {
    Active::default().with(Effect::ViscousFriction).with(Effect::DriveGainError)
}

fn truth() -> Point {
    let mut values = [0.0; EFFECT_PARAMS];
    values[Effect::ViscousFriction.first()] = DAMPING;
    values[Effect::DriveGainError.first()] = GAIN;
    let speeds = (0..RUNS).map(|run| if run == RUNS - 1 { SPEED } else { 0.0 }).collect();
    let shares = [1.0, 1.0, 1.0, 0.0];
    Point { active: active(), values, shares, speeds, offsets: vec![0.0; RUNS] }
}

fn how(level: Level, threads: usize, control: &Control) -> How<'_> {
    How { level, threads, control }
}

const SPANS: [usize; RUNS] = [0, 1, 2];

/// Readings of the true model with a little unevenness in place of noise, and a start
/// position that is known to twice the deviation of a sample.
fn misfit() -> Misfit {
    misfit_beside(0.0, 2.0)
}

/// The same with readings that are all `off`, and start positions that are known to so many
/// deviations of a sample.
fn misfit_beside(off: f64, known: f64) -> Misfit {
    misfit_with(off, &[vec![(0, vec![known; RUNS * SAMPLES])]])
}

fn misfit_with(off: f64, shifts: &[Shift]) -> Misfit {
    let experiment = experiment();
    let count = RUNS * SAMPLES;
    let mut read = vec![vec![0.0; count]; 4];
    let control = Control::default();
    let [x, v, rear, force] = &mut read[..] else { unreachable!() };
    let how = how(Level::Baseline, 1, &control);
    readings(&experiment, &[truth()], &SPANS, None, &how, [x, v, rear, force]).unwrap();
    let uneven =
        |(i, x): (usize, &f64)| x + off + DEVIATION * ((i * 7919 % 101) as f64 / 50.0 - 1.0);
    let signal = Signal {
        source: Source::Replayed(0),
        measured: read[0].iter().enumerate().map(uneven).collect(),
        weights: vec![1.0 / DEVIATION; count],
    };
    Misfit::new(experiment, &[signal], shifts)
}

fn start(damping: f64) -> Fit {
    let parameter = |effect: Effect, log: bool| What::Parameter { index: effect.first(), log };
    let deviation = f64::INFINITY;
    let around = |deviation: f64| Coordinate {
        low: -8.0 * deviation,
        high: 8.0 * deviation,
        size: deviation,
        deviation,
    };
    let (free, coordinates) = [
        (
            parameter(Effect::ViscousFriction, true),
            Coordinate { low: -12.0, high: 3.0, size: 1.0, deviation },
        ),
        (
            parameter(Effect::DriveGainError, false),
            Coordinate { low: -0.5, high: 0.5, size: 0.1, deviation },
        ),
        (What::Share(0), around(1e-3)),
        (What::Speed(2), Coordinate { size: 0.1, ..around(deviation) }),
    ]
    .into_iter()
    .unzip();
    Fit {
        model: Replayed { active: active(), free },
        coordinates,
        theta: DVector::from_vec(vec![damping.ln(), 0.0, 0.0, 0.0]),
        chi2: None,
        covariance: None,
        damping: 1e-2,
        limit: f64::INFINITY,
    }
}

const RULE: Rule = Rule { steps: 30, tolerance: 1e-3, share: FINE, least: Some(f64::INFINITY) };

fn fitted(misfit: &Misfit, level: Level, threads: usize) -> Vec<Fit> {
    let mut fits: Vec<Fit> = [0.01, 0.03, 0.3].into_iter().map(start).collect();
    let objective = OverSpans { misfit, spans: &SPANS };
    fit(&objective, &mut fits, RULE, &how(level, threads, &Control::default())).unwrap();
    fits
}

#[test]
fn true_values_come_back_from_every_start() {
    for found in fitted(&misfit(), Level::current().unwrap(), 2) {
        let covariance = found.covariance.as_ref().unwrap();
        let spread = |i: usize| covariance[(i, i)].sqrt();
        for (i, truth) in [DAMPING.ln(), GAIN, 0.0, SPEED].into_iter().enumerate() {
            let off = (found.theta[i] - truth).abs();
            assert!(off < 3.0 * spread(i), "{i}: {off:e} of {:e}", spread(i));
        }
        assert!(found.chi2.unwrap() < (RUNS * SAMPLES) as f64);
    }
}

#[test]
fn threads_and_levels_do_not_change_bits() {
    let misfit = misfit();
    let levels = Level::available();
    let expected = fitted(&misfit, levels[0], 1);
    for level in &levels {
        for threads in [1, 2, 3] {
            assert!(fitted(&misfit, *level, threads) == expected, "{level:?}, {threads}");
        }
    }
}

/// The same without room for derivatives beside trials.
struct Narrow<'a>(OverSpans<'a>);

impl Objective for Narrow<'_> {
    type Model = Replayed;

    fn compare(&self, asked: &[Asked], how: &How) -> Result<Vec<Compared>> {
        self.0.compare(asked, how)
    }

    fn room(&self, _: &Fit, _: usize) -> usize {
        0
    }

    fn samples(&self) -> u64 {
        self.0.samples()
    }

    fn samples_of_derivatives(&self, fit: &Fit) -> u64 {
        self.0.samples_of_derivatives(fit)
    }
}

#[test]
fn derivatives_that_come_with_a_step_change_no_bits() {
    let (misfit, control) = (misfit(), Control::default());
    let wide = OverSpans { misfit: &misfit, spans: &SPANS };
    let narrow = Narrow(OverSpans { misfit: &misfit, spans: &SPANS });
    assert!(wide.room(&start(0.01), 3) > 0);
    let how = how(Level::current().unwrap(), 1, &control);
    let fits = || [0.01, 0.03, 0.3].into_iter().map(start).collect::<Vec<Fit>>();
    let (mut with, mut without) = (fits(), fits());
    let counted = fit(&wide, &mut with, RULE, &how).unwrap();
    assert_eq!(fit(&narrow, &mut without, RULE, &how).unwrap(), counted);
    assert!(with == without);
}

#[test]
fn a_fit_that_would_not_catch_up_is_left() {
    let (misfit, control) = (misfit(), Control::default());
    let objective = OverSpans { misfit: &misfit, spans: &SPANS };
    let how = how(Level::current().unwrap(), 1, &control);
    let ends = |least: Option<f64>| {
        let mut one = [start(0.01)];
        let ended = fit(&objective, &mut one, Rule { least, ..RULE }, &how).unwrap();
        assert!(ended.open.is_empty());
        (ended.evaluated, one[0].chi2.unwrap())
    };
    let (alone, end) = ends(None);
    // Others are far ahead: what the last steps gain is too little for their distance.
    let (behind, left) = ends(Some(end - 1e9));
    assert!(behind < alone && left >= end, "{behind} of {alone}, {left} and {end}");
    assert_eq!(ends(Some(end)), (alone, end));
}

#[test]
fn derivatives_add_up_to_the_change_of_residuals() {
    let (misfit, control) = (misfit(), Control::default());
    let how = how(Level::current().unwrap(), 2, &control);
    let fit = start(0.05);
    let rows = jacobian(&misfit, &fit, &SPANS, &how).unwrap();
    let change = [1e-3, 1e-4, 1e-5, 1e-4];
    let moved = &fit.theta + DVector::from_row_slice(&change);
    let models = [(&fit, fit.theta.clone()), (&fit, moved)];
    let found = evaluate(&misfit, &models, &SPANS, true, &how).unwrap();
    let [here, there] = found.try_into().ok().map(|[a, b]: [_; 2]| [a, b]).unwrap();
    let (here, there) = (here.residual.unwrap(), there.residual.unwrap());
    let (mut off, mut all) = (0.0, 0.0);
    for i in 0..misfit.residuals(&SPANS) {
        let step: f64 = rows.iter().zip(change).map(|(row, by)| row[i] * by).sum();
        off += (there[i] - here[i] - step).powi(2);
        all += step.powi(2);
    }
    assert!(off.sqrt() < 0.02 * all.sqrt(), "{} of {}", off.sqrt(), all.sqrt());
}

/// Squares are worked out without the rows, from products with the shifts; where the shifts
/// take out all but 1e-12 of a row, these say nothing any more.
#[test]
fn squares_are_those_of_the_residuals_however_much_shifts_take_out() {
    let control = Control::default();
    let how = how(Level::current().unwrap(), 2, &control);
    let fit = start(0.05);
    for (off, known) in [(0.0, 2.0), (1e-2, 1e4), (1.0, 1e9)] {
        let misfit = misfit_beside(off, known);
        let models = [(&fit, fit.theta.clone())];
        let kept = evaluate(&misfit, &models, &SPANS, true, &how).unwrap().remove(0);
        let bare = evaluate(&misfit, &models, &SPANS, false, &how).unwrap().remove(0);
        let squares: f64 = kept.residual.unwrap().iter().map(|e| e * e).sum();
        assert_eq!(kept.chi2, bare.chi2);
        assert!((bare.chi2 - squares).abs() < 1e-9 * squares, "{off}: {} {squares}", bare.chi2);
    }
}

/// A start and the knots of a force move readings by millions of deviations, and by nearly the
/// same ones: what they can do is a line here, whatever their order and their lengths.
#[test]
fn long_shifts_that_differ_little_are_taken_out_together() {
    let control = Control::default();
    let how = how(Level::current().unwrap(), 1, &control);
    let ramp = |i: usize| (i % SAMPLES) as f64 / SAMPLES as f64;
    let long = |share: f64| -> Shift {
        vec![(0, (0..RUNS * SAMPLES).map(|i| 1e7 * (1.0 + share * ramp(i))).collect())]
    };
    let rows = |shifts: &[Shift]| {
        let misfit = misfit_with(1e-3, shifts);
        let mut rows = vec![0.0; misfit.residuals(&SPANS)];
        residuals(&misfit, &[truth()], &SPANS, f64::INFINITY, &how, &mut rows).unwrap();
        rows
    };
    let bare = rows(&[]);
    for shifts in [[long(0.0), long(1e-3)], [long(1e-3), long(0.0)]] {
        let found = rows(&shifts);
        for run in SPANS {
            let own = run * SAMPLES..(run + 1) * SAMPLES;
            let mean = bare[own.clone()].iter().sum::<f64>() / SAMPLES as f64;
            let middle = (SAMPLES - 1) as f64 / 2.0 / SAMPLES as f64;
            let along: f64 = own.clone().map(|i| bare[i] * (ramp(i) - middle)).sum();
            let slope = along / own.clone().map(|i| (ramp(i) - middle).powi(2)).sum::<f64>();
            for i in own {
                let line = mean + slope * (ramp(i) - middle);
                assert!((found[i] - (bare[i] - line)).abs() < 1e-6, "{i}: {}", found[i]);
            }
        }
    }
}

#[test]
fn a_model_that_runs_away_is_far_from_everything() {
    let (misfit, control) = (misfit(), Control::default());
    let how = how(Level::current().unwrap(), 1, &control);
    let mut point = truth();
    point.values[Effect::ViscousFriction.first()] = -1e3;
    let mut rows = vec![0.0; misfit.residuals(&SPANS)];
    residuals(&misfit, &[point], &SPANS, f64::INFINITY, &how, &mut rows).unwrap();
    assert!(rows.iter().all(|e| e.is_finite()));
    assert!(rows.iter().map(|e| e * e).sum::<f64>() > 1e100);
}

#[test]
fn a_cancelled_fit_ends() {
    let control = Control::default();
    control.cancel.store(true, Ordering::Relaxed);
    let mut fits = [start(0.01)];
    let how = how(Level::current().unwrap(), 1, &control);
    let objective = OverSpans { misfit: &misfit(), spans: &SPANS };
    let ended = fit(&objective, &mut fits, RULE, &how);
    assert!(matches!(ended, Err(Error::Cancelled { .. })));
}
