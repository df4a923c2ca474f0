//! The `stosszahl` command.
fn main() {}
