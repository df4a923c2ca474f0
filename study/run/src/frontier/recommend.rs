//! The cheapest setting that keeps a target, for each engine, and whether it keeps it on fresh seeds.

use stosszahl_analysis::accuracy::Accuracy;

use super::FrontierError;
use super::front::Measured;
use super::measure::{Task, Workshop};
use super::quantity::{Kind, Quantity};
use super::reference::Reference;

/// First replica of the tests: none that a setting or the reference has run.
const FIRST: u64 = 1 << 33;
/// Most replicas that are recommended.
const MOST: u64 = 4096;

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target<'a> {
    /// Largest error.
    pub error: f64,
    /// Of these.
    pub kinds: &'a [Kind],
    /// Disks of the case.
    pub disks: usize,
    /// Times that a recommendation is tested.
    pub tests: u64,
}

/// The two engines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Engines {
    /// Exact dynamics.
    EventDriven,
    /// Any Monte Carlo scheme.
    MonteCarlo,
}

impl Engines {
    pub(crate) const ALL: [Self; 2] = [Self::EventDriven, Self::MonteCarlo];

    /// In words.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::EventDriven => "event-driven",
            Self::MonteCarlo => "Monte Carlo",
        }
    }

    fn holds(self, measured: &Measured) -> bool {
        measured.setting.is_event_driven() == (self == Self::EventDriven)
    }
}

/// A choice: which setting, and how many replicas of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Choice {
    /// Place among the measured settings.
    pub index: usize,
    /// Replicas.
    pub replicas: u64,
    /// CPU time of all of them \[s\].
    pub core_seconds: f64,
    /// Root mean squared error that is expected, of the worst quantity.
    pub error: f64,
}

/// Bias and noise of a quantity as a choice sees them. Exact dynamics of the whole case is what an ensemble is made of, so it has
/// no systematic error against one: the difference of the two means is noise of both.
fn judged(
    one: &Measured,
    index: usize,
    references: &[Reference],
    disks: usize,
) -> Option<Accuracy> {
    let found = one.accuracies[index]?;
    if one.setting.is_reference(disks) && references[index].is_ensemble {
        Some(found.without_systematic_error())
    } else {
        Some(found)
    }
}

/// The quantities of the kinds asked for.
fn wanted(target: &Target<'_>, quantities: &[Quantity]) -> Vec<usize> {
    let asked = |index: &usize| target.kinds.contains(&quantities[*index].kind);
    (0..quantities.len()).filter(asked).collect()
}

/// The cheapest setting whose assured error of every wanted quantity is within the target.
pub(crate) fn choose(
    engines: Engines,
    measured: &[Measured],
    quantities: &[Quantity],
    references: &[Reference],
    target: &Target<'_>,
) -> Option<Choice> {
    let wanted = wanted(target, quantities);
    let choice = |(index, one): (usize, &Measured)| {
        let runs: Option<Vec<u64>> = wanted
            .iter()
            .map(|&index| {
                judged(one, index, references, target.disks)?.runs_for(target.error, MOST)
            })
            .collect();
        let replicas = runs?.into_iter().max()?;
        let errors = wanted.iter().filter_map(|&index| {
            Some(judged(one, index, references, target.disks)?.total(replicas))
        });
        Some(Choice {
            index,
            replicas,
            core_seconds: replicas as f64 * one.core_seconds,
            error: errors.fold(0.0, f64::max),
        })
    };
    measured
        .iter()
        .enumerate()
        .filter(|(_, one)| engines.holds(one))
        .filter_map(choice)
        .min_by(|a, b| a.core_seconds.total_cmp(&b.core_seconds))
}

/// The setting whose systematic error of the worst wanted quantity is smallest, with that error and its standard error.
pub(crate) fn nearest(
    engines: Engines,
    measured: &[Measured],
    quantities: &[Quantity],
    target: &Target<'_>,
) -> Option<(usize, [f64; 2])> {
    let wanted = wanted(target, quantities);
    let worst = |one: &Measured| {
        let errors: Option<Vec<[f64; 2]>> = wanted
            .iter()
            .map(|&quantity| {
                let found = one.accuracies[quantity]?;
                Some([found.systematic.abs(), found.systematic_error])
            })
            .collect();
        errors?.into_iter().max_by(|a, b| a[0].total_cmp(&b[0]))
    };
    measured
        .iter()
        .enumerate()
        .filter(|(_, one)| engines.holds(one))
        .filter_map(|(index, one)| Some((index, worst(one)?)))
        .min_by(|a, b| a.1[0].total_cmp(&b.1[0]))
}

/// A finer setting of a sequence of the chosen one, whose systematic error is surely beyond the target: then the chosen one is
/// right because errors cancel, and not because it is fine enough.
pub(crate) fn finer_that_fails<'a>(
    choice: &Choice,
    measured: &'a [Measured],
    quantities: &[Quantity],
    target: &Target<'_>,
) -> Option<(&'a Measured, f64)> {
    let wanted = wanted(target, quantities);
    let chosen = &measured[choice.index].setting;
    let finer = |other: &&Measured| {
        chosen.refinements.iter().any(|own| {
            let mut members = other.setting.refinements.iter();
            members.any(|member| member.sequence == own.sequence && member.h < own.h)
        })
    };
    measured.iter().filter(finer).find_map(|other| {
        let surely = |&quantity: &usize| {
            let found = other.accuracies[quantity]?;
            (found.systematic_range()[0] > target.error).then_some(found.systematic)
        };
        let error = wanted.iter().find_map(surely)?;
        Some((other, error))
    })
}

/// How a choice did on fresh seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tested {
    /// Tests in which every wanted quantity was within the target.
    pub kept: u64,
    /// Tests.
    pub tests: u64,
    /// Root mean squared error of the worst quantity.
    pub error: f64,
    /// CPU time of one test \[s\].
    pub core_seconds: f64,
}

/// Runs a choice on fresh seeds, as often as asked for and its share of the time \[s\] allows, but at least once.
///
/// # Errors
/// [`FrontierError`] if runs cannot be made.
pub(crate) fn test(
    workshop: &Workshop<'_>,
    choice: &Choice,
    measured: &[Measured],
    quantities: &[Quantity],
    references: &[Reference],
    target: &Target<'_>,
    share: f64,
) -> Result<Tested, FrontierError> {
    let setting = measured[choice.index].setting.clone();
    let one = setting.nominal_seconds(workshop.plan) * choice.replicas as f64;
    let tests = ((share / one) as u64).clamp(1, target.tests.max(1));
    let task = Task {
        setting,
        replicas: FIRST..FIRST + tests * choice.replicas,
    };
    let outcome = workshop
        .run(&[task])?
        .pop()
        .unwrap_or_else(|| Ok(Vec::new()));
    let samples = outcome.map_err(|reason| FrontierError::NoTest { reason })?;
    let wanted = wanted(target, quantities);
    let (mut kept, mut squares) = (0, vec![0.0; quantities.len()]);
    let groups = samples.chunks(choice.replicas as usize);
    for group in groups {
        let mut within = true;
        for &index in &wanted {
            let mean = group.iter().map(|run| run.values[index]).sum::<f64>() / group.len() as f64;
            let known = references[index].known.value;
            let error = (mean - known) / quantities[index].kind.unit(known);
            squares[index] += error * error / tests as f64;
            // Written so that a value that is no number is not within.
            within &= error.abs() <= target.error;
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
