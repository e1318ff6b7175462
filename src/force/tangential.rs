// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tangential force: TFD, Mindlin, linear (THEORY, sections 4 and 5).
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
//! clipped where the elastic part alone reaches the cone (`s = 1`), not where the sum does.

use super::hertz_factors::Factors;
use super::law::{LawConstants, LawKinds};
use super::normal::NormalForce;
use super::parameters::{Displacement, Tangential};
use crate::geometry::{Symmetric2, Vector2};
use crate::real::Real;

/// The tangential force of one contact.
#[derive(Clone, Copy, Debug)]
pub struct TangentialForce<T = f64> {
    /// Force on body `j` in the tangent basis.
    pub force: Vector2<T>,
    /// What of it the tangential displacement makes, without the viscous part: `force` itself where that is none.
    pub elastic_force: Vector2<T>,
    /// What is remembered, in the tangent basis: `xi` (length) for `displacement total`, `zeta` (force) otherwise.
    pub memory: Vector2<T>,
    /// Tangential displacement that the elastic part stands for, in the tangent basis, length.
    pub displacement: Vector2<T>,
    /// The normal stiffness that `displacement rescaled` remembers.
    pub stiffness: T,
    /// Elastic energy of the tangential displacement.
    pub elastic_energy: T,
}

/// Tangential force.
///
/// - `memory`: what is remembered, carried into the tangent basis of now; `remembered_stiffness`: the normal stiffness
///   at the last step (only `displacement rescaled`; 0 for a new contact).
/// - `increment`: the tangential displacement of `j` relative to `i` in this step.
/// - `velocity`: the tangential velocity of `j` relative to `i`.
/// - `curvature`: the relative curvature matrix `M` in the same basis.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub fn tangential_force<T: Real>(
    kinds: &LawKinds,
    c: &LawConstants<T>,
    normal: &NormalForce<T>,
    factors: &Factors<T>,
    curvature: Symmetric2<T>,
    memory: Vector2<T>,
    remembered_stiffness: T,
    increment: Vector2<T>,
    velocity: Vector2<T>,
) -> TangentialForce<T> {
    let zero = normal.force.constant(0.0);
    let one = normal.force.constant(1.0);
    let tiny = normal.force.constant(1e-300);
    let limit = c.friction * normal.force.max(zero);

    // Stiffness matrix C^-1 and its inverse, and the compliance's viscous companion.
    let linear = matches!(kinds.tangential, Tangential::Linear);
    let (stiffness, compliance, kappa_inverse) = if linear {
        let k = c.tangential_stiffness;
        let inverse = one / k.max(tiny);
        (
            Symmetric2::new(k, zero, k),
            Symmetric2::new(inverse, zero, inverse),
            Symmetric2::new(one, zero, one),
        )
    } else {
        let kappa = compliance_matrix(c.kappa0, c.kappa1, factors.sigma, curvature);
        let inverse = kappa.adjugate() * kappa.determinant().reciprocal();
        (
            inverse * normal.stiffness,
            kappa * normal.stiffness.max(tiny).reciprocal(),
            inverse,
        )
    };

    let zeta = match kinds.displacement {
        Displacement::Total => stiffness.apply(memory + increment),
        Displacement::Incremental => memory + stiffness.apply(increment),
        Displacement::Rescaled => {
            let kept = if linear {
                one
            } else {
                (normal.stiffness / remembered_stiffness.max(tiny)).min(one)
            };
            memory * kept + stiffness.apply(increment)
        }
    };

    let square = zeta.dot(zeta);
    let inverse_size = square.max(normal.force.constant(1e-290)).reciprocal_sqrt();
    let size = square * inverse_size;
    let tfd = matches!(kinds.tangential, Tangential::Tfd);
    let most = if tfd { limit * 1.5 } else { limit };
    // Sliding: the elastic part stays on the cone.
    let slides = most.less(size);
    let clip = T::select(slides, most * inverse_size, one);
    let zeta = zeta * clip;
    let (elastic, root, energy_factor) = if tfd {
        // Exactly 1 while sliding: the viscous part goes with sqrt(1 - s), which would make 1e-8 of a rounding.
        let s = T::select(slides, one, (size * most.max(tiny).reciprocal()).min(one));
        let r = (one - s).sqrt();
        // [1 - (1-s)^(3/2)]/s and the work, without cancellation at s -> 0 (r -> 1).
        let next = r + 1.0;
        let inverse = next.reciprocal();
        let factor = (r * next + 1.0) * inverse * (2.0 / 3.0);
        let work = (((r * 0.4 + 0.8) * r + 1.2) * r + 0.6) * (inverse * inverse) * (2.0 / 3.0);
        (zeta * factor, r, work)
    } else {
        (zeta, one, one * 0.5)
    };

    let mut force = elastic;
    if kinds.tangential_viscous {
        let viscous = if linear {
            velocity * c.tangential_damping
        } else {
            let tau = compliance_matrix(c.tau0, c.tau1, factors.sigma, curvature);
            kappa_inverse.apply(tau.apply(kappa_inverse.apply(velocity)))
                * (normal.stiffness * root)
        };
        force = force + viscous;
        let square = force.dot(force);
        let inverse = square.max(normal.force.constant(1e-290)).reciprocal_sqrt();
        force = force * T::select(limit.less(square * inverse), limit * inverse, one);
    }
    let displacement = match kinds.displacement {
        // What zeta was made of, clipped with it.
        Displacement::Total => (memory + increment) * clip,
        _ => compliance.apply(zeta),
    };
    TangentialForce {
        force: force * -one,
        elastic_force: elastic * -one,
        memory: match kinds.displacement {
            Displacement::Total => displacement,
            _ => zeta,
        },
        displacement,
        stiffness: normal.stiffness,
        elastic_energy: displacement.dot(zeta) * energy_factor,
    }
}

/// `x0 I - x1 Beta`, `Beta = I/2 + sigma (2 M/tr M - I)`.
#[inline(always)]
fn compliance_matrix<T: Real>(x0: T, x1: T, sigma: T, curvature: Symmetric2<T>) -> Symmetric2<T> {
    let anisotropy = x1 * sigma;
    let isotropic = x0 - x1 * 0.5 + anisotropy;
    let scaled = curvature * (anisotropy * -2.0 * curvature.trace().reciprocal());
    scaled.shifted(isotropic)
}
