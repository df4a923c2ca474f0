//! From a case as written to what it means: defaults that depend on other keys, and relations between keys.
//!
//! Types and the ranges of single keys have been checked against the schema before.

use std::f64::consts::FRAC_PI_4;
use std::path::Path;

use toml::Table;

use super::error::Problem;
use super::locate::KeyPath;
use super::written::{self, Written};
use super::{
    Bodies, Case, Domain, Drive, Engine, EventDriven, Gas, GasSpecies, Measure, Restitution, Run,
    Start, StartFile, StartFileKind, Structure, Units, Velocities, Verdict, monte_carlo, schema,
    typed,
};

/// Most kicks of a run.
const MOST_KICKS: f64 = 1e9;

/// Checks a table and gives the case that it means. `folder` holds the case file.
pub(super) fn case(table: &Table, folder: &Path) -> Result<Case, Problem> {
    let written: Written = typed::read(schema::shared(), table)?;
    let check = Check { table, folder };
    let start = check.start(&written)?;
    let run = check.run(&written.run)?;
    let gas = check.gas(&written)?;
    Ok(Case {
        title: written.title,
        units: written.units,
        seed: written.seed,
        replicas: written.replicas as usize,
        gas,
        domain: Domain {
            aspect_ratio: written.domain.aspect_ratio,
            boundary: written.domain.boundary,
        },
        start,
        run,
        drive: check.drive(written.drive.as_ref(), run.until)?,
        engines: check.engines(written.engine)?,
        measure: check.measure(written.measure, run)?,
        verdict: Verdict {
            false_alarm: written.verdict.false_alarm,
        },
        accuracy: check.accuracy(written.accuracy.as_ref())?,
    })
}

/// A case under check, and the folder that its files are relative to.
struct Check<'a> {
    table: &'a Table,
    folder: &'a Path,
}

impl Check<'_> {
    /// Refuses the value of a key, or its absence.
    fn refuse(&self, key: &str, allowed: impl Into<String>) -> Problem {
        self.refuse_at(KeyPath::of(key), allowed)
    }

    fn refuse_at(&self, key: KeyPath, allowed: impl Into<String>) -> Problem {
        typed::refuse(self.table, key, allowed)
    }

    fn start(&self, written: &Written) -> Result<Start, Problem> {
        let start = &written.start;
        let from_file = start.placement == written::Placement::File;
        let bodies = if from_file {
            for (key, given) in [
                ("gas.disks", written.gas.disks.is_some()),
                (
                    "gas.packing_fraction",
                    written.gas.packing_fraction.is_some(),
                ),
            ] {
                if given {
                    let allowed = "with start.placement = \"file\" this key is left out, for the file says it";
                    return Err(self.refuse(key, allowed));
                }
            }
            Bodies::File(self.start_file(start.file.as_deref())?)
        } else {
            if start.file.is_some() {
                return Err(self.refuse("start.file", schema::sentence("start.file")));
            }
            if start.velocities == written::Velocities::File {
                return Err(self.refuse("start.velocities", schema::sentence("start.velocities")));
            }
            self.placed(written)?
        };
        let velocities = match start.velocities {
            written::Velocities::Maxwellian => Velocities::Maxwellian {
                temperature: self.temperature(&written.gas, written.units)?,
            },
            written::Velocities::File => {
                for (key, given) in [
                    ("gas.temperature", written.gas.temperature),
                    ("gas.rms_speed", written.gas.rms_speed),
                ] {
                    if given.is_some() {
                        let allowed = "with start.velocities = \"file\" this key is left out, for the file says it";
                        return Err(self.refuse(key, allowed));
                    }
                }
                if written.replicas > 1 {
                    let allowed = "with start.velocities = \"file\" there is one replica, as one file is one start: \
                                   compare several files for error bars";
                    return Err(self.refuse("replicas", allowed));
                }
                Velocities::File
            }
        };
        let least = start.collisions_per_particle;
        let most = start
            .most_collisions_per_particle
            .unwrap_or_else(|| (4.0 * least).max(200.0));
        if most < least {
            let key = "start.most_collisions_per_particle";
            return Err(self.refuse(key, format!("{} = {least}", schema::sentence(key))));
        }
        Ok(Start {
            bodies,
            velocities,
            collisions_per_particle: least,
            most_collisions_per_particle: most,
        })
    }

    fn placed(&self, written: &Written) -> Result<Bodies, Problem> {
        let missing = |key: &str| Problem::Missing {
            key: KeyPath::of(key),
            allowed: schema::sentence(key),
        };
        let disks = written.gas.disks.ok_or_else(|| missing("gas.disks"))? as usize;
        let packing_fraction = written
            .gas
            .packing_fraction
            .ok_or_else(|| missing("gas.packing_fraction"))?;
        match written.start.placement {
            written::Placement::Square if packing_fraction > FRAC_PI_4 => Err(self.refuse(
                "gas.packing_fraction",
                "a square lattice has a packing fraction above 0 and at most 0.7854 (disks touching)",
            )),
            written::Placement::Square => Ok(Bodies::Square { disks, packing_fraction }),
            written::Placement::Hexagonal => Ok(Bodies::Hexagonal { disks, packing_fraction }),
            _ => Ok(Bodies::Disordered { disks, packing_fraction }),
        }
    }

    fn start_file(&self, file: Option<&str>) -> Result<StartFile, Problem> {
        let sentence = || schema::sentence("start.file");
        let Some(written) = file else {
            return Err(Problem::Missing {
                key: KeyPath::of("start.file"),
                allowed: sentence(),
            });
        };
        let path = self.folder.join(written);
        let kind = match path.extension().and_then(|ending| ending.to_str()) {
            Some(ending) if ending.eq_ignore_ascii_case("csv") => StartFileKind::Csv,
            Some(ending) if ending.eq_ignore_ascii_case("xyz") => StartFileKind::ExtendedXyz,
            _ => return Err(self.refuse("start.file", sentence())),
        };
        if !path.is_file() {
            let allowed = format!(
                "a start file exists, but there is no file {}",
                path.display()
            );
            return Err(self.refuse("start.file", allowed));
        }
        Ok(StartFile {
            written: written.to_owned(),
            kind,
            path,
        })
    }

    /// The default 1 of reduced units; SI units have no defaults.
    fn or_one(&self, key: &str, value: Option<f64>, units: Units) -> Result<f64, Problem> {
        match (value, units) {
            (Some(value), _) => Ok(value),
            (None, Units::Reduced) => Ok(1.0),
            (None, Units::Si) => {
                let allowed = format!(
                    "with units = \"si\" this key is required; {}",
                    schema::sentence(key)
                );
                Err(self.refuse(key, allowed))
            }
        }
    }

    fn temperature(&self, gas: &written::Gas, units: Units) -> Result<f64, Problem> {
        let Some(speed) = gas.rms_speed else {
            return self.or_one("gas.temperature", gas.temperature, units);
        };
        if gas.temperature.is_some() {
            let allowed = "gas.temperature is given too, and only one of the two may be";
            return Err(self.refuse("gas.rms_speed", allowed));
        }
        let temperature = 0.5 * self.or_one("gas.mass", gas.mass, units)? * speed * speed;
        if temperature.is_normal() {
            Ok(temperature)
        } else {
            Err(self.refuse(
                "gas.rms_speed",
                "the temperature m v^2/2 is a normal floating-point number",
            ))
        }
    }

    fn gas(&self, written: &Written) -> Result<Gas, Problem> {
        let (gas, units) = (&written.gas, written.units);
        let species = self.species(written)?;
        // Means of the species stand for the disk where one is asked for.
        let mean = |value: fn(&GasSpecies) -> f64| -> Option<f64> {
            let sum = species.iter().map(|one| one.share * value(one)).sum();
            (!species.is_empty()).then_some(sum)
        };
        let diameter = mean(|one| one.diameter).or(gas.diameter);
        let mass = mean(|one| one.mass).or(gas.mass);
        Ok(Gas {
            restitution: match &gas.restitution {
                written::Restitution::Constant(value) => Restitution::Constant(*value),
                written::Restitution::Viscoelastic(law) => Restitution::Viscoelastic {
                    dissipation: law.viscoelastic,
                },
            },
            diameter: self.or_one("gas.diameter", diameter, units)?,
            mass: self.or_one("gas.mass", mass, units)?,
            species,
        })
    }

    fn species(&self, written: &Written) -> Result<Vec<GasSpecies>, Problem> {
        let gas = &written.gas;
        if gas.species.is_empty() {
            return Ok(Vec::new());
        }
        let total: f64 = gas.species.iter().map(|one| one.share).sum();
        let disordered = written.start.placement == written::Placement::Disordered;
        // Shares are written with a few digits.
        let whole = (total - 1.0).abs() < 1e-6;
        if !(disordered && whole) {
            return Err(self.refuse("gas.species", schema::sentence("gas.species")));
        }
        for (key, given) in [
            ("gas.diameter", gas.diameter),
            ("gas.mass", gas.mass),
            ("gas.rms_speed", gas.rms_speed),
        ] {
            if given.is_some() {
                let allowed = "with [[gas.species]] this key is left out; gas.temperature says how hot all are";
                return Err(self.refuse(key, allowed));
            }
        }
        let species = gas.species.iter().map(|one| GasSpecies {
            share: one.share / total,
            diameter: one.diameter,
            mass: one.mass,
        });
        Ok(species.collect())
    }

    fn run(&self, run: &written::Run) -> Result<Run, Problem> {
        let first_sample = run.first_sample.unwrap_or(run.until / 1000.0);
        if !(0.0 < first_sample && first_sample < run.until) {
            let key = if run.first_sample.is_some() {
                "run.first_sample"
            } else {
                "run.until"
            };
            let allowed = format!("{}; run.until = {}", schema::sentence(key), run.until);
            return Err(self.refuse(key, allowed));
        }
        Ok(Run {
            until: run.until,
            first_sample,
            samples_per_decade: run.samples_per_decade as usize,
            checkpoint_seconds: run.checkpoint_seconds,
        })
    }

    fn accuracy(&self, accuracy: Option<&written::Accuracy>) -> Result<Option<f64>, Problem> {
        let Some(accuracy) = accuracy else {
            return Ok(None);
        };
        let key = "accuracy.target";
        let target = crate::words::share(&accuracy.target);
        target
            .map(Some)
            .ok_or_else(|| self.refuse(key, schema::sentence(key)))
    }

    fn drive(&self, drive: Option<&written::Drive>, until: f64) -> Result<Option<Drive>, Problem> {
        let Some(&written::Drive { heating, interval }) = drive else {
            return Ok(None);
        };
        if !(interval < until && until / interval <= MOST_KICKS) {
            let key = "drive.interval";
            let allowed = format!("{}; run.until = {until}", schema::sentence(key));
            return Err(self.refuse(key, allowed));
        }
        Ok(Some(Drive { heating, interval }))
    }

    fn engines(&self, mut engines: written::Engines) -> Result<Vec<Engine>, Problem> {
        let mut list = Vec::new();
        if let Some(ed) = engines.ed.take() {
            if ed.collision_limit.is_some_and(|limit| limit.fract() != 0.0) {
                let key = "engine.ed.collision_limit";
                return Err(self.refuse(key, schema::sentence(key)));
            }
            let collision_limit = ed.collision_limit.map(|limit| limit as u64);
            list.push(Engine::Ed(EventDriven {
                contact_time: ed.contact_time,
                collision_limit,
            }));
        }
        list.extend(monte_carlo::engines(&engines).into_iter().map(Engine::Dsmc));
        if list.is_empty() {
            return Err(self.refuse("engine", schema::sentence("engine")));
        }
        Ok(list)
    }

    fn measure(&self, measure: written::Measure, run: Run) -> Result<Measure, Problem> {
        let until = run.until;
        let impact_windows = match measure.impact_windows {
            None => default_windows(until),
            Some(written::Windows::Whole(written::WholeRun::WholeRun)) => vec![[0.0, until]],
            Some(written::Windows::List(windows)) => {
                for (i, [start, end]) in windows.iter().enumerate() {
                    if !(start < end && *end <= until) {
                        let key = "measure.impact_windows";
                        let allowed = format!("{}; run.until = {until}", schema::sentence(key));
                        return Err(self.refuse_at(KeyPath::of(key).element(i), allowed));
                    }
                }
                windows
            }
        };
        let structure_times = self.times(
            "measure.structure_times",
            measure.structure_times,
            &[0.0, until],
            until,
        )?;
        let snapshot_times = self.times(
            "measure.snapshot_times",
            measure.snapshot_times,
            &[until],
            until,
        )?;
        let displacement_start = self.displacement_start(
            measure.mean_squared_displacement,
            measure.displacement_start,
            run,
        )?;
        Ok(Measure {
            impact_windows,
            impact_bins: measure.impact_bins as usize,
            structure: Structure {
                times: structure_times,
                assignment: measure.structure_assignment,
                correction: measure.structure_correction,
                largest_wave_number: measure.largest_wave_number as usize,
            },
            pair_correlation_range: measure.pair_correlation_range,
            snapshot_times,
            displacement_start,
        })
    }

    /// From when on displacements are measured.
    fn displacement_start(
        &self,
        asked: bool,
        start: Option<f64>,
        run: Run,
    ) -> Result<Option<f64>, Problem> {
        let last = run.until - run.first_sample;
        match start {
            Some(start) if !(asked && start < last) => {
                let key = "measure.displacement_start";
                let allowed = format!(
                    "{}; run.until - run.first_sample = {last}",
                    schema::sentence(key)
                );
                Err(self.refuse(key, allowed))
            }
            _ => Ok(asked.then(|| start.unwrap_or(0.0))),
        }
    }

    /// Times within the run, in order and each once.
    fn times(
        &self,
        key: &str,
        times: Option<Vec<f64>>,
        default: &[f64],
        until: f64,
    ) -> Result<Vec<f64>, Problem> {
        let mut times = times.unwrap_or_else(|| default.to_vec());
        if let Some(i) = times.iter().position(|&time| time > until) {
            let allowed = format!("{}; run.until = {until}", schema::sentence(key));
            return Err(self.refuse_at(KeyPath::of(key).element(i), allowed));
        }
        times.sort_by(f64::total_cmp);
        times.dedup();
        Ok(times)
    }
}

/// Windows from 0 to 1, 5, 20, 100, 400, 2000 and so on, the last one cut at the end of the run.
fn default_windows(until: f64) -> Vec<[f64; 2]> {
    let mut windows = Vec::new();
    let mut start = 0.0;
    let mut end = 1.0;
    let mut factors = [5.0, 4.0].into_iter().cycle();
    while end < until {
        windows.push([start, end]);
        start = end;
        end *= factors.next().unwrap_or(5.0);
    }
    windows.push([start, until]);
    windows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_windows_end_with_the_run() {
        assert_eq!(
            default_windows(400.0),
            [
                [0.0, 1.0],
                [1.0, 5.0],
                [5.0, 20.0],
                [20.0, 100.0],
                [100.0, 400.0]
            ]
        );
        assert_eq!(default_windows(0.5), [[0.0, 0.5]]);
        assert_eq!(default_windows(1.0), [[0.0, 1.0]]);
        assert_eq!(default_windows(7.0), [[0.0, 1.0], [1.0, 5.0], [5.0, 7.0]]);
        assert!(default_windows(f64::MAX).len() < 1000);
    }
}
