// SPDX-License-Identifier: MIT OR Apache-2.0
//! Points and curves on plain or logarithmic axes, several panels in one SVG picture.

use std::ops::Range;
use std::path::Path;

use anyhow::{anyhow, Context, Result};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Okabe and Ito's colours, which colour-blind readers tell apart.
pub const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xb2);
pub const SKY: RGBColor = RGBColor(0x56, 0xb4, 0xe9);
pub const VERMILION: RGBColor = RGBColor(0xd5, 0x5e, 0x00);
pub const ORANGE: RGBColor = RGBColor(0xe6, 0x9f, 0x00);
pub const GREEN: RGBColor = RGBColor(0x00, 0x9e, 0x73);
pub const PURPLE: RGBColor = RGBColor(0xcc, 0x79, 0xa7);
pub const GREY: RGBColor = RGBColor(0x70, 0x70, 0x70);
/// One colour per law, told apart in grey as well.
pub const OURS: RGBColor = RGBColor(0x1b, 0x4f, 0x9c);
pub const OURS_LIGHT: RGBColor = RGBColor(0x7a, 0xa6, 0xda);
pub const GRANULAR: RGBColor = RGBColor(0xc8, 0x5a, 0x17);
pub const SUPERELLIPSOID: RGBColor = RGBColor(0x2f, 0x7d, 0x5b);
pub const SUPERELLIPSOID_LIGHT: RGBColor = RGBColor(0x8b, 0xbf, 0xa3);
const INK: RGBColor = RGBColor(0x33, 0x33, 0x33);
const GRID: RGBColor = RGBColor(0xe4, 0xe4, 0xe4);

/// plotters rounds to whole units of the picture: one FINE times as large, shown at its own size, is smooth.
const FINE: i32 = 8;
/// Of a curve; more would only make the file larger.
const MOST_POINTS: usize = 400;
const TITLE_HEIGHT: i32 = 40;
const LEGEND_LINE: i32 = 22;

#[derive(Clone, Copy, PartialEq)]
pub enum Shape {
    Circle,
    Square,
    Triangle,
    Diamond,
    /// A line alone.
    None,
}

#[derive(Clone, Copy, PartialEq)]
pub enum Line {
    None,
    Solid,
    Dashed,
}

/// Abscissa and ordinate of each point of a curve.
pub type Points = Vec<(f64, f64)>;

#[derive(Clone)]
pub struct Series {
    /// Series of the same label share a line of the legend.
    pub label: String,
    pub points: Points,
    /// A word beside each point, or none at all.
    pub notes: Vec<String>,
    pub colour: RGBColor,
    pub shape: Shape,
    pub filled: bool,
    pub line: Line,
}

impl Series {
    /// A line; dashed, it is seen over another that it should lie on.
    pub fn curve(label: &str, points: Points, colour: RGBColor, dashed: bool) -> Series {
        Series {
            label: label.into(),
            points,
            notes: Vec::new(),
            colour,
            shape: Shape::None,
            filled: false,
            line: if dashed { Line::Dashed } else { Line::Solid },
        }
    }
}

/// A vertical line across the panel.
pub struct Mark {
    pub x: f64,
    pub label: String,
}

#[derive(Clone, Copy, PartialEq)]
pub enum Scale {
    Plain,
    Decades,
}

pub struct Panel {
    pub title: String,
    pub x_label: String,
    pub y_label: String,
    /// Points beyond an end are drawn at it.
    pub x: Range<f64>,
    pub y: Range<f64>,
    pub series: Vec<Series>,
    pub marks: Vec<Mark>,
    pub scale: Scale,
}

impl Panel {
    /// Curves on plain axes that hold all of them.
    pub fn of_curves(title: &str, x_label: &str, y_label: &str, curves: Vec<Series>) -> Panel {
        let points = || curves.iter().flat_map(|curve| &curve.points);
        Panel {
            title: title.into(),
            x_label: x_label.into(),
            y_label: y_label.into(),
            x: ends(points().map(|point| point.0)),
            y: with_zero(ends(points().map(|point| point.1))),
            series: curves,
            marks: Vec::new(),
            scale: Scale::Plain,
        }
    }
}

fn ends(values: impl Iterator<Item = f64>) -> Range<f64> {
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
fn with_zero(range: Range<f64>) -> Range<f64> {
    if range.start > 0.0 && range.start < 0.6 * range.end {
        0.0..range.end
    } else {
        range
    }
}

/// Of one panel.
pub const PANEL: (i32, i32) = (520, 390);

/// Rows of panels; `title` is the conclusion to draw from the picture.
pub fn draw(path: &Path, title: &str, rows: &[Vec<Panel>]) -> Result<()> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(1) as i32;
    let keys = keys(rows);
    let key_rows = keys.iter().map(Vec::len).max().unwrap_or(0) as i32;
    let width = columns * PANEL.0;
    let height = TITLE_HEIGHT + rows.len() as i32 * PANEL.1 + key_rows * LEGEND_LINE + 14;
    let size = ((width * FINE) as u32, (height * FINE) as u32);
    let mut svg = String::new();
    draw_figure(&mut svg, size, title, rows, &keys)
        .map_err(|error| anyhow!("{}: {error}", path.display()))?;
    // The first width and height of the text are those of the picture; its view box keeps the fine units.
    let svg = svg.replacen(
        &format!(r#"width="{}" height="{}""#, size.0, size.1),
        &format!(r#"width="{width}" height="{height}""#),
        1,
    );
    std::fs::write(path, svg).with_context(|| format!("cannot write {}", path.display()))
}

/// The columns of the legend: the first series of each label. Where the curves of the panels of a row are others, those of a panel
/// stand below it.
fn keys(rows: &[Vec<Panel>]) -> Vec<Vec<Series>> {
    let of = |panels: &mut dyn Iterator<Item = &Panel>| {
        let mut keys: Vec<Series> = Vec::new();
        for series in panels.flat_map(|panel| &panel.series) {
            if !series.label.is_empty() && !keys.iter().any(|key| key.label == series.label) {
                keys.push(series.clone());
            }
        }
        keys
    };
    if let [row] = rows {
        if row.iter().all(|panel| panel.scale == Scale::Plain) {
            return row
                .iter()
                .map(|panel| of(&mut std::iter::once(panel)))
                .collect();
        }
    }
    let columns = if rows.iter().all(|row| row.len() == 1) {
        2
    } else {
        3
    };
    let all = of(&mut rows.iter().flatten());
    let lines = all.len().div_ceil(columns).max(1);
    all.chunks(lines).map(<[Series]>::to_vec).collect()
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

fn draw_figure(
    svg: &mut String,
    size: (u32, u32),
    title: &str,
    rows: &[Vec<Panel>],
    keys: &[Vec<Series>],
) -> Drawn {
    let root = SVGBackend::with_string(svg, size).into_drawing_area();
    root.fill(&WHITE)?;
    root.draw(&Text::new(
        title.to_string(),
        (size.0 as i32 / 2, 12 * FINE),
        text(17, HPos::Center, VPos::Top),
    ))?;
    let (_, mut below) = root.split_vertically(TITLE_HEIGHT * FINE);
    for row in rows {
        let (here, rest) = below.split_vertically(PANEL.1 * FINE);
        for (area, panel) in here.split_evenly((1, row.len())).iter().zip(row) {
            draw_panel(&root, area, panel)?;
        }
        below = rest;
    }
    let width = size.0 as i32 / keys.len().max(1) as i32;
    let lines = keys.iter().map(Vec::len).max().unwrap_or(0) as i32;
    let places = keys.iter().enumerate().flat_map(|(column, keys)| {
        let key = move |(line, key)| (column as i32, line as i32, key);
        keys.iter().enumerate().map(key)
    });
    for (column, line, key) in places {
        let (x, y) = (
            column * width + 30 * FINE,
            line * LEGEND_LINE * FINE + LEGEND_LINE / 2 * FINE,
        );
        let ends = [(x, y), (x + 34 * FINE, y)];
        match key.line {
            Line::None => {}
            Line::Solid => {
                below.draw(&PathElement::new(ends, key.colour.stroke_width(stroke())))?;
            }
            Line::Dashed => {
                for part in 0..3 {
                    let from = x + part * 13 * FINE;
                    let dash = [(from, y), (from + 8 * FINE, y)];
                    below.draw(&PathElement::new(dash, key.colour.stroke_width(stroke())))?;
                }
            }
        }
        let top = size.1 as i32 - (lines * LEGEND_LINE + 14) * FINE;
        symbol(&root, key, (x + 17 * FINE, top + y))?;
        below.draw(&Text::new(
            key.label.clone(),
            (x + 44 * FINE, y),
            text(13, HPos::Left, VPos::Center),
        ))?;
    }
    root.present()
}

fn stroke() -> u32 {
    2 * FINE as u32
}

fn text(size: i32, h: HPos, v: VPos) -> TextStyle<'static> {
    TextStyle::from(("sans-serif", size * FINE).into_font())
        .color(&INK)
        .pos(Pos::new(h, v))
}

fn draw_panel(root: &Area, area: &Area, panel: &Panel) -> Drawn {
    let fine = FINE as u32;
    let mut chart = ChartBuilder::on(area)
        .margin(10 * fine)
        .margin_right(18 * fine)
        .caption(&panel.title, ("sans-serif", 15 * fine, &INK))
        .x_label_area_size(44 * fine)
        .y_label_area_size(62 * fine)
        .build_cartesian_2d(
            Axis(panel.x.clone(), panel.scale),
            Axis(panel.y.clone(), panel.scale),
        )?;
    let light = match panel.scale {
        Scale::Plain => WHITE.stroke_width(0),
        Scale::Decades => GRID.mix(0.5).stroke_width(fine / 2),
    };
    let formatter = |value: &f64| match panel.scale {
        Scale::Plain => trimmed(*value, 3),
        Scale::Decades => number(*value),
    };
    chart
        .configure_mesh()
        .light_line_style(light)
        .x_labels(if panel.scale == Scale::Plain { 7 } else { 11 })
        .y_labels(if panel.scale == Scale::Plain { 7 } else { 11 })
        .x_label_formatter(&formatter)
        .y_label_formatter(&formatter)
        .bold_line_style(GRID.stroke_width(fine))
        .axis_style(INK.stroke_width(fine))
        .set_all_tick_mark_size(5 * fine)
        .label_style(("sans-serif", 13 * fine, &INK))
        .axis_desc_style(("sans-serif", 14 * fine, &INK))
        .x_desc(&panel.x_label)
        .y_desc(&panel.y_label)
        .draw()?;
    let inside = |(x, y): (f64, f64)| {
        (
            x.clamp(panel.x.start, panel.x.end),
            y.clamp(panel.y.start, panel.y.end),
        )
    };
    for (number, mark) in panel.marks.iter().enumerate() {
        let line = [(mark.x, panel.y.start), (mark.x, panel.y.end)];
        chart.draw_series(DashedLineSeries::new(
            line,
            2 * fine,
            3 * fine,
            INK.stroke_width(fine),
        ))?;
        // One below the other, so that neighbours do not collide.
        let depth = (panel.y.end / panel.y.start).powf(-0.035 - 0.055 * number as f64);
        chart.draw_series(std::iter::once(
            EmptyElement::at((mark.x, panel.y.end * depth))
                + Text::new(
                    mark.label.clone(),
                    (4 * FINE, 0),
                    text(12, HPos::Left, VPos::Center),
                ),
        ))?;
    }
    for series in &panel.series {
        let apart = series.points.len().div_ceil(MOST_POINTS).max(1);
        let last = series.points.last().filter(|_| apart > 1);
        let kept = series.points.iter().step_by(apart).chain(last);
        let points: Points = kept.copied().map(inside).collect();
        let style = series.colour.stroke_width(stroke());
        match series.line {
            Line::None => {}
            Line::Solid => {
                chart.draw_series(LineSeries::new(points.clone(), style))?;
            }
            Line::Dashed => {
                chart.draw_series(DashedLineSeries::new(
                    points.clone(),
                    7 * fine,
                    4 * fine,
                    style,
                ))?;
            }
        }
        for (number, point) in points.iter().enumerate() {
            symbol(root, series, chart.backend_coord(point))?;
            if let Some(note) = series.notes.get(number) {
                chart.draw_series(std::iter::once(
                    EmptyElement::at(*point)
                        + Text::new(
                            note.clone(),
                            (-8 * FINE, 2 * FINE),
                            text(12, HPos::Right, VPos::Center),
                        ),
                ))?;
            }
        }
    }
    Ok(())
}

/// A point's symbol around a place of the whole picture.
fn symbol(root: &Area, series: &Series, (x, y): (i32, i32)) -> Drawn {
    let outline = series.colour.stroke_width(stroke());
    let inside = if series.filled { series.colour } else { WHITE };
    let corners: &[(i32, i32)] = match series.shape {
        Shape::None => return Ok(()),
        Shape::Circle => {
            let radius = 9 * FINE / 2;
            root.draw(&Circle::new((x, y), radius, inside.filled()))?;
            return root.draw(&Circle::new((x, y), radius, outline));
        }
        Shape::Square => &[(-8, -8), (8, -8), (8, 8), (-8, 8), (-8, -8)],
        Shape::Triangle => &[(0, -10), (10, 8), (-10, 8), (0, -10)],
        Shape::Diamond => &[(0, -11), (11, 0), (0, 11), (-11, 0), (0, -11)],
    };
    let path: Vec<(i32, i32)> = corners
        .iter()
        .map(|(dx, dy)| (x + dx * FINE / 2, y + dy * FINE / 2))
        .collect();
    root.draw(&Polygon::new(path.clone(), inside.filled()))?;
    root.draw(&PathElement::new(path, outline))
}

/// A logarithmic one is labelled at powers of ten (at 1, 2, 5 where there are few).
struct Axis(Range<f64>, Scale);

impl Ranged for Axis {
    type ValueType = f64;
    type FormatOption = NoDefaultFormatting;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        if self.1 == Scale::Plain {
            return RangedCoordf64::from(self.0.clone()).map(value, limit);
        }
        let share = (value / self.0.start).ln() / (self.0.end / self.0.start).ln();
        limit.0 + (f64::from(limit.1 - limit.0) * share).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if self.1 == Scale::Plain {
            return RangedCoordf64::from(self.0.clone()).key_points(hint);
        }
        let (low, high) = (self.0.start.log10(), self.0.end.log10());
        let decades = (high - low).max(0.1);
        let within = |value: f64| value >= self.0.start * 0.999 && value <= self.0.end * 1.001;
        let multiples: &[f64] = if !hint.weight().allow_light_points() {
            if decades < 2.6 {
                &[1.0, 2.0, 5.0]
            } else {
                &[1.0]
            }
        } else if decades < 4.0 {
            &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]
        } else {
            &[1.0]
        };
        let apart = if multiples.len() > 1 {
            1
        } else {
            (decades / 9.0).ceil() as i32
        };
        let first = low.floor() as i32;
        (first..=high.ceil() as i32)
            .filter(|power| power.rem_euclid(apart) == 0)
            .flat_map(|power| multiples.iter().map(move |m| m * 10f64.powi(power)))
            .filter(|value| within(*value))
            .collect()
    }

    fn range(&self) -> Range<f64> {
        self.0.clone()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format(value: &f64) -> String {
        number(*value)
    }
}

/// Without the noise of binary fractions.
fn trimmed(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    text.strip_prefix("-0")
        .filter(|rest| rest.is_empty())
        .map_or(text, |_| "0")
        .to_string()
}

/// 0.01 to 5000 as they are, beyond as powers of ten.
fn number(value: f64) -> String {
    if (0.0099..9999.0).contains(&value) {
        return trimmed(value, 2);
    }
    let power = (value.log10() + 1e-9).floor() as i32;
    let first = value / 10f64.powi(power);
    let power: String = power
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
        })
        .collect();
    if (first - 1.0).abs() < 1e-6 {
        format!("10{power}")
    } else {
        format!("{first:.0}·10{power}")
    }
}

/// A range that holds all numbers of the series, widened to the next nice ends.
pub fn range(values: impl IntoIterator<Item = f64>, floor: f64) -> Range<f64> {
    let (mut low, mut high) = (f64::INFINITY, floor);
    for value in values {
        if value.is_finite() && value > 0.0 {
            low = low.min(value.max(floor));
            high = high.max(value);
        }
    }
    if !low.is_finite() {
        return 0.1..1.0;
    }
    low / 1.4..high * 1.6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(0.02), "0.02");
        assert_eq!(number(1000.0), "1000");
        assert_eq!(number(1e-13), "10⁻¹³");
        assert_eq!(number(2e5), "2·10⁵");
        assert_eq!(trimmed(0.1 + 0.2, 3), "0.3");
        assert_eq!(trimmed(-0.0, 3), "0");
        assert_eq!(trimmed(-12.0, 3), "-12");
    }

    #[test]
    fn an_axis_begins_at_zero_where_that_leaves_the_curves_apart() {
        assert_eq!(with_zero(240.0..650.0), 0.0..650.0);
        assert_eq!(with_zero(600.0..650.0), 600.0..650.0);
        assert_eq!(with_zero(-1.0..650.0), -1.0..650.0);
    }

    #[test]
    fn a_picture_holds_its_words() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("picture.svg");
        let panel = Panel {
            title: "two methods".into(),
            x_label: "time (ns)".into(),
            y_label: "error".into(),
            x: 1.0..1e3,
            y: 1e-15..1.0,
            series: vec![Series {
                label: "a method".into(),
                points: vec![(2.0, 1e-3), (20.0, 0.0)],
                notes: vec!["one".into()],
                colour: BLUE,
                shape: Shape::Diamond,
                filled: true,
                line: Line::Dashed,
            }],
            marks: vec![Mark {
                x: 10.0,
                label: "limit".into(),
            }],
            scale: Scale::Decades,
        };
        let curve = Series::curve("a law", vec![(0.0, 0.0), (1.0, 2.0)], OURS, true);
        let plain = Panel::of_curves("two spheres", "overlap (µm)", "force (mN)", vec![curve]);
        draw(&path, "what to conclude", &[vec![panel], vec![plain]]).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        for word in [
            "what to conclude",
            "two methods",
            "time (ns)",
            "a method",
            "limit",
            "one",
            "two spheres",
            "overlap (µm)",
            "force (mN)",
            "a law",
        ] {
            assert!(text.contains(word), "{word}");
        }
        assert!(!text.contains("NaN"));
    }
}
