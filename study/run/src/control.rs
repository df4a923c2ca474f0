//! Checkpoints, interruption and progress of one part of a run.

use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};
use std::{fmt, fs, io};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_dsmc::Beside;
use stosszahl_model::Interrupt;
use stosszahl_model::snapshot::{self, Fingerprint, SnapshotError};
use stosszahl_results::{ResultsError, half_written};

use crate::gauge::Gauge;

/// What a run tells while it goes on; libraries print nothing.
pub trait Progress: Sync {
    /// A point of a sweep, or the only one, begins: its name or title, and its work, of which nothing is done.
    fn begin(&self, _point: usize, _name: &str, _work: Gauge) {}

    /// A part has done a share of its work, and this many collisions since its last report.
    fn tell(&self, _point: usize, _part: usize, _share: f64, _collisions: u64) {}

    /// What takes the time of a part that goes on slowly, in words.
    fn tell_activity(&self, _point: usize, _part: usize, _activity: &str) {}

    /// A point is finished.
    fn end(&self, _point: usize) {}

    /// What a user should know.
    fn note(&self, _text: &str) {}
}

/// Tells nothing.
impl Progress for () {}

/// What a checkpoint holds.
pub trait Content: Serialize + DeserializeOwned {
    /// Which of the two sets of shards belongs to it, if it has some.
    fn set(&self) -> Option<Set> {
        None
    }
}

/// Shards are written beside those of the checkpoint before, which go only when the new checkpoint is there: two sets in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Set {
    /// One.
    A,
    /// The other.
    B,
}

impl Set {
    /// Both.
    pub const ALL: [Self; 2] = [Self::A, Self::B];

    /// The one that the next checkpoint has.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }

    /// How the names of its shards begin, of a checkpoint with a name.
    pub fn stem(self, checkpoint: &str) -> String {
        let set = match self {
            Self::A => "a",
            Self::B => "b",
        };
        format!("{checkpoint}.{set}-")
    }
}

/// Place in a run that a checkpoint was written for. Two checkpoints of one run differ in it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CheckpointOrigin {
    /// Replica, from 0.
    pub replica: u64,
    /// `start`, or the name of the engine.
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

/// File of the checkpoint of one part of a run.
pub struct CheckpointFile<'a> {
    /// Path of the file.
    pub path: PathBuf,
    /// Hash of all that decides the numbers, and of the point.
    pub run: Fingerprint,
    /// Place in the run.
    pub origin: CheckpointOrigin,
    /// Says whether the file may still be written; `None` if it always may.
    pub guard: Option<&'a WriteGuard<'a>>,
}

/// Says whether files may still be written: the results folder is at its path, and the replica was not taken over by another process.
pub type WriteGuard<'a> = dyn Fn() -> Result<(), ResultsError> + Sync + 'a;

/// Saves, stops and tells about one part of one replica. `T` is what is saved.
pub struct Control<'a, T> {
    /// The checkpoint; none if nothing is kept.
    file: Option<CheckpointFile<'a>>,
    interval: Duration,
    last: Mutex<Instant>,
    stop: &'a Interrupt,
    tell: &'a (dyn Fn(f64, u64) + Sync),
    tell_activity: &'a (dyn Fn(&str) + Sync),
    content: PhantomData<fn(T)>,
}

/// A finished part that took less since its last checkpoint is not saved by itself.
const WORTH_SAVING: Duration = Duration::from_secs(1);

/// What to roll back to is kept at most so often \[s\], and so that keeping it takes at most this share of the time.
const ROLLBACK_SECONDS: f64 = 1.0;
const ROLLBACK_SHARE: f64 = 0.02;

/// What a leg that is broken off is rolled back to: what was saved before it, in memory.
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

/// The run was asked to stop; its checkpoint is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interrupted;

#[cfg(test)]
impl CheckpointFile<'_> {
    /// A checkpoint outside of a results folder.
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
    /// The control of a part, with `seconds` of computing between two checkpoints.
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

    /// The same where somebody hears what takes the time.
    #[must_use]
    pub fn with_activity(self, tell_activity: &'a (dyn Fn(&str) + Sync)) -> Self {
        Self {
            tell_activity,
            ..self
        }
    }

    /// Tells what takes the time, in words.
    pub fn tell_activity(&self, activity: &str) {
        (self.tell_activity)(activity);
    }

    /// Tells the share that is done, and the collisions since the last time.
    pub fn tell(&self, share: f64, collisions: u64) {
        (self.tell)(share, collisions);
    }

    /// The last checkpoint, if there is one.
    ///
    /// # Errors
    /// [`SnapshotError`] if it is damaged, or of another run, replica or engine.
    pub fn load(&self) -> Result<Option<T>, SnapshotError> {
        let Some(file) = &self.file else {
            return Ok(None);
        };
        match snapshot::read::<(CheckpointOrigin, T)>(&file.path, &file.run) {
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

    /// Writes a checkpoint.
    ///
    /// # Errors
    /// [`SnapshotError`] if it cannot.
    pub fn save(&self, content: &T) -> Result<(), SnapshotError> {
        let Some(file) = &self.file else {
            return Ok(());
        };
        let path = &file.path;
        if let Some(guard) = file.guard {
            guard().map_err(|error| SnapshotError::of_file(path, io::Error::other(error)))?;
        }
        snapshot::write(path, &file.run, &(&file.origin, content))?;
        remove_shards(path, content.set());
        Ok(())
    }

    /// Of a finished part: writes its checkpoint if the run is asked to stop, or if it took a while to come here from the last one. What
    /// is done again in a moment is not worth a file, of which thousands of short replicas would make thousands.
    ///
    /// # Errors
    /// Those of `content` and of [`Self::save`].
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

    /// Of a gas that several processes hold: how the names of its shards begin, of a set, and the run that they are of; none if nothing
    /// is kept.
    pub fn shards(&self, set: Set) -> Option<(PathBuf, &Fingerprint)> {
        let file = self.file.as_ref()?;
        let name = file.path.file_name()?.to_str()?;
        Some((file.path.with_file_name(set.stem(name)), &file.run))
    }

    /// Where the shards of the last checkpoint are.
    pub fn beside(&self) -> Option<Beside> {
        let file = self.file.as_ref()?;
        Some(Beside {
            folder: std::path::absolute(&file.path).ok()?.parent()?.to_owned(),
            run: file.run,
        })
    }

    /// What asks the part to stop.
    pub fn interrupt(&self) -> &'a Interrupt {
        self.stop
    }

    /// Before a leg, which may be broken off: keeps what is saved, unless little was done since the last time. As in
    /// [`Self::pause`], only whether it is kept depends on the clock. What is in shards, and so on disk, becomes the checkpoint at
    /// once.
    ///
    /// # Errors
    /// Those of `gather` and of [`Self::save`].
    pub fn keep<E: From<SnapshotError>>(
        &self,
        rollback: &mut Rollback<T>,
        gather: impl FnOnce() -> Result<T, E>,
    ) -> Result<(), E> {
        let due = ROLLBACK_SECONDS.max(rollback.cost / ROLLBACK_SHARE);
        if self.file.is_none() || rollback.since.elapsed().as_secs_f64() < due {
            return Ok(());
        }
        // Never two at a time.
        rollback.saved = None;
        let began = Instant::now();
        let hold = self.stop.hold();
        let saved = gather()?;
        if saved.set().is_some() {
            self.save(&saved)?;
        } else {
            rollback.saved = Some(saved);
        }
        drop(hold);
        rollback.cost = began.elapsed().as_secs_f64();
        rollback.since = Instant::now();
        Ok(())
    }

    /// A leg was broken off: what was kept becomes the checkpoint. Without it the last checkpoint stays.
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

    /// After a leg: saves when it is time to, and stops when asked to. Only whether a checkpoint is written depends on the
    /// clock, never what is in it.
    ///
    /// # Errors
    /// Those of `gather` and of [`Self::save`]; [`Interrupted`] when asked to stop.
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

/// Removes the shards that belong to a checkpoint no more: those of the sets but one. What cannot be removed is written over, or goes
/// with the run.
fn remove_shards(checkpoint: &Path, kept: Option<Set>) {
    let (Some(folder), Some(name)) = (checkpoint.parent(), checkpoint.file_name()) else {
        return;
    };
    let old = Set::ALL.into_iter().filter(|set| kept != Some(*set));
    let stems: Vec<String> = old.map(|set| set.stem(&name.to_string_lossy())).collect();
    let ours = |name: &str| {
        // A kill may have left one that is not whole.
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

    /// A leg that is broken off is rolled back to what was kept before it, which is then on disk; and nothing is kept twice.
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
        // Too early for another one.
        control.keep(&mut rollback, gather(3)).expect("kept");
        assert_eq!(control.load().expect("read"), Some(1));
        assert_eq!(
            control.roll_back(&mut rollback).expect("saved"),
            Interrupted
        );
        assert_eq!(control.load().expect("read"), Some(2));
        // With nothing kept, the checkpoint stays.
        assert_eq!(
            control.roll_back(&mut rollback).expect("saved"),
            Interrupted
        );
        assert_eq!(control.load().expect("read"), Some(2));
    }

    /// A checkpoint of another replica, part or seed under the name of one is refused with both.
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
        fn set(&self) -> Option<Set> {
            self.0
        }
    }

    /// Shards of the checkpoint before go when the next is there, and nothing else does.
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
