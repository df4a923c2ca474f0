//! Load balancing among processes: recursive bisection of the box by the measured costs of its
//! tiles.

/// Assigns each tile of a block to one of `ranks` processes so that all have about equal cost;
/// returns the owners. `counts` are the numbers of tiles along the axes, the first running fastest.
///
/// Recursive bisection (Berger & Bokhari, IEEE Trans. Comput. 36, 570 (1987),
/// doi:10.1109/TC.1987.1676942): tiles are sorted along their longest axis and cut where the costs
/// best match the shares of the two halves of the processes; both parts are bisected further. A cut
/// may run within a plane of tiles, so parts differ by half a tile, not half a plane. Each process
/// has at least one tile, if there are enough.
pub(crate) fn bisect(counts: [u32; 3], costs: &[f64], ranks: usize) -> Vec<u32> {
    let mut owners = vec![0; costs.len()];
    let mut tiles: Vec<usize> = (0..costs.len()).collect();
    let counts = counts.map(|count| count as usize);
    cut(&mut owners, costs, counts, &mut tiles, [0, ranks.max(1)]);
    owners
}

fn cut(
    owners: &mut [u32],
    costs: &[f64],
    counts: [usize; 3],
    tiles: &mut [usize],
    range: [usize; 2],
) {
    let ranks = range[1] - range[0];
    if ranks == 1 || tiles.len() < 2 {
        for &mut tile in tiles {
            owners[tile] = range[0] as u32;
        }
        return;
    }
    let at = |tile: usize, axis: usize| match axis {
        0 => tile % counts[0],
        1 => tile / counts[0] % counts[1],
        _ => tile / counts[0] / counts[1],
    };
    let extent = |axis: usize| {
        let places = tiles.iter().map(|&tile| at(tile, axis));
        places.clone().max().unwrap_or(0) - places.min().unwrap_or(0)
    };
    // Of equally long axes the last, whose tiles are farthest apart in memory.
    let axis = (0..3).max_by_key(|&axis| extent(axis)).unwrap_or(0);
    tiles.sort_unstable_by_key(|&tile| (at(tile, axis), tile));
    let first = ranks / 2;
    let total: f64 = tiles.iter().map(|&tile| costs[tile]).sum();
    let wanted = total * first as f64 / ranks as f64;
    let (fewest, most) = if tiles.len() >= ranks {
        (first, tiles.len() - (ranks - first))
    } else {
        (1, tiles.len() - 1)
    };
    let (mut sum, mut best, mut error) = (0.0, fewest, f64::INFINITY);
    for (count, &tile) in (1..=most).zip(tiles.iter()) {
        sum += costs[tile];
        if count >= fewest && (sum - wanted).abs() < error {
            (best, error) = (count, (sum - wanted).abs());
        }
    }
    let (low, high) = tiles.split_at_mut(best);
    let middle = range[0] + first;
    cut(owners, costs, counts, low, [range[0], middle]);
    cut(owners, costs, counts, high, [middle, range[1]]);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each process has tiles, and at most the mean plus half a tile for each cut, for equal costs.
    #[test]
    fn equal_tiles_are_shared_evenly() {
        for (counts, ranks) in [
            ([16, 16, 1], 1),
            ([16, 16, 1], 2),
            ([16, 16, 1], 3),
            ([16, 15, 1], 7),
            ([8, 8, 8], 8),
            ([9, 7, 5], 6),
        ] {
            let tiles = counts.iter().product::<u32>() as usize;
            let owners = bisect(counts, &vec![1.0; tiles], ranks);
            let mean = tiles as f64 / ranks as f64;
            let cuts = f64::from(ranks as u32).log2().ceil();
            for rank in 0..ranks as u32 {
                let own = owners.iter().filter(|&&owner| owner == rank).count() as f64;
                assert!(
                    own > 0.0 && own <= mean + 0.5 * cuts,
                    "{counts:?} {ranks}: {own}"
                );
            }
        }
    }

    /// A tile that costs as much as all others together gets half of the cuts next to it.
    #[test]
    fn dear_tiles_have_fewer_neighbours() {
        let mut costs = vec![1.0; 64];
        costs[0] = 63.0;
        let owners = bisect([64, 1, 1], &costs, 2);
        assert_eq!(owners.iter().filter(|&&owner| owner == 0).count(), 1);
    }

    #[test]
    fn there_may_be_fewer_tiles_than_processes() {
        assert_eq!(bisect([1, 1, 1], &[1.0], 4), [0]);
    }
}
