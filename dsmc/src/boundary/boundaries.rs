//! Boundary conditions of a DSMC run: walls, open faces, inflows, obstacles and simulator weights.

use stosszahl_model::walls::{FreeArea, Obstacle};
use stosszahl_model::{Domain, Face, Plane, Sizes, Space, Volume, Walls};

use super::inflow::Inflow;
use super::weights::SimulatorWeights;
use crate::parameters::{DsmcError, Parameters};
use crate::scheme::{DensityWindow, Neighbourhood, PartnerDisplacement, WallClearance};

/// Least free fraction of the box volume: a box completely filled by obstacles counts as having
/// this much.
const LEAST_SHARE: f64 = 1e-9;

/// Boundary conditions of a DSMC run: walls and open faces, inflows, obstacles and simulator
/// weights. The default is a periodic box.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoundaryConditions<S: Space> {
    /// Walls and open faces of the box; the box must be periodic along the other axes.
    pub walls: Walls<S>,
    /// Contact of particles with walls and obstacles: by their centre or by their surface.
    pub clearance: WallClearance,
    /// Inflows: streams of gas that enter through open faces.
    pub inflows: Vec<Inflow<S>>,
    /// Simulator weights: number of particles per simulator, by region of the box.
    pub weights: SimulatorWeights,
    /// Obstacles in the box; in three dimensions, prisms along the third axis.
    pub obstacles: Vec<Obstacle>,
}

impl BoundaryConditions<Volume> {
    /// Returns the boundary conditions reduced to two dimensions, without components along the
    /// third axis.
    pub fn in_plane(&self) -> BoundaryConditions<Plane> {
        BoundaryConditions {
            walls: self.walls.in_plane(),
            clearance: self.clearance,
            inflows: self.inflows.iter().map(Inflow::in_plane).collect(),
            weights: self.weights.clone(),
            obstacles: self.obstacles.clone(),
        }
    }
}

impl<S: Space> BoundaryConditions<S> {
    /// Returns a copy with the given weight factors of the regions; unchanged if their number
    /// differs.
    pub(crate) fn with_factors(&self, factors: &[f64]) -> Self {
        Self {
            weights: self.weights.with_factors(factors),
            ..self.clone()
        }
    }

    /// Returns true if the box is periodic along all axes, without inflows, obstacles and weight
    /// factors.
    pub fn is_periodic(&self) -> bool {
        self.walls.is_periodic()
            && self.inflows.is_empty()
            && self.weights.is_uniform()
            && self.obstacles.is_empty()
    }

    /// Returns true if the number of simulators can change: they enter, leave, split or merge.
    pub fn is_open(&self) -> bool {
        self.walls.is_open() || !self.inflows.is_empty() || !self.weights.is_uniform()
    }

    /// Returns the largest packing fraction among the inflows; 0 without inflows.
    pub(crate) fn densest<Z: Sizes>(&self, sizes: &Z) -> f64 {
        let inflows = self.inflows.iter();
        let packing = |inflow: &Inflow<S>| {
            inflow.density * S::particle_volume(sizes.radius(sizes.tag_of(inflow.like)))
        };
        // A NaN is dropped here and refused when the inflow is checked.
        inflows.map(packing).fold(0.0, f64::max)
    }

    /// Returns the volume of the box in which centres of particles with a radius do not overlap
    /// obstacles \[length^D\]. Space that walls occupy is not subtracted.
    pub(crate) fn free_volume(&self, domain: &Domain<S>, radius: f64) -> f64 {
        let all = domain.volume();
        if self.obstacles.is_empty() {
            return all;
        }
        let clearance = match self.clearance {
            WallClearance::Centre => 0.0,
            WallClearance::Radius => radius,
        };
        let sides = [0, 1].map(|axis| domain.lengths()[axis]);
        let periodic = [0, 1].map(|axis| domain.is_periodic(axis));
        let area = FreeArea::new(&self.obstacles, sides, periodic, clearance);
        // A box without room counts as almost full; its particles are then refused one by one.
        let share = area.rectangle_between([0.0; 2], sides) / (sides[0] * sides[1]);
        all * share.max(LEAST_SHARE)
    }

    /// Checks that walls, inflows, weights and obstacles fit the box and the collision scheme.
    pub(crate) fn check_domain(
        &self,
        domain: &Domain<S>,
        Parameters {
            scheme,
            displacement,
            ..
        }: Parameters,
    ) -> Result<(), DsmcError> {
        for axis in 0..S::DIMENSION {
            let periodic = domain.is_periodic(axis);
            if periodic != (*self.walls.face(axis, 0) == Face::Periodic) {
                return Err(DsmcError::UnlikeFaces { axis, periodic });
            }
        }
        let is_plain = self.weights.is_uniform() && self.obstacles.is_empty();
        if !is_plain && scheme.is_cross_cell() {
            return Err(DsmcError::Boundary {
                scheme: scheme.name(),
                what: "weights or obstacles",
                allowed: "schemes within cells: collisionless, boltzmann, free-volume, enskog",
            });
        }
        let is_mean = scheme.properties().window == DensityWindow::Fixed(Neighbourhood::Mean);
        if !self.obstacles.is_empty() && is_mean && !scheme.is_dilute() {
            return Err(DsmcError::Boundary {
                scheme: scheme.name(),
                what: "the mean density of the whole box, and obstacles",
                allowed: "the density of some cells around, which ends at bodies",
            });
        }
        if !self.is_periodic() && displacement != PartnerDisplacement::None {
            return Err(DsmcError::Boundary {
                scheme: scheme.name(),
                what: "a displacement and walls, open faces, weights or obstacles",
                allowed: "no displacement, which would lead partners through walls",
            });
        }
        Ok(())
    }
}
