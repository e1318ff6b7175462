// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a servo of a mesh go on after a restart as if it had not been interrupted: velocity of the mesh, sum of the errors, load of the step before?

use std::fs;

use crate::decomposition::difference;
use crate::harness::{fresh_directory, run_in, Deck, Engine, Outcome};
use crate::mesh_ranks::{on_a_sheet, sheet_deck};
use crate::meshes::sheet;

const COLUMNS: [&str; 7] = [
    "sheet[1]", "sheet[2]", "sheet[3]", "sheet[4]", "sheet[5]", "sheet[6]", "sheet[9]",
];

fn deck(controller: &str, source: Option<String>, runs: Vec<String>, spheres: bool) -> Deck {
    let columns = COLUMNS.map(|name| format!("f_{name}"));
    let mut deck = Deck {
        before: vec![format!(
            "fix sheet all mesh/surface/stress/servo file sheet.stl type 1 com 0 0 0 {controller}"
        )],
        thermo: format!("step {}", columns.join(" ")),
        integrator: "ellipsoid",
        source: source.into_iter().collect(),
        runs,
        ..sheet_deck()
    };
    if spheres {
        deck.atom_style = "sphere".into();
        deck.wall_fix = "wall/gran".into();
        deck.model = "hertz tangential history".into();
    }
    deck
}

/// Differences of velocities, of the load on the mesh and of its place, over the largest of each, at the end.
fn apart(a: &Outcome, b: &Outcome) -> f64 {
    let (last, first) = (a.thermo().pop().unwrap(), b.thermo().pop().unwrap());
    assert_eq!((last["Step"], a.last().step), (200.0, 200));
    COLUMNS
        .iter()
        .map(|name| (last[*name] - first[*name]).abs() / first[*name].abs().max(1e-9))
        .fold(difference(a.last(), b.last()), f64::max)
}

const CONTROLLERS: [(&str, &str); 4] = [
    (
        "proportional",
        "ctrlPV force axis 0 0 1 target_val 0.5 vel_max 0.1 kp 0.1",
    ),
    (
        "integral",
        "ctrlPV force axis 0 0 1 target_val 0.5 vel_max 0.1 kp 0.1 ki 30 kd 1e-5",
    ),
    (
        "torque",
        "ctrlPV torque axis 0 0 1 target_val 0.002 vel_max 0.5 kp 0.1 ki 30 kd 1e-5",
    ),
    (
        "auto",
        "ctrlPV force axis 0 0 1 target_val 0.5 vel_max 0.1 mode auto ratio 1e-4",
    ),
];

#[test]
fn a_servo_goes_on_after_a_restart() {
    let engine = Engine::from_environment();
    let mut scene = on_a_sheet();
    for (name, controller) in CONTROLLERS {
        for spheres in [false, true] {
            let directory = fresh_directory(&format!("{name}_{spheres}"));
            fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
            if spheres {
                for grain in &mut scene.grains {
                    grain.semi_axes = [grain.semi_axes[2]; 3];
                }
            }
            // LIGGGHTS' own histories beside meshes are not those of the other number of ranks
            let ranks: &[(usize, usize)] = if spheres {
                &[(1, 1)]
            } else {
                &[(1, 1), (1, 2), (2, 1)]
            };
            let whole = |ranks: usize| {
                let runs = ["run 120", "write_restart half", "run 80"].map(String::from);
                run_in(
                    &engine,
                    &directory,
                    &scene,
                    &deck(controller, None, runs.to_vec(), spheres),
                    ranks,
                )
            };
            for &(before, after) in ranks {
                let through = whole(before);
                let rest = deck(
                    controller,
                    Some("read_restart half".into()),
                    vec!["run 80".into()],
                    spheres,
                );
                let again = run_in(&engine, &directory, &scene, &rest, after);
                let apart = apart(&again, &through);
                println!(
                    "{name}, spheres {spheres}, {before} ranks and {after}: apart by {apart:.1e}"
                );
                assert!(
                    apart < 1e-11,
                    "{name}, spheres {spheres}, {before} ranks and {after}: {apart:e}"
                );
            }
        }
        scene = on_a_sheet();
    }
}

/// From a file that LIGGGHTS wrote in the middle of a run, which goes on without being set up anew; and where the run is split.
#[test]
fn a_servo_goes_on_from_the_middle_of_a_run() {
    let engine = Engine::from_environment();
    let scene = on_a_sheet();
    for (name, controller) in CONTROLLERS {
        let directory = fresh_directory(name);
        fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
        let run = |source: Option<&str>, runs: &[&str]| {
            let runs = runs.iter().map(|line| line.to_string()).collect();
            let deck = deck(controller, source.map(String::from), runs, false);
            run_in(&engine, &directory, &scene, &deck, 1)
        };
        let through = run(None, &["restart 120 middle.*", "run 200"]);
        let split = apart(&run(None, &["run 50", "run 150"]), &through);
        let restarted = apart(&run(Some("read_restart middle.120"), &["run 80"]), &through);
        println!(
            "{name}: apart by {split:.1e} where the run is split, by {restarted:.1e} from the file"
        );
        assert!(split < 1e-8 && restarted < 1e-8, "{name}");
    }
}

/// A mesh that is given again, and one that is gone, leave no controller behind.
#[test]
fn a_mesh_given_again_has_a_new_controller() {
    let engine = Engine::from_environment();
    let directory = fresh_directory("again");
    fs::write(directory.join("sheet.stl"), sheet(8)).unwrap();
    let controller = CONTROLLERS[0].1;
    let mesh = &deck(controller, None, vec![], false).before[0];
    let wall = "fix wall0 all wall/gran/ellipsoid model nfd tangential tfd surface ellipsoid mesh n_meshes 1 meshes sheet";
    let runs = [
        "run 20",
        "thermo_style custom step",
        "unfix wall0",
        "unfix sheet",
        "write_restart without",
        "run 20",
        mesh,
        wall,
        "run 20",
        "write_restart with",
    ];
    let first = deck(controller, None, runs.map(String::from).to_vec(), false);
    run_in(&engine, &directory, &on_a_sheet(), &first, 1);
    for file in ["without", "with"] {
        let source = Some(format!("read_restart {file}"));
        let rest = deck(controller, source, vec!["run 20".into()], false);
        run_in(&engine, &directory, &on_a_sheet(), &rest, 2);
    }
}
