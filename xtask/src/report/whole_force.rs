// SPDX-License-Identifier: MIT OR Apache-2.0
//! The picture of the whole force: contacts of dense packings through the engines.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use anyhow::{ensure, Context, Result};
use plotters::style::RGBColor;

use super::measurements::{self, scientific, Table};
use super::Section;
use crate::bench::contender::{Contender, Model};
use crate::bench::lammps_run::{path_word, timing, touching, Lammps};
use crate::bench::liggghts_run::{Files, Liggghts};
use crate::bench::packing::{for_superellipsoids, Kind, Packing, CONTACT_RADIUS, MATERIAL};
use crate::bench::scenes::{run_variables, steps_for};
use crate::bench::statistics::{short, Measured};
use crate::chart::{
    self, Line, Panel, Scale, Series, Shape, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION,
};
use crate::demo::table::Table as MarkdownTable;
use crate::engine_forces::{
    in_lammps, in_lammps_on, in_liggghts, pairs_in_reach, relative_error, LammpsStyle,
    LiggghtsModel, Pair, Wrench,
};
use crate::liggghts::Optimisation;
use crate::packed_grains::PackedGrains;
use crate::progress::{say, Progress};
use crate::setup;

pub const PICTURE: &str = "whole-force.svg";

/// One choice of law in one engine.
struct Way {
    name: &'static str,
    engine: Engine,
}

enum Engine {
    /// Words after the normal law, and whether with friction and viscosity when timed.
    Ours {
        set: &'static str,
        keywords: &'static str,
        full: bool,
    },
    /// Words of the pair style.
    Superellipsoid(&'static str),
    Liggghts(Model),
}

fn ways(lammps: &Lammps) -> Vec<Way> {
    let ours = |name, set, keywords, full| Way {
        name,
        engine: Engine::Ours {
            set,
            keywords,
            full,
        },
    };
    let sets = Contender::instruction_sets();
    let widest = sets[sets.len() - 1];
    let mut ways = vec![
        ours("ours", widest, "conservative no", true),
        ours("ours conservative", widest, "conservative yes", true),
        ours("ours hale", widest, "conservative no factors hale", true),
        ours("ours elastic no friction", widest, "conservative no", false),
    ];
    for set in &sets[..sets.len() - 1] {
        let name = match *set {
            "scalar" => "ours scalar",
            "baseline" => "ours baseline",
            _ => "ours avx2",
        };
        ways.push(ours(name, set, "conservative no", true));
    }
    if lammps.superellipsoid {
        for (name, style) in [
            ("superellipsoid mean", "granular/superellipsoid"),
            (
                "superellipsoid gaussian",
                "granular/superellipsoid curvature_gaussian",
            ),
        ] {
            ways.push(Way {
                name,
                engine: Engine::Superellipsoid(style),
            });
        }
    }
    for (name, model) in [
        ("liggghts ours", Model::Nfd),
        ("liggghts superquadric", Model::Superquadric),
        ("liggghts superquadric mean", Model::MeanCurvature),
        ("liggghts superquadric gaussian", Model::GaussianCurvature),
    ] {
        ways.push(Way {
            name,
            engine: Engine::Liggghts(model),
        });
    }
    ways
}

/// Name in the measurements, in the legend, colour, shape, filled.
const LOOKS: [(&str, &str, RGBColor, Shape, bool); 13] = [
    ("ours", "ours, widest lanes", BLUE, Shape::Diamond, true),
    ("ours avx2", "ours, AVX2", BLUE, Shape::Triangle, true),
    ("ours baseline", "ours, SSE2", BLUE, Shape::Square, true),
    ("ours scalar", "ours, scalar", BLUE, Shape::Circle, true),
    (
        "ours elastic no friction",
        "ours, elastic without friction",
        BLUE,
        Shape::Diamond,
        false,
    ),
    (
        "ours conservative",
        "ours, conservative",
        SKY,
        Shape::Diamond,
        true,
    ),
    (
        "ours hale",
        "ours, Hale's factors",
        PURPLE,
        Shape::Diamond,
        true,
    ),
    (
        "liggghts ours",
        "ours in LIGGGHTS",
        BLUE,
        Shape::Square,
        false,
    ),
    (
        "superellipsoid mean",
        "LAMMPS superellipsoid, mean",
        VERMILION,
        Shape::Circle,
        true,
    ),
    (
        "superellipsoid gaussian",
        "LAMMPS superellipsoid, Gaussian",
        VERMILION,
        Shape::Circle,
        false,
    ),
    (
        "liggghts superquadric",
        "LIGGGHTS superquadric",
        GREY,
        Shape::Square,
        true,
    ),
    (
        "liggghts superquadric mean",
        "LIGGGHTS superquadric, mean",
        ORANGE,
        Shape::Square,
        true,
    ),
    (
        "liggghts superquadric gaussian",
        "LIGGGHTS superquadric, Gaussian",
        GREEN,
        Shape::Square,
        true,
    ),
];

/// Contacts and Hertz' force in them.
struct Contacts {
    pairs: Vec<Pair>,
    forces: Vec<Wrench>,
}

pub fn take(output: &Path, quick: bool) -> Result<()> {
    setup::setup()?;
    let lammps = Lammps::prepare()?;
    if !lammps.superellipsoid {
        say(format!(
            "LAMMPS {} has no granular/superellipsoid: it is left out",
            lammps.release
        ));
    }
    let optimisation = if quick {
        Optimisation::O2
    } else {
        Optimisation::O3
    };
    let liggghts = Liggghts::prepare(&[optimisation])?;
    let packings: &[(Kind, [usize; 3], f64)] = if quick {
        &[(Kind::Dense, [8; 3], 2.0)]
    } else {
        &[
            (Kind::Dense, [16; 3], 2.0),
            (Kind::Needles, [16, 8, 8], 10.0),
        ]
    };
    let (rounds, seconds, wanted) = if quick {
        (1, 0.1, 1000)
    } else {
        (3, 0.8, 20_000)
    };
    let mut table = String::from(
        "aspect_ratio,way,contacts,median_error,rms_error,high_error,largest_error,missed,ns_per_contact,ns_spread\n",
    );
    for (kind, lattice, aspect) in packings {
        let file = Packing {
            kind: *kind,
            lattice: *lattice,
            spheres: false,
        }
        .file(&lammps)?;
        let mut progress = Progress::start(format!("Whole force: {}", kind.title()));
        let contacts = contacts(&file, wanted)?;
        let grains = lattice.iter().product::<usize>();
        let ways = ways(&lammps);
        // Contacts per grain, each once.
        let mut words = run_variables(&file, Contender::Ours("scalar"), [1; 3], 5, 20)?;
        words.extend([("count", "1".into()), ("newton", "on".into())]);
        let counted = lammps.run("run.lmp", 1, None, &words)?;
        let per_grain = touching(&counted)? / timing(&counted)?.atoms;
        let mut times = vec![Vec::new(); ways.len()];
        for round in 0..rounds {
            for (k, way) in ways.iter().enumerate() {
                progress.update(
                    Some((round * ways.len() + k) as f64 / (rounds * ways.len()) as f64),
                    way.name,
                );
                let taken = run(
                    way,
                    &lammps,
                    (&liggghts, optimisation),
                    &file,
                    (*kind, grains, seconds),
                )?;
                times[k].push(taken / per_grain);
            }
        }
        for (way, times) in ways.iter().zip(&times) {
            let found = forces(way, &lammps, (&liggghts, optimisation), &contacts.pairs)?;
            let mut errors: Vec<f64> = found
                .iter()
                .zip(&contacts.forces)
                .map(|(found, reference)| relative_error(found, reference))
                .collect();
            errors.sort_by(f64::total_cmp);
            let at = |share: f64| errors[((errors.len() - 1) as f64 * share).round() as usize];
            let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
            let missed = found.iter().filter(|w| w.force == [0.0; 3]).count();
            let time = Measured::of(times).context("no round was run")?;
            writeln!(
                table,
                "{aspect},{},{},{:.3e},{rms:.3e},{:.3e},{:.3e},{missed},{:.1},{:.1}",
                way.name,
                errors.len(),
                at(0.5),
                at(0.95),
                at(1.0),
                time.median,
                time.spread
            )?;
        }
        progress.finish();
    }
    fs::write(output.join("whole-force.csv"), table)?;
    Ok(())
}

fn contacts(packing: &Path, wanted: usize) -> Result<Contacts> {
    let text = fs::read_to_string(packing)
        .with_context(|| format!("cannot read {}", packing.display()))?;
    let pairs = pairs_in_reach(&PackedGrains::read(&text)?, wanted);
    let directory = tempfile::tempdir()?;
    let file = directory.path().join("pairs.csv");
    let mut lines = String::new();
    for pair in &pairs {
        let numbers: Vec<String> = pair
            .iter()
            .flat_map(|grain| {
                grain
                    .semi_axes
                    .into_iter()
                    .chain(grain.position)
                    .chain(grain.quaternion)
            })
            .map(|number| format!("{number:e}"))
            .collect();
        lines += &numbers.join(",");
        lines.push('\n');
    }
    fs::write(&file, lines)?;
    measurements::take(
        "whole-force",
        directory.path(),
        false,
        &[
            &path_word(&file)?,
            &format!("{:e}", MATERIAL.effective_modulus()),
        ],
    )?;
    let reference = Table::read(&directory.path().join("whole-force-reference.csv"))?;
    let (mut touching, mut forces) = (Vec::new(), Vec::new());
    for row in reference.rows() {
        let force = ["fx", "fy", "fz"].map(|name| row.number(name));
        ensure!(
            force.iter().all(|f| f.is_finite()),
            "a reference force is no number"
        );
        touching.push(pairs[row.number("pair") as usize]);
        forces.push(Wrench {
            force,
            torques: [[0.0; 3]; 2],
        });
    }
    ensure!(!touching.is_empty(), "no two grains of the packing touch");
    Ok(Contacts {
        pairs: touching,
        forces,
    })
}

/// Nanoseconds of pair time per grain and step in the packing.
fn run(
    way: &Way,
    lammps: &Lammps,
    (liggghts, optimisation): (&Liggghts, Optimisation),
    file: &Path,
    (kind, grains, seconds): (Kind, usize, f64),
) -> Result<f64> {
    let contender = match way.engine {
        Engine::Ours { set, .. } => Contender::Ours(set),
        Engine::Superellipsoid(_) => Contender::Superellipsoid,
        Engine::Liggghts(model) => Contender::Liggghts(model, optimisation),
    };
    let steps = steps_for(contender, kind, grains, seconds);
    if let Engine::Liggghts(model) = way.engine {
        let files = Files::of(file)?;
        let taken = liggghts.run(optimisation, model, &files, 20, steps)?;
        return Ok(taken.per_grain(taken.pair));
    }
    let input = match way.engine {
        Engine::Superellipsoid(_) => for_superellipsoids(file)?,
        _ => file.to_path_buf(),
    };
    let mut words = run_variables(&input, contender, [1; 3], 20, steps)?;
    let mut replace = |name: &str, value: String| {
        if let Some(word) = words.iter_mut().find(|(one, _)| *one == name) {
            word.1 = value;
        }
    };
    match way.engine {
        Engine::Ours { keywords, full, .. } => {
            let law = if full {
                MATERIAL.with_friction(&MATERIAL.viscoelastic())
            } else {
                MATERIAL.elastic()
            };
            replace("law", format!("{law} {keywords}"));
        }
        Engine::Superellipsoid(style) => replace("style", style.into()),
        Engine::Liggghts(_) => {}
    }
    words.push(("newton", "off".into()));
    let output = lammps.run("run.lmp", 1, contender.instruction_set(), &words)?;
    let taken = timing(&output)?;
    Ok(taken.per_grain(taken.pair))
}

/// The elastic normal force of each pair.
fn forces(
    way: &Way,
    lammps: &Lammps,
    (liggghts, optimisation): (&Liggghts, Optimisation),
    pairs: &[Pair],
) -> Result<Vec<Wrench>> {
    match way.engine {
        Engine::Ours { set, keywords, .. } => in_lammps_on(
            &lammps.binary,
            &LammpsStyle {
                atoms: "ellipsoid",
                style: "gran/ellipsoid",
                coefficients: &format!("{} {keywords}", MATERIAL.elastic()),
                plugin: &lammps.plugin,
            },
            Some(set),
            pairs,
        ),
        Engine::Superellipsoid(style) => in_lammps(
            &lammps.binary,
            &LammpsStyle {
                atoms: "superellipsoid",
                style,
                coefficients: &MATERIAL.superellipsoid(None, 0.0, CONTACT_RADIUS),
                plugin: &lammps.plugin,
            },
            pairs,
        ),
        Engine::Liggghts(model) => in_liggghts(
            liggghts.binary(optimisation)?,
            &LiggghtsModel {
                model: &model.normal_words(),
                youngs_modulus: MATERIAL.youngs_modulus,
                poissons_ratio: MATERIAL.poissons_ratio,
            },
            pairs,
        ),
    }
}

pub fn section(output: &Path) -> Result<Section> {
    let table = Table::read(&output.join("whole-force.csv"))?;
    let of = |way: &str, column: &str| table.number(&[("aspect_ratio", "2"), ("way", way)], column);
    ensure!(
        of("ours", "largest_error")? < 1e-8,
        "our force is not Hertz'"
    );
    draw(&output.join(PICTURE), &table)?;
    let ours = of("ours", "ns_per_contact")?;
    let mut others = String::new();
    for (way, label) in [
        ("superellipsoid mean", "Superellipsoids of LAMMPS"),
        (
            "liggghts superquadric mean",
            "Superquadrics of LIGGGHTS with the mean curvature",
        ),
    ] {
        if let Ok(time) = of(way, "ns_per_contact") {
            others += &format!(
                " {label} take {} times as long for a force that is off by {} (median).",
                short(time / ours),
                scientific(of(way, "median_error")?)
            );
        }
    }
    let text = format!(
        "**Conclusion.** The exact force is also the cheapest one: at aspect ratio 2 ours is Hertz' to {} (95 % of the contacts) for {} ns of \
         pair time per contact.{others} What the built-in styles lose is not in the search alone: one radius of curvature stands for the contact \
         ellipse, and their normal is that of the midway point. Hale's factors cost accuracy, and time: they run one contact at a time, at {} times the time. The conservative law departs from \
         F n by a force of relative order overlap over radius, which is what keeps the energy: it is no error of Hertz' force.\n\n\
         Contacts drawn from packings of grains of aspect ratio 2 (solid fraction {}) and 10 ({}). Error: of the force as a vector, over Hertz' \
         exact force, each pair alone in a run of the engine too short to move it, at rest, so that neither friction nor damping acts; symbol: median, \
         upper end of the line: 95 %. The reference is computed in `validation/report/whole_force.rs` by another way than the library's; what is \
         left is the rounding of coordinates, of which the overlap is a small difference. The built-in LAMMPS style takes a spring constant, here 4/3 E*; LIGGGHTS takes E and nu. Time: pair time of the whole packing in motion, \
         neighbours that do not touch included, friction and damping on unless it says otherwise, over the number of contacts; LAMMPS with \
         newton off, LIGGGHTS built with -O3. A running simulation starts each search from the last normal. Elastic grains without friction lose no \
         energy and move the faster, so that pairs that may touch are found anew more often: what their law saves is in the kernels of `cargo xtask bench`.\n",
        scientific(of("ours", "high_error")?),
        short(ours),
        short(of("ours hale", "ns_per_contact")? / ours),
        Kind::Dense.fraction(),
        Kind::Needles.fraction(),
    );
    Ok(Section {
        title: "The whole force",
        picture: PICTURE,
        text,
        tables: vec![markdown(&table)],
        files: vec!["whole-force.csv"],
    })
}

fn draw(path: &Path, table: &Table) -> Result<()> {
    let mut panels = Vec::new();
    for aspect in ["2", "10"] {
        let mut series = Vec::new();
        for (name, label, colour, shape, filled) in LOOKS {
            for row in table.of(&[("aspect_ratio", aspect), ("way", name)]) {
                let time = row.number("ns_per_contact");
                let (median, high) = (row.number("median_error"), row.number("high_error"));
                // The line first, the symbol over it.
                series.push(Series {
                    label: String::new(),
                    points: vec![(time, median), (time, high)],
                    notes: Vec::new(),
                    colour,
                    shape: Shape::None,
                    filled,
                    line: Line::Solid,
                });
                series.push(Series {
                    label: label.into(),
                    points: vec![(time, median)],
                    notes: Vec::new(),
                    colour,
                    shape,
                    filled,
                    line: Line::None,
                });
            }
        }
        if series.is_empty() {
            continue;
        }
        panels.push(Panel {
            title: format!("Aspect ratio {aspect}"),
            x_label: "pair time per contact (ns)".into(),
            y_label: "relative error of the force".into(),
            x: chart::range(series.iter().flat_map(|s| &s.points).map(|p| p.0), 1.0),
            y: 1e-16..3.0,
            series,
            marks: Vec::new(),
            scale: Scale::Decades,
        });
    }
    chart::draw(
        path,
        "In a dense packing the exact force is also the cheapest",
        &[panels],
    )
}

fn markdown(table: &Table) -> MarkdownTable {
    let mut out = MarkdownTable::new(
        "Force in the contacts of dense packings",
        &[
            "way",
            "aspect ratio",
            "contacts",
            "median error",
            "95 %",
            "largest",
            "contacts missed",
            "ns per contact",
        ],
    );
    for row in table.rows() {
        let name = row.word("way");
        let label = LOOKS
            .iter()
            .find(|(one, ..)| *one == name)
            .map_or(name, |(_, label, ..)| label);
        out.row(vec![
            label.to_string(),
            row.word("aspect_ratio").into(),
            row.word("contacts").into(),
            scientific(row.number("median_error")),
            scientific(row.number("high_error")),
            scientific(row.number("largest_error")),
            row.word("missed").into(),
            format!(
                "{} ± {}",
                short(row.number("ns_per_contact")),
                short(row.number("ns_spread"))
            ),
        ]);
    }
    out
}
