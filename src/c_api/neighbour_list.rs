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
use super::tallies::{add_preceding_half_step, borrow, Asked, EllgranTallies};
use crate::list::{compute_pairs, ListError, NeighbourRow, NeighbourRows};
use crate::list::{Accumulators, Entries};
use libc::size_t;

/// An engine's neighbour list: every pair once, in the row of one of its two particles.
///
/// A pair that is not listed is not seen. So the list needs each pair whose centres are closer than the sum of the two largest
/// semi-axes, and, to be used for several steps, a margin to that: no particle may have moved by more than half of it since the
/// list was built. More pairs do no harm.
///
/// `touching` and `history` belong to the caller. When a pair enters the list, they are to be 0 (the normal may hold anything:
/// it is a start of the search); while it stays, in whatever list and place, they go with it; where it comes back with its
/// particles exchanged, `ellgran_history_swap` turns the history. A contact whose history is lost begins anew, without
/// tangential force.
///
/// The pointers are read during a call and not kept after it. Of arrays by particle index only the entries of central particles
/// are read.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranNeighbourList {
    /// `sizeof(EllgranNeighbourList)`; `ELLGRAN_INIT` sets it.
    pub size: size_t,
    /// Number of central particles.
    pub count: size_t,
    /// Their indices, [count].
    pub central: *const i32,
    /// Number of neighbours, by particle index; a negative number is 0.
    pub neighbour_counts: *const i32,
    /// Neighbours, by particle index: [neighbour_counts] entries each, none of them the central particle itself. A row
    /// without neighbours may be NULL.
    pub neighbours: *const *const i32,
    /// Bits of an entry that are the neighbour's index (all: -1).
    pub index_mask: i32,
    /// Number of the lowest of the two bits of an entry that select one of `special_factors`, 0 to 30 (LAMMPS: 30); they
    /// are to be 0 in `index_mask`. Not read if `special_factors` is NULL.
    pub special_shift: i32,
    /// [4] or NULL; a pair whose factor is 0 is left out. Other factors do not scale a contact force.
    pub special_factors: *const f64,
    /// 1: forces are added to ghosts too, and a pair appears once among all ranks; 0: only to owned particles, and a pair
    /// with a ghost appears on both ranks.
    pub newton: i32,
    /// 1: since the last call with this workspace that succeeded, the laws, the particles and their order, the list's entries,
    /// `touching` and `history` have not changed but by this library (positions, rotations, shapes and types may have): most
    /// pairs that do not touch are then left out without being looked at, and what is remembered of the others is taken from
    /// the workspace. 0: they may have. When in doubt, 0.
    ///
    /// `ellgran_compute_wall` and calls for one contact in between do not count, a call that failed neither; in the first
    /// call with a workspace it makes no difference. The arrays themselves may have moved. Other laws, another `count`, other
    /// `central` or `neighbour_counts` and rows that are NULL are found out and refused. The behaviour is undefined if 1 is
    /// said of a list whose `touching` or `history` are shorter than they were; if other entries or other numbers are in their
    /// places, forces are wrong.
    pub unchanged: i32,
    /// 1: `touching` and `history` may stay behind what the workspace remembers, which is faster: whoever reads them, or
    /// changes the list, calls `ellgran_write_history` first. 0: they are written in every call.
    pub keep_history: i32,
    /// 1: every touching pair is recorded, at some cost, for `ellgran_recorded_contact`. 0: none is, which costs nothing.
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
    fn new(
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
        // SAFETY: by the contract of `EllgranNeighbourList`, the arrays have an entry for every central particle, the rows
        // have as many entries as the count says, and no row is borrowed twice at a time (`&mut self`).
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
                "a row has become shorter in an unchanged list"
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

/// What is wrong with a list, with the particles that it concerns.
fn list_failure(p: &EllgranParticles, list: &EllgranNeighbourList, error: ListError) -> Failure {
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
/// Particles are checked first, and of a new list the entries, and the histories of pairs that touch; on failure nothing is
/// written.
///
/// The same calls with the same numbers give the same bits, run after run, on one machine with one instruction set. They differ
/// by rounding from one instruction set to another (and between makers of processors with AVX-512, whose approximate
/// reciprocals differ), from `ellgran_contact` for the same pair, with the order of the list, and between a list that was said
/// to be unchanged and a new one.
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
        // SAFETY: promised by the caller, for all of this function.
        let (number, kept) = unsafe {
            (
                required(laws, "laws")?.number,
                required_mut(workspace, "workspace")?,
            )
        };
        let laws = &unsafe { required(laws, "laws") }?.laws;
        kept.workspace.contacts.clear();
        let p = &*unsafe { given(particles, "particles") }?;
        let list = &*unsafe { given(list, "list") }?;
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
                "the list may have changed (unchanged = 0), but the history that the workspace keeps of the last list was \
                 not written: call ellgran_write_history before the list changes, or ellgran_forget_history to lose it",
            ));
        }
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
            let k = usize::try_from(c)
                .ok()
                .filter(|k| *k < p.count)
                .ok_or_else(|| {
                    Failure::new(
                        ELLGRAN_ERROR_ARGUMENT,
                        format!(
                            "central names particle {c}, which is not one of {}",
                            p.count
                        ),
                    )
                })?;
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
        let mut excluded = [false; 4];
        let mut shift = 0;
        if let Some(factors) = unsafe { list.special_factors.cast::<[f64; 4]>().as_ref() } {
            shift = u32::try_from(list.special_shift)
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
            for (e, f) in excluded.iter_mut().zip(factors) {
                *e = *f == 0.0;
            }
        }
        let forces = unsafe { slice_mut(p.forces.cast::<[f64; 3]>(), p.count, "forces") }?;
        let torques = unsafe { slice_mut(p.torques.cast::<[f64; 3]>(), p.count, "torques") }?;
        let mut asked = unsafe { Asked::new(tallies) }?;
        let mut sums = match &asked {
            Some(asked) => Some(unsafe { borrow(&asked.given, p.count) }?),
            None => None,
        };
        let purpose = Purpose::Pairs {
            unchanged: list.unchanged != 0,
        };
        *is_computing = true;
        let prepared = unsafe { prepare(p, p.count, Some(laws), workspace, purpose) };
        *is_computing = false;
        prepared?;
        workspace.keeps_history = list.keep_history != 0;
        workspace.records_contacts = list.record_contacts != 0;
        let entries = Entries {
            mask: list.index_mask,
            shift,
            excluded,
        };
        let mut rows = Rows::new(list, central, length, entries);
        let mut accumulators = Accumulators {
            forces,
            torques,
            reaction_below: if list.newton != 0 {
                p.count
            } else {
                p.owned_count
            },
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
            let count = accumulators.reaction_below;
            // SAFETY: promised by the caller.
            unsafe { add_preceding_half_step(&mut sums, p, count, &step) }?;
            asked.write(&sums);
        }
        Ok(())
    })
}

/// Writes to `touching` and `history` of the list of the last call what calls with `keep_history` = 1 left behind; does
/// nothing where they are up to date.
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
                        "the list is not that of the last call: row {central} has no entry {entry} any more, of which a \
                         history is kept"
                    ),
                ));
            }
        }
        workspace.write_history(&mut Rows::new(list, &[], length, Entries::PLAIN));
        Ok(())
    })
}

/// Forgets the histories that a workspace keeps (`keep_history` = 1) and did not write: for a caller who has given up the list
/// that they belong to, or who wants none of them. The next call takes `touching` and `history` of its list as they are,
/// whatever `unchanged` says; those of the old list stay as the last writing left them.
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
