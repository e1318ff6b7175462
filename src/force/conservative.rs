// SPDX-License-Identifier: MIT OR Apache-2.0
//! The terms that make force and torques the complete gradient of the elastic energy (docs/theory.md, section 7).
//!
//! The energy `U = (2/5) c g(M) delta^(5/2)` depends on the pose through `delta` and through the relative curvature
//! `M`. A force along `n` is the first part of its gradient; the second, of relative order `delta/R`, is here.
//! With `V_k = W_k^-1` the Weingarten maps and `P = dg/dM`, the section's expressions become
//!
//! ```text
//! gamma_k  = [ tr(P V_k) s_k + 2 P V_k s_k ] / (2 h_k)        tau_k = (P V_k)_vu - (P V_k)_uv
//! lambda   = (W_i + W_j - delta I)^-1 (gamma_i + gamma_j)
//! ```

use super::hertz_factors::Factors;
use crate::real::Real;
use crate::vector::{Symmetric2, Vector2};

/// What the gradient needs of one body at the contact, in the tangent basis of the normal.
#[derive(Clone, Copy, Debug)]
pub struct BodyAtContact<T = f64> {
    /// Support function `h`, length.
    pub h: T,
    /// `1/h`.
    pub inverse_h: T,
    /// Tangent components of the witness point from the centre, `s`.
    pub witness: Vector2<T>,
    /// Weingarten map `V`, 1/length.
    pub weingarten: Symmetric2<T>,
    /// `W = V^-1`, length.
    pub inverse_weingarten: Symmetric2<T>,
}

/// The additional terms of one body: subtract `scale` times them, see [`additional_torque`].
#[derive(Clone, Copy, Debug)]
pub struct BodyGradient<T = f64> {
    /// `gamma`: change of `g` with the normal.
    pub gamma: Vector2<T>,
    /// `tau`: change of `g` with a twist of the body about the normal.
    pub twist: T,
}

/// `P = dg/dM` divided by `g`.
#[inline(always)]
pub fn curvature_gradient<T: Real>(
    curvature: Symmetric2<T>,
    factors: &Factors<T>,
) -> Symmetric2<T> {
    // d ln g = -(1/4) M^-1 + (ln phi)'(w) (2/T I - M^-1),  (ln phi)'(w) = sigma/2
    let slope = factors.sigma * 0.5;
    let inverse = curvature.adjugate() * curvature.determinant().reciprocal();
    (inverse * -(slope + 0.25)).shifted(factors.sigma * curvature.trace().reciprocal())
}

/// `gamma_k` and `tau_k` of one body, divided by `g`.
#[inline(always)]
pub fn body_gradient<T: Real>(p: Symmetric2<T>, body: &BodyAtContact<T>) -> BodyGradient<T> {
    let v = body.weingarten;
    // Entries of P V, which is not symmetric.
    let uu = p.uu.multiply_add(v.uu, p.uv * v.uv);
    let uv = p.uu.multiply_add(v.uv, p.uv * v.vv);
    let vu = p.uv.multiply_add(v.uu, p.vv * v.uv);
    let vv = p.uv.multiply_add(v.uv, p.vv * v.vv);
    let s = body.witness;
    let half = body.inverse_h * 0.5;
    // tr(P V) I + 2 P V
    let (diagonal_u, diagonal_v) = (uu + uu + uu + vv, uu + vv + vv + vv);
    let s_half = s * half;
    let (uv2, vu2) = (uv + uv, vu + vu);
    BodyGradient {
        gamma: Vector2::new(
            diagonal_u.multiply_add(s_half.u, uv2 * s_half.v),
            diagonal_v.multiply_add(s_half.v, vu2 * s_half.u),
        ),
        twist: vu - uv,
    }
}

/// How the common normal answers.
#[derive(Clone, Copy, Debug)]
pub struct NormalResponse<T = f64> {
    /// `lambda = (W_i + W_j - delta I)^-1 (gamma_i + gamma_j)`.
    pub lambda: Vector2<T>,
    /// Half of the part of `delta` that was left out of the matrix; 0 but for the deepest contacts. Each body's torque takes
    /// it times `n x lambda`, or the torques would not balance. `None` where it is known to be 0.
    pub half_excess: Option<T>,
}

impl<T: Real> NormalResponse<T> {
    /// With nothing left out.
    #[inline(always)]
    pub fn exactly(lambda: Vector2<T>) -> Self {
        NormalResponse {
            lambda,
            half_excess: None,
        }
    }
}

/// `lambda` from the radii `W_i + W_j` and the sum of both `gamma`.
///
/// Where the contact is so deep that the matrix is nearly singular, or not positive, the normal itself is not unique
/// and Hertz' law has ended: the smallest eigenvalue is then kept above a twentieth of that of `W_i + W_j`.
#[inline(always)]
pub fn normal_response<T: Real>(
    radii: Symmetric2<T>,
    penetration: T,
    gamma: Vector2<T>,
) -> NormalResponse<T> {
    let mean = radii.trace() * 0.5;
    let half_difference = (radii.uu - radii.vv) * 0.5;
    let radius = (half_difference * half_difference + radii.uv * radii.uv).sqrt();
    let smallest = radii.determinant() / (mean + radius);
    let shift = penetration.min(smallest * 0.95);
    let m = radii.shifted(-shift);
    NormalResponse {
        lambda: m.adjugate().apply(gamma) * m.determinant().reciprocal(),
        half_excess: Some((penetration - shift) * 0.5),
    }
}

/// The additional torque of one body in the basis `(u, v, n)`, divided by `U'`: to be subtracted times `U'`.
///
/// `-s x lambda + n x (W lambda - gamma) + tau n`, where the normal component of `s` is `h`.
#[inline(always)]
pub fn additional_torque<T: Real>(
    body: &BodyAtContact<T>,
    own: &BodyGradient<T>,
    response: &NormalResponse<T>,
) -> (Vector2<T>, T) {
    let s = body.witness;
    let lambda = response.lambda;
    let q = body.inverse_weingarten.apply(lambda) - own.gamma;
    let q = match response.half_excess {
        Some(half) => q + lambda * half,
        None => q,
    };
    // s x lambda = (s_t + h n) x lambda: n x (u, v) = (-v, u); s_t x lambda = (s_u l_v - s_v l_u) n.
    let tangent = Vector2::new(
        body.h.multiply_subtract(lambda.v, q.v),
        body.h.negative_multiply_add(lambda.u, q.u),
    );
    let normal =
        s.v.multiply_add(lambda.u, s.u.negative_multiply_add(lambda.v, own.twist));
    (tangent, normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radii of 2 and 5 in any directions: the response of each is its own, with the penetration up to 0.95 of the smaller one.
    #[test]
    fn the_normal_answers_along_the_principal_directions() {
        for angle in [0.0f64, 0.4, 0.8, 2.1] {
            let (s, c) = angle.sin_cos();
            let radii = Symmetric2::new(
                2.0 * c * c + 5.0 * s * s,
                -3.0 * s * c,
                2.0 * s * s + 5.0 * c * c,
            );
            for (penetration, shift) in [(0.3, 0.3), (1.89, 1.89), (1.96, 1.9), (4.0, 1.9)] {
                let gamma = Vector2::new(c * 7.0 - s * 11.0, s * 7.0 + c * 11.0);
                let found = normal_response(radii, penetration, gamma);
                let (along, across) = (7.0 / (2.0 - shift), 11.0 / (5.0 - shift));
                let wanted = Vector2::new(c * along - s * across, s * along + c * across);
                let apart = found.lambda - wanted;
                assert!(
                    apart.dot(apart).sqrt() < 1e-12 * along,
                    "{angle}, {penetration}: {:?} {wanted:?}",
                    found.lambda
                );
                let excess = found.half_excess.map_or(0.0, |half| 2.0 * half);
                assert!((excess - (penetration - shift)).abs() < 1e-14);
            }
        }
    }
}
