//! One gas that several processes hold: who holds which tiles, and what they tell each other.
//!
//! The box is cut into blocks of tiles, one for each process ([`owners`]). A tile is treated by its owner as if there were nobody
//! else; what leaves it for a tile of another process goes there after the flight. Random streams are addressed by step and
//! cell, the order within cells is that of the cells they came from, and sums do not depend on the order of
//! adding. So a gas has the same bytes for any number of processes, one included.
//!
//! In each step a process sends ([`flights`]): what crosses its borders, to its neighbours; and to all the stock
//! that the next step follows, what was counted, and who flew farther than to the next tile. What it sends where
//! partners are sought across cells is in [`partners`].

mod bytes;
mod distribution;
mod flights;
mod owners;
mod partners;
mod ranks;
mod shards;
mod subdomain;
#[cfg(test)]
mod tests;

pub(crate) use bytes::{read, write};
pub use ranks::{Ranks, all_gather as gather_from_all, broadcast as from_first};
pub(crate) use ranks::{all_gather, all_reduce, broadcast, reduce};
pub use shards::{Beside, shard_name};
pub(crate) use shards::{Shard, read_all};
pub(crate) use subdomain::Subdomain;
