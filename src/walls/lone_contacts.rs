// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which particles touch a wall in one place and no other? Planes, places where a mesh is
//! one, and cylinders and cones from within, are searched in lanes, other shapes particle by particle.

use super::contacts::{touch_shapes, Searched};
use super::motion::Motion;
use super::part_in_lanes::SearchInput;
use super::shape::{Grain, Search, Shape, ShapeInLanes, WholePlane};
use crate::contact::particle::Particle;
use crate::contact::staged::WallSurface;
use crate::list::shapes::{Ellipsoids, Kind, Spheroids};
use crate::list::Shapes;
use crate::simd::{InstructionSet, Line, Registers, Stage, MOST_LANES};
use crate::vector::Vector3;

/// The contact of a particle that has no other.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LoneContact {
    /// The particle's place among those that may touch.
    pub(super) near: u32,
    /// The part of the wall.
    pub(super) part: u32,
    /// Whether the particle is on the side opposite to a plane's normal.
    pub(super) is_behind: bool,
    /// Whether the surface turns with the body's motion.
    pub(super) turns: bool,
}

/// A surface as the lanes load it: `[normal, height of the centre above it, direction]` in the frame of the world, then
/// `[curvatures, turning radii, normal in the frame of the wall]`, normals out of the wall.
pub(super) type SurfaceLines = [Line; 2];

/// What the particles of a call do with a wall. The memory is kept from call to call.
#[derive(Debug, Default)]
pub(super) struct LoneContacts {
    /// The planes of a wall that has no other parts and neither turns nor has turned, where they are; else empty.
    pub(super) planes: Vec<WholePlane>,
    pub(super) contacts: Vec<LoneContact>,
    /// The surface of each contact; empty where all are planes.
    pub(super) surfaces: Vec<SurfaceLines>,
    /// Velocity of the surface of each in the frame of the wall, along the axes of the world; empty where none moves there.
    pub(super) velocities: Vec<Line>,
    /// What each goes on from: normal and memory of the last step, energy, and 1, or 0 for a new contact.
    pub(super) last: Vec<Line>,
    /// Indices of those of which that had to be looked for.
    pub(super) doubtful: Vec<u32>,
    /// What the lanes find of each part.
    pub(super) parts: Vec<PartInLanes>,
    search: Search,
    pub(super) with_velocities: bool,
    /// Places of the particles that the lanes do not take.
    pub(super) others: Vec<u32>,
    /// What was found of those of them that have been searched, in the order of their places.
    pub(super) searched: Vec<Searched>,
    /// The same particles.
    pub(super) particles: Vec<Particle>,
    /// Their indices.
    pub(super) indices: Vec<usize>,
    /// Particles whose histories have been written.
    pub(super) written: Vec<usize>,
    /// The first of them, while they are put in order.
    first_written: Vec<usize>,
}

/// A part, and what the lanes find of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct PartInLanes {
    /// Where it is; `None` where particles are searched one by one.
    pub(super) shape: Option<ShapeInLanes>,
    /// Bits of the lanes that touch it.
    touching: u32,
    /// Those of them behind a plane.
    behind: u32,
    surfaces: [[Line; MOST_LANES]; 2],
}

impl LoneContacts {
    /// Begins a call: no contacts yet, and the parts where they are.
    pub(super) fn start<'s>(
        &mut self,
        shapes: impl Iterator<Item = &'s dyn Shape> + Clone,
        motion: &Motion,
    ) {
        self.contacts.clear();
        self.surfaces.clear();
        self.velocities.clear();
        self.with_velocities = shapes.clone().any(Shape::moves);
        self.others.clear();
        self.searched.clear();
        self.written.clear();
        self.planes.clear();
        self.parts.clear();
        for shape in shapes {
            let in_world = shape.in_lanes().map(|shape| shape.in_world(motion));
            if let Some(ShapeInLanes::Plane(plane)) = in_world {
                self.planes.push(plane);
            }
            self.parts.push(PartInLanes {
                shape: in_world,
                touching: 0,
                behind: 0,
                surfaces: [[Line::ZERO; MOST_LANES]; 2],
            });
        }
        let turns = motion.axes.is_some() || motion.spins();
        if self.planes.len() < self.parts.len() || turns {
            self.planes.clear();
        }
    }

    /// Finds which particles touch which part.
    pub(super) fn find<'s>(
        &mut self,
        shapes: impl Iterator<Item = &'s dyn Shape> + Clone,
        places: &SearchInput<'_>,
        instruction_set: InstructionSet,
    ) {
        if self.parts.iter().all(|part| part.shape.is_none()) {
            for near in 0..places.indices.len() {
                self.search_one(shapes.clone(), places, near);
            }
            return;
        }
        instruction_set.run(Find {
            shapes,
            places,
            contacts: self,
        });
    }

    /// Searches for the contacts of one particle with all parts.
    #[inline(never)]
    pub(super) fn search_one<'s>(
        &mut self,
        shapes: impl Iterator<Item = &'s dyn Shape>,
        places: &SearchInput<'_>,
        near: usize,
    ) {
        let particle = places.near.particle(near);
        let moved;
        let seen = if places.motion.is_none() {
            &particle
        } else {
            moved = places.motion.seen_from_wall(&particle, places.step);
            &moved
        };
        let grain = Grain {
            particle: places.indices[near],
            body: &seen.body,
            centre: seen.position,
        };
        let first = self.searched.len();
        let searched = &mut self.searched;
        let is_alone = self.parts.len() == 1;
        touch_shapes(is_alone, shapes, &grain, &mut self.search, &mut |found| {
            searched.push(Searched { near, ..found });
        });
        match self.searched[first..] {
            [] => {}
            [found] if is_taken_in_lanes(&found.surface) => {
                self.searched.truncate(first);
                if self.with_velocities {
                    let surface = &found.surface;
                    let [v, c] = [surface.velocity, surface.velocity_change]
                        .map(|v| places.motion.to_world(v));
                    self.velocities
                        .push(Line([v.x, v.y, v.z, c.x, c.y, c.z, 0.0, 0.0]));
                }
                let surface = &found.surface;
                self.surfaces
                    .push(lines_of(surface, grain.centre, places.motion));
                self.contacts.push(LoneContact {
                    near: near as u32,
                    part: found.part as u32,
                    is_behind: false,
                    turns: surface.turning_radii.iter().any(|r| r.is_finite()),
                });
            }
            _ => self.others.push(near as u32),
        }
    }

    /// Merges the first `count` particles that have been written with the others; both are in ascending order.
    pub(super) fn put_written_in_order(&mut self, count: usize) {
        let (before, all) = (&mut self.first_written, &mut self.written);
        if count == 0 || count == all.len() {
            return;
        }
        before.clear();
        before.extend_from_slice(&all[..count]);
        let mut of_others = count;
        let mut of_first = before.iter().copied().peekable();
        for place in 0..all.len() {
            let other = all.get(of_others).copied();
            match of_first.next_if(|first| other.is_none_or(|other| *first < other)) {
                Some(first) => all[place] = first,
                None if of_first.peek().is_none() => break,
                None => {
                    all[place] = all[of_others];
                    of_others += 1;
                }
            }
        }
    }

    /// The normal out of the wall at a contact, in the frame of the wall.
    #[inline(always)]
    pub(super) fn outwards(&self, index: usize) -> Vector3 {
        self.outwards_of(&self.contacts[index], self.surfaces.get(index))
    }

    /// The same of a contact with this surface; with none where all are planes.
    #[inline(always)]
    pub(super) fn outwards_of(
        &self,
        contact: &LoneContact,
        surface: Option<&SurfaceLines>,
    ) -> Vector3 {
        match surface {
            Some([_, Line(b)]) => Vector3::new(b[4], b[5], b[6]),
            None => self.planes[contact.part as usize].outwards(contact),
        }
    }
}

/// Whether lanes take a contact with a surface: a whole one, and no cavity.
fn is_taken_in_lanes(s: &WallSurface) -> bool {
    let [a, b] = s.turning_radii;
    let is_cavity = a.is_finite() && b.is_finite() && (a < 0.0 || b < 0.0);
    s.share.value == 1.0 && !is_cavity
}

/// A surface as the lanes load it, of a body with this centre in the frame of the wall.
fn lines_of(s: &WallSurface, centre: Vector3, motion: &Motion) -> SurfaceLines {
    let (n, d) = (motion.to_world(s.normal), motion.to_world(s.direction));
    let height = s.normal.dot(centre - s.point);
    let ([a, b], [c, e], w) = (s.curvatures, s.turning_radii, s.normal);
    [
        Line([n.x, n.y, n.z, height, d.x, d.y, d.z, 0.0]),
        Line([a, b, c, e, w.x, w.y, w.z, 0.0]),
    ]
}

impl WholePlane {
    /// Its normal on the side of a contact.
    pub(super) fn outwards(&self, contact: &LoneContact) -> Vector3 {
        if contact.is_behind {
            -self.normal
        } else {
            self.normal
        }
    }
}

/// See [`LoneContacts::find`].
struct Find<'p, 'a, I> {
    shapes: I,
    places: &'p SearchInput<'a>,
    contacts: &'p mut LoneContacts,
}

impl<'s, I: Iterator<Item = &'s dyn Shape> + Clone> Stage for Find<'_, '_, I> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        match self.places.near.shapes {
            Shapes::Ellipsoids => self.find::<S, Ellipsoids>(registers),
            _ => self.find::<S, Spheroids>(registers),
        }
    }
}

impl<'s, I: Iterator<Item = &'s dyn Shape> + Clone> Find<'_, '_, I> {
    #[inline(always)]
    fn find<S: Registers, K: Kind>(self, registers: S) {
        let near = &self.places.near;
        let found = self.contacts;
        let with_surfaces = found.planes.is_empty();
        for first in (0..near.count()).step_by(S::LANES) {
            let present = S::LANES.min(near.count() - first);
            let mut of_lanes = [near.record(first); MOST_LANES];
            for (lane, record) in of_lanes[..present].iter_mut().enumerate() {
                *record = near.record(first + lane);
            }
            let side = K::load(registers, &of_lanes);
            let all = (1u32 << present) - 1;
            let (mut once, mut twice, mut unsure) = (0u32, 0u32, 0u32);
            for (part, shape) in found.parts.iter_mut().zip(self.shapes.clone()) {
                match part.shape {
                    Some(ShapeInLanes::Plane(plane)) if !with_surfaces => {
                        let (touching, behind, _) = plane.touch::<S, K>(registers, &side);
                        part.touching = touching & all;
                        part.behind = behind;
                    }
                    Some(in_lanes) => {
                        let lanes = (first, present);
                        let of_part =
                            in_lanes.find::<S, K>(registers, shape, self.places, lanes, &side);
                        part.touching = of_part.touching;
                        unsure |= of_part.unsure;
                        if of_part.touching != 0 {
                            of_part.surface.put(registers, &mut part.surfaces);
                        }
                    }
                    None => {
                        for lane in 0..present {
                            let ball = self.places.ball::<K>(first + lane);
                            unsure |= u32::from(shape.may_touch(&ball)) << lane;
                        }
                    }
                }
                twice |= once & part.touching;
                once |= part.touching;
            }
            let mut left = once | unsure;
            while left != 0 {
                let lane = left.trailing_zeros();
                left &= left - 1;
                let near = first + lane as usize;
                if unsure >> lane & 1 != 0 {
                    found.search_one(self.shapes.clone(), self.places, near);
                    continue;
                }
                if twice >> lane & 1 != 0 {
                    found.others.push(near as u32);
                    continue;
                }
                let of_lane = |part: &PartInLanes| part.touching >> lane & 1 != 0;
                if let Some(index) = found.parts.iter().position(of_lane) {
                    let part = &found.parts[index];
                    found.contacts.push(LoneContact {
                        near: near as u32,
                        part: index as u32,
                        is_behind: part.behind >> lane & 1 != 0,
                        turns: part.shape.is_some_and(|shape| shape.turns()),
                    });
                    if found.with_velocities {
                        found.velocities.push(Line::ZERO);
                    }
                    if with_surfaces {
                        let [a, b] = &part.surfaces;
                        found.surfaces.push([a[lane as usize], b[lane as usize]]);
                    }
                }
            }
        }
    }
}
