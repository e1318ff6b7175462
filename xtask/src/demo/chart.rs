// SPDX-License-Identifier: MIT OR Apache-2.0
//! Curves side by side in one SVG picture.

use std::path::Path;

use anyhow::{anyhow, Result};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// One colour per law throughout the pictures, told apart in grey as well.
pub const OURS: RGBColor = RGBColor(0x1b, 0x4f, 0x9c);
pub const OURS_LIGHT: RGBColor = RGBColor(0x7a, 0xa6, 0xda);
pub const GRANULAR: RGBColor = RGBColor(0xc8, 0x5a, 0x17);
pub const SUPERELLIPSOID: RGBColor = RGBColor(0x2f, 0x7d, 0x5b);
pub const SUPERELLIPSOID_LIGHT: RGBColor = RGBColor(0x8b, 0xbf, 0xa3);
const INK: RGBColor = RGBColor(0x33, 0x33, 0x33);
const GRID: RGBColor = RGBColor(0xe4, 0xe4, 0xe4);

const PANEL_WIDTH: u32 = 560;
const HEIGHT: u32 = 460;
const TITLE_HEIGHT: u32 = 44;
const MOST_POINTS: usize = 160;
/// Legend lines stand under the panel, so that they cover no curve.
const LEGEND_LINE: i32 = 20;

pub struct Curve {
    pub label: String,
    pub points: Vec<(f64, f64)>,
    pub colour: RGBColor,
    /// Drawn over another curve that it should lie on.
    pub dashed: bool,
}

pub struct Panel {
    pub title: String,
    pub x_label: String,
    pub y_label: String,
    pub curves: Vec<Curve>,
}

/// `title` is the conclusion to draw from the picture.
pub fn draw(path: &Path, title: &str, panels: &[Panel]) -> Result<()> {
    let lines = panels.iter().map(|panel| panel.curves.len()).max();
    let legend = LEGEND_LINE * lines.unwrap_or(0) as i32 + 10;
    let size = (
        PANEL_WIDTH * panels.len() as u32,
        TITLE_HEIGHT + HEIGHT + legend as u32,
    );
    let failed = |error: &dyn std::fmt::Display| anyhow!("{}: {error}", path.display());
    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE).map_err(|error| failed(&error))?;
    root.draw(&Text::new(
        title.to_string(),
        (size.0 as i32 / 2, 14),
        centred(18),
    ))
    .map_err(|error| failed(&error))?;
    let (_, below) = root.split_vertically(TITLE_HEIGHT);
    for (area, panel) in below.split_evenly((1, panels.len())).iter().zip(panels) {
        let (plot, key) = area.split_vertically(HEIGHT);
        draw_panel(&plot, panel).map_err(|error| failed(&error))?;
        draw_legend(&key, panel).map_err(|error| failed(&error))?;
    }
    root.present().map_err(|error| failed(&error))
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

fn draw_panel(area: &Area, panel: &Panel) -> Drawn {
    let x = range(panel, |point| point.0);
    let y = range(panel, |point| point.1);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .margin_right(20)
        .caption(&panel.title, ("sans-serif", 15, &INK))
        .x_label_area_size(46)
        .y_label_area_size(64)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(GRID)
        .axis_style(INK)
        .x_labels(7)
        .y_labels(7)
        .x_label_formatter(&|value| number(*value))
        .y_label_formatter(&|value| number(*value))
        .label_style(("sans-serif", 13, &INK))
        .axis_desc_style(("sans-serif", 14, &INK))
        .x_desc(&panel.x_label)
        .y_desc(&panel.y_label)
        .draw()?;
    for curve in &panel.curves {
        // The picture has whole pixels: more points than every other one only make steps of a slope.
        let apart = curve.points.len().div_ceil(MOST_POINTS);
        let last = curve.points.last().copied();
        let points = curve
            .points
            .iter()
            .copied()
            .step_by(apart.max(1))
            .chain(last);
        let style = curve.colour.stroke_width(2);
        if curve.dashed {
            chart.draw_series(DashedLineSeries::new(points, 6, 5, style))?;
        } else {
            chart.draw_series(LineSeries::new(points, style))?;
        }
    }
    Ok(())
}

fn draw_legend(area: &Area, panel: &Panel) -> Drawn {
    for (line, curve) in panel.curves.iter().enumerate() {
        let y = LEGEND_LINE * line as i32 + LEGEND_LINE / 2;
        let style = curve.colour.stroke_width(2);
        let strokes: &[(i32, i32)] = if curve.dashed {
            &[(80, 87), (92, 99), (104, 110)]
        } else {
            &[(80, 110)]
        };
        for &(from, to) in strokes {
            area.draw(&PathElement::new(vec![(from, y), (to, y)], style))?;
        }
        let style = TextStyle::from(("sans-serif", 13).into_font())
            .color(&INK)
            .pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(curve.label.clone(), (118, y), style))?;
    }
    Ok(())
}

fn centred(size: i32) -> TextStyle<'static> {
    TextStyle::from(("sans-serif", size).into_font())
        .color(&INK)
        .pos(Pos::new(HPos::Center, VPos::Top))
}

fn range(panel: &Panel, of: impl Fn(&(f64, f64)) -> f64) -> std::ops::Range<f64> {
    let values = panel.curves.iter().flat_map(|curve| &curve.points).map(of);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if !low.is_finite() || low == high {
        return -1.0..1.0;
    }
    let margin = 0.04 * (high - low);
    low - margin..high + margin
}

/// An axis number without the noise of binary fractions.
fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".to_string()
    } else {
        text.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axis_numbers_are_short() {
        assert_eq!(number(0.1 + 0.2), "0.3");
        assert_eq!(number(-0.0), "0");
        assert_eq!(number(12.0), "12");
    }

    #[test]
    fn a_picture_holds_its_words() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("picture.svg");
        let panel = Panel {
            title: "two spheres".into(),
            x_label: "overlap (µm)".into(),
            y_label: "force (mN)".into(),
            curves: vec![Curve {
                label: "a law".into(),
                points: vec![(0.0, 0.0), (1.0, 2.0)],
                colour: OURS,
                dashed: true,
            }],
        };
        draw(&path, "what to conclude", &[panel]).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        for word in [
            "what to conclude",
            "two spheres",
            "overlap (µm)",
            "force (mN)",
            "a law",
        ] {
            assert!(text.contains(word), "{word}");
        }
    }
}
