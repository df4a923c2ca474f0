//! What one replica measures, and when.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use stosszahl_dsmc::homogeneous::{Ledger, Moments};

use super::plan::Plan;

/// Times at which the steady state of sticking and breaking is sampled.
pub(super) const STEADY_SAMPLES: usize = 200;

/// What may be due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Due {
    /// Scaling of the velocities.
    Heating,
    /// Moments of velocities and displacements.
    Sample,
    /// Numbers of clusters by size.
    Sizes,
    /// Numbers of clusters by size for the average over the steady state.
    Steady,
}

/// What is due at one time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moment {
    /// When, in the unit of time of the case.
    pub time: f64,
    /// What.
    pub due: Vec<Due>,
}

impl Moment {
    /// Whether something is due.
    pub fn asks(&self, due: Due) -> bool {
        self.due.contains(&due)
    }
}

/// All moments of a case, in order.
pub(super) fn schedule(plan: &Plan) -> Vec<Moment> {
    let case = &plan.case;
    let samples = case.sample_times();
    let sizes = &case.measure.size_distribution_times;
    let steady: Vec<f64> = case.measure.steady.map_or_else(Vec::new, |steady| {
        let span = case.run.until - steady.from;
        (1..=STEADY_SAMPLES)
            .map(|i| {
                if i == STEADY_SAMPLES {
                    case.run.until
                } else {
                    steady.from + span * i as f64 / STEADY_SAMPLES as f64
                }
            })
            .collect()
    });
    let heating: Vec<f64> = case.heating_interval.map_or_else(Vec::new, |interval| {
        let count = (case.run.until / interval) as u64;
        (1..=count).map(|i| i as f64 * interval).collect()
    });
    let lists = [
        (Due::Heating, &heating),
        (Due::Sample, &samples),
        (Due::Sizes, sizes),
        (Due::Steady, &steady),
    ];
    let mut all: Vec<(f64, Due)> = lists
        .into_iter()
        .flat_map(|(due, times)| times.iter().map(move |&time| (time, due)))
        .filter(|&(time, _)| time <= case.run.until)
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut moments: Vec<Moment> = Vec::new();
    for (time, due) in all {
        match moments.last_mut() {
            Some(last) if last.time == time => last.due.push(due),
            _ => moments.push(Moment {
                time,
                due: vec![due],
            }),
        }
    }
    moments
}

/// The gas at one sample time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// When, in the unit of time of the case.
    pub time: f64,
    /// Particles.
    pub particles: usize,
    /// Pair collisions since the start.
    pub collisions: u64,
    /// Kinetic energy, tracers included.
    pub energy: f64,
    /// Moments of each group.
    pub groups: Vec<Moments>,
    /// Clusters, where particles stick.
    pub clusters: Option<Clusters>,
}

/// Clusters at one time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clusters {
    /// Clusters of one monomer.
    pub single: u64,
    /// Monomers of the largest cluster.
    pub largest: u32,
    /// Mean over monomers of the number of monomers in their cluster.
    pub mean_by_mass: f64,
    /// What was booked since the start.
    pub ledger: Ledger,
    /// Kinetic energy put in by heating since the start.
    pub heated: f64,
}

/// Numbers of clusters by their monomers.
pub type Sizes = BTreeMap<u32, u64>;

/// The measurements of one replica.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The gas at the sample times.
    pub samples: Vec<Sample>,
    /// Displacements averaged over time by group and lag, at the end of the run.
    pub time_averaged: Vec<Vec<f64>>,
    /// Numbers of clusters by their monomers, by time.
    pub sizes: Vec<(f64, Sizes)>,
    /// Sums over the first and the second half of the steady state.
    pub steady: [Steady; 2],
    /// Kinetic energy put in by heating so far.
    pub heated: f64,
}

/// Sums over times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Steady {
    /// Number of times.
    pub times: u64,
    /// Numbers of clusters by their monomers, summed.
    pub sizes: Sizes,
}
