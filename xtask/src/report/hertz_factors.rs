// SPDX-License-Identifier: MIT OR Apache-2.0
//! The picture of the Hertz factors.

use std::path::Path;

use anyhow::{ensure, Result};
use plotters::style::RGBColor;

use super::measurements::{scientific, Table};
use super::Section;
use crate::bench::statistics::short;
use crate::chart::{
    self, Line, Panel, Scale, Series, Shape, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION,
};
use crate::demo::table::Table as MarkdownTable;

pub const PICTURE: &str = "hertz-factors.svg";

/// Name in the measurements, in the legend, colour and shape.
const METHODS: [(&str, &str, RGBColor, Shape); 8] = [
    ("ours scalar", "ours, one at a time", BLUE, Shape::Circle),
    ("ours avx2", "ours, AVX2", BLUE, Shape::Triangle),
    ("ours avx512", "ours, AVX-512", BLUE, Shape::Diamond),
    (
        "iteration",
        "elliptic integrals, by Newton steps",
        GREEN,
        Shape::Square,
    ),
    ("Antoine", "Antoine et al. 2006", PURPLE, Shape::Square),
    ("Hale", "Hale 1999", VERMILION, Shape::Triangle),
    (
        "Brewe-Hamrock 1977",
        "Brewe and Hamrock 1977",
        ORANGE,
        Shape::Diamond,
    ),
    (
        "Hamrock-Brewe 1983",
        "Hamrock and Brewe 1983",
        SKY,
        Shape::Circle,
    ),
];

pub fn section(output: &Path) -> Result<Section> {
    let table = Table::read(&output.join("hertz-factors.csv"))?;
    let curves = Table::read(&output.join("hertz-factors-curves.csv"))?;
    let ours = |column: &str| {
        table.number(
            &[("method", "ours scalar"), ("smallest_axis_ratio", "0.001")],
            column,
        )
    };
    let of_hale = table.number(
        &[("method", "Hale"), ("smallest_axis_ratio", "0.1")],
        "largest_error",
    )?;
    // What is known of the formulas: a slip in one of them would show here.
    ensure!(ours("largest_error")? < 1e-12, "our fitted factor is off");
    ensure!(
        (1e-3..1e-2).contains(&of_hale),
        "Hale's form is off by {of_hale}, not by some thousandths"
    );
    let antoine = table.number(
        &[("method", "Antoine"), ("smallest_axis_ratio", "0.001")],
        "largest_error",
    )?;
    ensure!(
        antoine < 1e-5,
        "Antoine's form is off by {antoine}, not by some millionths"
    );
    draw(&output.join(PICTURE), &table, &curves)?;

    let fastest = METHODS[..3]
        .iter()
        .flat_map(|(name, ..)| table.of(&[("method", name), ("smallest_axis_ratio", "0.001")]))
        .map(|row| row.number("ns"))
        .fold(f64::INFINITY, f64::min);
    let quickest_of_others = table
        .of(&[("smallest_axis_ratio", "0.1")])
        .into_iter()
        .filter(|row| !row.word("method").starts_with("ours"))
        .min_by(|a, b| a.number("ns").total_cmp(&b.number("ns")));
    let quickest = match quickest_of_others {
        Some(row) => format!(
            "The quickest of the others ({}) takes {} ns and errs by up to {} for b/a ≥ 0.1.",
            row.word("method"),
            short(row.number("ns")),
            scientific(row.number("largest_error")),
        ),
        None => String::new(),
    };
    let text = format!(
        "**Conclusion.** Because the factor is a function of one variable, a fitted polynomial is exact to {} and takes {} ns, {} ns in \
         lanes. One at a time, only closed forms that err by per cents are quicker; in lanes nothing is. An iteration that is as exact takes more \
         than ten times as long. {quickest} \
         Hale's form has no value beyond B/A = 25 178 (b/a ≈ 0.0025).\n\n\
         The factor is F2^(-3/2), the force of an elliptical contact over that of a circular one of the same Gaussian curvature. Left: its largest \
         relative error against time, filled for b/a from 1 to 0.1, open for b/a from 1 to 0.001 (Hale's open symbol stands at 10: no \
         value). Right: its error along b/a; Hale's line ends where it has no value. The reference is the factor from the axis ratio through Carlson's integrals; the \
         iteration uses the arithmetic-geometric mean, so that the two agree to rounding is a check of both. The closed forms and the iteration start from the \
         ratio B/A, ours from trace and determinant of the curvature matrix, its logarithm included. They are B.J. Hamrock and D. Brewe's of 1977 \
         (J. Lubr. Technol. 99, 485) and 1983 (105, 171), J.-F. Antoine et al.'s axis ratio (J. Tribol. 128 (2006) 660) with the polynomials 17.3.34 and \
         17.3.36 of Abramowitz and Stegun for the integrals, and Hale's as Zheng et al. 2013 use it.\n",
        scientific(ours("largest_error")?),
        short(ours("ns")?),
        short(fastest),
    );
    Ok(Section {
        title: "Hertz factors",
        picture: PICTURE,
        text,
        tables: vec![markdown(&table)],
        files: vec!["hertz-factors.csv", "hertz-factors-curves.csv"],
    })
}

fn draw(path: &Path, table: &Table, curves: &Table) -> Result<()> {
    let mut against_time = Vec::new();
    let mut along = Vec::new();
    for (name, label, colour, shape) in METHODS {
        for (smallest, filled) in [("0.001", false), ("0.1", true)] {
            let rows = table.of(&[("method", name), ("smallest_axis_ratio", smallest)]);
            if rows.is_empty() {
                continue;
            }
            let point = |row: &super::measurements::Row| {
                let failed = row.number("share_without_value") > 0.0;
                let error = row.number("largest_error");
                (row.number("ns"), if failed { 10.0 } else { error })
            };
            let many = rows.len() > 1 && filled;
            against_time.push(Series {
                // The legend shows filled symbols.
                label: if filled { label.into() } else { String::new() },
                points: rows.iter().map(point).collect(),
                notes: if many {
                    rows.iter().map(|row| row.word("steps").into()).collect()
                } else {
                    Vec::new()
                },
                colour,
                shape,
                filled,
                line: if rows.len() > 1 && filled {
                    Line::Solid
                } else if rows.len() > 1 {
                    Line::Dashed
                } else {
                    Line::None
                },
            });
        }
        // The lanes' errors are those of the scalar function.
        let steps = match name {
            "ours avx2" | "ours avx512" => continue,
            "iteration" => "1",
            _ => "0",
        };
        along.push(Series {
            label: String::new(),
            points: curves
                .of(&[("method", name), ("steps", steps)])
                .iter()
                .filter(|row| row.number("error").is_finite())
                .map(|row| (row.number("axis_ratio"), row.number("error")))
                .collect(),
            notes: Vec::new(),
            colour,
            shape: Shape::None,
            filled: true,
            line: Line::Solid,
        });
    }
    // Open symbols first, so that filled ones cover them where both are one.
    against_time.sort_by_key(|series| series.filled);
    let panels = vec![
        Panel {
            title: "Largest error, filled: b/a ≥ 0.1, open: b/a ≥ 0.001".into(),
            x_label: "time of one factor (ns)".into(),
            y_label: "relative error of the force factor".into(),
            x: chart::range(
                against_time.iter().flat_map(|s| &s.points).map(|p| p.0),
                0.1,
            ),
            y: 1e-16..30.0,
            series: against_time,
            marks: Vec::new(),
            scale: Scale::Decades,
        },
        Panel {
            title: "Error along the axis ratio (iteration: one step)".into(),
            x_label: "axis ratio b/a of the contact ellipse".into(),
            y_label: "relative error of the force factor".into(),
            x: 1e-3..1.0,
            y: 1e-16..30.0,
            series: along,
            marks: Vec::new(),
            scale: Scale::Decades,
        },
    ];
    chart::draw(
        path,
        "The fitted Hertz factor is exact to rounding at about the price of the crudest closed form",
        &[panels],
    )
}

fn markdown(table: &Table) -> MarkdownTable {
    let mut out = MarkdownTable::new(
        "Force factor of an elliptical contact",
        &[
            "method",
            "ns",
            "largest error, b/a ≥ 0.1",
            "rms",
            "largest error, b/a ≥ 0.001",
            "rms",
        ],
    );
    for row in table.of(&[("smallest_axis_ratio", "0.1")]) {
        let (name, steps) = (row.word("method"), row.word("steps"));
        let wide = [
            ("method", name),
            ("steps", steps),
            ("smallest_axis_ratio", "0.001"),
        ];
        let wide = table.of(&wide).first().copied().unwrap_or(row);
        let none = wide.number("share_without_value") > 0.0;
        let or_none = |column: &str| {
            if none {
                "no value at some".into()
            } else {
                scientific(wide.number(column))
            }
        };
        let label = METHODS
            .iter()
            .find(|(method, ..)| *method == name)
            .map_or(name, |(_, label, ..)| label);
        out.row(vec![
            if name == "iteration" {
                format!("elliptic integrals, {steps} Newton steps")
            } else {
                label.to_string()
            },
            format!(
                "{} ± {}",
                short(row.number("ns")),
                short(row.number("ns_spread"))
            ),
            scientific(row.number("largest_error")),
            scientific(row.number("rms_error")),
            or_none("largest_error"),
            or_none("rms_error"),
        ]);
    }
    out
}
