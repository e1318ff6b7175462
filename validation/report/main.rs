// SPDX-License-Identifier: MIT OR Apache-2.0
//! Error against run time: the measurements behind `cargo xtask report`, which draws them. What the library does stands beside
//! what the literature does, written here from its equations, built by the same compiler with the same options.
//!
//! `cargo bench --bench report -- [--quick] SECTION DIRECTORY` writes the section's CSV files into the directory.

mod collision;
mod contact_search;
mod hertz_factors;
mod literature;
mod midway_point;
mod numbers;
mod perram_wertheim;
mod search_lanes;
mod support_newton;
mod timing;
mod whole_force;

#[path = "../../benches/kernels/clock.rs"]
mod clock;
#[path = "../../tests/support/mod.rs"]
mod support;

use std::path::Path;
use std::process::ExitCode;

/// How long measurements take.
#[derive(Clone, Copy)]
pub struct Effort {
    /// Whether the measurements are made in their short form.
    pub quick: bool,
    /// Rounds of which the median is taken.
    pub rounds: usize,
    /// Of one round, s.
    pub seconds: f64,
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("report: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Outcome {
    let mut quick = false;
    let mut words = Vec::new();
    for word in std::env::args().skip(1) {
        match word.as_str() {
            "--quick" => quick = true,
            // cargo's own.
            "--bench" => {}
            _ => words.push(word),
        }
    }
    let effort = if quick {
        Effort {
            quick,
            rounds: 3,
            seconds: 5e-4,
        }
    } else {
        Effort {
            quick,
            rounds: 15,
            seconds: 4e-3,
        }
    };
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words[..] {
        ["hertz-factors", directory] => hertz_factors::run(Path::new(directory), &effort),
        ["contact-search", directory] => contact_search::run(Path::new(directory), &effort),
        ["whole-force", directory, pairs, effective_modulus] => whole_force::run(
            Path::new(directory),
            Path::new(pairs),
            effective_modulus.parse()?,
        ),
        ["time-step", directory] => collision::run(Path::new(directory), &effort),
        _ => Err("wanted: [--quick] hertz-factors|contact-search|time-step DIRECTORY, or whole-force DIRECTORY PAIRS MODULUS".into()),
    }
}
