// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contact forces as an engine computes them: each pair alone, in a run of two tiny steps, so that the force on a grain is
//! that of one contact. Grains at rest: damping and friction have nothing to act on.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{bail, ensure, Context, Error, Result};

use crate::dump;
use crate::packed_grains::{words, PackedGrain, PackedGrains};
use crate::process::output_of;
use crate::shapes::length;

pub type Pair = [PackedGrain; 2];

/// Force on the second grain, torques on the first and the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench {
    pub force: [f64; 3],
    pub torques: [[f64; 3]; 2],
}

/// Words of a pair style of LAMMPS.
pub struct LammpsStyle<'a> {
    /// `ellipsoid` or `superellipsoid`.
    pub atoms: &'a str,
    pub style: &'a str,
    /// After `pair_coeff * *`.
    pub coefficients: &'a str,
    pub plugin: &'a Path,
}

/// Words of contact models of LIGGGHTS for superquadrics, without viscosity and friction.
pub struct LiggghtsModel<'a> {
    /// After `pair_style gran model`, settings included.
    pub model: &'a str,
    pub youngs_modulus: f64,
    pub poissons_ratio: f64,
}

/// Pairs whose bounding spheres overlap, at most about `wanted` of them, evenly taken; the nearest image of the second
/// grain. The box must be wide enough for one image to be in reach.
pub fn pairs_in_reach(packing: &PackedGrains, wanted: usize) -> Vec<Pair> {
    let radius = |grain: &PackedGrain| grain.semi_axes.iter().copied().fold(0.0, f64::max);
    let edges: [f64; 3] = std::array::from_fn(|k| packing.high[k] - packing.low[k]);
    let mut pairs = Vec::new();
    for (k, i) in packing.grains.iter().enumerate() {
        for j in &packing.grains[k + 1..] {
            let shift: [f64; 3] = std::array::from_fn(|k| {
                let apart = j.position[k] - i.position[k];
                apart - edges[k] * (apart / edges[k]).round()
            });
            let square: f64 = shift.iter().map(|x| x * x).sum();
            if square < (radius(i) + radius(j)).powi(2) {
                let position = std::array::from_fn(|k| i.position[k] + shift[k]);
                pairs.push([*i, PackedGrain { position, ..*j }]);
            }
        }
    }
    thinned(pairs, wanted)
}

/// Every n-th, so that at most `wanted` are left.
pub fn thinned<T>(all: Vec<T>, wanted: usize) -> Vec<T> {
    let stride = all.len().div_ceil(wanted.max(1)).max(1);
    all.into_iter().step_by(stride).collect()
}

/// On our pair style's widest instruction set.
pub fn in_lammps(binary: &Path, style: &LammpsStyle, pairs: &[Pair]) -> Result<Vec<Wrench>> {
    in_lammps_on(binary, style, None, pairs)
}

/// `instruction_set` is what our pair style is told by ELLGRAN_INSTRUCTION_SET.
pub fn in_lammps_on(
    binary: &Path,
    style: &LammpsStyle,
    instruction_set: Option<&str>,
    pairs: &[Pair],
) -> Result<Vec<Wrench>> {
    let (grains, edge) = apart(pairs);
    let mut data = format!(
        "pairs\n\n{} atoms\n{} ellipsoids\n1 atom types\n0 {edge:e} xlo xhi\n0 {edge:e} ylo yhi\n0 {edge:e} zlo zhi\n\nAtoms # ellipsoid\n\n",
        grains.len(),
        grains.len()
    );
    for (k, grain) in grains.iter().enumerate() {
        let _ = writeln!(
            data,
            "{} 1 1 {:e} {}",
            k + 1,
            grain.density,
            words(&grain.position)
        );
    }
    data += "\nEllipsoids\n\n";
    let exponents = if style.atoms == "superellipsoid" {
        " 2 2"
    } else {
        ""
    };
    for (k, grain) in grains.iter().enumerate() {
        let _ = writeln!(
            data,
            "{} {} {}{exponents}",
            k + 1,
            words(&grain.semi_axes.map(|a| 2.0 * a)),
            words(&grain.quaternion)
        );
    }
    let atoms = if style.atoms == "superellipsoid" {
        "ellipsoid superellipsoid"
    } else {
        style.atoms
    };
    let deck = format!(
        "units si\natom_style {atoms}\nboundary f f f\nnewton off\ncomm_modify vel yes\nread_data pairs.data\n{}pair_style {}\npair_coeff * * {}\nneighbor {:e} bin\nfix move all nve/asphere\ntimestep 1e-12\nrun {STEPS}\nwrite_dump all custom forces id fx fy fz tqx tqy tqz modify sort id format float %.17g\n",
        if style.atoms == "ellipsoid" {
            format!("plugin load {}\n", style.plugin.display())
        } else {
            String::new()
        },
        style.style,
        style.coefficients,
        SKIN
    );
    let mut command = Command::new(binary);
    match instruction_set {
        Some(set) => command.env("ELLGRAN_INSTRUCTION_SET", set),
        None => command.env_remove("ELLGRAN_INSTRUCTION_SET"),
    };
    wrenches(command, &data, &deck, pairs.len())
        .with_context(|| format!("pair_style {} {}", style.style, style.coefficients))
}

pub fn in_liggghts(binary: &Path, model: &LiggghtsModel, pairs: &[Pair]) -> Result<Vec<Wrench>> {
    let (grains, edge) = apart(pairs);
    let packing = PackedGrains {
        low: [0.0; 3],
        high: [edge; 3],
        kinds: 1,
        grains,
        spheres: false,
    };
    let deck = format!(
        "atom_style superquadric\natom_modify map array\nboundary f f f\nnewton off\ncommunicate single vel yes\nunits si\nread_data pairs.data\n{}neighbor {SKIN:e} bin\nneigh_modify delay 0\nsoft_particles yes\n{}pair_style gran model {}\npair_coeff * *\nfix move all nve/superquadric\ntimestep 1e-12\ndump forces all custom {STEPS} forces id fx fy fz tqx tqy tqz\ndump_modify forces sort id first yes format \"%d %.17g %.17g %.17g %.17g %.17g %.17g\"\nrun {STEPS}\n",
        packing.liggghts_orientations(),
        constants(model),
        model.model
    );
    wrenches(
        Command::new(binary),
        &packing.liggghts_data(),
        &deck,
        pairs.len(),
    )
    .with_context(|| format!("pair_style gran model {}", model.model))
}

/// After the first step a search begins from the contact that it found, as in a running simulation. The grains hardly move.
const STEPS: usize = 2;
/// Neighbour skin, m.
const SKIN: f64 = 1e-4;

fn constants(model: &LiggghtsModel) -> String {
    [
        ("youngsModulus peratomtype", model.youngs_modulus),
        ("poissonsRatio peratomtype", model.poissons_ratio),
        ("viscosityShear peratomtype", 0.0),
        ("viscosityBulk peratomtype", 0.0),
        ("coefficientRestitution peratomtypepair 1", 1.0),
        ("coefficientFriction peratomtypepair 1", 0.0),
    ]
    .iter()
    .enumerate()
    .map(|(k, (name, value))| format!("fix constant{k} all property/global {name} {value:e}\n"))
    .collect()
}

/// The pairs on a cubic lattice, out of each other's reach and at rest, and the edge of the box around them.
fn apart(pairs: &[Pair]) -> (Vec<PackedGrain>, f64) {
    let largest = pairs
        .iter()
        .flatten()
        .flat_map(|grain| grain.semi_axes)
        .fold(0.0, f64::max);
    let cell = 6.0 * largest;
    let side = (pairs.len().max(1) as f64).cbrt().ceil() as usize;
    let mut grains = Vec::with_capacity(2 * pairs.len());
    for (k, pair) in pairs.iter().enumerate() {
        let place = [k % side, k / side % side, k / side / side];
        for grain in pair {
            let position = std::array::from_fn(|k| {
                let middle = 0.5 * (pair[0].position[k] + pair[1].position[k]);
                (place[k] as f64 + 0.5) * cell + (grain.position[k] - middle)
            });
            grains.push(PackedGrain {
                kind: 1,
                position,
                velocity: [0.0; 3],
                angular_velocity: [0.0; 3],
                ..*grain
            });
        }
    }
    (grains, side as f64 * cell)
}

/// Runs a deck that reads `pairs.data` and leaves the dump `forces`.
fn wrenches(mut command: Command, data: &str, deck: &str, pairs: usize) -> Result<Vec<Wrench>> {
    let directory = tempfile::tempdir()?;
    fs::write(directory.path().join("pairs.data"), data)?;
    fs::write(directory.path().join("deck"), deck)?;
    output_of(
        command
            .current_dir(directory.path())
            .env("OMP_NUM_THREADS", "1")
            .args(["-log", "none", "-in", "deck"]),
    )?;
    let dump = fs::read_to_string(directory.path().join("forces"))
        .context("the engine wrote no forces")?;
    let rows = forces(&dump)?;
    ensure!(
        rows.len() == 2 * pairs,
        "{} grains went in, {} came out",
        2 * pairs,
        rows.len()
    );
    Ok(rows
        .chunks_exact(2)
        .map(|rows| Wrench {
            force: rows[1].0,
            torques: [rows[0].1, rows[1].1],
        })
        .collect())
}

/// Force and torque of each grain in the last frame of a dump.
fn forces(dump: &str) -> Result<Vec<([f64; 3], [f64; 3])>> {
    let tables = dump::tables(dump).map_err(Error::msg)?;
    let last = tables.last().context("the dump holds no frame")?;
    let forces = |row: &Vec<f64>| match row[..] {
        [_, fx, fy, fz, tx, ty, tz] => Ok(([fx, fy, fz], [tx, ty, tz])),
        _ => bail!("not a line of forces: {row:?}"),
    };
    last.rows.iter().map(forces).collect()
}

/// Of the force, over that of the reference; a contact that was not found is off by all of it.
pub fn relative_error(found: &Wrench, reference: &Wrench) -> f64 {
    let difference: [f64; 3] = std::array::from_fn(|k| found.force[k] - reference.force[k]);
    length(difference) / length(reference.force)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grain(x: f64) -> PackedGrain {
        PackedGrain {
            kind: 1,
            density: 1.0,
            semi_axes: [1.0, 1.0, 1.0],
            position: [x, 0.5, 0.5],
            quaternion: [1.0, 0.0, 0.0, 0.0],
            velocity: [1.0; 3],
            angular_velocity: [1.0; 3],
        }
    }

    #[test]
    fn a_pair_across_the_boundary_is_brought_together_and_set_apart_from_others() {
        let packing = PackedGrains {
            low: [0.0; 3],
            high: [10.0; 3],
            kinds: 1,
            grains: vec![grain(0.5), grain(9.0), grain(5.0)],
            spheres: false,
        };
        let pairs = pairs_in_reach(&packing, 10);
        assert_eq!(pairs.len(), 1);
        assert_eq!(pairs[0][1].position[0], -1.0);
        let (grains, edge) = apart(&[pairs[0], pairs[0]]);
        assert_eq!(grains.len(), 4);
        assert_eq!(edge, 12.0);
        assert_eq!(grains[1].position[0] - grains[0].position[0], -1.5);
        assert_eq!(grains[2].position[0] - grains[0].position[0], 6.0);
        assert_eq!(grains[0].velocity, [0.0; 3]);
    }

    #[test]
    fn a_missed_contact_is_off_by_all_of_its_force() {
        let none = Wrench {
            force: [0.0; 3],
            torques: [[0.0; 3]; 2],
        };
        let some = Wrench {
            force: [0.0, 3.0, 4.0],
            ..none
        };
        assert_eq!(relative_error(&none, &some), 1.0);
        assert_eq!(relative_error(&some, &some), 0.0);
    }

    #[test]
    fn the_last_frame_of_a_dump_counts() {
        let columns = "ITEM: ATOMS id fx fy fz tx ty tz\n1";
        let dump = format!("{columns} 0 0 0 0 0 0\nITEM: TIMESTEP\n2\n{columns} 1 2 3 4 5 6\n");
        assert_eq!(forces(&dump).unwrap(), [([1.0, 2.0, 3.0], [4.0, 5.0, 6.0])]);
        assert!(forces("nothing").is_err());
    }

    #[test]
    fn thinning_is_even() {
        assert_eq!(thinned((0..10).collect(), 4), [0, 3, 6, 9]);
        assert_eq!(thinned(vec![1, 2], 4), [1, 2]);
    }
}
