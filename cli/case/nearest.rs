//! Did you mean: the closest of a few words.

/// The choice within two single-letter edits of `word`, if there is one, the closest first.
///
/// A choice that would have to change altogether is not close, however short it is.
pub(super) fn nearest<'a>(
    word: &str,
    choices: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    choices
        .into_iter()
        .map(|choice| (edit_distance(word, choice), choice))
        .filter(|&(distance, choice)| distance <= 2 && distance < choice.chars().count())
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, choice)| choice)
}

/// Fewest insertions, deletions and replacements of single letters that turn one word into the other
/// (Levenshtein's distance), by rows of the usual table.
fn edit_distance(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    // A word from a file may be of any length, and nothing this long is close.
    if from.chars().count() > to.len() + 2 {
        return usize::MAX;
    }
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, a) in from.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &b) in to.iter().enumerate() {
            let replace = diagonal + usize::from(a != b);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[to.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_known() {
        assert_eq!(edit_distance("", ""), 0);
        assert_eq!(edit_distance("", "ab"), 2);
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("restitution", "restitutoin"), 2);
        assert_eq!(edit_distance("disk", "disks"), 1);
        assert_eq!(edit_distance("a rather long word", "a"), usize::MAX);
    }

    #[test]
    fn only_close_words_are_offered() {
        let keys = ["disks", "mass", "diameter", "restitution"];
        assert_eq!(nearest("diks", keys), Some("disks"));
        assert_eq!(nearest("restituton", keys), Some("restitution"));
        assert_eq!(nearest("viscosity", keys), None);
        assert_eq!(nearest("x", ["ed"]), None);
        assert_eq!(nearest("", keys), None);
    }
}
