// SPDX-License-Identifier: MIT OR Apache-2.0
//! A packing of a data file of LAMMPS, copied side by side, in a layer of grains that stand.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::path::Path;

/// Grains in a box that begins at the origin.
#[derive(Default)]
pub struct Grains {
    pub positions: Vec<[f64; 3]>,
    pub velocities: Vec<[f64; 3]>,
    pub angular_momenta: Vec<[f64; 3]>,
    pub quaternions: Vec<[f64; 4]>,
    pub semi_axes: Vec<[f64; 3]>,
    pub masses: Vec<f64>,
    box_length: [f64; 3],
}

/// Of a file that `write_data` has written, `atom_style ellipsoid`.
pub fn read(file: &Path) -> Grains {
    let text = std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let mut grains = Grains::default();
    let mut low = [0.0; 3];
    let mut section = "";
    let mut atoms: Vec<(u64, f64, [f64; 3])> = Vec::new();
    let mut velocities = HashMap::new();
    let mut shapes = HashMap::new();
    for line in text.lines().skip(1) {
        let words: Vec<&str> = line
            .split('#')
            .next()
            .unwrap_or("")
            .split_whitespace()
            .collect();
        let Some(first) = words.first() else {
            continue;
        };
        if let [from, to, "xlo" | "ylo" | "zlo", _] = words[..] {
            let at = ["xlo", "ylo", "zlo"]
                .iter()
                .position(|w| *w == words[2])
                .unwrap();
            low[at] = number(from);
            grains.box_length[at] = number(to) - low[at];
        } else if first.starts_with(|c: char| c.is_ascii_alphabetic()) {
            section = first;
        } else if !section.is_empty() {
            let values: Vec<f64> = words.iter().map(|w| number(w)).collect();
            match section {
                "Atoms" => atoms.push((
                    values[0] as u64,
                    values[3],
                    [values[4], values[5], values[6]],
                )),
                "Velocities" => drop(velocities.insert(values[0] as u64, values[1..7].to_vec())),
                "Ellipsoids" => drop(shapes.insert(values[0] as u64, values[1..8].to_vec())),
                _ => {}
            }
        }
    }
    for (identifier, density, x) in atoms {
        let (v, s) = (&velocities[&identifier], &shapes[&identifier]);
        let semi_axes = [0.5 * s[0], 0.5 * s[1], 0.5 * s[2]];
        grains
            .positions
            .push(core::array::from_fn(|k| x[k] - low[k]));
        grains.velocities.push([v[0], v[1], v[2]]);
        grains.angular_momenta.push([v[3], v[4], v[5]]);
        grains.quaternions.push([s[3], s[4], s[5], s[6]]);
        grains
            .masses
            .push(4.0 / 3.0 * PI * semi_axes.iter().product::<f64>() * density);
        grains.semi_axes.push(semi_axes);
    }
    grains
}

fn number(word: &str) -> f64 {
    word.parse()
        .unwrap_or_else(|_| panic!("'{word}' is not a number"))
}

impl Grains {
    /// The largest semi-axis of all.
    pub fn reach(&self) -> f64 {
        self.semi_axes.iter().flatten().copied().fold(0.0, f64::max)
    }

    fn add(&mut self, from: &Grains, k: usize, position: [f64; 3], moves: bool) {
        let if_it_moves = |v: [f64; 3]| if moves { v } else { [0.0; 3] };
        self.positions.push(position);
        self.velocities.push(if_it_moves(from.velocities[k]));
        self.angular_momenta
            .push(if_it_moves(from.angular_momenta[k]));
        self.quaternions.push(from.quaternions[k]);
        self.semi_axes.push(from.semi_axes[k]);
        self.masses.push(from.masses[k]);
    }

    /// So many copies in each direction, and then a layer of grains that do not move, as thick as a pair reaches: all, and how many
    /// move. Grains that are close are close in memory, as engines sort them.
    pub fn copied(&self, copies: usize, skin: f64) -> (Grains, usize) {
        let layer = 2.0 * self.reach() + skin;
        let total = self.box_length.map(|l| l * copies as f64);
        let around = self.box_length.map(|l| (layer / l).ceil() as i64);
        let mut places: Vec<([i64; 3], [f64; 3], usize)> = Vec::new();
        let mut standing: Vec<([i64; 3], [f64; 3], usize)> = Vec::new();
        let cell = layer;
        for x in -around[0]..copies as i64 + around[0] {
            for y in -around[1]..copies as i64 + around[1] {
                for z in -around[2]..copies as i64 + around[2] {
                    let image = [x, y, z];
                    for (k, p) in self.positions.iter().enumerate() {
                        let at: [f64; 3] =
                            core::array::from_fn(|c| p[c] + image[c] as f64 * self.box_length[c]);
                        if (0..3).any(|c| at[c] < -layer || at[c] >= total[c] + layer) {
                            continue;
                        }
                        let cells = [2, 1, 0].map(|c: usize| (at[c] / cell).floor() as i64);
                        // Where it is, not which copy: a position on the border belongs to one of two copies by rounding.
                        let inside = image.iter().all(|&i| (0..copies as i64).contains(&i));
                        let list = if inside { &mut places } else { &mut standing };
                        list.push((cells, at, k));
                    }
                }
            }
        }
        let mut all = Grains {
            box_length: total,
            ..Grains::default()
        };
        for (list, moves) in [(&mut places, true), (&mut standing, false)] {
            list.sort_by_key(|(cells, _, k)| (*cells, *k));
            for (_, at, k) in list.iter() {
                all.add(self, *k, *at, moves);
            }
        }
        (all, places.len())
    }
}
