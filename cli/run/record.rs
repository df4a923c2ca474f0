//! What one engine of one replica measures, and when.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::energy::EnergySample;
use stosszahl_analysis::pair_correlation::{self, PairCorrelation};
use stosszahl_analysis::structure_factor::{StructureFactor, StructureFactorPlan};
use stosszahl_analysis::windows::{PairBins, Windows};
use stosszahl_model::{Sizes, State};

use super::driven::Driven;
use crate::dispatch::Planar;
use crate::setup::{Setup, structure_options};

/// Width of the bins of g(r), in diameters.
const PAIR_CORRELATION_BIN: f64 = 0.05;

/// What is due at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// When, in units of `t_0`.
    pub time_over_t0: f64,
    /// Moments of the velocities.
    pub energy: bool,
    /// S(k) and g(r).
    pub structure: bool,
    /// All disks into a file.
    pub snapshot: bool,
    /// The mean squared displacement: the time since its start, which is where this is zero.
    pub displacement: Option<f64>,
}

/// All moments of a case, in order.
pub fn schedule(setup: &Setup) -> Vec<Moment> {
    let (energy, case) = (setup.case.sample_times(), &setup.case);
    let (structure, snapshot) = (&case.measure.structure.times, &case.measure.snapshot_times);
    // Windows begin and end between legs, so that no step of a Monte Carlo engine lies across an edge.
    let edges = case.measure.impact_windows.as_flattened();
    let origin = case.measure.displacement_start.map(|start| (start, 0.0));
    let mut displacements = case.displacement_times();
    displacements.extend(origin);
    let mut times: Vec<f64> = energy
        .iter()
        .chain(structure)
        .chain(snapshot)
        .chain(edges)
        .copied()
        .chain(displacements.iter().map(|&(time, _)| time))
        .collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
        .into_iter()
        .map(|time_over_t0| Moment {
            time_over_t0,
            energy: energy.contains(&time_over_t0),
            structure: structure.contains(&time_over_t0),
            snapshot: snapshot.contains(&time_over_t0),
            displacement: displacements
                .iter()
                .find(|moment| moment.0 == time_over_t0)
                .map(|moment| moment.1),
        })
        .collect()
}

/// The measurements of one engine of one replica.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// Moments of the velocities at the sample times.
    pub energies: Vec<(f64, EnergySample)>,
    /// Collisions in windows of time.
    pub windows: Windows,
    /// S(k) by time over `t_0`.
    pub structure: Vec<(f64, StructureFactor)>,
    /// g(r) by time over `t_0`.
    pub pairs: Vec<(f64, PairCorrelation)>,
    /// Mean squared displacement in d^2 by the time since its start over `t_0`.
    pub displacements: Vec<(f64, f64)>,
    /// Temperature of each species by time over `t_0`; empty in a gas of one.
    pub partial: Vec<(f64, Vec<f64>)>,
    /// Kicks and the temperature between them; none in a gas that cools freely.
    pub driven: Option<Driven>,
}

impl Record {
    /// An empty record of a gas at temperature `temperature`.
    pub fn new(setup: &Setup, temperature: f64) -> Self {
        let spans: Vec<[f64; 2]> = setup
            .case
            .measure
            .impact_windows
            .iter()
            .map(|span| span.map(|edge| edge * setup.time))
            .collect();
        let mut windows = Windows::new(
            &spans,
            setup.case.measure.impact_bins,
            setup.disks,
            0.0,
            temperature,
        );
        if !setup.species.is_empty() {
            let species: Vec<(f64, f64)> = setup
                .species
                .iter()
                .map(|one| (one.radius, one.mass))
                .collect();
            let measure = &setup.case.measure;
            windows.pairs = Some(PairBins::new(
                &species,
                measure.impact_windows.len(),
                measure.impact_bins,
            ));
        }
        Self {
            energies: Vec::new(),
            windows,
            structure: Vec::new(),
            pairs: Vec::new(),
            displacements: Vec::new(),
            partial: Vec::new(),
            driven: setup.case.drive.map(|_| Driven::new(temperature)),
        }
    }
}

impl Record {
    /// Energy over that of the start, K/K(0), at a sample time.
    pub fn energy_ratio(&self, sample: usize) -> f64 {
        self.energies[sample].1.temperature / self.energies[0].1.temperature
    }
}

/// Temperature `m <v^2>/2` of each species of a gas; empty in a gas of one.
pub fn partial_temperatures<P: Planar>(setup: &Setup, scene: &P, state: &State<P>) -> Vec<f64> {
    let mut sums = vec![(0_usize, 0.0); setup.species.len()];
    if sums.is_empty() {
        return Vec::new();
    }
    let sizes = scene.sizes();
    for (index, body) in state.bodies.iter().enumerate() {
        let (count, twice) = &mut sums[setup.species_of(index)];
        *count += 1;
        *twice += sizes.mass(sizes.tag(index)) * body.velocity.norm_squared();
    }
    sums.iter()
        .map(|&(count, twice)| 0.5 * twice / count.max(1) as f64)
        .collect()
}

/// The grid of S(k), planned once for all times.
pub struct Structure<'a> {
    setup: &'a Setup,
    plan: StructureFactorPlan,
}

impl<'a> Structure<'a> {
    /// Plans the transforms.
    ///
    /// # Errors
    /// As `StructureFactorPlan::new`.
    pub fn new(setup: &'a Setup) -> Result<Self, stosszahl_analysis::Error> {
        let options = structure_options(&setup.case);
        let plan = StructureFactorPlan::new(setup.domain.lengths().into(), options)?;
        Ok(Self { setup, plan })
    }

    /// Measures S(k) and g(r).
    ///
    /// # Errors
    /// As the measurements; only for positions that are no numbers.
    pub fn measure<P: Planar>(
        &mut self,
        state: &State<P>,
        weight: f64,
    ) -> Result<(StructureFactor, PairCorrelation), stosszahl_analysis::Error> {
        let positions: Vec<Vector2<f64>> = state.bodies.iter().map(|body| body.position).collect();
        let lengths = state.domain.lengths();
        let range = self
            .setup
            .case
            .measure
            .pair_correlation_range
            .min(0.499_999 * lengths.min());
        let bins = ((range / PAIR_CORRELATION_BIN).round() as usize).max(1);
        let pairs = pair_correlation::measure(&positions, lengths.into(), 1.0, range, bins)?;
        Ok((self.plan.measure(&positions, weight)?, pairs))
    }
}
