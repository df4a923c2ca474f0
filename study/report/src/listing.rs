//! A page of sentences, figures of tables, and lists in words: that of a frontier.

use maud::html;
use stosszahl_results::Table;

use crate::figure::draw;
use crate::page::{self, Column, document, table};

/// A list in words: its title, its columns, its rows.
pub type Listing<'a> = (&'a str, &'a [Column<'a>], &'a [Vec<String>]);

/// Whether a sentence is about what was not done, which a page folds.
fn is_left_out(sentence: &str) -> bool {
    sentence.starts_with("Left out")
}

/// The page; lists without rows are left out.
pub fn listing(
    title: &str,
    sentences: &[String],
    tables: &[&Table],
    lists: &[Listing<'_>],
) -> String {
    let figures = tables.iter().flat_map(|table| {
        let all = table.figures.iter();
        all.filter_map(|figure| Some((figure, draw(table, figure)?)))
    });
    let content = html! {
        h1 { (title) }
        @for sentence in sentences.iter().filter(|one| !is_left_out(one)) { p { (sentence) } }
        @if sentences.iter().any(|one| is_left_out(one)) {
            details {
                summary { "What was left out, " (sentences.iter().filter(|one| is_left_out(one)).count()) }
                ul { @for sentence in sentences.iter().filter(|one| is_left_out(one)) { li { (sentence) } } }
            }
        }
        @for (number, (figure, found)) in (1..).zip(figures) {
            (page::figure(number, &figure.title, &figure.caption, &found))
        }
        @for (title, columns, rows) in lists.iter().filter(|list| !list.2.is_empty()) {
            h2 { (title) }
            (table(columns, rows))
        }
    };
    document(title, &content, None)
}
