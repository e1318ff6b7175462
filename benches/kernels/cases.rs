// SPDX-License-Identifier: MIT OR Apache-2.0
//! The laws that are timed, each with what it leaves out of the full one. Words and numbers alone, as [`super::packing`].

pub struct Case {
    pub name: &'static str,
    /// The words of `pair_coeff * *`.
    law: &'static str,
    /// Types in turns, each of a material of its own; of more than one the full law.
    materials: usize,
    pub semi_axes: [f64; 3],
    /// Energies and virial, global and per particle.
    pub energies: bool,
}

/// An axis of revolution, which has a kernel of its own; three axes apart, with as many touching pairs in a list that is a
/// fifth shorter; and spheres.
const SPHEROID: [f64; 3] = [2.0, 1.0, 1.0];
const TRIAXIAL: [f64; 3] = [2.0, 1.2, 1.0];
const SPHERE: [f64; 3] = [1.0; 3];

const FULL: &str = "nfd 1e7 0.3 50 50 tangential tfd 0.5";

/// The first is the one that the others are compared with.
pub const CASES: &[Case] = &[
    case("full law", FULL),
    Case {
        semi_axes: TRIAXIAL,
        ..case("full law, three semi-axes", FULL)
    },
    Case {
        energies: true,
        ..case("full law, energies and virial asked for", FULL)
    },
    Case {
        materials: 2,
        ..case("full law, two materials", FULL)
    },
    Case {
        materials: 16,
        ..case("full law, sixteen materials", FULL)
    },
    case(
        "conservative no",
        "nfd 1e7 0.3 50 50 tangential tfd 0.5 conservative no",
    ),
    case(
        "tangential mindlin",
        "nfd 1e7 0.3 50 50 tangential mindlin 0.5",
    ),
    case("elastic with friction", "hertz 1e7 0.3 tangential tfd 0.5"),
    case("viscous, no friction", "nfd 1e7 0.3 50 50"),
    case("elastic, no friction", "hertz 1e7 0.3"),
    case(
        "elastic, no friction, conservative no",
        "hertz 1e7 0.3 conservative no",
    ),
    Case {
        semi_axes: SPHERE,
        ..case("spheres, full law", FULL)
    },
    Case {
        semi_axes: SPHERE,
        ..case("spheres, elastic, no friction", "hertz 1e7 0.3")
    },
];

/// Laws that came later. They are not among [`CASES`] because revisions that these are compared with do not all know their words.
// `cargo xtask bench --against` compiles this file and compares CASES alone.
#[allow(dead_code)]
pub const LATER: &[Case] = &[
    case(
        "displacement hysteretic",
        "nfd 1e7 0.3 50 50 tangential tfd 0.5 displacement hysteretic",
    ),
    case(
        "twisting lubkin",
        "nfd 1e7 0.3 50 50 tangential tfd 0.5 displacement hysteretic twisting lubkin",
    ),
    case(
        "viscosity memory",
        "nfd 1e7 0.3 50 50 tangential tfd 0.5 viscosity memory",
    ),
];

const fn case(name: &'static str, law: &'static str) -> Case {
    Case {
        name,
        law,
        materials: 1,
        semi_axes: SPHEROID,
        energies: false,
    }
}

impl Case {
    /// The words of each type; the pairs of unlike types are mixed from these.
    pub fn words(&self) -> Vec<String> {
        let softer = |k: usize| 1.0 / (1.0 + 0.1 * k as f64);
        let others = (1..self.materials).map(|k| {
            format!(
                "nfd {} 0.3 {} 50 tangential tfd {}",
                1e7 * softer(k),
                50.0 * softer(k),
                0.5 * (1.0 + 0.02 * k as f64)
            )
        });
        std::iter::once(self.law.to_string())
            .chain(others)
            .collect()
    }

    /// Spheres need no normal from the last step.
    pub fn normals_are_kept(&self) -> bool {
        self.semi_axes != SPHERE
    }
}
