//! Checks of relations between the keys of a case, which a schema of single keys cannot express.

use std::path::Path;

use toml::{Table, Value};

use crate::error::Problem;
use crate::format::{
    Case, EnergyPart, FaceSpec, PlacementSpec, START_FILE_ENDINGS, TimeUnit, VelocitiesSpec,
};
use crate::origin::{split, value_at};

mod engines;
mod particles;
mod space;
mod thermostat;

pub(crate) use thermostat::replaced;

/// Largest number of particles of a gas, 2^31 - 1.
const MOST: f64 = 2_147_483_647.0;

/// Largest number of different masses of a power-law mixture.
const MOST_MASSES: u64 = 100_000;

type Checked = Result<(), Problem>;

/// Creates the problem of a value that is not allowed, or of its absence. `key` is dotted, with
/// elements of lists counted from 1.
pub(crate) fn refusal(table: &Table, key: &str, allowed: impl Into<String>) -> Problem {
    let key = split(key);
    match value_at(table, &key) {
        Some(value) => Problem::bad(&key, value, allowed),
        None => Problem::missing(&key, allowed),
    }
}

/// Checks the relations between keys of a case that has passed its schema. `folder` holds the case
/// file.
pub(crate) fn check_relations(table: &Table, case: &Case, folder: &Path) -> Checked {
    let all = Relations { table, case };
    all.places()?;
    all.particles()?;
    all.species()?;
    all.laws()?;
    all.start(folder)?;
    all.region()?;
    all.temperatures()?;
    all.spins()?;
    all.vectors()?;
    all.domain()?;
    all.walls()?;
    all.obstacles()?;
    all.inflow()?;
    all.engines()?;
    all.aggregation()?;
    all.thermostat()?;
    all.times()
}

struct Relations<'a> {
    table: &'a Table,
    case: &'a Case,
}

impl Relations<'_> {
    fn given(&self, key: &str) -> bool {
        value_at(self.table, &split(key)).is_some()
    }

    fn refuse(&self, key: impl AsRef<str>, allowed: impl Into<String>) -> Checked {
        Err(refusal(self.table, key.as_ref(), allowed))
    }

    /// Returns the problem of a key unless a condition holds.
    fn ensure(&self, holds: bool, key: impl AsRef<str>, allowed: impl Into<String>) -> Checked {
        if holds {
            Ok(())
        } else {
            self.refuse(key, allowed)
        }
    }

    /// Returns a problem if any of the given keys is set; `allowed` says when they may be.
    fn without(&self, keys: &[&str], allowed: &str) -> Checked {
        let found = keys.iter().find(|key| self.given(key));
        found.map_or(Ok(()), |key| self.refuse(key, allowed))
    }

    fn dimension(&self) -> usize {
        self.case.gas.dimension as usize
    }

    /// Checks keys that need a box, keys that need a gas without positions, and keys that need a
    /// frame of reference at rest.
    fn places(&self) -> Checked {
        let case = self.case;
        if !case.has_box() {
            let keys = [
                "walls",
                "obstacle",
                "inflow",
                "gravity",
                "start.placement",
                "start.file",
                "start.region",
                "start.equilibration",
                "start.longest_equilibration",
                "start.velocity",
                "start.spin_temperature",
                "start.empty",
                "accuracy",
                "gas.tangential_restitution",
                "gas.mean_free_path",
            ];
            self.without(
                &keys,
                "this key needs a [box]; without one the gas has no positions",
            )?;
            return self.ensure(
                self.given("gas.volume"),
                "gas.volume",
                "a gas has a [box], or else a volume, a number above 0",
            );
        }
        let allowed = "this key is for gases without positions; gas.mean_free_path makes fewer simulators of dsmc-boltzmann \
                       stand for a gas of many particles in a box";
        self.without(&["gas.particles_per_simulator"], allowed)?;
        let keys = [
            "gas.volume",
            "gas.pair_correlation",
            "power_law",
            "polydisperse",
            "aggregation",
            "verdict.sonine_orders",
        ];
        self.without(
            &keys,
            "this key is for gases without positions, which have no [box]",
        )?;
        if !case.is_bounded() {
            let allowed = "this key needs walls, openings or obstacles, which the gas moves against: a periodic gas in motion is the \
                           same gas as one at rest";
            self.without(&["start.velocity"], allowed)?;
        }
        Ok(())
    }

    fn start(&self, folder: &Path) -> Checked {
        let (start, case) = (&self.case.start, self.case);
        let placed_by_file = start.placement == PlacementSpec::File;
        self.ensure(
            start.file.is_some() == (placed_by_file || start.velocities == VelocitiesSpec::FILE),
            "start.file",
            "a file of positions or velocities; given with placement = \"file\" or velocities = \"file\", always and only",
        )?;
        self.cumulant()?;
        if let Some(file) = &start.file {
            let path = folder.join(file);
            let ending = path
                .extension()
                .and_then(|ending| ending.to_str())
                .unwrap_or("");
            let known = (START_FILE_ENDINGS.iter()).any(|one| {
                one.strip_prefix('.')
                    .is_some_and(|one| ending.eq_ignore_ascii_case(one))
            });
            let allowed = format!("a start file ends with {}", START_FILE_ENDINGS.join(", "));
            self.ensure(known, "start.file", allowed)?;
            let missing = format!(
                "a start file exists, but there is no file {}",
                path.display()
            );
            self.ensure(path.is_file(), "start.file", missing)?;
            let keys = [
                "box.packing_fraction",
                "box.aspect_ratio",
                "gas.mean_free_path",
            ];
            if placed_by_file {
                self.without(&keys, "with start.placement = \"file\" the file says it")?;
            }
        }
        self.ensure(
            case.replicas == 1 || !self.repeats_itself(),
            "replicas",
            "1, as exact disks from one file with velocities go the same way in every replica; start.placement = \"disordered\" \
             places them anew in each replica and deals the velocities of the file to them",
        )?;
        self.ensure(
            case.species.is_empty() || matches!(start.placement, PlacementSpec::Disordered),
            "start.placement",
            "\"disordered\" with [[species]]",
        )?;
        self.ensure(
            self.dimension() == 2
                || matches!(
                    start.placement,
                    PlacementSpec::Disordered | PlacementSpec::File
                ),
            "start.placement",
            "\"disordered\" or \"file\" in space; lattices are of disks",
        )?;
        if start.velocities == VelocitiesSpec::FILE {
            let allowed = "with start.velocities = \"file\" the file says it";
            self.without(&["start.velocity"], allowed)?;
        }
        if let (Some(most), Some(least)) = (start.longest_equilibration, start.equilibration) {
            let allowed = format!("a number of at least start.equilibration = {least}");
            self.ensure(most >= least, "start.longest_equilibration", allowed)?;
        }
        let allowed = "an empty box needs an [[inflow]]";
        self.ensure(
            !start.empty || !case.inflow.is_empty(),
            "start.empty",
            allowed,
        )
    }

    /// Checks that a velocity distribution with the given fourth cumulant exists.
    fn cumulant(&self) -> Checked {
        let VelocitiesSpec::Drawn(drawn) = self.case.start.velocities else {
            return Ok(());
        };
        let (least, dimension) = (-2.0 / (self.dimension() as f64 + 2.0), self.dimension());
        let allowed = format!(
            "a fourth cumulant from {least}, which particles of one speed have in {dimension} dimensions and below which no \
             distribution lies, to 10"
        );
        self.ensure(drawn.a2 >= least, "start.velocities.a2", allowed)
    }

    /// Returns true if all replicas of event-driven dynamics would be equal: a start from one given
    /// state, with no randomness later.
    fn repeats_itself(&self) -> bool {
        let case = self.case;
        let one_state = case.start.placement == PlacementSpec::File
            && case.start.velocities == VelocitiesSpec::FILE;
        let walls = case.walls.all_faces().filter_map(|face| match face {
            FaceSpec::Wall(wall) => wall.temperature,
            FaceSpec::Word(_) => None,
        });
        let bodies = case.obstacle.iter().filter_map(|body| body.temperature);
        let random = case.bath().is_some() || walls.chain(bodies).next().is_some();
        one_state && case.engine.ed.is_some() && !random
    }

    /// Checks the start region: its corners are in order, and the gas is placed at random and not
    /// equilibrated.
    fn region(&self) -> Checked {
        let (start, case) = (&self.case.start, self.case);
        let Some([low, high]) = &start.region else {
            return Ok(());
        };
        let dimension = self.dimension();
        let allowed = format!("two corners of {dimension} numbers, as gas.dimension = {dimension}");
        let full = low.len() == dimension && high.len() == dimension;
        self.ensure(full, "start.region", allowed)?;
        let wide = low.iter().zip(high).all(|(low, high)| low < high);
        let allowed = "the lower corner and then the upper one, so that the region is not empty";
        self.ensure(wide, "start.region", allowed)?;
        let size = case.domain.as_ref().and_then(|domain| domain.size.as_ref());
        let within = |(side, (low, high)): (&f64, (&f64, &f64))| *low >= 0.0 && high <= side;
        let mut sides = size.into_iter().flatten().zip(low.iter().zip(high));
        let allowed = "a region inside the box, from 0 to box.size";
        self.ensure(sides.all(within), "start.region", allowed)?;
        self.ensure(
            start.placement == PlacementSpec::Disordered && !start.empty,
            "start.region",
            "with placement = \"disordered\" and a gas that is not empty",
        )?;
        self.ensure(
            start.equilibration.is_none_or(|asked| asked == 0.0),
            "start.equilibration",
            "0 with start.region, as elastic motion spreads the gas over the box",
        )
    }

    fn spins(&self) -> Checked {
        if self.case.gas.tangential_restitution.is_some() {
            return Ok(());
        }
        let allowed = "this key is for grains that spin: give gas.tangential_restitution too";
        self.without(&["gas.reduced_inertia", "start.spin_temperature"], allowed)?;
        for index in 1..=self.case.inflow.len() {
            self.without(&[&format!("inflow.{index}.spin_temperature")], allowed)?;
        }
        Ok(())
    }

    fn aggregation(&self) -> Checked {
        let case = self.case;
        if let Some(aggregation) = &case.aggregation {
            let one = case.species.len() == 1 || case.gas.number.is_some();
            self.ensure(
                one,
                "aggregation",
                "particles that stick are the monomers of exactly one species",
            )?;
            let twice = [
                (
                    "aggregate_below_speed",
                    [
                        aggregation.aggregate_below,
                        aggregation.aggregate_below_speed,
                    ],
                ),
                (
                    "fragment_above_speed",
                    [aggregation.fragment_above, aggregation.fragment_above_speed],
                ),
            ];
            for (key, thresholds) in twice {
                let one = thresholds.iter().flatten().count() < 2;
                let allowed = "a threshold is an energy or a speed, not both";
                self.ensure(one, format!("aggregation.{key}"), allowed)?;
            }
            let normal = EnergyPart::Normal;
            let sticks_always = aggregation
                .aggregate_below
                .or(aggregation.aggregate_below_speed)
                .is_none();
            let idle = [
                (
                    "aggregate_energy_part",
                    aggregation.aggregate_energy_part == normal && sticks_always,
                ),
                (
                    "fragment_energy_part",
                    aggregation.fragment_energy_part == normal && !aggregation.breaks(),
                ),
            ];
            for (key, idle) in idle {
                let allowed = "a part of the motion is for a threshold: give aggregate_below or fragment_above too";
                self.ensure(!idle, format!("aggregation.{key}"), allowed)?;
            }
        }
        Ok(())
    }

    fn times(&self) -> Checked {
        let (run, case) = (&self.case.run, self.case);
        let until = run.until;
        if let Some(first) = run.first_sample {
            let allowed = format!("a number above 0 and below run.until = {until:?}");
            self.ensure(first < until, "run.first_sample", allowed)?;
        }
        if let Some(ed) = &case.engine.ed {
            let allowed = format!(
                "a number from 0 to run.until = {until:?}: beyond, each contact after the first would be elastic"
            );
            self.ensure(ed.contact_time <= until, "engine.ed.contact_time", allowed)?;
        }
        if run.samples.is_some() {
            let allowed =
                "run.samples sets samples at equal intervals; this is for equal factors of time";
            self.without(&["run.first_sample", "run.samples_per_decade"], allowed)?;
        }
        let haff = run.time_unit == Some(TimeUnit::Haff) && case.aggregation.is_some();
        let allowed =
            "\"case\" or \"mean-free-time\": a gas that sticks has no cooling time of Haff";
        self.ensure(!haff, "run.time_unit", allowed)?;
        let number = |value: &Value| value.as_float().or(value.as_integer().map(|n| n as f64));
        let within = |time: f64| (0.0..=until).contains(&time);
        for (name, options) in &case.measure {
            let key = |key: &str| format!("measure.{name}.{key}");
            let list = |key: &str| {
                options
                    .get(key)
                    .and_then(Value::as_array)
                    .into_iter()
                    .flatten()
            };
            for (index, time) in list("times").enumerate() {
                let fine = number(time).is_none_or(within);
                let allowed = format!("times lie from 0 to run.until = {until:?}");
                self.ensure(fine, key(&format!("times.{}", index + 1)), allowed)?;
            }
            for (index, window) in list("windows").enumerate() {
                let end = |side: usize| window.get(side).and_then(number);
                let fine = end(0)
                    .zip(end(1))
                    .is_none_or(|(start, end)| start < end && within(start) && within(end));
                let allowed = format!(
                    "a window is [start, end] with 0 <= start < end <= run.until = {until:?}"
                );
                self.ensure(fine, key(&format!("windows.{}", index + 1)), allowed)?;
            }
            for from in ["from", "steady_from"] {
                let fine = options
                    .get(from)
                    .and_then(number)
                    .is_none_or(|time| within(time) && time < until);
                let allowed = format!("a time from 0 to below run.until = {until:?}");
                self.ensure(fine, key(from), allowed)?;
            }
        }
        Ok(())
    }
}
