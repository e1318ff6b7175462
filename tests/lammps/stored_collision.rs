// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a collision of two ellipsoids end as the stored one that is held against finite elements?

use crate::engines::stored_collision::{
    check, deck, mass, BULK_VISCOSITY, FRICTION, SHEAR_VISCOSITY,
};
use crate::harness::{execute, fresh_directory, last_lines, Engine};

#[test]
fn an_oblique_collision_ends_as_the_stored_one() {
    let engine = Engine::from_environment();
    let law = format!("nfd 1 0.3 {SHEAR_VISCOSITY:e} {BULK_VISCOSITY:e} tangential tfd {FRICTION}");
    let deck = deck(
        "pair.lmp",
        &[
            ("plugin", engine.plugin.display().to_string()),
            ("law", law),
            ("mass", format!("{:e}", mass())),
            ("axes", "4 2 2".to_string()),
            ("turned", "0 -1 0 45".to_string()),
            ("turned2", "0 -1 0 45".to_string()),
        ],
    );
    let (success, output) = execute(&engine, &fresh_directory("stored_collision"), &deck, 1);
    assert!(success, "{}", last_lines(&output));
    // The same steps by the same scheme.
    check(&output, 1e-7);
}
