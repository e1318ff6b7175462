// SPDX-License-Identifier: MIT OR Apache-2.0
//! One contact in stages - geometry, normal force, tangential force - for engines that keep the three apart and let a
//! user combine them. The same functions as in one call, so that both give the same numbers.
//!
//! # Example
//! ```
//! use ellgran::contact::staged::{StagedContact, StagedHistory, WallSurface};
//! use ellgran::contact::{prepare_body, Body, Laws, Step};
//! use ellgran::geometry::facet_shares::Share;
//! use ellgran::vector::Vector3;
//!
//! let words = ["hertz", "1e7", "0.3", "tangential", "mindlin", "0.5"];
//! let (parameters, _) = ellgran::force::syntax::parse(&words)?;
//! let laws = Laws::new(1, &[Some(parameters)], true)?;
//! let law = laws.get(1, 1);
//! let ball = |z: f64| Body {
//!     position: [0.0, 0.0, z],
//!     quaternion: [1.0, 0.0, 0.0, 0.0],
//!     semi_axes: [1e-3; 3],
//!     velocity: [0.0; 3],
//!     angular_velocity: [0.0; 3],
//!     mass: 1e-5,
//!     particle_type: 1,
//!     identifier: 1,
//! };
//! let lower = prepare_body(&ball(0.0), Some(1))?;
//! let upper = prepare_body(&ball(1.99e-3), Some(1))?;
//! let (mut normal, mut found) = (Vector3::ZERO, None);
//! StagedContact::of_pair(&lower, &upper, &mut normal, &mut found);
//! let contact = found.expect("they touch");
//! assert!(!contact.is_wall() && (contact.penetration() - 1e-5).abs() < 1e-15);
//! assert!((contact.normal() - normal).norm() < 1e-15);
//! assert!((contact.contact_point(Vector3::ZERO, 0.5).z - 0.995e-3).abs() < 1e-15);
//! // R* = R/2; the circle in which the spheres intersect has the area 2 pi R* delta.
//! let radius = contact.equivalent_radius();
//! assert!((radius - 0.5e-3).abs() < 1e-12);
//! assert!((contact.section_area() / (2.0 * core::f64::consts::PI * radius * 1e-5) - 1.0).abs() < 1e-9);
//! // For laws of spheres: 4/3 E* sqrt(R delta), 8 G* sqrt(R delta).
//! let [in_normal, tangential] = contact.circular_stiffness(law);
//! let a = (radius * 1e-5).sqrt();
//! assert!((in_normal / (4.0 / 3.0 * law.effective_modulus() * a) - 1.0).abs() < 1e-9);
//! assert!((tangential / (8.0 * law.effective_shear_modulus() * a) - 1.0).abs() < 1e-9);
//! let step = Step { time_step: 1e-6, advance_history: true };
//! let alone = contact.normal_force(law, 0.5e-5, step.time_step).expect("exact factors");
//! assert!((alone.normal_force / (in_normal * 1e-5) - 1.0).abs() < 1e-9);
//! let new = || StagedHistory { touched: false, normal, memory: Vector3::ZERO, energy: 0.0, rests: [0.0; 3], springs: None, torques: None };
//! let both = contact.whole_force(law, 0.5, 0.5e-5, &step, &mut new()).expect("exact factors");
//! let sheared = contact.tangential_force(law, 0.5, 0.5e-5, &step, &mut new()).expect("exact factors");
//! assert_eq!(both.normal_force, alone.normal_force);
//! assert_eq!(sheared.tangential_force, both.tangential_force);
//!
//! // The same ball on a floor.
//! let floor = WallSurface {
//!     point: Vector3::new(0.0, 0.0, -0.99e-3),
//!     normal: Vector3::new(0.0, 0.0, 1.0),
//!     direction: Vector3::new(1.0, 0.0, 0.0),
//!     curvatures: [0.0; 2],
//!     turning_radii: [f64::INFINITY; 2],
//!     velocity: Vector3::ZERO,
//!     velocity_change: Vector3::ZERO,
//!     share: Share::WHOLE,
//! };
//! let on_floor = StagedContact::of_wall(&lower, &floor).expect("it touches");
//! assert!(on_floor.is_wall() && (on_floor.equivalent_radius() - 1e-3).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::forces::{
    contact_forces, Contact, ContactForces, NoBed, Remembered, SpringBed, TwistedSprings,
};
use super::history::{Step, NO_SPRINGS};
use super::pair::{checked_factors, contact_of, contact_with_wall, factors_for, HaleRatio, Pair};
use super::particle::Particle;
use super::turning_normal::{along_and_across, TurningNormal};
use crate::force::hertz_factors;
use crate::force::memory::MOST_PARTS;
use crate::force::{PairLaw, Springs, Tangential, TwistingResistance, SPRINGS};
use crate::geometry::share::Share;
#[cfg(not(feature = "std"))]
use crate::real::Real;
use crate::vector::{Symmetric2, Tangent, Vector2, Vector3};

/// The surface of a wall where a body touches it.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct WallSurface {
    /// The point of the surface that lies deepest in the body, world frame.
    pub point: Vector3,
    /// Unit normal out of the wall, towards the body.
    pub normal: Vector3,
    /// A unit tangent vector: the first principal direction.
    pub direction: Vector3,
    /// Curvatures for Hertz' law along `direction` and across it, 1/length; 0 for a plane, negative for a cavity.
    pub curvatures: [f64; 2],
    /// How far from the point, along the normal into the wall, the surface turns with the body's motion, along
    /// `direction` and across it: infinite for a plane, `-Rc` for a cavity of that radius, 0 at an edge or a corner.
    pub turning_radii: [f64; 2],
    /// Velocity of the surface there.
    pub velocity: Vector3,
    /// What that at the step has more; read where the body comes with a change.
    pub velocity_change: Vector3,
    /// By how much of the law the surface acts, and the gradient of that.
    pub share: Share,
}

/// What is remembered of a contact.
#[derive(Clone, Copy, Debug)]
pub struct StagedHistory {
    /// Whether the bodies touched at the last step.
    pub touched: bool,
    /// The normal then.
    pub normal: Vector3,
    /// The tangential memory; written.
    pub memory: Vector3,
    /// Its elastic energy, of `displacement rescaled`; written.
    pub energy: f64,
    /// Penetrations of rest, of `viscosity memory`; written.
    pub rests: [f64; MOST_PARTS],
    /// Springs of partial slip, of `displacement hysteretic`; written. `None` where no law has such.
    pub springs: Option<Springs<Vector3>>,
    /// Their torques, of `twisting lubkin`; written. `None` where no law has such.
    pub torques: Option<[f64; SPRINGS]>,
}

/// A contact whose geometry is known.
#[derive(Clone, Copy, Debug)]
pub struct StagedContact {
    x: Contact,
    curvature: Symmetric2,
    /// For a wall: its turning radii and the direction that they belong to, in the tangent basis.
    wall: Option<([f64; 2], Vector2)>,
    share: Share,
}

impl StagedContact {
    /// Two ellipsoids: the contact, or `None` when they do not touch, written to `found` (a contact is large, and most
    /// pairs do not touch). `cached_normal` is the normal of the last step, or not a unit vector if there was no last step;
    /// it is written.
    pub fn of_pair(
        i: &Particle,
        j: &Particle,
        cached_normal: &mut Vector3,
        found: &mut Option<Self>,
    ) {
        *found = None;
        let start = Some(*cached_normal).filter(|n| n.is_unit());
        match Pair::of(i, j, start) {
            Pair::Touching(contact) => {
                *cached_normal = contact.normal;
                let x = contact_of(&contact, i, j);
                *found = Some(StagedContact {
                    curvature: x.curvature(),
                    x,
                    wall: None,
                    share: Share::WHOLE,
                });
            }
            Pair::Apart {
                normal: Some(n),
                searched: true,
            } => *cached_normal = n,
            Pair::Apart { .. } => {}
        }
    }

    /// An ellipsoid and a wall, or `None` when they do not touch.
    pub fn of_wall(i: &Particle, wall: &WallSurface) -> Option<Self> {
        let normal = -wall.normal;
        let support = i.body.support(normal);
        let penetration = support.h - wall.normal.dot(i.position - wall.point);
        if !(penetration > 0.0) {
            return None;
        }
        let tangent = Tangent::new(normal);
        let along = tangent.components(wall.direction);
        let weingarten_j = along_and_across(along, wall.curvatures);
        let x = contact_with_wall(
            i,
            &support,
            (normal, tangent),
            penetration,
            weingarten_j,
            [wall.velocity, wall.velocity_change],
        );
        Some(StagedContact {
            curvature: convex(x.curvature(), x.i.weingarten),
            x,
            wall: Some((wall.turning_radii, along)),
            share: wall.share,
        })
    }

    /// Geometry and motion, the curvature that the law reads, and by how much of the law the surface acts.
    pub(crate) fn for_law(&self) -> (&Contact, Symmetric2, f64) {
        (&self.x, self.curvature, self.share.value)
    }

    /// Whether body `j` is a wall.
    pub fn is_wall(&self) -> bool {
        self.wall.is_some()
    }

    /// Penetration > 0.
    pub fn penetration(&self) -> f64 {
        self.x.penetration
    }

    /// Unit normal from `i` to `j`, or into the wall.
    pub fn normal(&self) -> Vector3 {
        self.x.normal
    }

    /// The contact point; `centre_i` is the centre of body `i`, `share_i` its share in the penetration.
    pub fn contact_point(&self, centre_i: Vector3, share_i: f64) -> Vector3 {
        let x = &self.x;
        let along = x.i.h - x.penetration * share_i;
        centre_i + x.tangent.vector(x.i.witness) + x.normal * along
    }

    /// The radius of the sphere that, pressed against a plane by as much, feels the same elastic force: `Re F2^-3`. It
    /// makes a law written for spheres exact on ellipses in its normal force. Times the square of the share.
    pub fn equivalent_radius(&self) -> f64 {
        let (trace, determinant) = (self.curvature.trace(), self.curvature.determinant());
        let phi = hertz_factors::exact(trace, determinant, false).phi;
        0.5 / determinant.sqrt() * phi * phi * self.share.value * self.share.value
    }

    /// Normal and tangential stiffness of a circular contact with the same elastic normal force, force/length:
    /// `4/3 E* sqrt(R delta)` and `8 G* sqrt(R delta)` with the [equivalent radius](Self::equivalent_radius), for laws written
    /// for spheres; zero for a law without a material.
    pub fn circular_stiffness(&self, law: &PairLaw) -> [f64; 2] {
        let root = (self.equivalent_radius() * self.x.penetration).sqrt();
        [
            4.0 / 3.0 * law.effective_modulus() * root,
            8.0 * law.effective_shear_modulus() * root,
        ]
    }

    /// Area of the plane section of the overlap, `pi delta / sqrt(A B)`, to first order in the penetration over the radii; with
    /// spheres that of the circle in which they intersect, and twice the contact area of Hertz.
    pub fn section_area(&self) -> f64 {
        core::f64::consts::PI * self.x.penetration / self.curvature.determinant().sqrt()
    }

    /// Normal force and the further terms of the conservative law, without the tangential force and without memory. The time step is for the begin
    /// of contacts whose velocities are those of the step; 0: not known.
    ///
    /// # Errors
    /// Only with `factors hale`.
    pub fn normal_force(
        &self,
        law: &PairLaw,
        effective_mass: f64,
        time_step: f64,
    ) -> Result<ContactForces, HaleRatio> {
        let mut law = *law;
        law.kinds.tangential.law = Tangential::None;
        let x = Contact {
            effective_mass,
            begin_time: self.x.change.map(|_| time_step),
            ..self.x
        };
        let nothing = Remembered::nothing(false, x.normal);
        let mut f = self.forces::<NoBed, false>(&law, &x, &nothing, None)?;
        if law.kinds.conservative {
            self.turn_with_wall(&law, &mut f);
        }
        take_share(&self.share, law.kinds.conservative, &mut f);
        Ok(f)
    }

    /// Tangential force and its torques alone, with this coefficient of friction.
    ///
    /// # Errors
    /// Only with `factors hale`.
    pub fn tangential_force(
        &self,
        law: &PairLaw,
        friction: f64,
        effective_mass: f64,
        step: &Step,
        history: &mut StagedHistory,
    ) -> Result<ContactForces, HaleRatio> {
        let mut law = *law;
        // The normal part is subtracted below: without its further terms.
        law.kinds.conservative = false;
        let mut f = self.with_friction(&mut law, friction, effective_mass, step, history)?;
        take_share(&self.share, false, &mut f);
        f.force = f.tangential_force;
        f.torque_i = -f.contact_point.cross(f.tangential_force);
        f.torque_j = if self.is_wall() {
            Vector3::ZERO
        } else {
            (f.contact_point - self.x.between_centres()).cross(f.tangential_force)
        };
        Ok(f)
    }

    /// Normal and tangential force together.
    ///
    /// # Errors
    /// Only with `factors hale`.
    pub fn whole_force(
        &self,
        law: &PairLaw,
        friction: f64,
        effective_mass: f64,
        step: &Step,
        history: &mut StagedHistory,
    ) -> Result<ContactForces, HaleRatio> {
        let mut law = *law;
        let mut f = self.with_friction(&mut law, friction, effective_mass, step, history)?;
        if law.kinds.conservative {
            self.turn_with_wall(&law, &mut f);
        }
        take_share(&self.share, law.kinds.conservative, &mut f);
        Ok(f)
    }

    fn with_friction(
        &self,
        law: &mut PairLaw,
        friction: f64,
        effective_mass: f64,
        step: &Step,
        history: &mut StagedHistory,
    ) -> Result<ContactForces, HaleRatio> {
        law.constants.tangential.friction = friction;
        if !(friction > 0.0) {
            law.kinds.tangential.law = Tangential::None;
        }
        let x = Contact {
            effective_mass,
            begin_time: self.x.change.map(|_| step.time_step),
            ..self.x
        };
        let known = history.touched && history.normal.is_unit();
        let normal = if known { history.normal } else { x.normal };
        let last = (normal, history.memory, history.energy);
        let rests = if history.touched {
            history.rests
        } else {
            [0.0; MOST_PARTS]
        };
        let remembered = Remembered {
            rests: Some(rests),
            ..Remembered::of(history.touched, x.normal, last, step.elapsed())
        };
        if !history.touched {
            history.springs = history.springs.map(|_| NO_SPRINGS);
            history.torques = history.torques.map(|_| [0.0; SPRINGS]);
        }
        let twists = law.resistance.twisting == TwistingResistance::OfSprings;
        let f = match (&mut history.springs, &mut history.torques) {
            (Some(springs), Some(torques)) if twists => {
                let mut held = TwistedSprings { springs, torques };
                self.forces::<_, true>(law, &x, &remembered, Some(&mut held))?
            }
            (springs, _) => self.forces::<_, true>(law, &x, &remembered, springs.as_mut())?,
        };
        history.memory = f.memory;
        history.energy = f.tangential_energy;
        history.rests = f.rests;
        Ok(f)
    }

    fn forces<B: SpringBed<f64>, const FRICTION: bool>(
        &self,
        law: &PairLaw,
        x: &Contact,
        remembered: &Remembered,
        springs: Option<&mut B>,
    ) -> Result<ContactForces, HaleRatio> {
        let factors = checked_factors(law, self.curvature)?;
        let (kinds, constants, m) = (&law.kinds, &law.constants, self.curvature);
        Ok(if self.is_wall() {
            contact_forces::<f64, B, FRICTION, true, true, true>(
                kinds, constants, &factors, m, x, remembered, springs,
            )
        } else {
            contact_forces::<f64, B, FRICTION, true, true, false>(
                kinds, constants, &factors, m, x, remembered, springs,
            )
        })
    }

    /// `lambda` of the conservative law, of the directions in which the wall lets the normal turn.
    fn turn_with_wall(&self, law: &PairLaw, f: &mut ContactForces) {
        let Some((radii, along)) = self.wall else {
            return;
        };
        if radii.iter().all(|r| r.is_infinite()) {
            return;
        }
        let x = &self.x;
        let turning = TurningNormal::of(x, self.curvature, &factors_for(law, self.curvature));
        let lambda = turning.response(along, radii, x.penetration);
        turning.add(x, lambda, f.elastic_energy, f);
    }
}

/// Times the share; with the conservative law, the further terms by which force and torque are the gradient of share
/// times energy. What is remembered is that of the whole, so that it can go from one face to the next.
pub(crate) fn take_share(share: &Share, conservative: bool, f: &mut ContactForces) {
    if share.value == 1.0 {
        return;
    }
    let w = share.value;
    f.force = f.force * w;
    f.torque_i = f.torque_i * w;
    f.torque_j = f.torque_j * w;
    f.tangential_force = f.tangential_force * w;
    f.viscous_force = f.viscous_force * w;
    f.frictional_force = f.frictional_force * w;
    if conservative {
        f.force = f.force + share.by_position * f.elastic_energy;
        f.torque_i = f.torque_i - share.by_rotation * f.elastic_energy;
    }
    for part in [
        &mut f.normal_force,
        &mut f.stiffness,
        &mut f.elastic_energy,
        &mut f.tangential_energy,
        &mut f.relaxed_energy,
        &mut f.viscous_power,
        &mut f.tangential_power,
    ] {
        *part *= w;
    }
}

/// Half of the least share of a body's own curvature that is left where a wall's cavity takes the rest. Cavities that are wider than the body by
/// more than a thousandth are as they are; in narrower ones Hertz' contact would be as wide as the body, and the law has ended: the bound
/// only keeps it finite.
pub(super) const LEAST_CURVATURE: f64 = 5e-4;

/// Hertz' law needs a convex gap. In a cavity nearly as narrow as the body it is not; then the smaller curvature is kept
/// above a thousandth of the body's own.
fn convex(m: Symmetric2, own: Symmetric2) -> Symmetric2 {
    let least = LEAST_CURVATURE * own.determinant() / own.trace();
    if m.trace() > 0.0 && m.determinant() > least * m.trace() {
        return m;
    }
    let (a, b, direction) = m.eigen();
    along_and_across(direction, [a.max(least), b.max(least)])
}
