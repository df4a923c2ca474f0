//! Parallel loops and sorting by the threads of the current pool.
//!
//! The code of the thread pool is compiled once, not for each engine and each kind of work, which
//! is a third of the compilation of an engine otherwise.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// Calls `work` for each item, in one thread or in parallel, and returns the results in order.
///
/// Threads share the numbers of items and call the work by pointer. An item should be worth some
/// thousand particles.
///
/// ```
/// use stosszahl_model::threads::each_of;
/// let squares = each_of(true, [1, 2, 3].into_iter(), |number, item| (number, item * item));
/// assert_eq!(squares, [(0, 1), (1, 4), (2, 9)]);
/// ```
pub fn each_of<T: Send, R: Send>(
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

/// Returns how many adjacent elements to put into one item of [`each_of`], such that each thread
/// gets several items, because some take longer.
pub fn piece(elements: usize) -> usize {
    elements.div_ceil(16 * rayon::current_num_threads()).max(1)
}

/// Sorts pairs of numbers in ascending order by all threads of the pool.
pub fn sort(all: &mut [(u32, u32)]) {
    all.par_sort_unstable();
}

fn each_number(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(work);
}
