// SPDX-License-Identifier: MIT OR Apache-2.0
//! The scenes of two grains: pressed together, sheared, and colliding.

use std::path::Path;

use anyhow::{Context, Result};

use super::deck;
use super::engine::Engine;
use super::material::Material;
use super::table::Table;
use crate::chart::{
    self, Panel, Points, Series, GRANULAR, OURS, OURS_LIGHT, SUPERELLIPSOID, SUPERELLIPSOID_LIGHT,
};

const MATERIAL: Material = Material {
    youngs_modulus: 1e7,
    poissons_ratio: 0.3,
    viscosity: 400.0,
    density: 2500.0,
    friction: 0.5,
};

/// The grains of press.lmp and shear.lmp, in metres.
const RADIUS: f64 = 1e-3;
const SPHERE: [&str; 3] = ["1e-3", "1e-3", "1e-3"];
const ELLIPSOID: [&str; 3] = ["2e-3", "1e-3", "1e-3"];
/// Overlap over radius at which shear.lmp holds the grains.
const SHEARED: f64 = 0.001;

/// A law on trial: what to run it with, and how it is drawn.
struct Trial<'a> {
    name: &'a str,
    label: String,
    colour: plotters::style::RGBColor,
    dashed: bool,
    atoms: &'a str,
    style: &'a str,
    law: String,
    axes: [&'a str; 3],
    /// Further variables of the deck.
    more: Vec<(&'a str, &'a str)>,
}

impl Trial<'_> {
    fn run<const N: usize>(&self, engine: &Engine, deck: &str) -> Result<Vec<[f64; N]>> {
        let output = engine.path(&format!("{}.txt", self.name));
        let output = deck::text(&output)?;
        let mut variables = vec![
            ("atoms", self.atoms),
            ("style", self.style),
            ("law", self.law.as_str()),
            ("output", output),
            ("a", self.axes[0]),
            ("b", self.axes[1]),
            ("c", self.axes[2]),
        ];
        variables.extend(&self.more);
        engine.run(deck, self.name, &variables)?;
        engine.columns(&format!("{}.txt", self.name))
    }

    fn curve(&self, points: Points) -> Series {
        Series::curve(&self.label, points, self.colour, self.dashed)
    }
}

fn ours<'a>(name: &'a str, label: &str, law: String, axes: [&'a str; 3]) -> Trial<'a> {
    Trial {
        name,
        label: label.to_string(),
        colour: OURS,
        dashed: false,
        atoms: "ellipsoid",
        style: "gran/ellipsoid",
        law,
        axes,
        more: Vec::new(),
    }
}

fn granular<'a>(name: &'a str, label: &str, law: String) -> Trial<'a> {
    Trial {
        colour: GRANULAR,
        atoms: "sphere",
        style: "granular",
        ..ours(name, label, law, SPHERE)
    }
}

fn superellipsoid<'a>(name: &'a str, label: &str, law: String, axes: [&'a str; 3]) -> Trial<'a> {
    Trial {
        colour: SUPERELLIPSOID,
        atoms: "superellipsoid",
        style: "granular/superellipsoid",
        ..ours(name, label, law, axes)
    }
}

fn sphere_mass() -> f64 {
    MATERIAL.mass(4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3))
}

/// Radius of the contact of two equal spheres at this overlap.
fn contact_radius(overlap: f64) -> f64 {
    (0.5 * RADIUS * overlap).sqrt()
}

/// Force against overlap: the loop of the viscous law, and what one radius in place of the contact ellipse does.
pub fn normal_force(engine: &Engine, output: &Path) -> Result<Table> {
    let spheres = [
        ours(
            "press-nfd",
            "gran/ellipsoid, NFD from E, nu and two viscosities",
            MATERIAL.viscoelastic(),
            SPHERE,
        ),
        Trial {
            colour: OURS_LIGHT,
            ..ours(
                "press-hertz",
                "gran/ellipsoid, elastic Hertz",
                MATERIAL.elastic(),
                SPHERE,
            )
        },
        Trial {
            dashed: true,
            ..granular(
                "press-granular",
                "granular, damping viscoelastic fitted to this mass",
                MATERIAL.granular(Some(sphere_mass()), 0.0),
            )
        },
    ];
    let mut table = Table::new(
        "Two grains pressed together to 2 % and pulled apart, at 5 cm/s",
        &[
            "scene and law",
            "force at 2 % (mN)",
            "lost in the loop (nJ)",
            "strongest pull (mN)",
        ],
    );
    let mut left = Vec::new();
    for trial in &spheres {
        left.push(pressed(engine, trial, "spheres", &mut table)?);
    }
    let mut panels = vec![Panel::of_curves(
        "Two spheres of 1 mm, pressed and pulled at 5 cm/s",
        "overlap (µm)",
        "normal force (mN)",
        left,
    )];
    for (pose, turn, name) in [
        ("parallel", "0", "press-parallel"),
        ("crossed", "90", "press-crossed"),
    ] {
        let mut trials = vec![Trial {
            more: vec![("turn", turn)],
            ..ours(
                name,
                "gran/ellipsoid, contact ellipse",
                MATERIAL.elastic(),
                ELLIPSOID,
            )
        }];
        if engine.superellipsoid {
            let law = MATERIAL.superellipsoid(None, 0.0, contact_radius(SHEARED * RADIUS));
            let mean = superellipsoid(
                "press-superellipsoid-mean",
                "granular/superellipsoid, mean curvature",
                law.clone(),
                ELLIPSOID,
            );
            let gaussian = Trial {
                style: "granular/superellipsoid curvature_gaussian",
                colour: SUPERELLIPSOID_LIGHT,
                ..superellipsoid(
                    "press-superellipsoid-gaussian",
                    "granular/superellipsoid, Gaussian curvature",
                    law,
                    ELLIPSOID,
                )
            };
            trials.extend([mean, gaussian].map(|trial| Trial {
                dashed: true,
                more: vec![("turn", turn)],
                ..trial
            }));
        }
        let mut curves = Vec::new();
        for trial in &trials {
            curves.push(pressed(engine, trial, pose, &mut table)?);
        }
        panels.push(Panel::of_curves(
            &format!("Two elastic ellipsoids, 2 x 1 x 1 mm, side by side, {pose}"),
            "overlap (µm)",
            "normal force (mN)",
            curves,
        ));
    }
    let title = if engine.superellipsoid {
        "NFD dissipates without a fitted constant and never pulls; one radius cannot serve both poses of a pair"
    } else {
        "NFD dissipates without a fitted constant and never pulls"
    };
    chart::draw(&output.join("normal-force.svg"), title, &[panels])?;
    Ok(table)
}

fn pressed(engine: &Engine, trial: &Trial, scene: &str, table: &mut Table) -> Result<Series> {
    let rows: Vec<[f64; 2]> = trial.run(engine, "compare/press.lmp")?;
    let deepest = rows
        .iter()
        .max_by(|a, b| a[0].total_cmp(&b[0]))
        .context("no rows")?;
    let loop_area: f64 = rows
        .windows(2)
        .map(|pair| 0.5 * (pair[0][1] + pair[1][1]) * (pair[1][0] - pair[0][0]))
        .sum();
    let pull = rows.iter().map(|row| row[1]).fold(0.0, f64::min);
    table.row(vec![
        format!("{scene}, {}", trial.label),
        format!("{:.3}", 1e3 * deepest[1]),
        format!("{:.2}", (1e9 * loop_area).max(0.0)),
        format!("{:.2}", 1e3 * pull.abs()),
    ]);
    let points = rows
        .iter()
        .filter(|row| row[0] > -5e-7)
        .map(|row| (1e6 * row[0], 1e3 * row[1]))
        .collect();
    Ok(trial.curve(points))
}

/// Tangential force against displacement, to and fro past sliding.
pub fn tangential_force(engine: &Engine, output: &Path) -> Result<Table> {
    let overlap = SHEARED * RADIUS;
    let friction = MATERIAL.friction;
    let mut spheres = vec![
        ours(
            "shear-tfd",
            "gran/ellipsoid, TFD",
            MATERIAL.with_friction(&MATERIAL.elastic()),
            SPHERE,
        ),
        granular(
            "shear-granular",
            "granular, tangential mindlin",
            MATERIAL.granular(None, friction),
        ),
    ];
    let fitted = MATERIAL.superellipsoid(None, friction, contact_radius(overlap));
    if engine.superellipsoid {
        spheres.push(Trial {
            dashed: true,
            ..superellipsoid(
                "shear-superellipsoid",
                "granular/superellipsoid, spring fitted to this overlap",
                fitted.clone(),
                SPHERE,
            )
        });
    }
    let law = MATERIAL.with_friction(&MATERIAL.elastic());
    let mut ellipsoids = vec![
        Trial {
            more: vec![("along", "x")],
            ..ours(
                "shear-major",
                "gran/ellipsoid, TFD along the major axis",
                law.clone(),
                ["6e-3", "1e-3", "1e-3"],
            )
        },
        Trial {
            colour: OURS_LIGHT,
            more: vec![("along", "y")],
            ..ours(
                "shear-minor",
                "gran/ellipsoid, TFD along the minor axis",
                law,
                ["6e-3", "1e-3", "1e-3"],
            )
        },
    ];
    if engine.superellipsoid {
        for (along, label, colour) in [
            ("x", "along the major axis", SUPERELLIPSOID),
            ("y", "along the minor axis", SUPERELLIPSOID_LIGHT),
        ] {
            ellipsoids.push(Trial {
                dashed: true,
                colour,
                more: vec![("along", along)],
                ..superellipsoid(
                    if along == "x" {
                        "shear-superellipsoid-major"
                    } else {
                        "shear-superellipsoid-minor"
                    },
                    &format!("granular/superellipsoid, the same spring, {label}"),
                    fitted.clone(),
                    ["6e-3", "1e-3", "1e-3"],
                )
            });
        }
    }
    let mut table = Table::new(
        "One grain sheared on another at 0.1 % overlap, friction 0.5",
        &[
            "scene and law",
            "first stiffness (N/m)",
            "normal force (mN)",
            "F_t/F_n when sliding",
            "slides from (µm)",
        ],
    );
    let mut left = Vec::new();
    for trial in &spheres {
        left.push(sheared(engine, trial, "spheres", &mut table)?);
    }
    let mut right = Vec::new();
    for trial in &ellipsoids {
        right.push(sheared(engine, trial, "aspect ratio 6", &mut table)?);
    }
    chart::draw(
        &output.join("tangential-force.svg"),
        "TFD softens as the contact slips from its edge inwards; a spring is straight up to sliding, and alike in every direction",
        &[vec![
            Panel::of_curves(
                "Two spheres of 1 mm at 0.1 % overlap",
                "tangential displacement (µm)",
                "tangential force over normal force",
                left,
            ),
            Panel::of_curves(
                "Two parallel ellipsoids, 6 x 1 x 1 mm, at 0.1 % overlap",
                "tangential displacement (µm)",
                "tangential force over normal force",
                right,
            ),
        ]],
    )?;
    Ok(table)
}

fn sheared(engine: &Engine, trial: &Trial, scene: &str, table: &mut Table) -> Result<Series> {
    let rows: Vec<[f64; 3]> = trial.run(engine, "compare/shear.lmp")?;
    // The force on the grain that is moved opposes the motion.
    let points: Points = rows
        .iter()
        .map(|row| (1e6 * row[0], -row[1] / row[2]))
        .collect();
    let first = rows
        .iter()
        .find(|row| row[0] > 0.0)
        .context("the grain did not move")?;
    // The first way there, up to the turn.
    let turn = points
        .windows(2)
        .position(|pair| pair[1].0 < pair[0].0)
        .unwrap_or(points.len());
    let there = &points[..turn];
    let most = there.iter().map(|point| point.1).fold(0.0, f64::max);
    let sliding = there
        .iter()
        .find(|point| point.1 > 0.999 * most)
        .context("no force")?;
    table.row(vec![
        format!("{scene}, {}", trial.label),
        format!("{:.0}", -first[1] / first[0]),
        format!("{:.4}", 1e3 * rows[0][2]),
        format!("{most:.4}"),
        format!("{:.3}", sliding.0),
    ]);
    Ok(trial.curve(points))
}

/// Of time, force and kinetic energy: a row with the greatest force, the contact time and the share of the energy that is kept, and
/// the force over the time since touch in ms.
pub fn impact(label: &str, rows: &[[f64; 3]]) -> Result<(Vec<String>, Points)> {
    let contact: Vec<&[f64; 3]> = rows.iter().filter(|row| row[1] > 0.0).collect();
    let first = contact.first().context("the grains missed each other")?[0];
    let force: Vec<_> = contact
        .iter()
        .map(|row| (1e3 * (row[0] - first), row[1]))
        .collect();
    let peak = force.iter().map(|point| point.1).fold(0.0, f64::max);
    let row = vec![
        label.to_string(),
        format!("{peak:.3}"),
        format!("{:.3}", force[force.len() - 1].0),
        format!("{:.4}", rows[rows.len() - 1][2] / rows[0][2]),
    ];
    Ok((row, force))
}

/// Two ellipsoids of aspect ratio 2 in an oblique collision with friction.
pub fn collision(engine: &Engine, output: &Path) -> Result<Table> {
    let example = engine.path("collision.dat");
    let example = deck::text(&example)?;
    engine.run("collision.lmp", "collision", &[("out", example)])?;
    let rows: Vec<[f64; 8]> = engine.columns("collision.dat")?;
    let touching: Vec<&[f64; 8]> = rows.iter().filter(|row| row[2] > 0.0).collect();
    let loop_of = |x: usize, y: usize| -> Points {
        touching.iter().map(|row| (1e6 * row[x], row[y])).collect()
    };
    let own = |label: &str, points| Series::curve(label, points, OURS, false);

    // Volume of the grains of collision.lmp, and the contact radius of spheres of it at a middling overlap.
    let mass = MATERIAL.mass(4.0 / 3.0 * std::f64::consts::PI * 5e-3 * 5e-3 * 10e-3);
    let radius = (5e-3f64 * 5e-3 * 10e-3).cbrt();
    let middling = (0.5 * radius * 0.01 * radius).sqrt();
    let mut trials = vec![ours(
        "collision-ellgran",
        "gran/ellipsoid, NFD and TFD",
        MATERIAL.with_friction(&MATERIAL.viscoelastic()),
        ELLIPSOID,
    )];
    if engine.superellipsoid {
        trials.push(superellipsoid(
            "collision-superellipsoid",
            "granular/superellipsoid, constants fitted to this mass",
            MATERIAL.superellipsoid(Some(mass), MATERIAL.friction, middling),
            ELLIPSOID,
        ));
    }
    trials.push(granular(
        "collision-granular",
        "granular, spheres of the same volume",
        MATERIAL.granular(Some(mass), MATERIAL.friction),
    ));
    let mut table = Table::new(
        "An oblique collision with friction, 0.56 m/s",
        &[
            "law",
            "peak force (N)",
            "contact time (ms)",
            "kinetic energy kept",
        ],
    );
    let mut beside = Vec::new();
    for trial in &trials {
        let rows: Vec<[f64; 3]> = trial.run(engine, "compare/collision.lmp")?;
        let (row, force) = impact(&trial.label, &rows).context(trial.name.to_string())?;
        table.row(row);
        beside.push(trial.curve(force));
    }
    chart::draw(
        &output.join("collision.svg"),
        "An oblique collision of two viscoelastic ellipsoids of aspect ratio 2: both loops lose energy; shape changes force and contact time",
        &[vec![
            Panel::of_curves(
                "Normal force (NFD)",
                "overlap (µm)",
                "normal force (N)",
                vec![own("gran/ellipsoid", loop_of(2, 3))],
            ),
            Panel::of_curves(
                "Tangential force (TFD)",
                "tangential displacement (µm)",
                "tangential force (N)",
                vec![own("gran/ellipsoid", loop_of(5, 4))],
            ),
            Panel::of_curves(
                "The whole force, beside the built-in styles",
                "time since touch (ms)",
                "force (N)",
                beside,
            ),
        ]],
    )?;
    Ok(table)
}
