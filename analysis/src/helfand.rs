//! Transport coefficients of elastic disks in equilibrium, by Einstein-Helfand moments and
//! Green-Kubo correlations of the fluxes.
//!
//! A flux J(t) whose integral over a lag is G has the coefficient
//!
//! ```text
//! self-diffusion     D      = lim <(ΔR)²>/(4 t)
//! shear viscosity    eta    = lim <(ΔG_xy)²>/(2 V T t),  and the same of (G_xx - G_yy)/2
//! bulk viscosity     zeta   = lim <(ΔG_p - <ΔG_p>)²>/(2 V T t),  G_p = (G_xx + G_yy)/2
//! heat conductivity  lambda = lim <(ΔG_q)²>/(2 V T² t)
//! ```
//!
//! with the fluxes of stress and energy (E. Helfand, *Physical Review* **119**, 1 (1960),
//! doi:10.1103/PhysRev.119.1; for hard particles B. J. Alder, D. M. Gass & T. E. Wainwright,
//! *Journal of Chemical Physics* **53**, 3813 (1970), doi:10.1063/1.1673845)
//!
//! ```text
//! J_ab = Σ_i m v_a v_b + Σ_collisions Δp_a r_b δ(t - t_c),   J_q = Σ_i (m v²/2) v + Σ_collisions ΔE r δ(t - t_c)
//! ```
//!
//! where the first partner gains the momentum Δp and the energy ΔE, and r points to it from the
//! second. The first term, the **kinetic** one, is constant between collisions and changes with the
//! velocities of the two partners; the second one is **collisional**. Both are kept apart, so that
//! a coefficient splits into a kinetic part, a collisional one, and twice their correlation.
//!
//! Disks move relative to their mean velocity, so no enthalpy flows. T is the temperature of N
//! disks of fixed momentum, the energy over N - 1. The mean of `G_p`, the pressure, is that of the
//! whole run. That lowers its variance by the fraction t over the time of the run, which is
//! corrected.
//!
//! # Design
//!
//! The run is cut into bins. Fluxes are averaged over all starts at the end of a bin, up to a
//! largest lag of a given number of bins; displacements, which N disks average, over lags one after
//! the other. Only velocities and displacements of the disks and the sums are stored: the engine is
//! not sampled between start and end.
//!
//! Beside the moments there are the correlations of Green and Kubo ([`Helfand::correlations`]). The
//! collisional flux is a sum of pulses, whose integrals have a meaning and whose values have none,
//! so fluxes and velocities are means over whole bins.

use std::collections::VecDeque;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use stosszahl_model::Collision;

/// Number of fluxes: two of shear stress, one of pressure, two of energy.
const FLUXES: usize = 5;

/// Time integrals of all fluxes: the kinetic parts, then the collisional parts.
type Integrals = [[f64; FLUXES]; 2];

/// Sums over all time origins at one lag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Sums {
    /// Number of time origins of the lag.
    starts: f64,
    /// Sums for each flux of three products of its changes over the lag: squared kinetic change,
    /// kinetic times collisional change, squared collisional change.
    squares: [[f64; 3]; FLUXES],
    /// Sum over the time origins of the collisional change of the pressure flux.
    pressure: f64,
    /// Sum of the squared displacements of disks over the lag \[length^2\].
    displacements: f64,
    /// Number of displacements that were summed, over all disks and time origins.
    disks: f64,
    /// Number of pairs of bins that are this lag apart; lag 0 pairs each bin with itself.
    pairs: f64,
    /// Sums of the products of the changes of each flux in two bins that are this lag apart.
    products: [f64; FLUXES],
    /// Sum over displacements of the product of two parts: those in the first and in the last bin
    /// of the lag \[length^2\].
    steps: f64,
}

/// Flux correlations at one lag (Green-Kubo); the integral of each over the lag is a transport
/// coefficient.
///
/// Units are those of [`HelfandMoments`] without the lag, over a time. The first correlations, at
/// lag zero, are of bins with themselves and count half.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Correlations {
    /// Lag of the correlations \[time\].
    pub lag: f64,
    /// Velocity autocorrelation: its integral over the lag is the self-diffusion coefficient.
    pub diffusion: f64,
    /// Stress autocorrelation: its integral over the lag is the shear viscosity.
    pub shear: f64,
    /// Pressure autocorrelation: its integral over the lag is the bulk viscosity.
    pub bulk: f64,
    /// Heat flux autocorrelation: its integral over the lag is the heat conductivity.
    pub heat: f64,
}

/// Helfand moments at one lag, scaled so that their slope over the lag is the coefficient:
/// [`Helfand::moments`] has the units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HelfandMoments {
    /// Lag of the moments \[time\].
    pub lag: f64,
    /// Moment of the displacements: its slope in the lag is the self-diffusion coefficient.
    pub diffusion: f64,
    /// Moments of the shear stress: kinetic, mixed and collisional part. The slope of their sum is
    /// the shear viscosity.
    pub shear: [f64; 3],
    /// Moment of the pressure: its slope in the lag is the bulk viscosity.
    pub bulk: f64,
    /// Moments of the heat flux: kinetic, mixed and collisional part. The slope of their sum is the
    /// heat conductivity.
    pub heat: [f64; 3],
}

/// Velocity and displacement of a disk, updated at its collisions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Disk {
    velocity: Vector2<f64>,
    /// Displacement of the disk since the beginning of the current lag, up to the time `since`
    /// \[length\].
    moved: Vector2<f64>,
    /// Time up to which `moved` is computed: that of the last collision of the disk, or the
    /// beginning of the lag.
    since: f64,
    /// Displacement of the disk in the first bin of the current lag \[length\].
    first: Vector2<f64>,
    /// Displacement of the disk from the beginning of the current lag to the end of the last bin
    /// \[length\].
    last: Vector2<f64>,
}

/// Transport-coefficient sums of one run (Einstein-Helfand and Green-Kubo), fed with its
/// collisions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Helfand {
    mass: f64,
    area: f64,
    temperature: f64,
    start: f64,
    now: f64,
    bin: f64,
    /// Number of time bins that have ended.
    bins: u64,
    disks: Vec<Disk>,
    flux: [f64; FLUXES],
    integrals: Integrals,
    /// Time integrals of the fluxes at the ends of the last bins, the latest first.
    history: VecDeque<Integrals>,
    /// Sums for each lag, from a lag of one bin on.
    sums: Vec<Sums>,
}

/// Computes the kinetic fluxes that a disk of velocity `v` carries.
fn kinetic_fluxes(mass: f64, v: Vector2<f64>) -> [f64; FLUXES] {
    let energy = 0.5 * mass * v.norm_squared();
    [
        mass * v.x * v.y,
        0.5 * mass * (v.x * v.x - v.y * v.y),
        energy,
        energy * v.x,
        energy * v.y,
    ]
}

impl Helfand {
    /// Memory needed for each disk \[bytes\].
    pub const BYTES_PER_DISK: usize = size_of::<Disk>();

    /// Creates sums for disks of one mass in a box of a given area, from the time `start` with the
    /// velocities of all disks. Lags reach over `bins` bins of the duration `bin`.
    pub fn new(
        start: f64,
        velocities: impl IntoIterator<Item = Vector2<f64>>,
        mass: f64,
        area: f64,
        bin: f64,
        bins: usize,
    ) -> Self {
        let mut velocities: Vec<_> = velocities.into_iter().collect();
        let count = velocities.len() as f64;
        let drift = velocities.iter().sum::<Vector2<f64>>() / count.max(1.0);
        let (mut flux, mut energy) = ([0.0; FLUXES], 0.0);
        for velocity in &mut velocities {
            *velocity -= drift;
            energy += 0.5 * mass * velocity.norm_squared();
            for (sum, one) in flux.iter_mut().zip(kinetic_fluxes(mass, *velocity)) {
                *sum += one;
            }
        }
        let disk = |velocity| Disk {
            velocity,
            moved: Vector2::zeros(),
            since: start,
            first: Vector2::zeros(),
            last: Vector2::zeros(),
        };
        Self {
            mass,
            area,
            temperature: energy / (count - 1.0).max(1.0),
            start,
            now: start,
            bin,
            bins: 0,
            disks: velocities.into_iter().map(disk).collect(),
            flux,
            integrals: Integrals::default(),
            history: VecDeque::from([Integrals::default()]),
            sums: vec![Sums::default(); bins],
        }
    }

    /// Adds a collision to the fluxes. Collisions earlier than the last one, and partners without
    /// an index, are ignored.
    pub fn collide(&mut self, collision: &Collision) {
        if collision.time < self.now {
            return;
        }
        self.advance(collision.time);
        let pair = collision.pair.map(|index| index as usize);
        let [Some(first), Some(second)] = pair.map(|index| self.disks.get(index).copied()) else {
            return;
        };
        let line = collision.line.xy();
        let approach = collision.relative_velocity.xy().dot(&line) / line.norm_squared();
        let gain = line * (-collision.reduced_mass * (1.0 + collision.restitution) * approach);
        let (before, mut energy) = ([first, second], 0.0);
        for (side, (index, sign)) in pair.into_iter().zip([1.0, -1.0]).enumerate() {
            let mut disk = before[side];
            disk.moved += disk.velocity * (self.now - disk.since);
            disk.since = self.now;
            disk.velocity += gain * (sign / self.mass);
            let [old, new] =
                [before[side], disk].map(|one| kinetic_fluxes(self.mass, one.velocity));
            for (flux, (old, new)) in self.flux.iter_mut().zip(old.into_iter().zip(new)) {
                *flux += new - old;
            }
            if side == 0 {
                energy = new[2] - old[2];
            }
            self.disks[index] = disk;
        }
        let given = [
            0.5 * (gain.x * line.y + gain.y * line.x),
            0.5 * (gain.x * line.x - gain.y * line.y),
            0.5 * gain.dot(&line),
            energy * line.x,
            energy * line.y,
        ];
        for (sum, one) in self.integrals[1].iter_mut().zip(given) {
            *sum += one;
        }
    }

    /// Advances the kinetic flux integrals to the time `until`, without a collision, and ends time
    /// bins on the way.
    pub fn advance(&mut self, until: f64) {
        loop {
            let end = self.start + (self.bins + 1) as f64 * self.bin;
            let to = end.min(until);
            for (sum, flux) in self.integrals[0].iter_mut().zip(&self.flux) {
                *sum += flux * (to - self.now).max(0.0);
            }
            self.now = self.now.max(to);
            if end > until {
                return;
            }
            self.end_bin();
        }
    }

    fn end_bin(&mut self) {
        self.bins += 1;
        self.add_bin_products();
        for (sums, before) in self.sums.iter_mut().zip(&self.history) {
            sums.starts += 1.0;
            let change = |part: usize, flux: usize| self.integrals[part][flux] - before[part][flux];
            for (flux, squares) in sums.squares.iter_mut().enumerate() {
                let [kinetic, collisional] = [0, 1].map(|part| change(part, flux));
                let terms = [
                    kinetic * kinetic,
                    kinetic * collisional,
                    collisional * collisional,
                ];
                for (sum, term) in squares.iter_mut().zip(terms) {
                    *sum += term;
                }
            }
            sums.pressure += change(1, 2);
        }
        self.history.push_front(self.integrals);
        self.history.truncate(self.sums.len());
        let lags = self.sums.len() as u64;
        let lag = ((self.bins - 1) % lags) as usize;
        let now = self.now;
        let sums = &mut self.sums[lag];
        for disk in &mut self.disks {
            let place = disk.moved + disk.velocity * (now - disk.since);
            sums.displacements += place.norm_squared();
            let step = place - disk.last;
            if lag == 0 {
                disk.first = step;
            }
            disk.last = place;
            sums.steps += step.dot(&disk.first);
        }
        sums.disks += self.disks.len() as f64;
        if self.bins.is_multiple_of(lags) {
            for disk in &mut self.disks {
                (disk.moved, disk.since) = (Vector2::zeros(), now);
                disk.last = Vector2::zeros();
            }
        }
    }

    /// Adds the products of the flux changes in the bin that ends and in each bin before it to the
    /// correlation sums.
    fn add_bin_products(&mut self) {
        let total = |integrals: &Integrals, flux: usize| integrals[0][flux] + integrals[1][flux];
        // The kinetic part of the pressure is that of the energy, which never changes.
        let given = |integrals: &Integrals, flux: usize| match flux {
            2 => integrals[1][2],
            _ => total(integrals, flux),
        };
        let change = |after: &Integrals, before: &Integrals| -> [f64; FLUXES] {
            std::array::from_fn(|flux| given(after, flux) - given(before, flux))
        };
        let now = change(&self.integrals, &self.history[0]);
        let mut later = &self.integrals;
        for (sums, earlier) in self.sums.iter_mut().zip(&self.history) {
            let then = change(later, earlier);
            sums.pairs += 1.0;
            for (sum, (now, then)) in sums.products.iter_mut().zip(now.iter().zip(then)) {
                *sum += now * then;
            }
            later = earlier;
        }
    }

    /// Computes the flux correlations by lag, from lag 0 on; their units are those of
    /// [`Helfand::moments`] over a lag.
    pub fn correlations(&self) -> Vec<Correlations> {
        let speed = (self.temperature / self.mass).sqrt();
        let run = self.now - self.start;
        let mean = self.integrals[1][2] / run * self.bin;
        // The squared mean of the run, less the variance of that mean.
        let last = self.moments().last().map(|last| last.bulk / last.lag);
        let slope = 2.0 * self.area * self.temperature * self.mass * speed * last.unwrap_or(0.0);
        let mean_square = mean * mean - slope / run * self.bin * self.bin;
        let reached = self.sums.iter().enumerate();
        let reached = reached.filter(|(_, sums)| sums.pairs > 0.0 && sums.disks > 0.0);
        // Viscosities are 1/(V T) of the integral over time, in sqrt(m T)/d; lags come in d
        // sqrt(m/T).
        let stress = 1.0 / (self.area * (self.temperature * self.bin).powi(2));
        let energy = stress * self.mass / self.temperature;
        let one = |(number, sums): (usize, &Sums)| {
            let of = |flux: usize| sums.products[flux] / sums.pairs;
            Correlations {
                lag: number as f64 * self.bin * speed,
                diffusion: 0.5 * sums.steps / sums.disks / (self.bin * speed).powi(2),
                shear: 0.5 * (of(0) + of(1)) * stress,
                bulk: (of(2) - mean_square) * stress,
                heat: 0.5 * (of(3) + of(4)) * energy,
            }
        };
        reached.map(one).collect()
    }

    /// Computes the Helfand moments by lag, in units of which mass m and temperature T of the gas
    /// are one. With the unit d of lengths, lags come in d sqrt(m/T), diffusion in d sqrt(T/m),
    /// viscosities in sqrt(m T)/d, conductivity in sqrt(T/m)/d, each times a lag. Lags that no bin
    /// has reached are left out.
    pub fn moments(&self) -> Vec<HelfandMoments> {
        let speed = (self.temperature / self.mass).sqrt();
        let run = self.now - self.start;
        let rate = self.integrals[1][2] / run;
        let reached = self.sums.iter().enumerate();
        let reached = reached.filter(|(_, sums)| sums.starts > 0.0 && sums.disks > 0.0);
        let moments = reached.map(|(number, sums)| {
            let lag = (number + 1) as f64 * self.bin;
            // 1/(2 V T) over a viscosity sqrt(m T)/d and times a lag d sqrt(m/T): 1/(2 V T m).
            let stress = 0.5 / (self.area * self.temperature * self.mass * sums.starts);
            let energy = stress * self.mass / self.temperature;
            let of = |fluxes: [usize; 2], unit: f64| {
                let mean = |term: usize| {
                    let sum: f64 = fluxes.iter().map(|&flux| sums.squares[flux][term]).sum();
                    0.5 * sum * unit
                };
                [mean(0), 2.0 * mean(1), mean(2)]
            };
            let mean = rate * lag;
            let square = sums.squares[2][2] - mean * (2.0 * sums.pressure - mean * sums.starts);
            HelfandMoments {
                lag: lag * speed,
                diffusion: 0.25 * sums.displacements / sums.disks,
                shear: of([0, 1], stress),
                bulk: square * stress / (1.0 - lag / run),
                heat: of([3, 4], energy),
            }
        });
        moments.collect()
    }
}

#[cfg(test)]
mod tests;
