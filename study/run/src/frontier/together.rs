//! The processes that measure a frontier together: each makes a run whenever it is free, and all know what came of all of them. So all
//! decide the same, and the first writes the files.

use std::sync::atomic::{AtomicU64, Ordering};

use serde::Serialize;
use serde::de::DeserializeOwned;
use stosszahl_dsmc::{Ranks, from_first, gather_from_all};

use super::FrontierError;

/// Processes that hand out work to each other.
pub trait Fellows: Ranks {
    /// The next number of a series: 0, 1, 2 and so on, each to one of those who ask, whichever process they are in.
    fn draw(&self, series: u64) -> u64;
}

/// The processes, if there are several.
#[derive(Clone, Copy)]
pub(crate) struct Together<'a>(pub Option<&'a dyn Fellows>);

/// Numbers that those who work draw from, in this process and others.
pub(crate) struct Turns<'a> {
    fellows: Option<&'a dyn Fellows>,
    series: u64,
    /// The next one, where there is one process.
    next: AtomicU64,
}

impl Turns<'_> {
    /// The next one.
    pub(crate) fn draw(&self) -> usize {
        let turn = match self.fellows {
            Some(fellows) => fellows.draw(self.series),
            None => self.next.fetch_add(1, Ordering::Relaxed),
        };
        turn as usize
    }
}

impl Together<'_> {
    /// Turns from 0 on; all processes ask for those of the same series.
    pub(crate) fn turns(&self, series: u64) -> Turns<'_> {
        Turns {
            fellows: self.0,
            series,
            next: AtomicU64::new(0),
        }
    }

    /// What all processes say, by their number.
    pub(crate) fn all<T: Serialize + DeserializeOwned>(&self, mine: T) -> Vec<T> {
        let Some(ranks) = self.0 else {
            return vec![mine];
        };
        // Fails only for types without a length, and for messages of another program, which was refused before.
        let bytes = postcard::to_stdvec(&mine).unwrap_or_default();
        let all = gather_from_all(ranks, bytes);
        let read = all.iter().flat_map(|bytes| postcard::from_bytes(bytes));
        read.collect()
    }

    /// What every process does for itself, if all can.
    ///
    /// # Errors
    /// Its own error, or that of the first process that has one.
    pub(crate) fn each<T>(&self, mine: Result<T, FrontierError>) -> Result<T, FrontierError> {
        let whys = self.all(mine.as_ref().err().map(ToString::to_string));
        let mine = mine?;
        match whys
            .into_iter()
            .enumerate()
            .find_map(|(rank, why)| Some((rank, why?)))
        {
            Some((rank, why)) => Err(FrontierError::Elsewhere { rank, why }),
            None => Ok(mine),
        }
    }

    /// What the first process does, as all know it then.
    ///
    /// # Errors
    /// Those of the work, which the others know as [`FrontierError::Elsewhere`].
    pub(crate) fn first<T: Serialize + DeserializeOwned>(
        &self,
        work: impl FnOnce() -> Result<T, FrontierError>,
    ) -> Result<T, FrontierError> {
        let Some(ranks) = self.0 else {
            return work();
        };
        if ranks.rank() == 0 {
            let done = work();
            let said = done.as_ref().map_err(ToString::to_string);
            from_first(ranks, postcard::to_stdvec(&said).unwrap_or_default());
            return done;
        }
        let said = postcard::from_bytes(&from_first(ranks, Vec::new()));
        let done: Result<T, String> = said.unwrap_or_else(|error| Err(error.to_string()));
        done.map_err(|why| FrontierError::Elsewhere { rank: 0, why })
    }
}
