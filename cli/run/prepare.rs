//! The initial state of a replica: placed, given velocities, equilibrated elastically, and tested.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::equilibrium::{self, Outcome};
use stosszahl_ed::{Checkpoint, Dissipation, Engine};
use stosszahl_model::initial::{self, Placement};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{Body, Collision, Observe, Sizes, State};

use super::{Control, RunError, leg_collisions};
use crate::case::Velocities;
use crate::dispatch::Planar;
use crate::setup::Setup;

/// Bins of the test for uniform impact parameters, and collisions that it needs in each.
const BINS: usize = 20;
const COLLISIONS_PER_BIN: u64 = 1000;

/// How a start came about.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct StartReport {
    /// How the disks were placed.
    pub placement: String,
    /// Elastic collisions per particle.
    pub collisions_per_particle: f64,
    /// Whether the collisions asked for happened, at least one, and no test failed.
    pub equilibrated: bool,
    /// The tests of the last block.
    pub tests: Vec<Outcome>,
}

/// A start on its way.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub(super) struct Preparation<P: Planar> {
    gas: Checkpoint<P>,
    reciprocal: Vec<[i32; 2]>,
    placement: String,
    bins: Vec<u64>,
    pub(super) report: Option<StartReport>,
}

impl<P: Planar> Preparation<P> {
    /// The finished start.
    pub(super) fn state(&self) -> &State<P> {
        &self.gas.state
    }
}

/// |b|/d in bins.
struct Histogram<'a>(&'a mut [u64]);

impl<P: Planar> Observe<P> for Histogram<'_> {
    #[inline]
    fn collision(&mut self, collision: &Collision<Vector2<f64>>) {
        let bin = (collision.impact_square().sqrt() * BINS as f64) as usize;
        self.0[bin.min(BINS - 1)] += 1;
    }
}

/// Places the disks and draws their velocities.
fn begin<P: Planar>(
    setup: &Setup,
    scene: &P,
    streams: Streams,
) -> Result<Preparation<P>, RunError> {
    let unlike = setup.sizes.as_ref().filter(|_| !setup.species.is_empty());
    let (placement, name) = match (&setup.file, setup.arrangement()) {
        (None, Some(_)) if unlike.is_some() => {
            let radii: Vec<f64> = unlike.map_or_else(Vec::new, |sizes| {
                (0..setup.disks)
                    .map(|index| sizes.radius(sizes.tag(index)))
                    .collect()
            });
            let placement = initial::place_unlike(&radii, &setup.domain, &streams)
                .map_err(|error| RunError::Setup(error.into()))?;
            (placement, "disordered, large disks first".to_owned())
        }
        (None, Some(arrangement)) => {
            let placement = initial::place(arrangement, setup.disks, 1.0, &setup.domain, &streams)
                .map_err(|error| RunError::Setup(error.into()))?;
            let molten =
                arrangement == initial::Arrangement::Disordered && !placement.reciprocal.is_empty();
            let name = if molten {
                "molten hexagonal lattice".into()
            } else {
                format!("{arrangement:?}").to_lowercase()
            };
            (placement, name)
        }
        (file, _) => {
            let positions = file
                .as_ref()
                .map_or_else(Vec::new, |file| file.positions.clone());
            (
                Placement {
                    positions,
                    reciprocal: Vec::new(),
                },
                "file".to_owned(),
            )
        }
    };
    let sizes = scene.sizes();
    let radius = |index: usize| sizes.radius(sizes.tag(index));
    if let Some(overlap) = initial::first_overlap(&placement.positions, radius, &setup.domain, 1e-9)
    {
        return Err(RunError::Overlap {
            pair: overlap.pair,
            depth: overlap.depth,
        });
    }
    let bodies = placement
        .positions
        .iter()
        .map(|&at| Body::new(setup.domain.wrap(at), Vector2::zeros()))
        .collect();
    let mut state = State {
        time: 0.0,
        domain: setup.domain,
        bodies,
    };
    match setup.case.start.velocities {
        Velocities::Maxwellian { .. } => {
            initial::maxwellian(
                scene,
                &mut state,
                1.0,
                &mut streams.at(Purpose::Velocities, [0, 0]),
            );
        }
        Velocities::File => {
            let velocities = setup
                .file
                .iter()
                .filter_map(|file| file.velocities.as_ref())
                .flatten();
            for (body, &velocity) in state.bodies.iter_mut().zip(velocities) {
                body.velocity = velocity;
            }
        }
    }
    Ok(Preparation {
        gas: state.into(),
        reciprocal: placement.reciprocal,
        placement: name,
        bins: vec![0; BINS],
        report: None,
    })
}

/// Equilibrates in blocks until the collisions asked for have happened and no test fails, or patience ends.
pub(super) fn prepare<P: Planar>(
    setup: &Setup,
    scene: &P,
    streams: Streams,
    control: &Control<'_, Preparation<P>>,
) -> Result<Preparation<P>, RunError> {
    let mut start = match control.load()? {
        Some(start) => start,
        None => begin(setup, scene, streams)?,
    };
    let pairs = |per_particle: f64| (0.5 * per_particle * setup.disks as f64).ceil() as u64;
    let asked = pairs(setup.case.start.collisions_per_particle);
    let most = pairs(setup.case.start.most_collisions_per_particle).max(asked);
    // The last half of what was asked is tested, or more where that is too little to tell.
    let block = (asked / 2).max(BINS as u64 * COLLISIONS_PER_BIN);
    while start.report.is_none() {
        let done = start.gas.tally.collisions;
        let in_block: u64 = start.bins.iter().sum();
        // Blocks end at a multiple of their length after the first half of what was asked.
        let first = asked.saturating_sub(block);
        let target = if done < first {
            first
        } else {
            done + (block - in_block)
        };
        let target = if asked == 0 { 0 } else { target.min(most) };
        if done < target {
            let leg = leg_collisions(setup.disks).min(target - done);
            // As long as theory needs for a hundred collisions of each disk: a gas in which nothing collides
            // in all that time has nothing to forget.
            let horizon = start.gas.state.time + 100.0 / setup.collision_rate();
            let mut engine = Engine::<P>::new(scene.clone(), Dissipation::Elastic, start.gas)?;
            if done < first {
                engine.advance(horizon, leg, &mut ())?;
            } else {
                engine.advance(horizon, leg, &mut Histogram(&mut start.bins))?;
            }
            let silent = engine.tally().collisions == done;
            start.gas = engine.checkpoint();
            control.tell(start.gas.tally.collisions as f64 / most.max(1) as f64, leg);
            if !silent {
                control.pause(&start)?;
                continue;
            }
        }
        let tests = test(setup, &start);
        let failed = tests.iter().any(|test| test.passed == Some(false));
        let done = start.gas.tally.collisions;
        if failed && done < most && done >= target && target > 0 {
            start.bins = vec![0; BINS];
            continue;
        }
        start.report = Some(StartReport {
            placement: start.placement.clone(),
            collisions_per_particle: 2.0 * done as f64 / setup.disks as f64,
            equilibrated: !failed && asked > 0 && done >= asked,
            tests,
        });
        start.gas.state.time = 0.0;
        if asked > 0 && matches!(setup.case.start.velocities, Velocities::Maxwellian { .. }) {
            initial::rescale(scene, &mut start.gas.state, 1.0);
        }
        control.save(&start)?;
    }
    control.tell(1.0, 0);
    Ok(start)
}

fn test<P: Planar>(setup: &Setup, start: &Preparation<P>) -> Vec<Outcome> {
    let positions: Vec<Vector2<f64>> = start
        .gas
        .state
        .bodies
        .iter()
        .map(|body| body.position)
        .collect();
    let lengths = setup.domain.lengths().into();
    let packing = setup.packing_fraction;
    let mut tests = vec![equilibrium::impact_uniform(&start.bins)];
    if !start.reciprocal.is_empty() {
        tests.push(equilibrium::lattice_forgotten(
            &positions,
            lengths,
            &start.reciprocal,
            packing,
        ));
    }
    if setup.sizes.is_none() {
        tests.push(equilibrium::long_waves_fluctuate(
            &positions, lengths, 1.0, packing,
        ));
    }
    tests
}
