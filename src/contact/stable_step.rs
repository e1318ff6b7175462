// SPDX-License-Identifier: MIT OR Apache-2.0
//! How long a time step is stable for bodies with many contacts, and how long one keeps the error of a collision small.
//!
//! **Stability.** Small motions of bodies in contact obey `M q'' = -K q - C q'`, the sums over the contacts of their springs and
//! dashpots. Velocity Verlet with damping by the velocities of the half step is `q(+) - 2 q + q(-) = -dt^2 M^-1 K q - dt M^-1 C (q - q(-))`.
//! An eigenvector of it, `q*Mq = 1`, with `k = q*Kq` and `c = q*Cq`, is multiplied in a step by the roots of
//! `z^2 - (2 - dt^2 k - dt c) z + 1 - dt c`, which do not exceed 1 where `dt^2 k + 2 dt c <= 4`. So a step is stable where the largest
//! eigenvalue of `M^-1 (dt^2 K + 2 dt C)` is at most 4, whatever the two matrices have in common.
//!
//! **The bound.** That eigenvalue belongs to all bodies together. What a contact adds to it is a function of the difference of the motions of
//! its two sides, and `(a - b)K(a - b) <= (1 + s) aKa + (1 + 1/s) bKb` for any `s > 0`: so a matrix of each body alone bounds it,
//! the sum over its contacts of `1 + s` times their springs as the body feels them, with its lever arms. `s` is the root of how much faster the
//! other body alone would oscillate at the contact, squared frequency over squared frequency: 1 for equal grains, 0 beside a wall, and little for a
//! light grain among heavy ones, while a heavy grain has room for many light ones. The bound is exact at walls, for two equal bodies whose stiffest
//! directions at the contact are the same, as in a central impact, and for the shortest wave of a regular packing of equal grains.
//! `tests/theory/stable_step.rs` says how far below the limit it is elsewhere.
//!
//! What both leave out: the rotation of the normal and the turning of the lever arms, smaller by the penetration over the radii of
//! curvature; that the stiffness grows with the penetration; and that a sliding contact hands on a change of the normal force sideways.
//!
//! # Example
//! ```
//! use ellgran::contact::stable_step::{least_stable_step, ContactExtremes, StepContact, SUMS};
//! use ellgran::contact::staged::{StagedContact, WallSurface};
//! use ellgran::contact::{prepare_body, Body, Laws};
//! use ellgran::geometry::facet_shares::Share;
//! use ellgran::vector::Vector3;
//!
//! let (parameters, _) = ellgran::force::syntax::parse(&["hertz", "1e7", "0.3"])?;
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
//! // A column of two balls of 10 mg on a floor, each contact 10 um deep (m, kg, s).
//! let lower = prepare_body(&ball(0.99e-3), Some(1))?;
//! let upper = prepare_body(&ball(2.98e-3), Some(1))?;
//! let pair = StepContact::of_pair(law, [&lower, &upper], [1e5, 1e5]).expect("exact factors").expect("they touch");
//! let floor = WallSurface {
//!     point: Vector3::ZERO,
//!     normal: Vector3::new(0.0, 0.0, 1.0),
//!     direction: Vector3::new(1.0, 0.0, 0.0),
//!     curvatures: [0.0; 2],
//!     turning_radii: [f64::INFINITY; 2],
//!     velocity: Vector3::ZERO,
//!     velocity_change: Vector3::ZERO,
//!     share: Share::WHOLE,
//! };
//! let staged = StagedContact::of_wall(&lower, &floor).expect("it touches");
//! let wall = StepContact::of_wall(law, &lower, &staged, 1e5, 1e-5).expect("exact factors");
//! let mut sums = [[0.0; SUMS]; 2];
//! pair.add_to_first(&mut sums[0]);
//! pair.add_to_second(&mut sums[1]);
//! wall.add_to_first(&mut sums[0]);
//! // The lower one has two contacts, and the shorter step.
//! let (step, body) = least_stable_step(&sums);
//! assert_eq!(body, Some(0));
//! // At most 2/omega of its spring to the floor alone, k = 2 E* sqrt(R delta).
//! let stiffness = 2.0 * law.effective_modulus() * (1e-3f64 * 1e-5).sqrt();
//! assert!(step < 2.0 / (stiffness * 1e5).sqrt());
//! let mut extremes = ContactExtremes::default();
//! extremes.add(&pair, [1, 2], [1, 1]);
//! extremes.add(&wall, [1, 0], [1, 1]);
//! // Both are as deep: 1 % of the radius.
//! assert_eq!(extremes.touching, 2);
//! assert!((extremes.deepest.0 - 0.01).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::forces::Contact;
use super::pair::{contact_of, HaleRatio, Pair};
use super::particle::Particle;
use super::stability::{arms, at_rest, Jacobian, Matrix, Springs};
use super::staged::StagedContact;
use crate::force::{normal_force, Factors, PairLaw};
use crate::vector::Symmetric2;

/// Of one matrix: the lower triangle of a symmetric matrix of six rows.
const TRIANGLE: usize = 21;

/// Doubles of the sums of one body.
pub const SUMS: usize = 2 * TRIANGLE;

/// The sums of one body over its contacts, bounds as in the head of this file: lower triangles, row by row, of its stiffness and of its
/// damping matrix over the six motions along and about its principal axes, in units of the root of its inertia: 1/time^2, then 1/time.
/// Sums over parts of the contacts add.
pub type StepSums = [f64; SUMS];

/// The elastic collision that passes through a contact as it is: with its penetration and its speed along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionThrough {
    /// Its duration, from first touch to the end of the contact.
    pub time: f64,
    /// The speed along the normal at first touch.
    pub speed: f64,
    /// Normal stiffness at a penetration of one unit of length, force/length.
    pub stiffness: f64,
    /// Acceleration of the penetration by a unit force, rotations included.
    pub inverse_mass: f64,
    /// The effective mass that damping with a coefficient of restitution reads.
    pub effective_mass: f64,
}

/// Springs and dashpots times the share of the surface, and by which velocities of the bodies they are strained.
#[derive(Debug)]
struct StepSprings {
    stiffness: Matrix,
    damping: Matrix,
    jacobians: [Jacobian; 2],
    /// By stiffness and by damping: the largest squared frequency or rate of each body alone at the contact; 0 for a fixed one.
    largest: [[f64; 2]; 2],
}

/// A contact as the step sees it.
#[derive(Debug)]
pub struct StepContact {
    /// What the motion of the contact point meets.
    force: StepSprings,
    /// What a relative rotation meets, where something resists rolling or twisting.
    couple: Option<StepSprings>,
    /// The collision through it; its time is infinite where nothing can move.
    pub collision: CollisionThrough,
    /// Penetration over the least semi-axis of the two bodies.
    pub relative_overlap: f64,
}

impl StepContact {
    /// Two bodies, of inverse masses for their inertia (0 for a fixed one); the inverse masses of the particles are those that the law
    /// reads. `None` where they do not touch.
    ///
    /// # Errors
    /// Only with `factors hale`.
    pub fn of_pair(
        law: &PairLaw,
        [i, j]: [&Particle; 2],
        inverse_masses: [f64; 2],
    ) -> Result<Option<Self>, HaleRatio> {
        let Pair::Touching(found) = Pair::of(i, j, None) else {
            return Ok(None);
        };
        let x = contact_of(&found, i, j);
        let m = x.curvature();
        let [arm_i, arm_j] = arms(&x, law.constants.share_i);
        let jacobians = [
            Jacobian::of(i, inverse_masses[0], arm_i, &x),
            Jacobian::of(j, inverse_masses[1], arm_j, &x),
        ];
        let apart = j.velocity + j.omega.cross(arm_j) - i.velocity - i.omega.cross(arm_i);
        let least = i.body.smallest_semi_axis().min(j.body.smallest_semi_axis());
        let turning = [
            Jacobian::of_rotation(i, inverse_masses[0], &x),
            Jacobian::of_rotation(j, inverse_masses[1], &x),
        ];
        let speed = x.normal.dot(apart);
        Self::of(law, &x, m, 1.0, [jacobians, turning], speed, least).map(Some)
    }

    /// A body at a wall. `effective_mass` is that which the law reads.
    ///
    /// # Errors
    /// Only with `factors hale`.
    pub fn of_wall(
        law: &PairLaw,
        i: &Particle,
        staged: &StagedContact,
        inverse_mass: f64,
        effective_mass: f64,
    ) -> Result<Self, HaleRatio> {
        let (x, m, share) = staged.for_law();
        let x = Contact {
            effective_mass,
            ..*x
        };
        let [arm, _] = arms(&x, law.constants.share_i);
        let jacobians = [
            Jacobian::of(i, inverse_mass, arm, &x),
            Jacobian([[0.0; 6]; 3]),
        ];
        let turning = [
            Jacobian::of_rotation(i, inverse_mass, &x),
            Jacobian([[0.0; 6]; 3]),
        ];
        let apart = x.j.velocity - i.velocity - i.omega.cross(arm);
        let least = i.body.smallest_semi_axis();
        let speed = x.normal.dot(apart);
        Self::of(law, &x, m, share, [jacobians, turning], speed, least)
    }

    fn of(
        law: &PairLaw,
        x: &Contact,
        m: Symmetric2,
        share: f64,
        [jacobians, turning]: [[Jacobian; 2]; 2],
        speed: f64,
        least_semi_axis: f64,
    ) -> Result<Self, HaleRatio> {
        let springs = Springs::of(law, x, m)?;
        let times = |matrix: Matrix| Matrix(matrix.0.map(|row| row.map(|entry| share * entry)));
        let inverse_mass: f64 = jacobians.iter().map(|j| j.mobility().0[2][2]).sum();
        // A collision may be too fast for what relaxes.
        let (spring, _) = law
            .constants
            .memory
            .springs_and_dashpots(law.kinds.normal.memory as usize);
        let stiffness =
            share * at_rest(law, &springs.factors, x, m, 1.0).stiffness * (1.0 + spring);
        let speed = (speed * speed + 2.0 * share * springs.elastic_energy * inverse_mass).sqrt();
        let time = if inverse_mass > 0.0 && stiffness > 0.0 && speed > 0.0 {
            law.kinds
                .normal
                .formula
                .collision(stiffness, inverse_mass, speed)
                .time
        } else {
            f64::INFINITY
        };
        Ok(StepContact {
            force: StepSprings::new(
                times(springs.stiffness()),
                times(springs.damping()),
                jacobians,
            ),
            couple: springs.turning.map(|[stiffness, damping]| {
                StepSprings::new(times(stiffness), times(damping), turning)
            }),
            collision: CollisionThrough {
                time,
                speed,
                stiffness,
                inverse_mass,
                effective_mass: x.effective_mass,
            },
            relative_overlap: x.penetration / least_semi_axis,
        })
    }

    /// Adds it to the sums of its first body.
    pub fn add_to_first(&self, sums: &mut StepSums) {
        self.force.add(0, sums);
        if let Some(couple) = &self.couple {
            couple.add(0, sums);
        }
    }

    /// Adds it to the sums of its second body; nothing for a wall.
    pub fn add_to_second(&self, sums: &mut StepSums) {
        self.force.add(1, sums);
        if let Some(couple) = &self.couple {
            couple.add(1, sums);
        }
    }
}

impl StepSprings {
    fn new(stiffness: Matrix, damping: Matrix, jacobians: [Jacobian; 2]) -> Self {
        let mobilities = jacobians.each_ref().map(Jacobian::mobility);
        // A fixed body, whose mobility has no root.
        let roots = mobilities.map(|m| (m.0[2][2] != 0.0).then(|| m.root()));
        let largest = [stiffness, damping].map(|matrix| {
            let nothing = matrix.0.iter().flatten().all(|entry| *entry == 0.0);
            roots.map(|root| match root {
                Some(root) if !nothing => matrix.between(&root).largest_eigenvalue(),
                _ => 0.0,
            })
        });
        StepSprings {
            stiffness,
            damping,
            jacobians,
            largest,
        }
    }

    fn add(&self, side: usize, sums: &mut StepSums) {
        let rows = &self.jacobians[side].0;
        let matrices = [&self.stiffness, &self.damping];
        let triangles = sums.chunks_exact_mut(TRIANGLE);
        for ((matrix, largest), triangle) in matrices.iter().zip(&self.largest).zip(triangles) {
            let (own, other) = (largest[side], largest[1 - side]);
            // A fixed body, or no such springs.
            if !(own > 0.0) {
                continue;
            }
            let weight = 1.0 + (other / own).sqrt();
            // The matrix times the rows.
            let mut sprung = [[0.0; 6]; 3];
            for (sprung, of_row) in sprung.iter_mut().zip(&matrix.0) {
                for (k, row) in of_row.iter().zip(rows) {
                    for (sum, entry) in sprung.iter_mut().zip(row) {
                        *sum += weight * k * entry;
                    }
                }
            }
            let mut at = 0;
            for a in 0..6 {
                for b in 0..=a {
                    for (row, sprung) in rows.iter().zip(&sprung) {
                        triangle[at] += row[a] * sprung[b];
                    }
                    at += 1;
                }
            }
        }
    }
}

/// Whether the step is stable by the sums of one body: `4 - dt^2 K - 2 dt C` is positive definite, tried by its root.
fn is_stable(sums: &StepSums, step: f64) -> bool {
    let mut root = [[0.0; 6]; 6];
    let mut at = 0;
    for a in 0..6 {
        for b in 0..=a {
            let whole = step * (step * sums[at] + 2.0 * sums[at + TRIANGLE]);
            at += 1;
            let known: f64 = (0..b).map(|k| root[a][k] * root[b][k]).sum();
            if a == b {
                let square = 4.0 - whole - known;
                if !(square > 0.0) {
                    return false;
                }
                root[a][a] = square.sqrt();
            } else {
                root[a][b] = (-whole - known) / root[b][b];
            }
        }
    }
    true
}

/// The largest step that is stable by the sums of one body, to a millionth, from below; infinite without contacts.
///
/// # Example
/// ```
/// use ellgran::contact::stable_step::{stable_step, SUMS};
/// // One spring: an angular frequency of 10 along the first axis, and 2 over it is the limit.
/// let mut sums = [0.0; SUMS];
/// sums[0] = 100.0;
/// assert!((stable_step(&sums) - 0.2).abs() < 1e-6);
/// assert_eq!(stable_step(&[0.0; SUMS]), f64::INFINITY);
/// ```
pub fn stable_step(sums: &StepSums) -> f64 {
    // One motion alone is stable no longer than all of them together.
    let alone = (0..6)
        .map(|k| {
            let diagonal = k * (k + 3) / 2;
            let (k, c) = (sums[diagonal], sums[diagonal + TRIANGLE]);
            // dt^2 k + 2 dt c = 4, without cancellation
            4.0 / (c + (c * c + 4.0 * k).sqrt())
        })
        .fold(f64::INFINITY, f64::min);
    if alone == f64::INFINITY {
        return alone;
    }
    // Six eigenvalues of which one is at least the largest entry on the diagonal, none more than six times that.
    let (mut stable, mut unstable) = (alone / 6.0, alone);
    if is_stable(sums, unstable * (1.0 - 1e-9)) {
        return unstable * (1.0 - 1e-9);
    }
    for _ in 0..24 {
        let step = 0.5 * (stable + unstable);
        if is_stable(sums, step) {
            stable = step;
        } else {
            unstable = step;
        }
    }
    stable
}

/// The least of the stable steps of many bodies, and the index of its body; infinite, and `None`, where nothing limits it.
pub fn least_stable_step(all: &[StepSums]) -> (f64, Option<usize>) {
    let mut least = (f64::INFINITY, None);
    for (index, sums) in all.iter().enumerate() {
        if least.1.is_none() || !is_stable(sums, least.0) {
            let step = stable_step(sums);
            if step < least.0 {
                least = (step, Some(index));
            }
        }
    }
    least
}

/// Most steps of a collision that are tried: the energy error falls with the step or faster, from 1e-3 at some 50 steps, to below 1e-6, the least
/// that a deck may ask for.
const MOST_STEPS: f64 = 1e5;

/// The longest step with which collisions like this end with the right kinetic energy to `error`, a part of what they began with: the root
/// of the mean square over first touches anywhere within a step, of a central impact by velocity Verlet with velocities of the half step, integrated
/// here; that of this and of the next shorter steps. Friction and rotation are not in it: an oblique collision with friction errs by up to a few times as much.
/// Nothing shorter than `time/1e5` is tried, and nothing longer than `time/5`.
///
/// # Example
/// An elastic collision after Hertz keeps its energy to 1 % with some 15 steps, to 1e-4 with some 40.
/// ```
/// use ellgran::contact::stable_step::{step_for_error, CollisionThrough};
/// use ellgran::contact::Laws;
///
/// let (parameters, _) = ellgran::force::syntax::parse(&["hertz", "1e7", "0.3"])?;
/// let laws = Laws::new(1, &[Some(parameters)], true)?;
/// let law = laws.get(1, 1);
/// let (stiffness, inverse_mass, speed) = (1e6, 1e5, 0.1);
/// let time = law.kinds.normal.formula.collision(stiffness, inverse_mass, speed).time;
/// let collision = CollisionThrough { time, speed, stiffness, inverse_mass, effective_mass: 1e-5 };
/// let rough = step_for_error(law, &collision, 1e-2);
/// let fine = step_for_error(law, &collision, 1e-4);
/// assert!(rough > time / 25.0 && fine < time / 25.0 && fine > time / 100.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn step_for_error(law: &PairLaw, collision: &CollisionThrough, error: f64) -> f64 {
    let time = collision.time;
    if !time.is_finite() {
        return f64::INFINITY;
    }
    let impact = Impact::new(law, collision);
    let exact = impact.exact();
    let mut steps = 5.0;
    let mut longest = None;
    let mut good = 0;
    while steps < MOST_STEPS {
        if impact.error(time / steps, exact) <= error {
            longest = longest.or(Some(steps));
            good += 1;
            // More than by chance: the error changes its sign here and there.
            if good == 4 {
                break;
            }
        } else {
            (longest, good) = (None, 0);
        }
        steps *= 1.15;
    }
    time / longest.unwrap_or(MOST_STEPS)
}

/// A central impact along the normal.
struct Impact<'a> {
    law: &'a PairLaw,
    factors: Factors,
    collision: &'a CollisionThrough,
}

impl<'a> Impact<'a> {
    fn new(law: &'a PairLaw, collision: &'a CollisionThrough) -> Self {
        let mut impact = Impact {
            law,
            factors: Factors {
                phi: 1.0,
                sigma: 0.0,
            },
            collision,
        };
        // The curvature is in the stiffness, which the factor brings about.
        if law.kinds.normal.elliptical {
            let at_one = impact.normal(1.0, 0.0).stiffness;
            impact.factors.phi = collision.stiffness / at_one;
        }
        impact
    }

    fn normal(&self, penetration: f64, rate: f64) -> crate::force::NormalForce {
        normal_force(
            &self.law.kinds.normal,
            &self.law.constants.normal,
            penetration,
            rate,
            1.0,
            &self.factors,
            self.collision.effective_mass,
        )
    }

    fn acceleration(&self, penetration: f64, rate: f64) -> f64 {
        if penetration > 0.0 {
            -self.collision.inverse_mass * self.normal(penetration, rate).force
        } else {
            0.0
        }
    }

    /// Steps after which bodies that stick are left alone.
    fn most(&self, step: f64) -> usize {
        (20.0 * self.collision.time / step) as usize
    }

    /// Kinetic energy after the collision over that before, by velocity Verlet; the bodies touch after this part of a step.
    fn after(&self, step: f64, part: f64) -> f64 {
        let before = self.collision.speed;
        let (mut penetration, mut rate) = ((1.0 - part) * step * before, before);
        for _ in 0..self.most(step) {
            rate += step * self.acceleration(penetration, rate);
            penetration += step * rate;
            if !(penetration > 0.0) {
                break;
            }
        }
        (rate / before).powi(2)
    }

    /// The same by the method of Runge and Kutta of fourth order with short steps, from the moment of first touch.
    fn exact(&self) -> f64 {
        let before = self.collision.speed;
        let step = self.collision.time / 10_000.0;
        let (mut penetration, mut rate) = (0.0, before);
        for _ in 0..self.most(step) {
            let mut slopes = [(0.0, 0.0); 4];
            for k in 0..4 {
                let by = [0.0, 0.5, 0.5, 1.0][k] * step;
                let (d, v) = if k == 0 { (0.0, 0.0) } else { slopes[k - 1] };
                let (d, v) = (penetration + by * d, rate + by * v);
                slopes[k] = (v, self.acceleration(d, v));
            }
            let sum = |of: fn(&(f64, f64)) -> f64| {
                let s = slopes.each_ref().map(of);
                (s[0] + 2.0 * s[1] + 2.0 * s[2] + s[3]) * step / 6.0
            };
            penetration += sum(|s| s.0);
            rate += sum(|s| s.1);
            if !(penetration > 0.0) {
                break;
            }
        }
        (rate / before).powi(2)
    }

    fn error(&self, step: f64, exact: f64) -> f64 {
        const TOUCHES: usize = 16;
        let squares: f64 = (0..TOUCHES)
            .map(|k| {
                let part = (k as f64 + 0.5) / TOUCHES as f64;
                (self.after(step, part) - exact).powi(2)
            })
            .sum();
        (squares / TOUCHES as f64).sqrt()
    }
}

/// What many contacts have in common, gathered one by one.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactExtremes {
    /// The shortest collision, if there is any, with the identifiers of its bodies, 0 for a wall, and their types.
    pub shortest: Option<(CollisionThrough, [i64; 2], [usize; 2])>,
    /// The deepest relative overlap, and the identifiers of its bodies; 0 without contacts.
    pub deepest: (f64, [i64; 2]),
    /// Number of contacts.
    pub touching: u64,
}

impl ContactExtremes {
    /// One more contact.
    pub fn add(&mut self, contact: &StepContact, identifiers: [i64; 2], types: [usize; 2]) {
        self.touching += 1;
        if contact.relative_overlap > self.deepest.0 {
            self.deepest = (contact.relative_overlap, identifiers);
        }
        let shorter = self
            .shortest
            .is_none_or(|(known, ..)| contact.collision.time < known.time);
        if shorter && contact.collision.time.is_finite() {
            self.shortest = Some((contact.collision, identifiers, types));
        }
    }
}
