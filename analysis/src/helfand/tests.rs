use super::*;
use nalgebra::vector;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Velocities of all disks from a time on, and the stress and energy that the collision at its
/// beginning carried.
struct Span {
    from: f64,
    velocities: Vec<Vector2<f64>>,
    given: [f64; FLUXES],
}

/// Change of the part and the flux of given numbers over a lag.
type Change<'a> = dyn Fn(usize, usize) -> f64 + 'a;

const MASS: f64 = 1.7;
const AREA: f64 = 55.0;
const BIN: f64 = 0.3;
const LAGS: usize = 4;
const END: f64 = 6.05;

/// Disks of mass [`MASS`] that collide at random times along random lines: disks do not move, but
/// the sums are the same.
fn history(seed: u64) -> (Vec<Span>, Vec<Collision>) {
    let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut number = || stream.random_range(-1.0..1.0_f64);
    let velocities = (0..7).map(|_| vector![number() + 0.4, number()]).collect();
    let mut spans = vec![Span {
        from: 0.0,
        velocities,
        given: [0.0; FLUXES],
    }];
    let (mut collisions, mut time) = (Vec::new(), 0.0);
    while time < END - 0.1 {
        time += 0.05 * (1.0 + number());
        let last = &spans[spans.len() - 1];
        let mut velocities = last.velocities.clone();
        let pair = [
            (number().abs() * 3.0) as usize,
            3 + (number().abs() * 4.0) as usize,
        ];
        let relative = velocities[pair[0]] - velocities[pair[1]];
        let mut line = vector![number(), number()];
        if relative.dot(&line) > 0.0 {
            line = -line;
        }
        collisions.push(Collision {
            time,
            pair: pair.map(|index| index as u32),
            ..Collision::at_contact(
                vector![relative.x, relative.y, 0.0],
                vector![line.x, line.y, 0.0],
                0.5 * MASS,
                1.0,
            )
        });
        let unit = line.normalize();
        let change = -unit * relative.dot(&unit);
        let mean: Vector2<f64> = velocities.iter().sum::<Vector2<f64>>() / 7.0;
        let energy = |v: Vector2<f64>| 0.5 * MASS * (v - mean).norm_squared();
        let before = energy(velocities[pair[0]]);
        velocities[pair[0]] += change;
        velocities[pair[1]] -= change;
        let gained = energy(velocities[pair[0]]) - before;
        let force = change * MASS;
        let given = [
            force.x * line.y,
            0.5 * (force.x * line.x - force.y * line.y),
            0.5 * (force.x * line.x + force.y * line.y),
            gained * line.x,
            gained * line.y,
        ];
        spans.push(Span {
            from: time,
            velocities,
            given,
        });
    }
    (spans, collisions)
}

/// Kinetic and collisional integrals of all fluxes, and displacements of all disks relative to the
/// mean, up to a time.
fn plain(spans: &[Span], until: f64) -> (Integrals, Vec<Vector2<f64>>) {
    let (mut integrals, mut places) = (Integrals::default(), vec![Vector2::zeros(); 7]);
    for (number, span) in spans
        .iter()
        .enumerate()
        .take_while(|(_, span)| span.from <= until)
    {
        let end = spans
            .get(number + 1)
            .map_or(until, |next| next.from.min(until));
        let mean: Vector2<f64> = span.velocities.iter().sum::<Vector2<f64>>() / 7.0;
        for (place, velocity) in places.iter_mut().zip(&span.velocities) {
            let v = velocity - mean;
            *place += v * (end - span.from);
            let carried = [
                MASS * v.x * v.y,
                0.5 * MASS * (v.x * v.x - v.y * v.y),
                0.5 * MASS * (v.x * v.x + v.y * v.y),
                0.5 * MASS * v.norm_squared() * v.x,
                0.5 * MASS * v.norm_squared() * v.y,
            ];
            for (sum, one) in integrals[0].iter_mut().zip(carried) {
                *sum += one * (end - span.from);
            }
        }
        for (sum, one) in integrals[1].iter_mut().zip(span.given) {
            *sum += one;
        }
    }
    (integrals, places)
}

/// All sums against integrals from the beginning to each end of a bin; halfway the record is
/// written and read back. Rounding: some hundred terms of order one.
#[test]
#[allow(clippy::too_many_lines, reason = "each sum is compared once")]
fn moments_are_the_plain_integrals() {
    let (spans, collisions) = history(3);
    let first = spans[0].velocities.iter().copied();
    let mut found = Helfand::new(0.0, first, MASS, AREA, BIN, LAGS);
    // Sums in two parts, equal to those in one.
    let mut parts = found.clone();
    for collision in &collisions {
        found.collide(collision);
    }
    for (number, collision) in collisions.iter().enumerate() {
        if number == collisions.len() / 2 {
            let bytes = postcard::to_stdvec(&parts).expect("a record");
            parts = postcard::from_bytes(&bytes).expect("the record");
        }
        parts.collide(collision);
    }
    found.advance(END);
    parts.advance(END);
    assert_eq!(found, parts);
    let at: Vec<_> = (0..=20)
        .map(|bin| plain(&spans, f64::from(bin) * BIN))
        .collect();
    let mean: Vector2<f64> = spans[0].velocities.iter().sum::<Vector2<f64>>() / 7.0;
    let energies = spans[0]
        .velocities
        .iter()
        .map(|v| 0.5 * MASS * (v - mean).norm_squared());
    let temperature = energies.sum::<f64>() / 6.0;
    let rate = plain(&spans, END).0[1][2] / END;
    let moments = found.moments();
    assert_eq!(moments.len(), LAGS);
    for (number, moment) in moments.iter().enumerate() {
        let lag = number + 1;
        let time = lag as f64 * BIN;
        let starts = 20 - lag + 1;
        let average = |of: &dyn Fn(&Change<'_>) -> f64| {
            let one = |start: usize| {
                of(&|part, flux| at[start + lag].0[part][flux] - at[start].0[part][flux])
            };
            (0..starts).map(one).sum::<f64>() / starts as f64
        };
        let parts = |flux: usize, unit: f64| {
            [
                average(&|g| g(0, flux) * g(0, flux)) / unit,
                average(&|g| 2.0 * g(0, flux) * g(1, flux)) / unit,
                average(&|g| g(1, flux) * g(1, flux)) / unit,
            ]
        };
        let near = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        };
        let unit = 2.0 * AREA * temperature * MASS;
        let shear = [0, 1].map(|flux| parts(flux, unit));
        let heat = [3, 4].map(|flux| parts(flux, unit * temperature / MASS));
        for part in 0..3 {
            near(moment.shear[part], 0.5 * (shear[0][part] + shear[1][part]));
            near(moment.heat[part], 0.5 * (heat[0][part] + heat[1][part]));
        }
        let bulk = average(&|g| (g(1, 2) - rate * time).powi(2)) / unit;
        near(moment.bulk, bulk / (1.0 - time / END));
        near(moment.lag, time * (temperature / MASS).sqrt());
        // Starts of displacements: 0, 1.2, 2.4 and so on.
        let starts = (0..20).step_by(LAGS).filter(|start| start + lag <= 20);
        let squares: Vec<f64> = starts
            .flat_map(|start| (0..7).map(move |disk| (start, disk)))
            .map(|(start, disk)| (at[start + lag].1[disk] - at[start].1[disk]).norm_squared())
            .collect();
        near(
            moment.diffusion,
            0.25 * squares.iter().sum::<f64>() / squares.len() as f64,
        );
    }
    // Correlations: changes in all pairs of bins at this distance; displacements in the first and
    // in the last bin of a lag.
    let correlations = found.correlations();
    assert_eq!(correlations.len(), LAGS);
    for (lag, one) in correlations.iter().enumerate() {
        let pairs = 20 - lag;
        let product = |flux: usize, parts: &[usize]| {
            let change = |bin: usize| -> f64 {
                let parts = parts.iter();
                parts
                    .map(|&part| at[bin + 1].0[part][flux] - at[bin].0[part][flux])
                    .sum()
            };
            (0..pairs)
                .map(|bin| change(bin) * change(bin + lag))
                .sum::<f64>()
                / pairs as f64
        };
        let near = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        };
        let unit = AREA * temperature * temperature * BIN * BIN;
        let all = &[0, 1];
        near(one.lag, lag as f64 * BIN * (temperature / MASS).sqrt());
        near(one.shear, 0.5 * (product(0, all) + product(1, all)) / unit);
        // The mean of the run has the variance of all of it over its square.
        let last = &moments[LAGS - 1];
        let variance = 2.0 * AREA * temperature * MASS * last.bulk / (LAGS as f64 * BIN) / END;
        let mean_square = rate * rate - variance;
        near(
            one.bulk,
            (product(2, &[1]) - mean_square * BIN * BIN) / unit,
        );
        let energy = unit * temperature / MASS;
        near(one.heat, 0.5 * (product(3, all) + product(4, all)) / energy);
        let starts = (0..20).step_by(LAGS).filter(|start| start + lag < 20);
        let step = |bin: usize, disk: usize| at[bin + 1].1[disk] - at[bin].1[disk];
        let products: Vec<f64> = starts
            .flat_map(|start| (0..7).map(move |disk| (start, disk)))
            .map(|(start, disk)| step(start, disk).dot(&step(start + lag, disk)))
            .collect();
        let mean = products.iter().sum::<f64>() / products.len() as f64;
        near(one.diffusion, 0.5 * mean / (BIN * BIN) * MASS / temperature);
    }
    // Late collisions and partners without an index change nothing.
    let known = found.clone();
    found.collide(&collisions[0]);
    let anonymous = [Collision::ANONYMOUS; 2];
    found.collide(&Collision {
        time: END,
        pair: anonymous,
        ..collisions[0]
    });
    assert_eq!(found, known);
}
