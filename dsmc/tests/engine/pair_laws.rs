//! Restitution laws of pairs of species apply to the right pairs, however the gas is stored.

use nalgebra::Vector3;
use stosszahl_dsmc::{
    BoundaryConditions, CellGas, Neighbourhood, Parameters, PartnerDisplacement, Scheme,
    SimulatorStart, simulate,
};
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{ideal_particles, law, species};
use stosszahl_model::{
    Budget, Collision, Observer, ParticleSpec, PerPair, Polydisperse, SizeDistribution,
};

/// Restitution by the species of both particles, and collision numbers of each pair of species.
#[derive(Default)]
struct Laws([u64; 3]);

const COEFFICIENTS: [f64; 3] = [0.9, 0.7, 0.5];

impl Observer for Laws {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for one in batch {
            let number = (one.species[0] + one.species[1]) as usize;
            assert_eq!(one.restitution, COEFFICIENTS[number], "{:?}", one.species);
            self.0[number] += 1;
        }
    }
}

/// Two species of a hundred with two simulators per particle: as species, and with individual
/// sizes, in plain scenes and in scenes that know species only.
#[test]
fn copies_of_species_keep_their_laws() {
    let sizes = [(0.5, 1.0), (0.3, 0.2)];
    let laws = [0, 1, 1, 2].map(|number: usize| law(COEFFICIENTS[number]));
    let laws = PerPair::new(2, laws.into()).expect("a table");
    let species = species(sizes.map(|(radius, mass)| (radius, mass, 100)));
    let list: Vec<_> = (0..200).map(|index| sizes[index / 100]).collect();
    let each = Polydisperse::new(list).expect("sizes");
    let each = each
        .of_kinds((0..200).map(|index| index / 100).collect())
        .expect("species of each");
    for (dimension, sizes, gravity) in [
        (2, SizeDistribution::Species(species.clone()), None),
        (3, SizeDistribution::Species(species), None),
        (2, SizeDistribution::Each(each.clone()), None),
        (2, SizeDistribution::Each(each.clone()), Some(Vector3::x())),
        (3, SizeDistribution::Each(each), None),
    ] {
        let grains = ParticleSpec {
            sizes,
            restitution: laws.clone().into(),
            rough: None,
            gravity,
            shear_rate: None,
            shear_offset: 0.0,
            is_bounded: false,
        };
        let start = ideal_particles(dimension, 20.0, 200, 7);
        let gas = CellGas {
            grains: &grains,
            parameters: Parameters {
                scheme: Scheme::Enskog(Neighbourhood::Cells(1)),
                displacement: PartnerDisplacement::None,
                cell_size: Some(5.0),
                simulators_per_particle: 2,
                copies: SimulatorStart::Independent,
                steps_per_cell_crossing: 4.0,
                max_contact_value: 10.0,
            },
            boundaries: &BoundaryConditions::default(),
            streams: Streams::new(3, 0),
            displacements: false,
        };
        let mut engine = simulate(&gas, &[start]).expect("an engine");
        let mut met = Laws::default();
        engine
            .advance(f64::INFINITY, Budget::Collisions(1000), &mut met)
            .expect("no failure");
        assert!(met.0.iter().all(|&count| count > 50), "{:?}", met.0);
        // Set after set, each in the order of the particles.
        let found = engine.particles().all;
        let species = found.iter().map(|one| one.species);
        assert!(species.eq((0..400).map(|index| index / 100 % 2)));
        assert!(
            found
                .iter()
                .all(|one| one.mass == [1.0, 0.2][one.species as usize])
        );
    }
}
