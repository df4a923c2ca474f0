//! Streams that flow in.

use stosszahl_model::Space;

/// What flows in through an open face: the particles of a Maxwellian that drifts, as they cross the face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inflow<S: Space> {
    /// The axis of the face, from 0.
    pub axis: usize,
    /// 0 for the lower face, 1 for the upper.
    pub side: usize,
    /// Number density of the gas beyond the face \[1/length^D\].
    pub density: f64,
    /// Its drift \[length/time\].
    pub velocity: S::Vector,
    /// Its temperature \[energy\].
    pub temperature: f64,
    /// Its temperature of rotation \[energy\]; smooth particles have none.
    pub spin_temperature: f64,
    /// The particle of the scene's sizes that they are like; 0 where all are alike.
    pub like: usize,
}
