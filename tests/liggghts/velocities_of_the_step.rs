// SPDX-License-Identifier: MIT OR Apache-2.0
//! With `fix nve/ellipsoid`: do contact forces see velocities of the step at which they are computed, in our loop over pairs and in
//! LIGGGHTS' own, at walls and meshes, and does a run that is split or restarted go on as one that is not, under viscous laws too?

use std::fs;

use crate::harness::{
    attempt, between_walls, crowd, fresh_directory, largest_difference, last_rows, run, run_in,
    Deck, Engine, Frame, Grain, Material, Outcome, Scene, State,
};
use crate::meshes::sheet;
use crate::shapes::{add, dot, length, mass, scale, sub, surface_point, Random};

const VISCOUS: Material = [1e8, 0.3, 2e3, 2e3];
const ELLIPSOIDS: &str = "nfd tangential tfd surface ellipsoid";

fn deck(model: &str) -> Deck {
    Deck {
        model: model.into(),
        integrator: "ellipsoid",
        time_step: 1e-5,
        ..Deck::new(VISCOUS, 0.5)
    }
}

fn gap(a: &Outcome, b: &Outcome) -> f64 {
    assert_eq!(a.last().step, b.last().step);
    let (positions, velocities) = largest_difference(a.last(), b.last());
    positions.max(velocities)
}

const SMALL: f64 = 5e-3;
/// Largest overlap of a head-on collision at 1 m/s.
const OVERLAP: f64 = 0.02 * SMALL;
/// Of Hertz' collision (docs/theory.md, section 6).
const CONTACT_TIME: f64 = 2.943_275_184_324_704_7 * OVERLAP;
const MEETINGS: usize = 12;

/// As in tests/theory/velocities_of_the_step.rs: aspect ratio 2, restitution 0.9, first touch anywhere within a step.
fn meetings() -> (Scene, Material) {
    let mut random = Random(11);
    let axes = [2.0 * SMALL, SMALL, SMALL];
    let density = 2500.0;
    let mut grains = vec![];
    for k in 0..MEETINGS {
        let turns = [random.quaternion(), random.quaternion()];
        let n = random.direction();
        let reach = sub(
            surface_point(axes, turns[0], n),
            surface_point(axes, turns[1], scale(-1.0, n)),
        );
        let apart = add(reach, scale(OVERLAP * random.between(0.05, 0.25), n));
        let place = [0.06 * (k % 4) as f64, 0.06 * (k / 4) as f64, 0.0];
        let grain = |turn: usize, place| Grain {
            density,
            ..Grain::new(axes, place).turned(turns[turn])
        };
        let towards = sub(scale(0.3, random.direction()), n);
        grains.push(grain(0, place));
        grains.push(grain(1, add(place, apart)).moving(towards));
    }
    let effective_mass = 0.5 * mass(density, axes);
    let poissons_ratio = 0.3;
    let stiffness = 1.25 * effective_mass / OVERLAP.powf(2.5);
    let modulus = 1.5 * (1.0 - poissons_ratio * poissons_ratio) * stiffness / SMALL.sqrt();
    let relaxation = 0.094 / 1.5 / (stiffness / effective_mass).powf(0.4);
    let viscosity = relaxation * modulus / 1.275_238;
    (
        Scene::open(0.3, grains),
        [modulus, poissons_ratio, viscosity, viscosity],
    )
}

/// Of each pair of grains.
fn energies(scene: &Scene, frame: &Frame) -> Vec<f64> {
    let of = |(grain, s): (&Grain, &State)| {
        0.5 * grain.mass() * dot(s.velocity, s.velocity)
            + 0.5 * dot(s.angular_velocity, s.angular_momentum)
    };
    let all: Vec<f64> = scene.grains.iter().zip(&frame.states).map(of).collect();
    all.chunks(2).map(|pair| pair[0] + pair[1]).collect()
}

#[test]
fn the_energy_error_of_a_collision_falls_as_the_square_of_the_step() {
    let engine = Engine::from_environment();
    let (scene, material) = meetings();
    for (model, mu, most) in [
        ("nfd surface ellipsoid", 0.0, [1e-4, 1.5e-5, 4e-7]),
        (ELLIPSOIDS, 0.5, [2e-4, 1e-4, 1e-5]),
    ] {
        let after = |integrator: &'static str, steps: u64| {
            let deck = Deck {
                model: model.into(),
                time_step: CONTACT_TIME / steps as f64,
                steps: 4 * steps,
                integrator,
                ..Deck::new(material, mu)
            };
            let name = format!("{model} {integrator} {steps}").replace(' ', "_");
            let outcome = run(&engine, &name, &scene, &deck, 1);
            let (before, after) = (outcome.first(), outcome.last());
            assert!(after.states.iter().all(|s| s.force == [0.0; 3]));
            let before = energies(&scene, before);
            let after = energies(&scene, after);
            after
                .iter()
                .zip(before)
                .map(|(after, before)| after / before)
                .collect::<Vec<_>>()
        };
        let fine = after("ellipsoid velocities step", 8000);
        assert!(fine.iter().all(|kept| *kept < 0.97), "{fine:?}");
        let errors = |integrator: &'static str| {
            [50, 100, 1000].map(|steps| {
                let found = after(integrator, steps);
                let squares = found.iter().zip(&fine).map(|(a, b)| (a - b) * (a - b));
                (squares.sum::<f64>() / fine.len() as f64).sqrt()
            })
        };
        let half = errors("ellipsoid velocities half");
        let step = errors("ellipsoid");
        println!("{model}: half {half:?}, step {step:?}");
        for k in 0..3 {
            assert!(step[k] < most[k] && 3.0 * step[k] < half[k], "{model}");
        }
    }
}

/// Laws, and how the contacts are computed.
fn cases() -> Vec<(&'static str, Deck)> {
    let walls = || {
        vec![
            "primitive type 1 xplane -3e-3".into(),
            "primitive type 1 xplane 0.099".into(),
            "primitive type 1 zplane -3e-3".into(),
            "primitive type 1 zplane 0.099".into(),
        ]
    };
    let of = |model: &str, settings: &str| Deck {
        settings: settings.into(),
        walls: walls(),
        ..deck(model)
    };
    let one_by_one = |deck: Deck| Deck {
        // Where the virial is asked for in each step, LIGGGHTS' own loop runs.
        fixes: vec![
            "compute stress all stress/atom".into(),
            "compute sum all reduce sum c_stress[1]".into(),
        ],
        thermo: "step ke c_sum".into(),
        ..deck
    };
    let mut mesh = of(ELLIPSOIDS, "");
    mesh.before = vec![
        "fix sheet all mesh/surface file sheet.stl type 1 scale 0.79 move 0.048 0.048 -3e-3".into(),
    ];
    mesh.walls[2] = "mesh n_meshes 1 meshes sheet".into();
    vec![
        ("normal alone", of("nfd surface ellipsoid", "")),
        ("friction", of(ELLIPSOIDS, "")),
        ("total displacement", of(ELLIPSOIDS, "totalDisplacement on")),
        ("restitution", of(ELLIPSOIDS, "restitutionDamping on")),
        ("one by one", one_by_one(of(ELLIPSOIDS, ""))),
        (
            "normal one by one",
            one_by_one(of("nfd surface ellipsoid", "")),
        ),
        ("mesh", mesh),
        (
            "their own",
            of("hertz tangential no_history surface ellipsoid", ""),
        ),
    ]
}

const HALF: u64 = 150;

#[test]
fn split_and_restarted_runs_go_on_under_viscous_laws() {
    let engine = Engine::from_environment();
    let scene = between_walls();
    for (k, (name, deck)) in cases().into_iter().enumerate() {
        let ranks = match k {
            0 => [1, 4],
            1 => [4, 1],
            _ if k % 2 == 0 => [1, 2],
            _ => [2, 1],
        };
        let each = if name.ends_with("one by one") {
            1
        } else {
            2 * HALF
        };
        let with = |what: &str, runs: &[&str], source: &[&str], ranks: usize| {
            let lines = |all: &[&str]| all.iter().map(|line| line.to_string()).collect::<Vec<_>>();
            let deck = Deck {
                steps: HALF,
                runs: [&[&*format!("thermo {each}")], runs]
                    .concat()
                    .iter()
                    .map(|l| l.to_string())
                    .collect(),
                source: lines(source),
                ..deck.clone()
            };
            let directory = fresh_directory(&format!("{name} {what}").replace(' ', "_"));
            fs::write(directory.join("sheet.stl"), sheet(4)).unwrap();
            if !source.is_empty() {
                let first = directory.with_file_name(format!("{name} first").replace(' ', "_"));
                fs::copy(first.join("middle"), directory.join("middle")).unwrap();
            }
            run_in(&engine, &directory, &scene, &deck, ranks)
        };
        let whole = with("whole", &["run 300"], &[], ranks[0]);
        let touching = whole.last().states.iter().filter(|s| s.force != [0.0; 3]);
        assert!(touching.count() >= 6, "{name}: few grains touch");
        let split = with(
            "split",
            &[
                "run 100",
                "write_restart between",
                "run 0",
                "run 50",
                "run 80",
                "run 70",
            ],
            &[],
            ranks[1],
        );
        with("first", &["run 150", "write_restart middle"], &[], ranks[0]);
        let restarted = with(
            "restarted",
            &["run 150"],
            &["read_restart middle"],
            ranks[1],
        );
        for (what, outcome) in [("split", &split), ("restarted", &restarted)] {
            let gap = gap(outcome, &whole);
            println!("{name}, {what}: {gap:.1e}");
            assert!(gap < 1e-12, "{name}, {what}: {gap:e}");
        }
    }
}

/// A run is split in the very step in which a contact begins, while another force acts.
#[test]
fn a_run_may_be_split_where_a_contact_begins() {
    let engine = Engine::from_environment();
    let grain = Grain::new([1e-2, 8e-3, 7e-3], [0.0, 0.0, 7.05e-3]).moving([0.3, 0.0, -0.5]);
    let scene = Scene::open(0.1, vec![grain]);
    let with = |runs: &[String]| {
        let deck = Deck {
            walls: vec!["primitive type 1 zplane 0.0".into()],
            fixes: vec!["fix weight all gravity 50 vector 0 0 -1".into()],
            runs: runs.to_vec(),
            dump_every: 1,
            ..deck(ELLIPSOIDS)
        };
        run(&engine, "begins", &scene, &deck, 1)
    };
    let whole = with(&["run 60".into()]);
    let begins = whole.frames.iter().find(|f| f.states[0].force[0] != 0.0);
    let begins = begins.expect("a contact").step;
    assert!(begins > 1 && begins < 50, "{begins}");
    let split = with(&[format!("run {begins}"), format!("run {}", 60 - begins)]);
    let gap = gap(&split, &whole);
    println!("split in step {begins}: {gap:.1e}");
    assert!(gap < 1e-12, "{gap:e}");
}

/// Without viscosity and friction the motion is that of the half step; contact by contact it is that of the whole list; ranks and groups
/// change nothing.
#[test]
fn loops_ranks_and_groups_move_the_grains_alike() {
    let engine = Engine::from_environment();
    let scene = between_walls();
    let moved = |name: &str, deck: Deck, ranks: usize| {
        let directory = fresh_directory(name);
        fs::write(directory.join("sheet.stl"), sheet(4)).unwrap();
        run_in(&engine, &directory, &scene, &deck, ranks)
    };
    let find = |name: &str| {
        let deck = cases()
            .into_iter()
            .find(|(case, _)| *case == name)
            .unwrap()
            .1;
        Deck { steps: 300, ..deck }
    };
    let elastic = |integrator: &'static str| Deck {
        materials: vec![[1e8, 0.3, 0.0, 0.0]],
        integrator,
        ..find("normal alone")
    };
    let half = moved("elastic_half", elastic("ellipsoid velocities half"), 1);
    let step = moved("elastic_step", elastic("ellipsoid velocities step"), 1);
    let apart = gap(&step, &half);
    println!("elastic: {apart:.1e}");
    assert!(apart < 1e-12, "{apart:e}");

    for (list, single) in [
        ("friction", "one by one"),
        ("normal alone", "normal one by one"),
    ] {
        let one = moved("list", find(list), 1);
        let single = Deck {
            runs: vec!["thermo 1".into(), "run 300".into()],
            ..find(single)
        };
        let apart = [
            gap(&moved("singly", single, 1), &one),
            gap(&moved("ranks", find(list), 4), &one),
        ];
        println!(
            "{list}: one by one {:.1e}, four ranks {:.1e}",
            apart[0], apart[1]
        );
        assert!(apart.iter().all(|apart| *apart < 1e-9), "{list}: {apart:?}");
        let half = Deck {
            integrator: "ellipsoid velocities half",
            ..find(list)
        };
        let apart = gap(&moved("half", half, 1), &one);
        assert!(apart > 1e-9, "the word changes nothing: {apart:e}");
    }

    let one = moved("one_group", find("friction"), 1);
    let groups = Deck {
        fixes: [
            "group a id <> 1 30",
            "group b subtract all a",
            "unfix move",
            "fix a a nve/ellipsoid",
            "fix b b nve/ellipsoid",
        ]
        .map(str::to_string)
        .to_vec(),
        ..find("friction")
    };
    let apart = gap(&moved("two_groups", groups, 4), &one);
    println!("two groups: {apart:.1e}");
    assert!(apart < 1e-11, "{apart:e}");
}

/// Outputs of contacts have the force that acted in the step.
#[test]
fn local_output_has_the_forces_that_acted() {
    let engine = Engine::from_environment();
    let scene = crowd(64);
    let deck = Deck {
        steps: 300,
        fixes: vec![
            "compute contacts all pair/gran/local id force".into(),
            "dump contacts all local 300 contacts c_contacts[1] c_contacts[2] c_contacts[4] c_contacts[5] c_contacts[6]".into(),
            "dump_modify contacts format \"%.17g %.17g %.17g %.17g %.17g\"".into(),
        ],
        ..deck("nfd surface ellipsoid")
    };
    let outcome = run(&engine, "local", &scene, &deck, 1);
    let mut sums = vec![[0.0; 3]; scene.grains.len()];
    let rows = last_rows(&outcome.directory.join("contacts"));
    for row in &rows {
        let force = [row[2], row[3], row[4]];
        let (i, j) = (row[0] as usize - 1, row[1] as usize - 1);
        sums[i] = add(sums[i], force);
        sums[j] = sub(sums[j], force);
    }
    let states = &outcome.last().states;
    let size = states.iter().map(|s| length(s.force)).fold(0.0, f64::max);
    let apart = sums
        .iter()
        .zip(states)
        .map(|(sum, s)| length(sub(*sum, s.force)));
    let apart = apart.fold(0.0, f64::max) / size;
    println!("{} contacts, off by {apart:.1e}", rows.len());
    assert!(rows.len() >= 3 && apart < 1e-11, "{apart:e}");
}

#[test]
fn springs_of_their_own_keep_velocities_of_the_half_step() {
    let engine = Engine::from_environment();
    // Of a smaller crowd some grains would touch others in two places, across the periodic box.
    let scene = crowd(27);
    for model in [
        "hertz tangential history surface ellipsoid",
        "nfd tangential tfd rolling_friction epsd2 surface ellipsoid",
    ] {
        let with = |integrator: &'static str| {
            let rolling =
                "fix mu all property/global coefficientRollingFriction peratomtypepair 1 0.1";
            let deck = Deck {
                steps: 100,
                before: vec![rolling.into()],
                integrator,
                ..deck(model)
            };
            attempt(&engine, "springs", &scene, &deck, 1)
        };
        let [default, half] =
            ["ellipsoid", "ellipsoid velocities half"].map(|i| with(i).succeeded());
        assert_eq!(default.last().states, half.last().states, "{model}");
        assert!(default.output.contains("velocities half, since"), "{model}");
        let step = with("ellipsoid velocities step");
        let words = step.output.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            !step.success && words.contains("sums up a displacement"),
            "{model}: {words}"
        );
    }
    let refused = |integrator: &'static str, said: &str| {
        let deck = Deck {
            integrator,
            ..deck(ELLIPSOIDS)
        };
        let outcome = attempt(&engine, "words", &scene, &deck, 1);
        let words = outcome
            .output
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        assert!(
            !outcome.success && words.contains(said),
            "{integrator}: {words}"
        );
    };
    refused("ellipsoid fast", "unknown word 'fast'");
    refused("ellipsoid velocities full", "'velocities full' must be");
}
