// SPDX-License-Identifier: MIT OR Apache-2.0
//! A whole neighbour list in one call: the path for speed.

use super::growing::{given, growing};
use super::law::EllgranLaws;
use super::particles::{
    hale_failure, history_failure, identifier, prepare, EllgranParticles, EllgranStep,
    EllgranWorkspace, ListLook, Purpose,
};
use super::status::{
    at_border, required, required_mut, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT,
    ELLGRAN_ERROR_NULL_POINTER,
};
use super::tallies::{add_preceding_half_step, borrow, check_half_step, Asked, EllgranTallies};
use crate::list::{compute_pairs, ListError, NeighbourRow, NeighbourRows};
use crate::list::{Accumulators, Entries};

/// An engine's neighbour list: every pair once, in the row of one of its two particles.
///
/// Forces are computed for listed pairs only. So the list must hold each pair whose centres are closer than the sum of
/// their two largest semi-axes plus a margin. It can be used until a particle has moved by half of the margin since the
/// list was built. Further pairs do not change the result.
///
/// `touching` and `history` belong to the caller, who must
/// - set them to 0 when a pair enters the list;
/// - carry them along when a new list has the pair in another place;
/// - apply `ellgran_history_swap` when a new list has the pair with its two particles exchanged.
///
/// A contact whose history is lost starts again without tangential force.
///
/// The pointers are read during a call and not kept after it. Arrays "by particle index" are read only at the indices of
/// central particles.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranNeighbourList {
    /// `sizeof(EllgranNeighbourList)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Number of central particles.
    pub count: usize,
    /// Their indices, [count]. With `newton` = 0 those that have neighbours are owned.
    pub central: *const i32,
    /// Number of neighbours, by particle index; a negative number counts as 0.
    pub neighbour_counts: *const i32,
    /// Neighbours, by particle index: [neighbour_counts] entries each, none of them the central particle itself. A row
    /// without neighbours may be NULL.
    pub neighbours: *const *const i32,
    /// Mask of the bits of an entry that hold the neighbour's index; -1 if all do.
    pub index_mask: i32,
    /// Position of the two bits of an entry that select one of `special_factors`, 0 to 30 (LAMMPS: 30). `index_mask` must
    /// not contain them. Not read if `special_factors` is NULL.
    pub special_shift: i32,
    /// [4] or NULL; a pair whose factor is 0 is left out. Other factors do not scale a contact force.
    pub special_factors: *const f64,
    /// 1: each pair is listed by one rank only, and forces are added to ghosts too. 0: a pair with a ghost is listed by
    /// both ranks, and forces are added to owned particles only.
    pub newton: i32,
    /// 1: since the last successful call with this workspace the caller has changed none of the following: the laws, the
    /// number and order of the particles, the entries of the list, `touching`, `history`. Positions, rotations, velocities,
    /// shapes and types may have changed. Most pairs that do not touch are then skipped, and histories are taken from the
    /// workspace. 0: any of them may have changed. When in doubt, use 0.
    ///
    /// Calls of other functions in between, and calls that failed, do not matter. In the first call with a workspace 1 has
    /// no effect. The arrays may be at other addresses. Other laws, another `count`, other `central` or `neighbour_counts`,
    /// and rows that have become NULL are detected and refused. Other changes are not detected: other entries or numbers
    /// give wrong forces, and the behaviour is undefined if `touching` or `history` have become shorter.
    pub unchanged: i32,
    /// 1: `touching` and `history` are stale until `ellgran_write_history` is called, which is faster. Call it before
    /// reading them and before changing the list. 0: they are written in every call.
    pub keep_history: i32,
    /// 1: touching pairs are recorded for `ellgran_recorded_contact`, which costs time. 0: they are not.
    pub record_contacts: i32,
    /// One flag per neighbour, by particle index, [neighbour_counts] each, read and written: 1 for a contact, 0 for none.
    /// NULL if the history length is 0.
    pub touching: *const *mut i32,
    /// History per neighbour, by particle index, [neighbour_counts][ellgran_laws_history_length] each, read and written.
    /// NULL if the history length is 0.
    pub history: *const *mut f64,
}

growing!(EllgranNeighbourList);

struct Rows<'a> {
    central: &'a [i32],
    counts: *const i32,
    neighbours: *const *const i32,
    touching: *const *mut i32,
    history: *const *mut f64,
    length: usize,
    entries: Entries,
}

impl<'a> Rows<'a> {
    /// # Safety
    /// The arrays of `list` are valid as [`EllgranNeighbourList`] demands, while the rows are used; those by particle index have
    /// an entry for each of `central`, and `touching` and `history` are not aliased. Methods of the rows rely on it.
    unsafe fn new(
        list: &EllgranNeighbourList,
        central: &'a [i32],
        length: usize,
        entries: Entries,
    ) -> Self {
        Rows {
            central,
            counts: list.neighbour_counts,
            neighbours: list.neighbours,
            touching: list.touching,
            history: list.history,
            length,
            entries,
        }
    }
}

impl NeighbourRows for Rows<'_> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.central.len()
    }

    #[inline(always)]
    fn row(&mut self, k: usize) -> NeighbourRow<'_> {
        let central = self.central[k] as usize;
        // SAFETY: by the contract of `Rows::new`, the arrays have an entry for every central particle, the rows have as many
        // entries as the count says, and no row is borrowed twice at a time (`&mut self`).
        unsafe {
            let count = (*self.counts.add(central)).max(0) as usize;
            let neighbours = if count == 0 {
                &[][..]
            } else {
                core::slice::from_raw_parts(*self.neighbours.add(central), count)
            };
            let (touching, history) = if self.length == 0 || count == 0 {
                (&mut [][..], &mut [][..])
            } else {
                (
                    core::slice::from_raw_parts_mut(*self.touching.add(central), count),
                    core::slice::from_raw_parts_mut(
                        *self.history.add(central),
                        count * self.length,
                    ),
                )
            };
            NeighbourRow {
                central,
                neighbours,
                touching,
                history,
            }
        }
    }

    #[inline(always)]
    fn pair(&mut self, central: usize, entry: usize) -> (Option<&mut i32>, &mut [f64]) {
        if self.length == 0 {
            return (None, &mut []);
        }
        // SAFETY: as above, for one entry of the row of a central particle, which is tested to be there; nothing of a row
        // is borrowed twice at a time (`&mut self`).
        unsafe {
            assert!(
                (entry as i64) < i64::from(*self.counts.add(central)),
                "a row has become shorter in a list with unchanged = 1"
            );
            (
                Some(&mut *(*self.touching.add(central)).add(entry)),
                core::slice::from_raw_parts_mut(
                    (*self.history.add(central)).add(entry * self.length),
                    self.length,
                ),
            )
        }
    }

    #[inline(always)]
    fn entries(&self) -> Entries {
        self.entries
    }
}

impl ListLook {
    /// A row more.
    #[inline(always)]
    fn add_row(&mut self, central: i32, count: i32) {
        let row = u64::from(central as u32) << 32 | u64::from(count as u32);
        // A step of a hash (Knuth's multiplier): another order or another length gives another number.
        self.rows = (self.rows ^ row)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .rotate_left(29);
    }

    /// Refuses what differs from a list that is said to be unchanged.
    fn require_like(&self, last: &ListLook) -> Result<(), Failure> {
        let what = if self.laws != last.laws {
            "the laws are".to_owned()
        } else if self.particles != last.particles {
            format!(
                "count = {} of the particles, which was {}, is",
                self.particles, last.particles
            )
        } else if self.rows != last.rows {
            "central and neighbour_counts of the list are".to_owned()
        } else {
            return Ok(());
        };
        Err(Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!(
                "unchanged = 1, but {what} not that of the last call: call ellgran_write_history if histories were kept, and \
                 set unchanged = 0"
            ),
        ))
    }
}

/// The index of a central particle.
fn central_index(central: i32, particles: usize) -> Result<usize, Failure> {
    usize::try_from(central)
        .ok()
        .filter(|k| *k < particles)
        .ok_or_else(|| {
            Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("central names particle {central}, which is not one of {particles}"),
            )
        })
}

/// How to read the entries of a list.
///
/// # Safety
/// `special_factors` of the list is NULL or valid for reads of 4 values.
unsafe fn entries_of(list: &EllgranNeighbourList) -> Result<Entries, Failure> {
    let mut entries = Entries {
        mask: list.index_mask,
        shift: 0,
        excluded: [false; 4],
    };
    // SAFETY: promised by the caller.
    if let Some(factors) = unsafe { list.special_factors.cast::<[f64; 4]>().as_ref() } {
        entries.shift = u32::try_from(list.special_shift)
            .ok()
            .filter(|s| *s <= 30)
            .ok_or_else(|| {
                Failure::new(
                    ELLGRAN_ERROR_ARGUMENT,
                    format!(
                        "special_shift = {} must be between 0 and 30: two bits of an entry above it select a factor",
                        list.special_shift
                    ),
                )
            })?;
        if (list.index_mask >> entries.shift) & 3 != 0 {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!(
                    "index_mask = {:#x} holds bits {shift} and above, which select a factor: special_shift = {shift}",
                    list.index_mask,
                    shift = entries.shift
                ),
            ));
        }
        for (e, f) in entries.excluded.iter_mut().zip(factors) {
            *e = *f == 0.0;
        }
    }
    Ok(entries)
}

/// The rows of a list for its pairs alone: `touching` and `history` are not read.
///
/// # Safety
/// The arrays of the list are as `EllgranNeighbourList` demands, but for those two, while the rows are used.
pub(super) unsafe fn pairs_of(
    list: &EllgranNeighbourList,
    particles: usize,
) -> Result<impl NeighbourRows + '_, Failure> {
    // SAFETY: `central` is NULL or valid for reads of `list.count` elements, as `EllgranNeighbourList` demands.
    let central = unsafe { slice(list.central, list.count, "central") }?;
    if list.count > 0 {
        for (is_null, name) in [
            (list.neighbour_counts.is_null(), "neighbour_counts"),
            (list.neighbours.is_null(), "neighbours"),
        ] {
            if is_null {
                return Err(Failure::new(
                    ELLGRAN_ERROR_NULL_POINTER,
                    format!("{name} must not be NULL"),
                ));
            }
        }
    }
    for &c in central {
        let k = central_index(c, particles)?;
        // SAFETY: promised by the caller; the outer pointers are not NULL here. Rows are read where they have entries.
        if unsafe { *list.neighbour_counts.add(k) > 0 && (*list.neighbours.add(k)).is_null() } {
            return Err(Failure::new(
                ELLGRAN_ERROR_NULL_POINTER,
                format!("neighbours[{k}] must not be NULL"),
            ));
        }
    }
    // SAFETY: `special_factors` is as `EllgranNeighbourList` demands; with a history of no doubles `touching` and `history` are not
    // read.
    unsafe { Ok(Rows::new(list, central, 0, entries_of(list)?)) }
}

/// What is wrong with a list, with the particles that it concerns.
pub(super) fn list_failure(
    p: &EllgranParticles,
    list: &EllgranNeighbourList,
    error: ListError,
) -> Failure {
    match error {
        ListError::Hale(e) => hale_failure(identifier(p, e.i), Some(identifier(p, e.j)), e.ratio),
        ListError::History { i, j, place, value } => {
            history_failure(identifier(p, i), Some(identifier(p, j)), place, value)
        }
        ListError::Entry {
            central,
            place,
            entry,
        } => {
            let (index, count) = (entry & list.index_mask, p.count);
            let what = if index as usize == central {
                "the particle of the row itself".to_owned()
            } else {
                format!("which is not one of {count}")
            };
            Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!(
                    "neighbours[{central}][{place}] = {entry} of particle {} names particle {index}, {what}",
                    identifier(p, central)
                ),
            )
        }
    }
}

/// Forces and torques of all touching pairs of a neighbour list, added to the particles' arrays.
///
/// Before anything is written, particles are checked, and in a new list the entries and the histories of touching pairs. On
/// failure nothing is written.
///
/// The same calls with the same numbers give the same bits on one machine with one instruction set. Results differ by
/// rounding
/// - between instruction sets, and with AVX-512 between makers of processors, whose approximate reciprocals differ;
/// - from those of `ellgran_contact` for the same pair;
/// - with the order of the list;
/// - between a list with `unchanged` = 1 and a new one.
///
/// # Safety
/// The pointers are as `EllgranParticles`, `EllgranNeighbourList` and `EllgranTallies` state; `tallies` may be NULL.
#[no_mangle]
pub unsafe extern "C" fn ellgran_compute_pairs(
    laws: *const EllgranLaws,
    workspace: *mut EllgranWorkspace,
    particles: *const EllgranParticles,
    list: *const EllgranNeighbourList,
    step: *const EllgranStep,
    tallies: *mut EllgranTallies,
) -> i32 {
    at_border("ellgran_compute_pairs", || {
        // Whatever is wrong with this call, contacts of an earlier one are not of it.
        // SAFETY: promised by the caller, for all of this function.
        if let Some(kept) = unsafe { workspace.as_mut() } {
            kept.workspace.contacts.clear();
        }
        // SAFETY: as above.
        let (number, kept) = unsafe {
            (
                required(laws, "laws")?.number,
                required_mut(workspace, "workspace")?,
            )
        };
        // SAFETY: `laws` is NULL or valid for reads, by this function's safety section.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = &*unsafe { given(particles, "particles") }?;
        // SAFETY: `list` is NULL or valid for reads, by this function's safety section.
        let list = &*unsafe { given(list, "list") }?;
        // SAFETY: `step` is NULL or valid for reads, by this function's safety section.
        let step = unsafe { given(step, "step") }?.to_core()?;
        let length = laws.layout().length;
        if kept.is_computing {
            // The last call ended in a panic.
            kept.workspace.forget_list();
            kept.last_list = None;
            kept.is_computing = false;
        }
        let EllgranWorkspace {
            workspace,
            last_list,
            is_computing,
            ..
        } = kept;
        if list.unchanged == 0 && workspace.has_unwritten_history() {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                "unchanged = 0, but the workspace keeps histories of the last list that were not written: call \
                 ellgran_write_history before the list changes, or ellgran_forget_history to discard them",
            ));
        }
        // SAFETY: `central` is NULL or valid for reads of `list.count` elements, as `EllgranNeighbourList` demands.
        let central = unsafe { slice(list.central, list.count, "central") }?;
        if list.count > 0 {
            for (is_null, name) in [
                (list.neighbour_counts.is_null(), "neighbour_counts"),
                (list.neighbours.is_null(), "neighbours"),
                (length > 0 && list.touching.is_null(), "touching"),
                (length > 0 && list.history.is_null(), "history"),
            ] {
                if is_null {
                    return Err(Failure::new(
                        ELLGRAN_ERROR_NULL_POINTER,
                        format!("{name} must not be NULL"),
                    ));
                }
            }
        }
        let mut look = ListLook {
            laws: number,
            particles: p.count,
            rows: list.count as u64,
        };
        for &c in central {
            let k = central_index(c, p.count)?;
            // SAFETY: promised by the caller; the outer pointers are not NULL here. Rows are read where they have entries.
            let rows = unsafe {
                let count = *list.neighbour_counts.add(k);
                look.add_row(c, count);
                if count <= 0 {
                    continue;
                }
                [
                    ("neighbours", (*list.neighbours.add(k)).is_null()),
                    ("touching", length > 0 && (*list.touching.add(k)).is_null()),
                    ("history", length > 0 && (*list.history.add(k)).is_null()),
                ]
            };
            if list.newton == 0 && k >= p.owned_count {
                return Err(Failure::new(
                    ELLGRAN_ERROR_ARGUMENT,
                    format!(
                        "central names particle {c}, which is a ghost: with newton = 0 the rows are those of the {} owned \
                         particles, and its pairs with these stand there",
                        p.owned_count
                    ),
                ));
            }
            for (name, is_null) in rows {
                if is_null {
                    return Err(Failure::new(
                        ELLGRAN_ERROR_NULL_POINTER,
                        format!("{name}[{k}] must not be NULL"),
                    ));
                }
            }
        }
        if let Some(last) = last_list.filter(|_| list.unchanged != 0) {
            look.require_like(&last)?;
        }
        // SAFETY: `special_factors` is NULL or valid for reads of 4 values, as `EllgranNeighbourList` demands.
        let entries = unsafe { entries_of(list) }?;
        // SAFETY: `forces` is NULL or valid for reads and writes of `p.count` elements, and not aliased, as
        // `EllgranParticles` demands.
        let forces = unsafe { slice_mut(p.forces.cast::<[f64; 3]>(), p.count, "forces") }?;
        // SAFETY: `torques` is NULL or valid for reads and writes of `p.count` elements, and not aliased, as
        // `EllgranParticles` demands.
        let torques = unsafe { slice_mut(p.torques.cast::<[f64; 3]>(), p.count, "torques") }?;
        // SAFETY: `tallies` and the arrays that it names are valid as `EllgranTallies` demands, by this function's
        // safety section.
        let mut asked = unsafe { Asked::new(tallies) }?;
        let mut sums = match &asked {
            // SAFETY: the arrays of `tallies` have an element for each particle, as `EllgranTallies` demands; they
            // are borrowed once.
            Some(asked) => Some(unsafe { borrow(&asked.given, p.count) }?),
            None => None,
        };
        let purpose = Purpose::Pairs {
            unchanged: list.unchanged != 0,
        };
        *is_computing = true;
        // SAFETY: the arrays of `particles` are NULL or as long as its counts say, as `EllgranParticles` demands.
        let prepared = unsafe { prepare(p, p.count, Some(laws), workspace, purpose) };
        *is_computing = false;
        prepared?;
        let reaction_below = if list.newton != 0 {
            p.count
        } else {
            p.owned_count
        };
        let work_is_added = sums.as_ref().is_some_and(|s| s.inelastic_loads.is_some());
        if work_is_added && step.advance_history && !laws.features().friction {
            // SAFETY: promised by the caller; the arrays were checked as the particles were prepared.
            unsafe { check_half_step(p, p.count, 0..reaction_below) }?;
        }
        workspace.keeps_history = list.keep_history != 0;
        workspace.records_contacts = list.record_contacts != 0;
        // SAFETY: the arrays are as `EllgranNeighbourList` demands, by this function's safety section; `central` is the list's own.
        let mut rows = unsafe { Rows::new(list, central, length, entries) };
        let mut accumulators = Accumulators {
            forces,
            torques,
            reaction_below,
            owned: p.owned_count,
        };
        *is_computing = true;
        let computed = compute_pairs(
            laws,
            workspace,
            &mut rows,
            &step,
            &mut accumulators,
            sums.as_mut(),
        );
        *is_computing = false;
        workspace.deep_contacts += computed.map_err(|e| list_failure(p, list, e))?;
        *last_list = Some(look);
        if let (Some(asked), Some(mut sums)) = (&mut asked, sums) {
            // SAFETY: promised by the caller.
            unsafe { add_preceding_half_step(&mut sums, p, reaction_below, &step) }?;
            asked.write(&sums);
        }
        Ok(())
    })
}

/// Writes the `touching` and `history` that calls with `keep_history` = 1 have kept in the workspace to the arrays of the
/// list. Does nothing where they are up to date.
///
/// # Safety
/// `workspace` is valid; `list` is that of the last call of `ellgran_compute_pairs` with it, unchanged since.
#[no_mangle]
pub unsafe extern "C" fn ellgran_write_history(
    workspace: *mut EllgranWorkspace,
    list: *const EllgranNeighbourList,
) -> i32 {
    at_border("ellgran_write_history", || {
        // SAFETY: promised by the caller.
        let workspace = &mut unsafe { required_mut(workspace, "workspace") }?.workspace;
        // SAFETY: `list` is NULL or valid for reads, by this function's safety section.
        let list = &*unsafe { given(list, "list") }?;
        if !workspace.has_unwritten_history() {
            return Ok(());
        }
        for (is_null, name) in [
            (list.neighbour_counts.is_null(), "neighbour_counts"),
            (list.touching.is_null(), "touching"),
            (list.history.is_null(), "history"),
        ] {
            if is_null {
                return Err(Failure::new(
                    ELLGRAN_ERROR_NULL_POINTER,
                    format!("{name} must not be NULL"),
                ));
            }
        }
        let length = workspace.kept_history_length();
        for (central, entry) in workspace.kept_pairs() {
            // SAFETY: promised by the caller; the outer pointers are not NULL here.
            let is_there = unsafe {
                (entry as i64) < i64::from(*list.neighbour_counts.add(central))
                    && !(*list.touching.add(central)).is_null()
                    && !(*list.history.add(central)).is_null()
            };
            if !is_there {
                return Err(Failure::new(
                    ELLGRAN_ERROR_ARGUMENT,
                    format!(
                        "the list is not that of the last call: row {central} no longer has entry {entry}, whose history is \
                         kept"
                    ),
                ));
            }
        }
        // SAFETY: the arrays are as `EllgranNeighbourList` demands, and the loop above has found an entry for each kept history.
        let mut rows = unsafe { Rows::new(list, &[], length, Entries::PLAIN) };
        workspace.write_history(&mut rows);
        Ok(())
    })
}

/// Discards the histories that a workspace keeps (`keep_history` = 1) and has not written: for a caller who no longer has
/// the list to which they belong, or does not want them. The next call reads `touching` and `history` of its list, even
/// with `unchanged` = 1. The arrays of the old list keep what was last written to them.
///
/// # Safety
/// `workspace` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_forget_history(workspace: *mut EllgranWorkspace) -> i32 {
    at_border("ellgran_forget_history", || {
        // SAFETY: promised by the caller.
        let kept = unsafe { required_mut(workspace, "workspace") }?;
        kept.workspace.forget_list();
        kept.last_list = None;
        Ok(())
    })
}
