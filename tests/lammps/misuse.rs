// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does every misuse stop the run with a message that names what is wrong?

use crate::harness::{
    attempt, attempt_in, crowd, fresh_directory, run, Deck, Engine, Grain, Outcome, Scene,
};
use crate::refusal;

const LAW: &str = "hertz 1e7 0.3";
const VISCOUS: &str = "nfd 1e7 0.3 200 200 tangential tfd 0.5";

fn pair_of_grains() -> Scene {
    Scene::open(
        10.0,
        vec![
            Grain::new([1.0, 0.8, 0.5], [0.0; 3]),
            Grain::new([1.0, 0.8, 0.5], [0.0, 0.0, 0.99]),
        ],
    )
}

/// The run must be refused with a message that names the words.
fn refused(name: &str, scene: &Scene, deck: &Deck, words: &[&str]) {
    let engine = Engine::from_environment();
    let place = format!("misuse_{}", name.replace([' ', '/'], "_"));
    let outcome = attempt(&engine, &place, scene, deck, 1);
    refused_with(name, &outcome, words);
}

fn refused_with(name: &str, outcome: &Outcome, words: &[&str]) {
    refusal::refused(name, outcome.success, &outcome.output, words);
}

fn with_law(law: &str) -> Deck {
    Deck::new(law)
}

#[test]
fn both_versions_coefficients() {
    let scene = pair_of_grains();
    let cases: &[(&str, &[&str])] = &[
        ("", &["normal law"]),
        ("hooke 1e5 0.1", &["hooke", "hertz"]),
        (
            "hertz 1e7",
            &["'hertz' must be followed by E nu", "missing"],
        ),
        ("hertz", &["'hertz' must be followed by E nu", "missing"]),
        ("hertz 1e7 0.3 0.5", &["unknown word '0.5'"]),
        ("hertz 1e7 0.3 nonsense", &["unknown word 'nonsense'"]),
        ("hertz stiff 0.3", &["'stiff' is not a number"]),
        ("hertz nan 0.3", &["E = NaN", "finite"]),
        ("hertz inf 0.3", &["E = inf", "finite"]),
        ("hertz -1e7 0.3", &["E = -10000000", "greater than 0"]),
        ("hertz 0 0.3", &["E = 0", "greater than 0"]),
        ("hertz 1e7 0.7", &["nu = 0.7", "at most 0.5"]),
        ("hertz 1e7 -1.5", &["nu = -1.5", "greater than -1"]),
        (
            "nfd 1e7 0.3 100",
            &["'nfd' must be followed by E nu eta1 eta2", "missing"],
        ),
        ("nfd 1e7 0.3 -100 100", &["eta1 = -100", "0 or greater"]),
        (
            "nfd 1e7 0.0 100 100 closure brilliantov",
            &["nu = 0", "closure brilliantov"],
        ),
        (
            "nfd 1e7 0.3 100 100 closure nonsense",
            &[
                "unknown word 'nonsense' after 'closure'",
                "energy|surface|brilliantov",
            ],
        ),
        (
            "nfd 1e7 0.3 100 100 unloading slow",
            &["unknown word 'slow' after 'unloading'", "ting|first_order"],
        ),
        ("lsd 1e4", &["'lsd' must be followed by kn cn", "missing"]),
        ("lsd -1e4 1", &["kn = -10000", "greater than 0"]),
        ("lsd 1e4 -1", &["cn = -1", "0 or greater"]),
        (
            "hertz 1e7 0.3 damping",
            &["'damping' must be followed by none|restitution|relaxation"],
        ),
        (
            "hertz 1e7 0.3 damping restitution",
            &["'damping restitution' must be followed by e", "missing"],
        ),
        (
            "hertz 1e7 0.3 damping restitution 1.5",
            &["e = 1.5", "at most 1"],
        ),
        (
            "hertz 1e7 0.3 damping restitution 0",
            &["e = 0", "greater than 0"],
        ),
        (
            "hertz 1e7 0.3 damping relaxation -1e-4",
            &["A_n = -0.0001", "0 or greater"],
        ),
        (
            "hertz 1e7 0.3 damping tsuji",
            &["unknown word 'tsuji' after 'damping'"],
        ),
        (
            "hertz 1e7 0.3 damping none damping none",
            &["'damping' is given twice"],
        ),
        (
            "hertz 1e7 0.3 tangential tfd",
            &["'tangential tfd' must be followed by mu", "missing"],
        ),
        (
            "hertz 1e7 0.3 tangential tfd -0.5",
            &["mu = -0.5", "0 or greater"],
        ),
        (
            "hertz 1e7 0.3 tangential mindlin high",
            &["'tangential mindlin'", "'high' is not a number"],
        ),
        (
            "hertz 1e7 0.3 tangential linear 1e4 0",
            &["'tangential linear' must be followed by kt ct mu"],
        ),
        ("hertz 1e7 0.3 tangential linear -1e4 0 0.5", &["-10000"]),
        (
            "hertz 1e7 0.3 tangential coulomb 0.5",
            &[
                "unknown word 'coulomb' after 'tangential'",
                "none|tfd|mindlin|linear",
            ],
        ),
        (
            "hertz 1e7 0.3 tangential tfd 0.5 displacement sideways",
            &[
                "unknown word 'sideways' after 'displacement'",
                "total|incremental|rescaled",
            ],
        ),
        (
            "hertz 1e7 0.3 factors approximate",
            &["unknown word 'approximate' after 'factors'", "exact|hale"],
        ),
        (
            "hertz 1e7 0.3 conservative maybe",
            &["unknown word 'maybe' after 'conservative'", "yes|no"],
        ),
        (
            "hertz 1e7 0.3 limit_force 1",
            &["unknown word '1' after 'limit_force'", "yes|no"],
        ),
        (
            "hertz 1e7 0.3 rolling",
            &["'rolling' must be followed by none|sds"],
        ),
        (
            "hertz 1e7 0.3 rolling sds 1e4 0",
            &["k_roll gamma_roll mu_roll"],
        ),
        (
            "hertz 1e7 0.3 rolling sds 1e4 0 -0.1",
            &["mu_roll = -0.1", "0 or greater"],
        ),
        (
            "hertz 1e7 0.3 rolling marshall",
            &["unknown word 'marshall' after 'rolling'", "none|sds"],
        ),
        (
            "hertz 1e7 0.3 twisting sds 1e-3 0",
            &["k_twist gamma_twist mu_twist"],
        ),
        (
            "hertz 1e7 0.3 twisting sds -1e-3 0 0.1",
            &["k_twist = -0.001", "0 or greater"],
        ),
        (
            "hertz 1e7 0.3 twisting marshall",
            &["twisting marshall", "tangential", "twisting sds"],
        ),
        (
            "hertz 1e7 0.3 marshall",
            &["did you mean 'twisting marshall'"],
        ),
        // A word without its keyword.
        ("hertz 1e7 0.3 tfd 0.5", &["did you mean 'tangential tfd'"]),
        (
            "hertz 1e7 0.3 restitution 0.5",
            &["did you mean 'damping restitution'"],
        ),
        (
            "nfd 1e7 0.3 100 100 surface",
            &["did you mean 'closure surface'"],
        ),
        ("hertz 1e7 0.3 hale", &["did you mean 'factors hale'"]),
        (
            "hertz 1e7 0.3 nfd 1e7 0.3 100 100",
            &["one normal law, and it comes first"],
        ),
    ];
    for (law, words) in cases {
        refused(
            &format!("pair_coeff * * {law}"),
            &scene,
            &with_law(law),
            words,
        );
    }
}

#[test]
fn both_versions_settings_around_the_pair_style() {
    let scene = pair_of_grains();
    let pair = |lines: &[&str]| Deck::with_pair(lines.iter().map(|s| s.to_string()).collect());
    let style = "pair_style gran/ellipsoid";
    refused(
        "atom_style sphere",
        &scene,
        &Deck {
            atom_style: "sphere".into(),
            ..Deck::new(LAW)
        },
        &["atom style is 'sphere'", "use 'atom_style ellipsoid'"],
    );
    refused(
        "no ghost velocities",
        &scene,
        &Deck {
            before_data: vec!["comm_modify vel no".into()],
            ..Deck::new(LAW)
        },
        &["add 'comm_modify vel yes'"],
    );
    refused(
        "pair_style with coefficients",
        &scene,
        &pair(&["pair_style gran/ellipsoid hertz 1e7 0.3", "pair_coeff * *"]),
        &["unexpected word '1e7'", "pair_coeff"],
    );
    refused(
        "cutoff not a number",
        &scene,
        &pair(&[
            "pair_style gran/ellipsoid wide",
            "pair_coeff * * hertz 1e7 0.3",
        ]),
        &["'wide'"],
    );
    refused(
        "cutoff too short",
        &scene,
        &pair(&[
            "pair_style gran/ellipsoid 0.5",
            "pair_coeff * * hertz 1e7 0.3",
        ]),
        &["cutoff 0.5 is smaller than 2", "types 1 and 1"],
    );
    refused(
        "types out of range",
        &scene,
        &pair(&[style, "pair_coeff 1 3 hertz 1e7 0.3"]),
        &["index 3 is out of bounds"],
    );
    let mut two = pair_of_grains();
    two.kinds = 2;
    two.grains[1].kind = 2;
    // LAMMPS' own message: from 2026 on it names the types too.
    refused(
        "a type without coefficients",
        &two,
        &pair(&[style, "pair_coeff 1 1 hertz 1e7 0.3"]),
        &["not set"],
    );
    refused(
        "no coefficients",
        &scene,
        &pair(&[style]),
        &["pair coeffs are not set"],
    );
    refused(
        "only the mixed pair",
        &two,
        &pair(&[style, "pair_coeff 1 2 hertz 1e7 0.3"]),
        &["not set"],
    );
    refused(
        "laws that do not mix",
        &two,
        &pair(&[
            style,
            "pair_coeff 1 1 hertz 1e7 0.3",
            "pair_coeff 2 2 lsd 1e4 1",
        ]),
        &["types 1 and 2", "cannot be mixed"],
    );
    let respa = Deck {
        fixes: vec!["run_style respa 2 2".into()],
        ..Deck::new(LAW)
    };
    refused(
        "rRESPA",
        &scene,
        &respa,
        &["rRESPA", "use 'run_style verlet'"],
    );
    for units in ["real", "metal", "electron"] {
        let deck = Deck {
            before_data: vec![format!("units {units}")],
            ..Deck::new(LAW)
        };
        refused(
            "units",
            &scene,
            &deck,
            &[&format!("units {units}"), "use units si"],
        );
    }
}

#[test]
fn both_versions_shapes_and_positions() {
    let scene = pair_of_grains();
    let nan = "variable bad atom exp(1000.0)-exp(1000.0)";
    let set = |commands: &[&str]| Deck {
        fixes: commands.iter().map(|s| s.to_string()).collect(),
        steps: 3,
        ..Deck::new(LAW)
    };
    // LAMMPS makes a particle of no extent out of zero axes
    let still = Deck {
        integrate: false,
        ..set(&["set atom 2 shape 0.0 0.0 0.0"])
    };
    refused(
        "zero axes",
        &scene,
        &still,
        &["particle 2", "set type 1 shape"],
    );
    let still = Deck {
        integrate: false,
        ..set(&[nan, "set atom 2 shape v_bad v_bad v_bad"])
    };
    refused(
        "NaN axes",
        &scene,
        &still,
        &["particle 2", "semi-axes", "finite positive length"],
    );
    let infinite = Deck {
        integrate: false,
        ..set(&[
            "variable bad atom exp(1000.0)",
            "set atom 2 shape v_bad 1.0 1.0",
        ])
    };
    refused(
        "infinite axis",
        &scene,
        &infinite,
        &["particle 2", "inf 0.5 0.5"],
    );
    let position = Deck {
        before_data: vec!["atom_modify sort 0 0".into()],
        ..set(&[nan, "set atom 1 vx v_bad"])
    };
    refused(
        "NaN velocity, then position",
        &scene,
        &position,
        &["particle 1", "velocity = (NaN 0 0)"],
    );
    let place = Deck {
        integrate: false,
        ..set(&[nan, "set atom 2 x v_bad"])
    };
    refused("NaN position", &scene, &place, &["Non-numeric"]);
    for (axis, words) in [(0.0, "shape"), (-1.0, "shape"), (f64::NAN, "NaN")] {
        let mut bad = pair_of_grains();
        bad.grains[1].semi_axes[1] = axis;
        refused(
            &format!("axis {axis} in the data file"),
            &bad,
            &Deck::new(LAW),
            &[words],
        );
    }
}

#[test]
fn superellipsoids_that_are_no_ellipsoids() {
    let scene = pair_of_grains();
    let deck = Deck {
        atom_style: "ellipsoid superellipsoid".into(),
        fixes: vec!["set atom 2 block 4.0 4.0".into()],
        ..Deck::new(LAW)
    };
    refused(
        "blockiness",
        &scene,
        &deck,
        &["particle 2", "block 4 4", "block 2 2"],
    );
}

/// Two parallel needles slender enough for Hale's closed form to break down.
#[test]
fn both_versions_hale_factors_beyond_their_range() {
    let a = [300.0, 1.0, 1.0];
    let scene = Scene::open(
        2000.0,
        vec![Grain::new(a, [0.0; 3]), Grain::new(a, [0.0, 1.99, 0.0])],
    );
    refused(
        "Hale's factors",
        &scene,
        &with_law("hertz 1e7 0.3 factors hale conservative no"),
        &[
            "particle 1",
            "the contact with particle 2",
            "25178",
            "factors exact",
        ],
    );
}

#[test]
fn both_versions_walls() {
    let scene = pair_of_grains();
    let wall = |words: &str| Deck {
        fixes: vec![format!("fix floor all wall/gran/ellipsoid {words}")],
        ..Deck::new(LAW)
    };
    let cases: &[(&str, &[&str])] = &[
        ("", &["no law given"]),
        ("hertz 1e7 0.3", &["floor", "no wall given"]),
        (
            "hertz 1e7 zplane -5 NULL",
            &["'zplane' is not a number", "E nu"],
        ),
        ("hertz 1e7 0.9 zplane -5 NULL", &["nu = 0.9", "at most 0.5"]),
        ("hertz 1e7 0.3 wplane -5 NULL", &["unknown word 'wplane'"]),
        ("hertz 1e7 0.3 zplane -5", &["'zplane' needs two positions"]),
        (
            "hertz 1e7 0.3 zplane NULL NULL",
            &["'zplane NULL NULL' has no plane"],
        ),
        ("hertz 1e7 0.3 zplane 5 -5", &["zplane lo 5", "below hi -5"]),
        (
            "hertz 1e7 0.3 zplane -5 NULL spin x 1",
            &["unknown word 'spin' after the wall"],
        ),
        (
            "hertz 1e7 0.3 tangential tfd -1 zplane -5 NULL",
            &["mu = -1", "0 or greater"],
        ),
        (
            "hertz 1e7 0.3 tfd 0.5 zplane -5 NULL",
            &["did you mean 'tangential tfd'"],
        ),
        ("hertz 1e7 0.3 zcylinder", &["'zcylinder' needs 1 value"]),
        ("hertz 1e7 0.3 zcylinder wide", &["'wide'"]),
        (
            "hertz 1e7 0.3 zcylinder 0",
            &["radius = 0", "greater than 0"],
        ),
        (
            "hertz 1e7 0.3 zcylinder -1",
            &["radius = -1", "greater than 0"],
        ),
        ("hertz 1e7 0.3 zcylinder 4 shear x 1", &["shear", "axis"]),
        ("hertz 1e7 0.3 zsphere 4", &["unknown word 'zsphere'"]),
        ("hertz 1e7 0.3 shape", &["'shape' needs a name"]),
        (
            "hertz 1e7 0.3 shape torus",
            &["'torus'", "plane, cylinder, cone, sphere"],
        ),
        (
            "hertz 1e7 0.3 shape sphere radius",
            &["'radius' of shape sphere needs 1 value"],
        ),
        (
            "hertz 1e7 0.3 shape sphere radius 0",
            &["sphere: radius = 0", "greater than 0"],
        ),
        (
            "hertz 1e7 0.3 shape sphere radius 4 radius 5",
            &["'radius' of shape sphere is given twice"],
        ),
        (
            "hertz 1e7 0.3 shape sphere radius 4 side left",
            &[
                "'side' of shape sphere",
                "centre, inside, outside",
                "'left'",
            ],
        ),
        (
            "hertz 1e7 0.3 shape cylinder axis 0 0 0 radius 4",
            &["'cylinder'", "axis = 0 0 0"],
        ),
        (
            "hertz 1e7 0.3 shape cone radii 1 2 bounds 3 2",
            &["cone", "lower bound 3", "upper one 2"],
        ),
        (
            "hertz 1e7 0.3 shape plane point 0 0",
            &["'point' of shape plane needs 3 values"],
        ),
        (
            "hertz 1e7 0.3 shape plane shear x 1",
            &["only a plane", "can shear", "velocity"],
        ),
        (
            "hertz 1e7 0.3 shape plane radius 3",
            &["shape plane has no 'radius'", "point, axis, side"],
        ),
        (
            "hertz 1e7 0.3 shape cone radius 3 bounds 0 1",
            &["shape cone has no 'radius'", "radii"],
        ),
        ("hertz 1e7 0.3 region", &["'region' needs 1 value"]),
        (
            "hertz 1e7 0.3 region nowhere",
            &["region nowhere does not exist"],
        ),
        ("hertz 1e7 0.3 mesh", &["'mesh' needs 1 value"]),
        (
            "hertz 1e7 0.3 mesh none.stl",
            &["STL file none.stl", "No such file"],
        ),
        (
            "hertz 1e7 0.3 mesh scene.data",
            &["STL file scene.data", "not an STL file"],
        ),
        (
            "hertz 1e7 0.3 mesh none.stl scale 0",
            &["scale = 0", "greater than 0"],
        ),
        (
            "hertz 1e7 0.3 mesh none.stl turn 90 0 0 0",
            &["turn needs an axis"],
        ),
        (
            "hertz 1e7 0.3 mesh none.stl move 1 2",
            &["'move' needs 3 values"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL velocity 0 0",
            &["'velocity' needs 3 values"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL rotate 0 0 0 0 0 1",
            &["'rotate' needs 7 values"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL rotate 0 0 0 0 0 0 1",
            &["rotate needs an axis"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL rotate 0 0 0 0 0 1 0",
            &["rotate period 0"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL shear x 1 velocity 0 0 1",
            &["wiggle or shear or move, once"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL contact",
            &["unknown word 'contact' after the wall"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL omega 0 0 0 0 0 0 1",
            &["omega needs an axis"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL rotate 0 0 0 0 0 1 v_t",
            &["the period of rotate is a number", "use omega", "v_t"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL velocity 0 0 v_nowhere",
            &["velocity variable v_nowhere does not exist"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL velocity 0 0 v_",
            &["velocity", "'v_' names no variable"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL omega 0 0 0 0 0 1 v_",
            &["omega", "'v_' names no variable"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 0 0 1 v_ 1",
            &["servo target", "'v_' names no variable"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 0 0 1 5",
            &["'servo' needs 5 values"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 0 0 0 5 1",
            &["servo needs a direction"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 0 0 1 -5 1",
            &["servo: target = -5", "0 or greater"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 0 0 1 5 0",
            &["servo speed 0", "greater than 0"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 0 0 1 5 1 gain 2",
            &["servo: gain = 2", "at most 1"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 0 0 1 5 1 area 0",
            &["servo area 0", "greater than 0"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 0 0 1 5 1 area",
            &["'servo ... area' needs a value"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 0 0 1 v_nowhere 1",
            &["servo target variable v_nowhere does not exist"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 5 servo 0 0 1 5 1",
            &["servo moves one plane", "NULL"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 0 0 -1 5 1",
            &["servo must press towards the grains", "other side"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 1 0 0 5 1",
            &[
                "servo must press towards the grains",
                "lies in the plane",
                "along its normal, 0 0 1",
            ],
        ),
        // a plane of any direction, with a side: it would leave the grains for ever
        (
            "hertz 1e7 0.3 shape plane point 0 0 -5 axis 0 1 2 side inside servo 0 -1 -2 5 1",
            &["servo must press towards the grains", "other side"],
        ),
        (
            "hertz 1e7 0.3 shape plane point 0 0 -5 axis 0 1 2 side outside servo 0 0 1 5 1",
            &["servo must press towards the grains", "other side"],
        ),
        (
            "hertz 1e7 0.3 shape plane point 0 0 -5 axis 0 1 2 servo 0 2 -1 5 1",
            &["lies in the plane", "along its normal"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL servo 0 0 1 5 1 servo 0 0 1 5 1",
            &["servo is given twice"],
        ),
        (
            "hertz 1e7 0.3 material zplane -5 NULL",
            &[
                "'material' with 'hertz' must be followed by E nu",
                "'zplane'",
            ],
        ),
        (
            "hertz 1e7 0.3 material 1e9 0.7 zplane -5 NULL",
            &["material of the wall", "nu = 0.7"],
        ),
        (
            "nfd 1e7 0.3 1 1 material 1e9 0.3 zplane -5 NULL",
            &["'material' with 'nfd' must be followed by E nu eta1 eta2"],
        ),
        (
            "lsd 1e4 1 material rigid zplane -5 NULL",
            &["'material' goes with hertz or nfd", "lsd"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL vtk 10 file.*",
            &["vtk shows triangles", "mesh"],
        ),
        (
            "hertz 1e7 0.3 zplane -5 NULL energies",
            &["'energies' needs 1 value"],
        ),
        ("hertz 1e7 0.3 zplane -5 NULL energies some", &["'some'"]),
    ];
    for (words, expected) in cases {
        refused(&format!("wall {words}"), &scene, &wall(words), expected);
    }
    for (word, reason) in [(" energies no", "'energies no'"), ("", "compute pair")] {
        for value in ["f_floor", "f_floor[7]", "f_floor[9]", "f_floor[12]"] {
            let mut deck = wall(&format!("hertz 1e7 0.3 zplane -5 NULL{word}"));
            deck.thermo_columns = format!("step {value}");
            refused(
                &format!("energies{word} {value}"),
                &scene,
                &deck,
                &["floor", value, reason, "energies yes"],
            );
        }
    }
    let mut deck = wall("hertz 1e7 0.3 zplane -5 NULL energies no");
    deck.fixes.push("compute all all energy/ellipsoid".into());
    let words = ["energy/ellipsoid", "floor", "energies no"];
    refused("energies no and the compute", &scene, &deck, &words);
    let mesh = |name: &str, variables: &[&str], words: &str, expected: &[&str]| {
        let directory = fresh_directory(&format!("misuse_mesh_{}", name.replace(' ', "_")));
        let triangle = crate::mesh_walls::square(2, -5.0, 1);
        std::fs::write(
            directory.join("wall.stl"),
            crate::mesh_walls::binary(&triangle),
        )
        .unwrap();
        let mut deck = wall(&format!("hertz 1e7 0.3 mesh wall.stl {words}"));
        deck.fixes
            .splice(0..0, variables.iter().map(|v| v.to_string()));
        let engine = Engine::from_environment();
        let outcome = attempt_in(&engine, directory, &scene, &deck, 1);
        refused_with(name, &outcome, expected);
    };
    mesh(
        "vtk step",
        &[],
        "vtk 0 wall.*.vtk",
        &["vtk 0", "greater than 0"],
    );
    mesh("vtk name", &[], "vtk 10 wall.vtk", &["wall.vtk", "'*'"]);
    mesh(
        "vtk place",
        &[],
        "vtk 10 nowhere/w.*.vtk",
        &["nowhere/w.0.vtk"],
    );
    mesh(
        "target below 0",
        &["variable t equal 1-2"],
        "servo 0 0 1 v_t 1",
        &["servo: target = -1", "0 or greater"],
    );
    mesh(
        "variable of atoms",
        &["variable t atom x"],
        "servo 0 0 1 v_t 1",
        &["servo target variable v_t", "equal style"],
    );
    mesh(
        "rate without end",
        &["variable t equal exp(1000)"],
        "omega 0 0 0 0 0 1 v_t",
        &["omega variable v_t = inf", "finite"],
    );
    let regions: &[(&[&str], &[&str])] = &[
        (
            &["region r prism -5 5 -5 5 -5 5 0 0 0"],
            &["region r", "prism"],
        ),
        (
            &["variable s equal 5", "region r sphere 0 0 0 v_s"],
            &["region r", "varies"],
        ),
        (
            &[
                "region a sphere 0 0 0 5",
                "region b block -5 5 -5 5 -5 5",
                "region r union 2 a b",
            ],
            &[
                "region r of style union with side in",
                "stick out",
                "a mesh",
            ],
        ),
        (
            &[
                "region a sphere 0 0 0 5",
                "region b block -5 5 -5 5 -5 5",
                "region r intersect 2 a b side out",
            ],
            &[
                "region r of style intersect with side out",
                "stick out",
                "a mesh",
            ],
        ),
        (
            &[
                "variable s equal step",
                "region a sphere 0 0 0 5 move v_s NULL NULL",
                "region b block -5 5 -5 5 -5 5",
                "region r intersect 2 a b",
            ],
            &["region a moves within region r", "intersect"],
        ),
        (
            &["region r block INF 5 -5 5 -5 5 side out"],
            &["region r", "INF"],
        ),
        (
            &["region r cylinder z 0 0 5 -5 5 open 3"],
            &["region r", "open 3"],
        ),
        (
            &["region r block INF INF INF INF INF INF"],
            &["region r", "no surface"],
        ),
    ];
    for (commands, expected) in regions {
        let mut deck = wall("hertz 1e7 0.3 region r");
        deck.fixes
            .splice(0..0, commands.iter().map(|c| c.to_string()));
        refused(
            &format!("wall of {}", commands.last().unwrap()),
            &scene,
            &deck,
            expected,
        );
    }
    let mut periodic = pair_of_grains();
    periodic.boundary = "p p p".into();
    let mut slab = pair_of_grains();
    slab.boundary = "p f f".into();
    let of_region = |region: &str| {
        let mut deck = wall("hertz 1e7 0.3 region r");
        deck.fixes.insert(0, format!("region r {region}"));
        deck
    };
    for (name, scene, deck, dimension) in [
        (
            "zplane",
            &periodic,
            wall("hertz 1e7 0.3 zplane -5 NULL"),
            "z",
        ),
        (
            "shape plane",
            &periodic,
            wall("hertz 1e7 0.3 shape plane"),
            "z",
        ),
        (
            "inclined plane",
            &slab,
            wall("hertz 1e7 0.3 shape plane point 0 0 -5 axis 0.1 0 1"),
            "x",
        ),
        (
            "inclined region",
            &slab,
            of_region("plane 0 0 -5 0.1 0 1"),
            "x",
        ),
        (
            "block that ends where the box does",
            &slab,
            of_region("block EDGE EDGE -5 5 -5 5"),
            "x",
        ),
    ] {
        refused(
            &format!("{name} in a periodic direction"),
            scene,
            &deck,
            &[&format!("periodic dimension, {dimension}"), "INF"],
        );
    }
    for deck in [
        wall("hertz 1e7 0.3 shape plane point 0 0 -5"),
        of_region("block INF INF -5 5 -5 5"),
        of_region("block -4 4 -5 5 -5 5"),
    ] {
        attempt(&Engine::from_environment(), "misuse_none", &slab, &deck, 1).succeeded();
    }
}

/// A wall has the surfaces that its region had when the fix was made: another region of that name stops the run, also where LAMMPS
/// initialises nothing anew.
#[test]
fn both_versions_walls_whose_region_changes_between_runs() {
    let scene = pair_of_grains();
    let engine = Engine::from_environment();
    let whole = "block -5 5 -5 5 -5 5";
    let deck = |between: &[&str], run: &str| Deck {
        fixes: vec![
            format!("region r {whole}"),
            "fix floor all wall/gran/ellipsoid hertz 1e7 0.3 region r".into(),
        ],
        runs: [&["run 0", "region r delete"], between, &[run]]
            .concat()
            .iter()
            .map(|line| line.to_string())
            .collect(),
        ..Deck::new(LAW)
    };
    let same = format!("region r {whole}");
    attempt(
        &engine,
        "misuse_same_region",
        &scene,
        &deck(&[&same], "run 1"),
        1,
    )
    .succeeded();
    for region in [
        "block -5 5 -5 5 -4 5",
        "sphere 0 0 0 5",
        "block -5 5 -5 5 -5 5 open 6",
    ] {
        refused(
            &format!("other region {region}"),
            &scene,
            &deck(&[&format!("region r {region}")], "run 1"),
            &["floor", "region r was defined anew", "give the fix anew"],
        );
    }
    for run in ["run 1", "run 1 pre no"] {
        let words = ["floor", "region r does not exist any more"];
        refused(&format!("no region {run}"), &scene, &deck(&[], run), &words);
    }
}

/// A run without set-up goes on with a neighbour list that such commands make useless, and would give histories to other contacts.
#[test]
fn both_versions_commands_before_a_run_without_set_up() {
    for command in [
        "velocity all create 1e15 4711",
        "delete_atoms group gone",
        "region low block INF INF INF INF INF INF\ncreate_ellipsoids 1 5 region low number 1 shape one 1e-3 1e-3 1e-3",
    ] {
        let mut deck = Deck::new(VISCOUS);
        deck.time_step = 1e-5;
        deck.skin = 2e-3;
        deck.fixes = vec!["group gone id 1:5".into()];
        let lines = std::iter::once("run 5").chain(command.lines());
        deck.runs = lines.map(String::from).collect();
        deck.runs.push("run 5 pre no".into());
        let words = ["atoms and images", "between two runs", "pre no"];
        refused(command, &crowd(64), &deck, &words);
        let with_set_up = deck.runs.len() - 1;
        deck.runs[with_set_up] = "run 5".into();
        run(&Engine::from_environment(), "with_set_up", &crowd(64), &deck, 1);
    }
}

#[test]
fn both_versions_computes_of_time_step_and_contacts() {
    let scene = pair_of_grains();
    let cases: &[(&str, &[&str])] = &[
        ("all timestep/ellipsoid now", &["'now'", "energy_error"]),
        (
            "all timestep/ellipsoid energy_error",
            &["energy_error", "number"],
        ),
        ("all timestep/ellipsoid energy_error small", &["small"]),
        (
            "all timestep/ellipsoid energy_error 0",
            &["energy_error 0", "1e-06"],
        ),
        (
            "all timestep/ellipsoid energy_error 2",
            &["energy_error 2", "0.5"],
        ),
        ("some timestep/ellipsoid", &["group some", "all"]),
        (
            "all contact/ellipsoid/atom cutoff",
            &["'cutoff'", "compute ID group-ID contact/ellipsoid/atom"],
        ),
    ];
    for (words, expected) in cases {
        let deck = Deck {
            fixes: vec!["group some id 1".into(), format!("compute step {words}")],
            ..Deck::new(LAW)
        };
        refused(&format!("compute {words}"), &scene, &deck, expected);
    }
    for style in ["timestep/ellipsoid", "contact/ellipsoid/atom"] {
        let deck = Deck {
            fixes: vec![format!("compute step all {style}")],
            ..Deck::with_pair(vec!["pair_style zero 3.0".into(), "pair_coeff * *".into()])
        };
        refused(
            &format!("compute {style} without contacts"),
            &scene,
            &deck,
            &[style, "pair_style gran/ellipsoid"],
        );
    }
}
