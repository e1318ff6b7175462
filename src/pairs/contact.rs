// SPDX-License-Identifier: MIT OR Apache-2.0
//! Force and torques of one touching pair, once its geometry is known: the law put together, in lanes.

use crate::force::conservative::{
    additional_torque, body_gradient, curvature_gradient, normal_response, BodyAtContact,
    NormalResponse,
};
use crate::force::{
    normal_force, tangential_force, Factors, LawConstants, LawKinds, Tangential, TangentialForce,
};
use crate::geometry::{Symmetric2, Tangent, Vector2, Vector3};
use crate::real::Real;

/// A touching pair: geometry and motion.
#[derive(Clone, Copy, Debug)]
pub struct Contact<T: Real = f64> {
    /// Unit normal from `i` to `j`.
    pub normal: Vector3<T>,
    /// Its tangent basis.
    pub tangent: Tangent<T>,
    /// Penetration > 0.
    pub penetration: T,
    /// Centre of `j` less centre of `i`; unused for a wall.
    pub d: Vector3<T>,
    /// Support function and witness of `i` (from its centre), and its Weingarten map.
    pub h_i: T,
    /// `1/h_i`.
    pub inverse_h_i: T,
    /// Witness of `i` from its centre.
    pub s_i: Vector3<T>,
    /// Weingarten map of `i` in the tangent basis.
    pub weingarten_i: Symmetric2<T>,
    /// `(a1 a2 a3)^2` of `i`.
    pub determinant_i: T,
    /// The same of `j`, for the same `n`: its witness from its centre is `-s_j`. Unused for a wall.
    pub h_j: T,
    /// `1/h_j`.
    pub inverse_h_j: T,
    /// Minus the witness of `j` from its centre.
    pub s_j: Vector3<T>,
    /// Weingarten map of `j` in the tangent basis; zero for a wall.
    pub weingarten_j: Symmetric2<T>,
    /// `(a1 a2 a3)^2` of `j`.
    pub determinant_j: T,
    /// Velocity of the centre of `i`.
    pub velocity_i: Vector3<T>,
    /// Velocity of the centre of `j`, or of the wall at the contact.
    pub velocity_j: Vector3<T>,
    /// Angular velocity of `i`, world frame.
    pub omega_i: Vector3<T>,
    /// Angular velocity of `j`, world frame.
    pub omega_j: Vector3<T>,
    /// Effective mass `m_i m_j/(m_i + m_j)`.
    pub effective_mass: T,
    /// `(W_i + W_j - delta I)^-1`, where it is known and the contact is less than half as deep as the smallest radius of
    /// curvature.
    pub inverse_hessian: Option<Symmetric2<T>>,
}

/// What is remembered of the pair.
#[derive(Clone, Copy, Debug)]
pub struct Remembered<T: Real = f64> {
    /// Whether the pair touched at the last step too.
    pub continued: T::Mask,
    /// The normal at the last step (that of now where it is not known).
    pub normal: Vector3<T>,
    /// Tangential memory, world frame.
    pub memory: Vector3<T>,
    /// Normal stiffness at the last step.
    pub stiffness: T,
    /// Time over which the memory advances: 0 in the set-up of a run.
    pub time: T,
}

/// Force, torques and what is to be remembered.
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
    /// Tangential memory, world frame.
    pub memory: Vector3<T>,
    /// Tangential displacement, world frame.
    pub displacement: Vector3<T>,
    /// Normal stiffness, to be remembered.
    pub stiffness: T,
    /// Rate of penetration, positive while the bodies approach.
    pub rate: T,
    /// Elastic energy of the normal deformation.
    pub elastic_energy: T,
    /// Elastic energy of the tangential deformation.
    pub tangential_energy: T,
    /// Power of the viscous part of the normal force, >= 0 when it dissipates.
    pub viscous_power: T,
    /// Power put into the contact by the tangential force.
    pub tangential_power: T,
}

/// Trace and determinant of the relative curvature matrix `M`, and `M`.
#[inline(always)]
pub fn relative_curvature_matrix<T: Real>(vi: Symmetric2<T>, vj: Symmetric2<T>) -> Symmetric2<T> {
    (vi + vj) * vi.uu.constant(0.5)
}

/// The law of one contact.
///
/// `FRICTION`, `RATE` and `CONSERVATIVE` say which terms the kernel has at all; `kinds` decides within them. `RATE`
/// must be on where velocities are needed: any damping, friction, or powers asked for. `WALL` takes `j` as a
/// half-space.
#[inline(always)]
pub fn contact_forces<
    T: Real,
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
) -> ContactForces<T> {
    let zero = x.penetration.constant(0.0);
    let one = x.penetration.constant(1.0);
    let n = x.normal;
    let null = Vector3::new(zero, zero, zero);

    // Any point between the witnesses has the same velocity along n: they lie on one line along n.
    let rate = if RATE {
        let point_i = x.velocity_i + x.omega_i.cross(x.s_i);
        let point_j = if WALL {
            x.velocity_j
        } else {
            x.velocity_j - x.omega_j.cross(x.s_j)
        };
        n.dot(point_i - point_j)
    } else {
        zero
    };

    let determinant = curvature.determinant();
    let normal = normal_force(
        kinds,
        c,
        x.penetration,
        rate,
        determinant,
        factors,
        x.effective_mass,
    );

    let r_i = n.scale_add(-(x.penetration * c.share_i), x.s_i);
    let r_j = if WALL { null } else { r_i - x.d };

    let mut force = n * normal.force;
    let mut torque_i = n.cross(x.s_i) * normal.force;
    let mut torque_j = if WALL {
        null
    } else {
        n.cross(x.s_j) * normal.force
    };

    if CONSERVATIVE && kinds.conservative {
        let p = curvature_gradient(curvature, factors);
        let body_i = body_at_contact(
            &x.tangent,
            x.h_i,
            x.inverse_h_i,
            x.s_i,
            x.weingarten_i,
            x.determinant_i,
        );
        let gradient_i = body_gradient(p, &body_i);
        let energy = normal.elastic_energy;
        if WALL {
            // The wall holds the normal where it is.
            let held = NormalResponse::exactly(Vector2::new(zero, zero));
            let own = additional_torque(&body_i, &gradient_i, &held);
            torque_i = world_vector(&x.tangent, n, own).scale_add(-energy, torque_i);
        } else {
            let body_j = body_at_contact(
                &x.tangent,
                x.h_j,
                x.inverse_h_j,
                x.s_j,
                x.weingarten_j,
                x.determinant_j,
            );
            let gradient_j = body_gradient(p, &body_j);
            let gamma = gradient_i.gamma + gradient_j.gamma;
            let response = match x.inverse_hessian {
                Some(inverse) => NormalResponse::exactly(inverse.apply(gamma)),
                None => normal_response(
                    body_i.inverse_weingarten + body_j.inverse_weingarten,
                    x.penetration,
                    gamma,
                ),
            };
            let minus = -energy;
            force = x.tangent.vector(response.lambda).scale_add(minus, force);
            let own_i = additional_torque(&body_i, &gradient_i, &response);
            let own_j = additional_torque(&body_j, &gradient_j, &response);
            torque_i = world_vector(&x.tangent, n, own_i).scale_add(minus, torque_i);
            torque_j = world_vector(&x.tangent, n, own_j).scale_add(minus, torque_j);
        }
    }

    let mut result = ContactForces {
        force,
        torque_i,
        torque_j,
        normal_force: normal.force,
        tangential_force: null,
        contact_point: r_i,
        memory: null,
        displacement: null,
        stiffness: normal.stiffness,
        rate,
        elastic_energy: normal.elastic_energy,
        tangential_energy: zero,
        viscous_power: (normal.force - normal.elastic) * rate,
        tangential_power: zero,
    };

    if FRICTION && !matches!(kinds.tangential, Tangential::None) {
        // The velocities are those that brought the bodies here from where they were a step ago: they belong to the
        // half step. Normal and lever arms are turned back by half a step, or a rotation of the pair as a whole, and
        // the normal approach, would leak into the tangential displacement (Vyas et al. 2024).
        let spin = n.dot(x.omega_i + x.omega_j) * remembered.time * 0.5;
        let tilt = remembered.normal.cross(n);
        let half_turn = n.scale_add(spin, tilt) * zero.constant(0.5);
        let middle = n - half_turn.cross(n);
        let arm_i = r_i - half_turn.cross(r_i);
        let mut relative = x.velocity_j - x.velocity_i - x.omega_i.cross(arm_i);
        if !WALL {
            let arm_j = r_j - half_turn.cross(r_j);
            relative = relative + x.omega_j.cross(arm_j);
        }
        let middle_square = middle.norm_squared();
        let along = middle.dot(relative) * middle_square.reciprocal();
        let tangential = middle.scale_add(-along, relative);
        let velocity = x.tangent.components(tangential);
        // A contact that began within this step slid only since then.
        let since = (x.penetration / rate.max(zero.constant(1e-300))).min(remembered.time);
        let time = T::select(remembered.continued, remembered.time, since);

        // The memory turns with the normal and with the pair's spin about it, and keeps its length.
        // The least rotation from one normal to the other, exactly: anything less drifts with the step.
        let before = remembered.normal;
        let leaning = n.dot(remembered.memory) / (before.dot(n) + 1.0).max(zero.constant(1e-12));
        let turned = (before + n).scale_add(-leaning, remembered.memory);
        let turned = n.cross(turned).scale_add(spin, turned);
        let memory = x.tangent.components(turned);
        let old = remembered.memory.norm_squared();
        let new = memory.dot(memory);
        let keep = T::select(
            zero.constant(1e-290).less(new),
            (old / new.max(zero.constant(1e-290))).sqrt(),
            one,
        );
        let t: TangentialForce<T> = tangential_force(
            kinds,
            c,
            &normal,
            factors,
            curvature,
            memory * keep,
            remembered.stiffness,
            velocity * time,
            velocity,
        );
        let on_j = x.tangent.vector(t.force);
        result.tangential_force = on_j;
        result.force = result.force + on_j;
        result.torque_i = result.torque_i - r_i.cross(on_j);
        if !WALL {
            result.torque_j = result.torque_j + r_j.cross(on_j);
        }
        result.memory = x.tangent.vector(t.memory);
        result.displacement = x.tangent.vector(t.displacement);
        result.stiffness = t.stiffness;
        result.tangential_energy = t.elastic_energy;
        result.tangential_power = -(t.force.dot(velocity));
    }
    result
}

/// What the conservative law needs of a body, in the tangent basis. A function, not a closure: a closure is not always
/// inlined into the code of the chosen instruction set, and then costs a call per operation.
#[inline(always)]
fn body_at_contact<T: Real>(
    tangent: &Tangent<T>,
    h: T,
    inverse_h: T,
    s: Vector3<T>,
    weingarten: Symmetric2<T>,
    determinant: T,
) -> BodyAtContact<T> {
    let square = inverse_h * inverse_h;
    BodyAtContact {
        h,
        inverse_h,
        witness: tangent.components(s),
        weingarten,
        inverse_weingarten: weingarten.adjugate() * (determinant * (square * square)),
    }
}

/// The world vector with these components along the tangent basis and the normal.
#[inline(always)]
fn world_vector<T: Real>(
    tangent: &Tangent<T>,
    n: Vector3<T>,
    (t, along): (Vector2<T>, T),
) -> Vector3<T> {
    n.scale_add(along, tangent.vector(t))
}
