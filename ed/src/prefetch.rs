//! Prefetch: records, partners and cells of disks whose events come up in the next buckets of the
//! calendar are requested from memory before their turn.

use std::hint::select_unpredictable;

use stosszahl_model::{Field, Plane, memory};

use crate::cells::{CellCoordinates, line_of};
use crate::disk::DiskSystem;
use crate::prefetch_plan::{AHEAD, NAMES, PrefetchPlan};
use crate::record::DiskRecord;

impl<F: Field<Plane>> DiskSystem<F> {
    /// Prefetches data for the disks of a bucket of the calendar, `ahead` buckets before its turn;
    /// the bucket ends at the engine time `end`. Four buckets ahead it requests their records, then
    /// partners and cells around, then the first disks of these cells.
    #[inline(always)]
    pub(crate) fn prefetch(&self, disks: &[u32], ahead: usize, end: f64, plan: &mut PrefetchPlan) {
        const { assert!(AHEAD == 4) };
        match ahead {
            4 => {
                for &disk in disks {
                    memory::prefetch(&self.all, disk as usize);
                }
            }
            3 => {
                self.plan(disks, end, plan);
                for &disk in plan.contacts() {
                    let disk = &self.all[disk as usize];
                    memory::prefetch(&self.all, line_of(disk.partner));
                    self.prefetch_cells(disk.home);
                }
                for places in plan.followed() {
                    for &place in places {
                        self.cells.prefetch(place as usize);
                    }
                }
            }
            2 => {
                for &disk in plan.contacts() {
                    self.prefetch_cells(self.partner(disk).home);
                }
                for places in plan.followed() {
                    for &place in places {
                        self.prefetch_first(place);
                    }
                }
            }
            _ => {
                for &disk in plan.contacts() {
                    self.prefetch_neighbours(self.home(disk));
                    self.prefetch_neighbours(self.partner(disk).home);
                }
            }
        }
    }

    /// Sorts the disks of a bucket into those that touch another disk before the engine time `end`
    /// and those that cross into another cell, and finds the cells whose lists the latter will
    /// read.
    #[inline(always)]
    fn plan(&self, disks: &[u32], end: f64, plan: &mut PrefetchPlan) {
        let mut crossings = [0; NAMES];
        (plan.touching, plan.leaving) = (0, 0);
        for &disk in disks {
            let touches = self.all[disk as usize].contact < end;
            plan.contacts[plan.touching % NAMES] = disk;
            crossings[plan.leaving % NAMES] = disk;
            plan.touching += usize::from(touches);
            plan.leaving += usize::from(!touches);
        }
        for (&disk, followed) in crossings.iter().zip(&mut plan.followed).take(plan.leaving) {
            let disk = &self.all[disk as usize];
            let (axis, forward) = self.way_out(disk);
            let [before, beside, after] = self.cells.across(disk.home, axis, 2, forward);
            *followed = [
                before,
                beside,
                after,
                self.cells.place(disk.home, 1, 1) as u32,
            ];
        }
    }

    /// Returns the record of a disk's predicted partner; that of the disk itself if it has none, or
    /// one that has collided since.
    #[inline(always)]
    fn partner(&self, disk: u32) -> &DiskRecord {
        let own = &self.all[disk as usize];
        match self.all.get(own.partner as usize) {
            Some(partner) => select_unpredictable(partner.count == own.partner_count, partner, own),
            None => own,
        }
    }

    /// Returns the boundary of its cell that a disk in straight flight reaches first: the axis, and
    /// true if forward.
    #[inline(always)]
    fn way_out(&self, disk: &DiskRecord) -> (usize, bool) {
        let width = self.cells.width();
        let forward = [0, 1].map(|axis| disk.velocity[axis] > 0.0);
        let distance = [0, 1].map(|axis| {
            let boundary = select_unpredictable(forward[axis], width[axis], 0.0);
            (boundary - disk.position[axis]).abs()
        });
        let speed = disk.velocity.abs();
        let second = distance[0] * speed[1] > distance[1] * speed[0];
        let forward = select_unpredictable(second, forward[1], forward[0]);
        (usize::from(second), forward)
    }

    /// Prefetches the list heads of the cells around the cell `home`.
    #[inline(always)]
    fn prefetch_cells(&self, home: CellCoordinates) {
        let (x, y) = self.cells.cells_around(home);
        for row in y {
            self.cells.prefetch((x[0] + row) as usize);
            self.cells.prefetch((x[2] + row) as usize);
        }
    }

    /// Prefetches the record of the first disk in each cell around the cell `home`.
    #[inline(always)]
    fn prefetch_neighbours(&self, home: CellCoordinates) {
        let (x, y) = self.cells.cells_around(home);
        for row in y {
            for column in x {
                self.prefetch_first(column + row);
            }
        }
    }

    /// Prefetches the record of the first disk in the cell at a memory index.
    #[inline(always)]
    fn prefetch_first(&self, place: u32) {
        memory::prefetch(&self.all, line_of(self.cells.first(place as usize)));
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Vector2, vector};
    use stosszahl_model::walls::Face;
    use stosszahl_model::{Free, Wall, Walls};

    use super::*;
    use crate::arrange::GridOptions;
    use crate::cells::NONE;
    use crate::disk::tests::lattice;
    use crate::motion::FlightMotion;
    use crate::{Buckets, Sorted};

    /// Creates disks all over a box, with speeds of no pattern.
    fn scattered(lengths: [f64; 2], periodic: [bool; 2]) -> DiskSystem<Free> {
        let face = |around: bool| {
            if around {
                Face::Periodic
            } else {
                Face::Wall(Wall::specular())
            }
        };
        let walls = Walls::<Plane>::new(&periodic.map(|around| [face(around); 2])).expect("walls");
        let domain = walls.domain(Vector2::from(lengths)).expect("a box");
        let body = |index: usize| {
            let (number, angle) = (index as f64 + 0.5, (index * index) as f64);
            let place = vector![0.618 * number % 1.0, 0.414 * number % 1.0];
            let velocity = vector![angle.sin(), angle.cos()];
            (Vector2::from(lengths).component_mul(&place), velocity, 0.5)
        };
        let options = GridOptions::default();
        DiskSystem::new(
            &domain,
            0.5,
            200,
            &body,
            FlightMotion::new(&Free, 1.0),
            options,
        )
        .0
    }

    /// Boxes of one and two columns, and with walls, too.
    #[test]
    fn a_plan_names_the_cells_that_a_crossing_follows() {
        let mut crossings = 0;
        for lengths in [[30.0, 20.0], [1.5, 40.0], [40.0, 2.5], [2.5, 2.5]] {
            for periodic in [[true, true], [true, false], [false, false]] {
                let mut disks = scattered(lengths, periodic);
                for who in 0..disks.all.len() as u32 {
                    let mut plan = PrefetchPlan::NOTHING;
                    for ahead in (1..=AHEAD).rev() {
                        disks.prefetch(&[who], ahead, f64::NEG_INFINITY, &mut plan);
                    }
                    let disk = &disks.all[who as usize];
                    let (time, axis) = disks.motion.exit(disk, disks.cells.width());
                    let left = disks.cells.place(disk.home, 1, 1);
                    let (forward, around) = disks.cross(who, axis, time);
                    if around && !periodic[axis] {
                        continue;
                    }
                    let (home, side) = (disks.home(who), 2 * usize::from(forward));
                    let place = |step| match axis {
                        0 => disks.cells.place(home, side, step) as u32,
                        _ => disks.cells.place(home, step, side) as u32,
                    };
                    assert_eq!(
                        plan.followed(),
                        [[place(0), place(1), place(2), left as u32]]
                    );
                    crossings += 1;
                }
            }
        }
        assert!(crossings > 1500, "{crossings}");
    }

    #[test]
    fn a_plan_tells_contacts_from_crossings() {
        let disks = lattice::<Buckets>(8).disks;
        let all: Vec<u32> = (0..NAMES as u32).collect();
        let mut plan = PrefetchPlan::NOTHING;
        disks.prefetch(&all, 3, 1.0, &mut plan);
        let (contacts, crossings): (Vec<u32>, Vec<u32>) =
            (all.iter()).partition(|&&disk| disks.all[disk as usize].contact < 1.0);
        assert!(!contacts.is_empty() && !crossings.is_empty());
        assert_eq!(plan.contacts(), contacts);
        let left = crossings.iter().map(|&disk| disks.home(disk));
        let left: Vec<u32> = left
            .map(|home| disks.cells.place(home, 1, 1) as u32)
            .collect();
        let own: Vec<u32> = plan.followed().iter().map(|places| places[3]).collect();
        assert_eq!(own, left);
    }

    #[test]
    fn a_partner_counts_until_it_collides() {
        let mut disks = lattice::<Buckets>(8).disks;
        let is = |disks: &DiskSystem<Free>, who: u32| {
            std::ptr::eq(disks.partner(0), &raw const disks.all[who as usize])
        };
        (disks.all[0].partner, disks.all[0].partner_count) = (5, disks.all[5].count);
        assert!(is(&disks, 5));
        disks.meet(5, 0.0);
        assert!(is(&disks, 0));
        disks.all[0].partner = NONE;
        assert!(is(&disks, 0));
        disks.all[0].partner = disks.all.len() as u32;
        assert!(is(&disks, 0), "a wall");
    }

    /// Prefetching changes nothing. There are more disks than fit in the cache, so that every index
    /// that is used is in range.
    #[test]
    fn looking_ahead_changes_nothing() {
        let mut ahead = lattice::<Buckets>(142);
        let mut plain = lattice::<Sorted>(142);
        assert!(crate::EventTimes::foresighted(&ahead.disks));
        ahead.advance(f64::INFINITY, 5000, &mut ()).expect("time");
        plain.advance(f64::INFINITY, 5000, &mut ()).expect("time");
        assert_eq!(ahead.tally().pushes, plain.tally().pushes);
        assert_eq!(ahead.state().bodies, plain.state().bodies);
    }
}
