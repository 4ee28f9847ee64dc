//! Numbers in lanes: one formula, written once, runs on a single `f64` and on
//! the widest registers of the machine.
//!
//! Every lane does the same operations in the same order, nothing is
//! reassociated, and [`Lane::mul_add`] rounds once: AVX-512, AVX2, NEON and the
//! scalar `f64` give the same bits.

mod dual;
pub mod exp;
mod level;
pub mod log;
mod root;
pub mod stream;
pub mod trig;
mod wide;

pub use dual::Dual;
pub use level::{Level, Task, run, scalar_token};
pub use wide::{Pack, Pack1, Pack2, Pack4};

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Bits of a double just above sqrt(1/2), and what lifts them to those of 1.
const SQRT_HALF: u64 = 0x3fe6_a09e_6800_0000;
const SPLIT_OFFSET: u64 = 0x3ff0_0000_0000_0000 - SQRT_HALF;
const MANTISSA: u64 = (1 << 52) - 1;
/// 2^52, whose bits count whole numbers.
const WHOLE_VALUE: f64 = 4_503_599_627_370_496.0;
const WHOLE: u64 = WHOLE_VALUE.to_bits();

/// Arithmetic that a formula may use.
pub trait Lane:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    type Mask: Copy;
    /// Whether numbers carry derivatives, see `Dual`.
    const DERIVED: bool = false;

    /// The number without its derivatives.
    #[inline(always)]
    fn frozen(self) -> Self {
        self
    }

    /// The same number in every lane, as many lanes as `self` has.
    fn splat(self, value: f64) -> Self;
    /// `self * a + b`, rounded once.
    fn mul_add(self, a: Self, b: Self) -> Self;
    fn sqrt(self) -> Self;
    /// `sqrt` for arguments in [1e-290, 1e290] or NaN: correctly rounded, as
    /// `sqrt` is, but faster where the divider is the bottleneck.
    fn root(self) -> Self;
    fn abs(self) -> Self;
    fn floor(self) -> Self;
    fn round(self) -> Self;
    /// `2^self` for whole numbers in [-1022, 1023].
    fn exp2_whole(self) -> Self;
    /// m in [0.7071, 1.4142] and a whole k with `self` = m 2^k, for positive
    /// normal numbers.
    fn split(self) -> (Self, Self);

    /// The smaller one; `other` or NaN where one is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger one; `other` or NaN where one is NaN.
    fn max(self, other: Self) -> Self;

    fn lt(self, other: Self) -> Self::Mask;
    fn le(self, other: Self) -> Self::Mask;
    fn not_nan(self) -> Self::Mask;
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn not(mask: Self::Mask) -> Self::Mask;
    fn any(mask: Self::Mask) -> bool;
    /// `a` where the mask holds, `b` elsewhere. Never computes with the lane
    /// that it does not take, so a NaN there does no harm.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;

    /// Applies a scalar function lane by lane.
    fn map(self, f: impl FnMut(f64) -> f64) -> Self;
    /// Lane `i`.
    fn lane(self, i: usize) -> f64;
    /// Builds lanes from their numbers; `self` only says how many there are.
    fn fill(self, f: impl FnMut(usize) -> f64) -> Self;

    /// Runs `f` in a function of its own, compiled for the same instructions.
    /// For large and rare parts, which would otherwise be copied into every
    /// kernel that might need them.
    fn outlined<R>(self, f: impl FnOnce() -> R) -> R;

    /// The same for parts that vectors are faster without: only plain numbers, whose
    /// kernels would grow several times over, call them.
    #[inline(always)]
    fn shared<R>(self, f: impl FnOnce() -> R) -> R {
        f()
    }

    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// 1, -1 or, at zero, 0.
    #[inline(always)]
    fn sign(self) -> Self {
        let zero = self.splat(0.0);
        let negative = Self::select(self.lt(zero), self.splat(-1.0), zero);
        Self::select(zero.lt(self), self.splat(1.0), negative)
    }
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        self.abs().lt(self.splat(f64::INFINITY))
    }
    /// Within `-limit` and `limit`.
    #[inline(always)]
    fn clip(self, limit: Self) -> Self {
        self.min(limit).max(-limit)
    }
    /// `self` where the mask holds, NaN elsewhere.
    #[inline(always)]
    fn only_if(self, mask: Self::Mask) -> Self {
        Self::select(mask, self, self.splat(f64::NAN))
    }
}

impl Lane for f64 {
    type Mask = bool;

    #[inline(always)]
    fn splat(self, value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn mul_add(self, a: f64, b: f64) -> f64 {
        f64::mul_add(self, a, b)
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn root(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn floor(self) -> f64 {
        libm::floor(self)
    }
    #[inline(always)]
    fn round(self) -> f64 {
        libm::rint(self)
    }
    #[inline(always)]
    fn exp2_whole(self) -> f64 {
        f64::from_bits(((self as i64 + 1023) as u64) << 52)
    }
    #[inline(always)]
    fn split(self) -> (f64, f64) {
        let shifted = self.to_bits().wrapping_add(SPLIT_OFFSET);
        let m = f64::from_bits((shifted & MANTISSA) + SQRT_HALF);
        // The exponent as the low bits of 2^52.
        (m, f64::from_bits((shifted >> 52) | WHOLE) - (WHOLE_VALUE + 1023.0))
    }
    #[inline(always)]
    fn min(self, other: f64) -> f64 {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: f64) -> f64 {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: f64) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: f64) -> bool {
        self <= other
    }
    #[inline(always)]
    fn not_nan(self) -> bool {
        !self.is_nan()
    }
    #[inline(always)]
    fn and(a: bool, b: bool) -> bool {
        a & b
    }
    #[inline(always)]
    fn or(a: bool, b: bool) -> bool {
        a | b
    }
    #[inline(always)]
    fn not(mask: bool) -> bool {
        !mask
    }
    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }
    #[inline(always)]
    fn select(mask: bool, a: f64, b: f64) -> f64 {
        if mask { a } else { b }
    }
    #[inline(always)]
    fn map(self, mut f: impl FnMut(f64) -> f64) -> f64 {
        f(self)
    }
    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self
    }
    #[inline(always)]
    fn fill(self, mut f: impl FnMut(usize) -> f64) -> f64 {
        f(0)
    }
    #[inline(always)]
    fn outlined<R>(self, f: impl FnOnce() -> R) -> R {
        #[inline(never)]
        fn called<R>(f: impl FnOnce() -> R) -> R {
            f()
        }
        called(f)
    }
    #[inline(always)]
    fn shared<R>(self, f: impl FnOnce() -> R) -> R {
        self.outlined(f)
    }
}
