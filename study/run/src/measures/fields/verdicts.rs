//! Verdicts on fields and profiles: density differences of engines, settled columns, wall
//! temperatures, overcrowding.

use stosszahl_analysis::fields::CellAveraging;
use stosszahl_model::Space as _;
use stosszahl_results::{Table, TableCell, TableEstimate, VerdictText, format_number};

use super::channel::Channel;
use super::view::{DENSITY, SPEED, TEMPERATURE, View};
use crate::judge::{self, DifferenceUnit, VerdictRule, interval_of, kind_of, title};
use crate::measures::energy::void_for;
use crate::measures::fewest_parts;
use crate::measures::time_blocks::TimeBlocks;
use crate::plan::{CasePlan, EnginePlan, in_space};
use crate::theory::flow;

/// Number of standard errors by which a packing fraction must exceed the closest packing before a
/// warning is given.
const SURE: f64 = 4.0;

/// Row of a table of fields or profiles, with access by column name.
#[derive(Clone, Copy)]
struct Row<'a> {
    table: &'a Table,
    cells: &'a [TableCell],
}

impl Row<'_> {
    fn number(&self, column: &str) -> Option<f64> {
        match self.cells.get(self.table.find_column(column)?)? {
            TableCell::Number(number) if number.is_finite() => Some(*number),
            _ => None,
        }
    }

    /// Returns the quantity in a column of the row, with its standard error.
    fn measured(&self, column: &str) -> TableEstimate {
        let error = self.number(&format!("{column}_se"));
        TableEstimate::with_error(self.number(column).unwrap_or(f64::NAN), error)
    }

    fn says(&self, column: &str, word: &str) -> bool {
        let cell = self
            .table
            .find_column(column)
            .and_then(|at| self.cells.get(at));
        matches!(cell, Some(TableCell::Text(text)) if text == word)
    }
}

/// Returns the rows of a table for one engine and one time window.
fn rows<'a>(table: &'a Table, engine: &EnginePlan, window: &TimeBlocks) -> Vec<Row<'a>> {
    let all = table.rows.iter().map(|cells| Row { table, cells });
    let wanted = |row: &Row<'_>| {
        let times = ["window_start", "window_end"].map(|name| row.number(name));
        row.says("engine", engine.name) && times == window.times.map(Some)
    };
    all.filter(wanted).collect()
}

/// Decides all verdicts on fields, the most important first. `views` are the fields of the engines.
pub(super) fn field_verdicts(
    plan: &CasePlan,
    counts: [usize; 2],
    steady: &[Option<f64>],
    (window, views): (&TimeBlocks, &[View<'_>]),
    tables: &[Table],
    rule: &VerdictRule,
) -> Vec<VerdictText> {
    let [_, profiles, ..] = tables else {
        return Vec::new();
    };
    let mut list = vec![steadiness(plan, steady, window)];
    let profiles = |engine: &EnginePlan| rows(profiles, engine, window);
    // Nothing keeps the particles of Monte Carlo from overlapping; Boltzmann's are points.
    let simulated = plan
        .engines
        .iter()
        .filter(|engine| engine.parameters().is_some());
    let sized = simulated.filter(|engine| !flow::is_dilute(engine));
    list.extend(sized.filter_map(|engine| overcrowding_warning(plan, engine, &profiles(engine))));
    let first = &plan.engines[0];
    // Independent parts behind the densities of each engine.
    let parts: Vec<usize> = views.iter().map(density_parts).collect();
    for (index, other) in plan.engines.iter().skip(1).enumerate() {
        let [a, b] = [first, other].map(|engine| title(engine.name));
        let both = [first, other].map(profiles);
        let parts = parts[0].min(parts[1 + index]);
        let found = profiles_agree([a, b], &both, parts, rule);
        list.extend(found.map(|found| void_for(found, plan, &[first, other])));
    }
    for ((engine, view), &parts) in plan.engines.iter().zip(views).zip(&parts) {
        let about = |what: &str| format!("{what}, {}", title(engine.name));
        let all = profiles(engine).into_iter();
        let along: Vec<Row<'_>> = all.filter(|row| row.says("along", "y")).collect();
        let topic = about("barometric profile");
        list.extend(barometric(plan, engine, &topic, &along, parts, rule));
        let cells: Vec<usize> = (0..counts[0] * counts[1]).collect();
        let mean = |quantity| view.mean(&cells, quantity);
        let about_walls = about("thermal walls");
        list.extend(walls(
            plan,
            about_walls,
            mean(TEMPERATURE),
            mean(SPEED),
            rule,
        ));
        if let Some(channel) = Channel::from_plan(plan, view, counts, rule) {
            list.extend(channel.verdicts(about));
        }
    }
    list
}

/// Returns the number of independent parts of the runs behind the standard errors of an engine's
/// density profiles.
fn density_parts(view: &View<'_>) -> usize {
    let along = |along| {
        let places = view.fields(None, along);
        fewest_parts(places.iter().map(|place| &place[DENSITY]))
    };
    along(CellAveraging::X).min(along(CellAveraging::Y))
}

fn steadiness(plan: &CasePlan, steady: &[Option<f64>], window: &TimeBlocks) -> VerdictText {
    let until = plan.case.run.until;
    let words = plan.engines.iter().zip(steady).map(|(engine, from)| {
        let name = title(engine.name);
        match from {
            Some(time) => format!("{name} is steady from t = {} on", format_number(*time)),
            None => format!("{name} is not steady by t = {until}"),
        }
    });
    let words: Vec<String> = words.collect();
    let [start, end] = window.times;
    let sentence = format!(
        "{} (marginal standard error rule). Fields and profiles are averages from t = {} to {}.",
        words.join("; "),
        format_number(start),
        format_number(end)
    );
    // A uniform gas that cools has no steady state to wait for.
    if window.steady || plan.is_uniform() {
        judge::verdict_note("steady state", sentence)
    } else {
        judge::warning("steady state", sentence)
    }
}

/// Creates the warning that an engine packs particles more closely than the closest packing, with
/// the position; `None` if it does not.
fn overcrowding_warning(
    plan: &CasePlan,
    engine: &EnginePlan,
    rows: &[Row<'_>],
) -> Option<VerdictText> {
    let closest = plan.closest_packing();
    let of = |species: &str| -> Vec<&Row<'_>> {
        rows.iter()
            .filter(|row| row.says("species", species))
            .collect()
    };
    let unit = plan.scale.length.powi(plan.gas.dimension as i32);
    // Each species has the same places as all together, which are the only rows of a gas of one.
    let (places, alone) = (of("all"), plan.gas.species.len() == 1);
    let solid = plan.gas.species.iter().filter(|kind| !kind.tracer);
    let kinds: Vec<_> = solid
        .map(|kind| {
            let volume = unit * in_space!(plan.gas.dimension, S => S::particle_volume(kind.radius));
            (volume, of(if alone { "all" } else { &kind.name }))
        })
        .collect();
    let surely_denser = |place: usize| {
        let (mut packing, mut square) = (0.0, 0.0);
        for (volume, rows) in &kinds {
            let density = rows.get(place)?.measured("number_density");
            packing += volume * density.value?;
            square += (volume * density.standard_error?).powi(2);
        }
        (packing - SURE * square.sqrt() > closest).then_some((packing, places[place]))
    };
    let all = (0..places.len()).filter_map(surely_denser);
    let (packing, row) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let name = title(engine.name);
    let sentence = format!(
        "{name} packs particles closer than they can lie: their packing fraction is {} at {}, and at most {} is possible. Its particles \
         collide and do not touch, so a bed that comes to rest sinks into itself, and its profiles there are not those of hard particles.",
        format_number(packing),
        place_text(row),
        format_number(closest),
    );
    Some(judge::warning(format!("packing, {name}"), sentence))
}

/// Formats the position of a row of a profile, such as "x = 3".
fn place_text(row: &Row<'_>) -> String {
    let axis = if row.says("along", "x") { "x" } else { "y" };
    let at = row.number("at").unwrap_or(f64::NAN);
    format!("{axis} = {}", format_number(at))
}

/// Decides the verdict on the difference of the density profiles of two engines. An axis with a
/// single cell is left out: the density of the whole box is fixed.
fn profiles_agree(
    pair: [&str; 2],
    rows: &[Vec<Row<'_>>; 2],
    parts: usize,
    rule: &VerdictRule,
) -> Option<VerdictText> {
    let [first, second] = [0, 1].map(|engine| {
        let all = &rows[engine];
        let along = ["x", "y"].into_iter().flat_map(|axis| {
            let found = (all.iter())
                .filter(|row| row.says("species", "all") && row.says("along", axis))
                .collect::<Vec<_>>();
            if found.len() > 1 { found } else { Vec::new() }
        });
        along.collect::<Vec<_>>()
    });
    let pair_at = |(a, b): (&Row<'_>, &Row<'_>)| {
        let densities = [a, b].map(|row| row.measured("number_density"));
        (densities, place_text(a))
    };
    let places: Vec<_> = first.into_iter().zip(second).map(pair_at).collect();
    let topic = format!("density profile, {} against {}", pair[0], pair[1]);
    let found = judge::profiles(&topic, [pair[0], pair[1], "density"], &places, parts, rule);
    let unknown = "Errors of the profiles are unknown, so they are not compared.";
    found.or_else(|| (places.len() > 2).then(|| judge::verdict_note(topic, unknown)))
}

/// Decides the verdict on the density profile of a column that has settled under gravity, against
/// the barometric profile.
fn barometric(
    plan: &CasePlan,
    engine: &EnginePlan,
    topic: &str,
    rows: &[Row<'_>],
    parts: usize,
    rule: &VerdictRule,
) -> Option<VerdictText> {
    plan.gas.particles.gravity?;
    let layer = |row: &Row<'_>| {
        let theory = TableEstimate::with_error(row.number("number_density_theory")?, Some(0.0));
        Some(([row.measured("number_density"), theory], place_text(row)))
    };
    let layers: Vec<_> = rows.iter().filter_map(layer).collect();
    let words = [title(engine.name), "the barometric law", "density"];
    judge::profiles(topic, words, &layers, parts, rule)
}

/// Decides the verdict on an elastic gas between walls of one temperature: its mean temperature,
/// and its mean velocity along the first axis.
fn walls(
    plan: &CasePlan,
    topic: String,
    temperature: TableEstimate,
    drift: TableEstimate,
    rule: &VerdictRule,
) -> Option<VerdictText> {
    let expected = flow::wall_temperature(plan)?;
    let temperature = temperature.times(1.0 / (expected * plan.scale.energy));
    let thermal = (expected / plan.gas.species[0].mass).sqrt() * plan.scale.speed();
    let drift = drift.times(1.0 / thermal);
    let half = rule.at_level(0.5 * rule.level);
    let off = |found: TableEstimate, expected: f64| {
        let off = TableEstimate {
            value: found.value.map(|value| value - expected),
            ..found
        };
        interval_of(&off, half.level)
    };
    let both = [off(temperature, 1.0), off(drift, 0.0)];
    let [hotter, faster] = both.map(|one| DifferenceUnit::Relative.interval(&one));
    let sentence = format!(
        "The gas is hotter than its walls by {hotter}, and moves along them at {faster} of the thermal speed; the margin of both is {}.",
        judge::format_margin(rule.margin)
    );
    let kind = judge::together(both.map(|one| kind_of(one.decide(&half))));
    Some(judge::verdict(topic, sentence, kind))
}

#[cfg(test)]
mod tests {
    use stosszahl_results::VerdictKind;

    use crate::measures::tests::{case, measure, run};

    /// Particles that collide and do not touch pile up in each other where they should rest.
    #[test]
    fn a_bed_that_sinks_into_itself_is_named() {
        let text = r#"
            format = 2
            title = "a bed"
            replicas = 2
            gas = { number = 64, restitution = 0.5 }
            box = { size = [8, 40] }
            walls = { bottom = { restitution = 0.5 }, top = "specular" }
            gravity = { acceleration = [0, GRAVITY] }
            run = { until = 40, samples = 40 }
            engine = { ENGINE = { simulators_per_particle = 4 } }
            measure.fields = { cells = [1, 20], blocks = 20 }
        "#;
        for (engine, gravity, sinks) in [
            ("dsmc-contact-point", "-1", true),
            ("dsmc-contact-point", "-0.001", false),
            // Points may lie as close as they like.
            ("dsmc-boltzmann", "-1", false),
        ] {
            let plan = case(&text.replace("ENGINE", engine).replace("GRAVITY", gravity));
            let (_, verdicts, _) = run(&plan, measure("fields"));
            let named = verdicts
                .iter()
                .find(|one| one.topic.starts_with("packing, "));
            assert_eq!(named.is_some(), sinks, "{engine}, {gravity}: {verdicts:?}");
            if let Some(named) = named {
                assert_eq!(named.kind, VerdictKind::Warning);
                assert!(named.sentence.contains(" at y = "), "{}", named.sentence);
            }
        }
    }
}
