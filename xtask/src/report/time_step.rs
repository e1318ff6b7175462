// SPDX-License-Identifier: MIT OR Apache-2.0
//! The picture of the time step.

use std::path::Path;

use anyhow::{ensure, Result};
use plotters::style::RGBColor;

use super::measurements::{scientific, Table};
use super::Section;
use crate::bench::statistics::short;
use crate::chart::{
    self, Line, Mark, Panel, Scale, Series, Shape, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY,
    VERMILION,
};
use crate::demo::table::Table as MarkdownTable;

pub const PICTURE: &str = "time-step.svg";

const LAWS: [(&str, &str, RGBColor, Shape); 7] = [
    ("hertz", "Hertz, conservative", BLUE, Shape::Circle),
    (
        "hertz conservative no",
        "Hertz, force along the normal only",
        VERMILION,
        Shape::Square,
    ),
    ("nfd", "NFD (viscoelastic)", GREEN, Shape::Triangle),
    (
        "nfd with friction",
        "NFD with friction (TFD)",
        ORANGE,
        Shape::Diamond,
    ),
    (
        "nfd of the step",
        "NFD, velocities of the step",
        PURPLE,
        Shape::Triangle,
    ),
    (
        "nfd with friction of the step",
        "TFD, velocities of the step",
        GREY,
        Shape::Diamond,
    ),
    ("lsd", "linear spring", SKY, Shape::Circle),
];

pub fn section(output: &Path) -> Result<Section> {
    let table = Table::read(&output.join("time-step.csv"))?;
    let limits = Table::read(&output.join("time-step-limits.csv"))?;
    let error = |law: &str, steps: &str| {
        table.number(
            &[("law", law), ("steps_per_contact", steps)],
            "energy_error_rms",
        )
    };
    let limit = |law: &str| limits.number(&[("law", law)], "limit_over_contact_time");
    let plain = error("hertz conservative no", "1000")?;
    ensure!(
        error("hertz", "1000")? < 0.01 * plain,
        "the conservative law does not keep the energy"
    );
    ensure!(
        error("hertz", "1000")? < 0.01 * error("hertz", "50")?,
        "the energy error does not fall with the step"
    );
    ensure!(
        error("nfd of the step", "1000")? < 0.2 * error("nfd", "1000")?,
        "velocities of the step do not make the viscous law's error fall faster"
    );
    let frequency = limits.number(&[("law", "hertz")], "limit_times_frequency")?;
    ensure!(
        (frequency - 2.0).abs() < 0.02,
        "velocity Verlet's limit is 2 over the angular frequency, not {frequency}"
    );
    draw(&output.join(PICTURE), &table, &limits)?;
    let text = format!(
        "**Conclusion.** The energy error of an elastic collision falls with the square of the step and faster when the law is a gradient: {} of it is \
         lost or gained at T/20, {} at T/100. With the force along the normal alone, as in the engines' own styles, it stops at {} whatever the step. The viscoelastic \
         law converges in the first order where forces see velocities of the half step, as with the engines' own integrators; its error at T/50 ({}) is smaller than that of \
         the plain force. With velocities of the step, as LAMMPS' `fix nve/ellipsoid` hands them out, it converges in the second: {} at T/100 in place of {}, with friction {} in place of {}. \
         Time is steps: no law's step costs more than {} % above the cheapest; the linear spring saves nothing, and at the same step errs more than Hertz, since its \
         stiffness begins with a jump.\n\n\
         The stability limit, measured on a grain that rests on a wall under a load that gives the same overlap: {} T for Hertz (velocity Verlet's 2 over the angular \
         frequency of the contact), {} T with viscosity, {} T with friction, whose tangential and rolling motion is faster. Rayleigh's time of a sphere of this volume is {} T \
         at this overlap; it does not know the speed of the impact, and the usual 10 to 30 % of it is on the safe side here, as are T/20 to T/50.\n\n\
         Collisions of two grains of aspect ratio 2, oblique, at random orientations and with first touch anywhere within a step; largest overlap, head-on, 2 % of the small \
         semi-axis; T is the Hertzian contact time of a head-on collision. Energy error: of the kinetic energy after the collision, over that before, root mean square; \
         for the viscous laws \
         the error is taken against T/16000 (T/4000 with `--quick`). Forces by the library's one-contact path, motion by velocity Verlet with a \
         symplectic rotation (that of the tests); processor time of both, per contact time. An engine's neighbour list runs the same law in lanes at a fraction of that.\n",
        scientific(error("hertz", "20")?),
        scientific(error("hertz", "100")?),
        scientific(plain),
        scientific(error("nfd", "50")?),
        scientific(error("nfd of the step", "100")?),
        scientific(error("nfd", "100")?),
        scientific(error("nfd with friction of the step", "100")?),
        scientific(error("nfd with friction", "100")?),
        short(dearest(&table)),
        two(limit("hertz")?),
        two(limit("nfd")?),
        two(limit("nfd with friction")?),
        two(limit("rayleigh")?),
    );
    Ok(Section {
        title: "Time step",
        picture: PICTURE,
        text,
        tables: vec![markdown(&table), limits_table(&limits)],
        files: vec!["time-step.csv", "time-step-limits.csv"],
    })
}

fn two(value: f64) -> String {
    format!("{value:.2}")
}

/// By how many per cent the dearest law's step is dearer than the cheapest one's.
fn dearest(table: &Table) -> f64 {
    let times: Vec<f64> = table
        .of(&[("steps_per_contact", "200")])
        .iter()
        .map(|row| row.number("ns_per_step"))
        .collect();
    let most = times.iter().copied().fold(0.0, f64::max);
    let least = times.iter().copied().fold(f64::INFINITY, f64::min);
    100.0 * (most / least - 1.0)
}

fn draw(path: &Path, table: &Table, limits: &Table) -> Result<()> {
    let of = |column: &'static str, scale: f64| -> Vec<Series> {
        LAWS.iter()
            .map(|(name, label, colour, shape)| Series {
                label: (*label).into(),
                points: table
                    .of(&[("law", name)])
                    .iter()
                    .map(|row| (row.number(column) * scale, row.number("energy_error_rms")))
                    .collect(),
                notes: Vec::new(),
                colour: *colour,
                shape: *shape,
                filled: *name != "lsd",
                line: if *name == "lsd" {
                    Line::Dashed
                } else {
                    Line::Solid
                },
            })
            .collect()
    };
    let limit = |law: &str| limits.number(&[("law", law)], "limit_over_contact_time");
    let by_steps = of("steps_per_contact", 1.0);
    let by_time = of("ns_per_contact", 1e-3);
    // What a step costs, to place the limit on the axis of time.
    let step = table.number(
        &[("law", "hertz"), ("steps_per_contact", "200")],
        "ns_per_step",
    )?;
    let hertz = limit("hertz")?;
    let friction = limit("nfd with friction")?;
    let panels = vec![
        Panel {
            title: "Against processor time".into(),
            x_label: "time per contact (µs)".into(),
            y_label: "energy error of a collision".into(),
            x: 1e-3 * step
                ..1.5
                    * by_time
                        .iter()
                        .flat_map(|s| &s.points)
                        .map(|p| p.0)
                        .fold(0.0, f64::max),
            y: 1e-9..0.2,
            series: by_time,
            scale: Scale::Decades,
            marks: vec![
                Mark {
                    x: 1e-3 * step / hertz,
                    label: "stability limit, Hertz".into(),
                },
                Mark {
                    x: 1e-3 * step / friction,
                    label: "with friction".into(),
                },
            ],
        },
        Panel {
            title: "Against the step".into(),
            x_label: "steps per contact time T".into(),
            y_label: "energy error of a collision".into(),
            x: 1.0..1500.0,
            y: 1e-9..0.2,
            series: by_steps,
            scale: Scale::Decades,
            marks: vec![
                Mark {
                    x: 1.0 / hertz,
                    label: "measured limit, Hertz".into(),
                },
                Mark {
                    x: 1.0 / friction,
                    label: "measured limit, with friction".into(),
                },
                Mark {
                    x: 5.0 / limit("rayleigh")?,
                    label: "20 % of Rayleigh's time".into(),
                },
                Mark {
                    x: 50.0,
                    label: "T/50, rule of thumb".into(),
                },
            ],
        },
    ];
    chart::draw(
        path,
        "The conservative law's energy error falls with the step; the plain normal force's does not",
        &[panels],
    )
}

fn markdown(table: &Table) -> MarkdownTable {
    let mut out = MarkdownTable::new(
        "Energy error by law and step",
        &[
            "law",
            "steps per contact time",
            "energy error, rms",
            "largest",
            "ns per step",
            "µs per contact time",
        ],
    );
    for row in table.rows() {
        let name = row.word("law");
        let label = LAWS
            .iter()
            .find(|(law, ..)| *law == name)
            .map_or(name, |(_, label, ..)| label);
        out.row(vec![
            label.to_string(),
            row.word("steps_per_contact").into(),
            scientific(row.number("energy_error_rms")),
            scientific(row.number("energy_error_largest")),
            short(row.number("ns_per_step")),
            short(1e-3 * row.number("ns_per_contact")),
        ]);
    }
    out
}

fn limits_table(limits: &Table) -> MarkdownTable {
    let mut out = MarkdownTable::new(
        "Largest stable step",
        &["law", "times angular frequency", "over contact time T"],
    );
    for row in limits.rows() {
        let name = row.word("law");
        let label = LAWS.iter().find(|(law, ..)| *law == name).map_or(
            "Rayleigh's time (bound of the literature, whole)",
            |(_, label, ..)| label,
        );
        out.row(vec![
            label.to_string(),
            row.word("limit_times_frequency").into(),
            row.word("limit_over_contact_time").into(),
        ]);
    }
    out
}
