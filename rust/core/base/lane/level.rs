//! Which instructions to use, found at run time; `LOCOSWEEP_SIMD` forces a
//! lower level.

use super::wide::{Pack, Pack1, Pack2, Pack4};
use crate::error::{Error, Result};
use fearless_simd::Simd;
use std::sync::OnceLock;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Plain numbers on x86-64, where vectors have no fused multiply-add; NEON on arm64.
    Baseline,
    Avx2,
    Avx512,
}

impl Level {
    pub fn name(self) -> &'static str {
        match self {
            Level::Baseline => "baseline",
            Level::Avx2 => "avx2",
            Level::Avx512 => "avx512",
        }
    }

    /// Every level that this machine runs, lowest first.
    pub fn available() -> Vec<Level> {
        let mut levels = vec![Level::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            let found = fearless_simd::Level::new();
            if found.as_avx2().is_some() {
                levels.push(Level::Avx2);
            }
            if found.as_avx512().is_some() {
                levels.push(Level::Avx512);
            }
        }
        levels
    }

    pub fn parse(name: &str) -> Result<Level> {
        let available = Level::available();
        available.iter().copied().find(|level| level.name() == name).ok_or_else(|| {
            Error::BadOption {
                name: "LOCOSWEEP_SIMD",
                given: format!("'{name}'"),
                allowed: available.iter().map(|l| l.name()).collect::<Vec<_>>().join(", "),
            }
        })
    }

    /// The level in use: the highest of the machine, or what `LOCOSWEEP_SIMD`
    /// asked for when the process first looked.
    pub fn current() -> Result<Level> {
        static CHOSEN: OnceLock<Result<Level>> = OnceLock::new();
        CHOSEN
            .get_or_init(|| match std::env::var("LOCOSWEEP_SIMD") {
                Ok(name) if !name.is_empty() => Level::parse(&name),
                _ => Ok(*Level::available().last().unwrap_or(&Level::Baseline)),
            })
            .clone()
    }
}

/// Work to be compiled once per level.
pub trait Task {
    type Output;
    /// Packs per register file: 4 vectors in flight where the loop carries a
    /// dependence (a running best), 2 where points are independent.
    const CHAINED: bool = false;
    /// Packs of eight lanes at every level that has vectors: more of them would wait for one
    /// another at events for longer than they save.
    const EIGHT_LANES: bool = false;
    /// AVX2 will do above it: a kernel this large costs more to build than it saves.
    const AVX2_AT_MOST: bool = false;
    fn run<P: Pack>(self, token: P::Token) -> Self::Output;
}

/// What plain numbers are packs of, at every level: they are fused everywhere.
pub fn scalar_token() -> <f64 as Pack>::Token {
    let found = fearless_simd::Level::new();
    #[cfg(target_arch = "x86_64")]
    match found.as_sse2() {
        Some(simd) => simd,
        None => unreachable!("every x86-64 processor has SSE2"),
    }
    #[cfg(target_arch = "aarch64")]
    match found {
        fearless_simd::Level::Neon(simd) => simd,
        _ => unreachable!("every arm64 processor has NEON"),
    }
}

/// Runs `task` with the widest pack that pays at `level`.
///
/// AVX-512 has 32 registers of eight numbers, so up to four vectors fit; AVX2
/// has half as many of half the width, where more than one pack spills.
pub fn run<T: Task>(level: Level, task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    {
        let found = fearless_simd::Level::new();
        let level = if T::AVX2_AT_MOST && level == Level::Avx512 { Level::Avx2 } else { level };
        match level {
            Level::Avx512 if !T::AVX2_AT_MOST => {
                if let Some(simd) = found.as_avx512() {
                    return simd.vectorize(
                        #[inline(always)]
                        || {
                            if T::EIGHT_LANES {
                                task.run::<Pack1<_>>(simd)
                            } else if T::CHAINED {
                                task.run::<Pack4<_>>(simd)
                            } else {
                                task.run::<Pack2<_>>(simd)
                            }
                        },
                    );
                }
            }
            Level::Avx2 => {
                if let Some(simd) = found.as_avx2() {
                    return simd.vectorize(
                        #[inline(always)]
                        || task.run::<Pack1<_>>(simd),
                    );
                }
            }
            Level::Avx512 | Level::Baseline => {}
        }
        task.run::<f64>(scalar_token())
    }
    #[cfg(target_arch = "aarch64")]
    {
        let _ = level;
        match fearless_simd::Level::new() {
            fearless_simd::Level::Neon(simd) => simd.vectorize(
                #[inline(always)]
                || {
                    if T::EIGHT_LANES {
                        task.run::<Pack1<_>>(simd)
                    } else {
                        task.run::<Pack2<_>>(simd)
                    }
                },
            ),
            _ => unreachable!("every arm64 processor has NEON"),
        }
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    {
        compile_error!("locosweep supports x86-64 and arm64");
    }
}
