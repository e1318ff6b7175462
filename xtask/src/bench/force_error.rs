// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far a contender's elastic normal force is from elliptical Hertz, on contacts of a packing.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use super::contender::{Contender, Model};
use super::lammps_run::Lammps;
use super::packing::{CONTACT_RADIUS, MATERIAL};
use super::scenes::Engines;
use super::Effort;
use crate::engine_forces::{
    in_lammps, in_lammps_on, in_liggghts, pairs_in_reach, relative_error, thinned, LammpsStyle,
    LiggghtsModel, Pair, Wrench,
};
use crate::packed_grains::PackedGrains;
use crate::shapes::length;

/// Of the force as a vector, over Hertz' force; a contact that is missed is off by 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceError {
    pub median: f64,
    /// 95 % of the contacts are below.
    pub high: f64,
}

/// Contacts of a packing and Hertz' force in them.
pub struct Reference {
    contacts: Vec<Pair>,
    forces: Vec<Wrench>,
}

impl Reference {
    pub fn of(packing: &Path, lammps: &Lammps, effort: &Effort) -> Result<Self> {
        let text = fs::read_to_string(packing)
            .with_context(|| format!("cannot read {}", packing.display()))?;
        let (reach, wanted) = if effort.quick {
            (2000, 100)
        } else {
            (20_000, 1000)
        };
        let pairs = pairs_in_reach(&PackedGrains::read(&text)?, reach);
        let ours = |pairs: &[Pair]| of_ours(lammps, "scalar", &hertz(), pairs);
        let forces = ours(&pairs)?;
        let touching: Vec<Pair> = pairs
            .into_iter()
            .zip(forces)
            .filter(|(_, wrench)| length(wrench.force) > 0.0)
            .map(|(pair, _)| pair)
            .collect();
        let contacts = thinned(touching, wanted);
        // Again, where the contenders see them: elsewhere the coordinates are rounded differently.
        let forces = ours(&contacts)?;
        Ok(Reference { contacts, forces })
    }

    /// `None` where there is nothing to compare.
    pub fn error_of(&self, contender: Contender, engines: &Engines) -> Result<Option<ForceError>> {
        if self.contacts.is_empty() || contender.spheres() {
            return Ok(None);
        }
        let lammps = &engines.lammps;
        let found = match contender {
            Contender::Ours(set) | Contender::OursMoved(set, _) => {
                let law = format!(
                    "nfd {} {} 0 0 conservative no",
                    MATERIAL.youngs_modulus, MATERIAL.poissons_ratio
                );
                of_ours(lammps, set, &law, &self.contacts)?
            }
            Contender::Superellipsoid => in_lammps(
                &lammps.binary,
                &LammpsStyle {
                    atoms: "superellipsoid",
                    style: "granular/superellipsoid",
                    coefficients: &MATERIAL.superellipsoid(None, 0.0, CONTACT_RADIUS),
                    plugin: &lammps.plugin,
                },
                &self.contacts,
            )?,
            Contender::Liggghts(model, optimisation) => {
                let engine = engines.liggghts.as_ref().context("LIGGGHTS is not there")?;
                of_liggghts(engine.binary(optimisation)?, model, &self.contacts)?
            }
            Contender::Spheres => return Ok(None),
        };
        let mut errors: Vec<f64> = found
            .iter()
            .zip(&self.forces)
            .map(|(found, reference)| relative_error(found, reference))
            .collect();
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors[((errors.len() - 1) as f64 * share).round() as usize];
        Ok(Some(ForceError {
            median: at(0.5),
            high: at(0.95),
        }))
    }
}

fn hertz() -> String {
    format!("{} conservative no", MATERIAL.elastic())
}

fn of_ours(
    lammps: &Lammps,
    instruction_set: &str,
    law: &str,
    pairs: &[Pair],
) -> Result<Vec<Wrench>> {
    in_lammps_on(
        &lammps.binary,
        &LammpsStyle {
            atoms: "ellipsoid",
            style: "gran/ellipsoid",
            coefficients: law,
            plugin: &lammps.plugin,
        },
        Some(instruction_set),
        pairs,
    )
}

fn of_liggghts(binary: &Path, model: Model, pairs: &[Pair]) -> Result<Vec<Wrench>> {
    in_liggghts(
        binary,
        &LiggghtsModel {
            model: &model.normal_words(),
            youngs_modulus: MATERIAL.youngs_modulus,
            poissons_ratio: MATERIAL.poissons_ratio,
        },
        pairs,
    )
}
