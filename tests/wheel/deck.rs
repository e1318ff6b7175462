// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does the README's deck run through the stock LAMMPS, without `plugin load`, and move the grains as a build from source does?

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::engines::dump::tables;
use crate::engines::printed::{blocks, page};
use crate::engines::process::{execute, last_lines};
use crate::stock::{fresh_directory, from_source, stock};

/// Positions, quaternion and diameters of each grain, frame by frame.
pub type Frames = Vec<BTreeMap<u64, Vec<f64>>>;

/// The README's deck for `steps`, its dump in full precision, without its line that loads the plugin.
pub fn deck(steps: u32) -> String {
    let dump = "dump grains all custom 2000 grains.dump id type x y z c_quat[*] c_shape[*]\n";
    let text = &blocks(&page("README.md"), "lammps")[0];
    let plugin = text.lines().find(|line| line.starts_with("plugin load"));
    let text = text.replace(plugin.expect("plugin load"), "");
    assert!(text.contains(dump) && text.contains("run 20000\n"));
    text.replace(
        dump,
        &format!("{dump}dump_modify grains format float %.17g\n"),
    )
    .replace("run 20000\n", &format!("run {steps}\n"))
}

pub fn frames(directory: &Path) -> Frames {
    let text = fs::read_to_string(directory.join("grains.dump")).expect("a dump");
    let tables = tables(&text).expect("a dump").into_iter();
    let by_identifier = |row: Vec<f64>| (row[0] as u64, row[2..].to_vec());
    tables
        .map(|table| table.rows.into_iter().map(by_identifier).collect())
        .collect()
}

/// The largest difference of any number in any frame.
pub fn difference(one: &Frames, other: &Frames) -> f64 {
    assert_eq!(one.len(), other.len());
    let mut largest = 0.0_f64;
    for (a, b) in one.iter().zip(other) {
        assert_eq!(a.len(), b.len());
        for (id, values) in a {
            for (x, y) in values.iter().zip(&b[id]) {
                assert!(x.is_finite() && y.is_finite());
                largest = largest.max((x - y).abs());
            }
        }
    }
    largest
}

/// Positions in metres in a box of 0.04, components of quaternions: both to 1e-12. The stock LAMMPS is another release, by another
/// compiler; over these steps both integrate by the same operations, and were seen to give the same bits.
#[test]
fn the_deck_moves_as_in_the_build_from_source() {
    let here = fresh_directory("stock");
    let (success, output) = stock().lmp(&here, &deck(20_000), 1);
    assert!(success, "{}", last_lines(&output));
    let (lammps, plugin) = from_source();
    let there = fresh_directory("source");
    let text = format!("plugin load {}\n{}", plugin.display(), deck(20_000));
    let (success, output) = execute(&lammps, &["-nocite"], Path::new(""), &there, &text, 1);
    assert!(success, "{}", last_lines(&output));
    let (here, there) = (frames(&here), frames(&there));
    assert_eq!((here.len(), here[0].len()), (11, 250));
    let moved = difference(&here[..1].to_vec(), &here[10..].to_vec());
    let largest = difference(&here, &there);
    println!("grains moved by up to {moved}, the two runs differ by up to {largest:e}");
    assert!(moved > 0.01);
    assert!(largest < 1e-12, "{largest:e}");
}

#[test]
fn python_and_two_ranks_run_the_deck_too() {
    let stock = stock();
    let alone = fresh_directory("alone");
    let (success, output) = stock.lmp(&alone, &deck(4000), 1);
    assert!(success, "{}", last_lines(&output));

    let python = fresh_directory("python");
    fs::write(python.join("in.deck"), deck(4000)).unwrap();
    let script = "from lammps import lammps\n\
                  l = lammps(cmdargs=['-log', 'none', '-nocite'])\n\
                  l.file('in.deck')\n\
                  assert l.extract_global('ntimestep') == 4000\n\
                  assert ['pair', 'gran/ellipsoid'] in l.available_plugins()\n\
                  l.close()\n";
    let run = stock.python(&python, script);
    assert!(
        run.status.success(),
        "{}{}",
        last_lines(&String::from_utf8_lossy(&run.stdout)),
        String::from_utf8_lossy(&run.stderr)
    );
    assert_eq!(difference(&frames(&alone), &frames(&python)), 0.0);

    let ranks = fresh_directory("ranks");
    let (success, output) = stock.lmp(&ranks, &deck(4000), 2);
    assert!(success, "{}", last_lines(&output));
    assert!(
        output.contains("1 by 1 by 2 MPI processor grid"),
        "{}",
        last_lines(&output)
    );
    let largest = difference(&frames(&alone), &frames(&ranks));
    println!("one rank and two differ by up to {largest:e}");
    // Forces are summed in another order, and collisions multiply what rounding differs by.
    assert!(largest < 1e-9, "{largest:e}");
}

/// A deck that was written for a build from source goes on working.
#[test]
fn a_second_load_changes_nothing() {
    let stock = stock();
    let own = stock.packages().join("ellgran/plugins/ellgranplugin.so");
    let directory = fresh_directory("again");
    let copy = directory.join("copyplugin.so");
    fs::copy(&own, &copy).unwrap();
    let plain = fresh_directory("plain");
    let (success, _) = stock.lmp(&plain, &deck(2000), 1);
    assert!(success);
    for file in [&own, &copy] {
        let text = format!(
            "plugin load {0}\nplugin load {0}\n{1}",
            file.display(),
            deck(2000)
        );
        let (success, output) = stock.lmp(&directory, &text, 1);
        assert!(success, "{}", last_lines(&output));
        let told = output
            .lines()
            .any(|l| l.contains("copyplugin.so are not used"));
        assert_eq!(told, file == &copy, "{}", last_lines(&output));
        assert_eq!(difference(&frames(&plain), &frames(&directory)), 0.0);
    }
}
