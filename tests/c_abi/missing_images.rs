// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where does a mesh end at the boundary of a box that repeats, as the C interface tells it?

use std::ptr::{null, null_mut};

use ellgran::c_api::rigid_wall::*;
use ellgran::c_api::status::*;

use crate::scene::*;

/// A floor from -1 to 1 along x.
fn floor() -> WallHandle {
    let wall = WallHandle::new();
    let at = |x: f64, y: f64| [x, 9.0 * y, 0.0];
    let corners = [
        [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0)],
        [at(-1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)],
    ];
    ok(unsafe { ellgran_wall_add_triangles(wall.0, 2, corners.as_ptr().cast()) });
    wall
}

struct Box {
    low: [f64; 3],
    high: [f64; 3],
    is_periodic: [i32; 3],
}

const BOX: Box = Box {
    low: [-1.0; 3],
    high: [1.0; 3],
    is_periodic: [1, 0, 0],
};

/// Status, axis, triangle and place.
fn missing(
    wall: &WallHandle,
    motion: *const EllgranWallMotion,
    domain: &Box,
    reach: f64,
) -> (i32, i32, usize, [f64; 3]) {
    let (mut axis, mut triangle, mut place) = (7, 7, [7.0; 3]);
    let status = unsafe {
        ellgran_wall_missing_image(
            wall.0,
            motion,
            domain.low.as_ptr(),
            domain.high.as_ptr(),
            domain.is_periodic.as_ptr(),
            reach,
            &mut axis,
            &mut triangle,
            place.as_mut_ptr(),
        )
    };
    (status, axis, triangle, place)
}

#[test]
fn the_place_is_beyond_the_boundary() {
    let wall = floor();
    let (status, axis, triangle, place) = missing(&wall, null(), &BOX, 0.1);
    ok(status);
    assert_eq!(axis, 0);
    assert!(triangle < 2, "{triangle}");
    assert!((1.0..1.11).contains(&place[0].abs()), "{place:?}");
    assert_eq!(place[2], 0.0);
    // In a shorter box it goes on by a quarter, and where the box does not repeat nothing is missing.
    let shorter = Box {
        low: [-0.75; 3],
        high: [0.75; 3],
        ..BOX
    };
    let open = Box {
        is_periodic: [0; 3],
        ..BOX
    };
    for (domain, reach) in [(&shorter, 0.2), (&open, 0.2), (&BOX, 0.0), (&BOX, f64::NAN)] {
        let (status, axis, triangle, place) = missing(&wall, null(), domain, reach);
        ok(status);
        assert_eq!((axis, triangle, place), (-1, 7, [7.0; 3]));
    }
    // Moved, it ends within it on one side.
    let mut motion = REST;
    motion.displacement[0] = 0.2;
    let (status, axis, ..) = missing(&wall, &motion, &shorter, 0.2);
    ok(status);
    assert_eq!(axis, 0);
}

#[test]
fn what_cannot_be_asked() {
    let wall = floor();
    let (mut axis, low, high, is_periodic) = (7, BOX.low, BOX.high, BOX.is_periodic);
    let (l, h, p) = (low.as_ptr(), high.as_ptr(), is_periodic.as_ptr());
    let ask = |wall: *const EllgranWall, l, h, p, axis| unsafe {
        ellgran_wall_missing_image(wall, null(), l, h, p, 0.1, axis, null_mut(), null_mut())
    };
    ok(ask(wall.0, l, h, p, &mut axis));
    assert_eq!(axis, 0);
    axis = 7;
    let is_null = ELLGRAN_ERROR_NULL_POINTER;
    fails(ask(null(), l, h, p, &mut axis), is_null, &["wall"]);
    fails(ask(wall.0, null(), h, p, &mut axis), is_null, &["low"]);
    fails(ask(wall.0, l, null(), p, &mut axis), is_null, &["high"]);
    fails(
        ask(wall.0, l, h, null(), &mut axis),
        is_null,
        &["is_periodic"],
    );
    fails(ask(wall.0, l, h, p, null_mut()), is_null, &["axis"]);
    let wrong = ELLGRAN_ERROR_ARGUMENT;
    let flat = Box {
        high: [-1.0, 1.0, 1.0],
        ..BOX
    };
    fails(
        missing(&wall, null(), &flat, 0.1).0,
        wrong,
        &["low[0] = -1", "high[0]"],
    );
    let endless = Box {
        high: [f64::INFINITY, 1.0, 1.0],
        ..BOX
    };
    fails(missing(&wall, null(), &endless, 0.1).0, wrong, &["high"]);
    assert_eq!(axis, 7);
}
