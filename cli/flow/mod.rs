//! Flows: grains between walls, with spin, gravity, inflow and obstacles, by exact dynamics, Monte Carlo, or both.
//!
//! | module | owns |
//! |---|---|
//! | [`case`] | the case as it is written, and its relations |
//! | [`plan`] | what follows from it |
//! | [`scene`] | choices that become types |
//! | [`start`] | the initial state |
//! | [`obstacles`] | obstacles as the model has them |
//! | `gas` | the two engines as a run sees them |
//! | [`run`] | replicas, checkpoints, samples |
//! | [`theory`] | what theory says |
//! | [`tables`], [`export`] | the tables |
//! | [`verdicts`], `channel` | what they say |
//! | [`manifest`], `report` | the manifest and the page |

pub mod case;
mod channel;
pub mod export;
mod gas;
pub mod manifest;
pub mod obstacles;
pub mod plan;
pub(crate) mod report;
pub mod run;
pub mod scene;
pub mod start;
pub mod tables;
pub mod theory;
mod verdicts;

use std::fmt::Write as _;

use plan::Plan;
pub use verdicts::verdicts;

/// Why a valid case of a flow cannot be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FlowError {
    /// The grains are too many, or have no size.
    #[error("{grains} grains; allowed are fewer than 4294967296, with finite diameters and masses")]
    Sizes {
        /// How many.
        grains: u64,
    },
    /// The faces do not fit together.
    #[error("walls: {0}")]
    Walls(#[from] stosszahl_model::walls::WallError),
    /// An obstacle has no meaning.
    #[error(transparent)]
    Obstacle(#[from] obstacles::BadObstacle),
    /// The start cannot be made.
    #[error("start: {0}")]
    Start(#[from] start::StartError),
    /// Theory cannot be computed.
    #[error("theory: {0}")]
    Theory(#[from] stosszahl_analysis::theory::TheoryError),
}

/// What a plan means, in lines.
pub fn outline(plan: &Plan) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for (name, value) in plan.derived() {
        let _ = writeln!(text, "  {name:<44} {value:>14.6}");
    }
    let _ = writeln!(
        text,
        "  {} replicas of {}",
        plan.flow.replicas,
        plan.engines().join(" and ")
    );
    for warning in warnings(plan) {
        let _ = writeln!(text, "  warning: {warning}");
    }
    text
}

/// What is allowed but deserves a second look.
pub fn warnings(plan: &Plan) -> Vec<String> {
    /// Cells wider than this many mean free paths carry momentum too far.
    const WIDE: f64 = 1.01;
    /// Simulators in a cell below which the same pairs meet again and again.
    const FEW: f64 = 4.0;
    let mut list = Vec::new();
    let derived = plan.derived();
    let value = |name: &str| {
        let found = derived.iter().find(|(known, _)| *known == name);
        found.map(|&(_, value)| value)
    };
    if let Some(width) = value("side_of_a_cell_over_mean_free_path").filter(|&w| w > WIDE) {
        list.push(format!(
            "Monte Carlo cells are {width:.2} mean free paths wide: transport is too fast by an error quadratic in this; set engine.dsmc.cell_size, or use more simulators per grain"
        ));
    }
    if let Some(count) = value("simulators_in_a_cell").filter(|&count| count < FEW) {
        list.push(format!(
            "a Monte Carlo cell holds {count:.1} simulators: the same pairs meet again and again; use more simulators per grain, or wider cells"
        ));
    }
    if plan.flow.run.blocks < 10 {
        list.push(format!(
            "{} blocks of time: standard errors of the fields are poorly known",
            plan.flow.run.blocks
        ));
    }
    list
}
