//! Particles, parameters and starts shared by the tests of walls and flow.

#![allow(dead_code, reason = "each file of tests uses what it needs")]

use rand::RngExt;
use stosszahl_dsmc::{Parameters, PartnerDisplacement, Scheme, SimulatorStart};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{
    Constant, Domain, Gravity, Law, ParticleModel, ParticleState, Scene, Space, Species,
    SpeciesProperties, State, Surface, initial,
};

/// Particles as programs have them that read their properties at run time. All tests share a few
/// types, since an engine takes ten seconds to compile.
pub type Grains<S, C> = Scene<S, C, Law, Species, Gravity<S>>;

/// Parameters of Bird's dilute gas, in cells that each test chooses.
pub const PARAMETERS: Parameters = Parameters {
    scheme: Scheme::Boltzmann,
    displacement: PartnerDisplacement::None,
    cell_size: Some(1.0),
    simulators_per_particle: 1,
    copies: SimulatorStart::Independent,
    steps_per_cell_crossing: 3.0,
    max_contact_value: 10.0,
};

/// Particles of one diameter and of mass one, in any number.
pub fn grains<S: Space, C: Surface<S>>(
    diameter: f64,
    restitution: f64,
    surface: C,
    field: Gravity<S>,
) -> Grains<S, C> {
    let kind = SpeciesProperties {
        radius: 0.5 * diameter,
        mass: 1.0,
        count: u32::MAX as usize,
    };
    of_kinds(vec![kind], restitution, surface, field)
}

/// Particles of several species.
pub fn of_kinds<S: Space, C: Surface<S>>(
    kinds: Vec<SpeciesProperties>,
    restitution: f64,
    surface: C,
    field: Gravity<S>,
) -> Grains<S, C> {
    Scene {
        space: S::default(),
        surface,
        restitution: Constant::new(restitution).expect("a coefficient").into(),
        sizes: Species::new(kinds).expect("species"),
        field,
    }
}

/// Zero gravity.
pub fn no_gravity<S: Space>() -> Gravity<S> {
    Gravity::new(S::from_components(|_| 0.0)).expect("finite")
}

/// Diameter of disks whose mean free path is one at this density.
pub fn disk_for_unit_path(density: f64) -> f64 {
    1.0 / (8.0_f64.sqrt() * density)
}

/// Diameter of spheres whose mean free path is one at this density.
pub fn sphere_for_unit_path(density: f64) -> f64 {
    (2.0_f64.sqrt() * std::f64::consts::PI * density).powf(-0.5)
}

/// Gas of random points in a box without its margins, with Maxwellian velocities and no drift.
pub fn gas<P: ParticleModel>(
    scene: &P,
    domain: Domain<P::Space>,
    margin: f64,
    count: usize,
    temperature: f64,
    seed: u64,
) -> State<P> {
    let streams = Streams::new(seed, 0);
    let mut stream = streams.stream_at(Purpose::Placement, [0, 0]);
    let lengths = domain.lengths();
    let mut anywhere = || {
        P::Space::from_components(|axis| {
            margin + (lengths[axis] - 2.0 * margin) * stream.random::<f64>()
        })
    };
    let mut state = State {
        time: 0.0,
        domain,
        bodies: (0..count)
            .map(|_| ParticleState::new(anywhere(), P::Space::from_components(|_| 0.0)))
            .collect(),
    };
    let mut stream = streams.stream_at(Purpose::Velocities, [0, 0]);
    initial::maxwellian(scene, &mut state, temperature, &mut stream);
    state
}
