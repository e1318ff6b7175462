// SPDX-License-Identifier: MIT OR Apache-2.0
//! The packings that every pair style reads: made by a deck, kept in the cache until the deck or its words change.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::lammps_run::{path_word, text_of, Lammps};
use crate::cache;
use crate::demo::material::Material;
use crate::progress::Progress;

/// Grains as soft as a time step of 4e-6 s allows; SI units.
pub const MATERIAL: Material = Material {
    youngs_modulus: 1e7,
    poissons_ratio: 0.3,
    viscosity: 50.0,
    density: 2500.0,
    friction: 0.5,
};
/// Of the grains of type 1.
pub const VOLUME: f64 = 4.0 / 3.0 * std::f64::consts::PI * 1e-9;
/// Overlap of some 2 % between spheres of 1 mm, at which spring constants are fitted.
pub const CONTACT_RADIUS: f64 = 1e-4;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Dense,
    Needles,
    Mixture,
    Gas,
    /// Layers that shear past each other.
    Flow,
}

#[derive(Clone, Copy, Debug)]
pub struct Packing {
    pub kind: Kind,
    /// Lattice points of type 1 in each direction, before large grains take the place of some.
    pub lattice: [usize; 3],
    pub spheres: bool,
}

impl Kind {
    pub fn title(self) -> &'static str {
        match self {
            Kind::Dense => "dense, AR 2",
            Kind::Needles => "needles, AR 10",
            Kind::Mixture => "sizes 1:5, AR 2",
            Kind::Gas => "dilute gas, AR 2",
            Kind::Flow => "flowing, AR 2",
        }
    }

    pub fn fraction(self) -> f64 {
        match self {
            Kind::Dense => 0.66,
            Kind::Needles => 0.36,
            Kind::Mixture => 0.75,
            Kind::Gas => 0.05,
            Kind::Flow => 0.58,
        }
    }

    /// How much more than in a dense packing of aspect ratio 2 a step of a grain costs, roughly.
    pub fn weight(self) -> f64 {
        match self {
            Kind::Dense | Kind::Mixture | Kind::Flow => 1.0,
            Kind::Needles => 4.0,
            Kind::Gas => 0.2,
        }
    }

    /// Aspect ratio of the ellipsoids.
    fn aspect(self) -> f64 {
        match self {
            Kind::Needles => 10.0,
            _ => 2.0,
        }
    }
}

impl Packing {
    fn variables(&self) -> Vec<(&'static str, String)> {
        let b = 1e-3 / self.kind.aspect().cbrt();
        let mut words = vec![
            ("nx", self.lattice[0].to_string()),
            ("ny", self.lattice[1].to_string()),
            ("nz", self.lattice[2].to_string()),
            ("a", format!("{:.6e}", self.kind.aspect() * b)),
            ("b", format!("{b:.6e}")),
            ("c", format!("{b:.6e}")),
            ("fraction", self.kind.fraction().to_string()),
        ];
        match self.kind {
            Kind::Dense => {}
            Kind::Needles => words.extend([
                ("spacing", "9.5e-3".to_string()),
                ("shrink", "12000".to_string()),
            ]),
            Kind::Mixture => words.push(("large", (self.lattice[0] / 6).to_string())),
            Kind::Gas => words.extend([
                ("spacing", "4.376e-3".to_string()),
                ("shrink", "0".to_string()),
                ("rest", "0".to_string()),
                ("gentle", "0.3".to_string()),
            ]),
            Kind::Flow => words.push(("flow", "1".to_string())),
        }
        if self.spheres {
            // Without friction: spheres with it would be packed tighter than they can stand.
            let made_with = Material {
                viscosity: 300.0,
                ..MATERIAL
            };
            words.extend([
                ("atoms", "sphere".to_string()),
                ("style", "granular".to_string()),
                ("law", made_with.granular(Some(MATERIAL.mass(VOLUME)), 0.0)),
            ]);
        }
        words
    }

    /// The data file, made when missing.
    pub fn file(&self, lammps: &Lammps) -> Result<PathBuf> {
        let mut words = self.variables();
        let mut parts = vec![text_of("make.lmp")?, lammps.release.as_str()];
        parts.extend(
            words
                .iter()
                .flat_map(|(name, value)| [*name, value.as_str()]),
        );
        let key = cache::key(&parts);
        let home = cache::directory()?.join("packings");
        fs::create_dir_all(&home)?;
        let _lock = cache::lock("packings")?;
        let file = home.join(format!("{key}.data"));
        if file.is_file() {
            return Ok(file);
        }
        let what = if self.spheres { "spheres, " } else { "" };
        let progress = Progress::start(format!(
            "Packing {what}{} ({} lattice points)",
            self.kind.title(),
            self.lattice.iter().product::<usize>()
        ));
        // Under another name until it is whole.
        let fresh = home.join(format!("{key}.new"));
        words.push(("data", path_word(&fresh)?));
        let made = lammps.run("make.lmp", 1, None, &words);
        match &made {
            Ok(_) => progress.finish(),
            Err(_) => progress.clear(),
        }
        made?;
        fs::rename(&fresh, &file)?;
        Ok(file)
    }
}

/// The same data file for `atom_style ellipsoid superellipsoid`, which wants the block exponents too.
pub fn for_superellipsoids(file: &Path) -> Result<PathBuf> {
    let target = file.with_extension("superellipsoids.data");
    if !target.is_file() {
        let text =
            fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
        fs::write(&target, with_exponents(&text))
            .with_context(|| format!("cannot write {}", target.display()))?;
    }
    Ok(target)
}

fn with_exponents(data: &str) -> String {
    let mut text = String::with_capacity(data.len() + 8);
    let mut inside = false;
    for line in data.lines() {
        let numbers = line.split_whitespace().count();
        // Sections begin with a word on a line of its own.
        if line.starts_with(|c: char| c.is_ascii_alphabetic()) {
            inside = line.trim() == "Ellipsoids";
        }
        text += line;
        if inside && numbers == 8 {
            text += " 2 2";
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::with_exponents;

    #[test]
    fn only_ellipsoids_get_exponents() {
        let data = "2 atoms\n\nAtoms # ellipsoid\n\n1 1 1 2500 0 0 0 0\n\nEllipsoids\n\n1 2 1 1 1 0 0 0\n\nVelocities\n\n1 0 0 0 0 0 0\n";
        let text = with_exponents(data);
        assert!(text.contains("\n1 2 1 1 1 0 0 0 2 2\n"), "{text}");
        assert_eq!(text.matches(" 2 2\n").count(), 1);
    }
}
