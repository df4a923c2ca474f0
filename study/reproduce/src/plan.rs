//! Selects the runs and claims of a paper, and checks before any run that all named tables, columns
//! and points exist.

use std::collections::{BTreeMap, BTreeSet};

use stosszahl_case::paper::{Claim, PaperFigureSpec, number};
use stosszahl_case::{CaseError, CaseFile, CasePoint, PaperFile};
use stosszahl_results::Table;
use stosszahl_study::check_case;
use stosszahl_study::cost::RuntimeEstimate;
use stosszahl_study::judge::ClaimedValue;
use toml::Value;

use crate::ReproduceError;
use crate::cases::read_case;
use crate::number_location::{COLLISIONS, NumberLocation, NumberSource, SECONDS, same_name};

/// Options of a reproduction: one figure or the whole paper, full or quick runs.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReproduceOptions<'a> {
    /// Name of the figure to reproduce; `None` for the whole paper.
    pub figure: Option<&'a str>,
    /// True if runs are the smaller ones of the paper's quick version.
    pub quick: bool,
}

/// Paper ready to be reproduced: cases read, and the number of each claim located in the result
/// tables.
pub struct Reproduction<'a> {
    pub(crate) file: &'a PaperFile,
    pub(crate) demand: ReproduceOptions<'a>,
    /// Case files of the needed runs, by the name of the run.
    pub(crate) cases: BTreeMap<&'a str, CaseFile>,
    /// Expected results of each point, by the names of the run and the point.
    known: BTreeMap<(&'a str, String), Known>,
    /// Claims of the requested figures, one entry for each number that is compared.
    pub(crate) items: Vec<Item<'a>>,
    /// False-alarm probability of one claim: the paper's family-wise error rate over the number of
    /// tests (Bonferroni).
    pub(crate) level: f64,
}

/// Results that one point of a run is expected to have: tables, quantities and cost.
struct Known {
    /// Result tables of the point, with columns but without rows.
    tables: Vec<Table>,
    /// Names of the quantities derived from the case, with its computing time and number of
    /// collisions.
    derived: Vec<String>,
    /// Estimated computing times of the start and the engines of the point \[s\].
    pace: RuntimeEstimate,
    /// Number of replicas of the sweep point's run.
    replicas: u64,
}

/// Comparison of one number in the results with one value or bound of a claim.
pub(crate) struct Item<'a> {
    /// Index of the figure that the claim belongs to, counted from 0 in the paper.
    pub figure: usize,
    /// Claim of the paper, as its paper file states it.
    pub claim: &'a Claim,
    /// Location of the compared number in the results.
    pub number: NumberLocation<'a>,
    /// Location of the number that the compared number is divided by; `None` without a division.
    pub over: Option<NumberLocation<'a>>,
    /// Value or bound that the claim states for the number.
    pub said: ClaimedValue,
    /// True if the compared value is the corrected one of the paper file, in place of the printed
    /// value.
    pub corrected: bool,
}

/// Estimated cost and number of claims of one figure of a paper.
#[derive(Clone, Debug)]
pub struct FigureOutline<'a> {
    /// Figure of the paper, as its paper file describes it.
    pub figure: &'a PaperFigureSpec,
    /// Number of comparisons that the claims of the figure make.
    pub claims: usize,
    /// Estimated time of all runs that the figure needs \[s\].
    pub seconds: f64,
}

impl Item<'_> {
    /// Returns by which factor the value of the swept key grows between the two points of a claim
    /// on a power law; `None` for other claims.
    pub(crate) fn growth(&self) -> Option<f64> {
        let power = self.claim.power_of.as_deref()?;
        let at = |spot: &NumberLocation<'_>| spot.keys.get(power).and_then(number);
        Some(at(&self.number)? / at(self.over.as_ref()?)?)
    }
}

impl<'a> Reproduction<'a> {
    /// Reads the case files that a paper needs and checks that all named tables, columns and points
    /// exist. `bundled` returns the text of a bundled case.
    ///
    /// # Errors
    /// The paper or a case is refused, or there is no such figure.
    pub fn new(
        file: &'a PaperFile,
        demand: ReproduceOptions<'a>,
        bundled: &dyn Fn(&str) -> Option<String>,
    ) -> Result<Self, ReproduceError> {
        let figures = &file.paper.figure;
        if let Some(asked) = demand.figure
            && !figures.iter().any(|figure| figure.name == asked)
        {
            return Err(ReproduceError::NoFigure {
                found: asked.to_owned(),
                allowed: figures.iter().map(|figure| figure.name.clone()).collect(),
            });
        }
        let mut all = Self {
            file,
            demand,
            cases: BTreeMap::new(),
            known: BTreeMap::new(),
            items: Vec::new(),
            level: 1.0,
        };
        for run in all.needed() {
            let case = read_case(file, run, demand.quick, bundled)?;
            for planned in check_case(&case)? {
                let derived = planned.plan.derived().into_iter().map(|one| one.name);
                let known = Known {
                    derived: derived
                        .chain([SECONDS, COLLISIONS].map(str::to_owned))
                        .collect(),
                    tables: planned.tables(),
                    pace: planned.pace(),
                    replicas: planned.plan.case.replicas,
                };
                all.known.insert((run, planned.point.name.clone()), known);
            }
            all.cases.insert(run, case);
        }
        let mut count = 0;
        for (place, figure) in figures.iter().enumerate() {
            count += figure.claim.iter().map(weight).sum::<usize>();
            if all.asks_for(figure) {
                all.add(place, figure)?;
            }
        }
        all.level = file.paper.family_wise_error_rate / count.max(1) as f64;
        Ok(all)
    }

    fn asks_for(&self, figure: &PaperFigureSpec) -> bool {
        self.demand.figure.is_none_or(|asked| asked == figure.name)
    }

    /// Returns the requested figures of the paper, each with its index from 0.
    pub(crate) fn figures(&self) -> impl Iterator<Item = (usize, &'a PaperFigureSpec)> {
        let all = self.file.paper.figure.iter().enumerate();
        all.filter(|(_, figure)| self.asks_for(figure))
    }

    /// Returns true if the planned runs can test a claim: all claims in full runs, some in quick
    /// runs.
    fn is_open(&self, claim: &Claim) -> bool {
        claim.quick || !self.demand.quick
    }

    /// Returns the names of all runs that the requested figures need.
    fn needed(&self) -> BTreeSet<&'a str> {
        let figures = self.figures().map(|(_, figure)| figure);
        figures.flat_map(|figure| self.runs_of(figure)).collect()
    }

    /// Returns the names of the runs that one figure and its testable claims need.
    fn runs_of(&self, figure: &'a PaperFigureSpec) -> BTreeSet<&'a str> {
        let claims = figure.claim.iter().filter(|claim| self.is_open(claim));
        let claims = claims.flat_map(|claim| {
            let over = claim.over.as_ref().and_then(|over| over.run.as_deref());
            claim.run.as_deref().into_iter().chain(over)
        });
        claims.chain([figure.run.as_str()]).collect()
    }

    /// Returns the estimated time of one run on `threads` threads, summed over the points of its
    /// sweep \[s\].
    fn seconds_of(&self, run: &str, threads: usize) -> f64 {
        let points = self.known.iter().filter(|((of, _), _)| *of == run);
        let each = points.map(|(_, point)| point.pace.seconds(point.replicas, threads));
        each.sum()
    }

    /// Estimates the cost of each requested figure on `threads` threads. A run that several figures
    /// share counts for each of them.
    pub fn outline(&self, threads: usize) -> Vec<FigureOutline<'a>> {
        let outline = |(place, figure): (usize, &'a PaperFigureSpec)| FigureOutline {
            figure,
            claims: self
                .items
                .iter()
                .filter(|item| item.figure == place)
                .count(),
            seconds: self
                .runs_of(figure)
                .iter()
                .map(|run| self.seconds_of(run, threads))
                .sum(),
        };
        self.figures().map(outline).collect()
    }

    /// Returns the estimated time of all needed runs on `threads` threads \[s\]; a run that several
    /// figures share counts once.
    pub fn seconds(&self, threads: usize) -> f64 {
        let runs = self.cases.keys();
        runs.map(|run| self.seconds_of(run, threads)).sum()
    }

    /// Adds the testable claims of a figure, after a check that the tables, columns and points it
    /// names exist.
    fn add(&mut self, place: usize, figure: &'a PaperFigureSpec) -> Result<(), ReproduceError> {
        let key = format!("figure.{}", place + 1);
        let refuse =
            |inside: &str, allowed: String| self.file.refuse(&format!("{key}.{inside}"), allowed);
        let first = self.cases[figure.run.as_str()].points[0].name.clone();
        let tables = &self.known[&(figure.run.as_str(), first)].tables;
        for (number, drawn) in (1..).zip(&figure.tables) {
            if !is_drawing(tables, drawn) {
                let with = tables.iter().filter(|table| !table.figures.is_empty());
                let names: Vec<&str> = with.map(|table| &*table.name).collect();
                let allowed = format!(
                    "a table with figures, or one of its figures by its number as in energy.2; the tables are {}",
                    names.join(", ")
                );
                return Err(refuse(&format!("tables.{number}"), allowed).into());
            }
        }
        let mut items = Vec::new();
        for (number, claim) in (1..).zip(&figure.claim) {
            if self.is_open(claim) {
                items.extend(self.items_of(
                    place,
                    &format!("{key}.claim.{number}"),
                    figure,
                    claim,
                )?);
            }
        }
        self.items.extend(items);
        Ok(())
    }

    /// Expands a claim into comparisons, one for each of its values or bounds.
    fn items_of(
        &self,
        figure: usize,
        key: &str,
        of: &'a PaperFigureSpec,
        claim: &'a Claim,
    ) -> Result<Vec<Item<'a>>, CaseError> {
        let mut keys: BTreeMap<&str, Value> = claim
            .keys
            .iter()
            .map(|(key, value)| (key.as_str(), value.clone()))
            .collect();
        let source = match (&claim.derived, &claim.table, &claim.column) {
            (Some(name), ..) => NumberSource::Derived(name),
            (_, Some(table), Some(column)) => NumberSource::Column(table, column),
            // Reading guarantees one of the two forms.
            _ => return Ok(Vec::new()),
        };
        let mut spot = NumberLocation {
            run: claim.run.as_deref().unwrap_or(&of.run),
            point: String::new(),
            source,
            keys: BTreeMap::new(),
            errors: claim.errors,
        };
        let mut items = Vec::new();
        let values = claim
            .values
            .iter()
            .flatten()
            .map(|[at, value]| (Some(*at), *value));
        let bound = [
            claim.above.map(ClaimedValue::Above),
            claim.below.map(ClaimedValue::Below),
        ];
        let value = |value: f64| ClaimedValue::Value {
            value,
            error: claim.error,
            margin: claim
                .within
                .unwrap_or(claim.margin.unwrap_or(0.0) * value.abs()),
        };
        let said = (values.map(|(at, one)| (at, value(one), false)))
            .chain(claim.value.map(|one| (None, value(one), false)))
            .chain(claim.corrected.map(|one| (None, value(one), true)))
            .chain(
                bound
                    .into_iter()
                    .flatten()
                    .map(|bound| (None, bound, false)),
            );
        for (at, said, corrected) in said {
            if let Some((along, at)) = claim.along.as_deref().zip(at) {
                keys.insert(along, Value::Float(at));
            }
            spot.keys.clone_from(&keys);
            spot.point = self.point(key, spot.run, &claim.point)?;
            let over = claim.over.as_ref().map(|over| {
                let mut there = spot.clone();
                there.run = over.run.as_deref().unwrap_or(there.run);
                if let NumberSource::Column(table, column) = there.source {
                    let table = over.table.as_deref().unwrap_or(table);
                    there.source =
                        NumberSource::Column(table, over.column.as_deref().unwrap_or(column));
                }
                there.keys.extend(
                    over.keys
                        .iter()
                        .map(|(key, value)| (key.as_str(), value.clone())),
                );
                let key = format!("{key}.over");
                there.point =
                    self.point(&key, there.run, over.point.as_ref().unwrap_or(&claim.point))?;
                Ok::<_, CaseError>((key, there))
            });
            self.check_spot(key, &spot)?;
            let over = over.transpose()?;
            if let Some((key, over)) = &over {
                self.check_spot(key, over)?;
            }
            if let Some(power) = &claim.power_of {
                let both = [Some(&spot), over.as_ref().map(|over| &over.1)];
                let numbers = both.map(|one| one?.keys.get(power.as_str()).and_then(number));
                let good = matches!(numbers, [Some(a), Some(b)] if a > 0.0 && b > 0.0 && a != b);
                if !good {
                    let allowed =
                        "a key column that where and over.where set to two numbers above 0";
                    return Err(self.file.refuse(&format!("{key}.power_of"), allowed));
                }
            }
            items.push(Item {
                figure,
                claim,
                number: spot.clone(),
                over: over.map(|over| over.1),
                said,
                corrected,
            });
        }
        Ok(items)
    }

    /// Returns the name of the sweep point of a run that has the chosen values. The choice must fit
    /// exactly one point.
    fn point(
        &self,
        key: &str,
        run: &str,
        chosen: &BTreeMap<String, Value>,
    ) -> Result<String, CaseError> {
        let points = &self.cases[run].points;
        let found: Vec<&CasePoint> = points.iter().filter(|point| point.has(chosen)).collect();
        if let [one] = found[..] {
            return Ok(one.name.clone());
        }
        let names: Vec<&str> = points.iter().map(|point| point.name.as_str()).collect();
        let allowed = format!(
            "values of swept keys that choose one point; these choose {} of {}: {}",
            found.len(),
            points.len(),
            names.join("; ")
        );
        Err(self.file.refuse(&format!("{key}.point"), allowed))
    }

    /// Checks that the table, column and key columns of a number's location exist in the expected
    /// results.
    fn check_spot(&self, key: &str, spot: &NumberLocation<'_>) -> Result<(), CaseError> {
        let refuse = |inside: &str, what: &str, names: Vec<String>| {
            let allowed = format!("{what} of run {}: {}", spot.run, names.join(", "));
            self.file.refuse(&format!("{key}.{inside}"), allowed)
        };
        let Known {
            tables, derived, ..
        } = &self.known[&(spot.run, spot.point.clone())];
        let (name, column) = match spot.source {
            NumberSource::Derived(name) => {
                let known = derived.iter().any(|one| same_name(one, name));
                let names = || derived.clone();
                return known
                    .then_some(())
                    .ok_or_else(|| refuse("derived", "a quantity", names()));
            }
            NumberSource::Column(table, column) => (table, column),
        };
        let Some(table) = tables.iter().find(|table| table.name == name) else {
            let names = tables.iter().map(|table| table.name.to_string()).collect();
            return Err(refuse("table", "a table", names));
        };
        let names = || {
            table
                .columns
                .iter()
                .map(|column| column.name.to_string())
                .collect()
        };
        let is_number = table
            .find_column(column)
            .is_some_and(|place| !table.columns[place].unit.is_empty());
        if !is_number {
            return Err(refuse("column", "a column of numbers", names()));
        }
        for (one, value) in &spot.keys {
            let Some(place) = table.find_column(one) else {
                return Err(refuse("where", &format!("columns of {name}"), names()));
            };
            let has_words = table.columns[place].unit.is_empty();
            if !has_words && value.is_str() || has_words && value.is_float() {
                let is = if has_words { "words" } else { "numbers" };
                let allowed = format!("the column {one} of {name} has {is}; found {value}");
                return Err(self.file.refuse(&format!("{key}.where"), allowed));
            }
        }
        Ok(())
    }
}

/// Returns true if a name such as `energy` or `energy.2` is that of a table with figures, or of one
/// of its figures.
fn is_drawing(tables: &[Table], name: &str) -> bool {
    let (table, number) = drawn_number(name);
    let found = tables.iter().find(|one| one.name == table);
    found.is_some_and(|table| (1..=table.figures.len()).contains(&number.unwrap_or(1)))
}

/// Splits a figure name such as `energy.2` into the table name and the figure number from 1.
pub(crate) fn drawn_number(name: &str) -> (&str, Option<usize>) {
    match name.rsplit_once('.') {
        Some((table, number)) => (table, number.parse().ok()),
        None => (name, None),
    }
}

/// Returns the number of statistical tests of a claim: one for each value or bound, and one for a
/// correction.
fn weight(claim: &Claim) -> usize {
    let corrected = usize::from(claim.corrected.is_some());
    claim.values.as_ref().map_or(1 + corrected, Vec::len)
}
