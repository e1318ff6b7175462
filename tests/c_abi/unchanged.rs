// SPDX-License-Identifier: MIT OR Apache-2.0
//! A list that is said to be unchanged: what is left out of it without being looked at never touches.

use std::ptr::null_mut;

use ellgran::c_api::contact::EllgranBody;

use crate::scene::*;
use crate::shapes;

const DECK: &str = "nfd 1e4 0.3 40 60 tangential tfd 0.4";
const OWNED: usize = 44;
const STEPS: usize = 60;
/// Of the largest force; a contact followed from another start ends at the same normal to rounding.
const TOLERANCE: f64 = 1e-9;

/// Both runs step after step, one with a new workspace and a new list each time, and how often they touched.
fn compare(motion: impl Fn(usize, &mut [EllgranBody])) -> (usize, usize) {
    compare_scene(random_bodies(11), STEPS, motion)
}

fn compare_scene(
    mut bodies: Vec<EllgranBody>,
    steps: usize,
    motion: impl Fn(usize, &mut [EllgranBody]),
) -> (usize, usize) {
    let laws = Laws::new(&[DECK, DECK]);
    let kept = WorkspaceHandle::new();
    // All pairs are listed: nothing is missed for want of an entry.
    let rows: Vec<Vec<i32>> = (0..OWNED)
        .map(|i| (i as i32 + 1..bodies.len() as i32).collect())
        .collect();
    let mut list = List::new(rows.clone(), laws.length());
    let mut other = List::new(rows, laws.length());
    let (mut touching, mut changes) = (0, 0);
    for step in 0..steps {
        motion(step, &mut bodies);
        let before = list.touching.clone();
        let mut forces = Vec::new();
        let fresh = WorkspaceHandle::new();
        for (workspace, list, unchanged) in [
            (&kept, &mut list, i32::from(step > 0)),
            (&fresh, &mut other, 0),
        ] {
            let mut arrays = Arrays::new(&bodies, OWNED);
            arrays.forces.fill([0.0; 3]);
            arrays.torques.fill([0.0; 3]);
            let (particles, mut view) = (arrays.particles(), list.view(true));
            view.unchanged = unchanged;
            ok(laws.pairs(workspace, &particles, &view, &STEP, null_mut()));
            forces.push((arrays.forces.clone(), arrays.torques.clone()));
        }
        assert_eq!(list.touching, other.touching, "step {step}");
        let largest = forces[1]
            .0
            .iter()
            .flatten()
            .fold(0.0f64, |m, f| m.max(f.abs()));
        for (a, b) in [(&forces[0].0, &forces[1].0), (&forces[0].1, &forces[1].1)] {
            for (k, (a, b)) in a.iter().flatten().zip(b.iter().flatten()).enumerate() {
                assert!(
                    (a - b).abs() <= TOLERANCE * largest,
                    "step {step}: component {k}: {a} and {b}"
                );
            }
        }
        touching += list.touching.iter().flatten().filter(|t| **t != 0).count();
        changes += usize::from(before != list.touching);
    }
    (touching, changes)
}

#[test]
fn slow_motion() {
    let (touching, changes) = compare(|_, bodies| advance(bodies, 2e-3));
    assert!(touching > 1000 && changes > 3, "{touching} {changes}");
}

#[test]
fn fast_motion() {
    let (touching, changes) = compare(|_, bodies| advance(bodies, 2e-2));
    assert!(touching > 500 && changes > 20, "{touching} {changes}");
}

#[test]
fn one_particle_jumps_and_one_turns() {
    let (touching, changes) = compare(|step, bodies| {
        let mut random = Random(100 + step as u64);
        let there = bodies[(step * 7 + 3) % OWNED].position;
        let shift: [f64; 3] = random.vector(-0.4, 0.4);
        bodies[step % OWNED].position = std::array::from_fn(|k| there[k] + shift[k]);
        bodies[(step + 5) % OWNED].quaternion = random.vector(-1.0, 1.0);
    });
    assert!(touching > 500 && changes > 20, "{touching} {changes}");
}

#[test]
fn shapes_change() {
    let (touching, changes) = compare(|step, bodies| {
        let body = &mut bodies[(step * 5) % OWNED];
        let factor = if step % 2 == 0 { 1.3 } else { 0.8 };
        body.semi_axes = body.semi_axes.map(|a| a * factor);
    });
    assert!(touching > 500 && changes > 10, "{touching} {changes}");
}

/// Long enough for the margin within which pairs are looked at to follow the motion both ways: wider while the grains
/// drift, as narrow as it becomes while they stand, and far too narrow for what comes at once.
#[test]
fn the_margin_follows_the_motion() {
    for (name, bodies) in [
        ("ellipsoids", random_bodies(11)),
        ("spheroids", shapes::mixture()),
        ("spheres", shapes::spheres()),
        ("needles", shapes::slender([30.0, 1.0, 1.0])),
    ] {
        let (touching, changes) = compare_scene(bodies, 480, |step, bodies| match step {
            0..80 => advance(bodies, 1e-4),
            80..360 => (),
            // One jumps, and another turns.
            360 => bodies[21].position[1] += 0.1,
            370 => bodies[26].quaternion[2] += 0.1,
            380..390 => (),
            390..400 => advance(bodies, 1e-2),
            400..440 => advance(bodies, 5e-4),
            _ => (),
        });
        assert!(
            touching > 10_000 && changes > 5,
            "{name}: {touching} {changes}"
        );
    }
}

/// Grains that go on with their velocities to the end of what is expected of them, are kicked, go the other way than they say, faster than
/// they say, are sped up step by step, and all go together past some that stand.
#[test]
fn motions_as_expected_and_others() {
    for (name, mut bodies) in [
        ("ellipsoids", random_bodies(12)),
        ("spheroids", shapes::mixture()),
        ("spheres", shapes::spheres()),
        ("needles", shapes::slender([30.0, 1.0, 1.0])),
        ("plates", shapes::slender([1.0, 1.0, 0.05])),
    ] {
        for body in &mut bodies {
            body.velocity = body.velocity.map(|v| 0.03 * v);
            body.angular_velocity = body.angular_velocity.map(|w| 0.03 * w);
        }
        let time = STEP.time_step;
        let (touching, changes) = compare_scene(bodies, 700, |step, bodies| {
            let mut random = Random(1000 + step as u64);
            let is_first = step % 100 == 0;
            for (k, body) in bodies.iter_mut().enumerate() {
                match step / 100 {
                    1 if (step + k) % 20 == 0 => {
                        let kick: [f64; 3] = random.vector(-0.05, 0.05);
                        let turn: [f64; 3] = random.vector(-0.05, 0.05);
                        body.velocity = std::array::from_fn(|c| kick[c] - body.velocity[c]);
                        body.angular_velocity = turn;
                    }
                    4 => {
                        body.velocity[2] += 1e-3 * (k % 3) as f64;
                        body.angular_velocity[0] += 1e-3 * (k % 2) as f64;
                    }
                    // The others stand.
                    5 if is_first => {
                        let all = if k % 4 == 0 { 0.0 } else { 0.5 };
                        body.velocity = [all, 0.0, 0.01 * (k % 5) as f64];
                        body.angular_velocity = [0.0; 3];
                    }
                    _ => {}
                }
            }
            match step / 100 {
                2 => advance(bodies, -time),
                3 => advance(bodies, 3.0 * time),
                5 | 6 if step % 200 >= 150 => {}
                _ => advance(bodies, time),
            }
        });
        println!("{name}: {touching} touching, {changes} steps with others");
        assert!(
            touching > 5_000 && changes > 20,
            "{name}: {touching} {changes}"
        );
    }
}
