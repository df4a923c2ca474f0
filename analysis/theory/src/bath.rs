//! Steady state of a uniform gas in a thermal bath: white noise, drag, or both.

/// Steady state of equal smooth particles in a bath, by the Boltzmann or the Enskog equation in
/// first Sonine order.
///
/// With the drag gamma and the rate of gain g (`dT/dt` by the noise alone), energy balances at `g =
/// 2 gamma T + zeta(T) T`, `zeta = zeta_M (1 + 3 a2/16)`, where `zeta_M` is the cooling rate of a
/// Maxwellian, which grows as sqrt(T). White noise of the energy h for each particle and time has
/// `gamma = 0` and `g = 2 h/D`, a Langevin bath of the temperature `T_b` has `g = 2 gamma T_b`. The
/// fourth moments balance at
///
/// ```text
/// a2 = 16 (1 - r)(1 - 2 r^2)/[73 + 56 D - (24 D + 105) r + 30 r^2 (1 - r) + 64 (D + 2)(1 - r) gamma/zeta_M]
/// ```
///
/// For gamma = 0 that is T. P. C. van Noije & M. H. Ernst, *Granular Matter* **1**, 57 (1998),
/// doi:10.1007/s100350050009; the term with the drag follows from the same moments, `mu_4 = (D + 2)
/// mu_2 + D (D + 2) (gamma/nu) a2` (compare M. G. Chamorro, F. Vega Reyes & V. Garzó, *J. Stat.
/// Mech.* (2013) P07013, doi:10.1088/1742-5468/2013/07/P07013).
///
/// ```
/// use stosszahl_theory::BathState;
/// // An elastic gas takes the temperature of its bath.
/// let state = BathState::new(2, 1.0, 0.0, 0.3, 2.0 * 0.3 * 1.5).expect("a steady state");
/// assert!((state.temperature - 1.5).abs() < 1e-12 && state.fourth_cumulant == 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BathState {
    /// Granular temperature of the steady state \[energy\].
    pub temperature: f64,
    /// Fourth cumulant a2 of the velocities in the steady state.
    pub fourth_cumulant: f64,
    /// Cooling rate zeta at the steady temperature \[1/time\].
    pub cooling_rate: f64,
    /// Drag coefficient gamma of the bath \[1/time\].
    pub drag: f64,
}

impl BathState {
    /// Solves the energy balance. `cooling` is the cooling rate of a Maxwellian gas at the
    /// temperature 1 \[1/time\], `gain` the rate at which the noise raises T \[energy/time\].
    /// `None` unless the gain is above 0 and drag or collisions dissipate energy.
    pub fn new(
        dimension: usize,
        restitution: f64,
        cooling: f64,
        drag: f64,
        gain: f64,
    ) -> Option<Self> {
        let at = |temperature: f64| {
            let maxwellian = cooling * temperature.sqrt();
            let fourth_cumulant = if restitution < 1.0 {
                fourth_cumulant(dimension, restitution, drag / maxwellian)
            } else {
                0.0
            };
            Self {
                temperature,
                fourth_cumulant,
                cooling_rate: maxwellian * (1.0 + 3.0 / 16.0 * fourth_cumulant),
                drag,
            }
        };
        let loses = cooling > 0.0 || drag > 0.0;
        if !(loses && gain > 0.0 && gain.is_finite()) {
            return None;
        }
        // Either loss alone bounds the temperature; |3 a2/16| is below 1/20 for all r.
        let by_drag = gain / (2.0 * drag);
        let by_collisions = 1.1 * (gain / cooling).powf(2.0 / 3.0);
        let (mut low, mut high) = (0.0, by_drag.min(by_collisions));
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            let state = at(middle);
            if gain > (2.0 * drag + state.cooling_rate) * middle {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(at(high))
    }

    /// Computes the time in which a small deviation of the temperature falls to 1/e \[time\]: `1/(2
    /// gamma + 3 zeta/2)`.
    pub fn relaxation_time(&self) -> f64 {
        1.0 / (2.0 * self.drag + 1.5 * self.cooling_rate)
    }

    /// Computes the shear-mode spectrum over that of thermal noise at the temperature of the gas,
    /// `S_perp(k) = 1 + (zeta/2)/(gamma + nu k^2)`, nu being the kinematic viscosity
    /// \[length^2/time\].
    ///
    /// Linear fluctuating hydrodynamics: a mode decays at `gamma + nu k^2`; viscous noise of the
    /// strength `2 nu k^2 T/m` and the noise of the bath, `g/m = (2 gamma + zeta) T/m`, feed it.
    ///
    /// White noise has `1 + (k_c/k)^2` with `k_c^2 = zeta/(2 nu)` (van Noije, Ernst, Trizac &
    /// Pagonabarraga, *Physical Review E* **59**, 4326 (1999), doi:10.1103/PhysRevE.59.4326). A
    /// Langevin bath has `(gamma T_b + nu k^2 T)/((gamma + nu k^2) T)`, with the plateaus `T_b/T`
    /// and 1 beside the wave number `sqrt(gamma/nu)` (Gradenigo, Sarracino, Villamaina & Puglisi,
    /// *EPL* **96**, 14004 (2011), doi:10.1209/0295-5075/96/14004).
    pub fn shear_spectrum(&self, viscosity: f64, wave_number: f64) -> f64 {
        1.0 + 0.5 * self.cooling_rate / self.shear_decay(viscosity, wave_number)
    }

    /// Computes the decay rate of a shear mode \[1/time\], `gamma + nu k^2`.
    pub fn shear_decay(&self, viscosity: f64, wave_number: f64) -> f64 {
        self.drag + viscosity * wave_number * wave_number
    }
}

/// Computes the fourth cumulant a2 for a drag given in units of the cooling rate of a Maxwellian.
fn fourth_cumulant(dimension: usize, restitution: f64, drag: f64) -> f64 {
    let (d, r) = (dimension as f64, restitution);
    let noise = 73.0 + 56.0 * d - (24.0 * d + 105.0) * r + 30.0 * r * r * (1.0 - r);
    let damping = 64.0 * (d + 2.0) * (1.0 - r) * drag;
    16.0 * (1.0 - r) * (1.0 - 2.0 * r * r) / (noise + damping)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White noise against the published value, both balances against their definitions.
    #[test]
    fn energy_and_fourth_moment_balance() {
        let state = BathState::new(2, 0.9, 2.0, 0.0, 2.0).expect("a steady state");
        let a2 = -16.0 * 0.1 * 0.62 / (185.0 - 153.0 * 0.9 + 30.0 * 0.81 * 0.1);
        assert!((state.fourth_cumulant - a2).abs() < 1e-15);
        let known = (1.0 + 3.0 / 16.0 * a2).powf(-2.0 / 3.0);
        assert!((state.temperature - known).abs() < 1e-14);
        for (dimension, r, drag) in [(2, 0.8, 0.1), (3, 0.5, 2.0), (2, 0.99, 30.0)] {
            let (cooling, gain) = (0.7, 2.0 * drag * 1.3);
            let state = BathState::new(dimension, r, cooling, drag, gain).expect("a steady state");
            let lost = (2.0 * drag + state.cooling_rate) * state.temperature;
            assert!((lost / gain - 1.0).abs() < 1e-13, "{state:?}");
            // mu_2 and mu_4 of van Noije & Ernst over their common factor A; the Maxwellian loses
            // zeta_M = (2/D) nu A, so that nu A = D zeta_M/2.
            let (d, a2) = (dimension as f64, state.fourth_cumulant);
            let mu2 = 1.0 + 3.0 / 16.0 * a2;
            let mu4 = d
                + 1.5
                + r * r
                + a2 * (3.0 / 32.0 * (10.0 * d + 39.0 + 10.0 * r * r) + (d - 1.0) / (1.0 - r));
            let rate = 0.5 * d * cooling * state.temperature.sqrt();
            let balance = (d + 2.0) * mu2 - mu4 - d * (d + 2.0) * drag / rate * a2;
            assert!(balance.abs() < 1e-13, "{balance}");
        }
    }

    /// The relaxation time is the slope of the balance; a2 changes slowly and is left out.
    #[test]
    fn deviations_relax() {
        let (cooling, drag) = (1.3, 0.2);
        let state = BathState::new(2, 0.9, cooling, drag, 1.0).expect("a steady state");
        let factor = state.cooling_rate / state.temperature.sqrt();
        let slope = |t: f64| 2.0 * drag * t + factor * t.powf(1.5);
        let step = 1e-5 * state.temperature;
        let found =
            (slope(state.temperature + step) - slope(state.temperature - step)) / (2.0 * step);
        assert!((found * state.relaxation_time() - 1.0).abs() < 1e-8);
    }

    /// Plateaus of both baths, and the sum of noises over the decay in between.
    #[test]
    fn shear_spectra_have_their_plateaus() {
        let (drag, bath) = (0.4, 2.0);
        let state = BathState::new(2, 0.8, 0.6, drag, 2.0 * drag * bath).expect("a steady state");
        let (nu, t) = (1.7, state.temperature);
        for k in [1e-4, 0.3, 0.5, 1e4] {
            let known = (drag * bath + nu * k * k * t) / ((drag + nu * k * k) * t);
            assert!((state.shear_spectrum(nu, k) / known - 1.0).abs() < 1e-12);
        }
        assert!((state.shear_spectrum(nu, 1e-4) / (bath / t) - 1.0).abs() < 1e-6);
        let state = BathState::new(2, 0.8, 0.6, 0.0, 1.0).expect("a steady state");
        let critical = state.cooling_rate / (2.0 * nu);
        assert!((state.shear_spectrum(nu, 0.5) - 1.0 - critical / 0.25).abs() < 1e-12);
    }

    #[test]
    fn states_that_do_not_exist_are_none() {
        assert_eq!(BathState::new(2, 1.0, 0.0, 0.0, 1.0), None);
        assert_eq!(BathState::new(2, 0.9, 1.0, 0.0, 0.0), None);
        assert_eq!(BathState::new(2, 0.9, 1.0, 1.0, f64::NAN), None);
    }
}
