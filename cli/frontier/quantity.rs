//! What is measured of a run, all at once, and what theory says of it where it is exact.

use serde::{Deserialize, Serialize};
use stosszahl_analysis::accuracy::Known;
use stosszahl_analysis::relaxation::unbiased_cumulant;
use stosszahl_model::{kinetic, transport};

use crate::case::{Case, Engine};
use crate::run::Finished;
use crate::setup::{Setup, TimeUnit};

/// Decades of time before the end of the run in which the energy is taken, and times in each.
const DECADES: i32 = 2;
const TIMES_PER_DECADE: usize = 3;
/// Longest wave number `k = L/wavelength` of the structure factor at low k, and the shells up to it.
const LOW_WAVE_NUMBERS: usize = 4;
/// Range of the pair correlation, which is measured with S(k) but not wanted here \[d\].
const SHORT_RANGE: f64 = 1.05;

/// A kind of quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// K(t)/K(0) at seven times, the last the end of the run; relative.
    Energy,
    /// Collisions over the whole run, over Enskog's at the temperature measured; relative.
    CollisionRate,
    /// Fourth cumulant a2 at the end; absolute.
    Cumulant,
    /// Slope of P(b/d) over the whole run; absolute.
    ImpactSlope,
    /// S(k) at the end, mean over the modes of up to four waves in the box; relative.
    Structure,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Energy,
        Self::CollisionRate,
        Self::Cumulant,
        Self::ImpactSlope,
        Self::Structure,
    ];

    /// Its name on the command line and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Energy => "energy",
            Self::CollisionRate => "collision-rate",
            Self::Cumulant => "cumulant",
            Self::ImpactSlope => "impact-slope",
            Self::Structure => "structure",
        }
    }

    /// What errors are divided by: the reference, or one where it may vanish.
    pub(crate) fn unit(self, reference: f64) -> f64 {
        match self {
            Self::Energy | Self::CollisionRate | Self::Structure => reference,
            Self::Cumulant | Self::ImpactSlope => 1.0,
        }
    }
}

/// One number of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// What it is.
    pub kind: Kind,
    /// When it is taken, or up to when, in units of `t_0`.
    pub time: f64,
}

/// The case as it is measured: its gas and start, sampled and observed in the same way whatever it asks for itself.
pub(crate) fn measured(case: &Case) -> Case {
    let mut case = case.clone();
    let until = case.run.until;
    case.run.first_sample = until / 10_f64.powi(DECADES);
    case.run.samples_per_decade = TIMES_PER_DECADE;
    case.measure.impact_windows = vec![[0.0, until]];
    case.measure.structure.times = vec![until];
    case.measure.structure.largest_wave_number = LOW_WAVE_NUMBERS;
    case.measure.pair_correlation_range = SHORT_RANGE;
    case.measure.snapshot_times.clear();
    case.measure.displacement_start = None;
    case
}

/// All quantities of a measured case.
pub(crate) fn quantities(case: &Case) -> Vec<Quantity> {
    let until = case.run.until;
    let energies = case
        .sample_times()
        .into_iter()
        .skip(1)
        .map(|time| Quantity {
            kind: Kind::Energy,
            time,
        });
    let others = Kind::ALL[1..]
        .iter()
        .map(|&kind| Quantity { kind, time: until });
    energies.chain(others).collect()
}

/// Their values in a finished run, in the same order; not a number where a run does not have one.
///
/// The wave numbers of S(k) are multiples of that of the box, so S(k) is that of the case only in a box of its size,
/// `whole`.
pub(crate) fn observe(setup: &Setup, engine: &Engine, run: &Finished, whole: bool) -> Vec<f64> {
    let copies = match engine {
        Engine::Ed(_) => 1,
        Engine::Dsmc(dsmc) => setup.dsmc_parameters(dsmc).simulators_per_disk as usize,
    };
    let energies = (1..run.record.energies.len()).map(|sample| run.record.energy_ratio(sample));
    let window = run.record.windows.windows.first();
    let enskog = kinetic::collision_rate(setup.packing_fraction, setup.contact_value, 0.0);
    let rate = window.and_then(|window| window.dissipation(enskog, setup.disks));
    let last = run.record.energies.last();
    let cumulant =
        last.map(|(_, sample)| unbiased_cumulant(sample.fourth_cumulant, setup.disks * copies));
    let slope = window.and_then(stosszahl_analysis::windows::Window::slope);
    let structure = run.record.structure.last().filter(|_| whole);
    let structure = structure.map(|(_, factor)| {
        let low = || {
            let shells = factor.shells.iter();
            shells.filter(|shell| shell.wave_number < LOW_WAVE_NUMBERS as f64 + 0.5)
        };
        let modes: usize = low().map(|shell| shell.modes).sum();
        low()
            .map(|shell| shell.value * shell.modes as f64)
            .sum::<f64>()
            / modes as f64
    });
    energies
        .chain([
            rate.map_or(f64::NAN, |found| found.rate),
            cumulant.unwrap_or(f64::NAN),
            slope.unwrap_or(f64::NAN),
            structure.unwrap_or(f64::NAN),
        ])
        .collect()
}

/// What theory says of a quantity, where it is exact in the limit of a large gas; none elsewhere.
///
/// An elastic gas keeps its energy, is Maxwellian, collides at Enskog's rate (the contact value is right to 0.1 % up
/// to packing 0.5; N disks of momentum zero have `sqrt(1 - 1/N)` of the rate) and has uniform impact parameters. A gas
/// that cools in a box too small for growing waves of shear follows Haff's law with the relaxation of a2.
pub(crate) fn theory(setup: &Setup, quantity: Quantity) -> Option<Known> {
    if !setup.has_theory() || setup.case.drive.is_some() {
        return None;
    }
    let value = match (setup.time_unit, quantity.kind) {
        (TimeUnit::MeanFreeTime, Kind::Energy) => 1.0,
        (TimeUnit::MeanFreeTime, Kind::CollisionRate) => (1.0 - 1.0 / setup.disks as f64).sqrt(),
        (TimeUnit::MeanFreeTime, Kind::Cumulant | Kind::ImpactSlope) => 0.0,
        (TimeUnit::Haff, Kind::Energy) if !setup.has_unstable_modes() => {
            transport::relaxing_haff_law(setup.restitution, quantity.time)
        }
        _ => return None,
    };
    Some(Known {
        value,
        standard_error: 0.0,
    })
}
