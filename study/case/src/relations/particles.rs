//! Checks of the particles of a case: numbers, sizes and contact laws.

use std::collections::BTreeSet;

use super::{Checked, MOST, MOST_MASSES, Relations};
use crate::error::format_total;
use crate::format::{DiameterDistribution, PlacementSpec, Rounding, UnitsSpec, VelocitiesSpec};

impl Relations<'_> {
    /// Checks that the number of particles is determined in exactly one way.
    pub(super) fn particles(&self) -> Checked {
        let case = self.case;
        let shares = case.species.iter().any(|one| one.share.is_some());
        let file = case.start.placement == PlacementSpec::File;
        let dealt = !file && case.start.velocities == VelocitiesSpec::FILE;
        let ways = [
            ("gas.number", case.gas.number.is_some() && !shares),
            ("species", !case.species.is_empty()),
            ("power_law", case.power_law.is_some()),
            ("polydisperse", case.polydisperse.is_some()),
            ("start.placement", file),
            ("start.velocities", dealt),
            (
                "box.width_over_critical_length",
                self.given("box.width_over_critical_length"),
            ),
        ];
        let mut given = ways.iter().filter(|way| way.1);
        let Some((first, _)) = given.next() else {
            let allowed = if case.has_box() {
                "the number of particles is given here, by [[species]], by box.width_over_critical_length, or by start.placement = \"file\""
            } else {
                "the number of particles is given here, or by [[species]], [power_law] or [polydisperse]"
            };
            return self.refuse("gas.number", allowed);
        };
        if let Some((second, _)) = given.next() {
            let allowed =
                format!("the number of particles is given once, and {first} gives it too");
            return self.refuse(second, allowed);
        }
        if !matches!(
            *first,
            "gas.number"
                | "start.placement"
                | "start.velocities"
                | "box.width_over_critical_length"
        ) {
            let keys = ["gas.diameter", "gas.mass", "gas.rms_speed"];
            let allowed = format!("{first} says this; gas.temperature is that of all");
            self.without(&keys, &allowed)?;
        }
        if case.is_uniform_box() {
            let few = case.gas.number.is_some_and(|number| number < 2);
            self.ensure(
                !few,
                "gas.number",
                "a gas that collides has at least 2 particles",
            )?;
        }
        if let Some(law) = &case.power_law {
            let count = |mass: u64| {
                let share = law.monomers as f64 * (mass as f64).powf(-law.exponent);
                match law.rounding {
                    // A share that is whole must not fall below itself by rounding.
                    Rounding::Down => (share * (1.0 + 1e-12)).floor(),
                    Rounding::Nearest => share.round(),
                }
            };
            self.ensure(
                law.largest_mass.is_some() || count(MOST_MASSES) == 0.0,
                "power_law.largest_mass",
                format!("numbers do not fall to zero up to mass {MOST_MASSES}: a whole number from 1 to that"),
            )?;
            let masses = 1..=law.largest_mass.unwrap_or(MOST_MASSES);
            let most = format!("all masses together have at most {MOST} particles");
            let total: f64 = masses.map(count).sum();
            self.ensure(total <= MOST, "power_law.monomers", most)?;
        }
        if let Some(continuous) = &case.polydisperse {
            // The smallest diameter of a uniform distribution is the mean less sqrt(3) deviations.
            let uniform = continuous.distribution == DiameterDistribution::Uniform;
            self.ensure(
                !uniform || continuous.relative_width <= 0.57,
                "polydisperse.relative_width",
                "a number above 0, and at most 0.57 where the distribution is uniform",
            )?;
            self.ensure(
                2 * continuous.groups <= continuous.number,
                "polydisperse.groups",
                "a whole number from 1 to half of the particles",
            )?;
        }
        Ok(())
    }

    /// Returns number and diameter of each species; empty if a start file or a size distribution
    /// determines them.
    pub(super) fn contents(&self) -> Vec<(f64, f64)> {
        let gas = &self.case.gas;
        let all = gas.number.unwrap_or(0) as f64;
        if self.case.species.is_empty() {
            return gas
                .number
                .map(|_| (all, gas.diameter.unwrap_or(1.0)))
                .into_iter()
                .collect();
        }
        let species = self.case.species.iter().map(|one| {
            let dense = one.number_density.unwrap_or(0.0) * gas.simulated_volume().unwrap_or(0.0);
            let shared = one.share.unwrap_or(0.0) * all;
            (
                one.number
                    .map_or(dense.round() + shared, |number| number as f64),
                one.diameter,
            )
        });
        species.collect()
    }

    /// Checks that each law of restitution has a valid combination of keys.
    pub(super) fn laws(&self) -> Checked {
        let pairs = self.case.pair.iter().enumerate();
        let of_pairs = pairs
            .map(|(index, pair)| (format!("pair.{}.restitution", index + 1), pair.restitution));
        let general = ("gas.restitution".to_owned(), self.case.gas.restitution);
        for (key, law) in std::iter::once(general).chain(of_pairs) {
            if let Some(allowed) = law.fault() {
                return self.refuse(key, allowed);
            }
        }
        Ok(())
    }

    pub(super) fn species(&self) -> Checked {
        let case = self.case;
        let (species, positionless) = (&case.species, !case.has_box());
        let mut names: BTreeSet<String> = BTreeSet::new();
        let shares = species.iter().any(|one| one.share.is_some());
        for (index, one) in species.iter().enumerate() {
            let key = |key: &str| format!("species.{}.{key}", index + 1);
            let ways = [
                ("number", one.number.is_some()),
                ("share", one.share.is_some()),
                ("number_density", one.number_density.is_some()),
            ];
            let given: Vec<&str> = ways.iter().filter(|way| way.1).map(|way| way.0).collect();
            let allowed = "a species has a number, or a share of gas.number, or, without a box, a number_density";
            self.ensure(!given.is_empty(), key("number"), allowed)?;
            if let Some(second) = given.get(1) {
                return self.refuse(key(second), allowed);
            }
            let alike = "all species have a share, or none has";
            let all_share = species.iter().all(|one| one.share.is_some());
            self.ensure(one.share.is_none() || all_share, key("share"), alike)?;
            self.ensure(
                positionless || one.number_density.is_none(),
                key("number_density"),
                "this key is for gases without positions, which have no [box]; here a number, or a share of gas.number",
            )?;
            self.ensure(
                positionless || one.number != Some(0),
                key("number"),
                "a species in a box has at least 1 particle",
            )?;
            self.ensure(
                positionless || one.temperature.is_none(),
                key("temperature"),
                "in a box all species start at gas.temperature",
            )?;
            let name = one.name.clone().unwrap_or_else(|| (index + 1).to_string());
            let plain = !name.chars().any(char::is_control) && name.chars().count() <= 40;
            self.ensure(
                plain && name != "all" && names.insert(name),
                key("name"),
                "names are short, differ from each other and from the numbers of species without one, and none is \"all\"",
            )?;
            let tracer = "tracer is true for one species at most, without a box, which has a number and is not the only one";
            let others =
                species.iter().filter(|other| other.tracer).count() == 1 && species.len() > 1;
            let fine = others && positionless && one.number.is_some();
            self.ensure(!one.tracer || fine, key("tracer"), tracer)?;
        }
        if shares {
            let total: f64 = species.iter().filter_map(|one| one.share).sum();
            // Shares are written with a few digits.
            self.ensure(
                (total - 1.0).abs() < 1e-6,
                format!("species.{}.share", species.len()),
                format!("shares add up to 1; these to {}", format_total(total)),
            )?;
            self.ensure(
                case.gas.number.is_some(),
                "gas.number",
                "with shares of species this is the number of all particles",
            )?;
        }
        let total: f64 = self.contents().iter().map(|one| one.0).sum();
        if !species.is_empty() {
            let allowed = format!(
                "all species together have from 1 to {MOST} particles; these have {}",
                format_total(total)
            );
            self.ensure((1.0..=MOST).contains(&total), "species", allowed)?;
        }
        let mut pairs = BTreeSet::new();
        for (index, pair) in case.pair.iter().enumerate() {
            let [a, b] = pair.species;
            // How many species a start file has is not known here.
            let in_file = case.start.file.is_some();
            let known = (in_file || a.max(b) <= species.len() as u64) && a.min(b) > 0;
            self.ensure(
                known && pairs.insert([a.min(b), a.max(b)]),
                format!("pair.{}.species", index + 1),
                format!(
                    "two of the {} species, counted from 1, and each pair once",
                    species.len()
                ),
            )?;
        }
        Ok(())
    }

    pub(super) fn temperatures(&self) -> Checked {
        let (gas, case) = (&self.case.gas, self.case);
        self.ensure(
            gas.temperature.is_none() || gas.rms_speed.is_none(),
            "gas.rms_speed",
            "gas.temperature is given too, and only one of the two may be",
        )?;
        let from_file = case.start.velocities == VelocitiesSpec::FILE;
        if from_file {
            let allowed = "with start.velocities = \"file\" the file says it";
            self.without(&["gas.temperature", "gas.rms_speed"], allowed)?;
        }
        if case.units == UnitsSpec::Si {
            let allowed = "with units = \"si\" this is given: a number above 0";
            let alike = case.species.is_empty() && case.start.file.is_none();
            if alike && case.power_law.is_none() && case.polydisperse.is_none() {
                self.ensure(gas.diameter.is_some(), "gas.diameter", allowed)?;
                self.ensure(gas.mass.is_some(), "gas.mass", allowed)?;
            }
            for index in 1..=case.species.len() {
                for key in ["diameter", "mass"] {
                    let key = format!("species.{index}.{key}");
                    self.ensure(self.given(&key), &key, allowed)?;
                }
            }
            let each = !case.species.is_empty()
                && case.species.iter().all(|one| one.temperature.is_some());
            let known = gas.temperature.is_some() || gas.rms_speed.is_some() || from_file || each;
            self.ensure(known, "gas.temperature", allowed)?;
        }
        Ok(())
    }
}
