// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs LAMMPS on a scene and reads back what it wrote.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::shapes::{
    add, cross, dot, inertia, rotate, scale, unrotate, Quaternion, Vector, IDENTITY,
};

const TIME_LIMIT: Duration = Duration::from_secs(150);

/// The three programs under test, from the environment.
pub struct Engine {
    pub lammps: PathBuf,
    pub plugin: PathBuf,
    pub mpirun: PathBuf,
}

impl Engine {
    pub fn from_environment() -> Engine {
        let read = |name: &str| {
            PathBuf::from(std::env::var_os(name).unwrap_or_else(|| {
                panic!("{name} is not set: these tests drive a real LAMMPS; run them with `cargo xtask test`")
            }))
        };
        Engine {
            lammps: read("ELLGRAN_TEST_LAMMPS"),
            plugin: read("ELLGRAN_TEST_LAMMPS_PLUGIN"),
            mpirun: read("ELLGRAN_TEST_MPIRUN"),
        }
    }
}

/// One grain. Lengths are semi-axes; the angular momentum is in the world frame.
#[derive(Clone, Debug)]
pub struct Grain {
    pub kind: usize,
    pub semi_axes: Vector,
    pub density: f64,
    pub position: Vector,
    pub quaternion: Quaternion,
    pub velocity: Vector,
    pub angular_momentum: Vector,
}

impl Grain {
    pub fn new(semi_axes: Vector, position: Vector) -> Grain {
        Grain {
            kind: 1,
            semi_axes,
            density: 1000.0,
            position,
            quaternion: IDENTITY,
            velocity: [0.0; 3],
            angular_momentum: [0.0; 3],
        }
    }

    pub fn sphere(radius: f64, position: Vector) -> Grain {
        Grain::new([radius; 3], position)
    }

    pub fn turned(mut self, quaternion: Quaternion) -> Grain {
        self.quaternion = quaternion;
        self
    }

    pub fn moving(mut self, velocity: Vector) -> Grain {
        self.velocity = velocity;
        self
    }

    pub fn mass(&self) -> f64 {
        self.density * 4.0 / 3.0
            * std::f64::consts::PI
            * self.semi_axes[0]
            * self.semi_axes[1]
            * self.semi_axes[2]
    }

    /// Gives the angular velocity (world frame) through the angular momentum.
    pub fn spinning(mut self, angular_velocity: Vector) -> Grain {
        let body = unrotate(self.quaternion, angular_velocity);
        let moments = inertia(self.mass(), self.semi_axes);
        self.angular_momentum = rotate(
            self.quaternion,
            std::array::from_fn(|k| moments[k] * body[k]),
        );
        self
    }
}

/// Grains in a box.
#[derive(Clone, Debug)]
pub struct Scene {
    pub grains: Vec<Grain>,
    pub low: Vector,
    pub high: Vector,
    /// Boundary command, e.g. `f f f` or `p p p`.
    pub boundary: String,
    pub kinds: usize,
}

impl Scene {
    /// Open boundaries, box as wide as told in every direction.
    pub fn open(half_width: f64, grains: Vec<Grain>) -> Scene {
        let kinds = grains.iter().map(|g| g.kind).max().unwrap_or(1);
        Scene {
            grains,
            low: [-half_width; 3],
            high: [half_width; 3],
            boundary: "f f f".into(),
            kinds,
        }
    }

    pub fn periodic(low: Vector, high: Vector, grains: Vec<Grain>) -> Scene {
        let kinds = grains.iter().map(|g| g.kind).max().unwrap_or(1);
        Scene {
            grains,
            low,
            high,
            boundary: "p p p".into(),
            kinds,
        }
    }

    fn header(&self, ellipsoids: bool) -> String {
        let mut text = String::from("scene\n\n");
        writeln!(
            text,
            "{} atoms\n{} atom types",
            self.grains.len(),
            self.kinds
        )
        .unwrap();
        if ellipsoids {
            writeln!(text, "{} ellipsoids", self.grains.len()).unwrap();
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
            let [x, y, z] = g.position;
            writeln!(
                text,
                "{} {} 1 {:e} {:e} {:e} {:e}",
                k + 1,
                g.kind,
                g.density,
                x,
                y,
                z
            )
            .unwrap();
        }
        text.push_str("\nEllipsoids\n\n");
        for (k, g) in self.grains.iter().enumerate() {
            let ([a, b, c], [qw, qx, qy, qz]) = (g.semi_axes, g.quaternion);
            let (a, b, c) = (2.0 * a, 2.0 * b, 2.0 * c);
            writeln!(
                text,
                "{} {:e} {:e} {:e} {:e} {:e} {:e} {:e}{block}",
                k + 1,
                a,
                b,
                c,
                qw,
                qx,
                qy,
                qz
            )
            .unwrap();
        }
        text.push_str("\nVelocities\n\n");
        for (k, g) in self.grains.iter().enumerate() {
            let ([u, v, w], [l, m, n]) = (g.velocity, g.angular_momentum);
            writeln!(
                text,
                "{} {:e} {:e} {:e} {:e} {:e} {:e}",
                k + 1,
                u,
                v,
                w,
                l,
                m,
                n
            )
            .unwrap();
        }
        text
    }

    /// The same spheres for `atom_style sphere`.
    pub fn sphere_data(&self) -> String {
        let mut text = self.header(false);
        text.push_str("\nAtoms # sphere\n\n");
        for (k, g) in self.grains.iter().enumerate() {
            let [x, y, z] = g.position;
            let diameter = 2.0 * g.semi_axes[0];
            writeln!(
                text,
                "{} {} {:e} {:e} {:e} {:e} {:e}",
                k + 1,
                g.kind,
                diameter,
                g.density,
                x,
                y,
                z
            )
            .unwrap();
        }
        text.push_str("\nVelocities\n\n");
        for (k, g) in self.grains.iter().enumerate() {
            let moment = inertia(g.mass(), g.semi_axes)[0];
            let ([u, v, w], [l, m, n]) = (g.velocity, scale(1.0 / moment, g.angular_momentum));
            writeln!(
                text,
                "{} {:e} {:e} {:e} {:e} {:e} {:e}",
                k + 1,
                u,
                v,
                w,
                l,
                m,
                n
            )
            .unwrap();
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

/// One particle at one step.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    pub position: Vector,
    pub velocity: Vector,
    pub force: Vector,
    pub torque: Vector,
    /// World frame; zero for `atom_style sphere`.
    pub angular_momentum: Vector,
    /// `atom_style sphere` only.
    pub angular_velocity: Vector,
    pub quaternion: Quaternion,
}

#[derive(Clone, Debug)]
pub struct Frame {
    pub step: u64,
    pub states: Vec<State>,
}

pub struct Outcome {
    pub directory: PathBuf,
    pub success: bool,
    /// Screen output and error stream together.
    pub output: String,
    pub frames: Vec<Frame>,
}

impl Outcome {
    pub fn first(&self) -> &Frame {
        self.frames.first().expect("no frame was dumped")
    }

    pub fn last(&self) -> &Frame {
        self.frames.last().expect("no frame was dumped")
    }

    /// Rows of all thermo tables in the output, in order.
    pub fn thermo(&self) -> Vec<HashMap<String, f64>> {
        thermo_rows(&self.output)
    }
}

pub fn thermo_rows(output: &str) -> Vec<HashMap<String, f64>> {
    let mut rows = vec![];
    let mut header: Option<Vec<&str>> = None;
    for line in output.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if words.first() == Some(&"Step") {
            header = Some(words);
        } else if line.starts_with("Loop time") {
            header = None;
        } else if let Some(names) = &header {
            let values: Option<Vec<f64>> = words.iter().map(|w| w.parse().ok()).collect();
            if let Some(values) = values {
                if values.len() == names.len() {
                    rows.push(names.iter().map(|n| n.to_string()).zip(values).collect());
                }
            }
        }
    }
    rows
}

/// A clean directory of this name under the build directory; another one for each test.
pub fn fresh_directory(name: &str) -> PathBuf {
    let test = std::thread::current()
        .name()
        .unwrap_or("main")
        .replace("::", ".");
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("lammps")
        .join(test)
        .join(name);
    let _ = fs::remove_dir_all(&directory);
    fs::create_dir_all(&directory).expect("cannot create a directory for the run");
    directory
}

/// Runs `deck` in `directory` on `ranks` ranks; returns whether it succeeded and everything it wrote on its streams.
pub fn execute(engine: &Engine, directory: &Path, deck: &str, ranks: usize) -> (bool, String) {
    fs::write(directory.join("in.deck"), deck).unwrap();
    // ranks that wait keep a core busy: one run on several ranks at a time
    static SEVERAL_RANKS: Mutex<()> = Mutex::new(());
    let _alone = (ranks > 1).then(|| SEVERAL_RANKS.lock().unwrap_or_else(|e| e.into_inner()));
    let mut command = if ranks == 1 {
        Command::new(&engine.lammps)
    } else {
        let mut command = Command::new(&engine.mpirun);
        command.arg("-n").arg(ranks.to_string()).arg(&engine.lammps);
        command
    };
    let output = fs::File::create(directory.join("output")).unwrap();
    let errors = output.try_clone().unwrap();
    let mut child = command
        .args(["-in", "in.deck", "-log", "none", "-nocite"])
        .current_dir(directory)
        .env("OMP_NUM_THREADS", "1")
        // Open MPI refuses root and more ranks than cores unless told; other launchers ignore these
        .env("OMPI_ALLOW_RUN_AS_ROOT", "1")
        .env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")
        .env("OMPI_MCA_rmaps_base_oversubscribe", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::from(output))
        .stderr(Stdio::from(errors))
        .spawn()
        .unwrap_or_else(|e| {
            panic!(
                "cannot start {}: {e}",
                command.get_program().to_string_lossy()
            )
        });
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break Some(status);
        }
        if started.elapsed() > TIME_LIMIT {
            let _ = child.kill();
            let _ = child.wait();
            break None;
        }
        std::thread::sleep(Duration::from_millis(
            if started.elapsed().as_millis() < 200 {
                2
            } else {
                20
            },
        ));
    };
    let text = String::from_utf8_lossy(&fs::read(directory.join("output")).unwrap()).into_owned();
    match status {
        Some(status) => (status.success(), text),
        None => panic!(
            "LAMMPS ran longer than {TIME_LIMIT:?} in {}; its last words:\n{}",
            directory.display(),
            last_lines(&text)
        ),
    }
}

pub fn last_lines(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(25)..].join("\n")
}

/// Runs a scene that must succeed.
pub fn run(engine: &Engine, name: &str, scene: &Scene, deck: &Deck, ranks: usize) -> Outcome {
    let outcome = attempt(engine, name, scene, deck, ranks);
    assert!(
        outcome.success,
        "LAMMPS failed in {}:\n{}",
        outcome.directory.display(),
        last_lines(&outcome.output)
    );
    outcome
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
    let frames = fs::read_to_string(directory.join("frames"))
        .map(|text| parse_frames(&text))
        .unwrap_or_default();
    Outcome {
        directory,
        success,
        output,
        frames,
    }
}

pub fn parse_frames(text: &str) -> Vec<Frame> {
    let mut frames = vec![];
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line != "ITEM: TIMESTEP" {
            continue;
        }
        let step = lines.next().unwrap().trim().parse().unwrap();
        lines.next();
        let count: usize = lines.next().unwrap().trim().parse().unwrap();
        let header = loop {
            let line = lines.next().unwrap();
            if let Some(names) = line.strip_prefix("ITEM: ATOMS ") {
                break names.split_whitespace().collect::<Vec<_>>();
            }
        };
        let column = |name: &str| header.iter().position(|n| *n == name);
        let places = |names: [&str; 3]| names.map(column);
        let vectors = [
            places(["xu", "yu", "zu"]),
            places(["vx", "vy", "vz"]),
            places(["fx", "fy", "fz"]),
            places(["tqx", "tqy", "tqz"]),
            places(["angmomx", "angmomy", "angmomz"]),
            places(["omegax", "omegay", "omegaz"]),
        ];
        let quaternion: [Option<usize>; 4] = std::array::from_fn(|k| {
            column(
                [
                    "c_quaternion[1]",
                    "c_quaternion[2]",
                    "c_quaternion[3]",
                    "c_quaternion[4]",
                ][k],
            )
        });
        let mut states = Vec::with_capacity(count);
        for _ in 0..count {
            let values: Vec<f64> = lines
                .next()
                .unwrap()
                .split_whitespace()
                .map(|w| w.parse().unwrap_or(f64::NAN))
                .collect();
            let pick = |k: usize| vectors[k].map(|c| c.map_or(0.0, |c| values[c]));
            states.push(State {
                position: pick(0),
                velocity: pick(1),
                force: pick(2),
                torque: pick(3),
                angular_momentum: pick(4),
                angular_velocity: pick(5),
                quaternion: quaternion.map(|c| c.map_or(0.0, |c| values[c])),
            });
        }
        frames.push(Frame { step, states });
    }
    frames
}

/// Kinetic energy of translation and rotation.
pub fn kinetic_energy(grain: &Grain, state: &State) -> f64 {
    let body = unrotate(state.quaternion, state.angular_momentum);
    let moments = inertia(grain.mass(), grain.semi_axes);
    0.5 * grain.mass() * dot(state.velocity, state.velocity)
        + 0.5 * (0..3).map(|k| body[k] * body[k] / moments[k]).sum::<f64>()
}

pub fn linear_momentum(grains: &[Grain], frame: &Frame) -> Vector {
    grains
        .iter()
        .zip(&frame.states)
        .fold([0.0; 3], |sum, (g, s)| {
            add(sum, scale(g.mass(), s.velocity))
        })
}

/// About the origin, orbital and spin.
pub fn angular_momentum(grains: &[Grain], frame: &Frame) -> Vector {
    grains
        .iter()
        .zip(&frame.states)
        .fold([0.0; 3], |sum, (g, s)| {
            add(
                sum,
                add(
                    scale(g.mass(), cross(s.position, s.velocity)),
                    s.angular_momentum,
                ),
            )
        })
}

/// Largest difference of positions and velocities of two final states, relative to the largest of each.
pub fn largest_difference(a: &Frame, b: &Frame) -> (f64, f64) {
    assert_eq!(a.states.len(), b.states.len());
    let compare = |pick: fn(&State) -> Vector| {
        let mut difference: f64 = 0.0;
        let mut largest: f64 = 0.0;
        for (s, t) in a.states.iter().zip(&b.states) {
            let (u, v) = (pick(s), pick(t));
            for k in 0..3 {
                assert!(
                    u[k].is_finite() && v[k].is_finite(),
                    "a state is not finite"
                );
                difference = difference.max((u[k] - v[k]).abs());
                largest = largest.max(v[k].abs());
            }
        }
        difference / largest.max(f64::MIN_POSITIVE)
    };
    (compare(|s| s.position), compare(|s| s.velocity))
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
