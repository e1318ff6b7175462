// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs LAMMPS on a scene and reads back what it wrote.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use crate::engines::process;
use crate::shapes::{inertia, scale};

pub use crate::engines::frames::*;
pub use crate::engines::process::last_lines;
pub use crate::engines::scene::*;

/// The three programs under test, from the environment, and words of LAMMPS' command line.
pub struct Engine {
    pub lammps: PathBuf,
    pub words: Vec<&'static str>,
    pub plugin: PathBuf,
    pub mpirun: PathBuf,
}

impl Engine {
    pub fn from_environment() -> Engine {
        let read = |name: &str| {
            process::from_environment(
                name,
                "these tests drive a real LAMMPS; run them with `cargo xtask test`",
            )
        };
        Engine {
            lammps: read("ELLGRAN_TEST_LAMMPS"),
            words: vec!["-nocite"],
            plugin: read("ELLGRAN_TEST_LAMMPS_PLUGIN"),
            mpirun: read("ELLGRAN_TEST_MPIRUN"),
        }
    }
}

/// All digits.
fn words(numbers: &[f64]) -> String {
    let words: Vec<String> = numbers.iter().map(|x| format!("{x:e}")).collect();
    words.join(" ")
}

impl Scene {
    fn header(&self, ellipsoids: bool) -> String {
        let mut text = String::from("scene\n\n");
        let (count, kinds) = (self.grains.len(), self.kinds);
        writeln!(text, "{count} atoms\n{kinds} atom types").unwrap();
        if ellipsoids {
            writeln!(text, "{count} ellipsoids").unwrap();
        }
        for (k, axis) in ["x", "y", "z"].iter().enumerate() {
            writeln!(text, "{} {} {axis}lo {axis}hi", self.low[k], self.high[k]).unwrap();
        }
        text
    }

    /// Data file for `atom_style ellipsoid`, every double readable to the same bits.
    pub fn ellipsoid_data(&self, atom_style: &str) -> String {
        // superellipsoids want their two exponents as well
        let block = if atom_style.contains("superellipsoid") {
            " 2 2"
        } else {
            ""
        };
        let mut text = self.header(true);
        text.push_str("\nAtoms # ellipsoid\n\n");
        for (k, g) in self.grains.iter().enumerate() {
            let (kind, density, position) = (g.kind, g.density, words(&g.position));
            writeln!(text, "{} {kind} 1 {density:e} {position}", k + 1).unwrap();
        }
        text.push_str("\nEllipsoids\n\n");
        for (k, g) in self.grains.iter().enumerate() {
            let (diameters, turn) = (words(&scale(2.0, g.semi_axes)), words(&g.quaternion));
            writeln!(text, "{} {diameters} {turn}{block}", k + 1).unwrap();
        }
        text.push_str("\nVelocities\n\n");
        for (k, g) in self.grains.iter().enumerate() {
            let (velocity, momentum) = (words(&g.velocity), words(&g.angular_momentum));
            writeln!(text, "{} {velocity} {momentum}", k + 1).unwrap();
        }
        text
    }

    /// The same spheres for `atom_style sphere`.
    pub fn sphere_data(&self) -> String {
        let mut text = self.header(false);
        text.push_str("\nAtoms # sphere\n\n");
        for (k, g) in self.grains.iter().enumerate() {
            let numbers = words(&[2.0 * g.semi_axes[0], g.density]);
            writeln!(
                text,
                "{} {} {numbers} {}",
                k + 1,
                g.kind,
                words(&g.position)
            )
            .unwrap();
        }
        text.push_str("\nVelocities\n\n");
        for (k, g) in self.grains.iter().enumerate() {
            let moment = inertia(g.mass(), g.semi_axes)[0];
            let spin = words(&scale(1.0 / moment, g.angular_momentum));
            writeln!(text, "{} {} {spin}", k + 1, words(&g.velocity)).unwrap();
        }
        text
    }
}

/// The commands around a scene. `Deck::new(law)` is a plain run of our pair style; change the fields as needed.
#[derive(Clone, Debug)]
pub struct Deck {
    /// Pair style and its coefficients, one command a line.
    pub pair: Vec<String>,
    /// `ellipsoid`, `ellipsoid superellipsoid` or `sphere`.
    pub atom_style: String,
    pub newton: bool,
    pub load_plugin: bool,
    /// Commands before `read_data`.
    pub before_data: Vec<String>,
    /// Commands after the integrator, before the runs.
    pub fixes: Vec<String>,
    pub integrate: bool,
    pub skin: f64,
    pub time_step: f64,
    pub steps: u64,
    /// Dump every so many steps; 0 dumps the first and the last step only.
    pub dump_every: u64,
    pub thermo_every: u64,
    pub thermo_columns: String,
    /// Replaces the final `run` when not empty.
    pub runs: Vec<String>,
    /// Replaces `read_data` when not empty, e.g. `read_restart`.
    pub source: Vec<String>,
}

impl Deck {
    pub fn new(law: &str) -> Deck {
        Deck::with_pair(vec![
            "pair_style gran/ellipsoid".into(),
            format!("pair_coeff * * {law}"),
        ])
    }

    pub fn with_pair(pair: Vec<String>) -> Deck {
        Deck {
            pair,
            atom_style: "ellipsoid".into(),
            newton: true,
            load_plugin: true,
            before_data: vec![],
            fixes: vec![],
            integrate: true,
            skin: 0.1,
            time_step: 1e-3,
            steps: 0,
            dump_every: 0,
            thermo_every: 0,
            thermo_columns: "step pe".into(),
            runs: vec![],
            source: vec![],
        }
    }

    /// A built-in style on `atom_style sphere`, no plugin.
    pub fn built_in_spheres(pair: Vec<String>) -> Deck {
        Deck {
            atom_style: "sphere".into(),
            load_plugin: false,
            ..Deck::with_pair(pair)
        }
    }

    pub fn text(&self, engine: &Engine, scene: &Scene, data: &str, dump: &str) -> String {
        let mut lines = vec![
            "units si".to_string(),
            format!("atom_style {}", self.atom_style),
            format!("newton {}", if self.newton { "on" } else { "off" }),
            format!("boundary {}", scene.boundary),
            "comm_modify vel yes".into(),
            format!("neighbor {:e} bin", self.skin),
            "neigh_modify delay 0 every 1 check yes".into(),
        ];
        if self.load_plugin {
            lines.push(format!("plugin load {}", engine.plugin.display()));
        }
        lines.extend(self.before_data.iter().cloned());
        if self.source.is_empty() {
            lines.push(format!("read_data {data}"));
        } else {
            lines.extend(self.source.iter().cloned());
        }
        lines.extend(self.pair.iter().cloned());
        lines.push(format!("timestep {:e}", self.time_step));
        let spheres = self.atom_style == "sphere";
        if self.integrate {
            lines.push(format!(
                "fix move all {}",
                if spheres { "nve/sphere" } else { "nve/asphere" }
            ));
        }
        lines.extend(self.fixes.iter().cloned());
        let columns = if spheres {
            "omegax omegay omegaz"
        } else {
            lines.push("compute quaternion all property/atom quatw quati quatj quatk".into());
            "angmomx angmomy angmomz c_quaternion[1] c_quaternion[2] c_quaternion[3] c_quaternion[4]"
        };
        let every = if self.dump_every == 0 {
            self.steps.max(1)
        } else {
            self.dump_every
        };
        lines.push(format!(
            "dump frames all custom {every} {dump} id type xu yu zu vx vy vz fx fy fz tqx tqy tqz {columns}"
        ));
        lines.push("dump_modify frames sort id first yes format float %.17g".into());
        lines.push(format!("thermo {}", self.thermo_every));
        lines.push(format!("thermo_style custom {}", self.thermo_columns));
        lines.push("thermo_modify norm no format float %.17g".into());
        if self.runs.is_empty() {
            lines.push(format!("run {}", self.steps));
        } else {
            lines.extend(self.runs.iter().cloned());
        }
        lines.join("\n") + "\n"
    }
}

pub fn fresh_directory(name: &str) -> PathBuf {
    process::fresh_directory("lammps", name)
}

/// Runs `deck` in `directory` on `ranks` ranks; whether it succeeded, and everything it wrote on its streams.
pub fn execute(engine: &Engine, directory: &Path, deck: &str, ranks: usize) -> (bool, String) {
    process::execute(
        &engine.lammps,
        &engine.words,
        &engine.mpirun,
        directory,
        deck,
        ranks,
    )
}

/// Runs a scene that must succeed.
pub fn run(engine: &Engine, name: &str, scene: &Scene, deck: &Deck, ranks: usize) -> Outcome {
    attempt(engine, name, scene, deck, ranks).succeeded()
}

/// Runs a scene that may fail.
pub fn attempt(engine: &Engine, name: &str, scene: &Scene, deck: &Deck, ranks: usize) -> Outcome {
    let directory = fresh_directory(name);
    attempt_in(engine, directory, scene, deck, ranks)
}

/// As `attempt`, in a directory that may hold files of an earlier run (a restart).
pub fn attempt_in(
    engine: &Engine,
    directory: PathBuf,
    scene: &Scene,
    deck: &Deck,
    ranks: usize,
) -> Outcome {
    let data = if deck.atom_style == "sphere" {
        scene.sphere_data()
    } else {
        scene.ellipsoid_data(&deck.atom_style)
    };
    fs::write(directory.join("scene.data"), data).unwrap();
    let _ = fs::remove_file(directory.join("frames"));
    let text = deck.text(engine, scene, "scene.data", "frames");
    let (success, output) = execute(engine, &directory, &text, ranks);
    Outcome::read(directory, success, output)
}

/// Forces of many scenes in one LAMMPS process, `clear` between them: for each scene and each of its laws (a list of
/// arguments of `pair_coeff`) one frame.
pub fn forces_of_many(
    engine: &Engine,
    name: &str,
    scenes: &[Scene],
    laws: &[Vec<Vec<String>>],
    atom_style: &str,
) -> Vec<Vec<Frame>> {
    let directory = fresh_directory(name);
    let mut text = String::new();
    for (k, scene) in scenes.iter().enumerate() {
        fs::write(
            directory.join(format!("{k}.data")),
            scene.ellipsoid_data(atom_style),
        )
        .unwrap();
        let skin = 1e-2 * (scene.high[0] - scene.low[0]);
        let commands = [
            "clear".to_string(),
            "units si".into(),
            format!("atom_style {atom_style}"),
            format!("boundary {}", scene.boundary),
            "comm_modify vel yes".into(),
            format!("neighbor {skin:e} bin"),
            format!("plugin load {}", engine.plugin.display()),
            format!("read_data {k}.data"),
            "pair_style gran/ellipsoid".into(),
            "compute quaternion all property/atom quatw quati quatj quatk".into(),
            "timestep 1e-12".into(),
            "fix move all nve/asphere".into(),
        ];
        text.push_str(&commands.join("\n"));
        for (l, law) in laws[k].iter().enumerate() {
            for command in law {
                write!(text, "\npair_coeff {command}").unwrap();
            }
            write!(
                text,
                "\nrun 0 post no\nwrite_dump all custom {k}.{l}.frame id xu yu zu fx fy fz tqx tqy tqz \
                 modify sort id format float %.17g"
            )
            .unwrap();
        }
        text.push('\n');
    }
    let (success, output) = execute(engine, &directory, &text, 1);
    assert!(
        success,
        "LAMMPS failed in {}:\n{}",
        directory.display(),
        last_lines(&output)
    );
    (0..scenes.len())
        .map(|k| {
            (0..laws[k].len())
                .map(|l| {
                    let text =
                        fs::read_to_string(directory.join(format!("{k}.{l}.frame"))).unwrap();
                    parse_frames(&text).pop().expect("no frame was written")
                })
                .collect()
        })
        .collect()
}
