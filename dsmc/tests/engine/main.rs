//! Monte Carlo in cells. One program for all tests, so that each instance of the engine is compiled once.

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
