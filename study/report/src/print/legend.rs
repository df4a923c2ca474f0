//! Legend of a figure for print: inside a panel where nothing is drawn, or else above all panels.

use crate::chart::Stroke;

use super::canvas::{Area, Canvas, Pen, Segment};
use super::font::{CAPITALS, Fonts, Line, SIZE};
use super::label::{key_names, words};
use super::marks::PlacedChart;
use super::style::{CurveStyle, THIN};

/// Length of the line sample of a legend entry \[pt\].
const SAMPLE: f64 = 18.0;
/// Height of a legend line \[pt\].
pub(crate) const LEADING: f64 = 9.6;
/// Gap between the sample and the name of an entry, and around the legend \[pt\].
const GAP: f64 = 3.5;
/// Gap between legend entries on one line \[pt\].
const BETWEEN: f64 = 12.0;

/// Entry of a legend: line sample, style and name.
struct Entry {
    style: CurveStyle,
    stroke: Stroke,
    name: Line,
}

/// Legend with its entries, in the order of the curves.
pub(crate) struct Legend(Vec<Entry>);

impl Legend {
    /// Creates a legend of entries: the kind of line, and the style of each.
    pub fn new(entries: Vec<(Stroke, CurveStyle)>, fonts: &Fonts) -> Self {
        let entries = entries.into_iter().map(|(stroke, style)| Entry {
            name: fonts.line(&words(&key_names(&style.label))),
            style,
            stroke,
        });
        Self(entries.collect())
    }

    /// Finds an area inside a panel in which nothing is drawn, for one entry on each line; `None`
    /// if there is none.
    pub fn find_place(&self, chart: &PlacedChart<'_>) -> Option<Area> {
        let widest = self.0.iter().map(|one| one.name.width).fold(0.0, f64::max);
        let [width, height] = [
            SAMPLE + 3.0 * GAP + widest,
            LEADING * self.0.len() as f64 + GAP,
        ];
        let frame = &chart.area;
        // Ticks are along the edges.
        let room = [frame.width() - width - 8.0, frame.height() - height - 8.0];
        if room[0] < 0.0 || room[1] < 0.0 {
            return None;
        }
        // Corners come first, the upper right one before all.
        let shares = [[1.0, 0.0], [0.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let edges = [[0.5, 0.0], [0.5, 1.0], [1.0, 0.5], [0.0, 0.5]];
        let mut places = shares.iter().chain(&edges).map(|[x, y]| {
            let [left, top] = [
                frame.left + 4.0 + x * room[0],
                frame.top + 4.0 + y * room[1],
            ];
            Area {
                left,
                top,
                right: left + width,
                bottom: top + height,
            }
        });
        places.find(|place| {
            // Markers reach beyond their points.
            let around = Area {
                left: place.left - 2.0,
                top: place.top - 2.0,
                right: place.right + 2.0,
                bottom: place.bottom + 2.0,
            };
            !chart.meets(&around)
        })
    }

    /// Computes the height of the legend above panels, wrapped at a width \[pt\].
    pub fn height(&self, width: f64) -> f64 {
        let lines = self.lines(width).last().map_or(0, |(line, _)| line + 1);
        LEADING * lines as f64
    }

    /// Computes line number and horizontal position of each entry, wrapped at a width \[pt\].
    fn lines(&self, width: f64) -> Vec<(usize, f64)> {
        let (mut line, mut x) = (0, 0.0);
        let places = self.0.iter().map(|entry| {
            let wide = SAMPLE + GAP + entry.name.width;
            if x > 0.0 && x + wide > width {
                (line, x) = (line + 1, 0.0);
            }
            let place = (line, x);
            x += wide + BETWEEN;
            place
        });
        places.collect()
    }

    /// Draws the legend above the panels, from the upper left corner of an area.
    pub fn draw_above(self, canvas: &mut Canvas, area: &Area) {
        let lines = self.lines(area.width());
        for (entry, (line, x)) in self.0.into_iter().zip(lines) {
            let y = area.top + LEADING * (line as f64 + 0.5);
            entry.draw(canvas, [area.left + x, y]);
        }
    }

    /// Draws the legend inside a panel, in a given area.
    pub fn draw_inside(self, canvas: &mut Canvas, area: &Area) {
        for (line, entry) in self.0.into_iter().enumerate() {
            let y = area.top + 0.5 * GAP + LEADING * (line as f64 + 0.5);
            entry.draw(canvas, [area.left + GAP, y]);
        }
    }
}

impl Entry {
    /// Draws line sample and name of the entry, vertically centred on a point \[pt\].
    fn draw(self, canvas: &mut Canvas, [x, y]: [f64; 2]) {
        let ends = [[x, y], [x + SAMPLE, y]];
        match (self.stroke, self.style.pen) {
            (Stroke::Bars, pen) => {
                let bar = Area {
                    left: x + 2.0,
                    top: y - 0.4 * SIZE,
                    right: x + SAMPLE - 2.0,
                    bottom: y + 0.4 * SIZE,
                };
                canvas.path(bar.outline(), self.style.bars, pen);
            }
            (_, Some(pen)) => {
                canvas.stroke(vec![Segment::Move(ends[0]), Segment::Line(ends[1])], pen);
            }
            (_, None) => {}
        }
        if let Some((path, fill)) = self.style.mark([x + 0.5 * SAMPLE, y]) {
            canvas.path(path, Some(fill), Some(Pen::solid(THIN, self.style.colour)));
        }
        let base = [x + SAMPLE + GAP, y + 0.5 * CAPITALS * SIZE];
        let text = self.name.place(base, 0.0, false);
        canvas.items.push(super::canvas::Item::Text(text));
    }
}
