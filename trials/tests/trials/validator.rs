//! Tests of the validator itself: correct methods pass all claims, and methods with a planted fault
//! fail.

use std::f64::consts::PI;

use nalgebra::{Vector2, vector};
use rand::RngExt;
use stosszahl_analysis::relaxation::unbiased_cumulant;
use stosszahl_analysis::windows::CollisionWindows;
use stosszahl_model::random::{Purpose, Stream, Streams};
use stosszahl_model::{Collision, Observer, Vector as _, equation_of_state};
use stosszahl_trials::table::{RowVerdict, TrialTableRow};
use stosszahl_trials::validate::subject::{
    ClaimEffort, CollisionMethod, ExactDynamics, GasCourse, ObservedGas, claims,
};
use stosszahl_trials::{Effort, TrialError, TrialLog};

/// Work with enough seeds for errors below half of every tolerance, as in the quick validation.
const QUICK: ClaimEffort = ClaimEffort {
    elastic: (1000, 40),
    cooling: (400, 1000),
};

/// Wrapped method with a collision rate 2 % too high, by a clock that is slow.
struct Hasty<S>(S);

impl<S: CollisionMethod> CollisionMethod for Hasty<S> {
    fn table_name(&self) -> String {
        format!("hasty {}", self.0.table_name())
    }

    fn follow_gas(&self, gas: &ObservedGas, seed: u64) -> Result<GasCourse, TrialError> {
        let times = gas.times.iter().map(|time| 1.02 * time).collect();
        let gas = ObservedGas {
            times,
            ..gas.clone()
        };
        let mut course = self.0.follow_gas(&gas, seed)?;
        course.window.root_temperature /= 1.02;
        Ok(course)
    }
}

/// Disks without positions, with Bird's acceptance-rejection of random pairs. The rule of
/// acceptance is `accept(g/g_max, u)` for a uniform u.
struct Pairs {
    name: &'static str,
    accept: fn(f64, f64) -> bool,
}

/// Correct rule: the chance of acceptance is in proportion to the relative speed.
const RIGHT: Pairs = Pairs {
    name: "pairs",
    accept: |ratio, uniform| ratio > uniform,
};
/// Reversed rule, as Luding, Müller & McNamara (1998) print it.
const REVERSED: Pairs = Pairs {
    name: "reversed pairs",
    accept: |ratio, uniform| ratio < uniform,
};

impl Pairs {
    /// Draws Maxwellian velocities of momentum zero and T = 1 exactly.
    fn velocities(count: usize, stream: &mut Stream) -> Vec<Vector2<f64>> {
        let mut all: Vec<Vector2<f64>> = (0..count)
            .map(|_| {
                let radius = (-2.0 * (1.0 - stream.random::<f64>()).ln()).sqrt();
                let angle = 2.0 * PI * stream.random::<f64>();
                radius * vector![angle.cos(), angle.sin()]
            })
            .collect();
        let mean = all.iter().sum::<Vector2<f64>>() / count as f64;
        for velocity in &mut all {
            *velocity -= mean;
        }
        let scale = temperature(&all).sqrt();
        for velocity in &mut all {
            *velocity /= scale;
        }
        all
    }
}

fn temperature(all: &[Vector2<f64>]) -> f64 {
    all.iter().map(Vector2::norm_squared).sum::<f64>() / (2.0 * all.len() as f64)
}

fn cumulant(all: &[Vector2<f64>]) -> f64 {
    let fourth = all.iter().map(|v| v.norm_squared().powi(2)).sum::<f64>() / all.len() as f64;
    unbiased_cumulant(fourth / (8.0 * temperature(all).powi(2)) - 1.0, all.len())
}

impl CollisionMethod for Pairs {
    fn table_name(&self) -> String {
        self.name.into()
    }

    fn follow_gas(&self, gas: &ObservedGas, seed: u64) -> Result<GasCourse, TrialError> {
        let streams = Streams::new(seed, 7);
        let stream = &mut streams.stream_at(Purpose::Pairs, [0, 0]);
        let count = gas.disks;
        let mut all = Self::velocities(count, stream);
        let volume = count as f64 * 0.25 * PI / gas.packing;
        let chi = equation_of_state::contact_value(gas.packing);
        let end = gas.times[gas.times.len() - 1];
        let mut windows = CollisionWindows::new(&[[0.0, end]], 20, count, 0.0, 1.0);
        let (mut temperatures, mut cumulants, mut time) = (Vec::new(), Vec::new(), 0.0);
        for &until in &gas.times {
            while time < until {
                // Majorant of the relative speed: three times the largest speed. A sum of two
                // speeds is at most twice the largest, and a single collision may make a faster
                // particle.
                let fastest = all.iter().map(Vector2::norm_squared).fold(0.0, f64::max);
                let bound = 3.0 * fastest.sqrt();
                let trials = 0.5 * (count * (count - 1)) as f64 * 2.0 * chi * bound / volume;
                // Step in which a hundredth of the particles collide at most, so that bound and T
                // hardly change.
                let step = (0.01 * count as f64 / trials).min(until - time);
                let whole = (trials * step + stream.random::<f64>()) as u64;
                time = if time + step < until {
                    time + step
                } else {
                    until
                };
                for _ in 0..whole {
                    let i = stream.random_range(0..count);
                    let j = (i + stream.random_range(1..count)) % count;
                    let relative = all[i] - all[j];
                    let speed = relative.norm();
                    if !(self.accept)(speed / bound, stream.random()) || speed == 0.0 {
                        continue;
                    }
                    let impact = 2.0 * stream.random::<f64>() - 1.0;
                    let along = relative / speed;
                    let across = vector![-along[1], along[0]];
                    let line = -along * (1.0 - impact * impact).sqrt() + across * impact;
                    let gain = 0.5 * (1.0 + gas.restitution) * relative.dot(&line) * line;
                    all[i] -= gain;
                    all[j] += gain;
                    let collision = Collision {
                        // Half a step back, because the end of the window is excluded.
                        time: time - 0.5 * step,
                        pair: [i as u32, j as u32],
                        ..Collision::at_contact(
                            relative.spatial(),
                            line.spatial(),
                            0.5,
                            gas.restitution,
                        )
                    };
                    windows.on_collisions(&[collision]);
                }
            }
            windows.synchronise(until, temperature(&all));
            temperatures.push(temperature(&all));
            cumulants.push(cumulant(&all));
        }
        Ok(GasCourse {
            temperatures,
            cumulants,
            window: windows.windows.swap_remove(0),
        })
    }
}

/// Runs all claims on a subject.
fn rows(subject: &dyn CollisionMethod, work: ClaimEffort) -> Vec<TrialTableRow> {
    let mut findings = TrialLog::new("claims", Effort::default());
    claims(subject, work, &mut findings).expect("rows");
    findings.rows().to_vec()
}

/// Formats the rows that do not pass.
fn faults(rows: &[TrialTableRow]) -> Vec<String> {
    let bad = rows.iter().filter(|row| row.verdict != RowVerdict::Pass);
    bad.map(|row| format!("{row:?}")).collect()
}

/// Returns the verdict on a quantity.
fn verdict(rows: &[TrialTableRow], quantity: &str) -> RowVerdict {
    let mut found = rows.iter().filter(|row| row.quantity.starts_with(quantity));
    found.next().expect("a row of this quantity").verdict
}

/// The subjects that `stosszahl-trials validate` has are tested there.
#[test]
fn right_pairs_pass_every_claim() {
    assert_eq!(faults(&rows(&RIGHT, QUICK)), [""; 0]);
}

/// A rate that is 2 % too high fails the collision rate and the energy of the cooling gas, but not
/// `<g²>`.
#[test]
fn a_biased_rate_is_caught() {
    for rows in [
        rows(&Hasty(ExactDynamics), QUICK),
        rows(&Hasty(RIGHT), QUICK),
    ] {
        assert_eq!(
            verdict(&rows, "collision rate"),
            RowVerdict::Fail,
            "{rows:?}"
        );
        assert_eq!(
            verdict(&rows, "K/Haff at t/t0 = 3"),
            RowVerdict::Fail,
            "{rows:?}"
        );
        assert_eq!(verdict(&rows, "<g²>"), RowVerdict::Pass, "{rows:?}");
    }
}

/// A reversed acceptance fails the collision rate, the speed of colliding pairs, and the cooling.
#[test]
fn a_reversed_acceptance_is_caught() {
    let rows = rows(&REVERSED, QUICK);
    for quantity in ["collision rate", "<g²>", "K/Haff at t/t0 = 1", "a2 at"] {
        assert_eq!(
            verdict(&rows, quantity),
            RowVerdict::Fail,
            "{quantity}: {rows:?}"
        );
    }
    assert_eq!(
        verdict(&rows, "slope of P(b/d)"),
        RowVerdict::Pass,
        "{rows:?}"
    );
}
