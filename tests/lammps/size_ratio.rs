// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a mixture of very different sizes miss no contact, however neighbours are listed?

use crate::harness::{run, Deck, Engine, Frame, Grain, Scene, State};
use crate::shapes::{add, length, scale, sub, surface_point, Random, IDENTITY};

/// Three coarse ellipsoids tip to tip, also across the periodic boundary, and fine ones, a twentieth of their size, all over them.
fn mixture() -> Scene {
    let coarse = [20e-3, 15e-3, 12e-3];
    let fine = [1e-3, 0.8e-3, 0.7e-3];
    let mut random = Random(20);
    let of = |axes, place| Grain {
        density: 2500.0,
        ..Grain::new(axes, place)
    };
    let overlap = 5e-5;
    let edge = 6.0 * (coarse[0] - overlap);
    let middles = [1.0, 3.0, 5.0].map(|at| [at / 6.0 * edge, 0.045, 0.045]);
    let mut grains: Vec<Grain> = middles.iter().map(|m| of(coarse, *m)).collect();
    while grains.len() < 600 {
        let normal = random.direction();
        let on = middles[grains.len() % 3];
        let place = add(
            on,
            add(
                surface_point(coarse, IDENTITY, normal),
                scale(0.75e-3, normal),
            ),
        );
        let near = |g: &Grain| length(sub(g.position, place)) < 1.5e-3;
        if !grains[3..].iter().any(near) {
            grains.push(
                of(fine, place)
                    .turned(random.quaternion())
                    .moving(scale(0.05, random.direction())),
            );
        }
    }
    Scene::periodic([0.0; 3], [edge, 0.09, 0.09], grains)
}

/// Largest difference of forces and torques, over the largest on a fine grain.
fn apart(a: &Frame, b: &Frame) -> f64 {
    let mut worst = 0.0f64;
    for of in [|s: &State| s.force, |s: &State| s.torque] {
        let largest = (b.states[3..].iter().flat_map(of)).fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(largest > 0.0);
        for (x, y) in a.states.iter().zip(&b.states) {
            worst = worst.max(length(sub(of(x), of(y))) / largest);
        }
    }
    worst
}

/// Lists by radius, by type and all pairs give the same forces, at once and after fine grains have moved by several skins.
#[test]
fn a_mixture_of_one_to_twenty_misses_nothing() {
    let engine = Engine::from_environment();
    let frames = |atom_style: &str, lists: &str, skin: f64, ranks: usize| {
        let deck = Deck {
            atom_style: atom_style.into(),
            before_data: vec![format!("neighbor {skin:e} {lists}")],
            fixes: vec!["compute touching all pair gran/ellipsoid".into()],
            thermo_columns: "step c_touching[4]".into(),
            thermo_every: 200,
            dump_every: 200,
            time_step: 1e-6,
            steps: 400,
            skin,
            ..Deck::new("nfd 5e6 0.3 100 100 tangential tfd 0.5")
        };
        let outcome = run(&engine, "size_ratio", &mixture(), &deck, ranks);
        let touching: Vec<f64> = outcome
            .thermo()
            .iter()
            .map(|r| r["c_touching[4]"])
            .collect();
        (outcome.frames, touching)
    };
    let (all_pairs, touching) = frames("ellipsoid", "nsq", 1e-3, 1);
    assert!(touching[0] > 300.0, "{touching:?}");
    for (atom_style, lists, skin, ranks) in [
        ("ellipsoid superellipsoid", "bin", 1e-5, 1),
        ("ellipsoid superellipsoid", "bin", 1e-3, 2),
        ("ellipsoid superellipsoid", "multi", 1e-4, 1),
        ("ellipsoid superellipsoid", "nsq", 1e-5, 1),
        ("ellipsoid", "bin", 1e-5, 2),
        ("ellipsoid", "multi", 1e-4, 1),
    ] {
        let (found, of) = frames(atom_style, lists, skin, ranks);
        assert_eq!(found.len(), all_pairs.len());
        let worst: Vec<f64> = found
            .iter()
            .zip(&all_pairs)
            .map(|(a, b)| apart(a, b))
            .collect();
        println!("{atom_style}, {lists}, skin {skin:.0e}, {ranks} ranks: {of:?} touching, apart by {:.1e}", worst.iter().fold(0.0, |m: f64, w| m.max(*w)));
        assert_eq!(of, touching);
        assert!(
            worst.iter().all(|w| *w < 1e-8),
            "{atom_style}, {lists}, skin {skin}"
        );
    }
}
