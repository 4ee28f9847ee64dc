//! Packs of 8, 16 and 32 lanes over the vectors of `fearless_simd`.
//!
//! More than one vector per pack hides the latency of an operation behind its
//! neighbours; how many pay depends on the number of registers (see `level`).

use super::{Lane, MANTISSA, SPLIT_OFFSET, SQRT_HALF, WHOLE, WHOLE_VALUE, root, stream};
use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, SimdMask, f64x8, u64x8};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A [`Lane`] that can be loaded from and stored to memory.
pub trait Pack: Lane + 'static {
    type Token: Simd;
    const LANES: usize;
    fn broadcast(token: Self::Token, value: f64) -> Self;
    /// Loads from the first `LANES` numbers of `from`.
    fn load(token: Self::Token, from: &[f64]) -> Self;
    /// Stores to the first `LANES` numbers of `to`.
    fn store(self, to: &mut [f64]);
    /// As `store`, past the caches where `to` begins a cache line. Other threads
    /// may read only after `stream::fence`.
    fn stream(self, to: &mut [f64]);
}

/// A pack of one, for kernels that are not worth vectors (see `Task`).
impl Pack for f64 {
    #[cfg(target_arch = "x86_64")]
    type Token = fearless_simd::x86::Sse2;
    #[cfg(target_arch = "aarch64")]
    type Token = fearless_simd::aarch64::Neon;
    const LANES: usize = 1;
    #[inline(always)]
    fn broadcast(_: Self::Token, value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn load(_: Self::Token, from: &[f64]) -> f64 {
        from[0]
    }
    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        to[0] = self;
    }
    #[inline(always)]
    fn stream(self, to: &mut [f64]) {
        to[0] = self;
    }
}

macro_rules! pack {
    ($name:ident, $vectors:literal, $($i:tt => $root:ident),+) => {
        #[derive(Clone, Copy)]
        pub struct $name<S: Simd>([f64x8<S>; $vectors]);

        impl<S: Simd> Pack for $name<S> {
            type Token = S;
            const LANES: usize = 8 * $vectors;
            #[inline(always)]
            fn broadcast(token: S, value: f64) -> Self {
                Self([f64x8::splat(token, value); $vectors])
            }
            #[inline(always)]
            fn load(token: S, from: &[f64]) -> Self {
                let from = &from[..Self::LANES];
                Self([$(f64x8::from_slice(token, &from[8 * $i..8 * $i + 8])),+])
            }
            #[inline(always)]
            fn store(self, to: &mut [f64]) {
                let to = &mut to[..Self::LANES];
                $(self.0[$i].store_slice(&mut to[8 * $i..8 * $i + 8]);)+
            }
            #[inline(always)]
            fn stream(self, to: &mut [f64]) {
                let to = &mut to[..Self::LANES];
                $(stream::line(self.0[$i], &mut to[8 * $i..8 * $i + 8]);)+
            }
        }

        impl<S: Simd> Lane for $name<S> {
            type Mask = [fearless_simd::mask64x8<S>; $vectors];

            #[inline(always)]
            fn splat(self, value: f64) -> Self {
                Self([f64x8::splat(self.0[0].simd, value); $vectors])
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                Self([$(self.0[$i].mul_add(a.0[$i], b.0[$i])),+])
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self([$(self.0[$i].sqrt()),+])
            }
            #[inline(always)]
            fn root(self) -> Self {
                Self([$(root::$root(self.0[$i])),+])
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self([$(self.0[$i].abs()),+])
            }
            #[inline(always)]
            fn floor(self) -> Self {
                Self([$(self.0[$i].floor()),+])
            }
            #[inline(always)]
            fn round(self) -> Self {
                Self([$(self.0[$i].round_ties_even()),+])
            }
            #[inline(always)]
            fn exp2_whole(self) -> Self {
                Self([$(exp2_whole(self.0[$i])),+])
            }
            #[inline(always)]
            fn split(self) -> (Self, Self) {
                let parts = [$(split(self.0[$i])),+];
                (Self([$(parts[$i].0),+]), Self([$(parts[$i].1),+]))
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self([$(self.0[$i].min(other.0[$i])),+])
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self([$(self.0[$i].max(other.0[$i])),+])
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                [$(self.0[$i].simd_lt(other.0[$i])),+]
            }
            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                [$(self.0[$i].simd_le(other.0[$i])),+]
            }
            #[inline(always)]
            fn not_nan(self) -> Self::Mask {
                [$(self.0[$i].simd_eq(self.0[$i])),+]
            }
            #[inline(always)]
            fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
                [$(a[$i] & b[$i]),+]
            }
            #[inline(always)]
            fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask {
                [$(a[$i] | b[$i]),+]
            }
            #[inline(always)]
            fn not(mask: Self::Mask) -> Self::Mask {
                [$(!mask[$i]),+]
            }
            #[inline(always)]
            fn any(mask: Self::Mask) -> bool {
                false $(| mask[$i].any_true())+
            }
            #[inline(always)]
            fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
                Self([$(mask[$i].select(a.0[$i], b.0[$i])),+])
            }
            #[inline(always)]
            fn map(self, mut f: impl FnMut(f64) -> f64) -> Self {
                self.fill(|i| f(self.lane(i)))
            }
            #[inline(always)]
            fn lane(self, i: usize) -> f64 {
                self.0[i / 8][i % 8]
            }
            #[inline(always)]
            fn fill(self, mut f: impl FnMut(usize) -> f64) -> Self {
                let mut lanes = [0.0; 8 * $vectors];
                for (i, lane) in lanes.iter_mut().enumerate() {
                    *lane = f(i);
                }
                Self::load(self.0[0].simd, &lanes)
            }
            #[inline(always)]
            fn outlined<R>(self, f: impl FnOnce() -> R) -> R {
                self.0[0].simd.vectorize(f)
            }
        }

        pack!(@op $name, Add, add, $($i),+);
        pack!(@op $name, Sub, sub, $($i),+);
        pack!(@op $name, Mul, mul, $($i),+);
        pack!(@op $name, Div, div, $($i),+);
        pack!(@scalar $name, Add, add);
        pack!(@scalar $name, Sub, sub);
        pack!(@scalar $name, Mul, mul);

        impl<S: Simd> Neg for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self([$(-self.0[$i]),+])
            }
        }
    };
    (@op $name:ident, $op:ident, $method:ident, $($i:tt),+) => {
        impl<S: Simd> $op for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self([$(self.0[$i].$method(other.0[$i])),+])
            }
        }
    };
    (@scalar $name:ident, $op:ident, $method:ident) => {
        impl<S: Simd> $op<f64> for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                self.$method(self.splat(other))
            }
        }
    };
}

// Every second square root goes to the multiply-add units, so that those and
// the divider work at the same time.
pack!(Pack1, 1, 0 => divider);
pack!(Pack2, 2, 0 => divider, 1 => multiplier);
pack!(Pack4, 4, 0 => divider, 1 => multiplier, 2 => divider, 3 => multiplier);

#[inline(always)]
fn exp2_whole<S: Simd>(x: f64x8<S>) -> f64x8<S> {
    // Adding 1.5 * 2^52 leaves the whole number in the low bits of the sum.
    let shifted: u64x8<S> = (x + (6_755_399_441_055_744.0 + 1023.0)).bitcast();
    let simd = x.simd;
    simd.shl_u64x8(shifted, 52).bitcast()
}

#[inline(always)]
fn split<S: Simd>(x: f64x8<S>) -> (f64x8<S>, f64x8<S>) {
    let simd = x.simd;
    let number = |bits| u64x8::splat(simd, bits);
    let bits: u64x8<S> = x.bitcast();
    let shifted = bits + number(SPLIT_OFFSET);
    let m: f64x8<S> = ((shifted & number(MANTISSA)) + number(SQRT_HALF)).bitcast();
    let k: f64x8<S> = (simd.shr_u64x8(shifted, 52) | number(WHOLE)).bitcast();
    (m, k - (WHOLE_VALUE + 1023.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::{Level, Task, run};

    struct PowersOfTwo;
    impl Task for PowersOfTwo {
        type Output = ();
        fn run<P: Pack>(self, token: P::Token) {
            for k in [-1022, -1, 0, 1, 52, 1023] {
                let wide = P::broadcast(token, f64::from(k)).exp2_whole();
                assert_eq!(wide.lane(P::LANES - 1), libm::exp2(f64::from(k)));
            }
        }
    }

    #[test]
    fn exp2_whole_is_exact_at_every_level() {
        for level in Level::available() {
            run(level, PowersOfTwo);
        }
    }
}
