//! What several tests need.

pub mod damage;
pub mod draws;
pub mod part;
pub mod program;
