// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a single ellipsoid on a plane move as the closed forms of rigid bodies say: rebound at any tilt, rocking, sliding into rolling?

use crate::engines::closed_forms::{self, Setting};
use crate::harness::{run, Deck, Engine, Frame};

fn in_liggghts(name: &str, setting: &Setting) -> Vec<Frame> {
    let model = if setting.friction > 0.0 {
        "nfd tangential tfd surface ellipsoid"
    } else {
        "nfd surface ellipsoid"
    };
    let fixes = if setting.gravity > 0.0 {
        vec![format!(
            "fix fall all gravity {} vector 0 0 -1",
            setting.gravity
        )]
    } else {
        vec![]
    };
    let deck = Deck {
        model: model.into(),
        walls: vec!["primitive type 1 zplane 0.0".into()],
        fixes,
        time_step: setting.time_step,
        steps: setting.steps,
        dump_every: setting.dump_every,
        ..Deck::new(setting.material, setting.friction)
    };
    run(&Engine::from_environment(), name, &setting.scene, &deck, 1).frames
}

#[test]
fn rebound_without_friction_at_any_tilt() {
    closed_forms::smooth_rebound(&in_liggghts);
}

#[test]
fn rebound_sliding_in_a_plane_of_symmetry() {
    closed_forms::sliding_rebound(&in_liggghts);
}

#[test]
fn rocking_with_and_without_friction() {
    closed_forms::rocking(&in_liggghts);
}

#[test]
fn spheroids_slide_and_then_roll() {
    closed_forms::sliding_into_rolling(&in_liggghts);
}
