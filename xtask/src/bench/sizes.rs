// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a mixture of very different sizes costs in LAMMPS: a few large grains in a bed of small ones beside the small ones alone, for
//! ellipsoids and for the engine's own spheres, in turns, on one core.

use anyhow::{Context, Result};

use super::lammps_run::{timing, Lammps, Timing};
use super::statistics::{short, Measured};
use super::Effort;
use crate::demo::table::Table;
use crate::progress::Progress;

/// What runs: the word of the deck, and its name.
const STYLES: [(&str, &str); 2] = [
    ("ellipsoid", "gran/ellipsoid, nve/asphere"),
    ("sphere", "granular, spheres, nve/sphere"),
];

pub struct Costs {
    /// Diameter of the large grains over that of the small ones.
    ratio: usize,
    rows: Vec<Cost>,
}

struct Cost {
    name: &'static str,
    with_large: bool,
    grains: f64,
    /// Listed pairs per grain.
    listed: f64,
    /// Nanoseconds per grain and step.
    pair: Measured,
    step: Measured,
    /// The whole step over that of the small grains alone, both of one round.
    over_small: Measured,
}

pub fn run(lammps: &Lammps, effort: &Effort) -> Result<Costs> {
    let (ratio, warm, steps) = if effort.quick {
        (6, 10, 50)
    } else {
        (20, 100, 200)
    };
    let cases: Vec<_> = (STYLES.iter())
        .flat_map(|style| [(style, false), (style, true)])
        .collect();
    let mut found: Vec<Vec<Timing>> = cases.iter().map(|_| Vec::new()).collect();
    let mut progress = Progress::start("Sizes");
    for round in 0..effort.rounds {
        progress.update(Some(round as f64 / effort.rounds as f64), "mixtures");
        for (((atoms, _), large), runs) in cases.iter().zip(&mut found) {
            let words = [
                ("atoms", atoms.to_string()),
                ("ratio", ratio.to_string()),
                ("large", if *large { "yes" } else { "no" }.to_string()),
                ("warm", warm.to_string()),
                ("steps", steps.to_string()),
            ];
            runs.push(timing(&lammps.run("sizes.lmp", 1, None, &words)?)?);
        }
    }
    progress.finish();
    let mut rows = vec![];
    for (k, ((_, name), with_large)) in cases.iter().enumerate() {
        let measured = |of: &dyn Fn(usize) -> f64| {
            let values: Vec<f64> = (0..effort.rounds).map(of).collect();
            Measured::of(&values).context("no round was run")
        };
        let (own, small) = (&found[k], &found[k - usize::from(*with_large)]);
        let last = own.last().context("no round was run")?;
        rows.push(Cost {
            name,
            with_large: *with_large,
            grains: last.atoms,
            listed: last.pairs / last.atoms,
            pair: measured(&|r| own[r].per_grain(own[r].pair))?,
            step: measured(&|r| own[r].per_grain(own[r].step))?,
            over_small: measured(&|r| own[r].step / small[r].step)?,
        });
    }
    Ok(Costs { ratio, rows })
}

pub fn table(costs: &Costs) -> Table {
    let title = format!(
        "Sizes in LAMMPS: 27 large grains in a bed of small ones, diameters {} to 1, *neighbor multi*, lists built every 50 steps",
        costs.ratio
    );
    let mut table = Table::new(
        &title,
        &[
            "",
            "grains",
            "pairs listed per grain",
            "pair time, ns per grain and step",
            "whole step, ns per grain",
            "whole step over that of the small ones alone",
        ],
    );
    for row in &costs.rows {
        let which = if row.with_large {
            "all grains"
        } else {
            "the small ones alone"
        };
        table.row(vec![
            format!("{}: {which}", row.name),
            format!("{}", row.grains),
            short(row.listed),
            row.pair.show(),
            row.step.show(),
            if row.with_large {
                row.over_small.show()
            } else {
                String::new()
            },
        ]);
    }
    table
}

pub fn csv(costs: &Costs) -> String {
    let mut text =
        String::from("style,ratio,large,grains,pairs_per_grain,pair_ns,step_ns,step_over_small\n");
    for row in &costs.rows {
        text += &format!(
            "\"{}\",{},{},{},{},{},{},{}\n",
            row.name,
            costs.ratio,
            row.with_large,
            row.grains,
            row.listed,
            row.pair.median,
            row.step.median,
            row.over_small.median
        );
    }
    text
}
