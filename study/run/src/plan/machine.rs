//! Threads and memory that the machine offers.

use std::thread;

pub use stosszahl_model::memory::available as available_memory;

/// Returns the number of threads of the current pool for each of `parts` parallel tasks, at least
/// 1.
pub fn threads_each(parts: usize) -> usize {
    (rayon::current_num_threads() / parts.max(1)).max(1)
}

/// Returns the number of threads that the operating system offers.
pub fn available_threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}
