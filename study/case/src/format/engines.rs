//! The engines and their parameters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

/// The engines to run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EnginesSpec {
    /// Exact event-driven hard disks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ed: Option<EventDrivenSpec>,
    /// Monte Carlo collisions at the dilute rate.
    #[serde(rename = "dsmc-boltzmann", skip_serializing_if = "Option::is_none")]
    pub boltzmann: Option<MonteCarloSpec>,
    /// Monte Carlo collisions at the rate of the free volume in each cell.
    #[serde(rename = "dsmc-free-volume", skip_serializing_if = "Option::is_none")]
    pub free_volume: Option<MonteCarloSpec>,
    /// Monte Carlo collisions at the rate of Enskog's theory, with the packing around each cell.
    #[serde(rename = "dsmc-enskog", skip_serializing_if = "Option::is_none")]
    pub enskog: Option<MonteCarloSpec>,
    /// Monte Carlo collisions with partners from the cell of the point of contact (Montanero and
    /// Santos).
    #[serde(rename = "dsmc-esmc", skip_serializing_if = "Option::is_none")]
    pub esmc: Option<MonteCarloSpec>,
    /// Monte Carlo collisions of overlapping disks along their line of centres (Donev, Alder and
    /// Garcia).
    #[serde(
        rename = "dsmc-stochastic-disks",
        skip_serializing_if = "Option::is_none"
    )]
    pub stochastic_disks: Option<MonteCarloSpec>,
    /// Monte Carlo collisions at the rate of Enskog's theory with partners around the point of
    /// contact.
    #[serde(rename = "dsmc-contact-point", skip_serializing_if = "Option::is_none")]
    pub contact_point: Option<MonteCarloSpec>,
    /// Monte Carlo collisions without positions: the engine of a case without a box.
    #[serde(rename = "dsmc-homogeneous", skip_serializing_if = "Option::is_none")]
    pub homogeneous: Option<HomogeneousSpec>,
}

/// Monte Carlo scheme in the case format: the engine's name, the keys of its table, and which gases
/// the scheme is for.
pub struct SchemeFormat {
    /// Name of the engine.
    pub engine: &'static str,
    /// Keys of the engine's table that not all schemes have.
    own_keys: &'static [&'static str],
    /// True if the scheme selects collision partners across cells.
    pub is_cross_cell: bool,
    /// True if the scheme is for disks only.
    pub is_planar: bool,
    /// Returns the engine's table in a case.
    pub table: fn(&EnginesSpec) -> &Option<MonteCarloSpec>,
    /// Returns the engine's table in a case, mutably.
    pub table_mut: fn(&mut EnginesSpec) -> &mut Option<MonteCarloSpec>,
}

impl SchemeFormat {
    /// Returns all keys that the engine's table can have.
    pub fn keys(&self) -> Vec<&'static str> {
        /// Keys that the tables of all Monte Carlo schemes in cells have.
        const ALL: &[&str] = &["simulators_per_particle", "wall_contact"];
        /// Keys of Monte Carlo schemes that select partners within a cell.
        const WITHIN_CELL: &[&str] = &[
            "cell_size",
            "steps_per_cell_crossing",
            "displacement",
            "weights",
        ];
        /// Keys of Monte Carlo schemes that select partners across cells.
        const CROSS_CELL: &[&str] = &["steps_per_mean_free_time"];
        let shared = if self.is_cross_cell {
            CROSS_CELL
        } else {
            WITHIN_CELL
        };
        [ALL, shared, self.own_keys].concat()
    }
}

impl EnginesSpec {
    /// Returns the table of a Monte Carlo engine in cells, mutably; `None` if the case does not
    /// have it.
    pub fn monte_carlo_mut(&mut self, engine: &str) -> Option<&mut MonteCarloSpec> {
        let format = SCHEMES.iter().find(|scheme| scheme.engine == engine)?;
        (format.table_mut)(self).as_mut()
    }
}

/// Monte Carlo schemes in cells, in the order of tables and reports.
pub static SCHEMES: [SchemeFormat; 6] = [
    SchemeFormat {
        engine: "dsmc-boltzmann",
        own_keys: &[],
        is_cross_cell: false,
        is_planar: false,
        table: |all| &all.boltzmann,
        table_mut: |all| &mut all.boltzmann,
    },
    SchemeFormat {
        engine: "dsmc-free-volume",
        own_keys: &["max_contact_value"],
        is_cross_cell: false,
        is_planar: false,
        table: |all| &all.free_volume,
        table_mut: |all| &mut all.free_volume,
    },
    SchemeFormat {
        engine: "dsmc-enskog",
        own_keys: &["max_contact_value", "density_window"],
        is_cross_cell: false,
        is_planar: false,
        table: |all| &all.enskog,
        table_mut: |all| &mut all.enskog,
    },
    SchemeFormat {
        engine: "dsmc-esmc",
        own_keys: &["cell_size", "max_contact_value", "density_window"],
        is_cross_cell: true,
        is_planar: false,
        table: |all| &all.esmc,
        table_mut: |all| &mut all.esmc,
    },
    SchemeFormat {
        engine: "dsmc-stochastic-disks",
        own_keys: &["stiffness"],
        is_cross_cell: true,
        is_planar: true,
        table: |all| &all.stochastic_disks,
        table_mut: |all| &mut all.stochastic_disks,
    },
    SchemeFormat {
        engine: "dsmc-contact-point",
        own_keys: &[
            "cell_size",
            "max_contact_value",
            "partner_radius",
            "simulator_start",
        ],
        is_cross_cell: true,
        is_planar: false,
        table: |all| &all.contact_point,
        table_mut: |all| &mut all.contact_point,
    },
];

/// Exact event-driven hard disks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EventDrivenSpec {
    /// Contact time of the TC model: a disk that touches a disk or a wall again sooner does so
    /// elastically. 0 is off.
    #[schemars(range(min = 0.0))]
    pub contact_time: f64,
    /// Most collisions in one run, as a safety limit. Default: none.
    #[schemars(range(min = 1, max = 9_007_199_254_740_992_u64))]
    pub collision_limit: Option<u64>,
    /// Most collisions of a particle in a unit of time. The mean is over all particles, and over
    /// 1000 collisions of each, or 2 000 000 of all where that is more. A run in which particles
    /// come to rest on each other ends here with an error. Default: 10 000 times the rate of the
    /// start, or of particles a diameter apart at the fastest speed that start, walls, streams,
    /// gravity or kicks give.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub collision_rate_limit: Option<f64>,
}

/// Monte Carlo collisions in cells. Defaults are those of the scheme; a key that a scheme does not
/// have is refused.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MonteCarloSpec {
    /// Side of a cell \[length\].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub cell_size: Option<f64>,
    /// Simulators for each particle.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub simulators_per_particle: Option<u64>,
    /// Time steps in which the fastest particle crosses a cell, and in a mean free time.
    #[schemars(range(min = 1.0, max = 1e6))]
    pub steps_per_cell_crossing: Option<f64>,
    /// Time steps in which a mean free time passes, of schemes whose partners lie across cells.
    #[schemars(range(min = 1.0, max = 1e6))]
    pub steps_per_mean_free_time: Option<f64>,
    /// Displace the partners of a collision as the consistent Boltzmann algorithm does: false, true
    /// for one diameter, or "inelastic" for d (1 + r)/(2 r).
    pub displacement: Option<DisplacementSpec>,
    /// Cells on each side over which the packing fraction of the contact value is taken, or "mean"
    /// for the whole box.
    pub density_window: Option<DensityWindowSpec>,
    /// Limit on the factor by which the density raises the collision rate.
    #[schemars(range(min = 1.0, max = 1e9))]
    pub max_contact_value: Option<f64>,
    /// Radius around the point of contact from which a partner is drawn \[length\].
    #[schemars(range(min = 0.0))]
    pub partner_radius: Option<f64>,
    /// Initial states of several simulators of a particle.
    pub simulator_start: Option<SimulatorStartSpec>,
    /// Rate at which overlapping disks collide, in units of the rate at which the dilute gas has
    /// Enskog's collision rate.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e6))]
    pub stiffness: Option<f64>,
    /// Contact of particles with walls: with their centre, or at their radius. Default: the centre
    /// for `dsmc-boltzmann`, otherwise the radius.
    pub wall_contact: Option<WallsActOn>,
    /// Weights of simulators by region: more simulators where particles are few.
    pub weights: Option<WeightsSpec>,
}

/// Displacement of the partners of a collision (consistent Boltzmann algorithm).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum DisplacementSpec {
    /// Displacement of the partners by one diameter, or none.
    Switch(bool),
    /// Displacement of the partners by the inelastic length.
    Word(Inelastic),
}

/// Word for the inelastic length of a displacement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Inelastic {
    /// d (1 + r)/(2 r).
    Inelastic,
}

/// Neighbourhood in which the packing fraction of a contact value is taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum DensityWindowSpec {
    /// Number of cells on each side over which the packing fraction is taken.
    Cells(#[schemars(range(min = 0, max = 50))] u64),
    /// Mean packing fraction of the whole box.
    Whole(Mean),
}

/// Word for the mean packing fraction of the whole box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mean {
    /// The mean packing fraction of the whole box.
    Mean,
}

/// Initial states of several simulators of a particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SimulatorStartSpec {
    /// Each set of simulators is a copy of the start, moved and turned at random.
    Independent,
    /// Each set of simulators has the long waves of the start.
    Coherent,
}

/// Part of a particle that touches walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallsActOn {
    /// Walls act on the centre of a particle.
    Centre,
    /// Walls act at the surface of a particle, a radius from its centre.
    Radius,
}

/// Weights of simulators by region of the box: stripes of equal width.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeightsSpec {
    /// The axis across the stripes: "x" or "y".
    pub along: StripeAxis,
    /// Weight in each stripe, over that of the start. This or `adaptive_stripes`.
    #[schemars(extend("minItems" = 1, "maxItems" = 1000, "items" = json!({"type": "number", "minimum": 1e-3, "maximum": 1e3})))]
    pub factors: Option<Vec<f64>>,
    /// Number of stripes whose weights follow the number of simulators: they double where there are
    /// more than twice as many as in the mean over stripes at the start, and halve where there are
    /// fewer than half as many.
    #[schemars(range(min = 2, max = 1000))]
    pub adaptive_stripes: Option<u64>,
}

/// Axis of the plane across the stripes of weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StripeAxis {
    /// First axis of the plane.
    X,
    /// Second axis of the plane.
    Y,
}

/// Monte Carlo engine of a gas without positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HomogeneousSpec {
    /// The selection of pairs; all are exact.
    pub selection: SelectionSpec,
}

/// Algorithm that selects colliding pairs in a gas without positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SelectionSpec {
    /// Alias tables over groups of like speed and size: the fastest selection of pairs.
    #[default]
    AliasTables,
    /// Low-rank majorant: products of the weights of size classes, found in trees (Bodrova &
    /// Osinsky 2024).
    LowRank,
    /// Single majorant of all pairs, by Bird.
    SingleMajorant,
}
