// SPDX-License-Identifier: MIT OR Apache-2.0
//! Force and torques of one touching pair, once its geometry is known: the law put together, in lanes.

use crate::force::conservative::{
    additional_torque, body_gradient, curvature_gradient, normal_response, BodyAtContact,
    NormalResponse,
};
use crate::force::contact_begin::begin_factor;
use crate::force::memory::{normal_force_with_memory, Approach, ForceWithMemory, MOST_PARTS};
use crate::force::twisting_bed::force_and_torque_of_springs;
use crate::force::{
    force_of_springs, normal_force, tangential_force, Factors, LawConstants, LawKinds, Springs,
    TangentialConstants, TangentialForce, TangentialKinds, SPRINGS,
};
use crate::geometry::curvature::inverse_weingarten;
use crate::real::Real;
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// One body at a contact: its surface, and its motion.
#[derive(Clone, Copy, Debug)]
pub struct Surface<T: Real = f64> {
    /// Support function, which is the part of the witness along the normal, from the centre.
    pub h: T,
    /// `1/h`.
    pub inverse_h: T,
    /// The other part of the witness, in the tangent basis.
    pub witness: Vector2<T>,
    /// Weingarten map in the tangent basis; zero for a plane.
    pub weingarten: Symmetric2<T>,
    /// `(a1 a2 a3)^2`.
    pub determinant: T,
    /// Velocity of the centre, or of a wall at the contact.
    pub velocity: Vector3<T>,
    /// Angular velocity, world frame.
    pub omega: Vector3<T>,
}

impl<T: Real> Surface<T> {
    /// Of a wall with this Weingarten map and this velocity at the contact.
    #[inline(always)]
    pub fn of_wall(weingarten: Symmetric2<T>, velocity: Vector3<T>) -> Self {
        let one = velocity.x.constant(1.0);
        let zero = velocity.x.constant(0.0);
        Surface {
            h: one,
            inverse_h: one,
            witness: Vector2::new(zero, zero),
            weingarten,
            determinant: one,
            velocity,
            omega: Vector3::new(zero, zero, zero),
        }
    }

    /// What the conservative law needs. A function, not a closure: a closure is not always inlined into the code of the
    /// chosen instruction set, and then costs a call per operation.
    #[inline(always)]
    pub(super) fn for_gradient(&self) -> BodyAtContact<T> {
        BodyAtContact {
            h: self.h,
            inverse_h: self.inverse_h,
            witness: self.witness,
            weingarten: self.weingarten,
            inverse_weingarten: inverse_weingarten(
                self.weingarten,
                self.inverse_h,
                self.determinant,
            ),
        }
    }
}

/// What the motion of a body has more at a step than at the half step before it, by which the body came to where it is.
#[derive(Clone, Copy, Debug)]
pub struct MotionChange<T = f64> {
    /// Velocity of the centre.
    pub velocity: Vector3<T>,
    /// Angular velocity, world frame.
    pub omega: Vector3<T>,
}

impl MotionChange {
    /// Of a body whose motion is steady.
    pub const NONE: MotionChange = MotionChange {
        velocity: Vector3::ZERO,
        omega: Vector3::ZERO,
    };

    /// Of `j` relative to `i`, whose own changes these are: as the motion of one rigid body, `velocity` that of its point at the centre of
    /// `i`, from which `d` leads to where `j` has its own velocity.
    #[inline(always)]
    pub fn between([i, j]: [MotionChange; 2], d: Vector3) -> MotionChange {
        MotionChange {
            velocity: j.velocity - i.velocity - j.omega.cross(d),
            omega: j.omega - i.omega,
        }
    }
}

impl<T: Real> MotionChange<T> {
    /// The change of the velocity of the point at `r` from where `velocity` is given.
    #[inline(always)]
    pub fn at(&self, r: Vector3<T>) -> Vector3<T> {
        self.velocity + self.omega.cross(r)
    }
}

/// A touching pair: geometry and motion.
#[derive(Clone, Copy, Debug)]
pub struct Contact<T: Real = f64> {
    /// Unit normal from `i` to `j`.
    pub normal: Vector3<T>,
    /// Its tangent basis.
    pub tangent: Tangent<T>,
    /// Penetration > 0.
    pub penetration: T,
    /// The surface and the motion of `i`.
    pub i: Surface<T>,
    /// The same of `j`, for the same normal: its witness from its centre is minus that of the support function.
    pub j: Surface<T>,
    /// Effective mass `m_i m_j/(m_i + m_j)`.
    pub effective_mass: T,
    /// `(W_i + W_j - delta I)^-1`, where it is known and the contact is less than half as deep as the smallest radius of
    /// curvature.
    pub inverse_hessian: Option<Symmetric2<T>>,
    /// What the motion of `j` relative to `i` has more at the step, as [`MotionChange::between`] has it, where velocities of the step are
    /// known beside those of the half step, which `i` and `j` hold: viscous forces take them. Else the velocities of the half step serve
    /// for all.
    pub change: Option<MotionChange<T>>,
    /// The time step, where viscous forces are to have the impulse of a contact that began within it (`force/contact_begin.rs`):
    /// where velocities are those of the step.
    pub begin_time: Option<T>,
}

impl<T: Real> Contact<T> {
    /// With this normal and its tangent basis; what is not given is not known: the inverse Hessian, and velocities of the step.
    #[inline(always)]
    pub fn new(
        (normal, tangent): (Vector3<T>, Tangent<T>),
        penetration: T,
        [i, j]: [Surface<T>; 2],
        effective_mass: T,
    ) -> Self {
        Contact {
            normal,
            tangent,
            penetration,
            i,
            j,
            effective_mass,
            inverse_hessian: None,
            change: None,
            begin_time: None,
        }
    }
    /// The relative curvature matrix `M`, 1/length.
    #[inline(always)]
    pub fn curvature(&self) -> Symmetric2<T> {
        relative_curvature_matrix(self.i.weingarten, self.j.weingarten)
    }
    /// How the elastic energy changes with the pose at the same penetration.
    #[inline(always)]
    pub fn energy_gradient<const WALL: bool>(
        &self,
        curvature: Symmetric2<T>,
        factors: &Factors<T>,
    ) -> EnergyGradient<T> {
        let zero = self.penetration.constant(0.0);
        let none = Vector2::new(zero, zero);
        let p = curvature_gradient(curvature, factors);
        let body_i = self.i.for_gradient();
        let gradient_i = body_gradient(p, &body_i);
        if WALL {
            // The wall holds the normal where it is.
            let held = NormalResponse::exactly(none);
            return EnergyGradient {
                lambda: none,
                torque_i: additional_torque(&body_i, &gradient_i, &held),
                torque_j: (none, zero),
            };
        }
        let body_j = self.j.for_gradient();
        let gradient_j = body_gradient(p, &body_j);
        let gamma = gradient_i.gamma + gradient_j.gamma;
        let response = match self.inverse_hessian {
            Some(inverse) => NormalResponse::exactly(inverse.apply(gamma)),
            None => normal_response(
                body_i.inverse_weingarten + body_j.inverse_weingarten,
                self.penetration,
                gamma,
            ),
        };
        EnergyGradient {
            lambda: response.lambda,
            torque_i: additional_torque(&body_i, &gradient_i, &response),
            torque_j: additional_torque(&body_j, &gradient_j, &response),
        }
    }
    /// Centre of `j` less centre of `i`.
    #[inline(always)]
    pub fn between_centres(&self) -> Vector3<T> {
        let along = self.i.h + self.j.h - self.penetration;
        let across = self.tangent.vector(self.i.witness + self.j.witness);
        self.normal.scale_add(along, across)
    }
}

/// The further terms of the conservative law over the elastic energy, in the frame of the contact (`force/conservative.rs`).
#[derive(Clone, Copy, Debug)]
pub struct EnergyGradient<T = f64> {
    /// Of the force, 1/length.
    pub lambda: Vector2<T>,
    /// Of the torque on `i`: tangential components, and that along the normal.
    pub torque_i: (Vector2<T>, T),
    /// Of the torque on `j`.
    pub torque_j: (Vector2<T>, T),
}

impl EnergyGradient {
    /// Adds the further terms of a conservative law to the force and the torques of a contact of two bodies that were found without them,
    /// its normal and its tangent basis as those of the gradient.
    #[inline(always)]
    pub fn add_to(&self, normal: Vector3, tangent: &Tangent, forces: &mut ContactForces) {
        let minus = -forces.elastic_energy;
        let in_world = |(across, along): (Vector2, f64)| {
            normal.scale_add(along * minus, tangent.vector(across * minus))
        };
        forces.force = forces.force + in_world((self.lambda, 0.0));
        forces.torque_i = forces.torque_i + in_world(self.torque_i);
        forces.torque_j = forces.torque_j + in_world(self.torque_j);
    }
}

/// What is remembered of the pair.
#[derive(Clone, Copy, Debug)]
pub struct Remembered<T: Real = f64> {
    /// Whether the pair touched at the last step too.
    pub continued: T::Mask,
    /// The normal at the last step (the present one where it is not known).
    pub normal: Vector3<T>,
    /// Tangential memory, world frame.
    pub memory: Vector3<T>,
    /// Elastic energy of the tangential memory at the last step.
    pub energy: T,
    /// Penetrations of rest of the relaxing parts of the normal force; `None` where the kernel has none.
    pub rests: Option<[T; MOST_PARTS]>,
    /// Time over which the memory advances: 0 in the set-up of a run.
    pub time: T,
}

impl<T: Real> Remembered<T> {
    /// Of contacts that go on from the normal, the memory and the energy `last` where `continued`, and else begin with the normal `now`;
    /// `time` is that over which the memory advances.
    #[inline(always)]
    pub fn of(
        continued: T::Mask,
        now: Vector3<T>,
        (normal, memory, energy): (Vector3<T>, Vector3<T>, T),
        time: T,
    ) -> Self {
        let zero = time.constant(0.0);
        Remembered {
            continued,
            normal: Vector3::select(continued, normal, now),
            memory: Vector3::select(continued, memory, Vector3::new(zero, zero, zero)),
            energy: T::select(continued, energy, zero),
            rests: None,
            time,
        }
    }

    /// Nothing, over no time; no lane is in the mask `none`.
    #[inline(always)]
    pub fn nothing(none: T::Mask, normal: Vector3<T>) -> Self {
        let zero = normal.x.constant(0.0);
        Remembered {
            continued: none,
            normal,
            memory: Vector3::new(zero, zero, zero),
            energy: zero,
            rests: None,
            time: zero,
        }
    }
}

/// Force, torques and what is to be remembered. Torques, tangential energy and powers of a whole contact have those of the couple that
/// resists rolling and twisting too.
#[derive(Clone, Copy, Debug)]
pub struct ContactForces<T = f64> {
    /// Force on `j`, world frame; on `i` the opposite.
    pub force: Vector3<T>,
    /// Torque on `i` about its centre, world frame.
    pub torque_i: Vector3<T>,
    /// Torque on `j` about its centre, world frame.
    pub torque_j: Vector3<T>,
    /// Normal force.
    pub normal_force: T,
    /// Tangential force on `j`, world frame.
    pub tangential_force: Vector3<T>,
    /// Contact point from the centre of `i`.
    pub contact_point: Vector3<T>,
    /// Tangential memory, world frame. Where no time passes it is the old one, turned with the contact.
    pub memory: Vector3<T>,
    /// Penetrations of rest of the relaxing parts of the normal force.
    pub rests: [T; MOST_PARTS],
    /// Energy that these dissipated in the step.
    pub relaxed_energy: T,
    /// Tangential displacement, world frame.
    pub displacement: Vector3<T>,
    /// Normal stiffness `dF_H/d(delta)` at the present contact area.
    pub stiffness: T,
    /// Rate of penetration, positive while the bodies approach.
    pub rate: T,
    /// Elastic energy of the normal deformation.
    pub elastic_energy: T,
    /// Elastic energy of the tangential deformation.
    pub tangential_energy: T,
    /// What of the force on `j` the viscous terms make, normal and tangential, world frame.
    pub viscous_force: Vector3<T>,
    /// What of the tangential force on `j` is not viscous, world frame.
    pub frictional_force: Vector3<T>,
    /// Power that the viscous force takes up, >= 0, with the velocities that the force was computed with.
    pub viscous_power: T,
    /// Power that the rest of the tangential force takes up, with these velocities: stored in the tangential
    /// displacement, or dissipated by friction.
    pub tangential_power: T,
    /// Torque on `i` of the couple that resists rolling and twisting, without its viscous part, world frame; on `j` the opposite.
    pub frictional_couple: Vector3<T>,
    /// The viscous part of that torque, world frame.
    pub viscous_couple: Vector3<T>,
}

/// The relative curvature matrix `M`, half the sum of two Weingarten maps.
#[inline(always)]
pub fn relative_curvature_matrix<T: Real>(vi: Symmetric2<T>, vj: Symmetric2<T>) -> Symmetric2<T> {
    (vi + vj) * vi.uu.constant(0.5)
}

/// A vector in the frame of a contact, `u x v = n`.
#[derive(Clone, Copy)]
struct InFrame<T> {
    /// Components in the tangent basis.
    tangential: Vector2<T>,
    /// Component along the normal.
    normal: T,
}

impl<T: Real> InFrame<T> {
    #[inline(always)]
    fn none(zero: T) -> Self {
        InFrame {
            tangential: Vector2::new(zero, zero),
            normal: zero,
        }
    }
    #[inline(always)]
    fn of(w: Vector3<T>, x: &Contact<T>) -> Self {
        InFrame {
            tangential: x.tangent.components(w),
            normal: x.normal.dot(w),
        }
    }
    #[inline(always)]
    fn to_world(self, x: &Contact<T>) -> Vector3<T> {
        let t = self.tangential;
        x.normal
            .scale_add(self.normal, x.tangent.v.scale_add(t.v, x.tangent.u * t.u))
    }
    /// `b + self x a`.
    #[inline(always)]
    fn cross_add(self, a: Self, b: Self) -> Self {
        let (p, q, r) = (self.tangential, a.tangential, b.tangential);
        let u = p.v.multiply_add(a.normal, r.u);
        let v = self.normal.multiply_add(q.u, r.v);
        let normal = p.u.multiply_add(q.v, b.normal);
        InFrame {
            tangential: Vector2::new(
                self.normal.negative_multiply_add(q.v, u),
                p.u.negative_multiply_add(a.normal, v),
            ),
            normal: p.v.negative_multiply_add(q.u, normal),
        }
    }
    /// `b - self x a`.
    #[inline(always)]
    fn cross_subtract(self, a: Self, b: Self) -> Self {
        a.cross_add(self, b)
    }
    /// `self + s (direction, along)`.
    #[inline(always)]
    fn plus(self, s: T, (direction, along): (Vector2<T>, T)) -> Self {
        InFrame {
            tangential: direction.scale_add(s, self.tangential),
            normal: along.multiply_add(s, self.normal),
        }
    }
}

/// `a_u b_v - a_v b_u`: the normal component of the product of two tangential vectors.
#[inline(always)]
fn area<T: Real>(a: Vector2<T>, b: Vector2<T>) -> T {
    a.u.multiply_subtract(b.v, a.v * b.u)
}

/// `n x a` of a tangential vector.
#[inline(always)]
fn quarter_turn<T: Real>(a: Vector2<T>) -> Vector2<T> {
    Vector2::new(-a.v, a.u)
}

/// The motion of two bodies in the frame of their contact.
#[derive(Clone, Copy)]
struct Motion<T> {
    /// Velocity of the centre of `j` relative to that of `i`.
    relative: InFrame<T>,
    /// Angular velocities.
    omega_i: InFrame<T>,
    omega_j: InFrame<T>,
    /// Rate of penetration, positive while the bodies approach.
    rate: T,
}

impl<T: Real> Motion<T> {
    /// Of two bodies at rest, for a kernel that reads no velocities.
    #[inline(always)]
    fn none(zero: T) -> Self {
        let still = InFrame::none(zero);
        Motion {
            relative: still,
            omega_i: still,
            omega_j: still,
            rate: zero,
        }
    }

    /// At the half step.
    #[inline(always)]
    fn of<const WALL: bool>(x: &Contact<T>) -> Self {
        let relative = InFrame::of(x.j.velocity - x.i.velocity, x);
        let omega_i = InFrame::of(x.i.omega, x);
        let omega_j = if WALL {
            InFrame::none(x.penetration.constant(0.0))
        } else {
            InFrame::of(x.j.omega, x)
        };
        // Any point between the witnesses has the same velocity along n: they lie on one line along n.
        let approach = area(omega_i.tangential, x.i.witness) - relative.normal;
        let rate = if WALL {
            approach
        } else {
            approach + area(omega_j.tangential, x.j.witness)
        };
        Motion {
            relative,
            omega_i,
            omega_j,
            rate,
        }
    }

    /// Tangential velocity of `j` relative to `i` at the contact point.
    #[inline(always)]
    fn tangential_velocity<const WALL: bool>(
        &self,
        r_i: InFrame<T>,
        r_j: InFrame<T>,
    ) -> Vector2<T> {
        let mut relative = self.omega_i.cross_subtract(r_i, self.relative);
        if !WALL {
            relative = self.omega_j.cross_add(r_j, relative);
        }
        relative.tangential
    }
}

/// What the bodies feel, in the frame of the contact.
#[derive(Clone, Copy)]
struct Load<T> {
    /// Force on `j`.
    force: InFrame<T>,
    /// Torques about the centres; that on a wall stays zero.
    torque_i: InFrame<T>,
    torque_j: InFrame<T>,
}

impl<T: Real> Load<T> {
    /// A normal force, at the witnesses.
    #[inline(always)]
    fn along_normal<const WALL: bool>(x: &Contact<T>, force: T) -> Self {
        let zero = x.penetration.constant(0.0);
        Load {
            force: InFrame {
                tangential: Vector2::new(zero, zero),
                normal: force,
            },
            torque_i: InFrame {
                tangential: quarter_turn(x.i.witness) * force,
                normal: zero,
            },
            torque_j: if WALL {
                InFrame::none(zero)
            } else {
                InFrame {
                    tangential: quarter_turn(x.j.witness) * force,
                    normal: zero,
                }
            },
        }
    }

    /// Adds the terms by which force and torques are the complete gradient of the elastic energy.
    #[inline(always)]
    fn add_gradient<const WALL: bool>(
        &mut self,
        x: &Contact<T>,
        curvature: Symmetric2<T>,
        factors: &Factors<T>,
        elastic_energy: T,
    ) {
        let gradient = x.energy_gradient::<WALL>(curvature, factors);
        let minus = -elastic_energy;
        self.torque_i = self.torque_i.plus(minus, gradient.torque_i);
        if !WALL {
            self.force.tangential = gradient.lambda * minus;
            self.torque_j = self.torque_j.plus(minus, gradient.torque_j);
        }
    }

    /// Adds a tangential force at the contact point, `r_i` and `r_j` from the centres.
    #[inline(always)]
    fn add_tangential<const WALL: bool>(
        &mut self,
        force: Vector2<T>,
        r_i: InFrame<T>,
        r_j: InFrame<T>,
    ) {
        let one = r_i.normal.constant(1.0);
        // r x t of a tangential t.
        let turned = quarter_turn(force);
        let own_i = (turned * r_i.normal, area(r_i.tangential, force));
        self.torque_i = self.torque_i.plus(-one, own_i);
        if !WALL {
            let own_j = (turned * r_j.normal, area(r_j.tangential, force));
            self.torque_j = self.torque_j.plus(one, own_j);
        }
        self.force.tangential = self.force.tangential + force;
    }
}

/// How the contact turned within the step.
#[derive(Clone, Copy)]
struct Turn<T> {
    /// The normal of the last step.
    before: InFrame<T>,
    /// Half the turn of the pair about the normal, as the tangent of the angle.
    spin: T,
    /// The share of the turn that the half step is away: none where no time passes. The normal of the last step may then be that of
    /// another place, to which no velocity led.
    half: T,
}

impl<T: Real> Turn<T> {
    #[inline(always)]
    fn of(x: &Contact<T>, motion: &Motion<T>, remembered: &Remembered<T>) -> Self {
        // A turn beyond a few radians says no more than that the step is far too long; its tangent would outgrow the rest.
        let limit = x.penetration.constant(10.0);
        let spin = (motion.omega_i.normal + motion.omega_j.normal) * remembered.time * 0.5;
        let spin = spin.min(limit).max(-limit);
        let before = InFrame::of(remembered.normal, x);
        let zero = spin.constant(0.0);
        let half = T::select(zero.less(remembered.time), spin.constant(0.5), zero);
        Turn { before, spin, half }
    }

    /// Tangential velocity of `j` relative to `i` at the contact point, at the half step.
    ///
    /// The velocities are those that brought the bodies here from where they were a step ago: they belong to the half step.
    /// Normal and lever arms are turned back by half a step, or a rotation of the pair as a whole, and the normal approach,
    /// would leak into the tangential displacement (Vyas et al. 2024).
    #[inline(always)]
    fn velocity_at_half_step<const WALL: bool>(
        &self,
        motion: &Motion<T>,
        r_i: InFrame<T>,
        r_j: InFrame<T>,
    ) -> Vector2<T> {
        let half = self.half;
        let one = self.spin.constant(1.0);
        // Half of (before x n + spin n); the normal at the half step is (half_before, 1), of greater length than 1.
        let half_before = self.before.tangential * half;
        let half_turn = InFrame {
            tangential: Vector2::new(half_before.v, -half_before.u),
            normal: self.spin * half,
        };
        let turned_i = half_turn.cross_subtract(r_i, r_i);
        let mut relative = motion.omega_i.cross_subtract(turned_i, motion.relative);
        if !WALL {
            let turned_j = half_turn.cross_subtract(r_j, r_j);
            relative = motion.omega_j.cross_add(turned_j, relative);
        }
        let middle_square = half_before.dot(half_before) + one;
        let along =
            (half_before.dot(relative.tangential) + relative.normal) * middle_square.reciprocal();
        half_before.scale_add(-along, relative.tangential)
    }

    /// Angular velocity of `i` relative to `j` about the normal at the half step, which is turned back by half a step as above.
    #[inline(always)]
    fn twisting_at_half_step(&self, motion: &Motion<T>) -> T {
        let half_before = self.before.tangential * self.half;
        let half_turn = Vector2::new(half_before.v, half_before.u * self.spin.constant(-1.0));
        let (i, j) = (motion.omega_i, motion.omega_j);
        let across = i.tangential + j.tangential * self.spin.constant(-1.0);
        i.normal - j.normal + area(half_turn, across)
    }

    /// The tangential memory of the last step, in the present tangent basis: it turns with the normal and with the pair's spin
    /// about it, and keeps its length.
    #[inline(always)]
    fn carry(&self, x: &Contact<T>, memory: Vector3<T>) -> Vector2<T> {
        let one = self.spin.constant(1.0);
        // The least rotation from one normal to the other, exactly: anything less drifts with the step.
        let memory = InFrame::of(memory, x);
        let leaning = memory.normal / (self.before.normal + 1.0).max(one.constant(1e-12));
        let turned = self
            .before
            .tangential
            .scale_add(-leaning, memory.tangential);
        let turned = quarter_turn(turned).scale_add(self.spin, turned);
        // The rotation between the normals keeps the length; that about the normal, by the tangent of its angle, does not.
        let keep = self.spin.multiply_add(self.spin, one).reciprocal_sqrt();
        turned * keep
    }
}

/// The time of the step for which the bodies touched: a contact that began within it has slid only since then.
#[inline(always)]
fn time_in_contact<T: Real>(x: &Contact<T>, motion: &Motion<T>, remembered: &Remembered<T>) -> T {
    let zero = x.penetration.constant(0.0);
    // Few contacts are new in a step. Lanes that do not touch have a penetration of 1e-300: they would all look new.
    let new = T::select(remembered.continued, zero, x.penetration);
    if !zero.any(zero.constant(1e-290).less(new)) {
        return remembered.time;
    }
    let approach = motion.rate.max(x.penetration.constant(1e-300));
    let since = (x.penetration / approach).min(remembered.time);
    T::select(remembered.continued, remembered.time, since)
}

/// The contact point from the centre of `i`, for the share of the penetration that is of `i`.
#[inline(always)]
fn arm_of_contact_point<T: Real>(x: &Contact<T>, share: T) -> InFrame<T> {
    InFrame {
        tangential: x.i.witness,
        normal: x.i.h - share,
    }
}

/// The relative error that rounding leaves in the penetration, which is a small difference of lengths, and so in the normal force.
#[inline(always)]
fn rounding_of_penetration<T: Real, const WALL: bool>(x: &Contact<T>) -> T {
    let lengths = if WALL {
        x.i.h.abs()
    } else {
        x.i.h.abs() + x.j.h.abs()
    };
    // Some tens of roundings: of centres, of both support functions, and of the normal that the search found.
    lengths * 1e-14 / x.penetration
}

/// Springs of partial slip as a contact has them, world frame: of forces alone in lanes, or of forces and torques.
pub trait SpringBed<T: Real> {
    /// Whether they resist a twist.
    const TWISTS: bool;

    /// The springs of forces.
    fn springs(&mut self) -> &mut Springs<Vector3<T>, T>;

    /// Force of these in the tangent basis, `bed`, which is written; and their torque on `i` about the normal, what the twist makes of it and the
    /// viscous part. `turn` is the twist of the step, and the rate of it of which the viscous part is made.
    #[allow(clippy::too_many_arguments)]
    fn forces(
        &mut self,
        law: (&TangentialKinds, &TangentialConstants<T>),
        normal: (T, T, T),
        ellipse: (&Factors<T>, Symmetric2<T>, T),
        bed: &mut Springs<Vector2<T>, T>,
        remembered: (Vector2<T>, T, T::Mask),
        motion: [Vector2<T>; 2],
        turn: [T; 2],
    ) -> (TangentialForce<T>, Option<[T; 2]>);
}

impl<T: Real> SpringBed<T> for Springs<Vector3<T>, T> {
    const TWISTS: bool = false;

    #[inline(always)]
    fn springs(&mut self) -> &mut Springs<Vector3<T>, T> {
        self
    }

    #[inline(always)]
    fn forces(
        &mut self,
        (kinds, c): (&TangentialKinds, &TangentialConstants<T>),
        normal: (T, T, T),
        (factors, curvature, penetration): (&Factors<T>, Symmetric2<T>, T),
        bed: &mut Springs<Vector2<T>, T>,
        (memory, energy, passes): (Vector2<T>, T, T::Mask),
        [increment, velocity]: [Vector2<T>; 2],
        _: [T; 2],
    ) -> (TangentialForce<T>, Option<[T; 2]>) {
        let f = force_of_springs(
            kinds,
            c,
            normal,
            factors,
            curvature,
            penetration,
            bed,
            memory,
            energy,
            passes,
            increment,
            velocity,
        );
        (f, None)
    }
}

/// None, of a kernel that has no room for them: what would work on them is not compiled.
pub(crate) enum NoBed {}

impl<T: Real> SpringBed<T> for NoBed {
    const TWISTS: bool = false;

    #[inline(always)]
    fn springs(&mut self) -> &mut Springs<Vector3<T>, T> {
        match *self {}
    }

    #[inline(always)]
    fn forces(
        &mut self,
        _: (&TangentialKinds, &TangentialConstants<T>),
        _: (T, T, T),
        _: (&Factors<T>, Symmetric2<T>, T),
        _: &mut Springs<Vector2<T>, T>,
        _: (Vector2<T>, T, T::Mask),
        _: [Vector2<T>; 2],
        _: [T; 2],
    ) -> (TangentialForce<T>, Option<[T; 2]>) {
        match *self {}
    }
}

/// Springs that hold torques too, of `twisting lubkin`.
pub(crate) struct TwistedSprings<'a> {
    /// Their forces.
    pub springs: &'a mut Springs<Vector3>,
    /// Their torques.
    pub torques: &'a mut [f64; SPRINGS],
}

impl SpringBed<f64> for TwistedSprings<'_> {
    const TWISTS: bool = true;

    fn springs(&mut self) -> &mut Springs<Vector3> {
        self.springs
    }

    fn forces(
        &mut self,
        (kinds, c): (&TangentialKinds, &TangentialConstants),
        normal: (f64, f64, f64),
        (factors, curvature, penetration): (&Factors, Symmetric2, f64),
        bed: &mut Springs<Vector2>,
        (memory, energy, passes): (Vector2, f64, bool),
        [increment, velocity]: [Vector2; 2],
        [turn, turning]: [f64; 2],
    ) -> (TangentialForce, Option<[f64; 2]>) {
        let (f, torque) = force_and_torque_of_springs(
            kinds,
            c,
            normal,
            factors,
            curvature,
            penetration,
            bed,
            self.torques,
            memory,
            energy,
            passes,
            increment,
            velocity,
            turn,
            turning,
        );
        (f, Some([torque.elastic, torque.viscous]))
    }
}

/// The law of one contact, in the frame of its tangent basis and normal: there most products with the normal and with
/// the witnesses have no terms at all.
///
/// `FRICTION`, `RATE` and `CONSERVATIVE` say which terms the kernel has at all; `kinds` decides within them. `RATE`
/// must be on where velocities are needed: any damping, friction, or powers asked for. `WALL` takes `j` as a
/// half-space. `springs` are those that are remembered of `displacement hysteretic`, world frame, zeros where the contact begins;
/// written. `None` where no law of the scene has such. With `twisting lubkin` the couples of the result are the torques of these springs about
/// the normal, which are not in the torques.
#[inline(always)]
pub fn contact_forces<
    T: Real,
    B: SpringBed<T>,
    const FRICTION: bool,
    const RATE: bool,
    const CONSERVATIVE: bool,
    const WALL: bool,
>(
    kinds: &LawKinds,
    c: &LawConstants<T>,
    factors: &Factors<T>,
    curvature: Symmetric2<T>,
    x: &Contact<T>,
    remembered: &Remembered<T>,
    springs: Option<&mut B>,
) -> ContactForces<T> {
    let zero = x.penetration.constant(0.0);
    let motion = if RATE {
        Motion::of::<WALL>(x)
    } else {
        Motion::none(zero)
    };
    // Of the velocity of j relative to i at the contact point.
    let change = match &x.change {
        Some(change) if RATE => {
            let arm = arm_of_contact_point(x, x.penetration * c.share_i).to_world(x);
            InFrame::of(change.at(arm), x)
        }
        _ => InFrame::none(zero),
    };
    let rate = motion.rate - change.normal;
    let viscous_rate = match x.begin_time {
        // By the rate at the step, which is the same where a run goes on from it.
        Some(time) => rate * begin_factor(kinds.normal.begin(), x.penetration, rate, time),
        None => rate,
    };
    let ForceWithMemory {
        normal,
        rests,
        relaxed,
    } = match remembered.rests {
        Some(rests) if kinds.normal.memory > 0 => {
            let time = time_in_contact(x, &motion, remembered);
            let before = motion.rate.negative_multiply_add(time, x.penetration);
            let approach = Approach {
                penetration: x.penetration,
                before: T::select(remembered.continued, before.max(zero), zero),
                time,
                rate: viscous_rate,
            };
            normal_force_with_memory(
                kinds.normal.memory as usize,
                &c.normal,
                &c.memory,
                &approach,
                rests,
                curvature.determinant(),
                factors,
            )
        }
        rests => ForceWithMemory {
            normal: normal_force(
                &kinds.normal,
                &c.normal,
                x.penetration,
                viscous_rate,
                curvature.determinant(),
                factors,
                x.effective_mass,
            ),
            rests: rests.unwrap_or([zero; MOST_PARTS]),
            relaxed: zero,
        },
    };

    // The contact point from either centre; from that of j, its tangential part is minus the witness.
    let share = x.penetration * c.share_i;
    let r_i = arm_of_contact_point(x, share);
    let r_j = InFrame {
        tangential: x.j.witness * -zero.constant(1.0),
        normal: x.penetration - share - x.j.h,
    };

    let mut load = Load::along_normal::<WALL>(x, normal.force);
    if CONSERVATIVE && kinds.conservative {
        load.add_gradient::<WALL>(x, curvature, factors, normal.elastic_energy);
    }

    let null = Vector3::new(zero, zero, zero);
    let mut result = ContactForces {
        force: null,
        torque_i: null,
        torque_j: null,
        normal_force: normal.force,
        tangential_force: null,
        contact_point: r_i.to_world(x),
        memory: null,
        rests,
        relaxed_energy: relaxed,
        displacement: null,
        stiffness: normal.stiffness,
        rate,
        elastic_energy: normal.elastic_energy,
        tangential_energy: zero,
        viscous_force: x.normal * (normal.force - normal.elastic),
        frictional_force: null,
        viscous_power: (normal.force - normal.elastic) * rate,
        tangential_power: zero,
        frictional_couple: null,
        viscous_couple: null,
    };

    if FRICTION && kinds.tangential.any() {
        let turn = Turn::of(x, &motion, remembered);
        let velocity = turn.velocity_at_half_step::<WALL>(&motion, r_i, r_j);
        let velocity_at_step = if x.change.is_some() {
            motion.tangential_velocity::<WALL>(r_i, r_j) + change.tangential
        } else {
            velocity
        };
        let time = time_in_contact(x, &motion, remembered);
        let mut increment = velocity * time;
        if x.begin_time.is_some() {
            let way = motion.rate * time;
            increment = increment * kinds.tangential.mean_stiffness(x.penetration, way);
        }
        let velocity_of_viscous = match x.begin_time {
            Some(time) => {
                let begin = kinds.tangential.begin();
                velocity_at_step * begin_factor(begin, x.penetration, rate, time)
            }
            None => velocity_at_step,
        };
        // A run that starts evaluates its first forces with no time passing, perhaps with other velocities than the
        // step before.
        let passes = zero.less(remembered.time);
        let stands = T::select(passes, zero, zero.constant(1.0));
        let rounding = if zero.any(zero.less(stands)) {
            rounding_of_penetration::<T, WALL>(x)
        } else {
            zero
        };
        let of_normal = (normal.force, normal.stiffness, rounding);
        let memory = turn.carry(x, remembered.memory);
        let t: TangentialForce<T> = match springs {
            Some(held) if kinds.tangential.has_springs() => {
                let springs = held.springs();
                let mut bed = Springs {
                    forces: [memory; SPRINGS],
                    reference: springs.reference,
                    penetration: springs.penetration,
                };
                for (carried, force) in bed.forces.iter_mut().zip(&springs.forces) {
                    *carried = turn.carry(x, *force);
                }
                let turn = if B::TWISTS {
                    let twisting = turn.twisting_at_half_step(&motion);
                    let at_step = match &x.change {
                        Some(change) => {
                            motion.omega_i.normal
                                - motion.omega_j.normal
                                - x.normal.dot(change.omega)
                        }
                        None => twisting,
                    };
                    [twisting * time, at_step]
                } else {
                    [zero; 2]
                };
                let (t, torque) = held.forces(
                    (&kinds.tangential, &c.tangential),
                    of_normal,
                    (factors, curvature, x.penetration),
                    &mut bed,
                    (memory, remembered.energy, passes),
                    [increment, velocity_of_viscous],
                    turn,
                );
                if let Some([elastic, viscous]) = torque {
                    result.frictional_couple = x.normal * elastic;
                    result.viscous_couple = x.normal * viscous;
                }
                let springs = held.springs();
                for (force, carried) in springs.forces.iter_mut().zip(&bed.forces) {
                    *force = x.tangent.vector(*carried);
                }
                springs.reference = bed.reference;
                springs.penetration = bed.penetration;
                t
            }
            _ => tangential_force(
                &kinds.tangential,
                &c.tangential,
                of_normal,
                factors,
                curvature,
                memory,
                remembered.energy,
                passes,
                increment,
                velocity_of_viscous,
            ),
        };
        load.add_tangential::<WALL>(t.force, r_i, r_j);
        result.tangential_force = x.tangent.vector(t.force);
        result.memory = x.tangent.vector(t.memory);
        result.displacement = x.tangent.vector(t.displacement);
        result.tangential_energy = t.elastic_energy;
        let viscous = t.force - t.elastic_force;
        result.viscous_force = result.viscous_force + x.tangent.vector(viscous);
        result.frictional_force = x.tangent.vector(t.elastic_force);
        result.viscous_power = result.viscous_power - viscous.dot(velocity_at_step);
        result.tangential_power = -(t.elastic_force.dot(velocity));
    }
    result.force = load.force.to_world(x);
    result.torque_i = load.torque_i.to_world(x);
    if !WALL {
        result.torque_j = load.torque_j.to_world(x);
    }
    result
}
