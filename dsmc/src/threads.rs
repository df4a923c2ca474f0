//! Work shared among threads, and memory lent to them.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// Pool of working memory, lent to the thread that works. Nothing in it outlives the loan.
pub(crate) struct Pool<T>(Mutex<Vec<T>>);

impl<T> Default for Pool<T> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<T: Default> Pool<T> {
    /// Lends working memory.
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        let pool = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = pool().pop().unwrap_or_default();
        let result = work(&mut scratch);
        pool().push(scratch);
        result
    }

    /// Sum of a size over all that was lent so far.
    pub(crate) fn bytes(&self, size: impl Fn(&T) -> usize) -> usize {
        let pool = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        pool.iter().map(size).sum()
    }
}

/// Fewest simulators for which threads are worth waking.
const WORTH_THREADS: usize = 20_000;

/// Whether a sweep over this number of simulators is shared among the threads of the present pool.
pub(crate) fn is_parallel(simulators: usize) -> bool {
    simulators >= WORTH_THREADS && rayon::current_num_threads() > 1
}

/// Does a piece of work for each item, by one thread or all, and returns the results in the order of the items.
///
/// What is shared out are numbers, and the work is behind a pointer: so the code of the pool is compiled once, not for each
/// engine and each kind of work. An item should be worth some thousand simulators.
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
        // Always free: each number comes once.
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
