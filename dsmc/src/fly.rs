//! Flight: moves the simulators of a tile, and sends those that leave.

use stosszahl_model::{Field, Physics, Space};

use crate::grid::{Grid, offset_number};
use crate::simulator::{Follow, Simulator, SimulatorOf};
use crate::tile::{Left, Outbox, Scratch, Tile, Traveller, code, fit};

impl<P, F> Tile<P, F>
where
    P: Physics,
    F: Follow<P::Space>,
{
    /// Moves what was arranged in the scratch buffer by a free flight, and keeps those that stay in the tile.
    pub(crate) fn fly(
        &mut self,
        scene: &P,
        grid: &Grid<P::Space>,
        duration: f64,
        scratch: &mut Scratch<P, F>,
        outbox: &mut Outbox<P, F>,
    ) {
        let Scratch {
            sorted, leavers, ..
        } = scratch;
        leavers.clear();
        outbox.far.clear();
        let total = sorted.len();
        // Taken out, so that the loop below knows that nothing else points to them.
        let mut simulators = std::mem::take(&mut self.simulators);
        let mut codes = std::mem::take(&mut self.codes);
        fit(&mut simulators, total);
        fit(&mut codes, total);
        simulators.resize(total, SimulatorOf::<P, F>::default());
        codes.resize(total, 0);
        let lengths = grid.domain().lengths();
        let field = scene.field();
        let acceleration = field.acceleration();
        let place = self.place;
        let width = place.sides[0] as usize;
        let mut stayed = 0;
        let mut begin = self.starts[0] as usize;
        for line in 0..self.lines.len() {
            let first = self.line_number(grid, line as u32);
            let end = self.starts[(line + 1) * width] as usize;
            // The counts of this line's cells are known no longer; those of its stayers are added from here on.
            for (index, simulator) in sorted[begin..end].iter().enumerate() {
                let Simulator {
                    mut position,
                    mut velocity,
                    tag,
                    mut mark,
                    spin,
                } = *simulator;
                let way = if P::Field::FREE {
                    velocity * duration
                } else {
                    (velocity + acceleration * (0.5 * duration)) * duration
                };
                field.drift(&mut position, &mut velocity, duration);
                F::moved(&mut mark, way);
                let mut inside = true;
                let position = P::Space::vector(|axis| {
                    let x = position[axis];
                    let x = x + if x < 0.0 { lengths[axis] } else { 0.0 };
                    // A tiny negative coordinate becomes the length itself.
                    let x = x - if x >= lengths[axis] {
                        lengths[axis]
                    } else {
                        0.0
                    };
                    inside &= (place.low[axis] <= x) & (x < place.high[axis]);
                    x
                });
                if inside {
                    codes[stayed] = code::<P>(grid, &place, position);
                    simulators[stayed] = Simulator {
                        position,
                        velocity,
                        tag,
                        mark,
                        spin,
                    };
                    stayed += 1;
                    continue;
                }
                // Apart from the above: what two branches share, or what has an address, lives in memory, and would do
                // so for all that stay.
                let moved = Simulator {
                    position,
                    velocity,
                    tag,
                    mark,
                    spin,
                };
                let cells = &self.starts[line * width..=(line + 1) * width];
                let column = cells.partition_point(|&start| start as usize <= begin + index);
                let source = first + column as u32 - 1;
                if let Some(moved) = self.depart(grid, moved, source, leavers, &mut outbox.far) {
                    codes[stayed] = code::<P>(grid, &place, moved.position);
                    simulators[stayed] = moved;
                    stayed += 1;
                }
            }
            begin = end;
            self.lines[line] = stayed as u32;
        }
        simulators.truncate(stayed);
        codes.truncate(stayed);
        self.starts.fill(0);
        for &code in &codes {
            self.starts[usize::from(code)] += 1;
        }
        (self.simulators, self.codes) = (simulators, codes);
        outbox.fill(leavers);
    }

    /// Sends a simulator to the tile it enters; gives it back, wrapped, if that is this one.
    #[cold]
    #[inline(never)]
    fn depart(
        &self,
        grid: &Grid<P::Space>,
        mut moved: SimulatorOf<P, F>,
        source: u32,
        leavers: &mut Vec<(u8, Traveller<P, F>)>,
        far: &mut Vec<(u32, Traveller<P, F>)>,
    ) -> Option<SimulatorOf<P, F>> {
        moved.position = grid.domain().wrap(moved.position);
        let tile = self.place.tile;
        let to = grid.owner(grid.cell_at(moved.position));
        if to == tile {
            return Some(moved);
        }
        let traveller = Left {
            source,
            simulator: moved,
        };
        match offset_number(grid.tiles(), tile, to) {
            Some(number) => leavers.push((number as u8, traveller)),
            None => far.push((grid.tile_number(to) as u32, traveller)),
        }
        None
    }
}
