//! Work that can be broken off.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Trials between two looks at the flag, within a cell.
const TRIALS: u64 = 1024;

/// A flag that ends work early, if there is one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stop {
    flag: Option<Arc<AtomicBool>>,
    has_ended: bool,
}

impl Stop {
    /// Ends work as soon as the flag is true.
    pub(crate) fn on(&mut self, flag: Arc<AtomicBool>) {
        self.flag = Some(flag);
    }

    /// Whether to end now.
    #[inline]
    pub(crate) fn is_set(&self) -> bool {
        let flag = self.flag.as_ref();
        flag.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Whether work has ended early; if the flag is up now, it has from now on.
    pub(crate) fn ends(&mut self) -> bool {
        self.has_ended |= self.is_set();
        self.has_ended
    }

    /// Whether work has ended early.
    pub(crate) fn has_ended(&self) -> bool {
        self.has_ended
    }

    /// Whether to end before the trial with this number.
    #[inline]
    pub(crate) fn is_set_at(&self, trial: u64) -> bool {
        trial % TRIALS == TRIALS - 1 && self.is_set()
    }
}
