// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which particles touch which planes of a wall, and what does each contact go on from?

use super::histories::{WallHistoryLayout, WrongHistory};
use super::shape::WholePlane;
use crate::contact::particle::Particle;
use crate::contact::ranges::LARGEST_DISPLACEMENT;
use crate::contact::HistoryLayout;
use crate::geometry::ConvexBody;
use crate::list::shapes::{Ellipsoids, Kind, Spheroids};
use crate::list::{ParticleRecords, Shapes};
use crate::real::Real;
use crate::simd::{InstructionSet, Lanes, Line, Registers, Stage, MOST_LANES};
use crate::vector::Vector3;

/// A particle that touches one plane and no other.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaneContact {
    /// Its place among those that may touch.
    pub(super) near: u32,
    /// The plane.
    pub(super) part: u32,
    /// Whether the particle is on the side opposite to the plane's normal.
    pub(super) is_behind: bool,
}

/// What the particles of a call do with a wall's planes. The memory is kept from call to call.
#[derive(Debug, Default)]
pub(super) struct PlaneContacts {
    /// The wall's planes, where they are.
    pub(super) planes: Vec<WholePlane>,
    pub(super) contacts: Vec<PlaneContact>,
    /// What each goes on from: normal and memory of the last step, energy, and 1, or 0 for a new contact.
    pub(super) last: Vec<Line>,
    /// Of each plane, the lanes that touch it, and those of them behind it.
    lanes: Vec<[u32; 2]>,
    /// Places of the particles that the lanes do not take.
    pub(super) others: Vec<u32>,
    /// The same particles.
    pub(super) particles: Vec<Particle>,
    /// Their indices.
    pub(super) indices: Vec<usize>,
    /// Particles whose histories have been written.
    pub(super) written: Vec<usize>,
}

impl PlaneContacts {
    /// Finds which particles touch which plane.
    pub(super) fn find(
        &mut self,
        planes: impl Iterator<Item = WholePlane>,
        near: ParticleRecords<'_>,
        instruction_set: InstructionSet,
    ) {
        self.contacts.clear();
        self.others.clear();
        self.written.clear();
        self.planes.clear();
        self.planes.extend(planes);
        self.lanes.resize(self.planes.len(), [0; 2]);
        instruction_set.run(Find {
            near,
            contacts: self,
        });
    }

    /// Finds what the contacts go on from, and whether it is such as calls have written. `near` are the indices of the particles that may
    /// touch.
    ///
    /// # Errors
    /// The first number that is not.
    pub(super) fn recall(
        &mut self,
        near: &[usize],
        layout: WallHistoryLayout,
        of_laws: &HistoryLayout,
        histories: &[f64],
    ) -> Result<(), WrongHistory> {
        self.last.clear();
        let length = layout.length();
        let Some(memory) = of_laws.memory.filter(|_| length > 0) else {
            return Ok(());
        };
        let parts = self.planes.len();
        self.last.reserve(self.contacts.len());
        for contact in &self.contacts {
            let particle = near[contact.near as usize];
            let row = &histories[particle * length..(particle + 1) * length];
            let mut line = Line::ZERO;
            if row[0] != 0.0 {
                let part = contact.part as usize;
                let inwards = -self.planes[part].outwards(contact);
                // Almost always the particle touched the same plane alone, and nothing is wrong.
                let own = (part + 1) as f64;
                let record = &row[1..1 + layout.record];
                let known = row[0] == 1.0 && record[0] == own;
                let (mut normal, mut history) = layout.parts_of(record);
                if !(known && is_sound(normal, inwards, &history[memory..])) {
                    layout.check(particle, histories, parts, Some(of_laws))?;
                    match layout.record_of(row, part, inwards) {
                        Some(found) => (normal, history) = found,
                        None => {
                            self.last.push(line);
                            continue;
                        }
                    }
                    if !normal.is_unit() {
                        normal = inwards;
                    }
                }
                let energy = of_laws.energy.map_or(0.0, |at| history[at]);
                let m = &history[memory..memory + 3];
                line = Line([normal.x, normal.y, normal.z, m[0], m[1], m[2], energy, 1.0]);
            }
            self.last.push(line);
        }
        for other in &self.others {
            let particle = near[*other as usize];
            layout.check(particle, histories, parts, Some(of_laws))?;
        }
        Ok(())
    }
}

/// Whether a normal of the last step and the history after it are what a call has written; where not, they may be that all the same.
fn is_sound(last: Vector3, normal: Vector3, history: &[f64]) -> bool {
    let mut sound = last.is_unit() && last.dot(normal) >= 0.5;
    for number in history {
        sound &= number.abs() <= LARGEST_DISPLACEMENT;
    }
    sound
}

impl WholePlane {
    /// Its normal on the side of a contact.
    pub(super) fn outwards(&self, contact: &PlaneContact) -> Vector3 {
        if contact.is_behind {
            -self.normal
        } else {
            self.normal
        }
    }
}

/// A vector that is the same in every lane.
#[inline(always)]
pub(super) fn splat<S: Registers>(registers: S, v: Vector3) -> Vector3<Lanes<S>> {
    Vector3::new(
        Lanes::splat(registers, v.x),
        Lanes::splat(registers, v.y),
        Lanes::splat(registers, v.z),
    )
}

/// See [`PlaneContacts::find`].
struct Find<'p, 'a> {
    near: ParticleRecords<'a>,
    contacts: &'p mut PlaneContacts,
}

impl Stage for Find<'_, '_> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        match self.near.shapes {
            Shapes::Ellipsoids => self.find::<S, Ellipsoids>(registers),
            _ => self.find::<S, Spheroids>(registers),
        }
    }
}

impl Find<'_, '_> {
    #[inline(always)]
    fn find<S: Registers, K: Kind>(self, registers: S) {
        let records = self.near.records;
        let found = self.contacts;
        let zero = Lanes::splat(registers, 0.0);
        for first in (0..records.len()).step_by(S::LANES) {
            let present = S::LANES.min(records.len() - first);
            let mut of_lanes = [&records[first]; MOST_LANES];
            for lane in 0..present {
                of_lanes[lane] = &records[first + lane];
            }
            let side = K::load(registers, &of_lanes);
            let (mut once, mut twice) = (0u32, 0u32);
            for (plane, lanes) in found.planes.iter().zip(&mut found.lanes) {
                let normal = splat(registers, plane.normal);
                let height = normal.dot(side.centre - splat(registers, plane.point));
                let behind = height.less(zero);
                let (support, _) = side.body.support_in_world(normal);
                let (touching, behind) = if plane.both_sides {
                    (height.max(-height).less(support), registers.bits(behind))
                } else {
                    (height.less(support), 0)
                };
                let touching = registers.bits(touching) & ((1 << present) - 1);
                *lanes = [touching, behind];
                twice |= once & touching;
                once |= touching;
            }
            let mut left = once;
            while left != 0 {
                let lane = left.trailing_zeros();
                left &= left - 1;
                let near = first as u32 + lane;
                if twice >> lane & 1 != 0 {
                    found.others.push(near);
                    continue;
                }
                let of_lane = |[touching, _]: &[u32; 2]| touching >> lane & 1 != 0;
                if let Some(part) = found.lanes.iter().position(of_lane) {
                    found.contacts.push(PlaneContact {
                        near,
                        part: part as u32,
                        is_behind: found.lanes[part][1] >> lane & 1 != 0,
                    });
                }
            }
        }
    }
}
