// SPDX-License-Identifier: MIT OR Apache-2.0
//! The contacts of all particles with a wall: force, torque, energies, and what is remembered of them.

use super::contact_history::{effective_mass, recalled, write_history};
use super::contacts::{Contacts, FoundContact, Frame, Places};
use super::histories::WrongHistory;
use super::motion::Motion;
use super::shape::Shape;
use super::touching_loads::TouchingLoads;
use super::wall::{RecordedWallContact, TriangleLoad, Wall, WallLoad};
use crate::contact::couple::{couple as contact_couple, Couple, TurningContact};
use crate::contact::particle::Particle;
use crate::contact::staged::{take_share, StagedContact, StagedHistory};
use crate::contact::wall_batch::{LastContact, WallBatch};
use crate::contact::{ContactForces, HistoryLayout, Laws, Step};
use crate::force::PairLaw;
use crate::geometry::triangles::Triangle;
use crate::simd::InstructionSet;
use crate::tallies::{Contribution, CoupleContribution, Tallies};
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
    /// The instructions that it may use.
    pub instruction_set: InstructionSet,
}

/// What a call writes, one entry per particle.
pub struct WallOutput<'a> {
    /// Whether the wall acts on a particle.
    pub acts_on: &'a dyn Fn(usize) -> bool,
    /// What is remembered ([`Wall::histories`]).
    pub histories: &'a mut [f64],
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
    /// Histories that hold a number which no call has written.
    History(WrongHistory),
}

/// All particles against a wall.
///
/// # Errors
/// Before anything is written.
///
/// # Example
/// A ball of radius 1 mm, 10 micrometres deep in a floor of the same material (SI units):
/// ```
/// use ellgran::contact::{prepare_body, Body, Laws, Step};
/// use ellgran::simd::InstructionSet;
/// use ellgran::vector::Vector3;
/// use ellgran::walls::{compute_wall, End, Motion, ShapeParameters, Side, Wall, WallInput, WallOutput};
///
/// let (parameters, _) = ellgran::force::syntax::parse(&["hertz", "1e7", "0.3"])?;
/// let laws = Laws::new(1, &[Some(parameters)], true)?;
/// let mut floor = Wall::new();
/// let plane = ShapeParameters {
///     point: Vector3::ZERO,
///     axis: Vector3::new(0.0, 0.0, 1.0),
///     radii: [0.0; 2],
///     bounds: [f64::NEG_INFINITY, f64::INFINITY],
///     ends: [End::None; 2],
///     side: Side::Inside,
/// };
/// floor.add_shape("plane", &plane)?;
/// let ball = Body {
///     position: [0.0, 0.0, 0.99e-3],
///     quaternion: [1.0, 0.0, 0.0, 0.0],
///     semi_axes: [1e-3; 3],
///     velocity: [0.0; 3],
///     angular_velocity: [0.0; 3],
///     mass: 1e-5,
///     particle_type: 1,
///     identifier: 1,
/// };
/// let near = floor.find_near(&Motion::REST, 1, |_| Some((Vector3::from_array(ball.position), 1e-3)));
/// assert_eq!(near, [0]);
/// let (mut forces, mut torques) = ([[0.0; 3]], [[0.0; 3]]);
/// let mut histories = vec![0.0; floor.histories(&laws).length()];
/// let load = compute_wall(
///     &mut floor,
///     &WallInput {
///         laws: &laws,
///         wall_type: 1,
///         near: &[prepare_body(&ball, Some(1))?],
///         motion: &Motion::REST,
///         step: &Step { time_step: 1e-6, advance_history: true },
///         instruction_set: InstructionSet::widest(),
///     },
///     &mut WallOutput { acts_on: &|_| true, histories: &mut histories, forces: &mut forces, torques: &mut torques },
///     None,
/// )
/// .expect("exact factors, and histories of zeros");
/// let modulus = 1e7 / (2.0 * (1.0 - 0.3f64.powi(2)));
/// let hertz = 4.0 / 3.0 * modulus * 1e-3f64.sqrt() * 1e-5f64.powf(1.5);
/// assert!((forces[0][2] / hertz - 1.0).abs() < 1e-9);
/// assert_eq!(load.force.z, -forces[0][2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn compute_wall(
    wall: &mut Wall,
    input: &WallInput<'_>,
    output: &mut WallOutput<'_>,
    mut tallies: Option<&mut Tallies<'_>>,
) -> Result<WallLoad, WallError> {
    wall.start_call();
    let of_laws = input.laws.layout();
    let layout = wall.histories(input.laws);
    let places = Places {
        near: input.near,
        motion: input.motion,
        step: input.step,
        frame: Frame::Wall,
    };
    wall.check_histories(layout, Some(&of_laws), output.histories)
        .map_err(WallError::History)?;
    wall.find_contacts(&places, layout, output.histories);
    check_factors(wall, input)?;
    if let Some(t) = tallies.as_deref_mut() {
        t.start_step();
    }
    let mut load = WallLoad::default();
    add_forces_of_found(wall, input, output, tallies, &mut load);
    wall.remember(output.histories, output.acts_on, &[]);
    load.crowded = wall.found.crowded();
    let motion = input.motion;
    load.power = load.force.dot(motion.velocity) + load.torque.dot(motion.angular_velocity);
    Ok(load)
}

/// The forces of the contacts that were found, added to what a call has already.
pub(super) fn add_forces_of_found(
    wall: &mut Wall,
    input: &WallInput<'_>,
    output: &mut WallOutput<'_>,
    tallies: Option<&mut Tallies<'_>>,
    load: &mut WallLoad,
) {
    let Wall {
        parts,
        found,
        part_forces,
        contacts,
        records_contacts,
        triangle_loads,
        records_triangles,
        touching_loads,
        keeps_inelastic_loads,
        ..
    } = wall;
    let halves = tallies
        .as_deref()
        .is_some_and(|t| t.inelastic_loads.is_none());
    let mut forces = Forces {
        input,
        of_laws: &input.laws.layout(),
        parts,
        part_forces,
        contacts: records_contacts.then_some(contacts),
        triangle_loads: records_triangles.then_some(triangle_loads),
        touching_loads: (*keeps_inelastic_loads && halves).then_some(touching_loads),
        forces: output.forces,
        torques: output.torques,
        tallies,
        load,
    };
    forces.of_all(found);
}

/// What the contacts of a call add to.
struct Forces<'p, 'i, 't> {
    input: &'p WallInput<'i>,
    of_laws: &'p HistoryLayout,
    parts: &'p [Box<dyn Shape>],
    part_forces: &'p mut [Vector3],
    contacts: Option<&'p mut Vec<RecordedWallContact>>,
    triangle_loads: Option<&'p mut Vec<TriangleLoad>>,
    touching_loads: Option<&'p mut TouchingLoads>,
    forces: &'p mut [[f64; 3]],
    torques: &'p mut [[f64; 3]],
    tallies: Option<&'p mut Tallies<'t>>,
    load: &'p mut WallLoad,
}

impl<'i> Forces<'_, 'i, '_> {
    /// All contacts that were found, in lanes where their law has them.
    fn of_all(&mut self, found: &mut Contacts) {
        let input = self.input;
        let mut batch = WallBatch::new(input.instruction_set);
        let count = found.all().len();
        for index in 0..count {
            let near = found.all()[index].near;
            let i = &input.near[near];
            let law = law_of(input, i);
            if !works_in_lanes(input.instruction_set, law) {
                self.of_batch(&mut batch, found, index);
                self.of_one(found, index);
                continue;
            }
            if batch.is_closed_to(law, i) {
                self.of_batch(&mut batch, found, index);
            }
            let (c, history) = found.with_history(index);
            let last = c.last_normal.map(|normal| {
                let (memory, energy) = self.of_laws.tangential(history);
                LastContact {
                    normal: if normal.is_unit() {
                        normal
                    } else {
                        -c.surface.normal
                    },
                    memory,
                    energy,
                }
            });
            let mass = effective_mass(i);
            if input.motion.is_none() {
                batch.push(law, i, &c.surface, mass, last.as_ref());
            } else {
                let seen = input.motion.seen_from_wall(i, input.step);
                batch.push(law, &seen, &c.surface, mass, last.as_ref());
            }
        }
        self.of_batch(&mut batch, found, count);
    }

    /// The contacts of a batch, the last of which is the one before `end`.
    fn of_batch(&mut self, batch: &mut WallBatch<'i>, found: &mut Contacts, end: usize) {
        let count = batch.len();
        let lanes = batch.compute(self.input.step);
        for lane in 0..count {
            let index = end - count + lane;
            if lanes.hard >> lane & 1 != 0 {
                self.of_one(found, index);
            } else if lanes.touching >> lane & 1 != 0 {
                let (mut f, penetration) = batch.forces(lane);
                let (c, history) = found.with_history(index);
                write_history(
                    self.of_laws,
                    &c.surface,
                    (f.memory, f.tangential_energy, &f.rests),
                    history,
                );
                if c.surface.share.value != 1.0 {
                    let law = law_of(self.input, &self.input.near[c.near]);
                    take_share(&c.surface.share, law.kinds.conservative, &mut f);
                }
                self.add(c, &mut f, penetration, None);
            } else {
                found.forget(index);
            }
        }
    }

    /// One contact.
    fn of_one(&mut self, found: &mut Contacts, index: usize) {
        let input = self.input;
        let (c, history) = found.with_history(index);
        let i = &input.near[c.near];
        let law = law_of(input, i);
        let Some(contact) = staged(input, i, c) else {
            found.forget(index);
            return;
        };
        let mut remembered = recalled(self.of_laws, c.last_normal, &c.surface, history);
        // Hale's form was tried before anything was written.
        let Ok(mut f) = contact.whole_force(
            law,
            law.constants.tangential.friction,
            effective_mass(i),
            input.step,
            &mut remembered,
        ) else {
            return;
        };
        let mut couple = None;
        let (x, curvature, share) = contact.for_law();
        if law.resistance.any() && share > 0.0 {
            let turning = TurningContact {
                // Of the whole surface.
                normal_force: f.normal_force / share,
                stiffness: f.stiffness / share,
                ..TurningContact::of(x, curvature, &f)
            };
            let (touched, before) = (c.last_normal.is_some(), c.last_normal.unwrap_or(x.normal));
            let mut own = contact_couple(
                law,
                &turning,
                self.of_laws,
                history,
                touched,
                before,
                input.step,
            )
            .times(share);
            for torque in [&mut own.elastic, &mut own.viscous] {
                *torque = input.motion.to_world(*torque);
            }
            couple = Some(own);
        }
        let StagedHistory {
            memory,
            energy,
            rests,
            springs,
            torques,
            ..
        } = &remembered;
        write_history(self.of_laws, &c.surface, (*memory, *energy, rests), history);
        self.of_laws.write_springs(history, springs.as_ref());
        self.of_laws.write_torques(history, torques.as_ref());
        self.add(c, &mut f, contact.penetration(), couple.as_ref());
    }

    /// Adds what acts at a contact; `f` in the frame of the wall, `couple` in that of the world.
    fn add(
        &mut self,
        c: &FoundContact,
        f: &mut ContactForces,
        penetration: f64,
        couple: Option<&Couple>,
    ) {
        let input = self.input;
        let motion = input.motion;
        let (k, i) = (c.particle, &input.near[c.near]);
        let law = law_of(input, i);
        if motion.axes.is_some() {
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
        }
        let (tangential_energy, powers) =
            (f.tangential_energy, [f.viscous_power, f.tangential_power]);
        if let Some(couple) = couple {
            couple.add_to_first(f);
        }
        for (target, v) in [
            (&mut self.forces[k], -f.force),
            (&mut self.torques[k], f.torque_i),
        ] {
            target[0] += v.x;
            target[1] += v.y;
            target[2] += v.z;
        }
        let load = &mut *self.load;
        load.contacts += 1;
        load.force = load.force + f.force;
        load.torque = load.torque + (i.position - motion.centre()).cross(f.force) - f.torque_i;
        self.part_forces[c.part] = self.part_forces[c.part] + f.force;
        let (stiffness, damping) = law.largest_springs(f.stiffness, effective_mass(i));
        load.stiffness += stiffness;
        load.damping += damping;
        if self.touching_loads.is_some() {
            let couples = couple.map_or([Vector3::ZERO; 2], |c| [c.viscous, c.elastic]);
            let parts = [f.viscous_force, f.frictional_force]
                .into_iter()
                .zip(couples);
            for (sum, (force, couple)) in load.inelastic.iter_mut().zip(parts) {
                sum.force = sum.force + force;
                if motion.spins() {
                    let arm = i.position + f.contact_point - motion.centre();
                    sum.torque = sum.torque + arm.cross(force) - couple;
                }
            }
        }
        if let Some(loads) = self.triangle_loads.as_deref_mut() {
            add_to_triangle(self.parts, loads, c, f.force, motion);
        }
        if let Some(t) = self.tallies.as_deref_mut() {
            t.pairs += 1;
            let time = input.step.elapsed();
            t.add(
                k,
                None,
                true,
                &Contribution {
                    normal_energy: f.elastic_energy,
                    tangential_energy,
                    works: powers.map(|power| time * power),
                    relaxed: f.relaxed_energy,
                    d: f.contact_point,
                    force: f.force,
                    viscous_force: f.viscous_force,
                    tangential_force: f.frictional_force,
                    contact_point: f.contact_point,
                    wall_velocity: motion.velocity_of(&c.surface, i.position + f.contact_point),
                },
                self.touching_loads.as_deref_mut().map(|l| l.of(k, c.near)),
            );
            if let Some(couple) = couple {
                let contribution = CoupleContribution {
                    energy: couple.energy,
                    works: [time * couple.viscous_power, time * couple.elastic_power],
                    viscous_torque: couple.viscous,
                    tangential_torque: couple.elastic,
                    wall_angular_velocity: motion.angular_velocity,
                };
                let load = self.touching_loads.as_deref_mut().map(|l| l.of(k, c.near));
                t.add_couple(k, None, true, &contribution, load);
            }
        }
        if let Some(contacts) = self.contacts.as_deref_mut() {
            contacts.push(RecordedWallContact {
                particle: k,
                part: c.part,
                normal: motion.to_world(c.surface.normal),
                point: i.position + f.contact_point,
                penetration,
                forces: *f,
            });
        }
    }
}

/// Whether the lanes have all terms of a law.
pub(super) fn works_in_lanes(set: InstructionSet, law: &PairLaw) -> bool {
    let without_friction = law.kinds.tangential.any() && !(law.constants.tangential.friction > 0.0);
    let one_at_a_time = law.kinds.hale
        || law.resistance.any()
        || law.kinds.normal.memory > 0
        || law.kinds.tangential.has_springs()
        || without_friction;
    set != InstructionSet::Scalar && !one_at_a_time
}

/// A contact that was found, if it touches, ready for its forces.
fn staged(input: &WallInput<'_>, i: &Particle, c: &FoundContact) -> Option<StagedContact> {
    if input.motion.is_none() {
        return StagedContact::of_wall(i, &c.surface);
    }
    StagedContact::of_wall(&input.motion.seen_from_wall(i, input.step), &c.surface)
}

/// Adds a force on the wall to the triangle of its contact, if it has one.
fn add_to_triangle(
    parts: &[Box<dyn Shape>],
    loads: &mut [TriangleLoad],
    c: &FoundContact,
    force: Vector3,
    motion: &Motion,
) {
    let Some(corners) = parts
        .get(c.part)
        .and_then(|p| p.triangles().get(c.triangle))
    else {
        return;
    };
    let before: usize = parts[..c.part].iter().map(|p| p.triangles().len()).sum();
    let load = &mut loads[before + c.triangle];
    load.force = load.force + force;
    let normal = triangle_normal(corners);
    let along = force.dot(motion.to_world(normal));
    load.pressing -= along * c.surface.normal.dot(normal).signum();
}

/// Unit normal of a triangle by the right-hand rule; zero for one without area.
pub(super) fn triangle_normal(corners: &Triangle) -> Vector3 {
    let [a, b, c] = *corners;
    (b - a).cross(c - a).direction().unwrap_or(Vector3::ZERO)
}

/// The law of a particle's type and the wall's.
fn law_of<'a>(input: &WallInput<'a>, i: &Particle) -> &'a PairLaw {
    input.laws.get(i.particle_type as usize, input.wall_type)
}

/// Whether Hale's form holds at every contact that was found.
fn check_factors(wall: &Wall, input: &WallInput<'_>) -> Result<(), WallError> {
    if !input.laws.features().hale {
        return Ok(());
    }
    for c in wall.found.all() {
        let i = &input.near[c.near];
        let Some(contact) = staged(input, i, c) else {
            continue;
        };
        if let Err(ratio) = contact.normal_force(law_of(input, i), effective_mass(i), 0.0) {
            return Err(WallError::Hale {
                particle: c.particle,
                ratio: ratio.0,
            });
        }
    }
    Ok(())
}
