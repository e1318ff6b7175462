// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pair styles and contact models that are compared, and their words for the same material.

use super::packing::{CONTACT_RADIUS, MATERIAL, VOLUME};
use crate::liggghts::Optimisation;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contender {
    /// In LAMMPS, on an instruction set, with the engine's integrator.
    Ours(&'static str),
    /// The same with `fix nve/ellipsoid`.
    OursMoved(&'static str, Velocities),
    Superellipsoid,
    Spheres,
    Liggghts(Model, Optimisation),
}

/// Those that forces see with `fix nve/ellipsoid`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Velocities {
    Step,
    Half,
}

impl Velocities {
    pub const ALL: [Velocities; 2] = [Velocities::Step, Velocities::Half];

    /// After `nve/`.
    fn words(self) -> &'static str {
        match self {
            Velocities::Step => "ellipsoid velocities step",
            Velocities::Half => "ellipsoid velocities half",
        }
    }
}

/// Contact models of LIGGGHTS.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Model {
    /// Ours.
    Nfd,
    /// Ours, with `fix nve/ellipsoid`.
    NfdMoved(Velocities),
    /// LIGGGHTS' own Hertz on our geometry.
    HertzOnEllipsoids,
    Superquadric,
    MeanCurvature,
    GaussianCurvature,
    Spheres,
}

/// Of the contact models that take one; NFD takes viscosities.
const RESTITUTION: f64 = 0.9;
/// Beyond every radius of curvature of the scenes: without it LIGGGHTS takes the radius of the sphere of equal volume.
const CURVATURE_LIMIT: f64 = 1e3;

impl Contender {
    pub fn label(self) -> String {
        match self {
            Contender::Ours(set) => format!("gran/ellipsoid, {set}"),
            Contender::OursMoved(set, velocities) => {
                format!("gran/ellipsoid, {set}, nve/{}", velocities.words())
            }
            Contender::Superellipsoid => "granular/superellipsoid".into(),
            Contender::Spheres => "granular, spheres".into(),
            Contender::Liggghts(model, optimisation) => {
                let mut label = format!("LIGGGHTS {}, {}", optimisation.flag(), model.label());
                if let Model::NfdMoved(velocities) = model {
                    label += &format!(", nve/{}", velocities.words());
                }
                label
            }
        }
    }

    pub fn instruction_set(self) -> Option<&'static str> {
        match self {
            Contender::Ours(set) | Contender::OursMoved(set, _) => Some(set),
            _ => None,
        }
    }

    pub fn spheres(self) -> bool {
        matches!(
            self,
            Contender::Spheres | Contender::Liggghts(Model::Spheres, _)
        )
    }

    /// Seconds that a step of a grain of a dense packing may take: the length of runs is guessed by it.
    pub fn cost(self) -> f64 {
        match self {
            Contender::Ours("scalar") => 2.5e-6,
            Contender::Ours(_) | Contender::OursMoved(..) => 1e-6,
            Contender::Superellipsoid => 15e-6,
            Contender::Spheres => 0.5e-6,
            Contender::Liggghts(Model::Spheres, _) => 1e-6,
            Contender::Liggghts(Model::Nfd | Model::NfdMoved(_) | Model::HertzOnEllipsoids, _) => {
                5e-6
            }
            Contender::Liggghts(..) => 10e-6,
        }
    }

    /// Variables of run.lmp.
    pub fn variables(self) -> Vec<(&'static str, String)> {
        let mass = Some(MATERIAL.mass(VOLUME));
        let (atoms, style, law) = match self {
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
            Contender::Ours(_) | Contender::OursMoved(..) | Contender::Liggghts(..) => (
                "ellipsoid",
                "gran/ellipsoid",
                MATERIAL.with_friction(&MATERIAL.viscoelastic()),
            ),
        };
        let mut variables = vec![
            ("atoms", atoms.into()),
            ("style", style.into()),
            ("law", law),
        ];
        if let Contender::OursMoved(_, velocities) = self {
            variables.push(("integrator", format!("nve/{}", velocities.words())));
        }
        variables
    }

    /// Instruction sets of this machine, narrowest first, as ELLGRAN_INSTRUCTION_SET takes them.
    pub fn instruction_sets() -> Vec<&'static str> {
        #[allow(unused_mut)]
        let mut sets = vec!["scalar", "baseline"];
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

impl Model {
    pub fn label(self) -> &'static str {
        match self {
            Model::Nfd | Model::NfdMoved(_) => "nfd, tfd, surface ellipsoid",
            Model::HertzOnEllipsoids => "hertz, history, surface ellipsoid",
            Model::Superquadric => "superquadric",
            Model::MeanCurvature => "superquadric, mean curvature",
            Model::GaussianCurvature => "superquadric, Gaussian curvature",
            Model::Spheres => "spheres",
        }
    }

    pub fn atoms(self) -> &'static str {
        match self {
            Model::Spheres => "sphere",
            _ => "superquadric",
        }
    }

    /// After `pair_style gran model`.
    pub fn words(self) -> String {
        let hertz = "hertz tangential history surface";
        match self {
            Model::Nfd | Model::NfdMoved(_) => "nfd tangential tfd surface ellipsoid".into(),
            Model::HertzOnEllipsoids => format!("{hertz} ellipsoid"),
            Model::Superquadric => format!("{hertz} superquadric"),
            Model::MeanCurvature => format!(
                "{hertz} superquadric meanCurvature yes curvatureLimitFactor {CURVATURE_LIMIT}"
            ),
            Model::GaussianCurvature => format!(
                "{hertz} superquadric gaussianCurvature yes curvatureLimitFactor {CURVATURE_LIMIT}"
            ),
            Model::Spheres => format!("{hertz} default"),
        }
    }

    /// The same for a force that is to be compared with Hertz' alone.
    pub fn normal_words(self) -> String {
        match self {
            Model::Nfd | Model::NfdMoved(_) => format!("{} conservative off", self.words()),
            _ => self.words(),
        }
    }

    /// Variables of run.lig.
    pub fn variables(self) -> Vec<(&'static str, String)> {
        let integrator = match self {
            Model::NfdMoved(velocities) => velocities.words(),
            _ => self.atoms(),
        };
        vec![
            ("atoms", self.atoms().into()),
            ("integrator", integrator.into()),
            ("model", self.words()),
            ("e", MATERIAL.youngs_modulus.to_string()),
            ("nu", MATERIAL.poissons_ratio.to_string()),
            ("eta", MATERIAL.viscosity.to_string()),
            ("mu", MATERIAL.friction.to_string()),
            ("r", RESTITUTION.to_string()),
        ]
    }
}
