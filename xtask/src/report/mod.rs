// SPDX-License-Identifier: MIT OR Apache-2.0
//! Error against run time: what accuracy costs, beside what the literature and the engines do. A page, pictures, numbers.

mod contact_search;
mod hertz_factors;
mod machine;
mod measurements;
mod time_step;
mod whole_force;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{bail, Context, Result};

use crate::demo::table::Table;
use crate::progress::{human_time, say};
use crate::validate::{self, Comparison};
use crate::workspace;

#[derive(clap::Args)]
pub struct Options {
    /// Few pairs, short measurements: under a minute once engines and packings are there
    #[arg(long)]
    quick: bool,
    /// Only this picture (repeat for more) [default: all]
    #[arg(long)]
    picture: Vec<Picture>,
    /// A chapter of `cargo xtask validate` instead (repeat for more)
    #[arg(long, conflicts_with_all = ["quick", "picture", "output"])]
    chapter: Vec<Comparison>,
    /// Where page, pictures and numbers go [default: docs/report, with --quick report-output in the checkout]
    #[arg(long)]
    output: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub enum Picture {
    HertzFactors,
    ContactSearch,
    WholeForce,
    TimeStep,
}

impl Picture {
    const ALL: [Picture; 4] = [
        Picture::HertzFactors,
        Picture::ContactSearch,
        Picture::WholeForce,
        Picture::TimeStep,
    ];

    /// Its name on the command line and among the measurements.
    fn name(self) -> &'static str {
        match self {
            Picture::HertzFactors => "hertz-factors",
            Picture::ContactSearch => "contact-search",
            Picture::WholeForce => "whole-force",
            Picture::TimeStep => "time-step",
        }
    }

    fn needs_engines(self) -> bool {
        self == Picture::WholeForce
    }
}

/// What one picture adds to the page.
pub struct Section {
    pub title: &'static str,
    pub picture: &'static str,
    /// What to conclude, and how it was taken.
    pub text: String,
    pub tables: Vec<Table>,
    pub files: Vec<&'static str>,
}

pub fn report(options: &Options) -> Result<()> {
    if !options.chapter.is_empty() {
        return validate::make(&options.chapter, false, &[]);
    }
    let output = match &options.output {
        Some(output) => output.clone(),
        None if options.quick => workspace::root().join("report-output"),
        None => workspace::root().join("docs/report"),
    };
    let pictures = if options.picture.is_empty() {
        Picture::ALL.to_vec()
    } else {
        options.picture.clone()
    };
    run(&output, options.quick, &pictures)
}

/// For the tests: the pictures that need engines, or the others, shortly, and whether all is there.
pub fn quick(output: &Path, engines: bool) -> Result<()> {
    let pictures: Vec<Picture> = Picture::ALL
        .into_iter()
        .filter(|picture| engines == picture.needs_engines())
        .collect();
    run(output, true, &pictures)?;
    let page = fs::read_to_string(output.join("README.md"))?;
    for picture in &pictures {
        let name = picture.name();
        for file in [format!("{name}.svg"), format!("{name}.csv")] {
            let text = fs::read_to_string(output.join(&file))
                .with_context(|| format!("the report left no {file}"))?;
            if text.contains("NaN") || text.contains("inf") {
                bail!("{file} holds what is no number");
            }
            if !page.contains(&file) {
                bail!("the page does not name {file}");
            }
        }
    }
    Ok(())
}

fn run(output: &Path, quick: bool, pictures: &[Picture]) -> Result<()> {
    let started = Instant::now();
    fs::create_dir_all(output).with_context(|| format!("cannot make {}", output.display()))?;
    let output = output.canonicalize()?;
    let before = crate::bench::machine::load();
    let mut sections = Vec::new();
    for picture in Picture::ALL {
        if !pictures.contains(&picture) {
            continue;
        }
        let name = picture.name();
        let taken = match picture {
            Picture::WholeForce => whole_force::take(&output, quick),
            _ => measurements::take(name, &output, quick, &[]),
        };
        taken.with_context(|| format!("the picture {name}"))?;
        let section = match picture {
            Picture::HertzFactors => hertz_factors::section(&output),
            Picture::ContactSearch => contact_search::section(&output),
            Picture::WholeForce => whole_force::section(&output),
            Picture::TimeStep => time_step::section(&output),
        };
        sections.push(section.with_context(|| format!("the picture {name}"))?);
        say(format!("wrote {name}.svg"));
    }
    let mut text = String::from("# Error against run time\n\n");
    text += "What accuracy costs, beside what the literature and the engines do: each picture shows an error against the processor time that it takes, \
             both logarithmic, so that the lower left is where to be.\n\n";
    text += "Written by `cargo xtask report";
    if quick {
        text += " --quick";
    }
    for picture in pictures {
        if pictures.len() < Picture::ALL.len() {
            text += &format!(" --picture {}", picture.name());
        }
    }
    text += &format!("` in {}.\n\n", human_time(started.elapsed()));
    if quick {
        text += "**Short measurements of few pairs (`--quick`): not to be quoted.**\n\n";
    }
    for section in &sections {
        text += &format!("## {}\n\n", section.title);
        text += &format!("![{0}]({0})\n\n", section.picture);
        text += &section.text;
        for table in &section.tables {
            text += "\n";
            text += &table.markdown();
        }
        let files: Vec<String> = section
            .files
            .iter()
            .map(|file| format!("[{file}]({file})"))
            .collect();
        text += &format!("\nThe numbers: {}.\n\n", files.join(", "));
    }
    text += "## The machine\n\n";
    for line in machine::describe(before) {
        text += &format!("- {line}\n");
    }
    text += "\nTimes are processor times, one core, the median of several rounds, which other programs on the machine disturb little; ± is half the \
             distance between the quartiles. The comparison methods are written from their equations (`validation/report/`), built by the same \
             compiler with the same options as the library.\n";
    fs::write(output.join("README.md"), &text)?;
    println!("{text}");
    say(format!(
        "the report is {}",
        output.join("README.md").display()
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::Picture;
    use clap::ValueEnum;

    #[test]
    fn pictures_are_named_alike_everywhere() {
        for picture in Picture::ALL {
            let value = picture.to_possible_value().unwrap();
            assert_eq!(value.get_name(), picture.name());
        }
    }
}
