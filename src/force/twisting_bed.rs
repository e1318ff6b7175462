// SPDX-License-Identifier: MIT OR Apache-2.0
//! `twisting lubkin`: twist and displacement share the friction of one bed of springs (docs/theory.md, section 5.2).
//!
//! The discs of radius `s` of a contact of radius `a` are the springs of [`super::spring_bed`]. Turned by `theta`, those up to `s` resist
//! with the share `(s/a)^3` of the stiffness about the normal, and each slides where its torque is that which Hertz' pressure and
//! Coulomb's law leave it: loaded once, the sum is Lubkin's curve (J. Appl. Mech. 18 (1951) 183; Jaeger, Arch. Appl. Mech. 65 (1995)
//! 478), and Masing's on every way back. Displaced and turned, an element slides where
//!
//! ```text
//! (f/f_max)^2 + (t/t_max)^2 = 1
//! ```
//!
//! and force and torque are reduced in proportion, so that a contact that is turned while it slides gives up force.
//!
//! On an ellipse stiffness and limit of the whole contact are its own, and are spread over the elements as on the circle. Sliding on in one
//! ratio of displacement and turn, an element keeps the ratio of its two stiffnesses times that, the full problem another one
//! (docs/report/tangential-contact.md).
//!
//! No cycle gives work: each element is two springs that are reduced together, and what all hold is never more than was remembered and the
//! work done on them.

use super::hertz_factors::Factors;
use super::spring_bed::{sticks_below, OfForce, Shares, Spread, Springs, LEAST_SHARE, SPRINGS};
use super::tangential::{
    compliance_matrix, within, TangentialConstants, TangentialForce, TangentialKinds, WithoutSlip,
};
use super::twisting::{mean_radius, squared_semi_axes, TwistSpring};
#[cfg(not(feature = "std"))]
use crate::real::{Functions, Real};
use crate::vector::{Symmetric2, Vector2};

/// Of the torque about the normal.
struct OfTorque;

impl Spread<f64> for OfTorque {
    fn stiffness(r: f64) -> f64 {
        r * r * r
    }
    fn load(r: f64) -> f64 {
        share_in_sliding_torque(r)
    }
    fn ratio(root: f64) -> f64 {
        root * root * root
    }
}

/// The share of the discs up to `r`, in units of the radius of the contact, in the torque of a contact that slides everywhere: the integral
/// from 0 to `r` of `64/pi^2 s^2 (K - E)`, complete elliptic integrals of the modulus `sqrt(1 - s^2)`. To 1e-10, for `0 < r <= 1`.
pub fn share_in_sliding_torque(r: f64) -> f64 {
    if !(r < 1.0) {
        return 1.0;
    }
    // Both integrals are power series in s^2, and others times ln s. Coefficients by least squares (validation/tangential_contact/torque_of_discs.py).
    const PLAIN: [f64; 5] = [
        1.555_487_580_537_649_4,
        -0.514_435_221_202_076,
        -0.031_466_751_208_121_98,
        -0.008_263_155_016_007_412,
        -0.001_322_453_111_443_938_6,
    ];
    const LOGARITHMIC: [f64; 5] = [
        1.080_759_445_523_341,
        -0.162_084_900_986_892_54,
        -0.021_128_211_171_999_56,
        -0.004_643_211_043_182_448_5,
        -0.000_351_126_236_439_649_3,
    ];
    let x = r * r;
    let of = |c: &[f64; 5]| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
    r * x * (of(&PLAIN) - of(&LOGARITHMIC) * x.max(1e-300).ln())
}

impl TwistSpring {
    /// Of two elastic bodies in a contact of this penetration, normal stiffness, curvature matrix and Hertz factors: exact stiffness without
    /// slip (R.D. Mindlin, J. Appl. Mech. 16 (1949) 259), and the torque of sliding for Hertz' pressure, within 0.041 % ([`mean_radius`]). On a circle of radius `a` and of equal
    /// bodies `8/3 G a^3` and `3 pi/16 mu F_n a`.
    pub fn of_elastic_bodies(
        c: &TangentialConstants,
        penetration: f64,
        normal_stiffness: f64,
        factors: &Factors,
        curvature: Symmetric2,
    ) -> Self {
        let squares = squared_semi_axes(penetration, factors.sigma, curvature);
        let beta = compliance_matrix(0.0, -1.0, factors.sigma, curvature);
        let area = squares.determinant().max(0.0);
        let product = |a: Symmetric2, b: Symmetric2| a.uu * b.uu + 2.0 * a.uv * b.uv + a.vv * b.vv;
        let deviator = |m: Symmetric2| m.shifted(-0.5 * m.trace());
        let (long, uneven) = (deviator(squares), deviator(beta));
        let size = product(long, long);
        // det S (D/K - Bl/K)/(a^2 - b^2), a^2/8 on the circle.
        let slope = if size > 1e-12 * area {
            -area * product(long, uneven) / size
        } else {
            0.125 * area.sqrt()
        };
        let both = product(squares, beta);
        let nu = c.kappa1 / c.kappa0;
        let over = area * beta.determinant() - nu * slope * both;
        let stiffness = if over > 0.0 {
            normal_stiffness / (3.0 * c.kappa0) * area * (both - 4.0 * nu * slope) / over
        } else {
            0.0
        };
        TwistSpring {
            stiffness,
            // A twist of the circle is shear alone, whose relaxation time this is.
            damping: stiffness * (c.tau0 / c.kappa0).max(0.0),
            friction: c.friction * LIMIT_OVER_MEAN_RADIUS * mean_radius(squares),
        }
    }
}

/// The torque of sliding under Hertz' pressure over that under an even one: `9 pi/32`, for every ellipse.
const LIMIT_OVER_MEAN_RADIUS: f64 = 9.0 * core::f64::consts::PI / 32.0;

/// Torque about the normal of a contact whose springs hold force and torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueOfSprings {
    /// What the twist makes. Of the sign of [`TwistingTorque`](super::TwistingTorque): against the relative rotation of `i`.
    pub elastic: f64,
    /// The viscous part.
    pub viscous: f64,
}

/// Tangential force and torque about the normal of `displacement hysteretic` with `twisting lubkin`. The arguments are those of
/// [`force_of_springs`](super::force_of_springs), and
///
/// - `torques`: what the elements hold against a twist; written;
/// - `turn`: the twist of this step, and `turning`, its rate: of `i` relative to `j`, about the normal from `i` to `j`.
///
/// Memory, energy and the reduction by it are of force and torque together.
///
/// # Example
/// Two balls of radius 1 cm slide on one another, and are then turned about the normal: the force falls (SI units).
/// ```
/// use ellgran::force::syntax::parse;
/// use ellgran::force::twisting_bed::{force_and_torque_of_springs, share_in_sliding_torque, TorqueOfSprings};
/// use ellgran::force::{hertz_factors, normal_force, PairLaw, Springs, TwistSpring, SPRINGS};
/// use ellgran::vector::{Symmetric2, Vector2};
///
/// let words = "hertz 1e7 0.3 tangential tfd 0.5 displacement hysteretic twisting lubkin";
/// let (parameters, _) = parse(&words.split(' ').collect::<Vec<_>>())?;
/// let law = PairLaw::resolve(&parameters, &parameters)?;
/// let (kinds, constants) = (&law.kinds, &law.constants);
/// let curvature = Symmetric2::new(100.0, 0.0, 100.0);
/// let factors = hertz_factors::exact(curvature.trace(), curvature.determinant(), true);
/// let (depth, det) = (1e-5, curvature.determinant());
/// let n = normal_force(&kinds.normal, &constants.normal, depth, 0.0, det, &factors, 1.0);
///
/// // The radius of the contact is that of Hertz, and the stiffness about the normal 8/3 G a^3.
/// let of_twist = TwistSpring::of_elastic_bodies(&constants.tangential, depth, n.stiffness, &factors, curvature);
/// let (radius, shear) = ((0.5e-2f64 * depth).sqrt(), 1e7 / (2.0 * 1.3));
/// assert!((of_twist.stiffness / (8.0 / 3.0 * shear * radius.powi(3)) - 1.0).abs() < 1e-9);
///
/// let none = Vector2::new(0.0, 0.0);
/// let mut springs = Springs { forces: [none; SPRINGS], reference: 0.0, penetration: 0.0 };
/// let (mut torques, mut memory, mut energy) = ([0.0; SPRINGS], none, 0.0);
/// let mut moved = |by: f64, turn: f64| {
///     let (f, t): (_, TorqueOfSprings) = force_and_torque_of_springs(
///         &kinds.tangential, &constants.tangential, (n.force, n.stiffness, 0.0), &factors, curvature, depth,
///         &mut springs, &mut torques, memory, energy, true, Vector2::new(by, 0.0), none, turn, 0.0,
///     );
///     (memory, energy) = (f.memory, f.elastic_energy);
///     (f.force.u.abs() / (0.5 * n.force), t.elastic)
/// };
/// let (slid, nothing) = moved(1e-4, 0.0);
/// assert!((slid - 1.0).abs() < 1e-9 && nothing == 0.0);
/// let (turned, torque) = (0..100).map(|_| moved(0.0, 1e-3)).last().expect("a hundred steps");
/// assert!(turned < 0.1 && torque < 0.0);
/// assert!((share_in_sliding_torque(0.5) - 0.358).abs() < 1e-3 && share_in_sliding_torque(1.0) == 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[allow(clippy::too_many_arguments)]
pub fn force_and_torque_of_springs(
    kinds: &TangentialKinds,
    c: &TangentialConstants,
    (normal_force, normal_stiffness, rounding): (f64, f64, f64),
    factors: &Factors,
    curvature: Symmetric2,
    penetration: f64,
    springs: &mut Springs<Vector2>,
    torques: &mut [f64; SPRINGS],
    memory: Vector2,
    remembered_energy: f64,
    passes: bool,
    increment: Vector2,
    velocity: Vector2,
    turn: f64,
    turning: f64,
) -> (TangentialForce, TorqueOfSprings) {
    let without_slip = WithoutSlip::of_ellipse(c, factors, curvature, normal_stiffness);
    let spring =
        TwistSpring::of_elastic_bodies(c, penetration, normal_stiffness, factors, curvature);
    let limit = c.friction * normal_force.max(0.0);
    let most_torque = spring.friction * normal_force.max(0.0);

    let mut bed = *springs;
    // The same grid, so that the elements stay those of the forces.
    let mut twist = Springs {
        forces: torques.map(|torque| Vector2::new(torque, 0.0)),
        ..bed
    };
    let shares = bed.follow::<OfForce>(penetration, passes);
    let twist_shares = twist.follow::<OfTorque>(penetration, passes);
    let energy_of = |bed: &Springs<Vector2>, twist: &Springs<Vector2>| {
        bed.energy(&without_slip, &shares) + energy_of_torques(twist, &spring, &twist_shares)
    };
    // The present contact may hold more than it took: its ellipse turned or changed.
    let holds = energy_of(&bed, &twist);
    let ratio = if passes && remembered_energy < holds {
        remembered_energy.max(0.0) / holds
    } else {
        1.0
    };
    let moved = without_slip.stiffness.apply(increment);
    let turned = spring.stiffness * turn;
    let (mut sticking, mut sticking_torque) = (0.0, 0.0);
    for k in 0..SPRINGS {
        let (share, twist_share) = (shares.stiffness[k], twist_shares.stiffness[k]);
        let force = moved.scale_add(share, bed.forces[k] * ratio);
        let torque = twist.forces[k].u * ratio + turned * twist_share;
        let most = [limit * shares.load[k], most_torque * twist_shares.load[k]];
        let loaded =
            of_limit(force.u.hypot(force.v), most[0]).hypot(of_limit(torque.abs(), most[1]));
        let kept = if loaded > 1.0 { 1.0 / loaded } else { 1.0 };
        bed.forces[k] = force * kept;
        twist.forces[k] = Vector2::new(torque * kept, 0.0);
        let mut least = [share, twist_share]
            .into_iter()
            .zip([shares.load[k], twist_shares.load[k]]);
        if least.all(|(share, load)| loaded * load < sticks_below(share, load, rounding)) {
            sticking += share;
            sticking_torque += twist_share;
        }
    }
    let (elastic, elastic_torque) = (bed.force(), twist.force().u);
    let (mut force, mut torque) = (elastic, elastic_torque);
    if kinds.viscous {
        let stiffness = normal_stiffness * sticking;
        let viscous = without_slip.viscous_force(c, factors, curvature, stiffness, velocity);
        force = within(limit, force + viscous);
        let viscous = spring.damping * sticking_torque * turning;
        torque = (torque + viscous).min(most_torque).max(-most_torque);
    }
    let mut result = TangentialForce {
        force: force * -1.0,
        elastic_force: elastic * -1.0,
        memory,
        displacement: without_slip.displacement(elastic),
        elastic_energy: remembered_energy,
    };
    if passes {
        result.memory = elastic;
        result.elastic_energy = energy_of(&bed, &twist);
        *springs = bed;
        *torques = twist.forces.map(|torque| torque.u);
    }
    let torque = TorqueOfSprings {
        elastic: -elastic_torque,
        viscous: elastic_torque - torque,
    };
    (result, torque)
}

/// A size over the largest that it may have.
fn of_limit(size: f64, most: f64) -> f64 {
    if size > 0.0 {
        size / most.max(1e-300)
    } else {
        0.0
    }
}

/// Elastic energy of the torques: each is a spring with its share of the stiffness.
fn energy_of_torques(twist: &Springs<Vector2>, spring: &TwistSpring, shares: &Shares<f64>) -> f64 {
    twist
        .forces
        .iter()
        .zip(&shares.stiffness)
        .map(|(torque, share)| {
            let stiffness = (spring.stiffness * share.max(LEAST_SHARE)).max(1e-300);
            torque.u * (0.5 * torque.u / stiffness)
        })
        .sum()
}
