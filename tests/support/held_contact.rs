// SPDX-License-Identifier: MIT OR Apache-2.0
//! One contact of `displacement hysteretic`, held and moved by hand: its law, its curvature and what it remembers.

use super::scene::pair_law;
use ellgran::force::hertz_factors::{exact, Factors};
use ellgran::force::{normal_force, PairLaw, Springs, SPRINGS};
use ellgran::vector::{Symmetric2, Vector2};

/// No displacement, no velocity, no force.
pub const NONE: Vector2 = Vector2 { u: 0.0, v: 0.0 };

/// A contact that has not been touched yet.
pub struct HeldContact {
    pub law: PairLaw,
    pub curvature: Symmetric2,
    pub springs: Springs<Vector2>,
    pub memory: Vector2,
    pub energy: f64,
    /// Work done on the contact.
    pub work: f64,
    pub force: Vector2,
}

impl HeldContact {
    /// With the words of a law.
    pub fn new(words: &str, curvature: Symmetric2) -> HeldContact {
        HeldContact {
            law: pair_law(words),
            curvature,
            springs: Springs {
                forces: [NONE; SPRINGS],
                reference: 0.0,
                penetration: 0.0,
            },
            memory: NONE,
            energy: 0.0,
            work: 0.0,
            force: NONE,
        }
    }

    pub fn factors(&self) -> Factors<f64> {
        exact(self.curvature.trace(), self.curvature.determinant(), true)
    }

    /// Force and stiffness of the contact at rest, at this penetration, and the rounding of one a hundred times as long as deep.
    pub fn normal_force(&self, depth: f64) -> (f64, f64, f64) {
        let (kinds, constants) = (&self.law.kinds.normal, &self.law.constants.normal);
        let (factors, determinant) = (self.factors(), self.curvature.determinant());
        let n = normal_force(kinds, constants, depth, 0.0, determinant, &factors, 1.0);
        (n.force, n.stiffness, 1e-12)
    }
}
