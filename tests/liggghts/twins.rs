// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do the scenes of examples/twins go the same way in both engines: grain by grain until chaos, then in the mean?

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::engines::dump::tables;
use crate::engines::frames::thermo_rows;
use crate::harness::{self, fresh_directory, last_lines};
use crate::lammps;

/// What a deck printed, and the places of the grains by step.
struct Run {
    rows: Vec<HashMap<String, f64>>,
    places: Vec<(u64, Vec<[f64; 3]>)>,
}

impl Run {
    fn new(success: bool, output: &str, directory: &Path, scene: &str) -> Run {
        assert!(success, "{scene}:\n{}", last_lines(output));
        let text = fs::read_to_string(directory.join(format!("{scene}.places"))).unwrap();
        let places = tables(&text).expect("a dump").into_iter().map(|table| {
            let place = |row: &Vec<f64>| [row[1], row[2], row[3]];
            (table.step, table.rows.iter().map(place).collect())
        });
        Run {
            rows: thermo_rows(output),
            places: places.collect(),
        }
    }

    fn column<'r>(&'r self, name: &str) -> impl Iterator<Item = f64> + 'r {
        let name = name.to_string();
        self.rows.iter().map(move |row| row[&name])
    }

    /// Mean over the rows from `first` on.
    fn mean(&self, name: &str, first: f64) -> f64 {
        let values: Vec<f64> = self
            .rows
            .iter()
            .filter(|row| row["Step"] >= first)
            .map(|row| row[name])
            .collect();
        values.iter().sum::<f64>() / values.len() as f64
    }
}

/// The decks of a scene, run where they lie, but for what they write.
fn both(scene: &str) -> [Run; 2] {
    let examples = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples");
    let directory = |engine: &str| {
        let directory = fresh_directory(&format!("twins_{scene}_{engine}"));
        for (from, files) in [
            ("twins", vec![format!("{scene}.grains")]),
            ("lammps", vec!["lifters.stl".into()]),
            ("liggghts", vec!["hopper.stl".into()]),
        ] {
            for file in files {
                fs::copy(examples.join(from).join(&file), directory.join(&file)).unwrap();
            }
        }
        directory
    };
    let deck = |ending: &str| {
        let text = fs::read_to_string(examples.join(format!("twins/{scene}.{ending}"))).unwrap();
        text.replace("../lammps/", "").replace("../liggghts/", "")
    };
    let of_liggghts = {
        let engine = harness::Engine::from_environment();
        let directory = directory("liggghts");
        let (success, output) = harness::execute(&engine, &directory, &deck("lig"), 1);
        Run::new(success, &output, &directory, scene)
    };
    let of_lammps = {
        let engine = lammps::Engine::from_environment();
        let directory = directory("lammps");
        let plugin = format!("variable plugin index {}\n", engine.plugin.display());
        let (success, output) = lammps::execute(&engine, &directory, &(plugin + &deck("lmp")), 1);
        Run::new(success, &output, &directory, scene)
    };
    [of_lammps, of_liggghts]
}

/// How far apart a grain is at most, by step.
fn apart(runs: &[Run; 2]) -> Vec<(u64, f64)> {
    let [a, b] = runs;
    let steps = a.places.iter().zip(&b.places);
    steps
        .take_while(|(p, q)| p.1.len() == q.1.len())
        .map(|((step, p), (other, q))| {
            assert_eq!(step, other);
            let pairs = p.iter().zip(q);
            let most = pairs
                .flat_map(|(p, q)| (0..3).map(move |k| (p[k] - q[k]).abs()))
                .fold(0.0, f64::max);
            (*step, most)
        })
        .collect()
}

/// How far apart the grains are at most in this step.
fn at(apart: &[(u64, f64)], step: u64) -> f64 {
    let found = apart.iter().find(|(of, _)| *of == step);
    found.unwrap_or_else(|| panic!("no step {step}")).1
}

fn relative(a: f64, b: f64) -> f64 {
    (a / b - 1.0).abs()
}

/// The drum turns, and the two engines take the velocity of a turning mesh at points that are half an overlap apart: grains move apart by
/// some 1e-4 of their way from the first contacts on, at any time step, and by less the stiffer they are (examples/twins/README.md).
#[test]
fn the_drum_of_both_engines() {
    let runs = both("drum");
    let apart = apart(&runs);
    println!("apart, by step: {apart:?}");
    assert!(at(&apart, 1000) == 0.0, "the fall");
    assert!(at(&apart, 1500) < 1e-7 && at(&apart, 2000) < 3e-6);
    for (what, names, allowed) in [
        ("torque", ["f_drum[17]", "drum[4]"], 0.08),
        ("y", ["c_y", "y"], 0.05),
        ("z", ["c_z", "z"], 0.05),
    ] {
        let [a, b] = [0, 1].map(|k| runs[k].mean(names[k], 10_000.0));
        let off = relative(a, b);
        println!("{what}: {a:.4e} and {b:.4e}, apart by {off:.1e}");
        // Means over 0.3 s in which the load slides back once: 63 grains.
        assert!(off < allowed, "{what}");
    }
}

/// A mesh at rest: what is left is that one engine reads its file in single precision.
#[test]
fn the_hopper_of_both_engines() {
    let runs = both("hopper");
    let apart = apart(&runs);
    println!("apart, by step: {apart:?}");
    assert!(at(&apart, 2500) == 0.0, "the fall");
    assert!(at(&apart, 3000) < 2e-9 && at(&apart, 3500) < 6e-9 && at(&apart, 4000) < 7e-8);
    // Grains a step between a tenth and three quarters of them.
    let [a, b] = [(0, "c_above"), (1, "above")].map(|(k, name)| {
        let above: Vec<f64> = runs[k].column(name).collect();
        let steps: Vec<f64> = runs[k].column("Step").collect();
        let when = |share: f64| {
            let wanted = above[0] * (1.0 - share);
            let k = above.iter().position(|n| *n < wanted).expect("it empties");
            let within = (above[k - 1] - wanted) / (above[k - 1] - above[k]);
            steps[k - 1] + within * (steps[k] - steps[k - 1])
        };
        assert_eq!(*above.last().unwrap(), 0.0);
        0.65 * above[0] / (when(0.75) - when(0.1)) / 2e-5
    });
    println!("{a:.1} and {b:.1} grains a second");
    // 130 grains that pass in no order: their number in a time varies by less than its root.
    assert!(relative(a, b) < 0.09);
}
