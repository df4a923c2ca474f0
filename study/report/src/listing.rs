//! HTML page with a headline, figures, sentences and lists, such as the page of a frontier.

use maud::html;
use stosszahl_results::Table;

use crate::figure::draw;
use crate::page::{self, ListColumn, document, unbroken};

/// List on a page: its title, columns and rows of text.
pub type Listing<'a> = (&'a str, &'a [ListColumn<'a>], &'a [Vec<String>]);

/// Contents of an HTML page with headline, figures, sentences and lists.
#[derive(Clone, Copy, Debug)]
pub struct Listed<'a> {
    /// Title of the HTML page.
    pub title: &'a str,
    /// Headline of the page: the main result in one sentence.
    pub headline: &'a str,
    /// Table whose figures are shown below the headline of the page.
    pub figure: &'a Table,
    /// Sentences below the figures of the page.
    pub lines: &'a [String],
    /// Collapsed groups of sentences on the page, each with its title.
    pub folded: &'a [(&'a str, &'a [String])],
    /// Lists on the page; lists without rows are left out.
    pub lists: &'a [Listing<'a>],
}

/// Builds the HTML page from its contents.
pub fn listing(page: &Listed<'_>) -> String {
    let table = page.figure;
    let figures = (table.figures.iter()).filter_map(|figure| Some((figure, draw(table, figure)?)));
    let content = html! {
        h1 { (page.title) }
        p.headline { (unbroken(page.headline)) }
        @for (number, (figure, found)) in (1..).zip(figures) {
            (page::figure(number, &figure.title, &figure.caption, &found))
        }
        @for line in page.lines { p { (unbroken(line)) } }
        @for (title, sentences) in page.folded.iter().filter(|group| !group.1.is_empty()) {
            details {
                summary { (title) ", " (sentences.len()) }
                ul { @for sentence in *sentences { li { (sentence) } } }
            }
        }
        @for (title, columns, rows) in page.lists.iter().filter(|list| !list.2.is_empty()) {
            h2 { (title) }
            (page::table(columns, rows))
        }
    };
    document(page.title, &content, &[])
}
