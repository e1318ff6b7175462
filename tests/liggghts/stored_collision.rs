// SPDX-License-Identifier: MIT OR Apache-2.0
//! Does a collision of two ellipsoids end as the stored one that is held against finite elements?

use std::f64::consts::PI;

use crate::engines::stored_collision::{check, deck, BULK_VISCOSITY, FRICTION, SHEAR_VISCOSITY};
use crate::harness::{execute, fresh_directory, Engine};

#[test]
fn an_oblique_collision_ends_as_the_stored_one() {
    let engine = Engine::from_environment();
    let turned = format!("{:e} 0 {:e} 0", (PI / 8.0).cos(), -(PI / 8.0).sin());
    let deck = deck(
        "pair.lig",
        &[
            ("shear", format!("{SHEAR_VISCOSITY:e}")),
            ("bulk", format!("{BULK_VISCOSITY:e}")),
            ("friction", FRICTION.to_string()),
            ("axes", "2 1 1".to_string()),
            ("turned", turned.clone()),
            ("turned2", turned),
        ],
    );
    let (success, output) = execute(&engine, &fresh_directory("stored_collision"), &deck, 1);
    assert!(success, "{output}");
    // Another scheme of motion, whose error of the step is another one: with four times as many steps the two differ by a quarter of it.
    check(&output, 1e-4);
}
