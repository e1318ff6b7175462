// SPDX-License-Identifier: MIT OR Apache-2.0
//! No memory is allocated in a step, once a workspace has seen as many particles.

#![allow(unsafe_code)]
// Each block is one call of the C interface with pointers to locals that outlive it.
#![allow(clippy::undocumented_unsafe_blocks)]

#[allow(dead_code)]
#[path = "support/shapes.rs"]
mod formulas;
#[allow(dead_code)]
#[path = "c_abi/scene.rs"]
mod scene;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ptr::{null, null_mut};

use ellgran::c_api::contact::*;
use ellgran::c_api::particles::*;
use ellgran::c_api::rigid_wall::*;

use scene::*;

struct Counting;

thread_local! {
    static BYTES: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: all is passed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        BYTES.with(|bytes| bytes.set(bytes.get() + layout.size()));
        // SAFETY: promised by the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: promised by the caller.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Bytes that this thread allocates in a call.
fn allocated(call: impl FnOnce()) -> usize {
    let before = BYTES.with(Cell::get);
    call();
    BYTES.with(Cell::get) - before
}

const DECKS: [[&str; 2]; 3] = [
    ["hertz 1e4 0.3", "hertz 3e4 0.2"],
    [
        "nfd 1e4 0.3 40 60 tangential tfd 0.4",
        "nfd 3e4 0.2 90 30 tangential tfd 0.2",
    ],
    [
        "hertz 1e4 0.3 damping restitution 0.5 tangential mindlin 0.4 factors hale",
        "hertz 3e4 0.2 damping restitution 0.9 tangential mindlin 0.2 factors hale",
    ],
];
const OWNED: usize = 44;

#[test]
fn an_allocation_is_counted() {
    assert_eq!(allocated(|| ()), 0);
    assert!(allocated(|| drop(std::hint::black_box(vec![0u8; 1000]))) >= 1000);
}

#[test]
fn a_neighbour_list_allocates_in_the_first_step_alone() {
    for decks in DECKS {
        let laws = Laws::new(&decks);
        let workspace = WorkspaceHandle::new();
        let mut bodies = random_bodies(9);
        let mut list = List::near(&bodies, OWNED, laws.length());
        let mut tallies = no_tallies();
        let mut contacts = 0;
        for n in 0..40 {
            advance(&mut bodies, STEP.time_step);
            let mut arrays = Arrays::new(&bodies, OWNED);
            let (particles, view) = (arrays.particles(), list.view(n % 2 == 0));
            let bytes = allocated(|| {
                ok(laws.pairs(&workspace, &particles, &view, &STEP, &mut tallies));
            });
            contacts += tallies.touching_count as usize;
            assert!(
                n == 0 || bytes == 0,
                "{bytes} bytes in step {n} of {decks:?}"
            );
            assert!(n > 0 || bytes > 0, "the workspace holds nothing");
        }
        assert!(contacts > 500, "{contacts}");
        // SAFETY: valid.
        assert!(unsafe { ellgran_workspace_bytes(workspace.0) } > 0);
    }
}

#[test]
fn rigid_walls_allocate_while_they_meet_more_alone() {
    let shape = EllgranWallShape {
        size: size_of::<EllgranWallShape>(),
        name: c"cylinder".as_ptr(),
        point: [0.0; 3],
        axis: [0.1, 0.2, 1.0],
        radii: [1.2, 0.0],
        bounds: [-1.0, 1.0],
        ends: [ELLGRAN_END_OPEN, ELLGRAN_END_CLOSED],
        side: ELLGRAN_SIDE_INSIDE,
        unused: 0,
    };
    let floor: [[[f64; 3]; 3]; 2] = [
        [[-9.0, -9.0, -0.6], [9.0, -9.0, -0.6], [9.0, 9.0, -0.6]],
        [[-9.0, -9.0, -0.6], [9.0, 9.0, -0.6], [-9.0, 9.0, -0.6]],
    ];
    for decks in DECKS {
        let laws = Laws::new(&decks);
        let workspace = WorkspaceHandle::new();
        let mut wall = null_mut();
        // SAFETY: all pointers are valid.
        let length = unsafe {
            ok(ellgran_wall_new(&mut wall));
            ok(ellgran_wall_add_shape(wall, &shape));
            ok(ellgran_wall_add_triangles(wall, 2, floor.as_ptr().cast()));
            ok(ellgran_wall_record_contacts(wall, 1));
            ellgran_wall_histories_length(wall, laws.0)
        };
        let mut memory = vec![0.0; OWNED * length];
        let mut tallies = no_tallies();
        // The same motion twice: the second time nothing is met for the first time.
        for round in 0..2 {
            let mut bodies = random_bodies(9);
            for n in 0..20 {
                advance(&mut bodies, STEP.time_step);
                let mut arrays = Arrays::new(&bodies, OWNED);
                let particles = arrays.particles();
                let bytes = allocated(|| {
                    // SAFETY: all arrays are valid.
                    ok(unsafe {
                        ellgran_compute_wall(
                            laws.0,
                            workspace.0,
                            wall,
                            &particles,
                            null(),
                            0,
                            1,
                            null(),
                            memory.as_mut_ptr(),
                            &STEP,
                            null_mut(),
                            &mut tallies,
                        )
                    });
                });
                assert!(
                    round == 0 || bytes == 0,
                    "{bytes} bytes in step {n} of {decks:?}"
                );
            }
        }
        assert!(tallies.touching_count > 10.0, "{}", tallies.touching_count);
        // SAFETY: not used again.
        unsafe { ellgran_wall_free(wall) };
    }
}

#[test]
fn one_contact_allocates_nothing() {
    for decks in DECKS {
        let laws = Laws::new(&decks);
        let (i, j) = (sphere_at(0.0), sphere_at(1.5));
        let (mut touching, mut history) = (0, vec![0.0; laws.length()]);
        let mut force = Untouched::<EllgranContactForce>::sized();
        let bytes = allocated(|| {
            // SAFETY: all pointers are valid.
            ok(unsafe {
                ellgran_contact(
                    laws.0,
                    &i,
                    &j,
                    &STEP,
                    &mut touching,
                    history.as_mut_ptr(),
                    null_mut(),
                    force.pointer(),
                )
            });
        });
        assert_eq!((bytes, touching), (0, 1));
    }
}
