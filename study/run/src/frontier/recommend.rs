//! Recommendation of a frontier: the cheapest setting of each class of engines that meets a target
//! error, and its test on fresh seeds.

use stosszahl_analysis::accuracy::SettingAccuracy;

use super::FrontierError;
use super::front::MeasuredSetting;
use super::measure::{FRESH, Task, Workshop};
use super::quantity::{FrontierQuantity, QuantityKind};
use super::reference::Reference;

/// Largest number of replicas in a recommendation.
const MOST: u64 = 4096;

/// Search among measured settings for the cheapest one that meets a target.
pub(crate) struct SettingSearch<'a> {
    /// Measured settings to choose among.
    pub measured: &'a [MeasuredSetting],
    /// Quantities whose errors were measured.
    pub quantities: &'a [FrontierQuantity],
    /// Reference values of the quantities, in their order.
    pub references: &'a [Reference],
    /// Target: largest error allowed, over the unit of the quantity's kind (`QuantityKind::unit`).
    pub error: f64,
    /// Kinds of quantities whose errors must not exceed the target.
    pub kinds: &'a [QuantityKind],
    /// Number of disks of the case, without smaller systems.
    pub disks: usize,
}

/// Class of engines that gets a recommendation of its own: exact dynamics, or Monte Carlo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EngineGroup {
    /// Exact event-driven dynamics.
    EventDriven,
    /// Monte Carlo, by any scheme.
    MonteCarlo,
}

impl EngineGroup {
    pub(crate) const ALL: [Self; 2] = [Self::EventDriven, Self::MonteCarlo];

    /// Returns the name of the engine class in words.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::EventDriven => "Exact dynamics",
            Self::MonteCarlo => "Monte Carlo",
        }
    }

    fn holds(self, measured: &MeasuredSetting) -> bool {
        measured.setting.is_event_driven() == (self == Self::EventDriven)
    }
}

/// Recommendation for a class of engines: a setting and a number of replicas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Choice {
    /// Index of the recommended setting among the measured settings.
    pub index: usize,
    /// Number of replicas whose mean meets the target.
    pub replicas: u64,
    /// CPU time of all replicas together \[s\].
    pub core_seconds: f64,
    /// Largest expected total error of the requested quantities, each over the unit of its kind
    /// (`QuantityKind::unit`): mostly the reference value.
    pub error: f64,
}

/// Outcome of the tests of a recommended setting on fresh seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tested {
    /// Number of tests in which every requested quantity was within the target.
    pub kept: u64,
    /// Number of tests made; each averages the recommended number of replicas.
    pub tests: u64,
    /// Largest root mean squared error of the quantities over all tests, each over the unit of its
    /// kind (`QuantityKind::unit`): mostly the reference value.
    pub error: f64,
    /// CPU time of one test \[s\].
    pub core_seconds: f64,
}

impl<'a> SettingSearch<'a> {
    /// Returns the systematic and statistical error of a setting in the quantity with this index.
    /// Exact dynamics of the whole case is given no systematic error against a reference ensemble
    /// of exact dynamics: the difference of their means is noise of both.
    fn accuracy_of(&self, one: &MeasuredSetting, index: usize) -> Option<SettingAccuracy> {
        let found = one.accuracies[index]?;
        let same = one.setting.is_reference(self.disks) && self.references[index].is_ensemble;
        Some(if same {
            found.without_systematic_error()
        } else {
            found
        })
    }

    /// Returns the indices of the quantities of the requested kinds.
    fn wanted(&self) -> impl Iterator<Item = usize> {
        let asked = |index: &usize| self.kinds.contains(&self.quantities[*index].kind);
        (0..self.quantities.len()).filter(asked)
    }

    /// Returns the measured settings of a class of engines, with their indices.
    fn settings_of(
        &self,
        engines: EngineGroup,
    ) -> impl Iterator<Item = (usize, &'a MeasuredSetting)> {
        let all = self.measured.iter().enumerate();
        all.filter(move |(_, one)| engines.holds(one))
    }

    /// Returns the cheapest setting of a class of engines whose assured error of every requested
    /// quantity meets the target.
    pub(crate) fn choose(&self, engines: EngineGroup) -> Option<Choice> {
        let choice = |(index, one): (usize, &MeasuredSetting)| {
            let runs = self
                .wanted()
                .map(|place| self.accuracy_of(one, place)?.runs_for(self.error, MOST));
            let replicas = runs.collect::<Option<Vec<u64>>>()?.into_iter().max()?;
            let found = self
                .wanted()
                .filter_map(|place| self.accuracy_of(one, place));
            Some(Choice {
                index,
                replicas,
                core_seconds: replicas as f64 * one.core_seconds,
                error: found.map(|found| found.total(replicas)).fold(0.0, f64::max),
            })
        };
        let choices = self.settings_of(engines).filter_map(choice);
        choices.min_by(|a, b| a.core_seconds.total_cmp(&b.core_seconds))
    }

    /// Returns the setting whose systematic error of the worst requested quantity is smallest, with
    /// this error and its standard error, both over the unit of the quantity's kind.
    pub(crate) fn nearest(&self, engines: EngineGroup) -> Option<(&'a MeasuredSetting, [f64; 2])> {
        let worst = |(_, one): (usize, &'a MeasuredSetting)| {
            let errors = self.wanted().map(|place| {
                let found = one.accuracies[place]?;
                Some([found.systematic.abs(), found.systematic_error])
            });
            let errors: Option<Vec<[f64; 2]>> = errors.collect();
            let worst = errors?.into_iter().max_by(|a, b| a[0].total_cmp(&b[0]));
            Some((one, worst?))
        };
        let all = self.settings_of(engines).filter_map(worst);
        all.min_by(|a, b| a.1[0].total_cmp(&b.1[0]))
    }

    /// Returns a finer setting, in a sequence of the chosen one, whose systematic error certainly
    /// exceeds the target. The chosen setting is then right only because errors cancel, not because
    /// it is fine enough.
    pub(crate) fn finer_that_fails(&self, choice: &Choice) -> Option<(&'a MeasuredSetting, f64)> {
        let chosen = &self.measured[choice.index].setting;
        let finer = |other: &&MeasuredSetting| {
            chosen.refinements.iter().any(|own| {
                let mut members = other.setting.refinements.iter();
                members.any(|member| member.sequence == own.sequence && member.h < own.h)
            })
        };
        self.measured.iter().filter(finer).find_map(|other| {
            let error = self.wanted().find_map(|quantity| {
                let found = other.accuracies[quantity]?;
                (found.systematic_range()[0] > self.error).then_some(found.systematic)
            });
            Some((other, error?))
        })
    }

    /// Tests a recommended setting on fresh seeds, as often as `most` and its share of the CPU time
    /// \[s\] allow, but at least once.
    ///
    /// # Errors
    /// [`FrontierError`] if runs cannot be made.
    pub(crate) fn test(
        &self,
        workshop: &Workshop<'_>,
        choice: &Choice,
        most: u64,
        share: f64,
    ) -> Result<Tested, FrontierError> {
        let setting = self.measured[choice.index].setting.clone();
        let one = setting.nominal_seconds(workshop.plan) * choice.replicas as f64;
        let tests = ((share / one) as u64).clamp(1, most.max(1));
        let replicas = FRESH..FRESH + tests * choice.replicas;
        let outcome = workshop.one(Task { setting, replicas })?;
        let what = "the recommended setting failed";
        let samples = outcome.map_err(|reason| FrontierError::Runs { what, reason })?;
        let (mut kept, mut squares) = (0, vec![0.0; self.quantities.len()]);
        for group in samples.chunks(choice.replicas as usize) {
            let mut within = true;
            for index in self.wanted() {
                let sum: f64 = group.iter().map(|run| run.values[index]).sum();
                let known = self.references[index].known.value;
                let unit = self.quantities[index].kind.unit(known);
                let error = (sum / group.len() as f64 - known) / unit;
                squares[index] += error * error / tests as f64;
                // Written so that a value that is no number is not within.
                within &= error.abs() <= self.error;
            }
            kept += u64::from(within);
        }
        Ok(Tested {
            kept,
            tests,
            error: squares.into_iter().fold(0.0, f64::max).sqrt(),
            core_seconds: samples.iter().map(|one| one.core_seconds).sum::<f64>() / tests as f64,
        })
    }
}
