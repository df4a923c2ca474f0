//! Table `contact_values.csv`: contact value of the pair correlation, from the flux of colliding
//! pairs.

use stosszahl_analysis::contact_value::{Flux, FluxWindow, number_of_pairs, separation_factor};
use stosszahl_results::{Figure, FigureAxis, Table, TableEstimate, table};
use stosszahl_theory::contact;

use super::{Observed, Record, ratio};
use crate::measure::ReplicaRecords;
use crate::plan::{CasePlan, EnginePlan};

fn empty() -> Table {
    table! {
        "contact_values", "Pair correlation at contact, from the normal speeds of colliding pairs and from their rate.";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "species_a", "1", "Number of one species, from 1";
        key "species_b", "1", "Number of the other, not below the first";
        key "pair", "", "Names of both species";
        note "collisions", "1", "Collisions, over all replicas";
        with_theory "approaching", "1", "Part of g(d+) of pairs that approach, from the mean of 1/g over collisions; theory is half of Enskog's contact value";
        with_theory "separating", "1", "Part of g(d+) of pairs that separate, from the mean of 1/g after contact; theory is that before over the restitution r";
        with_theory "contact_value", "1", "Pair correlation at contact g(d+), the sum of both parts; theory is Enskog's contact value times (1 + r)/(2 r)";
        with_theory "rate_contact_value", "1", "Contact value χ from the collision rate, as if the normal speeds of colliding pairs were Maxwellian; theory is Enskog's";
        estimate "rate_ratio", "1", "Contact value from the collision rate over Enskog's";
        estimate "flux_over_rate", "1", "Contact value g(d+) over (1 + r)/(2 r) times that from the collision rate; 1 if approach speeds of colliding pairs are Maxwellian";
        estimate "contact_value_elastic", "1", "Pair correlation at contact of the elastic twin: exact disks of the same start with restitution 1, at as many collisions per particle";
        note "replicas", "1", "Replicas";
    }
    .figure(
        Figure::curves(
            "Contact value",
            FigureAxis::logarithmic("window_end", "end of the window"),
            FigureAxis::linear("contact_value", "g(d+)"),
        )
        .panels(&["pair"])
        .caption("Pair correlation at contact by flux, with standard errors over replicas. The dashed line is Enskog's contact value times (1 + r)/(2 r)."),
    )
}

/// Computes Enskog's contact values of all pairs of species, row by row; `None` if particles of a
/// species differ in size.
fn enskog(plan: &CasePlan) -> Option<Vec<f64>> {
    let mixture = plan.mixture().ok()?;
    let components = mixture.components();
    let values = contact::values(plan.gas.dimension, components, plan.contact()).ok()?;
    (components.len() == plan.gas.species.len()).then_some(values)
}

/// Builds the table of contact values of all engines and windows; without rows for a gas that is
/// not uniform.
pub(super) fn table(plan: &CasePlan, runs: &ReplicaRecords<'_>, spans: &[[f64; 2]]) -> Table {
    let mut table = empty();
    if !plan.is_uniform_box() {
        return table;
    }
    let theory = enskog(plan);
    for (engine, records) in runs.each::<Record>(plan) {
        let known: Vec<&Observed> = records.iter().filter_map(|one| one.as_ref()).collect();
        for (number, &span) in spans.iter().enumerate() {
            for b in 0..plan.gas.species.len() {
                for a in 0..=b {
                    let chi = theory
                        .as_ref()
                        .map(|all| all[a * plan.gas.species.len() + b]);
                    let one = |one: &&Observed| one.own.flux.windows[number].clone();
                    let windows: Vec<FluxWindow> = known.iter().map(one).collect();
                    let one = |one: &&Observed| Some(one.elastic.get(number)?.1.clone());
                    let elastic: Vec<FluxWindow> = known.iter().filter_map(one).collect();
                    let pair = Pair::new(plan, engine, [a, b], chi);
                    let collisions: f64 = (windows.iter())
                        .map(|window| window.pair_sums([a, b]).collisions)
                        .sum();
                    if let Some(values) = pair.values(&windows) {
                        let numbers = [a, b].map(|one| one as u64 + 1);
                        let key = (engine.name, span, numbers, plan.pair_name([a, b]));
                        let twin = pair.total(&elastic).unwrap_or_default();
                        table.add(((key, collisions), values, twin, windows.len()));
                    }
                }
            }
        }
    }
    table
}

/// Pair of species in one engine, with the theory of its contact value, for one set of table rows.
struct Pair {
    species: [usize; 2],
    dimension: usize,
    volume: f64,
    /// Number of pairs of particles of both species.
    pairs: f64,
    /// Enskog's contact value χ of the pair of species; `None` if there is no theory.
    chi: Option<f64>,
    /// Factor by which g(d+) exceeds the contact value; 1 for elastic pairs.
    factor: Option<f64>,
    /// Collision rate of uncorrelated pairs over that of Maxwellian pairs at the temperature of the
    /// gas. `None` in mixtures, whose species have their own temperatures.
    sonine: Option<f64>,
}

impl Pair {
    fn new(plan: &CasePlan, engine: &EnginePlan, species: [usize; 2], chi: Option<f64>) -> Self {
        let counts = species.map(|one| plan.gas.species[one].count as f64);
        let weight = 1.0 / engine.copies() as f64;
        let factor = plan.gas.law.constant().map(separation_factor);
        let simulators = (plan.count() * engine.copies()) as f64;
        let sonine = plan.has_theory().then(|| {
            // The gas as a whole is at rest, which takes the energy of one particle from it.
            let at_rest = (simulators / (simulators - 1.0)).sqrt();
            at_rest * (1.0 - plan.fourth_cumulant() / 16.0)
        });
        Self {
            species,
            dimension: plan.gas.dimension,
            volume: plan.gas.volume,
            pairs: number_of_pairs(species[0] == species[1], counts, weight),
            chi,
            factor: factor.filter(|factor| factor.is_finite()),
            sonine,
        }
    }

    /// Estimates a contact value: a sum over collisions, divided by its value for independent
    /// pairs. `None` without collisions.
    fn over_norm(
        &self,
        windows: &[FluxWindow],
        sum: &dyn Fn(&Flux) -> f64,
    ) -> Option<TableEstimate> {
        ratio(windows, |window: &FluxWindow| {
            let norm = window.norm(self.dimension, self.pairs, self.volume);
            [sum(&window.pair_sums(self.species)), norm]
        })
    }

    /// Estimates g(d+), the pair correlation at contact, from the flux of colliding pairs before
    /// and after contact.
    fn total(&self, windows: &[FluxWindow]) -> Option<TableEstimate> {
        self.over_norm(windows, &|sums| sums.approaching + sums.separating)
    }

    /// Estimates the values of a table row from the windows of all replicas; `None` without
    /// collisions.
    fn values(&self, windows: &[FluxWindow]) -> Option<[TableEstimate; 6]> {
        let over_norm = |sum: &dyn Fn(&Flux) -> f64| self.over_norm(windows, sum);
        let chi = self.chi;
        let (half, total) = (
            chi.map(|chi| 0.5 * chi),
            chi.zip(self.factor).map(|(a, b)| a * b),
        );
        let after = total.zip(half).map(|(total, half)| total - half);
        let rate = self.sonine.and_then(|sonine| {
            let found = over_norm(&|sums| sums.rate)?;
            Some(found.times(1.0 / sonine))
        });
        let rate = rate.unwrap_or_default();
        let flux = self.sonine.zip(self.factor).and_then(|(sonine, factor)| {
            let found = ratio(windows, |window: &FluxWindow| {
                let sums = window.pair_sums(self.species);
                [sums.approaching + sums.separating, factor * sums.rate]
            })?;
            Some(found.times(sonine))
        });
        Some([
            over_norm(&|sums| sums.approaching)?.against(half),
            over_norm(&|sums| sums.separating)
                .unwrap_or_default()
                .against(after),
            self.total(windows).unwrap_or_default().against(total),
            rate.against(chi),
            chi.map(|chi| rate.times(1.0 / chi)).unwrap_or_default(),
            flux.unwrap_or_default(),
        ])
    }
}
