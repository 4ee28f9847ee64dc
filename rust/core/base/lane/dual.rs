//! A number and its derivatives along several directions: every formula written over lanes
//! gives its own derivative (forward mode).
//!
//! One number decides, so all directions go through the same events. What a formula reads
//! off as a plain number (`map`, `fill`, `lane`) has no derivative.

use super::{Lane, Pack};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `P` holds a direction per lane.
#[derive(Clone, Copy)]
pub struct Dual<P> {
    value: f64,
    slopes: P,
}

impl<P: Pack> Dual<P> {
    #[inline(always)]
    pub fn new(value: f64, slopes: P) -> Dual<P> {
        Dual { value, slopes }
    }

    #[inline(always)]
    pub fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    pub fn slopes(self) -> P {
        self.slopes
    }

    /// What a function of slope `factor` makes of it.
    #[inline(always)]
    fn through(self, value: f64, factor: f64) -> Dual<P> {
        Dual { value, slopes: self.slopes * factor }
    }

    #[inline(always)]
    fn plain(self, value: f64) -> Dual<P> {
        Dual { value, slopes: self.slopes.splat(0.0) }
    }
}

impl<P: Pack> Add for Dual<P> {
    type Output = Dual<P>;
    #[inline(always)]
    fn add(self, other: Dual<P>) -> Dual<P> {
        Dual { value: self.value + other.value, slopes: self.slopes + other.slopes }
    }
}

impl<P: Pack> Sub for Dual<P> {
    type Output = Dual<P>;
    #[inline(always)]
    fn sub(self, other: Dual<P>) -> Dual<P> {
        Dual { value: self.value - other.value, slopes: self.slopes - other.slopes }
    }
}

impl<P: Pack> Mul for Dual<P> {
    type Output = Dual<P>;
    #[inline(always)]
    fn mul(self, other: Dual<P>) -> Dual<P> {
        let like = self.slopes;
        let slopes = like.mul_add(like.splat(other.value), other.slopes * self.value);
        Dual { value: self.value * other.value, slopes }
    }
}

impl<P: Pack> Div for Dual<P> {
    type Output = Dual<P>;
    #[inline(always)]
    fn div(self, other: Dual<P>) -> Dual<P> {
        let value = self.value / other.value;
        let like = self.slopes;
        let slopes = other.slopes.mul_add(like.splat(-value), like) * (1.0 / other.value);
        Dual { value, slopes }
    }
}

impl<P: Pack> Neg for Dual<P> {
    type Output = Dual<P>;
    #[inline(always)]
    fn neg(self) -> Dual<P> {
        Dual { value: -self.value, slopes: -self.slopes }
    }
}

impl<P: Pack> Add<f64> for Dual<P> {
    type Output = Dual<P>;
    #[inline(always)]
    fn add(self, other: f64) -> Dual<P> {
        Dual { value: self.value + other, slopes: self.slopes }
    }
}

impl<P: Pack> Sub<f64> for Dual<P> {
    type Output = Dual<P>;
    #[inline(always)]
    fn sub(self, other: f64) -> Dual<P> {
        Dual { value: self.value - other, slopes: self.slopes }
    }
}

impl<P: Pack> Mul<f64> for Dual<P> {
    type Output = Dual<P>;
    #[inline(always)]
    fn mul(self, other: f64) -> Dual<P> {
        self.through(self.value * other, other)
    }
}

impl<P: Pack> Lane for Dual<P> {
    type Mask = bool;
    const DERIVED: bool = true;

    #[inline(always)]
    fn frozen(self) -> Self {
        self.plain(self.value)
    }
    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        self.plain(value)
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        let value = f64::mul_add(self.value, a.value, b.value);
        let like = self.slopes;
        let slopes =
            like.mul_add(like.splat(a.value), a.slopes.mul_add(like.splat(self.value), b.slopes));
        Dual { value, slopes }
    }
    /// At 0, where the slope is infinite, it is taken as 0: what stands there stays there.
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.through(root, if root > 0.0 { 0.5 / root } else { 0.0 })
    }
    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn abs(self) -> Self {
        if self.value < 0.0 { -self } else { self }
    }
    #[inline(always)]
    fn floor(self) -> Self {
        self.plain(Lane::floor(self.value))
    }
    #[inline(always)]
    fn round(self) -> Self {
        self.plain(Lane::round(self.value))
    }
    #[inline(always)]
    fn exp2_whole(self) -> Self {
        self.plain(Lane::exp2_whole(self.value))
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        let (m, k) = Lane::split(self.value);
        (self.through(m, m / self.value), self.plain(k))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self.value < other.value { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self.value > other.value { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self.value < other.value
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self.value <= other.value
    }
    #[inline(always)]
    fn not_nan(self) -> bool {
        !self.value.is_nan()
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
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
    #[inline(always)]
    fn map(self, mut f: impl FnMut(f64) -> f64) -> Self {
        self.plain(f(self.value))
    }
    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self.value
    }
    #[inline(always)]
    fn fill(self, mut f: impl FnMut(usize) -> f64) -> Self {
        self.plain(f(0))
    }
    #[inline(always)]
    fn outlined<R>(self, f: impl FnOnce() -> R) -> R {
        self.slopes.outlined(f)
    }
    #[inline(always)]
    fn shared<R>(self, f: impl FnOnce() -> R) -> R {
        self.slopes.outlined(f)
    }
}
