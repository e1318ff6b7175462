// SPDX-License-Identifier: MIT OR Apache-2.0
//! A whole neighbour list in one call: the path for speed.

use super::growing::{given, growing};
use super::law::EllgranLaws;
use super::particles::{
    hale_failure, handles, identifier, prepare, EllgranParticles, EllgranStep, EllgranWorkspace,
    Purpose,
};
use super::status::{
    at_border, required_mut, slice, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT,
    ELLGRAN_ERROR_NULL_POINTER,
};
use super::tallies::{borrow, Asked, EllgranTallies};
use crate::pairs::neighbour_list::{Accumulators, Entries};
use crate::pairs::{compute_pairs, NeighbourRow, NeighbourRows};
use libc::size_t;

/// An engine's neighbour list: every pair once.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranNeighbourList {
    /// `sizeof(EllgranNeighbourList)`; `ELLGRAN_INIT` sets it.
    pub size: size_t,
    /// Number of central particles.
    pub count: size_t,
    /// Their indices, [count].
    pub central: *const i32,
    /// Number of neighbours, by particle index.
    pub neighbour_counts: *const i32,
    /// Neighbours, by particle index.
    pub neighbours: *const *const i32,
    /// Bits of an entry that are the neighbour's index (all: -1).
    pub index_mask: i32,
    /// The bits above this one select one of `special_factors`.
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
    pub unchanged: i32,
    /// 1: `touching` and `history` may stay behind what the workspace remembers, which is faster: whoever reads them, or
    /// changes the list, calls `ellgran_write_history` first. 0: they are written in every call.
    pub keep_history: i32,
    /// One flag per neighbour, by particle index, written: 1 for a contact. NULL if the history length is 0.
    pub touching: *const *mut i32,
    /// History per neighbour, by particle index, written. NULL if the history length is 0.
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

/// Forces and torques of all touching pairs of a neighbour list, added to the particles' arrays.
///
/// All particles are checked first; on failure nothing is written.
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
        let (laws, workspace) = unsafe { handles(laws, workspace) }?;
        let p = &*unsafe { given(particles, "particles") }?;
        let list = &*unsafe { given(list, "list") }?;
        let step = unsafe { given(step, "step") }?.to_core()?;
        let length = laws.layout().length;
        if list.unchanged == 0 && workspace.has_unwritten_history() {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                "the list may have changed (unchanged = 0), but the history that the workspace keeps of the last list was \
                 not written: call ellgran_write_history before the list changes",
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
                if *list.neighbour_counts.add(k) <= 0 {
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
        let mut excluded = [false; 4];
        let mut shift = 0;
        if let Some(factors) = unsafe { list.special_factors.cast::<[f64; 4]>().as_ref() } {
            shift = list.special_shift.clamp(0, 31) as u32;
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
        unsafe { prepare(p, p.count, Some(laws), workspace, purpose) }?;
        workspace.keeps_history = list.keep_history != 0;
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
        let many_starts = compute_pairs(
            laws,
            workspace,
            &mut rows,
            &step,
            &mut accumulators,
            sums.as_mut(),
        )
        .map_err(|e| hale_failure(identifier(p, e.i), Some(identifier(p, e.j)), e.ratio))?;
        workspace.many_starts += many_starts;
        if let (Some(asked), Some(sums)) = (&mut asked, sums) {
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
        workspace.write_history(&mut Rows::new(list, &[], length, Entries::PLAIN));
        Ok(())
    })
}
