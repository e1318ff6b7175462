// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vectors, quaternions, and the few formulas of ellipsoids that the expectations need, apart from the library's own.

pub type Vector = [f64; 3];
/// (w, x, y, z), body to world.
pub type Quaternion = [f64; 4];

pub const IDENTITY: Quaternion = [1.0, 0.0, 0.0, 0.0];

pub fn add(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| a[k] + b[k])
}

pub fn sub(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| a[k] - b[k])
}

pub fn scale(s: f64, a: Vector) -> Vector {
    a.map(|x| s * x)
}

pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

pub fn unit(a: Vector) -> Vector {
    scale(1.0 / length(a), a)
}

pub fn rotate(q: Quaternion, v: Vector) -> Vector {
    let axis = [q[1], q[2], q[3]];
    let t = scale(2.0, cross(axis, v));
    add(add(v, scale(q[0], t)), cross(axis, t))
}

pub fn unrotate(q: Quaternion, v: Vector) -> Vector {
    rotate([q[0], -q[1], -q[2], -q[3]], v)
}

/// First `q`, then `p`.
pub fn compose(p: Quaternion, q: Quaternion) -> Quaternion {
    let (a, b) = ([p[1], p[2], p[3]], [q[1], q[2], q[3]]);
    let v = add(add(scale(p[0], b), scale(q[0], a)), cross(a, b));
    normalise([p[0] * q[0] - dot(a, b), v[0], v[1], v[2]])
}

pub fn normalise(q: Quaternion) -> Quaternion {
    let n = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / n)
}

pub fn about(axis: Vector, angle: f64) -> Quaternion {
    let u = unit(axis);
    let (s, c) = (angle / 2.0).sin_cos();
    [c, s * u[0], s * u[1], s * u[2]]
}

/// Two unit vectors that make a right-handed frame with the unit vector `n` before them.
pub fn tangents(n: Vector) -> (Vector, Vector) {
    let helper = if n[0].abs() < 0.6 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    let u = unit(cross(n, helper));
    (u, cross(n, u))
}

/// The axes of a body in the world.
pub fn body_axes(q: Quaternion) -> [Vector; 3] {
    std::array::from_fn(|k| rotate(q, std::array::from_fn(|c| f64::from(u8::from(c == k)))))
}

/// Angular velocity of a solid ellipsoid from its angular momentum, both in the world frame.
pub fn angular_velocity(mass: f64, a: Vector, q: Quaternion, momentum: Vector) -> Vector {
    let (body, moments) = (unrotate(q, momentum), inertia(mass, a));
    rotate(q, std::array::from_fn(|k| body[k] / moments[k]))
}

/// Angular momentum of a solid ellipsoid, world frame.
pub fn angular_momentum(mass: f64, a: Vector, q: Quaternion, velocity: Vector) -> Vector {
    let (body, moments) = (unrotate(q, velocity), inertia(mass, a));
    rotate(q, std::array::from_fn(|k| moments[k] * body[k]))
}

/// Mass of a solid ellipsoid.
pub fn mass(density: f64, a: Vector) -> f64 {
    density * 4.0 / 3.0 * std::f64::consts::PI * a[0] * a[1] * a[2]
}

/// Principal moments of a solid ellipsoid.
pub fn inertia(mass: f64, a: Vector) -> Vector {
    let s = a.map(|x| x * x);
    [s[1] + s[2], s[0] + s[2], s[0] + s[1]].map(|x| mass / 5.0 * x)
}

/// Surface point relative to the centre whose outward normal is `n`.
pub fn surface_point(a: Vector, q: Quaternion, n: Vector) -> Vector {
    let m = unrotate(q, n);
    let z: Vector = std::array::from_fn(|k| a[k] * m[k]);
    rotate(q, std::array::from_fn(|k| a[k] * z[k] / length(z)))
}

/// 2 x 2 curvature matrix at the surface point with normal `n`, in the tangent frame (u, v): xx, xy, yy.
/// From the Hessian of x^2/a^2 + y^2/b^2 + z^2/c^2.
pub fn curvature(a: Vector, q: Quaternion, n: Vector, u: Vector, v: Vector) -> [f64; 3] {
    let point = unrotate(q, surface_point(a, q, n));
    let gradient = length(std::array::from_fn(|k| point[k] / (a[k] * a[k])));
    let form = |s: Vector, t: Vector| {
        let (s, t) = (unrotate(q, s), unrotate(q, t));
        (0..3).map(|k| s[k] * t[k] / (a[k] * a[k])).sum::<f64>() / gradient
    };
    [form(u, u), form(u, v), form(v, v)]
}

/// k of F = k delta^(3/2) for two ellipsoids whose common normal is `n` (from the first to the second).
pub fn hertz_stiffness(
    modulus: f64,
    one: (Vector, Quaternion),
    other: (Vector, Quaternion),
    n: Vector,
) -> f64 {
    let (u, v) = tangents(n);
    let (p, q) = (
        curvature(one.0, one.1, n, u, v),
        curvature(other.0, other.1, scale(-1.0, n), u, v),
    );
    stiffness_of(modulus, std::array::from_fn(|k| 0.5 * (p[k] + q[k])))
}

/// The same from half the sum of the two curvature matrices: xx, xy, yy.
pub fn stiffness_of(modulus: f64, m: [f64; 3]) -> f64 {
    let (mean, radius) = (
        0.5 * (m[0] + m[2]),
        (0.25 * (m[0] - m[2]).powi(2) + m[1] * m[1]).sqrt(),
    );
    let b = mean + radius;
    let a = (m[0] * m[2] - m[1] * m[1]) / b;
    4.0 / 3.0 * modulus / (2.0 * (a * b).sqrt()).sqrt() * force_factor(b / a)
}

/// F2^(-3/2) at B/A, by bisection on b/a with Legendre's integrals from the arithmetic-geometric mean.
pub fn force_factor(ratio: f64) -> f64 {
    if ratio < 1.0 + 1e-6 {
        return 1.0;
    }
    let parts = |k: f64| {
        let (big_k, big_e) = elliptic(k);
        (big_e / (k * k) - big_k, big_k - big_e, big_k)
    };
    let (mut low, mut high) = (1.0 / ratio, 1.0);
    for _ in 0..100 {
        let middle = f64::sqrt(low * high);
        let (p, q, _) = parts(middle);
        if p / q > ratio {
            low = middle;
        } else {
            high = middle;
        }
    }
    let k = low;
    let (p, q, big_k) = parts(k);
    let f1 = (4.0 / (std::f64::consts::PI * (1.0 - k * k)) * k.powf(1.5) * (p * q).sqrt()).cbrt();
    (2.0 / std::f64::consts::PI * k.sqrt() * big_k / f1).powf(-1.5)
}

/// K and E with complementary modulus k.
pub fn elliptic(k: f64) -> (f64, f64) {
    let (mut a, mut g, mut c2) = (1.0, k, 1.0 - k * k);
    let (mut sum, mut power) = (0.5 * c2, 0.5);
    for _ in 0..60 {
        let (next_a, next_g) = (0.5 * (a + g), f64::sqrt(a * g));
        c2 = 0.25 * (a - g) * (a - g);
        power *= 2.0;
        sum += power * c2;
        a = next_a;
        g = next_g;
        if c2 < 1e-34 {
            break;
        }
    }
    let big_k = std::f64::consts::FRAC_PI_2 / a;
    (big_k, big_k * (1.0 - sum))
}

/// Effective mass along `n` at points `r_i`, `r_j` of two free rigid ellipsoids.
pub fn effective_mass(bodies: [(f64, Vector, Quaternion, Vector); 2], n: Vector) -> f64 {
    let inverse: f64 = bodies
        .iter()
        .map(|&(mass, a, q, arm)| {
            let w = unrotate(q, cross(arm, n));
            let moments = inertia(mass, a);
            1.0 / mass + (0..3).map(|k| w[k] * w[k] / moments[k]).sum::<f64>()
        })
        .sum();
    1.0 / inverse
}

/// Perram and Wertheim's contact function: below 1 the ellipsoids overlap, above 1 they are apart.
pub fn perram_wertheim(
    one: (Vector, Quaternion, Vector),
    other: (Vector, Quaternion, Vector),
) -> f64 {
    let shape = |(a, q): (Vector, Quaternion)| {
        let mut s = [[0.0; 3]; 3];
        for (axis, a) in body_axes(q).into_iter().zip(a) {
            let axis = scale(a, axis);
            for r in 0..3 {
                for c in 0..3 {
                    s[r][c] += axis[r] * axis[c];
                }
            }
        }
        s
    };
    let (si, sj) = (shape((one.0, one.1)), shape((other.0, other.1)));
    let d = sub(other.2, one.2);
    let value = |lambda: f64| {
        let m: [Vector; 3] = std::array::from_fn(|r| {
            std::array::from_fn(|c| (1.0 - lambda) * si[r][c] + lambda * sj[r][c])
        });
        let cofactor = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
        let determinant = dot(m[0], cofactor[0]);
        // the inverse's rows are the columns of the cofactors
        let y: Vector = std::array::from_fn(|r| {
            (0..3).map(|c| cofactor[c][r] * d[c]).sum::<f64>() / determinant
        });
        lambda * (1.0 - lambda) * dot(d, y)
    };
    // concave in lambda: golden section
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = (0.0, 1.0);
    let (mut x, mut y) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut fx, mut fy) = (value(x), value(y));
    for _ in 0..120 {
        if fx > fy {
            (high, y, fy) = (y, x, fx);
            x = high - ratio * (high - low);
            fx = value(x);
        } else {
            (low, x, fx) = (x, y, fy);
            y = low + ratio * (high - low);
            fy = value(y);
        }
    }
    fx.max(fy)
}

/// SplitMix64: the same scenes on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    pub fn vector<const N: usize>(&mut self, low: f64, high: f64) -> [f64; N] {
        std::array::from_fn(|_| self.between(low, high))
    }

    pub fn direction(&mut self) -> Vector {
        loop {
            let v: Vector = self.vector(-1.0, 1.0);
            let n = length(v);
            if n > 1e-3 && n < 1.0 {
                return scale(1.0 / n, v);
            }
        }
    }

    pub fn quaternion(&mut self) -> Quaternion {
        loop {
            let q: Quaternion = self.vector(-1.0, 1.0);
            let n = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if n > 1e-2 && n < 1.0 {
                return normalise(q);
            }
        }
    }
}

#[test]
fn both_versions_force_factor_is_that_of_the_reference() {
    let table = include_str!("../../validation/reference/hertz_factors.csv");
    let mut rows = 0;
    for line in table.lines().skip(1) {
        let values: Vec<f64> = line.split(',').map(|w| w.parse().unwrap()).collect();
        assert!(
            (force_factor(values[0]) / values[4] - 1.0).abs() < 1e-6,
            "B/A = {}",
            values[0]
        );
        rows += 1;
    }
    assert!(rows > 200);
}
