//! Initial simulators of a gas with several simulators per particle: independent or coherent copies
//! of one state.

use rand::{Rng, RngExt};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{
    ParticleModel, ParticleState, Sizes, Space, State, Surface, Vector, VectorOf,
};

use crate::parameters::{Parameters, SimulatorStart};
use crate::particle::{DisplacementTracking, Simulator, SimulatorOf};

/// Number of particles in the neighbourhood whose mean velocity coherent copies of a state keep.
const NEIGHBOURHOOD: f64 = 32.0;

/// Creates simulators from several given states, one for each set of simulators, set after set.
pub(crate) fn coarse_of_sets<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    scene: &P,
    sets: &[State<P>],
) -> Vec<SimulatorOf<P, F>> {
    let sizes = scene.sizes().repeat_sizes(sets.len());
    let bodies = sets
        .iter()
        .flat_map(|set| set.bodies.iter().map(move |body| (set, body)));
    bodies
        .enumerate()
        .map(|(index, (set, body))| Simulator {
            position: set.domain.wrap(body.position),
            velocity: body.velocity,
            tag: sizes.tag_of(index),
            mark: F::DisplacementMark::default(),
            spin: body.spin,
        })
        .collect()
}

/// Creates the simulators of a state with further sets of copies, set after set, each in the order
/// of the state.
pub(crate) fn simulators<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    scene: &P,
    parameters: &Parameters,
    state: &State<P>,
    streams: Streams,
) -> Vec<SimulatorOf<P, F>> {
    let copies = parameters.simulators_per_particle as usize;
    let sizes = scene.sizes().repeat_sizes(copies);
    let count = state.bodies.len();
    let mut simulators = Vec::with_capacity(count * copies);
    let flow = (copies > 1 && parameters.copies == SimulatorStart::Coherent)
        .then(|| Flow::block_averages(scene, state));
    for copy in 0..copies {
        let mut stream = streams.stream_at(Purpose::Simulators, [copy as u64, 0]);
        let bodies: Vec<ParticleState<P>> = match &flow {
            _ if copy == 0 => state.bodies.clone(),
            Some(flow) => flow.copy(scene, state, &mut stream),
            None => independent_copy(scene, state, &mut stream),
        };
        let bodies = bodies.into_iter().enumerate();
        simulators.extend(bodies.map(|(index, body)| Simulator {
            position: state.domain.wrap(body.position),
            velocity: body.velocity,
            tag: sizes.tag_of(copy * count + index),
            mark: F::DisplacementMark::default(),
            spin: body.spin,
        }));
    }
    simulators
}

/// Returns an independent copy of a state: shifted by a random vector, with all velocities rotated
/// at random.
fn independent_copy<P: ParticleModel>(
    scene: &P,
    state: &State<P>,
    stream: &mut impl Rng,
) -> Vec<ParticleState<P>> {
    let mut room = state.domain.lengths();
    for axis in 0..P::Space::DIMENSION {
        // Reflected at walls, a position is uniform only after a shift of up to twice the side.
        if !state.domain.is_periodic(axis) {
            room[axis] *= 2.0;
        }
    }
    let shift = random_vector::<P>(room, stream);
    let turn = P::Space::random_turn(stream);
    let turned = |body: &ParticleState<P>| ParticleState {
        position: body.position + shift,
        velocity: P::Space::rotate_vector(turn, body.velocity),
        spin: scene.surface().rotate_spin(turn, body.spin),
    };
    state.bodies.iter().map(turned).collect()
}

/// Draws a random vector, each component uniformly from 0 to that of `lengths`.
fn random_vector<P: ParticleModel>(lengths: VectorOf<P>, stream: &mut impl Rng) -> VectorOf<P> {
    let mut vector = VectorOf::<P>::default();
    for axis in 0..P::Space::DIMENSION {
        vector[axis] = lengths[axis] * stream.random::<f64>();
    }
    vector
}

/// Coarse flow field of a state, its long waves: the mean velocity around each particle.
struct Flow<V> {
    /// Width of a neighbourhood for mean velocities along each axis \[length\].
    width: V,
    /// Mean velocity in the neighbourhood of each particle \[length/time\].
    means: Vec<V>,
}

impl<V: Vector> Flow<V> {
    /// Computes the mean velocity around each particle: averages over blocks of three cells along
    /// each axis around its cell.
    fn block_averages<P: ParticleModel>(scene: &P, state: &State<P>) -> Self
    where
        P::Space: Space<Vector = V>,
    {
        let dimension = P::Space::DIMENSION;
        let lengths = state.domain.lengths();
        let each = state.domain.volume() * NEIGHBOURHOOD / state.bodies.len().max(1) as f64;
        let side = each.powf(1.0 / dimension as f64) / 3.0;
        let mut counts = [1_usize; 3];
        let mut width = lengths;
        for axis in 0..dimension {
            counts[axis] = ((lengths[axis] / side) as usize).clamp(1, 4096);
            width[axis] = lengths[axis] / counts[axis] as f64 * (counts[axis].min(3)) as f64;
        }
        let place = |position: V| {
            let mut cell = [0; 3];
            for axis in 0..dimension {
                let at = (position[axis] / lengths[axis] * counts[axis] as f64) as usize;
                cell[axis] = at.min(counts[axis] - 1);
            }
            cell
        };
        let number = |cell: [usize; 3]| cell[0] + counts[0] * (cell[1] + counts[1] * cell[2]);
        let mut sums = vec![(V::default(), 0.0); counts.iter().product()];
        let sizes = scene.sizes();
        for (index, body) in state.bodies.iter().enumerate() {
            let mass = sizes.mass(sizes.tag_of(index));
            let (momentum, total) = &mut sums[number(place(body.position))];
            *momentum += body.velocity * mass;
            *total += mass;
        }
        let mean = |cell: [usize; 3]| {
            let (mut momentum, mut total) = (V::default(), 0.0);
            let span = counts.map(|count| count.min(3));
            for z in 0..span[2] {
                for y in 0..span[1] {
                    for x in 0..span[0] {
                        let step = [x, y, z];
                        let other = [0, 1, 2].map(|axis| {
                            let back = usize::from(span[axis] == 3);
                            (cell[axis] + counts[axis] + step[axis] - back) % counts[axis]
                        });
                        let (more, mass) = sums[number(other)];
                        momentum += more;
                        total += mass;
                    }
                }
            }
            momentum * (1.0 / total)
        };
        let means = state
            .bodies
            .iter()
            .map(|body| mean(place(body.position)))
            .collect();
        Self { width, means }
    }

    /// Returns a coherent copy of a state: same long waves of the flow, random velocities relative
    /// to these, equal energy and momentum.
    fn copy<P: ParticleModel>(
        &self,
        scene: &P,
        state: &State<P>,
        stream: &mut impl Rng,
    ) -> Vec<ParticleState<P>>
    where
        P::Space: Space<Vector = V>,
    {
        let shift = random_vector::<P>(self.width, stream) - self.width * 0.5;
        let mut bodies: Vec<ParticleState<P>> = state
            .bodies
            .iter()
            .zip(&self.means)
            .map(|(body, &mean)| {
                let turn = P::Space::random_turn(stream);
                let own = P::Space::rotate_vector(turn, body.velocity - mean);
                ParticleState {
                    position: body.position + shift,
                    velocity: mean + own,
                    spin: scene.surface().rotate_spin(turn, body.spin),
                }
            })
            .collect();
        // Rotated velocities have other sums: they are shifted and scaled about the mean velocity.
        let sizes = scene.sizes();
        let mass = |index: usize| sizes.mass(sizes.tag_of(index));
        let sums = |velocities: &mut dyn Iterator<Item = V>| {
            let (mut momentum, mut total, mut twice_energy) = (V::default(), 0.0, 0.0);
            for (index, velocity) in velocities.enumerate() {
                momentum += velocity * mass(index);
                total += mass(index);
                twice_energy += mass(index) * velocity.square();
            }
            let mean = momentum * (1.0 / total);
            (mean, twice_energy - total * mean.square())
        };
        let (wanted, heat) = sums(&mut state.bodies.iter().map(|body| body.velocity));
        let (found, found_heat) = sums(&mut bodies.iter().map(|body| body.velocity));
        let stretch = if found_heat > 0.0 {
            (heat / found_heat).max(0.0).sqrt()
        } else {
            1.0
        };
        for body in &mut bodies {
            body.velocity = wanted + (body.velocity - found) * stretch;
        }
        bodies
    }
}
