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
use crate::list::{ParticleArrays, ParticleShapes, PreparedBy, Rotation, Workspace};
use crate::message::Number;
use crate::simd::InstructionSet;
use core::ffi::{c_char, c_void};

/// Pointers to an engine's own arrays: owned particles first, then ghosts. World frame.
///
/// The arrays are read and written during a call and not kept after it: they may move between calls.
/// `ellgran_compute_pairs` and `ellgran_staged_prepare` need `count` entries of each, `ellgran_compute_wall` the
/// first `owned_count`. A value outside the range of its field is an error that names the
/// particle and the value.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranParticles {
    /// `sizeof(EllgranParticles)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Particles that the caller owns.
    pub owned_count: usize,
    /// All particles, ghosts included.
    pub count: usize,
    /// Centres, [count][3]; components up to 1e20.
    pub positions: *const f64,
    /// Velocities of the centres at the half step (see `EllgranStep`), or at the step with `velocity_changes`, [count][3];
    /// components up to 1e25.
    pub velocities: *const f64,
    /// Angular velocities, [count][3]; components up to 1e25. NULL: they are computed from `angular_momenta` and `masses`.
    pub angular_velocities: *const f64,
    /// Angular momenta of solid ellipsoids, [count][3]; may be NULL if `angular_velocities` is not.
    pub angular_momenta: *const f64,
    /// Masses, [count], from 1e-50 to 1e50. May be NULL if `angular_velocities` are given and no law needs masses
    /// (`ellgran_laws_uses_mass`).
    pub masses: *const f64,
    /// Masses from which the effective mass of a contact is made, [count]: that of the rigid body to which a particle
    /// belongs, INFINITY for a fixed particle. NULL: `masses` are used.
    pub contact_masses: *const f64,
    /// Types, counted from 1, [count].
    pub types: *const i32,
    /// Index of each particle into `semi_axes` and `quaternions`, [count]. A negative index means that the particle is not
    /// an ellipsoid, which is an error. NULL: the particle's own index.
    pub shape_indices: *const i32,
    /// Semi-axes, 3 doubles per entry, from 1e-20 to 1e20, the largest at most 1e6 times the smallest. `count` entries, or
    /// as many as `shape_indices` refer to.
    pub semi_axes: *const f64,
    /// Bytes from one entry of `semi_axes` to the next, 24 or more.
    pub semi_axes_stride: usize,
    /// Quaternions (w, x, y, z) from body frame to world frame, 4 doubles per entry. They need not have unit length, but
    /// not zero length.
    pub quaternions: *const f64,
    /// Bytes from one entry of `quaternions` to the next, 32 or more.
    pub quaternions_stride: usize,
    /// Numbers by which error messages name the particles, [count] integers of `identifier_bytes` each. NULL: index + 1.
    pub identifiers: *const c_void,
    /// Size of an identifier: 4 or 8.
    pub identifier_bytes: i32,
    /// Forces, [count][3]: the contact forces are added. Those of ghosts change only with `newton` = 1 of the list.
    pub forces: *mut f64,
    /// Torques about the centres, [count][3]: the torques of the contacts are added, as with `forces`.
    pub torques: *mut f64,
    /// Where velocities and angular momenta (or angular velocities) above are those of the step at which the forces are
    /// computed: what they have more than those of the half step before, [count][6], as `ellgran_start_step` writes it. Viscous
    /// forces then take the velocities of the step, and those of a contact that began within the step are such that their sum
    /// has the impulse of its begin; tangential displacements and the work of forces take the velocities of the half step.
    /// Without friction and without `inelastic_loads` of the tallies the values are not read. NULL: the velocities above are
    /// those of the half step, and serve for all.
    pub velocity_changes: *const f64,
    /// 1 where since the last call of `ellgran_compute_wall` with the same wall the owned particles and their order have not changed, nor
    /// their shapes and `masks`, and nobody else has written the histories of the wall: particles far from the wall then cost little
    /// more than a look at their positions. 0 serves always. Other functions do not read it.
    pub unchanged: i64,
    /// The workspace of a call of `ellgran_compute_pairs` that succeeded, since which nothing but forces, torques and histories has changed:
    /// not the particles, their order, poses and motion, and not the time step. `ellgran_compute_wall` then takes from there what was
    /// prepared of particles near each other, which costs less than to prepare them again; of others near a wall too from the next step on.
    /// It may be the call's own workspace; another one must not be in use elsewhere during the call. A particle whose position or velocity is
    /// another all the same is prepared again. NULL serves always. Other functions do not read it.
    pub prepared_by: *const EllgranWorkspace,
}

growing!(EllgranParticles, torques: *mut f64);

/// Time step, and whether histories are advanced by it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranStep {
    /// `sizeof(EllgranStep)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// 1 in a time step: histories are advanced. 0 where forces are evaluated without a step, as when a run is set up: nothing
    /// slips, and what is remembered of a contact turns with its normal alone. Both write `touching` and histories, for the
    /// present positions: to try other positions, give a copy of them.
    pub advance_history: i32,
    /// Time step, from 0 to 1e15. Velocities given to this library must be those of the half step, with which the particles
    /// moved to their present positions: in velocity Verlet those between its two halves, in leapfrog those that it has.
    /// With velocities of the full step the tangential displacement has an error of the order of the time step, unless
    /// `velocity_changes` of the particles tell what they have more than those of the half step.
    pub time_step: f64,
}

growing!(EllgranStep);

/// Working memory of a sequence of calls, kept from step to step. Opaque.
///
/// Several threads may compute at the same time, each with its own workspace, with the same laws, if the arrays that they
/// write do not overlap. After an error the workspace still holds what the last successful call left in it. After
/// `ELLGRAN_ERROR_PANIC` it can still be used, but the histories that it kept are lost.
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

/// Makes a workspace. `ellgran_compute_pairs` will use the widest vector instruction set of this machine, or the one that
/// the environment variable `ELLGRAN_INSTRUCTION_SET` names: `scalar`, `baseline`, `avx2` or `avx512`. An empty variable
/// counts as not set.
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
pub unsafe extern "C" fn ellgran_workspace_bytes(workspace: *const EllgranWorkspace) -> usize {
    // SAFETY: promised by the caller.
    unsafe { workspace.as_ref() }.map_or(0, |w| w.workspace.bytes())
}

/// Number of contacts deeper than half the smallest local radius of curvature, summed over all calls since the workspace
/// was made; 0 for NULL. A number above 0 means that the material is too soft for Hertz' law at these loads. Such contacts
/// are also slow, since the deepest of them need a search for the global minimum.
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

pub(super) fn checked_time_step(time_step: f64) -> Result<f64, Failure> {
    if (0.0..=LONGEST_TIME_STEP).contains(&time_step) {
        Ok(time_step)
    } else {
        Err(Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!(
                "time_step = {} must be a finite number, 0 or greater, at most {LONGEST_TIME_STEP:e}",
                Number(time_step)
            ),
        ))
    }
}

impl EllgranStep {
    /// As the library takes it. Public for the border of `gpu/driver`; no interface for others.
    #[doc(hidden)]
    pub fn to_core(self) -> Result<Step, Failure> {
        Ok(Step {
            time_step: checked_time_step(self.time_step)?,
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
    /// Records of these particles alone, for lanes, some of which may be there.
    ChosenRecords(&'a [usize], PreparedBy<'a>),
    /// The pairs of a list, and whether list and particles are those of the last call.
    Pairs { unchanged: bool },
}

/// What the first `count` particles have more than at the half step; empty where that is not known.
///
/// # Safety
/// The arrays of `p` have the lengths that [`EllgranParticles`] states.
pub(super) unsafe fn changes(p: &EllgranParticles, count: usize) -> &[[f64; 6]] {
    if p.velocity_changes.is_null() {
        return &[];
    }
    // SAFETY: promised by the caller; the pointer is not NULL.
    unsafe { core::slice::from_raw_parts(p.velocity_changes.cast(), count) }
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
    check_strides(p.semi_axes_stride, p.quaternions_stride)?;
    // SAFETY: promised by the caller, for all arrays below.
    let rows =
        |pointer: *const f64, name: &str| unsafe { slice(pointer.cast::<[f64; 3]>(), count, name) };
    let rotation = if p.angular_velocities.is_null() {
        Rotation::Momentum(
            rows(p.angular_momenta, "angular_momenta (or angular_velocities)")?,
            // SAFETY: `masses` is NULL or valid for reads of `count` elements, as `EllgranParticles` demands.
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
        // SAFETY: `pointer` is NULL or valid for reads of `count` elements, by this function's safety section.
        unsafe { slice(pointer, count, "masses (or contact_masses)") }?
    } else {
        &[]
    };
    // Without friction nothing asks for the half step: the velocities of the step serve for all. Without laws it is not known.
    let changes = if laws.is_none_or(|l| l.features().friction) {
        // SAFETY: promised by the caller.
        unsafe { changes(p, count) }
    } else {
        &[]
    };
    let shape_indices = if p.shape_indices.is_null() {
        None
    } else {
        // SAFETY: `shape_indices` is NULL or valid for reads of `count` elements, as `EllgranParticles` demands.
        Some(unsafe { slice(p.shape_indices, count, "shape_indices") }?)
    };
    let arrays = ParticleArrays {
        owned: p.owned_count,
        positions: rows(p.positions, "positions")?,
        velocities: rows(p.velocities, "velocities")?,
        rotation,
        of_step: !p.velocity_changes.is_null(),
        changes,
        contact_masses,
        // SAFETY: `types` is NULL or valid for reads of `count` elements, as `EllgranParticles` demands.
        types: unsafe { slice(p.types, count, "types") }?,
        shape: Entries {
            particles: p,
            indices: shape_indices,
            count,
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
        (Purpose::ChosenRecords(chosen, prepared_by), laws) => {
            let types = laws.map_or(usize::MAX, Laws::types);
            workspace.prepare_chosen_records(&arrays, types, chosen, prepared_by)
        }
        _ => workspace.prepare(&arrays, laws.map_or(usize::MAX, Laws::types)),
    }
    .map_err(|e| Failure::new(ELLGRAN_ERROR_PARTICLE, e.to_string()))
}

/// Entries that overlap are the mark of a field that was left zero: every particle would have the shape of the first.
pub(super) fn check_strides(semi_axes: usize, quaternions: usize) -> Result<(), Failure> {
    for (stride, entry, name) in [
        (semi_axes, size_of::<[f64; 3]>(), "semi_axes_stride"),
        (quaternions, size_of::<[f64; 4]>(), "quaternions_stride"),
    ] {
        if stride < entry {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("{name} = {stride} must be at least {entry}, the bytes of an entry"),
            ));
        }
    }
    Ok(())
}

/// Shapes and attitudes of the particles of a call, which are as [`EllgranParticles`] states.
struct Entries<'a> {
    particles: &'a EllgranParticles,
    indices: Option<&'a [i32]>,
    count: usize,
}

/// The entry of a particle's or a body's shape: that of its index, or its own number where there are no indices; none where the index is negative.
#[inline(always)]
pub(super) fn entry_of(indices: Option<&[i32]>, k: usize) -> Option<usize> {
    match indices {
        None => Some(k),
        Some(indices) => usize::try_from(indices[k]).ok(),
    }
}

impl ParticleShapes for Entries<'_> {
    #[inline(always)]
    fn of(&self, k: usize) -> Option<([f64; 3], [f64; 4])> {
        let entry = entry_of(self.indices, k)?;
        // SAFETY: the caller promises an entry for every index that it names.
        Some(unsafe { shape_entry(self.particles, entry) })
    }

    #[inline(always)]
    fn place(&self, k: usize) -> Option<[&f64; 2]> {
        let entry = (k < self.count).then(|| entry_of(self.indices, k))??;
        let p = self.particles;
        // SAFETY: the caller promises an entry for every index that it names, and nothing writes while particles are read.
        unsafe {
            shape_place(
                p.semi_axes.byte_add(entry * p.semi_axes_stride),
                p.quaternions.byte_add(entry * p.quaternions_stride),
            )
        }
    }
}

/// The first and the last number of a shape, where they are aligned.
///
/// # Safety
/// There are three semi-axes and a quaternion, and nothing writes them during `'a`.
#[inline(always)]
pub(super) unsafe fn shape_place<'a>(
    semi_axes: *const f64,
    quaternion: *const f64,
) -> Option<[&'a f64; 2]> {
    // SAFETY: promised by the caller; what is not aligned is not referred to.
    unsafe {
        let last = quaternion.add(3);
        (semi_axes.is_aligned() && last.is_aligned()).then(|| [&*semi_axes, &*last])
    }
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
            "particle {i}: the contact with {with} has B/A = {}, where Hale's form of the Hertz factors is not \
             defined (above 25178): use factors exact",
            Number(ratio)
        ),
    )
}

/// The failure for an invalid history of a touching contact.
pub(super) fn history_failure(i: i64, j: Option<i64>, place: usize, value: f64) -> Failure {
    let with = j.map_or("a wall".to_owned(), |j| format!("particle {j}"));
    Failure::new(
        ELLGRAN_ERROR_HISTORY,
        format!(
            "particle {i}: the history of its contact with {with} is invalid: value {place} is {}. Set \
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
            "particle {i}: its contact with {with} has {name} = {}: sizes, motion and constants of the two give a result \
             out of the range of double precision",
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
