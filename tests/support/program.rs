//! The program as a user runs it, in a folder of its own, and its results.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

use stosszahl::case::{CaseFile, Format};
use stosszahl::results::{Manifest, Stored};
use stosszahl::study::{self, CasePlan};
use tempfile::TempDir;

/// Folder of the cases that come with the program.
pub const CASES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cases");

/// Smooth disks that cool, by exact dynamics and by two Monte Carlo schemes.
pub const COOLING: &str = r#"# Does a small gas cool alike?
format = 2
title = "a small comparison"
seed = 5
replicas = 3
[gas]
number = 400
restitution = 0.8
[box]
packing_fraction = 0.25
[run]
until = 10
checkpoint_seconds = 0.01
[engine.ed]
[engine.dsmc-free-volume]
simulators_per_particle = 2
[engine.dsmc-enskog]
simulators_per_particle = 2
[measure.structure_factor]
times = [0, 10]
[measure.pair_correlation]
times = [0, 10]
[measure.snapshots]
times = [10]
"#;

/// Disks of two sizes that are heated by kicks, with all measures that mixtures allow.
pub const DRIVEN_MIXTURE: &str = r#"# Do a few disks of two sizes share their energy?
format = 2
title = "a small driven mixture"
seed = 6
replicas = 2
[gas]
number = 90
restitution = 0.8
[[species]]
share = 0.7
[[species]]
share = 0.3
diameter = 2
mass = 4
[box]
packing_fraction = 0.2
[run]
until = 4
first_sample = 0.5
[thermostat]
kind = "white-noise"
heating = 1
interval = 0.05
[engine.ed]
[engine.dsmc-contact-point]
simulators_per_particle = 4
[measure.impact_parameters]
windows = [[0, 4]]
bins = 5
[measure.displacement]
"#;

/// Disks in a Langevin bath, with spectra.
pub const LANGEVIN: &str = r#"# Does a small gas take the temperature of its bath?
format = 2
title = "a small gas in a bath"
seed = 8
replicas = 2
[gas]
number = 80
restitution = 0.9
[box]
packing_fraction = 0.1
[run]
time_unit = "mean-free-time"
until = 8
first_sample = 0.5
checkpoint_seconds = 0.01
[thermostat]
kind = "langevin"
drag = 0.5
bath_temperature = 1.5
[engine.ed]
[engine.dsmc-enskog]
simulators_per_particle = 2
[measure.spectra]
times = [0, 4, 8]
largest_wave_number = 3
"#;

/// Mixture without positions, with tracers and with all measures that it allows.
pub const MIXTURE: &str = r#"# Does a small mixture cool?
format = 2
title = "a small mixture"
seed = 3
replicas = 2
[gas]
dimension = 3
volume = 2e4
restitution = 0.8
[[species]]
number_density = 0.1
[[species]]
number = 500
mass = 4
diameter = 1.5
temperature = 2
[[species]]
number = 100
mass = 9
tracer = true
[run]
until = 50
first_sample = 0.5
samples_per_decade = 4
[measure.displacement]
[measure.velocity_correlation]
[measure.time_averaged_displacement]
particles = 20
[verdict]
sonine_orders = 2
"#;

/// Monomers that stick and break.
pub const CLUSTERS: &str = r#"# Do a few monomers stick?
format = 2
title = "a test of sticking"
replicas = 2
[gas]
dimension = 3
volume = 2e5
restitution = 1
[[species]]
number = 2000
[aggregation]
aggregate_below = 4
fragment_above = 12
[thermostat]
kind = "rescaling"
interval = 5
[run]
until = 200
[measure.clusters]
times = [0, 100]
"#;

/// Rough disks that fall past obstacles between walls of all sorts, by both engines.
pub const WALLS: &str = r#"# Do a few rough disks fall?
format = 2
title = "a test of walls"
seed = 3
replicas = 2
[gas]
restitution = 0.9
tangential_restitution = 0.2
[[species]]
name = "small"
number = 60
[[species]]
number = 20
diameter = 1.5
mass = 2
[box]
size = [20, 20]
[walls]
left = { restitution = 0.9, slip = 0.5 }
right = "specular"
bottom = { restitution = 0.9, vibration = { amplitude = 0.2, period = 0.5 } }
top = { temperature = 2, sliding = [0.5, 0] }
[gravity]
acceleration = [0, -0.5]
[[obstacle]]
circle = { centre = [10, 10], radius = 2 }
[[obstacle]]
polyline = [[2, 5], [6, 4]]
temperature = 1
[run]
until = 20
samples = 40
[engine.ed]
contact_time = 1e-4
[engine.dsmc-enskog]
displacement = false
simulators_per_particle = 4
[measure.fields]
cells = [4, 5]
blocks = 10
windows = [[0, 4]]
"#;

/// Spheres that flow through a channel with regions of different weights.
pub const CHANNEL: &str = r#"# Do a few spheres flow?
format = 2
title = "a test of a channel"
replicas = 2
[gas]
dimension = 3
number = 2000
temperature = 0.5
restitution = 0.6
tangential_restitution = 0
mean_free_path = 1
[box]
size = [8, 4, 0.5]
[walls]
left = "open"
right = "open"
bottom = { restitution = 0.8, slip = 0 }
top = { restitution = 0.8, slip = 0 }
[[inflow]]
face = "left"
velocity = [2, 0, 0]
[start]
velocity = [2, 0, 0]
[run]
until = 20
samples = 40
[engine.dsmc-boltzmann]
weights = { along = "x", factors = [1, 0.7] }
[measure.fields]
cells = [16, 8]
blocks = 10
"#;

/// Dense disks that flow in on one side: simulators become more while partners are sought around
/// points of contact.
pub const INFLOW: &str = r#"# Do dense disks flow in?
format = 2
title = "a test of an inflow"
replicas = 2
[gas]
number = 60
restitution = 0.9
[box]
size = [24, 12]
[walls]
left = "open"
right = "open"
bottom = "specular"
top = "specular"
[[inflow]]
face = "left"
velocity = [1.5, 0]
number_density = [0.4]
[start]
velocity = [1, 0]
[run]
until = 10
samples = 20
[engine.dsmc-contact-point]
simulators_per_particle = 3
[measure.fields]
cells = [6, 3]
blocks = 10
"#;

/// Elastic disks of which the fluctuations are measured.
pub const FLUCTUATIONS: &str = r#"# How does a small elastic gas fluctuate?
format = 2
title = "a small gas in equilibrium"
seed = 6
replicas = 2
[gas]
number = 100
restitution = 1
[box]
packing_fraction = 0.2
[run]
until = 12
checkpoint_seconds = 0.01
[engine.ed]
[engine.dsmc-boltzmann]
simulators_per_particle = 2
[measure.spectra]
times = [0, 6, 12]
largest_wave_number = 5
[measure.intermediate_scattering]
from = 2
[measure.velocity_distribution]
times = [1, 12]
bins = 20
[measure.transport]
lag = 2
points = 4
"#;

/// One small case of each kind, with its name.
pub const SMALL: [(&str, &str); 9] = [
    ("cooling", COOLING),
    ("driven-mixture", DRIVEN_MIXTURE),
    ("mixture", MIXTURE),
    ("clusters", CLUSTERS),
    ("walls", WALLS),
    ("channel", CHANNEL),
    ("inflow", INFLOW),
    ("fluctuations", FLUCTUATIONS),
    ("langevin", LANGEVIN),
];

/// Settings that make each bundled case run in moments, with spaces between.
#[rustfmt::skip]
pub const SHRUNKEN: &[(&str, &str)] = &[
    ("aggregation", "gas.volume=1e5 run.until=100 measure.clusters.times=[10,100]"),
    ("aggregation-fragmentation", "gas.volume=1e5 run.until=50 measure.clusters.steady_from=20 measure.clusters.times=[10,50]"),
    ("binary-disks", "gas.number=60 run.until=1 engine.dsmc-contact-point.simulators_per_particle=4"),
    ("bodrova-2024-fig1", "gas.volume=5e3 verdict.sonine_orders=1 run.until=10"),
    ("bodrova-2024-fig2", "gas.volume=1e4 species.1.number=1000 species.2.number=50 verdict.sonine_orders=1 run.until=10"),
    ("bodrova-2024-fig3", "gas.volume=5e3 verdict.sonine_orders=1 run.until=10"),
    ("bodrova-2024-fig4", "gas.volume=1e4 power_law.monomers=1000 verdict.sonine_orders=1 run.until=10"),
    ("bodrova-2024-fig5", "gas.volume=5e3 species.2.number=50 verdict.sonine_orders=1 run.until=10 measure.time_averaged_displacement.particles=10"),
    ("bodrova-2024-fig6", "gas.volume=1e4 power_law.monomers=1000 verdict.sonine_orders=1 run.until=10"),
    ("bodrova-2024-fig7", "gas.volume=5e3 verdict.sonine_orders=1 run.until=10"),
    ("bodrova-2024-fig8", "gas.volume=5e3 verdict.sonine_orders=1 run.until=10"),
    ("bodrova-2024-table1", "gas.volume=1e4 power_law.monomers=1000 verdict.sonine_orders=1 run.until=10"),
    ("broken-chaos", "gas.number=100 run.until=1 engine.dsmc-contact-point.simulators_per_particle=4"),
    ("channel-disks", "gas.number=100 box.size=[20,20] run.until=5 run.samples=20 measure.fields.blocks=10"),
    ("contact-time", "replicas=2 gas.number=100 run.until=1 run.samples_per_decade=12 engine.ed.contact_time=1e-3 measure.impact_parameters.windows=[[0,1]] measure.contacts.windows=[[0,1]]"),
    ("contact-value", "replicas=2 gas.number=100 box.packing_fraction=0.25 measure.pair_correlation.times=[0.3,1]"),
    ("delta-model", "replicas=2 gas.number=100 run.until=4 measure.stress.blocks=4 measure.stress.looks=3"),
    ("dense-240", "start.equilibration=1 run.until=0.5"),
    ("density-ladder", "replicas=2 box.width_over_critical_length=0.8 box.packing_fraction=0.25 engine.dsmc-contact-point.simulators_per_particle=1 run.until=0.5"),
    ("driven", "gas.number=100 run.until=1"),
    ("elastic", "gas.number=100 run.until=1 engine.dsmc-boltzmann.simulators_per_particle=2 engine.dsmc-enskog.simulators_per_particle=2"),
    ("flow-past-disk", "gas.number=400 run.until=2 run.samples=20 measure.fields.blocks=10"),
    ("haff-3d", "species.1.number=500 gas.volume=5e3 verdict.sonine_orders=1 run.until=2"),
    ("kawasaki-1985-channel-gas", FLOW),
    ("kawasaki-1985-channel-granular", FLOW),
    ("kawasaki-1985-channel-gravity", FLOW),
    ("kawasaki-1985-channel-intermediate", FLOW),
    ("kawasaki-1985-sedimentation-1", FLOW),
    ("kawasaki-1985-sedimentation-2", TWO),
    ("kawasaki-1985-sedimentation-3", TWO),
    ("kawasaki-1985-sedimentation-4", TWO),
    ("kawasaki-1985-spin", FLOW),
    ("langevin-bath", "gas.number=100 run.until=10 measure.spectra.largest_wave_number=4"),
    ("li-2022", "replicas=2 start.equilibration=1 run.until=2 measure.stress.blocks=4 measure.stress.looks=3"),
    ("luding-1998", "gas.number=100 run.until=1 engine.dsmc-free-volume.simulators_per_particle=2 engine.dsmc-enskog.simulators_per_particle=2"),
    ("luding-1998-fig3b", "replicas=2 start.equilibration=1 run.until=0.5"),
    ("luding-1998-unbiased", "gas.number=100 run.until=1"),
    ("luding-1998-wide-cells", "gas.number=100 run.until=1"),
    ("map-boxes", "replicas=2 gas.restitution=0.8 box.packing_fraction=0.1 run.until=0.5 measure.impact_parameters.windows=[[0,0.5]]"),
    ("map-delta", "replicas=2 gas.number=100 gas.restitution={coefficient=0.9,delta=0.11} box.packing_fraction=0.1 run.until=4"),
    ("map-onset", "replicas=2 gas.number=100 gas.restitution=0.8 box.packing_fraction=0.1 run.until=0.2 measure.impact_parameters.windows=[[0,0.2]]"),
    ("map-quick", "replicas=2 box.width_over_critical_length=0.57 gas.restitution=0.8 box.packing_fraction=0.1 run.until=0.5 measure.impact_parameters.windows=[[0,0.5]]"),
    ("map-shear", "replicas=2 gas.number=100 gas.restitution=0.8 box.packing_fraction=0.2 box.shear_rate=0.5 run.until=4 measure.stress.from=2 measure.stress.blocks=4 measure.stress.looks=3 measure.impact_parameters.windows=[[2,4]]"),
    ("map-shear-enskog", "gas.restitution=0.8 box.packing_fraction=0.2 box.shear_rate=0.5 run.until=4 engine.dsmc-enskog.simulators_per_particle=16 measure.stress.from=2 measure.stress.blocks=4 measure.stress.looks=3 measure.impact_parameters.windows=[[2,4]]"),
    ("map-uniform", "replicas=2 box.width_over_critical_length=0.57 gas.restitution=0.8 box.packing_fraction=0.1 run.until=0.5 measure.impact_parameters.windows=[[0,0.5]]"),
    ("map-waves", "replicas=2 gas.number=100 gas.restitution=0.8 box.packing_fraction=0.1 run.until=0.5"),
    ("map-white-noise", "replicas=2 gas.number=100 gas.restitution=0.8 thermostat.heating=0.18 box.packing_fraction=0.1 run.until=4 measure.impact_parameters.windows=[[0,4]]"),
    ("mixture-cooling", "gas.volume=5e3 power_law.monomers=500 verdict.sonine_orders=1 run.until=10"),
    ("mpemba", "replicas=2 gas.number=100 run.until=10 engine.dsmc-boltzmann.simulators_per_particle=2"),
    ("quick", "gas.number=100 run.until=1 engine.dsmc-free-volume.simulators_per_particle=2"),
    ("rough-disks", "gas.number=50 box.size=[60,60] run.until=5 run.samples=12"),
    ("scaled-cooling", "replicas=2 gas.restitution=0.9 box.packing_fraction=0.1 run.until=1 measure.spectra.interval=0.1 measure.displacement.from=0.5"),
    ("sedimentation-disks", "gas.number=50 box.size=[30,30] run.until=10 run.samples=20 measure.fields.blocks=10"),
    ("short-range-correlation", "replicas=2 run.samples_per_decade=12 gas.number=100 run.until=1 measure.contacts.windows=[[0,1]]"),
    ("short-range-correlation-1998", "run.samples_per_decade=12 gas.number=100 run.until=1 measure.contacts.windows=[[0,1]]"),
    ("transport", "replicas=2 gas.number=60 run.until=20 measure.transport.lag=4"),
    ("uniform-shear", "replicas=2 gas.number=100 run.until=4 measure.stress.blocks=4 measure.stress.looks=3 measure.impact_parameters.windows=[[2,4]]"),
    ("vibrated-box", "gas.number=30 run.until=2 run.samples=20 measure.fields.blocks=10"),
    ("weak-dissipation", "gas.number=100 run.until=1 engine.dsmc-boltzmann.simulators_per_particle=2"),
];

const FLOW: &str = "gas.number=400 run.until=3 run.samples=20 measure.fields.blocks=10";
const TWO: &str =
    "species.1.number=200 species.2.number=200 run.until=3 run.samples=20 measure.fields.blocks=10";

/// Returns the path of a bundled case.
pub fn bundled(name: &str) -> PathBuf {
    Path::new(CASES).join(format!("{name}.toml"))
}

/// Returns the names of all bundled cases.
pub fn bundled_names() -> Vec<String> {
    let entries = fs::read_dir(CASES).expect("the folder of cases");
    let name = |path: PathBuf| {
        let stem = path.file_stem().filter(|_| path.is_file());
        stem.map(|stem| stem.to_string_lossy().into_owned())
    };
    let mut names: Vec<String> = entries
        .filter_map(|entry| name(entry.expect("a case").path()))
        .collect();
    names.sort();
    names
}

/// Folder with the case `case.toml`, in which the program is run.
pub struct TestFolder(TempDir);

/// Output of the program.
pub struct CommandOutput {
    /// Exit code; `None` after a signal.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl TestFolder {
    /// Creates a folder with a case.
    pub fn new(case: &str) -> Self {
        let work = Self(tempfile::tempdir().expect("a folder"));
        work.write("case.toml", case);
        work
    }

    /// Returns a path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).expect("a file is written");
    }

    /// Reads the text of a file.
    pub fn text(&self, name: &str) -> String {
        let path = self.path(name);
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    /// Returns the command of the program, with arguments that have no spaces.
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stosszahl"));
        command
            .current_dir(self.0.path())
            .args(line.split_whitespace())
            .stdin(Stdio::null());
        command
    }

    /// Runs the program.
    pub fn say(&self, line: &str) -> CommandOutput {
        let output = self.command(line).output().expect("the program starts");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let said = CommandOutput {
            code: output.status.code(),
            out: text(&output.stdout),
            err: text(&output.stderr),
        };
        assert!(!said.err.contains("panicked"), "{line}: {}", said.err);
        said
    }

    /// Runs the program, which must succeed.
    pub fn done(&self, line: &str) -> CommandOutput {
        let said = self.say(line);
        assert_eq!(said.code, Some(0), "{line}: {}", said.err);
        said
    }

    /// Runs the program, which must refuse its input with these words, print nothing else and leave
    /// no results.
    pub fn refused(&self, line: &str, words: &[&str]) {
        let said = self.say(line);
        assert_eq!(said.code, Some(2), "{line}: {}", said.err);
        assert!(said.out.is_empty(), "{line}: {}", said.out);
        for word in words {
            assert!(
                said.err.contains(word),
                "{line}: no {word:?} in {}",
                said.err
            );
        }
    }
}

/// Returns names and bytes of all tables and snapshots of a results folder.
pub fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for folder in [folder.to_owned(), folder.join("snapshots")] {
        for entry in fs::read_dir(&folder).into_iter().flatten() {
            let path = entry.expect("an entry").path();
            if path
                .extension()
                .is_some_and(|end| end == "csv" || end == "xyz")
            {
                let name = path.file_name().expect("a name").to_string_lossy();
                found.insert(name.into_owned(), fs::read(&path).expect("bytes"));
            }
        }
    }
    found
}

/// Checks that two results folders hold the same tables and snapshots, byte for byte.
pub fn assert_same(a: &Path, b: &Path) {
    let (first, second) = (files(a), files(b));
    assert!(!first.is_empty(), "{}", a.display());
    let names = |all: &BTreeMap<String, Vec<u8>>| all.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&first), names(&second));
    for (name, bytes) in &first {
        let (a, b) = (a.display(), b.display());
        assert!(bytes == &second[name], "{name} differs between {a} and {b}");
    }
}

/// Reads a finished run as it is stored, and checks that checksums hold and tables are those of the
/// manifest.
pub fn stored(folder: &Path) -> Stored {
    let stored = Stored::read(folder).unwrap_or_else(|error| panic!("{error}"));
    let stored = stored.unwrap_or_else(|| panic!("no results in {}", folder.display()));
    assert!(stored.changed.is_empty(), "{:?}", stored.changed);
    stored
}

/// Reads the manifest of a finished run.
pub fn manifest(folder: &Path) -> Manifest {
    stored(folder).manifest
}

/// Table by its columns.
pub struct Columns(BTreeMap<String, Vec<String>>);

impl Columns {
    /// Reads a table of a results folder.
    pub fn read(folder: &Path, name: &str) -> Self {
        let path = folder.join(format!("{name}.csv"));
        let reader = csv::Reader::from_path(&path);
        let mut reader = reader.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let headers = reader.headers().expect("a header").clone();
        let mut columns: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for record in reader.records() {
            for (name, cell) in headers.iter().zip(&record.expect("a row")) {
                let column = columns.entry(name.to_owned()).or_default();
                column.push(cell.to_owned());
            }
        }
        Self(columns)
    }

    /// Returns the cells of a column.
    pub fn texts(&self, column: &str) -> &[String] {
        let found = self.0.get(column);
        found.unwrap_or_else(|| panic!("no column {column} in {:?}", self.0.keys()))
    }

    /// Returns the numbers of a column; NaN where a cell is empty.
    pub fn numbers(&self, column: &str) -> Vec<f64> {
        let number = |cell: &String| match cell.as_str() {
            "" => f64::NAN,
            cell => cell.parse().expect("a number"),
        };
        self.texts(column).iter().map(number).collect()
    }
}

/// Returns the format of cases with all measures, made once.
pub fn format() -> &'static Format {
    static FORMAT: OnceLock<Format> = OnceLock::new();
    FORMAT.get_or_init(study::format)
}

/// Reads a case through the library, with settings from outside.
pub fn overridden(path: &Path, text: &str, set: &[&str]) -> CaseFile {
    let set: Vec<String> = set.iter().map(|&one| one.to_owned()).collect();
    let file = format().from_text(path, text, &set);
    file.unwrap_or_else(|error| panic!("{error}"))
}

/// Plans the first point of a case.
pub fn plan(text: &str, set: &[&str]) -> CasePlan {
    let file = overridden(Path::new("case.toml"), text, set);
    let plan = CasePlan::new(&file.points[0].case, Path::new(""));
    plan.unwrap_or_else(|error| panic!("{error}"))
}
