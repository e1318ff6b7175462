// SPDX-License-Identifier: MIT OR Apache-2.0
//! The walls of an engine that keeps its meshes and computes forces one contact after the other: triangles lent, contacts found, then
//! their forces in stages, and what is remembered of them.

use std::ptr;

use ellgran::c_api::contact::EllgranContactForce;
use ellgran::c_api::engine_walls::*;
use ellgran::c_api::particles::{EllgranParticles, EllgranStep};
use ellgran::c_api::rigid_wall::EllgranWallMotion;
use ellgran::c_api::staged::*;

use super::histories::numbers;
use super::neighbour_list::{bodies, Arrays};
use super::scene::*;
use super::walls::{add_shape, maybe_any, Wall};

/// What this engine keeps of each contact: whether it touched, its normal, and the memory of the law.
const KEPT: usize = 16;

pub fn run(bytes: &[u8]) {
    let u = &mut Bytes::new(bytes);
    if let Ok(Some(laws)) = Laws::read(u) {
        let _ = calls(u, &laws);
    }
}

struct Staged(*mut EllgranStagedContact);

impl Drop for Staged {
    fn drop(&mut self) {
        // SAFETY: made by ellgran_staged_new and not used again.
        unsafe { ellgran_staged_free(self.0) }
    }
}

/// Triangles near every particle.
fn lend(u: &mut Bytes, wall: &Wall, particles: usize) -> arbitrary::Result<()> {
    let corners: Vec<[f64; 3]> = (0..6).map(|_| usual_vector(u)).collect::<Result<_, _>>()?;
    let count = u.int_in_range(1..=6)?;
    let mut triangles: Vec<[f64; 3]> = Vec::new();
    let mut velocities: Vec<[f64; 3]> = Vec::new();
    for _ in 0..3 * count {
        let mut corner = *u.choose(&corners)?;
        corner[1] = maybe_any(u, corner[1])?;
        triangles.push(corner);
        velocities.push(usual_vector(u)?);
    }
    let (mut starts, mut near): (Vec<usize>, Vec<u32>) = (vec![0], Vec::new());
    for _ in 0..particles {
        near.extend(0..count as u32);
        starts.push(near.len());
    }
    if one_in(u, 16)? {
        let k = u.int_in_range(0..=near.len() - 1)?;
        near[k] = u.arbitrary()?;
    }
    let lent = EllgranLentTriangles {
        size: size_of::<EllgranLentTriangles>(),
        count,
        corners: triangles.as_ptr().cast(),
        velocities: if u.arbitrary()? {
            velocities.as_ptr().cast()
        } else {
            ptr::null()
        },
        particle_count: particles,
        near_starts: starts.as_ptr(),
        near: near.as_ptr(),
        velocity_changes: if u.arbitrary()? {
            velocities.as_ptr().cast()
        } else {
            ptr::null()
        },
    };
    // SAFETY: the arrays are as long as the struct says.
    succeeded(unsafe { ellgran_wall_lend_triangles(wall.0, &lent) });
    Ok(())
}

fn calls(u: &mut Bytes, laws: &Laws) -> arbitrary::Result<()> {
    let wall = Wall::new();
    if u.arbitrary()? {
        add_shape(u, &wall)?;
    }
    let workspace = Workspace::read(u)?;
    let mut bodies = bodies(u, laws.types, 5)?;
    let owned = bodies.len();
    lend(u, &wall, owned)?;
    let step = step(u)?;
    let mut motion = sized::<EllgranWallMotion>();
    motion.velocity = usual_vector(u)?;
    // SAFETY: valid.
    let length = owned * unsafe { ellgran_wall_found_histories_length(wall.0, KEPT) };
    let mut histories = if one_in(u, 8)? {
        numbers(u, length)?
    } else {
        vec![0.0; length]
    };
    let mut staged = Staged(ptr::null_mut());
    // SAFETY: valid for writes.
    assert!(succeeded(unsafe { ellgran_staged_new(&mut staged.0) }));
    for _ in 0..3 {
        let mut arrays = Arrays::new(bodies.clone());
        let particles = arrays.particles(owned);
        // SAFETY: the arrays are as long as the structs say, the histories as the wall says.
        let found = unsafe {
            ellgran_find_wall_contacts(
                workspace.0,
                wall.0,
                &particles,
                ptr::null(),
                0,
                &motion,
                KEPT,
                histories.as_ptr(),
            )
        };
        if succeeded(found) {
            // SAFETY: valid.
            for index in 0..unsafe { ellgran_wall_found_count(wall.0) } {
                contact(u, laws, &wall, &staged, index, &particles, &step)?;
            }
            // SAFETY: the histories are as long as the wall says.
            assert!(succeeded(unsafe {
                ellgran_remember_wall_contacts(
                    wall.0,
                    owned,
                    ptr::null(),
                    0,
                    histories.as_mut_ptr(),
                )
            }));
        }
        for (x, v) in motion.displacement.iter_mut().zip(motion.velocity) {
            *x += step.time_step * v;
        }
        for body in &mut bodies {
            advance(body, step.time_step);
        }
    }
    Ok(())
}

fn contact(
    u: &mut Bytes,
    laws: &Laws,
    wall: &Wall,
    staged: &Staged,
    index: usize,
    particles: &EllgranParticles,
    step: &EllgranStep,
) -> arbitrary::Result<()> {
    let mut found = sized::<EllgranFoundWallContact>();
    let mut geometry = sized::<EllgranStagedGeometry>();
    let share = if one_in(u, 16)? { number(u)? } else { 0.5 };
    // SAFETY: valid.
    let prepared = unsafe {
        assert!(succeeded(ellgran_wall_found(wall.0, index, &mut found)));
        succeeded(ellgran_staged_found(
            staged.0,
            wall.0,
            index,
            share,
            &mut geometry,
        ))
    };
    assert!(found.particle < particles.owned_count);
    assert_finite("point", &found.point);
    assert_finite("velocity", &found.velocity);
    assert_finite("last normal", &found.last_normal);
    if !prepared {
        return Ok(());
    }
    assert!(geometry.touching == 1 && geometry.penetration > 0.0);
    assert_finite("normal", &geometry.normal);
    assert_finite("contact point", &geometry.contact_point);
    let history = EllgranStagedHistory {
        size: size_of::<EllgranStagedHistory>(),
        friction: usual(u)?.abs(),
        touched: found.touched,
        normal: found.last_normal,
    };
    let mut force = sized::<EllgranContactForce>();
    // SAFETY: the type of a particle is that of the arrays; the history has more doubles than the memory of any law.
    let status = unsafe {
        ellgran_staged_forces(
            staged.0,
            laws.pointer,
            *particles.types.add(found.particle),
            1,
            *particles.masses.add(found.particle),
            step,
            &history,
            found.history,
            &mut force,
        )
    };
    if succeeded(status) {
        for vector in [force.force, force.torque_i, force.tangential_force] {
            assert_finite("force", &vector);
        }
        assert_finite("energies", &[force.elastic_energy, force.tangential_energy]);
    }
    Ok(())
}
