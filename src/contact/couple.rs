// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which couple resists the rolling and twisting of one touching pair, once its forces are known (docs/theory.md, section 5.1).

use super::forces::{Contact, ContactForces, MotionChange};
use super::history::{HistoryLayout, Step};
use crate::force::hertz_factors;
use crate::force::{
    rolling_force, twisting_torque, PairLaw, RollingResistance, TwistSpring, TwistingResistance,
};
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// A touching pair as far as rolling and twisting go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TurningContact {
    /// Unit normal from `i` to `j`.
    pub normal: Vector3,
    /// Its tangent basis.
    pub tangent: Tangent,
    /// The relative curvature matrix `M`, half of the sum of the two bodies'.
    pub curvature: Symmetric2,
    /// Penetration > 0, and its rate at the half step, positive while the bodies approach.
    pub penetration: f64,
    pub rate: f64,
    /// Normal force, and normal stiffness.
    pub normal_force: f64,
    pub stiffness: f64,
    /// Angular velocities of `i` and `j` at the half step, world frame.
    pub omega: [Vector3; 2],
    /// What the angular velocity of `j` relative to `i` has more at the step.
    pub omega_change: Vector3,
    /// Torque on `i` about the normal that springs of partial slip make: what the twist makes of it, and the viscous part.
    pub torque_of_springs: [f64; 2],
}

impl TurningContact {
    /// Of a contact and its forces; `curvature` is that which the law read.
    pub fn of(x: &Contact, curvature: Symmetric2, f: &ContactForces) -> Self {
        TurningContact {
            normal: x.normal,
            tangent: x.tangent,
            curvature,
            penetration: x.penetration,
            rate: approach(
                x.normal,
                [f.contact_point, f.contact_point - x.between_centres()],
                [x.i.velocity, x.j.velocity],
                [x.i.omega, x.j.omega],
            ),
            normal_force: f.normal_force,
            stiffness: f.stiffness,
            omega: [x.i.omega, x.j.omega],
            omega_change: x.change.unwrap_or(MotionChange::NONE).omega,
            torque_of_springs: [f.frictional_couple, f.viscous_couple].map(|c| c.dot(x.normal)),
        }
    }

    /// Rolling velocity for a relative angular velocity, in the tangent basis: that of the contact over the surfaces.
    fn rolling_velocity(&self, inverse: Symmetric2, omega: Vector3) -> Vector2 {
        let w = self.tangent.components(omega);
        inverse.apply(Vector2::new(w.v, -w.u))
    }

    /// The torque on `i` of a force that resists rolling.
    fn rolling_torque(&self, inverse: Symmetric2, force: Vector2) -> Vector3 {
        let f = inverse.apply(force);
        self.tangent.vector(Vector2::new(-f.v, f.u))
    }
}

/// The rate of penetration, of `i` and `j`: `arms` lead from the centres to the contact point. A wall has its velocity there, and no
/// angular velocity.
pub(crate) fn approach(
    n: Vector3,
    arms: [Vector3; 2],
    velocities: [Vector3; 2],
    omega: [Vector3; 2],
) -> f64 {
    let along = |k: usize| n.dot(velocities[k] + omega[k].cross(arms[k]));
    along(0) - along(1)
}

/// Springs and dashpots of a contact against a relative rotation, in its frame: stiffness and damping, tangential part and about the
/// normal. Without slip; torque over angle, and over angular velocity.
pub(crate) struct TurningSprings {
    pub stiffness: (Symmetric2, f64),
    pub damping: (Symmetric2, f64),
}

impl TurningSprings {
    /// Of a contact of bodies at rest with this normal stiffness; `None` where nothing resists.
    pub fn of(
        law: &PairLaw,
        x: &Contact,
        curvature: Symmetric2,
        normal_stiffness: f64,
    ) -> Option<Self> {
        if !law.resistance.any() {
            return None;
        }
        let [rolling_stiffness, rolling_damping] = match law.resistance.rolling {
            RollingResistance::None => [0.0; 2],
            RollingResistance::Given(c) => [c.stiffness, c.damping],
        };
        let twist = twist_spring(law, x.penetration, normal_stiffness, curvature);
        let inverse = curvature.adjugate() * (0.5 / curvature.determinant());
        let square = Symmetric2::new(
            inverse.uu * inverse.uu + inverse.uv * inverse.uv,
            inverse.uv * (inverse.uu + inverse.vv),
            inverse.vv * inverse.vv + inverse.uv * inverse.uv,
        );
        // Between a quarter turn and its reverse.
        let rolling = square.adjugate();
        Some(TurningSprings {
            stiffness: (
                rolling * rolling_stiffness,
                twist.map_or(0.0, |t| t.stiffness),
            ),
            damping: (rolling * rolling_damping, twist.map_or(0.0, |t| t.damping)),
        })
    }
}

/// What resists the twist, for `marshall` and `lubkin` from the present contact ellipse.
fn twist_spring(
    law: &PairLaw,
    penetration: f64,
    normal_stiffness: f64,
    curvature: Symmetric2,
) -> Option<TwistSpring> {
    match law.resistance.twisting {
        TwistingResistance::None => return None,
        TwistingResistance::Given(spring) => return Some(spring),
        TwistingResistance::OfContactEllipse | TwistingResistance::OfSprings => {}
    }
    // Hale's form has no ellipse of its own, and a law without curvatures has no factors.
    let m = curvature;
    let factors = hertz_factors::exact(m.trace(), m.determinant(), true);
    let (kinds, c) = (&law.kinds.tangential, &law.constants.tangential);
    Some(
        if law.resistance.twisting == TwistingResistance::OfSprings {
            TwistSpring::of_elastic_bodies(c, penetration, normal_stiffness, &factors, m)
        } else {
            TwistSpring::of_contact_ellipse(kinds, c, penetration, normal_stiffness, &factors, m)
        },
    )
}

/// The couple of a contact: torques, the opposite ones on `j`, and no force.
#[derive(Clone, Copy, Debug)]
pub struct Couple {
    /// Torque on `i` that the way of rolling and the twist make, world frame.
    pub elastic: Vector3,
    /// Viscous torque on `i`, world frame.
    pub viscous: Vector3,
    /// Elastic energy of way and twist.
    pub energy: f64,
    /// Power that the elastic torque takes up: stored, or dissipated by the sliders.
    pub elastic_power: f64,
    /// Power that the viscous torque takes up.
    pub viscous_power: f64,
}

impl Couple {
    /// No couple.
    pub const NONE: Couple = Couple {
        elastic: Vector3::ZERO,
        viscous: Vector3::ZERO,
        energy: 0.0,
        elastic_power: 0.0,
        viscous_power: 0.0,
    };

    /// All of the torque on `i`.
    pub fn torque(&self) -> Vector3 {
        self.elastic + self.viscous
    }

    /// Times the share of a surface.
    pub fn times(&self, share: f64) -> Couple {
        Couple {
            elastic: self.elastic * share,
            viscous: self.viscous * share,
            energy: self.energy * share,
            elastic_power: self.elastic_power * share,
            viscous_power: self.viscous_power * share,
        }
    }

    /// Adds the couple to the torques, energies and powers of the contact of two bodies.
    pub fn add_to(&self, f: &mut ContactForces) {
        self.add_to_first(f);
        f.torque_j = f.torque_j - self.torque();
    }

    /// The same of a body and a wall, whose torque is not asked for.
    pub fn add_to_first(&self, f: &mut ContactForces) {
        f.torque_i = f.torque_i + self.torque();
        f.frictional_couple = self.elastic;
        f.viscous_couple = self.viscous;
        f.tangential_energy += self.energy;
        f.tangential_power += self.elastic_power;
        f.viscous_power += self.viscous_power;
    }
}

/// The couple of a contact, from what is remembered of it to what is to be remembered. `touched` says whether it touched at the
/// last step, `before` which normal it had then.
///
/// Normal and angular velocities are taken at the half step, and turned with the pair to where it is now, as those of the tangential
/// displacement are.
pub(crate) fn couple(
    law: &PairLaw,
    c: &TurningContact,
    layout: &HistoryLayout,
    history: &mut [f64],
    touched: bool,
    before: Vector3,
    step: &Step,
) -> Couple {
    let n = c.normal;
    let elapsed = step.elapsed();
    let passes = elapsed > 0.0;
    // A contact that began within this step rolled only since then.
    let since = (c.penetration / c.rate.max(1e-300)).min(elapsed);
    let time = if touched { elapsed } else { since };
    let before = if touched && before.is_unit() {
        before
    } else {
        n
    };
    let [wi, wj] = c.omega;
    let relative = wi - wj;
    // As in the tangential memory: the tangent of half the turn of the two about the normal.
    let spin = (0.5 * elapsed * (wi + wj).dot(n)).clamp(-10.0, 10.0);
    // Where no time passes the normal of the last step may be that of another place, to which no velocity led.
    let half = if passes { 0.5 } else { 0.0 };
    let half_turn = (before.cross(n) + n * spin) * half;
    let at_half_step = relative + half_turn.cross(relative);
    let at_step = if c.omega_change.norm_squared() > 0.0 {
        relative - c.omega_change
    } else {
        at_half_step
    };

    let mut result = Couple::NONE;
    if let (RollingResistance::Given(constants), Some(at)) =
        (&law.resistance.rolling, layout.rolling)
    {
        let inverse = c.curvature.adjugate() * (0.5 / c.curvature.determinant());
        let velocity = c.rolling_velocity(inverse, at_half_step);
        let velocity_at_step = c.rolling_velocity(inverse, at_step);
        let way = if touched {
            let way = Vector3::new(history[at], history[at + 1], history[at + 2]);
            carried(way, before, n, spin)
        } else {
            Vector3::ZERO
        };
        let r = rolling_force(
            constants,
            c.normal_force,
            c.tangent.components(way),
            velocity * time,
            velocity_at_step,
            passes,
        );
        let viscous = r.force - r.elastic;
        result.elastic = c.rolling_torque(inverse, r.elastic);
        result.viscous = c.rolling_torque(inverse, viscous);
        result.energy = r.energy;
        result.elastic_power = -r.elastic.dot(velocity);
        result.viscous_power = -viscous.dot(velocity_at_step);
        history[at..at + 3].copy_from_slice(&c.tangent.vector(r.way).to_array());
    }
    if law.resistance.twisting == TwistingResistance::OfSprings {
        // Its energy is in that of the tangential force, with which it was computed.
        let [elastic, viscous] = c.torque_of_springs;
        result.elastic = result.elastic + n * elastic;
        result.viscous = result.viscous + n * viscous;
        result.elastic_power -= elastic * at_half_step.dot(n);
        result.viscous_power -= viscous * at_step.dot(n);
        return result;
    }
    let spring = twist_spring(law, c.penetration, c.stiffness, c.curvature);
    if let (Some(spring), Some(at)) = (spring, layout.twisting) {
        let held = if touched {
            [history[at], history[at + 1]]
        } else {
            [0.0; 2]
        };
        let (velocity, velocity_at_step) = (at_half_step.dot(n), at_step.dot(n));
        let t = twisting_torque(
            &spring,
            c.normal_force,
            held,
            velocity * time,
            velocity_at_step,
            passes,
        );
        let viscous = t.torque - t.elastic;
        result.elastic = result.elastic + n * t.elastic;
        result.viscous = result.viscous + n * viscous;
        result.energy += t.energy;
        result.elastic_power -= t.elastic * velocity;
        result.viscous_power -= viscous * velocity_at_step;
        history[at..at + 2].copy_from_slice(&t.held);
    }
    result
}

/// A tangential vector of the last step, turned with the normal and with the pair's spin about it.
fn carried(v: Vector3, before: Vector3, n: Vector3, spin: f64) -> Vector3 {
    let leaning = v.dot(n) / (before.dot(n) + 1.0).max(1e-12);
    let turned = v - (before + n) * leaning;
    (turned + n.cross(turned) * spin) * (1.0 / (1.0 + spin * spin).sqrt())
}
