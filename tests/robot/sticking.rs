//! Who sticks.

use super::*;

/// A random chain as a step sees it, with generic numbers.
fn random_step(random: &mut Random, n: usize, breaks: bool) -> Step<f64> {
    let mut step = Step::new(n, 0.0);
    for i in 0..n {
        step.inertia[i] = random.between(0.1, 1.0);
        let moves = random.one_in(2);
        step.v[i] = if moves { random.between(-0.1, 0.1) } else { 0.0 };
        step.push[i] = step.inertia[i] * step.v[i] + random.between(-0.05, 0.05);
        step.ahead_slide[i] = random.between(0.0, 0.06);
        step.back_slide[i] = random.between(0.0, 0.06);
        let more = if breaks { random.between(1.0, 2.0) } else { 1.0 };
        step.ahead_hold[i] = step.ahead_slide[i] * more;
        step.back_hold[i] = step.back_slide[i] * more;
        step.gain[i] = random.between(0.0, 20.0);
        step.bias[i] = random.between(-0.1, 0.1);
        step.limit[i] = if random.one_in(3) { f64::INFINITY } else { random.between(0.01, 0.1) };
    }
    step
}

/// All consistent answers for these friction levels, by trying every pattern of
/// sticking, sliding and joints at their limit on a dense matrix.
fn enumerate(step: &Step<f64>, ahead: &[f64], back: &[f64]) -> Vec<Vec<f64>> {
    use nalgebra::{DMatrix, DVector};
    let n = step.n;
    let mut found = Vec::new();
    let digit = |pattern: usize, i: usize| (pattern / 3usize.pow(i as u32) % 3) as i32 - 1;
    for modes in 0..3usize.pow(n as u32) {
        for bounds in 0..3usize.pow(n as u32 - 1) {
            let mut a = DMatrix::<f64>::zeros(n, n);
            let mut b = DVector::<f64>::zeros(n);
            for i in 0..n {
                a[(i, i)] = step.inertia[i];
                b[i] = step.push[i];
            }
            let mut possible = true;
            for j in 0..n - 1 {
                let bound = digit(bounds, j);
                if bound == 0 {
                    for (row, sign) in [(j, 1.0), (j + 1, -1.0)] {
                        a[(row, j)] += sign * step.gain[j];
                        a[(row, j + 1)] -= sign * step.gain[j];
                        b[row] += sign * step.bias[j];
                    }
                } else if step.limit[j].is_finite() {
                    b[j] += f64::from(bound) * step.limit[j];
                    b[j + 1] -= f64::from(bound) * step.limit[j];
                } else {
                    possible = false;
                }
            }
            if !possible {
                continue;
            }
            let (full_a, full_b) = (a.clone(), b.clone());
            for i in 0..n {
                match digit(modes, i) {
                    0 => {
                        a.row_mut(i).fill(0.0);
                        a[(i, i)] = 1.0;
                        b[i] = 0.0;
                    }
                    1 => b[i] -= ahead[i],
                    _ => b[i] += back[i],
                }
            }
            let Some(w) = a.lu().solve(&b) else { continue };
            let friction = &full_b - &full_a * &w;
            let fits = |i: usize| match digit(modes, i) {
                0 => friction[i] <= ahead[i] && friction[i] >= -back[i],
                1 => w[i] > 0.0,
                _ => w[i] < 0.0,
            };
            let joint = |j: usize| {
                let trial = step.bias[j] - step.gain[j] * (w[j] - w[j + 1]);
                match digit(bounds, j) {
                    0 => trial.abs() <= step.limit[j],
                    1 => trial > step.limit[j],
                    _ => trial < -step.limit[j],
                }
            };
            if (0..n).all(fits) && (0..n - 1).all(joint) {
                let pinned = |i: usize| if digit(modes, i) == 0 { 0.0 } else { w[i] };
                found.push((0..n).map(pinned).collect());
            }
        }
    }
    found
}

#[test]
fn sticking_is_decided_as_by_brute_force() {
    let mut random = Random(21);
    for round in 0..400 {
        let n = [1, 2, 3, 3, 4][round % 5];
        let breaks = round % 2 == 1;
        let mut step = random_step(&mut random, n, breaks);
        let level = |moves: bool, slide: f64, hold: f64| if moves { slide } else { hold };
        let mut ahead: Vec<f64> = (0..n)
            .map(|i| level(step.v[i] > 0.0, step.ahead_slide[i], step.ahead_hold[i]))
            .collect();
        let mut back: Vec<f64> =
            (0..n).map(|i| level(step.v[i] < 0.0, step.back_slide[i], step.back_hold[i])).collect();
        let body = |i: usize| Body {
            inertia: step.inertia[i],
            push: step.push[i],
            ahead: ahead[i],
            back: back[i],
        };
        let mut bodies: Vec<Body> = (0..n).map(body).collect();
        // Those that the joint answer lets slide fall to their sliding level.
        let answer = loop {
            let found = enumerate(&step, &ahead, &back);
            assert_eq!(found.len(), 1, "round {round}: one and only one answer");
            let w = &found[0];
            let mut more = false;
            for i in 0..n {
                let (a, b) = (step.ahead_slide[i], step.back_slide[i]);
                if (w[i] > 0.0 && ahead[i] > a) || (w[i] < 0.0 && back[i] > b) {
                    (ahead[i], back[i]) = (a, b);
                    more = true;
                }
            }
            if !more {
                break found[0].clone();
            }
        };
        let slide = |i: usize| Sliding { ahead: step.ahead_slide[i], back: step.back_slide[i] };
        let sliding: Vec<Sliding> = (0..n).map(slide).collect();
        let link = |j: usize| Link {
            gain: step.gain[j],
            bias: step.bias[j],
            low: -step.limit[j],
            high: step.limit[j],
        };
        let links: Vec<Link> = (0..n - 1).map(link).collect();
        let mut chain = Chain::default();
        solve_with_break_away(&mut chain, &mut bodies, &sliding, &links);
        for i in 0..n {
            // Any guess leads to the answer.
            step.slide[i] = random.whole(0, 2) - 1.0;
            step.bound[i] = 0.0;
        }
        step.solve();
        for (i, w) in answer.iter().enumerate() {
            for got in [chain.w[i], step.w[i]] {
                assert!((got - w).abs() < 1e-12, "round {round}: {got} {w}");
                assert_eq!(got == 0.0, *w == 0.0, "round {round}");
            }
        }
    }
}

#[test]
fn guesses_and_the_exact_solver_agree_on_long_chains() {
    let mut random = Random(22);
    for round in 0..3000 {
        let n = random.whole(2, 32) as usize;
        let mut step = random_step(&mut random, n, false);
        let body = |i: usize| Body {
            inertia: step.inertia[i],
            push: step.push[i],
            ahead: step.ahead_slide[i],
            back: step.back_slide[i],
        };
        let bodies: Vec<Body> = (0..n).map(body).collect();
        let link = |j: usize| Link {
            gain: step.gain[j],
            bias: step.bias[j],
            low: -step.limit[j],
            high: step.limit[j],
        };
        let links: Vec<Link> = (0..n - 1).map(link).collect();
        let mut chain = Chain::default();
        chain.solve(&bodies, &links);
        step.solve();
        for i in 0..n {
            let gap = (chain.w[i] - step.w[i]).abs();
            assert!(gap < 1e-11, "round {round} of {n}: {} {}", chain.w[i], step.w[i]);
        }
    }
}

#[test]
fn forces_keep_their_digits_in_long_chains_of_weak_gain() {
    // Joints that hardly depend on the speed, as the motor's line does within a step:
    // each body meets the sum of its forces, whatever the gain.
    let mut random = Random(24);
    let mut chain = Chain::default();
    for round in 0..600 {
        let n = random.whole(2, 32) as usize;
        let gain = random.log(1e-9, 1.0);
        let body = |random: &mut Random| Body {
            inertia: random.between(0.1, 1.0),
            push: random.between(-1.0, 1.0),
            ahead: random.between(0.0, 0.5),
            back: random.between(0.0, 0.5),
        };
        let bodies: Vec<Body> = (0..n).map(|_| body(&mut random)).collect();
        let link = |random: &mut Random| {
            let bias = random.between(-20.0, 20.0);
            Link { gain, bias, low: f64::NEG_INFINITY, high: f64::INFINITY }
        };
        let links: Vec<Link> = (1..n).map(|_| link(&mut random)).collect();
        chain.solve(&bodies, &links);
        let (w, q) = (&chain.w, &chain.q);
        for (j, link) in links.iter().enumerate() {
            let force = link.bias - gain * (w[j] - w[j + 1]);
            assert!((q[j] - force).abs() < 1e-12 * 20.0, "round {round} of {n}: {} {force}", q[j]);
        }
        for (i, body) in bodies.iter().enumerate() {
            let ahead = if i > 0 { q[i - 1] } else { 0.0 };
            let need = body.push + q.get(i).copied().unwrap_or(0.0) - ahead;
            let slides = (need - body.ahead).max(0.0) + (need + body.back).min(0.0);
            let wrong = body.inertia * w[i] - slides;
            assert!(wrong.abs() < 1e-11 * 20.0, "round {round} of {n}: {wrong}");
        }
    }
}

#[test]
fn rigid_joints_make_one_body() {
    let mut random = Random(23);
    let mut chain = Chain::default();
    for _ in 0..300 {
        let body = |random: &mut Random| Body {
            inertia: random.between(0.1, 1.0),
            push: random.between(-1.0, 1.0),
            ahead: random.between(0.0, 0.5),
            back: random.between(0.0, 0.5),
        };
        let n = random.whole(1, 8) as usize;
        let bodies: Vec<Body> = (0..n).map(|_| body(&mut random)).collect();
        chain.solve(&bodies, &vec![Link::RIGID; n - 1]);
        let sum = |f: fn(&Body) -> f64| bodies.iter().map(f).sum::<f64>();
        let (push, mass) = (sum(|b| b.push), sum(|b| b.inertia));
        let (ahead, back) = (sum(|b| b.ahead), sum(|b| b.back));
        let w = ((push - ahead).max(0.0) + (push + back).min(0.0)) / mass;
        for (i, body) in bodies.iter().enumerate() {
            assert!((chain.w[i] - w).abs() < 1e-13, "{} {w}", chain.w[i]);
            assert_eq!(chain.w[i] == 0.0, w == 0.0);
            // What each segment is left with is within its friction.
            let q = |j: Option<usize>| j.and_then(|j| chain.q.get(j)).copied().unwrap_or(0.0);
            let own = body.push + q(Some(i)) - q(i.checked_sub(1)) - body.inertia * w;
            assert!(own <= body.ahead + 1e-12 && own >= -body.back - 1e-12);
        }
    }
}
