// SPDX-License-Identifier: MIT OR Apache-2.0
//! `nfd`: Hertz' force with the relaxation time that follows from two viscosities and a closure (docs/theory.md, section 3).

use super::super::damping::{normal_relaxation_time, tangential_relaxation_numbers};
use super::super::parameters::LawParameters;
use super::hertz;
use super::{Formula, Law, Resolved};

pub(super) struct Nfd;

impl Law for Nfd {
    const FORMULA: Formula = Formula::Hertz;

    fn resolve(i: &LawParameters, j: &LawParameters, _: &LawParameters) -> Resolved {
        hertz::by_compliance(i, j, |p| normal_relaxation_time(&p.material(), p.closure))
    }

    fn tangential_relaxation(p: &LawParameters) -> (f64, f64) {
        tangential_relaxation_numbers(&p.material(), p.closure)
    }
}
