//! Tests of cell-based Monte Carlo, in one program so that each engine type is compiled once.

mod channels;
mod continued;
mod flow;
mod obstacles;
mod pair_laws;
mod rough;
mod sedimentation;
mod shear;
mod sides;
mod support;
mod walls;
