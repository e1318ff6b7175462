// SPDX-License-Identifier: MIT OR Apache-2.0
//! Settled grains seen from the side: each projected to the ellipse that it is, nearer ones in front and lighter.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use anyhow::{ensure, Context, Error, Result};

use crate::dump::{tables, Table};
use crate::shapes::{self, dot, scale, Vector};

/// An ellipsoid of a LAMMPS dump; a sphere has three equal axes and no attitude.
#[derive(Debug, Clone, Copy)]
pub struct Grain {
    pub kind: i32,
    pub centre: Vector,
    pub semi_axes: Vector,
    /// w, x, y, z; body to world.
    pub attitude: [f64; 4],
}

impl Grain {
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.semi_axes.iter().product::<f64>()
    }
}

/// What our LAMMPS decks call the diameters and the quaternion, which spheres need not have.
const DIAMETERS: [&str; 3] = ["c_shape[1]", "c_shape[2]", "c_shape[3]"];
const ATTITUDE: [&str; 4] = ["c_quat[1]", "c_quat[2]", "c_quat[3]", "c_quat[4]"];
/// What LIGGGHTS calls the semi-axes and the quaternion.
const SEMI_AXES: [&str; 3] = ["shapex", "shapey", "shapez"];
const LIGGGHTS_ATTITUDE: [&str; 4] = ["quat1", "quat2", "quat3", "quat4"];

/// The grains of the last frame of a text dump.
pub fn read_dump(path: &Path) -> Result<Vec<Grain>> {
    let frames = read_tables(path)?;
    let last = frames.last().context("no frame");
    last.and_then(grains)
        .with_context(|| format!("in {}", path.display()))
}

/// Every frame of a text dump: its grains, and for each of them the number in the column `quantity`.
pub fn read_frames(path: &Path, quantity: &str) -> Result<Vec<(Vec<Grain>, Vec<f64>)>> {
    let tables = read_tables(path)?;
    let frames: Result<_> = tables.iter().map(|t| frame(t, quantity)).collect();
    frames.with_context(|| format!("in {}", path.display()))
}

/// The same of one frame.
pub fn frame(table: &Table, quantity: &str) -> Result<(Vec<Grain>, Vec<f64>)> {
    let place = needed(table, quantity)?;
    let numbers = table.rows.iter().map(|row| row[place]).collect();
    Ok((grains(table)?, numbers))
}

/// The frames of a text dump.
pub fn read_tables(path: &Path) -> Result<Vec<Table>> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let tables = tables(&text).map_err(Error::msg);
    tables.with_context(|| format!("in {}", path.display()))
}

fn needed(table: &Table, name: &str) -> Result<usize> {
    table
        .column(name)
        .with_context(|| format!("no column {name}"))
}

fn grains(table: &Table) -> Result<Vec<Grain>> {
    let places = |names: [&str; 3]| -> Result<[usize; 3]> {
        let [a, b, c] = names.map(|name| needed(table, name));
        Ok([a?, b?, c?])
    };
    let kind = needed(table, "type")?;
    let centre = places(["x", "y", "z"]).or_else(|_| places(["xu", "yu", "zu"]))?;
    let (sizes, attitude, factor) = if table.column(SEMI_AXES[0]).is_some() {
        (SEMI_AXES, LIGGGHTS_ATTITUDE, 1.0)
    } else {
        (DIAMETERS, ATTITUDE, 0.5)
    };
    let sizes = places(sizes)?;
    let attitude = attitude.map(|name| table.column(name));
    ensure!(!table.rows.is_empty(), "no grains");
    let grain = |row: &Vec<f64>| Grain {
        kind: row[kind] as i32,
        centre: centre.map(|k| row[k]),
        semi_axes: sizes.map(|k| factor * row[k]),
        attitude: match attitude {
            [Some(w), Some(x), Some(y), Some(z)] => [row[w], row[x], row[y], row[z]],
            _ => [1.0, 0.0, 0.0, 0.0],
        },
    };
    Ok(table.rows.iter().map(grain).collect())
}

/// An orthographic view: two directions across the picture and one into it.
struct View {
    right: Vector,
    up: Vector,
    away: Vector,
}

impl View {
    /// From the side, turned by `azimuth` and looking down by `elevation`, both in radians.
    fn new(azimuth: f64, elevation: f64) -> Self {
        let (sa, ca) = azimuth.sin_cos();
        let (se, ce) = elevation.sin_cos();
        View {
            right: [ca, sa, 0.0],
            up: [-sa * se, ca * se, ce],
            away: [-sa * ce, ca * ce, -se],
        }
    }
}

/// The outline of a projected ellipsoid: an ellipse, its major axis turned by `angle` from the right.
#[derive(Debug, PartialEq)]
struct Outline {
    centre: [f64; 2],
    major: f64,
    minor: f64,
    angle: f64,
}

/// The shadow of S = R diag(a^2) R^T on a plane has the shape matrix P S P^T: its eigenvalues are the squares of
/// the outline's semi-axes.
fn outline(grain: &Grain, view: &View) -> Outline {
    let axes = body_axes(grain);
    let entry = |u: &Vector, v: &Vector| -> f64 {
        axes.iter()
            .map(|axis| dot(*axis, *u) * dot(*axis, *v))
            .sum()
    };
    let (xx, xy, yy) = (
        entry(&view.right, &view.right),
        entry(&view.right, &view.up),
        entry(&view.up, &view.up),
    );
    let mean = 0.5 * (xx + yy);
    let half = (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
    Outline {
        centre: [dot(grain.centre, view.right), dot(grain.centre, view.up)],
        major: (mean + half).sqrt(),
        minor: (mean - half).max(0.0).sqrt(),
        angle: 0.5 * (2.0 * xy).atan2(xx - yy),
    }
}

/// The semi-axes as vectors in the world.
pub fn body_axes(grain: &Grain) -> [Vector; 3] {
    let axes = shapes::body_axes(grain.attitude);
    [0, 1, 2].map(|k| scale(grain.semi_axes[k], axes[k]))
}

pub struct Picture {
    pub caption: String,
    pub grains: Vec<Grain>,
}

/// Width of a lone picture, and of one of several.
const ALONE: f64 = 640.0;
const PANEL: f64 = 420.0;
const TOP: f64 = 84.0;
const MARGIN: f64 = 18.0;

/// Draws the heaps side by side at one scale. Grains of type `frozen` are grey.
pub fn draw(path: &Path, title: &str, pictures: &[Picture], frozen: Option<i32>) -> Result<()> {
    let view = View::new(0.45, 0.35);
    let outlines: Vec<Vec<(f64, bool, Outline)>> = pictures
        .iter()
        .map(|picture| {
            let mut seen: Vec<_> = picture
                .grains
                .iter()
                .map(|grain| {
                    (
                        dot(grain.centre, view.away),
                        Some(grain.kind) == frozen,
                        outline(grain, &view),
                    )
                })
                .collect();
            seen.sort_by(|a, b| b.0.total_cmp(&a.0));
            seen
        })
        .collect();
    let panel_width = if pictures.len() == 1 { ALONE } else { PANEL };
    let all = || outlines.iter().flatten().map(|(_, _, outline)| outline);
    let low_x = least(all().map(|o| o.centre[0] - o.major));
    let high_x = -least(all().map(|o| -o.centre[0] - o.major));
    let low_y = least(all().map(|o| o.centre[1] - o.major));
    let high_y = -least(all().map(|o| -o.centre[1] - o.major));
    let units = (panel_width - 2.0 * MARGIN) / (high_x - low_x);
    let height = TOP + (high_y - low_y) * units + 2.0 * MARGIN;
    let width = panel_width * pictures.len() as f64;
    let mut svg = String::new();
    writeln!(
        svg,
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0}" height="{height:.0}" viewBox="0 0 {width:.0} {height:.0}">
<rect width="100%" height="100%" fill="#ffffff"/>
<g font-family="sans-serif" fill="#333333" text-anchor="middle">
<text x="{:.1}" y="30" font-size="18">{}</text>"##,
        0.5 * width,
        escaped(title)
    )?;
    for (panel, picture) in pictures.iter().enumerate() {
        writeln!(
            svg,
            r#"<text x="{:.1}" y="62" font-size="14">{}</text>"#,
            panel_width * (panel as f64 + 0.5),
            escaped(&picture.caption)
        )?;
    }
    svg.push_str("</g>\n");
    for (panel, seen) in outlines.iter().enumerate() {
        let far = seen.first().map_or(0.0, |grain| grain.0);
        let near = seen.last().map_or(0.0, |grain| grain.0);
        svg.push_str("<g stroke=\"#1d2b3a\" stroke-width=\"0.6\">\n");
        for (depth, grey, outline) in seen {
            let light = (far - depth) / (far - near).max(f64::MIN_POSITIVE);
            writeln!(
                svg,
                r#"<ellipse rx="{:.2}" ry="{:.2}" fill="{}" transform="translate({:.2} {:.2}) rotate({:.2})"/>"#,
                outline.major * units,
                outline.minor * units,
                shade(light, *grey),
                panel_width * panel as f64 + MARGIN + (outline.centre[0] - low_x) * units,
                TOP + MARGIN + (high_y - outline.centre[1]) * units,
                // SVG's second axis points down, so angles run the other way.
                -outline.angle.to_degrees(),
            )?;
        }
        svg.push_str("</g>\n");
    }
    svg.push_str("</svg>\n");
    fs::write(path, svg).with_context(|| format!("cannot write {}", path.display()))
}

fn least(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, f64::min)
}

/// From dark, far away, to light in front.
fn shade(light: f64, grey: bool) -> String {
    let (far, near): (Vector, Vector) = if grey {
        ([110.0, 110.0, 110.0], [205.0, 205.0, 205.0])
    } else {
        ([38.0, 70.0, 112.0], [190.0, 214.0, 240.0])
    };
    let mix = |k: usize| (far[k] + light.clamp(0.0, 1.0) * (near[k] - far[k])).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grain(semi_axes: Vector, attitude: [f64; 4]) -> Grain {
        Grain {
            kind: 1,
            centre: [0.0; 3],
            semi_axes,
            attitude,
        }
    }

    #[test]
    fn a_projected_ellipsoid_is_known_along_its_axes() {
        // Looking along y, from the front.
        let view = View::new(0.0, 0.0);
        let straight = outline(&grain([3.0, 2.0, 1.0], [1.0, 0.0, 0.0, 0.0]), &view);
        assert!((straight.major - 3.0).abs() < 1e-12 && (straight.minor - 1.0).abs() < 1e-12);
        assert!(straight.angle.abs() < 1e-12);
        // Turned by 90 degrees about z: the long axis points at us.
        let half = 0.5f64.sqrt();
        let end_on = outline(&grain([3.0, 2.0, 1.0], [half, 0.0, 0.0, half]), &view);
        assert!((end_on.major - 2.0).abs() < 1e-12 && (end_on.minor - 1.0).abs() < 1e-12);
        // Turned by 30 degrees about -y: the long axis rises to the right, the way an image angle grows.
        let turn = (15f64.to_radians().cos(), -(15f64.to_radians().sin()));
        let tilted = outline(&grain([3.0, 2.0, 1.0], [turn.0, 0.0, turn.1, 0.0]), &view);
        assert!(
            (tilted.angle.to_degrees() - 30.0).abs() < 1e-9,
            "{tilted:?}"
        );
    }

    #[test]
    fn no_point_of_the_surface_leaves_the_outline() {
        let view = View::new(0.45, 0.35);
        let grain = grain([1.6, 0.9, 0.4], {
            let q = [0.3, -0.5, 0.7, 0.2f64];
            let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
            q.map(|v| v / length)
        });
        let ellipse = outline(&grain, &view);
        let axes = body_axes(&grain);
        let (sin, cos) = ellipse.angle.sin_cos();
        let mut farthest: f64 = 0.0;
        for i in 0..400 {
            for j in 0..400 {
                let polar = std::f64::consts::PI * i as f64 / 399.0;
                let around = std::f64::consts::TAU * j as f64 / 399.0;
                let unit = [
                    polar.sin() * around.cos(),
                    polar.sin() * around.sin(),
                    polar.cos(),
                ];
                let point: Vector =
                    [0, 1, 2].map(|c| (0..3).map(|k| unit[k] * axes[k][c]).sum::<f64>());
                let (x, y) = (dot(point, view.right), dot(point, view.up));
                let along = (x * cos + y * sin) / ellipse.major;
                let across = (y * cos - x * sin) / ellipse.minor;
                farthest = farthest.max(along * along + across * across);
            }
        }
        assert!(farthest <= 1.0 + 1e-12 && farthest > 0.999, "{farthest}");
    }

    #[test]
    fn the_last_frame_of_a_dump_is_read() {
        let text = "\
ITEM: TIMESTEP
0
ITEM: ATOMS id type x y z
1 1 9 9 9
ITEM: TIMESTEP
10
ITEM: ATOMS id type x y z c_shape[1] c_shape[2] c_shape[3] c_quat[1] c_quat[2] c_quat[3] c_quat[4]
1 1 0.1 0.2 0.3 4 2 2 1 0 0 0
2 2 0.4 0.5 0.6 2 2 2 0 1 0 0
";
        let last = |text: &str| grains(tables(text).unwrap().last().unwrap());
        let grains = last(text).unwrap();
        assert_eq!(grains.len(), 2);
        assert_eq!(grains[0].semi_axes, [2.0, 1.0, 1.0]);
        assert_eq!(grains[1].attitude, [0.0, 1.0, 0.0, 0.0]);
        assert_eq!(grains[1].kind, 2);
        assert!(last(&text.replace("c_shape[1]", "other")).is_err());
        let liggghts = "\
ITEM: ATOMS id type x y z shapex shapey shapez quat1 quat2 quat3 quat4\x20
7 1 0.1 0.2 0.3 2 1 1 0 0 1 0\x20
";
        let grains = last(liggghts).unwrap();
        assert_eq!(grains[0].semi_axes, [2.0, 1.0, 1.0]);
        assert_eq!(grains[0].attitude, [0.0, 0.0, 1.0, 0.0]);
    }
}
