//! Distribution of work among threads, and pools of working memory.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// Pool of working memory, lent to one thread at a time; its contents do not outlive the loan.
pub(crate) struct Pool<T>(Mutex<Vec<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Default> Pool<T> {
    /// Runs the work with working memory from the pool.
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        let pool = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = pool().pop().unwrap_or_default();
        let result = work(&mut scratch);
        pool().push(scratch);
        result
    }

    /// Sum of a size over all memory lent so far.
    pub(crate) fn bytes(&self, size: impl Fn(&T) -> usize) -> usize {
        let pool = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        pool.iter().map(size).sum()
    }
}

/// Smallest number of simulators for which several threads are used.
const WORTH_THREADS: usize = 20_000;

/// Returns true if a sweep over this number of simulators uses several threads.
pub(crate) fn is_parallel(simulators: usize) -> bool {
    simulators >= WORTH_THREADS && rayon::current_num_threads() > 1
}

/// Runs a piece of work for each item, in one thread or several, and returns the results in order.
///
/// Threads share item numbers, and the work is behind a pointer, so the thread-pool code is
/// compiled once, not for each engine and each kind of work. An item should be worth some thousand
/// simulators.
pub(crate) fn each_of<T: Send, R: Send>(
    parallel: bool,
    items: impl Iterator<Item = T>,
    work: impl Fn(usize, T) -> R + Sync,
) -> Vec<R> {
    if !parallel {
        let items = items.enumerate();
        return items.map(|(number, item)| work(number, item)).collect();
    }
    let items: Vec<Mutex<(Option<T>, Option<R>)>> =
        items.map(|item| Mutex::new((Some(item), None))).collect();
    each_number(items.len(), &|number| {
        // The lock is always free: each number occurs once.
        let mut slot = items[number].lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(item) = slot.0.take() {
            slot.1 = Some(work(number, item));
        }
    });
    let results = items.into_iter();
    results
        .filter_map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner).1)
        .collect()
}

fn each_number(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(work);
}
