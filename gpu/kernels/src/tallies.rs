// SPDX-License-Identifier: MIT OR Apache-2.0
//! Elastic energies and virial of the contacts of pairs, of what they are about to be computed from.

use crate::candidates::Candidate;
use crate::contacts::{forces_with_safeguards, Scene, TOUCHES};
use crate::shapes::Kind;
use ellgran::walls::one_particle::LONGEST_HISTORY;

/// Numbers of a [`tally_of_pair`].
pub const TALLIES: usize = 8;

/// Elastic energy of the normal and of the tangential deformation, and virial (xx yy zz xy xz yz), of a pair: half of it where one of its grains
/// is no owned one, which another row or another rank has too. Zeros where it does not touch. State and history are those of the last step, and
/// stay so.
pub fn tally_of_pair<K: Kind>(
    scene: &Scene<'_>,
    candidate: &Candidate,
    state: u32,
    history: &[f64],
    owned: usize,
) -> [f64; TALLIES] {
    let mut now = [0.0; LONGEST_HISTORY];
    let now = &mut now[..history.len()];
    now.copy_from_slice(history);
    let Some(f) = forces_with_safeguards::<K>(scene, candidate, now, state & TOUCHES != 0) else {
        return [0.0; TALLIES];
    };
    let [i, j] = candidate.pair();
    let d = scene.grains[j].centre() - scene.grains[i].centre();
    let weight = if i < owned && j < owned { 1.0 } else { 0.5 };
    [
        f.elastic_energy,
        f.tangential_energy,
        d.x * f.force.x,
        d.y * f.force.y,
        d.z * f.force.z,
        d.x * f.force.y,
        d.x * f.force.z,
        d.y * f.force.z,
    ]
    .map(|x| weight * x)
}
