//! MPI processes that hold one gas together.

use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use mpi::Tag;
use mpi::point_to_point::{Message, Status};
use mpi::request::{Request, Scope, scope};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Buffer, Communicator as _, Destination as _, Equivalence as _, Source as _};
use serde::{Deserialize, Serialize};
use stosszahl::dsmc::Ranks;

/// Largest message of MPI \[bytes\], which counts them with 31 bits.
const MOST: usize = 1 << 30;
/// Time of a wait without a rest, since messages of a step come within microseconds.
const EAGER: Duration = Duration::from_millis(20);
/// Length of a rest in a longer wait.
const REST: Duration = Duration::from_micros(200);

/// Tag of messages of the gas. Heartbeats have tag 1.
const GAS: Tag = 0;

/// All processes of the job.
pub struct World {
    rank: usize,
    size: usize,
    /// Lock of the thread that calls MPI, never held while it waits for another process.
    calls: Mutex<()>,
    traffic: Mutex<Traffic>,
}

/// Messages of a process, and its time in exchanges.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Traffic {
    /// Number of exchanges.
    pub rounds: u64,
    /// Number of messages sent.
    pub messages: u64,
    /// Size of the messages sent \[bytes\].
    pub bytes: u64,
    /// Size of the messages received \[bytes\].
    pub received: u64,
    /// Time in exchanges \[s\].
    pub seconds: f64,
}

impl World {
    /// Returns all processes of this job.
    pub fn new() -> Self {
        let world = SimpleCommunicator::world();
        Self {
            rank: world.rank() as usize,
            size: world.size() as usize,
            calls: Mutex::default(),
            traffic: Mutex::default(),
        }
    }

    /// Returns the traffic of this process so far.
    pub fn traffic(&self) -> Traffic {
        *self.traffic.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes an MPI call that does not wait, while no other thread makes one.
    pub fn call<T>(&self, call: impl FnOnce(&SimpleCommunicator) -> T) -> T {
        let _alone = self.calls.lock().unwrap_or_else(PoisonError::into_inner);
        call(&SimpleCommunicator::world())
    }

    /// Waits until a message is sent, or has arrived.
    fn finish<'a, D: ?Sized + Buffer, S: Scope<'a>>(&self, mut request: Request<'a, D, S>) {
        let began = Instant::now();
        while let Err(again) = self.call(|_| request.test()) {
            request = again;
            rest(began);
        }
    }

    /// Receives a message that is there.
    fn receive(&self, (message, status): (Message, Status)) -> Vec<u8> {
        let mut part = vec![0; status.count(u8::equivalent_datatype()) as usize];
        scope(|scope| {
            let request =
                self.call(|_| message.immediate_matched_receive_into(scope, &mut part[..]));
            self.finish(request);
        });
        part
    }

    /// Receives parts until all messages from these processes are complete.
    fn complete(&self, coming: &mut [Coming], from: &[usize]) {
        let began = Instant::now();
        while let Some(next) = coming.iter().position(|one| !one.is_whole()) {
            let found = self.call(|world| {
                let process = world.process_at_rank(from[next] as i32);
                process.immediate_matched_probe_with_tag(GAS)
            });
            match found {
                Some(found) => coming[next].add_part(&self.receive(found)),
                None => rest(began),
            }
        }
    }
}

/// Rests in a wait that began at `began`.
fn rest(began: Instant) {
    if began.elapsed() < EAGER {
        thread::yield_now();
    } else {
        thread::sleep(REST);
    }
}

/// Incoming message: its bytes so far, and its length.
#[derive(Default)]
struct Coming {
    bytes: Vec<u8>,
    length: Option<usize>,
}

impl Coming {
    fn is_whole(&self) -> bool {
        self.length == Some(self.bytes.len())
    }

    /// Adds a part; the first begins with the length.
    fn add_part(&mut self, part: &[u8]) {
        let mut part = part;
        if self.length.is_none()
            && let Some((length, rest)) = part.split_first_chunk::<8>()
        {
            self.length = Some(u64::from_le_bytes(*length) as usize);
            part = rest;
        }
        self.bytes.extend_from_slice(part);
    }
}

/// Splits a message into parts.
fn parts(message: &[u8]) -> Vec<Vec<u8>> {
    let mut whole = Vec::with_capacity(message.len() + 8);
    whole.extend_from_slice(&(message.len() as u64).to_le_bytes());
    whole.extend_from_slice(message);
    if whole.len() <= MOST {
        return vec![whole];
    }
    whole.chunks(MOST).map(<[u8]>::to_vec).collect()
}

impl Ranks for World {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn exchange_around(
        &self,
        messages: Vec<(usize, Vec<u8>)>,
        from: &[usize],
        meanwhile: &mut dyn FnMut(),
        then: &mut dyn FnMut(Vec<Vec<u8>>),
    ) {
        let mut began = Instant::now();
        let mut traffic = Traffic {
            rounds: 1,
            messages: messages.len() as u64,
            bytes: messages.iter().map(|(_, one)| one.len() as u64).sum(),
            received: 0,
            seconds: 0.0,
        };
        let parts: Vec<(usize, Vec<u8>)> = (messages.iter())
            .flat_map(|(to, message)| parts(message).into_iter().map(|part| (*to, part)))
            .collect();
        let mut coming: Vec<Coming> = from.iter().map(|_| Coming::default()).collect();
        scope(|scope| {
            let sends: Vec<_> = parts
                .iter()
                .map(|(to, part)| {
                    self.call(|world| {
                        let to = world.process_at_rank(*to as i32);
                        to.immediate_send_with_tag(scope, &part[..], GAS)
                    })
                })
                .collect();
            // The time of other work does not count.
            traffic.seconds += began.elapsed().as_secs_f64();
            meanwhile();
            began = Instant::now();
            self.complete(&mut coming, from);
            traffic.seconds += began.elapsed().as_secs_f64();
            traffic.received = coming.iter().map(|one| one.bytes.len() as u64).sum();
            then(coming.drain(..).map(|one| one.bytes).collect());
            began = Instant::now();
            for send in sends {
                self.finish(send);
            }
            traffic.seconds += began.elapsed().as_secs_f64();
        });
        let mut all = self.traffic.lock().unwrap_or_else(PoisonError::into_inner);
        all.rounds += traffic.rounds;
        all.messages += traffic.messages;
        all.bytes += traffic.bytes;
        all.received += traffic.received;
        all.seconds += traffic.seconds;
    }
}
