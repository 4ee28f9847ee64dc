//! What is refused, and how a run is stopped.

use super::*;

#[test]
fn a_cancelled_run_stops() {
    let (axes, fixed) = plain();
    let job = job(&axes, &fixed, all());
    let control = Control::default();
    control.cancel.store(true, Ordering::Relaxed);
    let mut out = vec![0.0; job.cells()];
    let error = run(&job, vec![(0, Buffer::F64(&mut out))], options(2, 64), &control);
    assert_eq!(error, Err(Error::Cancelled { done: 0, total: job.evaluations() }));
}

#[test]
fn a_running_sweep_stops_soon() {
    let grid = || {
        let axes = [
            ("mu_static", steps(0.1, 1.3, 400)),
            ("mu_coulomb", steps(0.1, 1.3, 400)),
            ("viscous", steps(0.1, 1.3, 400)),
            ("segments", whole(2, 400)),
        ];
        Grid::new(&axes, &[]).unwrap()
    };
    let entry = Entry::parse("mean_velocity").unwrap();
    for reduce in [None, Some(Reduce::Mean), Some(Reduce::Quantile(0.5))] {
        let over = reduce.map(|_| "segments");
        let mut grid = grid();
        if reduce.is_none() {
            grid.axes[3].values.truncate(2);
        }
        let job =
            Job::new(grid, vec![Request { entry, reduce }], over, &Choice::default()).unwrap();
        let mut out = vec![0.0; job.cells()];
        let control = Control::default();
        let (result, waited) = std::thread::scope(|scope| {
            let sweep = scope.spawn(|| {
                run(&job, vec![(0, Buffer::F64(&mut out))], options(2, DEFAULT_CHUNK), &control)
            });
            while control.done.load(Ordering::Relaxed) == 0 {
                std::thread::yield_now();
            }
            let asked = Instant::now();
            control.cancel.store(true, Ordering::Relaxed);
            (sweep.join().unwrap(), asked.elapsed())
        });
        let Err(Error::Cancelled { done, total }) = result else {
            panic!("{reduce:?}: {result:?}");
        };
        assert!(done < total && total == job.evaluations());
        println!("{reduce:?}: stopped after {} ms", waited.as_millis());
        assert!(waited.as_millis() < 250, "{reduce:?}: {waited:?}");
    }
}

#[test]
fn progress_counts_every_evaluation() {
    let (axes, fixed) = plain();
    for job in [job(&axes, &fixed, all())].into_iter().chain(reduced(
        &axes,
        &fixed,
        "segments",
        "mean_velocity",
    )) {
        let control = Control::default();
        let mut out = vec![0.0; job.cells()];
        run(&job, vec![(0, Buffer::F64(&mut out))], options(3, 100), &control).unwrap();
        assert_eq!(control.done.load(Ordering::Relaxed), job.evaluations());
    }
}

#[test]
fn buffers_must_fit() {
    let (axes, fixed) = plain();
    let job = job(&axes, &fixed, all());
    for size in [0, job.cells() - 1, job.cells() + 1] {
        let (mut wide, mut narrow, mut codes) = (vec![0.0; size], vec![0.0; size], vec![0; size]);
        for buffer in [Buffer::F64(&mut wide), Buffer::F32(&mut narrow), Buffer::Status(&mut codes)]
        {
            let error = run(&job, vec![(1, buffer)], options(1, 64), &Control::default());
            let quantity = closed()[1].info.name.to_owned();
            assert_eq!(error, Err(Error::OutSize { quantity, given: size, needed: job.cells() }));
        }
    }
}

#[test]
fn grids_too_large_to_count_are_refused() {
    let long = |name| (name, vec![1.0; 1 << 20]);
    let axes = ["mu_static", "mu_coulomb", "mass", "stroke"].map(long);
    let sizes = vec![1 << 20; 4];
    assert_eq!(Grid::new(&axes, &[]).err(), Some(Error::GridTooLarge { sizes: sizes.clone() }));
    let text = Error::GridTooLarge { sizes }.to_string();
    assert!(text.contains("1048576 x 1048576 x 1048576 x 1048576"), "{text}");
    // 2^60 cells fit into 64 bits, 2^63 bytes do not fit into memory.
    assert!(matches!(Grid::new(&axes[..3], &[]).err(), Some(Error::GridTooLarge { .. })));
    assert_eq!(Grid::new(&axes[..2], &[]).unwrap().points(), Ok(1 << 40));
}

#[test]
fn requests_are_checked() {
    let grid = |axes: &[(&str, Vec<f64>)]| Grid::new(axes, &[("mu_static", 0.5)]).unwrap();
    let segments = ("segments", whole(2, 4));
    let request = |reduce| vec![Request { entry: Entry::parse("mean_velocity").unwrap(), reduce }];
    let error =
        Job::new(grid(std::slice::from_ref(&segments)), request(None), None, &Choice::default())
            .err();
    assert!(matches!(error, Some(Error::MissingParameter { name, .. }) if name == "mu_coulomb"));
    let axes = [segments, ("mu_coulomb", vec![0.3])];
    let error = Job::new(grid(&axes), request(Some(Reduce::Max)), None, &Choice::default()).err();
    assert!(matches!(error, Some(Error::BadOption { name: "reduce", .. })));
    let error = Job::new(grid(&axes), request(None), Some("segments"), &Choice::default()).err();
    assert!(matches!(error, Some(Error::BadOption { name: "reduce", .. })));
    let error =
        Job::new(grid(&axes), request(Some(Reduce::Max)), Some("mass"), &Choice::default()).err();
    assert!(matches!(error, Some(Error::NotAnAxis { axis, .. }) if axis == "mass"));
    let error =
        Job::new(grid(&axes), request(Some(Reduce::Max)), Some("masss"), &Choice::default()).err();
    assert!(matches!(error, Some(Error::UnknownName { kind: "parameter", .. })));
    for (name, q) in [("quantile", None), ("quantile", Some(1.5)), ("quantile", Some(f64::NAN))] {
        assert!(matches!(Reduce::parse(name, q), Err(Error::BadOption { name: "q", .. })));
    }
    assert!(matches!(Reduce::parse("max", Some(0.5)), Err(Error::BadOption { name: "q", .. })));
    for (name, _) in Reduce::ALL {
        let q = (*name == "quantile").then_some(0.5);
        assert!(Reduce::parse(name, q).is_ok());
    }
    for level in Level::available() {
        assert_eq!(Level::parse(level.name()), Ok(level));
    }
    assert!(matches!(Level::parse("avx1024"), Err(Error::BadOption { .. })));
}

#[test]
fn a_sample_takes_its_parameters_together() {
    let sample = [("mu_coulomb", vec![0.2, 0.3, 0.25]), ("slope_deg", vec![0.0, 5.0, 10.0])];
    let axes = [("segments", vec![3.0, 4.0])];
    let fixed = [("mu_static", 0.5)];
    let entry = Entry::parse("mean_velocity").unwrap();
    let values = |axes: &[(&str, Vec<f64>)], sample: &[(&str, Vec<f64>)], over, reduce| {
        let grid = Grid::with_sample(axes, sample, &fixed).unwrap();
        let request = Request { entry, reduce };
        let job = Job::new(grid, vec![request], over, &Choice::default()).unwrap();
        let mut out = vec![0.0; job.cells()];
        let control = Control::default();
        run(&job, vec![(0, Buffer::F64(&mut out))], options(1, 4), &control).unwrap();
        out
    };
    let found = values(&axes, &sample, None, None);
    assert_eq!(found.len(), 6);
    let best = values(&axes, &sample, Some("segments"), Some(Reduce::Max));
    for k in 0..3 {
        let one = [("mu_coulomb", vec![sample[0].1[k]]), ("slope_deg", vec![sample[1].1[k]])];
        let alone = values(&[axes[0].clone(), one[0].clone(), one[1].clone()], &[], None, None);
        same(&alone, &[found[k], found[3 + k]], "sample");
        same(&[alone[0].max(alone[1])], &[best[k]], "best of each point");
    }
}

#[test]
fn a_sample_of_unequal_lengths_is_refused() {
    let sample = [("mu_coulomb", vec![0.2, 0.3]), ("slope_deg", vec![0.0])];
    let error = Grid::with_sample(&[], &sample, &[]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "sample is 1 values of slope_deg: allowed is as many as mu_coulomb has: 2"
    );
    let twice = [("mu_coulomb", vec![0.2]), ("mu_coulomb", vec![0.3])];
    let error = Grid::with_sample(&[], &twice, &[]).unwrap_err();
    assert!(error.to_string().contains("mu_coulomb"), "{error}");
    let axes = [("segments", vec![3.0, 4.0])];
    let grid = Grid::with_sample(&axes, &[("mu_coulomb", vec![0.2, 0.3])], &[]).unwrap();
    assert_eq!(grid.shape(), [2, 2]);
}
