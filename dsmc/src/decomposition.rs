//! Domain decomposition: the tiles of one gas are held by several processes, which exchange
//! messages in each time step.
//!
//! The box is cut into blocks of tiles, one for each process ([`owners`]). A process treats its
//! tiles as if it were alone; particles that leave for a tile of another process migrate after the
//! flight. Random streams are addressed by step and cell, the order within cells is that of the
//! source cells, and sums do not depend on the order of adding. So results have the same bytes for
//! any number of processes, one included.
//!
//! In each step a process sends ([`flights`]) migrating particles to its neighbours, and to all the
//! statistics for the next time step, the counters, and particles that flew farther than to an
//! adjacent tile. Cross-cell schemes also exchange ghost cells ([`partners`]).

mod bytes;
mod distribution;
mod flights;
mod owners;
mod partners;
mod ranks;
mod shards;
mod start;
mod subdomain;
#[cfg(test)]
mod tests;

pub(crate) use bytes::{from_bytes, to_bytes};
pub use ranks::{Ranks, all_gather as gather_from_all, broadcast as from_first};
pub(crate) use ranks::{all_gather, all_reduce, broadcast, reduce};
pub(crate) use shards::{Shard, read_all};
pub use shards::{ShardLocation, shard_name};
pub(crate) use subdomain::Subdomain;
