//! From a valid case to numbers: units, box, sizes, and what theory expects of the run.

mod monte_carlo;
mod species;

use nalgebra::{Vector2, vector};
use stosszahl_analysis::structure_factor::{self, StructureFactorPlan};
use stosszahl_model::initial::{self, Arrangement, FileError, Overlap, PlacementError};
use stosszahl_model::random::Streams;
use stosszahl_model::{
    Constant, Domain, Plane, Polydisperse, Restitution as _, Sizes, Viscoelastic, kinetic,
};

use crate::case::{Assignment, Bodies, Case, Engine, Restitution, Scheme, Velocities};

pub use species::DiskSpecies;

/// Deepest overlap of a start that counts as rounding, over the mean diameter.
const OVERLAP_TOLERANCE: f64 = 1e-9;

/// What one reduced unit is in the units of the case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Mean diameter.
    pub length: f64,
    /// Mean mass.
    pub mass: f64,
    /// Temperature of the start.
    pub energy: f64,
}

impl Scale {
    /// Time unit d sqrt(m/T).
    pub fn time(&self) -> f64 {
        self.length / self.speed()
    }

    /// Thermal speed sqrt(T/m).
    pub fn speed(&self) -> f64 {
        (self.energy / self.mass).sqrt()
    }
}

/// What the unit of time `t_0` is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeUnit {
    /// Haff's time of the start.
    Haff,
    /// The mean free time, where nothing is lost.
    MeanFreeTime,
}

impl TimeUnit {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Haff => "haff",
            Self::MeanFreeTime => "mean free time",
        }
    }
}

/// Why a valid case cannot be started.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SetupError {
    /// The start file is unreadable or damaged.
    #[error(transparent)]
    File(#[from] FileError),
    /// Disks of the start overlap.
    #[error(
        "{file}: disks {} and {} (counted from 0) overlap by {depth}; allowed are touching disks", pair[0], pair[1]
    )]
    Overlap {
        /// The start file, as written in the case.
        file: String,
        /// The pair.
        pair: [usize; 2],
        /// Depth in the units of the file.
        depth: f64,
    },
    /// The start file lacks something that the case asks of it, or has too much of it.
    #[error("{file}: {found}; expected {expected}")]
    Content {
        /// The start file, as written in the case.
        file: String,
        /// What was found.
        found: String,
        /// What belongs there.
        expected: String,
    },
    /// The lattice does not fit.
    #[error("start.placement: {0}")]
    Placement(#[from] PlacementError),
    /// S(k) cannot be measured as asked.
    #[error("measure.largest_wave_number: {0}; shorten it, or leave measure.structure_times empty")]
    Structure(#[source] stosszahl_analysis::Error),
    /// The box is narrower than a disk.
    #[error("gas.disks and gas.packing_fraction give a box of {:.4} x {:.4} diameters; both sides must be longer than one disk is wide", lengths[0], lengths[1])]
    BoxTooSmall {
        /// Sides in diameters.
        lengths: [f64; 2],
    },
}

/// Positions and velocities of a start file, in reduced units.
#[derive(Clone, Debug, PartialEq)]
pub struct FileStart {
    /// Centres.
    pub positions: Vec<Vector2<f64>>,
    /// Velocities, where the case asks for those of the file.
    pub velocities: Option<Vec<Vector2<f64>>>,
    /// Whether the file has velocities that the case does not ask for.
    pub unused_velocities: bool,
}

/// The normal contact law, in reduced units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// One coefficient.
    Constant(Constant),
    /// Falling with the approach speed.
    Viscoelastic(Viscoelastic),
}

impl Law {
    fn new(restitution: Restitution) -> Option<Self> {
        match restitution {
            Restitution::Constant(coefficient) => Constant::new(coefficient).map(Self::Constant),
            Restitution::Viscoelastic { dissipation } => {
                Viscoelastic::new(dissipation).map(Self::Viscoelastic)
            }
        }
    }

    /// The coefficient at the mean normal approach speed of colliding pairs, sqrt(pi T/m), of the start.
    fn coefficient(self) -> f64 {
        match self {
            Self::Constant(law) => law.coefficient(),
            Self::Viscoelastic(law) => law.normal(std::f64::consts::PI.sqrt()),
        }
    }
}

/// A temperature with which units can be made.
fn warm(temperature: f64) -> Option<f64> {
    (temperature.is_normal() && temperature < 1e200).then_some(temperature)
}

/// Takes the drift of the whole gas out of its velocities, which changes nothing in it, and returns the temperature
/// that is left.
fn remove_drift(velocities: &mut [Vector2<f64>], masses: &[f64]) -> f64 {
    let total: f64 = masses.iter().sum();
    let drift = velocities
        .iter()
        .zip(masses)
        .fold(Vector2::zeros(), |sum, (v, m)| sum + v * (m / total));
    let mut twice = 0.0;
    for (velocity, mass) in velocities.iter_mut().zip(masses) {
        *velocity -= drift;
        twice += mass * velocity.norm_squared();
    }
    0.5 * twice / velocities.len() as f64
}

/// How S(k) is measured, in reduced units.
pub fn structure_options(case: &Case) -> structure_factor::Options {
    let structure = &case.measure.structure;
    structure_factor::Options {
        largest_wave_number: structure.largest_wave_number,
        assignment: match structure.assignment {
            Assignment::NearestGridPoint => structure_factor::Assignment::NearestGridPoint,
            Assignment::CloudInCell => structure_factor::Assignment::CloudInCell,
        },
        correction: structure.correction,
        diameter: 1.0,
    }
}

/// A case in reduced units, in which the mean diameter, the mean mass and the initial temperature are one.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The case.
    pub case: Case,
    /// Reduced units in those of the case.
    pub scale: Scale,
    /// Number of disks.
    pub disks: usize,
    /// Share of the box that they cover.
    pub packing_fraction: f64,
    /// The box.
    pub domain: Domain<Plane>,
    /// Radius and mass of each disk, where they are unlike.
    pub sizes: Option<Polydisperse>,
    /// Species of unlike disks, one after the other; empty where the case has none.
    pub species: Vec<DiskSpecies>,
    /// What a start file says.
    pub file: Option<FileStart>,
    /// The normal contact law.
    pub law: Law,
    /// Coefficient of restitution: the constant one, or that at the mean approach speed of the start.
    pub restitution: f64,
    /// Enskog's contact value at the mean density.
    pub contact_value: f64,
    /// `t_0`.
    pub time: f64,
    /// What `t_0` is.
    pub time_unit: TimeUnit,
    /// What the program chose of the resolution, and why, in sentences; empty unless the case asks for an accuracy.
    pub choices: Vec<String>,
}

impl Setup {
    /// Reads the start file if there is one, and derives everything.
    ///
    /// # Errors
    /// [`SetupError`] if the start file or the box cannot be used.
    pub fn new(case: &Case) -> Result<Self, SetupError> {
        let (disks, packing_fraction, arrangement) = match case.start.bodies {
            Bodies::File(ref file) => return Self::from_file(case, file),
            Bodies::Disordered {
                disks,
                packing_fraction,
            } => (disks, packing_fraction, Arrangement::Disordered),
            Bodies::Square {
                disks,
                packing_fraction,
            } => (disks, packing_fraction, Arrangement::Square),
            Bodies::Hexagonal {
                disks,
                packing_fraction,
            } => (disks, packing_fraction, Arrangement::Hexagonal),
        };
        if !case.gas.species.is_empty() {
            return species::setup(case, disks, packing_fraction);
        }
        // Velocities come from a file only with the bodies.
        let energy = case.temperature().unwrap_or(1.0);
        let scale = Scale {
            length: case.gas.diameter,
            mass: case.gas.mass,
            energy,
        };
        let area = disks as f64 * std::f64::consts::FRAC_PI_4 / packing_fraction;
        let width = (area / case.domain.aspect_ratio).sqrt();
        let setup = Self::assemble(
            case,
            scale,
            disks,
            [width, area / width],
            packing_fraction,
            None,
            None,
        )?;
        // Whether a lattice fits is known before anything is written.
        if arrangement != Arrangement::Disordered || packing_fraction > initial::SEQUENTIAL_LIMIT {
            initial::place(
                arrangement,
                disks,
                1.0,
                &setup.domain,
                &Streams::new(case.seed, 0),
            )?;
        }
        Ok(setup)
    }

    fn from_file(case: &Case, file: &crate::case::StartFile) -> Result<Self, SetupError> {
        let mut start = initial::read(&file.path)?;
        let content = |found: &str, expected: &str| SetupError::Content {
            file: file.written.clone(),
            found: found.into(),
            expected: expected.into(),
        };
        let count = start.positions.len();
        let radii = start
            .radii
            .unwrap_or_else(|| vec![0.5 * case.gas.diameter; count]);
        let masses = start.masses.unwrap_or_else(|| vec![case.gas.mass; count]);
        if count < 2 {
            return Err(content("one disk", "at least two"));
        }
        let domain = Domain::<Plane>::periodic(start.lengths.into())
            .ok_or_else(|| content("a box without area", "positive sides"))?;
        for position in &mut start.positions {
            *position = domain.wrap(*position);
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / count as f64;
        let length = 2.0 * mean(&radii);
        if let Some(Overlap { pair, depth }) = initial::first_overlap(
            &start.positions,
            |i| radii[i],
            &domain,
            OVERLAP_TOLERANCE * length,
        ) {
            return Err(SetupError::Overlap {
                file: file.written.clone(),
                pair,
                depth,
            });
        }
        let mass = mean(&masses);
        let energy = match (case.start.velocities, &mut start.velocities) {
            (Velocities::Maxwellian { temperature }, _) => temperature,
            (Velocities::File, None) => {
                return Err(content(
                    "no velocities",
                    "columns vx and vy (velo), or velocities = \"maxwellian\"",
                ));
            }
            (Velocities::File, Some(velocities)) => {
                let temperature = remove_drift(velocities, &masses);
                warm(temperature).ok_or_else(|| {
                    let found = format!("a granular temperature of {temperature}");
                    content(&found, "velocities that give one above zero")
                })?
            }
        };
        let scale = Scale {
            length,
            mass,
            energy,
        };
        let covered: f64 = radii.iter().map(|r| std::f64::consts::PI * r * r).sum();
        let packing = covered / domain.volume();
        let alike = |values: &[f64]| values.iter().all(|&value| value == values[0]);
        let pairs = || {
            radii
                .iter()
                .zip(&masses)
                .map(|(r, m)| (r / length, m / mass))
                .collect()
        };
        let sizes = if alike(&radii) && alike(&masses) {
            None
        } else {
            let sizes = Polydisperse::new(pairs());
            Some(sizes.ok_or_else(|| {
                content(
                    "radii or masses whose ratios are too large",
                    "ratios up to 1e300",
                )
            })?)
        };
        let lengths = start.lengths.map(|side| side / length);
        let positions = start.positions.iter().map(|x| x / length).collect();
        let unused_velocities =
            start.velocities.is_some() && case.start.velocities != Velocities::File;
        let velocities = match case.start.velocities {
            Velocities::Maxwellian { .. } => None,
            Velocities::File => start
                .velocities
                .map(|all| all.iter().map(|v| v / scale.speed()).collect()),
        };
        Self::assemble(
            case,
            scale,
            count,
            lengths,
            packing,
            sizes,
            Some(FileStart {
                positions,
                velocities,
                unused_velocities,
            }),
        )
    }

    fn assemble(
        case: &Case,
        scale: Scale,
        disks: usize,
        lengths: [f64; 2],
        packing_fraction: f64,
        sizes: Option<Polydisperse>,
        file: Option<FileStart>,
    ) -> Result<Self, SetupError> {
        let widest = sizes
            .as_ref()
            .map_or(1.0, |sizes| 2.0 * sizes.largest_radius());
        let domain = Domain::periodic(vector![lengths[0], lengths[1]])
            .filter(|_| lengths.iter().all(|&side| side > widest * (1.0 + 1e-9)))
            .ok_or(SetupError::BoxTooSmall { lengths })?;
        let law = Law::new(case.gas.restitution).ok_or_else(|| SetupError::Content {
            file: "gas.restitution".into(),
            found: format!("{:?}", case.gas.restitution),
            expected: "a coefficient from 0 to 1 or a positive strength".into(),
        })?;
        let restitution = law.coefficient();
        if !case.measure.structure.times.is_empty() {
            StructureFactorPlan::new(lengths, structure_options(case))
                .map_err(SetupError::Structure)?;
        }
        // A start beyond close packing is possible only for unlike disks.
        let contact_value =
            kinetic::contact_value(packing_fraction.min(0.999 * kinetic::CLOSE_PACKING));
        let (time, time_unit) = if restitution < 1.0 {
            (
                kinetic::haff_time(packing_fraction, restitution, contact_value),
                TimeUnit::Haff,
            )
        } else {
            (
                1.0 / kinetic::collision_rate(packing_fraction, contact_value, 0.0),
                TimeUnit::MeanFreeTime,
            )
        };
        let setup = Self {
            case: case.clone(),
            scale,
            disks,
            packing_fraction,
            domain,
            sizes,
            species: Vec::new(),
            file,
            law,
            restitution,
            contact_value,
            time,
            time_unit,
            choices: Vec::new(),
        };
        // Whether the drive has a meaning is known before anything is written.
        setup.drive()?;
        Ok(setup)
    }

    /// The arrangement to place; `None` with a start file.
    pub fn arrangement(&self) -> Option<Arrangement> {
        match self.case.start.bodies {
            Bodies::Disordered { .. } => Some(Arrangement::Disordered),
            Bodies::Square { .. } => Some(Arrangement::Square),
            Bodies::Hexagonal { .. } => Some(Arrangement::Hexagonal),
            Bodies::File(_) => None,
        }
    }

    /// Whether Enskog's theory with its Sonine correction applies: equal disks with one coefficient.
    pub fn has_theory(&self) -> bool {
        self.sizes.is_none() && matches!(self.case.gas.restitution, Restitution::Constant(_))
    }

    /// Fourth cumulant of the homogeneous cooling state, or of the steady state of a driven gas; 0 for an elastic gas.
    pub fn fourth_cumulant(&self) -> f64 {
        if self.case.drive.is_some() {
            kinetic::heated_fourth_cumulant(2, self.restitution)
        } else {
            kinetic::fourth_cumulant(2, self.restitution)
        }
    }

    /// Enskog's collision rate per particle, in units of sqrt(T/m)/d.
    pub fn collision_rate(&self) -> f64 {
        kinetic::collision_rate(
            self.packing_fraction,
            self.contact_value,
            self.fourth_cumulant(),
        )
    }

    /// Energy over that of the start at the time `time_over_t0`, by Haff's law; `None` where it does not apply, as for a
    /// driven gas.
    pub fn haff_ratio(&self, time_over_t0: f64) -> Option<f64> {
        let free = self.case.drive.is_none();
        (free && self.has_theory()).then(|| match self.time_unit {
            TimeUnit::Haff => kinetic::haff_law(time_over_t0, self.fourth_cumulant()),
            TimeUnit::MeanFreeTime => 1.0,
        })
    }

    /// Collisions per particle that theory expects up to a time.
    pub fn expected_collisions(&self, time_over_t0: f64) -> f64 {
        if let Some(drive) = self.case.drive {
            return self.driven_collisions(drive.heating, time_over_t0);
        }
        match self.time_unit {
            TimeUnit::Haff => kinetic::haff_collisions(2, self.restitution, time_over_t0),
            TimeUnit::MeanFreeTime => time_over_t0,
        }
    }

    /// What is allowed but deserves a second look, before the run.
    pub fn warnings(&self) -> Vec<String> {
        /// Below this many simulators per cell the scheme's own errors are larger than most of what is compared.
        const FEW: f64 = 5.0;
        /// Cells wider than this many mean free paths carry momentum too far.
        const WIDE: f64 = 2.0;
        let mut list: Vec<String> = self
            .case
            .warnings()
            .iter()
            .map(ToString::to_string)
            .collect();
        list.extend(self.driven_warnings());
        let path = kinetic::mean_free_path(self.packing_fraction, self.contact_value);
        for engine in &self.case.engines {
            let Engine::Dsmc(dsmc) = engine else { continue };
            let (name, side) = (engine.name(), self.cell_size(dsmc));
            let parameters = self.dsmc_parameters(dsmc);
            let simulators = self.simulators_per_cell(dsmc);
            if let Scheme::ContactPoint { .. } = dsmc.scheme {
                let wanted = stosszahl_dsmc::Parameters::strangers::<Plane>(
                    parameters.scheme,
                    self.packing_fraction,
                    1.0,
                    1,
                );
                if parameters.simulators_per_disk < wanted {
                    list.push(format!(
                        "{name}: {} simulators per disk, where {wanted} make the partners of a collision strangers; with fewer \
                         they meet again and lose less energy, as real disks do, so a difference to ED is a lower bound of \
                         broken chaos",
                        parameters.simulators_per_disk
                    ));
                }
                continue;
            }
            if !dsmc.scheme.within_cells() {
                continue;
            }
            if simulators < FEW {
                list.push(format!(
                    "{name}: {simulators:.2} simulators per cell, so its collision rate may be off by tens of per cent (see the \
                     rate in dissipation.csv) and its pairs meet again and again; a difference to ED is no statement about \
                     chaos by itself. More simulators_per_disk or a larger cell_size make it smaller"
                ));
            }
            if side[0] > WIDE * path {
                list.push(format!(
                    "{name}: cells are {:.1} mean free paths wide, so transport is overestimated, by an error that grows with \
                     the square of the width",
                    side[0] / path
                ));
            }
            if parameters.simulators_per_disk > 1 && self.file.is_some() {
                list.push(format!(
                    "{name}: several simulators per disk are copies of the start moved and turned at random, which blurs a \
                     pattern of density or flow in the start file"
                ));
            }
        }
        if self
            .file
            .as_ref()
            .is_some_and(|file| file.unused_velocities)
        {
            list.push(
                "the start file has velocities, which are not used: say start.velocities = \"file\" to use them".into(),
            );
        }
        list
    }

    /// Derived quantities by name: in diameters, thermal speeds and so on, unless the name says otherwise.
    pub fn derived(&self) -> Vec<(String, f64)> {
        let lengths = self.domain.lengths();
        let until = self.case.run.until;
        let path = kinetic::mean_free_path(self.packing_fraction, self.contact_value);
        let mut list = vec![
            ("particles".to_owned(), self.disks as f64),
            ("packing_fraction".to_owned(), self.packing_fraction),
            ("box_width_over_d".to_owned(), lengths[0]),
            ("box_height_over_d".to_owned(), lengths[1]),
            ("restitution".to_owned(), self.restitution),
            ("contact_value".to_owned(), self.contact_value),
            ("mean_free_path_over_d".to_owned(), path),
            (
                "collision_rate_per_particle".to_owned(),
                self.collision_rate() / self.scale.time(),
            ),
            ("t0".to_owned(), self.time * self.scale.time()),
            (
                "one_over_t0".to_owned(),
                1.0 / (self.time * self.scale.time()),
            ),
            (
                "structure_factor_at_zero_elastic".to_owned(),
                kinetic::structure_factor_at_zero(self.packing_fraction),
            ),
            (
                "expected_collisions_per_particle".to_owned(),
                self.expected_collisions(until),
            ),
            (
                "expected_pair_collisions_per_replica".to_owned(),
                0.5 * self.disks as f64 * self.expected_collisions(until),
            ),
        ];
        if self.has_theory() {
            list.push(("fourth_cumulant_theory".to_owned(), self.fourth_cumulant()));
        }
        list.extend(self.driven_quantities());
        for engine in &self.case.engines {
            if let Engine::Dsmc(dsmc) = engine {
                let side = self.cell_size(dsmc);
                let name = engine.name().replace('-', "_");
                let per_cell = self.simulators_per_cell(dsmc);
                list.push((format!("{name}_cell_width_over_d"), side[0]));
                list.push((
                    format!("{name}_cell_width_over_mean_free_path"),
                    side[0] / path,
                ));
                list.push((format!("{name}_simulators_per_cell"), per_cell));
                let parameters = self.dsmc_parameters(dsmc);
                list.push((
                    format!("{name}_simulators_per_disk"),
                    f64::from(parameters.simulators_per_disk),
                ));
                if let Scheme::ContactPoint { .. } = dsmc.scheme {
                    list.push((
                        format!("{name}_partner_radius_over_d"),
                        parameters.partner_radius::<Plane>(self.packing_fraction, 1.0),
                    ));
                    let coherent = parameters.copies == stosszahl_dsmc::Copies::Coherent;
                    list.push((
                        format!("{name}_coherent_copies"),
                        f64::from(u8::from(coherent)),
                    ));
                }
            }
        }
        list
    }
}
