//! Contact-point scheme in channels between walls: collision rate against exact disks.

use nalgebra::vector;
use stosszahl_dsmc::{
    BoundaryConditions, DsmcEngine, DsmcError, Parameters, Scheme, WallClearance,
};
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{FallingDisks, grains, ideal_gas, no_gravity};
use stosszahl_model::{Face, Plane, Smooth, Space, State, Wall, Walls};

use crate::support::PARAMETERS;

const AROUND_POINTS: Parameters = Parameters {
    scheme: Scheme::ContactPoint { radius: None },
    cell_size: None,
    steps_per_cell_crossing: 6.0,
    max_contact_value: 100.0,
    ..PARAMETERS
};

/// Reference of exact disks: packing fraction, channel width in diameters, and collisions per disk
/// and unit time at temperature one.
///
/// Event-driven engine, 400 elastic disks (1200 from 6 d on) between specular walls, from rows of
/// disks with Maxwellian velocities: 40 collisions per disk after 100 of relaxation. Standard
/// errors are 0.1 to 0.4 %.
const EXACT: [(f64, f64, f64); 15] = [
    (0.1, 3.0, 0.5561),
    (0.1, 4.0, 0.5620),
    (0.1, 6.0, 0.5569),
    (0.1, 10.0, 0.5503),
    (0.1, 20.0, 0.5425),
    (0.25, 3.0, 1.8597),
    (0.25, 4.0, 1.9011),
    (0.25, 6.0, 1.8723),
    (0.25, 10.0, 1.8442),
    (0.25, 20.0, 1.8171),
    (0.4, 3.0, 4.6053),
    (0.4, 4.0, 4.3791),
    (0.4, 6.0, 4.3373),
    (0.4, 10.0, 4.2672),
    (0.4, 20.0, 4.1936),
];

fn channel(
    packing: f64,
    width: f64,
    count: usize,
) -> (BoundaryConditions<Plane>, State<FallingDisks>) {
    let faces = [
        [Face::Periodic; 2],
        [Face::Wall(Wall::specular()); 2],
        [Face::Periodic; 2],
    ];
    let boundaries = BoundaryConditions {
        walls: Walls::new(&faces).expect("fit"),
        clearance: WallClearance::Radius,
        ..BoundaryConditions::default()
    };
    let length = count as f64 * Plane::particle_volume(0.5) / packing / width;
    let domain = boundaries
        .walls
        .domain(vector![length, width])
        .expect("a box");
    let scene: FallingDisks = grains(1.0, 1.0, Smooth, no_gravity());
    let state = ideal_gas(&scene, domain, 0.5, count, 1.0, 5);
    (boundaries, state)
}

/// Collision rates are below those of exact disks by at most the bound of the engine plus 4 %, and
/// above them by at most 4 %. The 4 % are the noise of 1200 simulators over 40 collisions each: the
/// density in a window of ten diameters varies with them, and so does chi.
#[test]
fn disks_in_channels_collide_as_often_as_the_engine_says() {
    let scene: FallingDisks = grains(1.0, 1.0, Smooth, no_gravity());
    for (packing, width, exact) in EXACT {
        for copies in [1, 4] {
            let (boundaries, state) = channel(packing, width, 1200 / copies as usize);
            let parameters = Parameters {
                simulators_per_particle: copies,
                ..AROUND_POINTS
            };
            let streams = Streams::new(1, 0);
            let mut engine: DsmcEngine<FallingDisks> =
                DsmcEngine::setup(&scene, parameters, streams)
                    .between(&boundaries)
                    .start(&state)
                    .expect("an engine");
            let unit = 1.0 / exact;
            engine.advance(15.0 * unit, u64::MAX, &mut ());
            let (from, before) = (engine.time(), engine.tally().collisions);
            engine.advance(from + 40.0 * unit, u64::MAX, &mut ());
            let collisions = (engine.tally().collisions - before) as f64;
            let simulators = engine.simulators() as f64;
            let temperature = engine.state().kinetic_energy(engine.scene()) / simulators;
            let rate = 2.0 * collisions / simulators / (40.0 * unit) / temperature.sqrt();
            let ratio = rate / exact;
            let said = engine.wall_error().expect("of this scheme");
            assert!((said - 1.75 * packing / width).abs() < 1e-3, "{said}");
            assert!(
                ratio < 1.04 && ratio > 1.0 - said - 0.04,
                "{copies} at packing {packing}, {width} d: {ratio}, said {said}"
            );
        }
    }
}

/// Narrower channels are refused with the scheme's name; other schemes have no such limit.
#[test]
fn channels_of_few_diameters_are_refused() {
    let scene: FallingDisks = grains(1.0, 1.0, Smooth, no_gravity());
    for (width, clearance) in [
        (1.5, WallClearance::Radius),
        (2.9, WallClearance::Radius),
        (1.9, WallClearance::Centre),
    ] {
        let (boundaries, state) = channel(0.1, width, 100);
        let boundaries = BoundaryConditions {
            clearance,
            ..boundaries
        };
        let start = |parameters| {
            let streams = Streams::new(1, 0);
            DsmcEngine::<FallingDisks>::setup(&scene, parameters, streams)
                .between(&boundaries)
                .start(&state)
                .map(|_| ())
        };
        let refused = start(AROUND_POINTS).expect_err("too narrow");
        let is_named = matches!(
            refused,
            DsmcError::Narrow {
                axis: 1,
                scheme: "contact-point",
                ..
            }
        );
        assert!(is_named, "{refused}");
        start(PARAMETERS).expect("pairs within cells");
    }
}
