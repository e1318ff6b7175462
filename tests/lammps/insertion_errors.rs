// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is a wrong deck with `fix pour/ellipsoid` or `create_ellipsoids` refused with a message that names the word, the value and the cure?

use crate::harness::{execute, fresh_directory, Engine};
use crate::refusal;

/// The run must be refused with a message that names the words.
fn refused(engine: &Engine, number: usize, before: &str, command: &str, words: &[&str]) {
    let deck = format!(
        "plugin load {}
units si
atom_style ellipsoid
boundary p p f
comm_modify vel yes
neighbor 0.001 bin
region box block 0 0.05 0 0.05 0 0.05
create_box 2 box
region top block 0 0.05 0 0.05 0.02 0.05
pair_style gran/ellipsoid
pair_coeff * * hertz 1e7 0.3
fix move all nve/asphere
timestep 1e-5
{before}
{command}
run 2
",
        engine.plugin.display()
    );
    let directory = fresh_directory(&format!("insertion_error_{number}"));
    let (success, output) = execute(engine, &directory, &deck, 1);
    refusal::refused(command, success, &output, words);
}

const GRAVITY: &str = "fix g all gravity 9.81 vector 0 0 -1";

/// What is before the fix, its words from N on, words of the message.
const STREAMS: &[(&str, &str, &[&str])] = &[
    (GRAVITY, "10 1", &["pour/ellipsoid p", "N, type and seed"]),
    (
        GRAVITY,
        "0 1 7 region top shape one 0.004 0.002 0.002",
        &["N 0", "1 or more"],
    ),
    (
        GRAVITY,
        "ten 1 7 region top shape one 0.004 0.002 0.002",
        &["N", "'ten'", "integer"],
    ),
    (
        GRAVITY,
        "10 3 7 region top shape one 0.004 0.002 0.002",
        &["type 3", "1 to 2"],
    ),
    (
        GRAVITY,
        "10 1 -7 region top shape one 0.004 0.002 0.002",
        &["seed -7", "greater than 0"],
    ),
    (
        GRAVITY,
        "10 1 7 shape one 0.004 0.002 0.002",
        &["no region"],
    ),
    (
        GRAVITY,
        "10 1 7 region away shape one 0.004 0.002 0.002",
        &["region away", "exist"],
    ),
    (
        GRAVITY,
        "10 1 7 region top",
        &["no shape", "shape one dx dy dz"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002",
        &["'shape one' needs 3 values, 2 given"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0",
        &["shape one", "value 0", "greater than 0"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape two 0.004 0.002 0.002",
        &["'two'", "one, range or poly"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape range 0.004 0.002 0.002 0.003 0.002 0.003",
        &["shape range", "0.002", "above"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape poly 2 0.004 0.002 0.002 0.5 0.002 0.002 0.002 0.6",
        &["shape", "sum to 1.1"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape poly 0",
        &["shape poly 0", "1 or more"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 scale poly 2 1 1.5 2 -0.5",
        &["scale", "-0.5", "negative"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 scale range 1 nan",
        &["scale range", "nan"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 fractions volume",
        &["fractions volume", "poly"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 fractions mass",
        &["'mass'", "number or volume"],
    ),
    (
        GRAVITY,
        "10 1 7 region top diam one 0.004",
        &["diam", "shape one D D D"],
    ),
    (
        GRAVITY,
        "10 1 7 region top mol grain",
        &["'mol'", "not supported"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 dens 3000 2000",
        &["dens", "3000", "2000"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 dens -1 2000",
        &["dens", "-1"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 orient up",
        &["'up'", "random, align"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 orient align 0 0 0",
        &["align", "0 0 0"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 orient quat 0 0 0 0",
        &["quat 0 0 0 0"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 vol 1.5 50",
        &["vol", "1.5", "between 0 and 1"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 vol 0.2 0",
        &["attempts 0", "1 or more"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 vel 0 0 0 0",
        &["'vel' needs 5 values, 4 given"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 vel 1 0 0 0 0",
        &["vel", "lower bound 1"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 vel 0 0 0 0 1",
        &["vz 1", "rate 0"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 rate up",
        &["rate", "'up'"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 flow 0",
        &["flow 0", "greater than 0"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 flow 1e6",
        &["flow", "solid fraction", "vol 0.25"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 id least",
        &["'least'", "max or next"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 inside box",
        &["'box'", "grain or centre"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.004 0.002 0.002 spin 1",
        &["unknown word 'spin'"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.03 0.01 0.01",
        &["diameter 0.03", "periodic box"],
    ),
    (
        GRAVITY,
        "10 1 7 region top shape one 0.02 0.02 0.02 vol 0.01 50",
        &["no grain at a time", "larger region"],
    ),
    (
        "",
        "10 1 7 region top shape one 0.004 0.002 0.002",
        &["0 fixes of style gravity"],
    ),
    (
        "fix g all gravity 9.81 vector 1 0 0",
        "10 1 7 region top shape one 0.004 0.002 0.002",
        &["gravity", "along -z"],
    ),
    (
        "fix g all gravity 0 vector 0 0 -1",
        "10 1 7 region top shape one 0.004 0.002 0.002",
        &["without gravity", "vz below 0"],
    ),
    (
        "region high block 0 0.05 0 0.05 0.02 0.08",
        "10 1 7 region high shape one 0.004 0.002 0.002",
        &["region high", "outside the simulation box", "z hi is 0.08"],
    ),
    (
        "variable a equal step\nregion mover block 0 0.05 0 0.05 0.02 0.03 move NULL NULL v_a",
        "10 1 7 region mover shape one 0.004 0.002 0.002",
        &["region mover", "moves"],
    ),
    (
        "region tilted prism 0 0.04 0 0.04 0.02 0.04 0 0 0",
        "10 1 7 region tilted shape one 0.004 0.002 0.002",
        &["region tilted", "prism"],
    ),
    (
        "fix g all gravity 9.81 vector 0 0 -1\ntimestep 0",
        "10 1 7 region top shape one 0.004 0.002 0.002",
        &["time step 0", "do not fall out", "longer time step"],
    ),
    (
        "fix g all gravity 9.81 vector 0 0 -1\ntimestep 0",
        "10 1 7 region top shape one 0.004 0.002 0.002 flow 0.001",
        &["time step 0", "do not fall out", "longer time step"],
    ),
];

/// What is before the command, its words, words of the message.
const FILLS: &[(&str, &str, &[&str])] = &[
    ("", "1", &["create_ellipsoids", "type and seed"]),
    (
        "",
        "0 7 region top fill 0.1 shape one 0.004 0.002 0.002",
        &["type 0", "1 to 2"],
    ),
    (
        "",
        "1 7 region top shape one 0.004 0.002 0.002",
        &["either 'fill'", "'number'"],
    ),
    (
        "",
        "1 7 region top fill 0.1 number 5 shape one 0.004 0.002 0.002",
        &["either 'fill'", "'number'"],
    ),
    (
        "",
        "1 7 region top fill 1.2 shape one 0.004 0.002 0.002",
        &["fill 1.2", "between 0 and 1"],
    ),
    (
        "",
        "1 7 region top number 0 shape one 0.004 0.002 0.002",
        &["number 0", "1 or more"],
    ),
    (
        "",
        "1 7 region top number 2000000000 partial yes shape one 0.004 0.002 0.002",
        &["number 2000000000", "room", "region top"],
    ),
    (
        "",
        "1 7 fill 0.2 shape one 0.004 0.002 0.002",
        &["no region"],
    ),
    ("", "1 7 region top fill 0.1", &["no shape"]),
    (
        "",
        "1 7 region top fill 0.7 shape one 0.008 0.004 0.004 attempts 20",
        &[
            "region top is full at a solid fraction of 0.",
            "0.6997 was asked for",
            "partial yes",
        ],
    ),
    (
        "",
        "1 7 region top fill 0.2 shape one 0.008 0.004 0.004 partial maybe",
        &["'maybe'", "yes or no"],
    ),
    (
        "",
        "1 7 region top fill 0.2 shape one 8e-9 4e-9 4e-9",
        &["grains of mean volume", "units"],
    ),
    (
        "",
        "1 7 region top fill 1e-6 shape one 0.008 0.004 0.004",
        &["less than one grain"],
    ),
    (
        "",
        "1 7 region top fill 0.2 vol 0.1 10 shape one 0.008 0.004 0.004",
        &["unknown word 'vol'"],
    ),
    (
        "change_box all triclinic",
        "1 7 region top fill 0.2 shape one 0.008 0.004 0.004",
        &["triclinic", "before 'change_box"],
    ),
    (
        "create_atoms 1 single 0.02 0.02 0.03",
        "1 7 region top fill 0.1 shape one 0.008 0.004 0.004",
        &["particle 1 of type 1 is not an ellipsoid", "ignore"],
    ),
];

/// LAMMPS finds the whole box within a region with an open face: 79 of 384 grains were put beside such a cup.
const OPEN: &[(&str, &str)] = &[
    (
        "region cup cylinder z 0.025 0.025 0.02 0.01 0.04 open 2",
        "region cup",
    ),
    (
        "region cup block 0.01 0.04 0.01 0.04 0.01 0.04 open 6",
        "region cup",
    ),
    (
        "region pipe cylinder z 0.025 0.025 0.02 0.01 0.04 open 1 open 2
region half block INF INF INF INF 0.02 INF
region cup intersect 2 half pipe",
        "region pipe",
    ),
];

#[test]
fn both_versions_regions_with_open_faces() {
    let engine = Engine::from_environment();
    let words = "1 7 region cup shape one 0.004 0.002 0.002";
    for (k, (region, name)) in OPEN.iter().enumerate() {
        let before = format!("{GRAVITY}\n{region}");
        for (number, command) in [
            (200 + k, format!("fix p all pour/ellipsoid 10 {words}")),
            (210 + k, format!("create_ellipsoids {words} fill 0.1")),
            (
                220 + k,
                format!("create_ellipsoids {words} fill 0.1 inside centre"),
            ),
        ] {
            refused(
                &engine,
                number,
                &before,
                &command,
                &[name, "open faces", "without 'open'"],
            );
        }
    }
}

#[test]
fn both_versions_wrong_streams() {
    let engine = Engine::from_environment();
    for (k, (before, words, expected)) in STREAMS.iter().enumerate() {
        refused(
            &engine,
            k,
            before,
            &format!("fix p all pour/ellipsoid {words}"),
            expected,
        );
    }
}

#[test]
fn both_versions_wrong_fills() {
    let engine = Engine::from_environment();
    for (k, (before, words, expected)) in FILLS.iter().enumerate() {
        refused(
            &engine,
            100 + k,
            before,
            &format!("create_ellipsoids {words}"),
            expected,
        );
    }
}

/// Two dimensions, no box, another atom style, the order of commands.
#[test]
fn both_versions_scenes_in_which_nothing_can_be_inserted() {
    let engine = Engine::from_environment();
    let plugin = engine.plugin.display();
    let fill = "create_ellipsoids 1 7 region top fill 0.1 shape one 0.008 0.004 0.004";
    let pour = "fix p all pour/ellipsoid 10 1 7 region top shape one 0.004 0.002 0.002";
    let space = "region top block 0 1 0 1 0 1\ncreate_box 1 top";
    let cases: [(String, &[&str]); 5] = [
        (format!("dimension 2\natom_style ellipsoid\nregion top block 0 1 0 1 -0.1 0.1\ncreate_box 1 top\n{fill}"), &["dimension 2", "dimension 3"]),
        (format!("atom_style ellipsoid\n{fill}"), &["no simulation box", "create_box"]),
        (format!("atom_style sphere\n{space}\n{pour}"), &["atom style is 'sphere'", "atom_style ellipsoid"]),
        (
            format!("atom_style ellipsoid\n{space}\n{GRAVITY}\n{pour}\ncomm_modify vel yes\npair_style gran/ellipsoid\npair_coeff * * hertz 1e7 0.3\ntimestep 1e-5\nrun 1"),
            &["'pair_style' before this fix"],
        ),
        (
            format!("atom_style hybrid ellipsoid molecular\n{space}\n{GRAVITY}\ncomm_modify vel yes\npair_style gran/ellipsoid\npair_coeff * * hertz 1e7 0.3\nneigh_modify exclude molecule/intra all\n{pour}\ntimestep 1e-5\nrun 1"),
            &["pour/ellipsoid p", "exclude molecule/intra all", "one molecule", "group"],
        ),
    ];
    for (k, (deck, words)) in cases.iter().enumerate() {
        let directory = fresh_directory(&format!("insertion_scene_{k}"));
        let (success, output) = execute(
            &engine,
            &directory,
            &format!("units si\nplugin load {plugin}\n{deck}\n"),
            1,
        );
        refusal::refused(deck, success, &output, words);
    }
}
