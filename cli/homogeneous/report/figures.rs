//! Which curves belong together, and what the caption says of them.
//!
//! Species run through the ordered scale of colours from light to heavy; theory is dashed.

use crate::homogeneous::tables::{ClusterRow, GasRow, SizeRow, SpeciesRow, TimeAveragedRow};
use crate::report::figures::{Figure, distinct, number, shade, spread, theory};
use crate::report::plot::{Axis, Chart, Curve, Mark, Point, Stroke};

/// Species that one plot shows at most.
const CURVES: usize = 6;

/// Label of the time axis.
const TIME: &str = "t";

/// Below this, numbers are noise on a logarithmic axis.
fn point(x: f64, y: Option<f64>, error: Option<f64>) -> Option<Point> {
    y.map(|y| Point { x, y, error })
}

fn single(
    title: &str,
    x: Axis,
    y: Axis,
    curves: Vec<Curve>,
    level: Option<f64>,
    caption: String,
) -> Option<Figure> {
    let chart = Chart {
        x,
        y,
        curves,
        level,
    };
    Figure {
        title: title.to_owned(),
        panels: vec![(String::new(), chart)],
        caption,
    }
    .drawable()
}

/// Measured points of one colour.
fn marks(label: String, place: usize, count: usize, points: Vec<Point>) -> Curve {
    Curve {
        label,
        colour: shade(place, count),
        mark: Some(Mark::ALL[place % Mark::ALL.len()]),
        stroke: Stroke::None,
        points,
    }
}

/// A dashed line of theory, if it has any points.
fn dashed(points: Vec<Point>) -> Option<Curve> {
    (!points.is_empty()).then(|| theory("theory", points))
}

/// Energy against time.
pub(super) fn energy(rows: &[GasRow]) -> Option<Figure> {
    let law = rows
        .iter()
        .filter_map(|row| point(row.time, row.energy_ratio_theory, None));
    let mut curves: Vec<Curve> = dashed(law.collect()).into_iter().collect();
    let found = rows
        .iter()
        .filter_map(|row| point(row.time, Some(row.energy_ratio), row.energy_ratio_se));
    curves.push(marks("simulation".to_owned(), 0, 2, found.collect()));
    let last = rows.last()?;
    let caption = format!(
        "Kinetic energy over that of the start against time, both logarithmic. At t = {} it is {}{}.",
        number(last.time, 4),
        number(last.energy_ratio, 4),
        last.energy_ratio_theory.map_or(String::new(), |theory| {
            format!("; theory says {}", number(theory, 4))
        })
    );
    single(
        "Energy",
        Axis::logarithmic(TIME),
        Axis::logarithmic("E / E(0)"),
        curves,
        None,
        caption,
    )
}

/// Collisions of a particle against time.
pub(super) fn collisions(rows: &[GasRow]) -> Option<Figure> {
    let law = rows
        .iter()
        .filter_map(|row| point(row.time, row.collisions_per_particle_theory, None));
    let mut curves: Vec<Curve> = dashed(law.collect()).into_iter().collect();
    let found = rows.iter().filter_map(|row| {
        point(
            row.time,
            row.collisions_per_particle,
            row.collisions_per_particle_se,
        )
    });
    curves.push(marks("simulation".to_owned(), 0, 2, found.collect()));
    single(
        "Collisions",
        Axis::logarithmic(TIME),
        Axis::linear("collisions per particle"),
        curves,
        None,
        "Collisions that a particle of the start took part in, on average, against the logarithm of time. In a gas that \
         cools by Haff’s law they grow as that logarithm."
            .to_owned(),
    )
}

/// The species that are shown, light to heavy, with their masses.
fn shown<'a>(species: impl Iterator<Item = (u64, f64)> + 'a) -> Vec<(u64, f64)> {
    let mut all: Vec<(u64, f64)> = species.collect();
    all.sort_by_key(|species| species.0);
    all.dedup_by_key(|species| species.0);
    if all.len() > CURVES {
        // By the logarithm of the number: power laws have their particles among the first.
        let last = all.len() as f64;
        let mut places: Vec<usize> = (0..CURVES)
            .map(|i| last.powf(i as f64 / (CURVES - 1) as f64).round() as usize - 1)
            .collect();
        places.dedup();
        return places.into_iter().map(|place| all[place]).collect();
    }
    spread(&all, CURVES)
}

/// How a quantity of a species is read from a row: value, error, theory.
type Quantity<R> = fn(&R) -> (Option<f64>, Option<f64>, Option<f64>);

/// Curves of one quantity, species by species, theory first.
fn by_species<R>(
    rows: &[R],
    species: fn(&R) -> (u64, f64),
    x: fn(&R) -> f64,
    quantity: Quantity<R>,
) -> Vec<Curve> {
    let list = shown(rows.iter().map(species));
    let (mut lines, mut found) = (Vec::new(), Vec::new());
    for (place, &(number_of, mass)) in list.iter().enumerate() {
        let own = || rows.iter().filter(move |row| species(row).0 == number_of);
        let law = own().filter_map(|row| point(x(row), quantity(row).2, None));
        lines.extend(dashed(law.collect()));
        let points: Vec<Point> = own()
            .filter_map(|row| {
                let (value, error, _) = quantity(row);
                point(x(row), value, error)
            })
            .collect();
        let label = if list.len() == 1 {
            "simulation".to_owned()
        } else {
            format!("species {number_of}, mass {}", number(mass, 4))
        };
        if !points.is_empty() {
            found.push(marks(label, place, list.len().max(2), points));
        }
    }
    lines.extend(found);
    lines
}

fn species_of(row: &SpeciesRow) -> (u64, f64) {
    (row.species, row.mass)
}

/// Temperatures of the species against time.
pub(super) fn temperatures(rows: &[SpeciesRow]) -> Option<Figure> {
    if rows.iter().all(|row| row.species == 1) {
        return None;
    }
    let curves = by_species(
        rows,
        species_of,
        |row| row.time,
        |row| {
            let lone = row.count > 0;
            (
                lone.then_some(row.temperature),
                row.temperature_se,
                row.temperature_theory,
            )
        },
    );
    single(
        "Temperatures of the species",
        Axis::logarithmic(TIME),
        Axis::logarithmic("T"),
        curves,
        None,
        "Temperatures m<v²>/D against time, both logarithmic. Energy is not shared alike in a gas that cools: light particles \
         become the coldest, and in the end all temperatures fall together. Dashed: the kinetic \
         equations."
            .to_owned(),
    )
}

/// The rows of the last time.
fn last_rows(rows: &[SpeciesRow]) -> Vec<&SpeciesRow> {
    let last = rows.last().map_or(f64::NAN, |row| row.time);
    rows.iter()
        .filter(|row| row.time == last && row.count > 0)
        .collect()
}

/// Temperatures against mass at the end, where there are many species.
pub(super) fn temperature_by_mass(rows: &[SpeciesRow]) -> Option<Figure> {
    let last = last_rows(rows);
    if last.len() <= CURVES {
        return None;
    }
    let law = last
        .iter()
        .filter_map(|row| point(row.mass, row.temperature_theory, None));
    let mut curves: Vec<Curve> = dashed(law.collect()).into_iter().collect();
    let found = last
        .iter()
        .filter_map(|row| point(row.mass, Some(row.temperature), row.temperature_se));
    curves.push(marks("simulation".to_owned(), 0, 2, found.collect()));
    let caption = format!(
        "Temperatures of all species at t = {} against their mass, both logarithmic.",
        number(last[0].time, 4)
    );
    single(
        "Temperature by mass",
        Axis::logarithmic("mass"),
        Axis::logarithmic("T"),
        curves,
        None,
        caption,
    )
}

/// Fourth cumulants against time.
pub(super) fn cumulants(rows: &[SpeciesRow]) -> Option<Figure> {
    // A few particles have a cumulant, but it says nothing.
    let many: Vec<SpeciesRow> = rows
        .iter()
        .filter(|row| row.count >= 1000)
        .cloned()
        .collect();
    let curves = by_species(
        &many,
        species_of,
        |row| row.time,
        |row| {
            (
                Some(row.fourth_cumulant),
                row.fourth_cumulant_se,
                row.fourth_cumulant_theory,
            )
        },
    );
    single(
        "Fourth cumulant",
        Axis::logarithmic(TIME),
        Axis::linear("a₂"),
        curves,
        Some(0.0),
        "Fourth cumulant of the velocities, D<v⁴>/((D + 2)<v²>²) − 1, of species with a thousand particles or more. It is zero \
         for Maxwellian velocities. Dashed: the kinetic equations in more than one Sonine order, where they were solved."
            .to_owned(),
    )
}

/// Velocity correlations against time.
pub(super) fn correlations(rows: &[SpeciesRow]) -> Option<Figure> {
    let curves = by_species(
        rows,
        species_of,
        |row| row.time,
        |row| {
            (
                row.velocity_correlation,
                row.velocity_correlation_se,
                row.velocity_correlation_theory,
            )
        },
    );
    single(
        "Velocity correlation",
        Axis::logarithmic(TIME),
        Axis::linear("<v(0)·v(t)> / <v(0)²>"),
        curves,
        None,
        "Correlation of the velocities with those of the start. Dashed: the kinetic equations."
            .to_owned(),
    )
}

/// Mean squared displacements against time.
pub(super) fn displacements(gas: &[GasRow], rows: &[SpeciesRow]) -> Option<Figure> {
    let mut curves = by_species(
        rows,
        species_of,
        |row| row.time,
        |row| {
            (
                row.displacement_square,
                row.displacement_square_se,
                row.displacement_square_theory,
            )
        },
    );
    if rows.iter().any(|row| row.species > 1) {
        let total = gas
            .iter()
            .filter_map(|row| point(row.time, row.displacement_square, None));
        curves.push(Curve {
            label: "all particles".to_owned(),
            colour: "var(--ink)".to_owned(),
            mark: None,
            stroke: Stroke::Thin,
            points: total.collect(),
        });
    }
    single(
        "Mean squared displacement",
        Axis::logarithmic(TIME),
        Axis::logarithmic("<R²>"),
        curves,
        None,
        "Mean squared displacement since the start against time, both logarithmic: ballistic at first, then ever slower as \
         the gas cools. Dashed: the kinetic equations."
            .to_owned(),
    )
}

/// Displacements over those of the first species against mass at the end, where there are many species.
pub(super) fn displacement_by_mass(rows: &[SpeciesRow]) -> Option<Figure> {
    let last = last_rows(rows);
    let first = last.first()?;
    if last.len() <= CURVES {
        return None;
    }
    let unit = first.displacement_square?;
    let law = last.iter().filter_map(|row| {
        let ratio = row.displacement_square_theory? / first.displacement_square_theory?;
        point(row.mass, Some(ratio), None)
    });
    let mut curves: Vec<Curve> = dashed(law.collect()).into_iter().collect();
    let found = last.iter().filter_map(|row| {
        let error = row.displacement_square_se.map(|error| error / unit);
        point(row.mass, row.displacement_square.map(|r| r / unit), error)
    });
    curves.push(marks("simulation".to_owned(), 0, 2, found.collect()));
    let caption = format!(
        "Mean squared displacement of all species over that of the first at t = {} against mass, both logarithmic.",
        number(first.time, 4)
    );
    single(
        "Displacement by mass",
        Axis::logarithmic("mass"),
        Axis::logarithmic("<R²> / <R₁²>"),
        curves,
        None,
        caption,
    )
}

/// Displacements averaged over time against the lag.
pub(super) fn time_averaged(rows: &[TimeAveragedRow]) -> Option<Figure> {
    let curves = by_species(
        rows,
        |row| (row.species, row.mass),
        |row| row.lag,
        |row| {
            (
                Some(row.displacement_square),
                row.displacement_square_se,
                row.displacement_square_theory,
            )
        },
    );
    single(
        "Time-averaged displacement",
        Axis::logarithmic("lag"),
        Axis::logarithmic("δ²"),
        curves,
        None,
        "Squared displacement over a lag, averaged over all its starts in the run and over paths. In a gas that cools it is \
         another than the mean squared displacement since the start: diffusion ages. Dashed: the kinetic equations."
            .to_owned(),
    )
}

/// Number and energy of clusters against time.
pub(super) fn clusters(rows: &[ClusterRow]) -> Option<Figure> {
    let number_of = rows
        .iter()
        .filter_map(|row| point(row.time, Some(row.clusters_ratio), row.clusters_ratio_se));
    let energy_of = rows
        .iter()
        .filter_map(|row| point(row.time, Some(row.energy_ratio), row.energy_ratio_se));
    let single_of = rows
        .iter()
        .filter_map(|row| point(row.time, Some(row.single_ratio), None));
    let curves = vec![
        marks("clusters, N / N(0)".to_owned(), 0, 3, number_of.collect()),
        marks("energy, E / E(0)".to_owned(), 1, 3, energy_of.collect()),
        marks(
            "clusters of one monomer".to_owned(),
            2,
            3,
            single_of.collect(),
        ),
    ];
    let last = rows.last()?;
    let caption = format!(
        "Clusters, energy and single monomers, over those of the start, against time, both logarithmic. At t = {} a \
         monomer is in a cluster of {} monomers on average; the largest has {}.",
        number(last.time, 4),
        number(last.mean_monomers, 4),
        number(last.largest_monomers, 5)
    );
    single(
        "Number and energy",
        Axis::logarithmic(TIME),
        Axis::logarithmic("share of the start"),
        curves,
        None,
        caption,
    )
}

/// Distributions of sizes.
pub(super) fn sizes(rows: &[SizeRow]) -> Option<Figure> {
    let mut curves = Vec::new();
    let instants: Vec<f64> = distinct(
        rows.iter()
            .filter(|row| row.average == "instant")
            .map(|row| row.time),
    );
    let told = spread(&instants, CURVES);
    let points = |average: &str, time: f64| -> Vec<Point> {
        rows.iter()
            .filter(|row| row.average == average && row.time == time)
            .filter_map(|row| {
                let middle = (row.monomers_low as f64 * row.monomers_high as f64).sqrt();
                point(
                    middle,
                    Some(row.clusters_per_monomer),
                    row.clusters_per_monomer_se,
                )
            })
            .collect()
    };
    for (place, &time) in told.iter().enumerate() {
        curves.push(marks(
            format!("t = {}", number(time, 4)),
            place,
            told.len() + 1,
            points("instant", time),
        ));
    }
    if let Some(steady) = rows.iter().find(|row| row.average == "steady") {
        curves.push(Curve {
            label: format!("mean from t = {} on", number(steady.time, 4)),
            colour: "var(--ink)".to_owned(),
            mark: None,
            stroke: Stroke::Solid,
            points: points("steady", steady.time),
        });
    }
    single(
        "Sizes of the clusters",
        Axis::logarithmic("monomers k"),
        Axis::logarithmic("clusters of k monomers per monomer"),
        curves,
        None,
        "Numbers of clusters by their monomers, for each monomer of the gas, both logarithmic; beyond 16 monomers in bins of \
         ten to a decade."
            .to_owned(),
    )
}
