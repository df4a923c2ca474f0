//! What a flow from left to right between walls shows.

use std::ops::Range;

use stosszahl_case::format::{Face, FaceWord};
use stosszahl_results::{Verdict, VerdictKind};

use super::Options;
use super::verdicts::{Measured, Row};
use crate::measures::words::{self, with_error};
use crate::plan::Plan;

/// A channel: inflow on the left, an open face on the right, walls below and above, and nothing inside.
pub(super) struct Channel<'a> {
    plan: &'a Plan,
    /// Fields of the last window, the first axis running fastest.
    cells: &'a [Row<'a>],
    columns: usize,
    rows: usize,
    /// Velocity of the inflow along the channel, in the units of the case.
    entering: f64,
    /// Blocks of all replicas that errors come from.
    parts: usize,
}

const SPEED: &str = "velocity_x";
const HEAT: &str = "temperature";
const DENSITY: &str = "number_density";

impl<'a> Channel<'a> {
    /// The channel of a case, if it is one and its fields are fine enough.
    pub(super) fn of(
        plan: &'a Plan,
        options: &Options,
        cells: &'a [Row<'a>],
        parts: usize,
    ) -> Option<Self> {
        let case = &plan.case;
        let inflow = case.inflow.iter().find(|inflow| inflow.face == "left")?;
        let open = *case.walls.at(0, 1) == Face::Word(FaceWord::Open);
        let walled = [0, 1].iter().all(|&side| match case.walls.at(1, side) {
            Face::Word(word) => *word == FaceWord::Specular,
            Face::Wall(_) => true,
        });
        let [columns, rows] = options.cells.map(|count| count as usize);
        let fine = rows >= 4 && columns >= 8 && cells.len() == rows * columns;
        (open && walled && fine && case.obstacle.is_empty()).then_some(Self {
            plan,
            cells,
            columns,
            rows,
            entering: inflow.velocity.first().copied().unwrap_or(0.0),
            parts,
        })
    }

    /// What happens along its middle, at its walls, and in its two halves.
    pub(super) fn verdicts(&self) -> impl Iterator<Item = Verdict> {
        let along = [self.along(), self.walls()];
        along.into_iter().chain(self.symmetry())
    }

    fn at(&self, column: usize, row: usize) -> &Row<'a> {
        &self.cells[column + self.columns * row]
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
    fn mean(&self, columns: Range<usize>, rows: Range<usize>, of: &str) -> Measured {
        let (mut number, mut sum, mut square) = (0.0, 0.0, Some(0.0_f64));
        for column in columns {
            for row in rows.clone() {
                let cell = self.at(column, row);
                let density = cell.number(DENSITY).unwrap_or(0.0);
                let (value, error) = cell.measured(of);
                number += density;
                sum += density * value;
                square = square
                    .zip(error)
                    .map(|(square, error)| square + (density * error).powi(2));
            }
        }
        (sum / number, square.map(|square| square.sqrt() / number))
    }

    /// Last over first eighth, in the middle.
    fn change(&self, of: &str) -> String {
        let [first, last] = self.ends().map(|end| self.mean(end, self.middle(), of));
        let quotient = last.0 / first.0;
        let error = first.1.zip(last.1);
        let error = error.map(|(a, b)| quotient.abs() * (a / first.0).hypot(b / last.0));
        with_error(quotient, error)
    }

    /// What changes along the channel.
    fn along(&self) -> Verdict {
        let [_, last] = self.ends();
        let (centre, error) = self.mean(last, self.middle(), SPEED);
        let exit = with_error(
            centre / self.entering,
            error.map(|error| error / self.entering.abs()),
        );
        Verdict {
            topic: "along the channel".into(),
            sentence: format!(
                "From the first to the last eighth the velocity in the middle changes by the factor {}, the temperature by {}, the density by {}. At the exit the velocity is {exit} of that of the inflow.",
                self.change(SPEED),
                self.change(HEAT),
                self.change(DENSITY),
            ),
            kind: VerdictKind::Note,
        }
    }

    /// Slip at the walls and the layer that they slow down.
    fn walls(&self) -> Verdict {
        /// Share of the velocity in the middle at which the layer ends.
        const FREE: f64 = 0.99;
        let [_, last] = self.ends();
        let (centre, centre_error) = self.mean(last.clone(), self.middle(), SPEED);
        let edges =
            [0..1, self.rows - 1..self.rows].map(|rows| self.mean(last.clone(), rows, SPEED));
        let slip = 0.5 * (edges[0].0 + edges[1].0) / centre;
        let error = edges[0].1.zip(edges[1].1).zip(centre_error);
        let error = error.map(|((a, b), c)| (0.5 * a.hypot(b) / centre).hypot(slip * c / centre));
        let slow = (0..self.rows / 2)
            .take_while(|&row| self.mean(last.clone(), row..row + 1, SPEED).0 < FREE * centre)
            .count();
        let height = self.plan.lengths[1] * self.plan.scale.length;
        let layer = height * slow as f64 / self.rows as f64;
        Verdict {
            topic: "walls of the channel".into(),
            sentence: format!(
                "At the exit particles slip along the walls at {} of the velocity in the middle, and are slower than {FREE} of it up to {layer:.3} from the wall.",
                with_error(slip, error)
            ),
            kind: VerdictKind::Note,
        }
    }

    /// How far the two halves are alike, where they must be.
    fn symmetry(&self) -> Option<Verdict> {
        /// Largest mean square of differences over their errors: errors from some forty blocks have ten per cent of error of
        /// their own.
        const ALIKE: f64 = 1.3;
        let case = &self.plan.case;
        if case.gravity.is_some() || case.walls.bottom != case.walls.top {
            return None;
        }
        let (mut chi_squared, mut count) = (0.0, 0.0_f64);
        for column in 0..self.columns {
            for row in 0..self.rows / 2 {
                let pair = [self.at(column, row), self.at(column, self.rows - 1 - row)];
                for of in [SPEED, HEAT, DENSITY] {
                    let [(x, Some(x_error)), (y, Some(y_error))] =
                        pair.map(|cell| cell.measured(of))
                    else {
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
        let mean_square: f64 = chi_squared / count;
        let (kind, sentence) = if count > 0.0 {
            let kind = words::test(mean_square <= ALIKE, self.parts);
            let found = format!(
                "Velocity, temperature and density of mirrored cells differ by {:.3} standard errors (root mean square of {count} differences, limit {:.3}{}).",
                mean_square.sqrt(),
                ALIKE.sqrt(),
                words::from_parts(self.parts)
            );
            (kind, found)
        } else {
            let unknown = "Errors of the fields are unknown, so mirrored cells are not compared.";
            (VerdictKind::Note, unknown.to_owned())
        };
        Some(Verdict {
            topic: "symmetry".into(),
            sentence,
            kind,
        })
    }
}
