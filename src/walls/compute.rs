// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contacts of all particles with a wall: force, torque, energies, and what is remembered of them.

use super::memory::MemoryLayout;
use super::motion::Motion;
use super::wall::{RecordedWallContact, TriangleLoad, Wall, WallLoad};
use crate::contact::particle::{self, Particle};
use crate::contact::staged::{Past, StagedContact};
use crate::contact::{Laws, Step};
use crate::geometry::triangles::Triangle;
use crate::tallies::{Contribution, Tallies};
use crate::vector::Vector3;

/// What a call is given.
pub struct WallInput<'a> {
    /// The laws; a contact follows that of the particle's type and `wall_type`.
    pub laws: &'a Laws,
    /// The wall's type, counted from 1.
    pub wall_type: usize,
    /// The particles that may touch ([`Wall::near`]), in that order.
    pub near: &'a [Particle],
    /// Number of all particles.
    pub particles: usize,
    /// Where the wall is and how it moves.
    pub motion: &'a Motion,
    /// The step.
    pub step: &'a Step,
}

/// What a call writes, one entry per particle.
pub struct WallOutput<'a> {
    /// Whether the wall acts on a particle.
    pub acts_on: &'a dyn Fn(usize) -> bool,
    /// What is remembered ([`Wall::memory`]).
    pub memory: &'a mut [f64],
    /// Forces, added to.
    pub forces: &'a mut [[f64; 3]],
    /// Torques about the centres, added to.
    pub torques: &'a mut [[f64; 3]],
}

/// Why a wall was not computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallError {
    /// Hale's form broke at a contact.
    Hale {
        /// The particle's index.
        particle: usize,
        /// `B/A`.
        ratio: f64,
    },
    /// A memory that holds a number which no call has written.
    Memory {
        /// The particle's index.
        particle: usize,
        /// Place in the particle's memory.
        place: usize,
        /// What stands there.
        value: f64,
    },
}

/// All particles against a wall.
///
/// # Errors
/// Before anything is written.
pub fn compute_wall(
    wall: &mut Wall,
    input: &WallInput<'_>,
    output: &mut WallOutput<'_>,
    mut tallies: Option<&mut Tallies<'_>>,
) -> Result<WallLoad, WallError> {
    let layout = wall.memory(input.laws);
    let length = layout.length();
    check(wall, input, output, &layout)?;
    if let Some(t) = tallies.as_deref_mut() {
        t.start_step();
    }
    let Wall {
        parts,
        search,
        found,
        before,
        near,
        part_forces,
        contacts,
        records_contacts,
        found_triangles,
        triangle_loads,
        records_triangles,
    } = wall;
    triangle_loads.clear();
    if *records_triangles {
        let triangles = parts.iter().map(|p| p.triangles().len()).sum();
        triangle_loads.resize(triangles, TriangleLoad::default());
    }
    part_forces.clear();
    part_forces.resize(parts.len(), Vector3::ZERO);
    contacts.clear();
    before.clear();
    before.resize(layout.records * layout.record, 0.0);
    let motion = input.motion;
    let mut load = WallLoad::default();
    let mut next = 0;
    for k in 0..input.particles {
        let memory = &mut output.memory[k * length..(k + 1) * length];
        if near.get(next) != Some(&k) {
            // far away: nothing is remembered any more
            if memory.first().is_some_and(|count| *count != 0.0) && (output.acts_on)(k) {
                memory.fill(0.0);
            }
            continue;
        }
        let i = &input.near[next];
        next += 1;
        let seen = motion.seen_from_wall(i, input.step);
        found.clear();
        found_triangles.clear();
        let mut first_triangle = 0;
        for (part, shape) in parts.iter().enumerate() {
            if shape.may_touch(seen.position, seen.radius) {
                let before = found.len();
                shape.touch(&seen.body, seen.position, search, &mut |surface| {
                    found.push((part, surface));
                });
                if *records_triangles {
                    found_triangles.extend((0..found.len() - before).map(|contact| {
                        let triangle = shape.touched_triangle(search, contact)?;
                        let normal = triangle_normal(&shape.triangles()[triangle]);
                        Some((first_triangle + triangle, normal))
                    }));
                }
            }
            if *records_triangles {
                first_triangle += shape.triangles().len();
            }
        }
        let records = layout.used(memory).max(1) - 1;
        if length > 0 {
            before[..records].copy_from_slice(&memory[1..1 + records]);
            memory.fill(0.0);
        }
        let law = input.laws.get(i.kind as usize, input.wall_type);
        let mut remembered = 0;
        for (place, (part, surface)) in found.iter().enumerate() {
            let Some(contact) = StagedContact::of_wall(&seen, surface) else {
                continue;
            };
            let mut past = if length > 0 {
                layout.recall(&mut before[..records], *part, surface, seen.position)
            } else {
                unremembered(&contact)
            };
            // Hale's form was tried before anything was written.
            let Ok(mut f) = contact.whole_force(
                law,
                law.constants.friction,
                effective_mass(&seen),
                input.step,
                &mut past,
            ) else {
                continue;
            };
            if remembered < layout.records {
                let at = 1 + remembered * layout.record;
                let record = &mut memory[at..at + layout.record];
                layout.remember(record, *part, surface, seen.position, &past);
                remembered += 1;
                memory[0] = remembered as f64;
            }
            for v in [
                &mut f.force,
                &mut f.torque_i,
                &mut f.tangential_force,
                &mut f.contact_point,
                &mut f.viscous_force,
                &mut f.frictional_force,
            ] {
                *v = motion.to_world(*v);
            }
            for (target, v) in [
                (&mut output.forces[k], -f.force),
                (&mut output.torques[k], f.torque_i),
            ] {
                target[0] += v.x;
                target[1] += v.y;
                target[2] += v.z;
            }
            load.contacts += 1;
            load.force = load.force + f.force;
            load.torque = load.torque + (i.position - motion.centre()).cross(f.force) - f.torque_i;
            part_forces[*part] = part_forces[*part] + f.force;
            let (stiffness, damping) = law.largest_springs(f.stiffness, effective_mass(&seen));
            load.stiffness += stiffness;
            load.damping += damping;
            if let Some(Some((triangle, normal))) = found_triangles.get(place) {
                let load = &mut triangle_loads[*triangle];
                load.force = load.force + f.force;
                let along = f.force.dot(motion.to_world(*normal));
                load.pressing -= along * surface.normal.dot(*normal).signum();
            }
            if let Some(t) = tallies.as_deref_mut() {
                t.pairs += 1;
                let time = if input.step.advance_history {
                    input.step.time_step
                } else {
                    0.0
                };
                t.add(
                    k,
                    None,
                    true,
                    &Contribution {
                        normal_energy: f.elastic_energy,
                        tangential_energy: f.tangential_energy,
                        works: [time * f.viscous_power, time * f.tangential_power],
                        d: f.contact_point,
                        force: f.force,
                        viscous_force: f.viscous_force,
                        tangential_force: f.frictional_force,
                        contact_point: f.contact_point,
                        wall_velocity: motion.velocity_at(i.position + f.contact_point),
                    },
                );
            }
            if *records_contacts {
                contacts.push(RecordedWallContact {
                    particle: k,
                    part: *part,
                    normal: motion.to_world(surface.normal),
                    point: i.position + f.contact_point,
                    penetration: contact.penetration(),
                    forces: f,
                });
            }
        }
    }
    load.power = load.force.dot(motion.velocity) + load.torque.dot(motion.angular_velocity);
    Ok(load)
}

/// Unit normal of a triangle by the right-hand rule; zero for one without area.
pub(super) fn triangle_normal(corners: &Triangle) -> Vector3 {
    let [a, b, c] = *corners;
    (b - a).cross(c - a).direction().unwrap_or(Vector3::ZERO)
}

/// The mass of a particle against a wall that nothing moves.
fn effective_mass(i: &Particle) -> f64 {
    particle::effective_mass(i.inverse_mass, 0.0)
}

fn unremembered(contact: &StagedContact) -> Past {
    Past {
        touched: false,
        normal: contact.normal(),
        memory: Vector3::ZERO,
        energy: 0.0,
    }
}

/// Whether every contact can be computed.
fn check(
    wall: &mut Wall,
    input: &WallInput<'_>,
    output: &WallOutput<'_>,
    layout: &MemoryLayout,
) -> Result<(), WallError> {
    let length = layout.length();
    if length > 0 {
        for k in &wall.near {
            let memory = &output.memory[k * length..(k + 1) * length];
            if let Some((place, value)) = layout.first_wrong(memory, wall.parts.len()) {
                return Err(WallError::Memory {
                    particle: *k,
                    place,
                    value,
                });
            }
        }
    }
    if !input.laws.features().hale {
        return Ok(());
    }
    let mut broken = None;
    for (i, k) in input.near.iter().zip(&wall.near) {
        let law = input.laws.get(i.kind as usize, input.wall_type);
        let seen = input.motion.seen_from_wall(i, input.step);
        for shape in &wall.parts {
            shape.touch(
                &seen.body,
                seen.position,
                &mut wall.search,
                &mut |surface| {
                    let contact = StagedContact::of_wall(&seen, &surface);
                    let tried = contact.map(|c| c.normal_force(law, effective_mass(&seen)));
                    if let (Some(Err(ratio)), None) = (tried, broken) {
                        broken = Some((*k, ratio.0));
                    }
                },
            );
        }
    }
    match broken {
        None => Ok(()),
        Some((particle, ratio)) => Err(WallError::Hale { particle, ratio }),
    }
}
