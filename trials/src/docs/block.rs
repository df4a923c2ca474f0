//! Search, parsing and replacement of generated blocks in Markdown pages.

/// First line of a generated documentation block: name, commit, date and statistics versions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Head {
    /// Name of the generated documentation block.
    pub name: String,
    /// Commit of the program whose runs the block shows.
    pub commit: String,
    /// Date of the commit whose runs the block shows.
    pub date: String,
    /// Statistics version of each engine whose results the block shows.
    pub statistics: Vec<(String, u32)>,
    /// Source of hand-typed results: their cases; `None` for a block that a command generates.
    pub typed: Option<String>,
}

/// Generated block of a Markdown page, between two HTML comments.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PageBlock {
    /// Parsed first line of the documentation block: name, commit and statistics versions.
    pub head: Head,
    /// Text of the documentation block between its first and its last line.
    pub text: String,
}

impl Head {
    fn line(&self) -> String {
        let versions = self
            .statistics
            .iter()
            .map(|(engine, version)| format!(" {engine}={version}"));
        let versions: String = versions.collect();
        let typed = self.typed.as_ref();
        let typed = typed.map_or(String::new(), |cases| format!(", typed from {cases}"));
        let Self {
            name, commit, date, ..
        } = self;
        format!("<!-- docs {name}: commit {commit}, date {date}, statistics{versions}{typed} -->")
    }

    /// Formats a generated block with new text `made`, from its first line to its last.
    pub(crate) fn format_block(&self, made: &str) -> String {
        let (line, made, name) = (self.line(), made.trim(), &self.name);
        format!("{line}\n\n{made}\n\n<!-- end of {name} -->")
    }

    fn parse_head(line: &str) -> Option<Self> {
        let inside = line
            .trim()
            .strip_prefix("<!-- docs ")?
            .strip_suffix(" -->")?;
        let (name, rest) = inside.split_once(": ")?;
        let mut parts = rest.split(", ");
        let commit = parts.next()?.strip_prefix("commit ")?;
        let date = parts.next()?.strip_prefix("date ")?;
        let versions = parts.next()?.strip_prefix("statistics")?;
        let typed = match parts.next() {
            None => None,
            Some(part) => Some(part.strip_prefix("typed from ")?.to_owned()),
        };
        let version = |word: &str| {
            let (engine, version) = word.split_once('=')?;
            Some((engine.to_owned(), version.parse().ok()?))
        };
        let statistics = versions.split_whitespace().map(version);
        Some(Self {
            name: name.to_owned(),
            commit: commit.to_owned(),
            date: date.to_owned(),
            statistics: statistics.collect::<Option<_>>()?,
            typed,
        })
    }
}

/// Returns the names of all generated blocks of a page, in order.
pub fn names(page: &str) -> Vec<String> {
    let heads = page.split("<!-- docs ").skip(1);
    heads
        .filter_map(|rest| Some(rest.split_once(':')?.0.to_owned()))
        .collect()
}

/// Returns true if a page has an empty generated block of this name, to be filled later.
pub fn is_open(page: &str, name: &str) -> bool {
    block_offsets(page, name).is_some_and(|[_, inner, end, _]| page[inner..end].trim().is_empty())
}

/// Returns the text of a page outside generated blocks and code.
pub fn outside(page: &str) -> String {
    let mut rest = page.to_owned();
    for name in names(page) {
        if let Some([begin, _, _, end]) = block_offsets(&rest, &name) {
            rest.replace_range(begin..end, "");
        }
    }
    let fenced = rest.split("```").step_by(2);
    fenced.collect()
}

/// Returns four byte offsets of a generated block: its begin, begin and end of its text, and its
/// end.
fn block_offsets(text: &str, name: &str) -> Option<[usize; 4]> {
    let begin = text.find(&format!("<!-- docs {name}:"))?;
    let inner = begin + text[begin..].find('\n')? + 1;
    let last = format!("<!-- end of {name} -->");
    let end = inner + text[inner..].find(&last)?;
    Some([begin, inner, end, end + last.len()])
}

/// Finds the generated block of a name in a page; `None` without one, or if its first line is
/// malformed.
pub fn find_block(text: &str, name: &str) -> Option<PageBlock> {
    let [begin, inner, end, _] = block_offsets(text, name)?;
    Some(PageBlock {
        head: Head::parse_head(&text[begin..inner])?,
        text: text[inner..end].trim().to_owned(),
    })
}

/// Returns the page with the generated block of this name replaced; `None` without such a block.
pub fn replace(text: &str, head: &Head, made: &str) -> Option<String> {
    let [begin, _, _, end] = block_offsets(text, &head.name)?;
    Some(format!(
        "{}{}{}",
        &text[..begin],
        head.format_block(made),
        &text[end..]
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_read_as_it_was_written() {
        let page = "# Page\n\n<!-- docs a: new -->\n<!-- end of a -->\n\nEnd.\n";
        let head = Head {
            name: "a".into(),
            commit: "0123abc".into(),
            date: "2026-11-23".into(),
            statistics: vec![("ed".into(), 1), ("dsmc".into(), 2)],
            typed: None,
        };
        assert!(is_open(page, "a"));
        let made = replace(page, &head, "| 1 |").expect("a block");
        let block = find_block(&made, "a").expect("a block");
        assert_eq!((&block.head, &*block.text), (&head, "| 1 |"));
        assert!(made.starts_with(
            "# Page\n\n<!-- docs a: commit 0123abc, date 2026-11-23, statistics ed=1 dsmc=2 -->"
        ));
        assert!(made.ends_with("<!-- end of a -->\n\nEnd.\n"));
        assert!(names(&made) == ["a"] && !is_open(&made, "a"));
        assert_eq!(outside(&made), "# Page\n\n\n\nEnd.\n");
        let typed = Head {
            typed: Some("quick, elastic".replace(", ", " ")),
            ..head.clone()
        };
        let kept = replace(page, &typed, "| 1 |").expect("a block");
        assert_eq!(find_block(&kept, "a").expect("a block").head, typed);
        // A second replacement changes nothing.
        assert_eq!(replace(&made, &head, "| 1 |").as_ref(), Some(&made));
        assert!(
            find_block(&made, "b").is_none()
                && replace(
                    &made,
                    &Head {
                        name: "b".into(),
                        ..head
                    },
                    ""
                )
                .is_none()
        );
    }
}
