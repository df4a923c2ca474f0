//! Collisions between partners in different cells, for the contact-point, contact-cell and overlap
//! schemes of Monte Carlo.
//!
//! Three schemes draw a partner by its position, not by its cell ([`crate::Scheme`] has their laws
//! and limits). The line of centres is drawn first, then the partner from the place where it must
//! be. All tiles are sorted first; then each is processed with its neighbours, colour after colour
//! ([`coloured_sweep`]), and the pairs of a tile one after the other.

mod arm;
mod change;
mod coloured_sweep;
mod colours;
mod extents;
mod halo_copy;
mod lanes;
mod missing;
mod overlap;
mod partners;
mod peers;
mod rate;
mod report;
mod search_ranges;
mod search_target;
mod step;
#[cfg(test)]
mod tests;
mod tile_collider;
mod tile_collisions;
mod tile_neighbourhood;
mod trials;

pub(crate) use arm::{ContactDistance, Distances};
pub(crate) use change::ChangeOf;
pub(crate) use colours::colours;
pub(crate) use halo_copy::HaloCopy;
pub(crate) use peers::TilePeers;
pub(crate) use rate::{Rates, Spread};
pub(crate) use report::{TileBounds, TileReport};
pub(crate) use search_ranges::{margin, reach};
