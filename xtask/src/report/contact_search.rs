// SPDX-License-Identifier: MIT OR Apache-2.0
//! The picture of the contact search.

use std::path::Path;

use anyhow::{ensure, Result};
use plotters::style::RGBColor;

use super::measurements::{scientific, Row, Table};
use super::Section;
use crate::bench::statistics::short;
use crate::chart::{self, Line, Panel, Scale, Series, Shape, BLUE, GREEN, SKY, VERMILION};
use crate::demo::table::Table as MarkdownTable;

pub const PICTURE: &str = "contact-search.svg";

/// A method and a start: their names in the measurements, in the legend, and how they look.
struct Look {
    method: &'static str,
    start: &'static str,
    label: &'static str,
    colour: RGBColor,
    shape: Shape,
}

const fn look(
    method: &'static str,
    start: &'static str,
    label: &'static str,
    colour: RGBColor,
    shape: Shape,
) -> Look {
    Look {
        method,
        start,
        label,
        colour,
        shape,
    }
}

const LOOKS: [Look; 10] = [
    look(
        "support",
        "warm",
        "support functions, warm",
        BLUE,
        Shape::Circle,
    ),
    look(
        "support",
        "cold",
        "support functions, cold",
        BLUE,
        Shape::Circle,
    ),
    look(
        "support avx2",
        "warm",
        "the same, AVX2: 1, 2, 3 steps",
        SKY,
        Shape::Triangle,
    ),
    look(
        "support avx512",
        "warm",
        "the same, AVX-512: 1, 2, 3 steps",
        SKY,
        Shape::Diamond,
    ),
    look(
        "library",
        "warm",
        "the library, safeguarded, warm",
        BLUE,
        Shape::Diamond,
    ),
    look(
        "library",
        "cold",
        "the library, safeguarded, cold",
        BLUE,
        Shape::Diamond,
    ),
    look(
        "perram-wertheim",
        "warm",
        "Perram and Wertheim, warm",
        VERMILION,
        Shape::Square,
    ),
    look(
        "perram-wertheim",
        "cold",
        "Perram and Wertheim, cold",
        VERMILION,
        Shape::Square,
    ),
    look(
        "midway",
        "warm",
        "midway point, warm",
        GREEN,
        Shape::Triangle,
    ),
    look(
        "midway",
        "cold",
        "midway point, cold",
        GREEN,
        Shape::Triangle,
    ),
];

pub fn section(output: &Path) -> Result<Section> {
    let table = Table::read(&output.join("contact-search.csv"))?;
    let of = |aspect: &str, method: &str, start: &str, tolerance: &str, column: &str| {
        table.number(
            &[
                ("aspect_ratio", aspect),
                ("method", method),
                ("start", start),
                ("tolerance", tolerance),
            ],
            column,
        )
    };
    for aspect in ["2", "10"] {
        ensure!(
            of(aspect, "library", "cold", "0e0", "failed")? == 0.0
                && of(aspect, "library", "cold", "0e0", "overlap_error_rms")? < 1e-9,
            "the library's search misses contacts at aspect ratio {aspect}"
        );
        // Different definitions stay apart however far they are iterated.
        ensure!(
            of(
                aspect,
                "perram-wertheim",
                "warm",
                "1e-11",
                "normal_error_rms"
            )? > 1e-5,
            "Perram and Wertheim's normal is that of the minimal overlap"
        );
    }
    draw(&output.join(PICTURE), &table)?;
    let normal = |aspect| {
        of(
            aspect,
            "perram-wertheim",
            "warm",
            "1e-11",
            "normal_error_rms",
        )
    };
    let lanes = table
        .of(&[
            ("aspect_ratio", "2"),
            ("method", "support avx512"),
            ("tolerance", "2e0"),
        ])
        .first()
        .map_or(String::new(), |row| {
            format!(
                " In the lanes of AVX-512 two steps take {} ns a pair, and leave {} of the overlap and {} rad.",
                short(row.number("ns")),
                scientific(row.number("overlap_error_rms")),
                scientific(row.number("normal_error_rms"))
            )
        });
    let text = format!(
        "**Conclusion.** Warm, a step of Perram and Wertheim's search is the cheapest (one unknown), one of the midway point the dearest (four); what \
         separates the searches is what they converge to. Perram and \
         Wertheim's contact function and the midway point have one and the same normal, which is not that along which the overlap is least: \
         it is off by {} rad at aspect ratio 2 and by {} rad at 10 (root mean square), however tight the tolerance. The support functions \
         converge to the least overlap itself; at aspect ratio 2 Newton's second step is at rounding, at 10 the third: a looser tolerance buys little.{lanes} Where ours is not on \
         the lower-left edge: to its own limit Perram and Wertheim's search is quicker, warm and above all cold, than ours one at a time (cold, {} against {} ns at aspect ratio 10), and \
         the library's own search pays for its safeguards ({} ns warm, {} ns cold); in a running simulation cold starts are the contacts \
         that are new.\n\n\
         Pairs of equal prolate grains, made from a chosen normal and a chosen overlap of 1e-4 to 1e-2 of the small semi-axis, so that the least \
         overlap is known without a search. Warm: from the search's own result one step earlier, a step moving the grains by 1e-3 of the small semi-axis and turning \
         them by 1e-3. Points of a line: tolerances from 0.1 to 1e-11. Upper rows: error against the least overlap and its normal, which is \
         the model's and the iteration's together (root mean square); lowest row: the iteration's alone, against the method's own converged \
         normal. The overlap along Perram and Wertheim's normal is h_i + h_j - n.d, which errs in the second order only; that of the midway point \
         is the distance between both surfaces on the line through it. The methods: J.W. Perram and M.S. Wertheim, J. Comput. Phys. 58 (1985) 409; \
         G.T. Houlsby, Comput. Geotech. 36 (2009) 953, and A. Podlozhnyuk et al., Comput. Part. Mech. 4 (2017) 101, as for superquadrics. Preparation per grain (axes; shape matrices and their inverses) is not \
         counted for any of them.\n",
        scientific(normal("2")?),
        scientific(normal("10")?),
        short(of("10", "perram-wertheim", "cold", "1e-6", "ns")?),
        short(of("10", "support", "cold", "1e-6", "ns")?),
        short(of("10", "library", "warm", "0e0", "ns")?),
        short(of("10", "library", "cold", "0e0", "ns")?),
    );
    Ok(Section {
        title: "Contact search",
        picture: PICTURE,
        text,
        tables: vec![markdown(&table)],
        files: vec!["contact-search.csv"],
    })
}

fn draw(path: &Path, table: &Table) -> Result<()> {
    let mut rows = Vec::new();
    for (column, y_label) in [
        ("overlap_error_rms", "relative error of the overlap"),
        ("normal_error_rms", "error of the normal (rad)"),
        ("normal_own_rms", "normal against its own limit (rad)"),
    ] {
        let mut panels = Vec::new();
        for aspect in ["2", "10"] {
            let mut series = Vec::new();
            for look in &LOOKS {
                let mut found = table.of(&[
                    ("aspect_ratio", aspect),
                    ("method", look.method),
                    ("start", look.start),
                ]);
                if found.is_empty() {
                    continue;
                }
                // From loose to tight; the lanes count steps.
                let lanes = look.method.starts_with("support avx");
                found.sort_by(|a, b| {
                    let order = b.number("tolerance").total_cmp(&a.number("tolerance"));
                    if lanes {
                        order.reverse()
                    } else {
                        order
                    }
                });
                let cold = look.start == "cold";
                series.push(Series {
                    label: look.label.into(),
                    points: found
                        .iter()
                        .map(|row: &Row| (row.number("ns"), row.number(column)))
                        // The tightest tolerance is its own limit.
                        .filter(|(_, error)| *error > 0.0)
                        .collect(),
                    notes: Vec::new(),
                    colour: look.colour,
                    shape: look.shape,
                    filled: !cold,
                    line: match (look.method, cold) {
                        ("library", _) => Line::None,
                        (_, true) => Line::Dashed,
                        (_, false) => Line::Solid,
                    },
                });
            }
            panels.push(Panel {
                title: if column == "overlap_error_rms" {
                    format!("Aspect ratio {aspect}")
                } else {
                    String::new()
                },
                x_label: "time of one pair (ns)".into(),
                y_label: y_label.into(),
                x: chart::range(series.iter().flat_map(|s| &s.points).map(|p| p.0), 1.0),
                y: 1e-17..1e3,
                series,
                marks: Vec::new(),
                scale: Scale::Decades,
            });
        }
        rows.push(panels);
    }
    chart::draw(
        path,
        "Two steps on the support functions find the least overlap; other searches converge to another normal",
        &rows,
    )
}

fn markdown(table: &Table) -> MarkdownTable {
    let mut out = MarkdownTable::new(
        "Searches, by start and tolerance (more of them in the file)",
        &[
            "method and start",
            "aspect ratio",
            "tolerance",
            "ns",
            "failed (%)",
            "overlap error, rms",
            "normal error, rms (rad)",
            "overlap against own limit",
            "normal against own limit",
        ],
    );
    for row in table.rows() {
        let (method, start) = (row.word("method"), row.word("start"));
        // The file has them all.
        if ["1e-1", "1e-6", "1e-11"].contains(&row.word("tolerance")) {
            continue;
        }
        let label = LOOKS
            .iter()
            .find(|look| look.method == method && look.start == start)
            .map_or(method, |look| look.label);
        let tolerance = match method {
            "library" => "rounding".to_string(),
            "support avx2" | "support avx512" => {
                format!("{} steps", row.number("tolerance"))
            }
            _ => row.word("tolerance").to_string(),
        };
        out.row(vec![
            label.split(':').next().unwrap_or(label).to_string(),
            row.word("aspect_ratio").into(),
            tolerance,
            format!(
                "{} ± {}",
                short(row.number("ns")),
                short(row.number("ns_spread"))
            ),
            short(100.0 * row.number("failed")),
            scientific(row.number("overlap_error_rms")),
            scientific(row.number("normal_error_rms")),
            scientific(row.number("overlap_own_rms")),
            scientific(row.number("normal_own_rms")),
        ]);
    }
    out
}
