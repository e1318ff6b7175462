// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a grain remembers of a wall, in the form of the host's walls, from that of a scene and back. The two differ: the laws of a scene remember
//! what any of its pairs needs, a scene has fewer records of a wall with many parts, and a plane of a scene has none.

use ellgran::contact::{HistoryLayout, Laws};
use ellgran::vector::Vector3;
use ellgran::walls::{Wall, WallHistoryLayout};

/// A record before the history of the contact: part, counted from 1, point and normal.
const HEAD: usize = 7;
const NORMAL: usize = 4;

/// How histories are laid out: those of a grain with the wall, and that of a contact.
#[derive(Clone, Copy, Debug)]
struct Form {
    wall: WallHistoryLayout,
    contact: HistoryLayout,
}

impl Form {
    /// The records that are in use.
    fn records<'h>(&self, histories: &'h [f64]) -> impl Iterator<Item = (&'h [f64], &'h [f64])> {
        let used = self.wall.used(histories);
        let records = histories[used.min(1)..used].chunks_exact(self.wall.record);
        records.map(|record| record.split_at(HEAD))
    }

    /// The place in the histories of a grain of the first number that no call has written, and that number.
    fn first_wrong(&self, histories: &[f64], parts: usize) -> Option<(usize, f64)> {
        let is_whole = |x: f64, most: usize| x.fract() == 0.0 && (0.0..=most as f64).contains(&x);
        let count = histories[0];
        if !is_whole(count, self.wall.records) {
            return Some((0, count));
        }
        let mut at = 1;
        for (head, history) in self.records(histories) {
            if !(is_whole(head[0], parts) && head[0] > 0.0) {
                return Some((at, head[0]));
            }
            if let Some(k) = head.iter().position(|x| !x.is_finite()) {
                return Some((at + k, head[k]));
            }
            if let Some((k, value)) = self.contact.first_wrong(history) {
                return Some((at + HEAD + k, value));
            }
            at += self.wall.record;
        }
        None
    }
}

/// A plane of a scene, among the parts of a wall of the host.
#[derive(Clone, Copy, Debug)]
struct PlaneOfScene {
    part: usize,
    /// From a grain to the plane.
    normal: Vector3,
}

/// How the host and a scene keep what is remembered of a wall.
#[derive(Clone, Copy, Debug)]
pub struct WallHistories {
    host: Form,
    scene: Form,
    parts: usize,
    plane: Option<PlaneOfScene>,
}

impl WallHistories {
    /// Of `wall` under `laws` on the host, and of a wall of a scene whose histories are so, or of a plane that is the part `part` of it.
    ///
    /// # Errors
    /// What is wrong with `part`.
    pub fn new(
        (wall, laws): (&Wall, &Laws),
        (of_scene, layout): (&Laws, Option<WallHistoryLayout>),
        part: usize,
    ) -> Result<Self, String> {
        let contact = of_scene.layout();
        let plane = match layout {
            Some(_) => None,
            None => match wall.whole_plane(part) {
                Some(plane) => Some(PlaneOfScene {
                    part,
                    normal: -plane.normal,
                }),
                None => return Err(format!("part {part} of the wall is not a whole plane")),
            },
        };
        Ok(WallHistories {
            host: Form {
                wall: wall.histories(laws),
                contact: laws.layout(),
            },
            scene: Form {
                wall: layout.unwrap_or_default(),
                contact,
            },
            parts: wall.part_count(),
            plane,
        })
    }

    /// Doubles of a grain on the host.
    pub fn length(&self) -> usize {
        self.host.wall.length()
    }

    /// The first number of a grain's histories of the host that no call has written, and its place.
    pub fn first_wrong(&self, host: &[f64]) -> Option<(usize, f64)> {
        self.host.first_wrong(host, self.parts)
    }

    /// Adds what a grain remembers of the scene's wall to what it remembers on the host, as far as there is room: the host has as many records as
    /// the parts of the wall can have contacts.
    pub fn add_to_host(&self, state: u32, scene: &[f64], host: &mut [f64]) {
        if state == 0 {
            return;
        }
        let add = |host: &mut [f64], head: &[f64; HEAD], history: &[f64]| {
            let at = self.host.wall.used(host).max(1);
            let Some(record) = host.get_mut(at..at + self.host.wall.record) else {
                return;
            };
            write_record(
                (head, history),
                &self.scene.contact,
                record,
                &self.host.contact,
            );
            host[0] += 1.0;
        };
        if let Some(PlaneOfScene { part, normal }) = self.plane {
            // Any point will do: a grain touches a plane in one.
            let head = [
                (part + 1) as f64,
                0.0,
                0.0,
                0.0,
                normal.x,
                normal.y,
                normal.z,
            ];
            return add(host, &head, scene);
        }
        for (head, history) in self.scene.records(scene) {
            if let Ok(head) = head.try_into() {
                add(host, head, history);
            }
        }
    }

    /// What a grain remembers of the scene's wall, from zeros, of what it remembers on the host; whether it touches.
    pub fn to_scene(&self, host: &[f64], scene: &mut [f64]) -> u32 {
        let records = self.host.records(host);
        if let Some(PlaneOfScene { part, .. }) = self.plane {
            let own = (part + 1) as f64;
            let Some((head, history)) = { records }.find(|(head, _)| head[0] == own) else {
                return 0;
            };
            copy(
                (&self.host.contact, history),
                (&self.scene.contact, scene),
                &head[NORMAL..],
            );
            return 1;
        }
        let room = self.scene.wall.records;
        let mut count = 0;
        for (head, history) in records.take(room) {
            let at = 1 + count * self.scene.wall.record;
            let record = &mut scene[at..at + self.scene.wall.record];
            write_record(
                (head, history),
                &self.host.contact,
                record,
                &self.scene.contact,
            );
            count += 1;
        }
        if let Some(first) = scene.first_mut() {
            *first = count as f64;
        }
        u32::from(count > 0)
    }
}

/// A record with the history of its contact in another layout.
fn write_record(
    (head, history): (&[f64], &[f64]),
    from: &HistoryLayout,
    record: &mut [f64],
    to: &HistoryLayout,
) {
    let (to_head, to_history) = record.split_at_mut(HEAD);
    to_head.copy_from_slice(head);
    copy((from, history), (to, to_history), &head[NORMAL..]);
}

/// The history of a contact, in another layout: of laws that have kernels, with this normal.
fn copy(
    (from, history): (&HistoryLayout, &[f64]),
    (to, target): (&HistoryLayout, &mut [f64]),
    normal: &[f64],
) {
    if let Some(at) = to.normal {
        target[at..at + 3].copy_from_slice(normal);
    }
    for (from, to, length) in [(from.memory, to.memory, 3), (from.energy, to.energy, 1)] {
        if let (Some(from), Some(to)) = (from, to) {
            target[to..to + length].copy_from_slice(&history[from..from + length]);
        }
    }
}
