//! What fields and profiles say.

use stosszahl_case::Kind;
use stosszahl_results::{Cell, Table, Verdict, VerdictKind, engine_title as title};

use super::Options;
use super::channel::Channel;
use crate::measures::course::Window;
use crate::measures::words::{self, with_error};
use crate::plan::{EnginePlan, Plan};
use crate::theory::flow;

/// Largest relative deviation of a profile, a temperature or a drift from theory.
const MARGIN: f64 = 0.01;

/// A number and its standard error.
pub(super) type Measured = (f64, Option<f64>);

/// One row of a table.
#[derive(Clone, Copy)]
pub(super) struct Row<'a> {
    table: &'a Table,
    cells: &'a [Cell],
}

impl Row<'_> {
    pub(super) fn number(&self, column: &str) -> Option<f64> {
        match self.cells.get(self.table.find(column)?)? {
            Cell::Number(number) if number.is_finite() => Some(*number),
            _ => None,
        }
    }

    /// A quantity and its standard error.
    pub(super) fn measured(&self, column: &str) -> Measured {
        let error = self.number(&format!("{column}_se"));
        (self.number(column).unwrap_or(f64::NAN), error)
    }

    fn says(&self, column: &str, word: &str) -> bool {
        let cell = self.table.find(column).and_then(|at| self.cells.get(at));
        matches!(cell, Some(Cell::Text(text)) if text == word)
    }
}

/// Rows of an engine in a window.
fn rows<'a>(
    table: &'a Table,
    engine: &'a EnginePlan,
    window: &'a Window,
) -> impl Iterator<Item = Row<'a>> {
    let all = table.rows.iter().map(|cells| Row { table, cells });
    all.filter(|row| {
        let times = ["window_start", "window_end"].map(|name| row.number(name));
        row.says("engine", engine.name) && times == window.times.map(Some)
    })
}

/// A profile of an engine in the last window.
fn profile<'a>(
    table: &'a Table,
    engine: &'a EnginePlan,
    window: &'a Window,
    along: Option<&str>,
) -> Vec<Row<'a>> {
    rows(table, engine, window)
        .filter(|row| along.is_none_or(|axis| row.says("along", axis)))
        .collect()
}

/// All of them, the most important first.
pub(super) fn all(
    plan: &Plan,
    options: &Options,
    steady: &[Option<f64>],
    window: &Window,
    tables: &[Table],
) -> Vec<Verdict> {
    let [cells, profiles] = tables else {
        return Vec::new();
    };
    let mut list = vec![steadiness(plan, steady, window)];
    for other in plan.engines.iter().skip(1) {
        let engines = [&plan.engines[0], other];
        list.extend(profiles_agree(plan, profiles, engines, window));
    }
    for engine in &plan.engines {
        list.extend(barometric(plan, profiles, engine, window));
        list.extend(walls(plan, profiles, engine, window));
        let cells: Vec<Row<'_>> = rows(cells, engine, window).collect();
        let about = |what: &str| format!("{what}, {}", title(engine.name));
        if let Some(channel) = Channel::of(plan, options, &cells, parts(plan, window)) {
            list.extend(channel.verdicts().map(|one| Verdict {
                topic: about(&one.topic),
                ..one
            }));
        }
    }
    list
}

/// How many blocks of all replicas an average of one engine runs over.
fn parts(plan: &Plan, window: &Window) -> usize {
    window.blocks.len() * plan.case.replicas as usize
}

fn steadiness(plan: &Plan, steady: &[Option<f64>], window: &Window) -> Verdict {
    let until = plan.case.run.until;
    let words = plan.engines.iter().zip(steady).map(|(engine, from)| {
        let name = title(engine.name);
        match from {
            Some(time) => format!("{name} is steady from t = {time:.3} on"),
            None => format!("{name} is not steady by t = {until}"),
        }
    });
    let words: Vec<String> = words.collect();
    let [start, end] = window.times;
    Verdict {
        topic: "steady state".into(),
        sentence: format!(
            "{} (marginal standard error rule). Fields and profiles are averages from t = {start:.4} to {end:.4}.",
            words.join("; ")
        ),
        kind: match plan.kind {
            Kind::Flow if !window.steady => VerdictKind::Warning,
            _ => VerdictKind::Note,
        },
    }
}

/// Largest difference of the density profiles of two engines.
fn profiles_agree(
    plan: &Plan,
    profiles: &Table,
    engines: [&EnginePlan; 2],
    window: &Window,
) -> Option<Verdict> {
    let [first, second] = engines.map(|engine| {
        let rows = profile(profiles, engine, window, None).into_iter();
        rows.filter(|row| row.says("species", "all"))
            .collect::<Vec<_>>()
    });
    let topic = {
        let [a, b] = engines.map(|engine| title(engine.name));
        format!("density profile, {a} against {b}")
    };
    let (mut worst, mut places) = (None::<(f64, &Row<'_>, f64)>, 0_u32);
    for (a, b) in first.iter().zip(&second) {
        let [(x, Some(x_error)), (y, Some(y_error))] =
            [a, b].map(|row| row.measured("number_density"))
        else {
            continue;
        };
        let error = x_error.hypot(y_error);
        if error > 0.0 {
            places += 1;
            let z = (x - y) / error;
            if worst.is_none_or(|(most, _, _)| z.abs() > f64::abs(most)) {
                worst = Some((z, a, y));
            }
        }
    }
    let Some((z, row, other)) = worst else {
        return (first.len() > 2).then(|| Verdict {
            topic,
            sentence: "Errors of the profiles are unknown, so they are not compared.".into(),
            kind: VerdictKind::Note,
        });
    };
    // The largest of so many independent normal numbers, at the chance of a false alarm.
    let limit = (2.0 * (f64::from(places) / plan.case.verdict.false_alarm).ln()).sqrt();
    let axis = if row.says("along", "x") { "x" } else { "y" };
    let number = |column| row.number(column).unwrap_or(f64::NAN);
    Some(Verdict {
        topic,
        sentence: format!(
            "The largest difference is at {axis} = {:.3}: {:.4} against {other:.4}, {z:+.1} standard errors among {places} places (limit {limit:.1}{}).",
            number("at"),
            number("number_density"),
            words::from_parts(parts(plan, window)),
        ),
        kind: words::test(z.abs() <= limit, parts(plan, window)),
    })
}

/// The profile of a settled column.
fn barometric(
    plan: &Plan,
    profiles: &Table,
    engine: &EnginePlan,
    window: &Window,
) -> Option<Verdict> {
    let (mut worst, mut squares, mut noise, mut count) = ((0.0_f64, 0.0), 0.0, Some(0.0), 0.0);
    for row in profile(profiles, engine, window, Some("y")) {
        let (found, error) = row.measured("number_density");
        if let Some(expected) = row.number("theory_number_density") {
            let off = found / expected - 1.0;
            squares += off * off;
            count += 1.0;
            noise = noise
                .zip(error)
                .map(|(sum, error)| sum + (error / expected).powi(2));
            if off.abs() > worst.0.abs() {
                worst = (off, row.number("at").unwrap_or(f64::NAN));
            }
        }
    }
    if count == 0.0 || plan.grains.gravity.is_none() {
        return None;
    }
    let typical: f64 = squares / count;
    let (typical, noise) = (typical.sqrt(), noise.map(|sum: f64| (sum / count).sqrt()));
    let expected = noise.map_or_else(|| "unknown".to_owned(), |n| format!("{:.2} %", 100.0 * n));
    Some(Verdict {
        topic: format!("barometric profile, {}", title(engine.name)),
        sentence: format!(
            "The density of the layers differs from the barometric one by {:.2} % (root mean square, margin {} %, standard error of a layer {expected}; at most {:+.2} %, at height {:.3}).",
            100.0 * typical,
            100.0 * MARGIN,
            100.0 * worst.0,
            worst.1
        ),
        kind: words::within(typical, noise, MARGIN),
    })
}

/// An elastic gas between walls of one temperature.
fn walls(plan: &Plan, profiles: &Table, engine: &EnginePlan, window: &Window) -> Option<Verdict> {
    let expected = flow::wall_temperature(plan)?;
    let rows = profile(profiles, engine, window, Some("y"));
    let rows: Vec<_> = rows
        .iter()
        .filter(|row| row.says("species", "all"))
        .collect();
    let density = |row: &Row<'_>| row.number("number_density").unwrap_or(0.0);
    let number: f64 = rows.iter().map(|row| density(row)).sum();
    let mean = |column: &str, unit: f64| {
        let (mut sum, mut square) = (0.0, Some(0.0_f64));
        for row in &rows {
            let (value, error) = row.measured(column);
            sum += density(row) * value;
            square = square
                .zip(error)
                .map(|(sum, error)| sum + (density(row) * error).powi(2));
        }
        let error = square.map(|square| square.sqrt() / number / unit);
        (sum / number / unit, error)
    };
    let (temperature, temperature_error) = mean("temperature", expected * plan.scale.energy);
    let thermal = (expected / plan.species[0].mass).sqrt() * plan.scale.speed();
    let (drift, drift_error) = mean("velocity_x", thermal);
    Some(Verdict {
        topic: format!("thermal walls, {}", title(engine.name)),
        sentence: format!(
            "The gas has {} times the temperature of its walls, and moves along them at {} thermal speeds (margin {MARGIN} for both).",
            with_error(temperature, temperature_error),
            with_error(drift, drift_error)
        ),
        kind: words::worst([
            words::within(temperature - 1.0, temperature_error, MARGIN),
            words::within(drift, drift_error, MARGIN),
        ]),
    })
}
