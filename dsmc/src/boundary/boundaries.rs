//! Boundary conditions of a box, as users give them.

use stosszahl_model::walls::{FreeArea, Obstacle};
use stosszahl_model::{Domain, Face, Plane, Sizes, Space, Volume, Walls};

use super::inflow::Inflow;
use super::weights::Weights;
use crate::parameters::{Displacement, EngineError, Parameters};
use crate::scheme::{Neighbourhood, Scheme};

/// Least share of a box that counts as free.
const LEAST_SHARE: f64 = 1e-9;

/// Where a wall stops a particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Clearance {
    /// With its centre on the wall: particles are points for walls, as for the dilute gas.
    #[default]
    Centre,
    /// With its surface on the wall: the centre keeps a radius away.
    Radius,
}

/// Everything at the faces of the box and inside it. The default is a periodic box.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boundaries<S: Space> {
    /// The faces of the box; its domain must be periodic along the same axes.
    pub walls: Walls<S>,
    /// Where walls and obstacles stop a particle.
    pub clearance: Clearance,
    /// What flows in through open faces.
    pub inflows: Vec<Inflow<S>>,
    /// Where a simulator stands for more or fewer particles than elsewhere.
    pub weights: Weights,
    /// What stands in the box: in three dimensions, prisms along the third axis.
    pub obstacles: Vec<Obstacle>,
}

impl Boundaries<Volume> {
    /// The same in the plane: what lies along the third axis is left out.
    pub fn in_plane(&self) -> Boundaries<Plane> {
        Boundaries {
            walls: self.walls.in_plane(),
            clearance: self.clearance,
            inflows: self.inflows.iter().map(Inflow::in_plane).collect(),
            weights: self.weights.clone(),
            obstacles: self.obstacles.clone(),
        }
    }
}

impl<S: Space> Boundaries<S> {
    /// Boundaries whose regions have these factors of the weight of simulators; their own if there are none.
    pub(crate) fn with_factors(&self, factors: &[f64]) -> Self {
        Self {
            weights: self.weights.with_factors(factors),
            ..self.clone()
        }
    }

    /// Whether the box is periodic, alike everywhere, and empty of obstacles.
    pub fn is_periodic(&self) -> bool {
        self.walls.is_periodic()
            && self.inflows.is_empty()
            && self.weights.is_uniform()
            && self.obstacles.is_empty()
    }

    /// Whether simulators come and go.
    pub fn is_open(&self) -> bool {
        self.walls.is_open() || !self.inflows.is_empty() || !self.weights.is_uniform()
    }

    /// Packing fraction of the densest inflow.
    pub(crate) fn densest<Z: Sizes>(&self, sizes: &Z) -> f64 {
        let inflows = self.inflows.iter();
        let packing =
            |inflow: &Inflow<S>| inflow.density * S::ball(sizes.radius(sizes.tag(inflow.like)));
        // What is no number is found later.
        inflows.map(packing).fold(0.0, f64::max)
    }

    /// Volume of a box in which centres of particles of a radius can be beside obstacles \[length^D\]. What walls take is not
    /// left out.
    pub(crate) fn free_volume(&self, domain: &Domain<S>, radius: f64) -> f64 {
        let all = domain.volume();
        if self.obstacles.is_empty() {
            return all;
        }
        let clearance = match self.clearance {
            Clearance::Centre => 0.0,
            Clearance::Radius => radius,
        };
        let sides = [0, 1].map(|axis| domain.lengths()[axis]);
        let periodic = [0, 1].map(|axis| domain.is_periodic(axis));
        let area = FreeArea::new(&self.obstacles, sides, periodic, clearance);
        // Without room particles are refused where they are.
        let share = area.between([0.0; 2], sides) / (sides[0] * sides[1]);
        all * share.max(LEAST_SHARE)
    }

    /// Whether all fits the box and the scheme.
    pub(crate) fn check(
        &self,
        domain: &Domain<S>,
        Parameters {
            scheme,
            displacement,
            ..
        }: Parameters,
    ) -> Result<(), EngineError> {
        for axis in 0..S::DIMENSION {
            let periodic = domain.is_periodic(axis);
            if periodic != (*self.walls.face(axis, 0) == Face::Periodic) {
                return Err(EngineError::UnlikeFaces { axis, periodic });
            }
        }
        let is_plain = self.weights.is_uniform() && self.obstacles.is_empty();
        if !is_plain && scheme.is_across() {
            return Err(EngineError::Boundary {
                scheme: scheme.name(),
                what: "weights or obstacles",
                allowed: "schemes within cells: collisionless, boltzmann, free-volume, enskog",
            });
        }
        if !self.obstacles.is_empty() && scheme == Scheme::Enskog(Neighbourhood::Mean) {
            return Err(EngineError::Boundary {
                scheme: scheme.name(),
                what: "the mean density of the whole box, and obstacles",
                allowed: "the density of some cells around, which ends at bodies",
            });
        }
        if !self.is_periodic() && displacement != Displacement::None {
            return Err(EngineError::Boundary {
                scheme: scheme.name(),
                what: "a displacement and walls, open faces, weights or obstacles",
                allowed: "no displacement, which would lead partners through walls",
            });
        }
        Ok(())
    }
}
