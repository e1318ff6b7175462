// SPDX-License-Identifier: MIT OR Apache-2.0
//! The hot loop: all pairs of an engine's neighbour list, one call a step.
//!
//! A pair is rejected by its bounding spheres, else by one evaluation with the cached normal; what is left goes through
//! the contact search, the law and the scatter. Nothing is allocated.

use super::lane_pass::in_lanes;
use super::rows::{check_history, Accumulators, HaleBroke, ListError, NeighbourRows};
use super::scalar_pass::Pass;
use super::workspace::Workspace;
use crate::contact::history::cached_normal;
use crate::contact::pair::{contact_of, hale_holds, HaleRatio, Pair};
use crate::contact::particle::Particle;
use crate::contact::{HistoryLayout, Laws, Step};
use crate::tallies::Tallies;

/// All pairs of the list. The workspace's particles are prepared ([`Workspace::prepare_for_pairs`]). Returns how many
/// contacts were deeper than Hertz' law allows. Where [`Workspace::records_contacts`] is set, the touching pairs are in
/// [`Workspace::contacts`] then.
///
/// # Errors
/// What is wrong with the list, before any force is written.
///
/// # Example
/// Two particles, of which the first has the second in its row; consistent units:
/// ```
/// use ellgran::contact::{Laws, Step};
/// use ellgran::list::{
///     compute_pairs, Accumulators, Entries, NeighbourRow, NeighbourRows, ParticleArrays, Rotation, Workspace,
/// };
/// use ellgran::simd::InstructionSet;
///
/// struct Rows {
///     neighbours: [i32; 1],
///     touching: [i32; 1],
///     history: Vec<f64>,
/// }
///
/// impl NeighbourRows for Rows {
///     fn count(&self) -> usize {
///         1
///     }
///     fn row(&mut self, _: usize) -> NeighbourRow<'_> {
///         NeighbourRow {
///             central: 0,
///             neighbours: &self.neighbours,
///             touching: &mut self.touching,
///             history: &mut self.history,
///         }
///     }
///     fn pair(&mut self, _: usize, _: usize) -> (Option<&mut i32>, &mut [f64]) {
///         (Some(&mut self.touching[0]), &mut self.history)
///     }
///     fn entries(&self) -> Entries {
///         Entries::PLAIN
///     }
/// }
///
/// let (parameters, _) = ellgran::force::syntax::parse(&["hertz", "1e6", "0.3", "tangential", "mindlin", "0.5"])?;
/// let laws = Laws::new(1, &[Some(parameters)], true)?;
/// let mut rows = Rows { neighbours: [1], touching: [0], history: vec![0.0; laws.layout().length] };
/// let mut workspace = Workspace::new(InstructionSet::choose()?);
/// let shape = |_: usize| Some(([2.0, 1.0, 1.0], [1.0, 0.0, 0.0, 0.0]));
/// let particles = ParticleArrays {
///     owned: 2,
///     positions: &[[0.0; 3], [0.0, 0.0, 1.99]],
///     velocities: &[[0.0; 3]; 2],
///     rotation: Rotation::Velocity(&[[0.0; 3]; 2]),
///     of_step: false,
///     changes: &[],
///     contact_masses: &[],
///     types: &[1, 1],
///     shape,
///     identifier: |k| k as i64 + 1,
/// };
/// // Whether particles and list are those of the last call.
/// let unchanged = false;
/// workspace.prepare_for_pairs(&particles, &laws, unchanged)?;
/// let (mut forces, mut torques) = ([[0.0; 3]; 2], [[0.0; 3]; 2]);
/// let mut accumulators =
///     Accumulators { forces: &mut forces, torques: &mut torques, reaction_below: 2, owned: 2 };
/// let step = Step { time_step: 1e-6, advance_history: true };
/// compute_pairs(&laws, &mut workspace, &mut rows, &step, &mut accumulators, None).expect("a valid list");
/// assert!(forces[1][2] > 0.0 && forces[0][2] == -forces[1][2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn compute_pairs<R: NeighbourRows>(
    laws: &Laws,
    workspace: &mut Workspace,
    rows: &mut R,
    step: &Step,
    accumulators: &mut Accumulators<'_>,
    tallies: Option<&mut Tallies<'_>>,
) -> Result<u64, ListError> {
    let in_batches = workspace.works_in_lanes(laws) && !workspace.records.records.is_empty();
    if in_batches && !workspace.candidates.are_valid() {
        workspace.candidates.batches.write(rows);
    }
    let deep_contacts = compute_rows(laws, workspace, rows, step, accumulators, tallies)?;
    if in_batches && !workspace.keeps_history {
        workspace.candidates.batches.write(rows);
    }
    Ok(deep_contacts)
}

/// [`compute_pairs`] without the histories that are kept in batches.
fn compute_rows(
    laws: &Laws,
    workspace: &mut Workspace,
    rows: &mut dyn NeighbourRows,
    step: &Step,
    accumulators: &mut Accumulators<'_>,
    mut tallies: Option<&mut Tallies<'_>>,
) -> Result<u64, ListError> {
    workspace.contacts.clear();
    let features = laws.features();
    if !workspace.works_in_lanes(laws) && !workspace.list_is_known {
        check_rows(&laws.layout(), workspace.particles().len(), rows)?;
        workspace.list_is_known = true;
    }
    if features.hale {
        check_hale(laws, workspace.particles(), rows).map_err(ListError::Hale)?;
    }
    if let Some(t) = tallies.as_deref_mut() {
        t.start_step();
    }
    let rate = features.viscous || features.friction || tallies.is_some();
    // Lent to the pass, which has the workspace beside it.
    let mut recorded = core::mem::take(&mut workspace.contacts);
    let records = workspace.records_contacts;
    let pass = Pass {
        laws,
        layout: laws.layout(),
        rows,
        step,
        accumulators,
        tallies,
        recorded: records.then_some(&mut recorded),
        deep_contacts: 0,
    };
    let deep_contacts = match (features.friction, rate) {
        // One kernel with all terms, of which the laws use theirs, serves all scenes. What resists rolling and twisting goes on from
        // what it records. It alone has the memory of the normal force, so that the others, and who builds them, do not pay for it.
        _ if records || features.resistance || features.memory => {
            take::<true, true, true>(pass, workspace)
        }
        (true, _) => take::<true, true, false>(pass, workspace),
        (false, true) => take::<false, true, false>(pass, workspace),
        (false, false) => take::<false, false, false>(pass, workspace),
    };
    if deep_contacts.is_ok() {
        recorded.sort();
    } else {
        recorded.clear();
    }
    workspace.contacts = recorded;
    deep_contacts
}

/// In lanes, or pair by pair.
fn take<const FRICTION: bool, const RATE: bool, const RECORD: bool>(
    pass: Pass<'_, '_, '_>,
    workspace: &mut Workspace,
) -> Result<u64, ListError> {
    if workspace.works_in_lanes(pass.laws) {
        in_lanes::<FRICTION, RATE, RECORD>(pass, workspace)
    } else {
        Ok(pass.all_scalar::<FRICTION, RATE>(workspace.particles()))
    }
}

/// Goes through a new list for entries that name no particle and for histories that no call has written. In lanes the search
/// for candidates does so.
fn check_rows(
    layout: &HistoryLayout,
    particles: usize,
    rows: &mut dyn NeighbourRows,
) -> Result<(), ListError> {
    let entries = rows.entries();
    for k in 0..rows.count() {
        let row = rows.row(k);
        for (place, &entry) in row.neighbours.iter().enumerate() {
            let Some(other) = entries.index(entry) else {
                continue;
            };
            if other >= particles || other == row.central {
                return Err(ListError::Entry {
                    central: row.central,
                    place,
                    entry,
                });
            }
            if row.touching.get(place).is_some_and(|t| *t != 0) {
                let history = &row.history[place * layout.length..(place + 1) * layout.length];
                check_history(layout, history, row.central, other)?;
            }
        }
    }
    Ok(())
}

/// Geometry of all pairs, to refuse a contact at which Hale's form breaks before anything is written.
fn check_hale(
    laws: &Laws,
    particles: &[Particle],
    rows: &mut dyn NeighbourRows,
) -> Result<(), HaleBroke> {
    let layout = laws.layout();
    for k in 0..rows.count() {
        let central = rows.row(k).central;
        let i = &particles[central];
        for m in 0..rows.row(k).neighbours.len() {
            let entry = rows.row(k).neighbours[m];
            let Some(other) = rows.entries().index(entry) else {
                continue;
            };
            let j = &particles[other];
            if !laws
                .get(i.particle_type as usize, j.particle_type as usize)
                .kinds
                .hale
            {
                continue;
            }
            let row = rows.row(k);
            let cached = cached_normal(
                &layout,
                &row.history[m * layout.length..(m + 1) * layout.length],
            );
            if let Pair::Touching(found) = Pair::of(i, j, cached) {
                hale_holds(contact_of(&found, i, j).curvature()).map_err(|HaleRatio(ratio)| {
                    HaleBroke {
                        i: central,
                        j: other,
                        ratio,
                    }
                })?;
            }
        }
    }
    Ok(())
}
