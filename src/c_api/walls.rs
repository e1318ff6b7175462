// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where an ellipsoid touches a wall: plane, cylinder, triangles. What `ellgran_staged_wall` is then told.

use super::contact::EllgranBody;
use super::growing::{given, growing, Output};
use super::staged::EllgranWallSurface;
use super::status::{at_border, required, required_mut, slice, Failure, ELLGRAN_ERROR_ARGUMENT};
use crate::contact::ranges::{self, LARGEST_COORDINATE};
use crate::geometry::cone::{touch_cone, Cone};
use crate::geometry::ellipsoid::LEAST_SEMI_AXIS;
use crate::geometry::facet_shares::Share;
use crate::geometry::triangles::{Feature, Triangle, TriangleSearch};
use crate::geometry::{touch_plane, Plane};
use crate::message::{Number, Numbers};
use crate::vector::{Tangent, Vector3};
use libc::size_t;

/// Which triangle stands for a contact of an ellipsoid with a wall.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EllgranWallContact {
    /// `sizeof(EllgranWallContact)`; `ELLGRAN_INIT` sets it.
    pub size: size_t,
    /// Index of the triangle that stands for the contact, 0 where there are none.
    pub triangle: size_t,
    /// Weights of that triangle's corners at the point of the surface; the velocity there is their mean so weighted.
    pub weights: [f64; 3],
}

growing!(EllgranWallContact);

/// Contacts found by one call, of a length that is not known before. Opaque; grows only when a particle has more contacts
/// or triangles than any before it.
#[derive(Default)]
pub struct EllgranWallContacts {
    all: Vec<(EllgranWallContact, EllgranWallSurface)>,
    triangles: Vec<Triangle>,
    search: TriangleSearch,
}

fn surface(point: Vector3, normal: Vector3, share: &Share) -> EllgranWallSurface {
    EllgranWallSurface {
        size: size_of::<EllgranWallSurface>(),
        point: point.to_array(),
        normal: normal.to_array(),
        direction: Tangent::new(normal).u.to_array(),
        curvatures: [0.0; 2],
        turning_radii: [f64::INFINITY; 2],
        velocity: [0.0; 3],
        others_share: 1.0 - share.value,
        others_share_by_position: (-share.by_position).to_array(),
        others_share_by_rotation: (-share.by_rotation).to_array(),
    }
}

/// Memory for the contacts of a particle.
///
/// # Safety
/// `contacts` is NULL or valid for writes.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_contacts_new(contacts: *mut *mut EllgranWallContacts) -> i32 {
    at_border("ellgran_wall_contacts_new", || {
        // SAFETY: promised by the caller.
        let out = unsafe { required_mut(contacts, "contacts") }?;
        *out = Box::into_raw(Box::default());
        Ok(())
    })
}

/// Frees what `ellgran_wall_contacts_new` gave; NULL is allowed.
///
/// # Safety
/// `contacts` is NULL or came from `ellgran_wall_contacts_new` and is not used again.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_contacts_free(contacts: *mut EllgranWallContacts) {
    if !contacts.is_null() {
        // SAFETY: promised by the caller.
        drop(unsafe { Box::from_raw(contacts) });
    }
}

/// Number of contacts of the last call; 0 for NULL.
///
/// # Safety
/// `contacts` is NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_contacts_count(
    contacts: *const EllgranWallContacts,
) -> size_t {
    // SAFETY: promised by the caller.
    unsafe { contacts.as_ref() }.map_or(0, |c| c.all.len())
}

/// The contact of this index, of the last call: the wall's `surface`, whose velocity is zero and is the caller's to set,
/// and, unless `contact` is NULL, the triangle.
///
/// # Safety
/// The pointers are NULL or valid.
#[no_mangle]
pub unsafe extern "C" fn ellgran_wall_contacts_get(
    contacts: *const EllgranWallContacts,
    index: size_t,
    contact: *mut EllgranWallContact,
    surface: *mut EllgranWallSurface,
) -> i32 {
    at_border("ellgran_wall_contacts_get", || {
        // SAFETY: promised by the caller, for all of this function.
        let all = &unsafe { required(contacts, "contacts") }?.all;
        let of_contact = unsafe { Output::optional(contact, "contact") }?;
        let mut of_surface = unsafe { Output::new(surface, "surface") }?;
        let (contact, surface) = all.get(index).ok_or_else(|| {
            Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!("index = {index} is not one of {} contacts", all.len()),
            )
        })?;
        of_surface.write(surface);
        if let Some(mut out) = of_contact {
            out.write(contact);
        }
        Ok(())
    })
}

/// A contact where there are no triangles.
const NO_TRIANGLE: EllgranWallContact = EllgranWallContact {
    size: size_of::<EllgranWallContact>(),
    triangle: 0,
    weights: [0.0; 3],
};

/// The contact of an ellipsoid with a plane that acts to both sides: the side is that of the ellipsoid's centre.
///
/// # Safety
/// The pointers are NULL or valid; `point` and `normal` have 3 doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_plane_contacts(
    contacts: *mut EllgranWallContacts,
    body: *const EllgranBody,
    point: *const f64,
    normal: *const f64,
) -> i32 {
    at_border("ellgran_plane_contacts", || {
        // SAFETY: promised by the caller, for all of this function.
        let contacts = unsafe { required_mut(contacts, "contacts") }?;
        let body = unsafe { given(body, "body") }?.to_core(None)?;
        let point = unsafe { vector(point, "point") }?;
        let mut normal = unsafe { direction(normal, "normal") }?;
        if normal.dot(body.position - point) < 0.0 {
            normal = -normal;
        }
        contacts.all.clear();
        let found = touch_plane(&body.body, body.position, &Plane { point, normal });
        if found.penetration > 0.0 {
            let deepest = body.position + found.support.point - found.normal * found.penetration;
            contacts
                .all
                .push((NO_TRIANGLE, surface(deepest, normal, &Share::WHOLE)));
        }
        Ok(())
    })
}

/// The contacts of an ellipsoid with a circular cylinder: from within, if its centre is - two, if both of its ends are beyond
/// the wall - else from without.
///
/// # Safety
/// The pointers are NULL or valid; `point` (of the axis) and `axis` have 3 doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_cylinder_contacts(
    contacts: *mut EllgranWallContacts,
    body: *const EllgranBody,
    point: *const f64,
    axis: *const f64,
    radius: f64,
) -> i32 {
    at_border("ellgran_cylinder_contacts", || {
        // SAFETY: promised by the caller, for all of this function.
        let contacts = unsafe { required_mut(contacts, "contacts") }?;
        let body = unsafe { given(body, "body") }?.to_core(None)?;
        let cylinder = Cone::cylinder(
            unsafe { vector(point, "point") }?,
            unsafe { direction(axis, "axis") }?,
            radius,
        );
        if !(LEAST_SEMI_AXIS..=LARGEST_COORDINATE).contains(&radius) {
            return Err(Failure::new(
                ELLGRAN_ERROR_ARGUMENT,
                format!(
                    "radius = {} must be greater than 0, from {LEAST_SEMI_AXIS:e} to {LARGEST_COORDINATE:e}",
                    Number(radius)
                ),
            ));
        }
        contacts.all.clear();
        let all = &mut contacts.all;
        let within = cylinder.has_within(body.position);
        let signed = if within { -radius } else { radius };
        touch_cone(&body.body, body.position, &cylinder, within, |c| {
            let surface = EllgranWallSurface {
                direction: cylinder.axis.cross(c.normal).to_array(),
                curvatures: [1.0 / signed, 0.0],
                turning_radii: [signed, f64::INFINITY],
                ..surface(c.point, c.normal, &Share::WHOLE)
            };
            all.push((NO_TRIANGLE, surface));
        });
        Ok(())
    })
}

/// The contacts of an ellipsoid with a surface of triangles, each once: on a face, at an edge or at a corner. An edge or a
/// corner is taken as flat in Hertz' law, with the normal that the contact has there. At a concave fold the faces act by
/// their shares, of which each is a contact: force and energy are continuous at any angle, and many facets are the curved
/// surface that they approach. A flat surface is one contact with the plane, in whatever pieces it comes.
///
/// `corners` is [count][3][3]: all triangles near the ellipsoid, since an edge whose other triangle is missing counts as
/// free.
///
/// # Safety
/// The pointers are NULL or valid; `corners` has `count * 9` doubles.
#[no_mangle]
pub unsafe extern "C" fn ellgran_triangle_contacts(
    contacts: *mut EllgranWallContacts,
    body: *const EllgranBody,
    count: size_t,
    corners: *const f64,
) -> i32 {
    at_border("ellgran_triangle_contacts", || {
        // SAFETY: promised by the caller, for all of this function.
        let contacts = unsafe { required_mut(contacts, "contacts") }?;
        let body = unsafe { given(body, "body") }?.to_core(None)?;
        let corners = unsafe { slice(corners.cast::<[[f64; 3]; 3]>(), count, "corners") }?;
        let EllgranWallContacts {
            all,
            triangles,
            search,
        } = contacts;
        for (index, corner) in corners.iter().flatten().enumerate() {
            if !corner.iter().all(|x| x.abs() <= LARGEST_COORDINATE) {
                let name = format!("corners[{}][{}]", index / 3, index % 3);
                ranges::vector(*corner, LARGEST_COORDINATE, &name)
                    .map_err(|what| Failure::new(ELLGRAN_ERROR_ARGUMENT, what))?;
            }
        }
        all.clear();
        triangles.clear();
        triangles.extend(corners.iter().map(|t| t.map(Vector3::from_array)));
        search.touch(&body.body, body.position, triangles);
        all.extend(search.contacts().iter().map(|c| {
            let flat = surface(c.point, c.normal, &c.share);
            let surface = match c.feature {
                Feature::Face => flat,
                Feature::Edge(along) => EllgranWallSurface {
                    direction: along.cross(c.normal).to_array(),
                    turning_radii: [0.0, f64::INFINITY],
                    ..flat
                },
                Feature::Corner => EllgranWallSurface {
                    turning_radii: [0.0; 2],
                    ..flat
                },
            };
            let contact = EllgranWallContact {
                triangle: c.triangle,
                weights: weights(&triangles[c.triangle], c.point),
                ..NO_TRIANGLE
            };
            (contact, surface)
        }));
        Ok(())
    })
}

/// Barycentric coordinates of a point of a triangle.
fn weights(t: &Triangle, p: Vector3) -> [f64; 3] {
    let (u, v, w) = (t[1] - t[0], t[2] - t[0], p - t[0]);
    let (uu, uv, vv) = (u.norm_squared(), u.dot(v), v.norm_squared());
    let determinant = uu * vv - uv * uv;
    if !(determinant > 0.0) {
        return [1.0 / 3.0; 3];
    }
    let (a, b) = (w.dot(u), w.dot(v));
    let second = (a * vv - b * uv) / determinant;
    let third = (b * uu - a * uv) / determinant;
    [1.0 - second - third, second, third]
}

/// # Safety
/// `pointer` is NULL or has 3 doubles.
unsafe fn vector(pointer: *const f64, name: &str) -> Result<Vector3, Failure> {
    // SAFETY: promised by the caller.
    let value = unsafe { required(pointer.cast::<[f64; 3]>(), name) }?;
    ranges::vector(*value, LARGEST_COORDINATE, name)
        .map_err(|what| Failure::new(ELLGRAN_ERROR_ARGUMENT, what))
}

/// # Safety
/// `pointer` is NULL or has 3 doubles.
unsafe fn direction(pointer: *const f64, name: &str) -> Result<Vector3, Failure> {
    // SAFETY: promised by the caller.
    let value = unsafe { required(pointer.cast::<[f64; 3]>(), name) }?;
    Vector3::from_array(*value).direction().ok_or_else(|| {
        Failure::new(
            ELLGRAN_ERROR_ARGUMENT,
            format!("{name} = {} has no direction", Numbers(value)),
        )
    })
}
