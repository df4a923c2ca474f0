//! Checkpoints, interruption and progress reports of one part of a run: one engine of one replica,
//! or its start.

use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};
use std::{fmt, fs, io};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_dsmc::ShardLocation;
use stosszahl_model::Interrupt;
use stosszahl_model::snapshot::{self, Fingerprint, SnapshotError};
use stosszahl_results::{ResultsError, half_written};

/// Data stored in a checkpoint.
pub trait Content: Serialize + DeserializeOwned {
    /// Returns the set of shards that belongs to the checkpoint; `None` without shards.
    fn shard_set(&self) -> Option<Set> {
        None
    }
}

/// Alternating sets of checkpoint shards. A new checkpoint writes the other set, and the old one is
/// removed when it is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Set {
    /// First of two alternating sets of checkpoint shards.
    A,
    /// Second of two alternating sets of checkpoint shards.
    B,
}

impl Set {
    /// Both alternating sets of checkpoint shards.
    pub const ALL: [Self; 2] = [Self::A, Self::B];

    /// Returns the set of shards that the next checkpoint uses.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }

    /// Returns the common beginning of the shard file names of this set, from the name of the
    /// checkpoint.
    pub fn stem(self, checkpoint: &str) -> String {
        let set = match self {
            Self::A => "a",
            Self::B => "b",
        };
        format!("{checkpoint}.{set}-")
    }
}

/// Origin of a checkpoint: replica, part and seed. It distinguishes the checkpoints of one run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CheckpointOrigin {
    /// Number of the replica, from 0.
    pub replica: u64,
    /// Name of the part of the run: `start`, or the engine.
    pub part: String,
    /// Seed of the case.
    pub seed: u64,
}

impl fmt::Display for CheckpointOrigin {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            replica,
            part,
            seed,
        } = self;
        write!(to, "{part} of replica {replica}, seed {seed}")
    }
}

/// Checkpoint file of one part of a run: path, fingerprint and origin.
pub struct CheckpointFile<'a> {
    /// Path of the checkpoint file.
    pub path: PathBuf,
    /// Fingerprint of the run and its sweep point.
    pub run: Fingerprint,
    /// Replica, part and seed of the checkpoint.
    pub origin: CheckpointOrigin,
    /// Check whether the checkpoint may still be written; `None` if it always may.
    pub guard: Option<&'a WriteGuard<'a>>,
}

/// Callback that returns an error if files may no longer be written: the results folder was moved,
/// or another process has taken over the replica.
pub type WriteGuard<'a> = dyn Fn() -> Result<(), ResultsError> + Sync + 'a;

/// Checkpointing, interruption and progress of one part of one replica. `T` is the data stored in a
/// checkpoint.
pub struct Control<'a, T> {
    /// Checkpoint file; `None` if nothing is saved.
    file: Option<CheckpointFile<'a>>,
    interval: Duration,
    last: Mutex<Instant>,
    stop: &'a Interrupt,
    tell: &'a (dyn Fn(f64, u64) + Sync),
    tell_activity: &'a (dyn Fn(&str) + Sync),
    content: PhantomData<fn(T)>,
}

/// Computing time since the last checkpoint below which a finished part of a run is not saved.
const WORTH_SAVING: Duration = Duration::from_secs(1);

/// Shortest computing time between two rollback states of an interruptible run \[s\].
const ROLLBACK_SECONDS: f64 = 1.0;
/// Largest fraction of the computing time spent on rollback states.
const ROLLBACK_SHARE: f64 = 0.02;

/// Rollback state of an interrupted segment, in memory: the checkpoint data from before it.
pub struct Rollback<T> {
    saved: Option<T>,
    since: Instant,
    cost: f64,
}

impl<T> Default for Rollback<T> {
    fn default() -> Self {
        Self {
            saved: None,
            since: Instant::now(),
            cost: 0.0,
        }
    }
}

/// Error of a run that was interrupted, after its checkpoint was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interrupted;

#[cfg(test)]
impl CheckpointFile<'_> {
    /// Creates a checkpoint file outside of any results folder.
    pub(crate) fn alone(path: PathBuf) -> Self {
        Self {
            path,
            run: [1; 32],
            origin: CheckpointOrigin::default(),
            guard: None,
        }
    }
}

impl<'a, T: Content> Control<'a, T> {
    /// Creates the control of a part. `seconds` is the computing time between two checkpoints.
    pub fn new(
        file: Option<CheckpointFile<'a>>,
        seconds: f64,
        stop: &'a Interrupt,
        tell: &'a (dyn Fn(f64, u64) + Sync),
    ) -> Self {
        Self {
            file,
            interval: Duration::from_secs_f64(seconds.clamp(0.0, 1e9)),
            last: Mutex::new(Instant::now()),
            stop,
            tell,
            tell_activity: &|_| {},
            content: PhantomData,
        }
    }

    /// Sets the receiver of messages on what a slow part spends its time on.
    #[must_use]
    pub fn with_activity(self, tell_activity: &'a (dyn Fn(&str) + Sync)) -> Self {
        Self {
            tell_activity,
            ..self
        }
    }

    /// Reports in words what the part spends its time on.
    pub fn tell_activity(&self, activity: &str) {
        (self.tell_activity)(activity);
    }

    /// Reports the fraction of the part's work that is done, and the collisions since the last
    /// report.
    pub fn report_progress(&self, share: f64, collisions: u64) {
        (self.tell)(share, collisions);
    }

    /// Reads the last checkpoint of the part; `None` if there is none.
    ///
    /// # Errors
    /// [`SnapshotError`] if it is damaged, or of another run, replica or engine.
    pub fn load(&self) -> Result<Option<T>, SnapshotError> {
        let Some(file) = &self.file else {
            return Ok(None);
        };
        match snapshot::read_snapshot::<(CheckpointOrigin, T)>(&file.path, &file.run) {
            Ok((origin, content)) if origin == file.origin => Ok(Some(content)),
            Ok((origin, _)) => Err(SnapshotError::Misplaced {
                path: file.path.clone(),
                found: format!("a checkpoint of {origin}"),
                expected: format!("one of {}", file.origin),
            }),
            Err(SnapshotError::File { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                Ok(None)
            }
            Err(error) => Err(error),
        }
    }

    /// Writes a checkpoint of the part.
    ///
    /// # Errors
    /// [`SnapshotError`] if the file cannot be written.
    pub fn save(&self, content: &T) -> Result<(), SnapshotError> {
        let Some(file) = &self.file else {
            return Ok(());
        };
        let path = &file.path;
        if let Some(guard) = file.guard {
            guard().map_err(|error| SnapshotError::of_file(path, io::Error::other(error)))?;
        }
        snapshot::write_snapshot(path, &file.run, &(&file.origin, content))?;
        remove_shards(path, content.shard_set());
        Ok(())
    }

    /// Writes the checkpoint of a finished part if the run is interrupted, or if the part took long
    /// since the last checkpoint. Short replicas, of which there may be thousands, are not worth a
    /// file.
    ///
    /// # Errors
    /// Errors of `content` and of [`Self::save`].
    pub fn finish<E: From<SnapshotError>>(
        &self,
        content: impl FnOnce() -> Result<T, E>,
    ) -> Result<(), E> {
        let last = *(self.last.lock()).unwrap_or_else(std::sync::PoisonError::into_inner);
        if self.stop.is_raised() || last.elapsed() >= self.interval.min(WORTH_SAVING) {
            self.save(&content()?)?;
        }
        Ok(())
    }

    /// Returns path and common name of the shard files of a set, and the fingerprint of the run;
    /// `None` if nothing is saved.
    pub fn shards(&self, set: Set) -> Option<(PathBuf, &Fingerprint)> {
        let file = self.file.as_ref()?;
        let name = file.path.file_name()?.to_str()?;
        Some((file.path.with_file_name(set.stem(name)), &file.run))
    }

    /// Returns the location of the shards of the last checkpoint; `None` without shards.
    pub fn beside(&self) -> Option<ShardLocation> {
        let file = self.file.as_ref()?;
        Some(ShardLocation {
            folder: std::path::absolute(&file.path).ok()?.parent()?.to_owned(),
            run: file.run,
        })
    }

    /// Returns the interrupt that stops the part.
    pub fn interrupt(&self) -> &'a Interrupt {
        self.stop
    }

    /// Stores the rollback state before a segment that may be interrupted, unless little was done
    /// since the last one. As in [`Self::pause`], the clock decides only whether it is stored. A
    /// state in shards is on disk, and becomes the checkpoint at once.
    ///
    /// # Errors
    /// Errors of `gather` and of [`Self::save`].
    pub fn keep<E: From<SnapshotError>>(
        &self,
        rollback: &mut Rollback<T>,
        gather: impl FnOnce() -> Result<T, E>,
    ) -> Result<(), E> {
        let due = ROLLBACK_SECONDS.max(rollback.cost / ROLLBACK_SHARE);
        if self.file.is_none() || rollback.since.elapsed().as_secs_f64() < due {
            return Ok(());
        }
        // Frees the old state first, so that there are never two.
        rollback.saved = None;
        let began = Instant::now();
        let hold = self.stop.hold();
        let saved = gather()?;
        if saved.shard_set().is_some() {
            self.save(&saved)?;
        } else {
            rollback.saved = Some(saved);
        }
        drop(hold);
        rollback.cost = began.elapsed().as_secs_f64();
        rollback.since = Instant::now();
        Ok(())
    }

    /// Writes the rollback state as the checkpoint after an interrupted segment. If there is none,
    /// the last checkpoint stays.
    ///
    /// # Errors
    /// As [`Self::save`].
    pub fn roll_back(&self, rollback: &mut Rollback<T>) -> Result<Interrupted, SnapshotError> {
        if let Some(saved) = rollback.saved.take() {
            let _hold = self.stop.hold();
            self.save(&saved)?;
        }
        Ok(Interrupted)
    }

    /// Writes a checkpoint after a segment if it is due, and stops if the run is interrupted. The
    /// clock decides only whether a checkpoint is written, never its content.
    ///
    /// # Errors
    /// Errors of `gather` and of [`Self::save`]; [`Interrupted`] if asked to stop.
    pub fn pause<E: From<SnapshotError> + From<Interrupted>>(
        &self,
        rollback: &mut Rollback<T>,
        gather: impl FnOnce() -> Result<T, E>,
    ) -> Result<(), E> {
        let stop = self.stop.is_raised();
        let due = {
            let mut last = (self.last.lock()).unwrap_or_else(std::sync::PoisonError::into_inner);
            let due = last.elapsed() >= self.interval;
            if due {
                *last = Instant::now();
            }
            due
        };
        if self.file.is_some() && (stop || due) {
            let _hold = self.stop.hold();
            *rollback = Rollback::default();
            self.save(&gather()?)?;
        }
        if stop {
            Err(Interrupted.into())
        } else {
            Ok(())
        }
    }
}

/// Removes the checkpoint shards of all sets but `kept`. Files that cannot be removed are
/// overwritten later, or removed with the run.
fn remove_shards(checkpoint: &Path, kept: Option<Set>) {
    let (Some(folder), Some(name)) = (checkpoint.parent(), checkpoint.file_name()) else {
        return;
    };
    let old = Set::ALL.into_iter().filter(|set| kept != Some(*set));
    let stems: Vec<String> = old.map(|set| set.stem(&name.to_string_lossy())).collect();
    let ours = |name: &str| {
        // A kill may have left a file that is not complete.
        let whole = half_written(name);
        let name = whole.as_deref().unwrap_or(name);
        stems.iter().any(|stem| {
            let rank = name.strip_prefix(stem.as_str());
            let rank = rank.and_then(|rest| rest.strip_suffix(".shard"));
            rank.is_some_and(|rank| rank.parse::<usize>().is_ok())
        })
    };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name().to_str().is_some_and(ours) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Content for u64 {}

    /// An interrupted segment is rolled back to the state saved before it, which is then on disk;
    /// nothing is saved twice.
    #[test]
    fn what_was_kept_before_a_leg_becomes_the_checkpoint() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, stop) = (folder.path().join("part.snapshot"), Interrupt::default());
        let file = CheckpointFile::alone(path);
        let control: Control<'_, u64> = Control::new(Some(file), 1e9, &stop, &|_, _| {});
        let gather = |number| move || Ok::<u64, SnapshotError>(number);
        let long_ago = Instant::now().checked_sub(Duration::from_secs(5));
        let mut rollback = Rollback {
            since: long_ago.expect("a machine that is up"),
            ..Rollback::default()
        };
        control.save(&1).expect("saved");
        control.keep(&mut rollback, gather(2)).expect("kept");
        // Too early for another state.
        control.keep(&mut rollback, gather(3)).expect("kept");
        assert_eq!(control.load().expect("read"), Some(1));
        assert_eq!(
            control.roll_back(&mut rollback).expect("saved"),
            Interrupted
        );
        assert_eq!(control.load().expect("read"), Some(2));
        // Without a rollback state the checkpoint stays.
        assert_eq!(
            control.roll_back(&mut rollback).expect("saved"),
            Interrupted
        );
        assert_eq!(control.load().expect("read"), Some(2));
    }

    /// A checkpoint of another replica, part or seed is refused, and both are named.
    #[test]
    fn a_checkpoint_of_another_replica_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, stop) = (folder.path().join("part.snapshot"), Interrupt::default());
        let origin = |replica, part: &str, seed| CheckpointOrigin {
            replica,
            part: part.to_owned(),
            seed,
        };
        let control = |origin| {
            let file = CheckpointFile {
                origin,
                ..CheckpointFile::alone(path.clone())
            };
            Control::<u64>::new(Some(file), 1e9, &stop, &|_, _| {})
        };
        let own = origin(1, "ed", 5);
        control(own.clone()).save(&7).expect("saved");
        assert_eq!(control(own).load().expect("read"), Some(7));
        for (other, found) in [
            (origin(0, "ed", 5), "one of ed of replica 0, seed 5"),
            (
                origin(1, "dsmc-enskog", 5),
                "one of dsmc-enskog of replica 1, seed 5",
            ),
            (origin(1, "ed", 6), "one of ed of replica 1, seed 6"),
        ] {
            let said = control(other).load().expect_err("refused").to_string();
            assert!(
                said.contains("holds a checkpoint of ed of replica 1, seed 5"),
                "{said}"
            );
            assert!(said.contains(found), "{said}");
        }
    }

    #[derive(Serialize, Deserialize)]
    struct InShards(Option<Set>);

    impl Content for InShards {
        fn shard_set(&self) -> Option<Set> {
            self.0
        }
    }

    /// Shards of the previous checkpoint are removed when the next is complete, and no other files.
    #[test]
    fn a_checkpoint_removes_the_shards_of_others() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, stop) = (folder.path().join("part.snapshot"), Interrupt::default());
        let file = CheckpointFile::alone(path);
        let control: Control<'_, InShards> = Control::new(Some(file), 1e9, &stop, &|_, _| {});
        let all = [
            "part.snapshot.a-0.shard",
            "part.snapshot.a-12.shard",
            "part.snapshot.b-0.shard",
            ".part.snapshot.b-3.shard.a1b2c3",
            "other.snapshot.a-0.shard",
            "part.snapshot.a-mine.shard",
        ];
        let left = || -> Vec<bool> {
            all.iter()
                .map(|name| folder.path().join(name).exists())
                .collect()
        };
        for (set, wanted) in [
            (Some(Set::A), [true, true, false, false, true, true]),
            (Some(Set::B), [false, false, true, true, true, true]),
            (None, [false, false, false, false, true, true]),
        ] {
            for name in all {
                fs::write(folder.path().join(name), "").expect("written");
            }
            control.save(&InShards(set)).expect("saved");
            assert_eq!(left(), wanted, "{set:?}");
        }
    }
}
