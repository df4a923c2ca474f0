//! Test of the growth of shear modes in a large cooling gas, against linear theory and exact
//! dynamics.
//!
//! The gas has 10⁴ disks with r = 0.8 at packing 0.25, in a box of 177 d, in which modes of up to
//! ten wavelengths grow. Weak waves are started along both axes. In `l = ln(1 + t/t_0)`, linear
//! theory predicts their growth over the thermal speed with the constant exponent `1 - (k/k_c)²`.
//! The thermal speed is that of Haff's law, because the measured one contains the growing modes.
//! All other modes grow from the initial noise. Their energies are compared with those of
//! fluctuating hydrodynamics.

use stosszahl_analysis::modes::Amplitude;
use stosszahl_analysis::relaxation::decay_rate;
use stosszahl_analysis::statistics::Estimate;
use stosszahl_model::{Simulation, equation_of_state};
use stosszahl_theory::{cooling, transport};

use super::gas::{advance, amplitudes, exact, kick, modes, monte_carlo, start, waves};
use super::over_seeds;
use super::schemes::{SchemeQuantity, SchemeSetting};
use super::small_gas::{PACKING, RESTITUTION, haff_time};
use crate::table::{RowPlace, against, mean};
use crate::{Done, TrialError, TrialLog};

/// Mode numbers of the shear waves that are started: wavelengths per box length.
const KICKED: [i32; 4] = [2, 4, 6, 8];
/// Mode numbers of the shear waves that grow from thermal noise alone.
const LEFT: [i32; 4] = [3, 5, 7, 9];
/// Velocity amplitude of a started shear wave over the thermal speed: each of eight waves has a
/// thousandth of T as energy.
const WAVE: f64 = 0.06;
/// Time of the first sample of the shear modes, in `ln(1 + t/t_0)`.
const FIRST: f64 = 0.3;
/// Interval of samples of the shear modes, in `ln(1 + t/t_0)`. A disk collides 11 times per unit.
const SPACING: f64 = 0.2;
/// Number of samples of the shear modes.
const SAMPLES: u32 = 6;

/// Measured results of one unstable gas: amplitudes of the started shear modes at each sample, and
/// final energies over T of the modes grown from noise.
struct Found {
    series: Vec<Vec<Vec<f64>>>,
    energies: Vec<f64>,
}

fn axes(numbers: &[i32]) -> Vec<[i32; 2]> {
    numbers.iter().flat_map(|&n| [[n, 0], [0, n]]).collect()
}

/// Starts shear waves in a cooling gas, and records their growth.
fn follow(mut gas: Box<dyn Simulation>) -> Result<Found, TrialError> {
    let start = gas.particles();
    let (kicked, left) = (modes(&start, axes(&KICKED))?, modes(&start, axes(&LEFT))?);
    kick(&mut *gas, &kicked, WAVE)?;
    let mut series = vec![vec![Vec::new(); 4]; KICKED.len()];
    let mut energies = Vec::new();
    for sample in 0..SAMPLES {
        let logarithm = FIRST + f64::from(sample) * SPACING;
        advance(&mut *gas, logarithm.exp_m1() * haff_time(), &mut ())?;
        let state = gas.particles();
        let temperature = cooling::relaxing_haff_law(RESTITUTION, logarithm.exp_m1());
        let found = waves(&state, &kicked)?.0;
        for (parts, series) in found.chunks(2).zip(&mut series) {
            for (values, value) in series.iter_mut().zip(parts.iter().flatten()) {
                values.push(value / temperature.sqrt());
            }
        }
        let found = amplitudes(&state, &left)?;
        let transverse = |a: &Amplitude| a.power(state.all.len()).transverse;
        let energy =
            |pair: &[Amplitude]| pair.iter().map(transverse).sum::<f64>() / 2.0 / temperature;
        energies = found.chunks(2).map(energy).collect();
    }
    Ok(Found { series, energies })
}

/// Growth exponents of the started shear modes, and energies of the modes grown from noise,
/// averaged over gases.
struct Growth {
    exponents: Vec<Estimate>,
    energies: Vec<Estimate>,
    seconds: f64,
}

impl Growth {
    fn new((found, seconds): (Vec<Found>, f64)) -> Result<Self, TrialError> {
        let exponent = |mode: usize| -> Result<Estimate, TrialError> {
            let series: Vec<_> = found.iter().map(|gas| gas.series[mode].clone()).collect();
            let rate = decay_rate(&series, SPACING)?;
            Ok(Estimate {
                value: -rate.value,
                ..rate
            })
        };
        let energy = |mode: usize| mean(found.iter().map(|gas| gas.energies[mode]));
        Ok(Self {
            exponents: (0..KICKED.len()).map(exponent).collect::<Result<_, _>>()?,
            energies: (0..LEFT.len()).map(energy).collect::<Result<_, _>>()?,
            seconds,
        })
    }

    fn rows(
        &self,
        log: &mut TrialLog,
        place: &RowPlace,
        first: f64,
        exact: Option<&Self>,
        claim: Option<f64>,
    ) {
        let chi = equation_of_state::contact_value(PACKING);
        let critical = transport::critical_wave_number(PACKING, chi, RESTITUTION);
        for (index, n) in KICKED.into_iter().enumerate() {
            let k = first * f64::from(n);
            let found = self.exponents[index];
            let theory = transport::shear_exponent(k, critical);
            let what = format!("exponent, {n} waves, k/kc {:.2}", k / critical);
            log.claim(place, format!("{what}, theory"), theory, found, claim);
            if let Some(exact) = exact {
                let other = exact.exponents[index];
                let errors = found.standard_error.zip(other.standard_error);
                let found = Estimate {
                    standard_error: errors.map(|(a, b)| a.hypot(b)),
                    ..found
                };
                log.claim(
                    place,
                    format!("{what}, event-driven"),
                    other.value,
                    found,
                    claim,
                );
            }
        }
        let logarithm = FIRST + f64::from(SAMPLES - 1) * SPACING;
        for (index, n) in LEFT.into_iter().enumerate() {
            let k = first * f64::from(n);
            let found = self.energies[index];
            let theory = transport::thermal_shear_energy(k, critical, logarithm);
            let what = format!("energy/T, {n} waves, ln(1 + t/t0) = {logarithm:.1}");
            log.claim(place, format!("{what}, theory"), theory, found, None);
            if let Some(exact) = exact {
                let ratio = against(found, exact.energies[index]);
                log.claim(place, format!("{what} over event-driven"), 1.0, ratio, None);
            }
        }
    }
}

/// Tests the growth of shear modes by exact dynamics, and by all schemes at all resolutions but the
/// refined one.
pub(super) fn test_unstable(log: &mut TrialLog) -> Done {
    let replicas = if log.effort.quick { 4 } else { 32 };
    let (starts, _) = over_seeds(0..replicas, |seed| start(10_000, PACKING, seed, 20.0))?;
    let first = std::f64::consts::TAU / starts[0].lengths[0];
    let of = |seeds, gas: &(dyn Fn(u64) -> Result<Box<dyn Simulation>, TrialError> + Sync)| {
        Growth::new(over_seeds(0..seeds, |seed| follow(gas(seed)?))?)
    };
    let reference = of(replicas, &|seed| exact(&starts[seed as usize], RESTITUTION))?;
    let place = |name, setting, growth: &Growth| {
        RowPlace::new("unstable", name, setting, PACKING, growth.seconds)
    };
    let here = place("event-driven", "exact", &reference).only_default(false);
    reference.rows(log, &here, first, None, None);
    for method in log.effort.methods.clone() {
        for setting in [SchemeSetting::Single, SchemeSetting::Eight] {
            let fewer = if setting == SchemeSetting::Single {
                1
            } else {
                4
            };
            let growth = of((replicas / fewer).max(4), &|seed| {
                let start = &starts[seed as usize];
                monte_carlo(start, RESTITUTION, method.parameters_at(setting), seed)
            })?;
            let here = place(method.name, setting.name(), &growth).only_default(method.default);
            let claim = method
                .claims(setting, SchemeQuantity::Growth)
                .then_some(0.1);
            growth.rows(log, &here, first, Some(&reference), claim);
        }
    }
    Ok(())
}
