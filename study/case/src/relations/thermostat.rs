//! Checks of the thermostat: its keys by kind, and gases that it is not for.

use toml::Table;

use super::{Checked, Relations, refusal};
use crate::format::{AggregationSpec, Case, ThermostatKind, ThermostatSpec};

/// Largest number of thermostat scalings and kicks in a run.
const MOST_SCALINGS: f64 = 1e7;
const MOST_KICKS: f64 = 1e9;
/// Largest product of drag and interval of a Langevin bath.
const LARGEST_DAMPING: f64 = 100.0;

/// Returns a problem if a case has one of the old tables that `[thermostat]` replaces.
pub(crate) fn replaced(table: &Table) -> Checked {
    let allowed = "[thermostat] with kind = \"white-noise\", and heating and interval as here";
    if table.contains_key("drive") {
        return Err(refusal(table, "drive", allowed));
    }
    Ok(())
}

/// Returns true if gravity accelerates particles for ever: along a periodic axis of a box without
/// walls or obstacles.
fn falls_for_ever(case: &Case) -> bool {
    let pulls = case.gravity.as_ref().is_some_and(|gravity| {
        let mut parts = gravity.acceleration.iter();
        parts.any(|&part| part != 0.0)
    });
    pulls && !case.is_bounded()
}

impl Relations<'_> {
    pub(super) fn thermostat(&self) -> Checked {
        let Some(thermostat) = &self.case.thermostat else {
            return Ok(());
        };
        self.keys_of_kind(thermostat)?;
        let until = self.case.run.until;
        match thermostat.kind {
            ThermostatKind::Rescaling => self.rescaling(),
            ThermostatKind::WhiteNoise | ThermostatKind::Langevin => self.bath(thermostat),
        }?;
        let (most, what) = match thermostat.kind {
            ThermostatKind::Rescaling => (MOST_SCALINGS, "scalings"),
            _ => (MOST_KICKS, "kicks"),
        };
        let fits = |interval: f64| interval < until && until / interval <= most;
        self.ensure(
            thermostat.interval.is_none_or(fits),
            "thermostat.interval",
            format!("an interval below run.until, for at most {most} {what}"),
        )
    }

    /// Checks that all given thermostat keys belong to its kind.
    fn keys_of_kind(&self, thermostat: &ThermostatSpec) -> Checked {
        let key = |name: &str| format!("thermostat.{name}");
        let (required, idle): (&[&str], &[(&str, &str)]) = match thermostat.kind {
            ThermostatKind::Rescaling => (
                &["interval"],
                &[
                    ("heating", "\"white-noise\""),
                    ("drag", "\"langevin\""),
                    ("bath_temperature", "\"langevin\""),
                ],
            ),
            ThermostatKind::WhiteNoise => (
                &["heating", "interval"],
                &[
                    ("drag", "\"langevin\""),
                    ("bath_temperature", "\"langevin\""),
                ],
            ),
            ThermostatKind::Langevin => (&["drag"], &[("heating", "\"white-noise\"")]),
        };
        for (name, kind) in idle {
            let allowed = format!("this key is for thermostat.kind = {kind}");
            self.without(&[&key(name)], &allowed)?;
        }
        for name in required {
            let allowed = "a number above 0, which this kind of thermostat needs";
            self.ensure(self.given(&key(name)), key(name), allowed)?;
        }
        Ok(())
    }

    /// Checks a case whose thermostat scales velocities to the initial energy.
    fn rescaling(&self) -> Checked {
        let case = self.case;
        if !case.has_box() {
            let breaks = case
                .aggregation
                .as_ref()
                .is_some_and(AggregationSpec::breaks);
            let allowed =
                "a gas that goes on losing energy: with aggregation.fragment_above, or with [box]";
            return self.ensure(breaks, "thermostat", allowed);
        }
        let moves_freely = case.is_uniform() && !case.is_rough();
        let allowed = "\"white-noise\" or \"langevin\"; velocities are scaled to the energy of the start in a box that is periodic on \
                       all sides, without obstacles, gravity and spin, which keep energies of their own";
        self.ensure(moves_freely, "thermostat.kind", allowed)
    }

    /// Checks a case whose thermostat is a bath of random kicks.
    fn bath(&self, thermostat: &ThermostatSpec) -> Checked {
        let case = self.case;
        let allowed =
            "\"rescaling\" in a gas without positions; random kicks are for gases in a [box]";
        self.ensure(case.has_box(), "thermostat.kind", allowed)?;
        let is_noise = thermostat.kind == ThermostatKind::WhiteNoise;
        let allowed = "\"langevin\", whose drag ends a fall; with white noise a gas in a periodic box falls ever faster under gravity";
        self.ensure(
            !(is_noise && falls_for_ever(case)),
            "thermostat.kind",
            allowed,
        )?;
        let damping = thermostat.drag.zip(thermostat.interval);
        let fits = damping.is_none_or(|(drag, interval)| drag * interval <= LARGEST_DAMPING);
        let allowed = format!(
            "an interval of at most {LARGEST_DAMPING} over the drag, after which velocities are forgotten"
        );
        self.ensure(fits, "thermostat.interval", allowed)
    }
}
