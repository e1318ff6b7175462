// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs LIGGGHTS on a scene and reads back what it wrote.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use crate::engines::process;
use crate::shapes::{self, Vector};

pub use crate::engines::frames::*;
pub use crate::engines::process::last_lines;
pub use crate::engines::scene::*;

/// The programs under test, from the environment.
pub struct Engine {
    pub liggghts: PathBuf,
    pub mpirun: PathBuf,
}

impl Engine {
    pub fn from_environment() -> Engine {
        let read = |name: &str| {
            process::from_environment(
                name,
                "these tests drive a real LIGGGHTS; `cargo xtask path liggghts` builds it",
            )
        };
        Engine {
            liggghts: read("ELLGRAN_TEST_LIGGGHTS"),
            mpirun: read("ELLGRAN_TEST_MPIRUN"),
        }
    }
}

/// E, nu, eta1, eta2 of a type.
pub type Material = [f64; 4];

pub const ELASTIC: Material = [1e7, 0.3, 0.0, 0.0];

/// The commands around a scene.
#[derive(Clone, Debug)]
pub struct Deck {
    /// The words after `model`, for the pair style and the walls.
    pub model: String,
    /// What stands after them.
    pub settings: String,
    pub atom_style: String,
    pub materials: Vec<Material>,
    pub friction: f64,
    /// Of each pair of types, row by row; 0.9 where empty.
    pub restitution: Vec<f64>,
    /// `primitive ...` or `mesh ...`, one fix each.
    pub walls: Vec<String>,
    /// Words that begin the wall fixes.
    pub wall_fix: String,
    /// Commands after the atoms, before the pair style.
    pub before: Vec<String>,
    /// Commands before the run.
    pub fixes: Vec<String>,
    /// Of ellipsoids: `superquadric` or `ellipsoid`.
    pub integrator: &'static str,
    pub time_step: f64,
    pub steps: u64,
    /// Dump every so many steps; 0 dumps the first and the last step only.
    pub dump_every: u64,
    pub skin: f64,
    pub thermo: String,
    /// Replaces the atoms, e.g. `read_restart`.
    pub source: Vec<String>,
    /// Replaces the final `run`.
    pub runs: Vec<String>,
}

impl Deck {
    pub fn new(material: Material, friction: f64) -> Deck {
        Deck {
            model: "nfd tangential tfd surface ellipsoid".into(),
            settings: String::new(),
            atom_style: "superquadric".into(),
            materials: vec![material],
            friction,
            restitution: vec![],
            walls: vec![],
            wall_fix: "wall/gran/ellipsoid".into(),
            before: vec![],
            fixes: vec![],
            integrator: "superquadric",
            time_step: 1e-6,
            steps: 0,
            dump_every: 0,
            skin: 2e-3,
            thermo: "step ke".into(),
            source: vec![],
            runs: vec![],
        }
    }

    pub fn text(&self, scene: &Scene, data: &str, dump: &str) -> String {
        let mut lines = vec![
            format!("atom_style {}", self.atom_style),
            "atom_modify map array".into(),
            format!("boundary {}", scene.boundary),
            "newton off".into(),
            "communicate single vel yes".into(),
            "units si".into(),
            "hard_particles yes".into(),
            "soft_particles yes".into(),
        ];
        if self.source.is_empty() {
            lines.push(format!("read_data {data}"));
            if self.atom_style == "superquadric" {
                for (k, g) in scene.grains.iter().enumerate() {
                    let [w, x, y, z] = g.quaternion;
                    lines.push(format!(
                        "set atom {} quat_direct {w:e} {x:e} {y:e} {z:e}",
                        k + 1
                    ));
                }
            }
            for (k, g) in scene.grains.iter().enumerate() {
                if g.angular_momentum == [0.0; 3] {
                    continue;
                }
                let [a, b, c] = angular_velocity(g);
                lines.push(format!(
                    "set atom {} omegax {a:e} omegay {b:e} omegaz {c:e}",
                    k + 1
                ));
            }
        } else {
            lines.extend(self.source.iter().cloned());
        }
        lines.push(format!("neighbor {:e} bin", self.skin));
        lines.push("neigh_modify delay 0".into());
        lines.extend(self.before.iter().cloned());
        let per_type = |k: usize| {
            self.materials
                .iter()
                .map(|m| format!("{:e}", m[k]))
                .collect::<Vec<_>>()
                .join(" ")
        };
        let types = self.materials.len();
        for (k, name) in [
            "youngsModulus",
            "poissonsRatio",
            "viscosityShear",
            "viscosityBulk",
        ]
        .iter()
        .enumerate()
        {
            lines.push(format!(
                "fix {name} all property/global {name} peratomtype {}",
                per_type(k)
            ));
        }
        let restitution = if self.restitution.is_empty() {
            vec![0.9; types * types]
        } else {
            self.restitution.clone()
        };
        for (name, values) in [
            ("coefficientFriction", vec![self.friction; types * types]),
            ("coefficientRestitution", restitution),
        ] {
            let values: String = values.iter().map(|value| format!(" {value}")).collect();
            lines.push(format!(
                "fix {name} all property/global {name} peratomtypepair {types}{values}"
            ));
        }
        lines.push(format!(
            "pair_style gran model {} {}",
            self.model, self.settings
        ));
        lines.push("pair_coeff * *".into());
        for (k, wall) in self.walls.iter().enumerate() {
            lines.push(format!(
                "fix wall{k} all {} model {} {wall} {}",
                self.wall_fix, self.model, self.settings
            ));
        }
        lines.push(format!("timestep {:e}", self.time_step));
        let sphere = self.atom_style != "superquadric";
        let integrator = if sphere { "sphere" } else { self.integrator };
        lines.push(format!("fix move all nve/{integrator}"));
        lines.extend(self.fixes.iter().cloned());
        let momentum = if sphere {
            ""
        } else {
            " angmomx angmomy angmomz"
        };
        let every = if self.dump_every == 0 {
            self.steps.max(1)
        } else {
            self.dump_every
        };
        lines.push(format!(
            "dump frames all custom {every} {dump} id xu yu zu vx vy vz fx fy fz tqx tqy tqz omegax omegay omegaz{momentum}"
        ));
        lines.push(format!(
            "dump_modify frames sort id first yes format \"%d{}\"",
            " %.17g".repeat(if sphere { 15 } else { 18 })
        ));
        lines.push(format!("thermo_style custom {}", self.thermo));
        lines.push("thermo_modify lost error norm no format float %.17g".into());
        lines.push(format!("thermo {}", self.steps.max(1)));
        if self.runs.is_empty() {
            lines.push(format!("run {}", self.steps));
        } else {
            lines.extend(self.runs.iter().cloned());
        }
        lines.join("\n") + "\n"
    }
}

pub fn angular_velocity(g: &Grain) -> Vector {
    shapes::angular_velocity(g.mass(), g.semi_axes, g.quaternion, g.angular_momentum)
}

pub fn data(scene: &Scene, atom_style: &str) -> String {
    let mut text = format!(
        "scene\n\n{} atoms\n{} atom types\n",
        scene.grains.len(),
        scene.kinds
    );
    for (k, axis) in ["x", "y", "z"].iter().enumerate() {
        writeln!(
            text,
            "{:e} {:e} {axis}lo {axis}hi",
            scene.low[k], scene.high[k]
        )
        .unwrap();
    }
    text.push_str("\nAtoms\n\n");
    for (k, g) in scene.grains.iter().enumerate() {
        let ([x, y, z], [a, b, c]) = (g.position, g.semi_axes);
        let (id, kind, density) = (k + 1, g.kind, g.density);
        if atom_style == "superquadric" {
            writeln!(
                text,
                // without the patch LIGGGHTS takes the whole number that each coordinate begins with for an image flag: 0.005, not 5e-3
                "{id} {kind} {density:e} {a:e} {b:e} {c:e} 2 2 {x} {y} {z}"
            )
            .unwrap();
        } else {
            writeln!(
                text,
                "{id} {kind} {:e} {density:e} {x:e} {y:e} {z:e}",
                2.0 * a
            )
            .unwrap();
        }
    }
    text.push_str("\nVelocities\n\n");
    for (k, g) in scene.grains.iter().enumerate() {
        let [u, v, w] = g.velocity;
        writeln!(text, "{} {u:e} {v:e} {w:e} 0 0 0", k + 1).unwrap();
    }
    text
}

/// A clean directory of this name; another one for each test.
pub fn fresh_directory(name: &str) -> PathBuf {
    process::fresh_directory("liggghts", name)
}

/// Runs `deck` in `directory`; whether it succeeded, and all that it wrote on its streams.
pub fn execute(engine: &Engine, directory: &Path, deck: &str, ranks: usize) -> (bool, String) {
    let (success, text) = process::execute(
        &engine.liggghts,
        &[],
        &engine.mpirun,
        directory,
        deck,
        ranks,
    );
    (success && !text.contains("ERROR"), text)
}

/// One run that may fail.
pub fn attempt(engine: &Engine, name: &str, scene: &Scene, deck: &Deck, ranks: usize) -> Outcome {
    attempt_in(engine, &fresh_directory(name), scene, deck, ranks)
}

/// As `attempt`, in a directory that may hold files of the caller's.
pub fn attempt_in(
    engine: &Engine,
    directory: &Path,
    scene: &Scene,
    deck: &Deck,
    ranks: usize,
) -> Outcome {
    fs::write(directory.join("scene.data"), data(scene, &deck.atom_style)).unwrap();
    let _ = fs::remove_file(directory.join("frames"));
    let text = deck.text(scene, "scene.data", "frames");
    let (success, output) = execute(engine, directory, &text, ranks);
    Outcome::read(directory.into(), success, output)
}

/// One run that must succeed.
pub fn run(engine: &Engine, name: &str, scene: &Scene, deck: &Deck, ranks: usize) -> Outcome {
    attempt(engine, name, scene, deck, ranks).succeeded()
}

pub fn run_in(
    engine: &Engine,
    directory: &Path,
    scene: &Scene,
    deck: &Deck,
    ranks: usize,
) -> Outcome {
    attempt_in(engine, directory, scene, deck, ranks).succeeded()
}
