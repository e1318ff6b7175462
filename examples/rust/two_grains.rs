// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two viscoelastic ellipsoids of aspect ratio 2 in an oblique collision with friction: the contact law alone, one
//! contact over a small time loop. SI units.
//!
//! ```text
//! cargo run --release --example two_grains
//! ```
//!
//! Prints what `examples/c/two_grains.c` prints, and shows there: a line every 100 steps while the grains touch, then the
//! velocities after.

use std::fmt::Write as _;

use ellgran::contact::prepare_body;
use ellgran::contact::{one_contact, Body, Laws, Step};
use ellgran::force::syntax;
use ellgran::geometry::Ellipsoid;
use ellgran::vector::Vector3;

const DENSITY: f64 = 2500.0;
const TIME_STEP: f64 = 1e-6;
const STEPS: usize = 1500;

struct Grain {
    body: Body,
    /// Principal moments of inertia, along the body axes.
    inertia: [f64; 3],
    /// World frame.
    angular_momentum: Vector3,
}

impl Grain {
    /// At `(x, 0, z)`, tilted by an angle in degrees about y.
    fn new(identifier: i64, [x, z]: [f64; 2], tilt: f64, [vx, vz]: [f64; 2]) -> Grain {
        let semi_axes = [0.005, 0.005, 0.01];
        let [a, b, c] = semi_axes;
        let mass = DENSITY * 4.0 / 3.0 * std::f64::consts::PI * a * b * c;
        let (sin, cos) = (0.5 * tilt.to_radians()).sin_cos();
        Grain {
            body: Body {
                position: [x, 0.0, z],
                quaternion: [cos, 0.0, sin, 0.0],
                semi_axes,
                velocity: [vx, 0.0, vz],
                angular_velocity: [0.0; 3],
                mass,
                particle_type: 1,
                identifier,
            },
            inertia: [b * b + c * c, a * a + c * c, a * a + b * b].map(|s| 0.2 * mass * s),
            angular_momentum: Vector3::ZERO,
        }
    }

    fn angular_velocity(&self, quaternion: [f64; 4]) -> Vector3 {
        let axes = Ellipsoid::new(self.body.semi_axes, quaternion)
            .expect("a turned quaternion is one")
            .axes;
        axes.iter()
            .zip(self.inertia)
            .fold(Vector3::ZERO, |sum, (axis, inertia)| {
                sum + *axis * (axis.dot(self.angular_momentum) / inertia)
            })
    }

    /// Velocity Verlet: the first half of a step. The force is then that at the new place, with the velocities of half
    /// way.
    fn start_step(&mut self, force: Vector3, torque: Vector3) {
        self.kick(force, torque);
        let v = Vector3::from_array(self.body.velocity);
        let x = Vector3::from_array(self.body.position);
        self.body.position = (x + v * TIME_STEP).to_array();
        let q = self.body.quaternion;
        let half_way = turned(q, self.angular_velocity(q), 0.5 * TIME_STEP);
        self.body.quaternion = turned(q, self.angular_velocity(half_way), TIME_STEP);
        self.update_spin();
    }

    fn finish_step(&mut self, force: Vector3, torque: Vector3) {
        self.kick(force, torque);
        self.update_spin();
    }

    fn kick(&mut self, force: Vector3, torque: Vector3) {
        let v = Vector3::from_array(self.body.velocity);
        self.body.velocity = (v + force * (0.5 * TIME_STEP / self.body.mass)).to_array();
        self.angular_momentum = self.angular_momentum + torque * (0.5 * TIME_STEP);
    }

    fn update_spin(&mut self) {
        self.body.angular_velocity = self.angular_velocity(self.body.quaternion).to_array();
    }

    fn kinetic_energy(&self) -> f64 {
        let v = Vector3::from_array(self.body.velocity);
        let omega = Vector3::from_array(self.body.angular_velocity);
        0.5 * self.body.mass * v.norm_squared() + 0.5 * omega.dot(self.angular_momentum)
    }
}

/// A quaternion turned by an angular velocity over a time.
fn turned(q: [f64; 4], omega: Vector3, time: f64) -> [f64; 4] {
    let speed = omega.norm();
    let s = if speed > 0.0 {
        (0.5 * speed * time).sin() / speed
    } else {
        0.0
    };
    let (w, v) = ((0.5 * speed * time).cos(), omega * s);
    [
        w * q[0] - v.x * q[1] - v.y * q[2] - v.z * q[3],
        w * q[1] + v.x * q[0] + v.y * q[3] - v.z * q[2],
        w * q[2] - v.x * q[3] + v.y * q[0] + v.z * q[1],
        w * q[3] + v.x * q[2] - v.y * q[1] + v.z * q[0],
    ]
}

/// The collision, and what is to be printed of it.
pub fn collide() -> Result<String, Box<dyn std::error::Error>> {
    //                E      nu     eta1   eta2                          mu
    let words = [
        "nfd",
        "1e7",
        "0.3",
        "400",
        "400",
        "tangential",
        "tfd",
        "0.5",
    ];
    let (parameters, _) = syntax::parse(&words)?;
    let laws = Laws::new(1, &[Some(parameters)], true)?;
    let step = Step {
        time_step: TIME_STEP,
        advance_history: true,
    };
    let mut history = vec![0.0; laws.layout().length];
    let mut touching = false;

    let mut i = Grain::new(1, [0.0, -0.006], 60.0, [0.0, 0.0]);
    let mut j = Grain::new(2, [0.003, 0.0061], -75.0, [-0.25, -0.5]);
    let before = i.kinetic_energy() + j.kinetic_energy();
    let (mut force, mut torque_i, mut torque_j) = (Vector3::ZERO, Vector3::ZERO, Vector3::ZERO);
    let mut work = 0.0;
    let mut text = String::new();
    writeln!(
        text,
        "   time/us  delta/um     F_n/N     F_t/N  elastic/uJ  dissipated/uJ   total/uJ"
    )?;
    for count in 1..=STEPS {
        i.start_step(-force, torque_i);
        j.start_step(force, torque_j);
        let types = Some(laws.types());
        let (body_i, body_j) = (prepare_body(&i.body, types)?, prepare_body(&j.body, types)?);
        let contact = one_contact(&laws, &body_i, &body_j, &step, &mut touching, &mut history)
            .map_err(|ratio| format!("Hale's form breaks at {ratio:?}"))?;
        (force, torque_i, torque_j) = match &contact {
            Some((_, f)) => (f.force, f.torque_i, f.torque_j),
            None => (Vector3::ZERO, Vector3::ZERO, Vector3::ZERO),
        };
        i.finish_step(-force, torque_i);
        j.finish_step(force, torque_j);
        let Some((geometry, f)) = contact else {
            continue;
        };
        work += TIME_STEP * (f.viscous_power + f.tangential_power);
        if count % 100 == 0 {
            let elastic = f.elastic_energy + f.tangential_energy;
            let dissipated = work - f.tangential_energy;
            let total = i.kinetic_energy() + j.kinetic_energy() + elastic + dissipated;
            writeln!(
                text,
                "{:10.0} {:9.2} {:9.3} {:9.3} {:11.3} {:14.3} {:10.2}",
                1e6 * count as f64 * TIME_STEP,
                1e6 * geometry.penetration,
                f.normal_force,
                f.tangential_force.norm(),
                1e6 * elastic,
                1e6 * dissipated,
                1e6 * total,
            )?;
        }
    }
    let (a, b) = (&i.body, &j.body);
    writeln!(
        text,
        "velocities after: ({:.4}, {:.4}) and ({:.4}, {:.4}) m/s, spins {:.2} and {:.2} rad/s",
        a.velocity[0],
        a.velocity[2],
        b.velocity[0],
        b.velocity[2],
        a.angular_velocity[1],
        b.angular_velocity[1],
    )?;
    writeln!(
        text,
        "dissipated: {:.1} % of the energy",
        100.0 * work / before
    )?;
    let after = i.kinetic_energy() + j.kinetic_energy() + work;
    let strayed = (after - before).abs() / before;
    if touching || strayed > 1e-3 {
        return Err(format!("energy strayed by {strayed} of itself").into());
    }
    Ok(text)
}

#[allow(dead_code)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    print!("{}", collide()?);
    Ok(())
}
