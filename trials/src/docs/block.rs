//! Blocks of Markdown: found, read and replaced.

/// What the first line of a block says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Head {
    /// Name of the entry.
    pub name: String,
    /// The commit that the runs are of.
    pub commit: String,
    /// Its day.
    pub date: String,
    /// Statistics version of each engine that the block rests on.
    pub statistics: Vec<(String, u32)>,
}

/// A block as it stands in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Its first line.
    pub head: Head,
    /// What stands between the first and the last line.
    pub text: String,
}

impl Head {
    fn line(&self) -> String {
        let versions = self
            .statistics
            .iter()
            .map(|(engine, version)| format!(" {engine}={version}"));
        let versions: String = versions.collect();
        let Self {
            name, commit, date, ..
        } = self;
        format!("<!-- docs {name}: commit {commit}, date {date}, statistics{versions} -->")
    }

    fn read(line: &str) -> Option<Self> {
        let inside = line
            .trim()
            .strip_prefix("<!-- docs ")?
            .strip_suffix(" -->")?;
        let (name, rest) = inside.split_once(": ")?;
        let mut parts = rest.split(", ");
        let commit = parts.next()?.strip_prefix("commit ")?;
        let date = parts.next()?.strip_prefix("date ")?;
        let versions = parts.next()?.strip_prefix("statistics")?;
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
        })
    }
}

/// Where a block begins, where its text begins and ends, and where it ends, in bytes.
fn place(text: &str, name: &str) -> Option<[usize; 4]> {
    let begin = text.find(&format!("<!-- docs {name}:"))?;
    let inner = begin + text[begin..].find('\n')? + 1;
    let last = format!("<!-- end of {name} -->");
    let end = inner + text[inner..].find(&last)?;
    Some([begin, inner, end, end + last.len()])
}

/// The block of a name; none where there is none, or its first line cannot be read.
pub fn find(text: &str, name: &str) -> Option<Block> {
    let [begin, inner, end, _] = place(text, name)?;
    Some(Block {
        head: Head::read(&text[begin..inner])?,
        text: text[inner..end].trim().to_owned(),
    })
}

/// A page with another block in place of the one of this name; none where there is none.
pub fn replace(text: &str, head: &Head, made: &str) -> Option<String> {
    let [begin, _, _, end] = place(text, &head.name)?;
    let (line, last) = (head.line(), format!("<!-- end of {} -->", head.name));
    Some(format!(
        "{}{line}\n\n{}\n\n{last}{}",
        &text[..begin],
        made.trim(),
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
        };
        let made = replace(page, &head, "| 1 |").expect("a block");
        let block = find(&made, "a").expect("a block");
        assert_eq!((&block.head, &*block.text), (&head, "| 1 |"));
        assert!(made.starts_with(
            "# Page\n\n<!-- docs a: commit 0123abc, date 2026-11-23, statistics ed=1 dsmc=2 -->"
        ));
        assert!(made.ends_with("<!-- end of a -->\n\nEnd.\n"));
        // Again, it is the same.
        assert_eq!(replace(&made, &head, "| 1 |").as_ref(), Some(&made));
        assert!(
            find(&made, "b").is_none()
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
