//! HTML page of a reproduced paper: its figures, each with the paper's claims, the numbers found,
//! and the verdicts.

use std::path::Path;

use maud::{Markup, html};
use stosszahl_results::{
    Figure, FigureAxis, PointMark, REPORT_FILE, Stored, Sweep, Table, TableCell, TableEstimate,
    VerdictText, headlines,
};

use crate::figure::{Drawn, draw};
use crate::page;
use crate::{ReportError, sweep};

/// Contents of the report page of a reproduced paper.
#[derive(Clone, Debug)]
pub struct PaperPage<'a> {
    /// Title of the reproduced paper.
    pub title: &'a str,
    /// Authors, journal and year of the paper.
    pub source: &'a str,
    /// Remark on the reproduction of the paper as a whole.
    pub remark: Option<&'a str>,
    /// Summary in words: numbers of claims by verdict.
    pub summary: String,
    /// Kind of the runs, such as full or quick.
    pub kind: &'a str,
    /// Family-wise error rate of the verdicts: probability of any false alarm.
    pub family_wise_error_rate: f64,
    /// Figures and tables of the paper, with their claims.
    pub figures: Vec<PaperFigure<'a>>,
    /// Runs of cases behind the figures.
    pub runs: Vec<PaperRun<'a>>,
}

/// Figure or table of a paper, with the paper's claims about it.
#[derive(Clone, Debug)]
pub struct PaperFigure<'a> {
    /// Number of the figure in the paper.
    pub name: &'a str,
    /// Title of the figure.
    pub title: &'a str,
    /// Parts of the paper's figure that are not reproduced, in words.
    pub missing: Option<&'a str>,
    /// Name of the run whose tables are drawn in place of the figure.
    pub run: &'a str,
    /// Tables to draw, each with the number of one of its figures from 1, or `None` for all.
    pub drawings: Vec<(&'a str, Option<usize>)>,
    /// Claims of the paper about the figure.
    pub claims: Vec<PaperClaim<'a>>,
}

/// Claim of a paper with the number that the run found, and the verdict.
#[derive(Clone, Debug)]
pub struct PaperClaim<'a> {
    /// Claim of the paper in words.
    pub claim: &'a str,
    /// Location of the number in the result tables, in words.
    pub place: String,
    /// Number that the paper states, as text.
    pub paper: String,
    /// Number found by the run, as text.
    pub found: String,
    /// Largest deviation that counts as agreement, as text; empty for bounds.
    pub margin: String,
    /// Number found over the paper's value; `None` for bounds.
    pub ratio: Option<TableEstimate>,
    /// Verdict on the claim.
    pub verdict: &'a VerdictText,
    /// Correction of the paper, if the claim is wrong; `None` otherwise.
    pub correction: Option<&'a str>,
}

/// Run of a case, made to reproduce figures of a paper.
#[derive(Clone, Debug)]
pub struct PaperRun<'a> {
    /// Name of the run and of its folder.
    pub name: &'a str,
    /// Name of the case of the run.
    pub case: &'a str,
    /// Title of the case of the run.
    pub title: &'a str,
    /// Case keys changed for the run, as `key=value`.
    pub settings: Vec<String>,
}

/// Builds the page of a paper whose runs are in folders of their names inside `folder`.
///
/// # Errors
/// [`ReportError`] if a results folder is damaged.
pub fn paper(folder: &Path, paper: &PaperPage<'_>) -> Result<String, ReportError> {
    let mut number = 0;
    let mut figures = Vec::new();
    for figure in &paper.figures {
        let mut drawings = Vec::new();
        for (shown, drawn) in drawn(&folder.join(figure.run), &figure.drawings)? {
            number += 1;
            drawings.push(page::figure(number, &shown.title, &shown.caption, &drawn));
        }
        let first = number + 1;
        let ratios = ratio_figure(figure, first);
        number += usize::from(ratios.is_some());
        figures.push(html! {
            section id=(figure_anchor(figure.name)) {
                h2 { (figure_name(figure.name)) ". " (figure.title) }
                @if let Some(missing) = figure.missing { p { strong { "Not here: " } (missing) } }
                @for drawing in &drawings { (drawing) }
                (claims_table(&figure.claims))
                @if let Some(ratios) = &ratios { (ratios) }
            }
        });
    }
    let runs = runs_table(folder, &paper.runs)?;
    let content = html! {
        h1 { (paper.title) }
        p.lead { (paper.source) }
        p { strong { (paper.summary) } " (" (paper.kind) ")." }
        @if let Some(remark) = paper.remark { p { (remark) } }
        nav { @for figure in &paper.figures { a href={ "#" (figure_anchor(figure.name)) } { (figure_name(figure.name)) } } a href="#runs" { "Runs" } }
        @for figure in &figures { (figure) }
        section id="runs" { h2 { "Runs" } (runs) }
        footer { p {
            "The chance that any claim of the paper is called different though it is not is " (paper.family_wise_error_rate) ", shared equally by all. "
            "A value differs if it is off by more than its margin and by more than chance explains; it agrees if it is within the margin, with "
            "its error. This page loads nothing; " code { "claims.csv" } " beside it has all claims."
        } }
    };
    Ok(page::document(paper.title, &content, &[]))
}

/// Returns the display name of a figure: "Fig. 3b" for a number, else the name itself.
pub fn figure_name(name: &str) -> String {
    if name.starts_with(|c: char| c.is_ascii_digit()) {
        format!("Fig. {name}")
    } else {
        name.to_owned()
    }
}

/// Returns the name of a figure in links and files: `figure-3b`.
pub fn figure_anchor(name: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    format!("figure-{}", name.chars().map(letter).collect::<String>())
}

/// Draws the requested figures of the tables of a results folder; for a sweep, with one panel for
/// each point.
fn drawn(
    folder: &Path,
    wanted: &[(&str, Option<usize>)],
) -> Result<Vec<(Figure, Drawn)>, ReportError> {
    let mut all: Vec<(Table, Figure)> = Vec::new();
    if let Some(sweep) = Sweep::read(folder)? {
        all.extend(sweep::at_each_point(folder, &sweep)?);
    } else if let Some(stored) = Stored::read(folder)? {
        let figures = stored.tables.iter().flat_map(|table| {
            let figures = table.figures.iter();
            figures.map(move |figure| (table.clone(), figure.clone()))
        });
        all.extend(figures);
    }
    let mut found = Vec::new();
    for (name, number) in wanted {
        let of = all.iter().filter(|(table, _)| table.name == *name);
        for (_, (table, figure)) in (1..)
            .zip(of)
            .filter(|one| number.is_none_or(|number| number == one.0))
        {
            if let Some(drawn) = draw(table, figure) {
                found.push((figure.clone(), drawn));
            }
        }
    }
    Ok(found)
}

/// Builds the HTML table of the claims about a figure, each with its verdict.
fn claims_table(all: &[PaperClaim<'_>]) -> Markup {
    html! {
        @if !all.is_empty() {
            div.scroll { table {
                thead { tr {
                    th scope="col" { "no." } th.text scope="col" { "the paper says" } th scope="col" { "paper" } th scope="col" { "found" }
                    th scope="col" { "margin" } th.text scope="col" { "verdict" }
                } }
                tbody { @for (number, one) in (1..).zip(all) { tr {
                    td { (number) }
                    td.text.long title=(one.place) { (one.verdict.topic) }
                    td { (one.paper) } td { (one.found) } td { (one.margin) }
                    td.text { (page::kind(one.verdict.kind)) }
                } } }
            } }
            @let corrections = claim_corrections(all);
            @if !corrections.is_empty() {
                p { strong { "Corrections. " } }
                ul { @for (claim, correction) in &corrections { li { strong { (claim) } ": " (correction) } } }
            }
            details {
                summary { "Where these numbers stand, and the verdicts in words" }
                ol { @for one in all { li { (one.verdict.sentence) " " code { (one.place) } } } }
            }
        }
    }
}

/// Returns the corrections of the paper with their claims, each once.
fn claim_corrections<'a>(all: &[PaperClaim<'a>]) -> Vec<(&'a str, &'a str)> {
    let mut found: Vec<(&str, &str)> = Vec::new();
    for one in all {
        if let Some(correction) = one.correction
            && !found.contains(&(one.claim, correction))
        {
            found.push((one.claim, correction));
        }
    }
    found
}

/// Builds the HTML figure of the ratios of found to claimed values; `None` with fewer than two.
fn ratio_figure(figure: &PaperFigure<'_>, number: usize) -> Option<Markup> {
    let mut table = stosszahl_results::table! {
        "claims", "What was found over what the paper says.";
        key "claim", "1", "Number of the claim in the table above";
        estimate "ratio", "1", "What was found over what the paper says";
    };
    for (number, claim) in (1_u64..).zip(&figure.claims) {
        let Some(ratio) = claim.ratio.filter(|ratio| ratio.value.is_some()) else {
            continue;
        };
        table.add((TableCell::Count(number), ratio));
    }
    let title = format!("{}, found over paper", figure_name(figure.name));
    let ratios = Figure::curves(
        "Found over paper",
        FigureAxis::linear("claim", "number of the claim"),
        FigureAxis::linear("ratio", "found / paper"),
    );
    let ratios = ratios
        .by(&[])
        .mark(PointMark::Points)
        .line("as the paper says", 1.0);
    let ratios = ratios.caption("Bars are standard errors of what was found.");
    (table.rows.len() > 1).then_some(())?;
    let drawn = draw(&table, &ratios)?;
    Some(page::figure(number, &title, &ratios.caption, &drawn))
}

/// Builds the HTML table of the runs, each with its headline and a link to its report.
fn runs_table(folder: &Path, all: &[PaperRun<'_>]) -> Result<Markup, ReportError> {
    let mut rows = Vec::new();
    for run in all {
        let inside = folder.join(run.name);
        let stored = if Sweep::read(&inside)?.is_some() {
            None
        } else {
            Stored::read(&inside)?
        };
        let first = stored.as_ref().and_then(|stored| {
            headlines(&stored.manifest.verdicts)
                .first()
                .copied()
                .cloned()
        });
        rows.push((run, first));
    }
    Ok(html! {
        div.scroll { table {
            thead { tr {
                th.text scope="col" { "run" } th.text scope="col" { "case" } th.text scope="col" { "what is set" } th.text scope="col" { "its own first verdict" }
            } }
            tbody { @for (run, first) in &rows { tr {
                td.text { a href={ "./" (run.name) "/" (REPORT_FILE) } { (run.name) } }
                td.text.long { code { (run.case) } ": " (run.title) }
                td.text { @for setting in &run.settings { code { (setting) } " " } }
                td.text.long { @if let Some(first) = first { (page::kind(first.kind)) " " (first.sentence) } @else { "in its report" } }
            } } }
        } }
    })
}
