//! Thread pools of our own, never the global one: sized per call, and made anew
//! in a forked child, whose inherited threads do not exist.

use crate::error::{Error, Result};
use rayon::ThreadPool;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock};
use std::thread::available_parallelism;

/// Threads to use: as asked, or `LOCOSWEEP_NUM_THREADS`, or what the batch
/// system granted, or the processors this process may run on.
pub fn threads_to_use(asked: Option<usize>) -> Result<usize> {
    const MOST: usize = 4096;
    // Asking reads several files: too slow for a sweep of one point.
    static PROCESSORS: OnceLock<usize> = OnceLock::new();
    let from = |name: &'static str| -> Result<Option<usize>> {
        match std::env::var(name) {
            Ok(text) if !text.trim().is_empty() => {
                text.trim().parse().map(Some).map_err(|_| bad(name, format!("'{text}'")))
            }
            _ => Ok(None),
        }
    };
    let (name, count) = if let Some(count) = asked {
        ("threads", count)
    } else if let Some(count) = from("LOCOSWEEP_NUM_THREADS")? {
        ("LOCOSWEEP_NUM_THREADS", count)
    } else if let Some(count) = from("SLURM_CPUS_PER_TASK")? {
        ("SLURM_CPUS_PER_TASK", count)
    } else {
        ("threads", *PROCESSORS.get_or_init(|| available_parallelism().map_or(1, |n| n.get())))
    };
    if (1..=MOST).contains(&count) { Ok(count) } else { Err(bad(name, count.to_string())) }
}

fn bad(name: &'static str, given: String) -> Error {
    Error::BadOption { name, given, allowed: "a whole number from 1 to 4096".to_owned() }
}

/// The pool of this process with that many threads.
pub fn pool(threads: usize) -> Result<Arc<ThreadPool>> {
    type Pools = HashMap<(u32, usize), Arc<ThreadPool>>;
    static POOLS: Mutex<Option<Pools>> = Mutex::new(None);
    let mut guard = POOLS.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let pools = guard.get_or_insert_with(HashMap::new);
    let key = (std::process::id(), threads);
    if let Some(pool) = pools.get(&key) {
        return Ok(pool.clone());
    }
    // A pool inherited through fork must not be dropped either: it would wait
    // for threads that never existed here.
    let inherited: Vec<_> = pools.keys().filter(|(pid, _)| *pid != key.0).copied().collect();
    for old in inherited {
        std::mem::forget(pools.remove(&old));
    }
    let built = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("locosweep-{i}"))
        .build()
        .map_err(|error| bad("threads", format!("{threads} ({error})")))?;
    let pool = Arc::new(built);
    pools.insert(key, pool.clone());
    Ok(pool)
}
