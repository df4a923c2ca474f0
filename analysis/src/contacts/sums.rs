//! Sums over collisions and over pairs near contact, from which contact statistics are computed.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::DISTANCES;
use super::history::{LONGEST_RING, MOST_BETWEEN, Past};

/// Adds an array of terms to an array of sums, element by element.
fn plus<const N: usize>(sums: &mut [f64; N], terms: &[f64; N]) {
    for (sum, term) in sums.iter_mut().zip(terms) {
        *sum += term;
    }
}

/// Sums over the collisions and near pairs of one time window. Contact statistics are ratios of
/// these sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactSums {
    /// Number of physical collisions: each counts the weight of its simulators.
    pub physical: f64,
    /// Number of physical collisions at places where the local temperature is known.
    pub known: f64,
    /// Sums over collisions of the powers [`ORDERS`](super::ORDERS) of the normal speed before
    /// contact.
    pub before: [f64; 4],
    /// Sums over collisions of the powers [`ORDERS`](super::ORDERS) of the normal speed after
    /// contact.
    pub after: [f64; 4],
    /// Expected sums, under molecular chaos, of the powers [`ORDERS`](super::ORDERS) of the normal
    /// speed before contact.
    pub chaos: [f64; 4],
    /// Number of collisions of slow and of fast pairs: squared relative speed below and above its
    /// mean under molecular chaos.
    pub pairs: [f64; 2],
    /// Sums of (b/d)^(D-1), b the impact parameter, of slow and of fast colliding pairs.
    pub impacts: [f64; 2],
    /// Number of collisions whose partners have an index, so that their past is known.
    pub named: f64,
    /// Number of recollisions: collisions whose partners both collided with each other last.
    pub again: f64,
    /// Number of collisions whose partners have met within the last [`MEMORY`](super::MEMORY)
    /// collisions of both.
    pub returned: f64,
    /// Number of recollisions by the number of collisions that both partners have had since they
    /// met.
    pub between: [f64; MOST_BETWEEN + 1],
    /// Sums over collisions by the common past of the partners, one for each [`Acquaintance`].
    pub met: [MetSums; 3],
    /// Number of ring collisions, by the number of collisions in the ring, first and last included.
    pub rings: [f64; LONGEST_RING + 1],
    /// Sums of the normal speed of approaching pairs near contact: real and shuffled pairs.
    pub flux: [f64; 2],
    /// Sums of the normal speed times (b/d)^(D-1), b the impact parameter, of approaching pairs
    /// near contact: real and shuffled pairs.
    pub flux_impacts: [f64; 2],
    /// Sums over particles of the local temperature, and of the temperature of the whole gas with
    /// its flow \[energy\]. Particles in cells without a temperature are left out.
    pub heat: [f64; 2],
    /// Velocity products of pairs in the distance bins [`super::EDGES`]: of real and of shuffled
    /// pairs.
    pub velocities: [[Products; 2]; DISTANCES],
}

impl ContactSums {
    /// Counts one collision by the collision history of its partners.
    pub(super) fn count_collision(&mut self, past: Past) {
        self.named += 1.0;
        if let Some(between) = past.between {
            self.again += f64::from(u8::from(between == 0));
            self.returned += 1.0;
            self.between[between] += 1.0;
        }
        if let Some(length) = past.ring {
            self.rings[length] += 1.0;
        }
    }

    /// Adds the sums over another set of collisions and pairs.
    pub fn merge(&mut self, other: &Self) {
        self.physical += other.physical;
        self.known += other.known;
        plus(&mut self.before, &other.before);
        plus(&mut self.after, &other.after);
        plus(&mut self.chaos, &other.chaos);
        plus(&mut self.pairs, &other.pairs);
        plus(&mut self.impacts, &other.impacts);
        self.named += other.named;
        self.again += other.again;
        self.returned += other.returned;
        plus(&mut self.between, &other.between);
        for (sums, more) in self.met.iter_mut().zip(&other.met) {
            sums.merge(more);
        }
        plus(&mut self.rings, &other.rings);
        plus(&mut self.flux, &other.flux);
        plus(&mut self.flux_impacts, &other.flux_impacts);
        plus(&mut self.heat, &other.heat);
        for (all, more) in self.velocities.iter_mut().zip(&other.velocities) {
            for (sums, more) in all.iter_mut().zip(more) {
                sums.merge(more);
            }
        }
    }
}

/// Relation of two partners before they collide, from the last [`MEMORY`](super::MEMORY) collisions
/// of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acquaintance {
    /// Partners that have not collided with each other.
    New,
    /// Partners that have collided with each other before.
    Returned,
    /// Partners whose last collision was with each other; they count as `Returned`, too.
    Again,
}

impl Acquaintance {
    /// Returns all relations that apply to two partners with `between` collisions of both since
    /// they met.
    pub(super) fn relations_after(between: Option<usize>) -> &'static [Self] {
        match between {
            None => &[Self::New],
            Some(0) => &[Self::Returned, Self::Again],
            Some(_) => &[Self::Returned],
        }
    }
}

/// Sums over the collisions of partners with one kind of common past, where the local temperature
/// is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MetSums {
    /// Number of collisions of partners in this relation.
    pub count: f64,
    /// Sum of (b/d)^(D-1) over the collisions, b the impact parameter.
    pub impacts: f64,
    /// Sum of the squared normal speed before contact \[length²/time²\].
    pub squares: f64,
    /// Sum of the squared normal speed expected under molecular chaos at the local temperature
    /// \[length²/time²\].
    pub chaos: f64,
}

impl MetSums {
    /// Adds a collision: its (b/d)^(D-1), its squared normal speed, and the squared normal speed
    /// expected under molecular chaos.
    pub(super) fn add(&mut self, uniform: f64, [square, chaos]: [f64; 2]) {
        self.count += 1.0;
        self.impacts += uniform;
        self.squares += square;
        self.chaos += chaos;
    }

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.impacts += other.impacts;
        self.squares += other.squares;
        self.chaos += other.chaos;
    }
}

/// Sums for the velocity correlation of pairs, along the line of centres and perpendicular to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Products {
    /// Sums of the products of the velocities of both partners: along the line of centres, and
    /// perpendicular.
    pub products: [f64; 2],
    /// Sums of the mean squared velocity of both partners: along the line of centres, and
    /// perpendicular.
    pub squares: [f64; 2],
}

impl Products {
    pub(super) fn add(&mut self, velocities: [Vector3<f64>; 2], along: &Vector3<f64>) {
        let [a, b] = velocities.map(|velocity| {
            let normal = velocity.dot(along);
            (normal, velocity - normal * along)
        });
        self.products[0] += a.0 * b.0;
        self.squares[0] += 0.5 * (a.0.powi(2) + b.0.powi(2));
        self.products[1] += a.1.dot(&b.1);
        self.squares[1] += 0.5 * (a.1.norm_squared() + b.1.norm_squared());
    }

    fn merge(&mut self, other: &Self) {
        for axis in 0..2 {
            self.products[axis] += other.products[axis];
            self.squares[axis] += other.squares[axis];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums whose every number is another one, from `first` on.
    fn numbered(first: f64) -> ContactSums {
        let mut next = first - 1.0;
        let mut number = || {
            next += 1.0;
            next
        };
        let mut sums = ContactSums::default();
        // Written through the serialized form, so that no field can be forgotten: all are numbers.
        let bytes = postcard::to_stdvec(&sums).expect("numbers");
        assert_eq!(bytes.len() % 8, 0);
        let filled: Vec<u8> = (0..bytes.len() / 8)
            .flat_map(|_| number().to_le_bytes())
            .collect();
        sums.merge(&postcard::from_bytes(&filled).expect("numbers"));
        sums
    }

    /// Merging adds every number: whole numbers, so exactly.
    #[test]
    fn merging_adds_every_number() {
        let (mut sums, other) = (numbered(1.0), numbered(1000.0));
        sums.merge(&other);
        let bytes = postcard::to_stdvec(&sums).expect("numbers");
        for (index, bytes) in bytes.chunks_exact(8).enumerate() {
            let found = f64::from_le_bytes(bytes.try_into().expect("eight bytes"));
            assert_eq!(found, 1001.0 + 2.0 * index as f64, "number {index}");
        }
    }
}
