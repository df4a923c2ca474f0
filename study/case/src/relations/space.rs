//! Checks of relations between the keys of the box, its walls, obstacles and inflows.

use std::f64::consts::PI;

use super::{Checked, Relations};
use crate::error::format_total;
use crate::format::{
    DisplacementSpec, FACES, FaceSpec, FaceWord, PairCorrelationSpec, PlacementSpec,
    RestitutionSpec, SCHEMES, WallSpec,
};

impl Relations<'_> {
    pub(super) fn domain(&self) -> Checked {
        let dimension = self.dimension();
        let (closest, packing) = if dimension == 2 {
            (0.9069, PI / 4.0)
        } else {
            (0.7405, PI / 6.0)
        };
        let filled = |one: &(f64, f64)| packing * one.0 * one.1.powi(dimension as i32);
        let filled: f64 = self.contents().iter().map(filled).sum();
        let Some(domain) = &self.case.domain else {
            let share = filled / self.case.gas.simulated_volume().unwrap_or(f64::INFINITY);
            let allowed = format!(
                "particles fill less than all of the volume where contact values are dense; here {}",
                format_total(share)
            );
            let dense = self.case.gas.pair_correlation == PairCorrelationSpec::Enskog;
            return self.ensure(!dense || share < 1.0, "gas.volume", allowed);
        };
        let file = self.case.start.placement == PlacementSpec::File;
        let one = "a box has either a size or a packing_fraction";
        let both = domain.size.is_some() && domain.packing_fraction.is_some();
        self.ensure(!both, "box.packing_fraction", one)?;
        let none = domain.size.is_none() && domain.packing_fraction.is_none();
        self.ensure(!none || file, "box.packing_fraction", one)?;
        if domain.size.is_some() {
            self.without(&["box.aspect_ratio"], "box.size says it")?;
        }
        if domain.width_over_critical_length.is_some() {
            let constant =
                matches!(self.case.gas.restitution, RestitutionSpec::Constant(one) if one < 1.0);
            let fits = domain.packing_fraction.is_some() && dimension == 2 && constant;
            let smooth = self.case.is_uniform_box() && !self.case.is_rough();
            let allowed = "this key is for smooth disks that cool in a periodic box: with box.packing_fraction and a constant gas.restitution below 1";
            self.ensure(
                fits && smooth && self.case.bath().is_none(),
                "box.width_over_critical_length",
                allowed,
            )?;
        }
        self.shear()?;
        let square = self.case.start.placement == PlacementSpec::Square;
        let closest = if square { PI / 4.0 } else { closest };
        let most = if square { " on a square lattice" } else { "" };
        if let Some(share) = domain.packing_fraction {
            let allowed = format!(
                "a number above 0 and at most {closest:.4}{most} in {dimension} dimensions"
            );
            self.ensure(share <= closest, "box.packing_fraction", allowed)?;
            let allowed = "with gas.mean_free_path the box has a size, and diameters follow";
            return self.without(&["gas.mean_free_path"], allowed);
        }
        if let Some(size) = &domain.size
            && self.case.gas.mean_free_path.is_none()
        {
            let share = filled / size.iter().product::<f64>();
            let allowed = format!(
                "a box with a packing fraction of at most {closest:.4}{most}; of this one {} is filled",
                format_total(share)
            );
            self.ensure(share <= closest, "box.size", allowed)?;
        }
        Ok(())
    }

    /// Checks the keys of a uniform shear flow, and keys that are invalid with one.
    fn shear(&self) -> Checked {
        let case = self.case;
        let Some(rate) = case.domain.as_ref().and_then(|domain| domain.shear_rate) else {
            return Ok(());
        };
        let key = "box.shear_rate";
        let allowed = "a finite number that is not 0";
        self.ensure(rate.is_finite() && rate != 0.0, key, allowed)?;
        let allowed = "a flow in a box that is periodic on all sides: without [walls], which would stop or drive the flow";
        self.ensure(case.walls.is_periodic(), key, allowed)?;
        let allowed = "a flow without [[obstacle]], which it could not pass uniformly";
        self.ensure(case.obstacle.is_empty(), key, allowed)?;
        let allowed = "a flow without [gravity], along which a periodic gas would fall for ever";
        self.ensure(case.gravity.is_none(), key, allowed)?;
        for scheme in SCHEMES.iter().filter(|scheme| !scheme.is_cross_cell) {
            let written = (scheme.table)(&case.engine);
            let name = scheme.engine;
            let is_displaced = written
                .as_ref()
                .and_then(|one| one.displacement.as_ref())
                .is_some_and(|displacement| *displacement != DisplacementSpec::Switch(false));
            let key = format!("engine.{name}.displacement");
            let allowed =
                "false in a shear flow, whose partners are a contact distance apart or points";
            self.ensure(!is_displaced, &key, allowed)?;
        }
        let allowed =
            "a box without this key: critical lengths are those of a gas that cools at rest";
        let is_critical = case
            .domain
            .as_ref()
            .is_some_and(|domain| domain.width_over_critical_length.is_some());
        self.ensure(!is_critical, "box.width_over_critical_length", allowed)?;
        let allowed =
            "velocities relative to the flow without a drift, which the flow would carry away";
        self.without(&["start.velocity"], allowed)
    }

    pub(super) fn walls(&self) -> Checked {
        let periodic =
            |axis: usize, side: usize| *self.case.walls.face_at(axis, side) == FaceSpec::default();
        for (axis, names) in FACES.iter().enumerate() {
            let both = [periodic(axis, 0), periodic(axis, 1)];
            let wall = format!("walls.{}", names[usize::from(both[0])]);
            self.ensure(
                axis < self.dimension() || both == [true, true],
                &wall,
                "a box of disks has no face along the third axis",
            )?;
            let other = names[usize::from(!both[0])];
            let allowed =
                format!("opposite faces are both periodic or neither; walls.{other} is periodic");
            self.ensure(both[0] == both[1], &wall, allowed)?;
            for (side, name) in names.iter().enumerate() {
                if let FaceSpec::Wall(wall) = self.case.walls.face_at(axis, side) {
                    let size = self
                        .case
                        .domain
                        .as_ref()
                        .and_then(|domain| domain.size.as_ref());
                    let length = size.and_then(|size| size.get(axis)).copied();
                    self.wall(wall, &format!("walls.{name}"), length)?;
                }
            }
        }
        Ok(())
    }

    pub(super) fn wall(&self, wall: &WallSpec, key: &str, length: Option<f64>) -> Checked {
        self.surface(
            key,
            wall.restitution.is_some() || wall.slip.is_some(),
            wall.temperature.is_some(),
        )?;
        let allowed = "a wall has a restitution from 0 to 1, or a temperature";
        let known = wall.restitution.is_some() || wall.temperature.is_some();
        self.ensure(known, format!("{key}.restitution"), allowed)?;
        let far = wall
            .vibration
            .zip(length)
            .is_some_and(|(one, length)| one.amplitude >= 0.5 * length);
        let allowed = "an amplitude lies above 0 and below half the box";
        self.ensure(!far, format!("{key}.vibration.amplitude"), allowed)
    }

    pub(super) fn surface(&self, key: &str, rebounds: bool, diffuse: bool) -> Checked {
        let allowed = "a surface has a temperature, or else restitution and slip";
        self.ensure(
            !(rebounds && diffuse),
            format!("{key}.temperature"),
            allowed,
        )
    }

    pub(super) fn obstacles(&self) -> Checked {
        let size = self
            .case
            .domain
            .as_ref()
            .and_then(|domain| domain.size.as_ref());
        for (index, obstacle) in self.case.obstacle.iter().enumerate() {
            let key = format!("obstacle.{}", index + 1);
            let shapes = [
                ("circle", obstacle.circle.is_some()),
                ("polyline", obstacle.polyline.is_some()),
                ("polygon", obstacle.polygon.is_some()),
            ];
            let count = shapes.iter().filter(|shape| shape.1).count();
            let allowed = "an obstacle has exactly one of circle, polyline and polygon";
            self.ensure(count == 1, &key, allowed)?;
            self.ensure(
                self.dimension() == 2,
                &key,
                "obstacles are for disks: gas.dimension = 2",
            )?;
            let rebounds = obstacle.restitution.is_some() || obstacle.slip.is_some();
            self.surface(&key, rebounds, obstacle.temperature.is_some())?;
            let inside = |point: &[f64; 2]| {
                size.is_none_or(|size| (0..2).all(|axis| (0.0..=size[axis]).contains(&point[axis])))
            };
            let allowed = "points of an obstacle lie in the box";
            let centre = obstacle
                .circle
                .as_ref()
                .is_none_or(|disk| inside(&disk.centre));
            self.ensure(centre, format!("{key}.circle.centre"), allowed)?;
            for (name, points) in [
                ("polyline", &obstacle.polyline),
                ("polygon", &obstacle.polygon),
            ] {
                let outside = points.iter().flatten().position(|point| !inside(point));
                if let Some(place) = outside {
                    return self.refuse(format!("{key}.{name}.{}", place + 1), allowed);
                }
            }
        }
        Ok(())
    }

    pub(super) fn inflow(&self) -> Checked {
        for (index, inflow) in self.case.inflow.iter().enumerate() {
            let key = |key: &str| format!("inflow.{}.{key}", index + 1);
            let place = (0..6)
                .map(|face| (face / 2, face % 2))
                .find(|&(axis, side)| FACES[axis][side] == inflow.face);
            let open = place.is_some_and(|(axis, side)| {
                *self.case.walls.face_at(axis, side) == FaceSpec::Word(FaceWord::Open)
            });
            let allowed = format!(
                "the face of an inflow is open; write walls.{} = \"open\"",
                inflow.face
            );
            self.ensure(open, key("face"), allowed)?;
            let kinds = self.case.species.len().max(1);
            let fits = inflow
                .number_density
                .as_ref()
                .is_none_or(|list| list.len() == kinds);
            let allowed = format!("a list of {kinds}, one number of at least 0 for each species");
            self.ensure(fits, key("number_density"), allowed)?;
        }
        Ok(())
    }

    pub(super) fn vectors(&self) -> Checked {
        let case = self.case;
        let check = |key: String, vector: Option<&Vec<f64>>| {
            let dimension = self.dimension();
            let fits = vector.is_none_or(|vector| vector.len() == dimension);
            let allowed = format!("a list of {dimension} numbers, as gas.dimension = {dimension}");
            self.ensure(fits, key, allowed)
        };
        let size = case.domain.as_ref().and_then(|domain| domain.size.as_ref());
        check("box.size".to_owned(), size)?;
        let pull = case.gravity.as_ref().map(|gravity| &gravity.acceleration);
        check("gravity.acceleration".to_owned(), pull)?;
        check("start.velocity".to_owned(), case.start.velocity.as_ref())?;
        for (index, inflow) in case.inflow.iter().enumerate() {
            check(
                format!("inflow.{}.velocity", index + 1),
                Some(&inflow.velocity),
            )?;
        }
        for (axis, side) in (0..6).map(|face| (face / 2, face % 2)) {
            if let FaceSpec::Wall(wall) = case.walls.face_at(axis, side) {
                let key = format!("walls.{}.sliding", FACES[axis][side]);
                check(key.clone(), wall.sliding.as_ref())?;
                let across = wall.sliding.as_ref().and_then(|sliding| sliding.get(axis));
                let allowed = "a velocity along the wall: zero across it";
                self.ensure(across.is_none_or(|&across| across == 0.0), key, allowed)?;
            }
        }
        Ok(())
    }
}
