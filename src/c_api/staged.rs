// SPDX-License-Identifier: MIT OR Apache-2.0
//! One contact in stages, for engines whose users combine surface, normal and tangential models themselves.

use super::contact::{force_of, EllgranBody, EllgranContactForce};
use super::growing::{given, growing, Output};
use super::law::{check_type, EllgranLaws};
use super::particles::{
    checked_time_step, hale_failure, history_failure, identifier, prepare, result_failure,
    EllgranParticles, EllgranStep, Purpose,
};
use super::status::{
    at_border, required, required_mut, slice_mut, Failure, ELLGRAN_ERROR_ARGUMENT,
    ELLGRAN_ERROR_LAW,
};
use crate::contact::pair::HaleRatio;
use crate::contact::ranges::{self, LARGEST_COORDINATE, LARGEST_MASS, LARGEST_VELOCITY};
use crate::contact::staged::{StagedContact, StagedHistory, WallSurface};
use crate::contact::{ContactForces, HistoryLayout, Step};
use crate::force::memory::MOST_PARTS;
use crate::force::parameters::LARGEST_CONSTANT;
use crate::force::PairLaw;
use crate::geometry::facet_shares::Share;
use crate::list::Workspace;
use crate::message::{Number, Numbers};
use crate::simd::InstructionSet;
use crate::vector::Vector3;

/// Of a wall, 1/length: that of the smallest body, as flat as it may be.
const LARGEST_CURVATURE: f64 = 1e26;

/// The surface of a wall where a body touches it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranWallSurface {
    /// `sizeof(EllgranWallSurface)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// The point of the surface that lies deepest in the body, world frame; components up to 1e20.
    pub point: [f64; 3],
    /// Normal out of the wall, towards the body; any length but zero.
    pub normal: [f64; 3],
    /// First principal direction; its component along the normal is ignored. Not read where both entries of `curvatures`
    /// are equal and both of `turning_radii` are equal.
    pub direction: [f64; 3],
    /// Curvatures along `direction` and across it, 1/length, up to 1e26: 0 for a plane, negative in a cavity.
    pub curvatures: [f64; 2],
    /// Distance from the point to the centre about which the normal turns as the body moves along `direction` and across
    /// it: INFINITY for a plane, Rc outside a cylinder of radius Rc, -Rc in a cavity of radius Rc, 0 across an edge.
    pub turning_radii: [f64; 2],
    /// Velocity of the surface there; components up to 1e25.
    pub velocity: [f64; 3],
    /// Share of the Hertz force that other faces of a mesh take over at this contact, from 0 to below 1; 0 where the
    /// surface acts alone.
    pub others_share: f64,
    /// Gradient of `others_share` with respect to the position of the body, 1/length; not read where `others_share` is 0.
    pub others_share_by_position: [f64; 3],
    /// Gradient of `others_share` with respect to a rotation of the body about its centre, 1/radian, world frame.
    pub others_share_by_rotation: [f64; 3],
    /// What the velocity of the surface at the step has more than `velocity`; read where the body's are those of the step. Components up
    /// to 1e25.
    pub velocity_change: [f64; 3],
}

growing!(EllgranWallSurface, others_share_by_rotation: [f64; 3]);

impl EllgranWallSurface {
    pub(super) fn to_core(self) -> Result<WallSurface, Failure> {
        let fail = |what| Failure::new(ELLGRAN_ERROR_ARGUMENT, what);
        let point = ranges::vector(self.point, LARGEST_COORDINATE, "wall: point").map_err(fail)?;
        let velocity =
            ranges::vector(self.velocity, LARGEST_VELOCITY, "wall: velocity").map_err(fail)?;
        let velocity_change = ranges::vector(
            self.velocity_change,
            LARGEST_VELOCITY,
            "wall: velocity_change",
        )
        .map_err(fail)?;
        let normal = Vector3::from_array(self.normal)
            .direction()
            .ok_or_else(|| {
                fail(format!(
                    "wall: normal = {} must be finite and not zero",
                    Numbers(&self.normal)
                ))
            })?;
        if !self.curvatures.iter().all(|k| k.abs() <= LARGEST_CURVATURE) {
            return Err(fail(format!(
                "wall: curvatures = {} must be between -{LARGEST_CURVATURE:e} and {LARGEST_CURVATURE:e}",
                Numbers(&self.curvatures)
            )));
        }
        let turns = |r: &f64| r.abs() <= LARGEST_COORDINATE || r.is_infinite();
        if !self.turning_radii.iter().all(turns) {
            return Err(fail(format!(
                "wall: turning_radii = {} must be between -{LARGEST_COORDINATE:e} and {LARGEST_COORDINATE:e}, or infinite",
                Numbers(&self.turning_radii)
            )));
        }
        let [by_position, by_rotation] = if self.others_share == 0.0 {
            [Vector3::ZERO; 2]
        } else {
            let gradient = |v, what| ranges::vector(v, LARGEST_CURVATURE, what).map_err(fail);
            [
                gradient(
                    self.others_share_by_position,
                    "wall: others_share_by_position",
                )?,
                gradient(
                    self.others_share_by_rotation,
                    "wall: others_share_by_rotation",
                )?,
            ]
        };
        if !(0.0..=1.0).contains(&self.others_share) {
            return Err(fail(format!(
                "wall: others_share = {} must be between 0 and 1",
                Number(self.others_share)
            )));
        }
        let tangential = Vector3::from_array(self.direction)
            .direction()
            .map(|given| given - normal * normal.dot(given))
            // Less is the rounding of a direction along the normal.
            .filter(|tangential| tangential.norm() > 1e-10)
            .and_then(Vector3::direction);
        let direction = if let Some(direction) = tangential {
            direction
        } else if self.curvatures[0] == self.curvatures[1]
            && self.turning_radii[0] == self.turning_radii[1]
        {
            crate::vector::Tangent::new(normal).u
        } else {
            return Err(fail(format!(
                "wall: direction = {} must not be zero nor along the normal",
                Numbers(&self.direction)
            )));
        };
        Ok(WallSurface {
            point,
            normal,
            direction,
            curvatures: self.curvatures,
            turning_radii: self.turning_radii,
            velocity,
            velocity_change,
            share: Share {
                value: 1.0 - self.others_share,
                by_position: -by_position,
                by_rotation: -by_rotation,
            },
        })
    }
}

/// Geometry of a contact that is computed in stages.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranStagedGeometry {
    /// `sizeof(EllgranStagedGeometry)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// 1 if the bodies touch; 0 otherwise, and then all other fields are zero.
    pub touching: i32,
    /// Penetration: the smallest translation that separates the bodies.
    pub penetration: f64,
    /// Unit normal from i to j, or into the wall.
    pub normal: [f64; 3],
    /// Contact point, world frame. It lies between the two witness points and divides their distance in the ratio of the
    /// compliances of the bodies.
    pub contact_point: [f64; 3],
}

growing!(EllgranStagedGeometry);

/// State of a contact at the last step, and its coefficient of friction.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranStagedHistory {
    /// `sizeof(EllgranStagedHistory)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Coefficient of friction of the pair of types.
    pub friction: f64,
    /// 1 if the bodies touched at the last step.
    pub touched: i32,
    /// Unit normal at the last step; changes sign when the two bodies are exchanged.
    pub normal: [f64; 3],
}

growing!(EllgranStagedHistory);

/// State of a contact between its stages. Opaque. One is enough for any number of contacts, one after the other; threads
/// need one each.
pub struct EllgranStagedContact {
    pub(super) contact: Option<StagedContact>,
    pub(super) identifiers: (i64, Option<i64>),
    /// For the begin of contacts, of normal forces alone.
    time_step: f64,
    /// The particles of a step, and what to call them.
    workspace: Workspace,
    names: Vec<i64>,
}

impl EllgranStagedContact {
    fn known(&self) -> Result<&StagedContact, Failure> {
        self.contact.as_ref().ok_or_else(|| {
            Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                "the bodies do not touch: forces exist for touching bodies only",
            )
        })
    }

    fn hale(&self, ratio: HaleRatio) -> Failure {
        hale_failure(self.identifiers.0, self.identifiers.1, ratio.0)
    }

    pub(super) fn write(
        &self,
        centre_i: Vector3,
        share_i: f64,
        out: &mut Output<EllgranStagedGeometry>,
    ) {
        let size = size_of::<EllgranStagedGeometry>();
        out.write(&match &self.contact {
            Some(contact) => EllgranStagedGeometry {
                size,
                touching: 1,
                penetration: contact.penetration(),
                normal: contact.normal().to_array(),
                contact_point: contact.contact_point(centre_i, share_i).to_array(),
            },
            None => EllgranStagedGeometry {
                size,
                touching: 0,
                penetration: 0.0,
                normal: [0.0; 3],
                contact_point: [0.0; 3],
            },
        });
    }
}

/// The effective mass, where the law reads it.
fn checked_mass(law: &PairLaw, effective_mass: f64) -> Result<f64, Failure> {
    if !law.kinds.normal.restitution || (0.0..=LARGEST_MASS).contains(&effective_mass) {
        Ok(effective_mass)
    } else {
        Err(Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!(
                "effective_mass = {} must be 0 or greater, at most {LARGEST_MASS:e}: damping restitution uses it",
                Number(effective_mass)
            ),
        ))
    }
}

pub(super) fn checked_share(share_i: f64) -> Result<f64, Failure> {
    if (0.0..=1.0).contains(&share_i) {
        Ok(share_i)
    } else {
        Err(Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!("share_i = {} is not between 0 and 1", Number(share_i)),
        ))
    }
}

/// Memory for the stages of a contact.
///
/// # Safety
/// `staged` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_new(staged: *mut *mut EllgranStagedContact) -> i32 {
    at_border("ellgran_staged_new", || {
        // SAFETY: promised by the caller.
        let out = unsafe { required_mut(staged, "staged") }?;
        *out = Box::into_raw(Box::new(EllgranStagedContact {
            contact: None,
            identifiers: (0, None),
            time_step: 0.0,
            workspace: Workspace::new(InstructionSet::Scalar),
            names: Vec::new(),
        }));
        Ok(())
    })
}

/// Frees what `ellgran_staged_new` gave; NULL is allowed.
///
/// # Safety
/// `staged` is NULL or came from `ellgran_staged_new` and is not used again.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_free(staged: *mut EllgranStagedContact) {
    if !staged.is_null() {
        // SAFETY: promised by the caller.
        drop(unsafe { Box::from_raw(staged) });
    }
}

/// Tells the time step of the contacts that follow, from 0 to 1e15, for `ellgran_staged_normal`: where velocities are those of the step
/// (`velocity_changes` of `EllgranParticles`), the viscous force of a contact that began within the step is such that the sum over the
/// steps has the impulse of its begin. 0, as in a new `EllgranStagedContact`: it is what the velocities make it.
///
/// # Safety
/// `staged` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_set_time_step(
    staged: *mut EllgranStagedContact,
    time_step: f64,
) -> i32 {
    at_border("ellgran_staged_set_time_step", || {
        // SAFETY: promised by the caller.
        let staged = unsafe { required_mut(staged, "staged") }?;
        staged.time_step = checked_time_step(time_step)?;
        Ok(())
    })
}

/// Checks and prepares all particles of a step, for `ellgran_staged_neighbours`. Any type from 1 is allowed; masses are not
/// read, and forces are not written.
///
/// # Safety
/// The pointers are NULL or valid; the arrays are as `EllgranParticles` states.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_prepare(
    staged: *mut EllgranStagedContact,
    particles: *const EllgranParticles,
) -> i32 {
    at_border("ellgran_staged_prepare", || {
        // SAFETY: promised by the caller, for all of this function.
        let staged = unsafe { required_mut(staged, "staged") }?;
        // SAFETY: `particles` is NULL or valid for reads, by this function's safety section.
        let p = &*unsafe { given(particles, "particles") }?;
        staged.names.clear();
        // SAFETY: the arrays of `particles` are NULL or as long as its counts say, as `EllgranParticles` demands.
        unsafe {
            prepare(
                p,
                p.count,
                None,
                &mut staged.workspace,
                Purpose::SingleContacts,
            )
        }?;
        staged.names.extend((0..p.count).map(|k| identifier(p, k)));
        Ok(())
    })
}

/// First stage for two particles of the last `ellgran_staged_prepare`, by their indices; otherwise as
/// `ellgran_staged_pair`.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_neighbours(
    staged: *mut EllgranStagedContact,
    i: usize,
    j: usize,
    share_i: f64,
    cached_normal: *mut f64,
    geometry: *mut EllgranStagedGeometry,
) -> i32 {
    at_border("ellgran_staged_neighbours", || {
        // SAFETY: promised by the caller, for all of this function.
        let (staged, mut out) = unsafe {
            (
                required_mut(staged, "staged")?,
                Output::new(geometry, "geometry")?,
            )
        };
        // SAFETY: `cached_normal` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let cache = unsafe { required_mut(cached_normal.cast::<[f64; 3]>(), "cached_normal") }?;
        let share_i = checked_share(share_i)?;
        let known = staged.names.len();
        let (Some(&name_i), Some(&name_j)) = (staged.names.get(i), staged.names.get(j)) else {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("particles {i} and {j} must be among the {known} of the last ellgran_staged_prepare"),
            ));
        };
        let particles = staged.workspace.particles();
        let (position, mut normal) = (particles[i].position, Vector3::from_array(*cache));
        StagedContact::of_pair(
            &particles[i],
            &particles[j],
            &mut normal,
            &mut staged.contact,
        );
        *cache = normal.to_array();
        staged.identifiers = (name_i, Some(name_j));
        staged.write(position, share_i, &mut out);
        Ok(())
    })
}

/// First stage for two ellipsoids: the geometry. Where they do not touch, all fields of the geometry are 0. Types are not
/// read.
///
/// `share_i` is the share of `i` in the penetration, 0.5 for equal materials. `cached_normal` (3 doubles; zeros at first)
/// is where the search starts. Keep it for each pair from step to step, and change its sign when the two bodies are
/// exchanged.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_pair(
    staged: *mut EllgranStagedContact,
    i: *const EllgranBody,
    j: *const EllgranBody,
    share_i: f64,
    cached_normal: *mut f64,
    geometry: *mut EllgranStagedGeometry,
) -> i32 {
    at_border("ellgran_staged_pair", || {
        // SAFETY: promised by the caller, for all of this function.
        let (staged, mut out) = unsafe {
            (
                required_mut(staged, "staged")?,
                Output::new(geometry, "geometry")?,
            )
        };
        // SAFETY: `i` and `j` are NULL or valid for reads, by this function's safety section.
        let (bi, bj) = unsafe { (given(i, "i")?, given(j, "j")?) };
        // SAFETY: `cached_normal` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let cache = unsafe { required_mut(cached_normal.cast::<[f64; 3]>(), "cached_normal") }?;
        let share_i = checked_share(share_i)?;
        let (i, j) = (bi.to_core(None)?, bj.to_core(None)?);
        let mut normal = Vector3::from_array(*cache);
        StagedContact::of_pair(&i, &j, &mut normal, &mut staged.contact);
        *cache = normal.to_array();
        staged.identifiers = (bi.identifier, Some(bj.identifier));
        staged.write(i.position, share_i, &mut out);
        Ok(())
    })
}

/// First stage for an ellipsoid and a wall; otherwise as `ellgran_staged_pair`.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_wall(
    staged: *mut EllgranStagedContact,
    i: *const EllgranBody,
    wall: *const EllgranWallSurface,
    share_i: f64,
    geometry: *mut EllgranStagedGeometry,
) -> i32 {
    at_border("ellgran_staged_wall", || {
        // SAFETY: promised by the caller, for all of this function.
        let (staged, mut out) = unsafe {
            (
                required_mut(staged, "staged")?,
                Output::new(geometry, "geometry")?,
            )
        };
        // SAFETY: `i` and `wall` are NULL or valid for reads, by this function's safety section.
        let (bi, wall) = unsafe { (given(i, "i")?, given(wall, "wall")?) };
        let share_i = checked_share(share_i)?;
        let i = bi.to_core(None)?;
        staged.contact = StagedContact::of_wall(&i, &wall.to_core()?);
        staged.identifiers = (bi.identifier, None);
        staged.write(i.position, share_i, &mut out);
        Ok(())
    })
}

/// Radius of the sphere that has the same elastic normal force when it is pressed into a plane by the same penetration: `Re
/// F2^-3`. A law for spheres gives with this radius the exact elastic normal force of the elliptic contact.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_equivalent_radius(
    staged: *const EllgranStagedContact,
    radius: *mut f64,
) -> i32 {
    at_border("ellgran_staged_equivalent_radius", || {
        // SAFETY: promised by the caller, for all of this function.
        let contact = unsafe { required(staged, "staged") }?.known()?;
        // SAFETY: `radius` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let out = unsafe { required_mut(radius, "radius") }?;
        *out = contact.equivalent_radius();
        Ok(())
    })
}

/// Normal and tangential stiffness of a circular contact with the same elastic normal force, force/length, for laws written for
/// spheres: `4/3 E* sqrt(R delta)` and `8 G* sqrt(R delta)` with the radius `R` of `ellgran_staged_equivalent_radius` and the
/// moduli of `ellgran_laws_mixture`; 0 for a law without a material.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_circular_stiffness(
    staged: *const EllgranStagedContact,
    laws: *const EllgranLaws,
    type_i: i32,
    type_j: i32,
    normal: *mut f64,
    tangential: *mut f64,
) -> i32 {
    at_border("ellgran_staged_circular_stiffness", || {
        // SAFETY: promised by the caller, for all of this function.
        let contact = unsafe { required(staged, "staged") }?.known()?;
        // SAFETY: `laws` is NULL or valid, by this function's safety section.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `normal` is NULL or valid for writes, by this function's safety section.
        let normal = unsafe { required_mut(normal, "normal") }?;
        // SAFETY: `tangential` is NULL or valid for writes, by this function's safety section.
        let tangential = unsafe { required_mut(tangential, "tangential") }?;
        let law = laws.get(
            check_type(laws, type_i, "type_i")?,
            check_type(laws, type_j, "type_j")?,
        );
        [*normal, *tangential] = contact.circular_stiffness(law);
        Ok(())
    })
}

/// Area of the plane section of the overlap, `pi delta / sqrt(A B)` with the relative curvatures `A` and `B`: for two spheres,
/// and to first order in the penetration over their radii, the area of the circle in which they intersect. Hertz' contact area
/// is half of it.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_section_area(
    staged: *const EllgranStagedContact,
    area: *mut f64,
) -> i32 {
    at_border("ellgran_staged_section_area", || {
        // SAFETY: promised by the caller, for all of this function.
        let contact = unsafe { required(staged, "staged") }?.known()?;
        // SAFETY: `area` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let out = unsafe { required_mut(area, "area") }?;
        *out = contact.section_area();
        Ok(())
    })
}

/// Second stage: the normal force with its torques, including the additional terms of `conservative`, without tangential
/// force. `effective_mass`, from 0 to 1e50, is used by damping with a coefficient of restitution. The semi-axes of the
/// contact ellipse are not computed. A law with `viscosity memory` or `displacement hysteretic` is refused: stages have no room
/// for what it remembers.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_normal(
    staged: *const EllgranStagedContact,
    laws: *const EllgranLaws,
    type_i: i32,
    type_j: i32,
    effective_mass: f64,
    force: *mut EllgranContactForce,
) -> i32 {
    at_border("ellgran_staged_normal", || {
        // SAFETY: promised by the caller, for all of this function.
        let staged = unsafe { required(staged, "staged") }?;
        // SAFETY: `laws` is NULL or valid for reads, by this function's safety section.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `force` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let mut out = unsafe { Output::new(force, "force") }?;
        let law = laws.get(
            check_type(laws, type_i, "type_i")?,
            check_type(laws, type_j, "type_j")?,
        );
        without_memory(law)?;
        let contact = staged.known()?;
        let effective_mass = checked_mass(law, effective_mass)?;
        let f = contact
            .normal_force(law, effective_mass, staged.time_step)
            .map_err(|ratio| staged.hale(ratio))?;
        let result = force_of(None, &f);
        result.check(staged.identifiers.0, staged.identifiers.1)?;
        out.write(&result);
        Ok(())
    })
}

/// Third stage: the tangential force and its torques, with the tangential law of the types and the coefficient of friction
/// of `history`. Laws that `ellgran_staged_normal` refuses are refused, and those that resist rolling or twisting.
///
/// `memory`: the part of a contact's history from `ellgran_laws_memory_offset` on; set it to 0 before the first step and
/// keep it from step to step: 4 doubles where any law has `displacement rescaled` (the default) or `hysteretic`, else 3. The first three
/// change sign when the two bodies are exchanged.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn ellgran_staged_tangential(
    staged: *const EllgranStagedContact,
    laws: *const EllgranLaws,
    type_i: i32,
    type_j: i32,
    effective_mass: f64,
    step: *const EllgranStep,
    history: *const EllgranStagedHistory,
    memory: *mut f64,
    force: *mut EllgranContactForce,
) -> i32 {
    at_border("ellgran_staged_tangential", || {
        // SAFETY: promised by the caller.
        unsafe {
            with_history(
                (
                    staged,
                    laws,
                    type_i,
                    type_j,
                    effective_mass,
                    step,
                    history,
                    memory,
                    force,
                ),
                |contact, law, friction, step, history| {
                    contact.tangential_force(law, friction, effective_mass, step, history)
                },
            )
        }
    })
}

/// Second and third stage together: the sum of `ellgran_staged_normal` and `ellgran_staged_tangential`, in about the time of
/// one of them. It refuses what they refuse.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn ellgran_staged_forces(
    staged: *const EllgranStagedContact,
    laws: *const EllgranLaws,
    type_i: i32,
    type_j: i32,
    effective_mass: f64,
    step: *const EllgranStep,
    history: *const EllgranStagedHistory,
    memory: *mut f64,
    force: *mut EllgranContactForce,
) -> i32 {
    at_border("ellgran_staged_forces", || {
        // SAFETY: promised by the caller.
        unsafe {
            with_history(
                (
                    staged,
                    laws,
                    type_i,
                    type_j,
                    effective_mass,
                    step,
                    history,
                    memory,
                    force,
                ),
                |contact, law, friction, step, history| {
                    contact.whole_force(law, friction, effective_mass, step, history)
                },
            )
        }
    })
}

/// The place of the first number of a memory that no call has written.
fn wrong_memory(layout: &HistoryLayout, memory: &[f64]) -> Option<usize> {
    let at = layout.memory?;
    let mut history = [0.0; HistoryLayout::LONGEST];
    history[at..at + memory.len()].copy_from_slice(memory);
    layout.first_wrong(&history).map(|(place, _)| place - at)
}

/// Refuses a law whose normal force has a memory, and one with springs of partial slip.
fn without_memory(law: &PairLaw) -> Result<(), Failure> {
    if law.kinds.tangential.has_springs() {
        return Err(Failure::new(
            ELLGRAN_ERROR_LAW,
            "the tangential force has no springs in stages: give 'displacement rescaled'",
        ));
    }
    if law.kinds.normal.memory == 0 {
        return Ok(());
    }
    Err(Failure::new(
        ELLGRAN_ERROR_LAW,
        "the normal force has no memory in stages: give 'viscosity first_order'",
    ))
}

type HistoryArguments = (
    *const EllgranStagedContact,
    *const EllgranLaws,
    i32,
    i32,
    f64,
    *const EllgranStep,
    *const EllgranStagedHistory,
    *mut f64,
    *mut EllgranContactForce,
);

/// Checks the arguments of the stages that remember, and writes what they give.
///
/// # Safety
/// The pointers are NULL or valid.
unsafe fn with_history(
    (staged, laws, type_i, type_j, effective_mass, step, history, memory, force): HistoryArguments,
    compute: impl FnOnce(
        &StagedContact,
        &PairLaw,
        f64,
        &Step,
        &mut StagedHistory,
    ) -> Result<ContactForces, HaleRatio>,
) -> Result<(), Failure> {
    // SAFETY: promised by the caller, for all of this function.
    let staged = unsafe { required(staged, "staged") }?;
    // SAFETY: `laws` is NULL or valid for reads, by this function's safety section.
    let laws = &unsafe { required(laws, "laws") }?.laws;
    // SAFETY: `force` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
    let mut out = unsafe { Output::new(force, "force") }?;
    // SAFETY: `history` is NULL or valid for reads, by this function's safety section.
    let history = unsafe { given(history, "history") }?;
    // SAFETY: `memory` is NULL or valid for reads, by this function's safety section.
    unsafe { required(memory.cast_const(), "memory") }?;
    // SAFETY: `step` is NULL or valid for reads, by this function's safety section.
    let step = unsafe { given(step, "step") }?.to_core()?;
    let law = laws.get(
        check_type(laws, type_i, "type_i")?,
        check_type(laws, type_j, "type_j")?,
    );
    if law.resistance.any() {
        return Err(Failure::new(
            ELLGRAN_ERROR_LAW,
            "rolling and twisting are not resisted in stages: give 'rolling none twisting none'",
        ));
    }
    without_memory(law)?;
    let friction = history.friction;
    if !(0.0..=LARGEST_CONSTANT).contains(&friction) {
        return Err(Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!(
                "friction = {} must be at least 0 and at most {LARGEST_CONSTANT:e}",
                Number(friction)
            ),
        ));
    }
    let contact = staged.known()?;
    let remembered = if laws.layout().energy.is_some() { 4 } else { 3 };
    // SAFETY: promised by the caller.
    let memory = unsafe { slice_mut(memory, remembered, "memory") }?;
    checked_mass(law, effective_mass)?;
    let (i, j) = staged.identifiers;
    if history.touched != 0 {
        if let Some(place) = wrong_memory(&laws.layout(), memory) {
            return Err(history_failure(i, j, place, memory[place]));
        }
    }
    let mut history = StagedHistory {
        touched: history.touched != 0,
        normal: Vector3::from_array(history.normal),
        memory: Vector3::new(memory[0], memory[1], memory[2]),
        energy: memory.get(3).copied().unwrap_or(0.0),
        rests: [0.0; MOST_PARTS],
        springs: None,
        torques: None,
    };
    let f = compute(contact, law, friction, &step, &mut history).map_err(|r| staged.hale(r))?;
    let result = force_of(None, &f);
    result.check(i, j)?;
    let [x, y, z] = history.memory.to_array();
    let remembered = [x, y, z, history.energy];
    if let Some(place) = wrong_memory(&laws.layout(), &remembered[..memory.len()]) {
        return Err(result_failure(i, j, "memory", remembered[place]));
    }
    memory.copy_from_slice(&remembered[..memory.len()]);
    out.write(&result);
    Ok(())
}
