// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do grains follow walls that move and turn, over any ranks and restarts?

use crate::harness::{
    attempt_in, largest_difference, last_lines, run, Deck, Engine, Frame, Grain, Scene,
};
use crate::shapes::{about, dot, rotate, Random};

pub const LAW: &str = "nfd 1e6 0.3 20 20 tangential tfd 0.5";
const PERIOD: f64 = 0.4;

/// Forty grains in a drum about x of radius 0.03, ends at -0.02 and 0.02.
pub fn load() -> Scene {
    let mut random = Random(7);
    let grains = (0..40)
        .map(|k| {
            let place = [k % 4, k / 4 % 5, k / 20].map(|c| c as f64);
            Grain {
                density: 2500.0,
                ..Grain::new(
                    [4e-3, 2.5e-3, 2e-3],
                    [
                        -0.0135 + 9e-3 * place[0],
                        -0.018 + 9e-3 * place[1],
                        -0.013 + 9e-3 * place[2],
                    ],
                )
            }
            .turned(random.quaternion())
        })
        .collect();
    Scene::open(0.04, grains)
}

/// The three ways of a deck to the same turning drum.
fn drums() -> [(&'static str, Vec<String>); 3] {
    let rotate = format!("rotate 0 0 0 1 0 0 {PERIOD}");
    let cylinder = "cylinder x 0 0 0.03 -0.02 0.02";
    [
        (
            "cylinder and planes",
            vec![
                format!("fix shell all wall/gran/ellipsoid {LAW} xcylinder 0.03 {rotate}"),
                format!("fix ends all wall/gran/ellipsoid {LAW} xplane -0.02 0.02 {rotate}"),
            ],
        ),
        (
            "region",
            vec![
                format!("region drum {cylinder}"),
                format!("fix shell all wall/gran/ellipsoid {LAW} region drum {rotate}"),
            ],
        ),
        (
            "region that turns",
            vec![
                format!("variable angle equal 2*PI*step*dt/{PERIOD}"),
                format!("region drum {cylinder} rotate v_angle 0 0 0 1 0 0"),
                format!("fix shell all wall/gran/ellipsoid {LAW} region drum"),
            ],
        ),
    ]
}

fn deck(walls: &[String], steps: u64) -> Deck {
    let mut fixes = walls.to_vec();
    fixes.push("fix fall all gravity 98.1 vector 0 0 -1".into());
    Deck {
        fixes,
        time_step: 2e-5,
        steps,
        skin: 1e-3,
        ..Deck::new(LAW)
    }
}

fn aside(frame: &Frame) -> f64 {
    let sum: f64 = frame.states.iter().map(|s| s.position[1]).sum();
    sum / frame.states.len() as f64
}

/// Energies are summed up on request, where a compute asks for them or where LAMMPS adds them to its own. Elsewhere grains move just so, and all
/// other outputs are the same, to the last digit.
#[test]
fn both_versions_energies_are_summed_up_where_somebody_asks() {
    let engine = Engine::from_environment();
    let scene = load();
    let (_, walls) = &drums()[1];
    let compute = |name: &str, word: &str, asks: &str, columns: &str| {
        let mut deck = deck(walls, 1500);
        deck.fixes[1] += word;
        if !asks.is_empty() {
            deck.fixes.push(asks.into());
        }
        deck.thermo_columns =
            format!("step f_shell[10] f_shell[13] f_shell[14] f_shell[17] f_shell[20] {columns}");
        let name = format!("drum_energies_{name}");
        let outcome = run(&engine, &name, &scene, &deck, 1);
        let thermo = outcome.thermo().last().cloned().unwrap();
        (outcome.last().clone(), thermo)
    };
    let energies = "f_shell f_shell[9] f_shell[12]";
    let (expected, sums) = compute("yes", " energies yes", "", energies);
    for number in sums.values() {
        assert!(*number != 0.0, "{sums:?}");
    }
    for (name, asks) in [
        ("pair", "compute contacts all pair gran/ellipsoid"),
        ("all", "compute energy all energy/ellipsoid"),
        ("potential", "fix_modify shell energy yes"),
    ] {
        let (found, same) = compute(name, "", asks, energies);
        assert_eq!(largest_difference(&expected, &found), (0.0, 0.0), "{name}");
        assert_eq!(sums, same, "{name}");
    }
    for (name, word) in [("default", ""), ("no", " energies no")] {
        let (found, same) = compute(name, word, "", "");
        assert_eq!(largest_difference(&expected, &found), (0.0, 0.0), "{name}");
        for (column, number) in &same {
            assert_eq!(number, &sums[column], "{name}: {column}");
        }
    }
}

#[test]
fn both_versions_a_turning_drum_is_the_same_in_all_words_and_on_all_ranks() {
    let engine = Engine::from_environment();
    let scene = load();
    let mut first: Option<Frame> = None;
    for (name, walls) in drums() {
        let outcome = run(&engine, "drum", &scene, &deck(&walls, 2500), 1);
        let last = outcome.last().clone();
        let side = aside(&last);
        println!("{name}: mean y {side:.6}");
        for s in &last.states {
            let [x, y, z] = s.position;
            assert!(
                x.abs() < 0.02 && y.hypot(z) < 0.03,
                "{name}: a grain has left"
            );
        }
        assert!(
            side.abs() > 1e-3,
            "{name}: the load does not lean to the side: {side}"
        );
        let spread = run(&engine, "drum_ranks", &scene, &deck(&walls, 800), 4);
        let alone = run(&engine, "drum_alone", &scene, &deck(&walls, 800), 1);
        let (position, velocity) = largest_difference(spread.last(), alone.last());
        println!("{name}: four ranks beside one: position {position:.1e}, velocity {velocity:.1e}");
        assert!(position < 1e-9 && velocity < 1e-6, "{name}");
        if let Some(first) = &first {
            let (position, _) = largest_difference(alone.last(), first);
            println!("{name}: beside the first: {position:.1e}");
            assert!(position < 1e-6, "{name}");
        } else {
            first = Some(alone.last().clone());
        }
    }
}

/// An axis is a direction, also where the square of its length is no number.
#[test]
fn both_versions_an_axis_has_any_length() {
    let engine = Engine::from_environment();
    let turned = |length: &str| {
        let rotate = format!("rotate 0 0 0 {length} 0 0 {PERIOD}");
        let walls = [format!(
            "fix shell all wall/gran/ellipsoid {LAW} xcylinder 0.03 {rotate}"
        )];
        run(&engine, "drum_axis", &load(), &deck(&walls, 1500), 1)
    };
    let expected = turned("1");
    assert!(aside(expected.last()).abs() > 1e-5);
    for length in ["1e300", "1e-200"] {
        assert_eq!(
            largest_difference(turned(length).last(), expected.last()),
            (0.0, 0.0),
            "{length}"
        );
    }
}

#[test]
fn both_versions_a_turning_drum_goes_on_after_a_restart() {
    let engine = Engine::from_environment();
    let scene = load();
    for (name, walls) in drums() {
        let whole = Deck {
            runs: vec!["run 700".into(), "run 700".into()],
            ..deck(&walls, 1400)
        };
        let whole = run(&engine, "drum_whole", &scene, &whole, 1);
        let half = Deck {
            runs: vec!["run 700".into(), "write_restart middle.restart".into()],
            ..deck(&walls, 700)
        };
        let half = run(&engine, "drum_half", &scene, &half, 1);
        let second = Deck {
            pair: vec![],
            source: vec!["read_restart middle.restart".into()],
            ..deck(&walls, 700)
        };
        // onto more ranks: what is remembered goes along
        let restarted = attempt_in(&engine, half.directory, &scene, &second, 2);
        assert!(restarted.success, "{}", last_lines(&restarted.output));
        let (position, velocity) = largest_difference(restarted.last(), whole.last());
        println!("{name}: restart beside two runs: {position:.1e}, {velocity:.1e}");
        assert!(position < 1e-9 && velocity < 1e-6, "{name}");
    }
}

/// With velocities of the step a run in parts is the run in one, friction with walls that turn included.
#[test]
fn both_versions_a_run_in_parts_is_the_same_in_a_turning_drum() {
    let engine = Engine::from_environment();
    let scene = load();
    let moving = drums().into_iter().chain([(
        "plane that moves and turns",
        vec![format!(
            "fix table all wall/gran/ellipsoid {LAW} zplane -0.02 NULL velocity 0.05 0 0.1 rotate 0 0 0 0 0 1 {PERIOD}"
        )],
    )]);
    for (name, walls) in moving {
        let of = |runs: &[&str]| {
            let mut deck = deck(&walls, 800);
            deck.integrate = false;
            deck.fixes.push("fix move all nve/ellipsoid".into());
            deck.runs = runs.iter().map(|r| r.to_string()).collect();
            deck
        };
        let whole = run(&engine, "drum_in_one", &scene, &of(&["run 1600"]), 1);
        let split = of(&["run 790", "run 10", "run 800"]);
        let split = run(&engine, "drum_in_parts", &scene, &split, 1);
        let half = of(&["run 800", "write_restart middle.restart"]);
        let half = run(&engine, "drum_first_part", &scene, &half, 1);
        let second = Deck {
            pair: vec![],
            source: vec!["read_restart middle.restart".into()],
            ..of(&["run 800"])
        };
        let restarted = attempt_in(&engine, half.directory, &scene, &second, 1);
        assert!(restarted.success, "{}", last_lines(&restarted.output));
        for (what, outcome) in [("split", &split), ("restarted", &restarted)] {
            let (position, velocity) = largest_difference(outcome.last(), whole.last());
            println!("{name}, {what}: positions {position:.1e}, velocities {velocity:.1e}");
            assert!(
                position < 1e-12 && velocity < 1e-10,
                "{name}, {what}: {position:e}, {velocity:e}"
            );
        }
    }
}

/// How a grain with these semi-axes leans outwards on a turntable, its centre at a radius of `place`: the angle about the
/// tangent at which the moments of the weight, of friction and of the turning inertia balance, and the height of its centre.
fn leaning([a, _, c]: [f64; 3], rate: f64, place: f64, gravity: f64) -> (f64, f64) {
    let height = |angle: f64| (a * angle.sin()).hypot(c * angle.cos());
    let moment = |angle: f64| {
        let product = (a * a - c * c) * angle.sin() * angle.cos();
        height(angle) * rate * rate * place
            - product / height(angle) * gravity
            - rate * rate * product / 5.0
    };
    let (mut low, mut high) = (0.0, 0.5);
    assert!(moment(low) > 0.0 && moment(high) < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if moment(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low, height(low))
}

/// A grain that is carried around by a plate keeps its place on it: nothing creeps, and friction turns with the plate. It starts
/// as it leans in the end, but for the displacement of the contact: what that sets swinging is less than 1e-5 m.
#[test]
fn both_versions_a_turntable_carries_a_grain() {
    let engine = Engine::from_environment();
    let (rate, place, gravity) = (2.0 * std::f64::consts::PI / PERIOD, 0.01, 19.62);
    let law = "nfd 1e6 0.3 200 200 tangential tfd 0.9";
    let semi_axes = [6e-3, 5e-3, 3e-3];
    let (angle, height) = leaning(semi_axes, rate, place, gravity);
    let grain = Grain {
        density: 2500.0,
        ..Grain::new(semi_axes, [place, 0.0, height - 4e-5])
    }
    .turned(about([0.0, 1.0, 0.0], angle))
    .moving([0.0, rate * place, 0.0])
    .spinning([0.0, 0.0, rate]);
    // two turns
    let steps = 40_000;
    let time_step = 2.0 * PERIOD / steps as f64;
    let deck = Deck {
        fixes: vec![
            format!(
                "fix table all wall/gran/ellipsoid {law} zplane 0 NULL rotate 0 0 0 0 0 1 {PERIOD}"
            ),
            format!("fix fall all gravity {gravity} vector 0 0 -1"),
        ],
        time_step,
        steps,
        dump_every: steps / 8,
        skin: 1e-3,
        ..Deck::new(law)
    };
    let outcome = run(
        &engine,
        "turntable",
        &Scene::open(0.05, vec![grain]),
        &deck,
        1,
    );
    let settled = &outcome.frames[4];
    let last = outcome.last();
    let on_table = |f: &Frame| {
        let (sin, cos) = (rate * f.step as f64 * time_step).sin_cos();
        let [x, y, _] = f.states[0].position;
        let axis = rotate(f.states[0].quaternion, [1.0, 0.0, 0.0]);
        let turned = dot(axis, [cos, sin, 0.0]) / angle.cos();
        ([cos * x + sin * y, cos * y - sin * x], turned)
    };
    let ((a, _), (b, turned)) = (on_table(settled), on_table(last));
    let moved = (b[0] - a[0]).hypot(b[1] - a[1]);
    let out = (b[0] - place).hypot(b[1]);
    println!("in the second turn it moved by {moved:.1e} m, from its place {out:.1e} m; axis along the table {turned:.9}");
    assert!(moved < 2e-5 && out < 5e-5 && turned > 1.0 - 1e-4);
}

/// A wall that follows variables is the wall that moves by the same law in numbers.
#[test]
fn both_versions_walls_follow_variables() {
    let engine = Engine::from_environment();
    let wall = |words: &str| format!("fix shell all wall/gran/ellipsoid {LAW} {words}");
    let drum = "region drum";
    let region = "region drum cylinder x 0 0 0.03 -0.02 0.02".to_string();
    let rate = format!("variable rate equal 2*PI/{PERIOD}");
    // the time of the run, in the decks' time step
    let clock = "variable t equal step*dt".to_string();
    let swing = "variable v equal 0.002*2*PI/0.05*sin(2*PI*v_t/0.05)".to_string();
    for (name, before, by_variables, by_numbers, bound, part) in [
        (
            "velocity",
            vec!["variable v equal 0.02".to_string()],
            format!("{drum} velocity 0 v_v -0.01"),
            format!("{drum} velocity 0 0.02 -0.01"),
            1e-10,
            1000,
        ),
        (
            "omega",
            vec![],
            format!(
                "{drum} omega 0 0 0 1 0 0 {:.17}",
                2.0 * std::f64::consts::PI / PERIOD
            ),
            format!("{drum} rotate 0 0 0 1 0 0 {PERIOD}"),
            1e-10,
            1000,
        ),
        (
            "omega by a variable",
            vec![rate],
            format!("{drum} velocity 0 0.02 0 omega 0 0 0 1 0 0 v_rate"),
            format!("{drum} velocity 0 0.02 0 rotate 0 0 0 1 0 0 {PERIOD}"),
            1e-9,
            1000,
        ),
        (
            "wiggle",
            vec![clock, swing],
            format!("{drum} velocity 0 0 v_v"),
            format!("{drum} wiggle z 0.002 0.05"),
            // the trapezoidal rule is off by 1e-9 m, and collisions amplify that: a shorter run
            1e-6,
            400,
        ),
    ] {
        let decks = [by_variables, by_numbers].map(|words| {
            let mut walls = before.clone();
            walls.extend([region.clone(), wall(&words)]);
            let mut deck = deck(&walls, 2 * part);
            // a run in parts is another run than a whole one with viscosity: both are made of two
            deck.runs = vec![
                format!("run {part}"),
                "write_restart middle.restart".into(),
                format!("run {part}"),
            ];
            deck.thermo_every = part;
            deck.thermo_columns = "step f_shell[21] f_shell[22] f_shell[23] f_shell[25]".into();
            deck
        });
        let scene = load();
        let wanted = run(&engine, "wall_numbers", &scene, &decks[1], 1);
        let directory = crate::harness::fresh_directory("wall_variables");
        let got = attempt_in(&engine, directory.clone(), &scene, &decks[0], 1).succeeded();
        let mut rest = decks[0].clone();
        rest.source = vec!["read_restart middle.restart".into()];
        rest.pair.clear();
        rest.runs.truncate(1);
        let rest = attempt_in(&engine, directory, &scene, &rest, 2).succeeded();
        for (how, outcome) in [("whole", &got), ("restarted", &rest)] {
            let (position, velocity) = largest_difference(outcome.last(), wanted.last());
            println!("{name}, {how}: {position:.1e} m, {velocity:.1e} m/s");
            assert!(position < bound && velocity < 1e4 * bound, "{name}, {how}");
            let (a, b) = (outcome.thermo(), wanted.thermo());
            for (key, value) in b.last().unwrap() {
                assert!(
                    (a.last().unwrap()[key] - value).abs() < bound,
                    "{name}, {how}: {key}"
                );
            }
        }
        assert!(largest_difference(wanted.last(), wanted.first()).0 > 1e-3);
    }
}

/// A region that moves by its own variables is the wall that moves by the same law in numbers, over a restart too.
#[test]
fn both_versions_a_region_that_moves_by_variables_is_the_wall_that_moves() {
    let engine = Engine::from_environment();
    let drum = "region drum cylinder x 0 0 0.03 -0.02 0.02";
    let wall = format!("fix shell all wall/gran/ellipsoid {LAW} region drum");
    let turn = format!("variable angle equal 2*PI*step*dt/{PERIOD}");
    let slide = "variable d equal 0.05*step*dt".to_string();
    let swing = "variable d equal 0.002*(1-cos(2*PI*step*dt/0.05))".to_string();
    let rotate = "rotate v_angle 0 0 0 1 0 0";
    for (name, variables, of_region, words, bound) in [
        (
            "moves",
            vec![&slide],
            "move NULL v_d NULL".to_string(),
            "velocity 0 0.05 0".to_string(),
            1e-9,
        ),
        // its mean velocity over a step is that of its middle, to second order in the step
        (
            "swings",
            vec![&swing],
            "move NULL NULL v_d".into(),
            "wiggle z 0.002 0.05".into(),
            1e-5,
        ),
        (
            "moves and turns",
            vec![&slide, &turn],
            format!("move NULL v_d NULL {rotate}"),
            format!("velocity 0 0.05 0 rotate 0 0 0 1 0 0 {PERIOD}"),
            1e-9,
        ),
    ] {
        let mut by_region: Vec<String> = variables.into_iter().cloned().collect();
        by_region.extend([format!("{drum} {of_region}"), wall.clone()]);
        let by_wall = [drum.to_string(), format!("{wall} {words}")];
        let [of_region, of_wall] = [&by_region[..], &by_wall[..]].map(|walls| {
            let mut deck = deck(walls, 800);
            deck.runs = vec![
                "run 400".into(),
                "write_restart middle.restart".into(),
                "run 400".into(),
            ];
            deck
        });
        let scene = load();
        let wanted = run(&engine, "region_of_wall", &scene, &of_wall, 1);
        let directory = crate::harness::fresh_directory("region_of_variables");
        let got = attempt_in(&engine, directory.clone(), &scene, &of_region, 1).succeeded();
        let mut rest = of_region.clone();
        rest.source = vec!["read_restart middle.restart".into()];
        rest.pair.clear();
        rest.runs = vec!["run 400".into()];
        let rest = attempt_in(&engine, directory, &scene, &rest, 2).succeeded();
        for (how, outcome) in [("whole", &got), ("restarted", &rest)] {
            let (position, velocity) = largest_difference(outcome.last(), wanted.last());
            println!("{name}, {how}: {position:.1e}, {velocity:.1e}");
            assert!(position < bound && velocity < 1e3 * bound, "{name}, {how}");
        }
        assert!(largest_difference(wanted.last(), wanted.first()).0 > 1e-3);
    }
}

/// In a step of no length a wall is at rest or moves at the speed of that instant, and no number is missing.
#[test]
fn both_versions_walls_move_in_a_step_of_no_length() {
    let engine = Engine::from_environment();
    for motion in ["wiggle z 0.1 1", "velocity 0 0 1", "omega 0 0 0 0 0 1 1"] {
        let deck = Deck {
            fixes: vec![format!(
                "fix floor all wall/gran/ellipsoid {LAW} zplane 0 NULL {motion}"
            )],
            time_step: 0.0,
            steps: 3,
            ..Deck::new(LAW)
        };
        let scene = Scene::open(10.0, vec![Grain::sphere(1.0, [0.0, 0.0, 0.999])]);
        run(&engine, "no_length", &scene, &deck, 1);
    }
}
