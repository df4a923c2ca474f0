//! Case files, good and bad ones.

mod bundled;
mod refusals;
