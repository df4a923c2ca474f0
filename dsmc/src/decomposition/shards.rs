//! Sharded checkpoints: each process writes its tiles, the root process the manifest of the files.
//!
//! A shard is a snapshot with a checksum that the manifest repeats, so shards of different
//! checkpoints do not mix. A resumed run cuts the tiles anew, for any number of processes, and each
//! reads the shards that hold some of its tiles.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use stosszahl_model::snapshot::{self, Checksum, Fingerprint, SnapshotError};
use stosszahl_model::{ParticleModel, VectorOf};

use super::bytes::{from_bytes, to_bytes};
use super::ranks::gather;
use super::subdomain::TileData;
use crate::engine::DsmcEngine;
use crate::parameters::DsmcError;
use crate::particle::{DisplacementTracking, SimulatorOf};
use crate::tile::Tile;

/// Location of the shards of a checkpoint, files with the tiles of one process each: folder and run
/// fingerprint.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShardLocation {
    /// Folder that contains the checkpoint and its shards.
    pub folder: PathBuf,
    /// Fingerprint of the run, a hash of its settings, to which the checkpoint belongs.
    pub run: Fingerprint,
}

/// Entry in the manifest of a sharded checkpoint: a file, and the tiles of one process in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Shard {
    /// File name of the shard in the folder of the checkpoint.
    file: String,
    checksum: Checksum,
    /// Number of each tile in the shard, with the number of simulators in it.
    tiles: Vec<(u32, u32)>,
}

/// Returns the file name of the shard of a process, for a checkpoint whose shard names begin with
/// `stem`.
pub fn shard_name(stem: &str, rank: usize) -> String {
    format!("{stem}{rank}.shard")
}

impl Shard {
    /// Returns the error that this shard cannot be used, with the reason; `all` is the number of
    /// shards.
    fn unusable(&self, why: &str, all: usize) -> DsmcError {
        let simulators: u64 = self.tiles.iter().map(|one| u64::from(one.1)).sum();
        DsmcError::Shard {
            why: why.to_owned(),
            tiles: self.tiles.len(),
            simulators,
            all,
        }
    }

    /// Reads all tiles from the file of this shard; `all` is the number of shards for error
    /// messages.
    fn read_tiles<P: ParticleModel, F: DisplacementTracking<P::Space>>(
        &self,
        beside: &ShardLocation,
        all: usize,
    ) -> Result<Vec<TileData<P, F>>, DsmcError> {
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

/// Reads all simulators of a sharded checkpoint into one process, in the order of their cells.
pub(crate) fn read_all<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    shards: &[Shard],
    beside: &ShardLocation,
) -> Result<Vec<SimulatorOf<P, F>>, DsmcError> {
    let mut all = Vec::new();
    for shard in shards {
        for content in shard.read_tiles::<P, F>(beside, shards.len())? {
            all.extend(content.simulators);
        }
    }
    Ok(all)
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> DsmcEngine<P, F> {
    /// Writes the tiles of each process into a shard whose file name begins with `stem`. All
    /// processes must call it. Returns the manifest of shards in the root process, and nothing in
    /// others.
    pub(crate) fn write_shards(
        &mut self,
        stem: &str,
        beside: &ShardLocation,
    ) -> Result<Vec<Shard>, DsmcError> {
        self.scatter_tiles();
        let Some(ranks) = self.share.as_ref().map(|share| share.ranks.clone()) else {
            return Ok(Vec::new());
        };
        let file = shard_name(stem, ranks.rank());
        let mine = self.write_shard(file, beside);
        let mine = mine.map_err(|error| error.to_string());
        let mut shards = Vec::new();
        for (rank, bytes) in gather(&*ranks, to_bytes(&mine)).iter().enumerate() {
            let one: Result<Option<Shard>, String> = from_bytes(bytes);
            let elsewhere = |why| DsmcError::Elsewhere { rank, why };
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
        beside: &ShardLocation,
    ) -> Result<Option<Shard>, SnapshotError> {
        let own = self.tiles.iter_mut().enumerate();
        let own = own.filter(|(_, tile)| tile.is_here);
        let contents: Vec<_> = own.map(|(number, tile)| tile.content(number)).collect();
        let written = (!contents.is_empty())
            .then(|| snapshot::write_snapshot(&beside.folder.join(&file), &beside.run, &contents))
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

    /// Reads the tiles that each process owns from the shards. All processes must call it; an error
    /// in any process reaches all.
    pub(crate) fn read_shards(
        &mut self,
        shards: &[Shard],
        beside: &ShardLocation,
    ) -> Result<(), DsmcError> {
        let counts = self.counted_in(shards)?;
        let Some(mut share) = self.share.take() else {
            return Ok(());
        };
        self.divide(&mut share, &counts);
        let is_mine = |tile: u32| share.is_mine(tile as usize);
        let mut done = Ok(());
        for shard in shards {
            if shard.tiles.iter().any(|&(tile, _)| is_mine(tile)) {
                let contents = match shard.read_tiles::<P, F>(beside, shards.len()) {
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

    /// Returns the number of simulators in each tile by the manifest; an error unless the shards
    /// hold each tile exactly once.
    fn counted_in(&self, shards: &[Shard]) -> Result<Vec<usize>, DsmcError> {
        let mut counts = vec![None; self.tiles.len()];
        for &(tile, count) in shards.iter().flat_map(|shard| &shard.tiles) {
            let Some(known @ None) = counts.get_mut(tile as usize) else {
                let why = format!(
                    "tile {tile} is there twice, or none of {}",
                    self.tiles.len()
                );
                return Err(DsmcError::Checkpoint(why));
            };
            *known = Some(count as usize);
        }
        let all: Option<Vec<usize>> = counts.iter().copied().collect();
        all.ok_or_else(|| DsmcError::Checkpoint("tiles are missing".into()))
    }
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> Tile<P, F> {
    /// Returns true if the simulators in the data of a tile lie in the cells in which they are
    /// listed; `cell` finds the cell of a position.
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
