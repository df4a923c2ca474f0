//! Who holds which tiles: recursive bisection of the box by what tiles cost.

/// The owner of each tile, for tiles in a block of `counts`, the first axis running fastest, among `ranks` processes.
///
/// A block goes to a range of processes. It is cut across its longest axis where the costs are nearest to the shares of the two
/// halves of the range, and so on with both parts (Berger & Bokhari, IEEE Trans. Comput. 36, 570 (1987),
/// doi:10.1109/TC.1987.1676942). Each process has at least one tile, unless there are fewer.
pub(crate) fn bisect(counts: [u32; 3], costs: &[f64], ranks: usize) -> Vec<u32> {
    let mut owners = vec![0; costs.len()];
    let block = Block {
        low: [0; 3],
        high: counts.map(|count| count as usize),
    };
    cut(
        &mut owners,
        costs,
        counts.map(|count| count as usize),
        block,
        [0, ranks.max(1)],
    );
    owners
}

#[derive(Clone, Copy)]
struct Block {
    low: [usize; 3],
    high: [usize; 3],
}

impl Block {
    fn side(&self, axis: usize) -> usize {
        self.high[axis] - self.low[axis]
    }

    fn tiles(&self, counts: [usize; 3]) -> impl Iterator<Item = usize> + use<> {
        let Self { low, high } = *self;
        (low[2]..high[2]).flat_map(move |z| {
            (low[1]..high[1]).flat_map(move |y| {
                (low[0]..high[0]).map(move |x| x + counts[0] * (y + counts[1] * z))
            })
        })
    }
}

fn cut(owners: &mut [u32], costs: &[f64], counts: [usize; 3], block: Block, range: [usize; 2]) {
    let ranks = range[1] - range[0];
    // The last of the longest, whose tiles are farthest apart in memory.
    let axis = (0..3).max_by_key(|&axis| block.side(axis)).unwrap_or(0);
    let planes = block.side(axis);
    if ranks == 1 || planes == 1 {
        for tile in block.tiles(counts) {
            owners[tile] = range[0] as u32;
        }
        return;
    }
    let mut costs_of_planes = vec![0.0; planes];
    for (plane, cost) in costs_of_planes.iter_mut().enumerate() {
        let mut slice = block;
        slice.low[axis] += plane;
        slice.high[axis] = slice.low[axis] + 1;
        *cost = slice.tiles(counts).map(|tile| costs[tile]).sum();
    }
    let total: f64 = costs_of_planes.iter().sum();
    let first = ranks / 2;
    let wanted = total * first as f64 / ranks as f64;
    let (mut sum, mut best, mut error) = (0.0, 1, f64::INFINITY);
    for plane in 1..planes {
        sum += costs_of_planes[plane - 1];
        if (sum - wanted).abs() < error {
            (best, error) = (plane, (sum - wanted).abs());
        }
    }
    let (mut low, mut high) = (block, block);
    low.high[axis] = block.low[axis] + best;
    high.low[axis] = low.high[axis];
    let middle = range[0] + first;
    cut(owners, costs, counts, low, [range[0], middle]);
    cut(owners, costs, counts, high, [middle, range[1]]);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each process has tiles, and none has more than the mean and two planes of them, for equal costs.
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
            let mut sides = counts;
            sides.sort_unstable();
            let plane = f64::from(sides[0] * sides[1]);
            for rank in 0..ranks as u32 {
                let own = owners.iter().filter(|&&owner| owner == rank).count() as f64;
                assert!(
                    own > 0.0 && own <= mean + 2.0 * plane,
                    "{counts:?} {ranks}: {own}"
                );
            }
        }
    }

    /// A tile that costs as much as all others together has half of the processes' cuts beside it.
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
