//! Measure `spectra`: spectra of density, flow and temperature of disks in a periodic box, and
//! growth rates of shear modes against fluctuating hydrodynamics.

use serde::Deserialize;
use stosszahl_analysis::relaxation::jackknife;
use stosszahl_analysis::spectra::{Shells, Spectra, Spectrum};
use stosszahl_dsmc::SimulatorStart;
use stosszahl_results::{Figure, FigureAxis, Table, TableEstimate, table};
use stosszahl_theory::{BathState, transport};

use super::structure_factor::{require_periodic, structure_times};
use super::{mean_over_replicas, require_kept};
use crate::measure::{self, BadOption, Measure, Probe, ReplicaRecords, SampleProbe, described};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `spectra` of the hydrodynamic fields: density, flow and temperature.
pub struct HydrodynamicSpectra;

/// Largest shell number, and largest number of modes in a shell.
pub(super) const LARGEST: u64 = 2048;

/// Options of `[measure.spectra]`: times and wave numbers.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SpectraOptions {
    /// Times at which spectra are measured. Default: the start and the end of the run.
    pub times: Option<Vec<f64>>,
    /// Time between two measurements of spectra, from the start on, in place of `times`.
    pub interval: Option<f64>,
    /// Largest mode number L/wavelength of the spectra.
    pub largest_wave_number: u64,
    /// Most wave vectors of a shell, one of each pair k and -k.
    pub modes_per_shell: u64,
}

impl Default for SpectraOptions {
    fn default() -> Self {
        Self {
            times: None,
            interval: None,
            largest_wave_number: 32,
            modes_per_shell: 48,
        }
    }
}

/// Spectra by time; `None` at a time without disks.
type Record = Vec<(f64, Option<Spectra>)>;

/// Creates the shells of modes with the given wave numbers, at most `most` modes in each. The error
/// says which wave numbers are allowed.
pub(super) fn shells(plan: &CasePlan, numbers: &[usize], most: u64) -> Result<Shells, String> {
    let [x, y, _] = plan.gas.lengths;
    Shells::new([x, y], numbers, most as usize)
        .map_err(|error| format!("{error}; allowed: smaller wave numbers"))
}

/// Returns an error for gases without waves of disks: spheres, or a box that is not periodic.
pub(super) fn require_waves(plan: &CasePlan) -> Result<(), BadOption> {
    require_periodic(plan)?;
    measure::require(plan.gas.dimension == 2, "", "disks: gas.dimension = 2")?;
    require_kept(plan)
}

/// Returns an error for a number of shells or modes that is zero or too large.
pub(super) fn require_number(found: u64, key: &str) -> Result<(), BadOption> {
    let allowed = format!("a whole number from 1 to {LARGEST}");
    measure::require((1..=LARGEST).contains(&found), key, allowed)
}

/// Largest number of samples of a run that an interval may lead to.
const MOST_LOOKS: f64 = 1e6;

impl SpectraOptions {
    fn looks(self, plan: &CasePlan) -> Vec<f64> {
        let Some(interval) = self.interval else {
            return structure_times(plan, self.times);
        };
        let count = (plan.case.run.until / interval + 1e-9).floor() as u64;
        let times = (0..=count).map(|look| look as f64 * interval);
        times.map(|time| time.min(plan.case.run.until)).collect()
    }

    fn shells(&self, plan: &CasePlan) -> Result<Shells, String> {
        let numbers: Vec<usize> = (1..=self.largest_wave_number as usize).collect();
        shells(plan, &numbers, self.modes_per_shell)
    }
}

/// Theory of shear modes: linear fluctuating hydrodynamics of van Noije, Ernst, Brito & Orza
/// (1997).
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shear {
    /// Freely cooling gas: modes below the critical wave number grow over the thermal speed, others
    /// decay, as powers of 1 + t/t0.
    Cooling {
        /// Critical wave number of shear modes \[1/engine length\].
        critical: f64,
    },
    /// Elastic gas: all modes decay, with the kinematic viscosity \[engine length^2 over the unit
    /// of time of the case\].
    Elastic { viscosity: f64 },
    /// Gas in a thermal bath: all modes decay by drag and viscosity, and the bath feeds them. Rates
    /// are per unit of time of the case.
    Bath { state: BathState, viscosity: f64 },
}

impl Shear {
    /// Creates the theory for a gas of equal disks that cools freely, is elastic, or is in a bath;
    /// `None` for other gases.
    fn from_plan(plan: &CasePlan) -> Option<Self> {
        if !plan.has_theory() || plan.gas.dimension != 2 {
            return None;
        }
        if plan.case.bath().is_some() {
            let state = plan.bath_state()?;
            return Some(Self::Bath {
                viscosity: plan.bath_viscosity()? * plan.clock.time,
                state: BathState {
                    cooling_rate: state.cooling_rate * plan.clock.time,
                    drag: state.drag * plan.clock.time,
                    ..state
                },
            });
        }
        let (phi, chi, r) = (
            plan.gas.packing_fraction,
            plan.gas.contact_value,
            plan.gas.restitution,
        );
        Some(if r < 1.0 {
            Self::Cooling {
                critical: transport::critical_wave_number(phi, chi, r),
            }
        } else {
            Self::Elastic {
                viscosity: transport::kinematic_viscosity(phi, chi) * plan.clock.time,
            }
        })
    }

    /// Computes the growth rate of a shear mode's amplitude over the thermal speed, per unit of
    /// [`clock`].
    fn rate(self, k: f64) -> f64 {
        match self {
            Self::Cooling { critical } => transport::shear_exponent(k, critical),
            Self::Elastic { viscosity } => -viscosity * k * k,
            Self::Bath { state, viscosity } => -state.shear_decay(viscosity, k),
        }
    }

    /// Computes the spectrum of a shear mode at a reading of [`clock`]; it is 1 at the start.
    fn spectrum(self, k: f64, clock: f64) -> f64 {
        match self {
            Self::Cooling { critical } => transport::thermal_shear_energy(k, critical, clock),
            Self::Elastic { .. } => 1.0,
            Self::Bath { state, viscosity } => {
                let steady = state.shear_spectrum(viscosity, k);
                steady + (1.0 - steady) * (2.0 * self.rate(k) * clock).exp()
            }
        }
    }

    /// Computes the growth rate of a mode without viscosity. The amplitude over the thermal speed
    /// grows as that speed falls; drag damps it.
    fn inviscid_rate(self) -> f64 {
        match self {
            Self::Cooling { .. } => 1.0,
            Self::Elastic { .. } => 0.0,
            Self::Bath { state, .. } => -state.drag,
        }
    }

    /// Returns true if all modes have the energy of thermal equilibrium, because contacts dissipate
    /// nothing.
    fn is_equilibrium(self) -> bool {
        match self {
            Self::Cooling { .. } => false,
            Self::Elastic { .. } => true,
            Self::Bath { state, .. } => state.cooling_rate == 0.0,
        }
    }

    /// Computes the growth rate of the summed correlation of the amplitudes of several modes
    /// between two readings of [`clock`].
    fn shell_rate(self, modes: &[f64], clocks: [f64; 2]) -> f64 {
        let [from, to] = clocks;
        let (mut now, mut then) = (0.0, 0.0);
        for &k in modes {
            let spectrum = self.spectrum(k, from);
            now += spectrum;
            then += spectrum * (self.rate(k) * (to - from)).exp();
        }
        (then / now).ln() / (to - from)
    }
}

/// Returns the time variable in which growth rates are constant: ln(1 + t/t0) with the Sonine
/// factor of Haff's law in a freely cooling gas, else the time of the case.
fn clock(plan: &CasePlan, time: f64) -> f64 {
    plan.cooling_logarithm(time, true).unwrap_or(time)
}

/// Returns true if the amplitudes of an engine start with the thermal noise of its own simulators,
/// as theory assumes.
fn starts_thermal(engine: &EnginePlan) -> bool {
    engine.copies() == 1
        || (engine.parameters())
            .is_none_or(|parameters| parameters.copies == SimulatorStart::Independent)
}

/// Returns the magnitudes of the wave vectors of each shell \[1/engine length\].
fn magnitudes(shells: &Shells) -> Vec<Vec<f64>> {
    let all: Vec<f64> = shells.modes().wave_numbers().collect();
    shells.ranges().map(|range| all[range].to_vec()).collect()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len();
    values.sum::<f64>() / count as f64
}

impl Measure for HydrodynamicSpectra {
    described!(
        "spectra",
        "Spectra of density, shear, sound and temperature by shells of wave numbers, and the growth of shear modes.",
        SpectraOptions
    );

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        require_waves(plan)?;
        let options: SpectraOptions = measure::options(plan, self.name())?;
        require_number(options.largest_wave_number, "largest_wave_number")?;
        require_number(options.modes_per_shell, "modes_per_shell")?;
        if let Some(interval) = options.interval {
            let until = plan.case.run.until;
            let good = interval > 0.0 && interval <= until && until / interval <= MOST_LOOKS;
            let allowed =
                format!("a time up to run.until = {until}, for at most {MOST_LOOKS:e} looks");
            measure::require(good && options.times.is_none(), "interval", allowed)?;
        }
        let shells = options.shells(plan).map(|_| ());
        shells.map_err(|allowed| BadOption {
            key: "largest_wave_number".into(),
            allowed,
        })
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        measure::chosen::<SpectraOptions>(plan, self.name()).looks(plan)
    }

    fn kept_bytes(&self, plan: &CasePlan) -> f64 {
        let shells = measure::chosen::<SpectraOptions>(plan, self.name()).shells(plan);
        let each = shells.map_or(0, |shells| {
            shells.ranges().count() * size_of::<Spectrum>()
                + shells.modes().indices().len() * size_of::<[f64; 2]>()
        });
        (self.sample_times(plan).len() * each) as f64
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let shells = measure::chosen::<SpectraOptions>(plan, self.name()).shells(plan);
        Box::new(SampleProbe::new(Record::new(), move |record, moment| {
            let gas = &*moment.simulation;
            let weight = gas.mean_weight();
            let found = shells.as_ref().ok();
            let mut found = found.and_then(|shells| {
                shells
                    .measure_gas(&mut |sum| gas.reduce_particles(sum))
                    .ok()
            });
            for shell in found.iter_mut().flat_map(|found| &mut found.shells) {
                shell.density *= weight;
            }
            record.push((moment.time, found));
        }))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let Ok(shells) = measure::chosen::<SpectraOptions>(plan, self.name()).shells(plan) else {
            return Vec::new();
        };
        let (mut spectra, mut growth) = (spectra_table(), growth_table());
        let mut decay = is_stationary(plan).then(decay_table);
        let mut steady = plan.bath_state().map(|_| steady_table());
        for (engine, records) in runs.each::<Record>(plan) {
            fill_spectra(&mut spectra, plan, engine, &shells, &records);
            fill_growth(&mut growth, plan, engine, &shells, &records);
            if let Some(table) = &mut decay {
                fill_decay(table, plan, engine, &shells, &records);
            }
            if let Some(table) = &mut steady {
                fill_steady(table, plan, engine, &shells, &records);
            }
        }
        let all = [Some(spectra), Some(growth), decay, steady];
        all.into_iter().flatten().collect()
    }
}

fn spectra_table() -> Table {
    let figure = |column, title, label| {
        let (x, y) = (
            FigureAxis::logarithmic("mode_number", "mode number L/wavelength"),
            FigureAxis::logarithmic(column, label),
        );
        Figure::curves(title, x, y).panels(&["time"])
    };
    let one = |column, title, label| figure(column, title, label).line("equilibrium", 1.0);
    table! {
        "spectra", "Spectra of density, flow and temperature by shells of wave numbers.";
        key "engine", "", "Engine";
        key "time", "time", "Time since the start";
        key "mode_number", "1", "Mode number L/wavelength, mean of the shell";
        estimate "s_nn", "1", "Structure factor of the disks";
        with_theory "s_perp", "1", "Shear: squared flow across k over that of thermal noise at the temperature of the moment; with several simulators for each disk over that of theirs";
        with_theory "s_par", "1", "Sound: the same of the flow along k";
        with_theory "s_tt", "1", "Temperature: squared amplitude over that of thermal noise";
        note "modes", "1", "Wave vectors that were averaged, one of each pair k and -k";
        note "replicas", "1", "Replicas";
    }
    .figure(one("s_perp", "Spectrum of shear", "S_perp(k)").caption(
        "One in equilibrium. Theory is linear fluctuating hydrodynamics of the homogeneous cooling state, or of the steady state of a bath \
         that a thermal start approaches.",
    ))
    .figure(one("s_par", "Spectrum of sound", "S_par(k)"))
    .figure(one("s_tt", "Spectrum of the temperature", "S_TT(k)"))
    .figure(figure("s_nn", "Structure factor", "S_nn(k)").line("ideal gas", 1.0))
}

fn steady_table() -> Table {
    table! {
        "steady_spectra", "Spectra of a gas in a bath, averaged over all looks in the second half of the run.";
        key "engine", "", "Engine";
        key "mode_number", "1", "Mode number L/wavelength, mean of the shell";
        estimate "s_nn", "1", "Structure factor of the disks";
        with_theory "s_perp", "1", "Shear, as in spectra.csv; theory is linear fluctuating hydrodynamics of the steady state";
        with_theory "s_par", "1", "Sound, as in spectra.csv";
        with_theory "s_tt", "1", "Temperature, as in spectra.csv";
        note "looks", "1", "Looks that were averaged";
        note "modes", "1", "Wave vectors that were averaged, one of each pair k and -k";
        note "replicas", "1", "Replicas";
    }
    .figure(
        Figure::curves(
            "Spectrum of shear in the steady state",
            FigureAxis::logarithmic("mode_number", "mode number L/wavelength"),
            FigureAxis::logarithmic("s_perp", "S_perp(k)"),
        )
        .line("equilibrium", 1.0),
    )
}

/// Computes the mean of a spectrum in a shell over samples, with the standard error over replicas.
fn shell_average(
    records: &[&Record],
    looks: &[usize],
    shell: usize,
    part: fn(&Spectrum) -> f64,
) -> TableEstimate {
    let one = |record: &&Record| {
        let found = looks.iter().map(|&look| {
            let found = record[look].1.as_ref()?;
            found.shells.get(shell).map(part)
        });
        let all: Option<Vec<f64>> = found.collect();
        all.filter(|all| !all.is_empty())
            .map(|all| mean(all.into_iter()))
    };
    mean_over_replicas(records.iter().map(one))
}

fn fill_steady(
    table: &mut Table,
    plan: &CasePlan,
    engine: &EnginePlan,
    shells: &Shells,
    records: &[&Record],
) {
    let theory = Shear::from_plan(plan);
    let equilibrium = theory.filter(|one| one.is_equilibrium()).map(|_| 1.0);
    let half = 0.5 * plan.case.run.until;
    let first = records
        .first()
        .into_iter()
        .flat_map(|one| one.iter().enumerate());
    let looks: Vec<usize> = first
        .filter(|(_, (time, _))| *time >= half)
        .map(|(look, _)| look)
        .collect();
    if looks.is_empty() {
        return;
    }
    let (numbers, magnitudes) = (shells.wave_numbers(), magnitudes(shells));
    for (shell, modes) in magnitudes.iter().enumerate() {
        let of = |part| shell_average(records, &looks, shell, part);
        let steady = |theory: Shear| mean(modes.iter().map(|&k| theory.spectrum(k, f64::INFINITY)));
        table.add((
            (engine.name, numbers[shell]),
            of(|one| one.density),
            of(|one| one.transverse).against(theory.map(steady)),
            of(|one| one.longitudinal).against(equilibrium),
            of(|one| one.temperature).against(equilibrium),
            looks.len(),
            modes.len(),
            records.len(),
        ));
    }
}

fn growth_table() -> Table {
    table! {
        "growth", "Growth of shear modes between two times.";
        key "engine", "", "Engine";
        key "window_start", "time", "First of the two times";
        key "window_end", "time", "Second";
        key "mode_number", "1", "Mode number L/wavelength, mean of the shell";
        with_theory "exponent", "1", "Growth of the amplitude over the thermal speed, as a power of 1 + t/t0 with the t0 of Haff's law; in gases that do not cool its rate over the unit of time. By regression of each amplitude on itself at the first time, so that noise adds nothing";
        note "modes", "1", "Wave vectors of the shell, one of each pair k and -k";
        note "replicas", "1", "Replicas";
    }
    .figure(
        Figure::curves(
            "Growth of shear modes",
            FigureAxis::linear("mode_number", "mode number L/wavelength"),
            FigureAxis::linear("exponent", "growth exponent"),
        )
        .panels(&["window_start", "window_end"])
        .line("no growth", 0.0),
    )
}

fn fill_spectra(
    table: &mut Table,
    plan: &CasePlan,
    engine: &EnginePlan,
    shells: &Shells,
    records: &[&Record],
) {
    let theory = Shear::from_plan(plan);
    let elastic = theory.is_some_and(Shear::is_equilibrium);
    let (numbers, magnitudes) = (shells.wave_numbers(), magnitudes(shells));
    for (index, (time, _)) in records
        .first()
        .into_iter()
        .flat_map(|one| one.iter().enumerate())
    {
        for (shell, modes) in magnitudes.iter().enumerate() {
            let of = |part| shell_average(records, &[index], shell, part);
            let expected = theory.filter(|_| starts_thermal(engine)).map(|theory| {
                mean(
                    modes
                        .iter()
                        .map(|&k| theory.spectrum(k, clock(plan, *time))),
                )
            });
            let equilibrium = elastic.then_some(1.0);
            table.add((
                (engine.name, *time, numbers[shell]),
                of(|one| one.density),
                of(|one| one.transverse).against(expected),
                of(|one| one.longitudinal).against(equilibrium),
                of(|one| one.temperature).against(equilibrium),
                modes.len(),
                records.len(),
            ));
        }
    }
}

/// Returns true if growth rates over the thermal speed are constant in time: without dissipation,
/// or if a thermostat balances it.
fn is_stationary(plan: &CasePlan) -> bool {
    let heats_up = plan.case.bath().is_some() && plan.bath_state().is_none();
    (plan.case.thermostat.is_some() || plan.gas.restitution == 1.0) && !heats_up
}

fn decay_table() -> Table {
    table! {
        "shear_decay", "Growth of shear modes in a stationary gas, over all pairs of successive times that are as far apart as the first two.";
        key "engine", "", "Engine";
        key "mode_number", "1", "Mode number L/wavelength, mean of the shell";
        with_theory "exponent", "1", "Growth of the amplitude over the thermal speed, as in growth.csv";
        estimate "viscosity_over_enskog", "1", "Shear viscosity that this growth means, over Enskog's at this restitution: of waves of this length, after the time between two looks";
        note "pairs", "1", "Pairs of times";
        note "replicas", "1", "Replicas";
    }
    .figure(
        Figure::curves(
            "Viscosity by the decay of shear modes",
            FigureAxis::linear("mode_number", "mode number L/wavelength"),
            FigureAxis::linear("viscosity_over_enskog", "viscosity over Enskog's"),
        )
        .line("Enskog", 1.0),
    )
}

/// Sums, over the modes of a shell in one replica, the products of the amplitudes at two times, and
/// their squares at the first time.
fn amplitude_products(
    record: &Record,
    looks: [usize; 2],
    range: std::ops::Range<usize>,
) -> Option<[f64; 2]> {
    let [before, after] = looks.map(|look| record[look].1.as_ref());
    let before = before?.shear.get(range.clone())?;
    let after = after?.shear.get(range)?;
    let pairs = before.iter().zip(after);
    Some(pairs.fold([0.0; 2], |[products, squares], (a, b)| {
        [
            products + a[0] * b[0] + a[1] * b[1],
            squares + a[0] * a[0] + a[1] * a[1],
        ]
    }))
}

/// Estimates the growth rate from the sums of all replicas over a span of [`clock`], with its
/// jackknife error.
fn growth_rate(sums: &[[f64; 2]], span: f64) -> TableEstimate {
    let rate = |[products, squares]: [f64; 2]| (products / squares).ln() / span;
    let found = jackknife(sums, rate).filter(|found| found.value.is_finite());
    found.map_or_else(TableEstimate::default, |found| {
        let error = found.standard_error.filter(|error| error.is_finite());
        TableEstimate::with_error(found.value, error)
    })
}

fn fill_decay(
    table: &mut Table,
    plan: &CasePlan,
    engine: &EnginePlan,
    shells: &Shells,
    records: &[&Record],
) {
    let (numbers, magnitudes) = (shells.wave_numbers(), magnitudes(shells));
    let looks = records.iter().map(|record| record.len()).min().unwrap_or(0);
    if looks < 2 {
        return;
    }
    let reading = |look: usize| clock(plan, records[0][look].0);
    let span = reading(1) - reading(0);
    let alike = |look: &usize| {
        let own = reading(*look) - reading(look - 1);
        (own - span).abs() < 1e-6 * span
    };
    let seconds: Vec<usize> = (1..looks).filter(alike).collect();
    for (shell, range) in shells.ranges().enumerate() {
        let own = |record: &&Record| {
            let all = seconds.iter();
            let all =
                all.map(|&second| amplitude_products(record, [second - 1, second], range.clone()));
            all.flatten().reduce(|[a, b], [c, d]| [a + c, b + d])
        };
        let sums: Vec<[f64; 2]> = records.iter().filter_map(own).collect();
        let found = growth_rate(&sums, span);
        // Modes of a shell count by their spectrum halfway through the run, when the start is
        // forgotten.
        let halfway = clock(plan, 0.5 * plan.case.run.until);
        let clocks = [halfway, halfway + span];
        let expected =
            Shear::from_plan(plan).map(|theory| theory.shell_rate(&magnitudes[shell], clocks));
        let inviscid = Shear::from_plan(plan).map_or(0.0, Shear::inviscid_rate);
        let viscosity = expected.map_or_else(TableEstimate::default, |expected| TableEstimate {
            value: found
                .value
                .map(|found| (inviscid - found) / (inviscid - expected)),
            ..found.times(1.0 / (inviscid - expected))
        });
        table.add((
            (engine.name, numbers[shell]),
            found.against(expected),
            viscosity,
            seconds.len(),
            records.len(),
        ));
    }
}

fn fill_growth(
    table: &mut Table,
    plan: &CasePlan,
    engine: &EnginePlan,
    shells: &Shells,
    records: &[&Record],
) {
    let theory = Shear::from_plan(plan);
    let (numbers, magnitudes) = (shells.wave_numbers(), magnitudes(shells));
    let looks = records.iter().map(|record| record.len()).min().unwrap_or(0);
    for second in 1..looks {
        let times = [second - 1, second].map(|look| records[0][look].0);
        let clocks = times.map(|time| clock(plan, time));
        for (shell, range) in shells.ranges().enumerate() {
            let looks = [second - 1, second];
            let sums = records
                .iter()
                .filter_map(|record| amplitude_products(record, looks, range.clone()));
            let sums: Vec<[f64; 2]> = sums.collect();
            let found = growth_rate(&sums, clocks[1] - clocks[0]);
            let expected = theory.map(|theory| theory.shell_rate(&magnitudes[shell], clocks));
            table.add((
                (engine.name, times, numbers[shell]),
                found.against(expected),
                range.len(),
                records.len(),
            ));
        }
    }
}
