// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a wall is and how it moves; a particle as the wall sees it.
//!
//! A contact is computed in the frame of the wall, which turns with it: there the wall is at rest, and what is remembered of
//! the contact turns with the wall by itself. Velocities are those of the half step that brought particle and wall to where
//! they are (docs/theory.md, on the tangential displacement): the wall's velocity is taken at the place in it where the particle
//! was then, and the difference turned by half a step's rotation. A particle that moves with the wall has no velocity. Those of the
//! step, where a particle comes with a change, are relative to the wall's velocity at the step, which may have a change likewise.

use crate::contact::forces::MotionChange;
use crate::contact::staged::WallSurface;
use crate::contact::Particle;
use crate::contact::Step;
use crate::geometry::ellipsoid::rotation_columns;
use crate::geometry::share::Share;
use crate::geometry::Ellipsoid;
use crate::vector::Vector3;

/// Pose and motion of a wall.
///
/// # Example
/// ```
/// use ellgran::vector::Vector3;
/// use ellgran::walls::Motion;
///
/// // A drum that has turned by 90 degrees about z through (1, 0, 0), at 2 rad/s.
/// let drum = Motion {
///     origin: Vector3::new(1.0, 0.0, 0.0),
///     axes: Motion::axes_of([0.5f64.sqrt(), 0.0, 0.0, 0.5f64.sqrt()]),
///     angular_velocity: Vector3::new(0.0, 0.0, 2.0),
///     ..Motion::REST
/// };
/// assert!(Motion::REST.is_none() && !drum.is_none());
/// assert_eq!(drum.centre(), Vector3::new(1.0, 0.0, 0.0));
/// // The mark that was at (2, 0, 0) is at (1, 1, 0), and moves to the left.
/// let mark = drum.point_to_world(Vector3::new(2.0, 0.0, 0.0));
/// assert!((mark - Vector3::new(1.0, 1.0, 0.0)).norm() < 1e-15);
/// assert!((drum.point_to_wall(mark) - Vector3::new(2.0, 0.0, 0.0)).norm() < 1e-15);
/// assert!((drum.velocity_at(mark) - Vector3::new(-2.0, 0.0, 0.0)).norm() < 1e-14);
/// let along = Vector3::new(0.0, 1.0, 0.0);
/// assert!((drum.to_world(drum.to_wall(along)) - along).norm() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// The point about which the wall has turned, where it was when the wall's shapes were described.
    pub origin: Vector3,
    /// How far that point has moved since.
    pub displacement: Vector3,
    /// The axes of the wall's frame in the world; `None` where the wall has not turned.
    pub axes: Option<[Vector3; 3]>,
    /// Velocity of the point, in the step.
    pub velocity: Vector3,
    /// Angular velocity in the step, world frame.
    pub angular_velocity: Vector3,
    /// What the velocity of the point at the step has more than that in the step; read where particles come with a change.
    pub velocity_change: Vector3,
    /// Likewise of the angular velocity.
    pub angular_velocity_change: Vector3,
    /// Whether the surface moves along itself: its matter has these velocities, and its frame stays where it is, as that of a cylinder that
    /// turns about its axis may. What is remembered of a contact is then in the frame of the world. Such a wall has neither
    /// moved nor turned.
    pub along_itself: bool,
}

impl Motion {
    /// No motion, in the place where the shapes were described.
    pub const REST: Motion = Motion {
        origin: Vector3::ZERO,
        displacement: Vector3::ZERO,
        axes: None,
        velocity: Vector3::ZERO,
        angular_velocity: Vector3::ZERO,
        velocity_change: Vector3::ZERO,
        angular_velocity_change: Vector3::ZERO,
        along_itself: false,
    };

    /// The axes of a quaternion (w, x, y, z) of any length but zero; `None` for one that does not turn.
    pub fn axes_of([w, x, y, z]: [f64; 4]) -> Option<[Vector3; 3]> {
        if x == 0.0 && y == 0.0 && z == 0.0 {
            return None;
        }
        let square = w * w + x * x + y * y + z * z;
        Some(rotation_columns([w, x, y, z], 2.0 / square))
    }

    /// The point about which the wall turns, where it is.
    pub fn centre(&self) -> Vector3 {
        self.origin + self.displacement
    }

    /// Velocity of the wall's matter at a point in the world.
    pub fn velocity_at(&self, point: Vector3) -> Vector3 {
        if self.angular_velocity == Vector3::ZERO {
            return self.velocity;
        }
        self.velocity + self.angular_velocity.cross(point - self.centre())
    }

    /// What the velocity of the wall's matter at a point in the world has more at the step.
    pub fn velocity_change_at(&self, point: Vector3) -> Vector3 {
        if self.angular_velocity_change == Vector3::ZERO {
            return self.velocity_change;
        }
        self.velocity_change + self.angular_velocity_change.cross(point - self.centre())
    }

    /// Whether the wall turns, in the step or at its end.
    pub(super) fn spins(&self) -> bool {
        self.angular_velocity != Vector3::ZERO || self.angular_velocity_change != Vector3::ZERO
    }

    /// Whether the wall is where it was, and at rest: its frame is the world's.
    pub fn is_none(&self) -> bool {
        self.axes.is_none()
            && !self.spins()
            && [self.displacement, self.velocity, self.velocity_change]
                .iter()
                .all(|v| *v == Vector3::ZERO)
    }

    /// A vector of the world in the wall's frame.
    pub fn to_wall(&self, v: Vector3) -> Vector3 {
        match &self.axes {
            None => v,
            Some([x, y, z]) => Vector3::new(x.dot(v), y.dot(v), z.dot(v)),
        }
    }

    /// A vector of the wall's frame in the world.
    pub fn to_world(&self, v: Vector3) -> Vector3 {
        match &self.axes {
            None => v,
            Some([x, y, z]) => *x * v.x + *y * v.y + *z * v.z,
        }
    }

    /// A point of the world in the wall's frame.
    pub fn point_to_wall(&self, p: Vector3) -> Vector3 {
        match self.axes {
            None => p - self.displacement,
            Some(_) => self.to_wall(p - self.centre()) + self.origin,
        }
    }

    /// A point of the wall's frame in the world.
    pub fn point_to_world(&self, p: Vector3) -> Vector3 {
        match self.axes {
            None => p + self.displacement,
            Some(_) => self.to_world(p - self.origin) + self.centre(),
        }
    }

    /// A surface of the wall's frame in the world, with its velocity there.
    pub fn surface_to_world(&self, s: &WallSurface) -> WallSurface {
        let point = self.point_to_world(s.point);
        WallSurface {
            point,
            normal: self.to_world(s.normal),
            direction: self.to_world(s.direction),
            velocity: self.velocity_at(point) + self.to_world(s.velocity),
            velocity_change: self.velocity_change_at(point) + self.to_world(s.velocity_change),
            share: Share {
                by_position: self.to_world(s.share.by_position),
                by_rotation: self.to_world(s.share.by_rotation),
                ..s.share
            },
            ..*s
        }
    }

    /// A surface in the frame in which forces are computed, that of the wall: where the wall moves along itself, with its velocity.
    pub(super) fn in_its_frame(&self, s: &WallSurface) -> WallSurface {
        if self.along_itself {
            self.surface_to_world(s)
        } else {
            *s
        }
    }

    /// Velocity in the world of the surface of a contact in the frame of the wall.
    pub(super) fn velocity_of(&self, s: &WallSurface, point: Vector3) -> Vector3 {
        if self.along_itself {
            s.velocity
        } else {
            self.velocity_at(point) + self.to_world(s.velocity)
        }
    }

    /// By how much the step is later than the velocities of a particle.
    ///
    /// Where no time passes velocities are those of the step, but for particles that come with a change: their velocities are those of
    /// the half step in any evaluation.
    pub(super) fn half_step(step: &Step, has_change: bool) -> f64 {
        if step.advance_history || has_change {
            0.5 * step.time_step
        } else {
            0.0
        }
    }

    /// A particle in the wall's frame, with its motion relative to the wall.
    pub fn seen_from_wall(&self, i: &Particle, step: &Step) -> Particle {
        if self.along_itself {
            return *i;
        }
        let mut velocity = i.velocity - self.velocity;
        let mut omega = i.omega;
        let mut change = i.change.map(|change| MotionChange {
            velocity: change.velocity - self.velocity_change,
            omega: change.omega - self.angular_velocity_change,
        });
        if self.spins() {
            let spin = self.angular_velocity;
            let half = Self::half_step(step, i.change.is_some());
            let from_centre = i.position - self.centre();
            let at_step = change.map(|change| {
                let spin_at_step = spin + self.angular_velocity_change;
                let velocity = velocity + change.velocity - spin_at_step.cross(from_centre);
                (velocity, omega + change.omega - spin)
            });
            velocity = velocity - spin.cross(from_centre - velocity * half);
            omega = omega - spin;
            velocity = velocity + spin.cross(velocity) * half;
            omega = omega + spin.cross(omega) * half;
            change = at_step.map(|(velocity_at_step, omega_at_step)| MotionChange {
                velocity: velocity_at_step - velocity,
                omega: omega_at_step - omega,
            });
        }
        Particle {
            position: self.point_to_wall(i.position),
            body: Ellipsoid {
                axes: i.body.axes.map(|a| self.to_wall(a)),
                ..i.body
            },
            velocity: self.to_wall(velocity),
            omega: self.to_wall(omega),
            change: change.map(|change| MotionChange {
                velocity: self.to_wall(change.velocity),
                omega: self.to_wall(change.omega),
            }),
            ..*i
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::prepare_body;
    use crate::contact::Body;

    /// A body that is carried by a turning and moving wall over a step, with the velocities of the half step.
    #[test]
    fn a_body_that_moves_with_the_wall_has_no_velocity() {
        let (dt, rate, velocity) = (1e-3, 3.0, Vector3::new(0.4, -0.2, 0.1));
        let centre = |t: f64| Vector3::new(1.0, 2.0, 3.0) + velocity * t;
        let place = |t: f64| {
            let (sin, cos) = (rate * t).sin_cos();
            centre(t) + Vector3::new(2.0 * cos, 2.0 * sin, 0.5)
        };
        let t = 0.7;
        let moved = (place(t) - place(t - dt)) * (1.0 / dt);
        let body = Body {
            position: place(t).to_array(),
            quaternion: [1.0, 0.0, 0.0, 0.0],
            semi_axes: [0.1, 0.2, 0.3],
            velocity: moved.to_array(),
            angular_velocity: [0.0, 0.0, rate],
            mass: 1.0,
            particle_type: 1,
            identifier: 1,
        };
        let half = 0.5 * rate * t;
        let motion = Motion {
            origin: centre(0.0),
            displacement: velocity * t,
            axes: Motion::axes_of([half.cos(), 0.0, 0.0, half.sin()]),
            velocity,
            angular_velocity: Vector3::new(0.0, 0.0, rate),
            ..Motion::REST
        };
        let step = Step {
            time_step: dt,
            advance_history: true,
        };
        let particle = prepare_body(&body, Some(1)).unwrap();
        let seen = motion.seen_from_wall(&particle, &step);
        // Particles with a change have velocities of the half step in any evaluation; with it they move as the wall does at the step.
        let now = velocity + motion.angular_velocity.cross(place(t) - centre(t));
        let with_change = Particle {
            change: Some(MotionChange {
                velocity: now - moved,
                omega: Vector3::ZERO,
            }),
            ..particle
        };
        let at_rest = Step {
            advance_history: false,
            ..step
        };
        let again = motion.seen_from_wall(&with_change, &at_rest);
        assert_eq!((again.velocity, again.omega), (seen.velocity, seen.omega));
        let change = again.change.unwrap();
        assert!((again.velocity + change.velocity).norm() < 1e-14);
        assert!((again.omega + change.omega).norm() < 1e-14);
        // to second order: 2 rate (rate dt)^2/24 of the chord, the same of the place
        assert!(seen.velocity.norm() < 1e-5, "{:?}", seen.velocity);
        assert!(seen.omega.norm() < 1e-14);
        let expected = centre(0.0) + Vector3::new(2.0, 0.0, 0.5);
        assert!((seen.position - expected).norm() < 1e-14);
        let back = motion.point_to_world(seen.position);
        assert!((back - place(t)).norm() < 1e-14);
    }

    /// A body that a wall carries whose velocity and spin change: at the step it has no velocity relative to the wall.
    #[test]
    fn a_body_that_an_accelerating_wall_carries_has_no_velocity_at_the_step() {
        let dt = 1e-3;
        let [spin, more] = [
            Vector3::new(0.3, -0.5, 2.0),
            Vector3::new(0.02, 0.01, -0.04),
        ];
        let motion = Motion {
            origin: Vector3::new(1.0, 2.0, 3.0),
            displacement: Vector3::new(0.1, -0.2, 0.3),
            axes: Motion::axes_of([0.9, 0.1, -0.3, 0.2]),
            velocity: Vector3::new(0.4, -0.2, 0.1),
            angular_velocity: spin,
            velocity_change: Vector3::new(-0.03, 0.05, 0.02),
            angular_velocity_change: more,
            along_itself: false,
        };
        let place = Vector3::new(1.5, 0.5, 3.5);
        let body = Body {
            position: place.to_array(),
            quaternion: [1.0, 0.0, 0.0, 0.0],
            semi_axes: [0.1, 0.2, 0.3],
            velocity: [0.1, 0.2, 0.3],
            angular_velocity: [0.3, 0.2, 0.1],
            mass: 1.0,
            particle_type: 1,
            identifier: 1,
        };
        let particle = prepare_body(&body, Some(1)).unwrap();
        let carried_by = |wall: &Motion| Particle {
            change: Some(MotionChange {
                velocity: wall.velocity_at(place) + wall.velocity_change_at(place)
                    - particle.velocity,
                omega: wall.angular_velocity + more - particle.omega,
            }),
            ..particle
        };
        let step = Step {
            time_step: dt,
            advance_history: true,
        };
        let starting = Motion {
            angular_velocity: Vector3::ZERO,
            velocity: motion.velocity_at(motion.centre()),
            ..motion
        };
        for wall in [motion, starting] {
            let carried = carried_by(&wall);
            let seen = wall.seen_from_wall(&carried, &step);
            let change = seen.change.unwrap();
            assert!((seen.velocity + change.velocity).norm() < 1e-14);
            assert!((seen.omega + change.omega).norm() < 1e-14);
            // The half step knows nothing of it.
            let without = Motion {
                velocity_change: Vector3::ZERO,
                angular_velocity_change: Vector3::ZERO,
                ..wall
            };
            let half = without.seen_from_wall(&carried, &step);
            assert!((half.velocity - seen.velocity).norm() < 1e-15);
            assert!((half.omega - seen.omega).norm() < 1e-15);
        }
        // A surface that moves along itself carries its matter's velocities in the frame of the world.
        let along_itself = Motion {
            displacement: Vector3::ZERO,
            axes: None,
            along_itself: true,
            ..motion
        };
        let carried = carried_by(&along_itself);
        let seen = along_itself.seen_from_wall(&carried, &step);
        assert_eq!((seen.velocity, seen.change.unwrap().velocity), {
            (carried.velocity, carried.change.unwrap().velocity)
        });
        let surface = along_itself.in_its_frame(&crate::walls::plane::flat(
            place,
            Vector3::new(0.0, 0.0, 1.0),
        ));
        assert_eq!(surface.velocity, along_itself.velocity_at(place));
        assert_eq!(
            surface.velocity_change,
            along_itself.velocity_change_at(place)
        );
    }
}
