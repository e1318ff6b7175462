// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sums over contacts that an engine may ask for: energies, virial, counts.

use crate::geometry::Vector3;

/// What is asked for and its sums. A scene that asks for nothing passes none and pays nothing.
#[derive(Debug, Default)]
pub struct Tallies<'a> {
    /// Elastic energy per particle, added to (half to each body).
    pub particle_energies: Option<&'a mut [f64]>,
    /// Virial per particle (xx yy zz xy xz yz), added to (half to each body).
    pub particle_virials: Option<&'a mut [[f64; 6]]>,
    /// Elastic energy of the normal deformation.
    pub normal_elastic_energy: f64,
    /// Elastic energy of the tangential deformation.
    pub tangential_elastic_energy: f64,
    /// Time integral of the power of the viscous normal and of the whole tangential force; carried between steps.
    pub accumulated_work: f64,
    /// Sum of `d (x) F`, `F` the force on `j`: xx yy zz xy xz yz.
    pub virial: [f64; 6],
    /// Touching pairs; one that another rank lists too counts one half.
    pub touching: f64,
    /// Neighbour pairs.
    pub pairs: u64,
}

/// One contact's contribution.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contribution {
    pub normal_energy: f64,
    pub tangential_energy: f64,
    pub work: f64,
    pub d: Vector3,
    pub force: Vector3,
}

impl Tallies<'_> {
    /// Zeroes the sums of a step; what is carried between steps stays.
    pub(super) fn start_step(&mut self) {
        self.normal_elastic_energy = 0.0;
        self.tangential_elastic_energy = 0.0;
        self.virial = [0.0; 6];
        self.touching = 0.0;
        self.pairs = 0;
    }

    /// Energy that left the elastic store: the work done against viscous and tangential forces less what the tangential
    /// springs hold.
    pub fn dissipated_energy(&self) -> f64 {
        self.accumulated_work - self.tangential_elastic_energy
    }

    /// Adds a contact of `i` and `j`. `owned_j` is false where another rank adds the same contact too.
    #[inline(always)]
    pub(super) fn add(&mut self, i: usize, j: Option<usize>, owned_j: bool, c: &Contribution) {
        let weight = if owned_j { 1.0 } else { 0.5 };
        self.touching += weight;
        self.normal_elastic_energy += weight * c.normal_energy;
        self.tangential_elastic_energy += weight * c.tangential_energy;
        self.accumulated_work += weight * c.work;
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
}
