// SPDX-License-Identifier: MIT OR Apache-2.0
//! The hot loop: all pairs of an engine's neighbour list, one call a step.
//!
//! A pair is rejected by its bounding spheres, else by one evaluation with the cached normal; what is left goes through
//! the contact search, the law and the scatter. Nothing is allocated.

use super::contact::{
    contact_forces, relative_curvature_matrix, Contact, ContactForces, Remembered,
};
use super::contact_record::{ContactRecord, ContactRecords};
use super::history::HistoryLayout;
use super::laws::Laws;
use super::one_contact::geometry_of;
use super::particles::{effective_mass, Particle, Workspace};
use super::tallies::{Contribution, Tallies};
use super::Step;
use crate::force::{hertz_factors, Factors, PairLaw, Tangential};
use crate::geometry::{search, ContactSearch, Ellipsoid, Outcome, Support, Tangent, Vector3};

/// The neighbours of one central particle, and what is remembered of its pairs.
pub struct NeighbourRow<'a> {
    /// Index of the central particle.
    pub central: usize,
    /// Entries of the engine's list; [`Entries::index`] makes an index of one.
    pub neighbours: &'a [i32],
    /// One flag per neighbour, written: 1 for a contact. Empty without history.
    pub touching: &'a mut [i32],
    /// [`HistoryLayout::length`] doubles per neighbour. Empty without history.
    pub history: &'a mut [f64],
}

/// An engine's neighbour list.
pub trait NeighbourRows {
    /// Number of central particles.
    fn count(&self) -> usize;
    /// The row of the `k`-th central particle.
    fn row(&mut self, k: usize) -> NeighbourRow<'_>;
    /// What is remembered of one pair: its flag (`None` without history) and its doubles, by the index of the central
    /// particle and the place in its row.
    fn pair(&mut self, central: usize, entry: usize) -> (Option<&mut i32>, &mut [f64]);
    /// How to read an entry.
    fn entries(&self) -> Entries;
}

/// How an engine writes a neighbour: the particle's index, and bits above it that may exclude the pair.
#[derive(Clone, Copy, Debug)]
pub struct Entries {
    /// Bits that are the index.
    pub mask: i32,
    /// The two bits above this one choose one of `excluded`.
    pub shift: u32,
    /// Whether the engine excludes such a pair.
    pub excluded: [bool; 4],
}

impl Entries {
    /// Entries that are indices and nothing else.
    pub const PLAIN: Entries = Entries {
        mask: -1,
        shift: 0,
        excluded: [false; 4],
    };

    /// Index of the particle that an entry names, or `None` for a pair that the engine excludes.
    #[inline(always)]
    pub fn index(&self, entry: i32) -> Option<usize> {
        let special = (entry as u32 >> self.shift) & 3;
        if self.excluded[special as usize] {
            return None;
        }
        Some((entry & self.mask) as usize)
    }
}

/// Where forces go.
pub struct Accumulators<'a> {
    /// Forces, added to.
    pub forces: &'a mut [[f64; 3]],
    /// Torques, added to.
    pub torques: &'a mut [[f64; 3]],
    /// Particles below this index get the reaction; with Newton's third law on, all of them.
    pub reaction_below: usize,
    /// Particles below this index are owned by the caller.
    pub owned: usize,
}

/// Hale's form broke at a contact: the pair and the curvature ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HaleBroke {
    /// First particle's index.
    pub i: usize,
    /// Second particle's index.
    pub j: usize,
    /// `B/A`.
    pub ratio: f64,
}

/// Why a list was not computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ListError {
    /// Hale's form broke at a contact.
    Hale(HaleBroke),
    /// An entry that names no particle, or the one whose row it stands in.
    Entry {
        /// The particle of the row.
        central: usize,
        /// Place in the row.
        place: usize,
        /// What stands there.
        entry: i32,
    },
    /// A history of a touching pair that holds a number which no call has written.
    History {
        /// First particle's index.
        i: usize,
        /// Second particle's index.
        j: usize,
        /// Place in the pair's history.
        place: usize,
        /// What stands there.
        value: f64,
    },
}

#[inline(always)]
fn add(target: &mut [f64; 3], v: Vector3) {
    target[0] += v.x;
    target[1] += v.y;
    target[2] += v.z;
}
/// Reads what is remembered of a pair.
#[inline(always)]
pub(super) fn recall(
    layout: &HistoryLayout,
    history: &[f64],
    touching: bool,
    step: &Step,
    normal_now: Vector3,
    normal_before: Vector3,
) -> Remembered {
    let read = |at: usize| Vector3::new(history[at], history[at + 1], history[at + 2]);
    Remembered {
        continued: touching,
        normal: if touching { normal_before } else { normal_now },
        memory: match layout.memory {
            Some(at) if touching => read(at),
            _ => Vector3::ZERO,
        },
        energy: match layout.energy {
            Some(at) if touching => history[at],
            _ => 0.0,
        },
        time: if step.advance_history {
            step.time_step
        } else {
            0.0
        },
    }
}

/// Writes what is remembered of a touching pair.
#[inline(always)]
pub(super) fn remember(
    layout: &HistoryLayout,
    history: &mut [f64],
    normal: Vector3,
    forces: &ContactForces,
) {
    let mut write = |at: usize, v: Vector3| history[at..at + 3].copy_from_slice(&v.to_array());
    if let Some(at) = layout.normal {
        write(at, normal);
    }
    if let Some(at) = layout.memory {
        write(at, forces.memory);
    }
    if let Some(at) = layout.energy {
        history[at] = forces.tangential_energy;
    }
}

/// Forgets the tangential part; the cached normal stays, the start of the next search.
#[inline(always)]
pub(super) fn forget(layout: &HistoryLayout, history: &mut [f64]) {
    let from = layout.memory.unwrap_or(layout.length);
    history[from..].fill(0.0);
}

/// The cached normal, if there is one.
#[inline(always)]
pub(super) fn cached_normal(layout: &HistoryLayout, history: &[f64]) -> Option<Vector3> {
    let at = layout.normal?;
    let n = Vector3::new(history[at], history[at + 1], history[at + 2]);
    // Zero: nothing cached yet. Anything else that is no unit vector came from elsewhere and is not used.
    ((n.norm_squared() - 1.0).abs() < 1e-6).then_some(n)
}

/// A square of a length below which it has lost its digits: the vector has no direction.
const LEAST_SQUARE: f64 = 1e-290;

/// Two spheres: the closed form.
pub(super) fn touch_spheres(
    ri: f64,
    rj: f64,
    d: Vector3,
    i: &Ellipsoid,
    j: &Ellipsoid,
) -> ContactSearch {
    let distance = d.norm();
    // Coincident centres have no direction of their own: any one serves, and momentum is kept.
    let normal = if d.norm_squared() > LEAST_SQUARE {
        d * (1.0 / distance)
    } else {
        Vector3::new(1.0, 0.0, 0.0)
    };
    let support = |body: &Ellipsoid, r: f64| Support {
        h: r,
        inverse_h: 1.0 / r,
        point: normal * r,
        local_normal: body.to_body(normal),
    };
    ContactSearch {
        normal,
        penetration: ri + rj - distance,
        support_i: support(i, ri),
        support_j: support(j, rj),
        tangent: Tangent::new(normal),
        deep: false,
        converged: true,
    }
}

/// Hertz factors of one contact in the form that the law asks for.
#[inline(always)]
pub(super) fn factors_for(law: &PairLaw, trace: f64, determinant: f64) -> Factors {
    if law.kinds.linear {
        return Factors {
            phi: 1.0,
            sigma: 0.0,
        };
    }
    let sigma = law.kinds.conservative
        || !matches!(law.kinds.tangential, Tangential::None | Tangential::Linear);
    if law.kinds.hale {
        // The caller made sure that the form does not break; were it to, the exact one stands in.
        if let Some(f) = hertz_factors::hale(trace, determinant, sigma) {
            return f;
        }
    }
    hertz_factors::exact(trace, determinant, sigma)
}

/// A pair after the search: geometry and motion for the law.
#[inline(always)]
pub(super) fn contact_of(found: &ContactSearch, i: &Particle, j: &Particle) -> Contact {
    Contact {
        normal: found.normal,
        tangent: found.tangent,
        penetration: found.penetration,
        h_i: found.support_i.h,
        inverse_h_i: found.support_i.inverse_h,
        witness_i: found.tangent.components(found.support_i.point),
        weingarten_i: i.body.weingarten(&found.support_i, &found.tangent),
        determinant_i: i.body.shape_determinant(),
        h_j: found.support_j.h,
        inverse_h_j: found.support_j.inverse_h,
        witness_j: found.tangent.components(found.support_j.point),
        weingarten_j: j.body.weingarten(&found.support_j, &found.tangent),
        determinant_j: j.body.shape_determinant(),
        velocity_i: i.velocity,
        velocity_j: j.velocity,
        omega_i: i.omega,
        omega_j: j.omega,
        effective_mass: effective_mass(i.inverse_mass, j.inverse_mass),
        inverse_hessian: None,
    }
}

/// Whether the plane with normal `n` separates a pair: one evaluation rejects.
#[inline(always)]
fn separates(i: &Particle, j: &Particle, d: Vector3, n: Vector3) -> bool {
    let h = |body: &Ellipsoid| body.semi_axes.componentwise(body.to_body(n)).norm();
    h(&i.body) + h(&j.body) < n.dot(d)
}

/// Whether and where a pair touches, from its cached normal.
#[inline(always)]
pub(super) fn touch(i: &Particle, j: &Particle, d: Vector3, start: Option<Vector3>) -> Outcome {
    if i.sphere && j.sphere {
        return Outcome::Touching(touch_spheres(i.radius, j.radius, d, &i.body, &j.body));
    }
    if let Some(n) = start {
        if separates(i, j, d, n) {
            return Outcome::Separated(n);
        }
    }
    search(&i.body, &j.body, d, start)
}

/// The normal at the last step. For two spheres it follows from the motion, so that they need not remember it.
#[inline(always)]
pub(super) fn normal_before(
    cached: Option<Vector3>,
    i: &Particle,
    j: &Particle,
    d: Vector3,
    now: Vector3,
    step: &Step,
) -> Vector3 {
    match cached {
        Some(n) => n,
        None if i.sphere && j.sphere && step.advance_history => {
            let before = d - (j.velocity - i.velocity) * step.time_step;
            if before.norm_squared() > LEAST_SQUARE {
                before.normalised()
            } else {
                now
            }
        }
        None => now,
    }
}

/// All pairs of the list. The workspace's particles are prepared ([`Workspace::prepare_for_pairs`]). Returns how many
/// contacts were deeper than Hertz' law allows. Where [`Workspace::records_contacts`] is set, the touching pairs are in
/// [`Workspace::contacts`] then.
///
/// # Errors
/// What is wrong with the list, before any force is written.
pub fn compute_pairs<R: NeighbourRows>(
    laws: &Laws,
    workspace: &mut Workspace,
    rows: &mut R,
    step: &Step,
    accumulators: &mut Accumulators<'_>,
    mut tallies: Option<&mut Tallies<'_>>,
) -> Result<u64, ListError> {
    workspace.contacts.clear();
    let features = laws.features();
    if !workspace.works_in_lanes(laws) && !workspace.list_is_known {
        check_rows(&laws.layout(), workspace.particles().len(), rows)?;
        workspace.list_is_known = true;
    }
    if features.hale {
        check_hale(laws, workspace.particles(), rows).map_err(ListError::Hale)?;
    }
    if let Some(t) = tallies.as_deref_mut() {
        t.start_step();
    }
    let rate = features.viscous || features.friction || tallies.is_some();
    // Lent to the pass, which has the workspace beside it.
    let mut recorded = core::mem::take(&mut workspace.contacts);
    let records = workspace.records_contacts;
    let pass = Pass {
        laws,
        layout: laws.layout(),
        rows,
        step,
        accumulators,
        tallies,
        recorded: records.then_some(&mut recorded),
        deep_contacts: 0,
    };
    let deep_contacts = match (features.friction, rate, features.conservative) {
        // One kernel with all terms, of which the laws use theirs, serves all scenes.
        _ if records => pass.run::<true, true, true, true>(workspace),
        (true, _, true) => pass.run::<true, true, true, false>(workspace),
        (true, _, false) => pass.run::<true, true, false, false>(workspace),
        (false, true, true) => pass.run::<false, true, true, false>(workspace),
        (false, true, false) => pass.run::<false, true, false, false>(workspace),
        (false, false, true) => pass.run::<false, false, true, false>(workspace),
        (false, false, false) => pass.run::<false, false, false, false>(workspace),
    };
    if deep_contacts.is_ok() {
        recorded.sort();
    } else {
        recorded.clear();
    }
    workspace.contacts = recorded;
    deep_contacts
}

/// Goes through a new list for entries that name no particle and for histories that no call has written. In lanes the search
/// for candidates does so.
fn check_rows<R: NeighbourRows>(
    layout: &HistoryLayout,
    particles: usize,
    rows: &mut R,
) -> Result<(), ListError> {
    let entries = rows.entries();
    for k in 0..rows.count() {
        let row = rows.row(k);
        for (place, &entry) in row.neighbours.iter().enumerate() {
            let Some(other) = entries.index(entry) else {
                continue;
            };
            if other >= particles || other == row.central {
                return Err(ListError::Entry {
                    central: row.central,
                    place,
                    entry,
                });
            }
            if row.touching.get(place).is_some_and(|t| *t != 0) {
                let history = &row.history[place * layout.length..(place + 1) * layout.length];
                check_history(layout, history, row.central, other)?;
            }
        }
    }
    Ok(())
}

/// Refuses the history of a touching pair that no call has written.
pub(super) fn check_history(
    layout: &HistoryLayout,
    history: &[f64],
    i: usize,
    j: usize,
) -> Result<(), ListError> {
    match layout.first_wrong(history) {
        None => Ok(()),
        Some((place, value)) => Err(ListError::History { i, j, place, value }),
    }
}

/// One pass over the list.
pub(super) struct Pass<'a, 'b, 'c, R: NeighbourRows> {
    pub laws: &'a Laws,
    pub layout: HistoryLayout,
    pub rows: &'a mut R,
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

impl<R: NeighbourRows> Pass<'_, '_, '_, R> {
    fn run<const FRICTION: bool, const RATE: bool, const CONSERVATIVE: bool, const RECORD: bool>(
        self,
        workspace: &mut Workspace,
    ) -> Result<u64, ListError> {
        if workspace.works_in_lanes(self.laws) {
            self.in_lanes::<FRICTION, RATE, CONSERVATIVE, RECORD>(workspace)
        } else {
            Ok(self.all_scalar::<FRICTION, RATE, CONSERVATIVE>(workspace.particles()))
        }
    }

    fn all_scalar<const FRICTION: bool, const RATE: bool, const CONSERVATIVE: bool>(
        mut self,
        particles: &[Particle],
    ) -> u64 {
        for row in 0..self.rows.count() {
            let (central, count) = self.start_row(row);
            for entry in 0..count {
                if let Some((place, d)) = self.within_reach(particles, row, entry, central) {
                    let (i, j) = (&particles[place.i], &particles[place.j]);
                    self.one_pair::<FRICTION, RATE, CONSERVATIVE>(place, i, j, d);
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

    /// A pair whose bounding spheres overlap, and the vector between its centres.
    #[inline(always)]
    fn within_reach(
        &mut self,
        particles: &[Particle],
        row: usize,
        entry: usize,
        central: usize,
    ) -> Option<(Place, Vector3)> {
        let named = self.rows.row(row).neighbours[entry];
        let other = self.rows.entries().index(named)?;
        let place = Place {
            entry,
            i: central,
            j: other,
        };
        let (i, j) = (&particles[central], &particles[other]);
        let d = j.position - i.position;
        let reach = i.radius + j.radius;
        if d.norm_squared() < reach * reach {
            Some((place, d))
        } else {
            self.separated(place, None);
            None
        }
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
    pub(super) fn one_pair<const FRICTION: bool, const RATE: bool, const CONSERVATIVE: bool>(
        &mut self,
        place: Place,
        i: &Particle,
        j: &Particle,
        d: Vector3,
    ) {
        let layout = self.layout;
        let step = *self.step;
        let (touching, history) = self.memory(place);
        let touched = touching.is_some_and(|t| *t != 0);
        let cached = cached_normal(&layout, history);
        let found = match touch(i, j, d, cached) {
            Outcome::Touching(found) if found.penetration > 0.0 => found,
            Outcome::Touching(_) => return self.separated(place, None),
            Outcome::Separated(n) => return self.separated(place, Some(n)),
        };
        let law = self.laws.get(i.kind as usize, j.kind as usize);
        let x = contact_of(&found, i, j);
        let curvature = relative_curvature_matrix(x.weingarten_i, x.weingarten_j);
        let factors = factors_for(law, curvature.trace(), curvature.determinant());
        let before = normal_before(cached, i, j, d, found.normal, &step);
        let (_, history) = self.memory(place);
        let remembered = recall(&layout, history, touched, &step, found.normal, before);
        let f = contact_forces::<f64, FRICTION, RATE, CONSERVATIVE, false>(
            &law.kinds,
            &law.constants,
            &factors,
            curvature,
            &x,
            &remembered,
        );
        self.deep_contacts += found.deep as u64;
        if let Some(recorded) = self.recorded.as_deref_mut() {
            recorded.push(ContactRecord {
                i: place.i,
                j: place.j,
                entry: place.entry,
                linear: law.kinds.linear,
                geometry: geometry_of(&found, i, j, law.constants.share_i),
                forces: f,
            });
        }
        self.apply(place, d, found.normal, &f, remembered.time);
    }

    /// Scatter of a touching pair: history, forces, tallies.
    #[inline(always)]
    fn apply(&mut self, place: Place, d: Vector3, normal: Vector3, f: &ContactForces, time: f64) {
        let layout = self.layout;
        let (touching, history) = self.memory(place);
        remember(&layout, history, normal, f);
        if let Some(t) = touching {
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
                    d,
                    force: f.force,
                    viscous_force: f.viscous_force,
                    tangential_force: f.frictional_force,
                    contact_point: f.contact_point,
                    wall_velocity: Vector3::ZERO,
                },
            );
        }
    }
}

/// Geometry of all pairs, to refuse a contact at which Hale's form breaks before anything is written.
fn check_hale<R: NeighbourRows>(
    laws: &Laws,
    particles: &[Particle],
    rows: &mut R,
) -> Result<(), HaleBroke> {
    let layout = laws.layout();
    for k in 0..rows.count() {
        let central = rows.row(k).central;
        let i = &particles[central];
        for m in 0..rows.row(k).neighbours.len() {
            let entry = rows.row(k).neighbours[m];
            let Some(other) = rows.entries().index(entry) else {
                continue;
            };
            let j = &particles[other];
            if !laws.get(i.kind as usize, j.kind as usize).kinds.hale {
                continue;
            }
            let d = j.position - i.position;
            let reach = i.radius + j.radius;
            if d.norm_squared() >= reach * reach {
                continue;
            }
            let row = rows.row(k);
            let cached = cached_normal(
                &layout,
                &row.history[m * layout.length..(m + 1) * layout.length],
            );
            if let Outcome::Touching(found) = touch(i, j, d, cached) {
                let x = contact_of(&found, i, j);
                let curvature = relative_curvature_matrix(x.weingarten_i, x.weingarten_j);
                hale_holds(curvature).map_err(|ratio| HaleBroke {
                    i: central,
                    j: other,
                    ratio,
                })?;
            }
        }
    }
    Ok(())
}

/// Whether Hale's form has a force at this curvature; else the ratio `B/A`.
pub(super) fn hale_holds(curvature: crate::geometry::Symmetric2) -> Result<(), f64> {
    match hertz_factors::hale(curvature.trace(), curvature.determinant(), false) {
        Some(_) => Ok(()),
        None => {
            let (a, b, _) = curvature.eigen();
            Err(b / a)
        }
    }
}
