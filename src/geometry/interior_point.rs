// SPDX-License-Identifier: MIT OR Apache-2.0
//! A point inside an ellipsoid (or ellipse), or outside of it: the direction in which the surface is nearest.

#[cfg(not(feature = "std"))]
use crate::real::{Functions, Real};

/// Outward normal, not of unit length, of the surface point nearest to the interior point `y`, both along the principal
/// axes; `semi_axes` > 0. `None` if the point is not inside.
pub fn nearest_normal<const N: usize>(semi_axes: [f64; N], y: [f64; N]) -> Option<[f64; N]> {
    let inside: f64 = (0..N).map(|k| (y[k] / semi_axes[k]).powi(2)).sum();
    (inside < 1.0).then(|| normal_towards(semi_axes, y))
}

/// The same for a point anywhere.
///
/// The nearest point is `p_k = a_k^2 y_k/(t + a_k^2)` with `t` the largest root of `sum (a_k y_k/(t + a_k^2))^2 = 1`. The
/// sum falls and is convex right of its last pole, so Newton's method from the left rises to the root.
#[cfg_attr(not(feature = "std"), inline(never))]
pub fn normal_towards<const N: usize>(semi_axes: [f64; N], y: [f64; N]) -> [f64; N] {
    let least = semi_axes.iter().copied().fold(f64::INFINITY, f64::min);
    let is_least = |k: usize| semi_axes[k] == least;
    let along_least = (0..N)
        .filter(|&k| is_least(k))
        .map(|k| y[k] * y[k])
        .sum::<f64>()
        .sqrt();
    // With s = t + least^2 > 0 no difference of near numbers is left but in the axes' own squares.
    let gap = |k: usize| (semi_axes[k] - least) * (semi_axes[k] + least);
    let sums = |s: f64| {
        let (mut value, mut slope) = (-1.0, 0.0);
        for k in 0..N {
            if y[k] != 0.0 {
                let bottom = s + gap(k);
                let term = (semi_axes[k] * y[k] / bottom).powi(2);
                value += term;
                slope -= 2.0 * term / bottom;
            }
        }
        (value, slope)
    };
    let mut s = least * along_least;
    if s == 0.0 {
        // On the plane (or axis) of symmetry: the others alone may reach the root, else the nearest points are a pair, and
        // either serves.
        let others: f64 = (0..N)
            .filter(|&k| !is_least(k) && y[k] != 0.0)
            .map(|k| (semi_axes[k] * y[k] / gap(k)).powi(2))
            .sum();
        if others <= 1.0 {
            let mut normal = [0.0; N];
            for k in 0..N {
                if !is_least(k) && y[k] != 0.0 {
                    normal[k] = y[k] / gap(k);
                }
            }
            let first = (0..N).find(|&k| is_least(k)).unwrap_or(0);
            normal[first] = (1.0 - others).sqrt() / least;
            return normal;
        }
        s = f64::MIN_POSITIVE.max(1e-14 * least * least);
    }
    for _ in 0..200 {
        let (value, slope) = sums(s);
        let step = -value / slope;
        if !(step > 1e-15 * s) {
            break;
        }
        s += step;
    }
    core::array::from_fn(|k| y[k] / (s + gap(k)))
}

/// The same for the other place of the surface from which the way to an interior point is shortest among those near it: on the other side of the
/// thinnest axis. `None` where there is none, which is where the point is near the surface of a body that is hardly thinner along one axis, or near the ends of a
/// thin one.
///
/// `t` is the root nearest to the pole of the thinnest axis between this and the next one. The sum is convex there, so Newton's method from where
/// that axis alone reaches 1 falls to the root.
#[cfg_attr(not(feature = "std"), inline(never))]
pub fn normal_on_other_side<const N: usize>(semi_axes: [f64; N], y: [f64; N]) -> Option<[f64; N]> {
    let least = (0..N).fold(0, |m, k| if semi_axes[k] < semi_axes[m] { k } else { m });
    let gap = |k: usize| (semi_axes[k] - semi_axes[least]) * (semi_axes[k] + semi_axes[least]);
    let narrowest = (0..N)
        .filter(|k| *k != least)
        .map(gap)
        .fold(f64::INFINITY, f64::min);
    if y[least] == 0.0 {
        // One of a pair.
        let mut normal = nearest_normal(semi_axes, y)?;
        normal[least] = -normal[least];
        return (normal[least] != 0.0).then_some(normal);
    }
    let bottom = |k: usize, s: f64| if k == least { s } else { s + gap(k) };
    let mut s = -semi_axes[least] * y[least].abs();
    for _ in 0..200 {
        if !(s > -narrowest) {
            return None;
        }
        let (mut value, mut slope) = (-1.0, 0.0);
        for k in 0..N {
            if y[k] != 0.0 {
                let bottom = bottom(k, s);
                let term = (semi_axes[k] * y[k] / bottom).powi(2);
                value += term;
                slope -= 2.0 * term / bottom;
            }
        }
        if !(slope > 0.0) {
            return None;
        }
        let step = value / slope;
        if !(step > 1e-15 * s.abs()) {
            break;
        }
        s -= step;
    }
    Some(core::array::from_fn(|k| y[k] / bottom(k, s)))
}

#[cfg(test)]
mod tests {
    use super::{nearest_normal, normal_on_other_side, normal_towards};

    fn depth(a: [f64; 3], y: [f64; 3], n: [f64; 3]) -> f64 {
        let size = n.iter().map(|c| c * c).sum::<f64>().sqrt();
        let h = (0..3)
            .map(|k| (a[k] * n[k] / size).powi(2))
            .sum::<f64>()
            .sqrt();
        h - (0..3).map(|k| y[k] * n[k] / size).sum::<f64>()
    }

    #[test]
    fn no_direction_is_nearer() {
        let a = [1.0, 0.5, 0.1];
        for y in [
            [0.3, 0.2, 0.05],
            [0.9, 0.0, 0.0],
            [0.0, 0.0, 0.0],
            [0.1, 0.0, 1e-9],
            [0.5, -0.4, 0.0],
            [0.0, 0.49, 0.0],
        ] {
            let n = nearest_normal(a, y).expect("the point is inside");
            let found = depth(a, y, n);
            let mut least = f64::INFINITY;
            for i in 0..200 {
                for j in 0..400 {
                    let (t, p) = (
                        std::f64::consts::PI * (i as f64 + 0.5) / 200.0,
                        std::f64::consts::TAU * j as f64 / 400.0,
                    );
                    let n = [t.cos(), t.sin() * p.cos(), t.sin() * p.sin()];
                    least = least.min(depth(a, y, n));
                }
            }
            assert!(found <= least + 1e-12, "{y:?}: {found} against {least}");
            assert!(found > least - 1e-3, "{y:?}: {found} against {least}");
        }
        assert!(nearest_normal(a, [0.0, 0.51, 0.0]).is_none());
    }

    /// From outside the nearest point is that of the plane which separates the most.
    #[test]
    fn from_outside_no_point_is_nearer() {
        let a = [1.0, 0.5, 0.1];
        for y in [
            [0.3, 0.2, 0.15],
            [1.1, 0.0, 0.0],
            [20.0, 3.0, -1.0],
            [0.0, 0.51, 0.0],
            [0.0, 0.0, 0.1 + 1e-9],
        ] {
            let n = normal_towards(a, y);
            let size = n.iter().map(|c| c * c).sum::<f64>().sqrt();
            let n = n.map(|c| c / size);
            let h = (0..3).map(|k| (a[k] * n[k]).powi(2)).sum::<f64>().sqrt();
            let away: [f64; 3] = core::array::from_fn(|k| y[k] - a[k] * a[k] * n[k] / h);
            let distance = away.iter().map(|c| c * c).sum::<f64>().sqrt();
            assert!(
                (depth(a, y, n) + distance).abs() < 1e-14 * (1.0 + distance),
                "{y:?}"
            );
        }
    }

    /// Of random points in random bodies each minimum that a search over directions finds is one of both, and each of both is one.
    #[test]
    fn both_minima_are_found_and_no_others() {
        let mut random = crate::geometry::random::Random::new(19);
        let (mut pairs, mut single) = (0, 0);
        for _ in 0..300 {
            let a = [0; 3].map(|_| random.uniform(0.2, 1.0));
            let direction = random.direction().to_array();
            let far = random.uniform(0.0, 0.98);
            let y: [f64; 3] = core::array::from_fn(|k| a[k] * direction[k] * far);
            let unit = |n: [f64; 3]| {
                let size = n.iter().map(|c| c * c).sum::<f64>().sqrt();
                n.map(|c| c / size)
            };
            let is_minimum = |n: [f64; 3]| {
                let n = unit(n);
                let value = depth(a, y, n);
                (0..40).all(|k| {
                    let e = random_direction(k);
                    depth(a, y, unit(core::array::from_fn(|m| n[m] + 1e-4 * e[m]))) > value - 1e-15
                })
            };
            let first = normal_towards(a, y);
            assert!(is_minimum(first), "{a:?} {y:?}");
            let other = normal_on_other_side(a, y);
            let mut known = vec![unit(first)];
            if let Some(other) = other {
                assert!(is_minimum(other), "{a:?} {y:?}");
                assert!(depth(a, y, other) >= depth(a, y, first) - 1e-14);
                known.push(unit(other));
                pairs += 1;
            } else {
                single += 1;
            }
            // down from many directions
            for k in 0..12 {
                let mut n = unit(random_direction(k));
                let mut step = 0.3;
                while step > 1e-7 {
                    let lower = (0..40)
                        .map(|m| {
                            let e = random_direction(m);
                            unit(core::array::from_fn(|c| n[c] + step * e[c]))
                        })
                        .min_by(|p, q| depth(a, y, *p).total_cmp(&depth(a, y, *q)))
                        .unwrap();
                    if depth(a, y, lower) < depth(a, y, n) {
                        n = lower;
                    } else {
                        step *= 0.6;
                    }
                }
                let value = depth(a, y, n);
                assert!(
                    known.iter().any(|q| (depth(a, y, *q) - value).abs() < 1e-6),
                    "{a:?} {y:?} {n:?} {value} {known:?}"
                );
            }
        }
        println!("{pairs} with two minima, {single} with one");
        assert!(pairs > 50 && single > 50);
    }

    /// Directions all around, the same ones each time.
    fn random_direction(k: usize) -> [f64; 3] {
        let z = ((k * 7 + 3) % 40) as f64 / 20.0 - 0.975;
        let (sin, cos) = (k as f64 * 2.399_963).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * cos, r * sin, z]
    }
}
