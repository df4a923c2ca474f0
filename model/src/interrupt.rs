//! Interrupts: flags by which other threads ask long work to end early or to pause.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Number of pieces of work between two checks of the interrupt, where one piece takes some
/// nanoseconds.
const BETWEEN_LOOKS: u64 = 1024;

/// Flag that asks long work to end early. Clones share the same flag.
///
/// Work checks it several times a second, and leaves nothing behind that could be taken for a
/// result.
///
/// ```
/// use stosszahl_model::Interrupt;
///
/// let interrupt = Interrupt::default();
/// let other = interrupt.clone();
/// assert!(!interrupt.is_raised());
/// other.raise();
/// assert!(interrupt.is_raised());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    raised: AtomicBool,
    holds: AtomicUsize,
}

impl Interrupt {
    /// Raises the interrupt: asks work to end, for good.
    pub fn raise(&self) {
        self.0.raised.store(true, Ordering::Relaxed);
    }

    /// Returns true if the interrupt was raised, so that work should end.
    #[inline]
    pub fn is_raised(&self) -> bool {
        self.0.raised.load(Ordering::Relaxed)
    }

    /// Returns true if the interrupt was raised; checks only at every thousandth piece of work, by
    /// its `number`.
    #[inline]
    pub fn is_raised_at(&self, number: u64) -> bool {
        number % BETWEEN_LOOKS == BETWEEN_LOOKS - 1 && self.is_raised()
    }

    /// Marks that data are being saved, until the returned guard is dropped.
    #[must_use]
    pub fn hold(&self) -> Hold<'_> {
        self.0.holds.fetch_add(1, Ordering::SeqCst);
        Hold(self)
    }

    /// Returns true if data are being saved, so that the process should not be ended now.
    pub fn is_held(&self) -> bool {
        self.0.holds.load(Ordering::SeqCst) > 0
    }
}

/// Guard that marks a save in progress while it lives; created by [`Interrupt::hold`].
#[derive(Debug)]
pub struct Hold<'a>(&'a Interrupt);

impl Drop for Hold<'_> {
    fn drop(&mut self) {
        self.0.0.holds.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Interrupt and pause flag of an engine, with the state whether work has ended because of the
/// interrupt.
#[derive(Clone, Debug, Default)]
pub struct Interruption {
    interrupt: Interrupt,
    pause: Interrupt,
    has_ended: bool,
}

impl Interruption {
    /// Sets the interrupt that ends the engine's work.
    pub fn on(&mut self, interrupt: &Interrupt) {
        self.interrupt = interrupt.clone();
    }

    /// Sets the flag that asks for a pause, after which the engine's work can resume.
    pub fn set_pause_flag(&mut self, pause: &Interrupt) {
        self.pause = pause.clone();
    }

    /// Returns true if a pause is requested.
    pub fn is_paused(&self) -> bool {
        self.pause.is_raised()
    }

    /// Returns the interrupt that the engine's work checks.
    pub fn interrupt(&self) -> &Interrupt {
        &self.interrupt
    }

    /// Checks the interrupt: returns true if it is raised or work has ended before, and remembers
    /// that work has ended.
    #[inline]
    pub fn ends(&mut self) -> bool {
        self.has_ended |= self.interrupt.is_raised();
        self.has_ended
    }

    /// Returns true if work has ended early because of the interrupt.
    pub fn has_ended(&self) -> bool {
        self.has_ended
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_held_as_long_as_somebody_saves() {
        let interrupt = Interrupt::default();
        let first = interrupt.hold();
        let second = interrupt.hold();
        drop(first);
        assert!(interrupt.is_held());
        drop(second);
        assert!(!interrupt.is_held());
    }

    #[test]
    fn one_piece_of_work_in_a_thousand_looks() {
        let interrupt = Interrupt::default();
        interrupt.raise();
        let looks = (0..10 * BETWEEN_LOOKS).filter(|&number| interrupt.is_raised_at(number));
        assert_eq!(looks.count(), 10);
    }
}
