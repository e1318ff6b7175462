// SPDX-License-Identifier: MIT OR Apache-2.0
//! What one thread of calls keeps from step to step: particles prepared, candidates, recorded contacts.

use super::arrays::{prepare_one, ParticleArrays, ParticleShapes};
use super::candidates::Candidates;
use super::contact_records::ContactRecords;
use super::memory::{reserve, Allocated};
use super::preparation::{
    Prepare, PrepareChosen, PrepareChosenRecords, Prepared, PreparedForPairs,
};
use super::records::{ParticleRecords, Records, Shapes};
use super::rows::NeighbourRows;
use crate::contact::particle::{Particle, ParticleError};
use crate::contact::Laws;
use crate::simd::{InstructionSet, Line};

/// Who has prepared particles for the pairs of a list since they last changed.
#[derive(Clone, Copy, Debug)]
pub enum PreparedBy<'w> {
    /// Nobody, or nobody knows.
    Nobody,
    /// The workspace that is asked.
    Itself,
    /// Another one.
    Other(&'w Workspace),
}

/// Memory that one thread of calls keeps from step to step; grows only when the number of particles or of pairs does.
///
/// # Example
/// ```
/// use ellgran::contact::stable_step::{least_stable_step, ContactExtremes, SUMS};
/// use ellgran::contact::{Laws, Step};
/// use ellgran::list::{
///     add_pairs_to_step_sums, compute_pairs, Accumulators, Entries, NeighbourRow, NeighbourRows, ParticleArrays,
///     PreparedBy, Rotation, Workspace,
/// };
/// use ellgran::simd::InstructionSet;
/// use ellgran::tallies::GrainSums;
/// use ellgran::vector::Vector3;
///
/// // A list of one row: ball 0 has the neighbours 1 and 2.
/// struct Row {
///     neighbours: [i32; 2],
///     touching: [i32; 2],
///     history: Vec<f64>,
/// }
/// impl NeighbourRows for Row {
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
///     fn pair(&mut self, _: usize, entry: usize) -> (Option<&mut i32>, &mut [f64]) {
///         let length = self.history.len() / 2;
///         (Some(&mut self.touching[entry]), &mut self.history[entry * length..(entry + 1) * length])
///     }
///     fn entries(&self) -> Entries {
///         Entries::PLAIN
///     }
/// }
/// assert_eq!(Entries::PLAIN.index(7), Some(7));
///
/// // Three balls of 1 cm radius in a row along x, each 0.1 mm deep in the next (m, kg).
/// let words = ["hertz", "1e7", "0.3", "tangential", "mindlin", "0.5"];
/// let (parameters, _) = ellgran::force::syntax::parse(&words)?;
/// let laws = Laws::new(1, &[Some(parameters)], true)?;
/// let positions = [[0.0; 3], [-0.0199, 0.0, 0.0], [0.0199, 0.0, 0.0]];
/// let particles = ParticleArrays {
///     owned: 3,
///     positions: &positions,
///     velocities: &[[0.0; 3]; 3],
///     rotation: Rotation::Velocity(&[[0.0; 3]; 3]),
///     of_step: false,
///     changes: &[],
///     contact_masses: &[1e-2; 3],
///     types: &[1; 3],
///     shape: |_: usize| Some(([0.01; 3], [1.0, 0.0, 0.0, 0.0])),
///     identifier: |k| k as i64 + 1,
/// };
/// let mut rows = Row { neighbours: [1, 2], touching: [0; 2], history: vec![0.0; 2 * laws.layout().length] };
/// let mut workspace = Workspace::new(InstructionSet::choose()?);
/// workspace.keeps_history = true;
/// workspace.records_contacts = true;
/// workspace.prepare_for_pairs(&particles, &laws, false)?;
/// let (mut forces, mut torques) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
/// let mut accumulators =
///     Accumulators { forces: &mut forces, torques: &mut torques, reaction_below: 3, owned: 3 };
/// let step = Step { time_step: 1e-6, advance_history: true };
/// compute_pairs(&laws, &mut workspace, &mut rows, &step, &mut accumulators, None).expect("a valid list");
///
/// // The contacts as they acted, and what they add up to for each ball.
/// assert_eq!(workspace.contacts.as_slice().len(), 2);
/// let second = workspace.contacts.find(2, 0).expect("they touch");
/// assert!((workspace.contacts.as_slice()[second].geometry.penetration - 1e-4).abs() < 1e-12);
/// let mut sums = [GrainSums::default(); 3];
/// workspace.contacts.add_to_grain_sums(|k| Vector3::from_array(positions[k]), |_| true, &mut sums);
/// assert_eq!((sums[0].touching, sums[1].touching, sums[0].fabric[0]), (2.0, 1.0, 2.0));
///
/// // Histories are kept in the workspace until they are asked for.
/// assert!(workspace.has_unwritten_history() && workspace.bytes() > 0);
/// assert_eq!(workspace.kept_history_length(), laws.layout().length);
/// assert_eq!(workspace.kept_pairs().count(), 2);
/// workspace.write_history(&mut rows);
/// assert_eq!(rows.touching, [1, 1]);
/// assert!(!workspace.has_unwritten_history());
/// workspace.forget_list();
///
/// // The time step that the contacts allow: the middle ball has two of them.
/// workspace.prepare(&particles, laws.types())?;
/// let (mut step_sums, mut extremes) = ([[0.0; SUMS]; 3], ContactExtremes::default());
/// add_pairs_to_step_sums(&laws, workspace.particles(), &|_| 1e2, &|k| k as i64 + 1, &mut rows, &mut step_sums, &mut extremes)
///     .expect("a valid list");
/// assert_eq!((least_stable_step(&step_sums).1, extremes.touching), (Some(0), 2));
/// workspace.prepare_chosen(&particles, laws.types(), &[2])?;
/// assert_eq!(workspace.particles().len(), 1);
/// // For a wall: what the call for the pairs has prepared serves it.
/// workspace.prepare_chosen_records(&particles, laws.types(), &[1, 2], PreparedBy::Itself)?;
/// workspace.contacts.clear();
/// workspace.clear();
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Workspace {
    particles: Vec<Particle>,
    /// For the lanes.
    pub(super) records: Records,
    /// Of particles that were chosen.
    chosen: Records,
    /// Whether the records are those of the last call for pairs, which did not fail.
    prepared: bool,
    /// Pairs that may touch.
    pub(super) candidates: Candidates,
    /// What the pairs are computed on.
    pub instruction_set: InstructionSet,
    /// Whether histories stay here from step to step, until [`Workspace::write_history`] or a changed list.
    pub keeps_history: bool,
    /// Whether [`super::compute_pairs`] records every touching pair.
    pub records_contacts: bool,
    /// The touching pairs of the last call that recorded them; none after one that did not.
    pub contacts: ContactRecords,
    /// Whether the rows of the list were looked through since the list changed.
    pub(super) list_is_known: bool,
    /// Contacts so far that were deeper than Hertz' law allows ([`crate::geometry::ContactSearch::deep`]).
    pub deep_contacts: u64,
    /// Is told of large memory just allocated, with its length in bytes.
    pub allocated: Allocated,
}

impl Workspace {
    /// An empty workspace for an instruction set.
    pub fn new(instruction_set: InstructionSet) -> Self {
        Workspace {
            particles: Vec::new(),
            records: Records::default(),
            chosen: Records {
                shapes: Shapes::Spheroids,
                ..Records::default()
            },
            prepared: false,
            candidates: Candidates::default(),
            instruction_set,
            keeps_history: false,
            records_contacts: false,
            contacts: ContactRecords::default(),
            list_is_known: false,
            deep_contacts: 0,
            allocated: |_, _| (),
        }
    }

    /// Checks and prepares all particles, for one contact at a time.
    ///
    /// # Errors
    /// The first particle with a position, velocity, angular velocity or mass out of range ([`crate::contact::ranges`]), a
    /// shape or pose that is none, or a type out of range.
    pub fn prepare<S: ParticleShapes, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        types: usize,
    ) -> Result<(), ParticleError> {
        self.prepare_each(arrays, types, 0..arrays.positions.len())
    }

    /// Checks and prepares the particles `chosen` alone, in that order.
    ///
    /// # Errors
    /// As [`Workspace::prepare`].
    pub fn prepare_chosen<S: ParticleShapes, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        types: usize,
        chosen: &[usize],
    ) -> Result<(), ParticleError> {
        if self.instruction_set == InstructionSet::Scalar {
            return self.prepare_each(arrays, types, chosen.iter().copied());
        }
        self.make_room(arrays.positions.len(), chosen.len());
        let mut failure = None;
        self.instruction_set.run(PrepareChosen {
            arrays,
            chosen,
            types,
            particles: &mut self.particles,
            failure: &mut failure,
        });
        if failure.is_some() {
            self.particles.clear();
        }
        named(arrays, failure)
    }

    /// Checks the particles `chosen` and prepares records of them, in that order, for the lanes. What the workspace `prepared_by` has prepared
    /// of them for the pairs of a list, in its last call, is taken from there: the arrays must not have changed since. In its next call it
    /// prepares what was missing, as long as its candidates hold.
    ///
    /// # Errors
    /// As [`Workspace::prepare`].
    pub fn prepare_chosen_records<S: ParticleShapes, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        types: usize,
        chosen: &[usize],
        prepared_by: PreparedBy<'_>,
    ) -> Result<(), ParticleError> {
        let from = match prepared_by {
            PreparedBy::Nobody => None,
            PreparedBy::Itself => self.prepared.then_some((&self.records, &self.candidates)),
            PreparedBy::Other(other) => other
                .prepared
                .then_some((&other.records, &other.candidates)),
        };
        let prepared = from
            .and_then(|(records, candidates)| Some((records, candidates.with_records()?)))
            .map(|(records, with_records)| PreparedForPairs::new(records, with_records))
            .filter(|prepared| prepared.are_of(arrays));
        // Those of the last call, as long as they serve: to look at all of them first would take longer.
        let mut shapes = match &prepared {
            None => self.chosen.shapes,
            Some(prepared) => prepared.shapes().max(Shapes::Spheroids),
        };
        loop {
            let r = &mut self.chosen;
            r.make_room(arrays, shapes, chosen.len(), self.allocated);
            let mut failure = None;
            let before = shapes;
            self.instruction_set.run(PrepareChosenRecords {
                arrays,
                chosen,
                // Those of ellipsoids have another form.
                prepared: prepared.filter(|p| {
                    (p.shapes() == Shapes::Ellipsoids) == (shapes == Shapes::Ellipsoids)
                }),
                types,
                records: r,
                shapes: &mut shapes,
                failure: &mut failure,
            });
            if shapes == before {
                return named(arrays, failure);
            }
        }
    }

    /// For `count` particles, of which there are at most `most`.
    fn make_room(&mut self, most: usize, count: usize) {
        if self.particles.capacity() < count {
            self.particles.reserve(most);
        }
        self.particles.resize(count, Particle::NONE);
    }

    fn prepare_each<S: ParticleShapes, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        types: usize,
        chosen: impl ExactSizeIterator<Item = usize>,
    ) -> Result<(), ParticleError> {
        self.make_room(arrays.positions.len(), chosen.len());
        for (particle, k) in self.particles.iter_mut().zip(chosen) {
            if let Err(what) = prepare_one(arrays, k, types, particle) {
                self.particles.clear();
                let identifier = (arrays.identifier)(k);
                return Err(ParticleError { identifier, what });
            }
        }
        Ok(())
    }

    /// Prepares the particles for the pairs of a neighbour list: all of them, or, where the list is `unchanged` since the
    /// last call and no particle has moved far since then, those that have a neighbour near enough to touch.
    ///
    /// `unchanged` says that particles, their order, the list and its histories are those of the last call; else what is kept
    /// here and was not written is lost.
    ///
    /// # Errors
    /// As [`Workspace::prepare`]. A particle that cannot touch any other is checked for a finite pose in every call, for
    /// the rest when the list changes.
    pub fn prepare_for_pairs<S: ParticleShapes, I: Fn(usize) -> i64>(
        &mut self,
        arrays: &ParticleArrays<'_, S, I>,
        laws: &Laws,
        unchanged: bool,
    ) -> Result<(), ParticleError> {
        let types = laws.types();
        self.list_is_known &= unchanged;
        self.prepared = false;
        if !self.works_in_lanes(laws) {
            return self.prepare(arrays, types);
        }
        let count = arrays.positions.len();
        let with_masses = !arrays.contact_masses.is_empty();
        let with_changes = !arrays.changes.is_empty();
        let same_contents = with_masses != self.records.inverse_masses.is_empty()
            && with_changes != self.records.changes.is_empty()
            && arrays.of_step == self.records.of_step;
        let mut outcome = Prepared::default();
        if !unchanged {
            // Of another list: there is no place any more for what was kept.
            self.candidates.batches.discard();
        }
        if unchanged && same_contents {
            let mut hold = self.candidates.are_for(count);
            if hold {
                hold = self.candidates.count_step();
                if !hold {
                    self.candidates.adapt_at_end(arrays);
                }
            }
            if hold {
                self.instruction_set.run(Prepare {
                    arrays,
                    candidates: Some(&self.candidates),
                    types,
                    records: &mut self.records,
                    outcome: &mut outcome,
                });
                hold = !outcome.moved;
                if !hold {
                    self.candidates.adapt_when_left();
                }
            }
            // Batches are made of pairs of one kind of law.
            if hold && !outcome.types_changed {
                self.prepared = outcome.failure.is_none();
                return named(arrays, outcome.failure);
            }
            outcome = Prepared::default();
        }
        self.candidates.forget();
        let r = &mut self.records;
        r.make_room(arrays, Shapes::of_all(arrays), count, self.allocated);
        self.instruction_set.run(Prepare {
            arrays,
            candidates: None,
            types,
            records: &mut *r,
            outcome: &mut outcome,
        });
        named(arrays, outcome.failure)?;
        r.sums.clear();
        reserve(&mut r.sums, count, self.allocated);
        r.sums.resize(count, Line::ZERO);
        self.candidates.begin(arrays, self.allocated);
        self.prepared = true;
        Ok(())
    }

    /// Whether the pairs under these laws are taken in lanes. Hale's form breaks where the exact one does not, and is not
    /// in the lanes.
    pub(super) fn works_in_lanes(&self, laws: &Laws) -> bool {
        self.instruction_set != InstructionSet::Scalar && !laws.features().hale
    }

    /// Whether the list's own histories are behind those that are kept here.
    pub fn has_unwritten_history(&self) -> bool {
        self.candidates.batches.are_unwritten()
    }

    /// Doubles that the list of the last call remembers of a pair.
    pub fn kept_history_length(&self) -> usize {
        self.candidates.batches.written_length()
    }

    /// The pairs of which histories are kept, by central particle and place in its row.
    pub fn kept_pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.candidates.batches.pairs()
    }

    /// Forgets the list of the last call and what is kept of it.
    pub fn forget_list(&mut self) {
        self.candidates.batches.discard();
        self.clear();
    }

    /// Brings the histories of the list of the last call up to date.
    pub fn write_history<R: NeighbourRows>(&mut self, rows: &mut R) {
        self.candidates.batches.write(rows);
    }

    /// Forgets the particles; keeps the memory.
    pub fn clear(&mut self) {
        self.particles.clear();
        self.chosen.records.clear();
        self.records.records.clear();
        self.candidates.forget();
        self.prepared = false;
        self.list_is_known = false;
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.particles.capacity() * core::mem::size_of::<Particle>()
            + self.records.bytes()
            + self.chosen.bytes()
            + self.candidates.bytes()
            + self.contacts.bytes()
    }

    /// The records of [`Workspace::prepare_chosen_records`], which was told of the same workspace.
    ///
    /// # Panics
    /// That was told of one, and this is not.
    pub fn chosen_records<'a>(&'a self, prepared_by: PreparedBy<'a>) -> ParticleRecords<'a> {
        self.chosen.view(match prepared_by {
            PreparedBy::Nobody => None,
            PreparedBy::Itself => Some(&self.records),
            PreparedBy::Other(other) => Some(&other.records),
        })
    }

    /// The particles prepared one at a time.
    pub fn particles(&self) -> &[Particle] {
        &self.particles
    }
}

/// The failure, with the name of its particle.
fn named<S: ParticleShapes, I: Fn(usize) -> i64>(
    arrays: &ParticleArrays<'_, S, I>,
    failure: Option<(usize, String)>,
) -> Result<(), ParticleError> {
    match failure {
        None => Ok(()),
        Some((k, what)) => Err(ParticleError {
            identifier: (arrays.identifier)(k),
            what,
        }),
    }
}
