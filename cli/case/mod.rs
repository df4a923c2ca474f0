//! Case files: one TOML file says which gas is run, from which start, by which engines, and what is measured.
//!
//! A case is read in four steps. The text becomes a table in which every key knows its line; overrides from
//! the command line and the values of a sweep are written into it; the table is checked against the JSON
//! [`schema`], which holds types, ranges and sentences; and relations between keys are checked while the
//! table becomes a [`Case`]. Every error names the file, the line, the key, the value found and what is allowed.
//!
//! A typed reader with spans on each field was not taken. Its errors know the line of a bad type, but not of a
//! bad combination, of an override or of a swept value; and it would state the ranges a second time.
//!
//! ```
//! use std::path::Path;
//! use stosszahl::case::{Case, CaseFile};
//!
//! let text = r#"
//! format = 1
//! title = "Homogeneous cooling"
//! [gas]
//! disks = 100
//! packing_fraction = 0.1
//! restitution = 0.9
//! [run]
//! until = 10
//! [engine.ed]
//! [[sweep]]
//! "gas.restitution" = [0.8, 0.9]
//! "#;
//! let file = CaseFile::<Case>::from_text(Path::new("cooling.toml"), text, &["replicas=8".to_owned()])?;
//! assert_eq!(file.points.len(), 2);
//! assert_eq!(file.points[0].name, "restitution=0.8");
//! assert_eq!(file.points[0].case.replicas, 8);
//! # Ok::<(), stosszahl::case::CaseError>(())
//! ```

mod error;
mod kind;
mod locate;
mod monte_carlo;
mod nearest;
mod overrides;
mod schema;
mod sweep;
pub(crate) mod typed;
mod validate;
mod warning;
mod written;

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Serialize;

pub use error::{CaseError, Place, Problem};
pub use kind::{Form, Kind};
pub use locate::{KeyPath, Step};
pub use monte_carlo::{Copies, Displacement, Dsmc, Neighbourhood, Scheme};
pub use schema::{Schema, schema};
pub use warning::Warning;
pub use written::{Assignment, Boundary, Units};

/// The format of case files that this version reads.
const FORMAT: i64 = 1;

/// Most bytes of a case file.
const MOST_BYTES: u64 = 1 << 20;

/// A case file as read: its text, and the points that it means.
#[derive(Clone, Debug)]
pub struct CaseFile<C = Case> {
    /// The text of the file, byte for byte.
    pub source_text: String,
    /// The file.
    pub path: PathBuf,
    /// The points of the sweeps, each different from the others; one point without settings if there is no
    /// sweep.
    pub points: Vec<Point<C>>,
}

/// One point of a sweep.
#[derive(Clone, Debug, Serialize)]
pub struct Point<C = Case> {
    /// A name that is safe for a folder, such as `packing_fraction=0.25,restitution=1`; empty without settings.
    pub name: String,
    /// What the sweep sets here.
    pub settings: Vec<Setting>,
    /// The case at this point.
    pub case: C,
}

/// A value that a sweep gives to a key.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// The dotted key.
    pub key: String,
    /// The value as written.
    pub value: toml::Value,
}

/// A valid case. Times are in units of `t0`: Haff's time of the start, or the mean free time of an elastic gas.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// What the case shows, in one line.
    pub title: String,
    /// Units of lengths, masses and energies.
    pub units: Units,
    /// Seed of every random stream.
    pub seed: u64,
    /// Number of independent runs, at least 1.
    pub replicas: usize,
    /// The disks.
    pub gas: Gas,
    /// The box.
    pub domain: Domain,
    /// The initial state.
    pub start: Start,
    /// How long to run and when to sample.
    pub run: Run,
    /// What keeps the gas in motion; none leaves it to cool freely.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drive: Option<Drive>,
    /// The engines to run, at least one and each at most once, in the order ed, dsmc-boltzmann,
    /// dsmc-free-volume, dsmc-enskog, dsmc-esmc, dsmc-stochastic-disks, dsmc-contact-point.
    pub engines: Vec<Engine>,
    /// What is measured.
    pub measure: Measure,
    /// How the engines are compared.
    pub verdict: Verdict,
    /// Largest error that the resolution of the Monte Carlo engines may make, a share; none leaves it to the case.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<f64>,
}

/// The disks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gas {
    /// Normal restitution.
    pub restitution: Restitution,
    /// Diameter \[length: reduced, or m\], above 0.
    pub diameter: f64,
    /// Mass \[reduced, or kg\], above 0.
    pub mass: f64,
    /// Species of unlike disks; empty where all are alike or a start file says their sizes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub species: Vec<GasSpecies>,
}

/// One species of disks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GasSpecies {
    /// Share of the disks, above 0; all shares together are 1.
    pub share: f64,
    /// Diameter \[length: reduced, or m\], above 0.
    pub diameter: f64,
    /// Mass \[reduced, or kg\], above 0.
    pub mass: f64,
}

/// Normal restitution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Restitution {
    /// The same at every approach speed, from 0 to 1; 1 is elastic.
    Constant(f64),
    /// Falling with the approach speed.
    Viscoelastic {
        /// Strength `(A kappa^(2/5))^(1/2)`, above 0, with speeds in units of the thermal speed `sqrt(T/m)` of
        /// the start.
        dissipation: f64,
    },
}

impl Restitution {
    /// Whether no energy is lost.
    pub fn is_elastic(&self) -> bool {
        *self == Self::Constant(1.0)
    }
}

/// The box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Domain {
    /// Height over width, `Ly/Lx`, above 0.
    pub aspect_ratio: f64,
    /// What happens at the edges.
    pub boundary: Boundary,
}

/// The initial state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Start {
    /// Where the disks are.
    pub bodies: Bodies,
    /// How fast they are.
    pub velocities: Velocities,
    /// Length of the elastic equilibration before `t = 0`, at least 0; 0 is none.
    pub collisions_per_particle: f64,
    /// Where to give up equilibrating, at least `collisions_per_particle`.
    pub most_collisions_per_particle: f64,
}

/// Where the disks are at the start, how many there are and how dense.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bodies {
    /// At random, without overlap.
    Disordered {
        /// Number of disks, at least 2.
        disks: usize,
        /// Covered fraction of the area, above 0 and at most 0.9069.
        packing_fraction: f64,
    },
    /// On a square lattice.
    Square {
        /// Number of disks, at least 2.
        disks: usize,
        /// Covered fraction of the area, above 0 and at most 0.7854.
        packing_fraction: f64,
    },
    /// On a hexagonal lattice.
    Hexagonal {
        /// Number of disks, at least 2.
        disks: usize,
        /// Covered fraction of the area, above 0 and at most 0.9069.
        packing_fraction: f64,
    },
    /// As in a file, which says also how many and how dense.
    File(StartFile),
}

/// A file with an initial state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StartFile {
    /// As written in the case.
    pub written: String,
    /// Its format, from its ending.
    pub kind: StartFileKind,
    /// The file, found from the folder of the case file. It is left out of the serialised case, which does not
    /// depend on where the program was started.
    #[serde(skip)]
    pub path: PathBuf,
}

/// Format of a start file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StartFileKind {
    /// `.csv`
    Csv,
    /// `.xyz`
    ExtendedXyz,
}

/// The velocities at the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Velocities {
    /// Drawn from a Maxwell distribution.
    Maxwellian {
        /// Granular temperature `T = m <v^2>/2` \[energy: reduced, or J\], above 0.
        temperature: f64,
    },
    /// As in the start file, which says also how hot the gas is.
    File,
}

/// How long to run and when to sample. Times in units of `t0`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Run {
    /// End of the run, above 0.
    pub until: f64,
    /// First sample after the start, above 0 and below `until`.
    pub first_sample: f64,
    /// Samples in each factor of ten of time, at least 1.
    pub samples_per_decade: usize,
    /// Seconds of computing between two checkpoints, above 0.
    pub checkpoint_seconds: f64,
}

/// Random kicks that keep the gas in motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Drive {
    /// Energy that each disk gains on average, in temperatures of the start per `t0`, above 0.
    pub heating: f64,
    /// Time between two kicks in units of `t0`, above 0 and below `run.until`.
    pub interval: f64,
}

/// An engine to run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Engine {
    /// Exact event-driven hard disks.
    Ed(EventDriven),
    /// Monte Carlo collisions in cells.
    Dsmc(Dsmc),
}

impl Engine {
    /// Name in case files and results: `ed`, or that of a Monte Carlo [`Scheme`].
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ed(_) => "ed",
            Self::Dsmc(dsmc) => dsmc.scheme.name(),
        }
    }
}

/// Exact event-driven hard disks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EventDriven {
    /// Contact time of the TC model in units of `t0`, at least 0; 0 is off.
    pub contact_time: f64,
    /// Most collisions of one run, at least 1.
    pub collision_limit: Option<u64>,
}

/// What is measured besides the energy and the collision rate. Times in units of `t0`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measure {
    /// Start and end of each window of impact parameters, `0 <= start < end <= until`, at least one.
    pub impact_windows: Vec<[f64; 2]>,
    /// Bins of the impact parameter, 2 to 1000.
    pub impact_bins: usize,
    /// The structure factor.
    pub structure: Structure,
    /// Largest distance of the pair correlation in diameters, above 1.
    pub pair_correlation_range: f64,
    /// When all positions and velocities are written, from 0 to `until`, rising; may be empty.
    pub snapshot_times: Vec<f64>,
    /// From when on displacements are measured, from 0 to below `until - first_sample`; none leaves them out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_start: Option<f64>,
}

/// The structure factor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Structure {
    /// When it is measured, and the pair correlation with it: from 0 to `until`, rising; may be empty.
    pub times: Vec<f64>,
    /// How a disk is shared among the points of the grid.
    pub assignment: Assignment,
    /// Whether the shape of the assignment is divided out.
    pub correction: bool,
    /// Largest tabulated `k = L/wavelength`, 1 to 2048.
    pub largest_wave_number: usize,
}

/// How the engines are compared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Chance of any false alarm in one comparison, all times together, above 0 and below 0.5.
    pub false_alarm: f64,
}

impl Case {
    /// Reads a case file, with overrides `key=value` as given to `--set`.
    ///
    /// The value of an override is TOML, or a bare word taken as text. A key that is overridden is no longer
    /// swept.
    ///
    /// # Errors
    /// A file that cannot be read, is not UTF-8 or not TOML; a key that is unknown or missing; a value that is not
    /// allowed, alone or beside another; an override that is not `key=value`.
    pub fn read(path: impl AsRef<Path>, overrides: &[String]) -> Result<CaseFile, CaseError> {
        CaseFile::read(path.as_ref(), overrides)
    }

    /// Times of the samples in units of `t0`: 0, then a logarithmic grid from the first sample on, and last the
    /// end of the run exactly.
    ///
    /// A point of the grid that all but coincides with the end is left out.
    pub fn sample_times(&self) -> Vec<f64> {
        std::iter::once(0.0)
            .chain(self.grid(self.run.until))
            .collect()
    }

    /// Times in units of `t0` at which displacements are measured, with the time that has passed since their start: a
    /// logarithmic grid as that of the samples, and last the end of the run exactly; empty unless they are measured.
    pub fn displacement_times(&self) -> Vec<(f64, f64)> {
        let Some(start) = self.measure.displacement_start else {
            return Vec::new();
        };
        let until = self.run.until;
        // Late starts may leave no room between two times of the grid.
        let mut times: Vec<(f64, f64)> = self
            .grid(until - start)
            .map(|elapsed| (start + elapsed, elapsed))
            .filter(|&(time, _)| start < time && time < until)
            .chain([(until, until - start)])
            .collect();
        times.dedup_by_key(|moment| moment.0);
        times
    }

    /// A logarithmic grid from the first sample on, and last the end exactly.
    fn grid(&self, until: f64) -> impl Iterator<Item = f64> {
        let Run {
            first_sample,
            samples_per_decade,
            ..
        } = self.run;
        (0..)
            .map(move |i| first_sample * 10_f64.powf(f64::from(i) / samples_per_decade as f64))
            .take_while(move |&time| time < until * (1.0 - 1e-9))
            .chain(std::iter::once(until))
    }

    /// What is allowed but deserves a second look.
    pub fn warnings(&self) -> Vec<Warning> {
        warning::of(self)
    }

    /// Number of disks, unless a start file says it.
    pub fn disks(&self) -> Option<usize> {
        match self.start.bodies {
            Bodies::Disordered { disks, .. }
            | Bodies::Square { disks, .. }
            | Bodies::Hexagonal { disks, .. } => Some(disks),
            Bodies::File(_) => None,
        }
    }

    /// Packing fraction, unless a start file says it.
    pub fn packing_fraction(&self) -> Option<f64> {
        match self.start.bodies {
            Bodies::Disordered {
                packing_fraction, ..
            }
            | Bodies::Square {
                packing_fraction, ..
            }
            | Bodies::Hexagonal {
                packing_fraction, ..
            } => Some(packing_fraction),
            Bodies::File(_) => None,
        }
    }

    /// Granular temperature at the start \[energy\], unless a start file says it.
    pub fn temperature(&self) -> Option<f64> {
        match self.start.velocities {
            Velocities::Maxwellian { temperature } => Some(temperature),
            Velocities::File => None,
        }
    }
}

impl Form for Case {
    const KIND: Kind = Kind::Paired;

    fn schema() -> &'static Schema {
        schema::shared()
    }

    fn from_table(table: &toml::Table, folder: &Path) -> Result<Self, Problem> {
        validate::case(table, folder)
    }

    fn shortened(path: &Path, until: f64) -> Vec<String> {
        overrides::shortened(path, until)
    }
}

impl<C: Form> CaseFile<C> {
    /// Reads a case file, with overrides `key=value` as given to `--set`.
    ///
    /// # Errors
    /// As [`Case::read`], and a case of another kind.
    pub fn read(path: &Path, overrides: &[String]) -> Result<Self, CaseError> {
        Self::from_text(path, &read_text(path)?, overrides)
    }

    /// Reads the text of a case; `path` stands in messages, and files are looked for beside it.
    ///
    /// # Errors
    /// As [`CaseFile::read`], but for the file itself.
    pub fn from_text(path: &Path, text: &str, overrides: &[String]) -> Result<Self, CaseError> {
        let mut places = locate::Places::new(path, text);
        let mut table = places.parse()?;
        check_format(&table)
            .and_then(|()| C::KIND.expect(&table))
            .map_err(|problem| problem.locate(&places))?;
        let overrides = overrides
            .iter()
            .map(|one| overrides::Override::read(one))
            .collect::<Result<Vec<_>, _>>()?;
        let points = sweep::expand(C::schema(), &mut table, &overrides)
            .map_err(|problem| problem.locate(&places))?;
        for one in &overrides {
            overrides::set(&mut table, &one.keys, one.value.clone());
            places.set_override(&one.path(), &one.argument);
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut names = sweep::Names::new(&points);
        let mut seen = BTreeSet::new();
        let mut read = Vec::new();
        for settings in points {
            let (mut table, mut places) = (table.clone(), places.clone());
            for one in &settings {
                overrides::set(&mut table, &one.keys, one.value.clone());
                places.set_as(&KeyPath::from_keys(&one.keys), &one.source);
            }
            let case = C::from_table(&table, folder).map_err(|problem| problem.locate(&places))?;
            if seen.insert(format!("{case:?}")) {
                let name = names.name(&settings);
                let settings = settings
                    .into_iter()
                    .map(|one| Setting {
                        key: one.key,
                        value: one.value,
                    })
                    .collect();
                read.push(Point {
                    name,
                    settings,
                    case,
                });
            }
        }
        Ok(Self {
            source_text: text.to_owned(),
            path: path.to_owned(),
            points: read,
        })
    }
}

/// Refuses another format before any of its keys is looked at.
fn check_format(table: &toml::Table) -> Result<(), error::Problem> {
    let key = KeyPath::of("format");
    match table.get("format") {
        Some(toml::Value::Integer(FORMAT)) => Ok(()),
        Some(value) => Err(error::Problem::Format {
            found: schema::written(value),
        }),
        None => Err(error::Problem::Missing {
            key,
            allowed: schema::sentence("format"),
        }),
    }
}

/// The text of a file.
fn read_text(path: &Path) -> Result<String, CaseError> {
    let unreadable = |source| CaseError::Unreadable {
        path: path.to_owned(),
        source,
    };
    if std::fs::metadata(path).map_err(unreadable)?.is_dir() {
        return Err(CaseError::Directory {
            path: path.to_owned(),
        });
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    file.take(MOST_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(CaseError::TooLarge {
            path: path.to_owned(),
            limit: MOST_BYTES,
        });
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let bytes = error.as_bytes();
        let line = bytes[..at].split(|&byte| byte == b'\n').count();
        CaseError::NotUtf8 {
            path: path.to_owned(),
            line,
            byte: bytes[at],
        }
    })
}
