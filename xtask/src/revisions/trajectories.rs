// SPDX-License-Identifier: MIT OR Apache-2.0
//! `cargo xtask trajectories`: grains that collide with one another and with walls, under every law, on every instruction set of this
//! machine; a digest of where they end, and how far another revision is from it.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{bail, Context, Result};
use sha2::{Digest, Sha256};

use super::kinds::packing::{Frame, Random};
use super::scene::{Scene, Shape};
use super::{play, Revision};
use crate::bench::contender::Contender;
use crate::progress::{say, Progress};
use crate::setup;

#[derive(clap::Args)]
pub struct Options {
    /// Compare with this revision (any name that git knows), which is built in the cache when it is asked for the first time
    #[arg(long)]
    against: Option<String>,
    /// Only the scenes whose name contains this (repeat for more)
    #[arg(long)]
    scene: Vec<String>,
    /// Fail if a relative difference is larger; 0 asks for the same bits
    #[arg(long, requires = "against")]
    tolerance: Option<f64>,
}

/// What is compared of a trajectory, in the order in which player.c writes it; forces are those of the last step and their sums over all.
const PARTS: [&str; 3] = ["motion", "forces", "histories"];
const STEPS: usize = 500;
const TIME_STEP: f64 = 2e-5;
const DENSITY: f64 = 2500.0;
/// Towards the origin or away from it, 1/s^2: 100 m/s^2 at the corner of a cube of grains.
const PULL: f64 = 5e3;
/// Grains along each direction.
const SIDE: usize = 4;

/// Forms of grains, the largest semi-axis 5 mm. Of the mixture each grain has another form.
const FORMS: [(&str, &[[f64; 3]]); 5] = [
    ("spheres", &[[5e-3, 5e-3, 5e-3]]),
    ("spheroids", &[[5e-3, 2.5e-3, 2.5e-3], [5e-3, 5e-3, 3e-3]]),
    ("triaxial", &[[5e-3, 4e-3, 3e-3]]),
    ("needles", &[[5e-3, 0.5e-3, 0.5e-3]]),
    (
        "mixture",
        &[
            [5e-3, 5e-3, 5e-3],
            [2.5e-3, 2.5e-3, 5e-3],
            [3e-3, 4e-3, 5e-3],
            [1e-3, 5e-3, 5e-3],
        ],
    ),
];

const NFD: &str = "nfd 1e7 0.3 50 20";
const HERTZ: &str = "hertz 1e7 0.3";
const LSD: &str = "lsd 5e3 0.5";

/// Laws: a name, and the words after a normal law. A test sees that every word of every table of src/force is in one of them.
const LAWS: [(&str, &str, &str); 30] = [
    ("nfd", NFD, ""),
    ("nfd, tfd", NFD, "tangential tfd 0.5"),
    ("nfd, mindlin", NFD, "tangential mindlin 0.5"),
    ("nfd, linear", NFD, "tangential linear 4e3 0.2 0.5"),
    ("nfd, total", NFD, "tangential tfd 0.5 displacement total"),
    (
        "nfd, hysteretic",
        NFD,
        "tangential tfd 0.5 displacement hysteretic",
    ),
    (
        "nfd, incremental",
        NFD,
        "tangential tfd 0.5 displacement incremental",
    ),
    (
        "nfd, rescaled",
        NFD,
        "tangential mindlin 0.5 displacement rescaled",
    ),
    (
        "nfd, conservative no",
        NFD,
        "tangential tfd 0.5 conservative no",
    ),
    (
        "nfd, limit_force no",
        NFD,
        "tangential tfd 0.5 limit_force no unloading first_order",
    ),
    (
        "nfd, ting",
        NFD,
        "tangential tfd 0.5 unloading ting viscosity first_order",
    ),
    ("nfd, surface", NFD, "tangential tfd 0.5 closure surface"),
    ("nfd, energy", NFD, "tangential tfd 0.5 closure energy"),
    (
        "nfd, brilliantov",
        NFD,
        "tangential tfd 0.5 closure brilliantov",
    ),
    ("nfd, hale", NFD, "tangential tfd 0.5 factors hale"),
    ("nfd, memory", NFD, "tangential tfd 0.5 viscosity memory"),
    ("hertz", HERTZ, "tangential none damping none factors exact"),
    ("hertz, conservative no", HERTZ, "conservative no"),
    ("hertz, tfd", HERTZ, "tangential tfd 0.5"),
    (
        "hertz, restitution, tfd",
        HERTZ,
        "damping restitution 0.7 tangential tfd 0.5",
    ),
    (
        "hertz, restitution, mindlin",
        HERTZ,
        "damping restitution 0.7 tangential mindlin 0.3",
    ),
    (
        "hertz, relaxation, tfd",
        HERTZ,
        "damping relaxation 1e-5 tangential tfd 0.5",
    ),
    (
        "hertz, relaxation, linear",
        HERTZ,
        "damping relaxation 1e-5 tangential linear 4e3 0.2 0.5",
    ),
    ("lsd", LSD, ""),
    ("lsd, linear", LSD, "tangential linear 4e3 0.2 0.5"),
    (
        "lsd, rolling",
        LSD,
        "tangential linear 4e3 0.2 0.5 rolling sds 1e3 0.1 0.05",
    ),
    (
        "nfd, rolling",
        NFD,
        "tangential tfd 0.5 rolling sds 1e3 0.1 0.05 twisting none",
    ),
    (
        "nfd, marshall",
        NFD,
        "tangential tfd 0.5 twisting marshall rolling none",
    ),
    (
        "nfd, lubkin",
        NFD,
        "tangential tfd 0.5 displacement hysteretic twisting lubkin",
    ),
    (
        "hertz, sds",
        HERTZ,
        "tangential mindlin 0.5 rolling sds 1e3 0.1 0.05 twisting sds 1e-2 1e-6 1e-4",
    ),
];

/// The laws under which grains meet walls.
const LAWS_AT_WALLS: [&str; 8] = [
    "nfd, tfd",
    "nfd, hale",
    "nfd, memory",
    "hertz, restitution, mindlin",
    "hertz, tfd",
    "lsd, linear",
    "hertz, sds",
    "nfd, lubkin",
];
const WALLS: [&str; 5] = ["plane", "cylinder", "sphere", "cone", "mesh"];

/// All scenes by name.
fn scenes() -> Vec<(String, Scene)> {
    let mut scenes = Vec::new();
    for (form, semi_axes) in FORMS {
        for law in LAWS {
            scenes.push((format!("{form}: {}", law.0), collision(semi_axes, &[law])));
        }
        scenes.push((
            format!("{form}: two materials"),
            collision(
                semi_axes,
                &[
                    LAWS[1],
                    ("softer", "nfd 4e6 0.4 80 10", "tangential tfd 0.3"),
                ],
            ),
        ));
        for wall in WALLS {
            for law in LAWS.iter().filter(|law| LAWS_AT_WALLS.contains(&law.0)) {
                let name = format!("{form} in a {wall}: {}", law.0);
                scenes.push((name, enclosed(semi_axes, *law, wall)));
            }
        }
    }
    scenes
}

/// A cube of grains turned at random, pulled together: all collide, and stay pressed.
fn collision(forms: &[[f64; 3]], laws: &[(&str, &str, &str)]) -> Scene {
    // Needles fill a smaller part of their bounding spheres.
    let least = forms[0].iter().fold(f64::INFINITY, |m, a| m.min(*a));
    let spacing = if least < 1e-3 { 6e-3 } else { 10.1e-3 };
    Scene {
        pull: PULL,
        ..cluster(forms, laws, spacing, -0.5)
    }
}

/// The same flies apart and is pressed against a wall around it, type 1 as the grains.
fn enclosed(forms: &[[f64; 3]], law: (&str, &str, &str), wall: &str) -> Scene {
    const SPACING: f64 = 10.1e-3;
    let mut scene = cluster(forms, &[law], SPACING, 0.6);
    let half = 0.5 * (SIDE - 1) as f64 * SPACING;
    let longest = 5.2e-3;
    scene.wall_type = 1;
    scene.pull = -PULL;
    let shape = |name, point, axis, radii| Shape {
        name,
        point,
        axis,
        radii,
        bounds: [-0.1, 0.1],
    };
    let origin = [0.0; 3];
    let x = [1.0, 0.0, 0.0];
    let across = half * 2f64.sqrt() + longest;
    scene.shapes = match wall {
        "plane" => vec![shape(
            "plane",
            [0.0, 0.0, -half - longest],
            [0.0, 0.0, 1.0],
            [0.0; 2],
        )],
        "cylinder" => vec![Shape {
            bounds: [f64::NEG_INFINITY, f64::INFINITY],
            ..shape("cylinder", origin, x, [across, 0.0])
        }],
        "sphere" => vec![shape(
            "sphere",
            origin,
            [0.0, 0.0, 1.0],
            [half * 3f64.sqrt() + longest, 0.0],
        )],
        // 0.2 m long, as wide as the cylinder in the middle of the cube's near side.
        "cone" => vec![shape("cone", origin, x, [0.75 * across, 1.35 * across])],
        _ => Vec::new(),
    };
    if wall == "mesh" {
        scene.triangles = cube(half + longest);
    }
    scene
}

/// Two triangles for each face.
fn cube(half: f64) -> Vec<[[f64; 3]; 3]> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-half, half] {
            let corner = |u: f64, v: f64| {
                let mut point = [0.0; 3];
                point[axis] = side;
                point[(axis + 1) % 3] = u;
                point[(axis + 2) % 3] = v;
                point
            };
            let [a, b] = [corner(-half, -half), corner(half, -half)];
            let [c, d] = [corner(half, half), corner(-half, half)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

/// Grains on a lattice about the origin, turned at random; `speed` (m/s) is that of the outermost away from the centre.
fn cluster(forms: &[[f64; 3]], laws: &[(&str, &str, &str)], spacing: f64, speed: f64) -> Scene {
    const COUNT: usize = SIDE * SIDE * SIDE;
    let mut random = Random::new(5);
    let mut between = |low: f64, high: f64| low + (high - low) * random.unit();
    let mut frame = Frame {
        positions: Vec::new(),
        velocities: Vec::new(),
        rotations: Vec::new(),
        quaternions: Vec::new(),
    };
    let mut grains = Vec::new();
    let half = 0.5 * (SIDE - 1) as f64;
    for k in 0..COUNT {
        let place = [k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE].map(|n| n as f64 - half);
        frame
            .positions
            .push(place.map(|x| spacing * (x + between(-0.005, 0.005))));
        frame
            .velocities
            .push(place.map(|x| speed * x / half + between(-0.1, 0.1)));
        frame.rotations.push([0; 3].map(|_| between(-20.0, 20.0)));
        let q = [0; 4].map(|_| between(-1.0, 1.0));
        let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        frame.quaternions.push(q.map(|x| x / length));
        let semi_axes = forms[k % forms.len()];
        let volume = 4.0 / 3.0 * std::f64::consts::PI * semi_axes.iter().product::<f64>();
        grains.push((1 + (k % laws.len()) as i32, semi_axes, DENSITY * volume));
    }
    Scene {
        laws: laws
            .iter()
            .map(|(_, normal, others)| format!("{normal} {others}"))
            .collect(),
        normals_are_kept: true,
        wall_type: 0,
        shapes: Vec::new(),
        triangles: Vec::new(),
        grains,
        frames: vec![frame],
        rows: (0..COUNT)
            .map(|i| (i as i32 + 1..COUNT as i32).collect())
            .collect(),
        time_step: TIME_STEP,
        pull: 0.0,
        tallied: true,
        cold: false,
        single: false,
    }
}

/// The numbers of each part at the end.
#[derive(Clone, Debug, PartialEq)]
struct End([Vec<f64>; 3]);

impl End {
    fn read(bytes: &[u8]) -> Result<Self> {
        let mut words = bytes.chunks_exact(8).map(|word| {
            let word: [u8; 8] = word.try_into().expect("eight bytes");
            u64::from_ne_bytes(word)
        });
        let mut part = || -> Result<Vec<f64>> {
            let count = words.next().context("the player ended early")? as usize;
            let values: Vec<f64> = words.by_ref().take(count).map(f64::from_bits).collect();
            if values.len() != count {
                bail!("the player ended early");
            }
            Ok(values)
        };
        Ok(End([part()?, part()?, part()?]))
    }

    /// Of one part, bit for bit.
    fn digest(&self, part: usize) -> String {
        let mut hash = Sha256::new();
        for value in &self.0[part] {
            hash.update(value.to_bits().to_le_bytes());
        }
        let digest = hash.finalize();
        digest[..6]
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect()
    }

    /// Contacts at the end, of pairs and of the wall.
    fn contacts(&self) -> f64 {
        self.0[1].iter().rev().take(2).sum()
    }

    /// How far each part is from another revision's: `None` where the bits are the same; infinite where it has another length or a
    /// number that is none.
    fn difference(&self, other: &End) -> [Option<f64>; 3] {
        std::array::from_fn(|part| difference(&self.0[part], &other.0[part]))
    }
}

/// Largest difference over the largest number.
fn difference(a: &[f64], b: &[f64]) -> Option<f64> {
    let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    if bits(a) == bits(b) {
        return None;
    }
    let finite = a.iter().chain(b).all(|x| x.is_finite());
    if a.len() != b.len() || !finite {
        return Some(f64::INFINITY);
    }
    let largest = a.iter().chain(b).fold(0.0, |m: f64, x| m.max(x.abs()));
    let apart = a
        .iter()
        .zip(b)
        .fold(0.0, |m: f64, (x, y)| m.max((x - y).abs()));
    // Of different bits and no difference are zeros of either sign.
    Some(if apart > 0.0 { apart / largest } else { 0.0 })
}

/// A revision's end of a scene on an instruction set.
fn end(player: &Path, scene: &Path, set: &str) -> Result<End> {
    let steps = STEPS.to_string();
    let words = [
        scene.as_os_str(),
        OsStr::new("trajectory"),
        OsStr::new(&steps),
    ];
    End::read(&play(player, set, &words)?)
}

pub fn trajectories(options: &Options) -> Result<()> {
    setup::setup()?;
    let wanted = |name: &str| {
        options.scene.is_empty() || options.scene.iter().any(|part| name.contains(part))
    };
    let scenes: Vec<(String, Scene)> = scenes()
        .into_iter()
        .filter(|(name, _)| wanted(name))
        .collect();
    if scenes.is_empty() {
        bail!("no scene has such a name: they are called as 'needles: nfd, tfd' and 'spheres in a cone: hertz, sds'");
    }
    let mut revisions = vec![Revision::here()?];
    if let Some(name) = &options.against {
        revisions.push(Revision::of(name)?);
    }
    let scratch = tempfile::tempdir()?;
    let players = revisions
        .iter()
        .enumerate()
        .map(|(k, revision)| {
            let directory = scratch.path().join(k.to_string());
            fs::create_dir_all(&directory)?;
            revision.player(&directory)
        })
        .collect::<Result<Vec<PathBuf>>>()?;
    let sets = Contender::instruction_sets();
    match &revisions[..] {
        [here, there] => println!(
            "{} and {}: '=' the same bits, else the largest difference over the largest number of {}",
            here.name,
            there.name,
            PARTS.join(", "),
        ),
        _ => println!("Digests of {}; contacts at the end", PARTS.join(", ")),
    }
    let mut summary = Summary::default();
    let file = scratch.path().join("scene");
    let mut progress = Progress::start("Trajectories");
    for (k, (name, scene)) in scenes.iter().enumerate() {
        progress.update(Some(k as f64 / scenes.len() as f64), name);
        fs::write(&file, scene.text())?;
        for set in &sets {
            let here = end(&players[0], &file, set).with_context(|| format!("{name}, {set}"))?;
            let said = match players.get(1).map(|player| end(player, &file, set)) {
                None => {
                    let digests: Vec<String> = (0..3).map(|part| here.digest(part)).collect();
                    format!("{} {:>5}", digests.join(" "), here.contacts())
                }
                Some(Ok(there)) => {
                    let found = here.difference(&there);
                    summary.add(name, set, found);
                    found.map(shown).join(" ")
                }
                Some(Err(why)) => {
                    summary.refused += 1;
                    format!("not played: {why:#}")
                }
            };
            println!("{name:<48} {set:<9} {said}");
        }
    }
    progress.finish();
    if revisions.len() > 1 {
        println!("{}", summary.text());
    }
    match options.tolerance {
        Some(tolerance) => summary.check(tolerance),
        None => Ok(()),
    }
}

fn shown(difference: Option<f64>) -> String {
    match difference {
        None => "=".into(),
        Some(value) if value.is_infinite() => "differ".into(),
        Some(value) => format!("{value:.1e}"),
    }
}

/// What all comparisons together say.
#[derive(Default)]
struct Summary {
    same: usize,
    different: usize,
    refused: usize,
    /// The largest difference of any part, and where.
    largest: Option<(f64, String)>,
}

impl Summary {
    fn add(&mut self, name: &str, set: &str, found: [Option<f64>; 3]) {
        let Some(largest) = found.into_iter().flatten().reduce(f64::max) else {
            self.same += 1;
            return;
        };
        self.different += 1;
        if self
            .largest
            .as_ref()
            .is_none_or(|(value, _)| largest > *value)
        {
            self.largest = Some((largest, format!("{name}, {set}")));
        }
    }

    fn text(&self) -> String {
        let mut text = format!(
            "{} the same bit for bit, {} different",
            self.same, self.different
        );
        if let Some((value, place)) = &self.largest {
            text += &format!(", at most by {} ({place})", shown(Some(*value)));
        }
        if self.refused > 0 {
            text += &format!(", {} not played by the other revision", self.refused);
        }
        text
    }

    fn check(&self, tolerance: f64) -> Result<()> {
        match &self.largest {
            Some((value, place)) if *value > tolerance || tolerance == 0.0 => bail!(
                "{place}: different by {}, where {tolerance:e} is allowed",
                shown(Some(*value))
            ),
            _ if self.refused > 0 => bail!("the other revision did not play all scenes"),
            _ => {
                say("within the tolerance");
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law_tables;
    use crate::workspace;

    /// A law, a choice or a shape that comes has to come here too.
    #[test]
    fn every_word_of_the_tables_of_laws_is_in_a_scene() {
        let words = law_tables::words(&workspace::root()).unwrap();
        assert!(words.len() > 20, "{words:?}");
        let decks: Vec<String> = LAWS
            .iter()
            .map(|(_, normal, others)| format!(" {normal} {others} "))
            .collect();
        for word in words {
            assert!(
                decks.iter().any(|deck| deck.contains(&format!(" {word} "))),
                "no scene has the word {word}"
            );
        }
        for name in LAWS_AT_WALLS {
            assert!(LAWS.iter().any(|law| law.0 == name), "{name}");
        }
    }

    #[test]
    fn a_difference_is_that_of_bits_first_and_relative_to_the_largest_number() {
        assert_eq!(difference(&[1.0, -2.0], &[1.0, -2.0]), None);
        assert_eq!(difference(&[0.0], &[-0.0]), Some(0.0));
        assert_eq!(difference(&[1.0, -2.0], &[1.5, -2.0]), Some(0.25));
        assert_eq!(difference(&[1.0], &[1.0, 0.0]), Some(f64::INFINITY));
        assert_eq!(difference(&[1.0], &[f64::NAN]), Some(f64::INFINITY));
        let mut summary = Summary::default();
        summary.add("a", "avx2", [None, None, None]);
        assert!(summary.check(0.0).is_ok());
        summary.add("b", "avx2", [None, Some(1e-14), Some(1e-9)]);
        assert!(summary.check(1e-8).is_ok());
        assert!(summary.check(1e-10).is_err() && summary.check(0.0).is_err());
        assert!(summary
            .text()
            .contains("1 the same bit for bit, 1 different, at most by 1.0e-9 (b, avx2)"));
    }

    /// On every instruction set: the same build ends at the same bits; a constant of the law that differs in its ninth digit is noticed
    /// in motion, forces and histories, of pairs and at a wall; and in all grains touch.
    #[test]
    fn the_same_build_is_the_same_and_a_changed_constant_is_noticed() {
        let directory = tempfile::tempdir().unwrap();
        let player = crate::revisions::test_player(directory.path());
        let file = directory.path().join("scene");
        let mixture = FORMS[4].1;
        let law = LAWS[1];
        for scene in [collision(mixture, &[law]), enclosed(mixture, law, "sphere")] {
            let mut changed = scene.clone();
            changed.laws[0] = changed.laws[0].replace(" 0.3 ", " 0.300000001 ");
            assert_ne!(changed.laws, scene.laws);
            for set in Contender::instruction_sets() {
                let of = |scene: &Scene| {
                    fs::write(&file, scene.text()).unwrap();
                    end(&player, &file, set).unwrap()
                };
                let first = of(&scene);
                assert!(first.contacts() > 5.0, "{set}: {}", first.contacts());
                let again = of(&scene);
                assert_eq!(first.difference(&again), [None; 3], "{set}");
                assert_eq!(first.digest(1), again.digest(1));
                let other = of(&changed);
                for (part, found) in PARTS.iter().zip(first.difference(&other)) {
                    assert!(found.is_some_and(|d| d > 1e-13), "{set}, {part}: {found:?}");
                }
                assert_ne!(first.digest(1), other.digest(1));
            }
        }
    }
}
