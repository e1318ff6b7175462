// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is remembered of a contact, and where: no longer than the laws of a scene need.
//!
//! ```text
//! [ normal x y z ]         cached normal, from i to j        unless the scene is told to go without
//! [ memory x y z ]         xi or zeta, world frame           with friction
//! [ energy ]               elastic energy of the memory      with friction and `displacement rescaled` or `hysteretic`
//! [ rest ... ]             penetrations of rest              with `viscosity memory`, one of each relaxing part
//! [ springs 8 x y z ]      forces of springs, world frame    with friction and `displacement hysteretic`
//! [ reference, d ]         penetrations: of the grid of the springs, and of the last step; with these
//! [ torques 8 ]            torques of springs                with these and `twisting lubkin`
//! [ way x y z ]            way of rolling, world frame       with `rolling`
//! [ torque, angle ]        that the twist holds              with `twisting marshall` or `sds`
//! ```
//!
//! All zeros is "nothing remembered". The contact `(j, i)` remembers the opposite normal and memory, and the same of rolling and
//! twisting, of rest and of torques and the two penetrations of springs. Where there are such there is room for a memory too, with friction or
//! without.

use super::forces::{ContactForces, Remembered};
use super::ranges::{
    LARGEST_DISPLACEMENT, LARGEST_TANGENTIAL_ENERGY, LARGEST_TANGENTIAL_FORCE, LARGEST_TWIST,
};
use crate::force::memory::MOST_PARTS;
use crate::force::{Springs, SPRINGS};
use crate::vector::Vector3;

/// Doubles of the springs of partial slip: a force of each in the world frame, the penetration of reference, that of the last step.
pub(crate) const SPRING_NUMBERS: usize = 3 * SPRINGS + 2;

/// Springs of a contact that begins.
pub(crate) const NO_SPRINGS: Springs<Vector3> = Springs {
    forces: [Vector3::ZERO; SPRINGS],
    reference: 0.0,
    penetration: 0.0,
};

/// Time step and whether the history is advanced.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Time step, the interval over which the velocities moved the bodies to where they are.
    pub time_step: f64,
    /// False in the set-up of a run: forces from the history as it stands.
    pub advance_history: bool,
}

impl Step {
    /// Time over which the history advances.
    #[inline(always)]
    pub fn elapsed(&self) -> f64 {
        if self.advance_history {
            self.time_step
        } else {
            0.0
        }
    }
}

/// What a scene remembers of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Remembers {
    /// The normal.
    pub normal: bool,
    /// The tangential memory.
    pub tangential: bool,
    /// Its energy.
    pub energy: bool,
    /// Penetrations of rest of the relaxing parts of the normal force: how many.
    pub rests: usize,
    /// Springs of partial slip.
    pub springs: bool,
    /// The way of rolling.
    pub rolling: bool,
    /// Torque and angle of the twist.
    pub twisting: bool,
    /// Torques of the springs of partial slip.
    pub torques: bool,
}

/// Offsets, in doubles, of the parts of a contact's history.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HistoryLayout {
    /// Where the cached normal stands.
    pub normal: Option<usize>,
    /// Where the tangential memory stands.
    pub memory: Option<usize>,
    /// Where the elastic energy of the memory stands.
    pub energy: Option<usize>,
    /// Where the penetrations of rest stand.
    pub rests: Option<usize>,
    /// How many they are.
    pub rest_count: usize,
    /// Where the springs of partial slip stand.
    pub springs: Option<usize>,
    /// Where the torques of these springs stand.
    pub torques: Option<usize>,
    /// Where the way of rolling stands.
    pub rolling: Option<usize>,
    /// Where the torque and the angle of the twist stand.
    pub twisting: Option<usize>,
    /// Doubles per contact.
    pub length: usize,
    /// Whether some memory is a displacement, not a force.
    pub of_displacements: bool,
}

impl HistoryLayout {
    /// Doubles per contact of the longest layout.
    pub(crate) const LONGEST: usize = 15 + SPRING_NUMBERS + SPRINGS;

    /// The layout for a scene.
    pub fn new(remembers: Remembers) -> Self {
        let mut length = 0;
        let mut take = |wanted: bool, doubles: usize| {
            wanted.then(|| {
                let at = length;
                length += doubles;
                at
            })
        };
        let normal = take(remembers.normal, 3);
        let memory = take(remembers.tangential, 3);
        let energy = take(remembers.tangential && remembers.energy, 1);
        let rests = take(remembers.rests > 0, remembers.rests);
        let springs = take(remembers.tangential && remembers.springs, SPRING_NUMBERS);
        let torques = take(springs.is_some() && remembers.torques, SPRINGS);
        let rolling = take(remembers.rolling, 3);
        let twisting = take(remembers.twisting, 2);
        HistoryLayout {
            normal,
            memory,
            energy,
            rests,
            rest_count: remembers.rests,
            springs,
            torques,
            rolling,
            twisting,
            length,
            of_displacements: false,
        }
    }

    /// What the layout has room for.
    pub(crate) fn remembers(&self) -> Remembers {
        Remembers {
            normal: self.normal.is_some(),
            tangential: self.memory.is_some(),
            energy: self.energy.is_some(),
            rests: self.rest_count,
            springs: self.springs.is_some(),
            rolling: self.rolling.is_some(),
            twisting: self.twisting.is_some(),
            torques: self.torques.is_some(),
        }
    }

    /// Whether a place is one of the penetrations of rest.
    fn is_rest(&self, place: usize) -> bool {
        self.rests
            .is_some_and(|at| (at..at + self.rest_count).contains(&place))
    }

    /// Whether a place is one of the forces of springs.
    fn is_spring_force(&self, place: usize) -> bool {
        self.springs
            .is_some_and(|at| (at..at + 3 * SPRINGS).contains(&place))
    }

    /// Whether a place is one of the torques of springs.
    fn is_spring_torque(&self, place: usize) -> bool {
        self.torques
            .is_some_and(|at| (at..at + SPRINGS).contains(&place))
    }

    /// Whether a place is one of the two penetrations of springs.
    fn is_spring_penetration(&self, place: usize) -> bool {
        self.springs
            .is_some_and(|at| (at + 3 * SPRINGS..at + SPRING_NUMBERS).contains(&place))
    }

    /// The springs of a history; `None` where the layout has no room for them.
    #[inline(always)]
    pub(crate) fn springs_of(&self, history: &[f64]) -> Option<Springs<Vector3>> {
        let numbers = &history[self.springs?..][..SPRING_NUMBERS];
        let mut springs = NO_SPRINGS;
        for (force, n) in springs.forces.iter_mut().zip(numbers.chunks_exact(3)) {
            *force = Vector3::new(n[0], n[1], n[2]);
        }
        springs.reference = numbers[3 * SPRINGS];
        springs.penetration = numbers[3 * SPRINGS + 1];
        Some(springs)
    }

    /// Writes them.
    #[inline(always)]
    pub(crate) fn write_springs(&self, history: &mut [f64], springs: Option<&Springs<Vector3>>) {
        let (Some(at), Some(springs)) = (self.springs, springs) else {
            return;
        };
        let numbers = &mut history[at..at + SPRING_NUMBERS];
        for (n, force) in numbers.chunks_exact_mut(3).zip(&springs.forces) {
            n.copy_from_slice(&force.to_array());
        }
        numbers[3 * SPRINGS] = springs.reference;
        numbers[3 * SPRINGS + 1] = springs.penetration;
    }

    /// The torques of the springs of a history; `None` where the layout has no room for them.
    pub(crate) fn torques_of(&self, history: &[f64]) -> Option<[f64; SPRINGS]> {
        let mut torques = [0.0; SPRINGS];
        torques.copy_from_slice(&history[self.torques?..][..SPRINGS]);
        Some(torques)
    }

    /// Writes them.
    pub(crate) fn write_torques(&self, history: &mut [f64], torques: Option<&[f64; SPRINGS]>) {
        if let (Some(at), Some(torques)) = (self.torques, torques) {
            history[at..at + SPRINGS].copy_from_slice(torques);
        }
    }

    /// The tangential memory of a history and its energy; zeros where the layout has no room for them.
    #[inline(always)]
    pub(crate) fn tangential(&self, history: &[f64]) -> (Vector3, f64) {
        let vector = |at: usize| Vector3::new(history[at], history[at + 1], history[at + 2]);
        (
            self.memory.map_or(Vector3::ZERO, vector),
            self.energy.map_or(0.0, |at| history[at]),
        )
    }

    /// Where what is remembered of rolling and twisting begins.
    pub(crate) fn resistance(&self) -> usize {
        let first = self.torques.or(self.rolling).or(self.twisting);
        first.unwrap_or(self.length)
    }

    /// The first invalid number of the history of a touching contact: its place and its value. A normal that is not a unit
    /// vector is not used, and not looked at.
    pub fn first_wrong(&self, history: &[f64]) -> Option<(usize, f64)> {
        let at = self.memory?;
        let wrong = |k: &usize| {
            let largest = if self.twisting.is_some_and(|at| *k >= at) || self.is_spring_torque(*k) {
                LARGEST_TWIST
            } else if *k >= self.resistance() {
                LARGEST_DISPLACEMENT
            } else if self.is_spring_force(*k) {
                LARGEST_TANGENTIAL_FORCE
            } else if self.is_rest(*k) || self.is_spring_penetration(*k) {
                return !(0.0..=LARGEST_DISPLACEMENT).contains(&history[*k]);
            } else if Some(*k) == self.energy {
                LARGEST_TANGENTIAL_ENERGY
            } else if self.of_displacements {
                LARGEST_DISPLACEMENT
            } else {
                LARGEST_TANGENTIAL_FORCE
            };
            !(history[*k].abs() <= largest)
        };
        (at..self.length).find(wrong).map(|k| (k, history[k]))
    }

    /// Writes the history of `(j, i)` from that of `(i, j)`.
    ///
    /// # Panics
    /// If either slice is shorter than the layout.
    pub fn swap(&self, source: &[f64], target: &mut [f64]) {
        for (k, (t, s)) in target[..self.length]
            .iter_mut()
            .zip(&source[..self.length])
            .enumerate()
        {
            let the_same = Some(k) == self.energy
                || self.is_rest(k)
                || self.is_spring_penetration(k)
                || k >= self.resistance();
            *t = if the_same { *s } else { -s };
        }
    }
}

/// Reads what is remembered of a pair.
#[doc(hidden)]
#[inline(always)]
pub fn recall(
    layout: &HistoryLayout,
    history: &[f64],
    touching: bool,
    step: &Step,
    normal_now: Vector3,
    normal_before: Vector3,
) -> Remembered {
    let (memory, energy) = layout.tangential(history);
    let rests = layout.rests.map(|at| {
        let mut rests = [0.0; MOST_PARTS];
        if touching {
            rests[..layout.rest_count].copy_from_slice(&history[at..at + layout.rest_count]);
        }
        rests
    });
    Remembered {
        rests,
        ..Remembered::of(
            touching,
            normal_now,
            (normal_before, memory, energy),
            step.elapsed(),
        )
    }
}

/// Writes what is remembered of a touching pair.
#[doc(hidden)]
#[inline(always)]
pub fn remember(
    layout: &HistoryLayout,
    history: &mut [f64],
    normal: Vector3,
    forces: &ContactForces,
) {
    write(
        layout,
        history,
        (normal, forces.memory, forces.tangential_energy),
    );
    if let Some(at) = layout.rests {
        history[at..at + layout.rest_count].copy_from_slice(&forces.rests[..layout.rest_count]);
    }
}

/// Writes normal, memory and energy to their places in a history, that of one contact or those of all lanes.
#[inline(always)]
pub(crate) fn write<T: Copy>(
    layout: &HistoryLayout,
    history: &mut [T],
    (normal, memory, energy): (Vector3<T>, Vector3<T>, T),
) {
    if let Some(at) = layout.normal {
        history[at..at + 3].copy_from_slice(&[normal.x, normal.y, normal.z]);
    }
    if let Some(at) = layout.memory {
        history[at..at + 3].copy_from_slice(&[memory.x, memory.y, memory.z]);
    }
    if let Some(at) = layout.energy {
        history[at] = energy;
    }
}

/// Forgets the tangential part; the cached normal stays, the start of the next search.
#[doc(hidden)]
#[inline(always)]
pub fn forget(layout: &HistoryLayout, history: &mut [f64]) {
    let from = layout.memory.unwrap_or(layout.length);
    history[from..].fill(0.0);
}

/// The cached normal, if there is one.
#[doc(hidden)]
#[inline(always)]
pub fn cached_normal(layout: &HistoryLayout, history: &[f64]) -> Option<Vector3> {
    let at = layout.normal?;
    let n = Vector3::new(history[at], history[at + 1], history[at + 2]);
    // Zero: nothing cached yet. Anything else that is no unit vector came from elsewhere and is not used.
    n.is_unit().then_some(n)
}
