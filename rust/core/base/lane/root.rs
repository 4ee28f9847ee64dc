//! Square roots by two routes with the same, correctly rounded, result.
//!
//! A 512-bit hardware square root keeps the divider busy for about 18 cycles;
//! the multiply-add units could finish one in a third of that. `multiplier`
//! uses them: a 14-bit estimate, two coupled Newton steps for the root g and
//! its half reciprocal h, and one correction from the exact residual x - g*g.
//! Why that rounds correctly: before the correction g is within one unit in
//! the last place, so the residual is exact and the error of g + h*d is below
//! 2^-51 units; only roots closer than that to a midpoint of two doubles could
//! go wrong, those are the few solutions of M^2 = -delta (mod 2^54) for small
//! delta, and the test below runs through all of them.

#[cfg(target_arch = "x86_64")]
use fearless_simd::Avx512;
use fearless_simd::{Simd, SimdFloat, f64x8};

#[inline(always)]
pub fn divider<S: Simd>(x: f64x8<S>) -> f64x8<S> {
    x.sqrt()
}

#[inline(always)]
pub fn multiplier<S: Simd>(x: f64x8<S>) -> f64x8<S> {
    #[cfg(target_arch = "x86_64")]
    if let fearless_simd::Level::Avx512(token) = x.simd.level() {
        use fearless_simd::SimdFrom;
        let lanes: [f64; 8] = x.into();
        let root: [f64; 8] = by_multiply_add(token, f64x8::simd_from(token, lanes)).into();
        return f64x8::simd_from(x.simd, root);
    }
    x.sqrt()
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    #[inline(always)]
    fn by_multiply_add(token: Avx512, x: f64x8<Avx512>) -> f64x8<Avx512> {
        use core::arch::x86_64::*;
        use fearless_simd::SimdInto;
        let x: __m512d = x.into();
        let half = _mm512_set1_pd(0.5);
        let estimate = _mm512_rsqrt14_pd(x);
        let (g, h) = (_mm512_mul_pd(x, estimate), _mm512_mul_pd(half, estimate));
        let r = _mm512_fnmadd_pd(g, h, half);
        let (g, h) = (_mm512_fmadd_pd(g, r, g), _mm512_fmadd_pd(h, r, h));
        let r = _mm512_fnmadd_pd(g, h, half);
        let (g, h) = (_mm512_fmadd_pd(g, r, g), _mm512_fmadd_pd(h, r, h));
        let residual = _mm512_fnmadd_pd(g, g, x);
        _mm512_fmadd_pd(h, residual, g).simd_into(token)
    }
);

#[cfg(test)]
mod tests {
    use crate::lane::{Level, Pack, Task, run};

    /// Odd 54-bit M with M^2 = -delta (mod 2^bits): the midpoints of two
    /// doubles whose squares lie closest to a double.
    fn nearest_midpoints(delta: i128, bits: u32) -> Vec<u128> {
        let target = |modulus: u128| (-delta).rem_euclid(modulus as i128) as u128;
        let mut roots: Vec<u128> = vec![1, 3, 5, 7];
        roots.retain(|m| (m * m) % 8 == target(8));
        for b in 4..=bits {
            let modulus = 1u128 << b;
            let half = modulus >> 1;
            let mut next: Vec<u128> =
                roots.iter().flat_map(|&m| [m, m + half / 2, m + half]).collect();
            next.iter_mut().for_each(|m| *m %= modulus);
            next.retain(|m| (m * m) % modulus == target(modulus));
            next.sort_unstable();
            next.dedup();
            roots = next;
        }
        let span = 1u128 << bits;
        let (low, high) = (1u128 << 53, 1u128 << 54);
        let mut all = Vec::new();
        for m in roots {
            let mut k = m;
            while k < high {
                if k >= low {
                    all.push(k);
                }
                k += span;
            }
        }
        all
    }

    fn hard_cases() -> Vec<f64> {
        let mut cases = Vec::new();
        for delta in -4097i128..=4097 {
            for bits in [54u32, 55] {
                for m in nearest_midpoints(delta, bits) {
                    let square = (m * m) as i128 + delta;
                    let x = square as f64;
                    if x as i128 == square {
                        cases.extend([x, x * 0.25, x * 2f64.powi(-108), x * 2f64.powi(400)]);
                    }
                }
            }
        }
        cases
    }

    struct SameAsHardware<'a>(&'a [f64]);
    impl Task for SameAsHardware<'_> {
        type Output = ();
        fn run<P: Pack>(self, token: P::Token) {
            for chunk in self.0.chunks_exact(P::LANES) {
                let wide = P::load(token, chunk).root();
                for (i, x) in chunk.iter().enumerate() {
                    assert_eq!(wide.lane(i).to_bits(), x.sqrt().to_bits(), "sqrt({x:e})");
                }
            }
        }
    }

    #[test]
    fn both_routes_round_correctly() {
        let mut cases = hard_cases();
        assert!(cases.len() > 5_000, "only {} hard cases", cases.len());
        let mut state = 1u64;
        for _ in 0..2_000_000 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let mantissa = 1.0 + (state >> 12) as f64 / (1u64 << 52) as f64;
            cases.push(mantissa * 2f64.powi((state % 1900) as i32 - 950));
        }
        for level in Level::available() {
            // Shifted by one vector, so that each case meets each route.
            run(level, SameAsHardware(&cases));
            run(level, SameAsHardware(&cases[8..]));
        }
    }
}
