//! What a case means, in lines, before it is run.

use std::fmt::Write as _;
use std::thread;

use super::case::Selection;
use super::plan::Plan;
use crate::progress::duration;

/// Collisions a second of one core that the estimate of the time assumes; a rough guide.
fn collisions_per_second(plan: &Plan) -> f64 {
    let alone = match plan.case.selection {
        Selection::Own => 3e6,
        Selection::LowRank => 1.5e6,
        Selection::Bird => 2e5,
    };
    // Paths need the time of every proposal.
    if plan.case.measure.displacement {
        0.5 * alone
    } else {
        alone
    }
}

/// Groups up to which theory is asked for the number of collisions; its cost grows with their square.
const MANY: usize = 40;

/// Collisions of a particle up to the end of the run, if theory tells them in short time.
fn collisions(plan: &Plan) -> Option<f64> {
    if plan.case.sticking.is_some() || plan.groups.len() > MANY {
        return None;
    }
    super::theory::collisions(plan).ok()
}

/// Bytes of one replica.
fn bytes(plan: &Plan) -> f64 {
    let measure = &plan.case.measure;
    let (vectors, each) = (
        8.0 * plan.case.dimension as f64,
        if measure.displacement { 78.0 } else { 38.0 },
    );
    let start = if measure.velocity_correlation {
        vectors
    } else {
        0.0
    };
    (each + start) * plan.particles() as f64
}

/// What follows from a case, in lines.
pub(crate) fn outline(plan: &Plan) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for (name, value) in plan.derived() {
        let _ = writeln!(text, "  {name:<44} {value:>14.6}");
    }
    let _ = writeln!(
        text,
        "  {:<44} {:>14.1}",
        "memory_of_one_replica_in_mebibytes",
        bytes(plan) / 1_048_576.0
    );
    let replicas = plan.case.replicas;
    if let Some(collisions) = collisions(plan) {
        let _ = writeln!(
            text,
            "  {:<44} {collisions:>14.3}",
            "collisions_per_particle_by_theory"
        );
        let threads = thread::available_parallelism().map_or(1, usize::from);
        let pairs = 0.5 * collisions * plan.particles() as f64;
        let rounds = replicas.div_ceil(threads) as f64;
        let seconds = pairs / collisions_per_second(plan) * rounds;
        let _ = writeln!(
            text,
            "  {replicas} replicas on {threads} threads: roughly {}",
            duration(seconds)
        );
    }
    for warning in warnings(plan) {
        let _ = writeln!(text, "  warning: {warning}");
    }
    text
}

/// What is allowed but deserves a second look.
pub(crate) fn warnings(plan: &Plan) -> Vec<String> {
    let mut list = Vec::new();
    if plan.case.replicas == 1 {
        list.push(
            "replicas = 1: errors come from the spread over particles, where that is known, and from nothing else"
                .to_owned(),
        );
    }
    let few = plan.groups.iter().filter(|group| group.count < 10).count();
    if few > 0 && plan.case.sticking.is_none() {
        list.push(format!(
            "{few} of {} species have fewer than 10 particles: their temperatures fluctuate by more than a quarter",
            plan.groups.len()
        ));
    }
    let packing = plan.packing_fraction();
    if packing > 1.0 {
        list.push(format!(
            "the packing fraction is {packing:.3}: no such gas exists; with contact values of one it is the Boltzmann equation \
             that is solved"
        ));
    }
    list
}
