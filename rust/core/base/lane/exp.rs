//! Exponential and the functions of viscous motion, over lanes.
//!
//! With x = t/tau, a segment that starts from rest with acceleration a under
//! viscous friction has v = a t E1(x) and path a t^2 E2(x). Both functions are
//! smooth at x = 0 (1 and 1/2), so no formula needs a special case for a
//! viscous coefficient of zero. Tested against 60-digit references.

use super::Lane;

/// e^x for x in [-700, 700] (clamped there), within 1 ulp.
#[inline(always)]
pub fn exp<L: Lane>(x: L) -> L {
    x.shared(
        #[inline(always)]
        || exp_here(x),
    )
}

#[inline(always)]
fn exp_here<L: Lane>(x: L) -> L {
    let x = x.max(x.splat(-700.0)).min(x.splat(700.0));
    let k = (x * std::f64::consts::LOG2_E).round();
    (reduced(x, k) + 1.0) * k.exp2_whole()
}

/// e^r - 1 for r = x - k ln 2.
#[inline(always)]
fn reduced<L: Lane>(x: L, k: L) -> L {
    // ln 2 in two parts: the first has 32 trailing zero bits, k * part is exact.
    let r = k.mul_add(x.splat(-6.931_471_803_691_238e-1), x);
    let r = k.mul_add(x.splat(-1.908_214_929_270_587_7e-10), r);
    // Taylor to r^13 on |r| <= 0.3466: remainder below 5e-18. Even and odd powers apart,
    // so that one chain does not wait for the other.
    let square = r * r;
    let mut even = x.splat(1.0 / 479_001_600.0);
    for c in [1.0 / 3_628_800.0, 1.0 / 40_320.0, 1.0 / 720.0, 1.0 / 24.0, 0.5] {
        even = even.mul_add(square, x.splat(c));
    }
    let mut odd = x.splat(1.0 / 6_227_020_800.0);
    for c in [1.0 / 39_916_800.0, 1.0 / 362_880.0, 1.0 / 5_040.0, 1.0 / 120.0, 1.0 / 6.0] {
        odd = odd.mul_add(square, x.splat(c));
    }
    let tail = odd.mul_add(r, even);
    square.mul_add(tail, r)
}

/// e^x - 1 for x in [-700, 700], within 2 ulp.
#[inline(always)]
pub fn exp_less_one<L: Lane>(x: L) -> L {
    x.shared(
        #[inline(always)]
        || exp_less_one_here(x),
    )
}

#[inline(always)]
fn exp_less_one_here<L: Lane>(x: L) -> L {
    let x = x.max(x.splat(-700.0)).min(x.splat(700.0));
    let k = (x * std::f64::consts::LOG2_E).round();
    let power = k.exp2_whole();
    // 2^k (1 + s) - 1 with s = e^r - 1.
    power.mul_add(reduced(x, k), power - 1.0)
}

/// tanh(x), within 4 ulp.
#[inline(always)]
pub fn tanh<L: Lane>(x: L) -> L {
    // (e^2a - 1)/(e^2a + 1) keeps its digits at 0; beyond 20 it is 1.
    let a = x.abs().min(x.splat(20.0));
    let grown = exp_less_one(a + a);
    let size = grown / (grown + 2.0);
    L::select(x.lt(x.splat(0.0)), -size, size)
}

/// E2(x) = (x + e^-x - 1)/x^2 for x >= 0.
#[inline(always)]
pub fn path_factor<L: Lane>(x: L) -> L {
    let one = x.splat(1.0);
    // Beyond 1 the subtraction loses at most two bits; below, the series.
    let far = x.max(one);
    let direct = (far + exp(-far) - 1.0) / (far * far);
    L::select(x.lt(one), near_path_factor(x.min(one)), direct)
}

/// E1(x) = (1 - e^-x)/x = 1 - x E2(x) for x >= 0.
#[inline(always)]
pub fn speed_factor<L: Lane>(x: L) -> L {
    let one = x.splat(1.0);
    let far = x.max(one);
    let direct = (one - exp(-far)) / far;
    let near = x.min(one);
    L::select(x.lt(one), (-near).mul_add(near_path_factor(near), one), direct)
}

/// e^-x, E1(x) and E2(x) together, x >= 0; only the form that some lane needs is
/// computed, and the one that is not needed changes no lane.
#[inline(always)]
pub fn motion_factors<L: Lane>(x: L) -> (L, L, L) {
    x.shared(
        #[inline(always)]
        || motion_factors_here(x),
    )
}

#[inline(always)]
fn motion_factors_here<L: Lane>(x: L) -> (L, L, L) {
    let one = x.splat(1.0);
    let is_near = x.lt(one);
    let near = x.min(one);
    let e2 = near_path_factor(near);
    let e1 = (-near).mul_add(e2, one);
    let decay = (-near).mul_add(e1, one);
    if !L::any(L::not(is_near)) {
        return (decay, e1, e2);
    }
    x.outlined(
        #[inline(always)]
        || {
            let far = x.max(one);
            let far_decay = exp(-far);
            let far_e1 = (one - far_decay) / far;
            let far_e2 = (one - far_e1) / far;
            (
                L::select(is_near, decay, far_decay),
                L::select(is_near, e1, far_e1),
                L::select(is_near, e2, far_e2),
            )
        },
    )
}

/// Sum of (-x)^n/(n + 2)! to n = 17 for x in [0, 1]: remainder below 1e-17.
#[inline(always)]
fn near_path_factor<L: Lane>(x: L) -> L {
    const EVEN: [f64; 9] = inverse_factorials(2, 1.0);
    const ODD: [f64; 9] = inverse_factorials(3, -1.0);
    let square = x * x;
    let (mut even, mut odd) = (x.splat(EVEN[8]), x.splat(ODD[8]));
    for n in (0..8).rev() {
        even = even.mul_add(square, x.splat(EVEN[n]));
        odd = odd.mul_add(square, x.splat(ODD[n]));
    }
    odd.mul_add(x, even)
}

/// sign/n! for every second n from `first` on.
const fn inverse_factorials(first: u32, sign: f64) -> [f64; 9] {
    let mut values = [0.0; 9];
    let (mut n, mut factorial) = (1, 1.0);
    while n < first + 18 {
        factorial *= n as f64;
        if n >= first && (n - first).is_multiple_of(2) {
            values[((n - first) / 2) as usize] = sign / factorial;
        }
        n += 1;
    }
    values
}

/// ln(1 + x)/x for x > -1, lane by lane.
#[inline(always)]
pub fn log_factor<L: Lane>(x: L) -> L {
    x.map(|x| if x == 0.0 { 1.0 } else { libm::log1p(x) / x })
}

/// (x - ln(1 + x))/x^2 for x > -1, lane by lane.
#[inline(always)]
pub fn log_path_factor<L: Lane>(x: L) -> L {
    x.map(|x| {
        if x.abs() > 0.25 {
            return (x - libm::log1p(x)) / (x * x);
        }
        // Sum of (-x)^n/(n + 2); 28 terms leave less than 1e-17 at |x| = 1/4.
        (0..28).rev().fold(0.0, |sum, n| 1.0 / f64::from(n + 2) - x * sum)
    })
}
