//! Formatting of labels as papers print them: oblique symbols, raised exponents, lowered indices,
//! units.
//!
//! Reports write labels as plain text, such as `S_perp(k)`, `t/t0` or `<R²>`. Words stay upright,
//! and so do units in square brackets.

/// Vertical level of text: base line, exponent or index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Level {
    /// Text on the base line.
    Base,
    /// Exponent: small raised text.
    Exponent,
    /// Index: small lowered text.
    Index,
}

/// Run of text with one style: upright or oblique, and its level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    /// Text of the run.
    pub text: String,
    /// True for symbols of quantities, which are printed in oblique letters.
    pub oblique: bool,
    /// Vertical level of the run.
    pub level: Level,
}

/// Superscript characters, each with its character on the base line.
const EXPONENTS: [(char, char); 12] = [
    ('⁰', '0'),
    ('¹', '1'),
    ('²', '2'),
    ('³', '3'),
    ('⁴', '4'),
    ('⁵', '5'),
    ('⁶', '6'),
    ('⁷', '7'),
    ('⁸', '8'),
    ('⁹', '9'),
    ('⁻', '−'),
    ('⁺', '+'),
];
/// Subscript characters, each with its character on the base line.
const INDICES: [(char, char); 14] = [
    ('₀', '0'),
    ('₁', '1'),
    ('₂', '2'),
    ('₃', '3'),
    ('₄', '4'),
    ('₅', '5'),
    ('₆', '6'),
    ('₇', '7'),
    ('₈', '8'),
    ('₉', '9'),
    ('₋', '−'),
    ('₊', '+'),
    ('ᵢ', 'i'),
    ('ᵥ', 'v'),
];

/// Builder of runs of text; adjacent text of one style is joined.
#[derive(Default)]
struct Runs(Vec<Run>);

impl Runs {
    fn push(&mut self, letter: char, oblique: bool, level: Level) {
        match self.0.last_mut() {
            Some(last) if last.oblique == oblique && last.level == level => last.text.push(letter),
            _ => self.0.push(Run {
                text: letter.into(),
                oblique,
                level,
            }),
        }
    }

    /// Adds a character; superscript and subscript characters become raised or lowered text.
    fn push_plain(&mut self, letter: char) {
        let of = |all: &[(char, char)]| all.iter().find(|one| one.0 == letter).map(|one| one.1);
        match (of(&EXPONENTS), of(&INDICES)) {
            (Some(sign), _) => self.push(sign, false, Level::Exponent),
            (None, Some(sign)) => self.push(sign, sign.is_alphabetic(), Level::Index),
            (None, None) => self.push(letter, false, Level::Base),
        }
    }
}

/// Splits text of words and numbers into runs; only superscripts and subscripts change the style.
pub(crate) fn words(text: &str) -> Vec<Run> {
    let mut runs = Runs::default();
    let letters: Vec<char> = text.chars().collect();
    for (place, letter) in letters.iter().enumerate() {
        let digit = |at: Option<usize>| {
            at.and_then(|at| letters.get(at))
                .is_some_and(char::is_ascii_digit)
        };
        match letter {
            // A product of a number and a power of ten.
            '·' if digit(place.checked_sub(1)) && digit(Some(place + 1)) => runs.push_plain('×'),
            other => runs.push_plain(*other),
        }
    }
    runs.0
}

/// Formats the label of an axis as runs of text, with its unit unless the label contains one.
pub(crate) fn axis(label: &str, unit: &str) -> Vec<Run> {
    symbols(&label_text(label, unit))
}

/// Returns the label of an axis as plain text, with its unit.
pub(crate) fn label_text(label: &str, unit: &str) -> String {
    format!("{}{}", key_names(label), unit_suffix(label, unit))
}

/// Replaces names of case keys and columns in a text by words: `box.packing_fraction` becomes
/// `packing fraction`. Indices as in `velocity_x` are kept.
pub(crate) fn key_names(text: &str) -> String {
    let word = |word: &str| {
        let name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "._-".contains(c);
        let last = word.rsplit_once('.').map_or(word, |(_, last)| last);
        let is_key = word.chars().all(name) && word.starts_with(|c: char| c.is_ascii_lowercase());
        if !is_key || !last.starts_with(|c: char| c.is_ascii_lowercase()) {
            return word.to_owned();
        }
        let parts: Vec<&str> = last.split('_').collect();
        match parts[..] {
            // An index after one letter, or an index of one letter.
            [first, index] if first.len() == 1 || index.len() == 1 => last.to_owned(),
            _ => parts.join(" "),
        }
    };
    text.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

/// Formats a unit in square brackets for the end of a label; empty if no unit is shown.
fn unit_suffix(label: &str, unit: &str) -> String {
    shown_unit(label, unit).map_or(String::new(), |unit| format!(" [{unit}]"))
}

/// Returns the unit to show with a label, if any. Pure numbers, words, labels that contain a unit,
/// and units of the case have none.
fn shown_unit<'a>(label: &str, unit: &'a str) -> Option<&'a str> {
    let words = ["length", "time", "mass", "energy", "speed", "quantity"];
    let is_named = !["", "1"].contains(&unit) && !words.iter().any(|word| unit.contains(word));
    match unit {
        _ if !is_named || label.contains(['[', '/']) => None,
        "percent" => Some("%"),
        unit => Some(unit),
    }
}

/// Formats a label, with its unit or one line of it, as runs of text with oblique symbols.
pub(crate) fn symbols(label: &str) -> Vec<Run> {
    let means = label.contains('<') && label.contains('>');
    let letters: Vec<char> = label.chars().collect();
    let at = |place: usize| letters.get(place).copied();
    let before = |place: usize| place.checked_sub(1).and_then(at);
    let small = |c: char| EXPONENTS.iter().chain(&INDICES).any(|one| one.0 == c);
    let of_word =
        |c: char| (c.is_alphabetic() && !small(c)) || c.is_ascii_digit() || "'.".contains(c);
    let joins = |letter: Option<char>| letter.is_some_and(of_word);
    // The article, also at the end of a line.
    let parts = |letter: Option<char>| letter.is_none_or(|c| c == ' ');
    let (mut runs, mut place, mut unit) = (Runs::default(), 0, false);
    while let Some(letter) = at(place) {
        unit = (unit || letter == '[') && letter != ']';
        let digits = letters[place + 1..]
            .iter()
            .take_while(|c| c.is_ascii_digit())
            .count();
        let after = at(place + 1 + digits);
        // A letter that is alone, but for an index.
        let is_symbol = (is_latin(letter) || is_small_greek(letter))
            && !unit
            && !joins(before(place))
            && !joins(after)
            && !(letter == 'a' && letters.len() > 2 && parts(before(place)) && parts(after));
        place += 1;
        match letter {
            '<' if means => runs.push('⟨', false, Level::Base),
            '>' if means => runs.push('⟩', false, Level::Base),
            '-' if before(place - 1) == Some(' ') && at(place) == Some(' ') => {
                runs.push('−', false, Level::Base);
            }
            // An index of one letter after a word.
            '_' if at(place).is_some_and(is_latin) && !joins(at(place + 1)) => {
                runs.push(letters[place], true, Level::Index);
                place += 1;
            }
            '^' => {
                while let Some(raised) = at(place).filter(|c| c.is_alphanumeric() || *c == '-') {
                    runs.push(
                        if raised == '-' { '−' } else { raised },
                        false,
                        Level::Exponent,
                    );
                    place += 1;
                }
            }
            _ if is_symbol => {
                runs.push(letter, true, Level::Base);
                for _ in 0..digits {
                    runs.push(letters[place], false, Level::Index);
                    place += 1;
                }
                if at(place) == Some('_') {
                    let index: String = letters[place + 1..]
                        .iter()
                        .take_while(|c| c.is_alphanumeric())
                        .collect();
                    place += 1 + index.chars().count();
                    let index = if index == "perp" {
                        "⊥".to_owned()
                    } else {
                        index
                    };
                    // Short indices are symbols, such as those of species; others are words.
                    let oblique = index.chars().count() <= 2;
                    for letter in index.chars() {
                        runs.push(letter, oblique && letter.is_alphabetic(), Level::Index);
                    }
                }
            }
            other => runs.push_plain(other),
        }
    }
    runs.0
}

fn is_latin(letter: char) -> bool {
    letter.is_ascii_alphabetic()
}

fn is_small_greek(letter: char) -> bool {
    ('α'..='ω').contains(&letter)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs in a short form: `*` around symbols, `^` and `_` before raised and lowered text.
    fn short(runs: &[Run]) -> String {
        let one = |run: &Run| {
            let level = match run.level {
                Level::Base => "",
                Level::Exponent => "^",
                Level::Index => "_",
            };
            let star = if run.oblique { "*" } else { "" };
            format!("{level}{star}{}{star}", run.text)
        };
        runs.iter().map(one).collect()
    }

    #[test]
    fn labels_are_set_as_in_papers() {
        for (label, unit, set) in [
            ("K(t) / K(0)", "1", "*K*(*t*) / *K*(0)"),
            ("t/t0", "time", "*t*/*t*_0"),
            ("a2", "1", "*a*_2"),
            ("τ₁", "time", "*τ*_1"),
            ("S_perp(k)", "1", "*S*_⊥(*k*)"),
            ("g_ab(r)", "1", "*g*_*ab*(*r*)"),
            ("<R²>", "length^2", "⟨*R*^2⟩"),
            ("1 - r", "1", "1 − *r*"),
            ("viscosity over Enskog's", "1", "viscosity over Enskog's"),
            ("speed of a disk", "m/s", "speed of a disk [m/s]"),
            ("number density", "1/m^2", "number density [1/m^2]"),
            ("core time [s]", "s", "core time [s]"),
            ("time", "s", "time [s]"),
            ("time", "unit of time", "time"),
            ("gas.packing_fraction", "1", "packing fraction"),
            ("engine.dsmc-homogeneous.selection", "", "selection"),
            ("number_density", "1/length^D", "number density"),
            ("velocity_x", "m/s", "velocity_*x* [m/s]"),
            ("clusters of k monomers", "1", "clusters of *k* monomers"),
            (
                "mode number L/wavelength",
                "1",
                "mode number *L*/wavelength",
            ),
        ] {
            assert_eq!(short(&axis(label, unit)), set, "{label}");
        }
        assert_eq!(short(&words("2·10⁻³")), "2×10^−3");
        assert_eq!(short(&words("k 2, a")), "k 2, a");
    }
}
