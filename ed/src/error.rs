//! What the engine refuses.

/// Why the engine could not start or go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// The box is narrower than a disk.
    #[error("a disk of diameter {diameter} meets its own image in a box of {:.6} x {:.6}; both sides must be longer", lengths[0], lengths[1])]
    BoxTooSmall {
        /// Largest diameter.
        diameter: f64,
        /// Box.
        lengths: [f64; 2],
    },
    /// A position or velocity is no finite number, or too large to be squared.
    #[error("disk {disk} has {quantity} {value:?}; allowed are finite numbers up to 1e150")]
    BadNumber {
        /// Index of the disk.
        disk: usize,
        /// `position` or `velocity`.
        quantity: &'static str,
        /// What was found.
        value: [f64; 2],
    },
    /// Not one value for each disk.
    #[error("{found} {quantity} for {disks} disks; allowed are none, or one for each disk")]
    WrongCount {
        /// What there is not one of for each disk.
        quantity: &'static str,
        /// How many were given.
        found: usize,
        /// How many disks there are.
        disks: usize,
    },
    /// More disks than the engine can number.
    #[error("{disks} disks; allowed are up to {}", u32::MAX - 1)]
    TooMany {
        /// How many were given.
        disks: usize,
    },
    /// The time of the start is no finite number.
    #[error("the start is at time {time}; allowed are finite numbers")]
    BadStart {
        /// What was found.
        time: f64,
    },
    /// The time asked for is no number, or so far that flying disks lose their positions.
    #[error(
        "asked to advance to time {until}; allowed are times that disks reach with a position that has digits left, or infinity"
    )]
    BadTime {
        /// What was asked for.
        until: f64,
    },
    /// The disks move but do not meet.
    #[error(
        "no collision while disks crossed {crossings} cells, until time {time}: they may never meet; ask for an earlier time, or for a gas whose disks do not fly past each other for ever"
    )]
    NoCollisions {
        /// When the engine gave up.
        time: f64,
        /// Cell boundaries crossed since the last collision.
        crossings: u64,
    },
    /// Infinitely many collisions in a finite time.
    #[error(
        "inelastic collapse at time {time}: {collisions} collisions without progress of time among {}, the last of disks {} and {} \
         near ({:.6}, {:.6}); a contact time above zero (TC model) lets such a gas go on",
        named(cluster), pair[0], pair[1], place[0], place[1]
    )]
    InelasticCollapse {
        /// When \[time\].
        time: f64,
        /// Collisions since time last advanced.
        collisions: u64,
        /// The last pair.
        pair: [usize; 2],
        /// All that took part in the last collisions, in order.
        cluster: Vec<usize>,
        /// Where.
        place: [f64; 2],
    },
}

/// The disks of a cluster; of a large one, the first.
fn named(cluster: &[usize]) -> String {
    const MOST: usize = 12;
    let names: Vec<String> = cluster.iter().take(MOST).map(usize::to_string).collect();
    let more = if cluster.len() > MOST { ", ..." } else { "" };
    format!("{} disks ({}{more})", cluster.len(), names.join(", "))
}
