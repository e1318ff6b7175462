// SPDX-License-Identifier: MIT OR Apache-2.0
//! Flat pieces of a surface in many triangles: in an STL file, rounded as it is, and lent by an engine.

use std::ffi::CString;
use std::ptr::{null, null_mut};

use ellgran::c_api::contact::EllgranBody;
use ellgran::c_api::engine_walls::*;
use ellgran::c_api::rigid_wall::*;
use ellgran::c_api::status::*;

use crate::hills::{divided, grains_on, hills, Triangle};
use crate::scene::*;

const LAW: &str = "hertz 1e4 0.3 conservative no";

const SIZE: f64 = 0.4;

/// A floor in the numbers of a file.
fn floor() -> Vec<Triangle> {
    in_single_precision(&hills(8, SIZE, 0.03))
}

fn in_single_precision(triangles: &[Triangle]) -> Vec<Triangle> {
    let single = |p: [f64; 3]| p.map(|x| f64::from(x as f32));
    triangles.iter().map(|t| t.map(single)).collect()
}

/// A wall of a binary file with these triangles.
fn wall_of_file(name: &str, triangles: &[Triangle]) -> WallHandle {
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        bytes.extend([0; 12]);
        for x in t.iter().flatten() {
            bytes.extend((*x as f32).to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    let path = std::env::temp_dir().join(format!("ellgran-{}-{name}.stl", std::process::id()));
    std::fs::write(&path, bytes).unwrap();
    let c_path = CString::new(path.to_str().unwrap()).unwrap();
    let wall = WallHandle::new();
    let mut count = 0;
    // SAFETY: valid pointers; NULL is allowed.
    ok(unsafe { ellgran_wall_add_stl(wall.0, c_path.as_ptr(), 1.0, null(), null(), &mut count) });
    std::fs::remove_file(&path).unwrap();
    assert_eq!(count, triangles.len());
    wall
}

/// Grains on the floor where it is so much higher.
fn grains(higher: f64) -> Vec<EllgranBody> {
    (grains_on(SIZE).into_iter().zip(0..))
        .map(|((semi_axes, [x, y, z]), identifier)| EllgranBody {
            semi_axes,
            position: [x, y, z + higher],
            identifier,
            ..sphere_at(0.0)
        })
        .collect()
}

fn forces(wall: &WallHandle, bodies: &[EllgranBody]) -> Vec<[f64; 3]> {
    let (laws, workspace) = (Laws::new(&[LAW]), WorkspaceHandle::new());
    let mut arrays = Arrays::new(bodies, bodies.len());
    let mut histories = wall.histories(&laws, bodies.len());
    let mut load = NO_LOAD;
    // SAFETY: all pointers are valid.
    ok(unsafe {
        ellgran_compute_wall(
            laws.0,
            workspace.0,
            wall.0,
            &arrays.particles(),
            null(),
            0,
            1,
            &REST,
            histories.as_mut_ptr(),
            &STEP,
            &mut load,
            null_mut(),
        )
    });
    arrays.forces.to_vec()
}

#[track_caller]
fn are_equal(found: &[[f64; 3]], expected: &[[f64; 3]], tolerance: f64) {
    let largest = expected
        .iter()
        .flatten()
        .fold(0.0f64, |m, f| m.max(f.abs()));
    assert!(largest > 1.0);
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        let off = (0..3).map(|m| (a[m] - b[m]).abs()).fold(0.0, f64::max);
        assert!(off <= tolerance * largest, "{k}: {a:?} {b:?}");
    }
}

/// The file of sixteen times as many triangles is the same wall.
#[test]
fn a_file_of_divided_triangles_is_the_same_wall() {
    let floor = floor();
    let whole = forces(&wall_of_file("whole", &floor), &grains(0.0));
    let fine = forces(&wall_of_file("fine", &divided(&floor)), &grains(0.0));
    are_equal(&fine, &whole, 1e-6);
}

/// Triangles that an engine lends, moved as a whole from call to call, and then others in their place.
#[test]
fn lent_triangles_are_the_wall_of_all_of_them() {
    let floor = floor();
    let mut fine = in_single_precision(&divided(&floor));
    let mut largest = 0.0;
    // SAFETY: nine doubles for each triangle.
    ok(unsafe { ellgran_flatten_triangles(fine.len(), fine.as_mut_ptr().cast(), &mut largest) });
    assert!(largest > 0.0 && largest < 1e-2, "{largest}");
    let wall = WallHandle::new();
    for step in 0..6 {
        let all = if step == 3 { &floor } else { &fine };
        let higher = 0.25 * f64::from(step);
        let moved: Vec<Triangle> = (all.iter())
            .map(|t| t.map(|p| [p[0], p[1], p[2] + higher]))
            .collect();
        let near: Vec<u32> = (0..moved.len() as u32).collect::<Vec<_>>().repeat(40);
        let starts: Vec<usize> = (0..=40).map(|k| k * moved.len()).collect();
        let lent = EllgranLentTriangles {
            size: size_of::<EllgranLentTriangles>(),
            count: moved.len(),
            corners: moved.as_ptr().cast(),
            velocities: null(),
            particle_count: 40,
            near_starts: starts.as_ptr(),
            near: near.as_ptr(),
            velocity_changes: null(),
        };
        // SAFETY: valid pointers.
        ok(unsafe { ellgran_wall_lend_triangles(wall.0, &lent) });
        let whole = WallHandle::new();
        // SAFETY: nine doubles for each triangle.
        ok(unsafe { ellgran_wall_add_triangles(whole.0, floor.len(), floor.as_ptr().cast()) });
        let expected = forces(&whole, &grains(0.0));
        are_equal(&forces(&wall, &grains(higher)), &expected, 1e-6);
    }
}

#[test]
fn what_cannot_be_made_flat() {
    // SAFETY: NULL, or nine doubles for each triangle.
    unsafe {
        ok(ellgran_flatten_triangles(0, null_mut(), null_mut()));
        fails(
            ellgran_flatten_triangles(1, null_mut(), null_mut()),
            ELLGRAN_ERROR_NULL_POINTER,
            &["corners must not be NULL"],
        );
        let mut floor = floor();
        floor[4][1][2] = f64::NAN;
        let before = format!("{floor:?}");
        fails(
            ellgran_flatten_triangles(floor.len(), floor.as_mut_ptr().cast(), null_mut()),
            ELLGRAN_ERROR_ARGUMENT,
            &["corner 2 of triangle 5 of the mesh is at", "out of range"],
        );
        assert_eq!(format!("{floor:?}"), before);
        // Of numbers of double precision nothing is known.
        let mut exact = [[[0.0, 1.0 / 3.0, 0.0], [1.0, 0.0, 0.1], [0.3, 0.2, 0.7]]; 2];
        let mut largest = 1.0;
        ok(ellgran_flatten_triangles(
            2,
            exact.as_mut_ptr().cast(),
            &mut largest,
        ));
        assert_eq!(largest, 0.0);
    }
}
