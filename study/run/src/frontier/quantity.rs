//! Quantities of a run whose errors a frontier measures, and their theory where it is exact.

use std::str::FromStr;

use stosszahl_analysis::accuracy::Known;
use stosszahl_analysis::relaxation::unbiased_cumulant;
use stosszahl_analysis::windows::CollisionWindow;
use stosszahl_case::Case;
use stosszahl_theory::cooling;
use toml::{Table, Value};

use crate::engine_run::in_memory::{collision_rate, energies, window};
use crate::measure::CompletedRun;
use crate::measures::{GasSeries, last_structure_factor};
use crate::plan::{CasePlan, EnginePlan};

/// Decades of time before the end of the run in which the energy is compared.
const DECADES: i32 = 2;
/// Number of times in each decade at which the energy is compared.
const TIMES_PER_DECADE: u64 = 3;
/// Largest mode number `L/wavelength` of the structure factor at long waves, and number of the
/// shells up to it.
const LOW_WAVE_NUMBERS: i64 = 4;
/// Measures that the runs of a frontier make.
pub(crate) const MEASURES: [&str; 3] = ["energy", "impact_parameters", "structure_factor"];

/// Choice of `--quantity`: the quantity whose error ranks the settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuantityKind {
    /// Energy K(t)/K(0) at seven times, the last the end of the run; relative errors.
    Energy,
    /// Collision rate over the whole run, over Enskog's at the temperature measured; relative
    /// errors.
    CollisionRate,
    /// Fourth cumulant a2 at the end; absolute errors.
    Cumulant,
    /// Slope of P(b/d) over the whole run; absolute errors.
    ImpactSlope,
    /// Structure factor S(k) at the end, mean over the modes of up to four waves in the box;
    /// relative errors.
    Structure,
}

impl QuantityKind {
    /// All kinds of quantities of a frontier.
    pub const ALL: [Self; 5] = [
        Self::Energy,
        Self::CollisionRate,
        Self::Cumulant,
        Self::ImpactSlope,
        Self::Structure,
    ];

    /// Returns the name of the quantity kind on the command line and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Energy => "energy",
            Self::CollisionRate => "collision-rate",
            Self::Cumulant => "cumulant",
            Self::ImpactSlope => "impact-slope",
            Self::Structure => "structure",
        }
    }

    /// Returns the name of the quantity kind in sentences.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Energy => "energy",
            Self::CollisionRate => "collision rate",
            Self::Cumulant => "fourth cumulant",
            Self::ImpactSlope => "slope of P(b/d)",
            Self::Structure => "S(k) of long waves",
        }
    }

    /// Returns the unit by which errors of this kind of quantity are divided: the reference value,
    /// or 1 for kinds whose reference may be zero.
    pub(crate) fn unit(self, reference: f64) -> f64 {
        match self {
            Self::Energy | Self::CollisionRate | Self::Structure => reference,
            Self::Cumulant | Self::ImpactSlope => 1.0,
        }
    }
}

impl FromStr for QuantityKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|kind| kind.name() == text);
        let names = Self::ALL.map(Self::name).join(", ");
        found.ok_or_else(|| format!("allowed is one of {names}"))
    }
}

/// Quantity of a run at one time or in one window, whose error is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrontierQuantity {
    /// Kind of the quantity.
    pub kind: QuantityKind,
    /// Time of the quantity, or end of its window, in the unit of time of the case.
    pub time: f64,
}

/// Returns the case as a frontier runs it: with its gas and start, but fixed sample times and
/// measures.
pub(crate) fn measured(case: &Case) -> Case {
    let mut case = case.clone();
    let until = case.run.until;
    case.accuracy = None;
    case.run.first_sample = Some(until / 10_f64.powi(DECADES));
    case.run.samples_per_decade = Some(TIMES_PER_DECADE);
    case.run.samples = None;
    let table = |options: Vec<(&str, Value)>| -> Table {
        let named = options.into_iter();
        named.map(|(key, value)| (key.to_owned(), value)).collect()
    };
    let window = Value::from(vec![0.0, until]);
    let times = ("times", Value::from(vec![until]));
    let waves = ("largest_wave_number", Value::from(LOW_WAVE_NUMBERS));
    let tables = [
        (
            "impact_parameters",
            table(vec![("windows", Value::from(vec![window]))]),
        ),
        ("structure_factor", table(vec![times, waves])),
    ];
    case.measure = tables.map(|(name, table)| (name.to_owned(), table)).into();
    case
}

/// Returns all quantities that a frontier of a case measures.
pub(crate) fn quantities(plan: &CasePlan) -> Vec<FrontierQuantity> {
    let kind = QuantityKind::Energy;
    let times = plan.sample_times().into_iter().skip(1);
    let energies = times.map(|time| FrontierQuantity { kind, time });
    let time = plan.case.run.until;
    let others = QuantityKind::ALL[1..].iter();
    energies
        .chain(others.map(|&kind| FrontierQuantity { kind, time }))
        .collect()
}

/// Reads the values of all quantities from a finished run, in the order of [`quantities`]; NaN for
/// a value that the run lacks.
///
/// The wave numbers of S(k) are multiples of 2π over the side of the box, so S(k) compares with the
/// case only in a box of its size: `whole`.
pub(crate) fn observe(
    plan: &CasePlan,
    engine: &EnginePlan,
    run: &CompletedRun,
    whole: bool,
) -> Vec<f64> {
    let last = run.record::<GasSeries>().and_then(|all| all.last());
    let count = plan.count() * engine.copies();
    let cumulant = last
        .map(|sample| unbiased_cumulant(sample.total().fourth_cumulant(plan.gas.dimension), count));
    let structure = last_structure_factor(run).filter(|_| whole);
    let structure = structure.map(|factor| {
        let low = || {
            let shells = factor.shells.iter();
            shells.filter(|shell| shell.wave_number < LOW_WAVE_NUMBERS as f64 + 0.5)
        };
        let modes: usize = low().map(|shell| shell.modes).sum();
        let sum: f64 = low().map(|shell| shell.value * shell.modes as f64).sum();
        sum / modes as f64
    });
    let mut values = energies(run);
    values.extend([
        collision_rate(plan, run),
        cumulant.unwrap_or(f64::NAN),
        window(run)
            .and_then(CollisionWindow::slope)
            .unwrap_or(f64::NAN),
        structure.unwrap_or(f64::NAN),
    ]);
    values
}

/// Computes the theoretical value of a quantity, if theory is exact for the case in the limit of a
/// large gas; `None` otherwise: for a cooling gas in a box in which waves of shear grow, too.
pub(crate) fn theory(plan: &CasePlan, quantity: FrontierQuantity) -> Option<Known> {
    let is_uniform = plan.gas.law.is_elastic() || !plan.has_unstable_modes();
    uniform_theory(plan, quantity).filter(|_| is_uniform)
}

/// Computes the theoretical value of a quantity of a gas that stays uniform, if theory is exact in
/// the limit of a large gas; `None` otherwise.
///
/// An elastic gas conserves its energy, is Maxwellian, collides at Enskog's rate and has uniform
/// impact parameters. The contact value is right to 0.1 % up to packing 0.5, and N disks of
/// momentum zero have `sqrt(1 - 1/N)` of the rate. A cooling gas follows Haff's law with the
/// relaxation of a2.
pub(super) fn uniform_theory(plan: &CasePlan, quantity: FrontierQuantity) -> Option<Known> {
    if !plan.has_theory() || plan.case.thermostat.is_some() {
        return None;
    }
    let value = match (plan.gas.law.is_elastic(), quantity.kind) {
        (true, QuantityKind::Energy) => 1.0,
        (true, QuantityKind::CollisionRate) => (1.0 - 1.0 / plan.count() as f64).sqrt(),
        (true, QuantityKind::Cumulant | QuantityKind::ImpactSlope) => 0.0,
        (false, QuantityKind::Energy) => {
            cooling::relaxing_haff_law(plan.gas.restitution, plan.time_over_haff(quantity.time)?)
        }
        _ => return None,
    };
    Some(Known {
        value,
        standard_error: 0.0,
    })
}
