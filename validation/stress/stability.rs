// SPDX-License-Identifier: MIT OR Apache-2.0
//! Time steps up to and beyond stability: the largest with which two bodies still move as they should, beside what the library
//! advises (src/contact/stability.rs).

use std::fmt::Write;
use std::path::Path;

use crate::support::motion::{Motion, Partner, Rigid};
use crate::support::scene::{geometry, laws};
use crate::support::stability::{grows, overlapping};
use ellgran::contact::prepare_body;
use ellgran::contact::stability::{collision, contact_stiffness};
use ellgran::contact::{Body, Laws};

/// First touch falls anywhere in a step: so many places are tried.
const PHASES: usize = 16;
/// Steps are sought with which no collision leaves more energy than it found by more than this share.
pub const GAIN: f64 = 1e-2;
/// LAMMPS' plugin advises so many steps for the shortest collision, and the critical step where that is shorter.
const STEPS_OF_A_COLLISION: f64 = 10.0;
/// Overlap at which small motions are tried, in semi-axes. A deeper contact that is pressed by a force of constant direction
/// buckles, slowly, which is no matter of the step.
const PRESSED: f64 = 1e-5;
const SPEED: f64 = 0.1;
const SMALL: f64 = 1e-3;

/// None to overdamped.
pub const DECKS: [&str; 10] = [
    "hertz 1e9 0.3",
    "hertz 1e9 0.3 tangential mindlin 0.5",
    "hertz 1e9 0.3 damping restitution 0.9",
    "hertz 1e9 0.3 damping restitution 0.1",
    "hertz 1e9 0.3 damping restitution 0.001",
    "nfd 1e9 0.3 1e2 1e2 tangential tfd 0.5",
    "nfd 1e9 0.3 1e4 1e4 tangential tfd 0.5",
    "nfd 1e9 0.3 1e6 1e6 tangential tfd 0.5",
    "lsd 1e5 1 tangential linear 8e4 1 0.5",
    "lsd 1e5 1e2 tangential linear 8e4 1e2 0.5",
];

pub const MASS_RATIOS: [f64; 3] = [1.0, 1e3, 1e9];

/// One law, shape and mass ratio.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub deck: &'static str,
    pub shape: &'static str,
    pub mass_ratio: f64,
}

/// Steps of one case, all in time.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    /// For small motions about a shallow contact: as the library says, and found.
    pub critical: f64,
    pub critical_found: f64,
    /// How long the elastic collision at the case's speed lasts.
    pub collision: f64,
    /// What is advised for it.
    pub advised: f64,
    /// The largest gain of energy with the advised step, a share of the energy before.
    pub gain: f64,
    /// The largest step with which no collision gains more than [`GAIN`].
    pub collision_found: f64,
}

impl Case {
    pub fn all() -> impl Iterator<Item = Case> {
        ["spheres", "ellipsoids"].into_iter().flat_map(|shape| {
            DECKS.into_iter().flat_map(move |deck| {
                MASS_RATIOS.into_iter().map(move |mass_ratio| Case {
                    deck,
                    shape,
                    mass_ratio,
                })
            })
        })
    }

    /// The lighter body above the heavier one, apart.
    fn bodies(&self) -> (Body, Body) {
        let sphere = self.shape == "spheres";
        let one = |mass: f64, position: [f64; 3], quaternion: [f64; 4]| Body {
            position,
            quaternion,
            semi_axes: if sphere {
                [SMALL; 3]
            } else {
                [2.0 * SMALL, SMALL, 1.3 * SMALL]
            },
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            mass,
            particle_type: 1,
            identifier: 1,
        };
        let mass = 1e-5;
        (
            one(mass * self.mass_ratio, [0.0; 3], [0.9, 0.1, -0.3, 0.2]),
            one(mass, [0.0, 0.0, 5.0 * SMALL], [0.5, -0.6, 0.2, 0.4]),
        )
    }

    pub fn measure(&self) -> Steps {
        let laws = laws(&[self.deck]);
        let (i, j) = self.bodies();
        let prepare = |b: &Body| prepare_body(b, Some(1)).expect("within the ranges");
        let elastic = collision(&laws, &prepare(&i), &prepare(&j), SPEED).expect("exact factors");
        let critical_at = |overlap: f64| {
            let (i, j) = overlapping(i, j, overlap);
            let stiffness = contact_stiffness(&laws, &prepare(&i), &prepare(&j));
            let stiffness = stiffness.expect("exact factors").expect("a contact");
            (stiffness.critical_step, i, j)
        };
        let (critical, a, b) = critical_at(PRESSED * SMALL);
        // What sticks must not slide away in the test of small motions.
        let sticking = crate::support::scene::laws(&[&self.deck.replace(" 0.5", " 1e9")]);
        let deepest = critical_at(elastic.penetration).0;
        let advised = deepest.min(elastic.time / STEPS_OF_A_COLLISION);
        let gain = |step: f64| self.gain(&laws, elastic.penetration, step);
        Steps {
            critical,
            critical_found: largest(critical, |step| !grows(&sticking, &a, &b, step)),
            collision: elastic.time,
            advised,
            gain: gain(advised),
            collision_found: largest(advised, |step| gain(step) <= GAIN),
        }
    }

    /// The largest gain of energy in a collision, wherever in a step it begins.
    fn gain(&self, laws: &Laws, penetration: f64, step: f64) -> f64 {
        let of = |phase: usize| {
            let (i, j) = self.bodies();
            let (i, mut j) = overlapping(i, j, 1e-3 * penetration);
            // A hair apart, and then part of a step.
            let back = 2e-3 * penetration + SPEED * step * phase as f64 / PHASES as f64;
            let n = geometry(&i, &j).normal.to_array();
            for (k, n) in n.into_iter().enumerate() {
                j.position[k] += back * n;
                j.velocity[k] = -SPEED * n;
            }
            let mut motion = Motion::new(laws, i, Partner::Body(Rigid::new(j)), step);
            let before = motion.kinetic_energy();
            // Long enough for an overdamped contact to come to rest.
            motion.collide(4000);
            motion.energy() / before - 1.0
        };
        (0..PHASES).map(of).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The largest step for which something holds, to half a per cent; it holds for short ones.
fn largest(about: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (about, about);
    while !holds(low) {
        high = low;
        low *= 0.5;
        if low < 1e-6 * about {
            return 0.0;
        }
    }
    while high == low || holds(high) {
        low = high;
        high *= 1.5;
        if high > 1e3 * about {
            return f64::INFINITY;
        }
    }
    while high > 1.005 * low {
        let middle = (low * high).sqrt();
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// A CSV file of all cases.
pub fn write(file: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut table = String::from(
        "shape,deck,mass_ratio,critical,critical_found,collision,advised,gain,collision_found\n",
    );
    for case in Case::all() {
        let s = case.measure();
        writeln!(
            table,
            "{},{},{:e},{:e},{:e},{:e},{:e},{:.3e},{:e}",
            case.shape,
            case.deck,
            case.mass_ratio,
            s.critical,
            s.critical_found,
            s.collision,
            s.advised,
            s.gain,
            s.collision_found
        )?;
    }
    std::fs::write(file, table)?;
    Ok(())
}
