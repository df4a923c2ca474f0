//! Letters: the fonts of this crate, and lines of text set in them.

use ttf_parser::{Face, GlyphId, OutlineBuilder};

use super::canvas::{Segment, Text};
use super::label::{Level, Run};

/// Font files: upright and oblique.
pub(crate) const FILES: [&[u8]; 2] = [
    include_bytes!("../../vendor/dejavu/DejaVuSansCondensed.ttf"),
    include_bytes!("../../vendor/dejavu/DejaVuSansCondensed-Oblique.ttf"),
];
/// Names of the fonts.
pub(crate) const NAMES: [&str; 2] = ["DejaVuSansCondensed", "DejaVuSansCondensed-Oblique"];
/// Size of text \[pt\].
pub(crate) const SIZE: f64 = 8.0;
/// Size of indices and exponents, in the size of the text.
const SMALL: f64 = 0.72;
/// Shift of exponents upwards and of indices downwards, in the size of the text.
const SHIFTS: [f64; 2] = [0.36, -0.17];

/// Letter of a line of text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Glyph {
    /// Number of the font in [`FILES`].
    pub font: usize,
    /// Number of the glyph in the font; 0 where the font has no such letter.
    pub id: u16,
    /// Letter that is shown.
    pub letter: char,
    /// Place on the base line, and above it \[pt\].
    pub at: [f64; 2],
    /// Size of the font \[pt\].
    pub size: f64,
}

/// Line of text that is not placed yet.
#[derive(Clone, Debug, Default)]
pub(crate) struct Line {
    /// Letters, from the start of the line.
    pub glyphs: Vec<Glyph>,
    /// Width of the line \[pt\].
    pub width: f64,
}

/// Fonts that text is set in.
pub(crate) struct Fonts([Face<'static>; 2]);

impl Fonts {
    /// Reads the fonts of this crate.
    pub fn new() -> Self {
        // A damaged file would fail all tests of this module.
        Self(FILES.map(|file| Face::parse(file, 0).expect("a font of this crate")))
    }

    /// Font by its number.
    pub fn face(&self, font: usize) -> &Face<'static> {
        &self.0[font]
    }

    /// Width of a glyph, in the size of the font.
    pub fn advance(&self, font: usize, id: u16) -> f64 {
        let face = self.face(font);
        let width = face.glyph_hor_advance(GlyphId(id)).unwrap_or(0);
        f64::from(width) / f64::from(face.units_per_em())
    }

    /// Sets some runs of text as a line.
    pub fn line(&self, runs: &[Run]) -> Line {
        let mut line = Line::default();
        for run in runs {
            let (size, rise) = match run.level {
                Level::Base => (SIZE, 0.0),
                Level::Exponent => (SMALL * SIZE, SHIFTS[0] * SIZE),
                Level::Index => (SMALL * SIZE, SHIFTS[1] * SIZE),
            };
            for letter in run.text.chars() {
                // The oblique font has letters only: digits and signs are upright.
                let wanted = usize::from(run.oblique);
                let found = [wanted, 0].into_iter().find_map(|font| {
                    let id = self.face(font).glyph_index(letter)?;
                    Some((font, id.0))
                });
                let (font, id) = found.unwrap_or((0, 0));
                line.glyphs.push(Glyph {
                    font,
                    id,
                    letter,
                    at: [line.width, rise],
                    size,
                });
                line.width += size * self.advance(font, id);
            }
        }
        line
    }

    /// Outline of a glyph at the origin of the base line, for a size of 1 and with y upwards.
    pub fn outline(&self, font: usize, id: u16) -> Vec<Segment> {
        let face = self.face(font);
        let mut outline = Outline {
            scale: 1.0 / f64::from(face.units_per_em()),
            segments: Vec::new(),
            last: [0.0; 2],
        };
        face.outline_glyph(GlyphId(id), &mut outline);
        outline.segments
    }
}

impl Line {
    /// Places the line so that `share` of its width is left of a point; `upwards` turns it.
    pub fn place(self, [x, y]: [f64; 2], share: f64, upwards: bool) -> Text {
        let back = share * self.width;
        Text {
            at: if upwards {
                [x, y + back]
            } else {
                [x - back, y]
            },
            upwards,
            glyphs: self.glyphs,
        }
    }
}

/// Height of capital letters, in the size of the text.
pub(crate) const CAPITALS: f64 = 0.73;

/// Collector of the outline of a glyph.
struct Outline {
    scale: f64,
    segments: Vec<Segment>,
    last: [f64; 2],
}

impl Outline {
    fn point(&self, x: f32, y: f32) -> [f64; 2] {
        [x, y].map(|part| f64::from(part) * self.scale)
    }
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.last = self.point(x, y);
        self.segments.push(Segment::Move(self.last));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.last = self.point(x, y);
        self.segments.push(Segment::Line(self.last));
    }

    /// Adds a quadratic curve, as the cubic curve that is equal to it.
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (control, end) = (self.point(x1, y1), self.point(x, y));
        let mix = |from: [f64; 2]| [0, 1].map(|i| from[i] + 2.0 / 3.0 * (control[i] - from[i]));
        self.segments
            .push(Segment::Curve(mix(self.last), mix(end), end));
        self.last = end;
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let [one, two] = [self.point(x1, y1), self.point(x2, y2)];
        self.last = self.point(x, y);
        self.segments.push(Segment::Curve(one, two, self.last));
    }

    fn close(&mut self) {
        self.segments.push(Segment::Close);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::print::label;

    /// Every letter of labels, titles and numbers of this program is in the fonts.
    #[test]
    fn fonts_have_the_letters_of_labels() {
        let fonts = Fonts::new();
        let text = "AZaz09 .,;:'\"()[]<>=+-/|_^%&é−·×±≤≥⟨⟩⊥χτδθπωηλμνΔΣΩΓ√∂∞²³⁴⁶⁻⁰¹₀₁₂₍₎ᵢᵥ⅔½∫≠∅✓–“”üöóíαβγ";
        let line = fonts.line(&label::words(text));
        let absent: Vec<char> = (line.glyphs.iter())
            .filter(|glyph| glyph.id == 0)
            .map(|glyph| glyph.letter)
            .collect();
        assert!(absent.is_empty(), "{absent:?}");
        assert_eq!(fonts.line(&label::words("球")).glyphs[0].id, 0);
    }

    #[test]
    fn outlines_are_closed_and_as_high_as_capitals() {
        let fonts = Fonts::new();
        let line = fonts.line(&label::words("H"));
        let outline = fonts.outline(0, line.glyphs[0].id);
        assert_eq!(outline.last(), Some(&Segment::Close));
        let top = outline.iter().fold(0.0_f64, |top, segment| match segment {
            Segment::Move(at) | Segment::Line(at) | Segment::Curve(_, _, at) => top.max(at[1]),
            Segment::Close => top,
        });
        // 1493 of 2048 units, by the font's own table of names and sizes.
        assert!((top - CAPITALS).abs() < 0.005, "{top}");
    }
}
