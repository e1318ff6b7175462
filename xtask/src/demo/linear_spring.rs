// SPDX-License-Identifier: MIT OR Apache-2.0
//! A linear spring and dashpot (LSD) fitted to NFD at one impact speed, run at others.

use std::f64::consts::PI;
use std::path::Path;

use anyhow::{Context, Result};

use super::deck;
use super::engine::Engine;
use super::material::Material;
use super::table::Table;
use crate::chart::{self, Panel, Series, OURS, OURS_LIGHT};

const MATERIAL: Material = Material {
    youngs_modulus: 1e7,
    poissons_ratio: 0.3,
    viscosity: 400.0,
    density: 2500.0,
    friction: 0.5,
};

/// The spheres of impact.lmp, in metres.
const RADIUS: f64 = 4e-3;
/// In m/s.
const FITTED_AT: f64 = 0.05;
/// Impact speeds over the fitted one.
const RATIOS: [f64; 7] = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];

/// What is measured of a collision.
struct Impact {
    greatest_force: f64,
    /// From first touch to the moment at which the gap opens.
    duration: f64,
    restitution: f64,
}

pub fn linear_spring(engine: &Engine, output: &Path) -> Result<Table> {
    let viscoelastic = MATERIAL.viscoelastic();
    let fitted_to = collide(engine, "impact-fit", &viscoelastic, FITTED_AT)?;
    let (stiffness, damping) = fit(
        0.5 * MATERIAL.mass(4.0 / 3.0 * PI * RADIUS.powi(3)),
        fitted_to.duration,
        fitted_to.restitution,
    );
    // Limited, the spring would not have the contact time that it was fitted to.
    let linear = format!("lsd {stiffness:e} {damping:e} limit_force no");

    let mut table = Table::new(
        "A linear spring fitted at one speed",
        &[
            "speed / fitted speed",
            "peak force, NFD (mN)",
            "LSD (mN)",
            "error (%)",
            "contact time, NFD (ms)",
            "LSD (ms)",
            "error (%)",
        ],
    );
    let (mut in_force, mut in_time) = (Vec::new(), Vec::new());
    for ratio in RATIOS {
        let speed = ratio * FITTED_AT;
        let nfd = collide(engine, &format!("impact-nfd-{ratio}"), &viscoelastic, speed)?;
        let lsd = collide(engine, &format!("impact-lsd-{ratio}"), &linear, speed)?;
        let force = 100.0 * (lsd.greatest_force / nfd.greatest_force - 1.0);
        let time = 100.0 * (lsd.duration / nfd.duration - 1.0);
        table.row(vec![
            format!("{ratio}"),
            format!("{:.3}", 1e3 * nfd.greatest_force),
            format!("{:.3}", 1e3 * lsd.greatest_force),
            per_cent(force),
            format!("{:.4}", 1e3 * nfd.duration),
            format!("{:.4}", 1e3 * lsd.duration),
            per_cent(time),
        ]);
        in_force.push((ratio.log10(), force));
        in_time.push((ratio.log10(), time));
    }
    chart::draw(
        &output.join("linear-spring.svg"),
        "A linear spring fitted at one speed is tens of per cent off in force and contact time at ten times less or more",
        &[vec![
            panel("Peak force", "error in peak force (%)", in_force),
            panel("Contact time", "error in contact time (%)", in_time),
        ]],
    )?;
    Ok(table)
}

fn collide(engine: &Engine, name: &str, law: &str, speed: f64) -> Result<Impact> {
    let file = format!("{name}.txt");
    let path = engine.path(&file);
    engine.run(
        "compare/impact.lmp",
        name,
        &[
            ("law", law),
            ("speed", &speed.to_string()),
            ("output", deck::text(&path)?),
        ],
    )?;
    impact(&engine.columns(&file)?, speed).with_context(|| format!("{name}: still in contact"))
}

/// From rows of time, overlap, rate of overlap and force; `None` if the spheres have not parted.
fn impact(rows: &[[f64; 4]], speed: f64) -> Option<Impact> {
    let [before, after] = rows
        .windows(2)
        .map(|pair| [pair[0], pair[1]])
        .find(|[before, after]| before[1] > 0.0 && after[1] <= 0.0)?;
    let part = before[1] / (before[1] - after[1]);
    Some(Impact {
        greatest_force: rows.iter().map(|row| row[3]).fold(0.0, f64::max),
        duration: before[0] + part * (after[0] - before[0]),
        restitution: -rows.last()?[2] / speed,
    })
}

/// Stiffness and damping of the linear law with this contact time and restitution, at any speed.
fn fit(effective_mass: f64, duration: f64, restitution: f64) -> (f64, f64) {
    let decrement = -restitution.ln();
    (
        effective_mass * (PI * PI + decrement * decrement) / duration.powi(2),
        2.0 * effective_mass * decrement / duration,
    )
}

/// Without a sign on what rounds to nothing.
fn per_cent(error: f64) -> String {
    let text = format!("{error:+.1}");
    match text.as_str() {
        "+0.0" | "-0.0" => "0.0".to_string(),
        _ => text,
    }
}

fn panel(title: &str, y: &str, errors: chart::Points) -> Panel {
    let ends = [errors[0].0, errors[errors.len() - 1].0];
    let reference = ends.map(|x| (x, 0.0)).to_vec();
    Panel::of_curves(
        &format!("{title} of two spheres of 4 mm, head-on, 5 mm/s to 50 cm/s"),
        "log10 (impact speed / fitted speed)",
        y,
        vec![
            Series::curve(
                "NFD from E, nu and two viscosities: the reference",
                reference,
                OURS,
                true,
            ),
            Series::curve(
                "LSD, fitted to contact time and restitution at 5 cm/s",
                errors,
                OURS_LIGHT,
                false,
            ),
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fitted_spring_has_the_contact_time_and_the_restitution() {
        let (mass, duration, restitution, speed) = (0.3, 2.0, 0.7, 0.4);
        let (stiffness, damping) = fit(mass, duration, restitution);
        let step = 1e-4;
        let (mut x, mut v) = (0.0, speed);
        let mut rows = Vec::new();
        for k in 0..30_000 {
            let force = stiffness * x + damping * v;
            let force = if x < 0.0 { 0.0 } else { force };
            rows.push([k as f64 * step, x, v, force]);
            v -= step * force / mass;
            x += step * v;
        }
        let found = impact(&rows, speed).unwrap();
        assert!((found.duration / duration - 1.0).abs() < 1e-3);
        assert!((found.restitution / restitution - 1.0).abs() < 1e-3);
    }

    #[test]
    fn errors_have_signs_but_zero() {
        assert_eq!(per_cent(-0.006), "0.0");
        assert_eq!(per_cent(14.51), "+14.5");
        assert_eq!(per_cent(-36.4), "-36.4");
    }

    #[test]
    fn the_gap_opens_between_two_rows() {
        let rows = [
            [0.0, 0.0, 2.0, 0.0],
            [1.0, 2.0, 0.0, 5.0],
            [2.0, 1.0, -1.0, 3.0],
            [3.0, -1.0, -1.0, 0.0],
        ];
        let found = impact(&rows, 2.0).unwrap();
        assert_eq!(found.duration, 2.5);
        assert_eq!(found.greatest_force, 5.0);
        assert_eq!(found.restitution, 0.5);
        assert!(impact(&rows[..3], 2.0).is_none());
    }
}
