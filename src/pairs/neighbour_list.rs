// SPDX-License-Identifier: MIT OR Apache-2.0
//! The hot loop: all pairs of an engine's neighbour list, one call a step.
//!
//! A pair is rejected by its bounding spheres, else by one evaluation with the cached normal; what is left goes through
//! the contact search, the law and the scatter. Nothing is allocated.

use super::contact::{
    contact_forces, relative_curvature_matrix, Contact, ContactForces, Remembered,
};
use super::history::HistoryLayout;
use super::laws::{Features, Laws};
use super::particles::{effective_mass, Particle};
use super::tallies::{Contribution, Tallies};
use super::Step;
use crate::force::{hertz_factors, Factors, PairLaw, Tangential};
use crate::geometry::{search, ContactSearch, Ellipsoid, Outcome, Support, Tangent, Vector3};

/// The neighbours of one central particle, and what is remembered of its pairs.
pub struct NeighbourRow<'a> {
    /// Index of the central particle.
    pub central: usize,
    /// Entries of the engine's list; [`NeighbourRows::index`] makes an index of one.
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
    /// Index of the particle that an entry names, or `None` for a pair that the engine excludes.
    fn index(&self, entry: i32) -> Option<usize>;
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
    /// Second particle's index (that of the first again for a wall).
    pub j: usize,
    /// `B/A`.
    pub ratio: f64,
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
        stiffness: match layout.stiffness {
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
    if let Some(at) = layout.stiffness {
        history[at] = forces.stiffness;
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
    let normal = if distance > 0.0 {
        d * (1.0 / distance)
    } else {
        Vector3::new(1.0, 0.0, 0.0)
    };
    let support = |body: &Ellipsoid, r: f64| Support {
        h: r,
        point: normal * r,
        local_normal: body.to_body(normal),
    };
    ContactSearch {
        normal,
        penetration: ri + rj - distance,
        support_i: support(i, ri),
        support_j: support(j, rj),
        tangent: Tangent::new(normal),
        many_starts: false,
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
pub(super) fn contact_of(found: &ContactSearch, d: Vector3, i: &Particle, j: &Particle) -> Contact {
    Contact {
        normal: found.normal,
        tangent: found.tangent,
        penetration: found.penetration,
        d,
        h_i: found.support_i.h,
        s_i: found.support_i.point,
        weingarten_i: i.body.weingarten(&found.support_i, &found.tangent),
        determinant_i: i.body.shape_determinant(),
        h_j: found.support_j.h,
        s_j: found.support_j.point,
        weingarten_j: j.body.weingarten(&found.support_j, &found.tangent),
        determinant_j: j.body.shape_determinant(),
        velocity_i: i.velocity,
        velocity_j: j.velocity,
        omega_i: i.omega,
        omega_j: j.omega,
        effective_mass: effective_mass(i.inverse_mass, j.inverse_mass),
    }
}

/// Whether and where a pair touches, from its cached normal.
#[inline(always)]
pub(super) fn touch(i: &Particle, j: &Particle, d: Vector3, start: Option<Vector3>) -> Outcome {
    if i.sphere && j.sphere {
        return Outcome::Touching(touch_spheres(i.radius, j.radius, d, &i.body, &j.body));
    }
    if let Some(n) = start {
        // One evaluation rejects: h_i + h_j - n.d < 0.
        let h = |body: &Ellipsoid| body.semi_axes.componentwise(body.to_body(n)).norm();
        if h(&i.body) + h(&j.body) - n.dot(d) < 0.0 {
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
            if before.norm_squared() > 0.0 {
                before.normalised()
            } else {
                now
            }
        }
        None => now,
    }
}

/// All pairs of the list. `particles` are prepared ([`super::Workspace::prepare`]). Returns how many contacts took the
/// slow search from many starts.
///
/// # Errors
/// Only with `factors hale`, and before any force is written.
pub fn compute_pairs<R: NeighbourRows>(
    laws: &Laws,
    particles: &[Particle],
    rows: &mut R,
    step: &Step,
    accumulators: &mut Accumulators<'_>,
    tallies: Option<&mut Tallies<'_>>,
) -> Result<u64, HaleBroke> {
    let features = laws.features();
    if features.hale {
        check_hale(laws, particles, rows)?;
    }
    let rate = features.viscous || features.friction || tallies.is_some();
    macro_rules! kernel {
        ($friction:literal, $rate:literal, $conservative:literal) => {
            all_rows::<R, $friction, $rate, $conservative>(
                laws,
                particles,
                rows,
                step,
                accumulators,
                tallies,
            )
        };
    }
    Ok(match (features.friction, rate, features.conservative) {
        (true, _, true) => kernel!(true, true, true),
        (true, _, false) => kernel!(true, true, false),
        (false, true, true) => kernel!(false, true, true),
        (false, true, false) => kernel!(false, true, false),
        (false, false, true) => kernel!(false, false, true),
        (false, false, false) => kernel!(false, false, false),
    })
}

fn all_rows<R: NeighbourRows, const FRICTION: bool, const RATE: bool, const CONSERVATIVE: bool>(
    laws: &Laws,
    particles: &[Particle],
    rows: &mut R,
    step: &Step,
    accumulators: &mut Accumulators<'_>,
    mut tallies: Option<&mut Tallies<'_>>,
) -> u64 {
    let mut many_starts = 0;
    let layout = laws.layout();
    let length = layout.length;
    if let Some(t) = tallies.as_deref_mut() {
        t.start_step();
    }
    for k in 0..rows.count() {
        let count = rows.row(k).neighbours.len();
        let central = rows.row(k).central;
        let i = &particles[central];
        let mut force_i = Vector3::ZERO;
        let mut torque_i = Vector3::ZERO;
        for m in 0..count {
            let entry = rows.row(k).neighbours[m];
            let Some(other) = rows.index(entry) else {
                continue;
            };
            let j = &particles[other];
            let d = j.position - i.position;
            let reach = i.radius + j.radius;
            let row = rows.row(k);
            let mut none_touching = 0;
            let touching: &mut i32 = match row.touching.get_mut(m) {
                Some(t) => t,
                None => &mut none_touching,
            };
            let history = &mut row.history[m * length..(m + 1) * length];
            if d.norm_squared() >= reach * reach {
                if *touching != 0 {
                    *touching = 0;
                    forget(&layout, history);
                }
                continue;
            }
            let cached = cached_normal(&layout, history);
            let found = match touch(i, j, d, cached) {
                Outcome::Separated(n) => {
                    if let Some(at) = layout.normal {
                        history[at..at + 3].copy_from_slice(&n.to_array());
                    }
                    if *touching != 0 {
                        *touching = 0;
                        forget(&layout, history);
                    }
                    continue;
                }
                Outcome::Touching(found) if found.penetration <= 0.0 => {
                    if *touching != 0 {
                        *touching = 0;
                        forget(&layout, history);
                    }
                    continue;
                }
                Outcome::Touching(found) => found,
            };
            let law = laws.get(i.kind as usize, j.kind as usize);
            let x = contact_of(&found, d, i, j);
            let curvature = relative_curvature_matrix(x.weingarten_i, x.weingarten_j);
            let factors = factors_for(law, curvature.trace(), curvature.determinant());
            let before = normal_before(cached, i, j, d, found.normal, step);
            let remembered = recall(&layout, history, *touching != 0, step, found.normal, before);
            let f = contact_forces::<f64, FRICTION, RATE, CONSERVATIVE, false>(
                &law.kinds,
                &law.constants,
                &factors,
                curvature,
                &x,
                &remembered,
            );
            remember(&layout, history, found.normal, &f);
            *touching = 1;
            many_starts += found.many_starts as u64;
            force_i = force_i - f.force;
            torque_i = torque_i + f.torque_i;
            if other < accumulators.reaction_below {
                add(&mut accumulators.forces[other], f.force);
                add(&mut accumulators.torques[other], f.torque_j);
            }
            if let Some(t) = tallies.as_deref_mut() {
                t.add(
                    central,
                    Some(other),
                    other < accumulators.reaction_below,
                    &Contribution {
                        normal_energy: f.elastic_energy,
                        tangential_energy: f.tangential_energy,
                        work: remembered.time * (f.viscous_power + f.tangential_power),
                        d,
                        force: f.force,
                    },
                );
            }
        }
        if let Some(t) = tallies.as_deref_mut() {
            t.pairs += count as u64;
        }
        add(&mut accumulators.forces[central], force_i);
        add(&mut accumulators.torques[central], torque_i);
    }
    many_starts
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
            let Some(other) = rows.index(entry) else {
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
                let x = contact_of(&found, d, i, j);
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

/// The terms of the scene's laws, for a report.
pub fn describe_kernel(features: &Features) -> String {
    let mut terms = vec!["elastic"];
    if features.viscous {
        terms.push("viscous");
    }
    if features.friction {
        terms.push("frictional");
    }
    if features.conservative {
        terms.push("conservative");
    }
    terms.join(", ")
}
