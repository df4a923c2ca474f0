//! Support for several test programs.

pub mod damage;
pub mod draws;
pub mod part;
pub mod program;
