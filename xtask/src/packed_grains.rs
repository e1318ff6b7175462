// SPDX-License-Identifier: MIT OR Apache-2.0
//! The grains of a packing that LAMMPS wrote, and the same grains as LIGGGHTS reads them.

use std::collections::BTreeMap;
use std::fmt::Write;

use anyhow::{Context, Result};

use crate::shapes;

/// One grain. World frame; quaternion `(w, x, y, z)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackedGrain {
    pub kind: usize,
    pub density: f64,
    pub semi_axes: [f64; 3],
    pub position: [f64; 3],
    pub quaternion: [f64; 4],
    pub velocity: [f64; 3],
    pub angular_velocity: [f64; 3],
}

/// Grains in a periodic box, in the order of their identifiers.
#[derive(Debug, PartialEq)]
pub struct PackedGrains {
    pub low: [f64; 3],
    pub high: [f64; 3],
    pub kinds: usize,
    pub grains: Vec<PackedGrain>,
    pub spheres: bool,
}

/// Columns of a section by identifier.
type Rows = BTreeMap<u64, Vec<f64>>;

impl PackedGrains {
    /// Reads a data file of `atom_style ellipsoid` or `sphere` as `write_data` writes it.
    pub fn read(data: &str) -> Result<Self> {
        let mut sections: BTreeMap<&str, Rows> = BTreeMap::new();
        let mut section = "";
        let (mut low, mut high, mut kinds) = ([0.0; 3], [0.0; 3], 0);
        // The first line is a title.
        for line in data.lines().skip(1) {
            let words: Vec<&str> = line.split_whitespace().collect();
            let Some(first) = words.first() else {
                continue;
            };
            if first.starts_with(|c: char| c.is_ascii_alphabetic()) {
                section = first;
            } else if section.is_empty() {
                let axis = ["xlo", "ylo", "zlo"].iter().position(|w| words.contains(w));
                if let Some(axis) = axis {
                    (low[axis], high[axis]) = (words[0].parse()?, words[1].parse()?);
                } else if line.trim_end().ends_with("atom types") {
                    kinds = words[0].parse()?;
                }
            } else {
                let numbers = words[1..]
                    .iter()
                    .map(|word| word.parse())
                    .collect::<Result<_, _>>()
                    .with_context(|| format!("not a line of {section}: {line}"))?;
                sections
                    .entry(section)
                    .or_default()
                    .insert(first.parse()?, numbers);
            }
        }
        let none = Rows::new();
        let of = |name: &str| sections.get(name).unwrap_or(&none);
        let shapes = of("Ellipsoids");
        let spheres = shapes.is_empty();
        let mut grains = Vec::new();
        for (identifier, atom) in of("Atoms") {
            let wanted = |found: Option<&Vec<f64>>, length: usize, name: &str| {
                found
                    .filter(|row| row.len() >= length)
                    .cloned()
                    .with_context(|| format!("grain {identifier} has no line in {name}"))
            };
            let atom = wanted(Some(atom), 6, "Atoms")?;
            let motion = wanted(of("Velocities").get(identifier), 6, "Velocities")?;
            let three = |row: &[f64], at: usize| [row[at], row[at + 1], row[at + 2]];
            let spin = three(&motion, 3);
            let grain = PackedGrain {
                kind: atom[0] as usize,
                // Atoms of a sphere: type, diameter, density; of an ellipsoid: type, flag, density.
                density: atom[2],
                semi_axes: [0.5 * atom[1]; 3],
                position: three(&atom, 3),
                quaternion: [1.0, 0.0, 0.0, 0.0],
                velocity: three(&motion, 0),
                angular_velocity: spin,
            };
            grains.push(if spheres {
                grain
            } else {
                let shape = wanted(shapes.get(identifier), 7, "Ellipsoids")?;
                let oriented = PackedGrain {
                    semi_axes: three(&shape, 0).map(|diameter| 0.5 * diameter),
                    quaternion: [shape[3], shape[4], shape[5], shape[6]],
                    ..grain
                };
                PackedGrain {
                    // Of an ellipsoid the file has the angular momentum.
                    angular_velocity: shapes::angular_velocity(
                        shapes::mass(oriented.density, oriented.semi_axes),
                        oriented.semi_axes,
                        oriented.quaternion,
                        spin,
                    ),
                    ..oriented
                }
            });
        }
        anyhow::ensure!(!grains.is_empty(), "the data file holds no grains");
        Ok(PackedGrains {
            low,
            high,
            kinds,
            grains,
            spheres,
        })
    }

    /// The data file that LIGGGHTS reads for `atom_style superquadric` or `sphere`.
    pub fn liggghts_data(&self) -> String {
        let mut text = format!(
            "packing\n\n{} atoms\n{} atom types\n",
            self.grains.len(),
            self.kinds
        );
        for (k, axis) in ["x", "y", "z"].iter().enumerate() {
            text += &format!("{:e} {:e} {axis}lo {axis}hi\n", self.low[k], self.high[k]);
        }
        text += "\nAtoms\n\n";
        for (k, grain) in self.grains.iter().enumerate() {
            let shape = if self.spheres {
                format!("{:e} {:e}", 2.0 * grain.semi_axes[0], grain.density)
            } else {
                format!("{:e} {} 2 2", grain.density, words(&grain.semi_axes))
            };
            let _ = writeln!(
                text,
                "{} {} {shape} {}",
                k + 1,
                grain.kind,
                words(&grain.position)
            );
        }
        text += "\nVelocities\n\n";
        for (k, grain) in self.grains.iter().enumerate() {
            let _ = writeln!(
                text,
                "{} {} {}",
                k + 1,
                words(&grain.velocity),
                words(&grain.angular_velocity)
            );
        }
        text
    }

    /// The commands of LIGGGHTS for what its data file of superquadrics does not hold.
    pub fn liggghts_orientations(&self) -> String {
        let mut text = String::new();
        for (k, grain) in self.grains.iter().enumerate() {
            let [x, y, z] = grain.angular_velocity;
            let _ = writeln!(
                text,
                "set atom {0} quat_direct {1}\nset atom {0} omegax {x:e} omegay {y:e} omegaz {z:e}",
                k + 1,
                words(&grain.quaternion)
            );
        }
        text
    }
}

/// All digits.
pub fn words(numbers: &[f64]) -> String {
    numbers
        .iter()
        .map(|x| format!("{x:e}"))
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    const DATA: &str = "LAMMPS data file, units = si\n\n2 atoms\n1 atom types\n2 ellipsoids\n\n0 4 xlo xhi\n0 5 ylo yhi\n0 6 zlo zhi\n\nAtoms # ellipsoid\n\n2 1 1 2500 1 2 3 0 0 0\n1 1 1 2500 0.5 0 0 0 0 0\n\nEllipsoids\n\n1 4 2 2 1 0 0 0\n2 4 2 2 0 0 0 1\n\nVelocities\n\n1 0.1 0 0 0 0 0\n2 0 0 0 1 0 0\n";

    #[test]
    fn shapes_follow_their_grains() {
        let packing = PackedGrains::read(DATA).unwrap();
        assert_eq!(packing.high, [4.0, 5.0, 6.0]);
        assert_eq!(packing.kinds, 1);
        assert!(!packing.spheres);
        let [first, second] = packing.grains[..] else {
            panic!("two grains");
        };
        assert_eq!(first.position, [0.5, 0.0, 0.0]);
        assert_eq!(first.semi_axes, [2.0, 1.0, 1.0]);
        assert_eq!(second.quaternion, [0.0, 0.0, 0.0, 1.0]);
        // Half a turn about z leaves the long axis along x.
        let moment = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 2.0 / 5.0 * 2.0;
        assert!((second.angular_velocity[0] - 1.0 / moment).abs() < 1e-15 / moment * 10.0);
        let text = packing.liggghts_data();
        assert!(
            text.contains("\n2 1 2.5e3 2e0 1e0 1e0 2 2 1e0 2e0 3e0\n"),
            "{text}"
        );
        assert!(packing
            .liggghts_orientations()
            .contains("set atom 2 quat_direct 0e0 0e0 0e0 1e0\n"));
    }
}
