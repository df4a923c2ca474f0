//! Runs in memory without files, for pilot runs and the frontier, and the quantities measured in
//! them.

use stosszahl_analysis::windows::{CollisionWindow, CollisionWindows};
use stosszahl_case::Case;
use stosszahl_model::{Interrupt, Particles, equation_of_state};

use crate::control::Control;
use crate::engine_run::{EngineRun, PartError, prepare};
use crate::measure::{CompletedRun, Measure};
use crate::measures::{self, GasSeries};
use crate::plan::{CasePlan, EnginePlan};

/// Run of one replica of a case in memory, without files.
#[derive(Clone, Copy)]
pub(crate) struct InMemoryRun<'a> {
    /// Resolved plan of the case.
    pub plan: &'a CasePlan,
    /// Measures to make in the run.
    pub measures: &'a [&'static dyn Measure],
    /// Number of the replica.
    pub replica: u64,
    /// Interrupt that stops the run at the end of the current segment.
    pub stop: &'a Interrupt,
}

impl InMemoryRun<'_> {
    /// Creates the initial state that all engines of the replica share.
    pub(crate) fn make_start(&self) -> Result<Particles, PartError> {
        let control = Control::new(None, 1e9, self.stop, &|_, _| {});
        Ok(prepare(self.plan, self.replica, &control)?.1)
    }

    /// Runs one engine of the replica from an initial state.
    pub(crate) fn run_engine(
        &self,
        engine: &EnginePlan,
        start: &Particles,
    ) -> Result<CompletedRun, PartError> {
        let part = EngineRun {
            plan: self.plan,
            engine,
            measures: self.measures,
            replica: self.replica,
            start: Some(start),
        };
        let control = Control::new(None, 1e9, self.stop, &|_, _| {});
        part.run_engine(&control)
    }
}

/// Returns the measures with these names, with default options unless the case sets them.
pub(crate) fn measures(names: &[&str]) -> Vec<&'static dyn Measure> {
    let all = measures::ALL.iter().copied();
    all.filter(|one| names.contains(&one.name())).collect()
}

/// Returns the case with another number of equal particles and packing fraction; unchanged if the
/// case defines its particles in another way.
pub(crate) fn resized(case: &Case, count: usize, packing_fraction: f64) -> Case {
    let mut case = case.clone();
    match (&mut case.species[..], &mut case.gas.number) {
        ([], Some(number)) => *number = count as u64,
        ([one], _) => {
            one.number = Some(count as u64);
            one.share = None;
            case.gas.number = None;
        }
        _ => return case,
    }
    if let Some(domain) = &mut case.domain {
        if let Some([width, height]) = domain.size.take().as_deref() {
            domain.aspect_ratio = height / width;
        }
        domain.packing_fraction = Some(packing_fraction);
    }
    case
}

/// Returns the kinetic energy over that of the start, K/K(0), at all samples but the first.
pub(crate) fn energies(run: &CompletedRun) -> Vec<f64> {
    let record = run.record::<GasSeries>();
    let energies = record
        .into_iter()
        .flatten()
        .map(|one| one.total().translation);
    let energies: Vec<f64> = energies.collect();
    let later = energies.iter().skip(1);
    later.map(|energy| energy / energies[0]).collect()
}

/// Returns the collision sums of the first time window of the run.
pub(crate) fn window(run: &CompletedRun) -> Option<&CollisionWindow> {
    run.record::<CollisionWindows>()?.windows.first()
}

/// Computes the collision rate in the first time window, over Enskog's rate at the measured
/// temperature.
pub(crate) fn collision_rate(plan: &CasePlan, run: &CompletedRun) -> f64 {
    let enskog =
        equation_of_state::collision_rate(plan.gas.packing_fraction, plan.gas.contact_value, 0.0);
    let found = window(run).and_then(|window| window.dissipation(enskog, plan.count()));
    found.map_or(f64::NAN, |found| found.rate)
}
