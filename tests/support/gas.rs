//! Gases of unit disks for tests and benchmarks.

use nalgebra::vector;
use stosszahl_model::initial::{self, Arrangement};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{Body, Constant, Domain, Free, Monodisperse, Plane, Scene, Smooth, State};

/// Smooth equal disks of diameter and mass one.
pub type Disks = Scene<Plane, Smooth, Constant, Monodisperse, Free>;

/// The scene of unit disks with the given restitution.
pub fn disks(restitution: f64) -> Disks {
    Scene {
        space: Plane,
        surface: Smooth,
        restitution: Constant::new(restitution).expect("a coefficient"),
        sizes: Monodisperse {
            radius: 0.5,
            mass: 1.0,
        },
        field: Free,
    }
}

/// A Maxwellian gas of unit disks at temperature one in a square box.
pub fn gas(
    arrangement: Arrangement,
    count: usize,
    packing_fraction: f64,
    seed: u64,
) -> State<Disks> {
    let side = (count as f64 * std::f64::consts::FRAC_PI_4 / packing_fraction).sqrt();
    let domain = Domain::periodic(vector![side, side]).expect("a box");
    let streams = Streams::new(seed, 0);
    let placement =
        initial::place(arrangement, count, 1.0, &domain, &streams).expect("a placement");
    let bodies = placement
        .positions
        .into_iter()
        .map(|at| Body::new(at, vector![0.0, 0.0]))
        .collect();
    let mut state = State {
        time: 0.0,
        domain,
        bodies,
    };
    initial::maxwellian(
        &disks(1.0),
        &mut state,
        1.0,
        &mut streams.at(Purpose::Velocities, [0, 0]),
    );
    state
}
