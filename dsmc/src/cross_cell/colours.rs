//! Colouring of the tiles of a box: no two tiles of one colour have a common neighbour, so they can
//! be processed in parallel.

use stosszahl_model::Space;

use crate::grid::Grid;

/// Returns the colour of each tile along a periodic axis: tiles of one colour are at least three
/// apart. Fewer than three tiles get a colour each.
fn ring_colours(count: u32) -> Vec<usize> {
    let regular = if count < 3 { 0 } else { count - count % 3 };
    (0..count)
        .map(|tile| match tile {
            _ if tile < regular => tile % 3,
            _ if regular > 0 => 3 + tile - regular,
            _ => tile,
        } as usize)
        .collect()
}

/// Returns the tiles of each colour, by their numbers in the grid.
pub(crate) fn colours<S: Space>(grid: &Grid<S>) -> Vec<Vec<u32>> {
    let counts = grid.tiles();
    let along = counts.map(ring_colours);
    let most = [0, 1, 2].map(|axis: usize| along[axis].iter().max().map_or(1, |most| most + 1));
    let mut groups = vec![Vec::new(); most.iter().product()];
    let is_sheared = grid.domain().images().shear().is_some();
    for number in 0..counts.iter().product::<u32>() {
        let at = grid.place_of(number as usize);
        if is_sheared && (at[1] == 0 || at[1] + 1 == counts[1]) {
            // All tiles beyond the edge may be neighbours, as they slide past.
            groups.push(vec![number]);
            continue;
        }
        let [x, y, z] = [0, 1, 2].map(|axis: usize| along[axis][at[axis] as usize]);
        groups[x + most[0] * (y + most[1] * z)].push(number);
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tiles of one colour have no neighbour in common, for any number of tiles.
    #[test]
    fn tiles_of_one_colour_share_no_neighbour() {
        for count in 1..40_u32 {
            let colours = ring_colours(count);
            assert!(colours.iter().all(|&colour| colour < 5));
            for one in 0..count {
                for other in 0..count {
                    if one == other || colours[one as usize] != colours[other as usize] {
                        continue;
                    }
                    let apart = (one + count - other) % count;
                    assert!(apart.min(count - apart) >= 3, "{count}: {one}, {other}");
                }
            }
        }
    }
}
