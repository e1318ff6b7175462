// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tangential force: TFD, Mindlin, linear (docs/theory.md, sections 4 and 5).
//!
//! In the tangent plane the no-slip compliance of an elliptical contact is a symmetric matrix,
//! `C = C_n (kappa0 I - kappa1 Beta)`, where `Beta` has the eigenvalue `Bl/K` along the major and `D/K` along the minor
//! semi-axis. Since `Beta = I/2 + sigma (2 M/tr M - I)`, with `sigma` a function of `B/A` alone, no eigenvector is
//! ever needed. With `zeta = C^-1 xi` (the force if there were no slip):
//!
//! ```text
//! tfd       F = mu F_n [1 - (1 - s)^(3/2)] zeta/|zeta| ,  s = min(|zeta| / (3/2 mu F_n), 1)
//! mindlin   F = zeta, at most mu F_n
//! ```
//!
//! which is the paper's law with `xi_max = (3/2) mu F_n C_t` along each principal direction, and Coulomb's limit in
//! every direction. The viscous part is `sqrt(1-s) C^-1 A_t v_t`. The sum is capped by `mu F_n`. What is remembered is
//! clipped where the elastic part alone reaches the cone (`s = 1`), not where the sum does, and once a step: after the
//! displacement of the step is added.
//!
//! At a steady normal force this is the published curve whatever is remembered. `displacement rescaled` remembers `zeta` and
//! the energy `E` that it holds (`E = zeta.C zeta` times a function of `s`), and never lets `E` grow by more than the work
//! of the tangential force, so that no cycle gives work:
//!
//! - Where the present contact would hold more at the same `zeta` (it shrinks, its ellipse turns or changes, a viscous normal
//!   force widens the cone), `zeta` is reduced by the ratio of the energies: without slip on a circle, by the ratio of the
//!   stiffnesses (R.D. Elata, J.G. Berryman, Mech. Mater. 24 (1996) 229).
//! - Under partial slip on an ellipse `F` along `zeta` is no gradient: turning `zeta` towards the more compliant direction
//!   takes `(2 w - f) |zeta|^2/2 dc` less work than `E` grows, with `f = |F|/|zeta|`, `E = w zeta.C zeta` and `c` the
//!   compliance along `zeta`. The energy that is remembered falls by so much. A displacement along one line loses nothing.
//!
//! # Example
//! ```
//! use ellgran::force::syntax::parse;
//! use ellgran::force::tangential::{largest_tangential_stiffness, tangential_stiffness};
//! use ellgran::force::twisting::{mean_radius, squared_semi_axes};
//! use ellgran::force::{
//!     normal_force, rolling_force, tangential_force, twisting_torque, PairLaw, RollingResistance, TwistSpring,
//! };
//! use ellgran::force::hertz_factors::exact;
//! use ellgran::vector::{Symmetric2, Vector2};
//!
//! let words = "hertz 1e7 0.3 tangential mindlin 0.5 rolling sds 1e3 0 0.1 twisting marshall";
//! let (parameters, _) = parse(&words.split(' ').collect::<Vec<_>>())?;
//! let law = PairLaw::resolve(&parameters, &parameters)?;
//! let (kinds, constants) = (&law.kinds, &law.constants);
//!
//! // Two spheres of 1 mm radius, A = B = 1/R, 1 um deep: Hertz' force with R* = R/2.
//! let (radius, penetration) = (1e-3f64, 1e-6f64);
//! let curvature = Symmetric2::new(1.0 / radius, 0.0, 1.0 / radius);
//! let factors = exact(curvature.trace(), curvature.determinant(), true);
//! let normal = normal_force(&kinds.normal, &constants.normal, penetration, 0.0, curvature.determinant(), &factors, 1e-5);
//! let hertz = 4.0 / 3.0 * law.effective_modulus() * (0.5 * radius).sqrt() * penetration.powf(1.5);
//! assert!((normal.force / hertz - 1.0).abs() < 1e-12);
//! assert!((normal.elastic_energy / (0.4 * hertz * penetration) - 1.0).abs() < 1e-12);
//!
//! // Displaced by 1 nm without slip: 8 G* a, in all directions.
//! let a = (0.5 * radius * penetration).sqrt();
//! let stiffness = 8.0 * law.effective_shear_modulus() * a;
//! let (springs, _) = tangential_stiffness(&kinds.tangential, &constants.tangential, normal.stiffness, &factors, curvature);
//! assert!((springs.uu / stiffness - 1.0).abs() < 1e-9 && (springs.vv / stiffness - 1.0).abs() < 1e-9);
//! let (bound, _) = largest_tangential_stiffness(&kinds.tangential, &constants.tangential, normal.stiffness);
//! assert!(bound >= springs.uu * (1.0 - 1e-12));
//! let way = Vector2::new(1e-9, 0.0);
//! let sheared = tangential_force(
//!     &kinds.tangential, &constants.tangential, (normal.force, normal.stiffness, 0.0), &factors, curvature,
//!     Vector2::new(0.0, 0.0), 0.0, true, way, Vector2::new(0.0, 0.0),
//! );
//! assert!((sheared.force.u / (-stiffness * 1e-9) - 1.0).abs() < 1e-9);
//! assert!(kinds.tangential.any() && !kinds.tangential.can_create_energy());
//!
//! // Rolled by 1 mm: the spring of 1 kN/m is cut off at 0.1 F_n.
//! let RollingResistance::Given(rolling) = law.resistance.rolling else { panic!("rolling sds") };
//! let rolled = rolling_force(&rolling, normal.force, Vector2::new(0.0, 0.0), Vector2::new(1e-3, 0.0), Vector2::new(0.0, 0.0), true);
//! assert!((rolled.force.u.abs() / (0.1 * normal.force) - 1.0).abs() < 1e-12);
//!
//! // Twisted by 1e-6 rad without slip: k a^2/2 of a circle, with its tangential stiffness k and the radius a. The lever of friction is 2 a/3.
//! let squares = squared_semi_axes(penetration, factors.sigma, curvature);
//! assert!((squares.uu / (a * a) - 1.0).abs() < 1e-9);
//! assert!((mean_radius(squares) / (2.0 / 3.0 * a) - 1.0).abs() < 1e-9);
//! let spring = TwistSpring::of_contact_ellipse(&kinds.tangential, &constants.tangential, penetration, normal.stiffness, &factors, curvature);
//! assert!((spring.stiffness / (0.5 * stiffness * a * a) - 1.0).abs() < 1e-9);
//! let twisted = twisting_torque(&spring, normal.force, [0.0; 2], 1e-6, 0.0, true);
//! assert!((twisted.torque / (-1e-6 * spring.stiffness) - 1.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::choice::{choices, resolved_constants, Choice};
use super::contact_begin::Begin;
use super::hertz_factors::Factors;
use crate::real::Real;
use crate::vector::{Symmetric2, Vector2};
#[cfg(not(feature = "std"))]
use alloc::string::String;

choices! {
    /// Tangential law.
    Tangential {
        /// No tangential force, no tangential history.
        None = 0, "none", ELLGRAN_TANGENTIAL_NONE, [];
        /// Partial slip after Cattaneo and Mindlin, with the compliance of the contact ellipse.
        Tfd = 1, "tfd", ELLGRAN_TANGENTIAL_TFD, [friction];
        /// The no-slip stiffness of the contact ellipse up to the Coulomb limit.
        Mindlin = 2, "mindlin", ELLGRAN_TANGENTIAL_MINDLIN, [friction];
        /// A constant stiffness and damping up to the Coulomb limit.
        Linear = 3, "linear", ELLGRAN_TANGENTIAL_LINEAR, [tangential_stiffness, tangential_damping, friction];
    }

    /// What is kept of the tangential displacement while the contact grows and shrinks.
    Displacement {
        /// The tangential displacement since first touch is remembered, and the force is that at the present stiffness: the
        /// published form. It can create energy: what was loaded while the contact was shallow gives more when it is unloaded
        /// while it is deep.
        Total = 0, "total", ELLGRAN_DISPLACEMENT_TOTAL, [];
        /// The tangential force is remembered: `dF = k_t(delta) d xi`. It can create energy: what was loaded while the contact was
        /// deep gives more when it is unloaded while it is shallow.
        Incremental = 1, "incremental", ELLGRAN_DISPLACEMENT_INCREMENTAL, [];
        /// The tangential force and its energy are remembered, reduced where the contact would otherwise hold more energy than
        /// it took, as with the stiffness while the contact shrinks: no cycle creates energy. The same as `total` while the
        /// normal force is steady. The default.
        Rescaled = 2, "rescaled", ELLGRAN_DISPLACEMENT_RESCALED, [];
        /// The tangential forces of eight springs with a Coulomb limit each are remembered: partial slip with its loop, that is with
        /// the energy that it dissipates below the limit of the whole contact. No cycle creates energy. Only with `tfd`.
        Hysteretic = 3, "hysteretic", ELLGRAN_DISPLACEMENT_HYSTERETIC, [];
    }
}

impl Tangential {
    /// Whether it takes its stiffness from the elastic constants of the material, and from the present contact ellipse.
    #[inline(always)]
    pub fn needs_material(self) -> bool {
        match self {
            Tangential::Tfd | Tangential::Mindlin => true,
            Tangential::None | Tangential::Linear => false,
        }
    }

    /// For a law under which slip begins at the rim of the contact: `|zeta|` at which all of it slides, over Coulomb's limit
    /// `mu F_n`. `None`: no slip below that limit.
    #[inline(always)]
    fn sliding(self) -> Option<f64> {
        match self {
            Tangential::Tfd => Some(1.5),
            Tangential::None | Tangential::Mindlin | Tangential::Linear => None,
        }
    }

    /// The force along `zeta` of a contact that slips partially, at `s = |zeta|` over that at which all of it slides.
    #[inline(always)]
    fn partial_slip<T: Real>(self, s: T, clip: T) -> Slip<T> {
        match self {
            Tangential::Tfd => Slip::of_cattaneo_and_mindlin(s, clip),
            Tangential::None | Tangential::Mindlin | Tangential::Linear => Slip::none(clip),
        }
    }
}

/// Which terms the tangential law has: the choices that select a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct TangentialKinds {
    /// The law.
    pub law: Tangential,
    /// What is kept of the displacement.
    pub displacement: Displacement,
    /// Whether it has a viscous part.
    pub viscous: bool,
}

impl TangentialKinds {
    /// The mean over a step of the stiffness with which the tangential force grows, over that at its end, where the contact
    /// has come `way` deeper within the step to this penetration. Taken at the end, it makes an error of the first order in
    /// the step.
    ///
    /// The stiffness goes with the root of the penetration `d`. Of `rescaled` a force that was there shrinks with the contact, so
    /// that what is added while it shrinks counts with the stiffness at the end; `total` keeps a displacement and adds no force.
    #[inline(always)]
    pub(crate) fn mean_stiffness<T: Real>(&self, penetration: T, way: T) -> T {
        let one = way.constant(1.0);
        let zero = way.constant(0.0);
        if !self.law.needs_material() || matches!(self.displacement, Displacement::Total) {
            return one;
        }
        // The root of the penetration before over that now; the law has the inverse root anyway.
        let inverse_root = penetration.max(one * 1e-300).reciprocal_sqrt();
        let s = (penetration - way).max(zero).sqrt() * inverse_root;
        let s = match self.displacement {
            Displacement::Rescaled | Displacement::Hysteretic => s.min(one),
            // Where the step ends the contact the force has vanished.
            _ => s.min(one * 1e3),
        };
        // The mean of the root from s^2 to 1: 2/3 (1 - s^3)/(1 - s^2).
        (s + (one + s).reciprocal()) * (2.0 / 3.0)
    }
    /// How the viscous force of a contact begins.
    #[inline(always)]
    pub(crate) fn begin(&self) -> Begin {
        if self.law.needs_material() {
            Begin::SquareRoot
        } else {
            Begin::Jump
        }
    }
    /// Whether springs of partial slip are remembered ([`super::spring_bed`]).
    #[inline(always)]
    pub(crate) fn has_springs(&self) -> bool {
        self.any() && matches!(self.displacement, Displacement::Hysteretic)
    }

    /// Whether there is a tangential force.
    #[inline(always)]
    pub fn any(&self) -> bool {
        !matches!(self.law, Tangential::None)
    }

    /// Whether a cycle of normal and tangential displacement can give work: the stiffness changes with the contact, and
    /// what is remembered is not reduced.
    pub fn can_create_energy(&self) -> bool {
        let creates = match self.displacement {
            Displacement::Total | Displacement::Incremental => true,
            Displacement::Rescaled | Displacement::Hysteretic => false,
        };
        self.law.needs_material() && creates && !self.viscous
    }
}

resolved_constants! {
    $
    /// The constants of a pair of types that the tangential law reads.
    TangentialConstants, tangential_constants {
        /// `mu`.
        friction,
        /// `kappa0`: the tangential compliance is `C_n (kappa0 - kappa1 beta)`.
        kappa0,
        /// `kappa1`.
        kappa1,
        /// `tau0`: `A_t (kappa0 - kappa1 beta) = tau0 - tau1 beta`, time.
        tau0,
        /// `tau1`.
        tau1,
        /// `kt` of `linear`.
        stiffness,
        /// `ct` of `linear`.
        damping,
    }
}

/// One term: the law with its constants and its choices, for the line that describes a law.
pub fn describe(kinds: &TangentialKinds, c: &TangentialConstants) -> String {
    if !kinds.any() {
        return String::new();
    }
    let (word, mu) = (kinds.law.word(), c.friction);
    let law = if kinds.law.needs_material() {
        format!(" {word} mu {mu}")
    } else {
        format!(" {word} kt {} ct {} mu {mu}", c.stiffness, c.damping)
    };
    law + match kinds.displacement {
        Displacement::Total => " displacement total",
        Displacement::Incremental => " displacement incremental",
        Displacement::Rescaled => "",
        Displacement::Hysteretic => " displacement hysteretic",
    }
}

/// The tangential force of one contact.
#[derive(Clone, Copy, Debug)]
pub struct TangentialForce<T = f64> {
    /// Force on body `j` in the tangent basis.
    pub force: Vector2<T>,
    /// What of it the tangential displacement makes, without the viscous part: `force` itself where that is none.
    pub elastic_force: Vector2<T>,
    /// What is remembered, in the tangent basis: `xi` (length) for `displacement total`, the force of all springs for `hysteretic`,
    /// `zeta` (force) otherwise.
    pub memory: Vector2<T>,
    /// Tangential displacement that the elastic part stands for, in the tangent basis, length.
    pub displacement: Vector2<T>,
    /// Elastic energy of what is remembered; `displacement rescaled` and `hysteretic` remember it too.
    pub elastic_energy: T,
}

/// What an elliptical contact has where nothing slips, in the tangent basis.
#[derive(Clone, Copy)]
pub(super) struct WithoutSlip<T> {
    /// Stiffness matrix `C^-1`.
    pub stiffness: Symmetric2<T>,
    /// The compliance matrix times the normal stiffness.
    kappa: Symmetric2<T>,
    /// The stiffness matrix over the normal stiffness.
    kappa_inverse: Symmetric2<T>,
    /// Over the normal stiffness.
    softness: T,
}

impl<T: Real> WithoutSlip<T> {
    #[inline(always)]
    pub fn of_ellipse(
        c: &TangentialConstants<T>,
        factors: &Factors<T>,
        curvature: Symmetric2<T>,
        normal_stiffness: T,
    ) -> Self {
        let tiny = normal_stiffness.constant(1e-300);
        let kappa = compliance_matrix(c.kappa0, c.kappa1, factors.sigma, curvature);
        let inverse = kappa.adjugate() * kappa.determinant().reciprocal();
        WithoutSlip {
            stiffness: inverse * normal_stiffness,
            kappa,
            kappa_inverse: inverse,
            softness: normal_stiffness.max(tiny).reciprocal(),
        }
    }

    /// The displacement that a force makes.
    #[inline(always)]
    pub fn displacement(&self, force: Vector2<T>) -> Vector2<T> {
        self.kappa.apply(force) * self.softness
    }

    /// `F.C F`, twice the energy of the spring that holds a force.
    ///
    /// A receding contact may have no stiffness left, and a force remembered: the terms of the product would leave double precision with
    /// either sign. The last factor here is positive, so that the result is too large to be held at most, and never no number.
    #[inline(always)]
    pub fn double_energy(&self, force: Vector2<T>) -> T {
        force.dot(self.kappa.apply(force)) * self.softness
    }

    /// `C^-1 A_t v_t`; of the normal stiffness that share which sticks.
    #[inline(always)]
    pub fn viscous_force(
        &self,
        c: &TangentialConstants<T>,
        factors: &Factors<T>,
        curvature: Symmetric2<T>,
        sticking_stiffness: T,
        velocity: Vector2<T>,
    ) -> Vector2<T> {
        let tau = compliance_matrix(c.tau0, c.tau1, factors.sigma, curvature);
        let strained = tau.apply(self.kappa_inverse.apply(velocity));
        self.kappa_inverse.apply(strained) * sticking_stiffness
    }
}

/// A force of at most this size in its direction.
#[inline(always)]
pub(super) fn within<T: Real>(limit: T, force: Vector2<T>) -> Vector2<T> {
    let one = limit.constant(1.0);
    let square = force.dot(force);
    let inverse = square.max(limit.constant(1e-290)).reciprocal_sqrt();
    force * T::select(limit.less(square * inverse), limit * inverse, one)
}

/// Tangential force of all laws but `displacement hysteretic`, which [`super::force_of_springs`] has.
///
/// - `normal_force`, `normal_stiffness`: those of the present contact ([`super::NormalForce`]); `rounding`: the relative error that
///   rounding leaves in that force, which is large where the contact is shallow. Read only where no time passes.
/// - `memory`: what is remembered, carried into the present tangent basis; `remembered_energy`: its elastic energy at the
///   last step (only `displacement rescaled`; 0 for a new contact).
/// - `passes`: whether time passes. Where none does, as when a run starts, nothing slips and nothing is given up: memory and
///   energy stay.
/// - `increment`: the tangential displacement of `j` relative to `i` in this step.
/// - `velocity`: the tangential velocity of `j` relative to `i`.
/// - `curvature`: the relative curvature matrix `M` in the same basis.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub fn tangential_force<T: Real>(
    kinds: &TangentialKinds,
    c: &TangentialConstants<T>,
    (normal_force, normal_stiffness, rounding): (T, T, T),
    factors: &Factors<T>,
    curvature: Symmetric2<T>,
    memory: Vector2<T>,
    remembered_energy: T,
    passes: T::Mask,
    increment: Vector2<T>,
    velocity: Vector2<T>,
) -> TangentialForce<T> {
    let zero = normal_force.constant(0.0);
    let one = normal_force.constant(1.0);
    let tiny = normal_force.constant(1e-300);
    let least = normal_force.constant(1e-290);
    let limit = c.friction * normal_force.max(zero);

    let linear = !kinds.law.needs_material();
    let without_slip = if linear {
        let k = c.stiffness;
        let inverse = one / k.max(tiny);
        let identity = Symmetric2::new(one, zero, one);
        WithoutSlip {
            stiffness: Symmetric2::new(k, zero, k),
            kappa: identity,
            kappa_inverse: identity,
            softness: inverse,
        }
    } else {
        WithoutSlip::of_ellipse(c, factors, curvature, normal_stiffness)
    };
    let stiffness = without_slip.stiffness;

    let law = kinds.law;
    let most = match law.sliding() {
        Some(over_limit) => limit * over_limit,
        None => limit,
    };
    // The stiffness of `linear` does not change: nothing of it is ever given up.
    let gives_up = !linear && matches!(kinds.displacement, Displacement::Rescaled);
    // What is kept of the memory, and the compliance along it.
    let (kept, compliance_before) = if gives_up {
        // A cone that shrank clips only once the displacement of this step is added: coming back, it may have left the cone.
        let (_, slip) = on_the_cone(memory, most, law);
        let energy = without_slip.double_energy(memory);
        let holds = (energy * slip.work).max(tiny).min(one * 1e300);
        let ratio = remembered_energy * holds.reciprocal();
        let along = energy * memory.dot(memory).max(least).reciprocal();
        // No energy is less than none: nothing is kept then.
        let ratio = T::select(passes, ratio.min(one).max(zero), one);
        (memory * ratio, along)
    } else {
        (memory, zero)
    };
    let trial = match kinds.displacement {
        Displacement::Total => stiffness.apply(memory + increment),
        _ => kept + stiffness.apply(increment),
    };
    let (zeta, slip) = on_the_cone(trial, most, law);
    // Where no time passes a contact that slides is found on the cone but for rounding, of which the root would make its square root.
    let slides = (slip.root * slip.root).less(rounding.max(one * 1e-12));
    let root = T::select(passes, slip.root, T::select(slides, zero, slip.root));

    let elastic = zeta * slip.factor;
    let mut force = elastic;
    if kinds.viscous {
        let viscous = if linear {
            velocity * c.damping
        } else {
            without_slip.viscous_force(c, factors, curvature, normal_stiffness * root, velocity)
        };
        force = within(limit, force + viscous);
    }
    let displacement = match kinds.displacement {
        // What zeta was made of, clipped with it.
        Displacement::Total => (memory + increment) * slip.clip,
        _ => without_slip.displacement(zeta),
    };
    let energy = match kinds.displacement {
        Displacement::Total => displacement.dot(zeta),
        _ => without_slip.double_energy(zeta),
    };
    let mut held = energy * slip.work;
    if gives_up && law.sliding().is_some() {
        let (old, new) = (kept.dot(kept), zeta.dot(zeta));
        let turned = (energy * new.max(least).reciprocal() - compliance_before).max(zero);
        let excess = slip.work * 2.0 - slip.factor;
        // Given up by the ratio of the next step: the force of this one is that of `zeta`.
        held = held - excess * 0.5 * old.min(new) * turned;
    }
    if gives_up {
        held = T::select(passes, held, remembered_energy);
    }
    let now = match kinds.displacement {
        Displacement::Total => displacement,
        _ => zeta,
    };
    TangentialForce {
        force: force * -one,
        elastic_force: elastic * -one,
        memory: Vector2::new(
            T::select(passes, now.u, memory.u),
            T::select(passes, now.v, memory.v),
        ),
        displacement,
        elastic_energy: held,
    }
}

/// Stiffness and damping matrix of a contact that has not slipped, in the tangent basis, for its normal stiffness; zero for
/// a law without a tangential part.
pub fn tangential_stiffness(
    kinds: &TangentialKinds,
    c: &TangentialConstants,
    normal_stiffness: f64,
    factors: &Factors,
    curvature: Symmetric2,
) -> (Symmetric2, Symmetric2) {
    let isotropic = |x: f64| Symmetric2::new(x, 0.0, x);
    let (stiffness, damping) = match kinds.law {
        Tangential::None => return (isotropic(0.0), isotropic(0.0)),
        law if !law.needs_material() => (isotropic(c.stiffness), isotropic(c.damping)),
        _ => {
            let kappa = compliance_matrix(c.kappa0, c.kappa1, factors.sigma, curvature);
            let tau = compliance_matrix(c.tau0, c.tau1, factors.sigma, curvature);
            let inverse = kappa.adjugate() * kappa.determinant().reciprocal();
            // The three have the same eigenvectors.
            let columns = [Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)]
                .map(|e| inverse.apply(tau.apply(inverse.apply(e))));
            let damping = Symmetric2::new(columns[0].u, columns[0].v, columns[1].v);
            (inverse * normal_stiffness, damping * normal_stiffness)
        }
    };
    if kinds.viscous {
        (stiffness, damping)
    } else {
        (stiffness, isotropic(0.0))
    }
}

/// Bounds in any direction of the stiffness (force/length) and the damping (force x time/length) of a contact that has not
/// slipped, whatever its ellipse (`beta` is from 0 to 1); zero for a law without a tangential part.
#[inline(always)]
pub fn largest_tangential_stiffness<T: Real>(
    kinds: &TangentialKinds,
    c: &TangentialConstants<T>,
    normal_stiffness: T,
) -> (T, T) {
    let zero = normal_stiffness.constant(0.0);
    match kinds.law {
        Tangential::None => (zero, zero),
        law if !law.needs_material() => (c.stiffness, c.damping),
        _ => {
            let least = c.kappa0.min(c.kappa0 - c.kappa1);
            let viscous = c.tau0.max(c.tau0 - c.tau1).max(zero);
            (
                normal_stiffness / least,
                normal_stiffness * viscous / (least * least),
            )
        }
    }
}

/// How far a contact with `zeta` on or in the cone has slipped.
#[derive(Clone, Copy)]
struct Slip<T> {
    /// What `zeta` was multiplied with to be there; below 1 while the contact slides.
    clip: T,
    /// What is left of the stiffness, `dF/d|zeta|`, which the viscous part goes with: `sqrt(1 - s)` for `tfd`; 1 without
    /// partial slip.
    root: T,
    /// Elastic force over `zeta`.
    factor: T,
    /// Elastic energy over `zeta.C zeta`.
    work: T,
}

impl<T: Real> Slip<T> {
    /// `F = mu F_n [1 - (1 - s)^(3/2)]`.
    #[inline(always)]
    fn of_cattaneo_and_mindlin(s: T, clip: T) -> Self {
        let one = s.constant(1.0);
        let r = (one - s).sqrt();
        // [1 - (1-s)^(3/2)]/s and the work, without cancellation at s -> 0 (r -> 1).
        let next = r + 1.0;
        let inverse = next.reciprocal();
        Slip {
            clip,
            root: r,
            factor: (r * next + 1.0) * inverse * (2.0 / 3.0),
            work: (((r * 0.4 + 0.8) * r + 1.2) * r + 0.6) * (inverse * inverse) * (2.0 / 3.0),
        }
    }

    /// No slip below Coulomb's limit.
    #[inline(always)]
    fn none(clip: T) -> Self {
        let one = clip.constant(1.0);
        Slip {
            clip,
            root: one,
            factor: one,
            work: one * 0.5,
        }
    }
}

/// `zeta`, no longer than `most`: sliding, the elastic part stays on the cone.
#[inline(always)]
fn on_the_cone<T: Real>(zeta: Vector2<T>, most: T, law: Tangential) -> (Vector2<T>, Slip<T>) {
    let one = most.constant(1.0);
    let square = zeta.dot(zeta);
    let inverse_size = square.max(most.constant(1e-290)).reciprocal_sqrt();
    let size = square * inverse_size;
    let slides = most.less(size);
    let clip = T::select(slides, most * inverse_size, one);
    let slip = if law.sliding().is_some() {
        // Exactly 1 while sliding: the viscous part goes with sqrt(1 - s), which would make 1e-8 of a rounding.
        let inverse_most = most.max(most.constant(1e-300)).reciprocal();
        let s = T::select(slides, one, (size * inverse_most).min(one));
        law.partial_slip(s, clip)
    } else {
        Slip::none(clip)
    };
    (zeta * clip, slip)
}

/// `x0 I - x1 Beta`, `Beta = I/2 + sigma (2 M/tr M - I)`.
#[inline(always)]
pub(super) fn compliance_matrix<T: Real>(
    x0: T,
    x1: T,
    sigma: T,
    curvature: Symmetric2<T>,
) -> Symmetric2<T> {
    let anisotropy = x1 * sigma;
    let isotropic = x0 - x1 * 0.5 + anisotropy;
    let scaled = curvature * (anisotropy * -2.0 * curvature.trace().reciprocal());
    scaled.shifted(isotropic)
}
