//! What a flow from left to right between walls shows.

use std::ops::Range;

use super::case::{Face, FaceName, FaceWord, Flow};
use super::tables::FieldRow;
use crate::verdicts::with_error;

/// A number and its standard error.
type Measured = (f64, Option<f64>);

/// A channel: inflow on the left, an open face on the right, walls below and above, and nothing inside.
pub(super) struct Channel<'a> {
    flow: &'a Flow,
    /// Fields of the last window, the first axis running fastest.
    cells: &'a [&'a FieldRow],
    columns: usize,
    rows: usize,
    /// Velocity of the inflow along the channel.
    entering: f64,
}

fn speed(row: &FieldRow) -> Measured {
    (row.velocity_x, row.velocity_x_se)
}

fn heat(row: &FieldRow) -> Measured {
    (row.temperature, row.temperature_se)
}

fn density(row: &FieldRow) -> Measured {
    (row.number_density, row.number_density_se)
}

impl<'a> Channel<'a> {
    /// The channel of a case, if it is one and its fields are fine enough.
    pub(super) fn of(flow: &'a Flow, cells: &'a [&'a FieldRow]) -> Option<Self> {
        let inflow = flow
            .inflow
            .iter()
            .find(|inflow| inflow.face == FaceName::Left)?;
        let open = *flow.walls.at(0, 1) == Face::Word(FaceWord::Open);
        let walled = [0, 1].iter().all(|&side| match flow.walls.at(1, side) {
            Face::Word(word) => *word == FaceWord::Specular,
            Face::Wall(_) => true,
        });
        let [columns, rows] = flow.fields.cells.map(|count| count as usize);
        let fine = rows >= 4 && columns >= 8 && cells.len() == rows * columns;
        (open && walled && fine && flow.obstacle.is_empty()).then_some(Self {
            flow,
            cells,
            columns,
            rows,
            entering: inflow.velocity[0],
        })
    }

    fn at(&self, column: usize, row: usize) -> &FieldRow {
        self.cells[column + self.columns * row]
    }

    /// The middle fifth of the height.
    fn middle(&self) -> Range<usize> {
        2 * self.rows / 5..(3 * self.rows).div_ceil(5)
    }

    /// The first and the last eighth of the length.
    fn ends(&self) -> [Range<usize>; 2] {
        let eighth = self.columns / 8;
        [0..eighth, self.columns - eighth..self.columns]
    }

    /// Mean over a block of cells, weighted with the density.
    fn mean(
        &self,
        columns: Range<usize>,
        rows: Range<usize>,
        of: fn(&FieldRow) -> Measured,
    ) -> Measured {
        let (mut number, mut sum, mut square) = (0.0, 0.0, Some(0.0_f64));
        for column in columns {
            for row in rows.clone() {
                let cell = self.at(column, row);
                let (value, error) = of(cell);
                number += cell.number_density;
                sum += cell.number_density * value;
                square = square
                    .zip(error)
                    .map(|(square, error)| square + (cell.number_density * error).powi(2));
            }
        }
        (sum / number, square.map(|square| square.sqrt() / number))
    }

    /// Last over first eighth, in the middle.
    fn change(&self, of: fn(&FieldRow) -> Measured) -> Measured {
        let [first, last] = self.ends().map(|end| self.mean(end, self.middle(), of));
        let quotient = last.0 / first.0;
        let error = first.1.zip(last.1);
        let error = error.map(|(a, b)| quotient.abs() * (a / first.0).hypot(b / last.0));
        (quotient, error)
    }

    /// What changes along the channel.
    pub(super) fn along(&self) -> (&'static str, String) {
        let [_, last] = self.ends();
        let (centre, error) = self.mean(last, self.middle(), speed);
        let say = |(value, error): Measured| with_error(value, error);
        let sentence = format!(
            "From the first to the last eighth, in the middle of the channel, the velocity changes by the factor {}, the temperature by {}, the density by {}; at the exit the velocity there is {} of that of the inflow.",
            say(self.change(speed)),
            say(self.change(heat)),
            say(self.change(density)),
            with_error(
                centre / self.entering,
                error.map(|error| error / self.entering.abs())
            )
        );
        ("along the channel", sentence)
    }

    /// Slip at the walls and the layer that they slow down.
    pub(super) fn walls(&self) -> (&'static str, String) {
        /// Share of the velocity in the middle at which the layer ends.
        const FREE: f64 = 0.99;
        let [_, last] = self.ends();
        let (centre, centre_error) = self.mean(last.clone(), self.middle(), speed);
        let edges =
            [0..1, self.rows - 1..self.rows].map(|rows| self.mean(last.clone(), rows, speed));
        let slip = 0.5 * (edges[0].0 + edges[1].0) / centre;
        let error = edges[0].1.zip(edges[1].1).zip(centre_error);
        let error = error.map(|((a, b), c)| (0.5 * a.hypot(b) / centre).hypot(slip * c / centre));
        let slow = (0..self.rows / 2)
            .take_while(|&row| self.mean(last.clone(), row..row + 1, speed).0 < FREE * centre)
            .count();
        let height = self.flow.domain.size[1] * slow as f64 / self.rows as f64;
        let sentence = format!(
            "At the exit grains slip along the walls at {} of the velocity in the middle, and are slower than {FREE} of it up to {height:.3} from the wall.",
            with_error(slip, error)
        );
        ("walls of the channel", sentence)
    }

    /// How far the two halves are alike, where they must be.
    pub(super) fn symmetry(&self) -> Option<(String, bool)> {
        /// Largest mean square of differences over their errors: errors from some forty blocks have ten per cent of error of
        /// their own.
        const ALIKE: f64 = 1.3;
        if self.flow.gravity.is_some() || self.flow.walls.bottom != self.flow.walls.top {
            return None;
        }
        let (mut chi_squared, mut count) = (0.0, 0.0_f64);
        for column in 0..self.columns {
            for row in 0..self.rows / 2 {
                let pair = [self.at(column, row), self.at(column, self.rows - 1 - row)];
                for of in [speed, heat, density] {
                    let [(x, Some(x_error)), (y, Some(y_error))] = pair.map(of) else {
                        continue;
                    };
                    let error = x_error.hypot(y_error);
                    if error > 0.0 {
                        chi_squared += ((x - y) / error).powi(2);
                        count += 1.0;
                    }
                }
            }
        }
        let mean_square: f64 = chi_squared / count.max(1.0);
        let sentence = format!(
            "Velocity, temperature and density of mirrored cells differ by {:.3} standard errors (root mean square of {count} differences; one is noise).",
            mean_square.sqrt()
        );
        Some((sentence, mean_square <= ALIKE))
    }
}
