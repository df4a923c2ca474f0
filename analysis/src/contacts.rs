//! Contact statistics of colliding pairs, compared with molecular chaos at the local temperature:
//! tests of the breakdown of molecular chaos.
//!
//! Under molecular chaos partners are drawn from the velocities of the place, independently, and
//! met with a chance in proportion to their normal relative speed g. With local Maxwellian
//! velocities its square is then exponential, `P(g) = (μ g/T) exp(-μ g²/(2 T))`, in any dimension
//! and whatever the flow is on larger scales, so
//!
//! ```text
//! <g^p> = (2 T/μ)^(p/2) Γ(1 + p/2)        before contact, and r^p times that after it
//! ```
//!
//! with the reduced mass μ and the coefficient of restitution r ([`moment_of_chaos`]). T is the
//! granular temperature about the local flow: of the some [`LOCAL`] disks of a cell, about a
//! velocity that is linear in the position. It is measured at samples of the gas, follows the
//! temperature of the whole gas between two samples, and its powers are freed of the bias that few
//! disks give
//! them. The *total* temperature would take flow for heat. Velocities are not quite Maxwellian in a
//! cooling gas: with the fourth cumulant a2 moments of order p change by about `a2 p (p - 2)/16` of
//! themselves, below .5 % at the restitutions of gases.
//!
//! *Shuffled pairs* tell short-range correlations from shear. Of pairs that approach each other
//! within a tenth of a diameter of contact, weighted by their normal speed, the slope of P(b/d) is
//! close to that at contact. The same pairs, but with velocities about the local flow that are
//! those of two other disks of the same cells, keep flow, shear, temperatures and positions, and
//! lose all correlations between partners.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use statrs::function::gamma::{gamma, ln_gamma};
use stosszahl_model::{Collision, Observer, Particles};

mod history;
mod pairs;
mod sums;

pub use history::{BYTES_PER_SIMULATOR, LONGEST_RING, MEMORY, MOST_BETWEEN};
use history::{History, Past};
use pairs::each_pair;
pub use sums::{Acquaintance, ContactSums, MetSums, Products};

/// Mean number of disks in a cell for the local flow and temperature.
pub const LOCAL: f64 = 24.0;
/// Largest centre distance of pairs that count as near contact, over their contact distance.
pub const NEAR: f64 = 1.1;
/// Edges of the distance bins in which velocity correlations are summed, over the contact distance.
pub const EDGES: [f64; DISTANCES + 1] = [1.0, NEAR, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0];
/// Number of distance bins for velocity correlations.
pub const DISTANCES: usize = 8;
/// Orders p of the moments `<g^p>` of the normal relative speed g of colliding pairs.
pub const ORDERS: [i32; 4] = [-1, 1, 2, 3];

/// Computes the moment `<g^p>` of the normal relative speed of colliding pairs under molecular
/// chaos, `(2 T/μ)^(p/2) Γ(1 + p/2)`.
///
/// ```
/// use stosszahl_analysis::contacts::moment_of_chaos;
///
/// // Equal disks of mass 1: <g> = sqrt(pi T), <g²> = 4 T.
/// assert!((moment_of_chaos(1, 2.0, 0.5) - (2.0 * std::f64::consts::PI).sqrt()).abs() < 1e-12);
/// assert!((moment_of_chaos(2, 2.0, 0.5) - 8.0).abs() < 1e-12);
/// ```
pub fn moment_of_chaos(order: i32, temperature: f64, reduced_mass: f64) -> f64 {
    let half = 0.5 * f64::from(order);
    (2.0 * temperature / reduced_mass).powf(half) * gamma(1.0 + half)
}

/// Bias factor of a power of a measured temperature: its mean over that power of the true
/// temperature, for `freedom` degrees of freedom.
fn power_bias(power: f64, freedom: f64) -> f64 {
    let half = 0.5 * freedom;
    (ln_gamma(half + power) - ln_gamma(half) - power * half.ln()).exp()
}

/// Local flow and temperature of a gas, fitted in the cells of a grid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Local {
    cells: [usize; 3],
    lengths: [f64; 3],
    places: Vec<Place>,
}

/// State of one cell: number of particles, temperature (0 if unknown), and degrees of freedom of
/// the temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Place {
    count: usize,
    temperature: f64,
    freedom: f64,
}

/// Flow of one cell, linear in position: mass, centre, mean velocity and velocity gradient.
#[derive(Clone, Copy, Default)]
struct Flow {
    mass: f64,
    place: Vector3<f64>,
    velocity: Vector3<f64>,
    gradient: Matrix3<f64>,
}

impl Flow {
    fn at(&self, place: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.gradient * (place - self.place)
    }
}

impl Local {
    /// Returns the index of the cell of a position, which may lie in any periodic image of the box.
    fn cell(&self, place: &Vector3<f64>) -> usize {
        (0..3).rev().fold(0, |index, axis| {
            let (count, length) = (self.cells[axis], self.lengths[axis]);
            let share = if length > 0.0 {
                (place[axis] / length).rem_euclid(1.0)
            } else {
                0.0
            };
            index * count + ((share * count as f64) as usize).min(count - 1)
        })
    }

    /// Fits flow and temperature in all cells. Also returns the flow of each cell, the velocity of
    /// each particle relative to it, corrected for the fit, and the cell of each particle.
    fn local_flow(particles: &Particles) -> (Self, Vec<Flow>, Vec<Vector3<f64>>, Vec<usize>) {
        let dimension = particles.dimension;
        let volume: f64 = particles.lengths[..dimension].iter().product();
        let number: f64 = particles.all.iter().map(|one| one.weight).sum();
        let side = (volume * LOCAL / number.max(1.0)).powf(1.0 / dimension as f64);
        let count = |axis: usize| {
            if axis < dimension {
                (particles.lengths[axis] / side) as usize
            } else {
                1
            }
        };
        let mut local = Self {
            cells: std::array::from_fn(|axis| count(axis).max(1)),
            lengths: particles.lengths,
            places: Vec::new(),
        };
        let cells: Vec<usize> = particles
            .all
            .iter()
            .map(|one| local.cell(&one.position))
            .collect();
        let total = local.cells.iter().product();
        local.places = vec![Place::default(); total];
        let mut flows = vec![Flow::default(); total];
        let each = || particles.all.iter().zip(&cells);
        for (one, &cell) in each() {
            let flow = &mut flows[cell];
            local.places[cell].count += 1;
            flow.mass += one.mass;
            flow.place += one.mass * one.position;
            flow.velocity += one.mass * one.velocity;
        }
        for flow in flows.iter_mut().filter(|flow| flow.mass > 0.0) {
            flow.place /= flow.mass;
            flow.velocity /= flow.mass;
        }
        let mut tensors = vec![[Matrix3::<f64>::zeros(); 2]; total];
        for (one, &cell) in each() {
            let away = one.position - flows[cell].place;
            tensors[cell][0] += one.mass * away * away.transpose();
            tensors[cell][1] += one.mass * (one.velocity - flows[cell].velocity) * away.transpose();
        }
        for (flow, [squares, products]) in flows.iter_mut().zip(&mut tensors) {
            for axis in dimension..3 {
                squares[(axis, axis)] = 1.0;
            }
            flow.gradient = squares
                .try_inverse()
                .map_or(Matrix3::zeros(), |inverse| *products * inverse);
        }
        let mut own: Vec<Vector3<f64>> = each()
            .map(|(one, &cell)| one.velocity - flows[cell].at(&one.position))
            .collect();
        for ((one, &cell), own) in each().zip(&own) {
            local.places[cell].temperature += one.mass * own.norm_squared();
        }
        let fitted = dimension + 1;
        for place in &mut local.places {
            // The fit takes D + 1 numbers for each component; three times as many particles leave a
            // spread to speak of.
            let known = place.count >= 3 * fitted;
            place.freedom = (dimension * place.count.saturating_sub(fitted)) as f64;
            place.temperature = if known {
                place.temperature / place.freedom
            } else {
                0.0
            };
        }
        for (own, &cell) in own.iter_mut().zip(&cells) {
            let place = &local.places[cell];
            *own *= ((dimension * place.count) as f64 / place.freedom.max(1.0)).sqrt();
        }
        (local, flows, own, cells)
    }
}

/// Observer of contact statistics of colliding pairs in time windows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactObserver {
    /// Time windows with their contact sums: start and end \[time\], the end not included.
    pub windows: Vec<([f64; 2], ContactSums)>,
    dimension: usize,
    number: f64,
    local: Local,
    /// Granular temperature of the whole gas \[energy\]: now, and at the last sample.
    temperature: [f64; 2],
    history: History,
}

impl ContactObserver {
    /// Creates an observer with windows `[start, end)` \[time\], which may overlap, and fits the
    /// local flow and temperature of the gas.
    pub fn new(spans: &[[f64; 2]], particles: &Particles) -> Self {
        let mut contacts = Self {
            windows: spans
                .iter()
                .map(|&span| (span, ContactSums::default()))
                .collect(),
            dimension: particles.dimension,
            number: particles.all.iter().map(|one| one.weight).sum(),
            local: Local::default(),
            temperature: [1.0; 2],
            history: History::new(particles.all.len()),
        };
        contacts.local = Local::local_flow(particles).0;
        contacts.temperature = [particles.temperature(); 2];
        contacts
    }

    /// Sets the granular temperature of the whole gas, so that rounding errors of the running
    /// energy do not accumulate.
    pub fn synchronise(&mut self, temperature: f64) {
        self.temperature[0] = temperature;
    }

    /// Samples the gas at a time: fits local flow and temperature for the next collisions, and sums
    /// over pairs near contact.
    pub fn sample_gas(&mut self, time: f64, particles: &Particles) {
        let (local, flows, own, cells) = Local::local_flow(particles);
        self.local = local;
        self.temperature = [particles.temperature(); 2];
        let inside = |span: &[f64; 2]| (span[0]..span[1]).contains(&time);
        if !self.windows.iter().any(|(span, _)| inside(span)) {
            return;
        }
        let mut sums = ContactSums::default();
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); self.local.places.len()];
        for (who, &cell) in cells.iter().enumerate() {
            members[cell].push(who);
        }
        let total = particles.all.iter().map(|one| one.mass).sum::<f64>();
        let drift = particles
            .all
            .iter()
            .map(|one| one.mass * one.velocity)
            .sum::<Vector3<f64>>()
            / total;
        for (one, &cell) in particles.all.iter().zip(&cells) {
            let temperature = self.local.places[cell].temperature;
            if temperature > 0.0 {
                let moving = (one.velocity - drift).norm_squared();
                sums.heat[0] += temperature;
                sums.heat[1] += one.mass * moving / self.dimension as f64;
            }
        }
        let power = self.dimension as i32 - 1;
        let mut draws = time.to_bits();
        each_pair(particles, EDGES[DISTANCES], |[i, j], line, distance| {
            let after = EDGES.iter().rposition(|&edge| edge <= distance);
            let bin = after.unwrap_or(0).min(DISTANCES - 1);
            let along = line.normalize();
            let moving = [i, j].map(|who| particles.all[who].velocity - drift);
            sums.velocities[bin][0].add(moving, &along);
            if [i, j]
                .iter()
                .any(|&who| self.local.places[cells[who]].temperature == 0.0)
            {
                return;
            }
            // Other particles of the cells of the pair, by a fixed sequence of numbers.
            let other = |who: usize, draws: &mut u64| loop {
                let all = &members[cells[who]];
                let chosen = all[(next_random(draws) % all.len() as u64) as usize];
                if chosen != i && chosen != j {
                    break chosen;
                }
            };
            let first = other(i, &mut draws);
            let mut second = other(j, &mut draws);
            while second == first {
                second = other(j, &mut draws);
            }
            let shuffled = [(i, first), (j, second)].map(|(who, other)| {
                flows[cells[who]].at(&particles.all[who].position) + own[other] - drift
            });
            sums.velocities[bin][1].add(shuffled, &along);
            if distance >= NEAR {
                return;
            }
            for (kind, [one, two]) in [moving, shuffled].into_iter().enumerate() {
                let relative = one - two;
                let normal = relative.dot(&along);
                if normal < 0.0 {
                    let across = (relative - normal * along).norm() / relative.norm();
                    sums.flux[kind] -= normal;
                    sums.flux_impacts[kind] -= normal * across.powi(power);
                }
            }
        });
        for (_, all) in self.windows.iter_mut().filter(|(span, _)| inside(span)) {
            all.merge(&sums);
        }
    }

    /// Returns the number of particles of the gas: the sum of the weights of simulators.
    pub fn particles(&self) -> f64 {
        self.number
    }

    fn collision(&mut self, collision: &Collision) {
        let past = self.history.record_collision(collision.pair);
        let inside = |span: &[f64; 2]| (span[0]..span[1]).contains(&collision.time);
        for (_, sums) in self.windows.iter_mut().filter(|(span, _)| inside(span)) {
            sums.physical += collision.weight;
            if let Some(past) = past {
                sums.count_collision(past);
            }
            let place = self.local.places[self.local.cell(&collision.position)];
            let temperature = place.temperature * self.temperature[0] / self.temperature[1];
            if temperature > 0.0 {
                sums.known += 1.0;
                let normal = collision.normal_square().sqrt();
                let mass = collision.reduced_mass;
                for (index, order) in ORDERS.into_iter().enumerate() {
                    let moment = moment_of_chaos(order, temperature, mass);
                    sums.before[index] += normal.powi(order);
                    sums.after[index] += collision.separation().powi(order);
                    sums.chaos[index] += moment / power_bias(0.5 * f64::from(order), place.freedom);
                }
                // The mean of μ g² under chaos is (D + 1) T.
                let mean = (self.dimension + 1) as f64 * temperature;
                let fast = usize::from(mass * collision.relative_velocity.norm_squared() > mean);
                let impact = collision.impact_square().sqrt();
                let uniform = impact.powi(self.dimension as i32 - 1);
                sums.pairs[fast] += 1.0;
                sums.impacts[fast] += uniform;
                if let Some(Past { between, .. }) = past {
                    let squares = [
                        collision.normal_square(),
                        moment_of_chaos(2, temperature, mass),
                    ];
                    for known in Acquaintance::relations_after(between) {
                        sums.met[*known as usize].add(uniform, squares);
                    }
                }
            }
        }
        // T = 2 K/(D N).
        let lost = collision.energy_lost() * collision.weight;
        self.temperature[0] -= 2.0 * lost / (self.dimension as f64 * self.number);
    }
}

impl Observer for ContactObserver {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            self.collision(collision);
        }
    }
}

/// Returns the next number of the splitmix64 generator (Steele, Lea & Flood 2014,
/// doi:10.1145/2660193.2660195).
fn next_random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut mixed = *state;
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use stosszahl_model::Particle;

    fn normal(stream: &mut Xoshiro256PlusPlus) -> Vector3<f64> {
        let [x, y]: [f64; 2] = std::array::from_fn(|_| stream.sample(StandardNormal));
        Vector3::new(x, y, 0.0)
    }

    /// Creates a gas of points in the plane with a shear flow, at temperature 4 and mass 1.
    fn gas(stream: &mut Xoshiro256PlusPlus, count: usize, side: f64, shear: f64) -> Particles {
        let one = |_| {
            let mut particle = Particle::at_rest(0.5, 1.0);
            particle.position = Vector3::new(
                side * stream.random::<f64>(),
                side * stream.random::<f64>(),
                0.0,
            );
            let angle = std::f64::consts::TAU * particle.position.y / side;
            particle.velocity = 2.0 * normal(stream) + shear * angle.sin() * Vector3::x();
            particle
        };
        Particles {
            time: 0.0,
            dimension: 2,
            lengths: [side, side, 0.0],
            periodic: [true; 3],
            all: (0..count).map(one).collect(),
        }
    }

    /// Collisions that are drawn from the velocities of the gas itself with a chance in proportion
    /// to their normal speed: what chaos is. A strong shear flow changes nothing, since the
    /// temperature is that about it. Moments are found from 60 000 collisions; spreads of g^p over
    /// its mean are 0.5 to 1.5 (of 1/g without bound, though its logarithm grows slowly; 3 for it),
    /// so four standard errors are 2.5 %, to which the shear within a cell, 4 % of the flow, adds
    /// less.
    #[test]
    fn chaos_by_direct_sampling_is_one() {
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(7);
        let gas = gas(stream, 20_000, 200.0, 6.0);
        let mut contacts = ContactObserver::new(&[[0.0, 1.0]], &gas);
        contacts.sample_gas(0.0, &gas);
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); contacts.local.places.len()];
        for (who, one) in gas.all.iter().enumerate() {
            members[contacts.local.cell(&one.position)].push(who);
        }
        let mut found = 0;
        while found < 60_000 {
            let i = stream.random_range(0..gas.all.len());
            let cell = &members[contacts.local.cell(&gas.all[i].position)];
            let j = cell[stream.random_range(0..cell.len())];
            let angle = std::f64::consts::TAU * stream.random::<f64>();
            let line = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let relative = gas.all[i].velocity - gas.all[j].velocity;
            if i == j || -relative.dot(&line) < 30.0 * stream.random::<f64>() {
                continue;
            }
            found += 1;
            contacts.on_collisions(&[Collision {
                time: 0.5,
                position: gas.all[i].position,
                pair: [i as u32, j as u32],
                ..Collision::at_contact(relative, line, 0.5, 1.0)
            }]);
        }
        let sums = contacts.windows[0].1;
        assert!(sums.known > 0.95 * 60_000.0);
        for (order, (found, chaos)) in ORDERS.iter().zip(sums.before.iter().zip(sums.chaos)) {
            let ratio = found / chaos;
            assert!((ratio - 1.0).abs() < 0.04, "order {order}: {ratio}");
        }
        // Slopes are known to 12 sqrt(1/12/n) = 0.02 of half the collisions; both contain the shear
        // flow of none.
        for (sum, count) in sums.impacts.iter().zip(sums.pairs) {
            let slope = 12.0 * (sum / count - 0.5);
            assert!(slope.abs() < 4.0 * (12.0 / count).sqrt(), "{slope}");
        }
        // Of 24 in a cell, 45 pairs have one of two partners; all are met alike, so one in 45 is
        // the pair that met last.
        assert_eq!(sums.named, 60_000.0);
        let again = sums.again / sums.named;
        assert!((0.01..0.03).contains(&again), "{again}");
    }

    /// Real pairs near contact that move apart sideways graze; shuffled pairs do not.
    #[test]
    fn shuffling_keeps_flow_and_loses_what_partners_know() {
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(8);
        let mut gas = gas(stream, 20_000, 100.0, 6.0);
        let slopes = |gas: &Particles| {
            let mut contacts = ContactObserver::new(&[[0.0, 1.0]], gas);
            contacts.sample_gas(0.0, gas);
            let sums = contacts.windows[0].1;
            let slope = |kind: usize| 12.0 * (sums.flux_impacts[kind] / sums.flux[kind] - 0.5);
            let across = sums.velocities[0].map(|one| one.products[1] / one.squares[1]);
            (slope(0), slope(1), across, sums.heat[0] / sums.heat[1])
        };
        // Points have 20 000^2/10^4/2 pi (1.1^2 - 1) = 13 000 pairs near contact, half of which
        // approach: errors are 0.04.
        let (real, shuffled, across, heat) = slopes(&gas);
        // A flow of amplitude 6 has the mean square 18, half of which is one of two components: 9
        // beside the temperature of 4.
        assert!((heat - 4.0 / 13.0).abs() < 0.02, "{heat}");
        assert!(
            real.abs() < 0.17 && shuffled.abs() < 0.17,
            "{real} {shuffled}"
        );
        // Temperature 4 and a flow of mean square 18 along x, half of which is across the line:
        // 9/(9 + 4), to which the shear over a line adds less than the errors of 0.02. Points know
        // nothing of each other, so that shuffling changes nothing.
        for across in across {
            assert!(
                (across - 9.0 / 13.0).abs() < 0.1,
                "the flow is common: {across}"
            );
        }
        let mut pairs = Vec::new();
        each_pair(&gas, NEAR, |pair, line, _| pairs.push((pair, line)));
        for ([i, j], line) in pairs {
            // The normal part of the relative velocity is halved.
            let along = line.normalize();
            let normal = 0.25 * (gas.all[i].velocity - gas.all[j].velocity).dot(&along) * along;
            gas.all[i].velocity -= normal;
            gas.all[j].velocity += normal;
        }
        let (real, shuffled, ..) = slopes(&gas);
        assert!(real > 0.4, "{real}");
        assert!(shuffled.abs() < 0.17, "{shuffled}");
    }

    /// Pairs, and their velocities by distance, by the oracle of all pairs.
    #[test]
    fn pairs_are_those_of_all_pairs() {
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(9);
        for side in [2.5, 3.5, 20.0] {
            let gas = gas(stream, 200, side, 0.0);
            let reach = EDGES[DISTANCES];
            let (mut fast, mut plain) = (Vec::new(), Vec::new());
            each_pair(&gas, reach, |pair, _, _| fast.push(pair));
            let drift = gas.all.iter().map(|one| one.velocity).sum::<Vector3<f64>>() / 200.0;
            let mut sums = [Products::default(); DISTANCES];
            for i in 0..200 {
                for j in 0..i {
                    let mut line = gas.all[i].position - gas.all[j].position;
                    line.apply(|x| *x -= side * (*x / side).round());
                    let distance = line.norm();
                    if !(1.0..reach).contains(&distance) {
                        continue;
                    }
                    plain.push([i, j]);
                    let bin = (0..DISTANCES).find(|&bin| distance < EDGES[bin + 1]);
                    let sums = &mut sums[bin.expect("in reach")];
                    let [a, b] = [i, j].map(|who| gas.all[who].velocity - drift);
                    let (along, across) = (line / distance, Vector3::z().cross(&line) / distance);
                    for (axis, unit) in [along, across].into_iter().enumerate() {
                        let [a, b] = [a, b].map(|velocity| velocity.dot(&unit));
                        sums.products[axis] += a * b;
                        sums.squares[axis] += 0.5 * (a * a + b * b);
                    }
                }
            }
            fast.sort_unstable();
            assert_eq!(fast, plain);
            let mut contacts = ContactObserver::new(&[[0.0, 1.0]], &gas);
            contacts.sample_gas(0.0, &gas);
            for (found, plain) in contacts.windows[0].1.velocities.iter().zip(sums) {
                for axis in 0..2 {
                    // Rounding of sums of some thousand terms of order ten.
                    assert!((found[0].products[axis] - plain.products[axis]).abs() < 1e-8);
                    assert!((found[0].squares[axis] - plain.squares[axis]).abs() < 1e-8);
                }
            }
        }
    }
}
