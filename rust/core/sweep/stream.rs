//! Results on their way to memory: past the caches where they would only evict
//! what the kernels need (half the traffic of a normal store, which first reads
//! the line it overwrites). The only unsafe code of the crate.
#![allow(unsafe_code)]

/// Copies `from` to `to`, both of the same length, without caching it.
#[cfg(target_arch = "x86_64")]
pub fn copy_past_caches(to: &mut [f64], from: &[f64]) {
    use core::arch::x86_64::{_mm_loadu_pd, _mm_sfence, _mm_stream_pd};
    assert_eq!(to.len(), from.len());
    let head = to.as_ptr().align_offset(16).min(to.len());
    to[..head].copy_from_slice(&from[..head]);
    let (to, from) = (&mut to[head..], &from[head..]);
    let pairs = to.len() / 2;
    for i in 0..pairs {
        // SAFETY: 2 i + 1 is below the length of both slices, `to` was aligned
        // to 16 bytes above, and SSE2 is part of every x86-64 processor.
        unsafe {
            let pair = _mm_loadu_pd(from.as_ptr().add(2 * i));
            _mm_stream_pd(to.as_mut_ptr().add(2 * i), pair);
        }
    }
    to[2 * pairs..].copy_from_slice(&from[2 * pairs..]);
    // Streamed stores are not ordered with later ones: without the fence the
    // thread that is told of the finished chunk could read old memory.
    // SAFETY: no operands; part of every x86-64 processor.
    unsafe { _mm_sfence() };
}

#[cfg(not(target_arch = "x86_64"))]
pub fn copy_past_caches(to: &mut [f64], from: &[f64]) {
    to.copy_from_slice(from);
}

#[cfg(test)]
mod tests {
    use super::copy_past_caches;

    #[test]
    fn copies_every_length_and_alignment() {
        let from: Vec<f64> = (0..70).map(f64::from).collect();
        for start in 0..4 {
            for len in 0..60 {
                let mut to = vec![-1.0; 70];
                copy_past_caches(&mut to[start..start + len], &from[..len]);
                assert_eq!(&to[start..start + len], &from[..len]);
                assert!(to[..start].iter().chain(&to[start + len..]).all(|v| *v == -1.0));
            }
        }
    }
}
