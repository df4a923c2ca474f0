//! Verdicts on a channel flow from left to right between walls: slip, boundary layers, changes
//! along the channel, symmetry.

use std::ops::Range;

use stosszahl_case::Case;
use stosszahl_case::format::{FaceSpec, FaceWord, InflowSpec};
use stosszahl_results::{TableEstimate, VerdictText};

use stosszahl_analysis::fields::CellAveraging;

use super::view::{DENSITY, Quantities, SPEED, TEMPERATURE, View};
use crate::judge::{self, VerdictRule, in_units};
use crate::measures::fewest_parts;
use crate::plan::CasePlan;

/// Fields of a channel flow, from the inflow on the left to the open face on the right.
pub(super) struct Channel<'a> {
    plan: &'a CasePlan,
    view: &'a View<'a>,
    /// Fields of each cell in the last time window; the index runs fastest along the first axis.
    cells: Vec<Quantities>,
    columns: usize,
    rows: usize,
    /// Velocity of the inflow along the channel \[length/time\], in the units of the case.
    entering: f64,
    rule: VerdictRule,
}

/// Smallest number of cells across a channel at which boundary layers are evaluated.
pub(super) const FEWEST_ROWS: usize = 4;

/// Returns true if a case is a channel: inflow through the left face, an open right face, walls
/// below and above, and no obstacles.
pub(super) fn is_channel(case: &Case) -> bool {
    let open = *case.walls.face_at(0, 1) == FaceSpec::Word(FaceWord::Open);
    let walled = [0, 1]
        .iter()
        .all(|&side| match case.walls.face_at(1, side) {
            FaceSpec::Word(word) => *word == FaceWord::Specular,
            FaceSpec::Wall(_) => true,
        });
    entering(case).is_some() && open && walled && case.obstacle.is_empty()
}

/// Returns the inflow through the left face of a case; `None` if there is none.
fn entering(case: &Case) -> Option<&InflowSpec> {
    case.inflow.iter().find(|inflow| inflow.face == "left")
}

/// Returns the middle fifth of the rows of cells across a channel.
pub(super) fn middle(rows: usize) -> Range<usize> {
    2 * rows / 5..(3 * rows).div_ceil(5)
}

impl<'a> Channel<'a> {
    /// Creates the channel flow of a case; `None` if the case is not a channel, or its fields have
    /// too few cells.
    pub(super) fn from_plan(
        plan: &'a CasePlan,
        view: &'a View<'a>,
        [columns, rows]: [usize; 2],
        rule: &VerdictRule,
    ) -> Option<Self> {
        let case = &plan.case;
        let inflow = entering(case)?;
        let fine = rows >= FEWEST_ROWS && columns >= 8;
        (is_channel(case) && fine).then(|| Self {
            plan,
            view,
            cells: view.fields(None, CellAveraging::Cells),
            columns,
            rows,
            entering: inflow.velocity.first().copied().unwrap_or(0.0),
            rule: *rule,
        })
    }

    /// Decides the verdicts on the middle of the channel, its walls and its two halves. `topic`
    /// adds the engine to a subject.
    pub(super) fn verdicts(&self, topic: impl Fn(&str) -> String) -> Vec<VerdictText> {
        let mut list = vec![
            judge::verdict_note(topic("along the channel"), self.along()),
            judge::verdict_note(topic("walls of the channel"), self.walls()),
        ];
        list.extend(self.symmetry(topic("symmetry")));
        list
    }

    fn at(&self, column: usize, row: usize) -> &Quantities {
        &self.cells[column + self.columns * row]
    }

    /// Returns the rows of cells in the middle fifth of the channel's height.
    fn middle(&self) -> Range<usize> {
        middle(self.rows)
    }

    /// Returns the columns of cells in the first and in the last eighth of the channel's length.
    fn ends(&self) -> [Range<usize>; 2] {
        let eighth = self.columns / 8;
        [0..eighth, self.columns - eighth..self.columns]
    }

    /// Computes the mean of a quantity over a rectangle of cells, weighted with the density.
    fn mean(&self, columns: Range<usize>, rows: Range<usize>, quantity: usize) -> TableEstimate {
        let across = self.columns;
        let cells = columns.flat_map(|column| rows.clone().map(move |row| column + across * row));
        self.view.mean(&cells.collect::<Vec<_>>(), quantity)
    }

    /// Formats the ratio of a quantity between the last and the first eighth of the channel's
    /// length, at middle height.
    fn change(&self, quantity: usize) -> String {
        let [first, last] = self
            .ends()
            .map(|end| self.mean(end, self.middle(), quantity));
        judge::format_quotient(&last, &first)
    }

    /// Describes the changes of density, velocity and temperature along the channel.
    fn along(&self) -> String {
        let [_, last] = self.ends();
        let centre = self.mean(last, self.middle(), SPEED);
        format!(
            "From the first to the last eighth the velocity in the middle changes by the factor {}, the temperature by {}, the \
             density by {}. At the exit the velocity is {} of that of the inflow.",
            self.change(SPEED),
            self.change(TEMPERATURE),
            self.change(DENSITY),
            in_units(&centre, self.entering)
        )
    }

    /// Describes the slip at the walls, and the boundary layers.
    fn walls(&self) -> String {
        /// Velocity, over that in the middle of the channel, at which the boundary layer ends.
        const FREE: f64 = 0.99;
        let [_, last] = self.ends();
        let speed = |rows| self.mean(last.clone(), rows, SPEED);
        let value = |found: &TableEstimate| found.value.unwrap_or(f64::NAN);
        let centre = speed(self.middle());
        let [low, high] = [speed(0..1), speed(self.rows - 1..self.rows)];
        let error = low.standard_error.zip(high.standard_error);
        let error = error.map(|(a, b)| 0.5 * a.hypot(b));
        let edges = TableEstimate::with_error(0.5 * (value(&low) + value(&high)), error);
        let free = FREE * value(&centre);
        let slow = (0..self.rows / 2).take_while(|&row| value(&speed(row..row + 1)) < free);
        let height = self.plan.gas.lengths[1] * self.plan.scale.length;
        let layer = height * slow.count() as f64 / self.rows as f64;
        format!(
            "At the exit particles slip along the walls at {} of the velocity in the middle, and are slower than {FREE} of it up \
             to {layer:.3} from the wall.",
            judge::format_quotient(&edges, &centre)
        )
    }

    /// Decides the verdict on the symmetry of the lower and upper half of the channel; `None` if
    /// the case is not symmetric.
    fn symmetry(&self, topic: String) -> Option<VerdictText> {
        let case = &self.plan.case;
        if case.gravity.is_some() || case.walls.bottom != case.walls.top {
            return None;
        }
        let (half, columns) = (self.rows / 2, self.columns);
        let mirrored = (0..columns).flat_map(|x| (0..half).map(move |y| (x, y)));
        let compared = [
            (SPEED, "velocity"),
            (TEMPERATURE, "temperature"),
            (DENSITY, "density"),
        ];
        let both = mirrored.flat_map(|(x, y)| {
            let pair = [self.at(x, y), self.at(x, self.rows - 1 - y)];
            compared.map(|(of, name)| {
                let place = format!("cell {x}, {y} ({name})");
                (pair.map(|cell| cell[of]), place)
            })
        });
        let both: Vec<_> = both.collect();
        let parts = fewest_parts(
            self.cells
                .iter()
                .flat_map(|cell| [SPEED, TEMPERATURE, DENSITY].map(|quantity| &cell[quantity])),
        );
        let words = [
            "The lower half",
            "the upper half",
            "velocity, temperature and density",
        ];
        let unknown = "Errors of the fields are unknown, so mirrored cells are not compared.";
        let found = judge::profiles(&topic, words, &both, parts, &self.rule);
        found.or_else(|| Some(judge::verdict_note(topic, unknown)))
    }
}
