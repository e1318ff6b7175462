// SPDX-License-Identifier: MIT OR Apache-2.0
//! One contact in stages, for engines whose users combine surface, normal and tangential models themselves.

use super::contact::{force_of, EllgranBody, EllgranContactForce, EllgranContactGeometry};
use super::law::{check_type, EllgranLaws};
use super::particles::{hale_failure, EllgranStep};
use super::status::{at_border, required, required_mut, Failure, ELLGRAN_ERROR_ARGUMENT};
use crate::geometry::Vector3;
use crate::pairs::one_contact::HaleRatio;
use crate::pairs::particles::Particle;
use crate::pairs::staged::{StagedContact, WallSurface};
use crate::pairs::OneContact;

/// The surface of a wall where a body touches it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranWallSurface {
    /// The point of the surface that lies deepest in the body, world frame.
    pub point: [f64; 3],
    /// Normal out of the wall, towards the body; any length but zero.
    pub normal: [f64; 3],
    /// First principal direction; only its part in the tangent plane counts. Not read where both entries of
    /// `curvatures` and of `turning_radii` are alike.
    pub direction: [f64; 3],
    /// Curvatures along `direction` and across it, 1/length: 0 for a plane, negative in a cavity.
    pub curvatures: [f64; 2],
    /// How far behind the point, along `direction` and across it, the surface turns as the body moves: INFINITY for a
    /// plane, -Rc in a cavity of radius Rc, 0 across an edge.
    pub turning_radii: [f64; 2],
    /// Velocity of the surface there.
    pub velocity: [f64; 3],
}

impl EllgranWallSurface {
    pub(super) fn to_core(self) -> Result<WallSurface, Failure> {
        let normal = Vector3::from_array(self.normal);
        let length = normal.norm();
        let (point, velocity) = (
            Vector3::from_array(self.point),
            Vector3::from_array(self.velocity),
        );
        let numbers = self.curvatures.iter().all(|k| k.is_finite())
            && self.turning_radii.iter().all(|r| !r.is_nan());
        if !(length > 0.0
            && length.is_finite()
            && point.is_finite()
            && velocity.is_finite()
            && numbers)
        {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("a wall with these values is none: {self:?}"),
            ));
        }
        let normal = normal * (1.0 / length);
        let given = Vector3::from_array(self.direction);
        let tangential = given - normal * normal.dot(given);
        let size = tangential.norm();
        let direction = if size > 0.0 && size.is_finite() {
            tangential * (1.0 / size)
        } else if self.curvatures[0] == self.curvatures[1]
            && self.turning_radii[0] == self.turning_radii[1]
        {
            crate::geometry::Tangent::new(normal).u
        } else {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("direction = {:?} lies along the normal", self.direction),
            ));
        };
        Ok(WallSurface {
            point,
            normal,
            direction,
            curvatures: self.curvatures,
            turning_radii: self.turning_radii,
            velocity,
        })
    }
}

/// A contact between its stages. Opaque; one per thread of calls, used for one contact after the other.
pub struct EllgranStagedContact {
    contact: Option<(StagedContact, OneContact)>,
    identifiers: (i64, Option<i64>),
}

impl EllgranStagedContact {
    fn known(&self) -> Result<&(StagedContact, OneContact), Failure> {
        self.contact.as_ref().ok_or_else(|| {
            Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                "the bodies do not touch: there is no force to ask for",
            )
        })
    }

    fn hale(&self, ratio: HaleRatio) -> Failure {
        hale_failure(self.identifiers.0, self.identifiers.1, ratio.0)
    }
}

fn checked_share(share_i: f64) -> Result<f64, Failure> {
    if (0.0..=1.0).contains(&share_i) {
        Ok(share_i)
    } else {
        Err(Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!("share_i = {share_i} is not between 0 and 1"),
        ))
    }
}

fn apart(centre: Vector3) -> EllgranContactGeometry {
    EllgranContactGeometry {
        touching: 0,
        penetration: 0.0,
        normal: [0.0; 3],
        contact_point: centre.to_array(),
        witness_i: centre.to_array(),
        witness_j: centre.to_array(),
        curvature_a: 0.0,
        curvature_b: 0.0,
        major_direction: [0.0; 3],
    }
}

fn write_geometry(
    staged: &mut EllgranStagedContact,
    found: Option<StagedContact>,
    i: &Particle,
    share_i: f64,
    out: &mut EllgranContactGeometry,
) {
    staged.contact = found.map(|c| (c, c.geometry(i.position, share_i)));
    *out = match &staged.contact {
        Some((_, geometry)) => EllgranContactGeometry::from(geometry),
        None => apart(i.position),
    };
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

/// First stage, two ellipsoids: the geometry. When they do not touch, `touching` of the geometry is 0 and the rest of it
/// says nothing. Types are not read.
///
/// `share_i` is the share of `i` in the penetration, 0.5 for equal materials. `cached_normal` (3 doubles; zeros at first)
/// is the start of the search, kept between steps; it belongs to the pair and changes sign when the pair is swapped.
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
    geometry: *mut EllgranContactGeometry,
) -> i32 {
    at_border("ellgran_staged_pair", || {
        // SAFETY: promised by the caller, for all of this function.
        let (staged, out) = unsafe {
            (
                required_mut(staged, "staged")?,
                required_mut(geometry, "geometry")?,
            )
        };
        let (bi, bj) = unsafe { (required(i, "i")?, required(j, "j")?) };
        let cache = unsafe { required_mut(cached_normal.cast::<[f64; 3]>(), "cached_normal") }?;
        let share_i = checked_share(share_i)?;
        let (i, j) = (bi.to_core(None)?, bj.to_core(None)?);
        let mut normal = Vector3::from_array(*cache);
        let found = StagedContact::of_pair(&i, &j, &mut normal);
        *cache = normal.to_array();
        staged.identifiers = (bi.identifier, Some(bj.identifier));
        write_geometry(staged, found, &i, share_i, out);
        Ok(())
    })
}

/// First stage, an ellipsoid and a wall; otherwise like `ellgran_staged_pair`.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_staged_wall(
    staged: *mut EllgranStagedContact,
    i: *const EllgranBody,
    wall: *const EllgranWallSurface,
    share_i: f64,
    geometry: *mut EllgranContactGeometry,
) -> i32 {
    at_border("ellgran_staged_wall", || {
        // SAFETY: promised by the caller, for all of this function.
        let (staged, out) = unsafe {
            (
                required_mut(staged, "staged")?,
                required_mut(geometry, "geometry")?,
            )
        };
        let (bi, wall) = unsafe { (required(i, "i")?, required(wall, "wall")?) };
        let share_i = checked_share(share_i)?;
        let i = bi.to_core(None)?;
        let found = StagedContact::of_wall(&i, &wall.to_core()?);
        staged.identifiers = (bi.identifier, None);
        write_geometry(staged, found, &i, share_i, out);
        Ok(())
    })
}

/// Radius of the sphere that feels the same elastic normal force when pressed into a plane as deep: `Re F2^-3`. With it a
/// law that was written for spheres gives the exact elastic normal force of the ellipse.
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
        let (contact, _) = unsafe { required(staged, "staged") }?.known()?;
        let out = unsafe { required_mut(radius, "radius") }?;
        *out = contact.equivalent_radius();
        Ok(())
    })
}

/// Second stage: the normal force with its torques, and the further terms of the conservative law. The tangential law of
/// the types is left out. `effective_mass` is read by damping with a coefficient of restitution. The semi-axes of the contact
/// ellipse are not computed here.
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
        let laws = &unsafe { required(laws, "laws") }?.laws;
        let out = unsafe { required_mut(force, "force") }?;
        let law = laws.get(
            check_type(laws, type_i, "type_i")?,
            check_type(laws, type_j, "type_j")?,
        );
        let (contact, geometry) = staged.known()?;
        let f = contact
            .normal(law, effective_mass)
            .map_err(|ratio| staged.hale(ratio))?;
        *out = force_of(geometry, &f, true);
        Ok(())
    })
}

/// Third stage: tangential force and its torques alone, with the tangential law of the types and this coefficient of
/// friction.
///
/// `touched`: 1 if the pair touched at the last step; `normal_before` (3 doubles): its normal then; `memory` (3 doubles):
/// the tangential displacement, kept between steps. Both change sign when the pair is swapped. `displacement rescaled`,
/// which remembers more, is not available here.
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
    friction: f64,
    effective_mass: f64,
    step: *const EllgranStep,
    touched: i32,
    normal_before: *const f64,
    memory: *mut f64,
    force: *mut EllgranContactForce,
) -> i32 {
    at_border("ellgran_staged_tangential", || {
        // SAFETY: promised by the caller, for all of this function.
        let staged = unsafe { required(staged, "staged") }?;
        let laws = &unsafe { required(laws, "laws") }?.laws;
        let out = unsafe { required_mut(force, "force") }?;
        let before = unsafe { required(normal_before.cast::<[f64; 3]>(), "normal_before") }?;
        let memory = unsafe { required_mut(memory.cast::<[f64; 3]>(), "memory") }?;
        let step = unsafe { required(step, "step") }?.to_core()?;
        let law = laws.get(
            check_type(laws, type_i, "type_i")?,
            check_type(laws, type_j, "type_j")?,
        );
        if !(friction >= 0.0 && friction.is_finite()) {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("friction = {friction} must be at least 0"),
            ));
        }
        if laws.layout().stiffness.is_some() {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                "displacement rescaled is not available in stages",
            ));
        }
        let (contact, geometry) = staged.known()?;
        let mut remembered = Vector3::from_array(*memory);
        let f = contact
            .tangential(
                law,
                friction,
                effective_mass,
                &step,
                touched != 0,
                Vector3::from_array(*before),
                &mut remembered,
            )
            .map_err(|ratio| staged.hale(ratio))?;
        *memory = remembered.to_array();
        *out = force_of(geometry, &f, true);
        Ok(())
    })
}
