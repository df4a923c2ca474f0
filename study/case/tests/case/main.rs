//! Case files, good and bad ones.

mod refusals;
