//! What happens at contact, against molecular chaos at the temperature of the place: the observatory of broken chaos.
//!
//! Under molecular chaos partners are drawn from the velocities of the place, independently, and met with a chance in proportion to
//! their normal relative speed g. With local Maxwellian velocities its square is then exponential,
//! `P(g) = (μ g/T) exp(-μ g²/(2 T))`, in any dimension and whatever the flow is on larger scales, so
//!
//! ```text
//! <g^p> = (2 T/μ)^(p/2) Γ(1 + p/2)        before contact, and r^p times that after it
//! ```
//!
//! with the reduced mass μ and the coefficient of restitution r ([`moment_of_chaos`]). T is the granular temperature about the
//! local flow: of the some [`LOCAL`] disks of a cell, about a velocity that is linear in the place. It is taken at looks at the gas,
//! follows the temperature of the whole gas between two looks, and its powers are freed of the bias that few disks give them.
//! The *total* temperature would take flow for heat. Velocities are not quite Maxwellian in a cooling gas: with the fourth cumulant
//! a2 moments of order p change by about `a2 p (p - 2)/16` of themselves, below .5 % at the restitutions of gases.
//!
//! *Shuffled pairs* tell short-range correlations from shear. Of pairs that approach each other within a tenth of a diameter of
//! contact, weighted by their normal speed, the slope of P(b/d) is what it will be at contact. The same pairs, but with
//! velocities about the local flow that are those of two other disks of the same cells, keep flow, shear, temperatures and places,
//! and lose all that partners know of each other.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use statrs::function::gamma::{gamma, ln_gamma};
use stosszahl_model::{Collision, Observer, Particles};

/// Disks of a cell, on average, of which the local flow and temperature are those.
pub const LOCAL: f64 = 24.0;
/// Pairs up to this distance over their contact distance count as near contact.
pub const NEAR: f64 = 1.1;
/// Collisions of a particle among which a former partner is looked for.
pub const MEMORY: usize = 8;
/// Orders p of the moments of the normal speed.
pub const ORDERS: [i32; 4] = [-1, 1, 2, 3];

/// Moment `<g^p>` of the normal relative speed of colliding pairs under molecular chaos, `(2 T/μ)^(p/2) Γ(1 + p/2)`.
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

/// Mean of the power `T^q` of a temperature that is found from `freedom` squares, over that power of the true one.
fn bias(power: f64, freedom: f64) -> f64 {
    let half = 0.5 * freedom;
    (ln_gamma(half + power) - ln_gamma(half) - power * half.ln()).exp()
}

/// Sums over what happened in one window of time. Ratios of them are what is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sums {
    /// Collisions, each of the weight of its simulators.
    pub physical: f64,
    /// Collisions where the local temperature is known.
    pub known: f64,
    /// Powers of the normal speed before contact.
    pub before: [f64; 4],
    /// Powers of the normal speed after contact.
    pub after: [f64; 4],
    /// What chaos expects of each of them before contact.
    pub chaos: [f64; 4],
    /// Collisions of slow and of fast pairs.
    pub pairs: [f64; 2],
    /// Their (b/d)^(D-1).
    pub impacts: [f64; 2],
    /// Collisions whose partners are known by their index.
    pub named: f64,
    /// Those whose partners met each other last, with no collision of either since.
    pub again: f64,
    /// Those whose partners have met within the last [`MEMORY`] collisions of both.
    pub returned: f64,
    /// Collisions of both since, summed over these.
    pub between: f64,
    /// Normal speed of approaching pairs near contact; of pairs as they are, and shuffled.
    pub flux: [f64; 2],
    /// The same times (b/d)^(D-1).
    pub flux_impacts: [f64; 2],
    /// Products of the velocities of both partners of a pair near contact, along the line of centres and across it.
    pub products: [f64; 2],
    /// Their mean squares.
    pub squares: [f64; 2],
}

/// Flow and temperature around the particles, in cells.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Local {
    cells: [usize; 3],
    lengths: [f64; 3],
    places: Vec<Place>,
}

/// One cell: how many particles, temperature (0 if unknown), and squares that it is from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Place {
    count: usize,
    temperature: f64,
    freedom: f64,
}

/// What is known of the last meeting of two partners.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Meeting {
    /// The engine does not tell particles apart.
    Unknown,
    /// None within the memory.
    New,
    /// So many collisions of both together ago.
    After(usize),
}

/// The linear flow of a cell.
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
    /// The cell of a place, which may be in another image of the box.
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

    /// Flow and temperature of all cells; velocities about the flow, free of what the fit takes from their spread, by particle, and the cells
    /// of all particles.
    fn of(particles: &Particles) -> (Self, Vec<Flow>, Vec<Vector3<f64>>, Vec<usize>) {
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
            // The fit takes D + 1 numbers for each component; three times as many particles leave a spread to speak of.
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

/// Observes contacts in windows of time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contacts {
    /// Start and end of each window \[time\], not included, with its sums.
    pub windows: Vec<([f64; 2], Sums)>,
    dimension: usize,
    number: f64,
    local: Local,
    /// Temperature of the whole gas now, and at the last look.
    temperature: [f64; 2],
    /// Former partners of each simulator, the last one first.
    partners: Vec<[u32; MEMORY]>,
}

impl Contacts {
    /// Windows `[start, end)` of a gas; they may overlap.
    pub fn new(spans: &[[f64; 2]], particles: &Particles) -> Self {
        let mut contacts = Self {
            windows: spans.iter().map(|&span| (span, Sums::default())).collect(),
            dimension: particles.dimension,
            number: particles.all.iter().map(|one| one.weight).sum(),
            local: Local::default(),
            temperature: [1.0; 2],
            partners: vec![[Collision::ANONYMOUS; MEMORY]; particles.all.len()],
        };
        contacts.local = Local::of(particles).0;
        contacts.temperature = [particles.temperature(); 2];
        contacts
    }

    /// Sets the temperature of the whole gas, so that rounding in the running energy never adds up.
    pub fn synchronise(&mut self, temperature: f64) {
        self.temperature[0] = temperature;
    }

    /// Looks at the gas: local flow and temperature from now on, and pairs near contact.
    pub fn look(&mut self, time: f64, particles: &Particles) {
        let (local, flows, own, cells) = Local::of(particles);
        self.local = local;
        self.temperature = [particles.temperature(); 2];
        let inside = |span: &[f64; 2]| (span[0]..span[1]).contains(&time);
        if !self.windows.iter().any(|(span, _)| inside(span)) {
            return;
        }
        let mut sums = Sums::default();
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
        let power = self.dimension as i32 - 1;
        let mut draws = time.to_bits();
        each_near(particles, |[i, j], line| {
            let pair = [i, j].map(|who| &particles.all[who]);
            let along = line.normalize();
            let moving = pair.map(|one| one.velocity - drift);
            let parts = moving.map(|velocity| {
                let normal = velocity.dot(&along);
                (normal, velocity - normal * along)
            });
            sums.products[0] += parts[0].0 * parts[1].0;
            sums.squares[0] += 0.5 * (parts[0].0.powi(2) + parts[1].0.powi(2));
            sums.products[1] += parts[0].1.dot(&parts[1].1);
            sums.squares[1] += 0.5 * (parts[0].1.norm_squared() + parts[1].1.norm_squared());
            if [i, j]
                .iter()
                .any(|&who| self.local.places[cells[who]].temperature == 0.0)
            {
                return;
            }
            // Others of the same cells, known by their place in a fixed sequence.
            let other = |who: usize, draws: &mut u64| loop {
                let all = &members[cells[who]];
                let chosen = all[(next(draws) % all.len() as u64) as usize];
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
                flows[cells[who]].at(&particles.all[who].position) + own[other]
            });
            for (kind, relative) in [moving[0] - moving[1], shuffled[0] - shuffled[1]]
                .into_iter()
                .enumerate()
            {
                let normal = relative.dot(&along);
                if normal < 0.0 {
                    let across = (relative - normal * along).norm() / relative.norm();
                    sums.flux[kind] -= normal;
                    sums.flux_impacts[kind] -= normal * across.powi(power);
                }
            }
        });
        for (_, all) in self.windows.iter_mut().filter(|(span, _)| inside(span)) {
            for kind in 0..2 {
                all.flux[kind] += sums.flux[kind];
                all.flux_impacts[kind] += sums.flux_impacts[kind];
                all.products[kind] += sums.products[kind];
                all.squares[kind] += sums.squares[kind];
            }
        }
    }

    /// Particles of the gas, all simulators of each counted once.
    pub fn particles(&self) -> f64 {
        self.number
    }

    fn collision(&mut self, collision: &Collision) {
        let returned = self.remember(collision.pair);
        let inside = |span: &[f64; 2]| (span[0]..span[1]).contains(&collision.time);
        for (_, sums) in self.windows.iter_mut().filter(|(span, _)| inside(span)) {
            sums.physical += collision.weight;
            if returned != Meeting::Unknown {
                sums.named += 1.0;
                if let Meeting::After(between) = returned {
                    sums.again += f64::from(u8::from(between == 0));
                    sums.returned += 1.0;
                    sums.between += between as f64;
                }
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
                    sums.after[index] += (collision.restitution * normal).powi(order);
                    sums.chaos[index] += moment / bias(0.5 * f64::from(order), place.freedom);
                }
                // The mean of μ g² under chaos is (D + 1) T.
                let mean = (self.dimension + 1) as f64 * temperature;
                let fast = usize::from(mass * collision.relative.norm_squared() > mean);
                let impact = collision.impact_square().sqrt();
                sums.pairs[fast] += 1.0;
                sums.impacts[fast] += impact.powi(self.dimension as i32 - 1);
            }
        }
        // T = 2 K/(D N).
        let lost = collision.energy_lost() * collision.weight;
        self.temperature[0] -= 2.0 * lost / (self.dimension as f64 * self.number);
    }

    /// Notes who met whom, and how many collisions both had since they met.
    fn remember(&mut self, pair: [u32; 2]) -> Meeting {
        let [i, j] = pair.map(|who| who as usize);
        if i.max(j) >= self.partners.len() {
            return Meeting::Unknown;
        }
        let since = |who: usize, whom: usize| {
            let known = self.partners[who].iter();
            known.take(MEMORY).position(|&other| other as usize == whom)
        };
        let between = since(i, j).zip(since(j, i)).map(|(a, b)| a + b);
        for (who, whom) in [(i, j), (j, i)] {
            self.partners[who].rotate_right(1);
            self.partners[who][0] = whom as u32;
        }
        between.map_or(Meeting::New, Meeting::After)
    }
}

impl Observer for Contacts {
    fn collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            self.collision(collision);
        }
    }
}

/// The next number of a fixed sequence: splitmix64 (Steele, Lea & Flood 2014, doi:10.1145/2660193.2660195).
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut mixed = *state;
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// Calls for each pair between contact and [`NEAR`] of it, with the line from the second to the first.
fn each_near(particles: &Particles, mut call: impl FnMut([usize; 2], Vector3<f64>)) {
    let largest = particles
        .all
        .iter()
        .map(|one| one.radius)
        .fold(0.0, f64::max);
    let (range, dimension) = (2.0 * NEAR * largest, particles.dimension);
    let count = |axis: usize| {
        let fit = (particles.lengths[axis] / range) as usize;
        // No more cells than particles, however large the box is.
        let most = particles.all.len();
        if axis < dimension && range > 0.0 {
            fit.clamp(1, most.max(1))
        } else {
            1
        }
    };
    let cells: [usize; 3] = std::array::from_fn(count);
    let wrap =
        |share: f64, count: usize| ((share.rem_euclid(1.0) * count as f64) as usize).min(count - 1);
    let of = |place: &Vector3<f64>| -> [usize; 3] {
        std::array::from_fn(|axis| match particles.lengths[axis] {
            length if length > 0.0 => wrap(place[axis] / length, cells[axis]),
            _ => 0,
        })
    };
    let number = |at: [usize; 3]| at[0] + cells[0] * (at[1] + cells[1] * at[2]);
    let mut members: std::collections::BTreeMap<usize, Vec<usize>> =
        std::collections::BTreeMap::new();
    for (who, one) in particles.all.iter().enumerate() {
        members
            .entry(number(of(&one.position)))
            .or_default()
            .push(who);
    }
    for (i, one) in particles.all.iter().enumerate() {
        let at = of(&one.position);
        let mut seen = Vec::with_capacity(27);
        for step in 0..27_usize {
            let steps = [step % 3, step / 3 % 3, step / 9];
            let to = std::array::from_fn(|axis| {
                (at[axis] + steps[axis] + cells[axis] - 1) % cells[axis]
            });
            let cell = number(to);
            if seen.contains(&cell) {
                continue;
            }
            seen.push(cell);
            for &j in members.get(&cell).into_iter().flatten().filter(|&&j| j < i) {
                let other = &particles.all[j];
                let mut line = one.position - other.position;
                for axis in 0..dimension {
                    let length = particles.lengths[axis];
                    if particles.periodic[axis] && length > 0.0 {
                        line[axis] -= length * (line[axis] / length).round();
                    }
                }
                let contact = one.radius + other.radius;
                let square = line.norm_squared();
                if square >= contact * contact && square < (NEAR * contact).powi(2) {
                    call([i, j], line);
                }
            }
        }
    }
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

    /// A gas of points in the plane with a shear flow, at temperature 4 and mass 1.
    fn gas(stream: &mut Xoshiro256PlusPlus, count: usize, side: f64, shear: f64) -> Particles {
        let one = |_| {
            let mut particle = Particle::of(0.5, 1.0);
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

    /// Collisions that are drawn from the velocities of the gas itself with a chance in proportion to their normal speed: what chaos is.
    /// A strong shear flow changes nothing, since the temperature is that about it. Moments are found from 60 000 collisions; spreads
    /// of g^p over its mean are 0.5 to 1.5 (of 1/g without bound, though its logarithm grows slowly; 3 for it), so four standard
    /// errors are 2.5 %, to which the shear within a cell, 4 % of the flow, adds less.
    #[test]
    fn chaos_by_direct_sampling_is_one() {
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(7);
        let gas = gas(stream, 20_000, 200.0, 6.0);
        let mut contacts = Contacts::new(&[[0.0, 1.0]], &gas);
        contacts.look(0.0, &gas);
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
            contacts.collisions(&[Collision {
                time: 0.5,
                position: gas.all[i].position,
                relative,
                line,
                reduced_mass: 0.5,
                restitution: 1.0,
                weight: 1.0,
                pair: [i as u32, j as u32],
                species: [0; 2],
            }]);
        }
        let sums = contacts.windows[0].1;
        assert!(sums.known > 0.95 * 60_000.0);
        for (order, (found, chaos)) in ORDERS.iter().zip(sums.before.iter().zip(sums.chaos)) {
            let ratio = found / chaos;
            assert!((ratio - 1.0).abs() < 0.04, "order {order}: {ratio}");
        }
        // Slopes are known to 12 sqrt(1/12/n) = 0.02 of half the collisions; both contain the shear flow of none.
        for (sum, count) in sums.impacts.iter().zip(sums.pairs) {
            let slope = 12.0 * (sum / count - 0.5);
            assert!(slope.abs() < 4.0 * (12.0 / count).sqrt(), "{slope}");
        }
        // Of 24 in a cell, 45 pairs have one of two partners; all are met alike, so one in 45 is the pair that met last.
        assert_eq!(sums.named, 60_000.0);
        let again = sums.again / sums.named;
        assert!((0.01..0.03).contains(&again), "{again}");
    }

    /// Partners near contact that move apart sideways: real pairs graze, shuffled ones do not.
    #[test]
    fn shuffling_keeps_flow_and_loses_what_partners_know() {
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(8);
        let mut gas = gas(stream, 20_000, 100.0, 6.0);
        let slopes = |gas: &Particles| {
            let mut contacts = Contacts::new(&[[0.0, 1.0]], gas);
            contacts.look(0.0, gas);
            let sums = contacts.windows[0].1;
            let slope = |kind: usize| 12.0 * (sums.flux_impacts[kind] / sums.flux[kind] - 0.5);
            let across = sums.products[1] / sums.squares[1];
            (slope(0), slope(1), across)
        };
        // Points have 20 000^2/10^4/2 pi (1.1^2 - 1) = 13 000 pairs near contact, half of which approach: errors are 0.04.
        let (real, shuffled, across) = slopes(&gas);
        assert!(
            real.abs() < 0.17 && shuffled.abs() < 0.17,
            "{real} {shuffled}"
        );
        assert!(across > 0.2, "the flow is common: {across}");
        let mut pairs = Vec::new();
        each_near(&gas, |pair, line| pairs.push((pair, line)));
        for ([i, j], line) in pairs {
            // The normal part of the relative velocity is halved.
            let along = line.normalize();
            let normal = 0.25 * (gas.all[i].velocity - gas.all[j].velocity).dot(&along) * along;
            gas.all[i].velocity -= normal;
            gas.all[j].velocity += normal;
        }
        let (real, shuffled, _) = slopes(&gas);
        assert!(real > 0.4, "{real}");
        assert!(shuffled.abs() < 0.17, "{shuffled}");
    }

    /// Near pairs by the oracle of all pairs.
    #[test]
    fn near_pairs_are_those_of_all_pairs() {
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(9);
        for side in [2.5, 3.5, 20.0] {
            let gas = gas(stream, 200, side, 0.0);
            let (mut fast, mut plain) = (Vec::new(), Vec::new());
            each_near(&gas, |pair, _| fast.push(pair));
            for i in 0..200 {
                for j in 0..i {
                    let mut line = gas.all[i].position - gas.all[j].position;
                    line.apply(|x| *x -= side * (*x / side).round());
                    if (1.0..NEAR * NEAR).contains(&line.norm_squared()) {
                        plain.push([i, j]);
                    }
                }
            }
            fast.sort_unstable();
            assert_eq!(fast, plain);
        }
    }

    #[test]
    fn meetings_are_remembered() {
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(10);
        let mut contacts = Contacts::new(&[], &gas(stream, 30, 10.0, 0.0));
        assert_eq!(contacts.remember([1, 2]), Meeting::New);
        assert_eq!(contacts.remember([2, 1]), Meeting::After(0));
        assert_eq!(contacts.remember([1, 3]), Meeting::New);
        assert_eq!(contacts.remember([4, 2]), Meeting::New);
        assert_eq!(contacts.remember([1, 2]), Meeting::After(2));
        assert_eq!(
            contacts.remember([Collision::ANONYMOUS; 2]),
            Meeting::Unknown
        );
        for other in 10..10 + MEMORY as u32 {
            contacts.remember([1, other]);
        }
        assert_eq!(contacts.remember([1, 2]), Meeting::New);
    }
}
