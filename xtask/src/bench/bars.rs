// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bars in groups, on a logarithmic scale, as one SVG picture.

use std::path::Path;

use anyhow::{Context, Result};
use plotters::style::RGBColor;

pub struct Bar {
    pub group: String,
    pub label: String,
    pub value: f64,
    pub colour: RGBColor,
}

const LINE: f64 = 22.0;
const LEFT: f64 = 350.0;
const WIDTH: f64 = 520.0;

/// `title` is the conclusion to draw from the picture; `unit` names what the bars measure.
pub fn draw(path: &Path, title: &str, unit: &str, bars: &[Bar]) -> Result<()> {
    std::fs::write(path, svg(title, unit, bars))
        .with_context(|| format!("cannot write {}", path.display()))
}

fn svg(title: &str, unit: &str, bars: &[Bar]) -> String {
    let largest = bars.iter().map(|bar| bar.value).fold(1.0, f64::max);
    let smallest = bars.iter().map(|bar| bar.value).fold(largest, f64::min);
    let low = smallest.max(1e-9).log10().floor();
    let high = largest.log10().ceil().max(low + 1.0);
    let place = |value: f64| (value.max(1e-9).log10() - low) / (high - low) * WIDTH;
    let mut body = String::new();
    let mut y = 60.0;
    let mut group = "";
    for bar in bars {
        if bar.group != group {
            group = &bar.group;
            y += 0.6 * LINE;
            body += &text(12.0, y + 15.0, 14, "start", group);
            y += LINE;
        }
        let RGBColor(r, g, b) = bar.colour;
        body += &text(LEFT - 8.0, y + 15.0, 13, "end", &bar.label);
        body += &format!(
            "<rect x=\"{LEFT}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>\n",
            y + 3.0,
            place(bar.value).max(1.0),
            LINE - 6.0
        );
        body += &text(
            LEFT + place(bar.value) + 6.0,
            y + 15.0,
            12,
            "start",
            &super::statistics::short(bar.value),
        );
        y += LINE;
    }
    let bottom = y + 6.0;
    let mut grid = String::new();
    let mut power = low;
    while power <= high + 0.5 {
        let x = LEFT + place(10f64.powf(power));
        grid += &format!(
            "<line x1=\"{x:.1}\" y1=\"60\" x2=\"{x:.1}\" y2=\"{bottom:.1}\" stroke=\"#e4e4e4\"/>\n"
        );
        grid += &text(
            x,
            bottom + 16.0,
            12,
            "middle",
            &10f64.powf(power).to_string(),
        );
        power += 1.0;
    }
    let (width, height) = (LEFT + WIDTH + 70.0, bottom + 46.0);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height:.0}\" viewBox=\"0 0 {width} {height:.0}\" font-family=\"sans-serif\" fill=\"#333333\">\n<rect width=\"{width}\" height=\"{height:.0}\" fill=\"#ffffff\"/>\n{}{grid}{body}{}</svg>\n",
        text(width / 2.0, 28.0, 17, "middle", title),
        text(LEFT + WIDTH / 2.0, bottom + 36.0, 13, "middle", unit),
    )
}

fn text(x: f64, y: f64, size: u32, anchor: &str, words: &str) -> String {
    let words = words
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;");
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\">{words}</text>\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_ten_times_as_long_is_a_power_further() {
        let bar = |value: f64| Bar {
            group: "one <group>".into(),
            label: "a bar".into(),
            value,
            colour: RGBColor(1, 2, 3),
        };
        let picture = svg("title", "ns", &[bar(10.0), bar(100.0)]);
        assert!(picture.contains("width=\"520.0\""), "{picture}");
        assert!(picture.contains("one &lt;group&gt;"));
        assert!(picture.contains("fill=\"#010203\""));
    }
}
