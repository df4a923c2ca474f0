//! Pools of working memory for threads, and the choice between one thread and several.

use std::sync::{Mutex, PoisonError};

/// Pool of working memory of a type, lent to one thread at a time; its contents do not outlive the
/// loan.
pub(crate) struct Pool<T>(Mutex<Vec<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Default> Pool<T> {
    /// Calls `work` with working memory from the pool, and returns its result.
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        let pool = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = pool().pop().unwrap_or_default();
        let result = work(&mut scratch);
        pool().push(scratch);
        result
    }

    /// Returns the sum of `size` over all working memory in the pool \[bytes\].
    pub(crate) fn lent_bytes(&self, size: impl Fn(&T) -> usize) -> usize {
        let pool = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        pool.iter().map(size).sum()
    }
}

/// Least number of simulators for which several threads are used.
const WORTH_THREADS: usize = 20_000;

/// Returns true if a sweep over this number of simulators uses several threads.
pub(crate) fn is_parallel(simulators: usize) -> bool {
    simulators >= WORTH_THREADS && rayon::current_num_threads() > 1
}
