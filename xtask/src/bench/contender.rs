// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pair styles that are compared, and their words for the same material.

use super::packing::{CONTACT_RADIUS, MATERIAL, VOLUME};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contender {
    /// On an instruction set.
    Ours(&'static str),
    Superellipsoid,
    Spheres,
}

impl Contender {
    pub fn label(self) -> String {
        match self {
            Contender::Ours(set) => format!("gran/ellipsoid, {set}"),
            Contender::Superellipsoid => "granular/superellipsoid".into(),
            Contender::Spheres => "granular, spheres".into(),
        }
    }

    pub fn instruction_set(self) -> Option<&'static str> {
        match self {
            Contender::Ours(set) => Some(set),
            _ => None,
        }
    }

    pub fn spheres(self) -> bool {
        self == Contender::Spheres
    }

    /// Variables of run.lmp.
    pub fn variables(self) -> Vec<(&'static str, String)> {
        let mass = Some(MATERIAL.mass(VOLUME));
        let (atoms, style, law) = match self {
            Contender::Ours(_) => (
                "ellipsoid",
                "gran/ellipsoid",
                MATERIAL.with_friction(&MATERIAL.viscoelastic()),
            ),
            Contender::Superellipsoid => (
                "superellipsoid",
                "granular/superellipsoid",
                MATERIAL.superellipsoid(mass, MATERIAL.friction, CONTACT_RADIUS),
            ),
            Contender::Spheres => (
                "sphere",
                "granular",
                MATERIAL.granular(mass, MATERIAL.friction),
            ),
        };
        vec![
            ("atoms", atoms.into()),
            ("style", style.into()),
            ("law", law),
        ]
    }

    /// Instruction sets of this machine, narrowest first, as ELLGRAN_INSTRUCTION_SET takes them.
    pub fn instruction_sets() -> Vec<&'static str> {
        #[allow(unused_mut)]
        let mut sets = vec!["scalar"];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                sets.push("avx2");
            }
            if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
                sets.push("avx512");
            }
        }
        sets
    }
}
