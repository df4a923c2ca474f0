//! Checks of a case for implausible numbers, each of which is allowed: mistaken units, unbalanced
//! forces, contact times that switch collisions off. Also lists what the time estimate ignores.

use std::f64::consts::PI;

use stosszahl_case::format::{FaceSpec, UnitsSpec};
use stosszahl_results::{format_number, format_percent};

use super::data::{CasePlan, EngineKind};

/// Share of elastic contacts at the start from which a warning about the contact time is given.
const MANY_ELASTIC: f64 = 0.1;
/// Fastest plausible speed of granular particles \[m/s\].
const FAST_GRAINS: f64 = 100.0;
/// Fastest plausible speed of molecules \[m/s\].
const FAST_MOLECULES: f64 = 1e4;
/// Diameter from which particles count as grains, not molecules \[m\].
const GRAIN: f64 = 1e-7;
/// Plausible mass densities of a particle, from an aerogel to more than any element \[kg/m^3\].
const DENSITIES: std::ops::RangeInclusive<f64> = 10.0..=5e4;
/// Ratio of largest to smallest diameter from which exact dynamics is slower than its time
/// estimate, because its cell grids fit the smallest disks.
const UNLIKE: f64 = 2.0;
/// Speed of a wall or of a fall through the box, in thermal speeds, from which the gas soon differs
/// from its start.
const DRIVEN: f64 = 2.0;

/// Source of heat or motion in a flow: a wall, an obstacle or an inflow.
struct Source {
    key: String,
    temperature: Option<f64>,
    speed: f64,
}

impl CasePlan {
    /// Returns warnings about settings that are allowed but probably mistaken, a sentence each.
    pub(super) fn implausible(&self) -> Vec<String> {
        let mut list = Vec::new();
        list.extend(self.elastic_by_contact_time());
        list.extend(self.falls_for_ever());
        if self.case.units == UnitsSpec::Si {
            list.extend(self.implausible_in_si());
        }
        list
    }

    /// Warns of a contact time so long that many particles collide again within it, which makes
    /// their contacts elastic.
    fn elastic_by_contact_time(&self) -> Option<String> {
        let contact_time = self.engines.iter().find_map(|engine| match engine.kind {
            EngineKind::EventDriven { contact_time, .. } => Some(contact_time),
            _ => None,
        })?;
        if contact_time == 0.0 || self.is_elastic() {
            return None;
        }
        // Neither of the two has collided within the contact time, at the rate of the start.
        let elastic = 1.0 - (-2.0 * contact_time / self.clock.mean_free_time).exp();
        (elastic > MANY_ELASTIC).then(|| {
            format!(
                "engine.ed.contact_time is {} mean free times of the start, so that {} of the contacts are elastic from the start on, \
                 whatever the restitution; contact times well below a hundredth of the mean free time change contacts in collapse alone",
                format_number(contact_time / self.clock.mean_free_time),
                format_percent(elastic)
            )
        })
    }

    /// Warns of gravity along a periodic axis, along which nothing balances it.
    fn falls_for_ever(&self) -> Option<String> {
        let pull = self.gas.particles.gravity?;
        let takes_up = |wall: &FaceSpec| match wall {
            FaceSpec::Wall(wall) => {
                wall.temperature.is_some() || wall.slip.is_some_and(|slip| slip < 1.0)
            }
            FaceSpec::Word(_) => false,
        };
        let held = self.case.walls.all_faces().any(takes_up) || !self.case.obstacle.is_empty();
        let open = !self.case.inflow.is_empty();
        let periodic = |axis: &usize| self.is_periodic_along(*axis);
        let axis = (0..self.gas.dimension)
            .filter(|axis| pull[*axis] != 0.0)
            .find(periodic)?;
        let speed = pull[axis].abs() * self.case.run.until * self.clock.time;
        (!held && !open).then(|| {
            format!(
                "gravity.acceleration along {}: the box is periodic there and nothing in it takes up momentum, so the whole gas falls for \
                 ever, at {} thermal speeds of the start when the run ends; walls across that axis, rough walls along it or obstacles \
                 hold it",
                ["x", "y", "z"][axis],
                format_number(speed / self.thermal_speed())
            )
        })
    }

    /// Warns of mistaken SI units: kelvin in place of joules, grams or millimetres in place of
    /// kilograms and metres.
    fn implausible_in_si(&self) -> Vec<String> {
        let mut list = Vec::new();
        let scale = self.scale;
        let diameters = || {
            self.gas
                .species
                .iter()
                .map(|one| 2.0 * one.radius * scale.length)
        };
        let smallest = diameters().fold(f64::INFINITY, f64::min);
        let fast = if smallest > GRAIN {
            FAST_GRAINS
        } else {
            FAST_MOLECULES
        };
        let lightest = (self.gas.species.iter())
            .map(|one| one.mass * scale.mass)
            .fold(f64::INFINITY, f64::min);
        // Where the case says a speed, it is meant.
        let hottest = (self.gas.species.iter())
            .filter(|_| self.case.gas.rms_speed.is_none())
            .map(|one| (one.temperature * scale.energy, one.mass * scale.mass))
            .max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
        let start =
            hottest.map(|(temperature, mass)| ("gas.temperature".to_owned(), temperature, mass));
        let others = self.sources().into_iter().filter_map(|source| {
            Some((
                format!("{}.temperature", source.key),
                source.temperature?,
                lightest,
            ))
        });
        for (key, temperature, mass) in start.into_iter().chain(others) {
            let speed = (temperature / mass).sqrt();
            if speed > fast {
                list.push(format!(
                    "units = \"si\": {key} = {} gives particles of {} kg a thermal speed of {} m/s; a granular temperature is the energy \
                     m <v^2>/D in joules, not kelvin (gas.rms_speed says the speed itself)",
                    format_number(temperature),
                    format_number(mass),
                    format_number(speed)
                ));
                break;
            }
        }
        for source in self
            .sources()
            .into_iter()
            .filter(|source| source.speed > fast)
        {
            list.push(format!(
                "units = \"si\": {} moves at {} m/s; lengths are in metres, times of walls and streams in seconds",
                source.key,
                format_number(source.speed)
            ));
        }
        let density = |one: &super::SpeciesPlan| {
            let diameter = 2.0 * one.radius * scale.length;
            (
                one.mass * scale.mass / (PI / 6.0 * diameter.powi(3)),
                diameter,
                one.mass * scale.mass,
            )
        };
        let odd = self
            .gas
            .species
            .iter()
            .map(density)
            .find(|one| !DENSITIES.contains(&one.0));
        if let Some((density, diameter, mass)) = odd {
            list.push(format!(
                "units = \"si\": particles of {} m and {} kg have a density of {} kg/m^3; diameters are in metres and masses in kilograms",
                format_number(diameter),
                format_number(mass),
                format_number(density)
            ));
        }
        list
    }

    /// Lists the walls, obstacles and inflows that heat or move the gas, in engine units; empty
    /// unless the case is a flow.
    fn sources(&self) -> Vec<Source> {
        let length = |vector: &[f64]| vector.iter().map(|one| one * one).sum::<f64>().sqrt();
        let faces = stosszahl_case::format::FACES.iter().flatten();
        let walls = faces
            .zip(self.case.walls.all_faces())
            .filter_map(|(name, face)| {
                let FaceSpec::Wall(wall) = face else {
                    return None;
                };
                let sliding = length(wall.sliding.as_deref().unwrap_or_default());
                // There and back in a period.
                let shaking = wall
                    .vibration
                    .map_or(0.0, |one| 2.0 * one.amplitude / one.period);
                Some(Source {
                    key: format!("walls.{name}"),
                    temperature: wall.temperature,
                    speed: sliding.max(shaking),
                })
            });
        let obstacles = self.case.obstacle.iter().enumerate();
        let obstacles = obstacles.map(|(number, one)| Source {
            key: format!("obstacle.{}", number + 1),
            temperature: one.temperature,
            speed: 0.0,
        });
        let inflows = self.case.inflow.iter().enumerate();
        let inflows = inflows.map(|(number, one)| Source {
            key: format!("inflow.{}", number + 1),
            temperature: one.temperature,
            speed: length(&one.velocity),
        });
        walls.chain(obstacles).chain(inflows).collect()
    }

    /// Estimates the fastest speed that the start, walls, inflows, gravity or kicks give to
    /// particles \[engine speed\].
    fn fastest_speed(&self) -> f64 {
        let lightest = (self.gas.species.iter())
            .map(|one| one.mass)
            .fold(f64::INFINITY, f64::min);
        let thermal = |temperature: f64| (temperature / lightest).sqrt();
        let start = (self.gas.species.iter())
            .map(|one| (one.temperature / one.mass).sqrt())
            .fold(0.0, f64::max);
        let sources = self.sources().into_iter();
        let sources = sources.map(|one| thermal(one.temperature.unwrap_or(0.0)).max(one.speed));
        let heated = self.steady_guess().map_or(0.0, thermal);
        sources.fold(start.max(heated), f64::max).max(self.fall())
    }

    /// Returns the speed gained in a fall through the box, or until the end of the run without a
    /// floor \[engine speed\].
    fn fall(&self) -> f64 {
        let pull = self.gas.particles.gravity.unwrap_or_default();
        let speed = |axis: usize| {
            let pull = pull[axis].abs();
            if self.is_periodic_along(axis) {
                pull * self.case.run.until * self.clock.time
            } else {
                (2.0 * pull * self.gas.lengths[axis]).sqrt()
            }
        };
        (0..self.gas.dimension).map(speed).fold(0.0, f64::max)
    }

    /// Estimates the largest collision rate of a particle to expect \[1/engine time\]: the rate of
    /// the start, or the fastest speed over a diameter.
    pub(super) fn natural_rate(&self) -> f64 {
        let diameters = self.gas.species.iter().map(|one| 2.0 * one.radius);
        let smallest = diameters
            .filter(|one| *one > 0.0)
            .fold(f64::INFINITY, f64::min);
        (self.fastest_speed() / smallest).max(1.0 / self.clock.mean_free_time)
    }

    /// Lists properties of the case that the time estimate ignores, a sentence each.
    pub fn unknown_to_the_estimate(&self) -> Vec<String> {
        let mut list = Vec::new();
        if self.gas.lengths[0] == 0.0 {
            return list;
        }
        let exact = self.engine("ed").is_some();
        let diameters = || self.diameter_range();
        let (least, most) = diameters();
        if exact && most > UNLIKE * least && least > 0.0 {
            list.push(format!(
                "diameters differ by a factor of {}: exact dynamics looks at more candidates for each of its collisions",
                format_number(most / least)
            ));
        }
        let thermal = self.thermal_speed();
        if self.fall() > DRIVEN * thermal {
            list.push(format!(
                "gravity: a fall through the box gains {} thermal speeds, and what has fallen lies densely; both raise the number of \
                 collisions, of which the start alone is counted",
                format_number(self.fall() / thermal)
            ));
        }
        for source in self.sources() {
            let heat = source.temperature.unwrap_or(0.0) / self.gas.temperature;
            if source.speed > DRIVEN * thermal {
                list.push(format!(
                    "{}: it moves at {} thermal speeds, and the faster gas collides as much more often",
                    source.key,
                    format_number(source.speed / thermal)
                ));
            } else if heat.sqrt() > DRIVEN {
                list.push(format!(
                    "{}: it is {} times as hot as the start, and the hotter gas collides more often by the root of that",
                    source.key,
                    format_number(heat)
                ));
            }
        }
        if exact && self.gas.packing_fraction > 0.5 && self.gas.restitution < 1.0 {
            list.push(format!(
                "a packing fraction of {} with restitution {}: dense clusters collide far more often than the start",
                format_number(self.gas.packing_fraction),
                format_number(self.gas.restitution)
            ));
        }
        list
    }

    /// Returns the smallest and largest diameter of all particles \[length\].
    fn diameter_range(&self) -> (f64, f64) {
        let mut range = (f64::INFINITY, 0.0_f64);
        let mut add = |radius: f64| range = (range.0.min(2.0 * radius), range.1.max(2.0 * radius));
        match &self.gas.particles.sizes {
            stosszahl_model::SizeDistribution::Equal(one) => add(one.radius),
            stosszahl_model::SizeDistribution::Each(all) => {
                all.pairs().iter().for_each(|one| add(one.0));
            }
            stosszahl_model::SizeDistribution::Species(species) => {
                species.kinds().iter().for_each(|one| add(one.radius));
            }
        }
        range
    }
}
