// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which contacts have all particles with a wall, and from which of the last step does each go on?

use super::histories::WallHistoryLayout;
use super::motion::Motion;
use super::shape::{Grain, Search, Shape};
use crate::contact::staged::{StagedContact, WallSurface};
use crate::contact::{Particle, Step};
use crate::vector::Vector3;
use core::ops::Range;

/// One contact of a particle.
#[derive(Clone, Copy, Debug)]
pub struct FoundContact {
    /// Index of the particle.
    pub particle: usize,
    /// Its place among the particles that may touch.
    pub near: usize,
    /// Index of the wall's part.
    pub part: usize,
    /// The triangle of that part that stands for the contact; 0 where it has none.
    pub triangle: usize,
    /// The surface, in the frame of the wall.
    pub surface: WallSurface,
    /// Centre of the particle, in the frame of the wall.
    centre: Vector3,
    /// Its normal at the last step, from the particle into the wall, in the frame in which its force is computed; `None` for a new
    /// contact.
    pub last_normal: Option<Vector3>,
    /// Whether there is room to remember it.
    pub is_remembered: bool,
}

/// A surface that a particle touches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Searched {
    /// The particle's place among those that may touch.
    pub(super) near: usize,
    /// The part of the wall, and its triangle.
    pub(super) part: usize,
    pub(super) triangle: usize,
    /// The surface, in the frame of the wall.
    pub(super) surface: WallSurface,
}

/// Calls `found` with each surface of some shapes that a body touches; its place is not known here. A shape that is alone has already
/// been asked whether the body may touch it.
pub(super) fn touch_shapes<'a>(
    is_alone: bool,
    shapes: impl Iterator<Item = &'a dyn Shape>,
    grain: &Grain<'_>,
    search: &mut Search,
    found: &mut dyn FnMut(Searched),
) {
    for (part, shape) in shapes.enumerate() {
        if is_alone || shape.may_touch(&grain.ball()) {
            shape.touch(grain, search, &mut |surface, triangle| {
                found(Searched {
                    near: 0,
                    part,
                    triangle,
                    surface: *surface,
                });
            });
        }
    }
}

/// One contact, ready for its forces, in the frame of the world.
#[derive(Clone, Copy, Debug)]
pub struct StagedInWorld {
    /// The surface, with the motion of the wall.
    pub surface: WallSurface,
    /// Centre of the particle.
    pub position: Vector3,
    /// The contact.
    pub contact: StagedContact,
}

/// The contacts of a call, in the order of the particles. The memory of the search is kept from call to call.
#[derive(Debug, Default)]
pub struct Contacts {
    all: Vec<FoundContact>,
    /// The same, ready for their forces, where these are computed in the frame of the world.
    staged: Vec<StagedInWorld>,
    /// The history of each, and those of earlier calls behind them.
    histories: Vec<f64>,
    layout: WallHistoryLayout,
    search: Search,
    /// Of one particle: which of its records a contact that acts alone has gone on from.
    taken: Vec<bool>,
    /// A particle with a contact that acts alone and is not remembered.
    crowded: Option<usize>,
}

/// In which frame forces are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// That of the wall, in which it is at rest.
    Wall,
    /// That of the world, in which an engine's own contact model computes, from contacts that are staged.
    World,
}

/// What the search for contacts is given.
#[derive(Clone, Copy, Debug)]
pub struct Places<'a> {
    /// The particles that may touch (`Wall::near`), in that order.
    pub near: &'a [Particle],
    /// Where the wall is and how it moves.
    pub motion: &'a Motion,
    /// The step.
    pub step: &'a Step,
    /// In which frame forces are computed.
    pub frame: Frame,
}

/// Where the contacts of a particle come from.
pub(super) enum Source<'s, I> {
    /// A search.
    Shapes {
        /// Whether there is one shape alone.
        is_alone: bool,
        shapes: I,
    },
    /// They were found before.
    Searched(&'s [Searched]),
}

impl Contacts {
    /// Begins anew.
    pub(super) fn start(&mut self, layout: WallHistoryLayout) {
        self.all.clear();
        self.staged.clear();
        self.layout = layout;
        self.crowded = None;
        self.taken.resize(layout.records, false);
    }

    /// Adds the contacts of a particle with some shapes, or those that were found of it.
    pub(super) fn add<'a>(
        &mut self,
        from: Source<'_, impl Iterator<Item = &'a dyn Shape>>,
        places: &Places<'_>,
        i: &Particle,
        (particle, near): (usize, usize),
        histories: &[f64],
    ) {
        let moved;
        let seen = if places.motion.is_none() {
            i
        } else {
            moved = places.motion.seen_from_wall(i, places.step);
            &moved
        };
        let first = self.all.len();
        let all = &mut self.all;
        let mut add = |found: Searched| {
            all.push(FoundContact {
                particle,
                near,
                part: found.part,
                triangle: found.triangle,
                surface: if places.frame == Frame::Wall {
                    places.motion.in_its_frame(&found.surface)
                } else {
                    found.surface
                },
                centre: seen.position,
                last_normal: None,
                is_remembered: false,
            });
        };
        match from {
            Source::Searched(found) => found.iter().copied().for_each(add),
            Source::Shapes { is_alone, shapes } => {
                let grain = Grain {
                    particle,
                    body: &seen.body,
                    centre: seen.position,
                };
                touch_shapes(is_alone, shapes, &grain, &mut self.search, &mut add);
            }
        }
        if self.all.len() == first {
            return;
        }
        if places.frame == Frame::World {
            self.stage(first, places.motion, i);
        }
        self.recall(first, places, histories);
    }

    /// Stages the contacts from `first` on, all of one particle, in the frame of the world, and drops those that do not touch there.
    fn stage(&mut self, first: usize, motion: &Motion, i: &Particle) {
        let mut kept = first;
        for index in first..self.all.len() {
            let surface = motion.surface_to_world(&self.all[index].surface);
            if let Some(contact) = StagedContact::of_wall(i, &surface) {
                self.staged.push(StagedInWorld {
                    surface,
                    position: i.position,
                    contact,
                });
                self.all[kept] = self.all[index];
                kept += 1;
            }
        }
        self.all.truncate(kept);
    }

    /// Finds what the contacts from `first` on, all of one particle, go on from.
    fn recall(&mut self, first: usize, places: &Places<'_>, histories: &[f64]) {
        let layout = self.layout;
        let length = layout.history;
        let needed = self.all.len() * length;
        if self.histories.len() < needed {
            self.histories.resize(needed, 0.0);
        }
        let before = &histories[..layout.used(histories)];
        let taken = &mut self.taken[..];
        taken.fill(false);
        let mut records = 0;
        // Faces that share a contact find what is remembered with each other: the contacts that act alone come first.
        for alone in [true, false] {
            for (index, c) in self.all.iter_mut().enumerate().skip(first) {
                if (c.surface.share.value == 1.0) != alone {
                    continue;
                }
                let history = &mut self.histories[index * length..(index + 1) * length];
                let last = layout.recall(before, taken, c.part, &c.surface, c.centre, history);
                c.last_normal = last.map(|n| match places.frame {
                    Frame::Wall => n,
                    Frame::World => places.motion.to_world(n),
                });
                c.is_remembered = records < layout.records;
                if alone && !c.is_remembered && length > 0 {
                    self.crowded = Some(c.particle);
                }
                records += 1;
            }
            if records == self.all.len() - first {
                break;
            }
        }
    }

    /// A particle that touches in more places than are remembered.
    pub fn crowded(&self) -> Option<usize> {
        self.crowded
    }

    /// Doubles that are remembered of a particle.
    pub fn histories_length(&self) -> usize {
        self.layout.length()
    }

    /// The contacts, in the order of the particles.
    pub fn all(&self) -> &[FoundContact] {
        &self.all
    }

    /// The same, ready for their forces; empty where these are computed in the frame of the wall.
    pub fn staged(&self) -> &[StagedInWorld] {
        &self.staged
    }

    /// Remembers nothing of a contact that its force did not find touching, by rounding.
    pub(super) fn forget(&mut self, index: usize) {
        self.all[index].is_remembered = false;
    }

    /// A contact and its history.
    pub(super) fn with_history(&mut self, index: usize) -> (&FoundContact, &mut [f64]) {
        let length = self.layout.history;
        (
            &self.all[index],
            &mut self.histories[index * length..(index + 1) * length],
        )
    }

    /// The history of a contact.
    ///
    /// # Panics
    /// If there is no such contact.
    pub fn history(&mut self, index: usize) -> &mut [f64] {
        let length = self.layout.history;
        &mut self.histories[index * length..(index + 1) * length]
    }

    /// Writes to the histories of the particles what is remembered of the contacts that were found. Of particles on which the wall acts and
    /// that do not touch nothing is remembered any more.
    ///
    /// # Panics
    /// If the histories are shorter than those of all particles.
    pub fn remember(&self, histories: &mut [f64], acts_on: &dyn Fn(usize) -> bool) {
        self.remember_others(histories, acts_on, &[], &mut WithHistories::default());
    }

    /// The same; those of the particles `written`, in ascending order, stay as they are. `with_histories` are the particles with something
    /// that is remembered, before and after.
    pub(super) fn remember_others(
        &self,
        histories: &mut [f64],
        acts_on: &dyn Fn(usize) -> bool,
        mut written: &[usize],
        with_histories: &mut WithHistories,
    ) {
        let length = self.layout.length();
        if length == 0 {
            return;
        }
        let WithHistories {
            all: with,
            before,
            are_known,
            layout,
        } = with_histories;
        *layout = self.layout;
        if *are_known && self.all.is_empty() && with == written {
            return;
        }
        core::mem::swap(with, before);
        with.clear();
        with.extend_from_slice(written);
        let row = |particle: usize| particle * length..(particle + 1) * length;
        let mut next = 0;
        while let Some(particle) = self.all.get(next).map(|c| c.particle) {
            let of_particle = self.all[next..].iter();
            let count = of_particle.take_while(|c| c.particle == particle).count();
            self.remember_one(&mut histories[row(particle)], next..next + count);
            with.push(particle);
            next += count;
        }
        let mut found = &self.all[..];
        let mut forget = |particle: usize, histories: &mut [f64]| {
            while written.first().is_some_and(|k| *k < particle) {
                written = &written[1..];
            }
            while found.first().is_some_and(|c| c.particle < particle) {
                found = &found[1..];
            }
            let is_new = written.first() == Some(&particle)
                || found.first().is_some_and(|c| c.particle == particle);
            if is_new || histories[0] == 0.0 {
                return;
            }
            if acts_on(particle) {
                let used = self.layout.used(histories);
                histories[..used.max(1)].fill(0.0);
            } else {
                with.push(particle);
            }
        };
        if *are_known {
            for &particle in &*before {
                forget(particle, &mut histories[row(particle)]);
            }
        } else {
            for (particle, histories) in histories.chunks_exact_mut(length).enumerate() {
                forget(particle, histories);
            }
        }
        // Runs that are in order already.
        with.sort();
        *are_known = true;
    }

    /// Writes what is remembered of these contacts, all of one particle.
    fn remember_one(&self, histories: &mut [f64], contacts: Range<usize>) {
        let layout = &self.layout;
        let used_before = layout.used(histories);
        let mut used = 1;
        for index in contacts {
            let c = &self.all[index];
            if c.is_remembered {
                let history = &self.histories[index * layout.history..][..layout.history];
                let record = &mut histories[used..used + layout.record];
                layout.remember(record, c.part, &c.surface, c.centre, history);
                used += layout.record;
            }
        }
        histories[0] = ((used - 1) / layout.record) as f64;
        if used < used_before {
            histories[used..used_before].fill(0.0);
        }
    }
}

/// The particles of which something is remembered.
#[derive(Debug, Default)]
pub(super) struct WithHistories {
    all: Vec<usize>,
    before: Vec<usize>,
    /// Whether these are they; where not, all particles are looked at.
    are_known: bool,
    /// In which they were written.
    layout: WallHistoryLayout,
}

impl WithHistories {
    /// Whether the histories of all particles on which the wall acts are those that its last call has written, in this layout.
    pub(super) fn are_written_in(&self, layout: WallHistoryLayout) -> bool {
        self.are_known && self.layout == layout
    }

    /// Somebody else may have written histories, or moved them.
    pub(super) fn forget(&mut self) {
        self.are_known = false;
    }
}
