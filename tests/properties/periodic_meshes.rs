// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is it found where a mesh ends at the boundary of a box that repeats, and nowhere else?

use ellgran::geometry::triangles::Triangle;
use ellgran::vector::Vector3;
use ellgran::walls::{Mesh, MissingImage, Motion, PeriodicBox, Wall};

fn wall(triangles: &[Triangle]) -> Wall {
    let mut wall = Wall::new();
    wall.add_mesh(Mesh::new(triangles.to_vec()).unwrap());
    wall
}

/// A rectangle in the plane z = 0.
fn floor(x: [f64; 2], y: [f64; 2]) -> Vec<Triangle> {
    let at = |i: usize, j: usize| Vector3::new(x[i], y[j], 0.0);
    vec![
        [at(0, 0), at(1, 0), at(1, 1)],
        [at(0, 0), at(1, 1), at(0, 1)],
    ]
}

/// A closed tetrahedron of size 0.2.
fn pebble(x: f64, y: f64) -> Vec<Triangle> {
    let corners = [
        [0.0, 0.0, 0.0],
        [0.2, 0.0, 0.0],
        [0.0, 0.2, 0.0],
        [0.0, 0.0, 0.2],
    ]
    .map(|[u, v, w]| Vector3::new(x + u, y + v, w));
    [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
        .map(|t| t.map(|k| corners[k]))
        .to_vec()
}

/// A tube about x, of so many facets, from one x to another.
fn tube(facets: usize, [from, to]: [f64; 2], turned: f64) -> Vec<Triangle> {
    let at = |k: usize, x: f64| {
        let angle = turned + k as f64 / facets as f64 * std::f64::consts::TAU;
        Vector3::new(x, angle.cos(), angle.sin())
    };
    (0..facets)
        .flat_map(|k| {
            let (a, b) = (at(k, from), at(k + 1, from));
            let (c, d) = (at(k + 1, to), at(k, to));
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// From -1 to 1; particles of semi-axis 0.1.
fn missing(triangles: &[Triangle], periodic: &str) -> Option<MissingImage> {
    moved(triangles, periodic, &Motion::REST)
}

fn moved(triangles: &[Triangle], periodic: &str, motion: &Motion) -> Option<MissingImage> {
    let domain = PeriodicBox {
        low: [-1.0; 3],
        high: [1.0; 3],
        is_periodic: ["x", "y", "z"].map(|axis| periodic.contains(axis)),
    };
    wall(triangles).missing_image(motion, &domain, 0.1)
}

#[test]
fn a_floor_must_reach_beyond_the_box_on_both_sides() {
    let ends = floor([-1.0, 1.0], [-2.0, 2.0]);
    assert!(missing(&ends, "").is_none());
    assert!(missing(&ends, "y").is_none());
    let at = missing(&ends, "x").expect("it ends at the boundary");
    assert_eq!(at.axis, 0);
    assert!((1.0..1.11).contains(&at.place.x.abs()), "{at:?}");
    assert!(missing(&floor([-1.2, 1.0], [-2.0, 2.0]), "x").is_some());
    assert!(missing(&floor([-1.0, 1.2], [-2.0, 2.0]), "x").is_some());
    assert!(missing(&floor([-1.05, 1.05], [-2.0, 2.0]), "x").is_some());
    assert!(missing(&floor([-1.1, 1.1], [-2.0, 2.0]), "x").is_none());
    assert_eq!(
        missing(&floor([-1.1, 1.1], [-1.0, 1.0]), "xy")
            .unwrap()
            .axis,
        1
    );
    assert!(missing(&floor([-1.1, 1.1], [-1.1, 1.1]), "xy").is_none());
}

#[test]
fn a_body_near_the_boundary_needs_its_image() {
    assert!(missing(&pebble(0.0, 0.0), "xyz").is_none());
    assert!(missing(&pebble(0.65, 0.0), "x").is_none());
    assert_eq!(missing(&pebble(0.75, 0.0), "x").unwrap().axis, 0);
    assert_eq!(missing(&pebble(0.95, 0.0), "x").unwrap().axis, 0);
    let both = [pebble(0.95, 0.0), pebble(-1.05, 0.0)].concat();
    assert!(missing(&both, "x").is_none());
    // one that is as far away in y is not its image
    let beside = [pebble(0.95, 0.0), pebble(-1.05, 0.3)].concat();
    assert!(missing(&beside, "x").is_some());
}

/// However it is divided into triangles, on the two sides.
#[test]
fn a_tube_goes_on() {
    assert!(missing(&tube(24, [-1.0, 1.0], 0.0), "x").is_some());
    assert!(missing(&tube(24, [-1.2, 1.2], 0.0), "x").is_none());
    let two = [tube(48, [-1.2, 0.0], 0.0), tube(48, [0.0, 1.2], 0.05)].concat();
    assert!(missing(&two, "x").is_none());
}

#[test]
fn a_wall_that_has_moved_is_where_it_is() {
    let body = pebble(0.0, 0.0);
    let motion = Motion {
        displacement: Vector3::new(0.9, 0.0, 0.0),
        ..Motion::REST
    };
    assert!(moved(&body, "x", &motion).is_some());
    let turned = Motion {
        axes: Motion::axes_of([1.0, 0.0, 0.0, 1.0]),
        displacement: Vector3::new(0.0, 0.9, 0.0),
        ..Motion::REST
    };
    assert!(moved(&body, "x", &turned).is_none());
    assert_eq!(moved(&body, "y", &turned).unwrap().axis, 1);
}

#[test]
fn walls_without_triangles_and_particles_without_size() {
    let domain = PeriodicBox {
        low: [-1.0; 3],
        high: [1.0; 3],
        is_periodic: [true; 3],
    };
    assert!(Wall::new()
        .missing_image(&Motion::REST, &domain, 0.1)
        .is_none());
    let floor = wall(&floor([-1.0, 1.0], [-1.0, 1.0]));
    for reach in [0.0, f64::NAN] {
        assert!(floor.missing_image(&Motion::REST, &domain, reach).is_none());
    }
}
