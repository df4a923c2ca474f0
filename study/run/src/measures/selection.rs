//! Selection of the engines and replicas of which a measure keeps a record, as options of the
//! measure.

use serde::Deserialize;

use crate::measure::{self, BadOption};
use crate::plan::CasePlan;

/// Replicas as given in a case: all, or a list of numbers.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(untagged, expecting = "a list of replicas, from 0, or \"all\"")]
pub enum Replicas {
    /// All replicas of the case.
    All(AllReplicas),
    /// List of numbers of replicas, from 0.
    List(Vec<u64>),
}

/// Word that stands for all replicas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AllReplicas {
    /// All replicas of the case.
    All,
}

impl Default for Replicas {
    fn default() -> Self {
        Self::List(vec![0])
    }
}

impl Replicas {
    /// Returns true if the selection contains the replica with this number, from 0.
    pub(super) fn has(&self, replica: u64) -> bool {
        match self {
            Self::All(_) => true,
            Self::List(list) => list.contains(&replica),
        }
    }

    /// Returns an error if the selection names replicas that the case does not have.
    pub(super) fn check_replicas(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let Self::List(list) = self else {
            return Ok(());
        };
        let most = plan.case.replicas - 1;
        for (index, &replica) in list.iter().enumerate() {
            let key = format!("replicas.{}", index + 1);
            let allowed = format!("replicas from 0 to {most}, or \"all\"");
            measure::require(replica <= most, &key, allowed)?;
        }
        Ok(())
    }
}

/// Returns true if `engines` names the engine, or is `None`.
pub(super) fn is_named(engines: Option<&[String]>, engine: &str) -> bool {
    engines.is_none_or(|names| names.iter().any(|one| one == engine))
}

/// Returns an error if the selection names engines that the case does not have.
pub(super) fn check_engines(plan: &CasePlan, engines: Option<&[String]>) -> Result<(), BadOption> {
    let names: Vec<&str> = plan.engines.iter().map(|engine| engine.name).collect();
    for (index, name) in engines.into_iter().flatten().enumerate() {
        let allowed = format!("engines of the case, {}", names.join(", "));
        let key = format!("engines.{}", index + 1);
        measure::require(names.contains(&&**name), &key, allowed)?;
    }
    Ok(())
}
