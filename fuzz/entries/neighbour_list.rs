// SPDX-License-Identifier: MIT OR Apache-2.0
//! `ellgran_compute_pairs`: a list of some bodies in several calls, on any instruction set, with histories that the workspace keeps
//! or not, and bodies that move, change or come to rest in between.

use std::ptr;

use ellgran::c_api::contact::EllgranBody;
use ellgran::c_api::neighbour_list::*;
use ellgran::c_api::particles::*;

use super::histories::numbers;
use super::scene::*;

pub fn run(bytes: &[u8]) {
    let u = &mut Bytes::new(bytes);
    if let Ok(Some(laws)) = Laws::read(u) {
        let _ = calls(u, &laws, false);
    }
}

/// The arrays of an engine.
pub struct Arrays {
    pub bodies: Vec<EllgranBody>,
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    spins: Vec<[f64; 3]>,
    masses: Vec<f64>,
    types: Vec<i32>,
    semi_axes: Vec<[f64; 3]>,
    quaternions: Vec<[f64; 4]>,
    identifiers: Vec<i64>,
    /// Empty where the velocities are those of the half step.
    changes: Vec<[f64; 6]>,
    pub forces: Vec<[f64; 3]>,
    pub torques: Vec<[f64; 3]>,
}

impl Arrays {
    pub fn new(bodies: Vec<EllgranBody>) -> Arrays {
        let of = |what: fn(&EllgranBody) -> [f64; 3]| bodies.iter().map(what).collect::<Vec<_>>();
        Arrays {
            positions: of(|b| b.position),
            velocities: of(|b| b.velocity),
            spins: of(|b| b.angular_velocity),
            masses: bodies.iter().map(|b| b.mass).collect(),
            types: bodies.iter().map(|b| b.particle_type).collect(),
            semi_axes: of(|b| b.semi_axes),
            quaternions: bodies.iter().map(|b| b.quaternion).collect(),
            identifiers: bodies.iter().map(|b| b.identifier).collect(),
            changes: if bodies[0].velocities_of_step == 0 {
                Vec::new()
            } else {
                let of = |b: &EllgranBody| {
                    let (v, w) = (b.velocity_change, b.angular_velocity_change);
                    [v[0], v[1], v[2], w[0], w[1], w[2]]
                };
                bodies.iter().map(of).collect()
            },
            forces: vec![[0.0; 3]; bodies.len()],
            torques: vec![[0.0; 3]; bodies.len()],
            bodies,
        }
    }

    pub fn particles(&mut self, owned: usize) -> EllgranParticles {
        EllgranParticles {
            size: size_of::<EllgranParticles>(),
            owned_count: owned,
            count: self.positions.len(),
            positions: self.positions.as_ptr().cast(),
            velocities: self.velocities.as_ptr().cast(),
            angular_velocities: self.spins.as_ptr().cast(),
            angular_momenta: ptr::null(),
            masses: self.masses.as_ptr(),
            contact_masses: ptr::null(),
            types: self.types.as_ptr(),
            shape_indices: ptr::null(),
            semi_axes: self.semi_axes.as_ptr().cast(),
            semi_axes_stride: size_of::<[f64; 3]>(),
            quaternions: self.quaternions.as_ptr().cast(),
            quaternions_stride: size_of::<[f64; 4]>(),
            identifiers: self.identifiers.as_ptr().cast(),
            identifier_bytes: 8,
            forces: self.forces.as_mut_ptr().cast(),
            torques: self.torques.as_mut_ptr().cast(),
            velocity_changes: if self.changes.is_empty() {
                ptr::null()
            } else {
                self.changes.as_ptr().cast()
            },
            unchanged: 0,
            prepared_by: ptr::null(),
        }
    }
}

pub fn bodies(u: &mut Bytes, types: i32, most: usize) -> arbitrary::Result<Vec<EllgranBody>> {
    let count = u.int_in_range(1..=most)?;
    (0..count).map(|_| body(u, types)).collect()
}

/// Each pair once, in either order, or with an entry that names no other particle.
fn rows(u: &mut Bytes, count: usize) -> arbitrary::Result<Vec<Vec<i32>>> {
    let mut rows = vec![Vec::new(); count];
    for i in 0..count {
        for j in i + 1..count {
            match u.int_in_range(0..=3)? {
                0 => {}
                1 => rows[j].push(i as i32),
                _ => rows[i].push(j as i32),
            }
        }
    }
    if one_in(u, 16)? {
        rows[0].push(u.arbitrary()?);
    }
    Ok(rows)
}

/// `strange`: the histories are any numbers, of contacts that are said to touch.
pub fn calls(u: &mut Bytes, laws: &Laws, strange: bool) -> arbitrary::Result<()> {
    let workspace = Workspace::read(u)?;
    let mut bodies = bodies(u, laws.types, 12)?;
    let count = bodies.len();
    let owned = u.int_in_range(0..=count)?;
    let rows = rows(u, count)?;
    let step = step(u)?;
    let (newton, keep, record): (bool, bool, bool) =
        (u.arbitrary()?, u.arbitrary()?, u.arbitrary()?);
    let mut touching: Vec<Vec<i32>> = Vec::new();
    let mut history: Vec<Vec<f64>> = Vec::new();
    for row in &rows {
        touching.push(vec![i32::from(strange); row.len()]);
        history.push(if strange {
            numbers(u, row.len() * laws.length)?
        } else {
            vec![0.0; row.len() * laws.length]
        });
    }
    let central: Vec<i32> = (0..owned as i32).collect();
    let counts: Vec<i32> = rows.iter().map(|row| row.len() as i32).collect();
    let row_pointers: Vec<_> = rows.iter().map(|row| row.as_ptr()).collect();
    show("rows", &(owned, newton, keep, &rows, &history));
    let mut computed = false;
    for _ in 0..u.int_in_range(1..=4)? {
        let before = (touching.clone(), history.clone());
        let touching_pointers: Vec<_> = touching.iter_mut().map(|row| row.as_mut_ptr()).collect();
        let history_pointers: Vec<_> = history.iter_mut().map(|row| row.as_mut_ptr()).collect();
        let list = EllgranNeighbourList {
            size: size_of::<EllgranNeighbourList>(),
            count: owned,
            central: central.as_ptr(),
            neighbour_counts: counts.as_ptr(),
            neighbours: row_pointers.as_ptr(),
            index_mask: -1,
            special_shift: 0,
            special_factors: ptr::null(),
            newton: i32::from(newton),
            unchanged: i32::from(computed),
            keep_history: i32::from(keep),
            record_contacts: i32::from(record),
            touching: touching_pointers.as_ptr(),
            history: history_pointers.as_ptr(),
        };
        let mut arrays = Arrays::new(bodies.clone());
        let particles = arrays.particles(owned);
        // SAFETY: the arrays are as long as the structs say; touching and history are the caller's and not changed between calls.
        let status = unsafe {
            ellgran_compute_pairs(
                laws.pointer,
                workspace.0,
                &particles,
                &list,
                &step,
                ptr::null_mut(),
            )
        };
        if succeeded(status) {
            computed = true;
            assert_finite("forces", arrays.forces.as_flattened());
            assert_finite("torques", arrays.torques.as_flattened());
            if !newton {
                let ghosts = arrays.forces[owned..].as_flattened();
                assert!(ghosts.iter().all(|f| *f == 0.0), "forces on ghosts");
            }
        } else {
            let forces = arrays.forces.as_flattened().iter();
            let torques = arrays.torques.as_flattened().iter();
            assert!(
                forces.chain(torques).all(|f| *f == 0.0),
                "forces of a failure"
            );
            assert_eq!(touching, before.0);
            for (row, was) in history.iter().zip(&before.1) {
                assert!(same_bits(row, was), "history of a call that failed");
            }
        }
        if computed && one_in(u, 3)? {
            // SAFETY: the list of the last successful call.
            assert!(succeeded(unsafe {
                ellgran_write_history(workspace.0, &list)
            }));
            // Those of ghosts are not in the list.
            for (flags, numbers) in touching[..owned].iter().zip(&history) {
                for (flag, one) in flags.iter().zip(numbers.chunks(laws.length.max(1))) {
                    if *flag != 0 {
                        assert_finite("history", one);
                    }
                }
            }
        }
        for body in &mut bodies {
            advance(body, step.time_step);
        }
        if one_in(u, 4)? {
            let k = u.int_in_range(0..=count - 1)?;
            bodies[k] = body(u, laws.types)?;
        }
    }
    Ok(())
}
