// SPDX-License-Identifier: MIT OR Apache-2.0
//! An engine's particle arrays and the workspace of a step.

use super::growing::growing;
use super::status::{
    at_border, required, required_mut, slice, Failure, ELLGRAN_ERROR_ARGUMENT, ELLGRAN_ERROR_HALE,
    ELLGRAN_ERROR_HISTORY, ELLGRAN_ERROR_NULL_POINTER, ELLGRAN_ERROR_PARTICLE,
    ELLGRAN_ERROR_RESULT,
};
use crate::contact::ranges::LONGEST_TIME_STEP;
use crate::contact::{Laws, Step};
use crate::list::Rotation;
use crate::list::{ParticleArrays, Workspace};
use crate::message::Number;
use crate::simd::InstructionSet;
use libc::{c_char, c_void, size_t};

/// Pointers to an engine's own arrays: owned particles first, then ghosts. World frame.
///
/// The arrays are read and written during a call and not kept after it: they may move between calls. `ellgran_compute_pairs`
/// and `ellgran_staged_prepare` need `count` entries of each, `ellgran_compute_wall` the first `owned_count`. What is out of
/// the range stated at a field is an error that names the particle and the value.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranParticles {
    /// `sizeof(EllgranParticles)`; `ELLGRAN_INIT` sets it.
    pub size: size_t,
    /// Particles that the caller owns.
    pub owned_count: size_t,
    /// All particles, ghosts included.
    pub count: size_t,
    /// Centres, [count][3]; components up to 1e20.
    pub positions: *const f64,
    /// Velocities of the centres, [count][3]; components up to 1e25. Those that moved the particles to where they are, see
    /// `EllgranStep`.
    pub velocities: *const f64,
    /// Angular velocities, [count][3], or NULL: then from `angular_momenta` and `masses`. Components up to 1e25.
    pub angular_velocities: *const f64,
    /// Angular momenta of solid ellipsoids, [count][3]; may be NULL if `angular_velocities` is not.
    pub angular_momenta: *const f64,
    /// Masses, [count], from 1e-50 to 1e50; may be NULL where neither `angular_momenta` nor a law reads them.
    pub masses: *const f64,
    /// Masses for effective masses, [count]: that of the rigid body that a particle belongs to, INFINITY for a frozen one.
    /// NULL: `masses`.
    pub contact_masses: *const f64,
    /// Types, counted from 1, [count].
    pub types: *const i32,
    /// Index of each particle into `semi_axes` and `quaternions`, [count]; negative: not an ellipsoid, an error. NULL: the
    /// particle's own index.
    pub shape_indices: *const i32,
    /// Semi-axes, 3 doubles an entry, from 1e-20 to 1e20, the largest at most 1e6 times the smallest. As many entries as there
    /// are particles, or as `shape_indices` name.
    pub semi_axes: *const f64,
    /// Bytes from one entry of `semi_axes` to the next.
    pub semi_axes_stride: size_t,
    /// Quaternions (w, x, y, z), body to world, 4 doubles an entry; of any length but zero.
    pub quaternions: *const f64,
    /// Bytes from one entry of `quaternions` to the next.
    pub quaternions_stride: size_t,
    /// What to call a particle in a message, [count] integers of `identifier_bytes` each, or NULL: index + 1.
    pub identifiers: *const c_void,
    /// 4 or 8.
    pub identifier_bytes: i32,
    /// Forces, [count][3], added to; those of ghosts only where a pair's reaction goes there (`newton` of the list).
    pub forces: *mut f64,
    /// Torques about the centres, [count][3], added to; as `forces`.
    pub torques: *mut f64,
}

growing!(EllgranParticles);

/// Time step, and whether the history advances.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranStep {
    /// `sizeof(EllgranStep)`; `ELLGRAN_INIT` sets it.
    pub size: size_t,
    /// 1 in a step; 0 in the set-up of a run: forces from the history as it stands.
    pub advance_history: i32,
    /// Time step, from 0 to 1e15. The velocities are those of the half step, which moved the particles over it to where they
    /// are: of velocity Verlet those between its two halves, of leapfrog its own. With velocities of the full step the
    /// tangential displacement has an error of the order of the time step.
    pub time_step: f64,
}

growing!(EllgranStep);

/// Memory that one thread of calls keeps from step to step. Opaque.
///
/// Two threads may compute at a time with a workspace each, with the same laws, where the arrays that they write are apart.
/// After an error a workspace is as good as before the call: what it keeps of the last call that succeeded is still there.
/// After `ELLGRAN_ERROR_PANIC` it can be used too, but what it kept is lost.
pub struct EllgranWorkspace {
    pub(super) workspace: Workspace,
    /// What the last list that was computed looked like.
    pub(super) last_list: Option<ListLook>,
    /// Set while a list is computed: still set after a panic, which leaves nothing to rely on.
    pub(super) is_computing: bool,
}

/// What is cheap to know of a list, by which most lists that have changed differ from the last one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ListLook {
    /// Number of the laws.
    pub laws: u64,
    /// Particles.
    pub particles: usize,
    /// Made of the central particles and the lengths of their rows, in their order.
    pub rows: u64,
}

/// A new workspace. The neighbour-list path will run on the widest instruction set of this machine, or on the one that the
/// environment variable `ELLGRAN_INSTRUCTION_SET` names: `scalar`, `baseline`, `avx2` or `avx512`; empty is as if it were not
/// set.
///
/// # Safety
/// `workspace` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_workspace_new(workspace: *mut *mut EllgranWorkspace) -> i32 {
    at_border("ellgran_workspace_new", || {
        // SAFETY: promised by the caller.
        let out = unsafe { required_mut(workspace, "workspace") }?;
        let chosen =
            InstructionSet::choose().map_err(|what| Failure::new(ELLGRAN_ERROR_ARGUMENT, what))?;
        let mut workspace = Workspace::new(chosen);
        workspace.allocated = super::huge_pages::advise;
        *out = Box::into_raw(Box::new(EllgranWorkspace {
            workspace,
            last_list: None,
            is_computing: false,
        }));
        Ok(())
    })
}

/// Frees a workspace; NULL is allowed.
///
/// # Safety
/// `workspace` is NULL or came from `ellgran_workspace_new` and is not used again.
#[no_mangle]
pub unsafe extern "C" fn ellgran_workspace_free(workspace: *mut EllgranWorkspace) {
    if !workspace.is_null() {
        // SAFETY: promised by the caller.
        drop(unsafe { Box::from_raw(workspace) });
    }
}

/// The name of the instruction set that a workspace runs on, static; NULL for NULL.
///
/// # Safety
/// `workspace` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_workspace_instruction_set(
    workspace: *const EllgranWorkspace,
) -> *const c_char {
    // SAFETY: promised by the caller.
    let text = unsafe { workspace.as_ref() }.map(|w| match w.workspace.instruction_set {
        InstructionSet::Scalar => c"scalar",
        InstructionSet::Baseline => c"baseline",
        InstructionSet::Avx2 => c"avx2",
        InstructionSet::Avx512 => c"avx512",
    });
    text.map_or(core::ptr::null(), |t| t.as_ptr())
}

/// Bytes that a workspace holds; 0 for NULL.
///
/// # Safety
/// `workspace` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_workspace_bytes(workspace: *const EllgranWorkspace) -> size_t {
    // SAFETY: promised by the caller.
    unsafe { workspace.as_ref() }.map_or(0, |w| w.workspace.bytes())
}

/// Contacts deeper than half the smallest local radius of curvature, since the workspace was made, counted in every call: the
/// scene is too soft for Hertz' law, and slow, for the deepest need a search for the global minimum; 0 for NULL.
///
/// # Safety
/// `workspace` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_workspace_deep_contacts_count(
    workspace: *const EllgranWorkspace,
) -> i64 {
    // SAFETY: promised by the caller.
    unsafe { workspace.as_ref() }.map_or(0, |w| w.workspace.deep_contacts as i64)
}

impl EllgranStep {
    pub(super) fn to_core(self) -> Result<Step, Failure> {
        if !(0.0..=LONGEST_TIME_STEP).contains(&self.time_step) {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!(
                    "time_step = {} must be a finite number, 0 or greater, at most {LONGEST_TIME_STEP:e}",
                    Number(self.time_step)
                ),
            ));
        }
        Ok(Step {
            time_step: self.time_step,
            advance_history: self.advance_history != 0,
        })
    }
}

/// What to call particle `k`.
pub(super) fn identifier(p: &EllgranParticles, k: usize) -> i64 {
    if p.identifiers.is_null() || k >= p.count {
        return k as i64 + 1;
    }
    // SAFETY: the array has `count` entries of `identifier_bytes` bytes, by the contract of the struct.
    unsafe {
        if p.identifier_bytes == 8 {
            p.identifiers.cast::<i64>().add(k).read_unaligned()
        } else {
            i64::from(p.identifiers.cast::<i32>().add(k).read_unaligned())
        }
    }
}

/// What particles are prepared for.
#[derive(Clone, Copy)]
pub(super) enum Purpose<'a> {
    /// One contact at a time.
    SingleContacts,
    /// One contact at a time, of these particles alone.
    Chosen(&'a [usize]),
    /// The pairs of a list, and whether list and particles are those of the last call.
    Pairs { unchanged: bool },
}

/// Checks the arrays' pointers and prepares the first `count` particles in the workspace; without laws any type
/// from 1 is right, and contact masses are not read.
///
/// # Safety
/// The arrays of `p` have the lengths that [`EllgranParticles`] states.
pub(super) unsafe fn prepare(
    p: &EllgranParticles,
    count: usize,
    laws: Option<&Laws>,
    workspace: &mut Workspace,
    purpose: Purpose<'_>,
) -> Result<(), Failure> {
    if count == 0 {
        workspace.clear();
        return Ok(());
    }
    if p.owned_count > p.count {
        return Err(Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!(
                "owned_count = {} is greater than count = {}",
                p.owned_count, p.count
            ),
        ));
    }
    if p.identifier_bytes != 4 && p.identifier_bytes != 8 && !p.identifiers.is_null() {
        return Err(Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!("identifier_bytes = {} must be 4 or 8", p.identifier_bytes),
        ));
    }
    for (pointer, name) in [(p.semi_axes, "semi_axes"), (p.quaternions, "quaternions")] {
        if pointer.is_null() {
            return Err(Failure::new(
                ELLGRAN_ERROR_NULL_POINTER,
                format!("{name} must not be NULL"),
            ));
        }
    }
    // SAFETY: promised by the caller, for all arrays below.
    let rows =
        |pointer: *const f64, name: &str| unsafe { slice(pointer.cast::<[f64; 3]>(), count, name) };
    let rotation = if p.angular_velocities.is_null() {
        Rotation::Momentum(
            rows(p.angular_momenta, "angular_momenta (or angular_velocities)")?,
            unsafe { slice(p.masses, count, "masses") }?,
        )
    } else {
        Rotation::Velocity(rows(p.angular_velocities, "angular_velocities")?)
    };
    let contact_masses = if laws.is_some_and(|l| l.features().mass) {
        let pointer = if p.contact_masses.is_null() {
            p.masses
        } else {
            p.contact_masses
        };
        unsafe { slice(pointer, count, "masses (or contact_masses)") }?
    } else {
        &[]
    };
    let shape_indices = if p.shape_indices.is_null() {
        None
    } else {
        Some(unsafe { slice(p.shape_indices, count, "shape_indices") }?)
    };
    let arrays = ParticleArrays {
        owned: p.owned_count,
        positions: rows(p.positions, "positions")?,
        velocities: rows(p.velocities, "velocities")?,
        rotation,
        contact_masses,
        types: unsafe { slice(p.types, count, "types") }?,
        shape: |k: usize| {
            let entry = match shape_indices {
                None => k,
                Some(indices) => usize::try_from(indices[k]).ok()?,
            };
            // SAFETY: the caller promises an entry for every index that it names.
            Some(unsafe { shape_entry(p, entry) })
        },
        identifier: |k: usize| identifier(p, k),
    };
    match (purpose, laws) {
        (Purpose::Pairs { unchanged }, Some(laws)) => {
            workspace.prepare_for_pairs(&arrays, laws, unchanged)
        }
        (Purpose::Chosen(chosen), laws) => {
            workspace.prepare_chosen(&arrays, laws.map_or(usize::MAX, Laws::types), chosen)
        }
        _ => workspace.prepare(&arrays, laws.map_or(usize::MAX, Laws::types)),
    }
    .map_err(|e| Failure::new(ELLGRAN_ERROR_PARTICLE, e.to_string()))
}

/// Semi-axes and quaternion of an entry.
///
/// # Safety
/// There is such an entry.
unsafe fn shape_entry(p: &EllgranParticles, entry: usize) -> ([f64; 3], [f64; 4]) {
    // SAFETY: promised by the caller.
    unsafe {
        let semi_axes = p
            .semi_axes
            .byte_add(entry * p.semi_axes_stride)
            .cast::<[f64; 3]>();
        let quaternion = p
            .quaternions
            .byte_add(entry * p.quaternions_stride)
            .cast::<[f64; 4]>();
        (semi_axes.read_unaligned(), quaternion.read_unaligned())
    }
}

/// Semi-axes and quaternion of particle `k`, if it is an ellipsoid.
///
/// # Safety
/// The arrays of `p` are as [`EllgranParticles`] states, and `k` is one of its particles.
pub(super) unsafe fn shape_of(p: &EllgranParticles, k: usize) -> Option<([f64; 3], [f64; 4])> {
    // SAFETY: promised by the caller.
    unsafe {
        let entry = if p.shape_indices.is_null() {
            k
        } else {
            usize::try_from(*p.shape_indices.add(k)).ok()?
        };
        Some(shape_entry(p, entry))
    }
}

/// The failure for a contact at which Hale's form breaks.
pub(super) fn hale_failure(i: i64, j: Option<i64>, ratio: f64) -> Failure {
    let with = j.map_or("a wall".to_owned(), |j| format!("particle {j}"));
    Failure::new(
        ELLGRAN_ERROR_HALE,
        format!(
            "particle {i}: the contact with {with} has B/A = {}, where Hale's form of the Hertz factors breaks \
             (above 25178); use factors exact",
            Number(ratio)
        ),
    )
}

/// The failure for a history of a touching contact that no call has written.
pub(super) fn history_failure(i: i64, j: Option<i64>, place: usize, value: f64) -> Failure {
    let with = j.map_or("a wall".to_owned(), |j| format!("particle {j}"));
    Failure::new(
        ELLGRAN_ERROR_HISTORY,
        format!(
            "particle {i}: the history of its contact with {with} has {} in place {place}, which no call has written: set \
             touching and history of new pairs to 0",
            Number(value)
        ),
    )
}

/// The failure for a contact whose numbers leave double precision.
pub(super) fn result_failure(i: i64, j: Option<i64>, name: &str, value: f64) -> Failure {
    let with = j.map_or("a wall".to_owned(), |j| format!("particle {j}"));
    Failure::new(
        ELLGRAN_ERROR_RESULT,
        format!(
            "particle {i}: its contact with {with} has {name} = {}: sizes, motion and law of the two are too far apart for \
             double precision",
            Number(value)
        ),
    )
}

/// Borrows laws and workspace of a call.
///
/// # Safety
/// The pointers are NULL or valid for the call.
pub(super) unsafe fn handles<'a>(
    laws: *const super::law::EllgranLaws,
    workspace: *mut EllgranWorkspace,
) -> Result<(&'a Laws, &'a mut Workspace), Failure> {
    // SAFETY: promised by the caller.
    unsafe {
        Ok((
            &required(laws, "laws")?.laws,
            &mut required_mut(workspace, "workspace")?.workspace,
        ))
    }
}
