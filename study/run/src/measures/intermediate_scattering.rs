//! Measure `intermediate_scattering`: the intermediate scattering function `F(k, t) = (w/N) <rho(k,
//! t) rho*(k, 0)>`, which shows how long density waves last.
//!
//! Time runs from a chosen moment of the run. It is a property of the density, so particles need
//! not be known by their index.

use serde::{Deserialize, Serialize};
use stosszahl_analysis::modes::{Amplitudes, ModeWeights};
use stosszahl_analysis::relaxation::jackknife;
use stosszahl_analysis::spectra::Shells;
use stosszahl_results::{Figure, FigureAxis, Table, TableEstimate, table};

use super::spectra::{LARGEST, require_number, require_waves, shells};
use super::{grid, mean_over_replicas};
use crate::measure::{self, BadOption, Measure, Probe, ReplicaRecords, SampleProbe, described};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `intermediate_scattering` of the function F(k, t).
pub struct IntermediateScattering;

/// Options of `[measure.intermediate_scattering]`: begin of the measurement and wave numbers.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ScatteringOptions {
    /// Time of the density waves with which later ones are correlated.
    pub from: f64,
    /// Shells to measure, as whole numbers n: shell n has the modes whose |k| L/2π rounds to n,
    /// with the first side L of the box.
    pub wave_numbers: Vec<u64>,
    /// Most wave vectors of a shell, one of each pair k and -k.
    pub modes_per_shell: u64,
}

impl Default for ScatteringOptions {
    fn default() -> Self {
        Self {
            from: 0.0,
            wave_numbers: vec![1, 2, 4, 8],
            modes_per_shell: 48,
        }
    }
}

impl ScatteringOptions {
    fn shells(&self, plan: &CasePlan) -> Result<Shells, String> {
        let numbers: Vec<usize> = self.wave_numbers.iter().map(|&k| k as usize).collect();
        shells(plan, &numbers, self.modes_per_shell)
    }
}

#[derive(Default, Serialize, Deserialize)]
struct Record {
    /// Density amplitudes rho(k) at the start of the measurement, one for each mode.
    first: Vec<[f64; 2]>,
    /// Values of F(k, t), by the time t since the start of the measurement, then by shell.
    scattering: Vec<(f64, Vec<f64>)>,
}

impl Measure for IntermediateScattering {
    described!(
        "intermediate_scattering",
        "Intermediate scattering function F(k, t): correlation of density waves with those of a chosen time.",
        ScatteringOptions
    );

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        require_waves(plan)?;
        let options: ScatteringOptions = measure::options(plan, self.name())?;
        let numbers = &options.wave_numbers;
        let allowed = format!("a rising list of whole numbers from 1 to {LARGEST}");
        let good = !numbers.is_empty()
            && numbers.is_sorted_by(|a, b| a < b)
            && numbers.iter().all(|k| (1..=LARGEST).contains(k));
        measure::require(good, "wave_numbers", allowed)?;
        require_number(options.modes_per_shell, "modes_per_shell")?;
        let bad = |allowed| BadOption {
            key: "wave_numbers".into(),
            allowed,
        };
        options.shells(plan).map(|_| ()).map_err(bad)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        let from = measure::chosen::<ScatteringOptions>(plan, self.name()).from;
        let later = grid(plan, plan.case.run.until - from).map(|elapsed| from + elapsed);
        std::iter::once(from).chain(later).collect()
    }

    fn kept_bytes(&self, plan: &CasePlan) -> f64 {
        let shells = measure::chosen::<ScatteringOptions>(plan, self.name()).shells(plan);
        shells.map_or(0.0, |shells| {
            let looks = self.sample_times(plan).len() * shells.ranges().count() * size_of::<f64>();
            (looks + shells.modes().indices().len() * size_of::<[f64; 2]>()) as f64
        })
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let options = measure::chosen::<ScatteringOptions>(plan, self.name());
        let (shells, from) = (options.shells(plan), options.from);
        Box::new(SampleProbe::new(
            Record::default(),
            move |record, moment| {
                let Ok(shells) = &shells else { return };
                let mut amplitudes = Amplitudes::new(shells.modes().clone(), ModeWeights::Density);
                moment.simulation.reduce_particles(&mut amplitudes);
                let (points, sums) = amplitudes.sums().unwrap_or_default();
                let now: Vec<[f64; 2]> = sums.iter().map(|sum| [sum.re, sum.im]).collect();
                if moment.time == from {
                    record.first.clone_from(&now);
                }
                let unit = moment.simulation.mean_weight() / points as f64;
                let products: Vec<f64> = (now.iter().zip(&record.first))
                    .map(|(now, first)| now[0] * first[0] + now[1] * first[1])
                    .collect();
                let means = shells.ranges().map(|range| {
                    let modes = products.get(range).unwrap_or_default();
                    unit * modes.iter().sum::<f64>() / modes.len() as f64
                });
                let means = means.collect();
                record.scattering.push((moment.time - from, means));
            },
        ))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let Ok(shells) = measure::chosen::<ScatteringOptions>(plan, self.name()).shells(plan)
        else {
            return Vec::new();
        };
        let figure = Figure::curves(
            "Intermediate scattering function",
            FigureAxis::logarithmic("lag", "time"),
            FigureAxis::linear("correlation", "F(k, t)/F(k, 0)"),
        );
        let mut table = table! {
            "intermediate_scattering", "Correlation of density waves with those of a chosen time.";
            key "engine", "", "Engine";
            key "mode_number", "1", "Mode number L/wavelength, mean of the shell";
            key "lag", "time", "Time since the beginning of the measurement";
            estimate "scattering", "1", "F(k, t) = <rho(k, t) rho*(k, 0)>/N of the disks; the structure factor at the beginning";
            estimate "correlation", "1", "F(k, t)/F(k, 0), quotient of the means over replicas";
            note "modes", "1", "Wave vectors that were averaged, one of each pair k and -k";
            note "replicas", "1", "Replicas";
        }
        .figure(figure.panels(&["mode_number"]).line("forgotten", 0.0));
        let numbers = shells.wave_numbers();
        for (engine, records) in runs.each::<Record>(plan) {
            let times = records.first().map_or(&[][..], |one| &one.scattering);
            for (shell, range) in shells.ranges().enumerate() {
                for (index, &(elapsed, _)) in times.iter().enumerate() {
                    let at = |record: &Record, look: usize| {
                        record.scattering.get(look)?.1.get(shell).copied()
                    };
                    let values = records.iter().map(|record| at(record, index));
                    let pairs = records
                        .iter()
                        .filter_map(|record| Some([at(record, index)?, at(record, 0)?]));
                    let pairs: Vec<[f64; 2]> = pairs.collect();
                    let ratio = jackknife(&pairs, |[now, first]| now / first);
                    let ratio = ratio.map_or_else(TableEstimate::default, |found| {
                        TableEstimate::with_error(found.value, found.standard_error)
                    });
                    table.add((
                        (engine.name, numbers[shell], elapsed),
                        mean_over_replicas(values),
                        ratio,
                        range.len(),
                        records.len(),
                    ));
                }
            }
        }
        vec![table]
    }
}
