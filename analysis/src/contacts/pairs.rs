//! Search for pairs of particles near contact, by a cell list.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use stosszahl_model::Particles;

/// Calls `call` for each pair between contact and `reach` times the contact distance. It receives
/// the indices, the vector from the second to the first, and the distance over the contact
/// distance.
pub(super) fn each_pair(
    particles: &Particles,
    reach: f64,
    mut call: impl FnMut([usize; 2], Vector3<f64>, f64),
) {
    let largest = particles
        .all
        .iter()
        .map(|one| one.radius)
        .fold(0.0, f64::max);
    let (range, dimension) = (2.0 * reach * largest, particles.dimension);
    let count = |axis: usize| {
        let fit = (particles.lengths[axis] / range) as usize;
        // No more cells than particles, however large the box is.
        let most = particles.all.len();
        if axis < dimension && range > 0.0 {
            fit.clamp(1, most.max(1))
        } else {
            1
        }
    };
    let cells: [usize; 3] = std::array::from_fn(count);
    let wrap =
        |share: f64, count: usize| ((share.rem_euclid(1.0) * count as f64) as usize).min(count - 1);
    let of = |place: &Vector3<f64>| -> [usize; 3] {
        std::array::from_fn(|axis| match particles.lengths[axis] {
            length if length > 0.0 => wrap(place[axis] / length, cells[axis]),
            _ => 0,
        })
    };
    let images = particles.images();
    let number = |at: [usize; 3]| at[0] + cells[0] * (at[1] + cells[1] * at[2]);
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (who, one) in particles.all.iter().enumerate() {
        members
            .entry(number(of(&one.position)))
            .or_default()
            .push(who);
    }
    for (i, one) in particles.all.iter().enumerate() {
        let at = of(&one.position);
        let mut seen = Vec::with_capacity(27);
        for step in 0..27_usize {
            let steps = [step % 3, step / 3 % 3, step / 9];
            let to = std::array::from_fn(|axis| {
                (at[axis] + steps[axis] + cells[axis] - 1) % cells[axis]
            });
            let cell = number(to);
            if seen.contains(&cell) {
                continue;
            }
            seen.push(cell);
            for &j in members.get(&cell).into_iter().flatten().filter(|&&j| j < i) {
                let other = &particles.all[j];
                let line = images.nearest(one.position - other.position);
                let contact = one.radius + other.radius;
                let square = line.norm_squared();
                if square >= contact * contact && square < (reach * contact).powi(2) {
                    call([i, j], line, square.sqrt() / contact);
                }
            }
        }
    }
}
