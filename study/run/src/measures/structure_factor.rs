//! Measure `structure_factor`: the structure factor S(k) of disks in a periodic box, by fast
//! Fourier transform.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::structure_factor::{
    Assignment, LatticeOptions as GridOptions, StructureFactor, StructureFactorPlan,
};
use stosszahl_results::{CellValues, Figure, FigureAxis, Table, table};

use super::mean_over_replicas;
use crate::measure::{
    self, BadOption, CompletedRun, Measure, Probe, ReplicaRecords, SampleContext, SampleProbe,
    described,
};
use crate::plan::{CasePlan, EnginePlan};

/// Caption of structure figures on how simulators of Monte Carlo enter them.
pub(super) const OF_SIMULATORS: &str = "Of Monte Carlo with n simulators for each particle all simulators are shown. Each is 1/n of a particle: independent ones have \
     S(k) = 1/n. At t = 0 they are n copies of the exact start.";

/// Measure `structure_factor` of the function S(k).
pub struct StructureFactors;

/// Assignment of a particle to the points of the density grid.
#[derive(Clone, Copy, Debug, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sharing {
    /// Nearest grid point: the whole particle on the nearest point.
    NearestGridPoint,
    /// Cloud in cell: linear shares on the four points around the particle.
    CloudInCell,
}

/// Options of `[measure.structure_factor]`: times, grid and wave numbers.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StructureFactorOptions {
    /// Times at which S(k) is measured. Default: the start and the end of the run.
    pub times: Option<Vec<f64>>,
    /// Assignment of a particle to the points of the density grid.
    pub assignment: Sharing,
    /// Correct S(k) for the shape of the assignment.
    pub correction: bool,
    /// Largest mode number L/wavelength of S(k).
    pub largest_wave_number: u64,
}

impl Default for StructureFactorOptions {
    fn default() -> Self {
        Self {
            times: None,
            assignment: Sharing::CloudInCell,
            correction: true,
            largest_wave_number: 64,
        }
    }
}

/// Returns the times at which structure is measured: `times`, or else the start and the end of the
/// run.
pub(super) fn structure_times(plan: &CasePlan, times: Option<Vec<f64>>) -> Vec<f64> {
    times.unwrap_or_else(|| vec![0.0, plan.case.run.until])
}

/// Returns an error for a case without positions, or with a box that is not periodic.
pub(super) fn require_periodic(plan: &CasePlan) -> Result<(), BadOption> {
    let periodic = plan.has_box() && !plan.is_bounded();
    measure::require(periodic, "", "a periodic box without walls and obstacles")
}

impl StructureFactors {
    /// Returns the sides of the box, and the options of the density lattice.
    fn lattice(options: &StructureFactorOptions, plan: &CasePlan) -> ([f64; 2], GridOptions) {
        let [x, y, _] = plan.gas.lengths;
        let options = GridOptions {
            largest_wave_number: options.largest_wave_number as usize,
            assignment: match options.assignment {
                Sharing::NearestGridPoint => Assignment::NearestGridPoint,
                Sharing::CloudInCell => Assignment::CloudInCell,
            },
            correction: options.correction,
            diameter: mean_diameter(plan),
        };
        ([x, y], options)
    }
}

/// Returns the mean diameter of the particles \[engine length\]: exactly one if it is the unit of
/// length.
pub(super) fn mean_diameter(plan: &CasePlan) -> f64 {
    if plan.has_thermal_units() {
        return 1.0;
    }
    2.0 * plan.mean_radius()
}

/// Result of a structure measurement for all particles, and for each pair of species of a mixture.
#[derive(Serialize, Deserialize)]
pub(super) struct WithPairs<T> {
    /// Result for all particles together.
    pub all: T,
    /// Result for each pair of species, in the order of
    /// [`pair_index`](stosszahl_analysis::contact_value::pair_index); empty in a gas of one
    /// species.
    pub pairs: Vec<T>,
}

/// Returns the pairs of species of a mixture with their key cells: numbers from 1, and names; empty
/// in a gas of one species.
pub(super) fn species_pairs(plan: &CasePlan) -> Vec<([u64; 2], String)> {
    let count = plan.gas.species.len();
    if count < 2 {
        return Vec::new();
    }
    let all = (0..count).flat_map(|b| (0..=b).map(move |a| [a, b]));
    all.map(|pair| (pair.map(|one| one as u64 + 1), plan.pair_name(pair)))
        .collect()
}

/// Species of each particle of a mixture, by particle index.
pub(super) struct SpeciesOf {
    /// Number of species of the mixture; 0 in a gas of one species.
    count: usize,
    species: Vec<u32>,
}

impl SpeciesOf {
    /// Collects the species of all particles of a case.
    pub(super) fn new(plan: &CasePlan) -> Self {
        let mixture = plan.gas.species.len() > 1;
        let count = if mixture { plan.gas.species.len() } else { 0 };
        let particles = if mixture { plan.count() } else { 0 };
        let species = (0..particles).map(|index| plan.species_of(index) as u32);
        Self {
            count,
            species: species.collect(),
        }
    }

    /// Returns the positions of the particles of each species, from one simulator for each
    /// particle; empty in a gas of one species.
    pub(super) fn places(&self, moment: &SampleContext<'_>) -> Vec<Vec<Vector3<f64>>> {
        let mut places = vec![Vec::new(); self.count];
        if self.count > 0 {
            for (one, &species) in moment.particles().all.iter().zip(&self.species) {
                places[species as usize].push(one.position);
            }
        }
        places
    }
}

/// Results by time; `None` at a time without enough particles.
pub(super) type ByTime<T> = Vec<(f64, Option<T>)>;

/// Fills a table with rows for each engine and time. For the result of one replica, `places` yields
/// the key cells, the value, and further cells of each row.
pub(super) fn by_time<T: 'static, K: CellValues, C: CellValues>(
    mut table: Table,
    plan: &CasePlan,
    runs: &ReplicaRecords<'_>,
    places: impl Fn(&T) -> Vec<(K, f64, C)>,
) -> Table {
    for (engine, records) in runs.each::<ByTime<T>>(plan) {
        for (index, (time, _)) in records
            .first()
            .into_iter()
            .flat_map(|first| first.iter().enumerate())
        {
            let found = records
                .iter()
                .map(|record| record[index].1.as_ref().map(&places));
            let found: Vec<_> = found.map(Option::unwrap_or_default).collect();
            let values: Vec<Vec<f64>> = (found.iter())
                .map(|places| places.iter().map(|place| place.1).collect())
                .collect();
            let first = found.into_iter().next().unwrap_or_default();
            for (number, (key, _, more)) in first.into_iter().enumerate() {
                let value =
                    mean_over_replicas(values.iter().map(|values| values.get(number).copied()));
                table.add((engine.name, *time, key, value, more));
            }
        }
    }
    table
}

/// Structure factors at one time, of all particles and of each pair of species.
type Found = WithPairs<StructureFactor>;

/// Returns the structure factor of all particles at the last time of a run; `None` if it was not
/// measured.
pub(crate) fn last_structure_factor(run: &CompletedRun) -> Option<&StructureFactor> {
    let (_, found) = run.record::<ByTime<Found>>()?.last()?;
    Some(&found.as_ref()?.all)
}

impl Measure for StructureFactors {
    described!(
        "structure_factor",
        "Structure factor S(k) of the density, averaged over shells of wave numbers.",
        StructureFactorOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        plan.is_disk_fluid()
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        require_periodic(plan)?;
        measure::require(plan.gas.dimension == 2, "", "disks: gas.dimension = 2")?;
        let options: StructureFactorOptions = measure::options(plan, self.name())?;
        let largest = options.largest_wave_number;
        let allowed = "a whole number from 1 to 2048";
        measure::require(
            (1..=2048).contains(&largest),
            "largest_wave_number",
            allowed,
        )?;
        let (lengths, options) = Self::lattice(&options, plan);
        let grid = StructureFactorPlan::new(lengths, options);
        grid.map(drop).map_err(|error| BadOption {
            key: "largest_wave_number".into(),
            allowed: format!("{error}; allowed: smaller wave numbers"),
        })
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        structure_times(
            plan,
            measure::chosen::<StructureFactorOptions>(plan, self.name()).times,
        )
    }

    fn gathers_particles(&self, plan: &CasePlan) -> bool {
        plan.gas.species.len() > 1
    }

    fn working_bytes(&self, plan: &CasePlan) -> f64 {
        let (lengths, options) = Self::lattice(&measure::chosen(plan, self.name()), plan);
        StructureFactorPlan::memory_bytes(lengths, options)
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let (lengths, options) = Self::lattice(&measure::chosen(plan, self.name()), plan);
        let record = ByTime::<Found>::new();
        let species = SpeciesOf::new(plan);
        Box::new(SampleProbe::new(record, move |record, moment| {
            let weight = moment.simulation.mean_weight();
            let count = moment.simulation.particle_count();
            // The lattice, which may be larger than the gas, is there only meanwhile.
            let grid = StructureFactorPlan::new(lengths, options);
            let found = grid
                .and_then(|mut grid| {
                    let mut lattice = grid.lattice_of(count);
                    moment.simulation.reduce_particles(&mut lattice);
                    let all = grid.measure_on(lattice, weight)?;
                    let places = species.places(moment);
                    let plane = |all: &Vec<Vector3<f64>>| all.iter().map(Vector3::xy).collect();
                    let places: Vec<Vec<_>> = places.iter().map(plane).collect();
                    let pairs = grid.measure_partial(&places)?;
                    Ok(WithPairs { all, pairs })
                })
                .ok();
            record.push((moment.time, found));
        }))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let figure = Figure::curves(
            "Structure factor",
            FigureAxis::logarithmic("mode_number", "mode number L/wavelength"),
            FigureAxis::logarithmic("structure_factor", "S(k)"),
        );
        let table = table! {
            "structure_factor", "Structure factor by shells of wave numbers.";
            key "engine", "", "Engine";
            key "time", "time", "Time since the start";
            key "mode_number", "1", "Mode number L/wavelength, mean of the shell";
            estimate "structure_factor", "1", "Structure factor S(k); one for an ideal gas";
            note "modes", "1", "Wave vectors of the shell, one of each pair k and -k";
        }
        .figure(
            figure
                .panels(&["time"])
                .line("ideal gas", 1.0)
                .caption(OF_SIMULATORS),
        );
        let mut tables = vec![by_time(table, plan, runs, |found: &Found| {
            let shells = found.all.shells.iter();
            shells
                .map(|shell| (shell.wave_number, shell.value, shell.modes))
                .collect()
        })];
        let named = species_pairs(plan);
        if !named.is_empty() {
            let table = table! {
                "partial_structure_factor", "Partial structure factors of the pairs of species, by shells of wave numbers.";
                key "engine", "", "Engine";
                key "time", "time", "Time since the start";
                key "species_a", "1", "Number of one species, from 1";
                key "species_b", "1", "Number of the other, not below the first";
                key "pair", "", "Names of both species";
                key "mode_number", "1", "Mode number L/wavelength, mean of the shell";
                estimate "structure_factor", "1", "Partial structure factor S_ab(k), of one simulator for each particle; of an ideal gas 1 for pairs of one species, else 0";
                note "modes", "1", "Wave vectors in the shell";
            }
            .figure(
                Figure::curves(
                    "Partial structure factors",
                    FigureAxis::logarithmic("mode_number", "L/wavelength"),
                    FigureAxis::linear("structure_factor", "S_ab(k)"),
                )
                .by(&["engine", "pair"])
                .panels(&["time"])
                .caption("One simulator for each particle. An ideal gas has 1 for pairs of one species and 0 for pairs of two."),
            );
            tables.push(by_time(table, plan, runs, |found: &Found| {
                let pairs = named.iter().zip(&found.pairs);
                let rows = pairs.flat_map(|(named, one)| {
                    let shells = one.shells.iter();
                    shells.map(|one| {
                        (
                            (named.0, named.1.clone(), one.wave_number),
                            one.value,
                            one.modes,
                        )
                    })
                });
                rows.collect()
            }));
        }
        tables
    }
}
