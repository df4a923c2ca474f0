//! Question of a case: which measurement answers it, and in which table and column the answer is.

use stosszahl_results::{RunQuestion, Table, VerdictText, engine_title};

use crate::measure::Measure;
use crate::plan::{CasePlan, PlanError};

/// Returns the index of the leading measure, whose verdict comes first: the measure that the
/// question names, else the first with a statistical test.
pub(crate) fn leading(plan: &CasePlan, measures: &[&'static dyn Measure]) -> usize {
    let place = |wanted: &dyn Fn(&&&'static dyn Measure) -> bool| {
        let mut all = measures.iter().enumerate();
        all.find(|(_, measure)| wanted(measure)).map(|one| one.0)
    };
    let named = plan.case.question.measure.as_ref();
    let named = named.and_then(|name| place(&|measure| measure.name() == name));
    named
        .or_else(|| place(&|measure| measure.test_count(plan) > 0))
        .unwrap_or(0)
}

/// Names the headline before the run: the leading measure, and the engine of the question.
pub(crate) fn headline(plan: &CasePlan, measures: &[&'static dyn Measure]) -> String {
    let measure = measures.get(leading(plan, measures));
    let measure = measure.map_or("", |measure| measure.name());
    match &plan.case.question.engine {
        Some(engine) => format!("{measure}, {}", engine_title(engine)),
        None => measure.to_owned(),
    }
}

/// Moves the first verdict about the engine of the question to the front.
pub(crate) fn put_first(plan: &CasePlan, verdicts: &mut [VerdictText]) {
    let Some(engine) = &plan.case.question.engine else {
        return;
    };
    let title = engine_title(engine);
    if let Some(place) = (verdicts.iter()).position(|one| one.topic.contains(title)) {
        verdicts[..=place].rotate_right(1);
    }
}

/// Returns the question of a run as text, and the location of its answer among the tables of the
/// leading measure.
pub(crate) fn run_question(plan: &CasePlan, text: Option<String>, tables: &[Table]) -> RunQuestion {
    let wanted = plan.case.question.column.as_deref();
    let drawn = |table: &Table, column: &str| {
        let mut figures = table.figures.iter();
        figures.any(|figure| figure.y.column == column)
    };
    // Tables that compare engines come before tables of single engines.
    let compared = |table: &&Table| table.find_column("engine_b").is_some();
    let mut order: Vec<&Table> = tables.iter().filter(compared).collect();
    order.extend(tables.iter().filter(|table| !compared(table)));
    let found = match wanted {
        Some(column) => {
            let mut with = order
                .iter()
                .filter(|table| table.find_column(column).is_some());
            let first = with.clone().next();
            let table = with.find(|table| drawn(table, column)).or(first);
            table.map(|table| (table.name.to_string(), column.to_owned()))
        }
        None => order.iter().find_map(|table| {
            let figure = table.figures.first()?;
            Some((table.name.to_string(), figure.y.column.to_string()))
        }),
    };
    let (table, column) = found.unwrap_or_default();
    RunQuestion {
        text: text.unwrap_or_default(),
        table,
        column,
    }
}

/// Checks that the measure, engine and column that the question names exist.
///
/// # Errors
/// [`PlanError`] names what is allowed.
pub(crate) fn check_question(
    plan: &CasePlan,
    measures: &[&'static dyn Measure],
    tables: impl FnOnce(usize) -> Vec<Table>,
) -> Result<(), PlanError> {
    let asked = &plan.case.question;
    if let Some(name) = &asked.measure
        && !measures.iter().any(|measure| measure.name() == name)
    {
        let names: Vec<&str> = measures.iter().map(|measure| measure.name()).collect();
        let allowed = format!("a measurement of this case: {}", names.join(", "));
        return Err(PlanError::new("question.measure", name.clone(), allowed));
    }
    if let Some(engine) = &asked.engine
        && !plan.engines.iter().any(|one| one.name == engine)
    {
        let names: Vec<&str> = plan.engines.iter().map(|one| one.name).collect();
        let allowed = format!("an engine of this case: {}", names.join(", "));
        return Err(PlanError::new("question.engine", engine.clone(), allowed));
    }
    let Some(column) = &asked.column else {
        return Ok(());
    };
    let tables = tables(leading(plan, measures));
    if tables
        .iter()
        .any(|table| table.find_column(column).is_some())
    {
        return Ok(());
    }
    let columns = tables.iter().flat_map(|table| &table.columns);
    let mut names: Vec<&str> = columns
        .filter(|column| column.role == stosszahl_results::Role::Value)
        .map(|column| &*column.name)
        .collect();
    names.sort_unstable();
    names.dedup();
    let allowed = format!("a column of its tables: {}", names.join(", "));
    Err(PlanError::new("question.column", column.clone(), allowed))
}
