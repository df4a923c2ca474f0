//! Features of obstacles that a particle can touch (edges, corners and disks), and the exact times
//! of contact in flight.
//!
//! All times are roots of the exact flight. Straight flight: a linear equation for an edge and a
//! quadratic one for a corner or a disk. Parabolic flight: a quadratic and a quartic. The quartic
//! is not solved by a formula, which loses digits and roots. Turning points of its derivatives are
//! found first, from the quadratic upwards. So each root is alone between two turning points and is
//! bracketed.

use nalgebra::{Vector2, vector};

use super::descent;

/// Particle in straight or parabolic flight: position, velocity and acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlyingParticle {
    /// Position of the particle at the start of the flight \[length\].
    pub position: Vector2<f64>,
    /// Velocity of the particle at the start of the flight \[length/time\].
    pub velocity: Vector2<f64>,
    /// Constant acceleration of the particle \[length/time^2\].
    pub acceleration: Vector2<f64>,
}

impl FlyingParticle {
    /// Returns the position of the particle after a time of flight \[length\].
    #[inline]
    pub fn position_at(&self, time: f64) -> Vector2<f64> {
        self.position + (self.velocity + self.acceleration * (0.5 * time)) * time
    }

    /// Returns the velocity of the particle after a time of flight \[length/time\].
    #[inline]
    pub fn velocity_at(&self, time: f64) -> Vector2<f64> {
        self.velocity + self.acceleration * time
    }

    /// Returns the bounding box of the flight up to a time: lower left and upper right corner
    /// \[length\].
    pub(super) fn bounds(&self, time: f64) -> [Vector2<f64>; 2] {
        let end = self.position_at(time);
        let (mut least, mut most) = (self.position.inf(&end), self.position.sup(&end));
        for axis in 0..2 {
            let turn = -self.velocity[axis] / self.acceleration[axis];
            // Turning point of the flight; false without acceleration, for NaN too.
            if turn > 0.0 && turn < time {
                let there = self.position_at(turn)[axis];
                least[axis] = least[axis].min(there);
                most[axis] = most[axis].max(there);
            }
        }
        [least, most]
    }
}

/// Predicted contact of a particle in flight with an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Time from the start of the flight until the contact \[time\]; never negative.
    pub time: f64,
    /// Unit vector at the contact, from the obstacle to the centre of the particle.
    pub normal: Vector2<f64>,
}

/// Straight edge of an obstacle without its end points, touched from the outside or from both
/// sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightEdge {
    /// First end point of the edge \[length\].
    pub(super) from: Vector2<f64>,
    /// Unit vector along the edge, from its first to its second end.
    pub(super) along: Vector2<f64>,
    pub(super) length: f64,
    /// True if the edge can be touched from both sides; false if only from the right of its
    /// direction.
    pub(super) both_sides: bool,
}

/// Round feature of an obstacle: a disk or, with radius 0, a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    /// Centre of the disk, or the corner \[length\].
    pub(super) centre: Vector2<f64>,
    pub(super) radius: f64,
}

/// Feature of an obstacle that a particle can touch: an edge, a corner or a disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feature {
    /// Straight edge without its end points.
    Edge(StraightEdge),
    /// Corner or disk.
    Round(Round),
}

impl Feature {
    /// Returns the feature displaced by a vector \[length\].
    #[must_use]
    pub fn moved(&self, by: Vector2<f64>) -> Self {
        match *self {
            Self::Edge(edge) => Self::Edge(StraightEdge {
                from: edge.from + by,
                ..edge
            }),
            Self::Round(round) => Self::Round(Round {
                centre: round.centre + by,
                ..round
            }),
        }
    }

    /// Returns the first contact of a particle in flight with the feature before `limit` \[time\]:
    /// the earliest time at which the particle's edge moves into it. A particle that touches by
    /// rounding and approaches, or is held against the feature by its acceleration, has a contact
    /// at once; one that leaves has none, however near it is.
    #[inline]
    pub fn first_contact(&self, flight: &FlyingParticle, radius: f64, limit: f64) -> Option<Hit> {
        match self {
            Self::Edge(edge) => edge.first_contact(flight, radius, limit),
            Self::Round(round) => round.first_contact(flight, radius, limit),
        }
    }

    /// Returns the unit normal vector of the feature at a point that touches it, pointing from the
    /// feature to the point.
    pub fn normal(&self, point: Vector2<f64>) -> Vector2<f64> {
        match self {
            Self::Edge(edge) => {
                let normal = vector![edge.along[1], -edge.along[0]];
                let inside = edge.both_sides && (point - edge.from).dot(&normal) < 0.0;
                if inside { -normal } else { normal }
            }
            Self::Round(round) => {
                let arm = point - round.centre;
                arm * (1.0 / arm.norm())
            }
        }
    }

    /// Returns the distance of a point from the line of an edge, on either side, or from a disk or
    /// corner \[length\].
    pub fn distance(&self, point: Vector2<f64>) -> f64 {
        match self {
            Self::Edge(edge) => {
                let along = (point - edge.from).dot(&edge.along);
                (point - edge.from - edge.along * along.clamp(0.0, edge.length)).norm()
            }
            Self::Round(round) => ((point - round.centre).norm() - round.radius).abs(),
        }
    }

    /// Returns the bounding box of the feature: lower left and upper right corner \[length\].
    pub fn bounds(&self) -> [Vector2<f64>; 2] {
        match self {
            Self::Edge(edge) => {
                let to = edge.from + edge.along * edge.length;
                [edge.from.inf(&to), edge.from.sup(&to)]
            }
            Self::Round(round) => {
                let reach = vector![round.radius, round.radius];
                [round.centre - reach, round.centre + reach]
            }
        }
    }
}

impl StraightEdge {
    fn first_contact(&self, flight: &FlyingParticle, radius: f64, limit: f64) -> Option<Hit> {
        let outwards = self.first_contact_from(1.0, flight, radius, limit);
        if !self.both_sides {
            return outwards;
        }
        let limit = outwards.map_or(limit, |hit| hit.time);
        (self.first_contact_from(-1.0, flight, radius, limit)).or(outwards)
    }

    /// Returns the first contact of a particle in flight with an edge from one side, `side` 1 or -1
    /// times the normal. The distance from the line is a parabola, which falls through the radius
    /// once.
    fn first_contact_from(
        &self,
        side: f64,
        flight: &FlyingParticle,
        radius: f64,
        limit: f64,
    ) -> Option<Hit> {
        // The joint to a corner must have no gap, for particles of any size.
        let slack = 4.0 * f64::EPSILON * (self.length + self.from.amax());
        let over = |point: Vector2<f64>| {
            let along = (point - self.from).dot(&self.along);
            along >= -slack && along <= self.length + slack
        };
        let normal = vector![self.along[1], -self.along[0]] * side;
        let height = (flight.position - self.from).dot(&normal);
        let speed = flight.velocity.dot(&normal);
        let acceleration = flight.acceleration.dot(&normal);
        let gap = height - radius;
        if gap <= 0.0 && height > 0.0 && over(flight.position) {
            // Contact by rounding or at once.
            let pressed = speed < 0.0 || (speed == 0.0 && acceleration < 0.0);
            let time = if pressed {
                0.0
            } else {
                descent::of_parabola(0.0, speed, acceleration)?
            };
            return (time < limit && over(flight.position_at(time)))
                .then_some(Hit { time, normal });
        }
        let time = descent::of_parabola(gap, speed, acceleration)?;
        (time >= 0.0 && time < limit && over(flight.position_at(time)))
            .then_some(Hit { time, normal })
    }
}

impl Round {
    fn first_contact(&self, flight: &FlyingParticle, radius: f64, limit: f64) -> Option<Hit> {
        let flight = FlyingParticle {
            position: flight.position - self.centre,
            ..*flight
        };
        let reach = radius + self.radius;
        let time = if flight.acceleration == Vector2::zeros() {
            time_of_straight_flight(&flight, reach)
        } else {
            time_of_parabolic_flight(&flight, reach, limit)
        };
        let time = time.filter(|&time| time < limit)?;
        let arm = flight.position_at(time);
        let normal = arm * (1.0 / arm.norm());
        Some(Hit { time, normal })
    }
}

/// Returns the time until a point in straight flight comes within `reach` of the origin; `None` if
/// it never does.
///
/// With b = r . v < 0 and c = r^2 - R^2, t = c/(-b + sqrt(v^2 R^2 - (r x v)^2)): the root that
/// loses no digits at slow approach, with the discriminant that loses none from afar.
fn time_of_straight_flight(flight: &FlyingParticle, reach: f64) -> Option<f64> {
    let (arm, velocity) = (flight.position, flight.velocity);
    let b = arm.dot(&velocity);
    if b >= 0.0 {
        return None;
    }
    let c = arm.norm_squared() - reach * reach;
    if c <= 0.0 {
        return Some(0.0);
    }
    let aside = arm.perp(&velocity);
    let discriminant = velocity.norm_squared() * reach * reach - aside * aside;
    (discriminant >= 0.0).then(|| c / (discriminant.sqrt() - b))
}

/// Returns the time until a point in parabolic flight comes within `reach` of the origin, if that
/// is before `limit` \[time\].
///
/// The first time at which f(t) = r(t)^2 - R^2 falls through zero. With f' = 2 r . v, f'' = 2
/// (v^2 + r . a), f''' = 6 v . a.
fn time_of_parabolic_flight(flight: &FlyingParticle, reach: f64, limit: f64) -> Option<f64> {
    let (arm, velocity, pull) = (flight.position, flight.velocity, flight.acceleration);
    let b = arm.dot(&velocity);
    let (speed, weight) = (velocity.norm(), pull.norm());
    let distance = arm.norm();
    // Time after which the point is out of reach for ever.
    let gone = (speed + (speed * speed + 2.0 * weight * (distance + reach)).sqrt()) / weight;
    let end = limit.min(2.0 * gone);
    if !end.is_finite() {
        // Straight flight, where the acceleration is too weak to be resolved.
        return time_of_straight_flight(flight, reach);
    }
    if distance - reach > (speed + 0.5 * weight * end) * end {
        return None;
    }
    let touches = distance <= reach;
    let bend = speed * speed + arm.dot(&pull);
    if touches && (b < 0.0 || (b == 0.0 && bend < 0.0)) {
        return Some(0.0);
    }
    // Contact of a point that overlaps by rounding.
    let square = if touches {
        arm.norm_squared()
    } else {
        reach * reach
    };
    let excess = |time: f64| flight.position_at(time).norm_squared() - square;
    let slope = |time: f64| 2.0 * flight.position_at(time).dot(&flight.velocity_at(time));
    let bend = |time: f64| {
        2.0 * (flight.velocity_at(time).norm_squared() + flight.position_at(time).dot(&pull))
    };
    // f''/2 = 3 a^2 t^2/2 + 3 v . a t + (v^2 + r . a): where it falls, and where it rises.
    let half_bend = 0.5 * bend(0.0);
    let change = 3.0 * velocity.dot(&pull);
    let curve = 3.0 * weight * weight;
    let mut turns = [f64::NAN; 2];
    if let Some(falls) = descent::of_parabola(half_bend, change, curve) {
        turns[0] = falls;
    }
    if let Some(rises) = descent::of_parabola(-half_bend, -change, -curve) {
        turns[1] = rises;
    }
    let within = 0.0..end;
    let turns = descent::turning_points(|time| (slope(time), bend(time)), &turns, &within);
    let mut begin = 0.0;
    for end in turns.into_iter().chain([end]) {
        if slope(0.5 * (begin + end)) < 0.0 && excess(end) < 0.0 {
            if excess(begin) > 0.0 {
                let both = |time: f64| (excess(time), slope(time));
                return Some(descent::bracketed(both, begin..end));
            }
            // The rise was smaller than can be resolved.
            return Some(begin);
        }
        begin = end;
    }
    None
}

#[cfg(test)]
mod tests;
