//! Statistics of the latest contacts of an event-driven engine: the particles that take part in
//! most of them, as in inelastic collapse.

use std::collections::BTreeMap;

/// Statistics of the latest contacts of an event-driven engine, which show where its time goes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecentContacts {
    /// Number of latest contacts that were examined.
    pub contacts: usize,
    /// Number of particles that took part in the latest contacts.
    pub involved: usize,
    /// Fewest particles that make up half of all participations in the latest contacts, by index,
    /// the most frequent first.
    pub busiest: Vec<usize>,
    /// Position of the particle with the most contacts among the latest, the first of `busiest`
    /// \[length\].
    pub place: [f64; 3],
}

impl RecentContacts {
    /// Computes the statistics of contacts, each given by the particles that took part in it: two,
    /// or one that touched a wall.
    ///
    /// ```
    /// use stosszahl_model::RecentContacts;
    ///
    /// let contacts = [vec![7, 3], vec![7, 4], vec![7], vec![7, 3], vec![1, 2]];
    /// let recent = RecentContacts::from_contacts(contacts);
    /// // The particle 7 makes up four of nine participations, and 3 two more.
    /// assert_eq!((recent.contacts, recent.involved), (5, 5));
    /// assert_eq!(recent.busiest, [7, 3]);
    /// ```
    pub fn from_contacts<C: IntoIterator<Item = usize>>(
        contacts: impl IntoIterator<Item = C>,
    ) -> Self {
        let (mut number, mut counts) = (0, BTreeMap::<usize, usize>::new());
        for contact in contacts {
            number += 1;
            for particle in contact {
                *counts.entry(particle).or_default() += 1;
            }
        }
        let all: usize = counts.values().sum();
        let mut frequent: Vec<(usize, usize)> = counts.into_iter().collect();
        let involved = frequent.len();
        // Stable: of equals, the first by index.
        frequent.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        let mut sum = 0;
        let busiest = frequent.into_iter().take_while(|&(_, count)| {
            let wanted = 2 * sum < all;
            sum += count;
            wanted
        });
        Self {
            contacts: number,
            involved,
            busiest: busiest.map(|(particle, _)| particle).collect(),
            place: [0.0; 3],
        }
    }
}
