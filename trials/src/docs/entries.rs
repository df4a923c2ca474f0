//! List of all generated documentation blocks: page, case and generator of each.

use std::mem::take;

use stosszahl_report::drawings;
use stosszahl_results::{Figure, FinishedPoints, ReferenceLine, Table};

use super::course::{BROKEN_CHAOS, FACTORS, UNBIASED};
use super::data::{DataMaker, Made};
use super::results::{Is, OF_EXACT, number_text};
use super::tables::{against, energy_ratio, markdown_table, measured_cells, of_window};
use super::verdicts::VERDICTS;
use super::{gases, map, papers};
use crate::TrialError;

/// Generated block of the documentation: its page, its runs and its generator.
pub struct DocsEntry {
    /// Name of the documentation block, unique in the documentation.
    pub name: &'static str,
    /// Path of the block's page, relative to the repository root.
    pub file: &'static str,
    /// Runs whose results the documentation block shows.
    pub source: EntrySource,
    /// Engines whose numbers the documentation block shows, with statistics versions.
    pub engines: &'static [EngineVersion],
    /// True if `--check` regenerates the block, which takes some ten seconds.
    pub is_cheap: bool,
    /// Generator of the text and the files of the block.
    pub make: DataMaker,
}

/// Runs whose results a documentation block shows: a bundled case, or all papers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EntrySource {
    /// Bundled case, by its name, whose results the block shows.
    Case(&'static str),
    /// Quick runs of all reproduced papers. Each paper counts as a point, with the table of its
    /// claims.
    Papers,
}

impl EntrySource {
    /// Returns the folder of the block's results, relative to `results/docs`.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Case(name) => name,
            Self::Papers => "papers",
        }
    }
}

/// Engine name and its statistics version, as in the first line of a block.
pub type EngineVersion = (&'static str, u32);

const ED: EngineVersion = ("ed", stosszahl_ed::STATISTICS_VERSION);
const DSMC: EngineVersion = ("dsmc", stosszahl_dsmc::STATISTICS_VERSION);
/// Statistics version of the `contact-point` scheme with many simulators per disk, counted apart
/// from other Monte Carlo results.
const HALFWAY: EngineVersion = ("dsmc-halfway", stosszahl_dsmc::HALFWAY_STATISTICS_VERSION);
const HOMOGENEOUS: EngineVersion = (
    "homogeneous",
    stosszahl_dsmc::homogeneous::STATISTICS_VERSION,
);

/// All engines with their current statistics versions.
pub(super) const VERSIONS: [EngineVersion; 4] = [ED, DSMC, HALFWAY, HOMOGENEOUS];

/// Creates a text-only block of the bundled case with the same name, which a check does not
/// regenerate.
const fn entry(
    name: &'static str,
    file: &'static str,
    engines: &'static [EngineVersion],
    make: fn(&FinishedPoints) -> Result<Made, TrialError>,
) -> DocsEntry {
    made_by(name, file, engines, DataMaker::Text(make))
}

/// Creates a block of the bundled case with the same name and a given generator, which a check does
/// not regenerate.
const fn made_by(
    name: &'static str,
    file: &'static str,
    engines: &'static [EngineVersion],
    make: DataMaker,
) -> DocsEntry {
    DocsEntry {
        name,
        file,
        source: EntrySource::Case(name),
        engines,
        is_cheap: false,
        make,
    }
}

/// Converts engine names and statistics versions to the form of a block's first line.
pub(super) fn versions(engines: &[EngineVersion]) -> Vec<(String, u32)> {
    let named = |&(name, version): &EngineVersion| (name.to_owned(), version);
    engines.iter().map(named).collect()
}

impl DocsEntry {
    /// Returns the current statistics versions of the engines whose results the block shows.
    pub fn statistics(&self) -> Vec<(String, u32)> {
        versions(self.engines)
    }

    /// Generates the text and the files of the block from the results of its runs.
    ///
    /// # Errors
    /// The results lack a number.
    pub fn made(&self, results: &FinishedPoints) -> Result<Made, TrialError> {
        match &self.make {
            DataMaker::Text(make) => make(results),
            DataMaker::Data { table, data } => data.made(self.name, &table(results)?),
        }
    }

    const fn with_source(mut self, source: EntrySource) -> Self {
        self.source = source;
        self
    }

    const fn cheap(mut self) -> Self {
        self.is_cheap = true;
        self
    }
}

const BOTH: &[EngineVersion] = &[ED, DSMC];
/// Engines of reproduced papers, which never use many simulators per disk.
const ALL_BUT_HALFWAY: &[EngineVersion] = &[ED, DSMC, HOMOGENEOUS];
const EXACT: &[EngineVersion] = &[ED];
const WITHOUT_POSITIONS: &[EngineVersion] = &[HOMOGENEOUS];
const LUDING: EntrySource = EntrySource::Case("luding-1998");
const CASE_OF_1998: &str = "docs/luding-1998.md";
const MIXTURES: &str = "docs/mixtures.md";
const FLOWS: &str = "docs/flows.md";

/// All documentation blocks that a command generates, in the order of a check.
pub const ENTRIES: &[DocsEntry] = &[
    entry("quick", "README.md", BOTH, quick).cheap(),
    entry("luding-1998-fig3b", CASE_OF_1998, EXACT, fig3b).cheap(),
    entry("luding-1998-energies", CASE_OF_1998, BOTH, energies).with_source(LUDING),
    entry("luding-1998-dissipation", CASE_OF_1998, BOTH, dissipation).with_source(LUDING),
    entry("luding-1998-slopes", CASE_OF_1998, BOTH, slopes).with_source(LUDING),
    entry("map-uniform", map::PAGE, EXACT, map::uniform),
    entry("map-waves", map::PAGE, EXACT, map::waves),
    entry("short-range-correlation", CASE_OF_1998, EXACT, gases::pairs),
    made_by(
        "broken-chaos",
        CASE_OF_1998,
        &[ED, DSMC, HALFWAY],
        BROKEN_CHAOS,
    ),
    made_by("luding-1998-unbiased", CASE_OF_1998, BOTH, UNBIASED),
    made_by("density-ladder", map::PAGE, BOTH, gases::LADDER),
    entry(
        "transport",
        "docs/hydrodynamics.md",
        EXACT,
        gases::transport,
    ),
    made_by("haff-3d", MIXTURES, WITHOUT_POSITIONS, VERDICTS),
    made_by("mixture-cooling", MIXTURES, WITHOUT_POSITIONS, VERDICTS),
    made_by("binary-disks", MIXTURES, BOTH, VERDICTS),
    made_by("sedimentation-disks", FLOWS, BOTH, VERDICTS),
    made_by("vibrated-box", FLOWS, BOTH, VERDICTS),
    made_by("channel-disks", FLOWS, BOTH, VERDICTS),
    made_by("flow-past-disk", FLOWS, &[DSMC], VERDICTS),
    entry(
        "papers",
        "docs/reproduce.md",
        ALL_BUT_HALFWAY,
        papers::papers_block,
    )
    .with_source(EntrySource::Papers),
    made_by("kawasaki-1985", FLOWS, ALL_BUT_HALFWAY, papers::KAWASAKI)
        .with_source(EntrySource::Papers),
    made_by("bodrova-2024", MIXTURES, WITHOUT_POSITIONS, papers::BODROVA)
        .with_source(EntrySource::Papers),
    entry("evidence", CASE_OF_1998, BOTH, evidence).with_source(LUDING),
    made_by("map-onset", map::PAGE, EXACT, map::ONSET),
];

fn quick(results: &FinishedPoints) -> Result<Made, TrialError> {
    // The comparison with free volume is void in these cells.
    let others = [("dsmc-contact-point", "contact point")];
    Ok(against(results, &[0.1, 1.0, 10.0, 100.0], &others)?.into())
}

fn energies(results: &FinishedPoints) -> Result<Made, TrialError> {
    let times = [0.1, 1.0, 10.0, 100.0, 400.0];
    // The others after exact dynamics.
    Ok(against(results, &times, &ENGINES[1..])?.into())
}

fn fig3b(results: &FinishedPoints) -> Result<Made, TrialError> {
    let rows = results.names().map(|point| {
        let row = results.row(point, "impact_parameter_summary", &[OF_EXACT])?;
        let restitution = results.setting(point, "gas.restitution")?;
        measured_cells([restitution.to_string()], [row.measured("slope")])
    });
    Ok(markdown_table("r | slope of P(b/d)", rows)?.into())
}

/// Time windows in the block of the case of Luding, Müller & McNamara (1998) \[`t_0`\].
const WINDOWS: [[f64; 2]; 5] = [
    [0.0, 1.0],
    [1.0, 5.0],
    [5.0, 20.0],
    [20.0, 100.0],
    [100.0, 400.0],
];
/// Names of the engines in the block of the case of Luding, Müller & McNamara (1998), each with its
/// title.
const ENGINES: [(&str, &str); 3] = [
    ("ed", "ED"),
    ("dsmc-free-volume", "free volume"),
    ("dsmc-enskog", "Enskog scheme"),
];

fn slopes(results: &FinishedPoints) -> Result<Made, TrialError> {
    let rows = ENGINES.map(|(engine, words)| {
        let slope = |window| {
            let row = results.row("", "impact_parameter_summary", &of_window(engine, window));
            row?.measured("slope")
        };
        measured_cells([words.to_owned()], WINDOWS.map(slope))
    });
    let header = "slope of P(b/d) in t/t0 | 0 to 1 | 1 to 5 | 5 to 20 | 20 to 100 | 100 to 400";
    Ok(markdown_table(header, rows)?.into())
}

fn dissipation(results: &FinishedPoints) -> Result<Made, TrialError> {
    let places = [WINDOWS[0], WINDOWS[4]];
    let places = places
        .into_iter()
        .flat_map(|window| ENGINES.map(|engine| (window, engine)));
    let rows = places.map(|(window, (engine, words))| {
        let row = results.row("", "dissipation", &of_window(engine, window))?;
        let words = [format!("{} to {}", window[0], window[1]), words.to_owned()];
        measured_cells(words, FACTORS.map(|factor| row.measured(factor)))
    });
    let header = "t/t0 | engine | collision rate | squared speed of pairs | impact parameters | correlation | cooling rate";
    Ok(markdown_table(header, rows)?.into())
}

/// Creates the figure of a table that plots one column, with the label `x` of its horizontal axis.
fn figure_of(table: &Table, column: &str, x: &'static str) -> Result<Figure, TrialError> {
    let found = table.figures.iter().find(|one| one.y.column == column);
    let missing = || TrialError::failed(format!("{}: no figure of {column}", table.name));
    let mut figure = found.cloned().ok_or_else(missing)?;
    figure.x.label = x.into();
    Ok(figure)
}

fn evidence(results: &FinishedPoints) -> Result<Made, TrialError> {
    let part = |name: &str, key: Option<&str>| -> Result<Table, TrialError> {
        let keys: Vec<_> = key.into_iter().map(|key| (key, Is("ed"))).collect();
        let table = results.point("")?.1.table(name)?;
        let rows = table.find_rows(&keys)?;
        let rows = rows.iter().map(|row| row.cells().to_vec()).collect();
        Ok(Table {
            rows,
            ..table.clone()
        })
    };
    let energies = part("energy", None)?;
    let quotients = part("comparison", Some("engine_a"))?;
    let impacts = part("impact_parameter", Some("engine"))?;
    let energy = figure_of(&energies, "energy_ratio", "t/t0")?;
    let mut quotient = figure_of(&quotients, "energy_ratio_a_over_b", "t/t0")?;
    quotient.lines.push(ReferenceLine {
        label: "equal".into(),
        y: 1.0,
    });
    let mut windows = figure_of(&impacts, "density", "b/d")?;
    // All windows in one panel.
    windows.curves = take(&mut windows.panels);
    let picture = drawings(
        "Exact disks against Monte Carlo and Haff's law",
        &[
            ("Kinetic energy", &energies, &energy),
            ("Exact disks over Monte Carlo", &quotients, &quotient),
            ("Impact parameters of exact disks", &impacts, &windows),
        ],
    );
    let picture = picture.ok_or_else(|| TrialError::failed("nothing to draw"))?;
    let last = |engine| energy_ratio(results, "", engine, 10.0);
    let slope = results.row("", "impact_parameter_summary", &of_window("ed", WINDOWS[4]))?;
    let text = format!(
        "![Energies of three engines against Haff's law, their quotients, and impact parameters in windows of time](evidence.svg)\n\n\
         From t/t0 = 100 to 400 the slope of P(b/d) of exact disks is {} (0 for chaos). At t/t0 = 10 they have {} times the energy of the \
         free-volume gas and {} times that of the Enskog scheme. Both quotients are void as comparisons: cells of 1.27 disks put energies off.",
        number_text(slope.measured("slope")?),
        number_text(last("dsmc-free-volume")?),
        number_text(last("dsmc-enskog")?),
    );
    let files = vec![("docs/evidence.svg".to_owned(), picture)];
    Ok(Made { text, files })
}
