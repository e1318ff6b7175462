// SPDX-License-Identifier: MIT OR Apache-2.0
//! Grains and transparent walls, shaded, coloured by a quantity: pictures and animations by POV-Ray, compressed by
//! WebP's tools. Coordinates are those of the simulation.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{bail, Result};

use super::heap::{body_axes, read_tables, Grain};
use crate::process::{jobs, run_logged};
use crate::progress::Progress;
use crate::shapes::{cross, sub, unit};

/// From nothing to the most: pale grains carry little.
const COLOURS: [[f64; 3]; 6] = [
    [0.93, 0.91, 0.83],
    [0.99, 0.85, 0.47],
    [0.99, 0.62, 0.25],
    [0.91, 0.32, 0.16],
    [0.72, 0.09, 0.13],
    [0.40, 0.00, 0.12],
];

/// What all frames have in common.
pub struct Scene {
    /// Corners of the box that the picture shows.
    pub low: [f64; 3],
    pub high: [f64; 3],
    /// What is drawn beside the grains.
    pub walls: Vec<Wall>,
    /// What the colour tells, the value of the last colour, and how the values of the first, which is 0, and of the last are written.
    pub quantity: String,
    pub most: f64,
    pub written: [String; 2],
}

/// A wall.
#[derive(Clone, Debug)]
pub enum Wall {
    /// Floor, four panes and the edges of the box that the picture shows.
    OpenBox,
    /// The floor of that box at this height.
    Floor(f64),
    /// A cylinder or cone without ends: two points of its axis, and the radius at each.
    Shell {
        ends: [[f64; 3]; 2],
        radii: [f64; 2],
    },
    /// A solid cylinder.
    Cylinder { ends: [[f64; 3]; 2], radius: f64 },
    /// Triangles.
    Triangles(Vec<[[f64; 3]; 3]>),
}

/// Grains with the quantity of each.
pub type Frame<'a> = (&'a [Grain], &'a [f64]);

impl Scene {
    /// One picture, WebP, with soft shadows.
    pub fn picture(&self, frame: Frame, output: &Path) -> Result<()> {
        let scratch = tempfile::tempdir()?;
        let png = scratch.path().join("picture.png");
        self.render(frame, true, (900, 720), &png)?;
        let log = scratch.path().join("cwebp.log");
        run_logged(
            Command::new("cwebp")
                .args(["-quiet", "-q", "85"])
                .arg(&png)
                .arg("-o")
                .arg(output),
            &log,
            |_| (),
        )
    }

    /// A loop of frames, animated WebP; the last one stays for a second and a half.
    pub fn animation(&self, frames: &[Frame], output: &Path) -> Result<()> {
        let Some(last) = frames.len().checked_sub(1) else {
            bail!("no frames for {}", output.display());
        };
        let scratch = tempfile::tempdir()?;
        let mut progress = Progress::start("Drawing the animation");
        let mut join = Command::new("img2webp");
        join.args(["-loop", "0", "-lossy", "-q", "60", "-m", "4"]);
        for (number, frame) in frames.iter().enumerate() {
            progress.update(
                Some(number as f64 / frames.len() as f64),
                &format!("{number} of {} frames", frames.len()),
            );
            let png = scratch.path().join(format!("{number:04}.png"));
            self.render(*frame, false, (450, 450), &png)?;
            join.args(["-d", if number == last { "1500" } else { "70" }])
                .arg(png);
        }
        progress.finish();
        let log = scratch.path().join("img2webp.log");
        run_logged(join.arg("-o").arg(output), &log, |_| ())
    }

    fn render(
        &self,
        frame: Frame,
        soft_shadows: bool,
        (width, height): (u32, u32),
        png: &Path,
    ) -> Result<()> {
        let source = png.with_extension("pov");
        fs::write(&source, self.describe(frame, soft_shadows)?)?;
        run_logged(
            Command::new("povray")
                .arg(format!("+I{}", source.display()))
                .arg(format!("+O{}", png.display()))
                .args([format!("+W{width}"), format!("+H{height}")])
                .args(["+A0.2", "-D", "-P", &format!("+WT{}", jobs())]),
            &png.with_extension("log"),
            |_| (),
        )
    }

    /// The scene in POV-Ray's language.
    fn describe(&self, (grains, values): Frame, soft_shadows: bool) -> Result<String> {
        if grains.len() != values.len() {
            bail!("{} values for {} grains", values.len(), grains.len());
        }
        let span = [0, 1, 2].map(|k| self.high[k] - self.low[k]);
        let radius = 0.5 * span.iter().map(|s| s * s).sum::<f64>().sqrt();
        // POV-Ray works with absolute tolerances around 1e-3: half the diagonal becomes 40 units, the box begins at 0.
        let unit = radius / 40.0;
        let [x, y, z] = span.map(|s| s / unit);
        let mut text = String::from(
            "#version 3.7;\nglobal_settings{assumed_gamma 1 max_trace_level 16}\nbackground{rgb 1}\n\
             #declare F=finish{ambient 0.16 diffuse 0.75 specular 0.25 roughness 0.03}\n\
             plane{z,-1.2 pigment{rgb 1} finish{ambient 0.62 diffuse 0.45}}\n",
        );
        let area = "area_light <60,0,0>,<0,40,40>,4,4 adaptive 1";
        writeln!(
            text,
            "light_source{{<-150,-260,330> rgb 0.95 {}}}\nlight_source{{<220,-160,160> rgb 0.35 shadowless}}",
            if soft_shadows { area } else { "" }
        )?;
        self.camera_and_legend(&mut text, [0.5 * x, 0.5 * y, 0.5 * z])?;
        let place = |point: [f64; 3]| [0, 1, 2].map(|k| (point[k] - self.low[k]) / unit);
        for wall in &self.walls {
            match wall {
                Wall::OpenBox => open_box(&mut text, [x, y, z])?,
                Wall::Floor(height) => floor(&mut text, [x, y], place([0.0, 0.0, *height])[2])?,
                Wall::Shell { ends, radii } => {
                    shell(&mut text, ends.map(place), radii.map(|r| r / unit))?
                }
                Wall::Cylinder { ends, radius } => writeln!(
                    text,
                    "cylinder{{<{}>,<{}>,{:.4} {STONE}}}",
                    triple(place(ends[0])),
                    triple(place(ends[1])),
                    radius / unit
                )?,
                Wall::Triangles(all) => {
                    for triangle in all {
                        let [a, b, c] = triangle.map(|corner| triple(place(corner)));
                        writeln!(text, "triangle{{<{a}>,<{b}>,<{c}> {METAL}}}")?;
                    }
                }
            }
        }
        for (grain, value) in grains.iter().zip(values) {
            let position = [0, 1, 2].map(|k| (grain.centre[k] - self.low[k]) / unit);
            let axes = body_axes(grain).map(|axis| axis.map(|component| component / unit));
            let [red, green, blue] = colour(value / self.most);
            writeln!(
                text,
                "sphere{{0,1 matrix<{},{},{},{}> pigment{{srgb<{red:.3},{green:.3},{blue:.3}>}} finish{{F}}}}",
                triple(axes[0]),
                triple(axes[1]),
                triple(axes[2]),
                triple(position)
            )?;
        }
        Ok(text)
    }

    /// From the front left, looking down; the legend stands to the right, across the line of sight.
    fn camera_and_legend(&self, text: &mut String, centre: [f64; 3]) -> Result<()> {
        let radius = 40.0;
        let (sin, cos) = 28f64.to_radians().sin_cos();
        let forward = [sin * cos, cos * cos, -sin];
        let right = [cos, -sin, 0.0];
        let up = [sin * sin, cos * sin, cos];
        let distance = 1.3 * radius / 15f64.to_radians().tan();
        let aim = [0, 1, 2].map(|k| centre[k] + 0.22 * radius * right[k]);
        let eye = [0, 1, 2].map(|k| aim[k] - distance * forward[k]);
        writeln!(
            text,
            "camera{{perspective location <{}> right -x*image_width/image_height up z sky z look_at <{}> angle 30}}",
            triple(eye),
            triple(aim)
        )?;
        const STEPS: usize = 40;
        text.push_str("union{\n");
        for step in 0..STEPS {
            let [red, green, blue] = colour(step as f64 / (STEPS - 1) as f64);
            writeln!(
                text,
                "box{{<0,{:.4},0>,<0.07,{:.4},0.01> pigment{{srgb<{red:.3},{green:.3},{blue:.3}>}} finish{{ambient 1 diffuse 0}}}}",
                step as f64 / STEPS as f64,
                (step + 1) as f64 / STEPS as f64
            )?;
        }
        for (words, x, y) in [
            (&self.written[0], 0.1, -0.02),
            (&self.written[1], 0.1, 0.97),
            (&self.quantity, 0.0, 1.1),
        ] {
            writeln!(
                text,
                "text{{internal 1 \"{words}\" 0.01,0 scale 0.1 translate <{x},{y},0> pigment{{rgb 0.15}} finish{{ambient 1 diffuse 0}}}}"
            )?;
        }
        let place = [0, 1, 2].map(|k| centre[k] + radius * (0.98 * right[k] - 0.3 * up[k]));
        let scaled = |axis: [f64; 3]| triple(axis.map(|component| component * radius));
        writeln!(
            text,
            "no_shadow matrix<{},{},{},{}>}}",
            scaled(right),
            scaled(up),
            scaled(forward),
            triple(place)
        )?;
        Ok(())
    }
}

const GLASS: &str =
    "pigment{rgbt<0.85,0.92,1,0.93>} finish{ambient 0.1 diffuse 0.5 specular 0.3} no_shadow";
const STONE: &str = "pigment{srgb<0.75,0.77,0.8>} finish{F}";
const METAL: &str = "pigment{srgbt<0.45,0.5,0.58,0.25>} finish{F}";
const DARK: &str = "pigment{rgb 0.3} finish{F} no_shadow";

fn floor(text: &mut String, [x, y]: [f64; 2], height: f64) -> Result<()> {
    Ok(writeln!(
        text,
        "box{{<0,0,{:.4}>,<{x:.4},{y:.4},{height:.4}> {STONE}}}",
        height - 1.0
    )?)
}

fn shell(text: &mut String, ends: [[f64; 3]; 2], radii: [f64; 2]) -> Result<()> {
    let [from, to] = ends.map(triple);
    writeln!(
        text,
        "cone{{<{from}>,{:.4},<{to}>,{:.4} open {GLASS}}}",
        radii[0], radii[1]
    )?;
    // A ring lies about POV-Ray's y axis: that becomes the axis of the shell.
    let axis = unit(sub(ends[1], ends[0]));
    let aside = unit(cross(
        axis,
        if axis[0].abs() < 0.5 {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 1.0, 0.0]
        },
    ));
    for (end, radius) in ends.into_iter().zip(radii) {
        writeln!(
            text,
            "torus{{{radius:.4},0.35 matrix<{},{},{},{}> {DARK}}}",
            triple(aside),
            triple(axis),
            triple(cross(aside, axis)),
            triple(end)
        )?;
    }
    Ok(())
}

/// Floor, four panes and the edges of the box.
fn open_box(text: &mut String, [x, y, z]: [f64; 3]) -> Result<()> {
    floor(text, [x, y], 0.0)?;
    for (low, high) in [
        ([-0.3, 0.0, 0.0], [0.0, y, z]),
        ([x, 0.0, 0.0], [x + 0.3, y, z]),
        ([0.0, y, 0.0], [x, y + 0.3, z]),
        ([0.0, -0.3, 0.0], [x, 0.0, z]),
    ] {
        writeln!(text, "box{{<{}>,<{}> {GLASS}}}", triple(low), triple(high))?;
    }
    text.push_str("union{\n");
    let corners = [[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]];
    for (corner, [a, b]) in corners.iter().enumerate() {
        let [c, d] = corners[(corner + 1) % 4];
        writeln!(
            text,
            "cylinder{{<{a:.4},{b:.4},0>,<{a:.4},{b:.4},{z:.4}>,0.35}} cylinder{{<{a:.4},{b:.4},{z:.4}>,<{c:.4},{d:.4},{z:.4}>,0.35}} sphere{{<{a:.4},{b:.4},{z:.4}>,0.35}}"
        )?;
    }
    writeln!(text, "{DARK}}}")?;
    Ok(())
}

fn triple([x, y, z]: [f64; 3]) -> String {
    format!("{x:.6},{y:.6},{z:.6}")
}

/// The colour of a part from 0 to 1; beyond them that of the end, and of what is no number the first.
fn colour(part: f64) -> [f64; 3] {
    let last = COLOURS.len() - 1;
    // not clamp, which would keep what is no number
    let place = if part > 0.0 { part.min(1.0) } else { 0.0 } * last as f64;
    let below = (place as usize).min(last - 1);
    let rest = place - below as f64;
    [0, 1, 2].map(|k| COLOURS[below][k] * (1.0 - rest) + COLOURS[below + 1][k] * rest)
}

/// The corners of the simulation's box, from the head of a LAMMPS dump.
pub fn box_of(dump: &Path) -> Result<([f64; 3], [f64; 3])> {
    let frames = read_tables(dump)?;
    let Some([x, y, z]) = frames.first().map(|frame| &frame.bounds[..]) else {
        bail!("no box in {}", dump.display());
    };
    Ok(([x[0], y[0], z[0]], [x[1], y[1], z[1]]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In units of a box whose half diagonal is 40: semi-axes 2, 1, 0.5 along z, x, y at (20, 30, 10).
    #[test]
    fn a_grain_stands_where_it_is_as_it_is() {
        let side = 80.0 / 3f64.sqrt();
        let scene = Scene {
            low: [-1.0, 0.0, 0.0],
            high: [side - 1.0, side, side],
            walls: vec![],
            quantity: "load".into(),
            most: 2.0,
            written: ["0".into(), "2 N".into()],
        };
        // Turned by a third of a circle about (1, 1, 1): x to y, y to z, z to x.
        let grain = Grain {
            kind: 1,
            centre: [19.0, 30.0, 10.0],
            semi_axes: [0.5, 2.0, 1.0],
            attitude: [0.5, 0.5, 0.5, 0.5],
        };
        let text = scene.describe((&[grain], &[2.0]), true).unwrap();
        let line = text.lines().last().unwrap();
        assert_eq!(
            line,
            "sphere{0,1 matrix<0.000000,0.500000,0.000000,0.000000,0.000000,2.000000,\
             1.000000,0.000000,0.000000,20.000000,30.000000,10.000000> \
             pigment{srgb<0.400,0.000,0.120>} finish{F}}"
        );
        assert!(text.contains("\"2 N\"") && text.contains("\"load\""));
        assert!(scene.describe((&[grain], &[]), true).is_err());
    }

    #[test]
    fn walls_stand_where_they_are() {
        let side = 80.0 / 3f64.sqrt();
        let scene = Scene {
            low: [-1.0, 0.0, 0.0],
            high: [side - 1.0, side, side],
            walls: vec![
                Wall::Shell {
                    ends: [[9.0, 5.0, 5.0], [19.0, 5.0, 5.0]],
                    radii: [3.0, 4.0],
                },
                Wall::Triangles(vec![[[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-1.0, 2.0, 0.0]]]),
                Wall::Floor(7.0),
            ],
            quantity: "load".into(),
            most: 2.0,
            written: ["0".into(), "2 N".into()],
        };
        let text = scene.describe((&[], &[]), true).unwrap();
        for part in [
            "cone{<10.000000,5.000000,5.000000>,3.0000,<20.000000,5.000000,5.000000>,4.0000 open",
            "torus{4.0000,0.35 matrix<0.000000,0.000000,1.000000,1.000000,0.000000,0.000000,0.000000,1.000000,0.000000,20.000000,5.000000,5.000000>",
            "triangle{<0.000000,0.000000,0.000000>,<1.000000,0.000000,0.000000>,<0.000000,2.000000,0.000000>",
            ",7.0000> pigment",
        ] {
            assert!(text.contains(part), "no {part} in\n{text}");
        }
    }

    #[test]
    fn colours_end_where_the_scale_ends() {
        assert_eq!(colour(0.0), COLOURS[0]);
        assert_eq!(colour(1.0), COLOURS[5]);
        assert_eq!(colour(7.0), COLOURS[5]);
        assert_eq!(colour(-1.0), COLOURS[0]);
        assert_eq!(colour(f64::NAN), COLOURS[0]);
        let middle = colour(0.5);
        assert!((middle[1] - 0.5 * (COLOURS[2][1] + COLOURS[3][1])).abs() < 1e-12);
    }

    #[test]
    fn the_box_is_in_the_head_of_the_dump() {
        let text =
            "ITEM: TIMESTEP\n0\nITEM: BOX BOUNDS ff ff ff\n0 1\n-2 3.5e0\n4 5\nITEM: ATOMS id\n";
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(&file, text).unwrap();
        assert_eq!(
            box_of(file.path()).unwrap(),
            ([0.0, -2.0, 4.0], [1.0, 3.5, 5.0])
        );
        fs::write(&file, "ITEM: ATOMS").unwrap();
        assert!(box_of(file.path()).is_err());
    }
}
