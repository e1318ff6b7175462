// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do two ellipsoids touch? The contact function of J.W. Perram and M.S. Wertheim, J. Comput. Phys. 58 (1985) 409.

use super::scene::{position, rotation};
use ellgran::contact::Body;
use nalgebra::Matrix3;

fn shape_matrix(b: &Body) -> Matrix3<f64> {
    let r = rotation(b.quaternion).to_rotation_matrix();
    let a = nalgebra::Vector3::from(b.semi_axes);
    r.matrix() * Matrix3::from_diagonal(&a.component_mul(&a)) * r.matrix().transpose()
}

/// The largest of `l (1-l) d.[(1-l) S_i + l S_j]^-1 d` over `0 < l < 1`: below 1 the bodies overlap, at 1 they touch,
/// above they are apart. It is the square of the factor by which both must grow to touch.
///
/// The function of `l` is concave; its maximum is found by bisection of the sign of its derivative
/// `n.[(1-l)^2 S_i - l^2 S_j] n`, `n` the solution.
pub fn contact_function(i: &Body, j: &Body) -> f64 {
    let (si, sj) = (shape_matrix(i), shape_matrix(j));
    let d = position(j) - position(i);
    let solve = |l: f64| {
        let m = si * (1.0 - l) + sj * l;
        m.cholesky().expect("shape matrices are positive").solve(&d)
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let l: f64 = 0.5 * (low + high);
        let n = solve(l);
        let slope = (1.0 - l).powi(2) * n.dot(&(si * n)) - l * l * n.dot(&(sj * n));
        if slope > 0.0 {
            low = l;
        } else {
            high = l;
        }
    }
    let l: f64 = 0.5 * (low + high);
    l * (1.0 - l) * d.dot(&solve(l))
}
