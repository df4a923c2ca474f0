//! Exchange of ghost cells and of velocity changes between processes, for schemes whose collision
//! partners lie in other cells.

use std::collections::BTreeMap;

use stosszahl_model::{Collision, ParticleModel, Space};

use super::bytes::{from_bytes, to_bytes};
use super::ranks::{all_gather, gather};
use super::subdomain::{Subdomain, TileData, tiles_around};
use crate::cross_cell::{ChangeOf, Distances, TileBounds, TilePeers, TileReport, colours};
use crate::grid::Grid;
use crate::particle::DisplacementTracking;
use crate::tally::CollisionCounters;
use crate::tile::Tile;

impl<S: Space> Subdomain<S> {
    /// Exchanges the covered area or volume of each cell with other processes: for tiles within
    /// `reach` cells of own tiles and, if `is_wide`, tiles adjacent to these. Returns the values
    /// received by tile number.
    pub(crate) fn units_around<P: ParticleModel<Space = S>, F: DisplacementTracking<S>>(
        &self,
        grid: &Grid<S>,
        tiles: &[Tile<P, F>],
        reach: [usize; 3],
        is_wide: bool,
        values: impl Fn(&Tile<P, F>) -> Vec<f32>,
    ) -> BTreeMap<usize, Vec<f32>> {
        let mut to: BTreeMap<usize, Vec<(u32, Vec<f32>)>> = BTreeMap::new();
        let mut from: Vec<usize> = Vec::new();
        for (number, tile) in tiles.iter().enumerate().filter(|(_, tile)| tile.is_here) {
            let mut near: Vec<usize> = tiles_within(grid, number, reach).collect();
            if is_wide {
                near = near
                    .iter()
                    .flat_map(|&other| tiles_around(grid, other))
                    .collect();
            }
            let owners = near.iter().map(|&other| self.owners[other] as usize);
            let mut wanted: Vec<usize> = owners.filter(|&owner| owner != self.me()).collect();
            wanted.sort_unstable();
            wanted.dedup();
            if wanted.is_empty() {
                continue;
            }
            let values = values(tile);
            for &rank in &wanted {
                to.entry(rank)
                    .or_default()
                    .push((number as u32, values.clone()));
            }
            from.extend(wanted);
        }
        // The relation is symmetric: receivers are also senders.
        from.sort_unstable();
        from.dedup();
        let messages = to.iter().map(|(&rank, some)| (rank, to_bytes(some)));
        let came = self.ranks.exchange(messages.collect(), &from);
        let all = came
            .iter()
            .flat_map(|bytes| from_bytes::<Vec<(u32, Vec<f32>)>>(bytes));
        all.map(|(number, values)| (number as usize, values))
            .collect()
    }
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> TilePeers<P, F> for Subdomain<P::Space> {
    fn is_seen(&self, tile: usize) -> bool {
        !self.seers[tile].is_empty()
    }

    fn tells(&self, tile: usize) -> bool {
        self.tells[tile]
    }

    fn see_around(
        &self,
        tiles: &mut [Tile<P, F>],
        bounds: &[TileBounds],
    ) -> Vec<(usize, TileBounds)> {
        let came = self.with_near(|rank| {
            let own = tiles.iter().enumerate().filter(|(_, tile)| tile.is_here);
            let seen = own.filter_map(|(number, tile)| {
                let seer = self.seer(number, rank)?;
                Some((tile.part(number, seer), bounds[number]))
            });
            seen.collect::<Vec<(TileData<P, F>, TileBounds)>>()
        });
        let mut known = Vec::new();
        for (content, bounds) in came.into_iter().flatten() {
            let number = content.tile as usize;
            known.push((number, bounds));
            tiles[number].hold(content);
        }
        known
    }

    fn tell_changes(
        &self,
        colour: usize,
        changes: &[ChangeOf<P>],
        meanwhile: &mut dyn FnMut(),
        then: &mut dyn FnMut(Vec<ChangeOf<P>>),
    ) {
        let [to, from] = &self.colours[colour];
        let messages = to.iter().map(|&rank| {
            let seen = changes.iter().filter(|change| {
                let seer = self.seer(change.tile as usize, rank);
                seer.is_some_and(|seer| seer.sees(change.cell))
            });
            (rank, to_bytes(&seen.copied().collect::<Vec<_>>()))
        });
        let messages = messages.collect();
        self.ranks
            .exchange_around(messages, from, meanwhile, &mut |came| {
                let all = came
                    .iter()
                    .flat_map(|bytes| from_bytes::<Vec<ChangeOf<P>>>(bytes));
                then(all.collect());
            });
    }

    fn all_reports(
        &self,
        grid: &Grid<P::Space>,
        mine: Vec<(u32, TileReport)>,
        looks: bool,
    ) -> Vec<(u32, TileReport)> {
        let counted: Vec<_> = mine
            .iter()
            .map(|(tile, report)| (*tile, report.tally, report.distances.clone()))
            .collect();
        let logs: Vec<(u32, Vec<Collision>)> = mine
            .iter()
            .filter(|(_, report)| self.me() > 0 && !report.log.is_empty())
            .map(|(tile, report)| (*tile, report.log.clone()))
            .collect();
        let mut all: Vec<Option<TileReport>> = Vec::new();
        all.resize_with(self.owners.len(), || None);
        for (tile, report) in mine {
            all[tile as usize] = Some(report);
        }
        for bytes in all_gather(&*self.ranks, to_bytes(&counted)) {
            for (tile, tally, distances) in
                from_bytes::<Vec<(u32, CollisionCounters, Distances)>>(&bytes)
            {
                all[tile as usize].get_or_insert_with(|| TileReport {
                    tally,
                    distances,
                    log: Vec::new(),
                });
            }
        }
        let came = if looks {
            gather(&*self.ranks, to_bytes(&logs))
        } else {
            Vec::new()
        };
        for bytes in came.iter().skip(1) {
            for (tile, log) in from_bytes::<Vec<(u32, Vec<Collision>)>>(bytes) {
                if let Some(report) = &mut all[tile as usize] {
                    report.log = log;
                }
            }
        }
        let order = colours(grid).into_iter().flatten();
        order
            .filter_map(|tile| Some((tile, all[tile as usize].take()?)))
            .collect()
    }

    fn see_no_more(&self, tiles: &mut [Tile<P, F>]) {
        (tiles.iter_mut().filter(|tile| !tile.is_here)).for_each(Tile::empty);
    }
}

/// Returns the numbers of the tiles that have cells within `reach` cells of a tile along each axis,
/// across periodic faces.
fn tiles_within<S: Space>(
    grid: &Grid<S>,
    tile: usize,
    reach: [usize; 3],
) -> impl Iterator<Item = usize> {
    let place = grid.tile_place(grid.place_of(tile));
    let [columns, rows, layers] = [0, 1, 2].map(|axis| {
        let count = i64::from(grid.counts()[axis]);
        let (first, side) = (i64::from(place.first[axis]), i64::from(place.sides[axis]));
        let reach = (reach[axis] as i64).min(count);
        let cells = (first - reach..first + side + reach).map(|cell| cell.rem_euclid(count) as u32);
        let mut at = [0; 3];
        let mut tiles: Vec<u32> = cells
            .map(|cell| {
                at[axis] = cell;
                grid.owner(at)[axis]
            })
            .collect();
        tiles.sort_unstable();
        tiles.dedup();
        tiles
    });
    let mut all = Vec::new();
    for &z in &layers {
        for &y in &rows {
            all.extend(columns.iter().map(|&x| grid.tile_number([x, y, z])));
        }
    }
    all.into_iter()
}
