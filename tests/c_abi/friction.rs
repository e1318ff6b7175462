// SPDX-License-Identifier: MIT OR Apache-2.0
//! Friction given per pair of types: do laws that were given it later act as laws that were built with it?

use std::ptr::null_mut;

use ellgran::c_api::law::*;
use ellgran::c_api::status::*;

use crate::scene::*;

fn nfd(friction: f64) -> String {
    format!("nfd 1e4 0.3 40 60 tangential tfd {friction}")
}

fn with_friction(laws: &Laws, friction: &[f64]) -> Laws {
    let mut changed = null_mut();
    // SAFETY: as many coefficients as pairs of types.
    ok(unsafe { ellgran_laws_with_friction(laws.0, friction.as_ptr(), &mut changed) });
    Laws(changed)
}

/// Force and history of a sliding contact of bodies of these types, after some steps.
fn slide(laws: &Laws, kinds: [i32; 2]) -> ([f64; 3], Vec<f64>) {
    let (mut i, mut j) = (sphere_at(0.0), sphere_at(1.9));
    [i.particle_type, j.particle_type] = kinds;
    i.semi_axes = [1.0, 0.8, 0.9];
    j.velocity = [0.0, 0.3, 0.2];
    let mut force = [0.0; 3];
    let (mut touching, mut history) = (0, vec![0.0; laws.length()]);
    for _ in 0..10 {
        let (_, f) = laws.contact([&i, &j], &STEP, &mut touching, &mut history);
        force = f.force;
        let mut both = [i, j];
        advance(&mut both, STEP.time_step);
        [i, j] = both;
    }
    assert_eq!(touching, 1);
    (force, history)
}

#[test]
fn each_pair_of_types_has_its_own() {
    let built = Laws::new(&[&nfd(1.0), &nfd(1.0)]);
    let changed = with_friction(&built, &[0.1, 0.3, 0.3, 0.7]);
    for (kinds, friction) in [([1, 1], 0.1), ([1, 2], 0.3), ([2, 1], 0.3), ([2, 2], 0.7)] {
        let wanted = slide(&Laws::new(&[&nfd(friction), &nfd(friction)]), kinds);
        assert_eq!(slide(&changed, kinds), wanted, "{kinds:?}");
        assert_ne!(slide(&built, kinds), wanted, "{kinds:?}");
    }
}

#[test]
fn none_where_it_is_zero_and_the_history_keeps_its_length() {
    let built = Laws::new(&[&nfd(0.5), &nfd(0.5)]);
    let changed = with_friction(&built, &[0.0; 4]);
    assert_eq!(changed.length(), built.length());
    let (force, history) = slide(&changed, [1, 2]);
    let without = Laws::new(&["nfd 1e4 0.3 40 60", "nfd 1e4 0.3 40 60"]);
    assert_eq!(force, slide(&without, [1, 2]).0);
    assert!(history[3..].iter().all(|h| *h == 0.0), "{history:?}");
    // A law without a tangential part gets none.
    let frictionless = with_friction(&without, &[0.5; 4]);
    assert_eq!(slide(&frictionless, [1, 2]).0, force);
}

#[test]
fn coefficients_that_cannot_be() {
    let laws = Laws::new(&[&nfd(0.5), &nfd(0.5)]);
    for wrong in [-0.1, f64::NAN, f64::INFINITY] {
        let mut out = Untouched::<*mut EllgranLaws>::new();
        let friction = [0.1, 0.1, wrong, 0.1];
        // SAFETY: all pointers are valid.
        let status =
            unsafe { ellgran_laws_with_friction(laws.0, friction.as_ptr(), out.pointer()) };
        fails(
            status,
            ELLGRAN_ERROR_LAW,
            &["types 2 and 1", "friction", &wrong.to_string()],
        );
        out.check();
    }
}
