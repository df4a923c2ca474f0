//! Plain engine, the slow reference of the tests: one vector, a stable sort by cell in each step,
//! no tiles, no threads, and the formulas written out once more. With equal streams it gives equal
//! bytes.

use rand::RngExt;
use stosszahl_model::random::{Purpose, ShortStream, Streams};
use stosszahl_model::{
    CollidingPair, Domain, Free, ParticleModel, Restitution, Sizes, Smooth, Space, State, Vector,
    VectorOf, collide, equation_of_state,
};

use crate::{Neighbourhood, Parameters, PartnerDisplacement, Scheme};

/// Plain engine with steps of fixed length.
pub(super) struct Plain<P: ParticleModel> {
    scene: P,
    parameters: Parameters,
    domain: Domain<P::Space>,
    counts: [usize; 3],
    /// Position, velocity and index of each simulator; sorted by cell after a sort.
    pub(super) members: Vec<(VectorOf<P>, VectorOf<P>, usize)>,
    streams: Streams,
}

impl<P: ParticleModel<Surface = Smooth, Field = Free>> Plain<P> {
    pub(super) fn new(
        scene: &P,
        parameters: Parameters,
        state: &State<P>,
        streams: Streams,
        counts: [usize; 3],
    ) -> Self {
        let members = state.bodies.iter().enumerate();
        let mut plain = Self {
            scene: scene.clone(),
            parameters,
            domain: state.domain,
            counts,
            members: members
                .map(|(index, body)| (body.position, body.velocity, index))
                .collect(),
            streams,
        };
        plain.sort();
        plain
    }

    fn cell(&self, position: VectorOf<P>) -> [usize; 3] {
        let mut cell = [0; 3];
        for axis in 0..P::Space::DIMENSION {
            let share = position[axis] / self.domain.lengths()[axis];
            cell[axis] = (share * self.counts[axis] as f64) as usize;
        }
        cell
    }

    fn number(&self, cell: [usize; 3]) -> usize {
        cell[0] + self.counts[0] * (cell[1] + self.counts[1] * cell[2])
    }

    fn sort(&mut self) {
        let mut members = std::mem::take(&mut self.members);
        members.sort_by_key(|(position, ..)| self.number(self.cell(*position)));
        self.members = members;
    }

    fn fly(&mut self, duration: f64) {
        for (position, velocity, _) in &mut self.members {
            *position += *velocity * duration;
            *position = self.domain.wrap(*position);
        }
    }

    /// Advances as [`DsmcEngine::advance`] with a fixed step that the clock represents exactly.
    pub(super) fn advance(&mut self, steps: u64, first: u64, step: f64) -> u64 {
        let mut collisions = 0;
        self.fly(0.5 * step);
        for number in 0..steps {
            self.sort();
            collisions += self.collide(first + number, step);
            let next = if number + 1 < steps { step } else { 0.0 };
            self.fly(0.5 * (step + next));
        }
        self.sort();
        collisions
    }

    /// Packing fraction of the density window of a cell.
    fn packing(&self, cell: [usize; 3], volume: f64) -> f64 {
        let reach = match self.parameters.scheme {
            Scheme::Enskog(Neighbourhood::Cells(n)) => n as usize,
            _ => 0,
        };
        let sizes = self.scene.sizes();
        let mut covered = 0.0;
        for (position, _, index) in &self.members {
            let other = self.cell(*position);
            let near = (0..P::Space::DIMENSION).all(|axis| {
                let apart = other[axis].abs_diff(cell[axis]);
                apart.min(self.counts[axis] - apart) <= reach
            });
            if near {
                let share = sizes.radius(sizes.tag_of(*index)) / sizes.largest_radius();
                covered += share.powi(P::Space::DIMENSION as i32);
            }
        }
        let cells = ((2 * reach + 1) as f64).powi(P::Space::DIMENSION as i32);
        covered * (P::Space::particle_volume(sizes.largest_radius()) / (volume * cells))
    }

    fn collide(&mut self, number: u64, step: f64) -> u64 {
        let mut total = 0;
        let bundle = self.streams.bundle(Purpose::Collisions, number);
        let before = self.members.clone();
        let [nx, ny, nz] = self.counts;
        let volume: f64 = (0..P::Space::DIMENSION)
            .map(|axis| self.domain.lengths()[axis] / self.counts[axis] as f64)
            .product();
        let mut begin = 0;
        for cell in 0..nx * ny * nz {
            let at = [cell % nx, cell / nx % ny, cell / nx / ny];
            let here = |(position, ..): &&(VectorOf<P>, _, _)| self.cell(*position) == at;
            let count = before[begin..].iter().take_while(here).count();
            let range = begin..begin + count;
            begin += count;
            if count < 2 {
                continue;
            }
            let packing = if self.parameters.scheme == Scheme::Boltzmann {
                0.0
            } else {
                let now = std::mem::replace(&mut self.members, before.clone());
                let packing = self.packing(at, volume);
                self.members = now;
                packing
            };
            let chi = self
                .parameters
                .scheme
                .contact_value::<P::Space>(packing)
                .min(self.parameters.max_contact_value);
            let mut stream = bundle.stream_at(cell as u64);
            total += self.collide_cell(range, step / volume, [chi, packing], &mut stream);
        }
        total
    }

    fn collide_cell(
        &mut self,
        range: std::ops::Range<usize>,
        step: f64,
        [chi, packing]: [f64; 2],
        stream: &mut ShortStream,
    ) -> u64 {
        let sizes = self.scene.sizes().clone();
        let dimension = P::Space::DIMENSION;
        let members = &mut self.members[range];
        let mut diagonal = VectorOf::<P>::default();
        for axis in 0..dimension {
            let all = members.iter().map(|(_, velocity, _)| velocity[axis]);
            diagonal[axis] = all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min);
        }
        let mut majorant = diagonal.square().sqrt();
        let moments = (0..members_of(&sizes)).map(|i| 2.0 * sizes.radius(sizes.tag_of(i)));
        let ratio = moments
            .clone()
            .map(|d| d.powi(dimension as i32 - 1))
            .sum::<f64>()
            / moments.map(|d| d.powi(dimension as i32)).sum::<f64>();
        let factor = |diameters: [f64; 2]| {
            P::Space::cross_section(0.5 * (diameters[0] + diameters[1]))
                * equation_of_state::mixture_contact_value(chi, packing.min(0.9), diameters, ratio)
        };
        let largest = 2.0 * sizes.largest_radius();
        let mut ceiling = chi * P::Space::cross_section(largest);
        if !P::Sizes::UNIFORM {
            ceiling = ceiling.max(factor([largest; 2]));
        }
        let n = members.len() as u64;
        let pairs = 0.5 * (n * (n - 1)) as f64;
        let mut collisions = 0;
        let trials = pairs * (ceiling * step) * majorant + stream.random::<f64>();
        for _ in 0..trials as u64 {
            let first = u128::from(stream.random::<u64>()) * u128::from(n);
            let second = u128::from(first as u64) * u128::from(n - 1);
            let (i, j) = ((first >> 64) as usize, (second >> 64) as usize);
            let j = if j >= i { j + 1 } else { j };
            let relative = members[i].1 - members[j].1;
            let diameters = [i, j].map(|who| 2.0 * sizes.radius(sizes.tag_of(members[who].2)));
            let mut threshold = majorant * stream.random::<f64>();
            let speed = relative.square().sqrt();
            majorant = majorant.max(speed);
            if !P::Sizes::UNIFORM {
                threshold *= ceiling / factor(diameters);
            }
            if speed <= threshold {
                continue;
            }
            collisions += 1;
            let (normal, along) = P::Space::line_of_centres(relative * (1.0 / speed), stream);
            let pair = CollidingPair {
                velocities: [members[i].1, members[j].1],
                spins: [(); 2],
                masses: [i, j].map(|who| sizes.mass(sizes.tag_of(members[who].2))),
                radii: diameters.map(|diameter| 0.5 * diameter),
                line: normal * (0.5 * (diameters[0] + diameters[1])),
            };
            let restitution = self.scene.restitution().normal_restitution(-along * speed);
            let [u, v] = collide(&self.scene, &pair, restitution).velocities;
            (members[i].1, members[j].1) = (u, v);
            let share = match self.parameters.displacement {
                PartnerDisplacement::None => continue,
                PartnerDisplacement::Diameter => 1.0,
                PartnerDisplacement::Inelastic => 0.5 * (1.0 + restitution) / restitution,
            };
            members[i].0 += pair.line * share;
            members[j].0 -= pair.line * share;
        }
        collisions
    }
}

/// Number of sizes: 400 in every mixture of these tests, one for equal particles.
fn members_of<Z: Sizes>(_sizes: &Z) -> usize {
    if Z::UNIFORM { 1 } else { 400 }
}
