// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rigid ellipsoids in motion: velocity Verlet, the free rotation split into turns about the body axes. Second order,
//! symplectic and reversible, so that an energy that drifts is the law's. Forces see the velocities of the half step, as with
//! the engines' own integrators, or those of the step, as with `fix nve/ellipsoid`.

use super::scene::{
    advance_at_step, advance_plane_at_step, array, plain, position, quaternion, rotation, Felt,
    Memory, Rotation, Vector,
};
use ellgran::contact::{Body, Laws, MotionChange};
use ellgran::walls::MovingPlane;
use nalgebra::Unit;

/// A body and its angular momentum (world frame). `body.angular_velocity` follows from it.
#[derive(Clone, Debug)]
pub struct Rigid {
    pub body: Body,
    pub momentum: Vector,
}

impl Rigid {
    pub fn new(body: Body) -> Self {
        let mut r = Rigid {
            body,
            momentum: Vector::zeros(),
        };
        let q = r.turn();
        let w = q.inverse_transform_vector(&Vector::from(r.body.angular_velocity));
        r.momentum = q * r.inertia().component_mul(&w);
        r
    }
    fn turn(&self) -> Rotation {
        rotation(self.body.quaternion)
    }
    /// Principal moments of a solid ellipsoid.
    fn inertia(&self) -> Vector {
        let a = self.body.semi_axes.map(|a| a * a);
        Vector::new(a[1] + a[2], a[0] + a[2], a[0] + a[1]) * (self.body.mass / 5.0)
    }
    fn set_angular_velocity(&mut self) {
        self.body.angular_velocity = array(self.angular_velocity_of(self.momentum));
    }
    fn angular_velocity_of(&self, momentum: Vector) -> Vector {
        let q = self.turn();
        let l = q.inverse_transform_vector(&momentum);
        q * l.component_div(&self.inertia())
    }
    /// What this load for this time adds to the motion.
    fn change(&self, (force, torque): (Vector, Vector), time: f64) -> MotionChange {
        MotionChange {
            velocity: plain(force * (time / self.body.mass)),
            omega: plain(self.angular_velocity_of(torque * time)),
        }
    }
    pub fn kinetic_energy(&self) -> f64 {
        let v = Vector::from(self.body.velocity);
        0.5 * self.body.mass * v.norm_squared()
            + 0.5 * self.momentum.dot(&Vector::from(self.body.angular_velocity))
    }
    pub fn kick(&mut self, force: Vector, torque: Vector, time: f64) {
        self.body.velocity =
            array(Vector::from(self.body.velocity) + force * (time / self.body.mass));
        self.momentum += torque * time;
        self.set_angular_velocity();
    }
    pub fn drift(&mut self, time: f64) {
        self.body.position = array(position(&self.body) + Vector::from(self.body.velocity) * time);
        let inertia = self.inertia();
        let mut q = self.turn();
        for (axis, part) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
            let direction = q * Vector::ith(axis, 1.0);
            let angle = self.momentum.dot(&direction) / inertia[axis] * part * time;
            q = Rotation::from_axis_angle(&Unit::new_normalize(direction), angle) * q;
        }
        self.body.quaternion = quaternion(Rotation::new_normalize(q.into_inner()));
        self.set_angular_velocity();
    }
    /// Runs backwards from now on.
    pub fn reverse(&mut self) {
        self.momentum = -self.momentum;
        self.body.velocity = self.body.velocity.map(|v| -v);
        self.set_angular_velocity();
    }
}

/// One body and a wall, or two bodies.
pub enum Partner {
    Wall(MovingPlane),
    Body(Rigid),
}

/// A contact in motion.
pub struct Motion<'a> {
    pub laws: &'a Laws,
    pub i: Rigid,
    pub j: Partner,
    pub memory: Memory,
    pub time_step: f64,
    /// On `i`, at all times.
    pub gravity: Vector,
    /// Which velocities viscous forces see.
    pub velocities: Velocities,
    /// The present contact.
    pub felt: Option<Felt>,
    /// Forces and torques of the step before, where they are known.
    before: Option<[(Vector, Vector); 2]>,
}

/// The velocities that viscous forces see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Velocities {
    /// Of half a step before.
    HalfStep,
    /// Extrapolated to the step.
    Step,
}

impl<'a> Motion<'a> {
    pub fn new(laws: &'a Laws, i: Body, j: Partner, time_step: f64) -> Self {
        let mut motion = Motion {
            laws,
            i: Rigid::new(i),
            j,
            memory: Memory::new(laws),
            time_step,
            gravity: Vector::zeros(),
            velocities: Velocities::HalfStep,
            felt: None,
            before: None,
        };
        motion.feel(0.0, None);
        motion
    }

    /// `loads` are those of the last step, extrapolated, where velocities of the step are wanted.
    fn feel(&mut self, time: f64, loads: Option<[(Vector, Vector); 2]>) {
        let half = 0.5 * time;
        let change_i = loads.map(|[load, _]| self.i.change(load, half));
        let i = (&self.i.body, change_i);
        self.felt = match &self.j {
            Partner::Wall(wall) => {
                advance_plane_at_step(self.laws, i, wall, time, &mut self.memory)
            }
            Partner::Body(j) => {
                let change_j = loads.map(|[_, load]| j.change(load, half));
                advance_at_step(self.laws, i, (&j.body, change_j), time, &mut self.memory)
            }
        };
    }

    /// Force and torque on `i` and `j`.
    fn loads(&self) -> [(Vector, Vector); 2] {
        let none = Vector::zeros();
        let (force, torque_i, torque_j) = self
            .felt
            .as_ref()
            .map_or((none, none, none), |f| (f.force, f.torque_i, f.torque_j));
        [
            (self.gravity * self.i.body.mass - force, torque_i),
            (force, torque_j),
        ]
    }

    fn kick(&mut self) {
        let time = 0.5 * self.time_step;
        let [on_i, on_j] = self.loads();
        self.i.kick(on_i.0, on_i.1, time);
        if let Partner::Body(j) = &mut self.j {
            j.kick(on_j.0, on_j.1, time);
        }
    }

    pub fn step(&mut self) {
        let loads = self.loads();
        let before = self.before.replace(loads).unwrap_or(loads);
        self.kick();
        self.i.drift(self.time_step);
        if let Partner::Body(j) = &mut self.j {
            j.drift(self.time_step);
        }
        let next = |k: usize| {
            let steadily = |now: Vector, then: Vector| {
                if now.dot(&then) < 0.0 {
                    Vector::zeros()
                } else {
                    now * 2.0 - then
                }
            };
            let (now, then) = (loads[k], before[k]);
            (steadily(now.0, then.0), steadily(now.1, then.1))
        };
        let extrapolated = (self.velocities == Velocities::Step).then(|| [next(0), next(1)]);
        self.feel(self.time_step, extrapolated);
        self.kick();
    }

    /// Steps until the bodies have touched and parted; false if they have not after `most` steps.
    pub fn collide(&mut self, most: usize) -> bool {
        let mut met = self.felt.is_some();
        for _ in 0..most {
            self.step();
            match (&self.felt, met) {
                (None, true) => return true,
                (Some(_), _) => met = true,
                (None, false) => {}
            }
        }
        false
    }

    pub fn reverse(&mut self) {
        self.i.reverse();
        if let Partner::Body(j) = &mut self.j {
            j.reverse();
        }
    }

    pub fn kinetic_energy(&self) -> f64 {
        self.i.kinetic_energy()
            + match &self.j {
                Partner::Wall(_) => 0.0,
                Partner::Body(j) => j.kinetic_energy(),
            }
    }

    /// Kinetic and elastic.
    pub fn energy(&self) -> f64 {
        self.kinetic_energy()
            + self.felt.as_ref().map_or(0.0, |f| {
                f.forces.elastic_energy + f.forces.tangential_energy
            })
    }
}
