//! Verdicts on the claims of a paper, as sentences, as a table and as an HTML page.

use std::collections::BTreeMap;

use stosszahl_report::{PaperClaim, PaperFigure, PaperPage, PaperRun};
use stosszahl_results::{
    FinishedPoints, Table, TableCell, TableEstimate, VerdictKind, VerdictText, format_number,
};
use stosszahl_study::judge::{self, ClaimedValue, with_error};

use crate::find::{find_number, quotient};
use crate::number_location::{NumberLocation, NumberSource};
use crate::plan::{Item, Reproduction, drawn_number};

/// Claim of a paper with the value found in the results, and the verdict.
pub struct ClaimOutcome<'a> {
    item: &'a Item<'a>,
    /// Name of the figure of the paper that the claim belongs to.
    pub figure: &'a str,
    /// Value found in the results for the claim, with its standard error.
    pub found: TableEstimate,
    /// Verdict on the claim; its topic is the text of the claim.
    pub verdict: VerdictText,
}

/// All requested claims of a paper with the values found and the verdicts.
pub struct Judged<'a> {
    of: &'a Reproduction<'a>,
    /// Claims with values and verdicts, in the order of the paper.
    pub outcomes: Vec<ClaimOutcome<'a>>,
}

impl<'a> Judged<'a> {
    /// Looks up the number of every claim in the results and derives the verdicts.
    pub(crate) fn new(of: &'a Reproduction<'a>, results: &BTreeMap<&str, FinishedPoints>) -> Self {
        let outcomes = of.items.iter().map(|item| {
            let topic = item.topic();
            let found = item.find_number(results);
            let verdict = match &found {
                Ok(found) => judge::claim(topic, found, item.said, of.level),
                Err(why) => judge::verdict(topic, format!("Not found: {why}."), VerdictKind::Void),
            };
            ClaimOutcome {
                item,
                figure: &of.file.paper.figure[item.figure].name,
                found: found.unwrap_or_default(),
                verdict,
            }
        });
        Self {
            of,
            outcomes: outcomes.collect(),
        }
    }

    /// Formats how many claims have each verdict, as one sentence.
    pub fn count(&self) -> String {
        let kinds = [
            VerdictKind::Agree,
            VerdictKind::Differ,
            VerdictKind::Undecided,
            VerdictKind::Void,
        ];
        let count = |kind| {
            self.outcomes
                .iter()
                .filter(|one| one.verdict.kind == kind)
                .count()
        };
        let parts = kinds.map(|kind| (kind.name(), count(kind)));
        let parts = parts.iter().filter(|(_, count)| *count > 0);
        let parts: Vec<String> = parts
            .map(|(name, count)| format!("{count} {name}"))
            .collect();
        format!("{} claims: {}", self.outcomes.len(), parts.join(", "))
    }

    /// Creates the table of claims, `claims.csv`: one row for each claim with its value and
    /// verdict.
    pub fn table(&self) -> Table {
        let mut table = stosszahl_results::table! {
            "claims", "What a paper claims, and what was found.";
            key "figure", "", "Figure or table of the paper";
            key "claim", "", "The claim in words";
            key "run", "", "The run that the number is of";
            key "place", "", "Where the number stands: point, table, column and row";
            note "relation", "", "What the paper says of the number: equal, above, below; or what it should say: corrected";
            value "paper", "of the column", "The number of the paper, its bound, or its correction";
            value "paper_se", "of the column", "Standard error of that, if it has one";
            value "found", "of the column", "The number that was found";
            value "found_se", "of the column", "Its standard error";
            value "margin", "of the column", "Largest deviation that counts as agreement";
            note "verdict", "", "agree, differ, undecided or void";
            note "sentence", "", "The verdict in words";
            note "correction", "", "Why the paper is wrong, and who says so";
        };
        for one in &self.outcomes {
            let item = one.item;
            let (relation, paper, error, margin) = match item.said {
                ClaimedValue::Value {
                    value,
                    error,
                    margin,
                } => {
                    let relation = if item.corrected { "corrected" } else { "equal" };
                    (relation, value, error, Some(margin))
                }
                ClaimedValue::Above(bound) => ("above", bound, None, None),
                ClaimedValue::Below(bound) => ("below", bound, None, None),
            };
            table.add((
                (
                    one.figure,
                    &*item.claim.claim,
                    item.number.run,
                    &*item.place_text(),
                ),
                (relation, paper, error),
                (one.found.value, one.found.standard_error, margin),
                (one.verdict.kind.name(), &*one.verdict.sentence),
                text(item.claim.correction.as_deref()),
            ));
        }
        table
    }

    /// Creates the content of the HTML page of the paper: its figures and its claims with verdicts.
    pub(crate) fn page(&self) -> PaperPage<'_> {
        let paper = &self.of.file.paper;
        let figures = self.of.figures().map(|(place, figure)| {
            let own = self.outcomes.iter().filter(|one| one.item.figure == place);
            let drawings = figure.tables.iter().map(|name| drawn_number(name));
            PaperFigure {
                name: &figure.name,
                title: &figure.title,
                missing: figure.missing.as_deref(),
                run: &figure.run,
                drawings: drawings.collect(),
                claims: own.map(ClaimOutcome::row).collect(),
            }
        });
        let runs = self.of.cases.iter().map(|(name, case)| {
            let run = &paper.run[*name];
            let quick = run.quick.iter().filter(|_| self.of.demand.quick);
            let settings = run.set.iter().chain(quick);
            PaperRun {
                name,
                case: &run.case,
                title: &case.points[0].case.title,
                settings: settings
                    .map(|(key, value)| format!("{key} = {value}"))
                    .collect(),
            }
        });
        PaperPage {
            title: &paper.title,
            source: &paper.source,
            remark: paper.remark.as_deref(),
            summary: self.count(),
            kind: self.of.kind(),
            family_wise_error_rate: paper.family_wise_error_rate,
            figures: figures.collect(),
            runs: runs.collect(),
        }
    }
}

/// Converts an optional text to a table cell; `None` gives an empty cell.
fn text(text: Option<&str>) -> TableCell {
    text.map_or(TableCell::Empty, |text| TableCell::Text(text.to_owned()))
}

impl ClaimOutcome<'_> {
    /// Converts the claim and its verdict to a row of the HTML page.
    fn row(&self) -> PaperClaim<'_> {
        let item = self.item;
        let (paper, margin, ratio) = match item.said {
            ClaimedValue::Value {
                value,
                error,
                margin,
            } => {
                let ratio = (value != 0.0).then(|| self.found.times(1.0 / value));
                let paper = match error {
                    Some(_) => with_error(value, error),
                    None => format_number(value),
                };
                let corrected = if item.corrected { " (corrected)" } else { "" };
                (
                    format!("{paper}{corrected}"),
                    format!("± {}", format_number(margin)),
                    ratio,
                )
            }
            ClaimedValue::Above(bound) => {
                (format!("> {}", format_number(bound)), String::new(), None)
            }
            ClaimedValue::Below(bound) => {
                (format!("< {}", format_number(bound)), String::new(), None)
            }
        };
        let found = match (self.found.value, self.found.standard_error) {
            (None, _) => "–".to_owned(),
            (Some(value), Some(0.0)) => format_number(value),
            (Some(value), error) => with_error(value, error),
        };
        PaperClaim {
            claim: &item.claim.claim,
            place: item.place_text(),
            paper,
            found,
            margin,
            ratio,
            verdict: &self.verdict,
            correction: item.claim.correction.as_deref(),
        }
    }
}

impl Item<'_> {
    /// Returns the text of the claim, with the position along a curve if it has one.
    fn topic(&self) -> String {
        let at = self.claim.along.as_deref().and_then(|along| {
            let value = self.number.keys.get(along)?;
            Some(format!(", {along} {value}"))
        });
        let corrected = if self.corrected { ", corrected" } else { "" };
        format!("{}{}{corrected}", self.claim.claim, at.unwrap_or_default())
    }

    /// Describes where the number of the claim is found in the results, as text.
    pub(crate) fn place_text(&self) -> String {
        let own = self.number.words();
        match (&self.over, &self.claim.power_of) {
            (None, _) => own,
            (Some(over), None) => format!("{own} over {}", over.words()),
            (Some(over), Some(power)) => format!("power of {power}: {own} over {}", over.words()),
        }
    }

    /// Looks up the number of one claim in the results of its run, divided by the reference number
    /// if the claim has one.
    fn find_number(
        &self,
        results: &BTreeMap<&str, FinishedPoints>,
    ) -> Result<TableEstimate, String> {
        let find = |spot: &NumberLocation<'_>| {
            let run = results.get(spot.run).ok_or("the run is not finished")?;
            find_number(run, spot)
        };
        let own = find(&self.number)?;
        let Some(over) = &self.over else {
            return Ok(own);
        };
        Ok(quotient(&own, &find(over)?, self.growth()))
    }
}

impl NumberLocation<'_> {
    /// Describes a number's location in the results: point of the sweep, table, column and row.
    fn words(&self) -> String {
        let keys: Vec<String> = self
            .keys
            .iter()
            .map(|(key, value)| format!("{key} = {value}"))
            .collect();
        let source = match self.source {
            NumberSource::Derived(name) => name.replace('_', " "),
            NumberSource::Column(table, column) => format!("{table}.{column}"),
        };
        let rows = if keys.is_empty() {
            String::new()
        } else {
            format!(" [{}]", keys.join(", "))
        };
        let point = if self.point.is_empty() {
            String::new()
        } else {
            format!("{}: ", self.point)
        };
        format!("{point}{source}{rows}")
    }
}
