// SPDX-License-Identifier: MIT OR Apache-2.0
//! The entries for walls with triangles, which are long, and in a module of their own: who has no such wall does not wait until they are
//! assembled. Compiled twice, as [`entries`](crate::entries).

use crate::memory::{entries, Here};
use crate::scene::{add, note, scene_of, wall_layout};
use core::sync::atomic::Ordering;
use ellgran::walls::parts::Parts;
use ellgran::walls::Motion;
use ellgran_kernels::arguments::{MeshArguments, FAULT};
use ellgran_kernels::meshes::{
    contacts_with_mesh, is_near_mesh, LargeRoom, MovingMesh, SmallRoom, CROWDED, NEAR,
    TOO_MANY_TRIANGLES,
};
use ellgran_kernels::shapes::{Ellipsoids, Spheroids};

/// The wall of a call, in a scene of it.
macro_rules! mesh_of {
    ($arguments:ident, $scene:ident) => {
        MovingMesh {
            parts: Parts {
                parts: $arguments.parts.all(),
                triangles: $arguments.triangles.all(),
                boxes: $arguments.boxes.all(),
                widths: $arguments.widths.all(),
                nodes: $arguments.nodes.all(),
                order: $arguments.order.all(),
            },
            motion: Motion::from(&$arguments.motion),
            layout: wall_layout(&$scene, $arguments.records),
            wall_type: $arguments.wall_type,
        }
    };
}

macro_rules! near_meshes {
    ($($name:ident: $kind:ty;)*) => {
        entries! {$(
            /// Lists the grains that are near a wall with triangles.
            fn $name(thread, arguments: MeshArguments<Here>) {
                let scene = scene_of(&arguments.scene, arguments.scene.tangential != 0);
                let wall = mesh_of!(arguments, scene);
                let (mut states, mut histories) = (arguments.states, arguments.histories);
                let mut near = arguments.near;
                let k = thread.index();
                let history = histories.part(&thread, wall.layout.length());
                if is_near_mesh::<$kind>(k, &scene, &wall, states.at(&thread), history) {
                    near.taken(&arguments.counts.all()[NEAR], 1).1[0] = k as u32;
                }
            }
        )*}
    };
}

// Spheres are spheroids to these.
near_meshes! {
    ellgran_near_mesh_spheroids: Spheroids;
    ellgran_near_mesh_ellipsoids: Ellipsoids;
}

entries! {
    /// Adds the loads of a wall with triangles. Grains of which there are more triangles than there is room for go to large room, or
    /// `faults` gets [`TOO_MANY_TRIANGLES`].
    fn ellgran_mesh(thread, arguments: MeshArguments<Here>) {
        // What the host has set aside is what this compiler makes of the types.
        assert!(arguments.room_bytes == size_of::<SmallRoom>() as u64);
        assert!(arguments.large_room_bytes == size_of::<LargeRoom>() as u64);
        let mut arrays = arguments;
        let scene = scene_of(&arrays.scene, arrays.scene.tangential != 0);
        let wall = mesh_of!(arrays, scene);
        let length = wall.layout.length();
        let is_crowded = arrays.is_crowded != 0;
        let counts = arrays.counts.all();
        let which = if is_crowded { CROWDED } else { NEAR };
        let count = counts[which].load(Ordering::Relaxed) as usize;
        for place in thread.numbers(count) {
            let (number, room) = if is_crowded {
                (*arrays.crowded.at(&place), arrays.large_rooms.at(&thread).lend())
            } else {
                (*arrays.near.at(&place), arrays.rooms.at(&thread).lend())
            };
            let own = place.within(|_| number);
            let state = arrays.states.at(&own);
            let outcome = contacts_with_mesh(
                number as usize,
                &scene,
                arrays.ellipsoids != 0,
                &wall,
                room,
                state,
                arrays.histories.part(&own, length),
            );
            match outcome {
                Ok(load) => {
                    if *state != 0 {
                        add(&mut arrays.forces, &own, load.force);
                        add(&mut arrays.torques, &own, load.torque);
                    }
                }
                Err(_) if is_crowded => {
                    let first = arrays.faults.at(&own);
                    if *first == 0 {
                        *first = TOO_MANY_TRIANGLES;
                    }
                    note(arrays.notes.all(), FAULT);
                }
                Err(_) => arrays.crowded.taken(&counts[CROWDED], 1).1[0] = number,
            }
        }
    }
}
