// SPDX-License-Identifier: MIT OR Apache-2.0
//! Walls: shapes, triangles and STL files of any content, against some bodies, in several calls while the wall moves.

use std::ffi::{CStr, CString};
use std::ptr;

use ellgran::c_api::contact::EllgranBody;
use ellgran::c_api::particles::EllgranStep;
use ellgran::c_api::rigid_wall::*;

use super::histories::numbers;
use super::neighbour_list::{bodies, Arrays};
use super::scene::*;

pub fn run(bytes: &[u8]) {
    let u = &mut Bytes::new(bytes);
    if let Ok(Some(laws)) = Laws::read(u) {
        let _ = calls(u, &laws, false);
    }
}

pub struct Wall(pub *mut EllgranWall);

impl Wall {
    pub fn new() -> Wall {
        let mut wall = Wall(ptr::null_mut());
        // SAFETY: valid for writes.
        assert!(succeeded(unsafe { ellgran_wall_new(&mut wall.0) }));
        wall
    }
}

impl Drop for Wall {
    fn drop(&mut self) {
        // SAFETY: made by ellgran_wall_new and not used again.
        unsafe { ellgran_wall_free(self.0) }
    }
}

pub fn maybe_any(u: &mut Bytes, value: f64) -> arbitrary::Result<f64> {
    if one_in(u, 32)? {
        number(u)
    } else {
        Ok(value)
    }
}

pub fn add_shape(u: &mut Bytes, wall: &Wall) -> arbitrary::Result<()> {
    const NAMES: [&CStr; 4] = [c"plane", c"cylinder", c"cone", c"sphere"];
    let mut vector = || -> arbitrary::Result<[f64; 3]> {
        let mut v: [f64; 3] = usual_vector(u)?;
        v[0] = maybe_any(u, v[0])?;
        Ok(v)
    };
    let (point, axis) = (vector()?, vector()?);
    let radii: [f64; 2] = usual_vector(u)?;
    let bounds: [f64; 2] = usual_vector(u)?;
    let bounds = [bounds[0].min(bounds[1]), bounds[0].max(bounds[1])];
    let bounded = one_in(u, 2)?;
    let shape = EllgranWallShape {
        size: size_of::<EllgranWallShape>(),
        name: u.choose(&NAMES)?.as_ptr(),
        point,
        axis,
        radii: [maybe_any(u, 2.0 * radii[0].abs())?, 2.0 * radii[1].abs()],
        bounds: if bounded { bounds } else { [0.0; 2] },
        ends: [u.int_in_range(0..=3)?, u.int_in_range(0..=2)?],
        side: u.int_in_range(0..=3)?,
        unused: 0,
    };
    // SAFETY: as written above.
    show("shape", &(unsafe { CStr::from_ptr(shape.name) }, &shape));
    // SAFETY: valid pointers; the name ends with NUL.
    succeeded(unsafe { ellgran_wall_add_shape(wall.0, &shape) });
    Ok(())
}

fn add_triangles(u: &mut Bytes, wall: &Wall) -> arbitrary::Result<()> {
    // Corners that triangles have in common, as of a surface.
    let corners: Vec<[f64; 3]> = (0..6).map(|_| usual_vector(u)).collect::<Result<_, _>>()?;
    let count = u.int_in_range(0..=8)?;
    let mut triangles = Vec::new();
    for _ in 0..count {
        for _ in 0..3 {
            let mut corner = *u.choose(&corners)?;
            corner[2] = maybe_any(u, corner[2])?;
            triangles.push(corner);
        }
    }
    if u.arbitrary()? {
        let mut largest = 0.0;
        // SAFETY: three corners for each triangle.
        succeeded(unsafe {
            ellgran_flatten_triangles(count, triangles.as_mut_ptr().cast(), &mut largest)
        });
    }
    show("triangles", &triangles);
    // SAFETY: three corners for each triangle.
    succeeded(unsafe { ellgran_wall_add_triangles(wall.0, count, triangles.as_ptr().cast()) });
    Ok(())
}

fn add_file(u: &mut Bytes, wall: &Wall) -> arbitrary::Result<()> {
    let scale = maybe_any(u, 1.0)?;
    let mut content = Vec::new();
    if u.arbitrary()? {
        // A binary file whose numbers are any.
        content.resize(80, 0);
        content.extend(u32::from(u.arbitrary::<u8>()? % 4).to_le_bytes());
    }
    let length = u.int_in_range(0..=400)?.min(u.len());
    content.extend(u.bytes(length)?);
    let path = std::env::temp_dir().join(format!(
        "ellgran-{}-{:?}.stl",
        std::process::id(),
        std::thread::current().id()
    ));
    std::fs::write(&path, content).expect("a file");
    let name = CString::new(path.to_str().expect("UTF-8")).expect("no NUL");
    let mut count = 0;
    // SAFETY: the path ends with NUL; NULL is allowed.
    let status = unsafe {
        ellgran_wall_add_stl(
            wall.0,
            name.as_ptr(),
            scale,
            ptr::null(),
            ptr::null(),
            &mut count,
        )
    };
    succeeded(status);
    std::fs::remove_file(&path).expect("the file");
    Ok(())
}

/// `strange`: the histories are any numbers.
pub fn calls(u: &mut Bytes, laws: &Laws, strange: bool) -> arbitrary::Result<()> {
    let wall = Wall::new();
    for _ in 0..u.int_in_range(1..=3)? {
        match u.int_in_range(0..=7)? {
            0..=3 => add_shape(u, &wall)?,
            4..=6 => add_triangles(u, &wall)?,
            _ => add_file(u, &wall)?,
        }
    }
    let workspace = Workspace::read(u)?;
    let mut bodies = bodies(u, laws.types, 6)?;
    let owned = bodies.len();
    let step = step(u)?;
    // SAFETY: valid pointers.
    let length = owned * unsafe { ellgran_wall_histories_length(wall.0, laws.pointer) };
    let mut histories = if strange {
        numbers(u, length)?
    } else {
        vec![0.0; length]
    };
    let mut motion = EllgranWallMotion {
        size: size_of::<EllgranWallMotion>(),
        origin: usual_vector(u)?,
        displacement: [0.0; 3],
        quaternion: if u.arbitrary()? {
            usual_vector(u)?
        } else {
            [0.0; 4]
        },
        velocity: usual_vector(u)?,
        angular_velocity: usual_vector(u)?,
        along_itself: 0,
        unused: 0,
        velocity_change: usual_vector(u)?,
        angular_velocity_change: usual_vector(u)?,
    };
    motion.velocity[0] = maybe_any(u, motion.velocity[0])?;
    show("histories", &histories);
    // With a list of its contacts, and without: then lanes take most of them from the search to the sums.
    let mut of_lanes = histories.clone();
    for _ in 0..3 {
        show("motion", &motion);
        let results = [true, false].map(|lists_contacts| {
            let histories = if lists_contacts {
                &mut histories
            } else {
                &mut of_lanes
            };
            let call = Call {
                laws,
                workspace: &workspace,
                wall: &wall,
                motion: &motion,
                step: &step,
                strange,
            };
            call.make(lists_contacts, &bodies, histories)
        });
        // Lanes do not look at what is remembered of a particle that does not touch. The forces are not held to each other: where a centre
        // lies on a triangle, rounding decides on which side it is.
        assert!(strange || results[0] == results[1], "one way fails");
        for (x, v) in motion.displacement.iter_mut().zip(motion.velocity) {
            *x += step.time_step * v;
        }
        for body in &mut bodies {
            advance(body, step.time_step);
        }
        if one_in(u, 4)? {
            let k = u.int_in_range(0..=owned - 1)?;
            bodies[k] = body(u, laws.types)?;
        }
    }
    Ok(())
}

/// One call for all bodies.
struct Call<'a> {
    laws: &'a Laws,
    workspace: &'a Workspace,
    wall: &'a Wall,
    motion: &'a EllgranWallMotion,
    step: &'a EllgranStep,
    strange: bool,
}

impl Call<'_> {
    /// Whether it succeeds.
    fn make(&self, lists_contacts: bool, bodies: &[EllgranBody], histories: &mut [f64]) -> bool {
        let wall = self.wall;
        // SAFETY: valid.
        assert!(succeeded(unsafe {
            ellgran_wall_record_contacts(wall.0, lists_contacts.into())
        }));
        let before = histories.to_vec();
        let mut arrays = Arrays::new(bodies.to_vec());
        let particles = arrays.particles(bodies.len());
        let mut load = EllgranWallLoad {
            size: size_of::<EllgranWallLoad>(),
            force: [0.0; 3],
            torque: [0.0; 3],
            power: 0.0,
            contact_count: 0,
            stiffness: 0.0,
            damping: 0.0,
            crowded_particle: 0,
            viscous_force: [0.0; 3],
            viscous_torque: [0.0; 3],
            tangential_force: [0.0; 3],
            tangential_torque: [0.0; 3],
        };
        // SAFETY: the arrays are as long as the structs say, the histories as the wall says.
        let status = unsafe {
            ellgran_compute_wall(
                self.laws.pointer,
                self.workspace.0,
                wall.0,
                &particles,
                ptr::null(),
                0,
                self.laws.types,
                self.motion,
                histories.as_mut_ptr(),
                self.step,
                &mut load,
                ptr::null_mut(),
            )
        };
        if !succeeded(status) {
            let forces = arrays.forces.as_flattened().iter();
            let torques = arrays.torques.as_flattened().iter();
            assert!(
                forces.chain(torques).all(|f| *f == 0.0),
                "forces of a failure"
            );
            assert!(
                same_bits(histories, &before),
                "histories of a call that failed"
            );
            assert_eq!((load.force, load.contact_count), ([0.0; 3], 0));
            return false;
        }
        if lists_contacts {
            recorded(wall);
        }
        assert_finite("forces", arrays.forces.as_flattened());
        assert_finite("torques", arrays.torques.as_flattened());
        assert_finite("force on the wall", &load.force);
        assert_finite("torque on the wall", &load.torque);
        assert_finite("numbers", &[load.power, load.stiffness, load.damping]);
        assert!(
            self.strange || histories.iter().all(|x| x.is_finite()),
            "{histories:?}"
        );
        true
    }
}

fn recorded(wall: &Wall) {
    // SAFETY: valid.
    for index in 0..unsafe { ellgran_wall_recorded_count(wall.0) } {
        let mut contact = sized::<EllgranRecordedWallContact>();
        // SAFETY: valid.
        assert!(succeeded(unsafe {
            ellgran_wall_recorded(wall.0, index, &mut contact)
        }));
        show("contact", &contact);
        assert!(contact.penetration > 0.0, "{contact:?}");
        for vector in [
            contact.point,
            contact.normal,
            contact.force,
            contact.torque,
            contact.tangential_force,
        ] {
            assert_finite("contact", &vector);
        }
    }
}
