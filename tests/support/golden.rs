// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reference tables of `validation/reference`.

use super::scene::Vector;
#[cfg(reference_pairs)]
use super::scene::{body, rotation};
use ellgran::contact::Body;

#[cfg(reference_pairs)]
const ASPECT_10: &str = include_str!("../../validation/reference/pairs_aspect_10.csv");
#[cfg(reference_pairs)]
const ASPECT_100: &str = include_str!("../../validation/reference/pairs_aspect_100.csv");
#[cfg(reference_pairs)]
const ASPECT_1000: &str = include_str!("../../validation/reference/pairs_aspect_1000.csv");
const FACTORS: &str = include_str!("../../validation/reference/hertz_factors.csv");

/// A table with named columns.
struct Table {
    names: Vec<&'static str>,
    rows: Vec<Vec<f64>>,
}

fn read(text: &'static str) -> Table {
    let mut lines = text.lines();
    let names: Vec<_> = lines.next().expect("a header").split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|line| {
            let row: Vec<f64> = line
                .split(',')
                .map(|x| x.parse().unwrap_or_else(|_| panic!("{x} is not a number")))
                .collect();
            assert_eq!(row.len(), names.len());
            row
        })
        .collect();
    assert!(!rows.is_empty());
    Table { names, rows }
}

impl Table {
    fn column(&self, name: &str) -> usize {
        self.names
            .iter()
            .position(|n| *n == name)
            .unwrap_or_else(|| panic!("no column {name}"))
    }
    fn number(&self, row: &[f64], name: &str) -> f64 {
        row[self.column(name)]
    }
    fn vector(&self, row: &[f64], stem: &str) -> Vector {
        Vector::from(["x", "y", "z"].map(|c| self.number(row, &format!("{stem}_{c}"))))
    }
}

/// One line of `hertz_factors.csv`.
pub struct FactorRow {
    pub ratio: f64,
    pub axis_ratio: f64,
    pub f1: f64,
    pub f2: f64,
    pub phi: f64,
    pub beta_major: f64,
}

pub fn factors() -> Vec<FactorRow> {
    let table = read(FACTORS);
    let get = |row: &Vec<f64>, name: &str| table.number(row, name);
    table
        .rows
        .iter()
        .map(|row| FactorRow {
            ratio: get(row, "ratio"),
            axis_ratio: get(row, "b_over_a"),
            f1: get(row, "F1"),
            f2: get(row, "F2"),
            phi: get(row, "phi"),
            beta_major: get(row, "beta_major"),
        })
        .collect()
}

/// Force on `j` and torques.
#[derive(Clone, Copy, Debug)]
pub struct Wrench {
    pub force: Vector,
    pub torque_i: Vector,
    pub torque_j: Vector,
}

/// One line of a table of pairs.
pub struct GoldenPair {
    pub case: usize,
    pub i: Body,
    pub j: Body,
    /// Young's modulus and Poisson's ratio of `i` and of `j`.
    pub materials: [[f64; 2]; 2],
    pub penetration: f64,
    pub normal: Vector,
    pub contact_point: Vector,
    pub curvature_a: f64,
    pub curvature_b: f64,
    /// Hertz' force along the normal.
    pub hertz: Wrench,
    /// The complete gradient of the energy.
    pub conservative: Wrench,
}

/// Pairs of aspect ratio up to 10, 100 or 1000.
#[cfg(reference_pairs)]
pub fn pairs(aspect: usize) -> Vec<GoldenPair> {
    let table = read(match aspect {
        10 => ASPECT_10,
        100 => ASPECT_100,
        1000 => ASPECT_1000,
        _ => panic!("no table for aspect ratio {aspect}"),
    });
    let convert = |row: &Vec<f64>| {
        let number = |name: &str| table.number(row, name);
        let grain = |which: &str, kind: i32| {
            let q = ["w", "x", "y", "z"].map(|c| number(&format!("quaternion_{which}_{c}")));
            let a = ["1", "2", "3"].map(|c| number(&format!("semi_axis_{which}_{c}")));
            let mut b = body(
                a,
                table.vector(row, &format!("position_{which}")),
                rotation([1.0, 0.0, 0.0, 0.0]),
            );
            b.quaternion = q;
            b.particle_type = kind;
            b
        };
        let wrench = |prefix: &str| Wrench {
            force: table.vector(row, &format!("{prefix}force_j")),
            torque_i: table.vector(row, &format!("{prefix}torque_i")),
            torque_j: table.vector(row, &format!("{prefix}torque_j")),
        };
        GoldenPair {
            case: number("case") as usize,
            i: grain("i", 1),
            j: grain("j", 2),
            materials: ["i", "j"].map(|b| {
                [
                    number(&format!("youngs_modulus_{b}")),
                    number(&format!("poissons_ratio_{b}")),
                ]
            }),
            penetration: number("delta"),
            normal: table.vector(row, "normal"),
            contact_point: table.vector(row, "contact_point"),
            curvature_a: number("curvature_a"),
            curvature_b: number("curvature_b"),
            hertz: wrench(""),
            conservative: wrench("conservative_"),
        }
    };
    table.rows.iter().map(convert).collect()
}
