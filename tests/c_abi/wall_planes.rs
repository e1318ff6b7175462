// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which parts of a wall are planes without an end, and where do they look? Which shapes are refused?

use std::ffi::{c_char, CString};
use std::ptr::{null, null_mut};

use ellgran::c_api::rigid_wall::*;
use ellgran::c_api::status::*;

use crate::scene::*;

fn normal_of(wall: &WallHandle, part: usize) -> [f64; 3] {
    plane_of(wall, part).0
}

/// Normal, and whether it acts on both sides.
fn plane_of(wall: &WallHandle, part: usize) -> ([f64; 3], i32) {
    let (mut normal, mut both_sides) = ([f64::NAN; 3], 7);
    ok(unsafe { ellgran_wall_part_plane(wall.0, part, normal.as_mut_ptr(), &mut both_sides) });
    (normal, both_sides)
}

/// Adds the shape that these words describe.
fn add_words(wall: &WallHandle, words: &str) {
    let words: Vec<CString> = (words.split(' '))
        .map(|word| CString::new(word).unwrap())
        .collect();
    let words: Vec<*const c_char> = words.iter().map(|word| word.as_ptr()).collect();
    let mut read = 0;
    ok(unsafe { ellgran_wall_add_shape_words(wall.0, words.len(), words.as_ptr(), &mut read) });
    assert_eq!(read, words.len());
}

/// Each part beside the normal that follows from its words by hand.
#[test]
fn normals_are_those_of_the_words() {
    let wall = WallHandle::new();
    for words in [
        "plane",
        "plane axis 0 3 -4 point 1 2 3 side inside",
        "plane side outside axis 0 0 2e-9",
        "plane axis -5 0 0 side centre",
        "sphere radius 1 side inside",
    ] {
        add_words(&wall, words);
    }
    let tolerance = 2.0 * f64::EPSILON; // of a division and a root
    for (part, expected, acts_on_both) in [
        (0, [0.0, 0.0, 1.0], 1),
        (1, [0.0, 0.6, -0.8], 0),
        (2, [0.0, 0.0, -1.0], 0),
        (3, [-1.0, 0.0, 0.0], 1),
        (4, [0.0; 3], 0),
    ] {
        let (normal, both_sides) = plane_of(&wall, part);
        assert_eq!(both_sides, acts_on_both, "part {part}");
        for k in 0..3 {
            assert!(
                (normal[k] - expected[k]).abs() <= tolerance,
                "part {part}: {normal:?}"
            );
        }
    }
}

/// Closed ends around the particles go on beyond their edges; those that particles may be beside, and triangles, end.
#[test]
fn only_faces_without_an_end_are_planes() {
    let ends = "bounds 0 2 ends closed closed";
    let within = WallHandle::new();
    add_words(&within, &format!("cylinder radius 1 {ends} side inside"));
    let expected = [[0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    for (part, expected) in expected.into_iter().enumerate() {
        assert_eq!(normal_of(&within, part), expected, "part {part}");
    }
    let others = WallHandle::new();
    for side in ["outside", "centre"] {
        add_words(&others, &format!("cylinder radius 1 {ends} side {side}"));
    }
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    ok(unsafe { ellgran_wall_add_triangles(others.0, 1, corners.as_ptr().cast()) });
    let parts = unsafe { ellgran_wall_part_count(others.0) };
    assert!(parts > 3, "{parts}");
    for part in 0..parts {
        assert_eq!(normal_of(&others, part), [0.0; 3], "part {part}");
    }
}

#[test]
fn what_cannot_be_asked() {
    let wall = WallHandle::plane([0.0; 3], [0.0, 0.0, 1.0]);
    let mut normal = [7.0; 3];
    let ask =
        |wall, part, normal| unsafe { ellgran_wall_part_plane(wall, part, normal, null_mut()) };
    for (part, out) in [(1, "part = 1"), (usize::MAX, "18446744073709551615")] {
        let status = ask(wall.0.cast_const(), part, normal.as_mut_ptr());
        fails(status, ELLGRAN_ERROR_ARGUMENT, &[out, "1 parts"]);
    }
    let null_pointer = ELLGRAN_ERROR_NULL_POINTER;
    fails(ask(null(), 0, normal.as_mut_ptr()), null_pointer, &["wall"]);
    fails(ask(wall.0, 0, null_mut()), null_pointer, &["normal"]);
    assert_eq!(normal, [7.0; 3]);
}

/// Of a shape that is not there its name is told, not the axis that it lacks.
#[test]
fn a_shape_without_name_or_axis() {
    let wall = WallHandle::new();
    for (name, words) in [
        (
            c"Sphere",
            &["'Sphere'", "plane, cylinder, cone, sphere"][..],
        ),
        (c"", &["''", "plane, cylinder, cone, sphere"]),
        (c"plane", &["'plane'", "axis = 0 0 0"]),
    ] {
        let mut given = shape(name);
        given.axis = [0.0; 3];
        let status = unsafe { ellgran_wall_add_shape(wall.0, &given) };
        fails(status, ELLGRAN_ERROR_ARGUMENT, words);
    }
}

/// A block has an inside, and both of its corners.
#[test]
fn a_block_without_an_inside() {
    let wall = WallHandle::new();
    let (low, high) = ([0.0, -1.0, 2.0], [1.0, 1.0, 3.0]);
    let add = |low: *const [f64; 3], high: *const [f64; 3]| unsafe {
        ellgran_wall_add_block(wall.0, low.cast(), high.cast())
    };
    for (low, high) in [(high, low), (low, low), (low, [f64::NAN, 1.0, 3.0])] {
        let status = add(&low, &high);
        fails(status, ELLGRAN_ERROR_ARGUMENT, &["a block from"]);
    }
    fails(
        add(&low, &[1e300; 3]),
        ELLGRAN_ERROR_ARGUMENT,
        &["out of range"],
    );
    for (low, high, name) in [
        (null(), &raw const high, "low"),
        (&raw const low, null(), "high"),
    ] {
        fails(
            add(low, high),
            ELLGRAN_ERROR_NULL_POINTER,
            &[name, "must not be NULL"],
        );
    }
    assert_eq!(unsafe { ellgran_wall_part_count(wall.0) }, 0);
    ok(add(&low, &high));
    assert_eq!(unsafe { ellgran_wall_part_count(wall.0) }, 1);
}
