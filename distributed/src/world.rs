//! The processes of MPI, as those that hold one gas together.

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

/// Most bytes of one message of MPI, which counts them with 31 bits.
const MOST: usize = 1 << 30;
/// For how long others are waited for without a rest, as they come within microseconds in a step; and the rests after that.
const EAGER: Duration = Duration::from_millis(20);
const REST: Duration = Duration::from_micros(200);

/// The tag of what the gas sends. Beats have tag 1.
const GAS: Tag = 0;

/// All processes.
pub struct World {
    rank: usize,
    size: usize,
    /// Held by the thread that talks to MPI, never while it waits for another process.
    calls: Mutex<()>,
    traffic: Mutex<Traffic>,
}

/// What a process has sent and received, and how long it waited for others.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Traffic {
    /// Exchanges.
    pub rounds: u64,
    /// Messages.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Bytes of the messages that came.
    pub received: u64,
    /// Time in exchanges \[s\].
    pub seconds: f64,
}

impl World {
    /// All processes of this job.
    pub fn new() -> Self {
        let world = SimpleCommunicator::world();
        Self {
            rank: world.rank() as usize,
            size: world.size() as usize,
            calls: Mutex::default(),
            traffic: Mutex::default(),
        }
    }

    /// What this process has sent.
    pub fn traffic(&self) -> Traffic {
        *self.traffic.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes a call of MPI that does not wait, while no other thread makes one.
    pub fn call<T>(&self, call: impl FnOnce(&SimpleCommunicator) -> T) -> T {
        let _alone = self.calls.lock().unwrap_or_else(PoisonError::into_inner);
        call(&SimpleCommunicator::world())
    }

    /// Waits until a message is sent, or has come.
    fn finish<'a, D: ?Sized + Buffer, S: Scope<'a>>(&self, mut request: Request<'a, D, S>) {
        let began = Instant::now();
        while let Err(again) = self.call(|_| request.test()) {
            request = again;
            rest(began);
        }
    }

    /// The content of a message that is there.
    fn receive(&self, (message, status): (Message, Status)) -> Vec<u8> {
        let mut part = vec![0; status.count(u8::equivalent_datatype()) as usize];
        scope(|scope| {
            let request =
                self.call(|_| message.immediate_matched_receive_into(scope, &mut part[..]));
            self.finish(request);
        });
        part
    }

    /// Receives parts until all messages from these processes are whole.
    fn complete(&self, coming: &mut [Coming], from: &[usize]) {
        let began = Instant::now();
        while let Some(next) = coming.iter().position(|one| !one.is_whole()) {
            let found = self.call(|world| {
                let process = world.process_at_rank(from[next] as i32);
                process.immediate_matched_probe_with_tag(GAS)
            });
            match found {
                Some(found) => coming[next].take(&self.receive(found)),
                None => rest(began),
            }
        }
    }
}

/// A rest in a wait that began then.
fn rest(began: Instant) {
    if began.elapsed() < EAGER {
        thread::yield_now();
    } else {
        thread::sleep(REST);
    }
}

/// A message on its way: its bytes so far, and how many there are to be.
#[derive(Default)]
struct Coming {
    bytes: Vec<u8>,
    length: Option<usize>,
}

impl Coming {
    fn is_whole(&self) -> bool {
        self.length == Some(self.bytes.len())
    }

    /// Takes a part; the first begins with the length.
    fn take(&mut self, part: &[u8]) {
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

/// The parts of a message.
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
            // The time of other work is none of the exchange.
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
