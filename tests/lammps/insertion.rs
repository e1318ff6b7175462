// SPDX-License-Identifier: MIT OR Apache-2.0
//! Do `fix pour/ellipsoid` and `create_ellipsoids` insert the grains that were asked for, where nothing is in their way?

use std::path::Path;

use crate::harness::{execute, fresh_directory, last_lines, thermo_rows, Engine};
use crate::shapes::{
    add, dot, length, perram_wertheim, rotate, sub, unrotate, Quaternion, Random, Vector,
};

const LAW: &str = "nfd 3e6 0.3 200 200 tangential tfd 0.4";

#[derive(Clone, Debug)]
struct Inserted {
    kind: usize,
    position: Vector,
    velocity: Vector,
    mass: f64,
    quaternion: Quaternion,
    semi_axes: Vector,
}

impl Inserted {
    fn volume(&self) -> f64 {
        let [a, b, c] = self.semi_axes;
        4.0 / 3.0 * std::f64::consts::PI * a * b * c
    }

    fn largest(&self) -> f64 {
        self.semi_axes.into_iter().fold(0.0, f64::max)
    }

    fn smallest(&self) -> f64 {
        self.semi_axes.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// How far it reaches from its centre along a unit vector.
    fn reach(&self, n: Vector) -> f64 {
        let along = unrotate(self.quaternion, n);
        length(std::array::from_fn(|k| self.semi_axes[k] * along[k]))
    }

    fn pose(&self) -> (Vector, Quaternion, Vector) {
        (self.semi_axes, self.quaternion, self.position)
    }
}

/// Text and grains of the last frame in a dump of [`dump`].
fn last_frame(path: &Path) -> (String, Vec<Inserted>) {
    let all = std::fs::read_to_string(path).unwrap();
    let text = all.rsplit("ITEM: TIMESTEP").next().unwrap().to_string();
    let grains = text
        .lines()
        .skip_while(|line| !line.starts_with("ITEM: ATOMS"))
        .skip(1)
        .map(|line| {
            let v: Vec<f64> = line
                .split_whitespace()
                .map(|w| w.parse().unwrap())
                .collect();
            Inserted {
                kind: v[1] as usize,
                position: [v[2], v[3], v[4]],
                velocity: [v[5], v[6], v[7]],
                mass: v[8],
                quaternion: [v[9], v[10], v[11], v[12]],
                semi_axes: [0.5 * v[13], 0.5 * v[14], 0.5 * v[15]],
            }
        })
        .collect();
    (text, grains)
}

/// The commands that write all grains every so many steps.
fn dump(every: u64) -> String {
    format!(
        "compute q all property/atom quatw quati quatj quatk
compute s all property/atom shapex shapey shapez
dump g all custom {every} grains id type xu yu zu vx vy vz mass c_q[*] c_s[*]
dump_modify g sort id format float %.17g first yes
"
    )
}

/// Everything before the grains: a box of `sides`, from the origin.
fn head(engine: &Engine, atom_style: &str, boundary: &str, sides: [f64; 3]) -> String {
    let [x, y, z] = sides;
    format!(
        "plugin load {}
units si
atom_style {atom_style}
boundary {boundary}
comm_modify vel yes
neighbor 0.001 bin
region box block 0 {x} 0 {y} 0 {z}
create_box 2 box
pair_style gran/ellipsoid
pair_coeff * * {LAW}
fix integrate all nve/asphere
timestep 4e-5
",
        engine.plugin.display()
    )
}

fn run(engine: &Engine, name: &str, deck: &str, ranks: usize) -> (String, String, Vec<Inserted>) {
    let directory = fresh_directory(name);
    let (success, output) = execute(engine, &directory, deck, ranks);
    assert!(success, "{name}:\n{}", last_lines(&output));
    let (text, grains) = last_frame(&directory.join("grains"));
    (output, text, grains)
}

/// Pairs that overlap by Perram and Wertheim's criterion, and pairs whose enclosing balls do; `periods` of the box, 0 for none.
fn overlaps(grains: &[Inserted], periods: [f64; 3]) -> (usize, usize) {
    let (mut overlapping, mut near) = (0, 0);
    for (k, i) in grains.iter().enumerate() {
        for j in &grains[..k] {
            let mut d = sub(j.position, i.position);
            for a in 0..3 {
                if periods[a] > 0.0 {
                    d[a] -= periods[a] * (d[a] / periods[a]).round();
                }
            }
            if length(d) > i.largest() + j.largest() {
                continue;
            }
            near += 1;
            let there = (j.semi_axes, j.quaternion, add(i.position, d));
            overlapping += usize::from(perram_wertheim(i.pose(), there) < 1.0);
        }
    }
    (overlapping, near)
}

const NEEDLES_AND_DISCS: &str =
    "shape poly 2 0.012 0.003 0.003 0.5 0.008 0.008 0.002 0.5 scale range 0.7 1.0 dens 2000 3000";

#[test]
fn both_versions_no_inserted_grain_overlaps_another_or_the_region() {
    let engine = Engine::from_environment();
    let sides = [0.05, 0.05, 0.05];
    let fill = |region: &str, seed: u32, fraction: f64| {
        format!("create_ellipsoids 1 {seed} region {region} fill {fraction} {NEEDLES_AND_DISCS}\n")
    };
    let deck = head(&engine, "ellipsoid", "p p f", sides)
        + "region cut block 0 0.05 0 0.05 0.004 0.046\n"
        // the second finds those of the first in its way
        + &fill("cut", 1, 0.1)
        + &fill("cut", 2, 0.15)
        + "compute c all pair gran/ellipsoid\nthermo_style custom step atoms c_c[4]\n"
        + &dump(1)
        + "run 0\n";
    let (output, _, grains) = run(&engine, "insertion_overlap", &deck, 2);
    let row = thermo_rows(&output).pop().unwrap();
    assert_eq!(
        row["c_c[4]"], 0.0,
        "our own search finds contacts among inserted grains"
    );
    let periods = [0.05, 0.05, 0.0];
    let (overlapping, near) = overlaps(&grains, periods);
    println!(
        "{} grains: {near} pairs within enclosing balls, {overlapping} overlap",
        grains.len()
    );
    assert_eq!(overlapping, 0);
    assert!(
        near > grains.len() / 2,
        "enclosing balls would have kept grains as far apart"
    );

    let volume: f64 = grains.iter().map(Inserted::volume).sum();
    let fraction = volume / (0.05 * 0.05 * 0.042);
    assert!((fraction - 0.25).abs() < 2e-3, "solid fraction {fraction}");
    for g in &grains {
        let reach = g.reach([0.0, 0.0, 1.0]);
        assert!(
            g.position[2] - reach >= 0.004 - 1e-12 && g.position[2] + reach <= 0.046 + 1e-12,
            "a grain sticks out of the region: {g:?}"
        );
        let density = g.mass / g.volume();
        assert!((2000.0 - 1e-6..=3000.0 + 1e-6).contains(&density));
    }

    // The judge is not blind: grains that keep only the balls inside them apart overlap, and it sees that.
    let mut random = Random(9);
    let mut turned = grains.clone();
    for g in &mut turned {
        g.quaternion = random.quaternion();
    }
    let inner = |i: &Inserted, j: &Inserted| {
        length(sub(i.position, j.position)) > i.smallest() + j.smallest()
    };
    assert!(turned
        .iter()
        .enumerate()
        .all(|(k, i)| turned[..k].iter().all(|j| inner(i, j))));
    let (wrong, _) = overlaps(&turned, periods);
    println!("turned at random where they are: {wrong} pairs overlap");
    assert!(wrong > 10);
}

/// Round regions hold grains whole: each point of each grain is inside.
#[test]
fn both_versions_grains_are_inside_of_round_regions() {
    let engine = Engine::from_environment();
    let cases: [(&str, &str, f64); 4] = [
        (
            "cylinder",
            "cylinder z 0.025 0.025 0.02 0.01 0.04",
            std::f64::consts::PI * 4e-4 * 0.03,
        ),
        (
            "sphere",
            "sphere 0.025 0.025 0.025 0.02",
            4.0 / 3.0 * std::f64::consts::PI * 8e-6,
        ),
        (
            "cone",
            "cone z 0.025 0.025 0.008 0.022 0.005 0.045",
            std::f64::consts::PI / 3.0
                * 0.04
                * (0.008f64.powi(2) + 0.008 * 0.022 + 0.022f64.powi(2)),
        ),
        ("outside", "sphere 0.025 0.025 0.025 0.02 side out", 0.0),
    ];
    for (name, words, volume) in cases {
        let deck = head(&engine, "ellipsoid", "f f f", [0.05; 3])
            + &format!("region r {words}\ncreate_ellipsoids 2 5 region r fill 0.12 shape one 0.008 0.004 0.003\n")
            + &dump(1)
            + "run 0\n";
        let (_, _, grains) = run(&engine, &format!("insertion_{name}"), &deck, 1);
        let centre = [0.025; 3];
        let mut random = Random(4);
        let mut closest = f64::INFINITY;
        for g in &grains {
            assert_eq!(g.kind, 2);
            for _ in 0..400 {
                let n = random.direction();
                let on: Vector = std::array::from_fn(|k| g.semi_axes[k] * n[k]);
                let p = add(g.position, rotate(g.quaternion, on));
                let from_centre = sub(p, centre);
                let aside = from_centre[0].hypot(from_centre[1]);
                // how far inside, in each way that the region has
                let inside = match name {
                    "cylinder" => (0.02 - aside).min(p[2] - 0.01).min(0.04 - p[2]),
                    "sphere" => 0.02 - length(from_centre),
                    "outside" => (length(from_centre) - 0.02)
                        .min(p.into_iter().fold(f64::INFINITY, f64::min))
                        .min(0.05 - p.into_iter().fold(0.0, f64::max)),
                    _ => (0.008 + 0.014 * (p[2] - 0.005) / 0.04 - aside)
                        .min(p[2] - 0.005)
                        .min(0.045 - p[2]),
                };
                closest = closest.min(inside);
            }
        }
        println!(
            "{name}: {} grains, the outermost point {closest:.1e} m inside",
            grains.len()
        );
        assert!(closest > -1e-12 && closest < 2e-3);
        let filled: f64 = grains.iter().map(Inserted::volume).sum();
        let of_region = if volume > 0.0 {
            volume
        } else {
            0.05f64.powi(3) - 4.0 / 3.0 * std::f64::consts::PI * 8e-6
        };
        // the volume of the region without a formula is counted
        assert!(
            (filled / of_region - 0.12).abs() < 2e-3,
            "{name}: {}",
            filled / of_region
        );
        assert_eq!(overlaps(&grains, [0.0; 3]).0, 0);
    }
}

/// Bodies that stand in the region, with edges and tips, smaller than the grains or larger: no point of a grain is in one, however near its centre
/// is. A grain that was tried in its full size alone was put across an edge that it had swallowed: up to 51 of 506 were.
#[test]
fn both_versions_grains_keep_clear_of_bodies_with_edges() {
    let engine = Engine::from_environment();
    type IsIn = fn(Vector) -> bool;
    let cases: [(&str, IsIn); 4] = [
        ("block 0.022 0.028 0.022 0.028 0.022 0.028", |p| {
            p.into_iter().all(|c| (0.022..0.028).contains(&c))
        }),
        ("block 0.02 0.03 0.02 0.03 0.025 0.0252", |p| {
            p[..2].iter().all(|c| (0.02..0.03).contains(c)) && (0.025..0.0252).contains(&p[2])
        }),
        ("cylinder z 0.025 0.025 0.004 0.025 0.026", |p| {
            (p[0] - 0.025).hypot(p[1] - 0.025) < 0.004 && (0.025..0.026).contains(&p[2])
        }),
        ("cone z 0.025 0.025 0.001 0.006 0.024 0.026", |p| {
            (0.024..0.026).contains(&p[2])
                && (p[0] - 0.025).hypot(p[1] - 0.025) < 0.001 + 2.5 * (p[2] - 0.024)
        }),
    ];
    for (k, (words, is_in)) in cases.into_iter().enumerate() {
        let mut count = 0;
        for seed in 1..=3 {
            let deck = head(&engine, "ellipsoid", "f f f", [0.05; 3])
                + &format!(
                    "region body {words} side out
region near block 0.017 0.033 0.017 0.033 0.017 0.033
region r intersect 2 body near
create_ellipsoids 1 {seed} region r number 60 shape one 0.006 0.003 0.003 attempts 1000 partial yes
"
                )
                + &dump(1)
                + "run 0\n";
            let (_, _, grains) = run(&engine, &format!("insertion_body_{k}"), &deck, 1);
            count += grains.len();
            let mut random = Random(4);
            for g in &grains {
                for _ in 0..2000 {
                    let part = random.uniform().cbrt();
                    let n = random.direction();
                    let within: Vector = std::array::from_fn(|a| part * g.semi_axes[a] * n[a]);
                    let p = add(g.position, rotate(g.quaternion, within));
                    assert!(!is_in(p), "{words}: {p:?} is in grain and body: {g:?}");
                }
            }
        }
        println!("{words}: none of {count} grains meets it");
        assert!(count > 50);
    }
}

/// What a grain sticks out of a periodic boundary is in the region too, where it comes in.
#[test]
fn both_versions_grains_across_a_periodic_boundary_stay_in_the_region() {
    let engine = Engine::from_environment();
    let deck = head(&engine, "ellipsoid", "p p f", [0.05; 3])
        + "region r sphere 0 0 0.025 0.015 side out
create_ellipsoids 1 5 region r fill 0.2 shape one 0.008 0.004 0.003
" + &dump(1)
        + "run 0\n";
    let (_, _, grains) = run(&engine, "insertion_across", &deck, 2);
    let mut random = Random(4);
    let (mut across, mut closest) = (0, f64::INFINITY);
    for g in &grains {
        let reach = [0, 1].map(|k| g.reach(std::array::from_fn(|a| f64::from(u8::from(a == k)))));
        across += usize::from(
            (0..2).any(|k| g.position[k] < reach[k] || g.position[k] + reach[k] > 0.05),
        );
        for _ in 0..400 {
            let n = random.direction();
            let on: Vector = std::array::from_fn(|k| g.semi_axes[k] * n[k]);
            let p = add(g.position, rotate(g.quaternion, on));
            let there = [p[0].rem_euclid(0.05), p[1].rem_euclid(0.05), p[2] - 0.025];
            closest = closest.min(length(there) - 0.015);
        }
    }
    println!(
        "{} grains, {across} of them across a boundary, the outermost point {closest:.1e} m inside",
        grains.len()
    );
    assert!(across > 40 && closest > -1e-12);
}

/// A region without a formula is as large as it is, wherever its faces lie.
#[test]
fn both_versions_regions_without_a_formula_have_their_volume() {
    let engine = Engine::from_environment();
    let cases = [
        (
            "region a block 0.01 0.02 0.01 0.04 0.01 0.04
region b block 0.03 0.0345 0.01 0.04 0.01 0.04
region r union 2 a b",
            0.0145 * 0.03 * 0.03,
        ),
        (
            "region r plane 0.025 0.025 0.0323 0 0 1",
            0.0177 * 0.05 * 0.05,
        ),
        (
            "region r sphere 0.025 0.025 0.025 0.02 side out",
            0.05f64.powi(3) - 4.0 / 3.0 * std::f64::consts::PI * 8e-6,
        ),
    ];
    for (k, (region, volume)) in cases.into_iter().enumerate() {
        let deck = head(&engine, "ellipsoid", "f f f", [0.05; 3])
            + region
            + "\ncreate_ellipsoids 1 5 region r number 3 shape one 0.001 0.001 0.001 inside centre\n"
            + &dump(1)
            + "run 0\n";
        let (output, _, _) = run(&engine, &format!("insertion_volume_{k}"), &deck, 1);
        let found: f64 = output
            .lines()
            .find_map(|l| l.split_once("of region r, volume "))
            .map(|(_, number)| number.trim().parse().unwrap())
            .expect("no volume");
        println!("{region}: volume off by {:.1e}", found / volume - 1.0);
        assert!((found / volume - 1.0).abs() < 2e-4);
    }
}

fn stream(words: &str) -> String {
    format!(
        "region top block 0 0.05 0 0.05 0.2 0.24
fix gravity all gravity 9.81 vector 0 0 -1
fix pour all pour/ellipsoid {words}
thermo_style custom step atoms f_pour f_pour[1] f_pour[2] f_pour[3]
thermo_modify format float %.17g
thermo 100
"
    )
}

#[test]
fn both_versions_the_number_of_ranks_changes_no_bit() {
    let engine = Engine::from_environment();
    let deck = head(&engine, "ellipsoid", "p p f", [0.05, 0.05, 0.3])
        + "region low block 0 0.05 0 0.05 0.25 0.3\n"
        + &format!("create_ellipsoids 2 8 region low fill 0.2 {NEEDLES_AND_DISCS}\n")
        + &stream(&format!(
            "300 1 4711 region top {NEEDLES_AND_DISCS} vol 0.05 50 vel 0 0 0 0 -2"
        ))
        + &dump(1000)
        + "run 1000\n";
    let (_, one, grains) = run(&engine, "insertion_ranks_1", &deck, 1);
    println!("{} grains", grains.len());
    assert!(grains.len() > 150);
    for ranks in [2, 4] {
        let (_, other, _) = run(&engine, &format!("insertion_ranks_{ranks}"), &deck, ranks);
        assert!(one == other, "{ranks} ranks insert other grains than one");
    }
}

/// New grains far above a heap: the box that shrinks around all of them gives the heap to other ranks, not only to neighbouring ones.
#[test]
fn both_versions_no_grain_is_lost_in_a_box_that_shrinks() {
    let engine = Engine::from_environment();
    let words = "shape one 0.006 0.004 0.004 dens 2000 2000";
    for created in ["middle", "low"] {
        let deck = head(&engine, "ellipsoid", "p p s", [0.04, 0.04, 0.2])
            .replace("create_box", "processors 1 1 *\ncreate_box")
            + &format!(
                "region low block 0 0.04 0 0.04 0 0.02
region middle block 0 0.04 0 0.04 0.1 0.15
region top block 0 0.04 0 0.04 0.16 0.19
create_ellipsoids 1 3 region {created} number 30 {words}
thermo_modify lost ignore
run 5
fix gravity all gravity 9.81 vector 0 0 -1
fix floor all wall/gran/ellipsoid {LAW} zplane 0 NULL
fix pour all pour/ellipsoid 60 1 5 region top {words} vol 0.05 50 vel 0 0 0 0 -2
thermo_style custom step atoms f_pour
thermo_modify lost ignore
"
            )
            + &dump(400)
            + "run 400\n";
        for ranks in [1, 4] {
            let name = format!("insertion_shrinking_{ranks}");
            let (output, _, grains) = run(&engine, &name, &deck, ranks);
            let poured = thermo_rows(&output).pop().unwrap()["f_pour"];
            println!(
                "created {created}, {ranks} ranks: 30 and {poured} inserted, {} left",
                grains.len()
            );
            assert!(poured >= 20.0);
            assert_eq!(grains.len() as f64, 30.0 + poured);
        }
    }
}

#[test]
fn both_versions_a_restart_goes_on_with_the_insertion() {
    let engine = Engine::from_environment();
    let pour =
        format!("400 1 4711 region top {NEEDLES_AND_DISCS} vol 0.04 50 vel 0 0 0 0 -2 rate 0.1");
    let deck = head(&engine, "ellipsoid", "p p f", [0.05, 0.05, 0.3])
        + &stream(&pour)
        + &dump(1500)
        + "run 700\nwrite_restart middle.restart\nrun 800\n";
    let directory = fresh_directory("insertion_restart");
    let (success, output) = execute(&engine, &directory, &deck, 1);
    assert!(success, "{}", last_lines(&output));
    let (whole, grains) = last_frame(&directory.join("grains"));
    let last = thermo_rows(&output).pop().unwrap();
    let half = thermo_rows(&output)
        .into_iter()
        .find(|r| r["Step"] == 700.0)
        .unwrap();
    println!(
        "{} grains at the restart, {} at the end",
        half["f_pour"], last["f_pour"]
    );
    assert!(half["f_pour"] > 20.0 && last["f_pour"] > half["f_pour"] + 20.0);
    assert_eq!(last["f_pour"], grains.len() as f64);

    let again = format!(
        "plugin load {}\nread_restart middle.restart\ncomm_modify vel yes\nneighbor 0.001 bin\n\
fix integrate all nve/asphere\ntimestep 4e-5\n",
        engine.plugin.display()
    ) + &stream(&pour)
        + &dump(1500)
        + "run 800\n";
    for ranks in [1, 2] {
        let (success, output) = execute(&engine, &directory, &again, ranks);
        assert!(success, "{}", last_lines(&output));
        let (text, _) = last_frame(&directory.join("grains"));
        assert!(text == whole, "a restart on {ranks} ranks ends otherwise");
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
    sum / count
}

/// Means of samples are within four standard errors of those of the distributions.
#[test]
fn both_versions_shapes_sizes_and_orientations_are_distributed_as_asked() {
    let engine = Engine::from_environment();
    let made = |name: &str, words: &str| {
        let deck = head(&engine, "ellipsoid", "f f f", [1.0; 3])
            + &format!("create_ellipsoids 1 17 region box number 3000 {words}\n")
            + &dump(1)
            + "run 0\n";
        run(&engine, &format!("insertion_{name}"), &deck, 1).2
    };
    let near = |what: &str, value: f64, expected: f64, error: f64| {
        println!("{what}: {value:.4}, expected {expected:.4} +- {error:.1e}");
        assert!((value - expected).abs() < 4.0 * error, "{what}");
    };
    let n = 3000f64;

    let grains = made(
        "poly",
        "shape poly 2 0.02 0.01 0.01 0.3 0.01 0.01 0.005 0.7 scale range 0.5 1.5 dens 1000 3000",
    );
    assert_eq!(grains.len(), 3000);
    let is_long = |g: &Inserted| g.semi_axes[1] == g.semi_axes[2];
    let long = mean(grains.iter().map(|g| f64::from(u8::from(is_long(g)))));
    near("fraction of the first shape", long, 0.3, (0.21 / n).sqrt());
    let size = |g: &Inserted| {
        if is_long(g) {
            g.semi_axes[0] / 0.01
        } else {
            g.semi_axes[0] / 0.005
        }
    };
    near(
        "mean scale",
        mean(grains.iter().map(size)),
        1.0,
        (1.0 / 12.0 / n).sqrt(),
    );
    let spread = mean(grains.iter().map(|g| (size(g) - 1.0).powi(2)));
    near(
        "variance of scale",
        spread,
        1.0 / 12.0,
        (1.0 / 180.0 / n).sqrt(),
    );
    near(
        "mean density",
        mean(grains.iter().map(|g| g.mass / g.volume())),
        2000.0,
        (2000f64.powi(2) / 12.0 / n).sqrt(),
    );
    let axis = |g: &Inserted, k: usize| {
        let mut e = [0.0; 3];
        e[k] = 1.0;
        rotate(g.quaternion, e)
    };
    for k in 0..3 {
        for c in 0..3 {
            near(
                "mean component of an axis",
                mean(grains.iter().map(|g| axis(g, k)[c])),
                0.0,
                (1.0 / 3.0 / n).sqrt(),
            );
            near(
                "mean of its square",
                mean(grains.iter().map(|g| axis(g, k)[c].powi(2))),
                1.0 / 3.0,
                (4.0 / 45.0 / n).sqrt(),
            );
        }
    }

    let grains = made(
        "aligned",
        "shape range 0.01 0.02 0.005 0.005 0.003 0.009 orient align 1 -2 2",
    );
    for g in &grains {
        assert!(length(sub(axis(g, 0), [1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0])) < 1e-12);
        assert!((0.005..=0.01).contains(&g.semi_axes[0]) && g.semi_axes[1] == 0.0025);
    }
    near(
        "mean first axis",
        mean(grains.iter().map(|g| g.semi_axes[0])),
        0.0075,
        (0.005f64.powi(2) / 12.0 / n).sqrt(),
    );
    near(
        "mean third axis",
        mean(grains.iter().map(|g| g.semi_axes[2])),
        0.003,
        (0.003f64.powi(2) / 12.0 / n).sqrt(),
    );
    // at random about the direction
    let across = [0.0, 0.5f64.sqrt(), 0.5f64.sqrt()];
    near(
        "mean square across",
        mean(grains.iter().map(|g| dot(axis(g, 1), across).powi(2))),
        0.5,
        (0.125 / n).sqrt(),
    );

    let grains = made("backwards", "shape one 0.02 0.01 0.01 orient align -3 0 0");
    assert!(grains
        .iter()
        .all(|g| length(sub(axis(g, 0), [-1.0, 0.0, 0.0])) < 1e-12));

    // A direction has any length.
    let grains = made("far", "shape one 0.02 0.01 0.01 orient align 0 1e300 0");
    assert!(grains
        .iter()
        .all(|g| length(sub(axis(g, 0), [0.0, 1.0, 0.0])) < 1e-12));

    let grains = made("given", "shape one 0.02 0.01 0.005 orient quat 2 2 0 0");
    let half = 0.5f64.sqrt();
    assert!(grains.iter().all(|g| g
        .quaternion
        .iter()
        .zip([half, half, 0.0, 0.0])
        .all(|(a, b)| (a - b).abs() < 1e-15)));

    let grains = made(
        "by_volume",
        "shape one 0.01 0.005 0.005 scale poly 2 1 0.5 2 0.5 fractions volume",
    );
    let large: f64 = grains
        .iter()
        .filter(|g| g.semi_axes[0] > 0.007)
        .map(Inserted::volume)
        .sum();
    let all: f64 = grains.iter().map(Inserted::volume).sum();
    // of n grains a ninth is large, each with eight times the volume
    near(
        "fraction by volume",
        large / all,
        0.5,
        (8.0 / 81.0 * n).sqrt() * 8.0 / (n * 16.0 / 9.0) * 0.5,
    );
}

#[test]
fn both_versions_a_stream_has_the_number_volume_and_flow_asked_for() {
    let engine = Engine::from_environment();
    let shape = "shape one 0.006 0.004 0.004 dens 2500 2500";
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 3e-3 * 2e-3 * 2e-3;
    // By volume: as LAMMPS' fix pour, as many as the fraction of the region holds, each time that a grain falls through it.
    let deck = head(&engine, "ellipsoid", "p p f", [0.05, 0.05, 0.3])
        + &stream(&format!(
            "150 1 3 region top {shape} vol 0.05 50 vel 0 0 0 0 -1"
        ))
        + &dump(1250)
        + "run 1250\n";
    let (output, _, grains) = run(&engine, "insertion_by_volume", &deck, 1);
    let each = (0.05 * 0.05 * 0.05 * 0.04 / volume).floor();
    let (g, height) = (9.81, 0.04);
    let fall = ((1.0f64 + 2.0 * g * height).sqrt() - 1.0) / g;
    let interval = (fall / 4e-5).round();
    for row in thermo_rows(&output) {
        let times = if row["Step"] < 1.0 {
            0.0
        } else {
            ((row["Step"] - 1.0) / interval).floor() + 1.0
        };
        let expected = (each * times).min(150.0);
        assert_eq!(row["f_pour"], expected, "at step {}", row["Step"]);
        assert_eq!(row["Atoms"], expected);
        assert!((row["f_pour[2]"] - expected * volume).abs() < 1e-12 * (1.0 + expected) * volume);
        assert!(
            (row["f_pour[3]"] - 2500.0 * expected * volume).abs()
                < 1e-8 * (1.0 + expected) * volume
        );
    }
    println!(
        "{each} grains every {interval} steps, {} in all",
        grains.len()
    );
    assert_eq!(grains.len(), 150);

    // All grains started at the top with the speed given: v^2 = v0^2 + 2 g (top - z), now as in free fall before.
    // A step so short that nothing moves shows them as they were inserted.
    let one = head(&engine, "ellipsoid", "p p f", [0.05, 0.05, 0.3])
        .replace("timestep 4e-5", "timestep 1e-12")
        + &stream(&format!(
            "150 1 3 region top {shape} vol 0.05 50 vel -0.2 0.1 0 0 -1"
        ))
        + &dump(1)
        + "run 1\n";
    let (_, _, grains) = run(&engine, "insertion_speed", &one, 1);
    assert_eq!(overlaps(&grains, [0.05, 0.05, 0.0]).0, 0);
    assert!(grains
        .iter()
        .all(|p| (-0.2..=0.1).contains(&p.velocity[0]) && p.velocity[1] == 0.0));
    for p in &grains {
        let expected = (1.0 + 2.0 * g * (0.24 - p.position[2])).sqrt();
        assert!((-p.velocity[2] / expected - 1.0).abs() < 1e-6, "{p:?}");
    }
    // uniform in time: the mean time of fall is half of the whole
    let time = mean(grains.iter().map(|p| (-p.velocity[2] - 1.0) / g));
    println!("mean time of fall {time:.4} s of {fall:.4} s");
    assert!((time / fall - 0.5).abs() < 4.0 / (12.0 * grains.len() as f64).sqrt() + 0.05);

    // By flow: mass per time, to one grain.
    let deck = head(&engine, "ellipsoid", "p p f", [0.05, 0.05, 0.3])
        + &stream(&format!(
            "100000 1 3 region top {shape} scale range 0.8 1.2 flow 0.2 vel 0 0 0 0 -1"
        ))
        + "run 2500\n"
        + &dump(1)
        + "run 0\n";
    let (output, _, _) = run(&engine, "insertion_flow", &deck, 1);
    let row = thermo_rows(&output)
        .into_iter()
        .find(|r| r["Step"] == 2500.0)
        .unwrap();
    let events = ((2500.0 - 1.0) / interval).floor() + 1.0;
    let asked = 0.2 * events * interval * 4e-5;
    println!("flow: {:.6} kg of {asked:.6} kg", row["f_pour[3]"]);
    assert!((row["f_pour[3]"] - asked).abs() < 2500.0 * volume);
}

/// Grains fall as long whatever the time step is: a stream whose step changes, in a run or between two, has as many grains at each time. With the
/// number of steps of the first one it had 181 in place of 724 at ten times the step.
#[test]
fn both_versions_a_stream_keeps_its_pace_when_the_time_step_changes() {
    let engine = Engine::from_environment();
    let end = 0.12;
    let counts = |name: &str, first: &str, runs: &str| {
        let deck = head(&engine, "ellipsoid", "p p f", [0.05, 0.05, 0.3]).replace("timestep 4e-5", first)
            + &stream("100000 1 3 region top shape one 0.006 0.004 0.004 dens 2500 2500 vol 0.02 50 vel 0 0 0 0 -1")
            + "thermo_style custom step time f_pour
thermo_modify lost ignore
thermo 5
"
            + runs;
        let directory = fresh_directory(&format!("insertion_pace_{name}"));
        let (success, output) = execute(&engine, &directory, &deck, 1);
        assert!(success, "{name}:\n{}", last_lines(&output));
        let rows = thermo_rows(&output);
        let grew: Vec<f64> = rows
            .windows(2)
            .filter(|two| two[1]["f_pour"] > two[0]["f_pour"])
            .map(|two| two[1]["Time"])
            .collect();
        let last = rows.last().unwrap();
        println!(
            "{name}: {} grains after {:.4} s, new ones at {grew:.4?}",
            last["f_pour"], last["Time"]
        );
        assert!((last["Time"] - end).abs() < 1e-3, "{name}");
        (last["f_pour"], grew)
    };
    let (number, times) = counts("steady", "timestep 4e-5", "run 3000\n");
    assert!(times.len() > 3);
    let longer = "fix longer all dt/reset 10 3.9999e-5 4e-5 1\nrun 3000\n";
    let shorter = "fix shorter all dt/reset 10 0.9999e-5 1e-5 1\nrun 12000\n";
    let between = "run 1000\ntimestep 1e-5\nrun 8000\n";
    for (name, first, runs) in [
        ("longer", "timestep 4e-6", longer),
        ("shorter", "timestep 4e-5", shorter),
        ("between", "timestep 4e-5", between),
    ] {
        let (other, at) = counts(name, first, runs);
        assert_eq!(other, number, "{name}");
        assert_eq!(at.len(), times.len(), "{name}");
        let same = at.iter().zip(&times).all(|(a, b)| (a - b).abs() < 5e-4);
        assert!(same, "{name}: {at:?}, {times:?}");
    }
}

/// A heap of poured grains, at rest: what the walls bear is what was poured.
#[test]
fn both_versions_the_walls_bear_the_weight_of_a_poured_heap() {
    let engine = Engine::from_environment();
    let deck = head(&engine, "ellipsoid", "f f f", [0.03, 0.03, 0.12]).replace(LAW, "nfd 1e6 0.3 1500 1500 tangential tfd 0.4")
        + "region top block 0 0.03 0 0.03 0.05 0.12
fix gravity all gravity 9.81 vector 0 0 -1
fix x all wall/gran/ellipsoid nfd 1e6 0.3 1500 1500 tangential tfd 0.4 xplane 0 0.03
fix y all wall/gran/ellipsoid nfd 1e6 0.3 1500 1500 tangential tfd 0.4 yplane 0 0.03
fix z all wall/gran/ellipsoid nfd 1e6 0.3 1500 1500 tangential tfd 0.4 zplane 0 0.12
fix pour all pour/ellipsoid 40 1 4711 region top shape one 0.008 0.006 0.005 dens 2500 2500 vol 0.2 100 vel 0 0 0 0 -0.5
timestep 4e-5
run 3000
fix drag all viscous 0.02
run 5000
unfix drag
fix drag all viscous 0.002
thermo_style custom step ke f_pour f_pour[3] f_x[16] f_y[16] f_z[16]
thermo_modify format float %.17g
thermo 1000
"
        + &dump(4000)
        + "run 4000\n";
    let (output, _, _) = run(&engine, "insertion_weight", &deck, 1);
    let row = thermo_rows(&output).pop().unwrap();
    assert_eq!(row["f_pour"], 40.0);
    let (weight, walls) = (
        9.81 * row["f_pour[3]"],
        row["f_z[16]"] + row["f_x[16]"] + row["f_y[16]"],
    );
    println!(
        "weight {weight:.9} N, floor {:.9} N, all walls {:.9} N: off by {:+.1e}, kinetic energy {:.1e} J",
        row["f_z[16]"],
        walls,
        walls / -weight - 1.0,
        row["KinEng"]
    );
    assert!((walls / -weight - 1.0).abs() < 1e-6);
}

/// The numbers of new grains: after the largest there is, or after the largest there was.
#[test]
fn both_versions_new_grains_get_the_next_ids() {
    let engine = Engine::from_environment();
    for (word, first) in [
        ("", "largest there is"),
        ("id max", "largest there is"),
        ("id next", "largest there was"),
    ] {
        let deck = head(&engine, "ellipsoid", "p p f", [0.05, 0.05, 0.3])
            + &stream(&format!(
                "100 1 4711 region top shape one 0.006 0.004 0.004 vol 0.01 50 vel 0 0 0 0 -2 {word}"
            ))
            + "run 10
variable before equal $(count(all))
group gone id > $(v_before-4)
delete_atoms group gone compress no
compute i all property/atom id
compute most all reduce max c_i
compute least all reduce min c_i
run 1000
thermo_style custom step atoms f_pour c_most c_least
run 0
print \"COUNTS $(v_before) $(f_pour) $(atoms) $(c_most:%.0f)\"
";
        let directory = fresh_directory("insertion_ids");
        let (success, output) = execute(&engine, &directory, &deck, 2);
        assert!(success, "{}", last_lines(&output));
        let line = output
            .lines()
            .find_map(|l| l.strip_prefix("COUNTS "))
            .unwrap();
        let counts: Vec<f64> = line
            .split_whitespace()
            .map(|w| w.parse().unwrap())
            .collect();
        let [before, inserted, atoms, most] = counts[..] else {
            panic!("{line}")
        };
        println!("'{word}', the {first}: {before} at first, {inserted} in all, {atoms} there, largest ID {most}");
        assert!(inserted > before + 5.0 && atoms == inserted - 4.0);
        let expected = if word == "id next" {
            inserted
        } else {
            inserted - 4.0
        };
        assert_eq!(most, expected, "'{word}'");
    }
}

/// No two grains have the same number, whoever else numbers some: contacts are remembered by it.
#[test]
fn both_versions_no_two_grains_have_the_same_id() {
    let engine = Engine::from_environment();
    let words = "shape one 0.006 0.004 0.004 dens 2500 2500 vol 0.01 50 vel 0 0 0 0 -2";
    for (word, other) in [("next", "next"), ("next", "max"), ("max", "next")] {
        let deck = head(&engine, "ellipsoid", "p p f", [0.05, 0.05, 0.3])
            + &stream(&format!("100 1 4711 region top {words} id {word}"))
            + &format!(
                "region low block 0 0.05 0 0.05 0.1 0.15
fix other all pour/ellipsoid 50 1 4712 region low {words} id {other}
run 300
create_ellipsoids 2 1 region low number 5 shape one 0.003 0.003 0.003 dens 2500 2500
run 700
write_dump all custom grains id modify sort id
"
            );
        let directory = fresh_directory("insertion_distinct_ids");
        let (success, output) = execute(&engine, &directory, &deck, 2);
        assert!(success, "{}", last_lines(&output));
        let text = std::fs::read_to_string(directory.join("grains")).unwrap();
        let ids: Vec<u64> = text
            .lines()
            .skip_while(|line| !line.starts_with("ITEM: ATOMS"))
            .skip(1)
            .map(|line| line.trim().parse().unwrap())
            .collect();
        println!("{word}, {other}: {} grains", ids.len());
        assert!(ids.len() > 60);
        assert!(ids.windows(2).all(|two| two[0] < two[1]), "{word}, {other}");
    }
}

/// A data file states how many ellipsoids it has: those that were inserted and not those that fell out of the box.
#[test]
fn both_versions_a_data_file_has_the_inserted_grains() {
    let engine = Engine::from_environment();
    let start = head(&engine, "ellipsoid", "p p f", [0.05, 0.05, 0.1]);
    let created = "region low block INF INF INF INF 0.03 0.06
create_ellipsoids 2 5 region low number 20 shape one 0.006 0.004 0.004 dens 2500 2500
write_data created.data
";
    let poured = "region top block 0 0.05 0 0.05 0.07 0.1
fix g all gravity 9.81 vector 0 0 -1
fix pour all pour/ellipsoid 40 1 4711 region top shape one 0.006 0.004 0.004 dens 2500 2500 vol 0.04 50 vel 0 0 0 0 -1
thermo_modify lost ignore
run 2000
write_data poured.data
print \"COUNTS $(atoms) $(f_pour)\"
";
    let read = |name: &str| {
        format!(
            "clear\nplugin load {}\nunits si\natom_style ellipsoid\nboundary p p f\nread_data {name}.data\nprint \"READ $(count(all))\"\n",
            engine.plugin.display()
        )
    };
    let deck = start + created + poured + &read("created") + &read("poured");
    let directory = fresh_directory("insertion_data_file");
    let (success, output) = execute(&engine, &directory, &deck, 2);
    assert!(success, "{}", last_lines(&output));
    let numbers = |word: &str| -> Vec<f64> {
        let lines = output.lines().filter_map(|l| l.strip_prefix(word));
        let words = lines.flat_map(str::split_whitespace);
        words.map(|w| w.parse().unwrap()).collect()
    };
    let [left, inserted] = numbers("COUNTS ")[..] else {
        panic!("no counts")
    };
    println!("20 created, {inserted} poured, {left} left");
    assert!(inserted > 20.0 && left < 20.0 + inserted);
    assert_eq!(numbers("READ "), [20.0, left]);
}

/// *ignore*, *inside centre* and *partial yes*.
#[test]
fn both_versions_words_that_allow_more_are_obeyed() {
    let engine = Engine::from_environment();
    let needles = "shape one 0.012 0.004 0.004";
    // points on a lattice so narrow that no grain lies between them
    let points = "lattice sc 0.003\ncreate_atoms 2 region r\n";
    let region = "region r block 0.005 0.045 0.005 0.045 0.005 0.045 units box\n";
    let start = head(&engine, "ellipsoid", "f f f", [0.05; 3]);
    let end = format!(
        "group points type 2\ndelete_atoms group points\n{}run 0\n",
        dump(1)
    );
    let refused =
        format!("{start}{region}{points}create_ellipsoids 1 5 region r number 30 {needles}\n");
    let directory = fresh_directory("insertion_not_ignored");
    let (success, output) = execute(&engine, &directory, &refused, 1);
    crate::refusal::refused(
        "without ignore",
        success,
        &output,
        &["is not an ellipsoid", "ignore"],
    );
    let obeyed = format!(
        "{start}{region}{points}create_ellipsoids 1 5 region r number 30 {needles} ignore\n{end}"
    );
    let (_, _, grains) = run(&engine, "insertion_ignore", &obeyed, 2);
    assert_eq!(grains.len(), 30);
    assert_eq!(overlaps(&grains, [0.0; 3]).0, 0);

    // centres alone, in a region in which no grain would find room whole, and of a style that has no surface
    let slabs = [
        (
            "block 0.005 0.045 0.005 0.045 0.024 0.026 units box",
            0.024,
            0.026,
        ),
        (
            "prism 0.005 0.04 0.005 0.045 0.02 0.03 0.005 0 0 units box",
            0.02,
            0.03,
        ),
    ];
    for (k, (words, low, high)) in slabs.into_iter().enumerate() {
        let fill = |inside: &str| {
            format!("{start}region r {words}\ncreate_ellipsoids 1 5 region r number 25 {needles} inside {inside} orient align 0 0 1\n{}run 0\n", dump(1))
        };
        let name = format!("insertion_centre_{k}");
        let (success, _) = execute(&engine, &fresh_directory(&name), &fill("grain"), 1);
        assert!(!success, "{words}: a grain fits in whole");
        let (_, _, grains) = run(&engine, &name, &fill("centre"), 2);
        assert_eq!(grains.len(), 25);
        assert_eq!(overlaps(&grains, [0.0; 3]).0, 0);
        assert!(grains.iter().all(|g| (low..=high).contains(&g.position[2])));
        let out = grains.iter().filter(|g| g.position[2] + g.largest() > high);
        assert!(out.count() > 5, "{words}: none sticks out");
    }

    // more than fits: those that do
    let partial = format!(
        "{start}{region}create_ellipsoids 1 5 region r fill 0.7 {needles} attempts 100 partial yes\n{}run 0\n",
        dump(1)
    );
    let (output, _, grains) = run(&engine, "insertion_partial", &partial, 2);
    let fraction = grains.iter().map(Inserted::volume).sum::<f64>() / 0.04f64.powi(3);
    println!(
        "partial: {} grains, a solid fraction of {fraction:.3}",
        grains.len()
    );
    assert!(fraction > 0.15 && fraction < 0.5);
    assert_eq!(overlaps(&grains, [0.0; 3]).0, 0);
    let warning = output
        .lines()
        .find(|l| l.starts_with("WARNING"))
        .expect("no warning");
    assert!(warning.contains("region r"), "{warning}");
}
