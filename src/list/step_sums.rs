// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the pairs of a neighbour list add to the bound of the stable step of their particles.

use super::rows::{HaleBroke, ListError, NeighbourRows};
use crate::contact::pair::HaleRatio;
use crate::contact::stable_step::{ContactExtremes, StepContact, StepSums};
use crate::contact::{Laws, Particle};

/// Adds all touching pairs of a list to the sums of both their particles. `inverse_mass` is that of the inertia of a particle, 0 for a fixed
/// one; `identifier` names particles in `extremes`. What `sums` has then for ghosts belongs to their owners, where each pair is
/// listed by one rank alone.
///
/// # Errors
/// An entry that names no particle, or Hale's form, before anything is added.
pub fn add_pairs_to_step_sums(
    laws: &Laws,
    particles: &[Particle],
    inverse_mass: &dyn Fn(usize) -> f64,
    identifier: &dyn Fn(usize) -> i64,
    rows: &mut dyn NeighbourRows,
    sums: &mut [StepSums],
    extremes: &mut ContactExtremes,
) -> Result<(), ListError> {
    check_entries(particles.len(), rows)?;
    let look = |i: usize, j: usize| -> Result<Option<StepContact>, ListError> {
        let pair = [&particles[i], &particles[j]];
        let [a, b] = pair.map(|p| p.particle_type as usize);
        StepContact::of_pair(laws.get(a, b), pair, [inverse_mass(i), inverse_mass(j)])
            .map_err(|HaleRatio(ratio)| ListError::Hale(HaleBroke { i, j, ratio }))
    };
    if laws.features().hale {
        for_each_pair(rows, &mut |i, j| look(i, j).map(drop))?;
    }
    for_each_pair(rows, &mut |i, j| {
        if let Some(contact) = look(i, j)? {
            contact.add_to_first(&mut sums[i]);
            contact.add_to_second(&mut sums[j]);
            let types = [i, j].map(|k| particles[k].particle_type as usize);
            extremes.add(&contact, [i, j].map(identifier), types);
        }
        Ok(())
    })
}

fn for_each_pair(
    rows: &mut dyn NeighbourRows,
    of_pair: &mut dyn FnMut(usize, usize) -> Result<(), ListError>,
) -> Result<(), ListError> {
    let entries = rows.entries();
    for k in 0..rows.count() {
        let row = rows.row(k);
        for other in row
            .neighbours
            .iter()
            .filter_map(|&entry| entries.index(entry))
        {
            of_pair(row.central, other)?;
        }
    }
    Ok(())
}

fn check_entries(particles: usize, rows: &mut dyn NeighbourRows) -> Result<(), ListError> {
    let entries = rows.entries();
    for k in 0..rows.count() {
        let row = rows.row(k);
        let central = row.central;
        for (place, &entry) in row.neighbours.iter().enumerate() {
            if entries
                .index(entry)
                .is_some_and(|other| other >= particles || other == central)
            {
                return Err(ListError::Entry {
                    central,
                    place,
                    entry,
                });
            }
        }
    }
    Ok(())
}
