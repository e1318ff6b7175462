// SPDX-License-Identifier: MIT OR Apache-2.0
//! One pair of a list with every safeguard, and a list pair by pair.

use super::contact_records::{ContactRecord, ContactRecords};
use super::rows::{Accumulators, NeighbourRows};
use crate::contact::couple::Couple;
use crate::contact::history::{cached_normal, forget};
use crate::contact::one_contact::geometry_of;
use crate::contact::pair::{law_of_pair, Pair};
use crate::contact::particle::Particle;
use crate::contact::{ContactForces, HistoryLayout, Laws, Step};
use crate::tallies::{Contribution, CoupleContribution, Tallies};
use crate::vector::Vector3;

#[inline(always)]
fn add(target: &mut [f64; 3], v: Vector3) {
    target[0] += v.x;
    target[1] += v.y;
    target[2] += v.z;
}

/// One pass over the list.
pub(super) struct Pass<'a, 'b, 'c> {
    pub laws: &'a Laws,
    pub layout: HistoryLayout,
    /// Behind a pointer, so that the kernels are compiled once, here, and not again by each crate with rows of its own.
    pub rows: &'a mut (dyn NeighbourRows + 'a),
    pub step: &'a Step,
    pub accumulators: &'a mut Accumulators<'b>,
    pub tallies: Option<&'a mut Tallies<'c>>,
    /// Every touching pair, where asked for.
    pub recorded: Option<&'a mut ContactRecords>,
    pub deep_contacts: u64,
}

/// Where a pair stands: its particles, the first with the row, and its place in the row.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub entry: usize,
    pub i: usize,
    pub j: usize,
}

impl Pass<'_, '_, '_> {
    pub(super) fn all_scalar<const FRICTION: bool, const RATE: bool>(
        mut self,
        particles: &[Particle],
    ) -> u64 {
        for row in 0..self.rows.count() {
            let (central, count) = self.start_row(row);
            for entry in 0..count {
                let named = self.rows.row(row).neighbours[entry];
                if let Some(other) = self.rows.entries().index(named) {
                    let place = Place {
                        entry,
                        i: central,
                        j: other,
                    };
                    let (i, j) = (&particles[central], &particles[other]);
                    self.one_pair::<FRICTION, RATE>(place, i, j);
                }
            }
        }
        self.deep_contacts
    }

    #[inline(always)]
    fn start_row(&mut self, row: usize) -> (usize, usize) {
        let r = self.rows.row(row);
        let (central, count) = (r.central, r.neighbours.len());
        if let Some(t) = self.tallies.as_deref_mut() {
            t.pairs += count as u64;
        }
        (central, count)
    }

    /// What is remembered of a pair: whether it touched, and the doubles.
    #[inline(always)]
    pub(super) fn memory(&mut self, place: Place) -> (Option<&mut i32>, &mut [f64]) {
        self.rows.pair(place.i, place.entry)
    }

    /// A pair that does not touch: forgets the tangential part, keeps the separating normal.
    #[inline(always)]
    pub(super) fn separated(&mut self, place: Place, normal: Option<Vector3>) {
        let layout = self.layout;
        let (touching, history) = self.memory(place);
        if let (Some(n), Some(at)) = (normal, layout.normal) {
            history[at..at + 3].copy_from_slice(&n.to_array());
        }
        if let Some(t) = touching {
            if *t != 0 {
                *t = 0;
                forget(&layout, history);
            }
        }
    }

    /// Search, law and scatter of one pair, with every safeguard.
    pub(super) fn one_pair<const FRICTION: bool, const RATE: bool>(
        &mut self,
        place: Place,
        i: &Particle,
        j: &Particle,
    ) {
        let layout = self.layout;
        let step = *self.step;
        let (touching, history) = self.memory(place);
        let touched = touching.is_some_and(|t| *t != 0);
        let cached = cached_normal(&layout, history);
        let found = match Pair::of(i, j, cached) {
            Pair::Touching(found) => found,
            Pair::Apart { normal, searched } => {
                return self.separated(place, normal.filter(|_| searched));
            }
        };
        let law = self
            .laws
            .get(i.particle_type as usize, j.particle_type as usize);
        let d = j.position - i.position;
        let (_, history) = self.memory(place);
        let (f, couple) = law_of_pair::<FRICTION, RATE>(
            law,
            &found,
            [i, j],
            &layout,
            history,
            touched,
            cached,
            &step,
        );
        self.deep_contacts += found.deep as u64;
        let mut whole = f;
        if law.resistance.any() {
            couple.add_to(&mut whole);
        }
        if let Some(recorded) = self.recorded.as_deref_mut() {
            recorded.push(ContactRecord {
                i: place.i,
                j: place.j,
                entry: place.entry,
                elliptical: law.kinds.normal.elliptical,
                geometry: geometry_of(&found, i, j, law.constants.share_i),
                forces: whole,
            });
        }
        self.apply(place, d, &f);
        if law.resistance.any() {
            self.apply_couple(place, &couple);
        }
    }

    /// Scatter of a couple: torques, tallies.
    fn apply_couple(&mut self, place: Place, couple: &Couple) {
        let a = &mut *self.accumulators;
        add(&mut a.torques[place.i], couple.torque());
        if place.j < a.reaction_below {
            add(&mut a.torques[place.j], -couple.torque());
        }
        self.tally_couple(place.i, place.j, couple);
    }

    /// What a couple adds to the sums of the call.
    pub(super) fn tally_couple(&mut self, i: usize, j: usize, couple: &Couple) {
        let time = self.step.elapsed();
        let reaction = j < self.accumulators.reaction_below;
        if let Some(t) = self.tallies.as_deref_mut() {
            let contribution = CoupleContribution {
                energy: couple.energy,
                works: [time * couple.viscous_power, time * couple.elastic_power],
                viscous_torque: couple.viscous,
                tangential_torque: couple.elastic,
                wall_angular_velocity: Vector3::ZERO,
            };
            t.add_couple(i, Some(j), reaction, &contribution, None);
        }
    }

    /// Scatter of a touching pair: forces, tallies.
    #[inline(always)]
    fn apply(&mut self, place: Place, d: Vector3, f: &ContactForces) {
        let time = self.step.elapsed();
        if let (Some(t), _) = self.memory(place) {
            *t = 1;
        }
        let a = &mut *self.accumulators;
        add(&mut a.forces[place.i], -f.force);
        add(&mut a.torques[place.i], f.torque_i);
        let reaction = place.j < a.reaction_below;
        if reaction {
            add(&mut a.forces[place.j], f.force);
            add(&mut a.torques[place.j], f.torque_j);
        }
        if let Some(t) = self.tallies.as_deref_mut() {
            t.add(
                place.i,
                Some(place.j),
                reaction,
                &Contribution {
                    normal_energy: f.elastic_energy,
                    tangential_energy: f.tangential_energy,
                    works: [time * f.viscous_power, time * f.tangential_power],
                    relaxed: f.relaxed_energy,
                    d,
                    force: f.force,
                    viscous_force: f.viscous_force,
                    tangential_force: f.frictional_force,
                    contact_point: f.contact_point,
                    wall_velocity: Vector3::ZERO,
                },
                None,
            );
        }
    }
}
