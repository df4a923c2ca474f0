//! Interface of the message transport between the processes that hold one gas, and collective
//! operations built on it: gather, reduce, broadcast.

use serde::Serialize;
use serde::de::DeserializeOwned;
use stosszahl_model::DynReduction;

use super::bytes::{from_bytes, to_bytes};

/// Message transport between the processes that hold one gas (MPI, for example). All processes make
/// the same calls in the same order.
pub trait Ranks: Send + Sync {
    /// Returns the rank of this process, from 0.
    fn rank(&self) -> usize;

    /// Returns the number of processes.
    fn size(&self) -> usize;

    /// Sends messages to other processes, and returns one message from each process in `from`, in
    /// that order. A process lists every sender in its own `from`. Messages may have any length;
    /// none is lost, and messages between two processes arrive in order.
    fn exchange(&self, messages: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Vec<Vec<u8>> {
        let mut all = Vec::new();
        self.exchange_around(messages, from, &mut || (), &mut |came| all = came);
        all
    }

    /// Exchanges messages around other work: sends, calls `meanwhile` while messages travel, then
    /// calls `then` with the messages received, which may contain other exchanges. Each is called
    /// once. Only at the end does it wait until the receivers have taken the messages.
    fn exchange_around(
        &self,
        messages: Vec<(usize, Vec<u8>)>,
        from: &[usize],
        meanwhile: &mut dyn FnMut(),
        then: &mut dyn FnMut(Vec<Vec<u8>>),
    );
}

/// Gathers the messages of all processes in every process, by rank, in log2(size) rounds (Bruck et
/// al., IEEE Trans. Parallel Distrib. Syst. 8, 1143 (1997), doi:10.1109/71.642949).
pub fn all_gather(ranks: &dyn Ranks, mine: Vec<u8>) -> Vec<Vec<u8>> {
    let (me, size) = (ranks.rank(), ranks.size());
    // Messages of this process and the following ones.
    let mut known = vec![mine];
    let mut step = 1;
    while step < size {
        let count = step.min(size - step);
        let (to, from) = ((me + size - step) % size, (me + step) % size);
        let came = ranks.exchange(vec![(to, pack_messages(&known[..count]))], &[from]);
        known.extend(came.iter().flat_map(|one| unpack(one)));
        step *= 2;
    }
    known.rotate_right(me);
    known
}

/// Reduces a value over all processes and returns the result in each, in log2(size) rounds, and two
/// more unless the size is a power of two. `add` must not depend on the order.
pub(crate) fn all_reduce<T: Serialize + DeserializeOwned>(
    ranks: &dyn Ranks,
    mut sum: T,
    add: impl Fn(&mut T, T),
) -> T {
    let (me, size) = (ranks.rank(), ranks.size());
    let from = |rank: usize| from_bytes::<T>(&ranks.exchange(Vec::new(), &[rank])[0]);
    // Processes beyond the power of two are represented by a partner.
    let paired = 1 << size.ilog2();
    if me >= paired {
        ranks.exchange(vec![(me - paired, to_bytes(&sum))], &[]);
        return from(me - paired);
    }
    let beyond = (me + paired < size).then_some(me + paired);
    if let Some(beyond) = beyond {
        add(&mut sum, from(beyond));
    }
    let mut step = 1;
    while step < paired {
        let other = me ^ step;
        let came = ranks.exchange(vec![(other, to_bytes(&sum))], &[other]);
        add(&mut sum, from_bytes(&came[0]));
        step *= 2;
    }
    if let Some(beyond) = beyond {
        ranks.exchange(vec![(beyond, to_bytes(&sum))], &[]);
    }
    sum
}

/// Reduces a sum over particles to the root process along a binary tree, in log2(size) rounds.
pub(crate) fn reduce(ranks: &dyn Ranks, sum: &mut dyn DynReduction) {
    let (me, size) = (ranks.rank(), ranks.size());
    let mut step = 1;
    while step < size {
        if me & step > 0 {
            ranks.exchange(vec![(me - step, sum.save_bytes())], &[]);
            return;
        }
        if me + step < size {
            let came = ranks.exchange(Vec::new(), &[me + step]);
            assert!(sum.add_saved(&came[0]), "the sum of the same program");
        }
        step *= 2;
    }
}

/// Collects the messages of all processes in the root process, by rank; returns an empty list
/// elsewhere.
pub(crate) fn gather(ranks: &dyn Ranks, mine: Vec<u8>) -> Vec<Vec<u8>> {
    if ranks.rank() > 0 {
        ranks.exchange(vec![(0, mine)], &[]);
        return Vec::new();
    }
    let others: Vec<usize> = (1..ranks.size()).collect();
    let mut all = vec![mine];
    all.extend(ranks.exchange(Vec::new(), &others));
    all
}

/// Sends the message of the root process to all processes along a binary tree, and returns it in
/// each.
pub fn broadcast(ranks: &dyn Ranks, mine: Vec<u8>) -> Vec<u8> {
    let (me, size) = (ranks.rank(), ranks.size());
    let message = if me == 0 {
        mine
    } else {
        ranks.exchange(Vec::new(), &[(me - 1) / 2]).swap_remove(0)
    };
    let below = [2 * me + 1, 2 * me + 2].into_iter();
    let messages: Vec<_> = below
        .filter(|&to| to < size)
        .map(|to| (to, message.clone()))
        .collect();
    if !messages.is_empty() {
        ranks.exchange(messages, &[]);
    }
    message
}

/// Concatenates several messages, each with its length, into one.
fn pack_messages(messages: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(messages.iter().map(|one| one.len() + 8).sum());
    for message in messages {
        bytes.extend_from_slice(&(message.len() as u64).to_le_bytes());
        bytes.extend_from_slice(message);
    }
    bytes
}

fn unpack(mut bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut messages = Vec::new();
    while let Some((length, rest)) = bytes.split_first_chunk::<8>() {
        let (message, rest) = rest.split_at(u64::from_le_bytes(*length) as usize);
        messages.push(message.to_vec());
        bytes = rest;
    }
    messages
}
