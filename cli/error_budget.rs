//! The error budget of a run: each source of error with what was measured of it, an estimate, and a mark.
//!
//! Estimates are rough, for a reader who must decide which choice to refine next; `stosszahl frontier` measures errors.
//! Where they come from:
//!
//! - *cell*: a collision in a cell of width h carries momentum across it, which raises the viscosity by 16/(45 π) (h/λ)²
//!   for the mean free path λ (F. J. Alexander, A. L. Garcia & B. J. Alder, Phys. Fluids 10, 1540 (1998),
//!   doi:10.1063/1.869674, for spheres);
//! - *step*: flights are cut into steps. The Green-Kubo integral of a stress that relaxes at the rate ν = nT/η is then a
//!   sum by the trapezoidal rule, which raises the viscosity by (ν Δt)²/12: π/48 (v Δt/λ)² for disks with v = √(2T/m), and
//!   16/(75 π) for spheres, where it is known (N. G. Hadjiconstantinou, Phys. Fluids 12, 2634 (2000)). Where partners are displaced,
//!   one that collides again in the same step gives momentum back: about half a collision per step of it, as measured
//!   (`docs/validation-background.md`);
//! - *few simulators*: the rate of displaced cells errs by a third over the number in a cell, K at `t_0` with partners
//!   around the point of contact by 0.4 over their number (both measured at packing 0.25 and restitution 0.8,
//!   `docs/validation-background.md` and `docs/monte-carlo.md`);
//! - *limit*, *contact time*: the share of collisions that are not what they should be, twice that for the energy of a gas
//!   that cools at a rate that is wrong by it;
//! - *majorant*, *separation* across cells: no estimate, and a mark by the size of what was measured;
//! - *replicas*: the standard error of the last energy.

use stosszahl_model::{Plane, Space as _, kinetic};

use crate::case::{Displacement, Dsmc, Engine, Scheme};
use crate::run::Finished;
use crate::setup::Setup;
use crate::tables::{EnergyRow, ErrorBudgetRow, Mark};

/// Estimates up to these are green and amber.
const GREEN: f64 = 0.01;
const AMBER: f64 = 0.05;
/// Share by which cells of a mean free path raise the viscosity, 16/(45 π).
const CELL: f64 = 16.0 / (45.0 * std::f64::consts::PI);

impl Mark {
    /// Of an estimated error; what is no number is red.
    fn of(estimate: f64) -> Self {
        if estimate <= GREEN {
            Self::Green
        } else if estimate <= AMBER {
            Self::Amber
        } else {
            Self::Red
        }
    }
}

/// The budget of one engine, from its runs and its last row of energies.
pub(crate) fn budget(
    setup: &Setup,
    engine: &Engine,
    runs: &[&Finished],
    last: Option<&EnergyRow>,
) -> Vec<ErrorBudgetRow> {
    let budget = Budget {
        setup,
        engine: engine.name(),
        runs,
    };
    let mut rows = match engine {
        Engine::Ed(ed) if ed.contact_time > 0.0 => vec![budget.contact_time()],
        Engine::Ed(_) => Vec::new(),
        Engine::Dsmc(dsmc) => budget.monte_carlo(dsmc),
    };
    rows.push(budget.replicas(last));
    rows
}

/// One engine of a run.
struct Budget<'a> {
    setup: &'a Setup,
    engine: &'static str,
    runs: &'a [&'a Finished],
}

impl Budget<'_> {
    fn row(
        &self,
        source: &str,
        value: f64,
        unit: &str,
        estimate: f64,
        reason: String,
    ) -> ErrorBudgetRow {
        ErrorBudgetRow {
            engine: self.engine.to_owned(),
            source: source.to_owned(),
            value: value.is_finite().then_some(value),
            unit: unit.to_owned(),
            estimate: estimate.is_finite().then_some(estimate),
            mark: Mark::of(estimate),
            reason,
        }
    }

    /// Mean of a number of work over the replicas.
    fn work(&self, name: &str) -> f64 {
        let numbers = self
            .runs
            .iter()
            .map(|run| run.work.numbers.get(name).copied());
        numbers
            .map(|number| number.unwrap_or(f64::NAN))
            .sum::<f64>()
            / self.runs.len() as f64
    }

    fn monte_carlo(&self, dsmc: &Dsmc) -> Vec<ErrorBudgetRow> {
        let path = kinetic::mean_free_path(self.setup.packing_fraction, self.setup.contact_value);
        let mut rows = Vec::new();
        if dsmc.scheme.within_cells() {
            rows.push(self.cell(dsmc, path));
        }
        rows.push(self.step(dsmc));
        rows.extend(self.simulators(dsmc));
        rows.push(self.separation(dsmc, path));
        rows.push(self.majorant());
        rows.push(self.limit());
        rows
    }

    fn cell(&self, dsmc: &Dsmc, path: f64) -> ErrorBudgetRow {
        let width = self.setup.cell_size(dsmc)[0] / path;
        let estimate = CELL * width * width;
        let reason = "cells carry momentum across their width: error of the viscosity";
        self.row("cell", width, "mean free paths", estimate, reason.into())
    }

    fn step(&self, dsmc: &Dsmc) -> ErrorBudgetRow {
        // Each simulator collides so often in a step: the step over the mean free time.
        let step = self.work("collisions_per_simulator_and_step");
        // The most probable speed over the mean one.
        let speeds = 2.0 / std::f64::consts::PI.sqrt();
        let flight = std::f64::consts::PI / 48.0 * (speeds * step).powi(2);
        let displaced = !matches!(displacement(dsmc), None | Some(Displacement::None));
        let (estimate, reason) = if displaced {
            let reason = "displaced partners that collide again in the step give momentum back: error of the collisional pressure";
            (0.5 * step, reason)
        } else {
            (flight, "flights are cut into steps: error of the viscosity")
        };
        self.row("step", step, "mean free times", estimate, reason.into())
    }

    fn simulators(&self, dsmc: &Dsmc) -> Option<ErrorBudgetRow> {
        if let Scheme::ContactPoint { .. } = dsmc.scheme {
            let parameters = self.setup.dsmc_parameters(dsmc);
            let radius = parameters.partner_radius::<Plane>(self.setup.packing_fraction, 1.0);
            let shell = Plane::ball(1.0 + radius) - Plane::ball((1.0 - radius).max(0.0));
            let density = self.setup.packing_fraction / Plane::ball(0.5);
            // With radius 0 the nearest is taken.
            let partners = (density * shell * self.setup.copies(dsmc)).max(1.0);
            let reason =
                "simulators that collided meet again and lose less energy: error of K at t0";
            Some(self.row(
                "partners",
                partners,
                "simulators",
                0.4 / partners,
                reason.into(),
            ))
        } else if dsmc.scheme.within_cells() {
            let count = self.setup.simulators_per_cell(dsmc);
            let reason = "pairs of a cell are few and meet again: error of the collision rate";
            Some(self.row(
                "simulators per cell",
                count,
                "simulators",
                1.0 / (3.0 * count),
                reason.into(),
            ))
        } else {
            None
        }
    }

    fn separation(&self, dsmc: &Dsmc, path: f64) -> ErrorBudgetRow {
        /// Mean distance of two random points of a square, over its side.
        const APART: f64 = 0.5214;
        let separation = self.work("collision_separation_over_d");
        if dsmc.scheme.within_cells() {
            let value = separation / path;
            let estimate = CELL * (value / APART).powi(2);
            let reason = "partners are apart by this: error of the viscosity, as measured rather than by the width of cells";
            return self.row(
                "separation",
                value,
                "mean free paths",
                estimate,
                reason.into(),
            );
        }
        let reason = "partners are apart by this and not by one diameter: mean distance, not along the line of centres";
        ErrorBudgetRow {
            estimate: None,
            mark: if (separation - 1.0).abs() <= 0.5 {
                Mark::Green
            } else {
                Mark::Amber
            },
            ..self.row(
                "separation",
                separation,
                "diameters",
                f64::NAN,
                reason.into(),
            )
        }
    }

    fn majorant(&self) -> ErrorBudgetRow {
        /// Shares from which the bound is looked at, and from which it is no bound.
        const SOME: f64 = 0.01;
        const MANY: f64 = 0.1;
        let share = self.work("majorant_violations_per_trial");
        let reason = "trials faster than the bound of their cell, accepted as if at it; it is raised then, so the rate lacks their \
                      share times an excess that is not recorded";
        let mark = if share <= SOME {
            Mark::Green
        } else if share <= MANY {
            Mark::Amber
        } else {
            Mark::Red
        };
        ErrorBudgetRow {
            mark,
            ..self.row("majorant", share, "of the trials", f64::NAN, reason.into())
        }
    }

    fn limit(&self) -> ErrorBudgetRow {
        let share = self.work("share_of_collisions_in_limited_cells");
        let reason = "collisions in cells whose contact value was cut at largest_contact_value: error of the rate, about";
        self.row(
            "limited cells",
            share,
            "of the collisions",
            share,
            reason.into(),
        )
    }

    fn contact_time(&self) -> ErrorBudgetRow {
        let share = self.work("share_of_collisions_made_elastic");
        let reason = "contacts within the contact time lose no energy: error of K";
        self.row(
            "contact time",
            share,
            "of the collisions",
            2.0 * share,
            reason.into(),
        )
    }

    fn replicas(&self, last: Option<&EnergyRow>) -> ErrorBudgetRow {
        let error = last.and_then(|row| Some(row.energy_ratio_se? / row.energy_ratio));
        let reason = if error.is_some() {
            "standard error of the last energy"
        } else {
            "one replica cannot tell its own error"
        };
        let count = self.runs.len() as f64;
        self.row(
            "replicas",
            count,
            "replicas",
            error.unwrap_or(f64::NAN),
            reason.into(),
        )
    }
}

/// How far partners of a scheme within cells are displaced.
fn displacement(dsmc: &Dsmc) -> Option<Displacement> {
    match dsmc.scheme {
        Scheme::Boltzmann { displacement }
        | Scheme::FreeVolume { displacement, .. }
        | Scheme::Enskog { displacement, .. } => Some(displacement),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_follow_estimates_and_no_number_is_red() {
        use Mark::{Amber, Green, Red};
        let marks = [0.0, 0.01, 0.02, 0.05, 0.06, f64::NAN].map(Mark::of);
        assert_eq!(marks, [Green, Green, Amber, Amber, Red, Red]);
    }
}
