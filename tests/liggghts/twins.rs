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

/// Runs of each engine whose means are compared: the first from the deck's start, the others from starts in which each grain is moved by up to
/// [`MOVED`].
const RUNS: usize = 6;

/// Distance in m that is more than what the engines set apart before chaos begins (8e-5 m at 0.08 s). With less, the runs of one engine
/// would share their first contacts, and scatter less than runs of two engines do.
const MOVED: f64 = 1e-4;

/// A difference of two means counts from so many of its standard errors on: with ten degrees of freedom, one comparison in a thousand.
const STANDARD_ERRORS: f64 = 4.5;

/// The decks of a scene, run where they lie, but for what they write: LAMMPS and LIGGGHTS.
fn both(scene: &str) -> [Vec<Run>; 2] {
    let engines = (
        harness::Engine::from_environment(),
        lammps::Engine::from_environment(),
    );
    let runs = (0..RUNS).map(|number| {
        [
            run_liggghts(&engines.0, scene, number),
            run_lammps(&engines.1, scene, number),
        ]
    });
    let (of_liggghts, of_lammps) = runs.map(|[a, b]| (a, b)).unzip();
    [of_lammps, of_liggghts]
}

fn run_liggghts(engine: &harness::Engine, scene: &str, number: usize) -> Run {
    let directory = directory(scene, "liggghts", number);
    let (success, output) = harness::execute(engine, &directory, &deck(scene, "lig", number), 1);
    Run::new(success, &output, &directory, scene)
}

fn run_lammps(engine: &lammps::Engine, scene: &str, number: usize) -> Run {
    let directory = directory(scene, "lammps", number);
    let plugin = format!("variable plugin index {}\n", engine.plugin.display());
    let text = plugin + &deck(scene, "lmp", number);
    let (success, output) = lammps::execute(engine, &directory, &text, 1);
    Run::new(success, &output, &directory, scene)
}

fn examples() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples")
}

/// A directory with what the decks of a scene read.
fn directory(scene: &str, engine: &str, number: usize) -> PathBuf {
    let directory = fresh_directory(&format!("twins_{scene}_{engine}_{number}"));
    for (from, file) in [
        ("twins", format!("{scene}.grains")),
        ("lammps", "lifters.stl".into()),
        ("liggghts", "hopper.stl".into()),
    ] {
        fs::copy(examples().join(from).join(&file), directory.join(&file)).unwrap();
    }
    directory
}

/// A deck of the scene; from the second on, with its grains moved.
fn deck(scene: &str, ending: &str, number: usize) -> String {
    let text = fs::read_to_string(examples().join(format!("twins/{scene}.{ending}"))).unwrap();
    let text = text.replace("../lammps/", "").replace("../liggghts/", "");
    // LIGGGHTS asks for seeds that are prime.
    let seeds: [u64; RUNS - 1] = [10_007, 10_009, 10_037, 10_039, 10_061];
    let Some(of_seeds) = number.checked_sub(1) else {
        return text;
    };
    let read = "include      ${grains}\n";
    let (before, after) = text.split_once(read).expect("a deck that reads its grains");
    let moved = format!(
        "displace_atoms all random {MOVED:e} {MOVED:e} {MOVED:e} {} units box\n",
        seeds[of_seeds]
    );
    format!("{before}{read}{moved}{after}")
}

/// Fails where the means of the two engines' runs differ by more than the scatter of the runs explains, or where the runs scatter by more than
/// `scatter` of their mean and so would tell nothing.
fn agree(what: &str, values: [Vec<f64>; 2], scatter: f64) {
    let count = RUNS as f64;
    let [a, b] = values.map(|values| {
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        println!("{what}: {mean:.4e} of {values:?}");
        (mean, squares / (count - 1.0))
    });
    let deviation = (0.5 * (a.1 + b.1)).sqrt();
    let error = deviation * (2.0 / count).sqrt();
    let (relative_deviation, off) = ((deviation / a.0).abs(), (a.0 - b.0).abs());
    println!(
        "{what}: a run scatters by {relative_deviation:.1e}, means apart by {:.1} standard errors",
        off / error
    );
    assert!(
        relative_deviation < scatter,
        "{what} scatters by {relative_deviation:.1e}"
    );
    assert!(
        off < STANDARD_ERRORS * error,
        "{what}: {:.4e} and {:.4e}",
        a.0,
        b.0
    );
}

/// How far apart a grain is at most, by step.
fn apart(runs: &[Vec<Run>; 2]) -> Vec<(u64, f64)> {
    let [a, b] = [&runs[0][0], &runs[1][0]];
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

/// The drum turns, and the two engines take the velocity of a turning mesh at points that are half an overlap apart: grains move apart by
/// some 1e-4 of their way from the first contacts on, at any time step, and by less the stiffer they are (examples/twins/README.md).
#[test]
fn the_drum_of_both_engines() {
    let runs = both("drum");
    let apart = apart(&runs);
    println!("apart, by step: {apart:?}");
    assert!(at(&apart, 1000) == 0.0, "the fall");
    assert!(at(&apart, 1500) < 1e-7 && at(&apart, 2000) < 3e-6);
    // Means over 0.3 s in which 63 grains slide back once.
    for (what, names, scatter) in [
        ("torque", ["f_drum[17]", "drum[4]"], 0.1),
        ("y", ["c_y", "y"], 0.05),
        ("z", ["c_z", "z"], 0.05),
    ] {
        let means = [0, 1].map(|k| {
            let means = runs[k].iter().map(|run| run.mean(names[k], 10_000.0));
            means.collect()
        });
        agree(what, means, scatter);
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
    let rates = [(0, "c_above"), (1, "above")].map(|(k, name)| {
        let rates = runs[k].iter().map(|run| rate_of_discharge(run, name));
        rates.collect()
    });
    agree("grains a second", rates, 0.08);
}

/// Grains a second between a tenth and three quarters of them.
fn rate_of_discharge(run: &Run, above: &str) -> f64 {
    let above: Vec<f64> = run.column(above).collect();
    let steps: Vec<f64> = run.column("Step").collect();
    let when = |share: f64| {
        let wanted = above[0] * (1.0 - share);
        let k = above.iter().position(|n| *n < wanted).expect("it empties");
        let within = (above[k - 1] - wanted) / (above[k - 1] - above[k]);
        steps[k - 1] + within * (steps[k] - steps[k - 1])
    };
    assert_eq!(*above.last().unwrap(), 0.0);
    0.65 * above[0] / (when(0.75) - when(0.1)) / 2e-5
}
