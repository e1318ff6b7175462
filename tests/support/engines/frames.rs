// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a run wrote, read back, and the sums and differences taken of it.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::dump::{tables, Table};
use super::process::last_lines;
use super::scene::Grain;
use super::shapes::{add, cross, dot, inertia, length, scale, sub, unrotate, Quaternion, Vector};

/// One particle at one step.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    pub position: Vector,
    pub velocity: Vector,
    pub force: Vector,
    pub torque: Vector,
    /// World frame; zero for `atom_style sphere`.
    pub angular_momentum: Vector,
    /// `atom_style sphere` only.
    pub angular_velocity: Vector,
    pub quaternion: Quaternion,
}

#[derive(Clone, Debug)]
pub struct Frame {
    pub step: u64,
    pub states: Vec<State>,
}

pub struct Outcome {
    pub directory: PathBuf,
    pub success: bool,
    /// Screen output and error stream together.
    pub output: String,
    pub frames: Vec<Frame>,
}

impl Outcome {
    pub fn first(&self) -> &Frame {
        self.frames.first().expect("no frame was dumped")
    }

    pub fn last(&self) -> &Frame {
        self.frames.last().expect("no frame was dumped")
    }

    /// Itself, if the run succeeded.
    pub fn succeeded(self) -> Outcome {
        assert!(
            self.success,
            "the run failed in {}:\n{}",
            self.directory.display(),
            last_lines(&self.output)
        );
        self
    }

    /// Frames that the run wrote into `frames` in its directory.
    pub fn read(directory: PathBuf, success: bool, output: String) -> Outcome {
        let frames = std::fs::read_to_string(directory.join("frames"))
            .map(|text| parse_frames(&text))
            .unwrap_or_default();
        Outcome {
            directory,
            success,
            output,
            frames,
        }
    }

    /// Rows of all thermo tables in the output, in order.
    pub fn thermo(&self) -> Vec<HashMap<String, f64>> {
        thermo_rows(&self.output)
    }
}

pub fn thermo_rows(output: &str) -> Vec<HashMap<String, f64>> {
    let mut rows = vec![];
    let mut header: Option<Vec<&str>> = None;
    for line in output.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if words.first() == Some(&"Step") {
            header = Some(words);
        } else if line.starts_with("Loop time") {
            header = None;
        } else if let Some(names) = &header {
            let values: Option<Vec<f64>> = words.iter().map(|w| w.parse().ok()).collect();
            if let Some(values) = values {
                if values.len() == names.len() {
                    rows.push(names.iter().map(|n| n.to_string()).zip(values).collect());
                }
            }
        }
    }
    rows
}

/// The rows of the last table of a dump.
pub fn last_rows(file: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(file).unwrap();
    let last = tables(&text).expect("a dump").pop();
    last.expect("a table").rows
}

pub fn parse_frames(text: &str) -> Vec<Frame> {
    let frame = |table: Table| {
        let state = |row: &Vec<f64>| {
            let entry = |name: String| table.column(&name).map_or(0.0, |at| row[at]);
            let vector = |names: &str| ["x", "y", "z"].map(|c| entry(names.replace('*', c)));
            State {
                position: vector("*u"),
                velocity: vector("v*"),
                force: vector("f*"),
                torque: vector("tq*"),
                angular_momentum: vector("angmom*"),
                angular_velocity: vector("omega*"),
                quaternion: [1, 2, 3, 4].map(|k| entry(format!("c_quaternion[{k}]"))),
            }
        };
        Frame {
            step: table.step,
            states: table.rows.iter().map(state).collect(),
        }
    };
    tables(text)
        .expect("a dump")
        .into_iter()
        .map(frame)
        .collect()
}

/// Kinetic energy of translation and rotation.
pub fn kinetic_energy(grain: &Grain, state: &State) -> f64 {
    let body = unrotate(state.quaternion, state.angular_momentum);
    let moments = inertia(grain.mass(), grain.semi_axes);
    0.5 * grain.mass() * dot(state.velocity, state.velocity)
        + 0.5 * (0..3).map(|k| body[k] * body[k] / moments[k]).sum::<f64>()
}

pub fn linear_momentum(grains: &[Grain], frame: &Frame) -> Vector {
    grains
        .iter()
        .zip(&frame.states)
        .fold([0.0; 3], |sum, (g, s)| {
            add(sum, scale(g.mass(), s.velocity))
        })
}

/// Change of the momentum between two frames, over the sum of the grains' momenta in the first.
pub fn momentum_error(grains: &[Grain], first: &Frame, last: &Frame) -> f64 {
    let size: f64 = grains
        .iter()
        .zip(&first.states)
        .map(|(g, s)| g.mass() * length(s.velocity))
        .sum();
    length(sub(
        linear_momentum(grains, last),
        linear_momentum(grains, first),
    )) / size
}

/// About the origin, orbital and spin.
pub fn angular_momentum(grains: &[Grain], frame: &Frame) -> Vector {
    grains
        .iter()
        .zip(&frame.states)
        .fold([0.0; 3], |sum, (g, s)| {
            add(
                sum,
                add(
                    scale(g.mass(), cross(s.position, s.velocity)),
                    s.angular_momentum,
                ),
            )
        })
}

/// Largest difference of positions and velocities of two final states, relative to the largest of each.
pub fn largest_difference(a: &Frame, b: &Frame) -> (f64, f64) {
    assert_eq!(a.states.len(), b.states.len());
    let compare = |pick: fn(&State) -> Vector| {
        let mut difference: f64 = 0.0;
        let mut largest: f64 = 0.0;
        for (s, t) in a.states.iter().zip(&b.states) {
            let (u, v) = (pick(s), pick(t));
            for k in 0..3 {
                assert!(
                    u[k].is_finite() && v[k].is_finite(),
                    "a state is not finite"
                );
                difference = difference.max((u[k] - v[k]).abs());
                largest = largest.max(v[k].abs());
            }
        }
        difference / largest.max(f64::MIN_POSITIVE)
    };
    (compare(|s| s.position), compare(|s| s.velocity))
}
