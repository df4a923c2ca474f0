//! From a case as written to what it means: defaults that depend on other keys, and relations between keys.

use toml::Table;

use super::case::{Case, Content, Measure, Restitution, Run, Species, Steady, Sticking, TimeUnit};
use super::written::{self, Written};
use crate::case::{Form, KeyPath, Problem, typed};

/// Most species in a power law.
const MOST_MASSES: u64 = 100_000;

/// Fewest and most particles of a gas.
const FEWEST: usize = 1;
const MOST: usize = (1 << 31) - 1;

/// Most scalings of velocities in a run.
const MOST_SCALINGS: f64 = 1e7;

/// Checks a table and gives the case that it means.
pub(super) fn case(table: &Table) -> Result<Case, Problem> {
    let written: Written = typed::read(Case::schema(), table)?;
    let check = Check { table };
    let content = check.content(&written)?;
    let pairs = check.pairs(&written, &content)?;
    let sticking = check.sticking(&written, &content)?;
    let run = check.run(&written, &pairs)?;
    let heating_interval = check.heating(&written, sticking.as_ref(), run.until)?;
    let measure = check.measure(&written, sticking.as_ref(), run.until)?;
    Ok(Case {
        title: written.title,
        seed: written.seed,
        replicas: written.replicas as usize,
        dimension: written.gas.dimension as usize,
        volume: written.gas.volume,
        restitution: written.gas.restitution,
        pairs,
        contact_values: written.gas.contact_values,
        content,
        sticking,
        heating_interval,
        selection: written.engine.selection,
        run,
        measure,
        tolerance: written.verdict.tolerance,
        sonine_orders: written.verdict.sonine_orders.map(|orders| orders as usize),
    })
}

/// Number of particles of mass `mass` in a power law.
pub(super) fn power_law_count(
    monomers: u64,
    exponent: f64,
    mass: u64,
    rounding: written::Rounding,
) -> usize {
    let share = monomers as f64 * (mass as f64).powf(-exponent);
    match rounding {
        // A share that is whole must not fall below itself by rounding.
        written::Rounding::Down => (share * (1.0 + 1e-12)).floor() as usize,
        written::Rounding::Nearest => share.round() as usize,
    }
}

/// A case under check.
struct Check<'a> {
    table: &'a Table,
}

impl Check<'_> {
    /// Refuses the value of a key, or its absence, with the sentence of the schema.
    fn refuse(&self, key: &str) -> Problem {
        self.refuse_with(key, Case::schema().sentence(key))
    }

    fn refuse_with(&self, key: &str, allowed: impl Into<String>) -> Problem {
        typed::refuse(self.table, KeyPath::of(key), allowed)
    }

    /// Refuses a key of one block of a list.
    fn refuse_in(&self, list: &str, index: usize, key: &str) -> Problem {
        let allowed = Case::schema().sentence(&format!("{list}.{key}"));
        typed::refuse(self.table, block(list, index).key(key), allowed)
    }

    fn content(&self, written: &Written) -> Result<Content, Problem> {
        let one = "the gas consists of [[species]], of a [power_law] or of [continuous] sizes: exactly one of the three";
        match (&written.species, &written.power_law, &written.continuous) {
            (Some(list), None, None) => self.species(list, written.gas.volume),
            (None, Some(law), None) => self.power_law(law),
            (None, None, Some(continuous)) => self.continuous(continuous),
            (None, None, None) => Err(self.refuse_with("species", one)),
            (_, Some(_), _) => Err(self.refuse_with("power_law", one)),
            _ => Err(self.refuse_with("continuous", one)),
        }
    }

    fn species(&self, list: &[written::Species], volume: f64) -> Result<Content, Problem> {
        let mut species = Vec::with_capacity(list.len());
        let mut total = 0_usize;
        for (index, one) in list.iter().enumerate() {
            let count = match (one.count, one.density) {
                (Some(count), None) => count as usize,
                (None, Some(density)) if !one.tracer => (density * volume).round() as usize,
                (None, None) => return Err(self.refuse_in("species", index, "count")),
                (_, Some(_)) => return Err(self.refuse_in("species", index, "density")),
            };
            total = total.saturating_add(count);
            if total > MOST {
                let key = if one.count.is_some() {
                    "count"
                } else {
                    "density"
                };
                let allowed = format!(
                    "all species together have at most {MOST} particles; with this one they have {total}"
                );
                return Err(typed::refuse(
                    self.table,
                    block("species", index).key(key),
                    allowed,
                ));
            }
            species.push(Species {
                count,
                mass: one.mass,
                diameter: one.diameter,
                temperature: one.temperature,
                tracer: one.tracer,
            });
        }
        if total < FEWEST {
            let allowed = "a gas has at least one particle; with these counts, or densities and volume, it has none";
            return Err(self.refuse_with("species", allowed));
        }
        let mut tracers = species.iter().enumerate().filter(|(_, one)| one.tracer);
        if let Some((first, _)) = tracers.next() {
            if let Some((second, _)) = tracers.next() {
                return Err(self.refuse_in("species", second, "tracer"));
            }
            if species.len() == 1 {
                return Err(self.refuse_in("species", first, "tracer"));
            }
        }
        Ok(Content::Species(species))
    }

    fn power_law(&self, law: &written::PowerLaw) -> Result<Content, Problem> {
        let count = |mass| power_law_count(law.monomers, law.exponent, mass, law.rounding);
        let most = law.largest_mass.unwrap_or(MOST_MASSES);
        if law.largest_mass.is_none() && count(MOST_MASSES) > 0 {
            return Err(self.refuse("power_law.largest_mass"));
        }
        let total = (1..=most).map(count).try_fold(0_usize, |sum, count| {
            let sum = sum.checked_add(count)?;
            (sum <= MOST).then_some(sum)
        });
        if total.is_none() {
            let allowed = format!("all masses together have at most {MOST} particles");
            return Err(self.refuse_with("power_law.monomers", allowed));
        }
        Ok(Content::PowerLaw {
            monomers: law.monomers,
            exponent: law.exponent,
            largest_mass: law.largest_mass,
            rounding: law.rounding,
            temperature: law.temperature,
        })
    }

    fn continuous(&self, continuous: &written::Continuous) -> Result<Content, Problem> {
        // The smallest diameter of a uniform distribution is the mean less sqrt(3) deviations.
        let uniform = continuous.distribution == written::Distribution::Uniform;
        if uniform && continuous.relative_width > 0.57 {
            return Err(self.refuse("continuous.relative_width"));
        }
        if 2 * continuous.groups > continuous.particles {
            return Err(self.refuse("continuous.groups"));
        }
        Ok(Content::Continuous {
            particles: continuous.particles as usize,
            distribution: continuous.distribution,
            mean_diameter: continuous.mean_diameter,
            relative_width: continuous.relative_width,
            unit_mass: continuous.unit_mass,
            temperature: continuous.temperature,
            groups: continuous.groups as usize,
        })
    }

    fn pairs(
        &self,
        written: &Written,
        content: &Content,
    ) -> Result<Vec<([usize; 2], Restitution)>, Problem> {
        let known = match content {
            Content::Species(species) => species.len() as u64,
            _ => 0,
        };
        let mut pairs: Vec<([usize; 2], Restitution)> = Vec::new();
        for (index, pair) in written.pair.iter().enumerate() {
            let [a, b] = pair.species;
            let named = [a.min(b) as usize, a.max(b) as usize].map(|one| one.wrapping_sub(1));
            let twice = pairs.iter().any(|(known, _)| *known == named);
            if a.max(b) > known || a.min(b) == 0 || twice {
                return Err(self.refuse_in("pair", index, "species"));
            }
            pairs.push((named, pair.restitution));
        }
        Ok(pairs)
    }

    fn sticking(&self, written: &Written, content: &Content) -> Result<Option<Sticking>, Problem> {
        let Some(sticking) = &written.sticking else {
            return Ok(None);
        };
        let monomers = matches!(content, Content::Species(species) if species.len() == 1);
        if !monomers {
            let allowed = "particles that stick are the monomers of exactly one [[species]]";
            return Err(self.refuse_with("sticking", allowed));
        }
        Ok(Some(Sticking {
            stick_below: sticking.stick_below,
            stick_part: sticking.stick_part,
            break_above: sticking.break_above,
            break_part: sticking.break_part,
            first: sticking.first,
            speed_kept_in_breaking: sticking.speed_kept_in_breaking,
        }))
    }

    fn heating(
        &self,
        written: &Written,
        sticking: Option<&Sticking>,
        until: f64,
    ) -> Result<Option<f64>, Problem> {
        let Some(heating) = &written.heating else {
            return Ok(None);
        };
        let breaks = sticking.is_some_and(|sticking| sticking.break_above.is_some());
        let interval = heating.interval;
        if breaks && interval < until && until / interval <= MOST_SCALINGS {
            Ok(Some(interval))
        } else {
            Err(self.refuse("heating.interval"))
        }
    }

    fn run(&self, written: &Written, pairs: &[([usize; 2], Restitution)]) -> Result<Run, Problem> {
        let run = &written.run;
        let first_sample = run.first_sample.unwrap_or(run.until / 1000.0);
        if first_sample >= run.until {
            let allowed = format!(
                "{}; run.until = {}",
                Case::schema().sentence("run.first_sample"),
                run.until
            );
            return Err(self.refuse_with("run.first_sample", allowed));
        }
        let all = std::iter::once(written.gas.restitution).chain(pairs.iter().map(|pair| pair.1));
        let elastic = all.into_iter().all(|law| law == Restitution::Constant(1.0));
        if run.time_unit == TimeUnit::Haff && (elastic || written.sticking.is_some()) {
            let allowed = format!(
                "{}, and one that sticks neither",
                Case::schema().sentence("run.time_unit")
            );
            return Err(self.refuse_with("run.time_unit", allowed));
        }
        Ok(Run {
            time_unit: run.time_unit,
            until: run.until,
            first_sample,
            samples_per_decade: run.samples_per_decade as usize,
            checkpoint_seconds: run.checkpoint_seconds,
        })
    }

    fn measure(
        &self,
        written: &Written,
        sticking: Option<&Sticking>,
        until: f64,
    ) -> Result<Measure, Problem> {
        let measure = &written.measure;
        let sticks = sticking.is_some();
        for (key, asked) in [
            ("displacement", measure.displacement),
            ("velocity_correlation", measure.velocity_correlation),
            ("paths", measure.paths > 0),
        ] {
            let alone = key == "paths" && !measure.displacement;
            if asked && (sticks || alone) {
                return Err(self.refuse(&format!("measure.{key}")));
            }
        }
        let size_distribution_times = match &measure.size_distribution_times {
            None if sticks => vec![until],
            None => Vec::new(),
            Some(times) => {
                let rising = times.is_sorted_by(|a, b| a < b);
                let inside = times.last().is_none_or(|&last| last <= until);
                if !(sticks && rising && inside) {
                    return Err(self.refuse("measure.size_distribution_times"));
                }
                times.clone()
            }
        };
        let breaks = sticking.is_some_and(|sticking| sticking.break_above.is_some());
        for (key, given) in [
            ("steady_from", measure.steady_from.is_some()),
            ("fit_monomers", measure.fit_monomers.is_some()),
        ] {
            if given && !breaks {
                return Err(self.refuse(&format!("measure.{key}")));
            }
        }
        let from = measure.steady_from.unwrap_or(0.5 * until);
        if from >= until {
            return Err(self.refuse("measure.steady_from"));
        }
        let [low, high] = measure.fit_monomers.unwrap_or([2, 20]);
        if high < low.saturating_mul(2) || high > u64::from(u32::MAX) {
            return Err(self.refuse("measure.fit_monomers"));
        }
        Ok(Measure {
            displacement: measure.displacement,
            velocity_correlation: measure.velocity_correlation,
            paths: measure.paths as usize,
            size_distribution_times,
            steady: breaks.then_some(Steady {
                from,
                fit_monomers: [low as u32, high as u32],
            }),
        })
    }
}

/// The path of one block of a list.
fn block(list: &str, index: usize) -> KeyPath {
    KeyPath::of(list).element(index)
}
