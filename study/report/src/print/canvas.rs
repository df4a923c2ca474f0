//! Vector drawing as paths and lines of text in points, from which SVG and PDF are written.
//!
//! Nothing is clipped by the file formats: lines are cut at the frame of their panel here, so that
//! programs for drawings find plain paths, and drawings on one page need no identifiers.

/// Colour of a line or area: red, green and blue from 0 to 255.
pub(crate) type Colour = [u8; 3];

/// Black, the colour of axes and text.
pub(crate) const BLACK: Colour = [0, 0, 0];
/// White, the colour of the paper and of open markers.
pub(crate) const WHITE: Colour = [255, 255, 255];

/// Segment of a path; coordinates \[pt\] from the upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Segment {
    /// Start of a subpath, at a point.
    Move([f64; 2]),
    /// Straight line to a point.
    Line([f64; 2]),
    /// Cubic Bézier curve: two control points and the end.
    Curve([f64; 2], [f64; 2], [f64; 2]),
    /// Straight line back to the start of the subpath.
    Close,
}

/// Pen of a stroked path: line width, colour and dashes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pen {
    /// Width of the line \[pt\].
    pub width: f64,
    /// Colour of the line.
    pub colour: Colour,
    /// Lengths of dashes and gaps \[pt\]; empty for a solid line.
    pub dash: &'static [f64],
}

impl Pen {
    /// Creates a pen for solid lines.
    pub const fn solid(width: f64, colour: Colour) -> Self {
        Self {
            width,
            colour,
            dash: &[],
        }
    }
}

/// Element of a vector drawing: a path, or a line of text.
#[derive(Clone, Debug)]
pub(crate) enum Item {
    /// Path that is filled, stroked, or both.
    Path {
        /// Segments of the path.
        segments: Vec<Segment>,
        /// Fill colour inside the path; `None` if it is not filled.
        fill: Option<Colour>,
        /// Pen of the outline; `None` if the path is not stroked.
        pen: Option<Pen>,
    },
    /// Line of text at a position.
    Text(Text),
}

/// Line of text placed on a drawing.
#[derive(Clone, Debug)]
pub(crate) struct Text {
    /// Start of the text's base line \[pt\].
    pub at: [f64; 2],
    /// True for text that is turned by 90° and runs upwards.
    pub upwards: bool,
    /// Glyphs of the text with their places on the base line.
    pub glyphs: Vec<Glyph>,
}

/// Glyph: one letter of a line of text, with its font and position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Glyph {
    /// Index of the font: 0 upright, 1 oblique.
    pub font: usize,
    /// Index of the glyph in the font; 0 if the font lacks the letter.
    pub id: u16,
    /// Letter that the glyph shows.
    pub letter: char,
    /// Position of the glyph along the base line and above it \[pt\].
    pub at: [f64; 2],
    /// Font size of the glyph \[pt\].
    pub size: f64,
}

/// Drawing of a figure in points, with the origin in the upper left corner.
#[derive(Clone, Debug, Default)]
pub(crate) struct Canvas {
    /// Width and height of the drawing \[pt\].
    pub size: [f64; 2],
    /// Elements of the drawing, in the order in which they are drawn.
    pub items: Vec<Item>,
}

impl Canvas {
    /// Adds a stroked path to the drawing, unless it is empty.
    pub fn stroke(&mut self, segments: Vec<Segment>, pen: Pen) {
        self.path(segments, None, Some(pen));
    }

    /// Adds a filled or stroked path to the drawing, unless it is empty.
    pub fn path(&mut self, segments: Vec<Segment>, fill: Option<Colour>, pen: Option<Pen>) {
        if !segments.is_empty() {
            self.items.push(Item::Path {
                segments,
                fill,
                pen,
            });
        }
    }
}

/// Rectangular area of a drawing, with its edges \[pt\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Area {
    /// Left edge of the area \[pt\].
    pub left: f64,
    /// Upper edge of the area \[pt\].
    pub top: f64,
    /// Right edge of the area \[pt\].
    pub right: f64,
    /// Lower edge of the area \[pt\].
    pub bottom: f64,
}

impl Area {
    /// Returns the width of the area \[pt\].
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    /// Returns the height of the plot area, between the axes of a figure \[pt\].
    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// Returns the point at given shares of width and height, counted from the lower left corner
    /// \[pt\].
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            self.left + x * self.width(),
            self.bottom - y * self.height(),
        ]
    }

    /// Returns true if a point is inside the area, or at most `room` outside \[pt\].
    pub fn holds(&self, [x, y]: [f64; 2], room: f64) -> bool {
        (self.left - room..=self.right + room).contains(&x)
            && (self.top - room..=self.bottom + room).contains(&y)
    }

    /// Returns the point of the area that is closest to a given point \[pt\].
    pub fn clamp(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            x.clamp(self.left, self.right.max(self.left)),
            y.clamp(self.top, self.bottom.max(self.top)),
        ]
    }

    /// Returns the closed path along the edges of the area.
    pub fn outline(&self) -> Vec<Segment> {
        vec![
            Segment::Move([self.left, self.top]),
            Segment::Line([self.right, self.top]),
            Segment::Line([self.right, self.bottom]),
            Segment::Line([self.left, self.bottom]),
            Segment::Close,
        ]
    }

    /// Clips a straight line to the area; `None` if all of it is outside (Liang-Barsky algorithm).
    pub fn cut(&self, from: [f64; 2], to: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let step = [to[0] - from[0], to[1] - from[1]];
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        let edges = [[self.left, self.right], [self.top, self.bottom]];
        for axis in 0..2 {
            let [low, high] = edges[axis].map(|edge| edge - from[axis]);
            if step[axis] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let ends = [low / step[axis], high / step[axis]];
            first = first.max(ends[0].min(ends[1]));
            last = last.min(ends[0].max(ends[1]));
        }
        let at = |share: f64| [from[0] + share * step[0], from[1] + share * step[1]];
        // An end that is inside is not moved by rounding.
        (first <= last).then(|| {
            [
                if first > 0.0 { at(first) } else { from },
                if last < 1.0 { at(last) } else { to },
            ]
        })
    }

    /// Clips the polyline through some points to the area, and returns its path. `None` among the
    /// points interrupts the polyline.
    pub fn cut_line(&self, points: &[Option<[f64; 2]>]) -> Vec<Segment> {
        let mut segments = Vec::new();
        let mut pen: Option<[f64; 2]> = None;
        for pair in points.windows(2) {
            let part = match pair {
                [Some(from), Some(to)] => self.cut(*from, *to),
                _ => None,
            };
            let Some([from, to]) = part else {
                pen = None;
                continue;
            };
            if pen != Some(from) {
                segments.push(Segment::Move(from));
            }
            segments.push(Segment::Line(to));
            pen = Some(to);
        }
        segments
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_at_the_frame() {
        let area = Area {
            left: 0.0,
            top: 0.0,
            right: 4.0,
            bottom: 2.0,
        };
        assert_eq!(
            area.cut([-2.0, 1.0], [2.0, 1.0]),
            Some([[0.0, 1.0], [2.0, 1.0]])
        );
        assert_eq!(area.cut([1.0, 3.0], [3.0, 3.0]), None);
        assert_eq!(area.cut([1.0, -1.0], [1.0, -0.5]), None);
        let line = area.cut_line(&[
            Some([1.0, 1.0]),
            Some([2.0, 1.0]),
            Some([2.0, 4.0]),
            None,
            Some([3.0, 1.0]),
            Some([9.0, 1.0]),
        ]);
        let found = [
            Segment::Move([1.0, 1.0]),
            Segment::Line([2.0, 1.0]),
            Segment::Line([2.0, 2.0]),
            Segment::Move([3.0, 1.0]),
            Segment::Line([4.0, 1.0]),
        ];
        assert_eq!(line, found);
    }
}
