//! Measure `fields`: density, velocity, temperatures, pressure and collision rate in cells and
//! along both axes, averaged over time windows.

mod channel;
mod layers;
mod tables;
mod verdicts;
mod view;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::fields::{FieldGrid, FieldSums as Sums};
use stosszahl_model::{Collision, Observer, images};
use stosszahl_results::{Table, VerdictText};

use view::View;

use super::gas_series::{GasSample, GasSampling, GasSeries};
use super::time_blocks::{self, TimeBlocks};
use crate::measure::{
    self, BadOption, Measure, Probe, ReplicaRecords, SampleContext, described, keeps_record,
};
use crate::plan::{CasePlan, EngineKind, EnginePlan};

/// Measure `fields` of the fields of a flow, on a grid over the first two axes.
pub struct FieldMeasure;

/// Memory of a table row of fields while the report draws it \[bytes\], as measured.
const SHOWN: f64 = 3400.0;
/// Largest number of stored sums: cells times species times time blocks.
const MOST_SUMS: usize = 20_000_000;

/// Options of `[measure.fields]`: cells, time blocks and windows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FieldOptions {
    /// Cells along the first two axes, each from 1 to 1000.
    pub cells: [u64; 2],
    /// Blocks of time that fields are kept for, and that their standard errors come from; a divisor
    /// of the number of samples. Default: the one nearest to 40.
    pub blocks: Option<u64>,
    /// Time windows over which fields are averaged, besides the steady state; moved to the ends of
    /// blocks.
    pub windows: Vec<[f64; 2]>,
}

impl Default for FieldOptions {
    fn default() -> Self {
        Self {
            cells: [20, 20],
            blocks: None,
            windows: Vec::new(),
        }
    }
}

impl FieldOptions {
    fn of(plan: &CasePlan) -> Self {
        measure::chosen(plan, FieldMeasure.name())
    }

    fn grid(&self, plan: &CasePlan) -> Result<FieldGrid, stosszahl_analysis::Error> {
        let [x, y, z] = plan.gas.lengths;
        let depth = if plan.gas.dimension == 3 { z } else { 1.0 };
        FieldGrid::new([x, y], self.cells.map(|count| count as usize), depth)
    }

    fn sums(&self, plan: &CasePlan) -> Result<Sums, stosszahl_analysis::Error> {
        let blocks = time_blocks::blocks(plan, self.blocks);
        let length = plan.engine_time(plan.case.run.until) / blocks as f64;
        Sums::new(
            self.grid(plan)?,
            plan.gas.species.len().max(1),
            blocks,
            length,
        )
    }
}

/// Sums for the fields of one replica.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Record {
    series: GasSeries,
    sums: Sums,
}

impl Measure for FieldMeasure {
    described!(
        "fields",
        "Density, velocity, temperatures, pressure and collision rate in cells, and profiles along both axes.",
        FieldOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        !plan.is_uniform()
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let options: FieldOptions = measure::options(plan, self.name())?;
        let good = options.cells.iter().all(|count| (1..=1000).contains(count));
        measure::require(good, "cells", "two whole numbers from 1 to 1000")?;
        let blocks = time_blocks::blocks(plan, options.blocks);
        time_blocks::check_blocks(plan, blocks)?;
        let [columns, rows] = options.cells.map(|count| count as usize);
        let few = columns * rows * blocks * plan.gas.species.len() <= MOST_SUMS;
        let allowed = format!("at most {MOST_SUMS} cells times blocks times species");
        measure::require(few, "cells", allowed)?;
        let failed = |error: stosszahl_analysis::Error| BadOption {
            key: String::new(),
            allowed: error.to_string(),
        };
        options.grid(plan).map(drop).map_err(failed)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        time_blocks::times(plan).split_off(1)
    }

    /// Returns the memory of the sums \[bytes\]: seven for each cell, block and species, and two of
    /// collisions for each cell and block.
    fn kept_bytes(&self, plan: &CasePlan) -> f64 {
        let options = FieldOptions::of(plan);
        let cells: u64 = options.cells.iter().product();
        let blocks = time_blocks::blocks(plan, options.blocks);
        let sums = 7 * plan.gas.species.len().max(1) + 2;
        cells as f64 * (blocks * sums * size_of::<f64>()) as f64
    }

    /// Returns the memory of the figures \[bytes\], from the rows of the table: one for each cell,
    /// time window and engine.
    fn figure_bytes(&self, plan: &CasePlan) -> f64 {
        let options = FieldOptions::of(plan);
        let cells: u64 = options.cells.iter().product();
        let windows = options.windows.len() + 1;
        cells as f64 * (windows * plan.engines.len()) as f64 * SHOWN
    }

    fn new_probe(&self, plan: &CasePlan, engine: &EnginePlan) -> Box<dyn Probe> {
        let options = FieldOptions::of(plan);
        Box::new(Watch {
            sampling: GasSampling::from_plan(plan),
            per_block: time_blocks::per_block(plan, time_blocks::blocks(plan, options.blocks)),
            lengths: plan.gas.lengths,
            periodic: plan.periodic(),
            carries: match &engine.kind {
                EngineKind::EventDriven { .. } => true,
                EngineKind::MonteCarlo(parameters) => parameters.scheme.is_cross_cell(),
                EngineKind::Homogeneous(_) => false,
            },
            record: Record {
                series: GasSeries::new(),
                sums: options.sums(plan).expect("the options are checked"),
            },
        })
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let options = FieldOptions::of(plan);
        let windows = windows(plan, &options, runs);
        let (mut cells, mut profiles) = (tables::cells(&options), tables::profiles(&options));
        let mut layers = layers::has_layers(plan, &options).then(layers::table);
        for (engine, records) in runs.each::<Record>(plan) {
            let sums: Vec<&Sums> = records.iter().map(|record| &record.sums).collect();
            let Some(grid) = sums.first().map(|sums| sums.grid()) else {
                continue;
            };
            let free_shares = plan.free_shares(engine, grid.counts());
            for window in &windows {
                let seen = (window, &View::new(plan, &sums, &free_shares, window));
                tables::fill_cells(&mut cells, plan, engine, grid, seen);
                tables::fill_profiles(&mut profiles, plan, engine, grid, seen);
                if let Some(layers) = &mut layers {
                    layers::fill(layers, plan, engine, grid, seen);
                }
            }
        }
        [Some(cells), Some(profiles), layers]
            .into_iter()
            .flatten()
            .collect()
    }

    fn test_count(&self, plan: &CasePlan) -> usize {
        // Profiles of two engines; the barometric profile, walls and symmetry of each.
        4 * plan.engines.len() - 1
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        tables: &[Table],
    ) -> Vec<VerdictText> {
        let options = FieldOptions::of(plan);
        let steady = steady(plan, runs);
        let window = TimeBlocks::last(plan, time_blocks::blocks(plan, options.blocks), &steady);
        let counts = options.cells.map(|count| count as usize);
        let found = runs.each::<Record>(plan).map(|(engine, records)| {
            let sums: Vec<&Sums> = records.iter().map(|record| &record.sums).collect();
            (sums, plan.free_shares(engine, counts))
        });
        let found: Vec<_> = found.collect();
        let views: Vec<View<'_>> = (found.iter())
            .map(|(sums, free_shares)| View::new(plan, sums, free_shares, &window))
            .collect();
        verdicts::field_verdicts(
            plan,
            counts,
            &steady,
            (&window, &views),
            tables,
            &runs.rule(plan),
        )
    }
}

/// Finds, for each engine, the time from which its flow is steady, in the unit of time of the case;
/// `None` if it never is.
fn steady(plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Option<f64>> {
    time_blocks::steady::<Record>(plan, runs, |record| &record.series)
}

/// Returns the time windows of the case and, last, the window that verdicts use.
fn windows(plan: &CasePlan, options: &FieldOptions, runs: &ReplicaRecords<'_>) -> Vec<TimeBlocks> {
    let blocks = time_blocks::blocks(plan, options.blocks);
    let chosen = options.windows.iter();
    chosen
        .map(|&times| TimeBlocks::between_times(plan, blocks, times, false))
        .chain([TimeBlocks::last(plan, blocks, &steady(plan, runs))])
        .collect()
}

struct Watch {
    sampling: GasSampling,
    per_block: usize,
    lengths: [f64; 3],
    periodic: [bool; 2],
    /// True if collisions of the engine transfer momentum over the distance of the partners; false
    /// if partners collide as points.
    carries: bool,
    record: Record,
}

impl Observer for Watch {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            let at = [0, 1].map(|axis| {
                let (x, length) = (collision.position[axis], self.lengths[axis]);
                if self.periodic[axis] {
                    images::wrapped(x, length)
                } else {
                    x
                }
            });
            let virial = if self.carries {
                collision.virial()
            } else {
                0.0
            };
            let sums = &mut self.record.sums;
            sums.collision(collision.time, at, virial, collision.weight);
        }
    }
}

impl Probe for Watch {
    fn collision_observer(&mut self) -> Option<&mut dyn Observer> {
        Some(self)
    }

    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        let sample = GasSample::sample_gas(&self.sampling, moment);
        self.record.series.push(sample);
    }

    fn on_sample(&mut self, moment: &mut SampleContext<'_>) {
        let Record { series, sums } = &mut self.record;
        let block = (series.len() - 1) / self.per_block;
        let (sample, fields) = GasSample::take_with(&self.sampling, moment, Some(sums.sample()));
        if let Some(fields) = fields {
            sums.add_sample(block, fields);
        }
        series.push(sample);
    }

    keeps_record!();
}
