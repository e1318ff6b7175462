// SPDX-License-Identifier: MIT OR Apache-2.0
//! Are the contacts with cylinders, cones and spheres all of the places where a body's surface is deepest in the wall? The reference climbs
//! on the surface of the body, from very many places, and shares nothing with the library but the depth of a point.

use crate::support::brute_force::witness;
use crate::support::random::Stream;
use crate::support::scene::{body, laws, rotation, vector, Rotation, Vector};
use ellgran::contact::{prepare_body, Body, Laws, Step};
use ellgran::simd::InstructionSet;
use ellgran::vector::Vector3;
use ellgran::walls::{
    compute_wall, End, Motion, ShapeParameters, Side, Wall, WallInput, WallOutput,
};
use nalgebra::{Matrix2, Matrix3, Matrix3x2};

/// Of the walls at its point; the slopes of cones are up to 3.
const RADIUS: f64 = 1.0;

/// A round wall about z, seen from one side.
#[derive(Clone, Copy, Debug)]
pub enum Surface {
    /// Of radius 1 at the origin, growing with z by so much; a cylinder at 0.
    Cone { slope: f64 },
    /// About the origin.
    Sphere,
}

#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub surface: Surface,
    pub within: bool,
}

/// How deep a point is in the wall, and the first and second derivatives with the point.
struct Depth {
    value: f64,
    slope: Vector,
    bend: Matrix3<f64>,
}

impl Place {
    fn depth(&self, p: Vector) -> Depth {
        let sign = if self.within { 1.0 } else { -1.0 };
        match self.surface {
            Surface::Cone { slope } => {
                let c = sign / slope.hypot(1.0);
                let across = Vector::new(p.x, p.y, 0.0);
                let distance = across.norm();
                let u = across / distance;
                let t = Vector::new(-u.y, u.x, 0.0);
                Depth {
                    value: c * (distance - RADIUS - slope * p.z),
                    slope: (u - Vector::z() * slope) * c,
                    bend: t * t.transpose() * (c / distance),
                }
            }
            Surface::Sphere => {
                let distance = p.norm();
                let n = p / distance;
                Depth {
                    value: sign * (distance - RADIUS),
                    slope: n * sign,
                    bend: (Matrix3::identity() - n * n.transpose()) * (sign / distance),
                }
            }
        }
    }
}

/// A place of a body's surface where it is deepest.
#[derive(Clone, Copy, Debug)]
struct Deepest {
    depth: f64,
    /// Out of the body.
    normal: Vector,
    point: Vector,
    /// By which share of its bend in a plane the depth bends at least: near 0 two places become one.
    bend: f64,
}

impl Deepest {
    /// The place of the wall.
    fn on_wall(&self) -> Vector {
        self.point - self.normal * self.depth
    }
}

/// A body as the image of a ball.
struct Image {
    centre: Vector,
    matrix: Matrix3<f64>,
}

impl Image {
    fn of(b: &Body) -> Self {
        let turn = rotation(b.quaternion);
        Image {
            centre: Vector::from(b.position),
            matrix: turn.to_rotation_matrix().matrix()
                * Matrix3::from_diagonal(&b.semi_axes.into()),
        }
    }

    fn point(&self, w: Vector) -> Vector {
        self.centre + self.matrix * w
    }

    /// From a place of the ball's surface up to where the depth is a maximum, by Newton's method within a radius that shrinks where the
    /// depth does not grow; from a saddle along its rise.
    fn climb(&self, place: &Place, start: Vector) -> Option<Deepest> {
        let (mut w, mut radius) = (start, 0.3);
        for _ in 0..200 {
            let at = place.depth(self.point(w));
            let slope = self.matrix.tr_mul(&at.slope);
            let aside = if w.x.abs() < 0.6 {
                Vector::x()
            } else {
                Vector::y()
            };
            let u = w.cross(&aside).normalize();
            let t = Matrix3x2::from_columns(&[u, w.cross(&u)]);
            let flat = w.dot(&slope);
            let bend: Matrix2<f64> =
                t.transpose() * self.matrix.tr_mul(&(at.bend * self.matrix)) * t
                    - Matrix2::identity() * flat;
            let g = t.transpose() * slope;
            let eigen = bend.symmetric_eigen();
            let mut step = nalgebra::Vector2::zeros();
            for k in 0..2 {
                let (value, direction) = (eigen.eigenvalues[k], eigen.eigenvectors.column(k));
                let along = direction.dot(&g);
                let length = if value < 0.0 && (along / value).abs() < radius {
                    -along / value
                } else {
                    radius.copysign(along)
                };
                step += direction * length;
            }
            let largest = eigen.eigenvalues.max();
            if largest < 0.0 && step.norm() < 1e-9 {
                return Some(Deepest {
                    depth: at.value,
                    normal: at.slope,
                    point: self.point(w),
                    bend: -largest / flat,
                });
            }
            let next = (w + t * step).normalize();
            // what rounding makes of a depth
            let noise = 1e-15 * (self.point(w).norm() + RADIUS);
            if place.depth(self.point(next)).value > at.value - noise {
                w = next;
            } else {
                radius *= 0.5;
                if radius < 1e-12 {
                    return None;
                }
            }
        }
        None
    }

    /// All of the maxima that climbs from `count` places find, those above 0.
    fn deepest(&self, place: &Place, count: usize) -> Vec<Deepest> {
        let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        let mut found: Vec<Deepest> = vec![];
        for k in 0..count {
            let z = 1.0 - (2 * k + 1) as f64 / count as f64;
            let (sin, cos) = (golden * k as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let Some(d) = self.climb(place, Vector::new(r * cos, r * sin, z)) else {
                continue;
            };
            let known = |o: &Deepest| (o.point - d.point).norm() < 1e-6 * self.matrix.norm();
            if d.depth > 0.0 && !found.iter().any(known) {
                found.push(d);
            }
        }
        found.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        found
    }
}

impl Place {
    /// Depths and normals out of a body of its deepest places that lie between two heights of the wall; `None` where two of them are about to
    /// become one, or one is about to appear or to vanish.
    pub fn contacts_between(&self, b: &Body, bounds: [f64; 2]) -> Option<Vec<(f64, Vector)>> {
        let found = Image::of(b).deepest(self, 150);
        let is_clear = |d: &Deepest| {
            let z = d.on_wall().z;
            let to_bound = bounds.map(|bound| (z - bound).abs());
            d.bend > 5e-3 && d.depth > 1e-9 && to_bound[0].min(to_bound[1]) > 1e-6
        };
        let is_there = |d: &&Deepest| {
            let z = d.on_wall().z;
            // Beyond the tip there is no wall.
            bounds[0] < z && z < bounds[1] && radius_at(self.surface, z) > 0.0
        };
        let contacts = found.iter().filter(is_there);
        (found.iter().all(is_clear)).then(|| contacts.map(|d| (d.depth, d.normal)).collect())
    }
}

/// The radius at a height.
fn radius_at(surface: Surface, z: f64) -> f64 {
    match surface {
        Surface::Cone { slope } => RADIUS + slope * z,
        Surface::Sphere => RADIUS,
    }
}

/// The library's wall of this kind, without ends.
fn wall_of(place: &Place) -> Wall {
    let mut parameters = ShapeParameters {
        point: Vector3::ZERO,
        axis: Vector3::new(0.0, 0.0, 1.0),
        radii: [RADIUS; 2],
        bounds: [f64::NEG_INFINITY, f64::INFINITY],
        ends: [End::None; 2],
        side: if place.within {
            Side::Inside
        } else {
            Side::Outside
        },
    };
    let name = match place.surface {
        Surface::Sphere => "sphere",
        Surface::Cone { slope: 0.0 } => "cylinder",
        Surface::Cone { slope } => {
            // from the tip to far away
            let ends = [-RADIUS / slope, 20.0 / slope];
            let [low, high] = if slope > 0.0 {
                ends
            } else {
                [ends[1], ends[0]]
            };
            parameters.bounds = [low, high];
            parameters.radii = [low, high].map(|z| radius_at(place.surface, z).max(0.0));
            "cone"
        }
    };
    let mut wall = Wall::new();
    wall.add_shape(name, &parameters).unwrap();
    wall.records_contacts = true;
    wall
}

/// Depths and normals out of the body of the library's contacts, the deepest first.
pub fn contacts(wall: &mut Wall, laws: &Laws, b: &Body, set: InstructionSet) -> Vec<(f64, Vector)> {
    let particle = prepare_body(b, Some(1)).unwrap();
    let ball = |_: usize| Some((particle.position, particle.radius));
    let near = wall.find_near(&Motion::REST, 1, ball).len();
    let length = wall.histories(laws).length();
    compute_wall(
        wall,
        &WallInput {
            laws,
            wall_type: 1,
            near: &[particle][..near],
            motion: &Motion::REST,
            step: &Step {
                time_step: 1e-3,
                advance_history: true,
            },
            instruction_set: set,
        },
        &mut WallOutput {
            acts_on: &|_| true,
            histories: &mut vec![0.0; length],
            forces: &mut [[0.0; 3]],
            torques: &mut [[0.0; 3]],
        },
        None,
    )
    .unwrap();
    let mut found: Vec<_> = (wall.contacts().iter())
        .map(|c| (c.penetration, -vector(c.normal)))
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
}

/// Semi-axes of a needle, a lens or neither, the largest 1.
pub fn semi_axes(stream: &mut Stream) -> [f64; 3] {
    let mut a = stream.semi_axes(30.0);
    let kind = stream.uniform(0.0, 3.0);
    a.sort_by(f64::total_cmp);
    if kind < 1.0 {
        a[1] = a[0];
    } else if kind < 2.0 {
        a[1] = a[2];
    }
    a.rotate_left(stream.uniform(0.0, 3.0) as usize);
    a
}

/// Any rotation, or one with the longest axis along a direction, more or less.
pub fn lying(axes: [f64; 3], along: Vector, stream: &mut Stream) -> Rotation {
    let turn = stream.rotation();
    if stream.uniform(0.0, 1.0) < 0.5 {
        return turn;
    }
    let k = (0..3).max_by(|a, b| axes[*a].total_cmp(&axes[*b])).unwrap();
    let mut long = Vector::zeros();
    long[k] = 1.0;
    let aside = stream.direction() * stream.log_uniform(1e-3, 0.5);
    let to = Rotation::rotation_between(&(turn * long), &(along + aside));
    to.map_or(turn, |to| to * turn)
}

/// A body that is by a part of its smallest semi-axis beyond a place of the wall, along the normal there; every other one lies along the
/// circle through it, more or less.
fn touching(place: &Place, stream: &mut Stream) -> Body {
    let size = stream.log_uniform(0.02, 0.95);
    let axes = semi_axes(stream).map(|a| a * size);
    let (sin, cos) = stream.uniform(0.0, std::f64::consts::TAU).sin_cos();
    let u = Vector::new(cos, sin, 0.0);
    let p = match place.surface {
        Surface::Sphere => stream.direction() * RADIUS,
        Surface::Cone { slope: 0.0 } => u * RADIUS + Vector::z() * stream.uniform(-1.0, 1.0),
        Surface::Cone { slope } => {
            let radius = stream.log_uniform(0.1, 2.0);
            u * radius + Vector::z() * ((radius - RADIUS) / slope)
        }
    };
    let n = place.depth(p).slope;
    let turn = lying(axes, n.cross(&Vector::z()), stream);
    let mut b = body(axes, Vector::zeros(), turn);
    let smallest = axes.into_iter().fold(f64::INFINITY, f64::min);
    let depth = smallest * stream.log_uniform(1e-6, 0.1);
    let point = witness(&b, &n);
    b.position = (p + n * depth - point).into();
    b
}

/// Whether depths and normals are those of the reference, to the rounding of both.
pub fn are_same(found: &[(f64, Vector)], expected: &[(f64, Vector)]) -> bool {
    found.len() == expected.len()
        && (found.iter().zip(expected))
            .all(|(a, b)| (a.0 - b.0).abs() < 1e-10 && (a.1 - b.1).norm() < 1e-4)
}

/// The scalar path, and the one that the machine would take.
pub fn instruction_sets() -> [InstructionSet; 2] {
    let available = |set: &InstructionSet| set.is_available();
    let best = InstructionSet::ALL.into_iter().rfind(available);
    [InstructionSet::Scalar, best.unwrap()]
}

#[test]
fn every_deepest_place_is_a_contact() {
    let laws = laws(&["hertz 1e5 0.3"]);
    let mut stream = Stream::new(5);
    let cones = [0.0, 0.1, 0.3, 1.0, 3.0, -0.5].map(|slope| Surface::Cone { slope });
    for surface in cones.into_iter().chain([Surface::Sphere]) {
        for within in [true, false] {
            let place = Place { surface, within };
            let mut wall = wall_of(&place);
            let mut counts = [0; 3];
            for _ in 0..1000 {
                let b = touching(&place, &mut stream);
                // From outside without the tip, which is an end (`round_solids.rs`).
                let [x, y, z] = b.position;
                let largest = b.semi_axes.into_iter().fold(0.0, f64::max);
                let is_before = place.depth(Vector::new(x, y, z)).value < 0.0
                    && (within || x.hypot(y) > largest);
                let whole = [f64::NEG_INFINITY, f64::INFINITY];
                let expected = place.contacts_between(&b, whole);
                let Some(expected) = expected.filter(|_| is_before) else {
                    continue;
                };
                for set in instruction_sets() {
                    let found = contacts(&mut wall, &laws, &b, set);
                    assert!(
                        are_same(&found, &expected),
                        "{place:?}, {}: {found:?} where {expected:?} is expected, {b:?}",
                        set.name()
                    );
                }
                counts[expected.len()] += 1;
            }
            println!("{place:?}: {counts:?} poses by their contacts");
            assert!(counts[1] > 500, "{place:?}: {counts:?}");
            assert_eq!(counts[2] > 100, within, "{place:?}: {counts:?}");
        }
    }
}

/// Of a needle that lies nearly along a funnel both ends touch, the normals of which are a tenth of a radian apart. The shallower contact was
/// once left out.
#[test]
fn a_needle_along_a_funnel_touches_with_both_ends() {
    let place = Place {
        surface: Surface::Cone { slope: 0.3 },
        within: true,
    };
    let turn = [
        0.190_295_924_531,
        0.213_580_958_765,
        0.485_950_244_756,
        -0.825_846_834_940,
    ];
    let at = Vector::new(0.046_618_013_022, 0.773_920_571_624, -0.577_632_685_497);
    let needle = body([0.25, 0.025, 0.05], at, rotation(turn));
    let laws = laws(&["hertz 1e5 0.3"]);
    for set in instruction_sets() {
        let found = contacts(&mut wall_of(&place), &laws, &needle, set);
        let depths: Vec<f64> = found.iter().map(|c| c.0).collect();
        assert_eq!(depths.len(), 2, "{}: {depths:?}", set.name());
        assert!((depths[0] - 9.892_256_685e-5).abs() < 1e-11, "{depths:?}");
        assert!((depths[1] - 5.005_145_939e-5).abs() < 1e-11, "{depths:?}");
    }
}
