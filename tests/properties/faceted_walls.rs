// SPDX-License-Identifier: MIT OR Apache-2.0
//! Walls of triangles: is a flat one the plane in whatever pieces it comes, does a contact go over a fold of any angle without a
//! jump and with force and torque as the gradient of one energy, and do many facets act as the cylinder that they approach?

use std::f64::consts::PI;

use crate::support::motion::Rigid;
use crate::support::random::Stream;
use crate::support::scene::{body, laws, plain, quaternion, rotation, vector, Rotation, Vector};
use ellgran::contact::prepare_body;
use ellgran::contact::staged::{StagedContact, WallSurface};
use ellgran::contact::{Body, Laws};
use ellgran::geometry::cone::{touch_cone, Cone};
use ellgran::geometry::facet_shares::Share;
use ellgran::geometry::triangles::{Feature, Triangle, TriangleSearch};
use ellgran::vector::{Tangent, Vector3};

/// What a wall does to a body.
#[derive(Clone, Copy, Debug)]
pub struct Felt {
    pub energy: f64,
    pub force: Vector,
    pub torque: Vector,
    pub contacts: usize,
}

fn law() -> Laws {
    laws(&["hertz 1e7 0.3 conservative yes"])
}

pub fn felt(laws: &Laws, b: &Body, surfaces: impl Iterator<Item = WallSurface>) -> Felt {
    let i = prepare_body(b, None).unwrap();
    let mut sum = Felt {
        energy: 0.0,
        force: Vector::zeros(),
        torque: Vector::zeros(),
        contacts: 0,
    };
    for wall in surfaces {
        let contact = StagedContact::of_wall(&i, &wall).expect("touching");
        let f = contact
            .normal_force(laws.get(1, 1), b.mass, 0.0)
            .unwrap_or_else(|_| panic!("factors"));
        sum.energy += f.elastic_energy;
        sum.force -= vector(f.force);
        sum.torque += vector(f.torque_i);
        sum.contacts += 1;
    }
    sum
}

pub fn flat(point: Vector3, normal: Vector3, share: Share) -> WallSurface {
    WallSurface {
        point,
        normal,
        direction: Tangent::new(normal).u,
        curvatures: [0.0; 2],
        turning_radii: [f64::INFINITY; 2],
        velocity: Vector3::ZERO,
        velocity_change: Vector3::ZERO,
        share,
    }
}

pub fn on_triangles(laws: &Laws, b: &Body, triangles: &[Triangle]) -> Felt {
    let i = prepare_body(b, None).unwrap();
    let mut search = TriangleSearch::default();
    search.touch(&i.body, i.position, triangles);
    felt(
        laws,
        b,
        search.contacts().iter().map(|c| {
            let face = flat(c.point, c.normal, c.share);
            match c.feature {
                Feature::Face => face,
                Feature::Edge(along) => WallSurface {
                    direction: along.cross(c.normal),
                    turning_radii: [0.0, f64::INFINITY],
                    ..face
                },
                Feature::Corner => WallSurface {
                    turning_radii: [0.0; 2],
                    ..face
                },
            }
        }),
    )
}

/// The plane z = 0.
fn on_plane(laws: &Laws, b: &Body) -> Felt {
    let up = Vector3::new(0.0, 0.0, 1.0);
    felt(
        laws,
        b,
        std::iter::once(flat(Vector3::ZERO, up, Share::WHOLE)),
    )
}

pub fn support(semi_axes: [f64; 3], turn: Rotation, direction: Vector) -> Vector {
    let b = body(semi_axes, Vector::zeros(), turn);
    let i = prepare_body(&b, None).unwrap();
    vector(i.body.support(plain(direction)).point)
}

/// The body whose deepest point towards z = 0 lies over (x, y), so deep.
fn over(semi_axes: [f64; 3], turn: Rotation, [x, y]: [f64; 2], depth: f64) -> Body {
    let s = support(semi_axes, turn, -Vector::z());
    body(semi_axes, Vector::new(x - s.x, y - s.y, -s.z - depth), turn)
}

pub fn point(x: f64, y: f64, z: f64) -> Vector3 {
    Vector3::new(x, y, z)
}

/// A parallelogram as two triangles.
fn face(corner: Vector3, u: Vector3, v: Vector3) -> [Triangle; 2] {
    let far = corner + u + v;
    [[corner, corner + u, far], [corner, far, corner + v]]
}

fn rectangle([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> [Triangle; 2] {
    face(
        point(x0, y0, z),
        point(x1 - x0, 0.0, 0.0),
        point(0.0, y1 - y0, 0.0),
    )
}

const SHAPES: [[f64; 3]; 4] = [
    [1.0, 1.0, 1.0],
    [1.0, 0.5, 0.4],
    [2.0, 0.4, 0.4],
    [1.0, 1.0, 0.2],
];

/// The largest difference from the plane z = 0, of force and torque over the force, where a body's deepest point lies around
/// the origin.
fn apart_from_plane(triangles: &[Triangle], depth: f64) -> f64 {
    let laws = law();
    let mut stream = Stream::new(5);
    let mut worst = 0.0f64;
    for axes in SHAPES {
        for turn in [Rotation::identity(), stream.rotation()] {
            for k in 0..60 {
                // along a line that crosses the seams, and on the seams themselves
                let t = if k < 50 {
                    (k as f64 - 24.5) / 60.0
                } else {
                    0.0
                };
                let place = [t, 0.37 * t + if k % 3 == 0 { 0.0 } else { 0.013 }];
                let b = over(axes, turn, place, depth * axes[2]);
                let (plane, mesh) = (on_plane(&laws, &b), on_triangles(&laws, &b, triangles));
                let size = plane.force.norm();
                let apart = (mesh.force - plane.force)
                    .norm()
                    .max((mesh.torque - plane.torque).norm())
                    / size;
                worst = worst.max(apart);
            }
        }
    }
    worst
}

#[test]
fn a_flat_wall_is_the_plane_in_whatever_pieces_it_comes() {
    let t_junction = || {
        let mut all = rectangle([-6.0, 0.0], [-6.0, 6.0], 0.0).to_vec();
        for k in -8..8 {
            let y = [k as f64 * 0.7 + 0.11, (k + 1) as f64 * 0.7 + 0.11];
            all.extend(rectangle([0.0, 6.0], y, 0.0));
        }
        all
    };
    let fan = || {
        // slivers that meet at the origin
        let at = |k: usize| {
            let angle = 2.0 * PI * k as f64 / 700.0;
            point(6.0 * angle.cos(), 6.0 * angle.sin(), 0.0)
        };
        (0..700)
            .map(|k| [Vector3::ZERO, at(k), at(k + 1)])
            .collect::<Vec<_>>()
    };
    let overlapping = || {
        let mut all = rectangle([-6.0, 0.3], [-6.0, 6.0], 0.0).to_vec();
        all.extend(rectangle([-0.2, 6.0], [-5.0, 6.0], 0.0));
        all.extend(rectangle([-0.1, 0.1], [-0.1, 0.1], 0.0));
        all.extend(rectangle([-6.0, 0.3], [-6.0, 6.0], 0.0));
        all
    };
    let thin = || {
        let mut all = rectangle([-6.0, -0.001], [-6.0, 6.0], 0.0).to_vec();
        all.extend(rectangle([-0.001, 1e-9], [-6.0, 6.0], 0.0));
        all.extend(rectangle([1e-9, 6.0], [-6.0, 6.0], 0.0));
        all
    };
    for (name, triangles) in [
        ("T-junctions", t_junction()),
        ("fan", fan()),
        ("overlapping", overlapping()),
        ("thin strips", thin()),
    ] {
        let apart = apart_from_plane(&triangles, 1e-2);
        println!("{name}: force and torque apart from the plane's by {apart:.1e}");
        assert!(apart < 1e-10, "{name}");
    }
}

#[test]
fn flush_walls_are_one_plane_as_far_as_they_are_flush() {
    for exponent in -13..=-6 {
        let flaw = 10f64.powi(exponent);
        let depth = 1e-2;
        for (name, second) in [
            ("gap", rectangle([flaw, 6.0], [-5.0, 6.0], 0.0)),
            ("overlap", rectangle([-flaw, 6.0], [-5.0, 6.0], 0.0)),
            ("step up", rectangle([0.0, 6.0], [-5.0, 6.0], flaw)),
            ("step down", rectangle([0.0, 6.0], [-5.0, 6.0], -flaw)),
            (
                "slope up",
                face(
                    point(0.0, -5.0, 0.0),
                    point(6.0, 0.0, flaw),
                    point(0.0, 11.0, 0.0),
                ),
            ),
            (
                "slope down",
                face(
                    point(0.0, -5.0, 0.0),
                    point(6.0, 0.0, -flaw),
                    point(0.0, 11.0, 0.0),
                ),
            ),
            (
                "turned aside",
                face(
                    point(flaw, -5.0, 0.0),
                    point(6.0, 0.0, 0.0),
                    point(-flaw, 11.0, 0.0),
                ),
            ),
        ] {
            let mut all = rectangle([-6.0, 0.0], [-6.0, 6.0], 0.0).to_vec();
            all.extend(second);
            let apart = apart_from_plane(&all, depth);
            println!("{name} {flaw:.0e}: apart by {apart:.1e}");
            // a step of `flaw` is one of 3/2 flaw/depth in the force; the least depth is `depth` times 0.2
            assert!(apart < 1e-10 + 30.0 * flaw / depth, "{name} {flaw}");
        }
    }
}

/// A concave fold along y of this angle between the faces' normals, its bottom at the origin.
fn fold(angle: f64, length: f64) -> Vec<Triangle> {
    let (sin, cos) = (0.5 * angle).sin_cos();
    let along = point(0.0, 2.0 * length, 0.0);
    let corner = point(0.0, -length, 0.0);
    let mut all = face(corner, point(length * cos, 0.0, length * sin), along).to_vec();
    all.extend(face(corner, point(-length * cos, 0.0, length * sin), along));
    all
}

/// The body at `x` across the fold, so high that it is `depth` beyond the nearer plane.
fn in_fold(semi_axes: [f64; 3], turn: Rotation, angle: f64, x: f64, depth: f64) -> Body {
    let (sin, cos) = (0.5 * angle).sin_cos();
    let height = [1.0, -1.0].map(|side| {
        let normal = Vector::new(-side * sin, 0.0, cos);
        let h = support(semi_axes, turn, -normal).dot(&-normal);
        (h - depth - normal.x * x) / cos
    });
    body(
        semi_axes,
        Vector::new(x, 0.1, height[0].max(height[1])),
        turn,
    )
}

const ANGLES: [f64; 16] = [
    0.01, 0.1, 0.5, 1.0, 2.0, 2.9, 3.1, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0, 120.0, 175.0,
];

#[test]
fn a_contact_crosses_a_fold_of_any_angle_without_a_jump() {
    let laws = law();
    for axes in SHAPES {
        let mut stream = Stream::new(17);
        for turn in [Rotation::identity(), stream.rotation(), stream.rotation()] {
            for degrees in ANGLES {
                let angle = degrees * PI / 180.0;
                let wall = fold(angle, 60.0);
                let depth = 0.02 * axes[2];
                // about the place where both faces are as deep, as far as both matter; at a steep fold both change fast
                let sin = (0.5 * angle).sin();
                let extent = [1.0, -1.0].map(|side| {
                    let n = Vector::new(-side * sin, 0.0, (0.5 * angle).cos());
                    support(axes, turn, -n).dot(&-n)
                });
                let middle = (extent[1] - extent[0]) / (2.0 * sin);
                let reach =
                    (1.5 * axes[0] * (0.5 * angle).tan() + 0.5 * axes[0]).min(2.0 * depth / sin);
                let largest = |steps: usize| {
                    let mut before: Option<Felt> = None;
                    let (mut jump, mut size) = (0.0f64, 0.0f64);
                    for k in 0..=steps {
                        let x = middle + reach * (2.0 * k as f64 / steps as f64 - 1.0);
                        let b = in_fold(axes, turn, angle, x, depth);
                        let now = on_triangles(&laws, &b, &wall);
                        size = size.max(now.force.norm());
                        if let Some(p) = before {
                            jump = jump
                                .max((now.force - p.force).norm())
                                .max((now.torque - p.torque).norm() / axes[0]);
                        }
                        before = Some(now);
                    }
                    jump / size
                };
                let [coarse, fine] = [largest(500), largest(8000)];
                println!("{axes:?} {degrees} degrees: largest change {coarse:.1e}, {fine:.1e}");
                assert!(
                    fine < 2e-5 || fine < 0.4 * coarse,
                    "{axes:?} {turn:?} {degrees} degrees: the force jumps by {fine:.1e}"
                );
            }
        }
    }
}

pub fn turned(b: &Body, axis: usize, by: f64) -> Body {
    let mut b = *b;
    b.quaternion =
        quaternion(Rotation::from_scaled_axis(Vector::ith(axis, by)) * rotation(b.quaternion));
    b
}

fn shifted(b: &Body, axis: usize, by: f64) -> Body {
    let mut b = *b;
    b.position[axis] += by;
    b
}

#[test]
fn force_and_torque_at_a_fold_are_the_gradient_of_one_energy() {
    let laws = law();
    let mut worst = 0.0f64;
    let mut shared = 0;
    for axes in SHAPES {
        let mut stream = Stream::new(29);
        for degrees in [0.5, 2.0, 5.0, 10.0, 20.0] {
            let angle = degrees * PI / 180.0;
            let wall = fold(angle, 60.0);
            for _ in 0..12 {
                let turn = stream.rotation();
                let depth = 0.02 * axes[2];
                let s = support(axes, turn, -Vector::z());
                let x = -s.x + 0.05 * axes[2] * stream.direction().x;
                let b = in_fold(axes, turn, angle, x, depth);
                let at = on_triangles(&laws, &b, &wall);
                shared += (at.contacts > 1) as usize;
                let h = 2e-3 * depth;
                let slope = |f: &dyn Fn(f64) -> f64, h: f64| {
                    let d = |k: f64| f(k * h) - f(-k * h);
                    (45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / (60.0 * h)
                };
                let energy = |b: &Body| on_triangles(&laws, b, &wall).energy;
                let force =
                    Vector::from([0, 1, 2].map(|k| -slope(&|d| energy(&shifted(&b, k, d)), h)));
                let torque = Vector::from(
                    [0, 1, 2].map(|k| -slope(&|d| energy(&turned(&b, k, d)), h / axes[0])),
                );
                let size = at.force.norm();
                let error = ((force - at.force).norm() / size)
                    .max((torque - at.torque).norm() / (size * axes[0]));
                worst = worst.max(error);
            }
        }
    }
    println!("{shared} of 240 on both faces; force and torque off the gradient by {worst:.1e}");
    assert!(shared > 100);
    assert!(worst < 1e-6);
}

#[test]
fn at_a_deep_fold_a_grain_feels_the_sum_of_both_planes() {
    let laws = law();
    for axes in SHAPES {
        let mut stream = Stream::new(3);
        for degrees in [60.0, 90.0, 110.0] {
            let angle: f64 = degrees * PI / 180.0;
            let wall = fold(angle, 60.0);
            let turn = stream.rotation();
            let (sin, cos) = (0.5 * angle).sin_cos();
            let normals = [1.0, -1.0].map(|side| Vector::new(-side * sin, 0.0, cos));
            let reach = normals.map(|n| support(axes, turn, -n).dot(&-n) - 1e-3 * axes[2]);
            // both planes at the same depth
            let x = (reach[1] - reach[0]) / (2.0 * sin);
            let z = (reach[0] + reach[1]) / (2.0 * cos);
            let b = body(axes, Vector::new(x, 0.1, z), turn);
            let mesh = on_triangles(&laws, &b, &wall);
            let planes = felt(
                &laws,
                &b,
                normals
                    .iter()
                    .map(|n| flat(Vector3::ZERO, plain(*n), Share::WHOLE)),
            );
            let size = planes.force.norm();
            let apart = (mesh.force - planes.force)
                .norm()
                .max((mesh.torque - planes.torque).norm())
                / size;
            println!("{axes:?} {degrees} degrees: apart from two planes by {apart:.1e}");
            assert_eq!(mesh.contacts, 2);
            assert!(apart < 1e-12);
        }
    }
}

/// A drum about the y axis, its facets touching the cylinder in their middles.
fn drum(facets: usize, radius: f64) -> Vec<Triangle> {
    let half = PI / facets as f64;
    let outer = radius / half.cos();
    let at = |k: usize, y: f64| {
        let angle = 2.0 * half * k as f64;
        point(outer * angle.sin(), y, -outer * angle.cos())
    };
    (0..facets)
        .flat_map(|k| {
            face(
                at(k, -20.0),
                at(k + 1, -20.0) - at(k, -20.0),
                point(0.0, 40.0, 0.0),
            )
        })
        .collect()
}

#[test]
fn many_facets_are_the_cylinder() {
    let laws = law();
    for (axes, radius, limit) in [
        ([1.0, 1.0, 1.0], 10.0, 1e-3),
        ([1.0, 1.0, 1.0], 4.0, 1e-3),
        ([1.0, 0.6, 0.5], 20.0, 2e-3),
        ([2.0, 0.5, 0.5], 40.0, 3e-3),
    ] {
        let b = body(
            axes,
            Vector::new(0.013, 0.02, -(radius - 0.99 * axes[2])),
            Rotation::identity(),
        );
        let i = prepare_body(&b, None).unwrap();
        let cylinder = Cone::cylinder(Vector3::ZERO, Vector3::new(0.0, 1.0, 0.0), radius);
        let mut surfaces = vec![];
        touch_cone(&i.body, i.position, &cylinder, true, |c| {
            surfaces.push(WallSurface {
                direction: cylinder.axis.cross(c.normal),
                curvatures: [-1.0 / radius, 0.0],
                turning_radii: [-radius, f64::INFINITY],
                ..flat(c.point, c.normal, Share::WHOLE)
            })
        });
        let smooth = felt(&laws, &b, surfaces.into_iter());
        let mut before = f64::INFINITY;
        for facets in [36, 60, 120, 360, 3600] {
            let mesh = on_triangles(&laws, &b, &drum(facets, radius));
            let force = (mesh.force - smooth.force).norm() / smooth.force.norm();
            let energy = mesh.energy / smooth.energy - 1.0;
            println!(
                "{axes:?} in {radius}, {facets} facets: {} contacts, force off by {force:.1e}, energy by {energy:.1e}",
                mesh.contacts
            );
            // the coarse ones do not reach the body: a drum of few facets is wider
            assert!(force <= before, "{axes:?}");
            before = force;
        }
        assert!(before < limit, "{axes:?}");
    }
}

#[test]
fn an_elastic_grain_in_a_faceted_drum_keeps_its_energy() {
    let laws = laws(&["hertz 1e6 0.3 conservative yes"]);
    let (radius, axes, time_step) = (0.03, [4e-3, 3e-3, 2.5e-3], 5e-6);
    for facets in [36, 60, 120, 360] {
        let at = |k: usize| {
            let angle = 2.0 * PI * (k as f64 + 0.3) / facets as f64;
            point(radius * angle.sin(), -radius, -radius * angle.cos())
        };
        let wall: Vec<Triangle> = (0..facets)
            .flat_map(|k| face(at(k), at(k + 1) - at(k), point(0.0, 2.0 * radius, 0.0)))
            .collect();
        let mut grain = body(
            axes,
            Vector::new(0.004, 0.001, -0.016),
            Rotation::from_scaled_axis(Vector::new(0.2, 1.0, 0.1).normalize() * 0.4),
        );
        grain.mass = 2500.0 * 4.0 / 3.0 * PI * axes[0] * axes[1] * axes[2];
        grain.velocity = [0.3, 0.0, 0.0];
        grain.angular_velocity = [5.0, 30.0, 0.0];
        let weight = Vector::new(0.0, 0.0, -9.81 * grain.mass);
        let mut moving = Rigid::new(grain);
        let mut now = on_triangles(&laws, &moving.body, &wall);
        let energy = |r: &Rigid| r.kinetic_energy() - weight.z * r.body.position[2];
        let start = energy(&moving);
        // from the lowest that the grain can be
        let size = start - weight.z * (radius - axes[2]);
        let (mut apart, mut most, mut bounces) = (0.0f64, 0, 0);
        for _ in 0..(0.3 / time_step) as usize {
            moving.kick(now.force + weight, now.torque, 0.5 * time_step);
            moving.drift(time_step);
            let before = now.contacts;
            now = on_triangles(&laws, &moving.body, &wall);
            moving.kick(now.force + weight, now.torque, 0.5 * time_step);
            most = most.max(now.contacts);
            if now.contacts == 0 {
                bounces += (before > 0) as usize;
                apart = apart.max((energy(&moving) - start).abs() / size);
            }
        }
        println!(
            "{facets} facets, up to {most} at once: {bounces} bounces, energy off by {apart:.1e}"
        );
        assert!(bounces > 3 && apart < 1e-5, "{facets} facets: {apart:e}");
    }
}

/// A bowl of flat triangles under the origin: part of a sphere of this radius, `cells` squares in each direction.
fn bowl(radius: f64, half: f64, cells: usize) -> Vec<Triangle> {
    let at = |i: usize, j: usize| {
        let place = |k: usize| half * (2.0 * k as f64 / cells as f64 - 1.0);
        let (x, y) = (place(i), place(j));
        point(x, y, radius - (radius * radius - x * x - y * y).sqrt())
    };
    (0..cells * cells)
        .flat_map(|k| {
            let (i, j) = (k / cells, k % cells);
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

#[test]
fn thousands_of_faces_under_one_grain_share_it() {
    let laws = law();
    for cells in [16, 64] {
        let wall = bowl(20.0, 0.5, cells);
        let b = body(
            [1.0; 3],
            Vector::new(0.003, 0.007, 0.95),
            Rotation::identity(),
        );
        let i = prepare_body(&b, None).unwrap();
        let mut search = TriangleSearch::default();
        search.touch(&i.body, i.position, &wall);
        let begin = std::time::Instant::now();
        search.touch(&i.body, i.position, &wall);
        let time = begin.elapsed();
        let mesh = on_triangles(&laws, &b, &wall);
        // Hertz in a spherical cavity: F goes with the square root of the radius 1/(1 - 1/20)
        let plane = on_plane(&laws, &b);
        let apart = mesh.force.z / plane.force.z * (1.0f64 - 0.05).sqrt() - 1.0;
        println!(
            "{} triangles, {} faces act: {time:?}, force off by {apart:.1e}",
            wall.len(),
            mesh.contacts
        );
        assert!(mesh.contacts > cells * cells / 3);
        assert!(apart.abs() < 1e-2);
    }
}

/// A closed block about the origin, each face two triangles.
fn block([x, y, z]: [f64; 3]) -> Vec<Triangle> {
    let [u, v, w] = [
        point(2.0 * x, 0.0, 0.0),
        point(0.0, 2.0 * y, 0.0),
        point(0.0, 0.0, 2.0 * z),
    ];
    let low = point(-x, -y, -z);
    [[u, v, w], [v, w, u], [w, u, v]]
        .iter()
        .flat_map(|&[a, b, c]| [face(low, a, b), face(low + c, a, b)])
        .flatten()
        .collect()
}

/// Seen from outside, the faces of a block beside and behind the one that touches lie behind it: they must not act, however small
/// the block is beside the grain.
#[test]
fn a_closed_block_pushes_outwards_alone() {
    let mut stream = Stream::new(41);
    let (mut touching, mut inwards) = (0, 0);
    for half in [
        [1.0, 1.0, 1.0],
        [2.0, 0.5, 0.1],
        [0.3, 0.3, 0.3],
        [10.0, 0.4, 3.0],
        [0.02, 0.5, 0.7],
    ] {
        let wall = block(half);
        let mut search = TriangleSearch::default();
        for axes in SHAPES {
            for _ in 0..2000 {
                let b = body(axes, Vector::zeros(), stream.rotation());
                let i = prepare_body(&b, None).unwrap();
                // Over a place on an edge or a corner, along a direction that points away from the block there, with an
                // overlap that is small beside body and block.
                let mut n = stream.direction();
                let mut place: Vector = Vector::from([0, 1, 2].map(|k| half[k] * n[k].signum()));
                let along = stream.uniform(0.0, 6.0) as usize;
                if along < 3 {
                    place[along] *= stream.uniform(-1.0, 1.0);
                    n[along] = 0.0;
                    n = n.normalize();
                }
                let small = half.iter().fold(axes[2], |m, h| m.min(*h));
                let depth = small * stream.log_uniform(1e-4, 0.1);
                let centre = place - vector(i.body.support(plain(-n)).point) - n * depth;
                if (0..3).all(|k| centre[k].abs() <= half[k]) {
                    continue;
                }
                search.touch(&i.body, plain(centre), &wall);
                for c in search.contacts() {
                    touching += 1;
                    let (at, normal) = (c.point.to_array(), c.normal.to_array());
                    if c.feature == Feature::Face {
                        let axis = (0..3).find(|&k| normal[k].abs() > 0.5).unwrap();
                        let outwards = at[axis] * normal[axis] > 0.0;
                        inwards += usize::from(!outwards);
                    }
                }
            }
        }
    }
    println!("{touching} contacts, {inwards} from within");
    assert!(touching > 10_000);
    assert_eq!(inwards, 0);
}

/// Grains that fly against the faces, edges and corners of a block of their own size, and turn over its edges. What is lost is the
/// integrator's: it falls with the step.
#[test]
fn an_elastic_grain_keeps_its_energy_at_a_small_block() {
    let laws = laws(&["hertz 1e6 0.3 conservative yes"]);
    let half = [3e-3, 1e-3, 2e-3];
    let wall = block(half);
    for axes in [
        [4e-3, 3e-3, 2.5e-3],
        [6e-3, 1.5e-3, 1.5e-3],
        [4e-3, 4e-3, 1e-3],
    ] {
        let errors = [4e-6, 1e-6].map(|time_step| {
            let mut stream = Stream::new(53);
            let (mut worst, mut bounces) = (0.0f64, 0);
            for _ in 0..25 {
                let from = stream.direction();
                let aim = Vector::from([0, 1, 2].map(|k| half[k] * stream.uniform(-1.0, 1.0)));
                let mut grain = body(axes, 12e-3 * from, stream.rotation());
                grain.mass = 2500.0 * 4.0 / 3.0 * PI * axes[0] * axes[1] * axes[2];
                grain.velocity = ((aim - 12e-3 * from).normalize() * 0.5).into();
                grain.angular_velocity = (stream.direction() * 100.0).into();
                let mut moving = Rigid::new(grain);
                let mut now = on_triangles(&laws, &moving.body, &wall);
                let start = moving.kinetic_energy();
                while Vector::from(moving.body.position).norm() < 12.1e-3 {
                    moving.kick(now.force, now.torque, 0.5 * time_step);
                    moving.drift(time_step);
                    let before = now.contacts;
                    now = on_triangles(&laws, &moving.body, &wall);
                    moving.kick(now.force, now.torque, 0.5 * time_step);
                    bounces += usize::from(before > 0 && now.contacts == 0);
                }
                assert_eq!(now.contacts, 0);
                worst = worst.max((moving.kinetic_energy() / start - 1.0).abs());
            }
            println!("{axes:?}, step {time_step:e}: {bounces} bounces, energy off by {worst:.1e}");
            assert!(bounces >= 20);
            worst
        });
        assert!(
            errors[1] < 1e-4 && errors[1] < 0.5 * errors[0],
            "{axes:?}: {errors:?}"
        );
    }
}
