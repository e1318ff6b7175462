// SPDX-License-Identifier: MIT OR Apache-2.0
//! How stiff a contact is, the largest time step that it allows, how long a collision lasts and a wave through a grain.

use super::couple::TurningSprings;
use super::forces::Contact;
use super::laws::Laws;
use super::pair::{checked_factors, contact_of, touch_spheres, HaleRatio, Pair};
use super::particle::Particle;
pub use crate::force::normal::Collision;
use crate::force::normal::NormalForce;
use crate::force::{normal_force, tangential_stiffness, Factors, LawParameters, PairLaw};
use crate::geometry::contact_search::closest;
use crate::geometry::{relative_curvature, Ellipsoid};
use crate::vector::{Symmetric2, Vector3};

/// The springs and dashpots that a contact consists of for small motions about where it is.
#[derive(Clone, Copy, Debug)]
pub struct ContactStiffness {
    /// Of the normal spring, force/length: `dF_n/d(delta)` at the present penetration, for motion too fast for what relaxes.
    pub normal_stiffness: f64,
    /// Of the tangential spring along the major and the minor semi-axis of the contact ellipse, force/length, without slip.
    pub tangential_stiffness: [f64; 2],
    /// Of the normal dashpot while the bodies approach, force x time/length.
    pub normal_damping: f64,
    /// Of the tangential dashpot along the major and the minor semi-axis, force x time/length, without slip.
    pub tangential_damping: [f64; 2],
    /// The largest time step at which velocity Verlet is stable for this contact alone, its rotations included; infinite for
    /// two fixed bodies.
    pub critical_step: f64,
}

impl ContactStiffness {
    /// Of two bodies that do not touch.
    pub const NONE: ContactStiffness = ContactStiffness {
        normal_stiffness: 0.0,
        tangential_stiffness: [0.0; 2],
        normal_damping: 0.0,
        tangential_damping: [0.0; 2],
        critical_step: f64::INFINITY,
    };
}

/// A symmetric 3x3 matrix in the frame of a contact: its tangential part and its normal row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Matrix(pub(super) [[f64; 3]; 3]);

impl Matrix {
    pub(super) fn of(tangential: Symmetric2, normal: f64) -> Self {
        Matrix([
            [tangential.uu, tangential.uv, 0.0],
            [tangential.uv, tangential.vv, 0.0],
            [0.0, 0.0, normal],
        ])
    }

    fn combined(self, a: f64, other: Self, b: f64) -> Self {
        let mut sum = self.0;
        for (row, others) in sum.iter_mut().zip(other.0) {
            for (x, y) in row.iter_mut().zip(others) {
                *x = a * *x + b * y;
            }
        }
        Matrix(sum)
    }

    /// `L` of `self = L L^T`, for a positive definite matrix.
    pub(super) fn root(self) -> [[f64; 3]; 3] {
        let a = self.0;
        let mut l = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..=i {
                let sum: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
                l[i][j] = if i == j {
                    (a[i][i] - sum).max(0.0).sqrt()
                } else {
                    (a[i][j] - sum) / l[j][j]
                };
            }
        }
        l
    }

    /// `L^T self L`.
    pub(super) fn between(self, l: &[[f64; 3]; 3]) -> Self {
        let mut product = [[0.0; 3]; 3];
        for (i, row) in product.iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                for p in 0..3 {
                    for q in 0..3 {
                        *x += l[p][i] * self.0[p][q] * l[q][j];
                    }
                }
            }
        }
        Matrix(product)
    }

    /// The largest eigenvalue, by the trigonometric solution of the characteristic equation (Smith 1961).
    pub(super) fn largest_eigenvalue(self) -> f64 {
        let a = self.0;
        let mean = (a[0][0] + a[1][1] + a[2][2]) / 3.0;
        let off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
        let square = (0..3).map(|k| (a[k][k] - mean).powi(2)).sum::<f64>() + 2.0 * off;
        let p = (square / 6.0).sqrt();
        if !(p > 0.0) {
            return mean;
        }
        let b = |i: usize, j: usize| (a[i][j] - if i == j { mean } else { 0.0 }) / p;
        let determinant = b(0, 0) * (b(1, 1) * b(2, 2) - b(1, 2) * b(1, 2))
            - b(0, 1) * (b(0, 1) * b(2, 2) - b(1, 2) * b(0, 2))
            + b(0, 2) * (b(0, 1) * b(1, 2) - b(1, 1) * b(0, 2));
        let angle = (0.5 * determinant).clamp(-1.0, 1.0).acos() / 3.0;
        mean + 2.0 * p * angle.cos()
    }
}

/// The velocity of the contact point with a body: its components in the frame (u, v, n), row by row, over the six velocities of
/// the body along and about its principal axes, each times the root of its inertia. Zero for a fixed body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jacobian(pub(super) [[f64; 6]; 3]);

impl Jacobian {
    /// `arm` leads from the centre to the contact point.
    pub(super) fn of(body: &Particle, inverse_mass: f64, arm: Vector3, x: &Contact) -> Self {
        let frame = [x.tangent.u, x.tangent.v, x.normal];
        let root = inverse_mass.sqrt();
        let moments = body.body.squares_across().to_array();
        Jacobian(frame.map(|e| {
            let along = body.body.to_body(e).to_array();
            let about = body.body.to_body(arm.cross(e)).to_array();
            core::array::from_fn(|k| match k {
                0..3 => root * along[k],
                _ => root * (5.0 / moments[k - 3]).sqrt() * about[k - 3],
            })
        }))
    }

    /// The same of the angular velocity of the body in that frame.
    pub(super) fn of_rotation(body: &Particle, inverse_mass: f64, x: &Contact) -> Self {
        let frame = [x.tangent.u, x.tangent.v, x.normal];
        let root = inverse_mass.sqrt();
        let moments = body.body.squares_across().to_array();
        Jacobian(frame.map(|e| {
            let along = body.body.to_body(e).to_array();
            core::array::from_fn(|k| match k {
                0..3 => 0.0,
                _ => root * (5.0 / moments[k - 3]).sqrt() * along[k - 3],
            })
        }))
    }

    /// How easily the body gives way at the contact: the acceleration of the contact point is this matrix times the force on
    /// it, `1/m + [r]x^T I^-1 [r]x`.
    pub(super) fn mobility(&self) -> Matrix {
        let entry = |p: usize, q: usize| -> f64 {
            self.0[p].iter().zip(&self.0[q]).map(|(a, b)| a * b).sum()
        };
        Matrix(core::array::from_fn(|p| {
            core::array::from_fn(|q| entry(p, q))
        }))
    }
}

/// From the centres of the bodies to the contact point; the second has no meaning for a wall.
pub(super) fn arms(x: &Contact, share_i: f64) -> [Vector3; 2] {
    let share = x.penetration * share_i;
    [
        x.tangent.vector(x.i.witness) + x.normal * (x.i.h - share),
        x.normal * (x.penetration - share - x.j.h) - x.tangent.vector(x.j.witness),
    ]
}

/// How easily the bodies give way at the contact: the acceleration of the contact point of `j` relative to that of `i` is
/// this matrix times the force on `j`.
fn mobility(x: &Contact, i: &Particle, j: &Particle, share_i: f64) -> Matrix {
    let [arm_i, arm_j] = arms(x, share_i);
    let of_i = Jacobian::of(i, i.inverse_mass, arm_i, x).mobility();
    let of_j = Jacobian::of(j, j.inverse_mass, arm_j, x).mobility();
    of_i.combined(1.0, of_j, 1.0)
}

/// The springs and dashpots of a contact, in its frame.
pub(super) struct Springs {
    pub(super) normal_stiffness: f64,
    pub(super) tangential_stiffness: Symmetric2,
    pub(super) normal_damping: f64,
    pub(super) tangential_damping: Symmetric2,
    /// Elastic energy of the normal deformation.
    pub(super) elastic_energy: f64,
    pub(super) factors: Factors,
    /// Stiffness and damping against a relative rotation, where something resists rolling or twisting.
    pub(super) turning: Option<[Matrix; 2]>,
}

impl Springs {
    /// `m` is the curvature that the law reads.
    pub(super) fn of(law: &PairLaw, x: &Contact, m: Symmetric2) -> Result<Self, HaleRatio> {
        let factors = checked_factors(law, m)?;
        let at_rest = at_rest(law, &factors, x, m, x.penetration);
        let normal_stiffness = at_rest.stiffness;
        let (tangential_stiffness, tangential_damping) = tangential_stiffness(
            &law.kinds.tangential,
            &law.constants.tangential,
            normal_stiffness,
            &factors,
            m,
        );
        let c = &law.constants;
        let (spring, dashpot) = c
            .memory
            .springs_and_dashpots(law.kinds.normal.memory as usize);
        Ok(Springs {
            normal_stiffness: normal_stiffness * (1.0 + spring),
            tangential_stiffness,
            normal_damping: law
                .kinds
                .normal
                .dashpot(&c.normal, normal_stiffness, x.effective_mass)
                + normal_stiffness * dashpot,
            tangential_damping,
            elastic_energy: at_rest.elastic_energy,
            factors,
            turning: TurningSprings::of(law, x, m, normal_stiffness).map(|t| {
                [t.stiffness, t.damping].map(|(rolling, twist)| Matrix::of(rolling, twist))
            }),
        })
    }

    pub(super) fn stiffness(&self) -> Matrix {
        Matrix::of(self.tangential_stiffness, self.normal_stiffness)
    }

    pub(super) fn damping(&self) -> Matrix {
        Matrix::of(self.tangential_damping, self.normal_damping)
    }
}

/// Springs and dashpots of two bodies that touch, and the largest stable time step; `None` where they do not.
///
/// With `K` the stiffness, `C` the damping of the contact in the frame of its tangent plane and normal, and `A` the mobility of
/// the two bodies there, rotations included, a small motion obeys `u'' = -A (K u + C u')`. Velocity Verlet with damping by
/// the velocities of the half step, as the engines have it, becomes unstable where a mode changes its sign in every step
/// while it grows: where the largest eigenvalue of `A (dt^2 K + 2 dt C)` is 4; without damping `dt = 2/sqrt(lambda(A K))`.
/// What the normal's own rotation adds to `K` is left out: it is smaller by the penetration over the radius of curvature. What
/// resists rolling and twisting adds its own largest eigenvalue: the step is then a bound, not too long.
/// [`super::stable_step`] has the step of particles with many contacts.
///
/// # Errors
/// Only with `factors hale`.
///
/// # Example
/// Two spheres of radius 1 mm (SI units) that overlap by 10 micrometres: Hertz' stiffness `2 E* sqrt(R delta)`.
/// ```
/// use ellgran::contact::{prepare_body, stability::contact_stiffness, Body, Laws};
///
/// let (parameters, _) = ellgran::force::syntax::parse(&["hertz", "1e7", "0.3"])?;
/// let laws = Laws::new(1, &[Some(parameters)], true)?;
/// let sphere = |z: f64| Body {
///     position: [0.0, 0.0, z],
///     quaternion: [1.0, 0.0, 0.0, 0.0],
///     semi_axes: [1e-3; 3],
///     velocity: [0.0; 3],
///     angular_velocity: [0.0; 3],
///     mass: 1e-5,
///     particle_type: 1,
///     identifier: 1,
/// };
/// let (i, j) = (prepare_body(&sphere(0.0), Some(1))?, prepare_body(&sphere(1.99e-3), Some(1))?);
/// let found = contact_stiffness(&laws, &i, &j).expect("exact factors").expect("they touch");
/// let modulus = 1e7 / (2.0 * (1.0 - 0.3f64.powi(2)));
/// let expected = 2.0 * modulus * (0.5e-3f64 * 1e-5).sqrt();
/// assert!((found.normal_stiffness / expected - 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn contact_stiffness(
    laws: &Laws,
    i: &Particle,
    j: &Particle,
) -> Result<Option<ContactStiffness>, HaleRatio> {
    let Pair::Touching(found) = Pair::of(i, j, None) else {
        return Ok(None);
    };
    let law = laws.get(i.particle_type as usize, j.particle_type as usize);
    let x = contact_of(&found, i, j);
    let m = x.curvature();
    let springs = Springs::of(law, &x, m)?;
    let mut parts = vec![Oscillator {
        mobility: mobility(&x, i, j, law.constants.share_i),
        stiffness: springs.stiffness(),
        damping: springs.damping(),
    }];
    if let Some([stiffness, damping]) = springs.turning {
        let [of_i, of_j] =
            [i, j].map(|body| Jacobian::of_rotation(body, body.inverse_mass, &x).mobility());
        parts.push(Oscillator {
            mobility: of_i.combined(1.0, of_j, 1.0),
            stiffness,
            damping,
        });
    }
    let critical_step = critical_step(&parts);
    let major = found
        .tangent
        .components(relative_curvature(m, &found.tangent).major_direction);
    let along = |s: Symmetric2| {
        let minor = crate::vector::Vector2::new(-major.v, major.u);
        [major.dot(s.apply(major)), minor.dot(s.apply(minor))]
    };
    Ok(Some(ContactStiffness {
        normal_stiffness: springs.normal_stiffness,
        tangential_stiffness: along(springs.tangential_stiffness),
        normal_damping: springs.normal_damping,
        tangential_damping: along(springs.tangential_damping),
        critical_step,
    }))
}

/// The normal force at a penetration, the bodies at rest.
pub(super) fn at_rest(
    law: &PairLaw,
    factors: &Factors,
    x: &Contact,
    m: Symmetric2,
    penetration: f64,
) -> NormalForce {
    normal_force(
        &law.kinds.normal,
        &law.constants.normal,
        penetration,
        0.0,
        m.determinant(),
        factors,
        x.effective_mass,
    )
}

/// What a relative motion of the bodies meets, in the frame of the contact.
struct Oscillator {
    mobility: Matrix,
    stiffness: Matrix,
    damping: Matrix,
}

/// The critical step of all parts together: exact for one. The largest eigenvalue of a sum is at most the sum of the largest ones, so
/// that the step of several is a bound from below.
fn critical_step(parts: &[Oscillator]) -> f64 {
    if parts[0].mobility.0[2][2] == 0.0 {
        // Two fixed bodies.
        return f64::INFINITY;
    }
    let parts: Vec<[Matrix; 2]> = parts
        .iter()
        .map(|p| {
            let root = p.mobility.root();
            [p.stiffness.between(&root), p.damping.between(&root)]
        })
        .collect();
    let sum = |of: &dyn Fn(&[Matrix; 2]) -> Matrix| -> f64 {
        parts.iter().map(|p| of(p).largest_eigenvalue()).sum()
    };
    let undamped = 2.0 / sum(&|p| p[0]).sqrt();
    if parts
        .iter()
        .all(|[_, c]| c.0.iter().flatten().all(|x| *x == 0.0))
    {
        return undamped;
    }
    let (mut stable, mut unstable) = (0.0, undamped);
    // Halved to the last digit.
    for _ in 0..60 {
        let step = 0.5 * (stable + unstable);
        if sum(&|[k, c]| k.combined(step * step, *c, 2.0 * step)) < 4.0 {
            stable = step;
        } else {
            unstable = step;
        }
    }
    stable
}

/// The elastic collision in which the bodies meet with the normal, the curvatures and the mobility that they have here (apart or
/// touching) at this speed along the normal: for a central impact that of Hertz (Landau and Lifshitz, Theory of Elasticity,
/// section 9), half an oscillation for the linear law. Damping makes it longer and less deep.
///
/// # Errors
/// Only with `factors hale`.
pub fn collision(
    laws: &Laws,
    i: &Particle,
    j: &Particle,
    speed: f64,
) -> Result<Collision, HaleRatio> {
    let d = j.position - i.position;
    let found = if i.sphere && j.sphere {
        touch_spheres(i.radius, j.radius, d, &i.body, &j.body)
    } else {
        closest(&i.body, &j.body, d, None::<Vector3>)
    };
    let law = laws.get(i.particle_type as usize, j.particle_type as usize);
    let x = contact_of(&found, i, j);
    let m = x.curvature();
    let factors = checked_factors(law, m)?;
    // At first touch: there is no penetration.
    let touching = Contact {
        penetration: 0.0,
        ..x
    };
    let inverse_mass = mobility(&touching, i, j, law.constants.share_i).0[2][2];
    let stiffness = at_rest(law, &factors, &x, m, 1.0).stiffness;
    let formula = law.kinds.normal.formula;
    Ok(formula.collision(stiffness, inverse_mass, speed))
}

/// Limits of the time step by contacts of two grains, before any contact is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoGrainLimits {
    /// How long their shortest collision takes, time; infinite at speed 0 and for two fixed bodies.
    pub collision: f64,
    /// The largest time step at which velocity Verlet is stable for a contact of theirs; infinite for two fixed bodies.
    pub critical_step: f64,
}

/// Overlap at which stability is asked for, over the smaller of the two least semi-axes: at least this.
const LEAST_OVERLAP: f64 = 0.01;

/// Overlap over the distance of the centres, at most: deeper no law holds.
const LARGEST_OVERLAP: f64 = 0.25;

/// The limits of two grains that meet at this speed >= 0, flat side on flat side, where a contact is stiffest. Their places, attitudes
/// and velocities are not read. Stability is asked for at the deepest overlap of that collision, of 1 % of the smaller least semi-axis
/// at least and of a quarter of the distance of the centres at most.
///
/// # Errors
/// Only with `factors hale`.
///
/// # Example
/// Two glass beads of 1 mm radius that meet at 1 m/s (SI units): the time of Hertz' collision, and a step that is a small part of it.
/// ```
/// use ellgran::contact::stability::two_grain_limits;
/// use ellgran::contact::{prepare_body, Body, Laws};
///
/// let (parameters, _) = ellgran::force::syntax::parse(&["hertz", "6e10", "0.22"])?;
/// let laws = Laws::new(1, &[Some(parameters)], true)?;
/// let bead = Body {
///     position: [0.0; 3],
///     quaternion: [1.0, 0.0, 0.0, 0.0],
///     semi_axes: [1e-3; 3],
///     velocity: [0.0; 3],
///     angular_velocity: [0.0; 3],
///     mass: 1.05e-5,
///     particle_type: 1,
///     identifier: 1,
/// };
/// let bead = prepare_body(&bead, Some(1))?;
/// let limits = two_grain_limits(&laws, [&bead, &bead], 1.0).expect("exact factors");
/// let (modulus, radius, mass) = (0.5 * 6e10 / (1.0 - 0.22f64.powi(2)), 0.5e-3f64, 0.525e-5f64);
/// let hertz = 2.8683 * (mass * mass / (radius * modulus * modulus)).powf(0.2);
/// assert!((limits.collision / hertz - 1.0).abs() < 1e-3);
/// assert!(limits.critical_step < limits.collision);
/// assert_eq!(two_grain_limits(&laws, [&bead, &bead], 0.0).expect("exact factors").collision, f64::INFINITY);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn two_grain_limits(
    laws: &Laws,
    grains: [&Particle; 2],
    speed: f64,
) -> Result<TwoGrainLimits, HaleRatio> {
    let [one, other] = grains.map(lying);
    let [a, b] = [one.body.semi_axes.z, other.body.semi_axes.z];
    let apart_by = |overlap: f64| Particle {
        position: Vector3::new(0.0, 0.0, a + b - overlap),
        ..other
    };
    let mut overlap = LEAST_OVERLAP * a.min(b);
    let mut time = f64::INFINITY;
    if speed > 0.0 {
        let found = collision(laws, &one, &apart_by(overlap), speed)?;
        time = found.time;
        overlap = overlap
            .max(found.penetration)
            .min(LARGEST_OVERLAP * (a + b));
    }
    let stiffness = contact_stiffness(laws, &one, &apart_by(overlap))?;
    Ok(TwoGrainLimits {
        collision: time,
        critical_step: stiffness.unwrap_or(ContactStiffness::NONE).critical_step,
    })
}

/// The grain at the origin, its least semi-axis along z and its largest along x.
fn lying(grain: &Particle) -> Particle {
    let Vector3 { x, y, z } = grain.body.semi_axes;
    let (low, high) = (x.min(y), x.max(y));
    let semi_axes = [high.max(z), low.max(high.min(z)), low.min(z)];
    let body = Ellipsoid::new(semi_axes, [1.0, 0.0, 0.0, 0.0]);
    Particle {
        position: Vector3::ZERO,
        body: body.expect("the semi-axes of an ellipsoid, in another order"),
        ..*grain
    }
}

/// Rayleigh's time of a grain, `pi r sqrt(rho/G)/(0.1631 nu + 0.8766)`: how long a surface wave takes from pole to pole of a
/// sphere of the grain's least semi-axis `r`, `rho` the density of the solid grain (C. Thornton and C.W. Randall, in
/// Micromechanics of Granular Materials, Elsevier 1988). Infinite for the linear law, which has no material.
pub fn rayleigh_time(parameters: &LawParameters, grain: &Particle) -> f64 {
    if !parameters.normal.has_material() {
        return f64::INFINITY;
    }
    let density = 1.0 / (grain.inverse_mass * grain.body.volume());
    let material = &parameters.material();
    core::f64::consts::PI
        * grain.body.smallest_semi_axis()
        * (density / material.shear_modulus()).sqrt()
        / (0.1631 * material.poissons_ratio + 0.8766)
}
