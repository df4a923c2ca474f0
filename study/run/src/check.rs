//! Planning of a case before it is run: derived quantities, statistical power, cost, choices and
//! warnings.

pub(crate) mod question;

use stosszahl_case::{Case, CaseError, CaseFile, CasePoint, Format};
use stosszahl_results::{Table, engine_title, format_number};

use crate::cost::{Cost, RuntimeEstimate, estimate_cost, estimate_runtime};
use crate::engines;
use crate::measure::{BadOption, Measure, empty_tables};
use crate::measures;
use crate::plan::{CasePlan, DerivedQuantity, PlanError, available_memory};

/// Number of candidate pairs per collision from which a Monte Carlo scheme is called slow in a
/// warning.
const MANY_TRIALS: f64 = 50.0;

/// Sweep point of a case with its resolved plan and its measures.
pub struct Planned<'a> {
    /// Sweep point of the case.
    pub point: &'a CasePoint,
    /// Resolved plan of the point.
    pub plan: CasePlan,
    /// Measures of the point, in the order of their tables.
    pub measures: Vec<&'static dyn Measure>,
}

/// Summary of a planned point of a case, as the command `check` prints it.
#[derive(Clone, Debug)]
pub struct CaseOutline {
    /// Title of the planned case.
    pub title: String,
    /// Name of the sweep point; empty without a sweep.
    pub point: String,
    /// Quantities derived from the case, in its units.
    pub derived: Vec<DerivedQuantity>,
    /// Measure whose verdict is the headline, with the engine of the question if the case names
    /// one.
    pub leading: String,
    /// Names of the engines that the case runs.
    pub engines: Vec<&'static str>,
    /// Names of the measures of the case.
    pub measures: Vec<&'static str>,
    /// Number of replicas of each point.
    pub replicas: u64,
    /// Statistical power of the verdicts in words, as far as the spread of replicas is known.
    pub power: Vec<String>,
    /// Estimated memory and computing time of the point.
    pub cost: Cost,
    /// Choices that the program made for the case, with the reasons.
    pub choices: Vec<String>,
    /// Warnings about the case, as sentences.
    pub warnings: Vec<String>,
    /// Work that a time estimate without measurement leaves out, in words.
    pub unknown: Vec<String>,
}

/// Returns the parser and schema of case files, with the options of all measures.
pub fn format() -> Format {
    let all = measures::ALL.iter();
    let named: Vec<_> = all.map(|one| (one.name(), one.options_schema())).collect();
    Format::new(&named)
}

impl<'a> Planned<'a> {
    /// Plans one sweep point of a case: resolves its settings and chooses its measures.
    ///
    /// # Errors
    /// [`CaseError`] shows where the offending key is written.
    pub fn new(file: &CaseFile, point: &'a CasePoint) -> Result<Self, CaseError> {
        Self::plan_point(file, point, &point.case, available_memory())
    }

    /// Plans one sweep point with a case in which the program has made its choices. `free` is the
    /// available memory \[bytes\], see [`CasePlan::derive_within`].
    ///
    /// # Errors
    /// As [`Planned::new`].
    pub fn plan_point(
        file: &CaseFile,
        point: &'a CasePoint,
        case: &Case,
        free: Option<f64>,
    ) -> Result<Self, CaseError> {
        let folder = file.path.parent().unwrap_or(std::path::Path::new(""));
        let plan = CasePlan::derive_within(case, folder, free)
            .map_err(|error| case_error(point, &error))?;
        check_accuracy(&plan).map_err(|error| case_error(point, &error))?;
        engines::check_start(&plan).map_err(|error| case_error(point, &error))?;
        let measures = chosen(&plan).map_err(|error| case_error(point, &error))?;
        let planned = Self {
            point,
            plan,
            measures,
        };
        let tables = |leading: usize| planned.tables_of(leading);
        question::check_question(&planned.plan, &planned.measures, tables)
            .map_err(|error| case_error(point, &error))?;
        Ok(planned)
    }

    /// Returns the empty tables of the measure with this index.
    fn tables_of(&self, place: usize) -> Vec<Table> {
        let name = self.measures.get(place).map(|measure| measure.name());
        let own = empty_tables(&self.plan, &self.measures).into_iter();
        own.filter(|(measure, _)| Some(measure.name()) == name)
            .map(|(_, table)| table)
            .collect()
    }

    /// Returns the empty tables that a run will have, without solving theory for them.
    pub fn tables(&self) -> Vec<Table> {
        let all = empty_tables(&self.plan, &self.measures).into_iter();
        all.map(|(_, table)| table).collect()
    }

    /// Estimates memory and computing time of the point on a number of threads.
    pub fn cost(&self, threads: usize) -> Cost {
        estimate_cost(&self.plan, &self.measures, threads)
    }

    /// Estimates the computing times of one replica at nominal speeds: its start, its engines, and
    /// companion gases of measures.
    pub fn pace(&self) -> RuntimeEstimate {
        estimate_runtime(&self.plan, &self.measures)
    }

    /// Summarises the planned point for the user: derived quantities, choices, warnings,
    /// statistical power, and the memory and time that it will take on this number of threads.
    pub fn outline(&self, threads: usize) -> CaseOutline {
        let level = level(self);
        let replicas = self.plan.case.replicas as usize;
        let spreads = self
            .measures
            .iter()
            .flat_map(|one| one.quantity_spreads(&self.plan));
        CaseOutline {
            title: self.plan.case.title.clone(),
            point: self.point.name.clone(),
            derived: self.plan.derived(),
            leading: question::headline(&self.plan, &self.measures),
            engines: self.plan.engines.iter().map(|one| one.name).collect(),
            measures: self.measures.iter().map(|one| one.name()).collect(),
            replicas: self.plan.case.replicas,
            power: spreads.map(|one| one.power(replicas, level)).collect(),
            cost: self.cost(threads),
            choices: self.plan.notes.choices.clone(),
            warnings: self.warnings(),
            unknown: self.plan.unknown_to_the_estimate(),
        }
    }

    /// Returns the warnings of the plan, and one for each slow scheme.
    fn warnings(&self) -> Vec<String> {
        let slow = self.plan.engines.iter().filter_map(|engine| {
            let trials = self.plan.trials_per_collision(engine)?;
            (trials > MANY_TRIALS).then(|| {
                format!(
                    "{}: slow, for it tries about {} pairs for each collision: the largest particles meet far more often than \
                     most, and the lightest are far faster, while all pairs are tried as if they were both",
                    engine_title(engine.name),
                    format_number(trials.round())
                )
            })
        });
        self.plan
            .notes
            .warnings
            .iter()
            .cloned()
            .chain(slow)
            .collect()
    }
}

/// Computes the error probability of each verdict of a point: that of the point divided by the
/// number of its verdicts (Bonferroni). It is known before the run. Over the points of a sweep the
/// false discovery rate is controlled instead.
pub fn level(planned: &Planned<'_>) -> f64 {
    let measures = planned.measures.iter();
    let all: usize = measures.map(|one| one.test_count(&planned.plan)).sum();
    planned.plan.case.verdict.family_wise_error_rate / all.max(1) as f64
}

/// Returns the plans of all sweep points of a case, and checks each of them.
///
/// # Errors
/// As [`Planned::new`].
pub fn check_case(file: &CaseFile) -> Result<Vec<Planned<'_>>, CaseError> {
    check_within(file, available_memory())
}

/// Plans all sweep points of a case with a given amount of available memory \[bytes\], see
/// [`CasePlan::derive_within`].
pub(crate) fn check_within(
    file: &CaseFile,
    free: Option<f64>,
) -> Result<Vec<Planned<'_>>, CaseError> {
    let points = file.points.iter();
    let planned = points.map(|point| Planned::plan_point(file, point, &point.case, free));
    planned.collect()
}

/// Returns the measures of a planned case: those that it names, and the default ones.
///
/// # Errors
/// [`PlanError`] names the option, or the unknown measure.
pub fn chosen(plan: &CasePlan) -> Result<Vec<&'static dyn Measure>, PlanError> {
    let known = |name: &str| measures::ALL.iter().any(|measure| measure.name() == name);
    if let Some(name) = plan.case.measure.keys().find(|name| !known(name)) {
        let names: Vec<&str> = measures::ALL.iter().map(|measure| measure.name()).collect();
        let allowed = format!("one of {}", names.join(", "));
        return Err(PlanError::new(
            format!("measure.{name}"),
            "no such measure",
            allowed,
        ));
    }
    let asked = |measure: &&&'static dyn Measure| {
        let is_right = measure.knows_shear() || !plan.is_sheared();
        plan.case.measure.contains_key(measure.name()) || measure.by_default(plan) && is_right
    };
    let list: Vec<&'static dyn Measure> = measures::ALL.iter().filter(asked).copied().collect();
    for measure in &list {
        if plan.is_sheared() && !measure.knows_shear() {
            let allowed = "without box.shear_rate: in a shear flow this measure would take neighbours, displacements or theory as in a \
                           gas at rest";
            let key = format!("measure.{}", measure.name());
            return Err(PlanError::new(key, "", allowed));
        }
        measure
            .check_options(plan)
            .map_err(|BadOption { key, allowed }| {
                let dot = if key.is_empty() { "" } else { "." };
                PlanError::of_message(format!("measure.{}{dot}{key}", measure.name()), &allowed)
            })?;
    }
    Ok(list)
}

/// Checks that an accuracy target is used only where theory gives the error.
///
/// # Errors
/// [`PlanError`] names what the case has.
fn check_accuracy(plan: &CasePlan) -> Result<(), PlanError> {
    let found = if plan.case.accuracy.is_none() {
        return Ok(());
    } else if plan.gas.dimension != 2 {
        "spheres"
    } else if !plan.is_uniform() {
        "walls, openings, obstacles or gravity"
    } else if plan.is_rough() {
        "particles that spin"
    } else if plan.is_sheared() {
        "a shear flow"
    } else if plan.case.thermostat.is_some() {
        "a driven gas"
    } else if !plan.has_theory() {
        "several sizes or masses, or a restitution that depends on the speed"
    } else if plan.engines.iter().all(|one| one.parameters().is_none()) {
        "no Monte Carlo engine in cells"
    } else {
        return Ok(());
    };
    let allowed = "a uniform gas of equal smooth disks with one coefficient of restitution, cooling freely or elastic: theory says what \
                   the error of its pilot is";
    Err(PlanError::new("accuracy.target", found, allowed))
}

/// Converts a planning error to a case error with the position of its key.
fn case_error(point: &CasePoint, error: &PlanError) -> CaseError {
    let PlanError {
        key,
        found,
        allowed,
    } = error;
    let found = (!found.is_empty()).then(|| found.clone());
    point.refuse_found(key, found, allowed.as_str())
}
