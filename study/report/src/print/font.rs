//! Fonts of figures for print, and layout of lines of text with glyph positions.

use ttf_parser::{Face, GlyphId, OutlineBuilder};

use super::canvas::{Glyph, Segment, Text};
use super::label::{Level, Run};

/// Embedded font files: upright and oblique.
pub(crate) const FILES: [&[u8]; 2] = [
    include_bytes!("../../vendor/dejavu/DejaVuSansCondensed.ttf"),
    include_bytes!("../../vendor/dejavu/DejaVuSansCondensed-Oblique.ttf"),
];
/// Names of the embedded fonts: upright and oblique.
pub(crate) const NAMES: [&str; 2] = ["DejaVuSansCondensed", "DejaVuSansCondensed-Oblique"];
/// Font size of text in figures \[pt\].
pub(crate) const SIZE: f64 = 8.0;
/// Font size of indices and exponents, in units of that of the text.
const SMALL: f64 = 0.72;
/// Shift of the base line of exponents (up) and indices (down), in units of the font size.
const SHIFTS: [f64; 2] = [0.36, -0.17];

/// Line of text before it is placed: glyphs and width.
#[derive(Clone, Debug, Default)]
pub(crate) struct Line {
    /// Glyphs of the text, from the start of the line.
    pub glyphs: Vec<Glyph>,
    /// Width of the line of text \[pt\].
    pub width: f64,
}

/// Parsed fonts: upright and oblique.
pub(crate) struct Fonts([Face<'static>; 2]);

impl Fonts {
    /// Parses the embedded font files.
    pub fn new() -> Self {
        // A damaged file would fail all tests of this module.
        Self(FILES.map(|file| Face::parse(file, 0).expect("a font of this crate")))
    }

    /// Returns a font by its index: 0 upright, 1 oblique.
    pub fn face(&self, font: usize) -> &Face<'static> {
        &self.0[font]
    }

    /// Returns the advance width of a glyph, in units of the font size.
    pub fn advance(&self, font: usize, id: u16) -> f64 {
        let face = self.face(font);
        let width = face.glyph_hor_advance(GlyphId(id)).unwrap_or(0);
        f64::from(width) / f64::from(face.units_per_em())
    }

    /// Lays out runs of text, each of one style, as a line of glyphs.
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

    /// Returns the outline of a glyph as a path, for a font size of 1, with its origin on the base
    /// line and y upwards.
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
    /// Places the line of text at a point, with `share` of its width left of the point; `upwards`
    /// turns it by 90°.
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

/// Height of capital letters, in units of the font size.
pub(crate) const CAPITALS: f64 = 0.73;

/// Collector of path segments while a font's glyph outline is read.
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

    /// Adds a quadratic Bézier curve, converted to the equal cubic one.
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
