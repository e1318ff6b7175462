// SPDX-License-Identifier: MIT OR Apache-2.0
//! One contact at a time: for per-contact engines, for inspection, and for anyone who links the law alone.

use super::growing::{given, growing, Output};
use super::law::{check_type, EllgranLaws};
use super::particles::{hale_failure, history_failure, result_failure, EllgranStep};
use super::plane::EllgranPlane;
use super::status::{
    at_border, required, slice_mut, Failure, ELLGRAN_ERROR_NULL_POINTER, ELLGRAN_ERROR_PARTICLE,
};
use crate::contact::forces::MotionChange;
use crate::contact::one_contact::{geometry, one_contact_or_gap};
use crate::contact::{
    one_contact, prepare_body, Body, ContactForces, HistoryLayout, Laws, OneContact, Particle, Step,
};
use crate::vector::Vector3;
use crate::walls::{geometry_with_plane, one_contact_with_plane};

/// A body of a single contact, in the world frame. A value outside the range of its field is an error that names the body
/// and the value.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranBody {
    /// `sizeof(EllgranBody)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Centre; components up to 1e20.
    pub position: [f64; 3],
    /// Rotation from the body frame to the world frame, (w, x, y, z). Need not have unit length, but not zero length.
    pub quaternion: [f64; 4],
    /// Semi-axes along the body axes, from 1e-20 to 1e20, the largest at most 1e6 times the smallest.
    pub semi_axes: [f64; 3],
    /// Velocity of the centre; components up to 1e25. That of the half step (see `EllgranStep`), or of the step with
    /// `velocities_of_step`.
    pub velocity: [f64; 3],
    /// Angular velocity, world frame; components up to 1e25.
    pub angular_velocity: [f64; 3],
    /// Mass, from 1e-50 to 1e50, or INFINITY for a fixed body. Needed by damping with a coefficient of restitution and by
    /// stiffnesses and collision times.
    pub mass: f64,
    /// Particle type, counted from 1: selects the law.
    pub particle_type: i32,
    /// Number by which error messages name the body.
    pub identifier: i64,
    /// With `velocities_of_step`: what `velocity` has more than the velocity of the half step.
    pub velocity_change: [f64; 3],
    /// With `velocities_of_step`: what `angular_velocity` has more than that of the half step.
    pub angular_velocity_change: [f64; 3],
    /// 1: the velocities are those of the step at which the force is computed, as with `velocity_changes` of
    /// `EllgranParticles`, which says what the law then does. If one of two bodies has it, the other one is taken to be in
    /// steady motion. 0: they are those of the half step, and the changes are not read.
    pub velocities_of_step: i64,
}

growing!(EllgranBody, identifier: i64);

/// Geometry of a contact.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranContactGeometry {
    /// `sizeof(EllgranContactGeometry)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// 1 if the penetration is greater than 0.
    pub touching: i32,
    /// Penetration: the smallest translation that separates the bodies; minus the gap when they are apart.
    pub penetration: f64,
    /// Unit normal from i to j.
    pub normal: [f64; 3],
    /// Contact point, world frame. It lies between the two witness points and divides their distance in the ratio of the
    /// compliances of the bodies.
    pub contact_point: [f64; 3],
    /// Point of body i deepest in j (closest to j when apart), world frame.
    pub witness_i: [f64; 3],
    /// Point of body j deepest in i (closest to i when apart), world frame.
    pub witness_j: [f64; 3],
    /// Smaller relative curvature A, 1/length.
    pub curvature_a: f64,
    /// Larger relative curvature B, 1/length.
    pub curvature_b: f64,
    /// Unit vector along the major semi-axis of the contact ellipse, world frame: the direction in which the relative
    /// curvature is A.
    pub major_direction: [f64; 3],
}

growing!(EllgranContactGeometry);

/// Force of a contact.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranContactForce {
    /// `sizeof(EllgranContactForce)`; `ELLGRAN_INIT` sets it.
    pub size: usize,
    /// Force on j, world frame. The force on i is the opposite.
    pub force: [f64; 3],
    /// Torque on i about its own centre, world frame, with the couple that resists rolling and twisting.
    pub torque_i: [f64; 3],
    /// Torque on j about its own centre, world frame, with the opposite couple.
    pub torque_j: [f64; 3],
    /// Normal force; positive when repulsive.
    pub normal_force: f64,
    /// Tangential force on j, world frame.
    pub tangential_force: [f64; 3],
    /// Elastic tangential displacement xi of j relative to i, world frame.
    pub displacement: [f64; 3],
    /// Rate of penetration, > 0 while the bodies approach.
    pub penetration_rate: f64,
    /// Elastic energy of the normal deformation.
    pub elastic_energy: f64,
    /// Elastic energy of the tangential deformation, of rolling and of twisting.
    pub tangential_energy: f64,
    /// Viscous part of the force on j, normal and tangential, world frame.
    pub viscous_force: [f64; 3],
    /// Tangential force on j without its viscous part, world frame: that of the tangential displacement, limited by
    /// Coulomb's law.
    pub frictional_force: [f64; 3],
    /// Power dissipated by the viscous force at the given velocities, >= 0, and by the viscous parts of what resists rolling and twisting.
    pub viscous_power: f64,
    /// Power of the bodies against the rest of the tangential force and of what resists rolling and twisting, at the given
    /// velocities: stored in the tangential displacement and in the springs of these, or dissipated by friction.
    pub tangential_power: f64,
    /// Semi-axes a >= b of the contact ellipse at the elastic force; 0 for the linear law, which has no contact ellipse.
    pub contact_semi_axes: [f64; 2],
    /// Torque on i of the couple that resists rolling and twisting, without its viscous part, world frame. It is in torque_i, and its
    /// opposite in torque_j.
    pub frictional_couple: [f64; 3],
    /// Viscous part of that torque, world frame.
    pub viscous_couple: [f64; 3],
}

growing!(EllgranContactForce, contact_semi_axes: [f64; 2]);

impl EllgranBody {
    pub(super) fn to_core(self, types: Option<usize>) -> Result<Particle, Failure> {
        let of_step = self.velocities_of_step != 0;
        let half = |now: [f64; 3], change: [f64; 3]| {
            if of_step {
                core::array::from_fn(|k| now[k] - change[k])
            } else {
                now
            }
        };
        let particle = prepare_body(
            &Body {
                position: self.position,
                quaternion: self.quaternion,
                semi_axes: self.semi_axes,
                velocity: half(self.velocity, self.velocity_change),
                angular_velocity: half(self.angular_velocity, self.angular_velocity_change),
                mass: self.mass,
                particle_type: self.particle_type,
                identifier: self.identifier,
            },
            types,
        )
        .map_err(|e| Failure::new(ELLGRAN_ERROR_PARTICLE, e.to_string()))?;
        Ok(Particle {
            change: of_step.then(|| MotionChange {
                velocity: Vector3::from_array(self.velocity_change),
                omega: Vector3::from_array(self.angular_velocity_change),
            }),
            ..particle
        })
    }
}

impl From<&OneContact> for EllgranContactGeometry {
    fn from(g: &OneContact) -> Self {
        EllgranContactGeometry {
            size: size_of::<EllgranContactGeometry>(),
            touching: g.touching as i32,
            penetration: g.penetration,
            normal: g.normal.to_array(),
            contact_point: g.contact_point.to_array(),
            witness_i: g.witness_i.to_array(),
            witness_j: g.witness_j.to_array(),
            curvature_a: g.curvature_a,
            curvature_b: g.curvature_b,
            major_direction: g.major_direction.to_array(),
        }
    }
}

impl EllgranContactGeometry {
    /// Refuses results that are not finite.
    fn check(&self, i: i64, j: Option<i64>) -> Result<(), Failure> {
        let wrong = |name: &str, values: &[f64]| match values.iter().find(|x| !x.is_finite()) {
            None => Ok(()),
            Some(x) => Err(result_failure(i, j, name, *x)),
        };
        wrong("penetration", &[self.penetration])?;
        wrong("normal", &self.normal)?;
        wrong("contact_point", &self.contact_point)?;
        wrong("witness_i", &self.witness_i)?;
        wrong("witness_j", &self.witness_j)?;
        wrong("curvature", &[self.curvature_a, self.curvature_b])?;
        wrong("major_direction", &self.major_direction)
    }
}

impl EllgranContactForce {
    /// Refuses results that are not finite.
    pub(super) fn check(&self, i: i64, j: Option<i64>) -> Result<(), Failure> {
        let wrong = |name: &str, values: &[f64]| match values.iter().find(|x| !x.is_finite()) {
            None => Ok(()),
            Some(x) => Err(result_failure(i, j, name, *x)),
        };
        wrong("normal_force", &[self.normal_force])?;
        wrong("force", &self.force)?;
        wrong("torque_i", &self.torque_i)?;
        wrong("torque_j", &self.torque_j)?;
        wrong("tangential_force", &self.tangential_force)?;
        wrong("displacement", &self.displacement)?;
        wrong("penetration_rate", &[self.penetration_rate])?;
        wrong(
            "elastic energy",
            &[self.elastic_energy, self.tangential_energy],
        )?;
        wrong("power", &[self.viscous_power, self.tangential_power])?;
        wrong("contact_semi_axes", &self.contact_semi_axes)
    }
}

/// What a contact remembers, apart from the caller's array until all is known to be right.
struct History {
    numbers: [f64; HistoryLayout::LONGEST],
    length: usize,
}

impl History {
    fn read(
        laws: &Laws,
        touches: bool,
        given: &[f64],
        i: i64,
        j: Option<i64>,
    ) -> Result<History, Failure> {
        if let Some((place, value)) = laws.layout().first_wrong(given).filter(|_| touches) {
            return Err(history_failure(i, j, place, value));
        }
        let mut numbers = [0.0; HistoryLayout::LONGEST];
        numbers[..given.len()].copy_from_slice(given);
        Ok(History {
            numbers,
            length: given.len(),
        })
    }

    fn numbers(&mut self) -> &mut [f64] {
        &mut self.numbers[..self.length]
    }

    fn check(&self, laws: &Laws, i: i64, j: Option<i64>) -> Result<(), Failure> {
        match laws.layout().first_wrong(&self.numbers[..self.length]) {
            Some((_, value)) => Err(result_failure(i, j, "history", value)),
            None => Ok(()),
        }
    }
}

/// `of_ellipse`: the geometry for the semi-axes of the contact ellipse, where there is one and it is wanted.
pub(super) fn force_of(of_ellipse: Option<&OneContact>, f: &ContactForces) -> EllgranContactForce {
    let contact_semi_axes = of_ellipse.map_or([0.0; 2], OneContact::contact_semi_axes);
    EllgranContactForce {
        size: size_of::<EllgranContactForce>(),
        force: f.force.to_array(),
        torque_i: f.torque_i.to_array(),
        torque_j: f.torque_j.to_array(),
        normal_force: f.normal_force,
        tangential_force: f.tangential_force.to_array(),
        displacement: f.displacement.to_array(),
        penetration_rate: f.rate,
        elastic_energy: f.elastic_energy,
        tangential_energy: f.tangential_energy,
        viscous_force: f.viscous_force.to_array(),
        frictional_force: f.frictional_force.to_array(),
        viscous_power: f.viscous_power,
        tangential_power: f.tangential_power,
        contact_semi_axes,
        frictional_couple: f.frictional_couple.to_array(),
        viscous_couple: f.viscous_couple.to_array(),
    }
}

/// The touching flag, which may be NULL where the laws have no history.
fn flag<'a>(
    given: Option<&'a mut i32>,
    laws: &Laws,
    none: &'a mut i32,
) -> Result<&'a mut i32, Failure> {
    match given {
        Some(flag) => Ok(flag),
        None if laws.layout().length == 0 => Ok(none),
        None => Err(Failure::new(
            ELLGRAN_ERROR_NULL_POINTER,
            "touching must not be NULL",
        )),
    }
}

fn no_force() -> EllgranContactForce {
    EllgranContactForce {
        size: size_of::<EllgranContactForce>(),
        force: [0.0; 3],
        torque_i: [0.0; 3],
        torque_j: [0.0; 3],
        normal_force: 0.0,
        tangential_force: [0.0; 3],
        displacement: [0.0; 3],
        penetration_rate: 0.0,
        elastic_energy: 0.0,
        tangential_energy: 0.0,
        viscous_force: [0.0; 3],
        frictional_force: [0.0; 3],
        viscous_power: 0.0,
        tangential_power: 0.0,
        contact_semi_axes: [0.0; 2],
        frictional_couple: [0.0; 3],
        viscous_couple: [0.0; 3],
    }
}

/// What of a contact is to be computed beside its force.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    /// The geometry, of bodies that are apart too.
    pub geometry: bool,
    /// The semi-axes of the contact ellipse.
    pub ellipse: bool,
}

/// One contact of two ellipsoids with these names, computed and checked; `touching` and `history` are written on success alone.
#[inline]
pub(super) fn contact_of_two(
    laws: &Laws,
    [i, j]: [&Particle; 2],
    names: [i64; 2],
    step: &Step,
    wanted: Wanted,
    touching: &mut i32,
    history: &mut [f64],
) -> Result<(Option<EllgranContactGeometry>, EllgranContactForce), Failure> {
    let names = (names[0], Some(names[1]));
    let mut touches = *touching != 0;
    let mut kept = History::read(laws, touches, history, names.0, names.1)?;
    let numbers = kept.numbers();
    // The gap costs a search, so it is computed only where the geometry is wanted.
    let (found, forces) = if wanted.geometry {
        one_contact_or_gap(laws, i, j, step, &mut touches, numbers).map(|(g, f)| (Some(g), f))
    } else {
        one_contact(laws, i, j, step, &mut touches, numbers).map(Option::unzip)
    }
    .map_err(|ratio| hale_failure(names.0, names.1, ratio.0))?;
    let law = laws.get(i.particle_type as usize, j.particle_type as usize);
    let of_ellipse = found
        .as_ref()
        .filter(|_| wanted.ellipse && law.kinds.normal.elliptical);
    let result = forces.map_or_else(no_force, |f| force_of(of_ellipse, &f));
    let found = found.as_ref().map(EllgranContactGeometry::from);
    if let Some(found) = &found {
        found.check(names.0, names.1)?;
    }
    result.check(names.0, names.1)?;
    if touches {
        kept.check(laws, names.0, names.1)?;
    }
    history.copy_from_slice(kept.numbers());
    *touching = touches as i32;
    Ok((found, result))
}

/// Geometry of two ellipsoids, touching or apart: penetration or gap, normal, witness points, contact point, relative
/// curvature.
///
/// `laws` gives the compliances that divide the penetration at the contact point. With NULL the contact point is in the
/// middle, and types are not read. `start_normal` is NULL, or 3 doubles: the normal of the last step, of any length, from
/// which the search starts. It makes the call faster and does not change the result.
///
/// # Safety
/// `geometry` is NULL or valid for writes; the other pointers are NULL or valid for reads.
#[no_mangle]
pub unsafe extern "C" fn ellgran_contact_geometry(
    laws: *const EllgranLaws,
    i: *const EllgranBody,
    j: *const EllgranBody,
    start_normal: *const f64,
    geometry: *mut EllgranContactGeometry,
) -> i32 {
    at_border("ellgran_contact_geometry", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = unsafe { laws.as_ref() }.map(|l| &l.laws);
        let types = laws.map(Laws::types);
        // SAFETY: `i` and `j` are NULL or valid for reads, by this function's safety section.
        let (bi, bj) = unsafe { (given(i, "i")?, given(j, "j")?) };
        let (i, j) = (bi.to_core(types)?, bj.to_core(types)?);
        // SAFETY: `start_normal` is NULL or valid for reads of 3 values, by this function's safety section.
        let start = unsafe { start_normal.cast::<[f64; 3]>().as_ref() }
            .and_then(|n| Vector3::from_array(*n).direction());
        // SAFETY: `geometry` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let mut out = unsafe { Output::new(geometry, "geometry") }?;
        let share = laws.map_or(0.5, |l| {
            l.get(i.particle_type as usize, j.particle_type as usize)
                .constants
                .share_i
        });
        let found = EllgranContactGeometry::from(&self::geometry(&i, &j, share, start));
        found.check(bi.identifier, Some(bj.identifier))?;
        out.write(&found);
        Ok(())
    })
}

/// Geometry of an ellipsoid `i` and a plane wall. The normal points into the wall; the contact point is in the middle of
/// the penetration.
///
/// # Safety
/// `geometry` is NULL or valid for writes; the other pointers are NULL or valid for reads.
#[no_mangle]
pub unsafe extern "C" fn ellgran_contact_geometry_plane(
    i: *const EllgranBody,
    plane: *const EllgranPlane,
    geometry: *mut EllgranContactGeometry,
) -> i32 {
    at_border("ellgran_contact_geometry_plane", || {
        // SAFETY: promised by the caller, for all of this function.
        let body = unsafe { given(i, "i") }?;
        let i = body.to_core(None)?;
        // SAFETY: `plane` is NULL or valid for reads, by this function's safety section.
        let plane = unsafe { given(plane, "plane") }?.to_core()?;
        // SAFETY: `geometry` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let mut out = unsafe { Output::new(geometry, "geometry") }?;
        let found = EllgranContactGeometry::from(&geometry_with_plane(&i, &plane, 0.5));
        found.check(body.identifier, None)?;
        out.write(&found);
        Ok(())
    })
}

/// One contact of two ellipsoids: geometry, force, torques, energies. Where they do not touch, `touching` of the geometry
/// is 0, the force is zero, and the other fields of the geometry are those of `ellgran_contact_geometry`.
///
/// `touching` and `history` (`ellgran_laws_history_length` doubles; both NULL if 0) are the state of this pair: set them to
/// 0 before its first call, keep them from step to step. `geometry` may be NULL; the gap of bodies that do not touch is
/// then not computed, which is faster.
///
/// # Safety
/// The pointers are as stated, NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_contact(
    laws: *const EllgranLaws,
    i: *const EllgranBody,
    j: *const EllgranBody,
    step: *const EllgranStep,
    touching: *mut i32,
    history: *mut f64,
    geometry: *mut EllgranContactGeometry,
    force: *mut EllgranContactForce,
) -> i32 {
    at_border("ellgran_contact", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `i` and `j` are NULL or valid for reads, by this function's safety section.
        let (bi, bj) = unsafe { (given(i, "i")?, given(j, "j")?) };
        let (i, j) = (
            bi.to_core(Some(laws.types()))?,
            bj.to_core(Some(laws.types()))?,
        );
        // SAFETY: `step` is NULL or valid for reads, by this function's safety section.
        let step = unsafe { given(step, "step") }?.to_core()?;
        let mut none = 0;
        // SAFETY: `touching` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let touching = flag(unsafe { touching.as_mut() }, laws, &mut none)?;
        // SAFETY: `history` is NULL or valid for reads and writes of `laws.layout().length` elements, and not
        // aliased, by this function's safety section.
        let history = unsafe { slice_mut(history, laws.layout().length, "history") }?;
        // SAFETY: `force` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let mut force = unsafe { Output::new(force, "force") }?;
        // SAFETY: `geometry` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let out = unsafe { Output::optional(geometry, "geometry") }?;
        let names = [bi.identifier, bj.identifier];
        let wanted = Wanted {
            geometry: out.is_some(),
            ellipse: true,
        };
        let (found, result) =
            contact_of_two(laws, [&i, &j], names, &step, wanted, touching, history)?;
        force.write(&result);
        if let (Some(mut out), Some(found)) = (out, found) {
            out.write(&found);
        }
        Ok(())
    })
}

/// One contact of an ellipsoid `i` with a plane wall of type `wall_type`, otherwise as `ellgran_contact`. `torque_j` is
/// zero.
///
/// # Safety
/// The pointers are as stated, NULL or valid.
#[no_mangle]
#[allow(clippy::too_many_arguments)]
pub unsafe extern "C" fn ellgran_contact_plane(
    laws: *const EllgranLaws,
    i: *const EllgranBody,
    plane: *const EllgranPlane,
    wall_type: i32,
    step: *const EllgranStep,
    touching: *mut i32,
    history: *mut f64,
    geometry: *mut EllgranContactGeometry,
    force: *mut EllgranContactForce,
) -> i32 {
    at_border("ellgran_contact_plane", || {
        // SAFETY: promised by the caller, for all of this function.
        let laws = &unsafe { required(laws, "laws") }?.laws;
        // SAFETY: `i` is NULL or valid for reads, by this function's safety section.
        let bi = unsafe { given(i, "i") }?;
        let i = bi.to_core(Some(laws.types()))?;
        // SAFETY: `plane` is NULL or valid for reads, by this function's safety section.
        let plane = unsafe { given(plane, "plane") }?.to_core()?;
        let wall_type = check_type(laws, wall_type, "wall_type")?;
        // SAFETY: `step` is NULL or valid for reads, by this function's safety section.
        let step = unsafe { given(step, "step") }?.to_core()?;
        let mut none = 0;
        // SAFETY: `touching` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let touching = flag(unsafe { touching.as_mut() }, laws, &mut none)?;
        // SAFETY: `history` is NULL or valid for reads and writes of `laws.layout().length` elements, and not
        // aliased, by this function's safety section.
        let history = unsafe { slice_mut(history, laws.layout().length, "history") }?;
        // SAFETY: `force` is NULL or valid for reads and writes, and not aliased, by this function's safety section.
        let mut force = unsafe { Output::new(force, "force") }?;
        // SAFETY: `geometry` is NULL or valid for reads and writes, and not aliased, by this function's safety
        // section.
        let out = unsafe { Output::optional(geometry, "geometry") }?;
        let mut touches = *touching != 0;
        let mut kept = History::read(laws, touches, history, bi.identifier, None)?;
        let numbers = kept.numbers();
        let contact =
            one_contact_with_plane(laws, &i, &plane, wall_type, &step, &mut touches, numbers)
                .map_err(|ratio| hale_failure(bi.identifier, None, ratio.0))?;
        let law = laws.get(i.particle_type as usize, wall_type);
        let (found, result) = match &contact {
            Some((g, f)) => (*g, force_of(law.kinds.normal.elliptical.then_some(g), f)),
            None => (
                geometry_with_plane(&i, &plane, law.constants.share_i),
                no_force(),
            ),
        };
        let found = EllgranContactGeometry::from(&found);
        found.check(bi.identifier, None)?;
        result.check(bi.identifier, None)?;
        if touches {
            kept.check(laws, bi.identifier, None)?;
        }
        history.copy_from_slice(kept.numbers());
        *touching = touches as i32;
        force.write(&result);
        if let Some(mut out) = out {
            out.write(&found);
        }
        Ok(())
    })
}
