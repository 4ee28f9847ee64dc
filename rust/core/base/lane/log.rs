//! Natural logarithm and powers, over lanes.
//!
//! The logarithm is kept in two parts until the end: a power multiplies it by
//! an exponent, and e^x turns the error of x into a relative one.

use super::Lane;
use super::exp::exp;

/// ln(x): minus infinity at 0, NaN below; within 1 ulp.
#[inline(always)]
pub fn ln<L: Lane>(x: L) -> L {
    x.shared(
        #[inline(always)]
        || ln_here(x),
    )
}

#[inline(always)]
fn ln_here<L: Lane>(x: L) -> L {
    let (high, low) = parts(x);
    at_the_ends(x, high + low)
}

/// ln(1 + x) for x > -1, with all digits near 0; within 1 ulp.
#[inline(always)]
pub fn ln_1p<L: Lane>(x: L) -> L {
    x.shared(
        #[inline(always)]
        || ln_1p_here(x),
    )
}

#[inline(always)]
fn ln_1p_here<L: Lane>(x: L) -> L {
    let u = x + 1.0;
    // What the sum rounded away (Knuth), whichever of 1 and x is larger.
    let back = u - 1.0;
    let lost = (x - back) - ((u - back) - 1.0);
    let (m, k) = u.split();
    // Beyond 2^60 the lost part is too small to matter.
    let lost = lost * (-k.min(x.splat(60.0))).exp2_whole();
    let (high, low) = sum(m - 1.0, lost, k);
    at_the_ends(u, high + low)
}

/// x^p for x >= 0, clamped to e^-700..e^700 except that 0^p is 0 for p > 0 and
/// x^0 is 1. Within 2 ulp.
#[inline(always)]
pub fn power<L: Lane>(x: L, p: L) -> L {
    x.shared(
        #[inline(always)]
        || power_here(x, p),
    )
}

#[inline(always)]
fn power_here<L: Lane>(x: L, p: L) -> L {
    let zero = x.splat(0.0);
    let (high, low) = parts(x.min(x.splat(f64::MAX)));
    let product = high * p;
    let rest = high.mul_add(p, -product) + low * p;
    let grown = exp(product);
    let value = grown.mul_add(rest, grown);
    let at_zero = L::select(p.gt(zero), zero, x.splat(f64::INFINITY));
    let value = L::select(x.gt(zero), value, at_zero);
    let value = L::select(L::and(p.le(zero), zero.le(p)), x.splat(1.0), value);
    L::select(x.not_nan(), value, x)
}

/// ln(x) as the sum of two numbers, the second below half a unit of the first.
#[inline(always)]
fn parts<L: Lane>(x: L) -> (L, L) {
    let tiny = x.lt(x.splat(f64::MIN_POSITIVE));
    let lifted = L::select(tiny, x * 18_014_398_509_481_984.0, x);
    let (m, k) = lifted.split();
    let k = L::select(tiny, k - 54.0, k);
    sum(m - 1.0, x.splat(0.0), k)
}

/// ln(1 + f + rest) + k ln 2 in two parts, |f| <= 0.4143, rest far below f.
#[inline(always)]
fn sum<L: Lane>(f: L, rest: L, k: L) -> (L, L) {
    // ln(1 + f) = 2 atanh(t/2) with t = 2 f/(2 + f), here t + fine.
    let d = f + 2.0;
    let short = f - (d - 2.0) + rest;
    let per = f.splat(1.0) / d;
    let twice = f + f;
    let t = twice * per;
    let fine = ((-t).mul_add(d, twice) + (rest + rest) - t * short) * per;
    let z = t * t;
    // Sum of z^n/(4^n (2n + 1)): what is left out is below 1e-18 of the sum.
    let mut tail = f.splat(1.0 / (4_194_304.0 * 23.0));
    for c in [
        1.0 / (1_048_576.0 * 21.0),
        1.0 / (262_144.0 * 19.0),
        1.0 / (65_536.0 * 17.0),
        1.0 / (16_384.0 * 15.0),
        1.0 / (4_096.0 * 13.0),
        1.0 / (1_024.0 * 11.0),
        1.0 / (256.0 * 9.0),
        1.0 / (64.0 * 7.0),
        1.0 / (16.0 * 5.0),
        1.0 / (4.0 * 3.0),
    ] {
        tail = tail.mul_add(z, f.splat(c));
    }
    // ln 2 in two parts: the first has 32 trailing zero bits, k * part is exact
    // and, unless 0, larger than t.
    let whole = k * 6.931_471_803_691_238e-1;
    let high = whole + t;
    let lost = t - (high - whole);
    let small = (t * z).mul_add(tail, fine);
    let low = k.mul_add(f.splat(1.908_214_929_270_587_7e-10), small) + lost;
    let total = high + low;
    (total, low - (total - high))
}

/// Infinities and NaN where the bits of `x` are not those of a positive number.
#[inline(always)]
fn at_the_ends<L: Lane>(x: L, value: L) -> L {
    let zero = x.splat(0.0);
    let most = x.splat(f64::MAX);
    let below = L::select(x.lt(zero), x.splat(f64::NAN), x.splat(f64::NEG_INFINITY));
    let ends = L::select(x.gt(zero), x, below);
    let ends = L::select(x.not_nan(), ends, x);
    L::select(L::and(x.gt(zero), x.le(most)), value, ends)
}
