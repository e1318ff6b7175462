// SPDX-License-Identifier: MIT OR Apache-2.0
//! Curves side by side in one SVG picture.

use std::path::Path;

use anyhow::{anyhow, Context, Result};
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

/// plotters rounds to whole units of the picture: a picture FINE times as large, shown at its own size, has smooth
/// curves.
const MOST_POINTS: usize = 400;
const FINE: u32 = 8;
const PANEL_WIDTH: u32 = 560 * FINE;
const HEIGHT: u32 = 460 * FINE;
const TITLE_HEIGHT: u32 = 44 * FINE;
/// Legend lines stand under the panel, so that they cover no curve.
const LEGEND_LINE: u32 = 20 * FINE;
const STROKE: u32 = 2 * FINE;

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
    let legend = LEGEND_LINE * lines.unwrap_or(0) as u32 + 10 * FINE;
    let size = (
        PANEL_WIDTH * panels.len() as u32,
        TITLE_HEIGHT + HEIGHT + legend,
    );
    let mut svg = String::new();
    draw_figure(&mut svg, size, title, panels)
        .map_err(|error| anyhow!("{}: {error}", path.display()))?;
    std::fs::write(path, shown_at_its_size(&svg, size))
        .with_context(|| format!("cannot write {}", path.display()))
}

fn draw_figure(svg: &mut String, size: (u32, u32), title: &str, panels: &[Panel]) -> Drawn {
    let root = SVGBackend::with_string(svg, size).into_drawing_area();
    root.fill(&WHITE)?;
    root.draw(&Text::new(
        title.to_string(),
        (size.0 as i32 / 2, 14 * FINE as i32),
        centred(18 * FINE as i32),
    ))?;
    let (_, below) = root.split_vertically(TITLE_HEIGHT);
    for (area, panel) in below.split_evenly((1, panels.len())).iter().zip(panels) {
        let (plot, key) = area.split_vertically(HEIGHT);
        draw_panel(&plot, panel)?;
        draw_legend(&key, panel)?;
    }
    root.present()
}

/// The first width and height of the text are those of the picture; its view box keeps the fine units.
fn shown_at_its_size(svg: &str, size: (u32, u32)) -> String {
    svg.replacen(
        &format!(r#"width="{}" height="{}""#, size.0, size.1),
        &format!(r#"width="{}" height="{}""#, size.0 / FINE, size.1 / FINE),
        1,
    )
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

fn draw_panel(area: &Area, panel: &Panel) -> Drawn {
    let x = range(panel, |point| point.0);
    let y = with_zero(range(panel, |point| point.1));
    let mut chart = ChartBuilder::on(area)
        .margin(12 * FINE)
        .margin_right(20 * FINE)
        .caption(&panel.title, ("sans-serif", 15 * FINE, &INK))
        .x_label_area_size(46 * FINE)
        .y_label_area_size(64 * FINE)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(GRID.stroke_width(FINE))
        .axis_style(INK.stroke_width(FINE))
        .set_all_tick_mark_size(5 * FINE)
        .x_labels(7)
        .y_labels(7)
        .x_label_formatter(&|value| number(*value))
        .y_label_formatter(&|value| number(*value))
        .label_style(("sans-serif", 13 * FINE, &INK))
        .axis_desc_style(("sans-serif", 14 * FINE, &INK))
        .x_desc(&panel.x_label)
        .y_desc(&panel.y_label)
        .draw()?;
    for curve in &panel.curves {
        // More would only make the file larger.
        let apart = curve.points.len().div_ceil(MOST_POINTS);
        let last = curve.points.last().copied();
        let points = curve
            .points
            .iter()
            .copied()
            .step_by(apart.max(1))
            .chain(last);
        let style = curve.colour.stroke_width(STROKE);
        if curve.dashed {
            chart.draw_series(DashedLineSeries::new(points, 6 * FINE, 5 * FINE, style))?;
        } else {
            chart.draw_series(LineSeries::new(points, style))?;
        }
    }
    Ok(())
}

fn draw_legend(area: &Area, panel: &Panel) -> Drawn {
    for (line, curve) in panel.curves.iter().enumerate() {
        let y = (LEGEND_LINE * line as u32 + LEGEND_LINE / 2) as i32;
        let style = curve.colour.stroke_width(STROKE);
        let strokes: &[(i32, i32)] = if curve.dashed {
            &[(80, 87), (92, 99), (104, 110)]
        } else {
            &[(80, 110)]
        };
        for &(from, to) in strokes {
            let (from, to) = (from * FINE as i32, to * FINE as i32);
            area.draw(&PathElement::new(vec![(from, y), (to, y)], style))?;
        }
        let style = TextStyle::from(("sans-serif", 13 * FINE as i32).into_font())
            .color(&INK)
            .pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(
            curve.label.clone(),
            (118 * FINE as i32, y),
            style,
        ))?;
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

/// From zero where the values are of one size, so that what hardly varies looks so.
fn with_zero(range: std::ops::Range<f64>) -> std::ops::Range<f64> {
    if range.start > 0.0 && range.start < 0.6 * range.end {
        0.0..range.end
    } else {
        range
    }
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
    fn an_axis_begins_at_zero_where_that_leaves_the_curves_apart() {
        assert_eq!(with_zero(240.0..650.0), 0.0..650.0);
        assert_eq!(with_zero(600.0..650.0), 600.0..650.0);
        assert_eq!(with_zero(-1.0..650.0), -1.0..650.0);
    }

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
