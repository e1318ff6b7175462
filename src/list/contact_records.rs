// SPDX-License-Identifier: MIT OR Apache-2.0
//! The touching pairs of a neighbour list one by one: geometry and force of each, as they acted.

use super::batch::BatchRecords;
use crate::contact::couple::TurningContact;
use crate::contact::one_contact::OneContact;
use crate::contact::ContactForces;
use crate::force::memory::MOST_PARTS;
use crate::force::PairLaw;
use crate::geometry::relative_curvature;
use crate::tallies::GrainSums;
use crate::vector::{Symmetric2, Tangent, Vector3};

/// A touching pair of a list.
#[derive(Clone, Copy, Debug)]
pub struct ContactRecord {
    /// Index of the central particle.
    pub i: usize,
    /// Index of its neighbour.
    pub j: usize,
    /// Place of the neighbour in the row of the central particle.
    pub entry: usize,
    /// Whether its law has a contact ellipse.
    pub elliptical: bool,
    /// Where they touched.
    pub geometry: OneContact,
    /// What acted.
    pub forces: ContactForces,
}

/// The touching pairs of one call, in the order of the central particles' indices, then of their rows.
#[derive(Debug, Default)]
pub struct ContactRecords {
    all: Vec<ContactRecord>,
}

impl ContactRecords {
    /// None.
    pub fn clear(&mut self) {
        self.all.clear();
    }

    pub(super) fn push(&mut self, record: ContactRecord) {
        self.all.push(record);
    }

    /// Once all are there.
    pub(super) fn sort(&mut self) {
        self.all.sort_unstable_by_key(|r| (r.i, r.entry));
    }

    pub(super) fn bytes(&self) -> usize {
        self.all.capacity() * size_of::<ContactRecord>()
    }

    /// All of them.
    pub fn as_slice(&self) -> &[ContactRecord] {
        &self.all
    }

    /// Adds each contact to the sums of its central particle, and to those of its neighbour where `takes` says so of it. `position` gives the
    /// centre of a neighbour in the call that recorded them.
    pub fn add_to_grain_sums(
        &self,
        position: impl Fn(usize) -> Vector3,
        takes: impl Fn(usize) -> bool,
        sums: &mut [GrainSums],
    ) {
        for record in &self.all {
            let normal = record.geometry.normal;
            let force = record.forces.force;
            let of_i = &mut sums[record.i];
            of_i.touching += 1.0;
            of_i.add(normal, record.forces.contact_point, -force);
            if takes(record.j) {
                let arm = record.geometry.contact_point - position(record.j);
                let of_j = &mut sums[record.j];
                of_j.touching += 1.0;
                of_j.add(normal, arm, force);
            }
        }
    }

    /// Where the contact of two particles stands, whichever of them is the central one. The search goes as the logarithm of
    /// the number of contacts.
    pub fn find(&self, i: usize, j: usize) -> Option<usize> {
        let among = |central: usize, other: usize| {
            let first = self.all.partition_point(|r| r.i < central);
            self.all[first..]
                .iter()
                .take_while(|r| r.i == central)
                .position(|r| r.j == other)
                .map(|at| first + at)
        };
        among(i, j).or_else(|| among(j, i))
    }
}

/// What a lane left of a contact; `centre_i` is the centre of the first particle.
pub(super) fn of_lane(
    (i, j, entry): (usize, usize, usize),
    lane: usize,
    lines: &BatchRecords,
    law: &PairLaw,
    centre_i: Vector3,
) -> ContactRecord {
    let number = |line: usize, k: usize| lines.0[line][lane].0[k];
    let vector = |line: usize, k: usize| {
        Vector3::new(number(line, k), number(line, k + 1), number(line, k + 2))
    };
    let normal = vector(2, 0);
    let tangent = Tangent {
        u: vector(4, 0),
        v: vector(4, 3),
    };
    let curvature = relative_curvature(
        Symmetric2::new(number(3, 4), number(3, 5), number(3, 6)),
        &tangent,
    );
    let penetration = number(0, 7);
    let arm = vector(2, 3);
    let contact_point = centre_i + arm;
    let witness_i = contact_point + normal * (penetration * law.constants.share_i);
    ContactRecord {
        i,
        j,
        entry,
        elliptical: law.kinds.normal.elliptical,
        geometry: OneContact {
            touching: true,
            penetration,
            normal,
            contact_point,
            witness_i,
            witness_j: witness_i - normal * penetration,
            curvature_a: curvature.a,
            curvature_b: curvature.b,
            major_direction: curvature.major_direction,
        },
        forces: ContactForces {
            force: vector(0, 0),
            torque_i: vector(0, 3),
            torque_j: vector(1, 0),
            normal_force: number(0, 6),
            tangential_force: vector(1, 3),
            contact_point: arm,
            memory: vector(5, 0),
            // What is remembered is with the history.
            rests: [0.0; MOST_PARTS],
            relaxed_energy: number(5, 7),
            displacement: vector(3, 0),
            stiffness: number(5, 3),
            rate: number(3, 3),
            elastic_energy: number(2, 6),
            tangential_energy: number(2, 7),
            viscous_power: number(1, 6),
            tangential_power: number(1, 7),
            viscous_force: Vector3::new(number(3, 7), number(4, 6), number(4, 7)),
            frictional_force: vector(5, 4),
            frictional_couple: Vector3::ZERO,
            viscous_couple: Vector3::ZERO,
        },
    }
}

/// What a lane left of a contact, as far as rolling and twisting go; without what follows from velocities.
pub(super) fn turning_contact(lane: usize, lines: &BatchRecords) -> TurningContact {
    let number = |line: usize, k: usize| lines.0[line][lane].0[k];
    let vector = |line: usize, k: usize| {
        Vector3::new(number(line, k), number(line, k + 1), number(line, k + 2))
    };
    TurningContact {
        normal: vector(2, 0),
        tangent: Tangent {
            u: vector(4, 0),
            v: vector(4, 3),
        },
        curvature: Symmetric2::new(number(3, 4), number(3, 5), number(3, 6)),
        penetration: number(0, 7),
        rate: 0.0,
        normal_force: number(0, 6),
        stiffness: number(5, 3),
        omega: [Vector3::ZERO; 2],
        omega_change: Vector3::ZERO,
        // Springs that resist a twist are not in lanes.
        torque_of_springs: [0.0; 2],
    }
}

/// The contact point of a lane, from the centre of its first body.
pub(super) fn contact_point(lane: usize, lines: &BatchRecords) -> Vector3 {
    let line = &lines.0[2][lane].0;
    Vector3::new(line[3], line[4], line[5])
}
