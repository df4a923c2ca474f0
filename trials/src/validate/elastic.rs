//! Test of elastic gases against Enskog's theory: collision rate, pressure, diffusion, viscosity,
//! thermal noise, compressibility.
//!
//! Initial states are gases equilibrated by exact elastic collisions. Each scheme then relaxes to
//! its own structure before the measurement. Rates and noise relax within a few collisions per
//! disk; 20 are given. Density modes relax by sound damping, at a rate of at least `nu k²` for the
//! kinematic viscosity `nu`. S(k) is therefore taken only from [`SLOWEST`] on, after three
//! relaxation times.

use nalgebra::Vector2;
use stosszahl_analysis::fit::{self, FitPoint};
use stosszahl_analysis::modes::{Modes, shear_waves};
use stosszahl_analysis::relaxation::{decay_rate, diffusion};
use stosszahl_analysis::statistics::Estimate;
use stosszahl_dsmc::{DsmcEngine, Tracked};
use stosszahl_model::Particles;
use stosszahl_model::equation_of_state;
use stosszahl_model::samples::{EqualDisks, UNIT, particles_of, square};
use stosszahl_theory::{diffusion, transport};

use super::gas::{amplitudes, cells, columns, energy, modes, start, waves};
use super::over_seeds;
use super::schemes::SchemeQuantity::{
    CollisionRate, Compressibility, Diffusion, Longitudinal, Pressure, Transverse, Viscosity,
};
use super::schemes::{Method, SchemeSetting};
use crate::table::{RowPlace, TrialTableRow, divided_by, mean as over_gases};
use crate::{Done, Effort, TrialError, TrialLog};

/// Packing fractions of the elastic gases. In dilute gases only a scheme's own choice of cells is
/// tested.
pub const PACKINGS: [f64; 6] = [0.0025, 0.01, 0.05, 0.1, 0.25, 0.5];
const THIN: f64 = 0.05;

/// Smallest wave number k d of the density modes from which S(k → 0) is extrapolated.
const SLOWEST: f64 = 0.15;
/// Largest wave number k d of the density modes from which S(k → 0) is extrapolated. Below it, the
/// structure of hard disks changes S by less than a tenth.
const FASTEST: f64 = 0.6;
/// Band edges of wave numbers k d, in which the energy of velocity modes is averaged. Wavelengths
/// below two cells are left out.
const BANDS: [f64; 4] = [0.0, 0.5, 1.0, std::f64::consts::PI];
/// Largest number of velocity or density modes in a band of wave numbers.
const MODES: usize = 640;
/// Smallest number of modes in a band for a verdict. Mode energies are exponentially distributed,
/// so fewer modes are too noisy.
const FEWEST: usize = 100;
/// Claimed relative deviation of the energy of a velocity mode from the temperature T.
const NOISE: f64 = 0.02;
/// Claimed relative deviation of the energy of long longitudinal modes (sound), in a scheme's own
/// cells at high packing. It is 1.7 % too low at packing 0.25 and 2.3 to 3.3 % at 0.5.
const SOUND: f64 = 0.05;
/// Packing fraction from which the energy of sound modes is claimed within [`SOUND`] only.
const DENSE: f64 = 0.25;
/// Number of lowest wave-number bands in which the energy of sound modes is claimed within
/// [`SOUND`] only.
const LONG: usize = 2;
/// Number of samples of thermal noise and structure. Their interval is `BETWEEN` mean free times.
const SAMPLES: u32 = 12;
const BETWEEN: f64 = 5.0;
/// Velocity amplitude of a started shear wave over the thermal velocity: each of two waves has half
/// a percent of T as energy.
const WAVE: f64 = 0.15;
/// Number of time intervals in the regression of the shear-wave decay.
const STEPS: u32 = 6;
/// Time interval of the shear-wave regression, over the theoretical decay time to 1/e.
const STEP: f64 = 0.4;

/// Measured results of one elastic gas: rate, pressure, diffusion, mode energies, compressibility
/// and shear waves.
struct Found {
    rate: f64,
    pressure: f64,
    squares: [f64; 2],
    /// Transverse and longitudinal energy over T of each velocity mode in each band, averaged over
    /// samples.
    bands: Vec<Vec<[f64; 2]>>,
    compressibility: f64,
    /// Number of disks that each Monte Carlo simulator represents.
    weight: f64,
    /// Amplitudes of the shear waves at equal time intervals.
    waves: Vec<Vec<f64>>,
    /// Mean thermal speed, the square root of the temperature, while the shear waves decay.
    speed: f64,
}

/// Settings for the measurement of elastic gases that depend only on packing, cell size and box:
/// times, wave numbers and modes.
struct Plan {
    packing: f64,
    chi: f64,
    /// Mean free time of a disk by Enskog's theory \[time\].
    free: f64,
    relaxation: f64,
    /// Wave number of the started shear waves \[1/length\].
    wave: f64,
    wave_index: i32,
    spacing: f64,
    bands: Vec<(String, Modes)>,
    density: Modes,
}

impl Plan {
    fn new(packing: f64, cell: f64, start: &Particles) -> Result<Self, TrialError> {
        let chi = equation_of_state::contact_value(packing);
        let free = 1.0 / equation_of_state::collision_rate(packing, chi, 0.0);
        let viscosity = transport::kinematic_viscosity(packing, chi);
        let lengths = [start.lengths[0], start.lengths[1]];
        // Wavelength that is long against the mean free path and the diameter.
        let target = (0.15 / equation_of_state::mean_free_path(packing, chi)).min(0.2);
        let first = std::f64::consts::TAU / lengths[0];
        let wave_index = (target / first).round().max(1.0);
        let wave = wave_index * first;
        let resolved = std::f64::consts::PI / cell;
        let mut bands = Vec::new();
        for pair in BANDS.windows(2) {
            let range = [pair[0], pair[1].min(resolved)];
            let modes = Modes::band(lengths, range, MODES)?;
            if !modes.indices().is_empty() {
                bands.push((format!("k d {:.2} to {:.2}", range[0], range[1]), modes));
            }
        }
        Ok(Self {
            packing,
            chi,
            free,
            relaxation: (20.0 * free).max(3.0 / (viscosity * SLOWEST * SLOWEST)),
            wave,
            wave_index: wave_index as i32,
            spacing: STEP / (viscosity * wave * wave),
            bands,
            density: Modes::band(lengths, [SLOWEST, FASTEST], MODES)?,
        })
    }

    fn measure(&self, gas: &mut DsmcEngine<EqualDisks, Tracked>) -> Result<Found, TrialError> {
        gas.advance(self.relaxation, u64::MAX, &mut ());
        let (origin, before) = (gas.time(), gas.tally());
        gas.track_displacements();
        let mut squares = [0.0; 2];
        let bands = self.bands.iter();
        let mut bands: Vec<_> = bands
            .map(|(_, modes)| vec![[0.0; 2]; modes.indices().len()])
            .collect();
        let mut densities = vec![0.0; self.density.indices().len()];
        for sample in 1..=SAMPLES {
            let until = origin + f64::from(sample) * BETWEEN * self.free;
            gas.advance(until, u64::MAX, &mut ());
            if sample == SAMPLES / 4 {
                squares[0] = mean_square(&gas.displacements());
            }
            self.sample(gas, &mut bands, &mut densities)?;
        }
        squares[1] = mean_square(&gas.displacements());
        let (after, duration) = (gas.tally(), gas.time() - origin);
        let count = gas.simulators() as f64;
        let rate = 2.0 * (after.collisions - before.collisions) as f64 / count / duration;
        let disks = count * gas.weight();
        let virial = after.virial - before.virial;
        let energies = bands.iter_mut().flatten().flatten();
        for value in energies.chain(&mut densities) {
            *value /= f64::from(SAMPLES);
        }
        let points: Vec<_> = self
            .density
            .wave_numbers()
            .zip(&densities)
            .map(|(k, &y)| FitPoint {
                x: k * k,
                y,
                error: 1.0,
            })
            .collect();
        let compressibility = fit::line(&points)?.intercept;
        let (waves, speed) = self.shear(gas)?;
        Ok(Found {
            rate: rate * self.free,
            pressure: 1.0 + virial / (2.0 * disks * duration),
            squares,
            bands,
            compressibility,
            weight: gas.weight(),
            waves,
            speed,
        })
    }

    fn sample(
        &self,
        engine: &DsmcEngine<EqualDisks, Tracked>,
        bands: &mut [Vec<[f64; 2]>],
        densities: &mut [f64],
    ) -> Done {
        let gas = &particles_of(&UNIT, &engine.state());
        let (count, unit) = (gas.all.len(), energy(gas).temperature);
        for ((_, modes), sums) in self.bands.iter().zip(bands) {
            for (sum, amplitude) in sums.iter_mut().zip(amplitudes(gas, modes)?) {
                let power = amplitude.power(count);
                sum[0] += power.transverse / unit;
                sum[1] += power.longitudinal / unit;
            }
        }
        for (sum, amplitude) in densities.iter_mut().zip(amplitudes(gas, &self.density)?) {
            *sum += engine.weight() * amplitude.power(count).density;
        }
        Ok(())
    }

    /// Starts two shear waves in an elastic gas, and records their amplitudes and the mean thermal
    /// speed while they decay.
    fn shear(
        &self,
        gas: &mut DsmcEngine<EqualDisks, Tracked>,
    ) -> Result<(Vec<Vec<f64>>, f64), TrialError> {
        let start = particles_of(&UNIT, &gas.state());
        let modes = modes(&start, vec![[self.wave_index, 0], [0, self.wave_index]])?;
        gas.kick(&shear_waves(&modes, &columns(&start).0, WAVE)?);
        // Delay of a few collisions, in which the kick builds up its stress.
        let origin = gas.time() + 3.0 * self.free;
        let mut series = vec![Vec::new(); 4];
        let mut speed = 0.0;
        for sample in 0..=STEPS {
            gas.advance(origin + f64::from(sample) * self.spacing, u64::MAX, &mut ());
            let (found, temperature) = waves(&particles_of(&UNIT, &gas.state()), &modes)?;
            for (values, value) in series.iter_mut().zip(found.into_iter().flatten()) {
                values.push(value);
            }
            speed += temperature.sqrt() / f64::from(STEPS + 1);
        }
        Ok((series, speed))
    }
}

fn mean_square(displacements: &[Vector2<f64>]) -> f64 {
    let sum: f64 = displacements.iter().map(Vector2::norm_squared).sum();
    sum / displacements.len().max(1) as f64
}

/// Returns the number of disks at a setting, and the initial and the largest number of gases. More
/// simulators have less noise, and cost more.
fn extent(effort: &Effort, setting: SchemeSetting) -> (usize, [u64; 2]) {
    match (effort.quick, setting) {
        (true, SchemeSetting::Single) => (2_000, [4, 4]),
        (true, SchemeSetting::Own) => (1_000, [4, 4]),
        (true, _) => (500, [4, 4]),
        (false, SchemeSetting::Single) => (20_000, [4, 64]),
        (false, SchemeSetting::Eight) => (2_000, [8, 128]),
        (false, SchemeSetting::Refined) => (500, [8, 64]),
        (false, SchemeSetting::Own) => (5_000, [8, 64]),
    }
}

/// Returns the resolutions at which an elastic gas of this packing fraction is measured.
fn settings(packing: f64) -> Vec<SchemeSetting> {
    let fixed: &[SchemeSetting] = if packing < THIN {
        &[]
    } else {
        &SchemeSetting::ALL
    };
    [fixed, &[SchemeSetting::Own]].concat()
}

/// Tests all Monte Carlo schemes in elastic gases at all packing fractions and resolutions. Gases
/// are added until every claim is decided, or up to a limit.
pub(super) fn test_elastic(log: &mut TrialLog) -> Done {
    for packing in PACKINGS {
        for setting in settings(packing) {
            let methods = log.effort.methods.iter();
            let methods: Vec<Method> = methods
                .filter(|method| setting != SchemeSetting::Own || method.default)
                .copied()
                .collect();
            if methods.is_empty() {
                continue;
            }
            let (disks, gases) = extent(&log.effort, setting);
            let domain = square(disks, packing);
            let make = |seed| start(disks, packing, seed, 20.0);
            let mut starts = over_seeds(0..gases[0], make)?.0;
            for method in methods {
                let parameters = method.parameters_at(setting);
                let columns = parameters.cells(&domain, packing, 1.0)[0];
                let cell = domain.lengths()[0] / columns as f64;
                let plan = Plan::new(packing, cell, &starts[0])?;
                let (mut found, mut seconds) = (Vec::new(), 0.0);
                let mut count = gases[0];
                let table = loop {
                    starts.extend(over_seeds(starts.len() as u64..count, make)?.0);
                    let more = over_seeds(found.len() as u64..count, |seed| {
                        let state = &starts[seed as usize];
                        plan.measure(&mut cells(state, parameters, seed)?)
                    })?;
                    found.extend(more.0);
                    seconds += more.1;
                    let table = table(&plan, &method, setting, &found, seconds)?;
                    if count >= gases[1] || table.iter().all(TrialTableRow::is_decided) {
                        break table;
                    }
                    count = (2 * count).min(gases[1]);
                };
                for row in table {
                    log.add(row);
                }
            }
        }
    }
    Ok(())
}

fn table(
    plan: &Plan,
    method: &Method,
    setting: SchemeSetting,
    found: &[Found],
    seconds: f64,
) -> Result<Vec<TrialTableRow>, TrialError> {
    let place = RowPlace::new(
        "elastic",
        method.name,
        setting.name(),
        plan.packing,
        seconds,
    );
    let place = place.only_default(method.default);
    let mean = |value: fn(&Found) -> f64| over_gases(found.iter().map(value));
    let (packing, chi) = (plan.packing, plan.chi);
    let times = [0.25, 1.0].map(|share| share * f64::from(SAMPLES) * BETWEEN * plan.free);
    let squares: Vec<_> = found.iter().map(|gas| gas.squares).collect();
    let diffusion = diffusion(&squares, times).ok_or_else(|| TrialError::failed("no diffusion"))?;
    let series: Vec<_> = found.iter().map(|gas| gas.waves.clone()).collect();
    let decay = decay_rate(&series, plan.spacing)?;
    let theory = transport::kinematic_viscosity(packing, chi) * plan.wave * plan.wave;
    let rate = match setting {
        SchemeSetting::Single => 0.01,
        SchemeSetting::Own => 0.0075,
        SchemeSetting::Eight | SchemeSetting::Refined => 0.005,
    };
    let z = equation_of_state::compressibility_factor(packing, 1.0);
    let mut rows = Vec::new();
    let mut add = |what: String, found: Estimate, quantity, tolerance: f64| {
        let claimed = method.claims(setting, quantity) && tolerance > 0.0;
        rows.push(place.row(what, 1.0, found, claimed.then_some(tolerance)));
    };
    add(
        "collision rate/Enskog".into(),
        mean(|gas| gas.rate)?,
        CollisionRate,
        rate,
    );
    add(
        "pressure/Z".into(),
        divided_by(mean(|gas| gas.pressure)?, z),
        Pressure,
        0.02,
    );
    let diffusion = divided_by(diffusion, diffusion::self_diffusion(packing, chi));
    add("self-diffusion/Enskog".into(), diffusion, Diffusion, 0.05);
    let what = format!("shear viscosity/Enskog, k d = {:.3}", plan.wave);
    let decay = divided_by(decay, theory * mean(|gas| gas.speed)?.value);
    add(what, decay, Viscosity, 0.05);
    for (index, (name, modes)) in plan.bands.iter().enumerate() {
        let is_many = modes.indices().len() >= FEWEST;
        let sides = [("transverse", Transverse), ("longitudinal", Longitudinal)];
        for (side, (what, quantity)) in sides.into_iter().enumerate() {
            // Modes are as independent of each other as gases are.
            let modes = found.iter().flat_map(|gas| &gas.bands[index]);
            let energy = over_gases(modes.map(|mode| mode[side]))?;
            let lacks = setting == SchemeSetting::Own && packing >= DENSE && index < LONG;
            let tolerance = if !is_many {
                0.0
            } else if lacks && quantity == Longitudinal {
                SOUND
            } else {
                NOISE
            };
            add(
                format!("{what} energy/T, {name}"),
                energy,
                quantity,
                tolerance,
            );
        }
    }
    let zero = equation_of_state::structure_factor_at_zero(packing);
    // The mean over m independent simulators for each disk fluctuates m times less than the disks.
    let of_disks = mean(|gas| gas.weight)?.value;
    let ratio = divided_by(mean(|gas| gas.compressibility)?, zero);
    let claimed = method.claims(setting, Compressibility) && of_disks == 1.0;
    rows.push(place.row(
        "S(k to 0)/compressibility",
        of_disks,
        ratio,
        claimed.then_some(0.1),
    ));
    Ok(rows)
}
