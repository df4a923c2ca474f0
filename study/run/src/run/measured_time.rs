//! Measured runtime estimate: each engine runs for a short time slice from its start, which is a
//! known fraction of the whole run.
//!
//! The fraction is that of the collisions that theory expects. It is also that of the time steps,
//! whose length follows the gas. The time of samples is measured separately, once, because a sample
//! may take longer than the time slice. Companion gases of measurements are not run, as their
//! collisions take as long as those of the engine. Engines run in parallel as in a real run,
//! because they share memory and caches of the machine.

use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use stosszahl_model::random::Streams;
use stosszahl_model::{Budget, Interrupt, Particles};

use super::error::RunError;
use crate::check::Planned;
use crate::cost::RuntimeEstimate;
use crate::engine_run::kicks::StochasticDrive;
use crate::engine_run::schedule::{ScheduledEvent, schedule_events};
use crate::engine_run::{EngineRun, PartError, RunState};
use crate::measure::{SampleContext, share_of_others, work_with_companions};
use crate::measures::energy;
use crate::plan::CasePlan;
use crate::start::{Preparation, is_prepared, pairs};
use crate::theory::homogeneous;

/// Multiple of an engine's time slice after which a running time step is interrupted. Used only to
/// measure run times.
const PATIENCE: u32 = 3;
/// Sampling time below which the measurement of its duration is repeated, for a better estimate.
const QUICK: Duration = Duration::from_millis(20);
/// Smallest number of sweep points whose run time is measured, even if the allowed time is short.
const MEASURED: usize = 6;

/// Measures the run time of a case's sweep points on `threads` threads, in about `seconds` in all.
/// A few evenly spread points are measured, and the others scaled from the nearest.
///
/// # Errors
/// [`RunError`] if a start or an engine cannot be made.
pub fn paces(
    planned: &[Planned<'_>],
    threads: usize,
    seconds: f64,
) -> Result<Vec<RuntimeEstimate>, RunError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let jobs = |one: &Planned<'_>| one.plan.engines.len() + usize::from(is_prepared(&one.plan));
    let most = planned.iter().map(jobs).max().unwrap_or(1);
    // A second for each part of a point; less if there are many points, of which some ten are
    // measured.
    let points = (seconds / most as f64).floor().max(MEASURED as f64) as usize;
    let points = points.clamp(1, planned.len().max(1));
    let each = (seconds / (points * most) as f64).min(1.0);
    let each = Duration::from_secs_f64(each);
    let mut found: Vec<(usize, RuntimeEstimate)> = Vec::new();
    for number in 0..points {
        let place = number * (planned.len() - 1) / (points - 1).max(1);
        let guess = planned[place].pace();
        let pace = pool.install(|| measured(&planned[place], threads, each))?;
        found.push((place, pace.ratio_to(&guess)));
    }
    let nearest = |place: usize| found.iter().min_by_key(|one| one.0.abs_diff(place));
    let all = planned.iter().enumerate().map(|(place, one)| {
        let guess = one.pace();
        nearest(place).map_or(guess.clone(), |(_, factor)| guess.scaled(factor))
    });
    Ok(all.collect())
}

/// Measures the run time of one sweep point: its start, then all engines in parallel.
fn measured(
    planned: &Planned<'_>,
    threads: usize,
    each: Duration,
) -> Result<RuntimeEstimate, RunError> {
    let plan = &planned.plan;
    let failed = |part: &str, source: PartError| RunError::Replica {
        replica: 0,
        part: part.to_owned(),
        source: Box::new(source),
    };
    let streams = Streams::new(plan.case.seed, 0);
    let (start, particles) = if is_prepared(plan) {
        let (start, particles) =
            measure_start(plan, streams, each).map_err(|error| failed("start", error))?;
        (start, Some(particles))
    } else {
        (0.0, None)
    };
    let engines = plan.engines.len();
    let most = engines * plan.case.replicas as usize;
    let runs = threads.min(most).max(1);
    let runs = engines.next_multiple_of(runs).min(most).max(engines);
    let found = (0..runs).into_par_iter().map(|number| {
        let engine = &plan.engines[number % engines];
        let part = EngineRun {
            plan,
            engine,
            measures: &planned.measures,
            replica: 0,
            start: particles.as_ref(),
        };
        let pace = pace(&part, each).map_err(|error| failed(engine.name, error))?;
        Ok((number % engines, pace))
    });
    let found: Vec<(usize, [f64; 2])> = found.collect::<Result<_, RunError>>()?;
    let mean = |engine: usize| {
        let own: Vec<[f64; 2]> = found
            .iter()
            .filter(|one| one.0 == engine)
            .map(|one| one.1)
            .collect();
        [0, 1].map(|which| own.iter().map(|one| one[which]).sum::<f64>() / own.len() as f64)
    };
    Ok(RuntimeEstimate {
        start,
        engines: (0..engines).map(mean).collect(),
        ending: theory(plan),
    })
}

/// Returns the time to solve the theory that result tables show \[s\]. The plan keeps the solution
/// for the run.
fn theory(plan: &CasePlan) -> f64 {
    let began = Instant::now();
    // Theory that cannot be followed is left out of a run, too, after the same time.
    if plan.has_box() {
        plan.partial_temperatures();
        for engine in &plan.engines {
            let _ = energy::two_temperature_theory(plan, engine);
        }
    } else {
        let _ = homogeneous::curves(plan);
    }
    began.elapsed().as_secs_f64()
}

/// Prepares initial particles, and interrupts the equilibration after the time slice `each`.
/// Returns its estimated full duration \[s\] and the particles.
fn measure_start(
    plan: &CasePlan,
    streams: Streams,
    each: Duration,
) -> Result<(f64, Particles), PartError> {
    let (pause, never, began) = (Interrupt::default(), Interrupt::default(), Instant::now());
    let start = Preparation::new(plan, streams, &never)?;
    let placed = began.elapsed().as_secs_f64();
    let asked = pairs(plan, plan.equilibration());
    let mut gas = start.gas(plan, streams)?;
    let began = Instant::now();
    let mut left = 1.0;
    if asked > 0 {
        gas.set_pause_flag(&pause);
        let watch = watch(each, &pause, &never);
        gas.advance(f64::INFINITY, Budget::Collisions(asked), &mut ())?;
        drop(watch);
        left = asked as f64 / gas.work_counters().collisions.max(1) as f64;
    }
    let spent = began.elapsed().as_secs_f64();
    let mut particles = gas.particles();
    particles.time = 0.0;
    Ok((placed + spent * left, particles))
}

/// Estimates the run time of an engine: for the first replica, and for each further one \[s\].
fn pace(part: &EngineRun<'_>, each: Duration) -> Result<[f64; 2], PartError> {
    let stop = Interrupt::default();
    let began = Instant::now();
    let mut course = RunState::begin(part, &stop, None)?;
    let beginning = began.elapsed().as_secs_f64();
    let looks = estimate_sampling_time(part, &mut course);
    let (flown, done) = run_time_slice(part, &mut course, &stop, each)?;
    let flight = if done > 0.0 {
        flown / done.min(1.0)
    } else {
        part.plan.seconds(part.engine).max(flown)
    };
    // Companion gases have no collisions yet in the samples of the start.
    let work = work_with_companions(part.measures, part.plan, part.engine);
    Ok([0, 1].map(|which| beginning + flight * work[which] + looks[which]))
}

/// Runs an engine for the time slice `each` without sampling. Returns the time taken \[s\] and the
/// fraction of the whole run done.
fn run_time_slice(
    part: &EngineRun<'_>,
    course: &mut RunState<'_>,
    stop: &Interrupt,
    each: Duration,
) -> Result<(f64, f64), PartError> {
    let plan = part.plan;
    // Samples are timed separately: one at the start would take the time in which the gas should
    // move.
    let without_looks = |due| ScheduledEvent {
        measures: Vec::new(),
        ..due
    };
    let schedule: Vec<ScheduledEvent> = (schedule_events(plan, part.measures).into_iter())
        .map(without_looks)
        .collect();
    let drive = StochasticDrive::new(plan, part.streams())?;
    let pause = Interrupt::default();
    course.gas.set_pause_flag(&pause);
    let _watch = watch(each, &pause, stop);
    let began = Instant::now();
    let mut broken = false;
    while let Some(due) = schedule.get(course.next)
        && !pause.is_raised()
    {
        match course.leg(due, drive.as_ref()) {
            Ok(()) => {}
            Err(PartError::Interrupted) => {
                broken = true;
                break;
            }
            // A run would end here too, because the gas cannot continue.
            Err(error) if error.is_of_gas() => break,
            Err(error) => return Err(error),
        }
    }
    let done = if broken {
        // In the middle of a step the time is not defined, but collisions are counted.
        course.gas.work_counters().collisions as f64 / plan.collisions(part.engine)
    } else {
        plan.done_share(course.gas.time() / plan.clock.time)
    };
    Ok((began.elapsed().as_secs_f64(), done))
}

/// Estimates the total sampling time of an engine from one sample of each measurement \[s\]: for
/// replica 0, and for each further replica.
fn estimate_sampling_time(part: &EngineRun<'_>, course: &mut RunState<'_>) -> [f64; 2] {
    let plan = part.plan;
    let mut sums = [0.0; 2];
    for (number, measure) in part.measures.iter().enumerate() {
        let until = plan.case.run.until;
        let times = measure.sample_times(plan);
        let times = times.iter().filter(|time| (0.0..=until).contains(*time));
        let Some(&first) = times.clone().next() else {
            continue;
        };
        let mut look = || {
            let began = Instant::now();
            let mut moment = SampleContext::new(first, &mut *course.gas);
            course.probes[number].on_sample(&mut moment);
            began.elapsed()
        };
        // The first quick sample waits for memory, so that a second one is timed.
        let found = look();
        let found = if found < QUICK { look() } else { found };
        let all = times.count() as f64 * found.as_secs_f64();
        if measure.looks_at(plan, 0) {
            sums[0] += all;
        }
        sums[1] += all * share_of_others(*measure, plan);
    }
    sums
}

/// Raises `pause` after a time slice, and `stop` after three, unless the returned sender is dropped
/// before.
fn watch(each: Duration, pause: &Interrupt, stop: &Interrupt) -> Sender<()> {
    let (sender, receiver) = mpsc::channel();
    let (pause, stop) = (pause.clone(), stop.clone());
    thread::spawn(move || {
        let waited = |time| receiver.recv_timeout(time) == Err(RecvTimeoutError::Timeout);
        if waited(each) {
            pause.raise();
            if waited(PATIENCE * each) {
                stop.raise();
            }
        }
    });
    sender
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::Path;

    use super::*;
    use crate::measure::{Measure, Probe, SampleProbe, described};
    use crate::plan::EnginePlan;

    /// Measurement for a test, whose first sample takes longer than the engine's time slice.
    struct Slow;

    const GIVEN: Duration = Duration::from_millis(20);

    impl Measure for Slow {
        described!("slow", "Waits.", BTreeMap<String, f64>);

        fn sample_times(&self, _plan: &CasePlan) -> Vec<f64> {
            vec![0.0]
        }

        fn new_probe(&self, _plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
            Box::new(SampleProbe::new((), |(), _| thread::sleep(5 * GIVEN)))
        }
    }

    /// Tests that the engine runs for its full time slice, however long the first sample takes.
    #[test]
    fn a_long_look_at_the_start_leaves_the_engine_its_time() {
        let text = "format = 2\ntitle = \"slow\"\n[gas]\nnumber = 100\nrestitution = 1\n[box]\npacking_fraction = 0.1\n\
                    [engine.ed]\n[run]\nuntil = 1e7\ntime_unit = \"mean-free-time\"";
        let case = toml::from_str(text).expect("a case");
        let plan = CasePlan::new(&case, Path::new(".")).expect("a plan");
        let part = EngineRun {
            plan: &plan,
            engine: &plan.engines[0],
            measures: &[&Slow],
            replica: 0,
            start: None,
        };
        let stop = Interrupt::default();
        let mut course = RunState::begin(&part, &stop, None).expect("a course");
        let looks = estimate_sampling_time(&part, &mut course);
        assert!(looks[0] >= 5.0 * GIVEN.as_secs_f64());
        let (_, done) = run_time_slice(&part, &mut course, &stop, GIVEN).expect("a flight");
        assert!(done > 0.0 && done < 1.0, "{done}");
    }
}
