// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lists that name no particle, and lists that are said to be unchanged and are not: refused before anything is written.

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use ellgran::c_api::neighbour_list::*;
use ellgran::c_api::particles::{ellgran_workspace_instruction_set, EllgranParticles};
use ellgran::c_api::status::*;

use crate::scene::*;

const FRICTION: &str = "nfd 1e4 0.3 40 60 tangential tfd 0.4";

/// Three bodies in a row, the first two and the last two touching.
struct Scene {
    laws: Laws,
    workspace: WorkspaceHandle,
    arrays: Arrays,
    list: List,
}

/// Forces, torques, flags and histories.
type Written = (Vec<[f64; 3]>, Vec<[f64; 3]>, Vec<Vec<i32>>, Vec<Vec<f64>>);

impl Scene {
    fn new() -> Scene {
        let laws = Laws::new(&[FRICTION]);
        let mut bodies = [0.0, 1.5, 3.0].map(sphere_at);
        for (k, body) in bodies.iter_mut().enumerate() {
            body.semi_axes = [1.0, 0.9, 0.8];
            body.identifier = 70 + k as i64;
            body.velocity = [0.0, 0.1 * k as f64, 0.0];
        }
        let list = List::new(vec![vec![1, 2], vec![2]], laws.length());
        Scene {
            laws,
            workspace: WorkspaceHandle::new(),
            arrays: Arrays::new(&bodies, 3),
            list,
        }
    }

    fn call(&mut self, change: impl Fn(&mut EllgranParticles, &mut EllgranNeighbourList)) -> i32 {
        let (mut particles, mut view) = (self.arrays.particles(), self.list.view(true));
        change(&mut particles, &mut view);
        self.laws
            .pairs(&self.workspace, &particles, &view, &STEP, null_mut())
    }

    /// One number at a time, histories are written in every step.
    fn keeps_nothing(&self) -> bool {
        // SAFETY: valid; the name is static and ends with NUL.
        let name = unsafe { CStr::from_ptr(ellgran_workspace_instruction_set(self.workspace.0)) };
        name == c"scalar"
    }

    /// All that a call may write.
    fn written(&self) -> Written {
        (
            self.arrays.forces.clone(),
            self.arrays.torques.clone(),
            self.list.touching.clone(),
            self.list.history.clone(),
        )
    }
}

#[test]
fn entries_that_name_no_particle() {
    for wrong in [3, 1_000_000, i32::MAX, -1, i32::MIN, 0] {
        for (row, place) in [(0, 0), (0, 1), (1, 0)] {
            let mut scene = Scene::new();
            if wrong == 0 && row == 1 {
                // A particle as good as any other.
                continue;
            }
            let good = scene.list.rows[row][place];
            let before = scene.written();
            scene.list.rows[row][place] = wrong;
            let name = format!("neighbours[{row}][{place}] = {wrong}");
            let particle = format!("particle {}", 70 + row);
            for unchanged in [0, 1] {
                let status = scene.call(|_, list| list.unchanged = unchanged);
                fails(status, ELLGRAN_ERROR_ARGUMENT, &[&name, &particle]);
                assert_eq!(scene.written(), before, "{name}");
            }
            // The workspace is as good as before.
            scene.list.rows[row][place] = good;
            ok(scene.call(|_, _| ()));
            assert_eq!(scene.list.touching, [[1, 0].to_vec(), vec![1]]);
            assert!(scene.arrays.forces[0][0] < 0.0 && scene.arrays.forces[2][0] > 0.0);
        }
    }
}

#[test]
fn an_excluded_pair_may_name_anything() {
    let mut scene = Scene::new();
    scene.list.rows[0][1] = 1 << 30 | 1000;
    let factors = [1.0, 0.0, 1.0, 1.0];
    ok(scene.call(|_, list| {
        list.index_mask = 0x3fff_ffff;
        list.special_shift = 30;
        list.special_factors = factors.as_ptr();
    }));
}

/// What changes a list, and a word of the message.
type Change = (&'static str, fn(&mut Scene));

#[test]
fn unchanged_lists_that_have_changed() {
    let changes: [Change; 5] = [
        ("neighbour_counts", |s| {
            // The second row alone is shorter: its history may be too.
            s.list = List::new(vec![vec![1, 2], vec![]], s.laws.length());
        }),
        ("neighbour_counts", |s| {
            s.list = List::new(vec![vec![1], vec![2, 0]], s.laws.length());
        }),
        ("neighbour_counts", |s| s.list.central = vec![1, 0]),
        ("laws", |s| s.laws = Laws::new(&[FRICTION])),
        ("count = 4", |s| {
            let bodies = [0.0, 1.5, 3.0, 9.0].map(sphere_at);
            s.arrays = Arrays::new(&bodies, 3);
        }),
    ];
    for (word, change) in changes {
        for keep in [0, 1] {
            let mut scene = Scene::new();
            ok(scene.call(|_, list| list.keep_history = keep));
            ok(scene.call(|_, list| (list.unchanged, list.keep_history) = (1, keep)));
            change(&mut scene);
            let before = scene.written();
            let status = scene.call(|_, list| (list.unchanged, list.keep_history) = (1, keep));
            fails(
                status,
                ELLGRAN_ERROR_ARGUMENT,
                &["unchanged = 1", word, "ellgran_write_history"],
            );
            assert_eq!(scene.written(), before, "{word}");
        }
    }
}

#[test]
fn a_row_that_is_gone() {
    for keep in [0, 1] {
        let mut scene = Scene::new();
        ok(scene.call(|_, list| list.keep_history = keep));
        let before = scene.written();
        let rows = [scene.list.touching[0].as_mut_ptr(), null_mut()];
        let status = scene.call(|_, list| {
            list.unchanged = 1;
            list.touching = rows.as_ptr();
        });
        fails(status, ELLGRAN_ERROR_NULL_POINTER, &["touching[1]"]);
        assert_eq!(scene.written(), before);
    }
}

#[test]
fn histories_are_not_written_to_another_list() {
    let mut scene = Scene::new();
    ok(scene.call(|_, list| list.keep_history = 1));
    let good = scene.list.view(true);
    let mut shorter = List::new(vec![vec![1, 2], vec![]], scene.laws.length());
    let before = scene.written();
    let rows: [*mut f64; 2] = [scene.list.history[0].as_mut_ptr(), null_mut()];
    let mut without = good;
    without.history = rows.as_ptr();
    for list in [shorter.view(true), without] {
        // SAFETY: the arrays are as long as is said of them.
        let status = unsafe { ellgran_write_history(scene.workspace.0, &list) };
        if scene.keeps_nothing() {
            ok(status);
            continue;
        }
        fails(status, ELLGRAN_ERROR_ARGUMENT, &["row 1", "entry 0"]);
        assert_eq!(scene.written(), before);
    }
    // SAFETY: the list of the last call.
    ok(unsafe { ellgran_write_history(scene.workspace.0, &good) });
    assert_eq!(scene.list.touching, [[1, 0].to_vec(), vec![1]]);
}

/// A failing call loses nothing: the next one goes on from where the last good one ended.
#[test]
fn a_step_that_failed_can_be_repeated() {
    let (mut scene, mut other) = (Scene::new(), Scene::new());
    for step in 0..4 {
        let call = |_: &mut EllgranParticles, list: &mut EllgranNeighbourList| {
            (list.unchanged, list.keep_history) = (i32::from(step > 0), 1);
        };
        if step == 2 {
            let x = scene.arrays.positions[1][0];
            for wrong in [f64::NAN, 1e300] {
                scene.arrays.positions[1][0] = wrong;
                fails(
                    scene.call(call),
                    ELLGRAN_ERROR_PARTICLE,
                    &["particle 71", "position"],
                );
            }
            scene.arrays.positions[1][0] = x;
        }
        ok(scene.call(call));
        ok(other.call(call));
        for scene in [&mut scene, &mut other] {
            scene.arrays.positions[1][1] += 1e-3;
        }
    }
    for scene in [&mut scene, &mut other] {
        let view = scene.list.view(true);
        // SAFETY: the list of the last call.
        ok(unsafe { ellgran_write_history(scene.workspace.0, &view) });
    }
    assert_eq!(scene.written(), other.written());
    assert!(scene.list.history[0].iter().all(|x| x.is_finite()));
    assert_ne!(scene.list.history[0][3..6], [0.0; 3]);
}

#[test]
fn walls_are_no_call_for_a_list() {
    use ellgran::c_api::rigid_wall::*;
    let (mut scene, mut other) = (Scene::new(), Scene::new());
    let plane = WallHandle::plane([-0.9, 0.0, 0.0], [1.0, 0.0, 0.0]);
    for step in 0..3 {
        let call = |_: &mut EllgranParticles, list: &mut EllgranNeighbourList| {
            (list.unchanged, list.keep_history) = (i32::from(step > 0), 1);
        };
        ok(scene.call(call));
        ok(other.call(call));
        let mut apart = Arrays::new(&[0.0, 1.5, 3.0].map(sphere_at), 3);
        let particles = apart.particles();
        let mut memory = plane.histories(&scene.laws, 3);
        let mut load = NO_LOAD;
        // SAFETY: all arrays are valid.
        ok(unsafe {
            ellgran_compute_wall(
                scene.laws.0,
                scene.workspace.0,
                plane.0,
                &particles,
                null(),
                0,
                1,
                null(),
                memory.as_mut_ptr(),
                &STEP,
                &mut load,
                null_mut(),
            )
        });
        assert_eq!(load.contact_count, 1);
        assert_eq!(scene.arrays.forces, other.arrays.forces, "step {step}");
    }
}
