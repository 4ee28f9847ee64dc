//! Results on their way to memory, past the caches: a normal store first reads
//! the line that it overwrites, which doubles the traffic of a kernel that only
//! writes. The only unsafe code of the crate.
#![allow(unsafe_code)]

use fearless_simd::{Simd, f64x8};

/// Bytes of a cache line.
const LINE: usize = 64;

/// Numbers before the first one that begins a cache line.
pub fn cells_to_line(to: &[f64]) -> usize {
    to.as_ptr().align_offset(LINE)
}

/// Stores eight numbers to `to`: past the caches where `to` begins a cache line.
#[inline(always)]
pub fn line<S: Simd>(value: f64x8<S>, to: &mut [f64]) {
    let to: &mut [f64; 8] = to.first_chunk_mut().expect("a pack is stored whole");
    if to.as_ptr().align_offset(LINE) != 0 {
        *to = value.into();
        return;
    }
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{
            _mm256_loadu_pd, _mm256_stream_pd, _mm512_loadu_pd, _mm512_stream_pd,
        };
        use fearless_simd::Level;
        let lanes: [f64; 8] = value.into();
        let (from, to) = (lanes.as_ptr(), to.as_mut_ptr());
        // SAFETY: both arrays hold eight numbers, `to` begins a cache line, and
        // the level is proof that the processor has the instructions.
        unsafe {
            match value.simd.level() {
                Level::Avx512(_) => _mm512_stream_pd(to, _mm512_loadu_pd(from)),
                Level::Avx2(_) => {
                    for k in [0, 4] {
                        _mm256_stream_pd(to.add(k), _mm256_loadu_pd(from.add(k)));
                    }
                }
                _ => unreachable!("packs have one of the two levels"),
            }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        *to = value.into();
    }
}

/// Orders streamed stores before what this thread does next: without it, a
/// thread that is told of finished cells could read old memory.
pub fn fence() {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: no operands; part of every x86-64 processor.
    unsafe {
        core::arch::x86_64::_mm_sfence();
    }
}
