// SPDX-License-Identifier: MIT OR Apache-2.0
//! One of the collisions of validation/collisions, with friction and viscosity and off the centres, through the decks of that folder:
//! two ellipsoids 2:1:1 with their long axes at 45 degrees to the normal, at 0.003 of the speed of sound and 45 degrees.

use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};

const SPEED: f64 = 0.003;
/// A five hundredth of the duration of the elastic impact.
const STEP: f64 = 0.038_315_865_771_771_775;
pub const SHEAR_VISCOSITY: f64 = 0.5 / 1.3;
pub const BULK_VISCOSITY: f64 = 0.5 / 1.2;
pub const FRICTION: f64 = 0.3;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/collisions")
}

/// A deck of that folder after its variables, of which both engines share some.
pub fn deck(name: &str, variables: &[(&str, String)]) -> String {
    let (x, z) = (0.9_f64.sqrt(), 2.5_f64.sqrt());
    let shared = [
        ("place", format!("{:e} 0 {:e}", -x, -z)),
        ("place2", format!("{x:e} 0 {z:e}")),
        ("along", SPEED.to_string()),
        ("approach", SPEED.to_string()),
        ("step", format!("{STEP:e}")),
        ("steps", "1000".to_string()),
    ];
    let mut text = String::new();
    for (variable, value) in shared.iter().chain(variables) {
        text += &format!("variable {variable} index \"{value}\"\n");
    }
    text + &fs::read_to_string(folder().join(name)).unwrap()
}

/// The mass of a grain of density 1.
pub fn mass() -> f64 {
    4.0 / 3.0 * PI * 2.0
}

/// The stored velocities along x and z of the second grain relative to the first, and the spins of both, over the speed of approach.
fn stored() -> [f64; 4] {
    let text = fs::read_to_string(folder().join("laws.csv")).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let quoted = "\"45 degrees, viscous\"";
    let line = lines
        .map(|line| line.replace(quoted, "viscous"))
        .find(|line| line.starts_with("oblique,0.003,viscous,NFD+TFD,"))
        .expect("the collision is stored");
    let cells: Vec<&str> = line.split(',').collect();
    ["velocity_x", "velocity_z", "spin_lower", "spin_upper"].map(|name| {
        let column = head.iter().position(|word| *word == name).unwrap();
        cells[column].parse().unwrap()
    })
}

/// Does the last row that a deck printed end as is stored?
pub fn check(output: &str, tolerance: f64) {
    let last = output
        .lines()
        .take_while(|line| !line.starts_with("Loop time"))
        .last()
        .unwrap();
    let row: Vec<f64> = last
        .split_whitespace()
        .map(|word| {
            word.parse()
                .unwrap_or_else(|_| panic!("{last} in:\n{output}"))
        })
        .collect();
    let [_, fx, fz, vx1, vz1, vx2, vz2, first, second] = row[..] else {
        panic!("other columns: {last}");
    };
    assert_eq!([fx, fz], [0.0; 2], "still in contact");
    // About the small axis.
    let inertia = mass() / 5.0 * (2.0_f64.powi(2) + 1.0);
    let found = [vx2 - vx1, vz2 - vz1, first / inertia, second / inertia].map(|x| x / SPEED);
    let wanted = stored();
    println!("{found:.10?}, stored {wanted:.10?}");
    for (found, wanted) in found.iter().zip(wanted) {
        assert!((found - wanted).abs() < tolerance, "{found} for {wanted}");
    }
}
