//! Layout of a figure for print: panels in rows, with axes, labels, letters and a legend.

use crate::figure::{Drawn, Panel, Subject};
use crate::scale::{AxisRange, Tick};

use super::canvas::{Area, BLACK, Canvas, Item, Pen, Segment};
use super::font::{CAPITALS, Fonts, Line, SIZE};
use super::label::{self, Run, key_names};
use super::legend::{LEADING, Legend};
use super::marks::{PlacedChart, draw_bar, draw_map};
use super::style::{CurveStyle, FRAME, entries, styles};

/// Lengths of ticks with and without a number \[pt\].
const TICKS: [f64; 2] = [3.2, 1.8];
/// Gap between ticks, their numbers and the label of the axis \[pt\].
const GAP: f64 = 3.0;
/// Smallest gap between the numbers of two ticks \[pt\].
const APART: f64 = 4.0;
/// Margin around the drawing, for lines on its edge \[pt\].
const MARGIN: f64 = 1.0;
/// Width of a figure from which three panels stand in a row \[pt\].
const WIDE: f64 = 340.0;
/// Largest height of a drawing: the height of the text on a page, 230 mm \[pt\].
const TALLEST: f64 = 652.0;
/// Largest and smallest height of the frame of a panel \[pt\].
const HEIGHTS: [f64; 2] = [210.0, 42.0];
/// Height over width of the frame of a chart in print.
const ASPECT: f64 = 0.72;
/// Width of a colour bar \[pt\].
const BAR: f64 = 7.0;

/// Axes of a panel with their ticks and labels.
struct Axes {
    frames: [AxisRange; 2],
    ticks: [Vec<Tick>; 2],
    labels: [(String, String); 2],
    /// Colour bar of a map: its range, label and unit.
    bar: Option<(AxisRange, String, String)>,
}

impl Axes {
    fn new(subject: &Subject) -> Self {
        match subject {
            Subject::Chart(chart) => {
                let (x, y) = chart.frames();
                Self {
                    ticks: [chart.x.ticks(&x), chart.y.ticks(&y)],
                    frames: [x, y],
                    labels: [&chart.x, &chart.y]
                        .map(|axis| (axis.label.clone(), axis.unit.clone())),
                    bar: None,
                }
            }
            Subject::Map { map, range, .. } => {
                let ends = map.ends();
                let frames = ends.map(|ends| {
                    AxisRange::range_around(stosszahl_results::AxisScale::Linear, ends, true)
                });
                let label = |axis: usize| (map.labels[axis].clone(), map.units[axis].clone());
                let (low, high) = *range;
                Self {
                    ticks: frames.map(|frame| frame.ticks()),
                    frames,
                    labels: [label(0), label(1)],
                    bar: Some((
                        AxisRange::range_around(map.scale, *range, high > low),
                        map.value.clone(),
                        map.units[2].clone(),
                    )),
                }
            }
        }
    }
}

/// Lengths of the layout of a figure for print \[pt\].
struct Lengths {
    /// Space left of each column of panels, for vertical axes \[pt\].
    left: Vec<f64>,
    /// Width and height of the frame of a panel \[pt\].
    frame: [f64; 2],
    /// Space for titles above each row of panels \[pt\].
    titles: Vec<f64>,
    /// Space for ticks and axis label below a row of panels that has them \[pt\].
    below: f64,
    /// Space for the legend above all panels; 0 if the legend is inside a panel \[pt\].
    legend: f64,
}

/// Figure with the choices of its layout for print.
struct Arrangement<'a> {
    fonts: &'a Fonts,
    drawn: &'a Drawn,
    axes: Vec<Axes>,
    /// Number of panels in each row.
    across: usize,
    /// True if all panels have a common horizontal axis, and a common vertical axis.
    shared: [bool; 2],
    /// True if the names on the horizontal axis are turned upwards, because they are too long.
    turned: bool,
    width: f64,
}

/// Draws a figure for print with a width \[pt\].
pub(crate) fn lay_out(drawn: &Drawn, width: f64, fonts: &Fonts) -> Canvas {
    let axes: Vec<Axes> = drawn
        .panels
        .iter()
        .map(|panel| Axes::new(&panel.subject))
        .collect();
    let common = |axis: usize| {
        axes.iter()
            .all(|one| one.frames[axis] == axes[0].frames[axis])
    };
    let shared = [common(0), common(1)];
    let mut arrangement = Arrangement {
        fonts,
        drawn,
        across: columns(drawn.panels.len(), width),
        shared,
        axes,
        turned: false,
        width,
    };
    arrangement.turned = arrangement.names_are_crowded();
    arrangement.draw()
}

/// Chooses the number of panels in a row for a width \[pt\].
fn columns(panels: usize, width: f64) -> usize {
    match panels {
        _ if width < WIDE && panels < 4 => 1,
        _ if width < WIDE => 2,
        0 | 1 => 1,
        2 | 4 => 2,
        _ => 3,
    }
}

impl Arrangement<'_> {
    fn words(&self, text: &str) -> Line {
        self.fonts.line(&label::words(text))
    }

    fn rows(&self) -> usize {
        self.axes.len().div_ceil(self.across)
    }

    /// Returns the width of the widest tick label \[pt\].
    fn widest(&self, ticks: &[Tick]) -> f64 {
        let labels = ticks.iter().filter_map(|tick| tick.1.as_ref());
        labels
            .map(|text| self.words(text).width)
            .fold(0.0, f64::max)
    }

    /// Returns true if the names on the horizontal axis do not fit next to each other.
    fn names_are_crowded(&self) -> bool {
        let room = 0.8 * self.width / self.across as f64;
        self.drawn.panels.iter().any(|panel| match &panel.subject {
            Subject::Chart(chart) => {
                let names = chart.x.names.iter();
                let widest = names
                    .map(|name| self.words(name).width + APART)
                    .fold(0.0, f64::max);
                widest * chart.x.names.len() as f64 > room
            }
            Subject::Map { .. } => false,
        })
    }

    /// Returns true if no panel is below this one in its column.
    fn is_lowest(&self, number: usize) -> bool {
        number + self.across >= self.axes.len()
    }

    /// Returns whether a panel shows the numbers of its horizontal axis, and those of its vertical
    /// axis.
    fn shows(&self, number: usize) -> [bool; 2] {
        [
            !self.shared[0] || self.is_lowest(number),
            !self.shared[1] || number.is_multiple_of(self.across),
        ]
    }

    /// Wraps text into lines of limited width \[pt\]. Lines break after spaces and commas, and
    /// inside words only where a word alone is too long.
    fn wrapped(&self, text: &str, limit: f64, set: impl Fn(&str) -> Vec<Run>) -> Vec<Line> {
        let fits = |line: &str| self.fonts.line(&set(line.trim_end())).width <= limit;
        let mut lines = vec![String::new()];
        for part in text.split_inclusive([' ', ',']) {
            let last = lines.len() - 1;
            let longer = format!("{}{part}", lines[last]);
            if fits(&longer) {
                lines[last] = longer;
                continue;
            }
            lines.push(String::new());
            for letter in part.chars() {
                let last = lines.len() - 1;
                if !lines[last].is_empty() && !fits(&format!("{}{letter}", lines[last])) {
                    lines.push(String::new());
                }
                lines.last_mut().expect("a line").push(letter);
            }
        }
        let lines = lines
            .iter()
            .map(|line| line.trim_end())
            .filter(|line| !line.is_empty());
        lines.map(|line| self.fonts.line(&set(line))).collect()
    }

    /// Wraps the label of an axis, with its unit, into lines of limited width \[pt\].
    fn axis_label(&self, (text, unit): &(String, String), limit: f64) -> Vec<Line> {
        let whole = self.fonts.line(&label::axis(text, unit));
        if whole.width <= limit {
            return vec![whole];
        }
        self.wrapped(&label::label_text(text, unit), limit, label::symbols)
    }

    /// Returns the title of a panel, with its letter (a), (b) and so on if there are several.
    fn title(&self, number: usize) -> String {
        let Panel { title, subject, .. } = &self.drawn.panels[number];
        // The quantity of a map is at its colour bar.
        let title = match subject {
            Subject::Map { map, .. } => title
                .strip_prefix(&*map.value)
                .map_or(&**title, |rest| rest.trim_start_matches(", ")),
            Subject::Chart(_) => title,
        };
        // Points of a sweep are named by keys and values.
        let title = match title.strip_prefix("point ") {
            Some(point) => point.replace(',', ", ").replace('=', " = "),
            None => title.to_owned(),
        };
        let title = key_names(&title);
        let letter = char::from(b'a' + (number % 26) as u8);
        match self.axes.len() {
            1 => title,
            _ => format!("({letter}) {title}").trim_end().to_owned(),
        }
    }

    /// Computes the lengths of the layout; labels of the vertical axes are wrapped at `limit`, and
    /// `legend` is the space above the panels \[pt\].
    fn lengths(&self, limit: f64, legend: f64) -> Lengths {
        let numbers = 0..self.axes.len();
        let left = (0..self.across).map(|column| {
            let of_column = numbers
                .clone()
                .filter(|number| number % self.across == column);
            let rooms = of_column.map(|number| self.left_room(number, limit));
            rooms.fold(if column == 0 { 0.0 } else { self.column_gap() }, f64::max)
        });
        let left: Vec<f64> = left.collect();
        let bars = self.axes.iter().filter_map(|axes| axes.bar.as_ref());
        let bar = bars
            .map(|bar| self.bar_room(bar, limit))
            .fold(0.0, f64::max);
        let right = bar + self.overhang()[1];
        let frame =
            (self.width - 2.0 * MARGIN - left.iter().sum::<f64>() - right) / self.across as f64;
        let frame = frame.max(10.0);
        let aspects = self.drawn.panels.iter().map(|panel| match &panel.subject {
            Subject::Chart(_) => ASPECT,
            Subject::Map { map, .. } => map.aspect(),
        });
        let aspect = aspects.fold(0.0, f64::max);
        let titles: Vec<f64> = (0..self.rows())
            .map(|row| {
                let first = row * self.across;
                let of_row = first..(first + self.across).min(self.axes.len());
                let lines = of_row.map(|number| self.title_lines(number, frame).len());
                let room = LEADING * lines.max().unwrap_or(0) as f64;
                let gap = if row == 0 { 1.0 } else { 4.0 };
                if room > 0.0 { room + gap } else { 0.5 * SIZE }
            })
            .collect();
        let below = self.tick_room() + self.label_lines(frame) * LEADING - 1.0;
        let rows = self.rows() as f64;
        let every_row = if self.shared[0] { 0.0 } else { below };
        let other =
            titles.iter().sum::<f64>() + every_row * (rows - 1.0) + below + legend + 2.0 * MARGIN;
        let height = (frame * aspect)
            .min(HEIGHTS[0])
            .min((TALLEST - other) / rows);
        Lengths {
            left,
            frame: [frame, height.max(HEIGHTS[1])],
            titles,
            below,
            legend,
        }
    }

    /// Computes the gap between columns of panels at which labels of horizontal axes do not overlap
    /// \[pt\].
    fn column_gap(&self) -> f64 {
        let [first, last] = self.overhang();
        (first + last + APART).max(8.0)
    }

    /// Computes how far tick labels of horizontal axes extend beyond the left and right end of a
    /// frame \[pt\].
    fn overhang(&self) -> [f64; 2] {
        let mut reach = [0.0_f64; 2];
        for axes in self.axes.iter().filter(|_| !self.turned) {
            for (place, text) in &axes.ticks[0] {
                let half = 0.5 * text.as_ref().map_or(0.0, |text| self.words(text).width);
                // Frames are at least about 60 pt wide.
                reach[0] = reach[0].max(half - 60.0 * place);
                reach[1] = reach[1].max(half - 60.0 * (1.0 - place));
            }
        }
        reach
    }

    fn left_room(&self, number: usize, limit: f64) -> f64 {
        if !self.shows(number)[1] {
            return 0.0;
        }
        let axes = &self.axes[number];
        let lines = self.axis_label(&axes.labels[1], limit).len() as f64;
        let room = self.widest(&axes.ticks[1]) + 2.0 * GAP + LEADING * lines;
        if number.is_multiple_of(self.across) {
            room
        } else {
            room + self.overhang()[1] + APART
        }
    }

    fn bar_room(&self, (frame, text, unit): &(AxisRange, String, String), limit: f64) -> f64 {
        let lines = self.axis_label(&(text.clone(), unit.clone()), limit).len() as f64;
        8.0 + BAR + GAP + self.widest(&frame.ticks()) + GAP + LEADING * lines
    }

    /// Computes the space for tick labels below horizontal axes \[pt\].
    fn tick_room(&self) -> f64 {
        if self.turned {
            let widest = self.axes.iter().map(|axes| self.widest(&axes.ticks[0]));
            widest.fold(0.0, f64::max) + 2.0 * GAP
        } else {
            GAP + SIZE + GAP
        }
    }

    /// Computes the largest number of lines of a horizontal axis label, for frames of a width
    /// \[pt\].
    fn label_lines(&self, frame: f64) -> f64 {
        let limit = frame.max(60.0);
        let lines = self
            .axes
            .iter()
            .map(|axes| self.axis_label(&axes.labels[0], limit).len());
        lines.max().unwrap_or(1) as f64
    }

    fn title_lines(&self, number: usize, frame: f64) -> Vec<Line> {
        let title = self.title(number);
        if title.is_empty() {
            return Vec::new();
        }
        self.wrapped(&title, frame, label::words)
    }

    /// Returns the area of the frame of a panel on the drawing.
    fn area(&self, number: usize, lengths: &Lengths) -> Area {
        let (row, column) = (number / self.across, number % self.across);
        let [width, height] = lengths.frame;
        let left = MARGIN + lengths.left[..=column].iter().sum::<f64>() + width * column as f64;
        let every_row = if self.shared[0] { 0.0 } else { lengths.below };
        let top = MARGIN
            + lengths.legend
            + lengths.titles[..=row].iter().sum::<f64>()
            + (height + every_row) * row as f64;
        Area {
            left,
            top,
            right: left + width,
            bottom: top + height,
        }
    }

    fn placed<'a>(
        &self,
        number: usize,
        chart: &'a crate::chart::Chart,
        area: Area,
    ) -> PlacedChart<'a> {
        PlacedChart {
            chart,
            axes: self.axes[number].frames,
            area,
        }
    }

    /// Returns a free area for the legend inside a panel; `None` if there is none.
    fn place_in_panel(&self, legend: &Legend, lengths: &Lengths) -> Option<Area> {
        let mut places = self
            .drawn
            .panels
            .iter()
            .enumerate()
            .filter_map(|(number, panel)| {
                let Subject::Chart(chart) = &panel.subject else {
                    return None;
                };
                legend.find_place(&self.placed(number, chart, self.area(number, lengths)))
            });
        places.next()
    }

    fn draw(&self) -> Canvas {
        let styles = styles(&self.drawn.legend);
        let legend = Legend::new(entries(&self.drawn.legend, &styles), self.fonts);
        // The height of frames limits labels, which take width from frames.
        let first = self.lengths(f64::INFINITY, 0.0);
        let limit = first.frame[1].max(60.0);
        let mut lengths = self.lengths(limit, 0.0);
        let inside = self.place_in_panel(&legend, &lengths);
        let above = legend.height(self.width - 2.0 * MARGIN);
        if inside.is_none() && above > 0.0 {
            lengths = self.lengths(limit, above + GAP);
        }
        let height = self.area(self.axes.len() - 1, &lengths).bottom + lengths.below + MARGIN;
        let mut canvas = Canvas {
            size: [self.width, height],
            items: Vec::new(),
        };
        for number in 0..self.axes.len() {
            self.panel(&mut canvas, number, &lengths, &styles);
        }
        match inside {
            Some(place) => legend.draw_inside(&mut canvas, &place),
            None => legend.draw_above(
                &mut canvas,
                &Area {
                    left: MARGIN,
                    top: MARGIN,
                    right: self.width - MARGIN,
                    bottom: MARGIN + above,
                },
            ),
        }
        canvas
    }

    fn panel(&self, canvas: &mut Canvas, number: usize, lengths: &Lengths, styles: &[CurveStyle]) {
        let area = self.area(number, lengths);
        match &self.drawn.panels[number].subject {
            Subject::Chart(chart) => {
                let placed = self.placed(number, chart, area);
                // A single curve may have no name, and so no place in the legend.
                let alone = super::style::styles(&chart.curves);
                let style = |label: &str| {
                    let mut all = styles.iter().chain(&alone);
                    all.find(|style| style.label == label)
                        .cloned()
                        .unwrap_or_default()
                };
                placed.lines(canvas, style);
                self.frame(canvas, number, &area);
                placed.markers(canvas, style);
                for word in &chart.words {
                    if let Some([x, y]) = placed.place(word.x, word.y) {
                        canvas.items.push(Item::Text(self.words(&word.text).place(
                            [x, y],
                            0.5,
                            false,
                        )));
                    }
                }
            }
            Subject::Map {
                map,
                range: (low, high),
                obstacles,
            } => {
                let bar = AxisRange::range_around(map.scale, (*low, *high), high > low);
                draw_map(canvas, map, &bar, obstacles, &area);
                self.frame(canvas, number, &area);
                let ends_row =
                    (number + 1).is_multiple_of(self.across) || number + 1 == self.axes.len();
                if ends_row {
                    self.colour_bar(canvas, number, &area);
                }
            }
        }
        self.labels(canvas, number, &area, lengths);
    }

    /// Draws the frame of a panel, with ticks on all sides.
    fn frame(&self, canvas: &mut Canvas, number: usize, area: &Area) {
        let mut path = area.outline();
        let mut tick = |from: [f64; 2], step: [f64; 2]| {
            path.push(Segment::Move(from));
            path.push(Segment::Line([from[0] + step[0], from[1] + step[1]]));
        };
        let [across, up] = &self.axes[number].ticks;
        let within = |place: f64| (0.001..=0.999).contains(&place);
        for (place, label) in across.iter().filter(|tick| within(tick.0)) {
            let length = TICKS[usize::from(label.is_none())];
            let x = area.at([*place, 0.0])[0];
            tick([x, area.bottom], [0.0, -length]);
            tick([x, area.top], [0.0, length]);
        }
        for (place, label) in up.iter().filter(|tick| within(tick.0)) {
            let length = TICKS[usize::from(label.is_none())];
            let y = area.at([0.0, *place])[1];
            tick([area.left, y], [length, 0.0]);
            tick([area.right, y], [-length, 0.0]);
        }
        canvas.stroke(path, Pen::solid(FRAME, BLACK));
    }

    /// Draws tick labels, axis labels and the title of a panel.
    fn labels(&self, canvas: &mut Canvas, number: usize, area: &Area, lengths: &Lengths) {
        let mut put = |line: Line, at: [f64; 2], share: f64, upwards: bool| {
            canvas
                .items
                .push(Item::Text(line.place(at, share, upwards)));
        };
        let axes = &self.axes[number];
        let [below, beside] = self.shows(number);
        let high = CAPITALS * SIZE;
        if below {
            let mut free = f64::NEG_INFINITY;
            for (place, text) in &axes.ticks[0] {
                let Some(text) = text else { continue };
                let (line, x) = (self.words(text), area.at([*place, 0.0])[0]);
                if self.turned {
                    put(line, [x + 0.5 * high, area.bottom + GAP], 1.0, true);
                } else if x - 0.5 * line.width >= free {
                    free = x + 0.5 * line.width + APART;
                    put(line, [x, area.bottom + GAP + high], 0.5, false);
                }
            }
            let middle = 0.5 * (area.left + area.right);
            let top = area.bottom + self.tick_room() - GAP;
            for (row, line) in (0..).zip(self.axis_label(&axes.labels[0], area.width().max(60.0))) {
                let base = top + GAP + high + LEADING * f64::from(row);
                put(line, [middle, base], 0.5, false);
            }
        }
        if beside {
            let mut free = f64::INFINITY;
            for (place, text) in &axes.ticks[1] {
                let Some(text) = text else { continue };
                let y = area.at([0.0, *place])[1];
                if y + 0.5 * high < free {
                    free = y - 0.5 * high - 1.0;
                    put(
                        self.words(text),
                        [area.left - GAP, y + 0.5 * high],
                        1.0,
                        false,
                    );
                }
            }
            let middle = 0.5 * (area.top + area.bottom);
            let lines = self.axis_label(&axes.labels[1], area.height().max(60.0));
            let right = area.left - 2.0 * GAP - self.widest(&axes.ticks[1]);
            let count = lines.len() as f64;
            for (row, line) in (0..).zip(lines) {
                let base = right - LEADING * (count - 1.0 - f64::from(row)) - 1.5;
                put(line, [base, middle], 0.5, true);
            }
        }
        let title = self.title_lines(number, lengths.frame[0]);
        let count = title.len() as f64;
        for (row, line) in (0..).zip(title) {
            let base = area.top - 3.0 - LEADING * (count - 1.0 - f64::from(row));
            put(line, [area.left, base], 0.0, false);
        }
    }

    /// Draws the colour bar right of a map, with ticks and label.
    fn colour_bar(&self, canvas: &mut Canvas, number: usize, area: &Area) {
        let Some((frame, text, unit)) = &self.axes[number].bar else {
            return;
        };
        let bar = Area {
            left: area.right + 8.0,
            right: area.right + 8.0 + BAR,
            ..*area
        };
        draw_bar(canvas, &bar);
        let (mut path, ticks, high) = (bar.outline(), frame.ticks(), CAPITALS * SIZE);
        let mut free = f64::INFINITY;
        for (place, label) in &ticks {
            let y = bar.at([0.0, *place])[1];
            if (0.001..=0.999).contains(place) {
                path.push(Segment::Move([bar.right, y]));
                path.push(Segment::Line([
                    bar.right - TICKS[usize::from(label.is_none())] * 0.6,
                    y,
                ]));
            }
            if let Some(label) = label
                && y + 0.5 * high < free
            {
                free = y - 0.5 * high - 1.0;
                let line = self.words(label);
                let at = [bar.right + GAP, y + 0.5 * high];
                canvas.items.push(Item::Text(line.place(at, 0.0, false)));
            }
        }
        canvas.stroke(path, Pen::solid(FRAME, BLACK));
        let label = (text.clone(), unit.clone());
        let left = bar.right + 2.0 * GAP + self.widest(&ticks);
        let middle = 0.5 * (bar.top + bar.bottom);
        for (row, line) in (0..).zip(self.axis_label(&label, area.height().max(60.0))) {
            let base = left + high + LEADING * f64::from(row);
            canvas
                .items
                .push(Item::Text(line.place([base, middle], 0.5, true)));
        }
    }
}
