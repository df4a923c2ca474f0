//! Work that can be broken off.

use stosszahl_model::Interrupt;

/// An interrupt, and whether work has ended because of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stop {
    pub(crate) interrupt: Interrupt,
    has_ended: bool,
}

impl Stop {
    /// Ends work as soon as this is raised.
    pub(crate) fn on(&mut self, interrupt: &Interrupt) {
        self.interrupt = interrupt.clone();
    }

    /// Whether work has ended early; if the interrupt is raised now, it has from now on.
    pub(crate) fn ends(&mut self) -> bool {
        self.has_ended |= self.interrupt.is_raised();
        self.has_ended
    }

    /// Whether work has ended early.
    pub(crate) fn has_ended(&self) -> bool {
        self.has_ended
    }
}
