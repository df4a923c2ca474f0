//! Flight: moves the simulators of a tile, and sends those that leave.

use stosszahl_model::{Field, Free, Physics, Smooth};

use crate::grid::{Grid, Place, offset_number};
use crate::simulator::{Follow, SimulatorOf};
use crate::tile::{Outbox, Scratch, Tile, Traveller, code, fit};

impl<P, F> Tile<P, F>
where
    P: Physics<Surface = Smooth, Field = Free>,
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
        fit(&mut self.simulators, total);
        fit(&mut self.codes, total);
        self.simulators
            .resize(total, SimulatorOf::<P, F>::default());
        self.codes.resize(total, 0);
        let lengths = grid.domain().lengths();
        let field = scene.field();
        let place = self.place;
        let width = place.sides[0] as usize;
        let mut stayed = 0;
        let mut begin = self.starts[0] as usize;
        for line in 0..self.lines.len() {
            let end = self.starts[(line + 1) * width] as usize;
            // The counts of this line's cells are known no longer; those of its stayers are added from here on.
            for (index, simulator) in sorted[begin..end].iter().enumerate() {
                let mut moved = *simulator;
                Field::<P::Space>::drift(field, &mut moved.position, &mut moved.velocity, duration);
                F::moved(&mut moved.mark, moved.velocity * duration);
                let mut inside = true;
                for axis in 0..crate::dimension::<P>() {
                    let x = moved.position[axis];
                    let x = x + if x < 0.0 { lengths[axis] } else { 0.0 };
                    // A tiny negative coordinate becomes the length itself.
                    let x = x - if x >= lengths[axis] {
                        lengths[axis]
                    } else {
                        0.0
                    };
                    moved.position[axis] = x;
                    inside &= (place.low[axis] <= x) & (x < place.high[axis]);
                }
                if inside || self.depart(grid, &mut moved, [line, begin + index], leavers, outbox) {
                    self.simulators[stayed] = moved;
                    self.codes[stayed] = code::<P>(grid, &place, moved.position);
                    stayed += 1;
                }
            }
            begin = end;
            self.lines[line] = stayed as u32;
        }
        self.simulators.truncate(stayed);
        self.codes.truncate(stayed);
        self.starts.fill(0);
        for &code in &self.codes {
            self.starts[usize::from(code)] += 1;
        }
        outbox.fill(leavers);
    }

    /// Sends a simulator to the tile it enters; true if that is this one.
    #[cold]
    #[inline(never)]
    fn depart(
        &self,
        grid: &Grid<P::Space>,
        moved: &mut SimulatorOf<P, F>,
        [line, index]: [usize; 2],
        leavers: &mut Vec<(u8, Traveller<P, F>)>,
        outbox: &mut Outbox<P, F>,
    ) -> bool {
        moved.position = grid.domain().wrap(moved.position);
        let Place { tile, sides, .. } = self.place;
        let to = grid.owner(grid.cell_at(moved.position));
        if to == tile {
            return true;
        }
        let width = sides[0] as usize;
        let cells = &self.starts[line * width..=(line + 1) * width];
        let column = cells.partition_point(|&start| start as usize <= index) - 1;
        let traveller = Traveller {
            source: self.line_number(grid, line as u32) + column as u32,
            simulator: *moved,
        };
        match offset_number(grid.tiles(), tile, to) {
            Some(number) => leavers.push((number as u8, traveller)),
            None => outbox.far.push((grid.tile_number(to) as u32, traveller)),
        }
        false
    }
}
