// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does everything that cannot be right stop with a message that names it?

use std::fs;

use crate::harness::{
    attempt, attempt_in, fresh_directory, last_lines, Deck, Engine, Grain, Outcome, Scene, ELASTIC,
};
use crate::meshes::sheet;

fn pair() -> Scene {
    let grain = |z: f64| Grain {
        density: 2500.0,
        ..Grain::new([5e-3, 4e-3, 3e-3], [0.0, 0.0, z])
    };
    Scene::open(0.1, vec![grain(-2.9e-3), grain(2.9e-3)])
}

fn refuse(name: &str, deck: Deck, words: &[&str]) {
    refuse_scene(name, &pair(), deck, words);
}

fn refuse_scene(name: &str, scene: &Scene, deck: Deck, words: &[&str]) {
    let engine = Engine::from_environment();
    refused(name, &attempt(&engine, name, scene, &deck, 1), words);
}

fn refused(name: &str, outcome: &Outcome, words: &[&str]) {
    let output = outcome.output.to_lowercase();
    assert!(!outcome.success, "{name} was accepted");
    for word in words {
        assert!(
            output.contains(&word.to_lowercase()),
            "{name}: no '{word}' in\n{}",
            last_lines(&outcome.output)
        );
    }
}

fn plain() -> Deck {
    Deck {
        steps: 1,
        ..Deck::new(ELASTIC, 0.5)
    }
}

#[test]
fn another_blockiness() {
    refuse(
        "blockiness",
        Deck {
            before: vec!["set atom 2 blockiness 3 2".into()],
            ..plain()
        },
        &["particle 2", "blockiness 3 2"],
    );
}

#[test]
fn what_check_timestep_ellipsoid_does_not_take() {
    let with = |fix: &str| Deck {
        fixes: vec![format!("fix step {fix}")],
        ..plain()
    };
    for (name, fix, words) in [
        ("few", "all check/timestep/ellipsoid 10", &["fraction"][..]),
        (
            "every",
            "all check/timestep/ellipsoid 0 1.0",
            &["nevery '0'"],
        ),
        (
            "fraction",
            "all check/timestep/ellipsoid 10 much",
            &["fraction 'much'"],
        ),
        (
            "word",
            "all check/timestep/ellipsoid 10 1.0 vmax 3",
            &["'vmax'", "energy_error"],
        ),
        (
            "missing",
            "all check/timestep/ellipsoid 10 1.0 warn",
            &["missing after 'warn'"],
        ),
        (
            "warn",
            "all check/timestep/ellipsoid 10 1.0 warn maybe",
            &["'maybe'", "yes or no"],
        ),
        (
            "error",
            "all check/timestep/ellipsoid 10 1.0 energy_error 0",
            &["energy_error '0'"],
        ),
    ] {
        let name = format!("check_timestep_{name}");
        refuse(
            &name,
            with(fix),
            &[&["check/timestep/ellipsoid"], words].concat(),
        );
    }
    refuse(
        "check_timestep_group",
        Deck {
            fixes: vec![
                "group some id 1".into(),
                "fix step some check/timestep/ellipsoid 10 1.0".into(),
            ],
            ..plain()
        },
        &["group must be all"],
    );
    refuse(
        "check_timestep_model",
        Deck {
            model: "hertz tangential history surface ellipsoid".into(),
            ..with("all check/timestep/ellipsoid 10 1.0")
        },
        &["check/timestep/ellipsoid", "model nfd"],
    );
}

#[test]
fn what_nve_ellipsoid_cannot_move() {
    let with = |before: &str, fixes: &[&str]| Deck {
        before: before.lines().map(String::from).collect(),
        fixes: fixes.iter().map(|line| line.to_string()).collect(),
        integrator: "ellipsoid",
        ..plain()
    };
    refuse(
        "nve_ellipsoid_word",
        with("", &["unfix move", "fix move all nve/ellipsoid fast"]),
        &["fix nve/ellipsoid", "'fast'"],
    );
    refuse(
        "nve_ellipsoid_spin",
        with("set atom 2 omegax 1e10", &[]),
        &["nve/ellipsoid", "particle 2", "half a circle"],
    );
    // It would move nothing. Of another surface, since surface ellipsoid refuses respa by itself.
    refuse(
        "nve_ellipsoid_respa",
        Deck {
            model: "hertz tangential off surface superquadric".into(),
            ..with("run_style respa 2 2", &[])
        },
        &["nve/ellipsoid", "run_style verlet"],
    );
    // LIGGGHTS' own model takes any blockiness: it is the integrator that refuses.
    refuse(
        "nve_ellipsoid_blockiness",
        Deck {
            model: "hertz tangential off surface superquadric".into(),
            ..with("set atom 2 blockiness 3 2", &[])
        },
        &["particle 2", "blockiness 3 2", "nve/ellipsoid needs"],
    );
}

/// LIGGGHTS itself refuses an axis of zero, but not one that is no number.
#[test]
fn axes_that_are_none() {
    let mut scene = pair();
    scene.grains[1].semi_axes[2] = f64::NAN;
    refuse_scene("nan", &scene, plain(), &["particle 2", "NaN"]);
    scene.grains[1].semi_axes[2] = 0.0;
    refuse_scene("zero", &scene, plain(), &["Invalid shape"]);
}

#[test]
fn a_missing_constant() {
    for (fix, name) in [
        ("viscosityShear", "viscosityShear"),
        ("viscosityBulk", "viscosityBulk"),
        ("youngsModulus", "youngsModulus"),
        ("coefficientFriction", "coefficientFriction"),
    ] {
        refuse(
            fix,
            Deck {
                fixes: vec![format!("unfix {fix}")],
                ..plain()
            },
            &[name],
        );
    }
}

#[test]
fn a_negative_viscosity() {
    refuse(
        "negative",
        Deck {
            materials: vec![[1e7, 0.3, -1.0, 0.0]],
            ..plain()
        },
        &["viscosityShear", "-1"],
    );
}

#[test]
fn atoms_that_are_spheres() {
    refuse(
        "spheres",
        Deck {
            atom_style: "sphere".into(),
            ..plain()
        },
        &["atom_style superquadric"],
    );
}

/// LIGGGHTS takes `surface default` where no surface is named, and each grain then for the sphere around it.
#[test]
fn ellipsoids_without_their_surface() {
    let words = ["model nfd", "superquadric needs surface ellipsoid"];
    for (name, surface) in [
        ("none", ""),
        ("default", " surface default"),
        ("superquadric", " surface superquadric"),
    ] {
        let model = format!("nfd tangential tfd{surface}");
        refuse(name, Deck { model, ..plain() }, &words);
    }
    let wall = "fix floor all wall/gran model nfd tangential tfd primitive type 1 zplane -0.05";
    refuse(
        "of_a_wall",
        Deck {
            fixes: vec![wall.into()],
            ..plain()
        },
        &words,
    );
}

#[test]
fn the_engines_own_walls() {
    refuse(
        "wall",
        Deck {
            walls: vec!["primitive type 1 zplane -0.05".into()],
            wall_fix: "wall/gran".into(),
            ..plain()
        },
        &["wall/gran/ellipsoid"],
    );
}

#[test]
fn energies_that_are_not_there() {
    for word in ["computeElasticPotential", "computeDissipatedEnergy"] {
        refuse(
            word,
            Deck {
                settings: format!("{word} on"),
                ..plain()
            },
            &[word, "not available"],
        );
    }
}

#[test]
fn tfd_without_nfd() {
    refuse(
        "tfd",
        Deck {
            model: "hertz tangential tfd surface ellipsoid".into(),
            ..plain()
        },
        &["tangential tfd needs model nfd"],
    );
}

/// It would do work on what it presses and stay in its place.
#[test]
fn a_plane_that_shears_along_its_normal() {
    for plane in ["xplane", "yplane", "zplane"] {
        let wall = format!("primitive type 1 {plane} -0.05 shear {} 0.1", &plane[..1]);
        refuse(
            &format!("shear_{plane}"),
            Deck {
                walls: vec![wall],
                ..plain()
            },
            &["a plane cannot shear along its own normal"],
        );
    }
}

/// It has no images there. Along a dimension that repeats it may go on.
#[test]
fn primitive_walls_across_a_periodic_dimension() {
    let mut scene = pair();
    scene.boundary = "p p f".into();
    let with = |wall: &str, runs: &[&str]| Deck {
        walls: vec![format!("primitive type 1 {wall}")],
        runs: runs.iter().map(|r| (*r).into()).collect(),
        ..plain()
    };
    for (wall, word, dimension) in [
        ("xplane -0.05", "xplane", "x"),
        ("yplane 0.05", "yplane", "y"),
        ("zcylinder 0.05 0. 0.", "zcylinder", "x"),
        ("xcylinder 0.05 0. 0.", "xcylinder", "y"),
        (
            "shape plane axis 1 0 1 side inside point -0.05 0 -0.05",
            "shape plane",
            "x",
        ),
        (
            "shape sphere radius 0.09 shape plane axis 0 1 0 point 0 -0.05 0",
            "shape plane",
            "y",
        ),
    ] {
        let name = wall.replace(' ', "_");
        let words = format!("{word} is across a periodic dimension, {dimension}");
        refuse_scene(
            &name,
            &scene,
            with(wall, &[]),
            &["wall/gran/ellipsoid (id wall0)", &words],
        );
    }
    let engine = Engine::from_environment();
    for wall in ["zplane -0.05", "shape plane point 0 0 -0.05"] {
        attempt(&engine, "along", &scene, &with(wall, &[]), 1).succeeded();
        // the box may come to repeat later
        let later = ["run 1", "change_box all boundary p p p", "run 1"];
        let outcome = attempt(&engine, "later", &scene, &with(wall, &later), 1);
        refused("later", &outcome, &["is across a periodic dimension, z"]);
    }
}

/// A needle touches a primitive cylinder at both ends, and LIGGGHTS' store for stresses has room for one contact.
#[test]
fn stored_stresses_of_a_primitive_cylinder() {
    let cylinder = "primitive type 1 zcylinder 0.01 0. 0.";
    refuse(
        "words",
        Deck {
            walls: vec![format!("{cylinder} store_force_contact_stress yes")],
            ..plain()
        },
        &["store_force_contact_stress", "use a mesh"],
    );
    // fix continuum/weighted turns them on by itself
    let deck = plain();
    refuse(
        "continuum",
        Deck {
            fixes: vec![
                "fix continuum all continuum/weighted kernel_radius 0.012 kernel_type Wendland compute stress".into(),
                format!("fix wall all {} model {} {cylinder}", deck.wall_fix, deck.model),
            ],
            ..deck
        },
        &["fix continuum/weighted", "use a mesh"],
    );
    // and a plane takes both
    let engine = Engine::from_environment();
    let allowed = Deck {
        walls: vec!["primitive type 1 zplane -0.05 store_force_contact_stress yes".into()],
        ..plain()
    };
    attempt(&engine, "plane", &pair(), &allowed, 1).succeeded();
}

/// LIGGGHTS took the last of two primitive walls, or parts of both.
#[test]
fn two_walls_in_one_fix() {
    let engine = Engine::from_environment();
    for wall in [
        "primitive type 1 zplane -0.006 primitive type 1 xplane -0.006",
        "primitive type 1 zplane -0.006 mesh n_meshes 1 meshes sheet",
        "mesh n_meshes 1 meshes sheet primitive type 1 zplane -0.006",
        "primitive type 1 shape sphere radius 0.1 primitive type 1 zplane -0.006",
    ] {
        let directory = fresh_directory("two");
        fs::write(directory.join("sheet.stl"), sheet(2)).unwrap();
        let deck = Deck {
            before: vec![
                "fix sheet all mesh/surface file sheet.stl type 1 move 0. 0. -0.05".into(),
            ],
            walls: vec![wall.into()],
            ..plain()
        };
        let outcome = attempt_in(&engine, &directory, &pair(), &deck, 1);
        refused(
            wall,
            &outcome,
            &["takes one 'primitive' or one 'mesh'", "several 'shape'"],
        );
    }
    // an ID may be any word
    let directory = fresh_directory("named");
    fs::write(directory.join("sheet.stl"), sheet(2)).unwrap();
    let deck = Deck {
        before: ["mesh", "primitive"]
            .map(|id| format!("fix {id} all mesh/surface file sheet.stl type 1 move 0. 0. -0.05"))
            .to_vec(),
        walls: vec!["mesh n_meshes 2 meshes mesh primitive".into()],
        ..plain()
    };
    attempt_in(&engine, &directory, &pair(), &deck, 1).succeeded();
}

/// It would act once, where it acts twice under LIGGGHTS' own models.
#[test]
fn a_mesh_that_is_named_twice() {
    let engine = Engine::from_environment();
    for (meshes, words) in [
        ("2 meshes sheet sheet", Some("mesh 'sheet' is named twice")),
        (
            "3 meshes other sheet other",
            Some("mesh 'other' is named twice"),
        ),
        ("2 meshes sheet other", None),
    ] {
        let directory = fresh_directory("named_twice");
        fs::write(directory.join("sheet.stl"), sheet(2)).unwrap();
        let deck = Deck {
            before: ["sheet", "other"]
                .map(|id| {
                    format!("fix {id} all mesh/surface file sheet.stl type 1 move 0. 0. -0.05")
                })
                .to_vec(),
            walls: vec![format!("mesh n_meshes {meshes}")],
            ..plain()
        };
        let outcome = attempt_in(&engine, &directory, &pair(), &deck, 1);
        match words {
            Some(words) => refused(meshes, &outcome, &[words]),
            None => drop(outcome.succeeded()),
        }
    }
}

/// LIGGGHTS' own rule, on which the search for the contacts with meshes rests.
#[test]
fn a_second_wall_of_meshes() {
    let engine = Engine::from_environment();
    let directory = fresh_directory("second");
    for name in ["left", "right"] {
        fs::write(directory.join(format!("{name}.stl")), sheet(2)).unwrap();
    }
    let deck = Deck {
        before: ["left", "right"]
            .map(|name| {
                format!("fix {name} all mesh/surface file {name}.stl type 1 move 0. 0. -0.05")
            })
            .to_vec(),
        walls: ["left", "right"]
            .map(|name| format!("mesh n_meshes 1 meshes {name}"))
            .to_vec(),
        ..plain()
    };
    let outcome = attempt_in(&engine, &directory, &pair(), &deck, 1);
    refused("second", &outcome, &["More than one wall of type 'mesh'"]);
}

/// LIGGGHTS goes on with the numbers that fixes had when the last run was set up: without the check one of these crashes, and others go on with
/// other fixes or without the new one.
#[test]
fn fixes_that_changed_before_a_run_without_setup() {
    let with = |between: &[&str], last: &str| Deck {
        fixes: vec![
            "group first id 1".into(),
            "group second id 2".into(),
            "unfix move".into(),
            "fix one first nve/ellipsoid".into(),
            "fix two second nve/ellipsoid".into(),
            "fix weight all gravity 9.81 vector 0 0 -1".into(),
        ],
        runs: [&["run 5"], between, &[last]]
            .concat()
            .iter()
            .map(|line| line.to_string())
            .collect(),
        ..plain()
    };
    let again = "fix weight all gravity 9.81 vector 0 0 -1";
    let engine = Engine::from_environment();
    for (name, between) in [
        ("integrator_gone", &["unfix one"][..]),
        ("weight_gone", &["unfix weight"]),
        ("added", &["fix drag all viscous 1e-3"]),
        ("given_again", &[again]),
        (
            "pair_style",
            &[
                "pair_style gran model nfd tangential tfd surface ellipsoid",
                "pair_coeff * *",
            ],
        ),
    ] {
        refuse(
            name,
            with(between, "run 5 pre no"),
            &["pre no", "fixes were", "leave"],
        );
        attempt(
            &engine,
            &format!("{name}_set_up"),
            &pair(),
            &with(between, "run 5"),
            1,
        )
        .succeeded();
    }
    // LIGGGHTS itself goes on with the memory of a compute that is gone, and leaves a new one without its beginning.
    let stress = "compute stress all stress/atom";
    refuse(
        "compute_added",
        with(&[stress], "run 5 pre no"),
        &["pre no", "computes were", "leave"],
    );
    refuse(
        "compute_gone",
        with(&[stress, "run 5", "uncompute stress"], "run 5 pre no"),
        &["pre no", "computes were", "leave"],
    );
    refuse(
        "every",
        with(&[], "run 10 pre no every 5 \"unfix weight\""),
        &["pre no", "fixes were"],
    );
    for last in [
        "run 5 pre no",
        "run 10 pre no every 5 \"variable nothing equal 1\"",
    ] {
        attempt(&engine, "as_they_were", &pair(), &with(&[], last), 1).succeeded();
    }
}
