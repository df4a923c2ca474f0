//! What the tables of a flow say, in words.

use stosszahl_analysis::compare::{self, Verdict as Test};
use stosszahl_model::walls::Obstacle;

use super::case::FaceName;
use super::channel::Channel;
use super::export::{Tables, Window, granular_temperature, over, spin_temperature, total};
use super::obstacles;
use super::plan::Plan;
use super::run::{Record, Replica, Sample};
use super::tables::{FieldRow, ProfileRow, SeriesRow};
use super::theory::{Theory, keeps_energy};
use crate::manifest::{Verdict, VerdictKind};
use crate::verdicts::with_error;

/// Largest relative change of an energy that is kept.
const KEPT: f64 = 1e-10;

/// Standard errors within which a number agrees.
const WITHIN: f64 = 3.0;

/// Everything, most important first.
pub fn verdicts(
    plan: &Plan,
    theory: &Theory,
    replicas: &[Replica],
    tables: &Tables,
) -> Vec<Verdict> {
    let mut list = Vec::new();
    list.push(steadiness(plan, tables));
    if plan.engines().len() == 2 {
        list.extend(engines_agree(plan, replicas));
        list.extend(profiles_agree(tables));
    }
    for (index, engine) in plan.engines().into_iter().enumerate() {
        let runs: Vec<&Record> = replicas.iter().map(|r| &r.engines[index]).collect();
        let said = Said {
            plan,
            engine,
            tables,
            window: tables.windows.last(),
        };
        list.extend(said.energy(&runs));
        list.extend(said.cooling(theory));
        list.extend(said.column(theory, &runs));
        list.extend(said.walls(theory));
        list.extend(said.channel());
        list.extend(said.drag());
        list.extend(said.balance(&runs));
    }
    list
}

/// How an engine is called.
fn title(engine: &str) -> &'static str {
    if engine == "ed" { "ED" } else { "DSMC" }
}

fn percent(found: f64, expected: f64) -> String {
    format!("{:+.2} %", 100.0 * (found / expected - 1.0))
}

fn steadiness(plan: &Plan, tables: &Tables) -> Verdict {
    let words: Vec<String> = tables
        .steady_from
        .iter()
        .map(|(engine, from)| match from {
            Some(time) => format!("{} is steady from t = {time:.3} on", title(engine)),
            None => format!("{} is not steady by the end", title(engine)),
        })
        .collect();
    let unsteady = tables.steady_from.iter().any(|(_, from)| from.is_none());
    let used = tables.windows.last().map_or_else(String::new, |window| {
        format!(
            " Fields and profiles are averages from t = {:.4} to {:.4}.",
            window.times[0], window.times[1]
        )
    });
    Verdict {
        topic: "steady state".into(),
        sentence: format!(
            "{} (marginal standard error rule; run to t = {}).{used}",
            words.join("; "),
            plan.flow.run.until
        ),
        kind: if unsteady {
            VerdictKind::Warning
        } else {
            VerdictKind::Agree
        },
    }
}

/// Temperatures of the two engines at a dozen times.
fn engines_agree(plan: &Plan, replicas: &[Replica]) -> Vec<Verdict> {
    const TIMES: u64 = 12;
    let freedom = plan.freedom();
    let samples = plan.flow.run.samples;
    let chosen: Vec<usize> = (1..=TIMES.min(samples))
        .map(|part| (samples * part / TIMES.min(samples)) as usize)
        .collect();
    let test = |topic: &str, of: &dyn Fn(&Sample) -> f64| {
        let pairs: Vec<Vec<(f64, f64)>> = chosen
            .iter()
            .map(|&sample| {
                let at =
                    |replica: &Replica, engine: usize| of(&replica.engines[engine].series[sample]);
                (replicas.iter())
                    .map(|replica| (at(replica, 0), at(replica, 1)))
                    .collect()
            })
            .collect();
        if pairs.iter().flatten().any(|&(a, b)| a <= 0.0 || b <= 0.0) {
            return None;
        }
        let found = compare::quotients(&pairs, plan.flow.verdict.false_alarm);
        let differ = found
            .iter()
            .any(|one| matches!(one.verdict, Test::Higher | Test::Lower));
        let agree = found.iter().all(|one| one.verdict == Test::Agree);
        let last = found.last()?;
        let quotient = with_error(last.quotient.value, last.quotient.standard_error);
        Some(Verdict {
            topic: format!("{topic}, ED against DSMC"),
            sentence: format!(
                "At the end the quotient is {quotient}; over {} times it {} (paired t tests over {} replicas, chance of any false alarm {}).",
                chosen.len(),
                if differ {
                    "departs from one"
                } else if agree {
                    "is one within the errors"
                } else {
                    "is not known well enough"
                },
                replicas.len(),
                plan.flow.verdict.false_alarm
            ),
            kind: if differ {
                VerdictKind::Differ
            } else if agree {
                VerdictKind::Agree
            } else {
                VerdictKind::Undecided
            },
        })
    };
    let translation = test("temperature", &|sample| {
        granular_temperature(&total(&sample.species), freedom.dimension)
    });
    let rotation = (freedom.rotations > 0).then(|| {
        test("temperature of rotation", &|sample| {
            spin_temperature(&total(&sample.species), freedom.rotations)
        })
    });
    translation.into_iter().chain(rotation.flatten()).collect()
}

/// Largest difference of the density profiles of two engines in the last window.
fn profiles_agree(tables: &Tables) -> Option<Verdict> {
    let last = tables.windows.last()?;
    let rows = |engine: &str| -> Vec<&ProfileRow> {
        let all = tables.profiles.iter();
        all.filter(|row| {
            row.engine == engine
                && row.species == "all"
                && row.window_start == last.times[0]
                && row.window_end == last.times[1]
        })
        .collect()
    };
    let (ed, dsmc) = (rows("ed"), rows("dsmc"));
    let (mut worst, mut places) = (None::<(f64, &ProfileRow, f64)>, 0);
    for (a, b) in ed.iter().zip(&dsmc) {
        let (Some(x), Some(y)) = (a.number_density_se, b.number_density_se) else {
            continue;
        };
        let error = x.hypot(y);
        if error > 0.0 {
            places += 1;
            let z = (a.number_density - b.number_density) / error;
            if worst.is_none_or(|(most, _, _)| z.abs() > f64::abs(most)) {
                worst = Some((z, a, b.number_density));
            }
        }
    }
    let (z, row, other) = worst?;
    // The largest of so many independent normal numbers, at a chance of 1 %.
    let limit = (2.0 * (f64::from(places) / 0.01).ln()).sqrt();
    Some(Verdict {
        topic: "density profile, ED against DSMC".into(),
        sentence: format!(
            "The largest difference is at {} = {:.3}: {:.4} (ED) against {other:.4}, {z:+.1} standard errors of {places} places (limit {limit:.1}).",
            row.along, row.at, row.number_density
        ),
        kind: if z.abs() > limit {
            VerdictKind::Differ
        } else {
            VerdictKind::Agree
        },
    })
}

/// What is said of one engine.
struct Said<'a> {
    plan: &'a Plan,
    engine: &'static str,
    tables: &'a Tables,
    window: Option<&'a Window>,
}

impl Said<'_> {
    fn series(&self) -> impl Iterator<Item = &SeriesRow> {
        (self.tables.series.iter()).filter(|row| row.engine == self.engine)
    }

    fn topic(&self, what: &str) -> String {
        format!("{what}, {}", title(self.engine))
    }

    /// Rows of the last window.
    fn profile(&self, along: &str) -> Vec<&ProfileRow> {
        let Some(window) = self.window else {
            return Vec::new();
        };
        let rows = self.tables.profiles.iter();
        rows.filter(|row| {
            row.engine == self.engine
                && row.species == "all"
                && row.along == along
                && row.window_start == window.times[0]
                && row.window_end == window.times[1]
        })
        .collect()
    }

    fn fields(&self) -> Vec<&FieldRow> {
        let Some(window) = self.window else {
            return Vec::new();
        };
        let rows = self.tables.fields.iter();
        rows.filter(|row| {
            row.engine == self.engine
                && row.window_start == window.times[0]
                && row.window_end == window.times[1]
        })
        .collect()
    }

    /// Whether an elastic gas in a closed box keeps its energy.
    fn energy(&self, runs: &[&Record]) -> Option<Verdict> {
        if !keeps_energy(&self.plan.flow) {
            return None;
        }
        let mut worst = 0.0_f64;
        for run in runs {
            let energies = run.series.iter().map(|sample| {
                let all = total(&sample.species);
                (
                    all.translation + all.rotation + sample.potential,
                    all.translation + all.rotation,
                )
            });
            let energies: Vec<_> = energies.collect();
            let (first, scale) = *energies.first()?;
            for (energy, _) in energies {
                worst = worst.max((energy - first).abs() / scale.max(first.abs()));
            }
        }
        Some(Verdict {
            topic: self.topic("energy"),
            sentence: format!(
                "The energy{} is kept to {worst:.1e} of itself (limit {KEPT:.0e}).",
                if self.plan.flow.gravity.is_some() {
                    ", with that of height,"
                } else {
                    ""
                }
            ),
            kind: if worst <= KEPT {
                VerdictKind::Agree
            } else {
                VerdictKind::Differ
            },
        })
    }

    /// Temperatures of a homogeneous gas of rough grains against theory.
    fn cooling(&self, theory: &Theory) -> Option<Verdict> {
        if !theory.cools() {
            return None;
        }
        let mut worst: [(f64, f64); 2] = [(0.0, 0.0); 2];
        for row in self.series() {
            let found = [Some(row.temperature), row.spin_temperature];
            let expected = [row.theory_temperature, row.theory_spin_temperature];
            for (worst, (found, expected)) in worst.iter_mut().zip(found.iter().zip(expected)) {
                if let (Some(found), Some(expected)) = (found, expected)
                    && expected > 0.0
                {
                    let off = found / expected - 1.0;
                    if off.abs() > worst.0.abs() {
                        *worst = (off, row.time);
                    }
                }
            }
        }
        let good = worst.iter().all(|(off, _)| off.abs() <= 0.02);
        Some(Verdict {
            topic: self.topic("two-temperature theory"),
            sentence: format!(
                "The largest deviation from theory is {:+.2} % in the temperature of translation (t = {:.3}) and {:+.2} % in that of rotation (t = {:.3}); theory is that of a homogeneous gas.",
                100.0 * worst[0].0,
                worst[0].1,
                100.0 * worst[1].0,
                worst[1].1
            ),
            kind: if good {
                VerdictKind::Agree
            } else {
                VerdictKind::Differ
            },
        })
    }

    /// A column that has settled.
    fn column(&self, theory: &Theory, runs: &[&Record]) -> Vec<Verdict> {
        let (Some(column), Some(window)) = (theory.column(), self.window) else {
            return Vec::new();
        };
        let freedom = self.plan.freedom();
        let within =
            |sample: &&Sample| sample.time > window.times[0] && sample.time <= window.times[1];
        let (temperature, error) = over(runs.iter().map(|run| {
            let inside: Vec<&Sample> = run.series.iter().filter(within).collect();
            let sum: f64 = inside
                .iter()
                .map(|s| granular_temperature(&total(&s.species), freedom.dimension))
                .sum();
            sum / inside.len().max(1) as f64
        }));
        let expected = column.temperature();
        let start = self.plan.flow.start.temperature;
        let mut list = vec![Verdict {
            topic: self.topic("settled column"),
            sentence: format!(
                "The temperature is {} times that of the start; theory says {:.4} ({}).",
                with_error(temperature / start, error.map(|e| e / start)),
                expected / start,
                percent(temperature, expected)
            ),
            kind: if (temperature / expected - 1.0).abs() <= 0.01 {
                VerdictKind::Agree
            } else {
                VerdictKind::Differ
            },
        }];
        let rows = self.tables.profiles.iter().filter(|row| {
            row.engine == self.engine
                && row.along == "y"
                && row.window_start == window.times[0]
                && row.window_end == window.times[1]
        });
        let (mut worst, mut squares, mut count) = ((0.0_f64, 0.0), 0.0, 0.0);
        for row in rows {
            if let Some(expected) = row.theory_number_density {
                let off = row.number_density / expected - 1.0;
                squares += off * off;
                count += 1.0;
                if off.abs() > worst.0.abs() {
                    worst = (off, row.at);
                }
            }
        }
        if count > 0.0 {
            let typical = (squares / count).sqrt();
            list.push(Verdict {
                topic: self.topic("barometric profile"),
                sentence: format!(
                    "The density of the layers differs from the barometric one by {:.2} % (root mean square; at most {:+.2} %, at height {:.3}).",
                    100.0 * typical, 100.0 * worst.0, worst.1
                ),
                kind: if typical <= 0.01 {
                    VerdictKind::Agree
                } else {
                    VerdictKind::Differ
                },
            });
        }
        list.extend(self.overshoot(runs, window));
        list
    }

    /// Whether the centre of mass falls lower than where it comes to rest: the energy of height has a minimum.
    fn overshoot(&self, runs: &[&Record], window: &Window) -> Option<Verdict> {
        let samples = runs.iter().map(|run| run.series.len()).min()?;
        let mean = |index: usize| over(runs.iter().map(|run| run.series[index].potential));
        let lowest = (0..samples).min_by(|&a, &b| mean(a).0.total_cmp(&mean(b).0))?;
        let time = runs[0].series[lowest].time;
        let (steady, steady_error) = over(runs.iter().map(|run| {
            let inside: Vec<f64> = (run.series.iter())
                .filter(|sample| sample.time > window.times[0])
                .map(|sample| sample.potential)
                .collect();
            inside.iter().sum::<f64>() / inside.len().max(1) as f64
        }));
        let (least, least_error) = mean(lowest);
        let rate = self.plan.collision_rate();
        let fall = runs[0].series[0].potential - steady;
        let depth = (steady - least) / fall;
        let error = steady_error
            .zip(least_error)
            .map(|(a, b)| a.hypot(b) / fall.abs());
        let seen = error.is_some_and(|error| depth > WITHIN * error);
        Some(Verdict {
            topic: self.topic("overshoot"),
            sentence: format!(
                "The centre of mass is lowest at t = {time:.3}, {:.1} mean collision times after the release: it falls {} further than where it comes to rest, in units of the whole fall{}.",
                time * rate,
                with_error(depth, error),
                if seen {
                    ""
                } else {
                    "; that is no more than noise"
                }
            ),
            kind: if seen {
                VerdictKind::Agree
            } else {
                VerdictKind::Undecided
            },
        })
    }

    /// An elastic gas between walls of one temperature.
    fn walls(&self, theory: &Theory) -> Option<Verdict> {
        let expected = theory.wall_temperature()?;
        let rows = self.profile("y");
        let number: f64 = rows.iter().map(|row| row.number_density).sum();
        let mean = |of: &dyn Fn(&ProfileRow) -> f64| {
            rows.iter()
                .map(|row| row.number_density * of(row))
                .sum::<f64>()
                / number
        };
        let error = |of: &dyn Fn(&ProfileRow) -> Option<f64>| {
            let sum: Option<f64> = rows
                .iter()
                .map(|row| of(row).map(|e| (row.number_density * e).powi(2)))
                .sum();
            sum.map(|sum| sum.sqrt() / number)
        };
        let temperature = mean(&|row| row.temperature);
        let temperature_error = error(&|row| row.temperature_se);
        let drift = mean(&|row| row.velocity_x);
        let drift_error = error(&|row| row.velocity_x_se);
        let thermal = (expected / self.plan.kinds[0].mass).sqrt();
        let good = (temperature / expected - 1.0).abs() <= 0.01 && drift.abs() <= 0.01 * thermal;
        Some(Verdict {
            topic: self.topic("thermal walls"),
            sentence: format!(
                "The gas has {} times the temperature of its walls, and moves along them at {} thermal speeds (both to be known to 1 %).",
                with_error(
                    temperature / expected,
                    temperature_error.map(|e| e / expected)
                ),
                with_error(drift / thermal, drift_error.map(|e| e / thermal))
            ),
            kind: if good {
                VerdictKind::Agree
            } else {
                VerdictKind::Differ
            },
        })
    }

    /// A flow from left to right between walls: what happens along its middle, at its walls, and in its two halves.
    fn channel(&self) -> Vec<Verdict> {
        let flow = &self.plan.flow;
        let cells = self.fields();
        Channel::of(flow, &cells).map_or_else(Vec::new, |channel| {
            let said = [channel.along(), channel.walls()]
                .into_iter()
                .map(|(what, sentence)| Verdict {
                    topic: self.topic(what),
                    sentence,
                    kind: VerdictKind::Agree,
                });
            let halves = channel.symmetry().map(|(sentence, holds)| Verdict {
                topic: self.topic("symmetry"),
                sentence,
                kind: if holds {
                    VerdictKind::Agree
                } else {
                    VerdictKind::Differ
                },
            });
            said.chain(halves).collect()
        })
    }

    /// The drag of each obstacle in a stream from the left, and its coefficient F/(rho u^2 h/2) with the height h that it
    /// has across the stream.
    fn drag(&self) -> Vec<Verdict> {
        let flow = &self.plan.flow;
        let Some(inflow) = flow.inflow.iter().find(|one| one.face == FaceName::Left) else {
            return Vec::new();
        };
        let Ok(obstacles) = obstacles::of(flow) else {
            return Vec::new();
        };
        let mass_density: f64 = (self.plan.kinds.iter().enumerate())
            .map(|(species, kind)| {
                let uniform = kind.count as f64 / self.plan.volume;
                let given = inflow.number_density.as_ref();
                kind.mass * given.map_or(uniform, |densities| densities[species])
            })
            .sum();
        let speed = inflow.velocity[0];
        let one = |(index, obstacle): (usize, &Obstacle)| {
            let name = format!("obstacle {}", index + 1);
            let row = (self.tables.boundaries.iter())
                .find(|row| row.engine == self.engine && row.boundary == name)?;
            let [low, high] = obstacle.bounds();
            let scale = 0.5 * mass_density * speed * speed * (high[1] - low[1]);
            let share = |force: f64, error: Option<f64>| {
                with_error(-force / scale, error.map(|error| error / scale))
            };
            Some(Verdict {
                topic: self.topic(&format!("drag of {name}")),
                sentence: format!(
                    "The stream drags it with the force {}, the coefficient of drag is {}, that of lift {}.",
                    with_error(-row.force_x, row.force_x_se),
                    share(row.force_x, row.force_x_se),
                    share(row.force_y, row.force_y_se)
                ),
                kind: VerdictKind::Agree,
            })
        };
        obstacles.iter().enumerate().filter_map(one).collect()
    }

    /// What splitting and merging of simulators added.
    fn balance(&self, runs: &[&Record]) -> Option<Verdict> {
        let last = |run: &&&Record| {
            let ledger = run.ledgers.last()?;
            let entries = ledger.entries.iter();
            entries
                .filter(|entry| entry.name == super::gas::BALANCE)
                .map(|entry| (entry.grains, entry.energy))
                .next()
        };
        let given: Vec<(f64, f64)> = runs.iter().filter_map(|run| last(&run)).collect();
        if given.is_empty() {
            return None;
        }
        let (grains, grains_error) = over(given.iter().map(|pair| pair.0));
        let (energy, energy_error) = over(given.iter().map(|pair| pair.1));
        let fair = |value: f64, error: Option<f64>| {
            error.is_none_or(|error| value.abs() <= WITHIN * error.max(f64::MIN_POSITIVE))
        };
        Some(Verdict {
            topic: self.topic("splitting and merging"),
            sentence: format!(
                "Over the whole run it added {} grains and the energy {}; on average it adds nothing.",
                with_error(grains, grains_error),
                with_error(energy, energy_error)
            ),
            kind: if fair(grains, grains_error) && fair(energy, energy_error) {
                VerdictKind::Agree
            } else {
                VerdictKind::Differ
            },
        })
    }
}
