//! Checkpoints in shards: each process writes the tiles that it holds, and the first a manifest of the files that belong together.
//!
//! A shard is a snapshot with its own checksum, which the manifest repeats: a shard of another checkpoint is none of this one. Whoever
//! goes on cuts the tiles anew, for any number of processes, and each reads those shards that have some of its tiles.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use stosszahl_model::snapshot::{self, Checksum, Fingerprint, SnapshotError};
use stosszahl_model::{Physics, VectorOf};

use super::bytes::{read, write};
use super::owners;
use super::ranks::gather;
use super::subdomain::TileData;
use crate::engine::Engine;
use crate::parameters::EngineError;
use crate::particle::{Follow, SimulatorOf};
use crate::tile::Tile;

/// Location of checkpoint shards: folder and run fingerprint.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Beside {
    /// The folder of the checkpoint.
    pub folder: PathBuf,
    /// The run that it belongs to.
    pub run: Fingerprint,
}

/// One file, with the tiles of one process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Shard {
    /// Its name in the folder of the checkpoint.
    file: String,
    checksum: Checksum,
    /// Numbers of the tiles, and of simulators in each.
    tiles: Vec<(u32, u32)>,
}

/// The name of the shard of a process, of a checkpoint whose shards have names that begin so.
pub fn shard_name(stem: &str, rank: usize) -> String {
    format!("{stem}{rank}.shard")
}

impl Shard {
    /// Error returned when this shard cannot be read.
    fn unusable(&self, why: &str, all: usize) -> EngineError {
        let simulators: u64 = self.tiles.iter().map(|one| u64::from(one.1)).sum();
        EngineError::Shard {
            why: why.to_owned(),
            tiles: self.tiles.len(),
            simulators,
            all,
        }
    }

    /// Its tiles.
    fn read<P: Physics, F: Follow<P::Space>>(
        &self,
        beside: &Beside,
        all: usize,
    ) -> Result<Vec<TileData<P, F>>, EngineError> {
        let path = beside.folder.join(&self.file);
        let shown = path.display();
        let said = |error: SnapshotError| match error {
            SnapshotError::Damaged {
                found, expected, ..
            } => format!("{shown}: {found}; expected {expected}"),
            other => other.to_string(),
        };
        let unusable = |why: String| self.unusable(&why, all);
        let (contents, checksum) =
            snapshot::read_checked::<Vec<TileData<P, F>>>(&path, &beside.run)
                .map_err(|error| unusable(said(error)))?;
        let tiles = contents.iter();
        let tiles = tiles.map(|one| (one.tile, one.simulators.len() as u32));
        if checksum != self.checksum || !tiles.eq(self.tiles.iter().copied()) {
            return Err(unusable(format!("{shown}: it is of another checkpoint")));
        }
        Ok(contents)
    }
}

/// All simulators of a checkpoint in shards; those of a cell are in their order.
pub(crate) fn read_all<P: Physics, F: Follow<P::Space>>(
    shards: &[Shard],
    beside: &Beside,
) -> Result<Vec<SimulatorOf<P, F>>, EngineError> {
    let mut all = Vec::new();
    for shard in shards {
        for content in shard.read::<P, F>(beside, shards.len())? {
            all.extend(content.simulators);
        }
    }
    Ok(all)
}

impl<P: Physics, F: Follow<P::Space>> Engine<P, F> {
    /// Has all processes write the tiles that they hold, into files with names that begin with `stem`; all call it. The first learns
    /// what belongs to the checkpoint, the others nothing.
    pub(crate) fn write_shards(
        &mut self,
        stem: &str,
        beside: &Beside,
    ) -> Result<Vec<Shard>, EngineError> {
        self.divide();
        let Some(ranks) = self.share.as_ref().map(|share| share.ranks.clone()) else {
            return Ok(Vec::new());
        };
        let file = shard_name(stem, ranks.rank());
        let mine = self.write_shard(file, beside);
        let mine = mine.map_err(|error| error.to_string());
        let mut shards = Vec::new();
        for (rank, bytes) in gather(&*ranks, write(&mine)).iter().enumerate() {
            let one: Result<Option<Shard>, String> = read(bytes);
            let elsewhere = |why| EngineError::Elsewhere { rank, why };
            let Some(shard) = one.map_err(elsewhere)? else {
                continue;
            };
            let path = beside.folder.join(&shard.file);
            if !path.is_file() {
                let path = path.display();
                let why = format!(
                    "it wrote {path}, which the first process does not see; all processes need the results folder"
                );
                return Err(elsewhere(why));
            }
            shards.push(shard);
        }
        Ok(shards)
    }

    fn write_shard(
        &mut self,
        file: String,
        beside: &Beside,
    ) -> Result<Option<Shard>, SnapshotError> {
        let own = self.tiles.iter_mut().enumerate();
        let own = own.filter(|(_, tile)| tile.is_here);
        let contents: Vec<_> = own.map(|(number, tile)| tile.content(number)).collect();
        let written = (!contents.is_empty())
            .then(|| snapshot::write(&beside.folder.join(&file), &beside.run, &contents))
            .transpose();
        let count = |content: &TileData<P, F>| (content.tile, content.simulators.len() as u32);
        let tiles = contents.iter().map(count).collect();
        for content in contents {
            self.tiles[content.tile as usize].hold(content);
        }
        Ok(written?.map(|checksum| Shard {
            file,
            checksum,
            tiles,
        }))
    }

    /// Gives each process its tiles, of a gas of which nobody has read any. All of them call it; each says what hinders it.
    pub(crate) fn read_shards(
        &mut self,
        shards: &[Shard],
        beside: &Beside,
    ) -> Result<(), EngineError> {
        let counts = self.counted_in(shards)?;
        let Some(mut share) = self.share.take() else {
            return Ok(());
        };
        self.simulators = counts.iter().sum();
        let tiles = self.tiles.iter().zip(&counts);
        let costs: Vec<f64> = tiles.map(|(tile, &count)| tile.guess(count)).collect();
        let owners = owners::bisect(self.grid.tiles(), &costs, share.ranks.size());
        share.own(&self.grid, owners, self.margin());
        self.part_with(&mut share);
        let is_mine = |tile: u32| share.is_mine(tile as usize);
        let mut done = Ok(());
        for shard in shards {
            if shard.tiles.iter().any(|&(tile, _)| is_mine(tile)) {
                let contents = match shard.read::<P, F>(beside, shards.len()) {
                    Ok(contents) => contents,
                    Err(error) => {
                        done = Err(error);
                        break;
                    }
                };
                for content in contents.into_iter().filter(|one| is_mine(one.tile)) {
                    let number = content.tile as usize;
                    if !self.tiles[number].fits(&content, |position| {
                        let (tile, cell) = self.grid.locate(self.grid.cell_at(position));
                        (tile == number).then_some(cell)
                    }) {
                        done =
                            Err(shard.unusable("its simulators are in other cells", shards.len()));
                        break;
                    }
                    self.tiles[number].hold(content);
                }
            }
        }
        self.share = Some(share);
        done
    }

    /// Simulators of each tile, if shards have each tile once.
    fn counted_in(&self, shards: &[Shard]) -> Result<Vec<usize>, EngineError> {
        let mut counts = vec![None; self.tiles.len()];
        for &(tile, count) in shards.iter().flat_map(|shard| &shard.tiles) {
            let Some(known @ None) = counts.get_mut(tile as usize) else {
                let why = format!(
                    "tile {tile} is there twice, or none of {}",
                    self.tiles.len()
                );
                return Err(EngineError::Checkpoint(why));
            };
            *known = Some(count as usize);
        }
        let all: Option<Vec<usize>> = counts.iter().copied().collect();
        all.ok_or_else(|| EngineError::Checkpoint("tiles are missing".into()))
    }
}

impl<P: Physics, F: Follow<P::Space>> Tile<P, F> {
    /// Whether the simulators of a content are in its cells, which `cell` finds.
    fn fits(&self, content: &TileData<P, F>, cell: impl Fn(VectorOf<P>) -> Option<usize>) -> bool {
        let total: usize = content.counts.iter().map(|&count| count as usize).sum();
        if content.counts.len() != self.cells() || total != content.simulators.len() {
            return false;
        }
        let counts = content.counts.iter().enumerate();
        let cells = counts.flat_map(|(cell, &count)| std::iter::repeat_n(cell, count as usize));
        let mut both = cells.zip(&content.simulators);
        both.all(|(number, one)| cell(one.position) == Some(number))
    }
}
