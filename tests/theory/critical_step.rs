// SPDX-License-Identifier: MIT OR Apache-2.0
//! The critical time step of a contact is where velocity Verlet stops being stable, and the time of a collision is how long
//! it lasts: both found by integrating the motion.

use crate::support::motion::{Motion, Partner, Rigid};
use crate::support::scene::{advance, geometry, laws, position, Memory};
use crate::support::stability::{grows, overlapping};
use ellgran::contact::prepare_body;
use ellgran::contact::stability::{collision, contact_stiffness};
use ellgran::contact::Body;

fn grain(semi_axes: [f64; 3], quaternion: [f64; 4], position: [f64; 3], mass: f64) -> Body {
    Body {
        position,
        quaternion,
        semi_axes,
        velocity: [0.0; 3],
        angular_velocity: [0.0; 3],
        mass,
        particle_type: 1,
        identifier: 1,
    }
}

fn pairs() -> [(&'static str, Body, Body); 3] {
    let upright = [1.0, 0.0, 0.0, 0.0];
    [
        (
            "spheres",
            grain([1e-3; 3], upright, [0.0; 3], 1e-5),
            grain([1.5e-3; 3], upright, [1e-3, 2e-3, 0.5e-3], 4e-5),
        ),
        (
            "ellipsoids that meet off their centres",
            grain([3e-3, 1e-3, 1.5e-3], [0.9, 0.1, -0.3, 0.2], [0.0; 3], 2e-5),
            grain(
                [1e-3, 2e-3, 1.2e-3],
                [0.5, -0.6, 0.2, 0.4],
                [1.5e-3, 1e-3, 1.8e-3],
                1e-5,
            ),
        ),
        (
            "a needle's flank and a light grain",
            grain([8e-3, 1e-3, 1e-3], upright, [0.0; 3], 1e-4),
            grain(
                [1e-3, 1.3e-3, 1e-3],
                [0.7, 0.1, 0.6, 0.0],
                [6e-3, 0.2e-3, 1.7e-3],
                1e-6,
            ),
        ),
    ]
}

#[test]
fn is_where_the_motion_stops_being_stable() {
    for deck in [
        "hertz 1e7 0.3",
        "hertz 1e7 0.3 tangential mindlin 1e9 displacement total",
        "hertz 1e7 0.3 damping restitution 0.3",
        "nfd 1e7 0.3 1000 1000 tangential tfd 1e9",
        "lsd 60 0.02 tangential linear 40 0.01 1e9",
    ] {
        let laws = laws(&[deck]);
        for (name, i, j) in pairs() {
            let (i, j) = overlapping(i, j, 1e-8);
            let prepared = [&i, &j].map(|b| prepare_body(b, Some(1)).unwrap());
            let found = contact_stiffness(&laws, &prepared[0], &prepared[1]).unwrap();
            let step = found.expect("a contact").critical_step;
            assert!(step > 0.0 && step.is_finite());
            assert!(!grows(&laws, &i, &j, 0.98 * step), "{name}, {deck}");
            assert!(grows(&laws, &i, &j, 1.02 * step), "{name}, {deck}");
        }
    }
}

#[test]
fn springs_are_the_derivatives_of_the_forces() {
    let (_, i, j) = pairs()[1];
    let (i, j) = overlapping(i, j, 1e-6);
    for deck in ["hertz 1e7 0.3 conservative no", "lsd 60 0.02"] {
        let laws = laws(&[deck]);
        let prepared = [&i, &j].map(|b| prepare_body(b, Some(1)).unwrap());
        let found = contact_stiffness(&laws, &prepared[0], &prepared[1])
            .unwrap()
            .expect("a contact");
        let n = geometry(&i, &j).normal.to_array();
        let force = |by: f64| {
            let mut moved = j;
            for (x, n) in moved.position.iter_mut().zip(n) {
                *x -= by * n;
            }
            let felt = advance(&laws, &i, &moved, 0.0, &mut Memory::new(&laws));
            felt.expect("a contact").forces.normal_force
        };
        let slope = (force(1e-9) - force(-1e-9)) / 2e-9;
        let apart = (found.normal_stiffness - slope).abs() / slope;
        assert!(apart < 1e-5, "{deck}: {apart}");
        assert_eq!(found.tangential_stiffness, [0.0; 2]);
    }
}

#[test]
fn fixed_bodies_and_bodies_apart() {
    let laws = laws(&["hertz 1e7 0.3"]);
    let (_, mut i, mut j) = pairs()[0];
    (i, j) = overlapping(i, j, 1e-8);
    let prepare = |b: &Body| prepare_body(b, Some(1)).unwrap();
    (i.mass, j.mass) = (f64::INFINITY, f64::INFINITY);
    let found = contact_stiffness(&laws, &prepare(&i), &prepare(&j)).unwrap();
    assert_eq!(found.unwrap().critical_step, f64::INFINITY);
    let time = collision(&laws, &prepare(&i), &prepare(&j), 1.0)
        .unwrap()
        .time;
    assert_eq!(time, f64::INFINITY);
    j.position[0] += 1.0;
    assert!(contact_stiffness(&laws, &prepare(&i), &prepare(&j))
        .unwrap()
        .is_none());
}

#[test]
fn a_collision_lasts_as_long_and_goes_as_deep() {
    for (deck, semi_axes) in [
        ("hertz 1e7 0.3", [1e-3; 3]),
        ("hertz 1e7 0.3", [1e-3, 2e-3, 1.5e-3]),
        ("lsd 60 0", [1e-3, 2e-3, 1.5e-3]),
    ] {
        let laws = laws(&[deck]);
        let upright = [1.0, 0.0, 0.0, 0.0];
        let i = grain(semi_axes, upright, [0.0; 3], 1e-5);
        let mut j = grain(
            semi_axes,
            upright,
            [2.0 * semi_axes[0] + 1e-9, 0.0, 0.0],
            3e-5,
        );
        let speed = 0.02;
        j.velocity[0] = -speed;
        let prepared = [&i, &j].map(|b| prepare_body(b, Some(1)).unwrap());
        let expected = collision(&laws, &prepared[0], &prepared[1], speed).unwrap();
        let step = expected.time / 4000.0;
        let mut motion = Motion::new(&laws, i, Partner::Body(Rigid::new(j)), step);
        let (mut touching, mut deepest) = (0, 0.0f64);
        for _ in 0..6000 {
            motion.step();
            if let Some(felt) = &motion.felt {
                touching += 1;
                deepest = deepest.max(felt.geometry.penetration);
            }
        }
        let lasted = touching as f64 * step;
        assert!(position(&motion.i.body).norm() > 0.0);
        assert!(
            (lasted / expected.time - 1.0).abs() < 2e-3,
            "{deck}: {lasted} is not {}",
            expected.time
        );
        assert!(
            (deepest / expected.penetration - 1.0).abs() < 1e-4,
            "{deck}: {deepest} is not {}",
            expected.penetration
        );
    }
}
