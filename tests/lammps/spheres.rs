// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do spheres move as with LAMMPS' own `granular hertz/material`, and where does `mindlin` differ from its own?

use crate::harness::{largest_difference, run, Deck, Engine, Frame, Grain, Scene};
use crate::shapes::{add, inertia, length, scale, sub, Random, Vector};

/// 200 spheres of several sizes in a periodic box, random velocities.
fn gas() -> Scene {
    let mut random = Random(200);
    let cell = 2.35e-3;
    let mut grains = vec![];
    'fill: for x in 0..6 {
        for y in 0..6 {
            for z in 0..6 {
                if grains.len() == 200 {
                    break 'fill;
                }
                let mut jitter = || random.between(-0.05, 0.05);
                let place = [
                    x as f64 + 0.5 + jitter(),
                    y as f64 + 0.5 + jitter(),
                    z as f64 + 0.5 + jitter(),
                ];
                let radius = random.between(0.7e-3, 1.05e-3);
                let mut grain = Grain::sphere(radius, scale(cell, place));
                grain.density = 2500.0;
                grain.velocity = scale(random.between(0.2, 1.0), random.direction());
                grains.push(grain);
            }
        }
    }
    Scene::periodic([0.0; 3], [6.0 * cell; 3], grains)
}

const MODULUS: f64 = 1e8;
const POISSON: f64 = 0.3;

fn built_in(tangential: &str) -> Deck {
    Deck::built_in_spheres(vec![
        "pair_style granular".into(),
        format!("pair_coeff * * hertz/material {MODULUS} 0.0 {POISSON} {tangential}"),
    ])
}

fn changed_velocities(scene: &Scene, frame: &Frame) -> usize {
    scene
        .grains
        .iter()
        .zip(&frame.states)
        .filter(|(g, s)| length(sub(g.velocity, s.velocity)) > 1e-2 * length(g.velocity))
        .count()
}

/// For the gas.
fn settings(deck: Deck) -> Deck {
    Deck {
        time_step: 1e-6,
        steps: 3000,
        skin: 2e-4,
        ..deck
    }
}

#[test]
fn both_versions_two_hundred_spheres_move_as_with_built_in_hertz() {
    let engine = Engine::from_environment();
    let scene = gas();
    let built_in = settings(built_in("tangential linear_nohistory 0.0 0.0"));
    let reference = run(&engine, "gas_built_in", &scene, &built_in, 1);
    let hit = changed_velocities(&scene, reference.last());
    println!("of 200 spheres {hit} collided");
    assert!(
        hit > 180,
        "only {hit} of 200 spheres collided: the scene tests little"
    );
    for conservative in ["yes", "no"] {
        let law = format!("hertz {MODULUS} {POISSON} conservative {conservative}");
        let name = format!("gas_ours_{conservative}");
        let ours = run(&engine, &name, &scene, &settings(Deck::new(&law)), 1);
        let (positions, velocities) = largest_difference(ours.last(), reference.last());
        println!("conservative {conservative}: positions {positions:.1e}, velocities {velocities:.1e} relative to built-in hertz/material");
        assert!(positions < 1e-9 && velocities < 1e-9);
    }
}

#[test]
fn two_hundred_spheres_in_the_superellipsoid_atom_style() {
    let engine = Engine::from_environment();
    let scene = gas();
    let built_in = settings(built_in("tangential linear_nohistory 0.0 0.0"));
    let reference = run(&engine, "gas_super_built_in", &scene, &built_in, 1);
    let law = format!("hertz {MODULUS} {POISSON}");
    let deck = Deck {
        atom_style: "ellipsoid superellipsoid".into(),
        ..settings(Deck::new(&law))
    };
    let ours = run(&engine, "gas_super_ours", &scene, &deck, 1);
    let (positions, velocities) = largest_difference(ours.last(), reference.last());
    println!("superellipsoid atom style: positions {positions:.1e}, velocities {velocities:.1e}");
    assert!(positions < 1e-9 && velocities < 1e-9);
}

/// Final velocity and spin of the second of two spheres after an oblique collision with a glancing start.
fn oblique(
    engine: &Engine,
    name: &str,
    deck: Deck,
    overlap: f64,
    steps: u64,
) -> (Vector, Vector, f64) {
    let radius: f64 = 1e-2;
    // approach speed that gives the overlap asked for
    let scene = |v: f64| {
        let at = |s: f64| {
            let mut g = Grain::sphere(radius, [s * radius, 0.0, 0.0]).moving([
                -s * 0.5 * v,
                s * 0.3 * v,
                s * 0.1 * v,
            ]);
            g.density = 2500.0;
            g.spinning(scale(v / radius, [0.1, 0.2, -0.1]))
        };
        Scene::open(0.1, vec![at(-1.0), at(1.0)])
    };
    let mass = scene(1.0).grains[0].mass() / 2.0;
    let stiffness = 4.0 / 3.0 * MODULUS / (2.0 * (1.0 - POISSON * POISSON)) * (radius / 2.0).sqrt();
    let speed = (4.0 * stiffness * (overlap * radius).powf(2.5) / (5.0 * mass)).sqrt();
    let duration = 2.9432751843247047 * overlap * radius / speed;
    let scene = scene(speed);
    let outcome = run(
        engine,
        name,
        &scene,
        &Deck {
            time_step: 1.5 * duration / steps as f64,
            steps,
            skin: 1e-3,
            ..deck
        },
        1,
    );
    let (g, s) = (&scene.grains[1], &outcome.last().states[1]);
    assert_eq!(length(s.force), 0.0, "{name}: still in contact");
    let spin = if length(s.angular_velocity) > 0.0 {
        s.angular_velocity
    } else {
        scale(1.0 / inertia(g.mass(), g.semi_axes)[0], s.angular_momentum)
    };
    (
        scale(1.0 / speed, s.velocity),
        scale(radius / speed, spin),
        speed,
    )
}

/// `displacement total` is LAMMPS' `mindlin`, `incremental` its `mindlin/force`, `rescaled` its `mindlin_rescale/force`.
/// What is left between the two programs goes with the overlap. The built-in law takes the surface velocity at the whole radius
/// and the torque at the radius less half the overlap, ours both at the contact point; the built-in law projects the remembered
/// vector back when the normal turns, ours turns it with the normal and with the spin about it.
/// The built-in `mindlin_rescale` has no counterpart: it shortens the displacement with the contact radius and multiplies by a
/// stiffness that shrinks as well.
#[test]
fn both_versions_mindlin_beside_built_in_mindlin() {
    let engine = Engine::from_environment();
    let mut differences = vec![];
    for (ours, theirs) in [
        ("total", "mindlin"),
        ("rescaled", "mindlin_rescale/force"),
        ("incremental", "mindlin/force"),
    ] {
        for friction in [0.2, 2.0] {
            for overlap in [1e-2, 1e-4] {
                let law = format!(
                    "hertz {MODULUS} {POISSON} tangential mindlin {friction} displacement {ours}"
                );
                let a = oblique(&engine, "mindlin_ours", Deck::new(&law), overlap, 3000);
                let b = oblique(
                    &engine,
                    "mindlin_built_in",
                    built_in(&format!("tangential {theirs} NULL 0.0 {friction}")),
                    overlap,
                    3000,
                );
                let (velocity, spin) = (
                    length(sub(a.0, b.0)) / length(b.0),
                    length(sub(a.1, b.1)) / length(b.1),
                );
                println!(
                    "mindlin {ours} beside {theirs}, mu {friction}, overlap {overlap:.0e} R: velocity {:?} and {:?}, differing by {velocity:.1e}; spin by {spin:.1e}",
                    a.0, b.0
                );
                differences.push((overlap, velocity.max(spin)));
                // no force out of nothing: both conserve momentum, so the second sphere's velocity says it all
                assert!(add(a.0, [0.0; 3]).iter().all(|x| x.is_finite()));
            }
        }
    }
    for (overlap, difference) in differences {
        assert!(
            difference < 5.0 * overlap,
            "overlap {overlap}: {difference}"
        );
    }
}
