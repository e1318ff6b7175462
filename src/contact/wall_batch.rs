// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts of ellipsoids with walls in lanes: surfaces that were found one by one, and the law for as many of them at a time as there
//! are lanes.
//!
//! A lane in which the gap is not convex, the curvature ratio beyond the fit, or the wall a cavity in both directions is handed back, to
//! be taken one at a time ([`StagedContact::whole_force`](super::staged::StagedContact::whole_force)), which gives the same numbers to
//! rounding.

use super::forces::{
    contact_forces, relative_curvature_matrix, Contact, ContactForces, MotionChange, NoBed,
    Remembered, Surface,
};
use super::history::Step;
use super::lane_law::{constants_of, factors_for};
use super::particle::Particle;
use super::staged::{WallSurface, LEAST_CURVATURE};
use super::turning_normal::{along_and_across, TurningNormal};
use super::vectors_in_lanes::{load, put_in_lane, Column, Columns};
use crate::force::memory::MOST_PARTS;
use crate::force::{Factors, LawConstants, LawKinds, PairLaw};
use crate::geometry::{ConvexBody, Ellipsoid, SupportInFrame};
use crate::real::Real;
use crate::simd::{put, InstructionSet, Lanes, Line, Registers, Stage, MOST_LANES};
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// What the lanes load.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
struct Numbers {
    axes: [Columns; 3],
    semi_axes: Columns,
    inverse_semi_axes: Columns,
    /// Centre of the body, from the surface's point.
    offset: Columns,
    /// Of the surface, as in [`WallSurface`].
    normal: Columns,
    direction: Columns,
    curvatures: [Column; 2],
    turning_radii: [Column; 2],
    /// Velocity of the body relative to the surface, and angular velocity.
    velocity: Columns,
    omega: Columns,
    velocity_change: Columns,
    omega_change: Columns,
    effective_mass: Column,
    /// What is remembered of the last step.
    last_normal: Columns,
    memory: Columns,
    energy: Column,
}

/// What is remembered of a contact of the last step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LastContact {
    /// Its normal, from the body into the wall; a unit vector.
    pub normal: Vector3,
    /// Its tangential memory.
    pub memory: Vector3,
    /// The elastic energy of that.
    pub energy: f64,
}

/// Contacts on their way into the lanes.
#[derive(Debug)]
pub(crate) struct WallBatch<'a> {
    set: InstructionSet,
    lanes: usize,
    count: usize,
    laws: [Option<&'a PairLaw>; MOST_LANES],
    numbers: Numbers,
    /// Bits of contacts that go on from the last step.
    continued: u32,
    /// Whether a surface is curved.
    curved: bool,
    /// Whether velocities of the step are known.
    changes: bool,
    /// What the lanes gave, four lines a contact.
    lines: [[Line; MOST_LANES]; 4],
}

/// Bits of the contacts of a batch.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WallLanes {
    /// Those that touch.
    pub touching: u32,
    /// Those that are to be taken one at a time.
    pub hard: u32,
}

impl<'a> WallBatch<'a> {
    /// Empty.
    pub fn new(set: InstructionSet) -> Self {
        WallBatch {
            set,
            lanes: set.lanes(),
            count: 0,
            laws: [None; MOST_LANES],
            numbers: Numbers::default(),
            continued: 0,
            curved: false,
            changes: false,
            lines: [[Line::ZERO; MOST_LANES]; 4],
        }
    }

    /// How many contacts there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is no room for another contact of this law and particle: the terms of all must be the same.
    pub fn is_closed_to(&self, law: &PairLaw, i: &Particle) -> bool {
        let Some(first) = self.laws[0].filter(|_| self.count > 0) else {
            return false;
        };
        self.count == self.lanes || first.kinds != law.kinds || self.changes != i.change.is_some()
    }

    /// Adds a contact that the batch is not closed to. Body, surface and what is remembered are in one frame.
    ///
    /// # Panics
    /// Where there is no room.
    pub fn push(
        &mut self,
        law: &'a PairLaw,
        i: &Particle,
        surface: &WallSurface,
        effective_mass: f64,
        last: Option<&LastContact>,
    ) {
        let lane = self.count;
        assert!(lane < self.lanes, "a batch that is full");
        if lane == 0 {
            self.continued = 0;
            self.curved = false;
            self.changes = i.change.is_some();
        }
        self.count += 1;
        self.laws[lane] = Some(law);
        let n = &mut self.numbers;
        for (columns, axis) in n.axes.iter_mut().zip(i.body.axes) {
            put_in_lane(columns, lane, axis);
        }
        put_in_lane(&mut n.semi_axes, lane, i.body.semi_axes);
        put_in_lane(&mut n.inverse_semi_axes, lane, i.body.inverse_semi_axes);
        put_in_lane(&mut n.offset, lane, i.position - surface.point);
        put_in_lane(&mut n.normal, lane, surface.normal);
        put_in_lane(&mut n.direction, lane, surface.direction);
        for k in 0..2 {
            n.curvatures[k][lane] = surface.curvatures[k];
            n.turning_radii[k][lane] = surface.turning_radii[k];
            self.curved |= surface.turning_radii[k].is_finite();
        }
        put_in_lane(&mut n.velocity, lane, i.velocity - surface.velocity);
        put_in_lane(&mut n.omega, lane, i.omega);
        if let Some(change) = &i.change {
            let velocity = change.velocity - surface.velocity_change;
            put_in_lane(&mut n.velocity_change, lane, velocity);
            put_in_lane(&mut n.omega_change, lane, change.omega);
        }
        n.effective_mass[lane] = effective_mass;
        let [normal, memory] = last.map_or([-surface.normal, Vector3::ZERO], |last| {
            [last.normal, last.memory]
        });
        put_in_lane(&mut n.last_normal, lane, normal);
        put_in_lane(&mut n.memory, lane, memory);
        n.energy[lane] = last.map_or(0.0, |last| last.energy);
        self.continued |= u32::from(last.is_some()) << lane;
    }

    /// Takes the contacts through the law, and begins anew; [`WallBatch::forces`] gives what came out. Shares are not taken.
    pub fn compute(&mut self, step: &Step) -> WallLanes {
        let mut found = WallLanes::default();
        let Some(first) = self.laws[0].filter(|_| self.count > 0) else {
            return found;
        };
        // Lanes without a contact of their own compute the first one again.
        let mut laws = [first; MOST_LANES];
        for (law, own) in laws.iter_mut().zip(&self.laws[..self.count]) {
            *law = own.unwrap_or(first);
        }
        if self.count < self.lanes {
            self.numbers.fill_from(self.count);
        }
        self.set.run(Contacts {
            batch: self,
            laws: &laws,
            step,
            found: &mut found,
        });
        let present = (1u32 << self.count) - 1;
        found.touching &= present;
        found.hard &= present;
        self.count = 0;
        found
    }

    /// Forces and penetration of a contact that touches.
    pub fn forces(&self, lane: usize) -> (ContactForces, f64) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| &self.lines[k][lane].0);
        let vector = |line: &[f64; 8], k: usize| Vector3::new(line[k], line[k + 1], line[k + 2]);
        let forces = ContactForces {
            force: vector(a, 0),
            torque_i: vector(a, 3),
            torque_j: Vector3::ZERO,
            normal_force: a[6],
            stiffness: a[7],
            tangential_force: vector(b, 0),
            contact_point: vector(b, 3),
            elastic_energy: b[6],
            tangential_energy: b[7],
            memory: vector(c, 0),
            rests: [0.0; MOST_PARTS],
            relaxed_energy: 0.0,
            displacement: vector(c, 3),
            rate: c[6],
            viscous_power: c[7],
            viscous_force: vector(d, 0),
            frictional_force: vector(d, 3),
            tangential_power: d[6],
            frictional_couple: Vector3::ZERO,
            viscous_couple: Vector3::ZERO,
        };
        (forces, d[7])
    }
}

impl Numbers {
    /// Copies the first lane to those from `from` on.
    fn fill_from(&mut self, from: usize) {
        let Numbers {
            axes: [a, b, c],
            semi_axes,
            inverse_semi_axes,
            offset,
            normal,
            direction,
            curvatures,
            turning_radii,
            velocity,
            omega,
            velocity_change,
            omega_change,
            effective_mass,
            last_normal,
            memory,
            energy,
        } = self;
        let vectors = [
            a,
            b,
            c,
            semi_axes,
            inverse_semi_axes,
            offset,
            normal,
            direction,
            velocity,
            omega,
            velocity_change,
            omega_change,
            last_normal,
            memory,
        ];
        let numbers = curvatures.iter_mut().chain(turning_radii);
        let all = vectors.into_iter().flatten().chain(numbers);
        for column in all.chain([effective_mass, energy]) {
            let first = column[0];
            column[from..].fill(first);
        }
    }
}

/// See [`contacts`].
struct Contacts<'p, 'a> {
    batch: &'p mut WallBatch<'a>,
    laws: &'p [&'a PairLaw; MOST_LANES],
    step: &'p Step,
    found: &'p mut WallLanes,
}

impl Stage for Contacts<'_, '_> {
    #[inline(always)]
    fn run<S: Registers>(self, registers: S) {
        *self.found = contacts(registers, self.batch, self.laws, self.step);
    }
}

/// A body in each lane beside a surface, in one frame, in which the surface is at rest.
pub(crate) struct BodyAtSurface<T: Real, B> {
    pub body: B,
    /// Unit normal out of the wall, towards the body.
    pub outwards: Vector3<T>,
    /// How far its centre lies from the plane that touches the surface.
    pub height: T,
    /// Motion of the body.
    pub velocity: Vector3<T>,
    pub omega: Vector3<T>,
    /// What it has more at the step, where that is known.
    pub change: Option<MotionChange<T>>,
    pub effective_mass: T,
}

/// The same, with the place of the contact.
pub(crate) struct PlacedAtSurface<S: Registers, B: ConvexBody<Lanes<S>>> {
    at: BodyAtSurface<Lanes<S>, B>,
    view: B::View,
    support: SupportInFrame<Lanes<S>>,
    /// Basis of the tangent plane; the normal of the contact is into the wall.
    pub tangent: Tangent<Lanes<S>>,
    /// Penetration, not positive in lanes that do not touch.
    pub penetration: Lanes<S>,
    /// Lanes that touch.
    pub touching: S::Mask,
}

/// How a surface is curved and turns, as in [`WallSurface`].
pub(crate) struct CurvedWall<S: Registers> {
    pub direction: Vector3<Lanes<S>>,
    pub curvatures: [Lanes<S>; 2],
    pub turning_radii: [Lanes<S>; 2],
}

/// What the law makes of it.
pub(crate) struct ForcesAtSurface<S: Registers> {
    pub forces: ContactForces<Lanes<S>>,
    /// Lanes that are to be taken one at a time.
    pub hard: S::Mask,
}

/// The same, with what the turning of the normal needs.
struct AtSurface<S: Registers> {
    contact: Contact<Lanes<S>>,
    curvature: Symmetric2<Lanes<S>>,
    factors: Factors<Lanes<S>>,
    forces: ContactForces<Lanes<S>>,
    hard: S::Mask,
}

impl<S: Registers, B: ConvexBody<Lanes<S>>> PlacedAtSurface<S, B> {
    /// Finds how deep each body is.
    #[inline(always)]
    pub fn new(registers: S, at: BodyAtSurface<Lanes<S>, B>) -> Self {
        let normal = -at.outwards;
        let tangent = Tangent::new(normal);
        let view = at.body.view(normal, &tangent);
        let support = at.body.support_in_frame(&view);
        let penetration = support.h - at.height;
        PlacedAtSurface {
            touching: Lanes::splat(registers, 0.0).less(penetration),
            at,
            view,
            support,
            tangent,
            penetration,
        }
    }

    /// The body.
    #[inline(always)]
    pub fn body(&self) -> &B {
        &self.at.body
    }

    /// The surface's deepest point, from the centre of the body.
    #[inline(always)]
    pub fn point(&self) -> Vector3<Lanes<S>> {
        self.tangent.vector(self.support.witness) - self.at.outwards * self.at.height
    }

    /// Takes the velocity of the surface off that of the body.
    #[inline(always)]
    pub fn take_off(&mut self, velocity: Vector3<Lanes<S>>) {
        self.at.velocity = self.at.velocity - velocity;
    }

    /// The same of what it has more at the step, where the body comes with a change.
    #[inline(always)]
    pub fn take_off_change(&mut self, velocity: Vector3<Lanes<S>>) {
        if let Some(change) = &mut self.at.change {
            change.velocity = change.velocity - velocity;
        }
    }

    /// The masses that the contacts move.
    #[inline(always)]
    pub fn effective_mass(&self) -> Lanes<S> {
        self.at.effective_mass
    }

    /// Forces at a flat surface.
    #[inline(always)]
    pub fn forces(
        &self,
        registers: S,
        kinds: &LawKinds,
        constants: &LawConstants<Lanes<S>>,
        remembered: &Remembered<Lanes<S>>,
        step: &Step,
    ) -> ForcesAtSurface<S> {
        let AtSurface { forces, hard, .. } =
            self.through_law(registers, kinds, constants, None, remembered, step);
        ForcesAtSurface { forces, hard }
    }

    /// Forces at any surface; `turns` says whether one of the lanes has a finite radius about which it turns.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub fn forces_at_curved(
        &self,
        registers: S,
        kinds: &LawKinds,
        constants: &LawConstants<Lanes<S>>,
        wall: &CurvedWall<S>,
        turns: bool,
        remembered: &Remembered<Lanes<S>>,
        step: &Step,
    ) -> ForcesAtSurface<S> {
        let along = self.tangent.components(wall.direction);
        let of_wall = Some(along_and_across(along, wall.curvatures));
        let AtSurface {
            contact: x,
            curvature,
            factors,
            mut forces,
            mut hard,
        } = self.through_law(registers, kinds, constants, of_wall, remembered, step);
        if kinds.conservative && turns {
            let zero = Lanes::splat(registers, 0.0);
            let radii = wall.turning_radii;
            let infinite = zero.constant(f64::INFINITY);
            let turns = [radii[0].less(infinite), radii[1].less(infinite)];
            let both = registers.and(turns[0], turns[1]);
            let either = registers.or(turns[0], turns[1]);
            let cavity = registers.or(radii[0].less(zero), radii[1].less(zero));
            hard = registers.or(hard, registers.and(both, cavity));

            let turning = TurningNormal::of(&x, curvature, &factors);
            let direction = Vector2::new(
                Lanes::select(turns[0], along.u, -along.v),
                Lanes::select(turns[0], along.v, along.u),
            );
            let radius = Lanes::select(turns[0], radii[0], radii[1]);
            let radius = Lanes::select(either, radius, zero);
            let mut lambda = turning.response_along(direction, radius, x.penetration);
            if registers.any(both) {
                let radii = [
                    Lanes::select(both, radii[0], zero),
                    Lanes::select(both, radii[1], zero),
                ];
                let around = turning.response_around(along, radii, x.penetration);
                lambda = Vector2::new(
                    Lanes::select(both, around.u, lambda.u),
                    Lanes::select(both, around.v, lambda.v),
                );
            }
            let lambda = Vector2::new(
                Lanes::select(either, lambda.u, zero),
                Lanes::select(either, lambda.v, zero),
            );
            turning.add(&x, lambda, forces.elastic_energy, &mut forces);
        }
        ForcesAtSurface { forces, hard }
    }

    /// The law, with this Weingarten map of the surface in the tangent basis; none for a plane.
    #[inline(always)]
    fn through_law(
        &self,
        registers: S,
        kinds: &LawKinds,
        constants: &LawConstants<Lanes<S>>,
        of_wall: Option<Symmetric2<Lanes<S>>>,
        remembered: &Remembered<Lanes<S>>,
        step: &Step,
    ) -> AtSurface<S> {
        let zero = Lanes::splat(registers, 0.0);
        let null = Vector3::new(zero, zero, zero);
        let at = &self.at;
        let weingarten = at.body.weingarten_in_frame(&self.view, self.support.h);
        let flat = Symmetric2::new(zero, zero, zero);
        let curvature = relative_curvature_matrix(weingarten, of_wall.unwrap_or(flat));
        let mut hard = registers.no_lane();
        if of_wall.is_some() {
            let least = weingarten.determinant() * LEAST_CURVATURE / weingarten.trace();
            hard = registers.not(registers.and(
                zero.less(curvature.trace()),
                (least * curvature.trace()).less(curvature.determinant()),
            ));
        }
        let unsound = registers.or(registers.not(self.touching), hard);
        let (factors, beyond) = factors_for(registers, kinds, curvature, unsound, true);

        let body = Surface {
            h: self.support.h,
            inverse_h: self.support.inverse_h,
            witness: self.support.witness,
            weingarten,
            determinant: at.body.squared_product(),
            velocity: at.velocity,
            omega: at.omega,
        };
        let mut contact = Contact::new(
            (-at.outwards, self.tangent),
            // A lane that does not touch computes nothing that is used, but must not make a trap of it.
            self.penetration.max(zero.constant(1e-300)),
            [body, Surface::of_wall(of_wall.unwrap_or(flat), null)],
            at.effective_mass,
        );
        if let Some(change) = at.change {
            contact.change = Some(MotionChange {
                velocity: -change.velocity,
                omega: -change.omega,
            });
            contact.begin_time = Some(Lanes::splat(registers, step.time_step));
        }
        let forces = contact_forces::<Lanes<S>, NoBed, true, true, true, true>(
            kinds, constants, &factors, curvature, &contact, remembered, None,
        );
        AtSurface {
            contact,
            curvature,
            factors,
            forces,
            hard: registers.or(hard, beyond),
        }
    }
}

/// Geometry, law and the turning of the normal.
#[inline(always)]
fn contacts<S: Registers>(
    registers: S,
    batch: &mut WallBatch<'_>,
    laws: &[&PairLaw; MOST_LANES],
    step: &Step,
) -> WallLanes {
    let numbers = &batch.numbers;
    let kinds: &LawKinds = &laws[0].kinds;

    let outwards = load(registers, &numbers.normal);
    let mut at = BodyAtSurface {
        body: Ellipsoid {
            axes: [
                load(registers, &numbers.axes[0]),
                load(registers, &numbers.axes[1]),
                load(registers, &numbers.axes[2]),
            ],
            semi_axes: load(registers, &numbers.semi_axes),
            inverse_semi_axes: load(registers, &numbers.inverse_semi_axes),
        },
        outwards,
        height: outwards.dot(load(registers, &numbers.offset)),
        velocity: load(registers, &numbers.velocity),
        omega: load(registers, &numbers.omega),
        change: None,
        effective_mass: Lanes::load(registers, &numbers.effective_mass),
    };
    if batch.changes {
        at.change = Some(MotionChange {
            velocity: load(registers, &numbers.velocity_change),
            omega: load(registers, &numbers.omega_change),
        });
    }
    let placed = PlacedAtSurface::new(registers, at);
    let last = (
        load(registers, &numbers.last_normal),
        load(registers, &numbers.memory),
        Lanes::load(registers, &numbers.energy),
    );
    let remembered = Remembered::of(
        registers.mask(batch.continued),
        -outwards,
        last,
        Lanes::splat(registers, step.elapsed()),
    );
    let wall = CurvedWall {
        direction: load(registers, &numbers.direction),
        curvatures: [
            Lanes::load(registers, &numbers.curvatures[0]),
            Lanes::load(registers, &numbers.curvatures[1]),
        ],
        turning_radii: [
            Lanes::load(registers, &numbers.turning_radii[0]),
            Lanes::load(registers, &numbers.turning_radii[1]),
        ],
    };
    let constants = constants_of(registers, laws, None);
    let curved = batch.curved;
    let ForcesAtSurface { forces, hard } = placed.forces_at_curved(
        registers,
        kinds,
        &constants,
        &wall,
        curved,
        &remembered,
        step,
    );
    store(registers, &forces, placed.penetration, &mut batch.lines);
    let apart = registers.not(placed.touching);
    WallLanes {
        touching: registers.bits(registers.and_not(placed.touching, hard)),
        hard: registers.bits(registers.and_not(hard, apart)),
    }
}

/// The reverse of [`WallBatch::forces`].
#[inline(always)]
fn store<S: Registers>(
    registers: S,
    f: &ContactForces<Lanes<S>>,
    penetration: Lanes<S>,
    lines: &mut [[Line; MOST_LANES]; 4],
) {
    let line = |a: Vector3<Lanes<S>>, b: Vector3<Lanes<S>>, c: Lanes<S>, d: Lanes<S>| {
        [a.x, a.y, a.z, b.x, b.y, b.z, c, d]
    };
    let all = [
        line(f.force, f.torque_i, f.normal_force, f.stiffness),
        line(
            f.tangential_force,
            f.contact_point,
            f.elastic_energy,
            f.tangential_energy,
        ),
        line(f.memory, f.displacement, f.rate, f.viscous_power),
        line(
            f.viscous_force,
            f.frictional_force,
            f.tangential_power,
            penetration,
        ),
    ];
    for (numbers, lines) in all.into_iter().zip(lines) {
        put(registers, numbers, lines);
    }
}
