// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a single ellipsoid on a plane move as the closed forms of rigid bodies say: rebound at any tilt, rocking, sliding into rolling?

use crate::engines::closed_forms::{self, Setting};
use crate::harness::{run, Deck, Engine, Frame};

fn in_lammps(name: &str, setting: &Setting) -> Vec<Frame> {
    let [e, nu, eta1, eta2] = setting.material;
    let tangential = if setting.friction > 0.0 {
        format!("tfd {}", setting.friction)
    } else {
        "none".into()
    };
    let law = format!("nfd {e:e} {nu} {eta1:e} {eta2:e} tangential {tangential}");
    let mut fixes = vec![format!(
        "fix floor all wall/gran/ellipsoid {law} zplane 0.0 NULL"
    )];
    if setting.gravity > 0.0 {
        fixes.push(format!(
            "fix fall all gravity {} vector 0 0 -1",
            setting.gravity
        ));
    }
    let deck = Deck {
        fixes,
        time_step: setting.time_step,
        steps: setting.steps,
        dump_every: setting.dump_every,
        skin: 1e-3,
        ..Deck::new(&law)
    };
    run(&Engine::from_environment(), name, &setting.scene, &deck, 1).frames
}

#[test]
fn both_versions_rebound_without_friction_at_any_tilt() {
    closed_forms::smooth_rebound(&in_lammps);
}

#[test]
fn both_versions_rebound_sliding_in_a_plane_of_symmetry() {
    closed_forms::sliding_rebound(&in_lammps);
}

#[test]
fn both_versions_rocking_with_and_without_friction() {
    closed_forms::rocking(&in_lammps);
}

#[test]
fn both_versions_spheroids_slide_and_then_roll() {
    closed_forms::sliding_into_rolling(&in_lammps);
}
