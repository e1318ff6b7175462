// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contacts of all particles with a wall: force, torque, energies, and what is remembered of them.

use super::contacts::{FoundContact, Frame, Places, WrongMemory};
use super::motion::Motion;
use super::wall::{RecordedWallContact, Wall, WallLoad};
use crate::contact::particle::{self, Particle};
use crate::contact::staged::Past;
use crate::contact::{HistoryLayout, Laws, Step};
use crate::force::PairLaw;
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
    Memory(WrongMemory),
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
    let of_laws = input.laws.layout();
    let layout = wall.memory(input.laws);
    let places = Places {
        near: input.near,
        motion: input.motion,
        step: input.step,
        frame: Frame::Wall,
    };
    wall.find_contacts(&places, layout, Some(&of_laws), output.memory)
        .map_err(WallError::Memory)?;
    check_factors(wall, input)?;
    if let Some(t) = tallies.as_deref_mut() {
        t.start_step();
    }
    let parts = wall.part_count();
    let Wall {
        found,
        part_forces,
        contacts,
        records_contacts,
        ..
    } = wall;
    part_forces.clear();
    part_forces.resize(parts, Vector3::ZERO);
    contacts.clear();
    let motion = input.motion;
    let mut load = WallLoad::default();
    for index in 0..found.all().len() {
        let c = found.all()[index];
        let (k, i) = (c.particle, &input.near[c.near]);
        let law = law_of(input, i);
        let mut past = recalled(&of_laws, &c, found.history(index));
        // Hale's form was tried before anything was written.
        let Ok(mut f) = c.contact.whole_force(
            law,
            law.constants.tangential.friction,
            effective_mass(i),
            input.step,
            &mut past,
        ) else {
            continue;
        };
        write_history(&of_laws, &c, &past, found.history(index));
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
        part_forces[c.part] = part_forces[c.part] + f.force;
        if let Some(t) = tallies.as_deref_mut() {
            t.pairs += 1;
            let time = input.step.elapsed();
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
                    wall_velocity: motion.velocity_at(i.position + f.contact_point)
                        + motion.to_world(c.surface.velocity),
                },
            );
        }
        if *records_contacts {
            contacts.push(RecordedWallContact {
                particle: k,
                part: c.part,
                normal: c.world.normal,
                point: i.position + f.contact_point,
                penetration: c.contact.penetration(),
                forces: f,
            });
        }
    }
    found.remember(output.memory, output.acts_on);
    load.power = load.force.dot(motion.velocity) + load.torque.dot(motion.angular_velocity);
    Ok(load)
}

/// The mass of a particle against a wall that nothing moves.
fn effective_mass(i: &Particle) -> f64 {
    particle::effective_mass(i.inverse_mass, 0.0)
}

/// The law of a particle's type and the wall's.
fn law_of<'a>(input: &WallInput<'a>, i: &Particle) -> &'a PairLaw {
    input.laws.get(i.particle_type as usize, input.wall_type)
}

fn recalled(layout: &HistoryLayout, c: &FoundContact, history: &[f64]) -> Past {
    // without a tangential memory there is no history
    let vector = |at: usize| Vector3::new(history[at], history[at + 1], history[at + 2]);
    Past {
        touched: c.last_normal.is_some(),
        normal: c.last_normal.unwrap_or(c.contact.normal()),
        memory: layout.memory.map_or(Vector3::ZERO, vector),
        energy: layout.energy.map_or(0.0, |at| history[at]),
    }
}

fn write_history(layout: &HistoryLayout, c: &FoundContact, past: &Past, history: &mut [f64]) {
    let Some(at) = layout.memory else {
        return;
    };
    history[at..at + 3].copy_from_slice(&past.memory.to_array());
    if let Some(at) = layout.normal {
        history[at..at + 3].copy_from_slice(&(-c.surface.normal).to_array());
    }
    if let Some(at) = layout.energy {
        history[at] = past.energy;
    }
}

/// Whether Hale's form holds at every contact that was found.
fn check_factors(wall: &Wall, input: &WallInput<'_>) -> Result<(), WallError> {
    if !input.laws.features().hale {
        return Ok(());
    }
    for c in wall.found.all() {
        let i = &input.near[c.near];
        if let Err(ratio) = c.contact.normal_force(law_of(input, i), effective_mass(i)) {
            return Err(WallError::Hale {
                particle: c.particle,
                ratio: ratio.0,
            });
        }
    }
    Ok(())
}
