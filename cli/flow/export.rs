//! From records to tables.

use std::ops::Range;
use std::path::Path;

use stosszahl_analysis::fields::{self, Fields, Measured};
use stosszahl_analysis::statistics::Estimate;
use stosszahl_analysis::steady;
use stosszahl_model::snapshot::SnapshotError;

use super::gas::Entry;
use super::plan::Plan;
use super::run::{Record, Replica, Sample, Share};
use super::tables::{BoundaryRow, FieldRow, ProfileRow, SeriesRow, SpeciesRow};
use super::theory::Theory;
use crate::export::write_table;

/// Blocks of time that are averaged over.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// The blocks.
    pub blocks: Range<usize>,
    /// Start and end \[time\].
    pub times: [f64; 2],
    /// Whether it is the steady state.
    pub steady: bool,
}

/// Everything that is written, and what verdicts need besides.
#[derive(Clone, Debug)]
pub struct Tables {
    /// `series.csv`
    pub series: Vec<SeriesRow>,
    /// `species.csv`; empty for one species.
    pub species: Vec<SpeciesRow>,
    /// `fields.csv`
    pub fields: Vec<FieldRow>,
    /// `profiles.csv`
    pub profiles: Vec<ProfileRow>,
    /// `boundaries.csv`
    pub boundaries: Vec<BoundaryRow>,
    /// From when on each engine is steady; `None` if it never is.
    pub steady_from: Vec<(&'static str, Option<f64>)>,
    /// The windows that were averaged over, the last of them for verdicts.
    pub windows: Vec<Window>,
}

impl Tables {
    /// Gathers the tables of all replicas.
    pub fn new(plan: &Plan, theory: &Theory, replicas: &[Replica]) -> Self {
        let names = plan.engines();
        let runs: Vec<Vec<&Record>> = (0..names.len())
            .map(|engine| {
                (replicas.iter())
                    .map(|replica| &replica.engines[engine])
                    .collect()
            })
            .collect();
        let steady_from: Vec<_> = names
            .iter()
            .zip(&runs)
            .map(|(&name, runs)| (name, steady_from(plan, runs)))
            .collect();
        let windows = windows(plan, steady_from.iter().map(|&(_, from)| from));
        let mut tables = Self {
            series: Vec::new(),
            species: Vec::new(),
            fields: Vec::new(),
            profiles: Vec::new(),
            boundaries: Vec::new(),
            steady_from,
            windows,
        };
        for (name, runs) in names.iter().zip(&runs) {
            tables.series(plan, theory, name, runs);
            for window in tables.windows.clone() {
                tables.fields(plan, theory, name, runs, &window);
            }
            if let Some(window) = tables.windows.last().cloned() {
                tables.boundaries(name, runs, &window);
            }
        }
        tables
    }

    /// Writes all tables.
    ///
    /// # Errors
    /// [`SnapshotError`] if a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), SnapshotError> {
        write_table(folder, &self.series)?;
        if !self.species.is_empty() {
            write_table(folder, &self.species)?;
        }
        write_table(folder, &self.fields)?;
        write_table(folder, &self.profiles)?;
        write_table(folder, &self.boundaries)
    }

    fn series(&mut self, plan: &Plan, theory: &Theory, engine: &str, runs: &[&Record]) {
        let freedom = plan.freedom();
        let replicas = runs.len() as u64;
        let samples = runs.iter().map(|run| run.series.len()).min().unwrap_or(0);
        for index in 0..samples {
            let here: Vec<&Sample> = runs.iter().map(|run| &run.series[index]).collect();
            let time = here[0].time;
            let mean = |quantity: &dyn Fn(&Sample) -> f64| over(here.iter().map(|s| quantity(s)));
            let all = |sample: &Sample| total(&sample.species);
            let (energy, energy_se) = mean(&|sample| {
                let all = all(sample);
                all.translation + all.rotation + sample.potential
            });
            let (temperature, temperature_se) =
                mean(&|sample| granular_temperature(&all(sample), freedom.dimension));
            let spin = (freedom.rotations > 0)
                .then(|| mean(&|sample| spin_temperature(&all(sample), freedom.rotations)));
            let expected = theory.temperatures(time);
            self.series.push(SeriesRow {
                engine: engine.to_owned(),
                time,
                grains: mean(&|sample| all(sample).number).0,
                collisions_per_grain: mean(&|sample| {
                    2.0 * sample.collisions / all(sample).number.max(f64::MIN_POSITIVE)
                })
                .0,
                translation: mean(&|sample| all(sample).translation).0,
                rotation: mean(&|sample| all(sample).rotation).0,
                potential: mean(&|sample| sample.potential).0,
                energy,
                energy_se,
                temperature,
                temperature_se,
                spin_temperature: spin.map(|(value, _)| value),
                spin_temperature_se: spin.and_then(|(_, error)| error),
                theory_temperature: expected.map(|[translation, _]| translation),
                theory_spin_temperature: expected
                    .filter(|_| freedom.rotations > 0)
                    .map(|[_, rotation]| rotation),
                replicas,
            });
            if plan.kinds.len() < 2 {
                continue;
            }
            for species in 0..plan.kinds.len() {
                let (temperature, temperature_se) = mean(&|sample| {
                    granular_temperature(&sample.species[species], freedom.dimension)
                });
                let spin = (freedom.rotations > 0).then(|| {
                    mean(&|sample| spin_temperature(&sample.species[species], freedom.rotations))
                });
                self.species.push(SpeciesRow {
                    engine: engine.to_owned(),
                    time,
                    species: plan.name(species),
                    grains: mean(&|sample| sample.species[species].number).0,
                    temperature,
                    temperature_se,
                    spin_temperature: spin.map(|(value, _)| value),
                    spin_temperature_se: spin.and_then(|(_, error)| error),
                });
            }
        }
    }

    fn fields(
        &mut self,
        plan: &Plan,
        theory: &Theory,
        engine: &str,
        runs: &[&Record],
        window: &Window,
    ) {
        let all: Vec<&Fields> = runs.iter().map(|run| &run.fields).collect();
        let measure = |species, along| {
            fields::measure(&all, window.blocks.clone(), species, along, plan.freedom())
        };
        let grid = *all[0].grid();
        let [window_start, window_end] = window.times;
        for (cell, found) in measure(None, fields::Along::Cells).iter().enumerate() {
            let [x, y] = grid.centre(cell);
            let (v, e) = (&found.values, &found.errors);
            let error = |of: &dyn Fn(&fields::Values) -> f64| finite(e.as_ref().map(of));
            self.fields.push(FieldRow {
                engine: engine.to_owned(),
                window_start,
                window_end,
                x,
                y,
                number_density: v.number_density,
                number_density_se: error(&|e| e.number_density),
                velocity_x: v.velocity[0],
                velocity_x_se: error(&|e| e.velocity[0]),
                velocity_y: v.velocity[1],
                velocity_y_se: error(&|e| e.velocity[1]),
                temperature: v.temperature,
                temperature_se: error(&|e| e.temperature),
                spin_temperature: v.spin_temperature,
                spin_temperature_se: error(&|e| e.spin_temperature),
                pressure: v.pressure,
                pressure_se: error(&|e| e.pressure),
                collision_rate: v.collision_rate,
                collision_rate_se: error(&|e| e.collision_rate),
            });
        }
        let many = plan.kinds.len() > 1;
        let species = std::iter::once(None).chain((0..plan.kinds.len()).filter(|_| many).map(Some));
        for species in species {
            for (axis, along) in [fields::Along::X, fields::Along::Y].into_iter().enumerate() {
                let width = grid.width()[axis];
                for (place, found) in measure(species, along).iter().enumerate() {
                    let at = (place as f64 + 0.5) * width;
                    let expected = (axis == 1)
                        .then(|| {
                            let ends = [at - 0.5 * width, at + 0.5 * width];
                            theory.density(plan, species, ends)
                        })
                        .flatten();
                    let which = species.map_or_else(|| "all".to_owned(), |index| plan.name(index));
                    self.profiles.push(profile(
                        engine,
                        window,
                        axis,
                        which,
                        at,
                        found,
                        expected.filter(|_| window.steady),
                    ));
                }
            }
        }
    }

    fn boundaries(&mut self, engine: &str, runs: &[&Record], window: &Window) {
        let names: Vec<String> = runs
            .iter()
            .filter_map(|run| run.ledgers.last())
            .map(|ledger| ledger.entries.iter().map(|entry| entry.name.clone()))
            .fold(Vec::new(), |mut names, more| {
                for name in more {
                    if !names.contains(&name) {
                        names.push(name);
                    }
                }
                names
            });
        let [window_start, window_end] = window.times;
        let duration = window_end - window_start;
        for name in names {
            let entry = |run: &Record, block: Option<usize>| {
                block
                    .and_then(|block| run.ledgers.get(block))
                    .and_then(|ledger| ledger.entries.iter().find(|entry| entry.name == name))
                    .cloned()
                    .unwrap_or_default()
            };
            let rate = |of: &dyn Fn(&Entry) -> f64| {
                over(runs.iter().map(|run| {
                    let before = entry(run, window.blocks.start.checked_sub(1));
                    let after = entry(run, Some(window.blocks.end - 1));
                    (of(&after) - of(&before)) / duration
                }))
            };
            let (grains_per_time, grains_per_time_se) = rate(&|entry| entry.grains);
            let (force_x, force_x_se) = rate(&|entry| entry.momentum[0]);
            let (force_y, force_y_se) = rate(&|entry| entry.momentum[1]);
            let (power, power_se) = rate(&|entry| entry.energy);
            self.boundaries.push(BoundaryRow {
                engine: engine.to_owned(),
                boundary: name,
                window_start,
                window_end,
                grains_per_time,
                grains_per_time_se,
                force_x,
                force_x_se,
                force_y,
                force_y_se,
                power,
                power_se,
            });
        }
    }
}

fn profile(
    engine: &str,
    window: &Window,
    axis: usize,
    species: String,
    at: f64,
    found: &Measured,
    theory_number_density: Option<f64>,
) -> ProfileRow {
    let (v, e) = (&found.values, &found.errors);
    let error = |of: &dyn Fn(&fields::Values) -> f64| finite(e.as_ref().map(of));
    ProfileRow {
        engine: engine.to_owned(),
        window_start: window.times[0],
        window_end: window.times[1],
        along: ["x", "y"][axis].to_owned(),
        species,
        at,
        number_density: v.number_density,
        number_density_se: error(&|e| e.number_density),
        theory_number_density,
        velocity_x: v.velocity[0],
        velocity_x_se: error(&|e| e.velocity[0]),
        velocity_y: v.velocity[1],
        velocity_y_se: error(&|e| e.velocity[1]),
        temperature: v.temperature,
        temperature_se: error(&|e| e.temperature),
        spin_temperature: v.spin_temperature,
        spin_temperature_se: error(&|e| e.spin_temperature),
        pressure: v.pressure,
        pressure_se: error(&|e| e.pressure),
    }
}

fn finite(error: Option<f64>) -> Option<f64> {
    error.filter(|error| error.is_finite())
}

/// All species together.
pub(super) fn total(species: &[Share]) -> Share {
    let mut all = Share::default();
    for share in species {
        all.number += share.number;
        all.mass += share.mass;
        for (sum, more) in all.momentum.iter_mut().zip(share.momentum) {
            *sum += more;
        }
        all.translation += share.translation;
        all.rotation += share.rotation;
    }
    all
}

/// m <(v - u)^2>/D with the mean velocity u; 0 without grains.
pub(super) fn granular_temperature(share: &Share, dimension: usize) -> f64 {
    if share.number <= 0.0 {
        return 0.0;
    }
    let square: f64 = share.momentum.iter().map(|p| p * p).sum();
    (2.0 * share.translation - square / share.mass) / (dimension as f64 * share.number)
}

/// I <w^2> for each rotation; 0 without grains.
pub(super) fn spin_temperature(share: &Share, rotations: usize) -> f64 {
    2.0 * share.rotation / (rotations as f64 * share.number.max(f64::MIN_POSITIVE))
}

/// Mean and standard error over replicas.
pub(super) fn over(values: impl Iterator<Item = f64>) -> (f64, Option<f64>) {
    let values: Vec<f64> = values.collect();
    match Estimate::over_replicas(&values) {
        Some(estimate) => (estimate.value, finite(estimate.standard_error)),
        None => (
            values.iter().sum::<f64>() / values.len().max(1) as f64,
            None,
        ),
    }
}

/// From when on all that the gas has is steady.
fn steady_from(plan: &Plan, runs: &[&Record]) -> Option<f64> {
    let samples = runs.iter().map(|run| run.series.len()).min()?;
    // The start itself is no average over an interval.
    let series = |of: &dyn Fn(&Sample) -> f64| -> Vec<f64> {
        (1..samples)
            .map(|index| runs.iter().map(|run| of(&run.series[index])).sum())
            .collect()
    };
    let dimension = plan.dimension();
    let signals = [
        series(&|sample| total(&sample.species).number),
        series(&|sample| granular_temperature(&total(&sample.species), dimension)),
        series(&|sample| total(&sample.species).translation),
        series(&|sample| total(&sample.species).rotation),
        series(&|sample| sample.potential),
    ];
    let mut begin = 0;
    for signal in signals {
        let largest = signal
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()));
        let low = signal
            .iter()
            .fold(f64::INFINITY, |least, &value| least.min(value));
        let high = signal
            .iter()
            .fold(f64::NEG_INFINITY, |most, &value| most.max(value));
        // What does not change but by rounding is steady.
        if high - low > 1e-9 * largest {
            begin = begin.max(steady::beginning(&signal)?);
        }
    }
    Some(plan.sample_time(begin as u64))
}

/// The windows of the case and, last, the steady state of all engines; without one, the last quarter of the run.
fn windows(plan: &Plan, steady: impl Iterator<Item = Option<f64>>) -> Vec<Window> {
    let (count, length) = (plan.flow.run.blocks as usize, plan.block());
    let window = |start: f64, end: f64, steady: bool| {
        let first = ((start / length).round() as usize).min(count - 1);
        let last = ((end / length).round() as usize).clamp(first + 1, count);
        Window {
            blocks: first..last,
            times: [first as f64 * length, last as f64 * length],
            steady,
        }
    };
    let until = plan.flow.run.until;
    let mut steady = steady;
    let from = steady.try_fold(0.0_f64, |latest, from| Some(latest.max(from?)));
    let last = match from {
        // The block in which it becomes steady is left out.
        Some(from) => window((from / length).ceil() * length, until, true),
        None => window(0.75 * until, until, false),
    };
    let chosen = plan.flow.fields.windows.iter();
    chosen
        .map(|&[start, end]| window(start, end, false))
        .chain([last])
        .collect()
}
