// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is the motion the same on one and four ranks, with newton on and off, and across a periodic boundary; is momentum kept?

use crate::harness::{
    angular_momentum, attempt, crowd, largest_difference, momentum_error, run, Deck, Engine, Frame,
    Grain, Scene,
};
use crate::refusal::refused;
use crate::shapes::{add, length, sub, Random, Vector};

/// Friction, viscosity and every other thing that needs history or rates.
pub const LAW: &str = "nfd 1e8 0.3 2000 3000 tangential tfd 0.5";

/// With newton off the two sides of a contact across a boundary are computed apart, from coordinates that were shifted by the
/// box and rounded: momentum is kept to that rounding over the overlap, else to that of the sum.
fn rounding(newton: bool) -> f64 {
    if newton {
        1e-13
    } else {
        1e-11
    }
}

#[test]
fn both_versions_ranks_and_newton_do_not_change_the_motion() {
    let engine = Engine::from_environment();
    let scene = crowd(64);
    let deck = |newton: bool| Deck {
        newton,
        time_step: 1e-5,
        steps: 300,
        skin: 2e-3,
        ..Deck::new(LAW)
    };
    let reference = run(&engine, "crowd_1_on", &scene, &deck(true), 1);
    let changed = scene
        .grains
        .iter()
        .zip(&reference.last().states)
        .filter(|(g, s)| length(sub(s.velocity, g.velocity)) > 1e-2 * length(g.velocity))
        .count();
    println!("{changed} of {} grains have collided", scene.grains.len());
    assert!(changed > 25);
    println!(
        "momentum error {:.1e}",
        momentum_error(&scene.grains, reference.first(), reference.last())
    );
    assert!(momentum_error(&scene.grains, reference.first(), reference.last()) < 1e-13);
    for (ranks, newton) in [(1, false), (4, true), (4, false)] {
        let name = format!("crowd_{ranks}_{newton}");
        let outcome = run(&engine, &name, &scene, &deck(newton), ranks);
        let (positions, velocities) = largest_difference(outcome.last(), reference.last());
        let momentum = momentum_error(&scene.grains, outcome.first(), outcome.last());
        println!("{ranks} ranks, newton {newton}: positions {positions:.1e}, velocities {velocities:.1e}, momentum {momentum:.1e}");
        assert!(
            positions < 1e-9 && velocities < 1e-9,
            "{ranks} ranks, newton {newton}"
        );
        assert!(
            momentum < rounding(newton),
            "{ranks} ranks, newton {newton}"
        );
    }
}

/// Two ellipsoids that meet obliquely under friction about a point of the box.
pub fn meeting_at(centre: Vector) -> Scene {
    let mut random = Random(5);
    let axes = [0.016, 0.01, 0.008];
    let grain = |s: f64, random: &mut Random| {
        let offset = [s * 0.0093, s * 0.003, -s * 0.002];
        Grain {
            density: 2500.0,
            ..Grain::new(axes, add(centre, offset)).turned(random.quaternion())
        }
        .moving([-s * 0.3, s * 0.1, s * 0.2])
        .spinning([5.0 * s, 3.0, -4.0])
    };
    let grains = vec![grain(-1.0, &mut random), grain(1.0, &mut random)];
    Scene::periodic([0.0; 3], [0.125; 3], grains)
}

fn wrapped(mut scene: Scene) -> Scene {
    for g in &mut scene.grains {
        g.position = g.position.map(|x| x.rem_euclid(0.125));
    }
    scene
}

#[test]
fn both_versions_a_contact_across_a_periodic_boundary() {
    let engine = Engine::from_environment();
    let deck = |newton: bool| Deck {
        newton,
        time_step: 8e-6,
        steps: 100,
        skin: 2e-3,
        ..Deck::new(LAW)
    };
    let inside = meeting_at([0.0625; 3]);
    let reference = run(&engine, "boundary_inside", &inside, &deck(true), 1);
    let force: f64 = length(reference.first().states[0].force);
    let turned = length(sub(
        reference.last().states[0].velocity,
        inside.grains[0].velocity,
    ));
    println!(
        "change of velocity {turned:.3} m/s, force at the start {force:.1} N, at the end {:?}",
        reference.last().states[0].force
    );
    assert!(turned > 0.1);
    // relative motion: positions less their starts, so that the box does not matter
    let moved = |frame: &Frame, first: &Frame| {
        let mut frame = frame.clone();
        for (s, f) in frame.states.iter_mut().zip(&first.states) {
            s.position = sub(s.position, f.position);
        }
        frame
    };
    let expected = moved(reference.last(), reference.first());
    let places: [(&str, Vector); 5] = [
        ("middle, where ranks meet", [0.0625; 3]),
        ("x face", [0.0, 0.0625, 0.0625]),
        ("y face", [0.0625, 0.0, 0.0625]),
        ("edge", [0.0, 0.0, 0.0625]),
        ("corner", [0.0; 3]),
    ];
    for (place, centre) in places {
        let scene = wrapped(meeting_at(centre));
        let everywhere = [(1, true), (1, false), (4, true), (4, false)];
        let on_four = matches!(place, "corner" | "middle, where ranks meet");
        for (ranks, newton) in everywhere
            .into_iter()
            .filter(|(ranks, _)| *ranks == 1 || on_four)
        {
            let outcome = run(&engine, "boundary", &scene, &deck(newton), ranks);
            let (positions, velocities) =
                largest_difference(&moved(outcome.last(), outcome.first()), &expected);
            let momentum = momentum_error(&scene.grains, outcome.first(), outcome.last());
            println!("{place}, {ranks} ranks, newton {newton}: positions {positions:.1e}, velocities {velocities:.1e}, momentum {momentum:.1e}");
            assert!(
                positions < 1e-9 && velocities < 1e-9 && momentum < rounding(newton),
                "{place}, {ranks} ranks, newton {newton}"
            );
        }
    }
    // no boundary between them: angular momentum is kept as well
    let about = |frame: &Frame| angular_momentum(&inside.grains, frame);
    let size: f64 = inside
        .grains
        .iter()
        .zip(&reference.first().states)
        .map(|(g, s)| g.mass() * length(s.position) * length(s.velocity))
        .sum();
    let drift = length(sub(about(reference.last()), about(reference.first()))) / size;
    println!("angular momentum: relative change {drift:.1e}");
    assert!(drift < 1e-13);
}

/// Neighbour lists built often or seldom, and either atom style, must not change the motion: the history of a contact follows it.
#[test]
fn rebuilt_lists_and_atom_styles_do_not_change_the_motion() {
    let engine = Engine::from_environment();
    let scene = crowd(64);
    let deck = |skin: f64, style: &str| Deck {
        atom_style: style.into(),
        skin,
        time_step: 1e-5,
        steps: 300,
        ..Deck::new(LAW)
    };
    let reference = run(
        &engine,
        "lists_reference",
        &scene,
        &deck(2e-3, "ellipsoid"),
        1,
    );
    for (skin, style) in [
        (1e-4, "ellipsoid"),
        (2e-3, "ellipsoid superellipsoid"),
        (1e-4, "ellipsoid superellipsoid"),
    ] {
        let outcome = run(&engine, "lists", &scene, &deck(skin, style), 1);
        let builds = |o: &crate::harness::Outcome| {
            o.output
                .lines()
                .find_map(|l| {
                    l.strip_prefix("Neighbor list builds = ")
                        .map(|n| n.trim().to_string())
                })
                .unwrap()
        };
        let (positions, velocities) = largest_difference(outcome.last(), reference.last());
        println!("{style}, skin {skin}: {} builds beside {}; positions {positions:.1e}, velocities {velocities:.1e}", builds(&outcome), builds(&reference));
        assert!(
            positions < 1e-9 && velocities < 1e-9,
            "{style}, skin {skin}"
        );
    }
}

/// The pair style puts shapes in memory in the order of the atoms, which LAMMPS sorts by place: each grain keeps its own, also where others are
/// deleted from among them.
#[test]
fn both_versions_each_grain_keeps_its_shape_where_shapes_are_sorted() {
    each_grain_keeps_its_shape("ellipsoid");
}

/// The same in the array that LAMMPS has for superellipsoids since 30 Mar 2026.
#[test]
fn each_superellipsoid_keeps_its_shape_where_shapes_are_sorted() {
    each_grain_keeps_its_shape("ellipsoid superellipsoid");
}

fn each_grain_keeps_its_shape(style: &str) {
    const COUNT: usize = 216;
    let engine = Engine::from_environment();
    let mut scene = crowd(COUNT);
    // Identifiers that say nothing of the place: 85 and 216 have no common factor.
    let ordered = scene.grains.clone();
    for (k, grain) in scene.grains.iter_mut().enumerate() {
        *grain = ordered[k * 85 % COUNT].clone();
        grain.semi_axes = grain.semi_axes.map(|a| a * (1.0 - 1e-4 * k as f64));
    }
    let dump = |name: &str| {
        format!("write_dump all custom {name} id c_shape[*] modify sort id format float %.17g")
    };
    for ranks in [1, 4] {
        let deck = Deck {
            atom_style: style.into(),
            runs: vec![
                "compute shape all property/atom shapex shapey shapez quatw quati quatj quatk"
                    .into(),
                "run 0".into(),
                dump("all_shapes"),
                "group gone id 3:216:7".into(),
                "delete_atoms group gone compress no".into(),
                "run 0".into(),
                dump("fewer_shapes"),
            ],
            ..Deck::new(LAW)
        };
        let name = format!("sorted_shapes_{ranks}");
        let outcome = run(&engine, &name, &scene, &deck, ranks);
        for (name, left) in [("all_shapes", COUNT), ("fewer_shapes", COUNT - 31)] {
            let text = std::fs::read_to_string(outcome.directory.join(name)).unwrap();
            let rows: Vec<Vec<f64>> = text
                .lines()
                .skip(9)
                .map(|line| {
                    line.split_whitespace()
                        .map(|x| x.parse().unwrap())
                        .collect()
                })
                .collect();
            assert_eq!(rows.len(), left, "{style}, {ranks} ranks: {name}");
            for row in rows {
                let grain = &scene.grains[row[0] as usize - 1];
                for k in 0..3 {
                    // LAMMPS has diameters of what it was given as diameters.
                    let error = (row[1 + k] - 2.0 * grain.semi_axes[k]).abs();
                    assert!(
                        error < 1e-15,
                        "{style}, {ranks} ranks, {name}: {row:?}, {grain:?}"
                    );
                }
                for k in 0..4 {
                    let error = (row[4 + k] - grain.quaternion[k]).abs();
                    assert!(
                        error < 1e-15,
                        "{style}, {ranks} ranks, {name}: {row:?}, {grain:?}"
                    );
                }
            }
        }
    }
}

/// After many steps with remembered normals the forces are those that a fresh search finds.
#[test]
fn both_versions_remembered_normals_give_the_forces_of_a_fresh_search() {
    let engine = Engine::from_environment();
    let law = "hertz 1e8 0.3";
    let deck = |steps: u64| Deck {
        time_step: 1e-5,
        steps,
        skin: 2e-3,
        ..Deck::new(law)
    };
    let scene = crowd(216);
    let moved = run(&engine, "warm", &scene, &deck(400), 1);
    let mut again = scene.clone();
    for (g, s) in again.grains.iter_mut().zip(&moved.last().states) {
        g.position = std::array::from_fn(|k| s.position[k].rem_euclid(scene.high[k]));
        g.quaternion = s.quaternion;
        g.velocity = s.velocity;
    }
    let fresh = run(&engine, "cold", &again, &deck(0), 1);
    let (mut largest, mut force, mut torque, mut touching) = (0.0f64, 0.0f64, 0.0f64, 0);
    for (warm, cold) in moved.last().states.iter().zip(&fresh.first().states) {
        largest = largest.max(length(cold.force));
        force = force.max(length(sub(warm.force, cold.force)));
        torque = torque.max(length(sub(warm.torque, cold.torque)) / 1.5e-2);
        touching += usize::from(length(cold.force) > 0.0);
    }
    println!("{touching} grains in contact; forces differ by {:.1e}, torques by {:.1e} of the largest force", force / largest, torque / largest);
    assert!(touching > 20);
    assert!(force < 1e-10 * largest && torque < 1e-10 * largest);
}

/// Two grains that touch each other on both sides of a short periodic box, and one that touches itself: contacts are remembered by ID, so
/// that friction of the two would be mixed up. Without friction, and where they touch once, they may.
#[test]
fn both_versions_two_contacts_of_the_same_grains_are_refused_with_friction() {
    let engine = Engine::from_environment();
    let edge = 1.98;
    let alone = vec![Grain::new([1.0, 0.5, 0.5], [1.0, 2.0, 2.0])];
    let two = |shift: f64| {
        vec![
            Grain::new([0.5, 0.4, 0.3], [0.25 * edge, 2.0, 2.0]),
            Grain::new([0.5, 0.4, 0.3], [0.75 * edge + shift, 2.0, 2.0]),
        ]
    };
    let friction = "hertz 1e7 0.3 tangential mindlin 0.5";
    for (grains, law, newton, refusal) in [
        (
            two(0.0),
            friction,
            true,
            Some("particle 1 touches particle 2 in two places"),
        ),
        (
            two(0.0),
            friction,
            false,
            Some("particle 1 touches particle 2 in two places"),
        ),
        (
            alone.clone(),
            friction,
            true,
            Some("particle 1 touches itself"),
        ),
        (two(0.015), friction, true, None),
        (two(0.0), "hertz 1e7 0.3", true, None),
        (alone, "hertz 1e7 0.3", true, None),
    ] {
        let mut scene = Scene::periodic([0.0; 3], [edge, 4.0, 4.0], grains);
        scene.boundary = "p f f".into();
        let deck = Deck {
            newton,
            time_step: 1e-6,
            steps: 10,
            skin: 0.05,
            before_data: vec!["neigh_modify delay 0 every 5 check no".into()],
            ..Deck::new(law)
        };
        let outcome = attempt(&engine, "two_contacts", &scene, &deck, 1);
        match refusal {
            Some(words) => refused(
                law,
                outcome.success,
                &outcome.output,
                &[words, "periodic box"],
            ),
            None => drop(outcome.succeeded()),
        }
    }
}
