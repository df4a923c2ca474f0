//! Layout of the particles for the selection of pairs by alias tables: classes of nearly equal
//! radius, and in these groups of nearly equal speed with free slots.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Vector, memory};

use super::gas::{COLDEST, GasParticle, HomogeneousGas, SmoothPhysics, size_key};
use super::selection::ProposalValidity;

/// Number of low bits of the squared speed that do not affect its group: there are eight groups per
/// factor two, so the speed bound of a group is on average 2 % above the speeds.
const SPEED_SHIFT: u32 = 52 - 3;
/// Largest number of groups of speed in a size class; the slowest group also holds all slower
/// particles.
const WINDOW: u32 = 160;
/// Number of groups laid out above that of the fastest particle, for particles that get faster: a
/// factor two in speed.
const HEADROOM: u32 = 16;

/// Class of particles of nearly equal radius, with its slots and its weights as second partners.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct SizeClass {
    /// Upper bound of the radii in the class \[length\].
    pub radius: f64,
    /// Sum of the collision kernel of the class's radius with all slots for second partners.
    pub partners: f64,
    /// Cumulative fractions of the radius powers 0, and 0 and 1, in the sum `partners`, from which
    /// the power for a second partner is drawn.
    pub cuts: [f64; 2],
    /// Number of the size class, a logarithmic scale of radii, see [`size_key`].
    pub key: u32,
    /// Index of the first particle of the class in the list sorted at the last rebuild.
    pub start: u32,
    /// Number of particles in the class at the last rebuild.
    pub count: u32,
    /// First slot of the class in [`Layout::joined`], for particles added since the last rebuild.
    pub join_first: u32,
    /// Number of slots of the class for particles added after the last rebuild.
    pub join_capacity: u32,
    /// Number of particles added to the class since the last rebuild.
    pub joined: u32,
    /// Index after the last group of speed of the class; groups are in rising order of speed.
    pub groups_end: u32,
    /// Index of the last group of speed added to the class since the last rebuild.
    pub extra: u32,
    /// True if all particles of the class have exactly the same radius.
    pub exact: bool,
}

impl SizeClass {
    /// Returns the number of slots of the class for second partners, free ones included.
    #[inline]
    pub fn slots(&self) -> u32 {
        self.count + self.join_capacity
    }
}

/// Group of slots with one speed bound, for particles of one size class.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Group {
    /// Upper bound of the speeds in the group \[length/time\].
    pub bound: f64,
    pub square: f64,
    pub first: u32,
    pub capacity: u32,
    pub length: u32,
    pub class: u32,
}

impl Group {
    /// Stores the index of a particle in the next free slot of the group.
    fn add_index(&mut self, order: &mut [u32], index: u32) {
        order[(self.first + self.length) as usize] = index;
        self.length += 1;
    }
}

/// Layout of the slots of a gas: size classes, and their groups of speed.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Layout {
    pub classes: Vec<SizeClass>,
    pub groups: Vec<Group>,
    /// Number of groups of speed at the last rebuild, without those added since.
    regular: usize,
    /// Particle index in each slot of the groups of speed.
    pub order: Vec<u32>,
    /// Particle index in each slot for particles added to a size class since the last rebuild.
    pub joined: Vec<u32>,
    /// Largest key of a squared speed, its leading bits, at the last rebuild.
    top: u64,
    /// Number of particles added since the last rebuild, for each size class from `first_key` on.
    joins: Vec<u32>,
    first_key: u32,
    /// True if particles merge or break in this gas.
    sizes_change: bool,
    /// Number of free slots laid out per slot expected to be needed until the next rebuild.
    generosity: f64,
    /// True if a particle found no free slot in its size class since the last rebuild.
    refused: bool,
    /// Index of the group of speed for each size class and speed key, or of the next faster group.
    /// During a rebuild: numbers of particles.
    bins: Vec<u32>,
    /// Key of squared speed, its leading bits, of the slowest group.
    base: u64,
}

#[inline]
fn speed_key(square: f64) -> u64 {
    square.to_bits() >> SPEED_SHIFT
}

/// Returns the next floating-point number below a squared speed; zero for zero.
#[inline]
fn next_below(square: f64) -> f64 {
    f64::from_bits(square.to_bits().saturating_sub(1))
}

/// Returns the squared speed at the upper edge of the group with a speed key \[length^2/time^2\].
fn upper_edge(key: u64) -> f64 {
    f64::from_bits((key + 1) << SPEED_SHIFT)
}

impl Layout {
    pub fn memory_bytes(&self) -> usize {
        self.classes.capacity() * size_of::<SizeClass>()
            + self.groups.capacity() * size_of::<Group>()
            + (self.order.capacity() + self.joined.capacity() + self.bins.capacity())
                * size_of::<u32>()
    }

    /// Moves a particle that has become faster than its group allows to a free slot of a faster
    /// group in its size class; returns the effect on the proposals.
    pub fn find_slot<P: SmoothPhysics>(
        &mut self,
        particle: &mut GasParticle<P>,
        index: u32,
        class: u32,
        square: f64,
    ) -> ProposalValidity {
        let bin = bin(next_below(square), self.base);
        let first = self.bins[class as usize * WINDOW as usize + bin] as usize;
        let end = self.classes[class as usize].groups_end as usize;
        debug_assert!(
            first.checked_sub(1).is_none_or(|before| {
                let group = &self.groups[before];
                group.class < class || group.square < square
            }),
            "the group before is too slow"
        );
        for (number, group) in self.groups[..end].iter_mut().enumerate().skip(first) {
            // The last may be too slow: a particle may be faster than the fastest group.
            if group.length < group.capacity && group.square >= square {
                group.add_index(&mut self.order, index);
                particle.mark = number as u32;
                return ProposalValidity::Kept;
            }
        }
        self.open(particle, index, class, square)
    }

    /// Adds a group of speed for a particle of a size class none of whose faster groups has a free
    /// slot; returns the effect on the proposals.
    fn open<P: SmoothPhysics>(
        &mut self,
        particle: &mut GasParticle<P>,
        index: u32,
        class: u32,
        square: f64,
    ) -> ProposalValidity {
        let own = &mut self.classes[class as usize];
        if let Some(group) = self.groups.get_mut(own.extra as usize)
            && group.square >= square
            && group.length < group.capacity
        {
            group.add_index(&mut self.order, index);
            particle.mark = own.extra;
            return ProposalValidity::Kept;
        }
        if self.groups.len() > 2 * self.regular + 64 {
            return ProposalValidity::Outdated;
        }
        own.extra = self.groups.len() as u32;
        let capacity = 1 + own.slots() / 256;
        let first = self.order.len() as u32;
        self.groups.push(Group {
            bound: (1.5 * square).sqrt(),
            square: 1.5 * square,
            first,
            capacity,
            length: 1,
            class,
        });
        self.order.resize((first + capacity) as usize, 0);
        self.order[first as usize] = index;
        particle.mark = own.extra;
        ProposalValidity::Changed
    }

    /// Adds a new particle to the size class of its radius, in a free slot; returns the effect on
    /// the proposals.
    pub fn join<P: SmoothPhysics>(
        &mut self,
        particle: &mut GasParticle<P>,
        index: u32,
        radius: f64,
    ) -> ProposalValidity {
        self.sizes_change = true;
        let key = size_key(radius);
        let number = key.wrapping_sub(self.first_key) as usize;
        let Some(joins) = self.joins.get_mut(number) else {
            return ProposalValidity::Outdated;
        };
        *joins += 1;
        let number = self.classes.partition_point(|class| class.key < key);
        let Some(class) = self
            .classes
            .get_mut(number)
            .filter(|class| class.key == key)
        else {
            return ProposalValidity::Outdated;
        };
        if class.joined >= class.join_capacity || radius > class.radius {
            self.refused = true;
            return ProposalValidity::Outdated;
        }
        self.joined[(class.join_first + class.joined) as usize] = index;
        class.joined += 1;
        self.find_slot(particle, index, number as u32, particle.velocity.square())
    }
}

/// Rebuilds the layout: sorts all particles into size classes, groups of speed and slots.
pub(crate) fn arrange<P: SmoothPhysics>(layout: &mut Layout, gas: &mut HomogeneousGas<P>) {
    if layout.classes.is_empty() || layout.sizes_change {
        gas.sort();
        classify(layout, gas);
    }
    layout.generosity = if layout.refused {
        (1.5 * layout.generosity).min(16.0)
    } else {
        (0.9 * layout.generosity).max(1.0)
    };
    layout.refused = false;
    // The fastest particle of the last time gives the bounds of the groups; if that was far off,
    // once more.
    let mut fastest = 0.0;
    for _ in 0..2 {
        layout.base = (layout.top + u64::from(HEADROOM) + 1).saturating_sub(u64::from(WINDOW));
        fastest = count_by_speed(layout, gas);
        let found = speed_key(fastest);
        let near = found.abs_diff(layout.top) < u64::from(HEADROOM);
        layout.top = found;
        if near {
            break;
        }
    }
    open_groups(layout, fastest);
    fill_slots(layout, gas);
}

/// Creates the size classes of a gas sorted by radius; where particles merge or break, also classes
/// that may be needed next.
fn classify<P: SmoothPhysics>(layout: &mut Layout, gas: &HomogeneousGas<P>) {
    let old_first = layout.first_key;
    let old = std::mem::take(&mut layout.joins);
    layout.classes.clear();
    let radius = |index: usize| gas.radius(&gas.particles[index]);
    let total = gas.particles.len();
    let mut start = 0;
    while start < total {
        let key = size_key(radius(start));
        let run = gas.particles[start..]
            .partition_point(|particle| size_key(gas.radius(particle)) == key);
        if layout.sizes_change
            && let Some(next) = layout.classes.last().map(|class: &SizeClass| class.key + 1)
        {
            let empty = (next..key).map(|key| SizeClass::empty(key, start));
            layout.classes.extend(empty);
        }
        let mut class = SizeClass::empty(key, start);
        class.count = run as u32;
        let radii = || (start..start + run).map(radius);
        let largest = radii().fold(0.0, f64::max);
        class.exact = radii().all(|radius| radius == largest);
        if !layout.sizes_change || class.exact {
            class.radius = largest;
        }
        layout.classes.push(class);
        start += run;
    }
    let (Some(first), Some(last)) = (
        layout.classes.first().map(|class| class.key),
        layout.classes.last().map(|class| class.key),
    ) else {
        return;
    };
    layout.first_key = first;
    if layout.sizes_change {
        // Two equal clusters become one of 2^(1/D) times the radius, at most 7 classes above.
        let above = (last + 1..=last + 8).map(|key| SizeClass::empty(key, total));
        layout.classes.extend(above);
        layout.joins.resize((last + 9 - first) as usize, 0);
        for class in &mut layout.classes {
            let before = (class.key.wrapping_sub(old_first)) as usize;
            let joined = f64::from(old.get(before).copied().unwrap_or(0));
            class.join_capacity =
                2 + class.count / 16 + (layout.generosity * (1.5 * joined + 1.0)) as u32;
            // A particle that joins may be larger than those that are there.
            class.exact = false;
            class.radius = f64::from_bits((u64::from(class.key) + 1) << 48);
        }
    }
}

impl SizeClass {
    fn empty(key: u32, start: usize) -> Self {
        Self {
            radius: f64::from_bits((u64::from(key) + 1) << 48),
            partners: 0.0,
            cuts: [0.0; 2],
            key,
            start: start as u32,
            count: 0,
            join_first: 0,
            join_capacity: 0,
            joined: 0,
            groups_end: 0,
            extra: u32::MAX,
            exact: false,
        }
    }
}

/// Returns the index of the group of a squared speed within a size class; `base` is the speed key
/// of the slowest group.
#[inline]
fn bin(square: f64, base: u64) -> usize {
    speed_key(square)
        .saturating_sub(base)
        .min(u64::from(WINDOW) - 1) as usize
}

/// Counts the particles of each size class by speed; returns the largest squared speed.
fn count_by_speed<P: SmoothPhysics>(layout: &mut Layout, gas: &HomogeneousGas<P>) -> f64 {
    layout.bins.clear();
    layout
        .bins
        .resize(layout.classes.len() * WINDOW as usize, 0);
    let mut fastest = 0.0_f64;
    for (class, counts) in layout
        .classes
        .iter()
        .zip(layout.bins.chunks_exact_mut(WINDOW as usize))
    {
        let range = class.start as usize..(class.start + class.count) as usize;
        for particle in &gas.particles[range] {
            let square = particle.velocity.square();
            fastest = fastest.max(square);
            counts[bin(square, layout.base)] += 1;
        }
    }
    fastest
}

/// Creates the groups of speed of all size classes, with slots for the particles counted and free
/// slots.
fn open_groups(layout: &mut Layout, fastest: f64) {
    layout.groups.clear();
    let (mut slot, mut join) = (0_u32, 0_u32);
    let mut top = 0;
    for (number, class) in layout.classes.iter_mut().enumerate() {
        let counts = &mut layout.bins[number * WINDOW as usize..][..WINDOW as usize];
        // An empty class expects the speeds of the one before it.
        top = counts.iter().rposition(|&count| count > 0).unwrap_or(top);
        let spare = 1 + class.slots() / 512;
        for (bin, count) in counts.iter_mut().enumerate() {
            let within = if *count > 2 { *count / 6 + 1 } else { 0 };
            let above = match bin.checked_sub(top) {
                Some(2 | 6 | 12) => spare,
                _ => 0,
            };
            let joining = if class.join_capacity > 0
                && bin <= top
                && (top - bin).is_multiple_of(4)
                && top - bin <= 24
            {
                class.join_capacity / 3 + 1
            } else {
                0
            };
            let free = within + above + joining;
            let taken = *count;
            *count = layout.groups.len() as u32;
            if taken + free == 0 {
                continue;
            }
            let square = upper_edge(layout.base + bin as u64);
            let last = bin + 1 == WINDOW as usize;
            let square = match () {
                // A gas at rest has no rate at all.
                () if fastest < COLDEST => 0.0,
                () if last => square.max(fastest),
                () => square,
            };
            layout.groups.push(Group {
                bound: square.sqrt(),
                square,
                first: slot,
                capacity: taken + free,
                length: 0,
                class: number as u32,
            });
            slot += taken + free;
        }
        class.groups_end = layout.groups.len() as u32;
        class.join_first = join;
        class.joined = 0;
        class.extra = u32::MAX;
        join += class.join_capacity;
    }
    layout.regular = layout.groups.len();
    layout.joined.clear();
    layout.joined.resize(join as usize, 0);
    if layout.order.capacity() < slot as usize {
        layout.order = memory::reserved(slot as usize + slot as usize / 16);
    }
    layout.order.resize(slot as usize, 0);
}

/// Stores the index of every particle in a slot of its group of speed.
fn fill_slots<P: SmoothPhysics>(layout: &mut Layout, gas: &mut HomogeneousGas<P>) {
    for (number, class) in layout.classes.iter().enumerate() {
        let groups = &layout.bins[number * WINDOW as usize..][..WINDOW as usize];
        for index in class.start..class.start + class.count {
            let particle = &mut gas.particles[index as usize];
            let mark = groups[bin(particle.velocity.square(), layout.base)];
            let group = &mut layout.groups[mark as usize];
            layout.order[(group.first + group.length) as usize] = index;
            group.length += 1;
            particle.mark = mark;
        }
    }
}
