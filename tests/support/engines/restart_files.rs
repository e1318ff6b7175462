// SPDX-License-Identifier: MIT OR Apache-2.0
//! The restart files that are kept in tests/restart_files, and what the version that wrote each of them computed from it.

use std::fs;
use std::path::{Path, PathBuf};

pub fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/restart_files")
}

/// Names of the kept files of an engine, such as `lammps_format_1`.
pub fn kept(engine: &str) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(directory())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter_map(|name| Some(name.strip_suffix(".restart")?.to_string()))
        .filter(|name| name.starts_with(engine))
        .collect();
    names.sort();
    names
}

/// The last frame of a dump, a row for each grain, and the energies after it.
fn rows(dump: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(dump).unwrap();
    let frame = text.rfind("ITEM: ATOMS").expect("a frame");
    text[frame..]
        .lines()
        .skip(1)
        .map(|line| {
            let words = line.split_whitespace();
            words.filter_map(|word| word.parse().ok()).collect()
        })
        .collect()
}

/// Numbers of the line after the grains: three dissipated energies, and the work of a wall.
const ENERGIES: usize = 4;

/// The largest difference between the dump in `run` and the kept one, as a part of the largest number of its column among
/// the grains; of an energy, as a part of itself. The second number is that of the work of a wall, 0 where the dump has none.
pub fn differences(run: &Path, name: &str) -> (f64, f64) {
    let file = format!("{name}.dump");
    let (computed, kept) = (rows(&run.join(&file)), rows(&directory().join(&file)));
    assert_eq!(computed.len(), kept.len());
    let (mut largest, mut work) = (0.0f64, 0.0);
    for (row, there) in computed.iter().zip(&kept) {
        assert_eq!(row.len(), there.len());
        for (k, (x, y)) in row.iter().zip(there).enumerate() {
            let column = kept.iter().filter(|other| other.len() == there.len());
            let scale = column.fold(0.0f64, |most, other| most.max(other[k].abs()));
            let apart = (x - y).abs() / scale;
            if (there.len(), k) == (ENERGIES, ENERGIES - 1) {
                work = apart;
            } else {
                largest = largest.max(apart);
            }
        }
    }
    (largest, work)
}

/// Writes the restart file `name` of `source` to `run`, with the bytes `from`, which it holds once or more, replaced by `to`.
pub fn write_changed(source: &Path, name: &str, run: &Path, from: &[u8], to: &[u8]) {
    let mut bytes = fs::read(source.join(format!("{name}.restart"))).unwrap();
    let places: Vec<usize> = (0..bytes.len() - from.len())
        .filter(|k| bytes[*k..].starts_with(from))
        .collect();
    assert!(!places.is_empty(), "{name} holds no {from:?}");
    for place in places {
        bytes[place..place + to.len()].copy_from_slice(to);
    }
    fs::write(run.join(format!("{name}.restart")), bytes).unwrap();
}
