// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sums over contacts that an engine may ask for: energies, virial, counts.
//!
//! # Example
//! ```
//! use ellgran::tallies::{GrainSums, InelasticLoad, Tallies};
//! use ellgran::vector::Vector3;
//!
//! // A ball that slides to the right at 1 m/s; friction of 2 N on it, to the left, for half a step of 1 ms.
//! let load = InelasticLoad {
//!     tangential_force: [-2.0, 0.0, 0.0],
//!     ..InelasticLoad::default()
//! };
//! assert!(!load.is_zero());
//! assert_eq!(load.powers([1.0, 0.0, 0.0], [0.0; 3]), [0.0, -2.0]);
//! let mut tallies = Tallies::default();
//! tallies.add_half_step(0.5e-3, [(0, &load)], |_| ([1.0, 0.0, 0.0], [0.0; 3]));
//! assert!((tallies.frictional_dissipation() - 1e-3).abs() < 1e-18);
//! // Where a body answers torques by its inertia, what acts on it is replaced by what it feels.
//! let mut turned = InelasticLoad { tangential_torque: [0.0, 0.0, 4.0], ..load };
//! turned.respond(|torque| torque * 0.5);
//! assert_eq!(turned.tangential_torque, [0.0, 0.0, 2.0]);
//!
//! // Fabric and stress of a grain of radius 1 cm that is pressed from both sides along x with 3 N.
//! let mut sums = GrainSums::default();
//! for side in [-1.0, 1.0] {
//!     let normal = Vector3::new(side, 0.0, 0.0);
//!     sums.touching += 1.0;
//!     sums.add(normal, normal * 0.01, normal * -3.0);
//! }
//! assert_eq!((sums.touching, sums.fabric[0]), (2.0, 2.0));
//! assert!((sums.stress[0] + 0.06).abs() < 1e-15);
//! ```

use crate::vector::Vector3;

/// What is asked for and its sums. A scene that asks for nothing passes none and pays nothing.
#[derive(Debug, Default)]
pub struct Tallies<'a> {
    /// Elastic energy per particle, added to (half to each body).
    pub particle_energies: Option<&'a mut [f64]>,
    /// Virial per particle (xx yy zz xy xz yz), added to (half to each body).
    pub particle_virials: Option<&'a mut [[f64; 6]]>,
    /// Elastic energy of the normal deformation, that of the springs of `viscosity memory` too.
    pub normal_elastic_energy: f64,
    /// Elastic energy of the tangential deformation, of rolling and of twisting.
    pub tangential_elastic_energy: f64,
    /// Where the loads that are not elastic are wanted, one entry per particle: overwritten. With them the work of these
    /// loads is that of half a step, to which [`Tallies::add_half_step`] adds the other half.
    pub inelastic_loads: Option<&'a mut [InelasticLoad]>,
    /// Energy that viscous forces took up; carried between steps.
    pub viscous_dissipation: f64,
    /// Energy that the tangential forces and what resists rolling and twisting took up, without their viscous parts, of which
    /// the tangential displacements and the springs of rolling and twisting hold some; carried between steps.
    pub tangential_work: f64,
    /// Power of the viscous forces, and of the rest of the tangential forces, on the walls: force on a wall times its
    /// velocity. With the loads alone.
    pub wall_powers: [f64; 2],
    /// Sum of `d (x) F`, `F` the force on `j`: xx yy zz xy xz yz.
    pub virial: [f64; 6],
    /// Touching pairs; one that another rank lists too counts one half.
    pub touching: f64,
    /// Neighbour pairs.
    pub pairs: u64,
}

/// What acts on a particle beside the gradient of the normal elastic energy.
///
/// [`InelasticLoad::respond`] makes of a torque, where an engine keeps angular momenta, what gives the power when it is
/// multiplied by an angular momentum: the inverse inertia times the torque.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct InelasticLoad {
    /// Force of the viscous terms.
    pub viscous_force: [f64; 3],
    /// Its torque about the centre.
    pub viscous_torque: [f64; 3],
    /// Tangential force without its viscous part.
    pub tangential_force: [f64; 3],
    /// Its torque about the centre.
    pub tangential_torque: [f64; 3],
}

impl InelasticLoad {
    /// Whether nothing acts.
    pub fn is_zero(&self) -> bool {
        *self == Self::default()
    }

    /// Replaces the torques by what `response` makes of them.
    pub fn respond(&mut self, response: impl Fn(Vector3) -> Vector3) {
        for torque in [&mut self.viscous_torque, &mut self.tangential_torque] {
            *torque = response(Vector3::from_array(*torque)).to_array();
        }
    }

    /// Powers of the viscous force and of the other, for a velocity and an angular velocity (or momentum).
    pub fn powers(&self, velocity: [f64; 3], rotation: [f64; 3]) -> [f64; 2] {
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        [
            dot(&self.viscous_force, &velocity) + dot(&self.viscous_torque, &rotation),
            dot(&self.tangential_force, &velocity) + dot(&self.tangential_torque, &rotation),
        ]
    }

    /// Adds two torques.
    fn add_torques(&mut self, viscous: Vector3, tangential: Vector3) {
        for (target, v) in [
            (&mut self.viscous_torque, viscous),
            (&mut self.tangential_torque, tangential),
        ] {
            target[0] += v.x;
            target[1] += v.y;
            target[2] += v.z;
        }
    }

    /// Adds two forces that act at a point `arm` from the centre.
    #[inline(always)]
    fn add(&mut self, viscous: Vector3, tangential: Vector3, arm: Vector3) {
        for (target, v) in [
            (&mut self.viscous_force, viscous),
            (&mut self.viscous_torque, arm.cross(viscous)),
            (&mut self.tangential_force, tangential),
            (&mut self.tangential_torque, arm.cross(tangential)),
        ] {
            target[0] += v.x;
            target[1] += v.y;
            target[2] += v.z;
        }
    }
}

/// What the contacts of one particle add up to. Sums over parts of the contacts, as those that another rank knows, add.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct GrainSums {
    /// Number of particles that it touches.
    pub touching: f64,
    /// Number of contacts with walls.
    pub wall_contacts: f64,
    /// Sum of `n (x) n` over all of them, `n` the unit normal: xx yy zz xy xz yz. Its trace is their number.
    pub fabric: [f64; 6],
    /// Sum of `l (x) F` over all of them, its symmetric part: `l` from the centre of the particle to the contact, `F` the force on the
    /// particle: xx yy zz xy xz yz. It is the mean stress in the particle, tension positive, times a volume, as far as contacts go (Love
    /// 1927). What the symmetric part leaves out is the torque of the forces.
    pub stress: [f64; 6],
}

impl GrainSums {
    /// Adds the normal and the force of a contact, which is not counted. The sign of `normal` is of no account; `arm` leads from the centre of
    /// the particle to the contact, `force` is that on the particle.
    pub fn add(&mut self, normal: Vector3, arm: Vector3, force: Vector3) {
        let both = |a: Vector3, b: Vector3| {
            [
                a.x * b.x,
                a.y * b.y,
                a.z * b.z,
                0.5 * (a.x * b.y + a.y * b.x),
                0.5 * (a.x * b.z + a.z * b.x),
                0.5 * (a.y * b.z + a.z * b.y),
            ]
        };
        for (sum, term) in self.fabric.iter_mut().zip(both(normal, normal)) {
            *sum += term;
        }
        for (sum, term) in self.stress.iter_mut().zip(both(arm, force)) {
            *sum += term;
        }
    }
}

/// One contact's contribution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contribution {
    pub normal_energy: f64,
    pub tangential_energy: f64,
    /// Time of the step times the power of the viscous and of the other tangential forces, with the velocities given.
    pub works: [f64; 2],
    /// Energy that the memory of the normal force dissipated in the step, whatever acts on the bodies.
    pub relaxed: f64,
    pub d: Vector3,
    pub force: Vector3,
    /// On `j`.
    pub viscous_force: Vector3,
    /// On `j`.
    pub tangential_force: Vector3,
    /// From the centre of `i`.
    pub contact_point: Vector3,
    /// Of a wall.
    pub wall_velocity: Vector3,
}

/// What the couple of a contact, which resists rolling and twisting, adds to its contribution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoupleContribution {
    /// Elastic energy of rolling and twisting.
    pub energy: f64,
    /// Time of the step times the power of the viscous and of the other torque, with the velocities given.
    pub works: [f64; 2],
    /// On `i`; on `j` the opposite.
    pub viscous_torque: Vector3,
    /// On `i`; on `j` the opposite.
    pub tangential_torque: Vector3,
    /// Of a wall.
    pub wall_angular_velocity: Vector3,
}

impl Tallies<'_> {
    /// Zeroes the sums of a step; what is carried between steps stays.
    pub(crate) fn start_step(&mut self) {
        self.normal_elastic_energy = 0.0;
        self.tangential_elastic_energy = 0.0;
        self.virial = [0.0; 6];
        self.touching = 0.0;
        self.pairs = 0;
        self.wall_powers = [0.0; 2];
        if let Some(loads) = self.inelastic_loads.as_deref_mut() {
            loads.fill(InelasticLoad::default());
        }
    }

    /// Energy that friction dissipated: what the tangential forces took up less what the tangential displacements hold. What
    /// a contact still held when it opened, slid or was let go as the contact shrank is in it.
    pub fn frictional_dissipation(&self) -> f64 {
        self.tangential_work - self.tangential_elastic_energy
    }

    /// Adds the work of loads and walls over half a step of this duration. `motion` gives velocity and rotation of a
    /// particle, by its index among the loads.
    ///
    /// Velocity Verlet lets a force do the work of its half of the step before, with the velocity that the particle had,
    /// and of the half after, with the velocity to which that force itself has led.
    pub fn add_half_step<'l>(
        &mut self,
        time: f64,
        loads: impl IntoIterator<Item = (usize, &'l InelasticLoad)>,
        motion: impl Fn(usize) -> ([f64; 3], [f64; 3]),
    ) {
        let [mut viscous, mut tangential] = self.wall_powers;
        for (k, load) in loads {
            if !load.is_zero() {
                let (velocity, rotation) = motion(k);
                let [v, t] = load.powers(velocity, rotation);
                viscous += v;
                tangential += t;
            }
        }
        // What the bodies gain, the contacts give.
        self.viscous_dissipation -= time * viscous;
        self.tangential_work -= time * tangential;
    }

    /// Adds a contact of `i` and `j`. `owned_j` is false where another rank adds the same contact too. `load_i` is where the load of
    /// `i` goes instead of [`Tallies::inelastic_loads`], if a wall keeps it.
    #[inline(always)]
    pub(crate) fn add(
        &mut self,
        i: usize,
        j: Option<usize>,
        owned_j: bool,
        c: &Contribution,
        load_i: Option<&mut InelasticLoad>,
    ) {
        let weight = if owned_j { 1.0 } else { 0.5 };
        self.touching += weight;
        self.normal_elastic_energy += weight * c.normal_energy;
        self.tangential_elastic_energy += weight * c.tangential_energy;
        self.viscous_dissipation += weight * c.relaxed;
        if self.inelastic_loads.is_none() && load_i.is_none() {
            self.viscous_dissipation += weight * c.works[0];
            self.tangential_work += weight * c.works[1];
        }
        let (d, f) = (c.d, c.force);
        let v = [
            d.x * f.x,
            d.y * f.y,
            d.z * f.z,
            d.x * f.y,
            d.x * f.z,
            d.y * f.z,
        ];
        for (sum, term) in self.virial.iter_mut().zip(v) {
            *sum += weight * term;
        }
        let (viscous, tangential) = (c.viscous_force, c.tangential_force);
        let loads = self.inelastic_loads.as_deref_mut();
        let is_wall_in_halves = j.is_none() && (loads.is_some() || load_i.is_some());
        match (load_i, loads) {
            (Some(load), _) => load.add(-viscous, -tangential, c.contact_point),
            (None, Some(loads)) => {
                loads[i].add(-viscous, -tangential, c.contact_point);
                if let Some(j) = j.filter(|_| owned_j) {
                    loads[j].add(viscous, tangential, c.contact_point - d);
                }
            }
            (None, None) => {}
        }
        if is_wall_in_halves {
            self.wall_powers[0] += viscous.dot(c.wall_velocity);
            self.wall_powers[1] += tangential.dot(c.wall_velocity);
        }
        // A wall has no share: all of the contact's energy and virial is the particle's.
        let share = if j.is_some() { 0.5 } else { 1.0 };
        let energy = share * (c.normal_energy + c.tangential_energy);
        for k in core::iter::once(i).chain(j.filter(|_| owned_j)) {
            if let Some(e) = self.particle_energies.as_deref_mut() {
                e[k] += energy;
            }
            if let Some(w) = self.particle_virials.as_deref_mut() {
                for (sum, term) in w[k].iter_mut().zip(v) {
                    *sum += share * term;
                }
            }
        }
    }

    /// Adds the couple of a contact that was added with [`Tallies::add`]; the arguments are the same.
    pub(crate) fn add_couple(
        &mut self,
        i: usize,
        j: Option<usize>,
        owned_j: bool,
        c: &CoupleContribution,
        load_i: Option<&mut InelasticLoad>,
    ) {
        let weight = if owned_j { 1.0 } else { 0.5 };
        self.tangential_elastic_energy += weight * c.energy;
        let (viscous, tangential) = (c.viscous_torque, c.tangential_torque);
        let loads = self.inelastic_loads.as_deref_mut();
        let in_halves = loads.is_some() || load_i.is_some();
        match (load_i, loads) {
            (Some(load), _) => load.add_torques(viscous, tangential),
            (None, Some(loads)) => {
                loads[i].add_torques(viscous, tangential);
                if let Some(j) = j.filter(|_| owned_j) {
                    loads[j].add_torques(-viscous, -tangential);
                }
            }
            (None, None) => {}
        }
        if !in_halves {
            self.viscous_dissipation += weight * c.works[0];
            self.tangential_work += weight * c.works[1];
        } else if j.is_none() {
            self.wall_powers[0] -= viscous.dot(c.wall_angular_velocity);
            self.wall_powers[1] -= tangential.dot(c.wall_angular_velocity);
        }
        let share = if j.is_some() { 0.5 } else { 1.0 };
        for k in core::iter::once(i).chain(j.filter(|_| owned_j)) {
            if let Some(e) = self.particle_energies.as_deref_mut() {
                e[k] += share * c.energy;
            }
        }
    }
}
