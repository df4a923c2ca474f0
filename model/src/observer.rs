//! Observers: measurements that receive the collisions of a running engine, in batches.
//!
//! An observer is called through a virtual table, once for some hundred collisions, so that a new
//! measurement instantiates no engine anew. A type parameter for it lost: each measurement made
//! every engine compile once more, for a gain that cannot be measured. States at chosen times come
//! from the engine instead.

use crate::collision::Collision;

/// Receiver of the collisions of an engine.
///
/// ```
/// use stosszahl_model::{Collision, Observer};
///
/// /// Counts collisions that graze.
/// struct Grazing(u64);
///
/// impl Observer for Grazing {
///     fn on_collisions(&mut self, batch: &[Collision]) {
///         self.0 += batch.iter().filter(|one| one.impact_square() > 0.81).count() as u64;
///     }
/// }
/// ```
pub trait Observer {
    /// Receives collisions in order of time. At the end of [`crate::Simulation::advance`] all
    /// collisions of that call have been received.
    fn on_collisions(&mut self, batch: &[Collision]);

    /// Returns true if the observer needs collisions; otherwise engines record none. Read at the
    /// beginning of each advance.
    fn is_active(&self) -> bool {
        true
    }
}

/// Observer that needs no collisions.
impl Observer for () {
    fn on_collisions(&mut self, _batch: &[Collision]) {}

    fn is_active(&self) -> bool {
        false
    }
}

impl<A: Observer + ?Sized> Observer for &mut A {
    fn on_collisions(&mut self, batch: &[Collision]) {
        (**self).on_collisions(batch);
    }

    fn is_active(&self) -> bool {
        (**self).is_active()
    }
}

impl<T: Observer + ?Sized> Observer for Box<T> {
    fn on_collisions(&mut self, batch: &[Collision]) {
        (**self).on_collisions(batch);
    }

    fn is_active(&self) -> bool {
        (**self).is_active()
    }
}

/// Pair of observers that receive the same collisions.
impl<A: Observer, B: Observer> Observer for (A, B) {
    fn on_collisions(&mut self, batch: &[Collision]) {
        self.0.on_collisions(batch);
        self.1.on_collisions(batch);
    }

    fn is_active(&self) -> bool {
        self.0.is_active() || self.1.is_active()
    }
}

impl<A: Observer> Observer for [A] {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for one in self.iter_mut().filter(|one| Observer::is_active(*one)) {
            one.on_collisions(batch);
        }
    }

    fn is_active(&self) -> bool {
        self.iter().any(Observer::is_active)
    }
}

/// Observer made of a function that is called for each collision.
pub struct EachCollision<F>(pub F);

impl<F: FnMut(&Collision)> Observer for EachCollision<F> {
    fn on_collisions(&mut self, batch: &[Collision]) {
        batch.iter().for_each(&mut self.0);
    }
}

/// Number of collisions in a batch for the observer: few enough to stay in the first two caches.
const BATCH: usize = 256;

/// Buffer in which engines record collisions, and which passes them to the observer in batches.
pub struct Recorder<'a> {
    observer: &'a mut dyn Observer,
    looks: bool,
    batch: Vec<Collision>,
}

impl<'a> Recorder<'a> {
    /// Creates a recorder for an observer; it records nothing if the observer needs no collisions.
    pub fn new(observer: &'a mut dyn Observer) -> Self {
        let looks = observer.is_active();
        Self {
            observer,
            looks,
            batch: Vec::with_capacity(if looks { BATCH } else { 0 }),
        }
    }

    /// Returns true if the observer of this recorder needs collisions.
    #[inline(always)]
    pub fn looks(&self) -> bool {
        self.looks
    }

    /// Records a collision for the observer; it is computed only if the observer needs it.
    #[inline(always)]
    pub fn record(&mut self, collision: impl FnOnce() -> Collision) {
        if self.looks {
            self.push(collision());
        }
    }

    #[inline(never)]
    fn push(&mut self, collision: Collision) {
        self.batch.push(collision);
        if self.batch.len() == BATCH {
            self.flush();
        }
    }

    /// Passes a batch of collisions that an engine has stored itself to the observer, after those
    /// recorded before.
    pub fn pass(&mut self, batch: &[Collision]) {
        if self.looks && !batch.is_empty() {
            self.flush();
            self.observer.on_collisions(batch);
        }
    }

    /// Passes the collisions still in the buffer to the observer; engines call it at the end of an
    /// advance.
    pub fn flush(&mut self) {
        if !self.batch.is_empty() {
            self.observer.on_collisions(&self.batch);
            self.batch.clear();
        }
    }
}

impl Drop for Recorder<'_> {
    fn drop(&mut self) {
        self.flush();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn collision(time: f64) -> Collision {
        Collision {
            time,
            ..Collision::at_contact(Vector3::x(), -Vector3::x(), 0.5, 1.0)
        }
    }

    #[test]
    fn all_collisions_arrive_in_order_and_once() {
        struct Log<'a>(&'a mut Vec<f64>, &'a mut usize);
        impl Observer for Log<'_> {
            fn on_collisions(&mut self, batch: &[Collision]) {
                *self.1 += 1;
                self.0.extend(batch.iter().map(|one| one.time));
            }
        }
        let (mut times, mut batches) = (Vec::new(), 0);
        let mut log = Log(&mut times, &mut batches);
        let mut recorder = Recorder::new(&mut log);
        for number in 0..1000 {
            recorder.record(|| collision(f64::from(number)));
        }
        recorder.pass(&[collision(1000.0)]);
        drop(recorder);
        let expected: Vec<f64> = (0..=1000).map(f64::from).collect();
        assert_eq!(times, expected);
        assert_eq!(batches, 1000_usize.div_ceil(BATCH) + 1);
    }

    #[test]
    fn who_does_not_look_costs_nothing() {
        let mut silent = ();
        let mut recorder = Recorder::new(&mut silent);
        recorder.record(|| panic!("not asked for"));
        assert_eq!(recorder.batch.capacity(), 0);
        assert!(!((), ()).is_active());
    }
}
