//! Comparison of two texts, word by word: numbers within their standard errors, everything else
//! exactly.

/// Largest difference of two equal numbers in standard errors. By the normal distribution, one of
/// 1000 exceeds it with probability 1e-5.
const Z: f64 = 5.7;

/// Token of a text: a word, or a number with its standard error.
#[derive(Clone, Debug, PartialEq)]
enum Token<'a> {
    Word(&'a str),
    Measured {
        text: String,
        value: f64,
        error: f64,
        /// Rounding error of the printed number: half a unit of its last digit.
        rounding: f64,
    },
}

/// Returns half a unit of the last digit of a printed number; `None` if its exponent is malformed.
fn half_digit(text: &str) -> Option<f64> {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let digits = mantissa
        .split_once('.')
        .map_or(0, |(_, digits)| digits.len());
    Some(0.5 * 10_f64.powi(exponent.parse::<i32>().ok()? - digits as i32))
}

fn tokens(text: &str) -> Vec<Token<'_>> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let number = |word: &str| {
        let bare = word.trim_end_matches([',', '.', ';', ')']);
        Some((bare.parse::<f64>().ok()?, half_digit(bare)?))
    };
    let (mut list, mut at) = (Vec::new(), 0);
    while at < words.len() {
        let error = (words.get(at + 1) == Some(&"±"))
            .then(|| words.get(at + 2))
            .flatten();
        if let Some((error_text, (value, rounding))) = error.zip(number(words[at]))
            && let Some((error, _)) = number(error_text)
        {
            list.push(Token::Measured {
                text: words[at..at + 3].join(" "),
                value,
                error,
                rounding,
            });
            at += 3;
        } else {
            list.push(Token::Word(words[at]));
            at += 1;
        }
    }
    list
}

/// Lists the differences between an old and a new text as sentences; empty if they agree.
///
/// `a ± b` agrees with `c ± d` within 5.7 standard errors of their difference and its rounding, if
/// errors are alike within a factor of two. Everything else must be the same.
pub fn differences(there: &str, here: &str) -> Vec<String> {
    let (old, new) = (tokens(there), tokens(here));
    if old.len() != new.len() {
        return vec![format!(
            "{} words and numbers stand there, {} are made",
            old.len(),
            new.len()
        )];
    }
    let parts = old.iter().zip(&new).filter_map(|pair| match pair {
        (
            Token::Measured {
                text,
                value,
                error,
                rounding,
            },
            Token::Measured {
                text: made,
                value: now,
                error: spread,
                rounding: other,
            },
        ) => {
            let slack = rounding + other;
            let near = (value - now).abs() <= Z * error.hypot(*spread) + slack;
            let alike = error <= &(2.0 * spread + slack) && spread <= &(2.0 * error + slack);
            (!near || !alike).then(|| format!("{text} stands there, {made} is found"))
        }
        (a, b) if a == b => None,
        (Token::Word(a), Token::Word(b)) => Some(format!("{a} stands there, {b} is made")),
        _ => Some("a number with an error stands in place of one without".to_owned()),
    });
    parts.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_agree_within_their_errors_and_words_exactly() {
        let text = "| 0.1 | 1.0276 ± 0.0013 | agree |";
        assert!(differences(text, text).is_empty());
        assert!(differences(text, "| 0.1 | 1.0290 ± 0.0011 | agree |").is_empty());
        for planted in [
            "| 0.1 | 1.0435 ± 0.0013 | agree |",
            "| 0.1 | 1.0276 ± 0.0130 | agree |",
            "| 0.2 | 1.0276 ± 0.0013 | agree |",
            "| 0.1 | 1.0276 ± 0.0013 | differ |",
            "| 0.1 | 1.0276 | agree |",
            "| 0.1 | 1.0276 ± 0.0013 |",
        ] {
            assert_eq!(differences(planted, text).len(), 1, "{planted}");
        }
        // The last digit of 6.0e-15 is no tenth.
        assert_eq!(
            differences("6.0e-15 ± 1.0e-16", "8.0e-15 ± 1.0e-16").len(),
            1
        );
        assert!(differences("1.207e7 ± 1e3", "1.208e7 ± 1e3").is_empty());
    }
}
