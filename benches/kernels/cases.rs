// SPDX-License-Identifier: MIT OR Apache-2.0
//! The laws that are timed, each with what it leaves out of the full one.

use ellgran::force::syntax::parse;
use ellgran::force::LawParameters;
use ellgran::pairs::Laws;

pub struct Case {
    pub name: &'static str,
    /// The words of `pair_coeff 1 1`.
    law: &'static str,
    /// The words of `pair_coeff 2 2`, for every second grain.
    second: Option<&'static str>,
    pub aspect: f64,
    /// Energies and virial, global and per particle.
    pub energies: bool,
}

const FULL: &str = "nfd 1e7 0.3 50 50 tangential tfd 0.5";

/// The first is the one that the others are compared with.
pub const CASES: &[Case] = &[
    case("full law", FULL),
    Case {
        energies: true,
        ..case("full law, energies and virial asked for", FULL)
    },
    Case {
        second: Some("nfd 3e7 0.2 90 90 tangential tfd 0.3"),
        ..case("full law, two materials", FULL)
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
        aspect: 1.0,
        ..case("spheres, full law", FULL)
    },
    Case {
        aspect: 1.0,
        ..case("spheres, elastic, no friction", "hertz 1e7 0.3")
    },
];

const fn case(name: &'static str, law: &'static str) -> Case {
    Case {
        name,
        law,
        second: None,
        aspect: 2.0,
        energies: false,
    }
}

impl Case {
    pub fn types(&self) -> usize {
        1 + usize::from(self.second.is_some())
    }

    /// Spheres need no normal from the last step.
    pub fn laws(&self) -> Laws {
        let one = |words: &str| -> LawParameters {
            let words: Vec<&str> = words.split(' ').collect();
            parse(&words).expect("a law of the table").0
        };
        let table: Vec<Option<LawParameters>> = match self.second {
            None => vec![Some(one(self.law))],
            Some(second) => vec![Some(one(self.law)), None, None, Some(one(second))],
        };
        Laws::new(self.types(), &table, self.aspect != 1.0).expect("a law of the table")
    }
}
