//! Bird's selection: any two particles with one majorant for all pairs.
//!
//! The baseline. The majorant is the largest `k(a_c, a_d)(v_c + v_d)` of two classes of size with their largest radii and
//! speeds, which is tighter than the largest radius with the largest speed and as exact; it is raised as soon as a
//! particle exceeds the speed of its class.

use rand::Rng;
use serde::{Deserialize, Serialize};
use stosszahl_model::{Sizes, Vector, memory};

use super::alias::split;
use super::gas::{COLDEST, GONE, Gas, Grains, size_key};
use super::selection::{Candidate, Selection, Standing};

/// Two particles.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pair {
    first: u32,
    second: u32,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Class {
    key: u32,
    radius: f64,
    square: f64,
}

/// See the module.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Bird {
    classes: Vec<Class>,
    majorant: f64,
    rate: f64,
    listed: u32,
}

impl Bird {
    /// Raises the majorant to all pairs with one class, and fits the rate to it and to the list.
    fn raise<P: Grains>(&mut self, gas: &Gas<P>, number: usize) {
        let own = self.classes[number];
        for other in &self.classes {
            let speeds = own.square.sqrt() + other.square.sqrt();
            let pair = gas.kernel().of(own.radius, other.radius) * speeds;
            self.majorant = self.majorant.max(pair);
        }
        self.listed = gas.particles.len() as u32;
        let listed = f64::from(self.listed);
        self.rate = 0.5 * listed * (listed - 1.0).max(0.0) * self.majorant;
    }
}

impl<P: Grains> Selection<P> for Bird {
    type Draw = Pair;
    const NAME: &'static str = "single-majorant";

    fn new() -> Self {
        Self {
            classes: Vec::new(),
            majorant: 0.0,
            rate: 0.0,
            listed: 0,
        }
    }

    fn rebuild(&mut self, gas: &mut Gas<P>) {
        gas.sort();
        self.classes.clear();
        for particle in &mut gas.particles {
            let radius = gas.scene.sizes().radius(particle.tag);
            let key = size_key(radius);
            if self.classes.last().is_none_or(|class| class.key != key) {
                self.classes.push(Class {
                    key,
                    radius,
                    square: 0.0,
                });
            }
            let number = self.classes.len() - 1;
            let class = &mut self.classes[number];
            class.radius = class.radius.max(radius);
            class.square = class.square.max(particle.velocity.square());
            particle.mark = number as u32;
        }
        if self.classes.iter().all(|class| class.square < COLDEST) {
            for class in &mut self.classes {
                class.square = 0.0;
            }
        }
        self.majorant = 0.0;
        self.rate = 0.0;
        for number in 0..self.classes.len() {
            self.raise(gas, number);
        }
    }

    fn rate(&self) -> f64 {
        self.rate
    }

    #[inline]
    fn draw(&self, stream: &mut impl Rng) -> Pair {
        let (first, _) = split(stream.next_u64(), self.listed);
        let (other, _) = split(stream.next_u64(), self.listed - 1);
        Pair {
            first,
            second: other + u32::from(other >= first),
        }
    }

    #[inline]
    fn prefetch_particles(&self, gas: &Gas<P>, draw: &Pair) {
        memory::prefetch(&gas.particles, draw.first as usize);
        memory::prefetch(&gas.particles, draw.second as usize);
    }

    #[inline]
    fn resolve(&self, gas: &Gas<P>, draw: &Pair) -> Option<Candidate> {
        let [first, second] = [draw.first, draw.second].map(|index| &gas.particles[index as usize]);
        if (first.mark == GONE) | (second.mark == GONE) {
            return None;
        }
        let pair = gas.kernel.of(gas.radius(first), gas.radius(second));
        Some(Candidate {
            first: draw.first,
            second: draw.second,
            bound: self.majorant / pair,
        })
    }

    #[inline]
    fn changed(&mut self, gas: &mut Gas<P>, index: u32) -> Standing {
        let particle = &gas.particles[index as usize];
        let number = particle.mark as usize;
        let square = particle.velocity.square();
        if square <= self.classes[number].square {
            return Standing::Kept;
        }
        self.classes[number].square = square;
        self.raise(gas, number);
        Standing::Changed
    }

    fn added(&mut self, gas: &mut Gas<P>, index: u32) -> Standing {
        if 4 * gas.gone > gas.particles.len() {
            return Standing::Outdated;
        }
        let particle = &mut gas.particles[index as usize];
        let radius = gas.scene.sizes().radius(particle.tag);
        let key = size_key(radius);
        let number = self.classes.partition_point(|class| class.key < key);
        let Some(class) = self
            .classes
            .get_mut(number)
            .filter(|class| class.key == key)
        else {
            return Standing::Outdated;
        };
        particle.mark = number as u32;
        class.radius = class.radius.max(radius);
        class.square = class.square.max(particle.velocity.square());
        self.raise(gas, number);
        Standing::Changed
    }

    fn lifetime(&self) -> f64 {
        1.0
    }

    fn bytes(&self) -> usize {
        self.classes.capacity() * size_of::<Class>()
    }
}
